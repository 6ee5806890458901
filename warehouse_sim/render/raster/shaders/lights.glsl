// The lights of the scene; positions and directions in the camera frame.
struct Light {
    vec3 position; float cone_offset;
    vec3 axis; float cone_scale;
    vec3 intensity; float texel_angle;
    vec4 to_light[3];             // rows of T_light_camera
    vec2 tile_scale; vec2 tile_offset;
    vec2 tile_low; vec2 tile_high;
    vec2 softness;                // radius of the light in texels of a map at SHADOW_NEAR
    vec2 map_ramp;                // what is kept of directions far from its axis, see light_selection.py
    vec3 along; float layer;      // half plane 0 of its distribution, and that one's layer; -1 = it has a cone
};
layout(std140) uniform Lights { Light lights[MAX_LIGHTS]; };
