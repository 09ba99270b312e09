// The box of each group of 32 items, in light space, and between what the planes of its faces lie:
// with g the box's middle, a plane is n . (p - g) + e.
#include "method/wedge/common.glsl"

uniform sampler2D item_a, item_b, item_c, item_d; // of setup.frag
uniform highp usampler2D group_info;
uniform int group_count;

layout(location = 0) out vec4 out_low; // w: of faces of a closed part, 1
layout(location = 1) out vec4 out_high;
layout(location = 2) out vec4 out_least; // n, e
layout(location = 3) out vec4 out_most;

void main()
{
    int group = unfold(ivec2(gl_FragCoord.xy));
    vec3 low = vec3(1e30), high = vec3(-1e30);
    int count = group < group_count ? 32 : 0;
    uint faces = texelFetch(group_info, fold(group), 0).z;
    bool closed = false;
    for (int i = 0; i < count; i++) {
        ivec2 at = fold(group * 32 + i);
        vec4 a = texelFetch(item_a, at, 0);
        vec3 b = texelFetch(item_b, at, 0).xyz, c = texelFetch(item_c, at, 0).xyz;
        bool none = a.w == 0.0;
        bool face = (faces >> uint(i) & 1u) != 0u;
        c = face ? c : b;
        low = none ? low : min(low, min(a.xyz, min(b, c)));
        high = none ? high : max(high, max(a.xyz, max(b, c)));
        closed = closed || (face && !none && a.w < 1.0);
    }
    vec3 middle = 0.5 * (low + high);
    vec4 least = vec4(1e30), most = vec4(-1e30);
    for (int i = 0; i < count; i++) {
        ivec2 at = fold(group * 32 + i);
        bool none = texelFetch(item_a, at, 0).w == 0.0;
        vec4 second = texelFetch(item_d, at, 0);
        vec4 first = (faces >> uint(i) & 1u) != 0u ? second : texelFetch(item_c, at, 0);
        first.w += dot(first.xyz, middle);
        second.w += dot(second.xyz, middle);
        least = none ? least : min(least, min(first, second));
        most = none ? most : max(most, max(first, second));
    }
    out_low = vec4(low, closed ? 1.0 : 0.0);
    out_high = vec4(high, 0.0);
    out_least = least;
    out_most = most;
}
