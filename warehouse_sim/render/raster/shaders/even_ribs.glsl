// Normals of ribbed sheets that every second pixel may sample. Needs surface.glsl and pack.glsl.
uniform sampler2D materials;

// The mean of 4 x 4 pixels where ``at`` shows a ribbed sheet, else n: ribs of two pixels, sampled at every second one,
// would beat. words: what the geometry pass stored of the pixel; n: its normal.
vec3 even_normal(ivec2 at, uvec2 words, vec3 n) {
    int row = material_row(words);
    int count = texelFetch(materials, ivec2(2, row), 0).z == -2.0 ? 16 : 0;  // a CPU leaves a loop, but not a branch
    ivec2 last = textureSize(surface_map, 0) - 1;
    vec3 sum = n;
    for (int k = 0; k < count; k++) {
        uvec2 other = texelFetch(surface_map, clamp(at + ivec2(k & 3, k >> 2) - 1, ivec2(0), last), 0).xy;
        vec3 m = unpack_normal(other.x);
        if (material_row(other) == row && dot(m, n) > 0.5) sum += m;
    }
    return count > 0 ? normalize(sum) : n;
}
