// How a surface looks under the lamps of the scene; positions and directions in the camera frame.
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

const float PI = 3.14159265;
const float LIFT_TEXELS = 1.5;    // two are needed in the worst case, but lift shadows off what casts them
const float GROUND = 0.3;         // share of the ambient light that the surroundings return from below

struct Surface {
    vec3 p, v;                    // position, direction to the camera
    vec3 g, n;                    // normal of the geometry, and as the normal map bends it
    float nv;
    vec3 base, diffuse, f0;
    float roughness, a;           // perceptual, and its square
    float emission;
    float factor;                 // of the texture on the base colour
};

// What material ``row`` makes of a point. tangent: direction of the texture's u axis; pixel: width of a pixel at z = 1 m.
Surface surface_at(vec3 p, vec3 g, vec3 tangent, vec2 tile, int row, float pixel) {
    vec4 look = texelFetch(materials, ivec2(0, row), 0);
    vec4 more = texelFetch(materials, ivec2(1, row), 0);
    Surface s;
    s.p = p;
    s.v = -normalize(p);
    s.g = s.n = g;
    s.nv = max(dot(g, s.v), 1e-3);
    s.base = look.rgb;
    s.roughness = look.a;
    s.factor = 1.0;
    if (more.z >= 0.0) {
        // The pixel's footprint in texels, halfway between its short and its long side.
        float footprint = p.z * pixel * inversesqrt(s.nv) * more.w * float(TEXTURE_PX);
        vec4 texel = textureLod(textures, vec3(tile, more.z), log2(footprint)) * 255.0;  // see textures.py
        s.factor = texel.x / 128.0;
        s.base *= s.factor;
        s.roughness *= texel.w / 128.0;
        vec2 bend = texel.yz / 127.0 - 128.0 / 127.0;
        s.n = normalize(g * sqrt(max(1.0 - dot(bend, bend), 0.0)) + tangent * bend.x + cross(g, tangent) * bend.y);
        s.nv = max(dot(s.n, s.v), 1e-3);
    }
    s.roughness = clamp(s.roughness, 0.05, 1.0);
    s.a = s.roughness * s.roughness;
    s.f0 = mix(vec3(0.04), s.base, more.x);
    s.diffuse = s.base * (1.0 - more.x) / PI;
    s.emission = more.y;
    return s;
}

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
    q.xyz += s.g * (LIFT_TEXELS * lights[i].texel_angle * dot(lights[i].to_light[2], q));
    vec3 r = vec3(dot(lights[i].to_light[0], q), dot(lights[i].to_light[1], q), dot(lights[i].to_light[2], q));
    vec2 at = r.xy / r.z * lights[i].tile_scale + lights[i].tile_offset;
    bool mapped = r.z > SHADOW_NEAR && at == clamp(at, lights[i].tile_low, lights[i].tile_high);
    return mapped ? filtered_shadow(at, SHADOW_NEAR / r.z) : 1.0;
}

// Add what lamp i sends to the camera: scattered below the surface, and mirrored by it.
void reflect_lamp(const int i, const bool shadowed, Surface s, inout vec3 matt, inout vec3 gloss) {
    vec3 to_lamp = lights[i].position - s.p;
    float inverse_distance = inversesqrt(dot(to_lamp, to_lamp));
    vec3 l = to_lamp * inverse_distance;
    float nl = dot(s.g, l) > 0.0 ? max(dot(s.n, l), 0.0) : 0.0;
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
    vec3 arriving = lights[i].intensity * share;
    matt += arriving * s.diffuse;
    gloss += arriving * fresnel * lobe;
}

// Environment part of the split-sum approximation (Karis 2014, "Physically based shading on mobile").
vec3 ambient_specular(vec3 f0, float roughness, float nv) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// Add what the even light does.
void reflect_even_light(Surface s, inout vec3 matt, inout vec3 gloss) {
    float irradiance = ambient * mix(GROUND, 1.0, 0.5 + 0.5 * dot(s.n, up));
    matt += irradiance * s.diffuse;
    gloss += irradiance * ambient_specular(s.f0, s.roughness, s.nv) / PI;
}

// Fit of the ACES reference tone curve (Narkowicz 2016, "ACES filmic tone mapping curve").
vec3 tone_map(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 srgb(vec3 x) {               // IEC 61966-2-1
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}
