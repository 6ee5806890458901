// How a surface looks under the lights of the scene, in the camera frame. Needs lights.glsl.
uniform sampler2D materials;
uniform sampler2DArray textures;
uniform float exposure;

const float PI = 3.14159265;

float fifth(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

struct Surface {
    vec3 p, v;                    // position, direction to the camera
    vec3 g, n;                    // normal of the geometry, and as the normal map bends it
    float nv, away;               // cosine between n and v, and (1 - it)^5
    vec3 base, diffuse, f0;
    float roughness, a;           // perceptual, and its square
    float metallic, emission;
    float factor;                 // of the texture on the base colour
#if RETROREFLECTORS
    float throws_back;            // 1 for retroreflectors
#endif
};

// What material ``row`` makes of a point. tangent: direction of the texture's u axis; pixel: width of a pixel at z = 1 m;
// paint: albedo on top of it, multiplied by its alpha, the fraction that it covers.
Surface surface_at(vec3 p, vec3 g, vec3 tangent, vec2 tile, int row, float pixel, vec4 paint) {
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
    s.base = s.base * (1.0 - paint.a) + paint.rgb;
    s.away = fifth(1.0 - min(s.nv, 1.0));
    s.roughness = clamp(s.roughness, 0.05, 1.0);
    s.a = s.roughness * s.roughness;
    s.metallic = more.x;
    s.f0 = mix(vec3(0.04), s.base, s.metallic);
    s.diffuse = s.base * (1.0 - s.metallic) / PI;
    s.emission = more.y;
#if RETROREFLECTORS
    s.throws_back = texelFetch(materials, ivec2(2, row), 0).w;
#endif
    return s;
}

// What a rough surface scatters over what an ideally matt one does: Burley 2015, "Extending the Disney BRDF", 4.1.
// from, to: (1 - cosine)^5 of the directions that light comes from and goes to; back: 2 roughness cos^2 of half the
// angle between them.
float matt_fraction(float from, float to, float back) {
    return (1.0 - 0.5 * from) * (1.0 - 0.5 * to) + back * (from + to + from * to * (back - 1.0));
}

// Direct light at a surface, before its colours are known.
struct DirectLight {
    vec3 matt;                    // irradiance
    vec3 gloss, rim;              // mirrored by a surface that reflects nothing, and everything, at a grazing angle
};

#if DISTRIBUTIONS
uniform sampler2DArray distributions;  // intensity over the greatest: angle from the axis, half plane

// Intensity over the greatest from light i in the unit direction -l.
float spread(const int i, vec3 l, float cone) {
    if (lights[i].layer < 0.0) return cone * cone;
    vec3 axis = lights[i].axis, along = lights[i].along;
    float angle = acos(clamp(-dot(l, axis), -1.0, 1.0));
    float turned = atan(-dot(l, cross(along, axis)), -dot(l, along));
    vec2 size = vec2(textureSize(distributions, 0).xy);
    vec2 at = vec2(angle / PI * (size.x - 1.0) + 0.5, turned / (2.0 * PI) * size.y + 0.5) / size;
    return textureLod(distributions, vec3(at, lights[i].layer), 0.0).x;
}
#endif

#if RETROREFLECTORS
// Light thrown back over that of white which faces the lamp, as sensors/retroreflectors.py; lv, nl: cosines of the
// observation angle and of the incidence.
float thrown_back(float lv, float nl) {
    float angle = degrees(acos(clamp(lv, -1.0, 1.0)));
    float fraction = angle < 1.0 ? 250.0 * pow(max(angle, 0.2) * 3.0, -2.096) : 25.0 / (angle * angle);
    return angle > 10.0 ? 0.0 : PI * min(fraction, 330.0) * pow(nl, 6.0);
}
#endif

// Add light i, of which the point sees a fraction.
void add_light(const int i, float seen, Surface s, inout DirectLight sum) {
    vec3 to_light = lights[i].position - s.p;
    float inverse_distance = inversesqrt(dot(to_light, to_light));
    vec3 l = to_light * inverse_distance;
    float cosine = dot(s.n, l), nl = max(cosine, 0.0), lv = dot(l, s.v);
    float along = -dot(l, lights[i].axis);
    float cone = clamp(along * lights[i].cone_scale + lights[i].cone_offset, 0.0, 1.0);
    seen *= clamp(along * lights[i].map_ramp.x + lights[i].map_ramp.y, 0.0, 1.0);
#if DISTRIBUTIONS
    float fraction = seen * spread(i, l, cone) * inverse_distance * inverse_distance;
#else
    float fraction = seen * cone * cone * inverse_distance * inverse_distance;
#endif
#if RETROREFLECTORS
    float facing = dot(s.g, l) > 0.0 ? fraction : 0.0;
#endif
    fraction = dot(s.g, l) > 0.0 ? fraction * nl : 0.0;
    // With the half vector h = (l + v) / |l + v|.
    float inverse_length = inversesqrt(2.0 + 2.0 * lv + 1e-4);
    float nh = (cosine + s.nv) * inverse_length, vh = (1.0 + lv) * inverse_length;
    // GGX (Walter et al. 2007) with Hammon's joint masking-shadowing (GDC 2017) and Schlick's Fresnel.
    float a2 = s.a * s.a;
    float spread = nh * nh * (a2 - 1.0) + 1.0;
    float lobe = fraction * a2 / (2.0 * PI * spread * spread * mix(2.0 * nl * s.nv, nl + s.nv, s.a));
    float rim = lobe * fifth(1.0 - vh);
    fraction *= matt_fraction(fifth(1.0 - nl), s.away, 2.0 * s.roughness * vh * vh);
    sum.matt += lights[i].intensity * fraction;
    sum.gloss += lights[i].intensity * (lobe - rim);
    sum.rim += lights[i].intensity * rim;
#if RETROREFLECTORS
    if (s.throws_back > 0.0) sum.matt += lights[i].intensity * (facing * thrown_back(lv, nl) / dot(s.base, LUMINANCE));
#endif
}

// Add what all lights do to the light that goes to the camera: scattered below the surface, and mirrored.
void reflect_direct(DirectLight sum, Surface s, inout vec3 matt, inout vec3 gloss) {
    matt += sum.matt * s.diffuse;
    gloss += sum.gloss * s.f0 + sum.rim;
}

// Environment part of the split-sum approximation (Karis 2014, "Physically based shading on mobile").
vec3 ambient_specular(vec3 f0, float roughness, float nv) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a004 = min(r.x * r.x, exp2(-9.28 * nv)) * r.x + r.y;
    vec2 ab = vec2(-1.04, 1.04) * a004 + r.zw;
    return f0 * ab.x + ab.y;
}

