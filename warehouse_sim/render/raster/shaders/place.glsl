// Shared by every program that draws parts on the pixel grid, so that all of them cover the same pixels.
in vec3 in_position;
in vec3 in_normal;
in vec4 in_to_edge;           // see face_edges.py
in mat3 in_rotation;
in vec3 in_translation;
in vec3 in_scale;
in vec2 in_texture_shift;
in ivec4 in_identity;         // instance id, material row, order and lengths of the edges, thinnest axis
in vec3 in_spread;            // see fine.glsl: steps a unit of position
in vec3 in_start;             // steps at position 0

uniform vec4 intrinsics;   // fx, fy, cx, cy in target coordinates
uniform vec2 window;       // size of the viewport in pixels
uniform float near;

vec3 camera_position() {
    return in_rotation * (in_position * in_scale) + in_translation;
}

// Position = intrinsics applied to p, moved by a whole number of pixels.
vec4 clip_position(vec3 p, vec2 shift) {
    precise vec2 position = intrinsics.xy * p.xy + intrinsics.zw * p.z;
    if (p.z > near) {
        // The rasteriser rounds to 1/256 pixel after operations whose error depends on the shift; rounding here
        // first makes its result, and thus the coverage, the same wherever in a target the object is sampled.
        precise vec2 pixel = floor(position / p.z * 256.0 + 0.5) / 256.0;
        position = (pixel + shift) * p.z;
    } else {
        position += shift * p.z;
    }
    // Reversed depth without far plane: depth = near / z, which a float stores with nearly constant relative error.
    return vec4(position * 2.0 / window - p.z, near, p.z);
}
