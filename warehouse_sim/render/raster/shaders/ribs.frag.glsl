// The mean normal of what a pixel sees of a ribbed sheet: ribs along z, heights along y, in the part's frame. A facet
// thinner than a pixel would light some pixels and not others. The view is a projection along the line of sight onto the
// plane halfway up the ribs, in which all that is seen of a period are up to four stretches, whose box-filtered fractions
// are known exactly. What the mean is shorter than 1 it is darker: black paint, as far as that goes.
uniform vec4 rib_edges;      // foot and top of a rib's one flank, top and foot of the other, along x (m)
uniform vec4 rib_shape;      // pitch; height of troughs and of tops (m); side of the sheet that is ribbed, 0 = both

flat in vec3 facet, grain, eye;
flat in mat3 to_camera;
flat in uint row;
in vec3 place;

layout(location = 4) out vec4 out_paint;  // as in picture.frag.glsl

const float FINEST = 5e-4;   // metres: below, a pixel sees one facet

float before(float x, vec2 stretch) {  // length of a stretch, repeated, from its start to x
    float periods = floor((x - stretch.x) / rib_shape.x);
    return periods * (stretch.y - stretch.x) + clamp(x - stretch.x - periods * rib_shape.x, 0.0, stretch.y - stretch.x);
}

float fraction(float x, float width, vec2 stretch) {
    if (stretch.y <= stretch.x) return 0.0;
    return (before(x + 0.5 * width, stretch) - before(x - 0.5 * width, stretch)) / width;
}

vec3 mean_normal() {
    vec3 to_eye = eye - place;
    float side = to_eye.y < 0.0 ? -1.0 : 1.0, half_height = 0.5 * (rib_shape.z - rib_shape.y);
    float slant = to_eye.x / max(abs(to_eye.y), 1e-3 * length(to_eye));
    float x = place.x - (side * place.y - 0.5 * (rib_shape.y + rib_shape.z)) * slant, pitch = rib_shape.x;
    float width = max(length(vec2(dFdx(x), dFdy(x))), FINEST);
    vec4 seen = rib_edges + vec4(1.0, -1.0, -1.0, 1.0) * half_height * slant;
    // What slants away is hidden, and hides with its edge what lies behind.
    float top = fraction(x, width, seen.yz);
    float rise = fraction(x, width, vec2(max(seen.x, seen.z - pitch), seen.y));
    float fall = fraction(x, width, vec2(seen.z, min(seen.w, seen.y + pitch)));
    float trough = fraction(x, width, vec2(max(seen.w, seen.z), min(seen.x, seen.y) + pitch));
    vec2 up = normalize(vec2(-2.0 * half_height, rib_edges.y - rib_edges.x));
    vec2 down = normalize(vec2(2.0 * half_height, rib_edges.w - rib_edges.z));
    vec2 n = vec2(0.0, top + trough) + rise * up + fall * down;
    return vec3(n.x, side * n.y, 0.0);
}

uvec2 filtered(uvec2 words) {
    vec3 n = mean_normal();
    float brightness = length(n);
    n /= brightness;
    bool ribbed = abs(facet.z) < 0.5 && (rib_shape.w == 0.0 || rib_shape.w * (eye.y - place.y) > 0.0);
    out_paint = vec4(0.0, 0.0, 0.0, ribbed ? sqrt(max(1.0 - brightness, 0.0)) : 0.0);
    return ribbed ? pack_surface(to_camera * n, to_camera * normalize(grain - n * dot(grain, n)), row) : words;
}

#define ADD_LOOK(words) words = filtered(words);

// Edges along the ribs are filtered already; those of the sheet itself lie across.
void keep_ends(vec4 across, vec4 down, inout vec4 distance) {
    vec2 along = vec2(dFdx(place.z), dFdy(place.z));
    vec4 over = abs(across * along.y - down * along.x), with = abs(across * along.x + down * along.y);
    distance = mix(distance, vec4(2.0), greaterThan(over, with));
}

#define DROP_EDGES(across, down, distance) keep_ends(across, down, distance);
