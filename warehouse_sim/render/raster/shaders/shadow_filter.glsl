// How much of a light a point sees: percentage-closer soft shadows (Fernando 2005) on maps of SHADOW_NEAR / z.
uniform sampler2D shadow_atlas;
uniform sampler2D shadow_blockers;  // see blockers.frag

const float LIFT_TEXELS = 0.3;    // more would lift shadows off what casts them
const float WIDEST = 8.0;         // texels: radius of the softest edge
const float SAME = 1.01;          // what is nearer to the light by less leaves no penumbra to speak of
const int TAPS = SHADOW_TAPS;     // of the filter, at each of four neighbours that soften.frag averages
const vec2 DISK[TAPS] = vec2[](SHADOW_DISK);

vec4 nearest_texels(vec2 grid) {  // the four around a point, in the order (0, 1), (1, 1), (1, 0), (0, 0)
    return textureGather(shadow_atlas, floor(grid + 0.5) / ATLAS_PX);
}

// Fraction of the four around ``grid + d`` that see the light, weighted by where that lies between them.
// reference, slope: SHADOW_NEAR / z of the surface at ``grid``, and how it grows along the map.
float visible(vec2 grid, vec2 d, float reference, vec2 slope) {
    vec2 at = grid + d - 0.5, f = fract(at);
    float first = reference + dot(d - f, slope);
    vec4 references = first + vec4(slope.y, slope.x + slope.y, slope.x, 0.0);
    vec4 seen = vec4(lessThanEqual(nearest_texels(grid + d), references));
    vec2 column = mix(seen.wx, seen.zy, f.x);
    return mix(column.x, column.y, f.y);
}

// turn: a rotation, one of four that neighbours fraction.
float visibility(const int i, vec3 p, vec3 g, mat2 turn) {
    mat3x4 to_light = mat3x4(lights[i].to_light[0], lights[i].to_light[1], lights[i].to_light[2]);
    vec3 r = vec4(p, 1.0) * to_light, n = g * mat3(to_light);
    // Along the normal, so that the back of a sheet a few millimetres thick does not shade its front across a texel.
    r += n * (LIFT_TEXELS * lights[i].texel_angle * r.z);
    float inverse_z = 1.0 / r.z, reference = SHADOW_NEAR * inverse_z, facing = -dot(n, r) * inverse_z;
    vec2 at = r.xy * inverse_z * lights[i].tile_scale + lights[i].tile_offset;
    bool mapped = r.z > SHADOW_NEAR && at == clamp(at, lights[i].tile_low, lights[i].tile_high);
    vec2 grid = at * ATLAS_PX;
    // Over a plane 1 / z is linear in the map, so that a surface never shades itself, however wide the filter.
    // The same holds for what looks away from the light: it stays dark, but lends its result to what lies beside it.
    float towards = facing < 0.0 ? min(facing, -0.02) : max(facing, 0.02);
    vec2 slope = n.xy * (-reference / towards) / (lights[i].tile_scale * ATLAS_PX);

    // Of a light of radius R a blocker at b leaves a penumbra of R (1 / b - 1 / z), half its width on the map.
    vec4 nearest = textureGather(shadow_blockers, floor(grid / BLOCK_TEXELS + 0.5) * (BLOCK_TEXELS / ATLAS_PX));
    vec4 blocks = vec4(greaterThan(nearest, vec4(reference * SAME)));
    float blocker = dot(blocks, nearest) / max(dot(blocks, vec4(1.0)), 1.0);
    vec2 radius = clamp(lights[i].softness * (blocker - reference), 1.0, WIDEST);
    float sum = 0.0;
    for (int k = 0; k < TAPS; k++) {
        vec2 d = turn * DISK[k] * radius;
        sum += visible(grid, d, reference, slope);
    }
    return mapped ? sum / float(TAPS) : 1.0;
}
