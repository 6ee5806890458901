flat in int instance_id;
flat in uvec2 surface;
in vec2 texture_coordinate;
in vec2 on_face;
flat in uint face;
in vec4 to_edge;              // linear on the face, 0 on an edge of it
flat in vec4 plane;           // n, n . p

uniform vec4 intrinsics;      // as in place.glsl
uniform float near;

// What a kind of part adds: nothing; the albedo of a picture in paint; another normal in words,
// and edges that are no borders.
layout(location = 0) out int out_instance_id;
layout(location = 1) out uvec4 out_surface;  // see pack.glsl and fine.glsl
layout(location = 2) out vec4 out_reach;
layout(location = 3) out float out_depth;  // near / z, as in the depth buffer

float most(vec4 v) {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// For the left, right, top and bottom of the pixel: where the face ends there within a pixel of its centre, as
// 4 * (63 - 63 * distance) + 4 * slope of the border, over 255; else 0. An edge counts on the side that it runs across
// (Persson 2011, "Geometry buffer antialiasing"; there a geometry shader finds the distances).
vec4 reach() {
    vec4 on_screen = to_edge * gl_FragCoord.w;  // divided by z it is linear in the image, too
    vec4 across = dFdx(on_screen), down = dFdy(on_screen);
    bvec4 upright = greaterThan(abs(across), abs(down));
    vec4 steep = mix(down, across, upright), other = mix(across, down, upright);
    vec4 distance = max(on_screen, 0.0) / abs(steep);  // infinite where there is no edge
    DROP_EDGES(across, down, distance)
    vec4 code = ceil(63.0 - 63.0 * distance) * 4.0 + min(floor(abs(other / steep) * 4.0), 3.0);
    code = mix(vec4(0.0), code, lessThan(distance, vec4(1.0)));
    vec4 before = mix(vec4(0.0), code, greaterThan(steep, vec4(0.0))), after = code - before;
    vec4 side_before = mix(vec4(0.0), before, upright), side_after = mix(vec4(0.0), after, upright);
    return vec4(most(side_before), most(side_after), most(before - side_before), most(after - side_after)) / 255.0;
}

// Interpolated, except where that is wrong: a strip that is long, thin and begins behind the camera has corners so far
// outside the image that rounding decides its gradient. There it is the depth of the face's plane on the pixel's ray.
float exact_depth() {
    vec3 ray = vec3((gl_FragCoord.xy - intrinsics.zw) / intrinsics.xy, 1.0);
    float of_plane = near * dot(plane.xyz, ray) / plane.w;
    return abs(of_plane - gl_FragCoord.z) < TRUSTED * gl_FragCoord.z || of_plane <= 0.0 ? gl_FragCoord.z : of_plane;
}

void main() {
    out_instance_id = instance_id;
    uvec2 words = surface;
    ADD_LOOK(words)
    out_surface = uvec4(words.x, words.y | pack_tile(texture_coordinate), pack_place(on_face), face);
    out_reach = reach();
    out_depth = exact_depth();
}
