// The boxes of coarse tiles: of COARSE x COARSE tiles each.
uniform sampler2D tile_low, tile_high;
uniform ivec2 tile_count;
uniform int coarse;

layout(location = 0) out vec4 out_low;
layout(location = 1) out vec4 out_high;

void main()
{
    ivec2 corner = ivec2(gl_FragCoord.xy) * coarse;
    out_low = vec4(1e30);
    out_high = vec4(-1e30);
    for (int j = 0; j < coarse; j++)
        for (int i = 0; i < coarse; i++) {
            ivec2 at = min(corner + ivec2(i, j), tile_count - 1);
            out_low = min(out_low, texelFetch(tile_low, at, 0));
            out_high = max(out_high, texelFetch(tile_high, at, 0));
        }
}
