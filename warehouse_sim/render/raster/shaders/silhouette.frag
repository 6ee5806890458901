flat in ivec4 rectangle;

layout(location = 0) out float out_covered;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (any(lessThan(at, rectangle.xy)) || any(greaterThanEqual(at, rectangle.zw))) discard;
    out_covered = 1.0;
}
