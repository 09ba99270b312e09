// A texel of a visibility channel behind a skin: the share of the segment that the surface there
// sees. The least stays by blending (overlap=least), or the skin nearest to the sample by the depth
// test (NEAREST). LINEAR: the paper's Gouraud shading instead of its equation 1.
#include "method/line_map/frame.glsl"

uniform sampler2DArray depths;
uniform int into_layer;
uniform int passive_layer; // depths of what casts no shadow; -1: none
uniform vec3 into;
uniform float far_q; // of the scene's farthest corner

flat in vec4 skin;
flat in vec2 skin_end;
out float share;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    float u = column_u(into, at.x);
    float q = texelFetch(depths, ivec3(at, into_layer), 0).x;
    if (passive_layer >= 0)
        q = max(q, texelFetch(depths, ivec3(at, passive_layer), 0).x);
    float line = (u - skin.x) * skin.w;
    if (!(q < line + skin_end.x) || !(q < skin.z))
        discard;
#ifdef LINEAR
    share = (u - skin.y) * skin_end.y;
#else
    share = (skin.y - u) / (skin.z - q) * skin.w;
#endif
    share = clamp(share, 0.0, 1.0);
#ifdef NEAREST
    gl_FragDepth = clamp(line / (line + far_q), 0.0, 1.0); // rises with line
#endif
}
