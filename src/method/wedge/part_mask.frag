// Which parts may hide some of the light from a tile: x: 32 parts, y: the tile.
#include "method/wedge/common.glsl"

uniform sampler2D tile_low, tile_high, part_low, part_high;
uniform int tile_columns, part_count;
uniform float light_gap;

layout(location = 0) out uint out_bits;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 tile = ivec2(at.y % tile_columns, at.y / tile_columns);
    vec3 p_low = texelFetch(tile_low, tile, 0).xyz, p_high = texelFetch(tile_high, tile, 0).xyz;
    int first = at.x * 32;
    int count = p_low.z > p_high.z ? 0 : min(part_count - first, 32);
    uint bits = 0u;
    for (int i = 0; i < count; i++) {
        vec3 low = texelFetch(part_low, fold(first + i), 0).xyz;
        vec3 high = texelFetch(part_high, fold(first + i), 0).xyz;
        bool hit = high.z > light_gap && !misses(low, high, p_low, p_high, false);
        bits |= hit ? 1u << uint(i) : 0u;
    }
    out_bits = bits;
}
