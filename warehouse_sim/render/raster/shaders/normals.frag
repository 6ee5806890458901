layout(location = 0) out vec4 out_normal;

void main() {
    bool nothing = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).x <= 0.0;
    uint word = texelFetch(surface_map, ivec2(gl_FragCoord.xy), 0).x;
    out_normal = vec4(nothing ? vec3(0.0) : unpack_normal(word), 0.0);
}
