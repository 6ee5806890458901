uniform float pixel;              // width of a pixel at z = 1 m
uniform sampler2D visibility_a, visibility_b;  // of the solid surface behind, see soft.frag

flat in int material;
flat in vec3 normal;
flat in vec3 tangent;
in vec3 point;
in vec2 texture_coordinate;
in vec4 around;                   // irradiance from the surroundings, and the grey one that is mirrored

layout(location = 0) out vec4 out_color;  // multiplied by alpha, the fraction of what lies behind that is covered

const float MIDDLE = 0.18;        // the linear value of what lies behind, as far as the blending of displayed values knows

// Strands are where film is bunched: each a thin cylinder, which mirrors a lamp wherever the half vector stands across
// it (Kajiya and Kay 1989, "Rendering fur with three dimensional textures"). Priors but for the mirrored fraction.
const float PLAIN = 0.97;         // factor of the texture between strands
const float MIRRORED = 4.5;       // of the light that meets strands, over the veil: bunched, film lies threefold
const float MOST = 0.7;           // of the same
const float LOBE = 16.0;          // how fast the light falls off beside a strand's highlight
const float PEAK = 0.6;           // radiance in its middle over the irradiance, of a strand that mirrors all

vec3 displayed(vec3 linear) {
    return srgb(tone_map(linear));
}

struct Film {
    Surface surface;
    vec3 along;                   // direction of the strands
};
struct FilmLight {
    DirectLight direct;
    vec3 strands;                 // irradiance, where a strand sends it to the camera
};

void add_light(const int i, float seen, Film s, inout FilmLight sum) {
    vec3 before = sum.direct.matt;
    add_light(i, seen, s.surface, sum.direct);
    vec3 half_way = normalize(lights[i].position - s.surface.p) + s.surface.v;
    float slant = dot(s.along, half_way);
    sum.strands += (sum.direct.matt - before) * exp2(-LOBE * slant * slant / dot(half_way, half_way));
}

void main() {
    Film s = Film(surface_at(point, normal, tangent, texture_coordinate, material, pixel, vec4(0.0)), tangent);
    vec4 look = texelFetch(materials, ivec2(2, material), 0);
    // Light crosses more of the film the more it slants, and where the texture has strands.
    float haze = 1.0 - pow(1.0 - look.y, s.surface.factor / max(dot(s.surface.g, s.surface.v), 0.2));
    float strand = look.z == -3.0 ? max(s.surface.factor - PLAIN, 0.0) / (2.0 - PLAIN) : 0.0;
    s.along = normalize(tangent - s.surface.n * dot(tangent, s.surface.n));

    vec3 matt = vec3(0.0), gloss = vec3(0.0);
    // What the goods cast no shadow on, the film around them does not either.
    ivec2 at = ivec2(gl_FragCoord.xy) / 2;
    vec4 seen[2] = vec4[](texelFetch(visibility_a, at, 0), texelFetch(visibility_b, at, 0));
    reflect_surroundings(s.surface, around, 1.0, matt, gloss);
    FilmLight direct = FilmLight(DirectLight(vec3(0.0), vec3(0.0), vec3(0.0)), vec3(0.0));
    ADD_LIGHTS                     // as in shade.frag
    reflect_direct(direct.direct, s.surface, matt, gloss);
    gloss += strand * min(MIRRORED * look.y, MOST) * (PEAK * direct.strands + around.rgb / PI);
    matt = displayed((matt + s.surface.base * s.surface.emission) * exposure);
    // What the gloss adds to a surface of middle brightness, as a fraction of what is left to white.
    vec3 behind = displayed(vec3(MIDDLE));
    gloss = (displayed(MIDDLE + gloss * exposure) - behind) / (1.0 - behind);
    float shine = max(gloss.r, max(gloss.g, gloss.b));
    out_color = vec4(matt * haze * (1.0 - shine) + gloss, haze + shine - haze * shine);
}
