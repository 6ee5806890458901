// Averages of what soft.frag sampled in other ways at neighbouring pixels, over those on the pixel's own plane:
// 4 x 4 of the occlusion, 2 x 2 of the shadows.
uniform sampler2D raw_near_light, raw_visibility_a, raw_visibility_b;

layout(location = 0) out float out_near_light;
layout(location = 1) out vec4 out_visibility[2];

void main() {
    ivec2 at = min(ivec2(gl_FragCoord.xy) * 2, textureSize(depth_map, 0) - 1);
    vec3 n = unpack_normal(texelFetch(surface_map, at, 0).x);
    float z = near / max(texelFetch(depth_map, at, 0).x, 1e-6);
    vec3 ray = vec3((vec2(at) + 0.5 - intrinsics.zw) / intrinsics.xy, 1.0);
    Plane plane = Plane(n, dot(n, ray) * z, z / intrinsics.x);
    vec2 size = vec2(textureSize(soft_depth, 0)), first = floor(gl_FragCoord.xy) - 1.0;
    float sum = 1e-4, weights = 1e-4;
    vec4 last;
    for (int k = 0; k < 4; k++) {
        vec2 corner = first + vec2(k & 1, k >> 1) * 2.0;
        vec4 weight = on_plane(plane, corner, 3.0);
        sum += dot(weight, textureGather(raw_near_light, corner / size));
        weights += dot(weight, vec4(1.0));
        last = weight;
    }
    out_near_light = sum / weights;
    // The last four are the pixel itself and its neighbours to the right and below.
    last /= dot(last, vec4(1.0));
    ivec2 me = ivec2(gl_FragCoord.xy), most = textureSize(soft_depth, 0) - 1;
    ivec2 right = min(me + ivec2(1, 0), most), below = min(me + ivec2(0, 1), most), both = min(me + 1, most);
    out_visibility[0] = last.w * texelFetch(raw_visibility_a, me, 0) + last.z * texelFetch(raw_visibility_a, right, 0) +
                        last.x * texelFetch(raw_visibility_a, below, 0) + last.y * texelFetch(raw_visibility_a, both, 0);
    out_visibility[1] = last.w * texelFetch(raw_visibility_b, me, 0) + last.z * texelFetch(raw_visibility_b, right, 0) +
                        last.x * texelFetch(raw_visibility_b, below, 0) + last.y * texelFetch(raw_visibility_b, both, 0);
}
