// The visibility of a pixel from the D-buffer.
//
// Everything is taken along the ray through a texel's middle, d = |c x| included: that is where the
// ray meets the receiver's own plane. So flat receivers need no bias, and the four texels around a
// pixel's own direction can be blended.
#include "gl/receiver.glsl"
#include "method/dbuffer/light.glsl"
#include "method/dbuffer/visibility.glsl"

uniform vec3 center, axis_u, axis_v, axis_n; // world: the light's frame
uniform float bias;                          // texels
uniform highp sampler2DArray occluder_texture, umbra_texture, penumbra_texture;
#ifdef LAYERS2
uniform highp sampler2DArray behind_texture, umbra2_texture, penumbra2_texture;
#endif

out float visibility;

// Eq. 3, re-derived: the share of the diameter that is seen past the edge (centre hidden), or
// hidden by it (centre seen: 1 - t).
float share(vec4 volume, float d)
{
    float q = volume.x, s = volume.y;
    return d > q && q > 0.0 ? 0.5 * s * (d - q) / (q * (d - s)) : 0.0;
}

float visibility_at(ivec3 texel, float d, float slack, bool backfacing)
{
    float occluder = texelFetch(occluder_texture, texel, 0).r;
    bool hidden = backfacing || (occluder > 0.0 && d > occluder + slack);
    if (hidden) {
        vec4 first = texelFetch(umbra_texture, texel, 0);
        float t1 = share(first, d);
#ifdef LAYERS2
        float behind = texelFetch(behind_texture, texel, 0).r;
        vec4 second = texelFetch(umbra2_texture, texel, 0);
        float t2 = share(second, d);
        if (behind > 0.0)
            // Two occluders: what both let through.
            return d > behind + slack ? caps_overlap(t1, t2, first.z - second.z) : cap(t1);
        if (t2 > 0.0)
            // One, with light on two sides of it.
            return cap(t1) + cap(t2) - caps_overlap(t1, t2, first.z - second.z);
#endif
        return cap(t1);
    }
    vec4 first = texelFetch(penumbra_texture, texel, 0);
    float t1 = share(first, d);
    if (t1 <= 0.0)
        return 1.0;
#ifdef LAYERS2
    vec4 second = texelFetch(penumbra2_texture, texel, 0);
    float t2 = share(second, d);
    if (t2 > 0.0) {
#if V_FORM == 2
        return max(0.0, cap(1.0 - t1) + cap(1.0 - t2) - 1.0);
#else
        return 1.0 - (cap(t1) + cap(t2) - caps_overlap(t1, t2, first.z - second.z));
#endif
    }
#endif
    return cap(1.0 - t1);
}

void main()
{
    Receiver receiver = receiver_here();
    vec3 world = receiver.lifted - center;
    vec3 x = vec3(dot(world, axis_u), dot(world, axis_v), dot(world, axis_n));
    vec3 n = vec3(dot(receiver.normal, axis_u), dot(receiver.normal, axis_v),
                  dot(receiver.normal, axis_n));
    vec2 at;
    int face = receiver.valid ? map_find(x, at) : -1;
    visibility = 1.0;
    if (face < 0)
        return;
    float d = length(x), under = dot(n, x);
    bool backfacing = under >= 0.0;
    float texel = 2.0 * max(map_fit.z, map_fit.w) / map_size;
    float slack = bias * texel * d;
#ifdef LINEAR
    vec2 corner = at - 0.5;
    vec2 low = floor(corner), part = corner - low;
    float sum = 0.0;
    for (int k = 0; k < 4; k++) {
        vec2 step_k = vec2(k & 1, k >> 1);
        vec2 weight = mix(1.0 - part, part, step_k);
        vec2 tap = clamp(low + step_k, vec2(0.0), vec2(map_size - 1.0));
#else
    float sum = 0.0;
    {
        vec2 weight = vec2(1.0);
        vec2 tap = min(floor(at), vec2(map_size - 1.0));
#endif
        // Where this ray meets the receiver's plane.
        float along = dot(n, map_ray(face, tap));
        float own = along * under > 0.0 ? clamp(under / along, 0.7 * d, 1.4 * d) : d;
        sum += weight.x * weight.y * visibility_at(ivec3(tap, face), own, slack, backfacing);
    }
    visibility = sum;
}
