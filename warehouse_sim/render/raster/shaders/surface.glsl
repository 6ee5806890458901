// What the geometry pass stored of a pixel, unpacked.
uniform sampler2D depth_map;      // near / z, 0 = nothing
uniform usampler2D surface_map;
uniform vec4 intrinsics;          // fx, fy, cx, cy in window coordinates
uniform float near;

vec3 unpack_normal(uint word) {
    vec2 p = vec2(word & 4095u, (word >> 12) & 4095u) / 4095.0 * 2.0 - 1.0;
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * vec2(n.x >= 0.0 ? 1.0 : -1.0, n.y >= 0.0 ? 1.0 : -1.0);
    return normalize(n);
}

vec2 unpack_texture_coordinate(uint word) {
    return (vec2(word & 4095u, (word >> 12) & 4095u) + 0.5) / 4096.0;
}

vec3 pixel_ray() {                // camera-frame point at z = 1 m
    return vec3((gl_FragCoord.xy - intrinsics.zw) / intrinsics.xy, 1.0);
}
