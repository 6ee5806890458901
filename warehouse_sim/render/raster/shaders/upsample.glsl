// Between what soft.frag computed at every second pixel: only samples on the pixel's own plane count.
// Needs surface.glsl.
uniform sampler2D soft_depth;     // near / z

struct Plane {
    vec3 n;
    float c;                      // dot(n, p) of its points
    float pixel;                  // width of a pixel there (m)
};

// Weights of the four samples about ``corner`` in the order of a gather: (0, 1), (1, 1), (1, 0), (0, 0).
// tolerance: distance from the plane, in pixels, at which a sample counts no more.
vec4 on_plane(Plane plane, vec2 corner, float tolerance) {
    vec4 z = near / max(textureGather(soft_depth, corner / vec2(textureSize(soft_depth, 0))), vec4(1e-6));
    vec2 first = (2.0 * corner - 1.5 - intrinsics.zw) / intrinsics.xy, second = first + 2.0 / intrinsics.xy;
    vec4 x = vec4(first.x, second.x, second.x, first.x), y = vec4(second.y, second.y, first.y, first.y);
    vec4 height = (plane.n.x * x + plane.n.y * y + plane.n.z) * z - plane.c;
    return max(1.0 - abs(height) / (tolerance * plane.pixel), vec4(0.0));
}
