// Textures are laid on each face along the axis of the part that it looks at most, with u along the longest edge.
// Needs the attributes of place.glsl.
uniform sampler2D materials;

struct Projection {
    vec2 tile;               // texture coordinate
    vec3 tangent;            // direction of growing u in the part's frame; v grows along cross(normal, tangent)
    ivec3 axes;              // of the part, along u, along v and that the face looks along
    float handed;            // 1 where v grows with its axis, else -1
};

Projection box_projection(vec3 n) {
    vec3 a = abs(n);
    int facing = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
    int order = in_identity.z & 63;
    ivec3 axes = ivec3(order & 3, (order >> 2) & 3, (order >> 4) & 3);
    int u = axes.x == facing ? axes.y : axes.x;
    int v = 3 - u - facing;
    float handed = (u + 1) % 3 == v ? 1.0 : -1.0;
    vec3 metres = in_position * in_scale;
    vec3 along = vec3(0.0);
    along[u] = 1.0;
    vec2 per_metre = vec2(texelFetch(materials, ivec2(2, in_identity.y), 0).x,
                          texelFetch(materials, ivec2(1, in_identity.y), 0).w);
    Projection p;
    p.handed = n[facing] < 0.0 ? -handed : handed;
    p.tile = vec2(metres[u], metres[v] * p.handed) * per_metre + in_texture_shift;
    p.tangent = normalize(along - n * n[u]);
    p.axes = ivec3(u, v, facing);
    return p;
}
