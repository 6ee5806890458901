// Light from the surroundings: the fields of irradiance.py, the fine one inside of the coarse one. A level's volume is
// eight blocks above each other: the irradiance along each of six directions, and how far a point sees along them.
const int LEVELS = 2;
uniform sampler3D field;
uniform mat3 world_camera;            // rotation
uniform mat4x3 field_camera[LEVELS];  // camera-frame point in cells of a level, whole numbers at its points
uniform vec3 field_size[LEVELS];      // points along the axes
uniform vec3 field_spacing[LEVELS];   // metres
uniform float field_first[LEVELS];    // layer of the volume at which a level starts
uniform vec3 field_fades[2];          // 1 on low and high sides beyond which the coarse level goes on

const float LIFT = 0.25;              // spacings along the normal, away from what is behind the surface
const float SOFT = 0.3;               // spacings over which a point loses sight of what is behind a wall
const float FADE = 1.5;               // cells over which the fine level gives way to the coarse one
const float LEAST = 1e-4;             // weight of a point that does not see a place

struct Around {
    vec3 irradiance;                  // (lx) on the surface
    vec3 mirrored;                    // on one that looks where its mirror image lies
};

vec3 field_value(ivec3 at, int block, int nz) {
    return texelFetch(field, ivec3(at.xy, at.z + block * nz), 0).rgb;
}

// p, n: place and normal in the camera frame; w, m: normal and mirrored direction in the world.
Around level_around(int level, vec3 p, vec3 n, vec3 w, vec3 m) {
    vec3 spacing = field_spacing[level];
    vec3 at = field_camera[level] * vec4(p, 1.0) + w * LIFT * dot(spacing, abs(w)) / spacing;
    ivec3 last = ivec3(field_size[level]) - 1, first = clamp(ivec3(floor(at)), ivec3(0), max(last - 1, ivec3(0)));
    vec3 f = clamp(at - vec3(first), vec3(0.0), vec3(1.0));
    int nz = last.z + 1;
    ivec3 block = ivec3(mix(vec3(0.0, 1.0, 2.0), vec3(3.0, 4.0, 5.0), lessThan(w, vec3(0.0))));
    ivec3 turned = ivec3(mix(vec3(0.0, 1.0, 2.0), vec3(3.0, 4.0, 5.0), lessThan(m, vec3(0.0))));
    vec3 fraction = w * w, mirror = m * m;
    Around sum = Around(vec3(0.0), vec3(0.0));
    float weights = 0.0;
    for (int k = 0; k < 8; k++) {
        ivec3 corner = ivec3(k & 1, (k >> 1) & 1, k >> 2);
        ivec3 cell = min(first + corner, last);
        vec3 away = clamp(at, vec3(0.0), vec3(last)) - vec3(cell);  // from the point of the grid, in cells
        ivec3 texel = ivec3(cell.xy, cell.z + int(field_first[level]));
        vec4 up = texelFetch(field, texel + ivec3(0, 0, 6 * nz), 0), down = texelFetch(field, texel + ivec3(0, 0, 7 * nz), 0);
        vec3 reach = mix(up.xyz, down.xyz, lessThan(away, vec3(0.0)));
        vec3 sees = clamp((reach - abs(away)) / SOFT + 1.0, vec3(0.0), vec3(1.0));
        vec3 near = mix(1.0 - f, f, vec3(corner));
        float facing = 0.5 - 0.5 * dot(w, normalize(away * spacing + 1e-4));
        float weight = near.x * near.y * near.z * (LEAST + up.w * sees.x * sees.y * sees.z * (facing * facing + 0.1));
        sum.irradiance += weight * (fraction.x * field_value(texel, block.x, nz) + fraction.y * field_value(texel, block.y, nz) +
                                    fraction.z * field_value(texel, block.z, nz));
        sum.mirrored += weight * (mirror.x * field_value(texel, turned.x, nz) +
                                  mirror.y * field_value(texel, turned.y, nz) + mirror.z * field_value(texel, turned.z, nz));
        weights += weight;
    }
    return Around(sum.irradiance / weights, sum.mirrored / weights);
}

// Light from the surroundings at a place p with normal n, both in the camera frame, seen from the camera.
Around light_around(vec3 p, vec3 n) {
    vec3 w = world_camera * n, m = world_camera * reflect(normalize(p), n);
    vec3 at = field_camera[0] * vec4(p, 1.0);
    vec3 low = mix(vec3(1.0), clamp((at + 0.5) / FADE, 0.0, 1.0), field_fades[0]);
    vec3 high = mix(vec3(1.0), clamp((field_size[0] - 0.5 - at) / FADE, 0.0, 1.0), field_fades[1]);
    float fine = min(min(min(low.x, low.y), low.z), min(min(high.x, high.y), high.z));
    Around around = Around(vec3(0.0), vec3(0.0));
    if (fine > 0.0) around = level_around(0, p, n, w, m);
    if (fine < 1.0) {
        Around coarse = level_around(1, p, n, w, m);
        around.irradiance = mix(coarse.irradiance, around.irradiance, fine);
        around.mirrored = mix(coarse.mirrored, around.mirrored, fine);
    }
    return around;
}

// What a surface of this roughness mirrors over what the fields say of that side of it, as hall_probe.py.
uniform sampler3D probe;
const float MATT = 0.85;              // roughness from which on the fields' six directions say as much
float mirrored_detail(vec3 p, vec3 n, float roughness) {
    if (roughness > MATT) return 1.0;
    vec3 m = world_camera * reflect(normalize(p), n);
    vec2 turn = vec2(atan(m.y, m.x) / 6.2831853, acos(clamp(m.z, -1.0, 1.0)) / 3.14159265);
    return textureLod(probe, vec3(turn, roughness), 0.0).x;
}
