flat in int instance_id;
flat in uint surface;
flat in uint face;
in vec2 texture_coordinate;

layout(location = 0) out int out_instance_id;
layout(location = 1) out uvec2 out_surface;

void main() {
    out_instance_id = instance_id;
    uvec2 tile = uvec2(fract(texture_coordinate) * 4096.0) & 4095u;   // place in the texture in 2 x 12 bits
    out_surface = uvec2(surface, tile.x | (tile.y << 12) | (face << 24));
}
