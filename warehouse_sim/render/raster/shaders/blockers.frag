// The nearest blocker in each block of BLOCK_TEXELS x BLOCK_TEXELS texels of the shadow maps.
uniform sampler2D shadow_atlas;

layout(location = 0) out float out_nearest;

void main() {
    vec2 first = floor(gl_FragCoord.xy) * float(BLOCK_TEXELS) + 1.0;
    vec4 nearest = vec4(0.0);
    for (int row = 0; row < BLOCK_TEXELS; row += 2)
        for (int column = 0; column < BLOCK_TEXELS; column += 2)
            nearest = max(nearest, textureGather(shadow_atlas, (first + vec2(column, row)) / ATLAS_PX));
    out_nearest = max(max(nearest.x, nearest.y), max(nearest.z, nearest.w));
}
