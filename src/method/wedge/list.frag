// The numbers of the groups that matter to a coarse tile, one after another. x and y: the place in
// the list, folded in rows of its tile.
#include "method/wedge/common.glsl"

uniform highp usampler2D hits, prefix;
uniform int word_count, list_width, list_rows;

layout(location = 0) out uint out_entry;

// The k-th group of the tile: the word by halving, then the bit in it.
int nth(int k, int tile)
{
    int low = 0, high = word_count; // prefix(low) <= k < prefix(high)
    while (high - low > 1) {
        int middle = (low + high) / 2;
        bool up = int(texelFetch(prefix, ivec2(middle, tile), 0).x) <= k;
        low = up ? middle : low;
        high = up ? high : middle;
    }
    uint word = texelFetch(hits, ivec2(low, tile), 0).x;
    int left = k - int(texelFetch(prefix, ivec2(low, tile), 0).x), at = 0;
    for (int width = 16; width > 0; width /= 2) {
        int below = bit_count((word >> uint(at)) & ((1u << uint(width)) - 1u));
        bool up = left >= below;
        left -= up ? below : 0;
        at += up ? width : 0;
    }
    return low * 32 + at;
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int tile = at.y / list_rows;
    int k = at.x + (at.y - tile * list_rows) * list_width;
    int count = int(texelFetch(prefix, ivec2(word_count, tile), 0).x);
    out_entry = 0u;
    for (int once = 0; once < 1 && k < count; once++)
        out_entry = uint(nth(k, tile));
}
