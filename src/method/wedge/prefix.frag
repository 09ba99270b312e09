// How many groups before each 32 matter to a coarse tile; the column behind the last word: how many
// in all.
#include "method/wedge/common.glsl"

uniform highp usampler2D hits;

layout(location = 0) out uint out_count;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    int sum = 0;
    for (int i = 0; i < at.x; i++)
        sum += bit_count(texelFetch(hits, ivec2(i, at.y), 0).x);
    out_count = uint(sum);
}
