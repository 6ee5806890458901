// What is finer on a surface than its texture, and how single things of one material differ. Needs lighting.glsl and
// fine.glsl.
uniform vec3 up;                  // world z in the camera frame
uniform float eye_height;         // of the camera over the floor (m)

const float BOARD = 1.0, PRINTED_BOARD = 2.0, WOOD = 3.0, TAPE = 4.0, COAT = 5.0, PAPER = 6.0;  // see surfaces.py
const float SOFTER = 0.35;        // mip levels: what is finer than a pixel must not differ between two views of a place
const float EVEN = 4.5;           // mip level from which on no detail is left
const float SMOOTH = 16.0;        // texels of grain of a coat in a pixel, from which on it is even
const float EDGE = 0.03;          // of board that is worn (m)
const float DIRTY = 0.16;          // height up to which wood is (m)
const float THIN = 0.03;          // half edges of faces below which edges are not worn (m)

// The fraction of a stretch of width w around d that lies between a and b.
float overlap(float d, float w, float a, float b) {
    return clamp((min(d + 0.5 * w, b) - max(d - 0.5 * w, a)) / w, 0.0, 1.0);
}

// Slow waves about 0, as hands and forks leave what they rub.
float waves(vec2 at, float turn) {
    vec2 q = at + 0.7 * sin(at.yx * 1.7 + 6.3 * turn);
    return sin(q.x * 1.3 + 40.0 * turn) * sin(q.y + 23.0 * turn);
}

void recolour(inout Surface s, vec3 factor) {
    s.f0 += s.metallic * s.base * (factor - 1.0);
    s.base *= factor;
    s.diffuse *= factor;
}

// Tint of a thing: lightness by up to ``lighter`` (linear), red against blue by up to ``warmer``.
vec3 tinted(float number, float lighter, float warmer) {
    float other = fract(number * 37.31 + 0.17) * 2.0 - 1.0;
    return (1.0 + lighter * (2.0 * number - 1.0)) * vec3(1.0 + warmer * other, 1.0, 1.0 - warmer * other);
}

vec3 worn(Fine f, vec2 metres, float kind, float pixel_m, float height) {
    if (kind == TAPE) return tinted(f.thing, 0.12, 0.08);
    if (kind == PAPER) return tinted(fract(f.thing * 7.3), 0.06, 0.03);
    vec3 factor = kind == WOOD ? tinted(f.part, 0.32, 0.07) : tinted(f.thing, 0.17, 0.035);
    vec2 room = (1.0 - abs(f.place)) * f.half_edges;
    float d = max(min(room.x, room.y), 0.0);
    bool thin = min(f.half_edges.x, f.half_edges.y) < THIN;
    if (kind == BOARD && !thin && d < EDGE + pixel_m) {
        float rub = waves(metres * 60.0, f.part);
        float gap = overlap(d, pixel_m, 0.0, 0.003);
        float pale = overlap(d, pixel_m, 0.003, 0.010 + 0.006 * rub) * (0.6 + 0.4 * rub);
        float corner = clamp(1.0 - (room.x + room.y) / 0.06, 0.0, 1.0);
        factor *= (1.0 - 0.65 * gap) * (1.0 + 0.16 * pale + 0.18 * corner * (0.5 + 0.5 * rub));
    }
    if (kind == WOOD) {
        float arris = overlap(d, pixel_m, 0.0, 0.0025);
        factor *= (1.0 - 0.35 * arris) * (f.across_grain ? 0.82 : 1.0);
        if (height < DIRTY) {
            float dirt = clamp(1.0 - height / DIRTY, 0.0, 1.0) * (0.75 + 0.25 * waves(metres * 60.0, f.part));
            factor *= mix(vec3(1.0), vec3(0.62, 0.60, 0.58), dirt);
        }
    }
    return factor;
}

// tangent: direction of the texture's u axis; pixel: width of a pixel at z = 1 m.
void add_fine_detail(inout Surface s, uvec2 words, int row, vec3 tangent, float pixel) {
    vec4 detail = texelFetch(materials, ivec2(3, row), 0);
    if (detail.w < 0.0) return;
    Fine f = unpack_fine(words);
    vec2 metres = f.place * f.half_edges;
    float width = s.p.z * pixel;
    vec3 factor = vec3(1.0);
    if (detail.w > 0.0 && detail.w != COAT) factor = worn(f, metres, detail.w, width, dot(up, s.p) + eye_height);
    if (detail.w == COAT && width * detail.z * float(TEXTURE_PX) > SMOOTH) detail.x = -1.0;
    if (detail.x >= 0.0) {
        if (detail.w == WOOD && f.across_grain) detail.xyz = texelFetch(materials, ivec2(4, row), 0).xyz;
        float footprint = width * inversesqrt(s.nv) * detail.z * float(TEXTURE_PX);
        vec2 at = metres * detail.yz + f.part * vec2(7.0, 13.0);
        float level = log2(footprint) + SOFTER, left = clamp(EVEN - level, 0.0, 1.0);
        if (left > 0.0) {
            vec4 texel = textureLod(textures, vec3(at, detail.x), level) * 255.0 - 128.0;  // see surfaces.py
            factor *= 1.0 + left / 128.0 * texel.x;
            s.roughness = clamp(s.roughness * (1.0 + left / 128.0 * texel.w), 0.05, 1.0);
            s.a = s.roughness * s.roughness;
            vec2 bend = texel.yz * (left / 127.0);
            s.n = normalize(s.n + tangent * bend.x + cross(s.g, tangent) * bend.y);
            s.nv = max(dot(s.n, s.v), 1e-3);
            s.away = fifth(1.0 - min(s.nv, 1.0));
        }
    }
    recolour(s, factor);
}
