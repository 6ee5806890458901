// The two words that the geometry pass stores of a pixel's surface.
// First: octahedral normal in 2 x 12 bits, direction of the texture's u axis in 6, the highest 2 bits of the material.
// Second: place in the texture in 2 x 11 bits, the lowest 10 bits of the material.
// Octahedral: Cigolle et al. 2014, "A survey of efficient representations for independent unit vectors".

uint pack_normal(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    uvec2 q = uvec2(round(((n.z > 0.0 ? p : folded) * 0.5 + 0.5) * 4095.0));
    return q.x | (q.y << 12);
}

vec3 unpack_normal(uint word) {
    vec2 p = vec2(word & 4095u, (word >> 12) & 4095u) / 4095.0 * 2.0 - 1.0;
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}

// A frame about n that both passes agree on: Duff et al. 2017, "Building an orthonormal basis, revisited".
void basis(vec3 n, out vec3 a, out vec3 b) {
    float side = n.z >= 0.0 ? 1.0 : -1.0;
    float k = -1.0 / (side + n.z), xy = n.x * n.y * k;
    a = vec3(1.0 + side * n.x * n.x * k, side * xy, -side * n.x);
    b = vec3(xy, side + n.y * n.y * k, -n.y);
}

// Steps of the diamond angle: it grows with the angle as the way around a square does.
uint pack_tangent(vec3 t, vec3 n) {
    vec3 a, b;
    basis(n, a, b);
    vec2 d = vec2(dot(t, a), dot(t, b));
    d /= abs(d.x) + abs(d.y);
    return uint(round((d.y >= 0.0 ? 1.0 - d.x : 3.0 + d.x) * 16.0)) & 63u;
}

vec3 unpack_tangent(uint word, vec3 n) {
    vec3 a, b;
    basis(n, a, b);
    float way = float((word >> 24) & 63u) / 16.0;
    float x = abs(way - 2.0) - 1.0;
    vec2 d = normalize(vec2(x, (1.0 - abs(x)) * (way < 2.0 ? 1.0 : -1.0)));
    return a * d.x + b * d.y;
}

uint pack_tile(vec2 coordinate) {
    uvec2 q = uvec2(fract(coordinate) * 2048.0) & 2047u;
    return q.x | (q.y << 11);
}

vec2 unpack_tile(uint word) {
    return (vec2(word & 2047u, (word >> 11) & 2047u) + 0.5) / 2048.0;
}

// n: unit normal, t: direction of the texture's u axis, both in the camera frame; row: of the material.
uvec2 pack_surface(vec3 n, vec3 t, uint row) {
    uint normal = pack_normal(n);
    return uvec2(normal | (pack_tangent(t, unpack_normal(normal)) << 24) | ((row >> 10) << 30), (row & 1023u) << 22);
}

int material_row(uvec2 words) {
    return int(((words.x >> 30) << 10) | (words.y >> 22));
}

// A number in 8 bits that differs between neighbouring faces: of normal and material.
uint face_hash(uvec2 words) {
    return (((words.y >> 22) * 2654435761u) ^ (words.x * 2246822519u)) >> 24;
}
