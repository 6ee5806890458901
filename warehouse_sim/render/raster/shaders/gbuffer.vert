uniform sampler2D materials;
uniform vec2 origin;         // window position of the image's first pixel

flat out int instance_id;
flat out uint surface;      // octahedral normal in 2 x 12 bits, material in 8 bits
flat out uint face;         // a hash of part and normal in 8 bits: what differs across an edge
out vec2 texture_coordinate;

vec2 octahedral(vec3 n) {  // Cigolle et al. 2014, "A survey of efficient representations for independent unit vectors"
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z > 0.0 ? p : folded;
}

vec2 box_coordinate(vec3 n) {  // metres on the face that looks most along n; u along the longest edge
    vec3 a = abs(n);
    int facing = a.x >= a.y && a.x >= a.z ? 0 : (a.y >= a.z ? 1 : 2);
    int order = in_identity.z;
    ivec3 axes = ivec3(order & 3, (order >> 2) & 3, (order >> 4) & 3);
    int u = axes.x == facing ? axes.y : axes.x;
    int v = 3 - u - facing;
    vec3 metres = in_position * in_scale;
    return vec2(metres[u], metres[v]);
}

void main() {
    vec3 p = camera_position();
    vec3 n = normalize(in_normal / in_scale);
    uvec2 packed_normal = uvec2(round((octahedral(in_rotation * n) * 0.5 + 0.5) * 4095.0));
    instance_id = in_identity.x;
    surface = packed_normal.x | (packed_normal.y << 12) | (uint(in_identity.y) << 24);
    uint normal_word = surface & 0xFFFFFFu;
    face = ((uint(in_identity.w) * 2654435761u) ^ (normal_word * 2246822519u)) >> 24;
    float per_metre = texelFetch(materials, ivec2(1, in_identity.y), 0).w;
    texture_coordinate = box_coordinate(n) * per_metre + in_texture_shift;
    gl_Position = clip_position(p, origin);
}
