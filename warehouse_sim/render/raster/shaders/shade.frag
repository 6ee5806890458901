layout(location = 0) out vec4 out_color;  // alpha: hash of the face that the pixel shows

void main() {
    float stored = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).x;
    uvec2 words = texelFetch(surface_map, ivec2(gl_FragCoord.xy), 0).xy;
    bool nothing = stored <= 0.0;
    vec3 p = pixel_ray() * (nothing ? 1.0 : near / stored), n = unpack_normal(words.x);
    vec3 tangent = unpack_tangent(words.y, n);
    Surface s = surface_at(p, n, tangent, unpack_tile(words.y), int(words.x >> 24), 1.0 / intrinsics.x);

    vec3 matt = vec3(0.0), gloss = vec3(0.0);
    reflect_even_light(s, matt, gloss);
    ADD_LIGHTS                    // reflect_lamp(0, true, s, matt, gloss); ...: constant indices cost a CPU far less
    vec3 linear = (matt + gloss) * exposure + s.base * s.emission;
    if (nothing) linear = vec3(ambient / PI * GROUND * exposure);
    out_color = vec4(srgb(tone_map(linear)), float(face_hash(words)) / 255.0);
}
