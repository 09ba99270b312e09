// Which items of a listed group matter to a tile: edges that may be silhouettes there and may be
// seen on the light or right of it, faces that a receiver's level may cut right of it. x: the place
// in the list of the tile's coarse tile; y: the tile.
#include "method/wedge/common.glsl"

uniform sampler2D item_a, item_b, item_c, item_d, group_low, group_high, group_least,
    group_most, tile_low, tile_high, part_low, part_high;
uniform highp usampler2D list, prefix, group_info;
uniform int tile_columns, coarse, coarse_columns, word_count, list_width, list_rows;

layout(location = 0) out uint out_bits;

// 1 or -1: the plane's side of all the tile; 0: not the same for all.
float side(vec4 plane, vec3 middle, vec3 extent)
{
    float at = dot(plane.xyz, middle) + plane.w;
    float reach = 1.001 * dot(abs(plane.xyz), extent) +
                  1e-5 * (dot(abs(plane.xyz), abs(middle)) + abs(plane.w));
    return at > reach ? 1.0 : at < -reach ? -1.0 : 0.0;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 tile = ivec2(at.y % tile_columns, at.y / tile_columns);
    ivec2 big = tile / coarse;
    int big_number = big.y * coarse_columns + big.x;
    int listed = int(texelFetch(prefix, ivec2(word_count, big_number), 0).x);
    int row = at.x / list_width;
    ivec2 place = ivec2(at.x - row * list_width, big_number * list_rows + row);
    int group = at.x < listed ? int(texelFetch(list, place, 0).x) : 0;
    uvec4 info = texelFetch(group_info, fold(group), 0);
    vec3 p_low = texelFetch(tile_low, tile, 0).xyz, p_high = texelFetch(tile_high, tile, 0).xyz;
    ivec2 where = fold(group);
    vec4 low = texelFetch(group_low, where, 0), high = texelFetch(group_high, where, 0);
    bool open = at.x < listed && p_low.z <= p_high.z &&
                !misses(low.xyz, high.xyz, p_low, p_high, true) &&
                !faces_alike(low, high, texelFetch(group_least, where, 0),
                             texelFetch(group_most, where, 0), p_low, p_high, info.w);
    vec3 middle = 0.5 * (p_low + p_high), extent = 0.5 * (p_high - p_low);
    vec2 p_z = vec2(p_low.z, p_high.z);
    float room = 1e-4 * p_high.z;
    // Seen at y from its cut at height z (1 - NEAR):  a.y = p.y (1 - NEAR) + NEAR y.
    vec3 p_least = p_low - 2.0 * NEAR * (1.0 + abs(p_low));
    vec3 p_most = p_high + 2.0 * NEAR * (1.0 + abs(p_high));
    // Of the group's parts those that are seen on the light itself.
    uint wanted = 0u, starts = info.y;
    int parts = open ? 1 + bit_count(starts) : 0;
    for (int k = 0, from = 0; k < parts; k++) {
        ivec2 part = fold(int(info.x) + k);
        int to = starts == 0u ? 32 : lowest_bit(starts);
        starts &= starts - 1u;
        bool seen = !misses(texelFetch(part_low, part, 0).xyz, texelFetch(part_high, part, 0).xyz,
                            p_low, p_high, false);
        uint below = to == 32 ? 0xffffffffu : (1u << uint(to)) - 1u;
        wanted |= seen ? below & ~((1u << uint(from)) - 1u) : 0u;
        from = to;
    }
    uint bits = 0u;
    int count = wanted != 0u ? 32 : 0;
    for (int i = 0; i < count; i++) {
        ivec2 item = fold(group * 32 + i);
        vec4 a = texelFetch(item_a, item, 0);
        vec3 b = texelFetch(item_b, item, 0).xyz;
        vec4 c = texelFetch(item_c, item, 0), d = texelFetch(item_d, item, 0);
        float s1 = side(c, middle, extent), s2 = side(d, middle, extent);

        vec3 least = min(min(a.xyz, b), c.xyz), most = max(max(a.xyz, b), c.xyz);
        bool cut = least.z <= p_most.z && most.z >= p_least.z && most.y >= p_least.y &&
                   least.y <= p_most.y && most.x >= p_least.x && !(a.w < 1.0 && s2 > 0.5);

        float top = min(least_beyond(a.y, a.zz, p_high.y, p_z),
                        least_beyond(b.y, b.zz, p_high.y, p_z));
        float bottom = min(least_beyond(-a.y, a.zz, -p_low.y, p_z),
                           least_beyond(-b.y, b.zz, -p_low.y, p_z));
        float left = min(least_beyond(-a.x, a.zz, -p_low.x, p_z),
                         least_beyond(-b.x, b.zz, -p_low.x, p_z));
        bool seen = !(s1 == s2 && s1 != 0.0) && min(a.z, b.z) < p_high.z &&
                    max(max(top, bottom), left) <= room;
        bits |= a.w != 0.0 && ((info.z >> uint(i) & 1u) != 0u ? cut : seen) ? 1u << uint(i) : 0u;
    }
    out_bits = bits & wanted;
}