// Light that near surfaces keep off a pale one comes back from them (Jimenez et al. 2016, "Practical realtime strategies
// for accurate indirect occlusion"). near_light: the fraction that would be left between black ones.
vec3 reflected_back(float near_light, vec3 albedo) {
    vec3 a = 2.0404 * albedo - 0.3324, b = -4.7951 * albedo + 0.6417, c = 2.7552 * albedo + 0.6903;
    return max(vec3(near_light), ((near_light * a + b) * near_light + c) * near_light);
}

// Add what the surroundings do. around: irradiance, and the grey one of a surface that looks where the mirror image lies.
// It is not kept as a ratio: between a dark face and a bright one that would be bright by far.
void reflect_surroundings(Surface s, vec4 around, float near_light, inout vec3 matt, inout vec3 gloss) {
    // Means over the half space: (1 - cosine)^5 is 1/21, cos^2 of half the angle to v is 1/2 + nv / 3.
    float fraction = matt_fraction(1.0 / 21.0, s.away, s.roughness * (1.0 + s.nv * 2.0 / 3.0));
    matt += around.rgb * reflected_back(near_light, s.base) * s.diffuse * fraction;
    float grey = max(dot(around.rgb, LUMINANCE), 1e-3);
    gloss += around.rgb * (around.a / grey * near_light / PI) * ambient_specular(s.f0, s.roughness, s.nv);
}

// Fit of the ACES reference tone curve (Narkowicz 2016, "ACES filmic tone mapping curve").
vec3 tone_map(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 srgb(vec3 x) {               // IEC 61966-2-1, as warehouse_sim/color.py
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, greaterThan(x, vec3(0.0031308)));
}
