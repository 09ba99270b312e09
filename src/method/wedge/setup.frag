// Items from the world into light space, once a frame: an item a fragment.
//
// Edges, clipped at the light's plane, and the lines in which that plane cuts faces: two ends, and
// two planes between which the receiver lies if it sees a silhouette, then of weight 2 k. Faces for the cut at a
// receiver's own level: three corners and the plane.
// CENTER 1: faces look at the light's middle, not at the receiver: their planes become constants,
// and of the edges only silhouettes are left.
#include "method/wedge/common.glsl"

uniform sampler2D item_a, item_b, item_c, item_first, item_second; // see struct wedge_item
uniform vec3 light_center, light_x_axis, light_y_axis, light_half_u, light_half_v, light_normal;
uniform float light_gap;

layout(location = 0) out vec4 out_a;
layout(location = 1) out vec4 out_b;
layout(location = 2) out vec4 out_c;
layout(location = 3) out vec4 out_d;

vec3 to_light(vec3 p)
{
    vec3 d = p - light_center;
    return vec3(dot(light_x_axis, d), dot(light_y_axis, d), dot(light_normal, d));
}

// A face of no area has no normal, and the same side everywhere.
vec4 plane_to_light(vec4 plane)
{
    float middle = dot(plane.xyz, light_center) + plane.w;
#if CENTER
    return vec4(0.0, 0.0, 0.0, middle > 0.0 ? -1.0 : 1.0);
#else
    return vec4(dot(plane.xyz, light_half_u), dot(plane.xyz, light_half_v),
                dot(plane.xyz, light_normal), middle);
#endif
}

vec3 cross_at(vec3 a, vec3 b, float z)
{
    float t = (z - a.z) / (b.z - a.z);
    return vec3(a.xy + (b.xy - a.xy) * t, z);
}

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 a4 = texelFetch(item_a, at, 0), b4 = texelFetch(item_b, at, 0),
         c4 = texelFetch(item_c, at, 0);
    vec3 a = to_light(a4.xyz), b = to_light(b4.xyz), c = to_light(c4.xyz);
    vec4 first = plane_to_light(texelFetch(item_first, at, 0));
    float sign = b4.w, k = c4.w;
    bool none = a4.w == 0.0;
    vec4 given = texelFetch(item_second, at, 0);
    bool alone = given == vec4(0.0);
    vec4 second = alone ? -first : plane_to_light(given);
    float z = light_gap;
    if (a4.w > 2.5) {
        out_a = vec4(a, k);
        out_b = vec4(b, sign);
        out_c = vec4(c, 0.0);
        out_d = first;
        return;
    }
    if (a4.w > 1.5) {
        // From where the face's outline leaves what lies under the light's plane to where it comes
        // back. Only the side that faces the receiver counts.
        bool ka = a.z > z, kb = b.z > z, kc = c.z > z;
        vec3 ab = cross_at(a, b, z), bc = cross_at(b, c, z), ac = cross_at(a, c, z);
        vec3 from = ka && !kb ? ab : kb && !kc ? bc : ac;
        vec3 to = !ka && kb ? ab : !kb && kc ? bc : ac;
        none = none || (ka == kb && kb == kc);
        a = sign > 0.0 ? from : to;
        b = sign > 0.0 ? to : from;
        second = k < 1.0 ? vec4(0.0, 0.0, 0.0, -1.0) : -first;
        k = k < 1.0 ? k : 0.5 * k;
    } else {
        none = none || (a.z <= z && b.z <= z);
        vec3 cut = cross_at(a, b, z);
        bool cut_a = a.z <= z, cut_b = b.z <= z;
        a = cut_a ? cut : a;
        b = cut_b ? cut : b;
        first *= sign;
        second *= sign;
        k = alone ? 0.5 * k : k;
    }
#if CENTER
    none = none || first.w * second.w > 0.0;
    k = first.w > 0.0 ? k : -k;
#endif
    out_a = none ? vec4(0.0, 0.0, 1e30, 0.0) : vec4(a, k);
    out_b = none ? vec4(0.0, 0.0, 1e30, 0.0) : vec4(b, 0.0);
    out_c = none ? vec4(0.0) : first;
    out_d = none ? vec4(0.0) : second;
}
