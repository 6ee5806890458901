// Fraction of the surroundings' light that what is near leaves to a point: McGuire, Mara and Luebke 2012, "Scalable
// ambient obscurance". Needs surface.glsl.
const float REACH = 0.8;          // metres from which on nothing occludes
const float REACH_PX = 240.0;     // what is close to the camera is searched only so far
const float RELIEF_PX = 6.5;      // what stands out less (px) is too fine for so few samples: ribs would show as rings
const float STRENGTH = 2.4;       // by the fraction of blocks (12 views, 5,016 blocks) within 1.25 of a path tracer's light

// pixel: where p shows; turn: angle that differs between the pixels of a block, over which the result is averaged.
float near_light(vec2 pixel, vec3 p, vec3 n, float turn) {
    float per_metre = intrinsics.x / p.z;
    float reach_px = min(REACH * per_metre, REACH_PX), reach = reach_px / per_metre;
    float reach2 = reach * reach, bias = RELIEF_PX / per_metre, sum = 0.0;
    vec2 axis = reach_px * vec2(cos(turn), sin(turn));
    vec2 last = vec2(textureSize(depth_map, 0)) - 1.0;
    vec2 taps[OCCLUSION_TAPS] = vec2[](OCCLUSION_DISK);
    for (int k = 0; k < OCCLUSION_TAPS; k++) {
        vec2 offset = vec2(axis.x * taps[k].x - axis.y * taps[k].y, axis.y * taps[k].x + axis.x * taps[k].y);
        vec2 at = clamp(floor(pixel + offset), vec2(0.0), last);
        float z = near / max(texelFetch(depth_map, ivec2(at), 0).x, 1e-6);
        vec3 d = vec3((at + 0.5 - intrinsics.zw) / intrinsics.xy, 1.0) * z - p;
        float d2 = dot(d, d), fade = max(1.0 - d2 / reach2, 0.0);
        sum += fade * max(dot(d, n) - bias, 0.0) / (d2 + 1e-4);
    }
    return max(1.0 - STRENGTH * reach * sum / float(OCCLUSION_TAPS), 0.0);
}
