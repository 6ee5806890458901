flat in int instance_id;
flat in uvec2 surface;
in vec2 texture_coordinate;

layout(location = 0) out int out_instance_id;
layout(location = 1) out uvec2 out_surface;

void main() {
    out_instance_id = instance_id;
    out_surface = uvec2(surface.x, surface.y | pack_tile(texture_coordinate));
}
