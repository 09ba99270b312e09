// Which groups of items may matter to a coarse tile: x: 32 groups, y: the tile.
#include "method/wedge/common.glsl"

uniform sampler2D tile_low, tile_high, group_low, group_high, group_least,
    group_most;
uniform highp usampler2D group_info, part_mask;
uniform int tile_columns, group_count;

layout(location = 0) out uint out_bits;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 tile = ivec2(at.y % tile_columns, at.y / tile_columns);
    vec3 p_low = texelFetch(tile_low, tile, 0).xyz, p_high = texelFetch(tile_high, tile, 0).xyz;
    int first = at.x * 32;
    int count = p_low.z > p_high.z ? 0 : min(group_count - first, 32);
    uint bits = 0u;
    for (int i = 0; i < count; i++) {
        ivec2 where = fold(first + i);
        uvec4 info = texelFetch(group_info, where, 0);
        int part = int(info.x);
        uint near = texelFetch(part_mask, ivec2(part >> 5, at.y), 0).x >> uint(part & 31);
        vec4 low = texelFetch(group_low, where, 0), high = texelFetch(group_high, where, 0);
        bool hit = ((near & 1u) != 0u || info.w == GROUP_MIXED) && low.x <= high.x &&
                   !misses(low.xyz, high.xyz, p_low, p_high, true) &&
                   !faces_alike(low, high, texelFetch(group_least, where, 0),
                                texelFetch(group_most, where, 0), p_low, p_high, info.w);
        // Faces: only those that a receiver's level may cut.
        hit = hit && (info.w != GROUP_FACES || high.z > p_low.z * (1.0 - 2.0 * NEAR));
        bits |= hit ? 1u << uint(i) : 0u;
    }
    out_bits = bits;
}
