// What is left of the light on a floor beside and under what stands on it, see contact.py.
uniform sampler2D contact_map;
uniform mat4x3 contact_camera;        // camera-frame point on the map (1 = its edge), and its height over the floor (m)
uniform float contact_texel;          // metres

const float FLOOR_FROM = 0.004, FLOOR_TO = 0.03;  // metres over the floor in which its light goes over to none of it

float light_at_foot(vec3 p) {
    vec3 at = contact_camera * vec4(p, 1.0);
    float on_floor = clamp((FLOOR_TO - abs(at.z)) / (FLOOR_TO - FLOOR_FROM), 0.0, 1.0);
    if (on_floor == 0.0 || at.xy != clamp(at.xy, vec2(0.0), vec2(1.0))) return 1.0;
    float lod = log2(2.0 * p.z / (intrinsics.x * contact_texel));
    return mix(1.0, textureLod(contact_map, at.xy, max(lod, 0.0)).x, on_floor);
}
