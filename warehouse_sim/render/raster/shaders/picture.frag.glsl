// Reading the picture here and not when shading gives the filter the true derivatives.
uniform sampler2DArray pictures;  // linear albedo multiplied by its cover

flat in float layer;
in vec2 picture_coordinate;

layout(location = 3) out vec4 out_paint;  // square roots, which keep dark tones apart in eight bits

void lay_paint() {
    vec4 paint = texture(pictures, vec3(picture_coordinate, max(layer, 0.0)));
    out_paint = layer < 0.0 ? vec4(0.0) : sqrt(paint);
}

#define ADD_LOOK(words) lay_paint();
#define DROP_EDGES(across, down, distance)
