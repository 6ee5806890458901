// Light from the surroundings: the field of irradiance.py, six blocks above each other, one a direction.
uniform sampler3D field;
uniform vec3 field_size;          // points along the axes
uniform mat4x3 field_camera;      // camera-frame point in cells of the field
uniform mat3 world_camera;        // rotation
uniform float field_lift;         // metres along the normal, away from what is behind the surface

vec4 field_block(vec3 at, float block) {
    vec3 place = vec3(at.xy, clamp(at.z, 0.5, field_size.z - 0.5) + block * field_size.z);
    return textureLod(field, place / (field_size * vec3(1.0, 1.0, 6.0)), 0.0);
}

// Irradiance (lx) at cell ``at`` of a surface with world normal n; points inside things hardly count.
vec3 field_irradiance(vec3 at, vec3 n) {
    vec3 share = n * n, block = mix(vec3(0.0, 1.0, 2.0), vec3(3.0, 4.0, 5.0), lessThan(n, vec3(0.0)));
    vec4 sum = share.x * field_block(at, block.x) + share.y * field_block(at, block.y) +
               share.z * field_block(at, block.z);
    return sum.rgb / sum.a;
}
