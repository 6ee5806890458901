uniform sampler2D near_light, around, visibility_a, visibility_b;  // see soft.frag
uniform float sky, ground;        // luminance of the environment above and below the horizon (cd/m^2)
uniform sampler2D paint_map;      // of pictures, see gbuffer.frag

layout(location = 0) out vec4 out_color;  // alpha: hash of the face that the pixel shows

// Facets finer than a pixel, whose mean normal is shorter than 1 by ``lack``, mirror more blurredly than each of them:
// the variance of their slopes adds to that of the surface's own (Toksvig 2005, "Mipmapping normal maps").
void roughen(inout Surface s, float lack) {
    float mean = max(1.0 - lack, 0.2);
    s.a = min(sqrt(s.a * s.a + 1.0 / (mean * mean) - 1.0), 1.0);
    s.roughness = sqrt(s.a);
}

void main() {
    float stored = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).x;
    uvec4 stored_words = texelFetch(surface_map, ivec2(gl_FragCoord.xy), 0);
    uvec2 words = stored_words.xy;
    bool nothing = stored <= 0.0;
    vec3 ray = pixel_ray(), p = ray * (nothing ? 1.0 : near / stored), n = unpack_normal(words.x);
    vec3 tangent = unpack_tangent(words.x, n);
    int row = material_row(words);
    vec4 paint = vec4(0.0);
    float picture = texelFetch(materials, ivec2(2, row), 0).z;
    if (picture != -1.0) paint = texelFetch(paint_map, ivec2(gl_FragCoord.xy), 0);
    paint *= paint;
    Surface s = surface_at(p, n, tangent, unpack_tile(words.y), row, 1.0 / intrinsics.x, paint);
    add_fine_detail(s, stored_words.zw, row, tangent, 1.0 / intrinsics.x);
    if (picture == -2.0) roughen(s, paint.a);

    vec2 half_way = floor(gl_FragCoord.xy) * 0.5, corner = floor(half_way) + 1.0, f = fract(half_way);
    vec4 weight = vec4(1.0 - f.x, f.x, f.x, 1.0 - f.x) * vec4(f.y, f.y, 1.0 - f.y, 1.0 - f.y);
    weight *= on_plane(Plane(n, dot(n, p), p.z / intrinsics.x), corner, 1.0) + 1e-3;
    // The place between the four samples from which plain interpolation gives them these weights.
    vec2 at = corner - 0.5 + vec2(weight.y + weight.z, weight.x + weight.y) / dot(weight, vec4(1.0));
    at /= vec2(textureSize(soft_depth, 0));
    vec4 seen[2] = vec4[](textureLod(visibility_a, at, 0.0), textureLod(visibility_b, at, 0.0));

    vec3 matt = vec3(0.0), gloss = vec3(0.0);
    reflect_surroundings(s, textureLod(around, at, 0.0), textureLod(near_light, at, 0.0).x, matt, gloss);
    DirectLight direct = DirectLight(vec3(0.0), vec3(0.0), vec3(0.0));
    ADD_LIGHTS                     // add_light(0, seen[0][0], s, direct); ...: constant indices cost a CPU far less
    reflect_direct(direct, s, matt, gloss);
    vec3 linear = (matt + gloss + s.base * s.emission) * exposure;
    if (nothing) linear = vec3((dot(ray, up) >= 0.0 ? sky : ground) * exposure);
    out_color = vec4(srgb(tone_map(linear)), float(face_hash(words)) / 255.0);
}
