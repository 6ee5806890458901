uniform vec2 origin;               // window position of the target's first pixel
uniform isampler2D cells;          // texel (0, k): whole-pixel shift of object k

void main() {
    vec2 shift = origin + vec2(texelFetch(cells, ivec2(0, in_identity.x), 0).xy);
    gl_Position = clip_position(camera_position(), shift);
}
