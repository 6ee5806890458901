void main() {
    gl_Position = clip_position(camera_position(), vec2(0.0));
}
