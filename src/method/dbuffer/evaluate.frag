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

// The receiver of the pixel: its place in light space, how much farther than an occluder it is hidden
// for sure, and how deep below an occluder's plane it counts as behind it.
struct Pixel {
    vec3 x;
    float slack, gap;
    bool backfacing;
};

// Within the slack an occluder may be the receiver itself or its neighbour across an edge: of a
// concave one, the pixel is not behind the neighbour's plane; of a convex one, the neighbour is not
// before the pixel's.
bool is_hidden(ivec3 texel, float d, Pixel pixel)
{
    vec2 occluder = texelFetch(occluder_texture, texel, 0).rg;
    if (pixel.backfacing || occluder.r == 0.0)
        return pixel.backfacing;
    vec3 off = pixel.x - occluder.r * map_ray(texel.z, vec2(texel.xy));
    return d > occluder.r + pixel.slack ||
           (d > occluder.r && dot(unpack_normal(occluder.g), off) < -pixel.gap);
}

// Where a texel's ray meets the plane of a receiver at d: under = n . x.
float own_distance(vec3 n, vec2 tap, int face, float under, float d)
{
    float along = dot(n, map_ray(face, tap));
    return along * under > 0.0 ? clamp(under / along, 0.7 * d, 1.4 * d) : d;
}

float visibility_at(ivec3 texel, vec3 x, float d, Pixel pixel)
{
    if (is_hidden(texel, d, pixel)) {
        // The centre is hidden: what is seen past the occluder's edges.
        Cut first = cut_at(texelFetch(umbra_texture, texel, 0), x, d, -1.0);
#ifdef LAYERS2
        float behind = texelFetch(behind_texture, texel, 0).r;
        if (behind > 0.0 && d <= behind + pixel.slack)
            return first.area;
        Cut second = cut_at(texelFetch(umbra2_texture, texel, 0), x, d, -1.0);
        // Two occluders: what both let through. One: all that it lets through.
        return behind > 0.0 ? cuts_overlap(first, second) : cuts_open(first, second);
#else
        return first.area;
#endif
    }
    // The centre is seen: what the occluder's edges hide.
    Cut first = cut_at(texelFetch(penumbra_texture, texel, 0), x, d, 1.0);
#if V_FORM == 2
    // sqrt(t) is no area: 1 - V(1 - t).
    first.area = first.t > 0.0 ? first.area * (1.0 - cap(1.0 - first.t)) / cap(first.t) : 0.0;
#endif
    float hides = first.area;
#ifdef LAYERS2
    if (first.t > 0.0) {
        hides = cuts_union(first, cut_at(texelFetch(penumbra2_texture, texel, 0), x, d, 1.0));
        // Light past the far side of a narrow occluder.
        hides -= cuts_overlap(first, cut_at(texelFetch(umbra_texture, texel, 0), x, d, -1.0));
    }
#endif
    return 1.0 - min(hides, 1.0);
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
    float texel = 2.0 * max(map_fit.z, map_fit.w) / map_size;
    float facing = max(abs(under) / d, 0.02);
    Pixel pixel = Pixel(x, 2.0 * bias * texel * d / facing, 0.6 * texel * d, under >= 0.0);
#ifdef LINEAR
    const int taps = 4;
    vec2 low = floor(at - 0.5), part = at - 0.5 - low;
#else
    const int taps = 1;
    vec2 low = floor(at), part = vec2(0.0);
#endif
    // Most pixels are lit, or dark, as far as a few distances tell.
    bool lit = true, dark = true;
    for (int k = 0; k < taps; k++) {
        vec2 tap = clamp(low + vec2(k & 1, k >> 1), vec2(0.0), vec2(map_size - 1.0));
        ivec3 texel_k = ivec3(tap, face);
        float own = own_distance(n, tap, face, under, d);
        bool hidden = is_hidden(texel_k, own, pixel);
        float umbra = texelFetch(umbra_texture, texel_k, 0).x;
        float penumbra = texelFetch(penumbra_texture, texel_k, 0).x;
        lit = lit && !hidden && (penumbra == 0.0 || own <= penumbra);
        dark = dark && hidden && (umbra == 0.0 || own <= umbra);
    }
    float sum = lit ? 1.0 : 0.0;
    // A loop, which ends where all is known, rather than a branch: software rasterisers take both
    // sides of branches.
    int count = lit || dark ? 0 : taps;
    for (int k = 0; k < count; k++) {
        vec2 place = vec2(k & 1, k >> 1), weight = mix(1.0 - part, part, place);
        vec2 tap = clamp(low + place, vec2(0.0), vec2(map_size - 1.0));
        float own = own_distance(n, tap, face, under, d);
        sum += weight.x * weight.y * visibility_at(ivec3(tap, face), own * map_ray(face, tap), own, pixel);
    }
    visibility = clamp(sum, 0.0, 1.0);
}
