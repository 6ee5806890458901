// Reading the picture here and not when shading gives the filter the true derivatives.
uniform sampler2DArray pictures;  // linear albedo multiplied by its cover

flat in float layer;
in vec2 picture_coordinate;

layout(location = 4) out vec4 out_paint;  // square roots, which keep dark tones apart in eight bits

const float MOST_TAPS = 4.0;

// The mean over a pixel's footprint: taps along its long side, each a mipmap's texel as wide as its short side. A driver's
// own anisotropic filter may walk over a whole texture at grazing angles.
vec4 filtered_picture() {
    vec2 across = dFdx(picture_coordinate), down = dFdy(picture_coordinate);
    vec2 texels = vec2(textureSize(pictures, 0).xy);
    float a = length(across * texels), b = length(down * texels);
    float most = clamp(max(a, b), 1e-3, 1e4), least = clamp(min(a, b), 1e-3, 1e4);
    float taps = min(ceil(most / least), MOST_TAPS), level = log2(max(most / taps, least));
    vec2 way = a > b ? across : down;
    vec4 sum = vec4(0.0);
    for (float k = 0.0; k < taps; k++)
        sum += textureLod(pictures, vec3(picture_coordinate + way * ((k + 0.5) / taps - 0.5), max(layer, 0.0)), level);
    return sum / taps;
}

void lay_paint() {
    vec4 paint = filtered_picture();
    out_paint = layer < 0.0 ? vec4(0.0) : sqrt(paint);
}

#define ADD_LOOK(words) lay_paint();
#define DROP_EDGES(across, down, distance)
