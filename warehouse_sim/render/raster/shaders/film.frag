uniform float pixel;              // width of a pixel at z = 1 m
uniform sampler2D visibility_a, visibility_b;  // of the solid surface behind, see soft.frag

flat in int material;
flat in vec3 normal;
flat in vec3 tangent;
in vec3 point;
in vec2 texture_coordinate;
in vec3 around;                   // irradiance from the surroundings

layout(location = 0) out vec4 out_color;  // multiplied by alpha, the fraction of what lies behind that is covered

const float MIDDLE = 0.18;        // the linear value of what lies behind, as far as the blending of displayed values knows

vec3 displayed(vec3 linear) {
    return srgb(tone_map(linear));
}

void main() {
    Surface s = surface_at(point, normal, tangent, texture_coordinate, material, pixel, vec4(0.0));
    float opacity = texelFetch(materials, ivec2(2, material), 0).y;
    // Light crosses more of the film the more it slants, and where the texture has creases.
    float haze = 1.0 - pow(1.0 - opacity, s.factor / max(dot(s.g, s.v), 0.2));

    vec3 matt = vec3(0.0), gloss = vec3(0.0);
    // What the goods cast no shadow on, the film around them does not either.
    ivec2 at = ivec2(gl_FragCoord.xy) / 2;
    vec4 seen[2] = vec4[](texelFetch(visibility_a, at, 0), texelFetch(visibility_b, at, 0));
    reflect_surroundings(s, vec4(around, dot(around, LUMINANCE)), 1.0, matt, gloss);
    DirectLight direct = DirectLight(vec3(0.0), vec3(0.0), vec3(0.0));
    ADD_LIGHTS                     // as in shade.frag
    reflect_direct(direct, s, matt, gloss);
    matt = displayed((matt + s.base * s.emission) * exposure);
    // What the gloss adds to a surface of middle brightness, as a fraction of what is left to white.
    vec3 behind = displayed(vec3(MIDDLE));
    gloss = (displayed(MIDDLE + gloss * exposure) - behind) / (1.0 - behind);
    float shine = max(gloss.r, max(gloss.g, gloss.b));
    out_color = vec4(matt * haze * (1.0 - shine) + gloss, haze + shine - haze * shine);
}
