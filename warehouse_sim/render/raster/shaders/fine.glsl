// What the geometry pass stores beside a pixel's surface, for detail that is finer than its texture, and for wear.
// First word: place on the face between the edges of the part's box in 2 x 16 bits, as interpolated.
// Second word, one a face: half of those edges in 2 x 8 bits, see parts.py; number of the part in 7 bits, and of the
// object in 8; 1 for faces across the part's longest edge.
const float FINE_STEPS = 32700.0, FINE_MIDDLE = 32768.0;

uint pack_face(uvec2 half_edges, float part, int thing, bool across_grain) {
    return half_edges.x | (half_edges.y << 8) | ((uint(part * 128.0) & 127u) << 16)
        | ((uint(thing) * 2654435761u >> 24) << 23) | (uint(across_grain) << 31);
}

uint pack_place(vec2 steps) {
    uvec2 q = uvec2(steps);
    return q.x | (q.y << 16);
}

struct Fine {
    vec2 place;              // on the face, -1 to 1 between the edges of the part's box
    vec2 half_edges;         // of that box (m)
    float part, thing;       // numbers of the part and of its object, 0-1
    bool across_grain;
};

Fine unpack_fine(uvec2 words) {
    Fine f;
    f.place = (vec2(words.x & 65535u, words.x >> 16) - FINE_MIDDLE + 0.5) / FINE_STEPS;
    f.half_edges = exp2(vec2(words.y & 255u, (words.y >> 8) & 255u) / 16.0 - 10.0);
    f.part = float((words.y >> 16) & 127u) / 127.0;
    f.thing = float((words.y >> 23) & 255u) / 255.0;
    f.across_grain = (words.y >> 31) == 1u;
    return f;
}
