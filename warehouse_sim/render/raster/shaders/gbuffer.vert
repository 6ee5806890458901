uniform vec2 origin;         // window position of the image's first pixel

flat out int instance_id;
flat out uvec2 surface;      // normal and material; tangent and part
out vec2 texture_coordinate;
out vec4 to_edge;

void main() {
    vec3 n = normalize(in_normal / in_scale);
    Projection projected = box_projection(n);
    uint normal = pack_normal(in_rotation * n);
    instance_id = in_identity.x;
    surface = uvec2(normal | (uint(in_identity.y) << 24),
                    (pack_tangent(in_rotation * projected.tangent, unpack_normal(normal)) << 22) |
                    ((uint(in_identity.w) & 31u) << 27));
    texture_coordinate = projected.tile;
    to_edge = in_to_edge;
    gl_Position = clip_position(camera_position(), origin);
}
