uniform vec2 origin;         // window position of the image's first pixel

flat out int instance_id;
flat out uvec2 surface;      // see pack.glsl
out vec2 texture_coordinate;
out vec2 on_face;            // see fine.glsl
flat out uint face;
out vec4 to_edge;
flat out vec4 plane;         // of the face in the camera frame: unit normal n, and n . p of its points p (m)

void main() {
    vec3 n = normalize(in_normal / in_scale);
    Projection projected = box_projection(n);
    instance_id = in_identity.x;
    surface = pack_surface(in_rotation * n, in_rotation * projected.tangent, uint(in_identity.y));
    texture_coordinate = projected.tile;
    int u = projected.axes.x, v = projected.axes.y;
    vec3 away = in_position * in_spread + in_start;
    on_face = vec2(away[u], away[v] * projected.handed) + FINE_MIDDLE;
    face = pack_face(uvec2(in_identity.z >> (6 + 8 * u), in_identity.z >> (6 + 8 * v)) & 255u, in_texture_shift.x,
                     in_identity.x, projected.axes.z == (in_identity.z & 3));
    to_edge = in_to_edge;
    vec3 p = camera_position(), facing = in_rotation * n;
    plane = vec4(facing, dot(facing, p));
    gl_Position = clip_position(p, origin);
    ADD_VARYINGS(n, projected)
}
