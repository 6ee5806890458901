// What the geometry pass stored of a pixel.
uniform sampler2D depth_map;      // near / z, 0 = nothing
uniform usampler2D surface_map;   // see pack.glsl
uniform vec4 intrinsics;          // fx, fy, cx, cy in window coordinates
uniform float near;

vec3 pixel_ray() {                // camera-frame point at z = 1 m
    return vec3((gl_FragCoord.xy - intrinsics.zw) / intrinsics.xy, 1.0);
}
