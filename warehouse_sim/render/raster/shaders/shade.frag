struct Light {
    vec3 position; float cone_offset;
    vec3 axis; float cone_scale;
    vec3 intensity; float texel_angle;
    vec4 to_light[3];             // rows of T_light_camera
    vec2 tile_scale; vec2 tile_offset;
    vec2 tile_low; vec2 tile_high;
};
layout(std140) uniform Lights { Light lights[MAX_LIGHTS]; };

uniform sampler2D materials;
uniform sampler2DArray textures;
uniform sampler2D shadow_atlas;   // SHADOW_NEAR / distance along the lamp's axis
uniform vec3 up;                  // world z in the camera frame
uniform float ambient;            // lx
uniform float exposure;

layout(location = 0) out vec4 out_color;  // alpha: hash of the face that the pixel shows

const float PI = 3.14159265;
const float LIFT_TEXELS = 1.5;    // two are needed in the worst case, but lift shadows off what casts them
const float GROUND = 0.3;         // share of the ambient light that the surroundings return from below

struct Surface {
    vec3 p, n, v;                 // position, normal, direction to the camera; camera frame
    float nv;
    vec3 diffuse, f0;
    float a;                      // squared perceptual roughness
};

// Share of 4 x 4 texels around a point that see the lamp, weighted by a box of 3 x 3 texels that moves with the point.
float filtered_shadow(vec2 at, float reference) {
    vec2 grid = at * ATLAS_PX - 0.5;
    vec2 f = fract(grid);
    vec2 base = floor(grid) / ATLAS_PX;
    const float two = 2.0 / ATLAS_PX;
    vec4 limit = vec4(reference);
    vec4 a = vec4(lessThanEqual(textureGather(shadow_atlas, base), limit));
    vec4 b = vec4(lessThanEqual(textureGather(shadow_atlas, base + vec2(two, 0.0)), limit));
    vec4 c = vec4(lessThanEqual(textureGather(shadow_atlas, base + vec2(0.0, two)), limit));
    vec4 d = vec4(lessThanEqual(textureGather(shadow_atlas, base + two), limit));
    // A gather returns its four texels in the order (0, 1), (1, 1), (1, 0), (0, 0).
    vec4 rows = vec4((1.0 - f.x) * a.w + a.z + b.w + f.x * b.z,
                     (1.0 - f.x) * a.x + a.y + b.x + f.x * b.y,
                     (1.0 - f.x) * c.w + c.z + d.w + f.x * d.z,
                     (1.0 - f.x) * c.x + c.y + d.x + f.x * d.y);
    return dot(rows, vec4(1.0 - f.y, 1.0, 1.0, f.y)) / 9.0;
}

float visibility(const int i, Surface s) {
    vec4 q = vec4(s.p, 1.0);
    // Along the normal, so that the back of a sheet a few millimetres thick does not shade its front across a texel.
    q.xyz += s.n * (LIFT_TEXELS * lights[i].texel_angle * dot(lights[i].to_light[2], q));
    vec3 r = vec3(dot(lights[i].to_light[0], q), dot(lights[i].to_light[1], q), dot(lights[i].to_light[2], q));
    vec2 at = r.xy / r.z * lights[i].tile_scale + lights[i].tile_offset;
    bool mapped = r.z > SHADOW_NEAR && at == clamp(at, lights[i].tile_low, lights[i].tile_high);
    return mapped ? filtered_shadow(at, SHADOW_NEAR / r.z) : 1.0;
}

vec3 reflected(const int i, const bool shadowed, Surface s) {
    vec3 to_lamp = lights[i].position - s.p;
    float inverse_distance = inversesqrt(dot(to_lamp, to_lamp));
    vec3 l = to_lamp * inverse_distance;
    float nl = max(dot(s.n, l), 0.0);
    float cone = clamp(-dot(l, lights[i].axis) * lights[i].cone_scale + lights[i].cone_offset, 0.0, 1.0);
    float share = nl * cone * cone * inverse_distance * inverse_distance;
    if (shadowed) share *= visibility(i, s);
    vec3 h = normalize(l + s.v);
    float nh = dot(s.n, h), vh = dot(s.v, h);
    // GGX (Walter et al. 2007) with Hammon's joint masking-shadowing (GDC 2017) and Schlick's Fresnel.
    float a2 = s.a * s.a;
    float spread = nh * nh * (a2 - 1.0) + 1.0;
    float lobe = a2 / (PI * spread * spread) * 0.5 / mix(2.0 * nl * s.nv, nl + s.nv, s.a);
    float grazing = 1.0 - vh;
    float grazing2 = grazing * grazing;
    vec3 fresnel = s.f0 + (1.0 - s.f0) * (grazing2 * grazing2 * grazing);
    return lights[i].intensity * share * (s.diffuse + fresnel * lobe);
}

// Environment part of the split-sum approximation (Karis 2014, "Physically based shading on mobile").
vec3 ambient_specular(vec3 f0, float roughness, float nv) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// Fit of the ACES reference tone curve (Narkowicz 2016, "ACES filmic tone mapping curve").
vec3 tone_map(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 srgb(vec3 x) {               // IEC 61966-2-1
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}

void main() {
    float stored = texelFetch(depth_map, ivec2(gl_FragCoord.xy), 0).x;
    uvec2 word = texelFetch(surface_map, ivec2(gl_FragCoord.xy), 0).xy;
    bool nothing = stored <= 0.0;
    vec3 ray = pixel_ray();
    float z = nothing ? 1.0 : near / stored;
    int material = int(word.x >> 24);
    vec4 look = texelFetch(materials, ivec2(0, material), 0);
    vec4 more = texelFetch(materials, ivec2(1, material), 0);
    vec3 base = look.rgb;

    Surface s;
    s.p = ray * z;
    s.n = unpack_normal(word.x);
    s.v = -normalize(ray);
    s.nv = max(dot(s.n, s.v), 1e-3);
    if (more.z >= 0.0) {
        // The pixel's footprint in texels, halfway between its short and its long side.
        float footprint = z / intrinsics.x * inversesqrt(s.nv) * more.w * float(TEXTURE_PX);
        vec3 at = vec3(unpack_texture_coordinate(word.y), more.z);
        base *= textureLod(textures, at, log2(footprint)).x * (255.0 / 128.0);
    }
    float roughness = max(look.a, 0.05);
    s.a = roughness * roughness;
    s.f0 = mix(vec3(0.04), base, more.x);
    s.diffuse = base * (1.0 - more.x) / PI;

    float irradiance = ambient * mix(GROUND, 1.0, 0.5 + 0.5 * dot(s.n, up));
    vec3 radiance = irradiance * (s.diffuse + ambient_specular(s.f0, roughness, s.nv) / PI);
    ADD_LIGHTS                    // radiance += reflected(0, true, s); ...: constant indices, which cost a CPU far less
    vec3 linear = radiance * exposure + base * more.y;
    if (nothing) linear = vec3(ambient / PI * GROUND * exposure);
    out_color = vec4(srgb(tone_map(linear)), float(word.y >> 24) / 255.0);
}
