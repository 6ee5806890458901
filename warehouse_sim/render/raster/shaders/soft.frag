// Light that changes slowly over a surface, at every second pixel of every second row.
layout(location = 0) out float out_depth;          // near / z of that pixel
layout(location = 1) out float out_near_light;     // see occlusion.glsl
layout(location = 2) out vec4 out_around;          // from the surroundings: irradiance; grey one of what is mirrored
layout(location = 3) out vec4 out_visibility[2];   // of the lights that have a shadow map

void main() {
    ivec2 at = min(ivec2(gl_FragCoord.xy) * 2, textureSize(depth_map, 0) - 1);
    float stored = texelFetch(depth_map, at, 0).x;
    uvec2 words = texelFetch(surface_map, at, 0).xy;
    vec3 n = even_normal(at, words, unpack_normal(words.x));
    vec3 p = vec3((vec2(at) + 0.5 - intrinsics.zw) / intrinsics.xy, 1.0) * (near / max(stored, 1e-6));

    out_depth = stored;
    ivec2 block = ivec2(gl_FragCoord.xy) & 3;
    out_near_light = near_light(vec2(at) + 0.5, p, n, 6.2831853 / 16.0 * float(block.x * 4 + (block.y ^ block.x)));
    float foot = light_at_foot(p);
    out_near_light = min(out_near_light, foot);

    Around around = light_around(p, n);
    float detail = mirrored_detail(p, n, texelFetch(materials, ivec2(0, material_row(words)), 0).a);
    out_around = vec4(around.irradiance, dot(around.mirrored, LUMINANCE) * detail);

    vec4 seen[2] = vec4[](vec4(1.0), vec4(1.0));
    float angle = 1.5707963 / 4.0 * float((block.x & 1) * 2 + ((block.x ^ block.y) & 1));
    mat2 turn = mat2(cos(angle), sin(angle), -sin(angle), cos(angle));
    ADD_SHADOWS                    // seen[0][0] = visibility(0, p, n, turn); ...: constant indices cost far less
    out_visibility[0] = seen[0] * foot;
    out_visibility[1] = seen[1] * foot;
}
