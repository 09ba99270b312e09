// Percentage-closer soft shadows (Fernando 2005): blocker search, penumbra, filter. See pcss.c.
#include "gl/receiver.glsl"
#include "gl/depth_map.glsl"

uniform sampler2D taps; // points of the light, from its middle; a row is one set
uniform int filter_count, blocker_count, rounds;
uniform float bias;
uniform float search;  // scales the search region
uniform float nearest; // distance of the nearest caster from the middle of the light
uniform float near_share; // no nearer than this share of the receiver's own

out float visibility;

// A set for each pixel of a block, so that neighbours differ.
int pattern_here()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint h = uint(pixel.x) * 0x9E3779B1u ^ uint(pixel.y) * 0x85EBCA77u;
    h = (h ^ (h >> 15)) * 0x2C1B3C6Du;
    return int((h >> 8) % uint(textureSize(taps, 0).y));
}

// The place where the ray from d to the light's point l is z from the middle, along the axis of the
// face in which d lies. scale widens the ray's distance from the middle's own.
vec3 crossing(vec3 d, vec3 axis, float own_z, float z, vec3 l, float scale)
{
    float s = (own_z - z) / max(own_z - dot(l, axis), 1e-6 * own_z);
    return d + clamp(s, 0.0, 1.0) * (scale * l - d);
}

// What the map holds towards q, and what the receiver's plane would hold there.
bool blocked(vec3 q, vec3 d, vec3 normal, out float stored)
{
    vec2 at;
    float z, own_z;
    int face = map_find(q, at, z);
    stored = 0.0;
    if (face < 0)
        return false;
    int size = map_size;
    ivec2 texel = min(ivec2(at * float(size)), ivec2(size - 1));
    stored = texelFetch(map_texture, ivec3(texel, face), 0).r;
    if (stored <= 0.0)
        return false;
    // On another face than the receiver's the plane may be out of its sight: then its own distance.
    own_z = dot(d, map_axes[3 * MAP_FACE(face) + 2]);
    vec3 ray = map_ray(face, (vec2(texel) + 0.5) / float(size));
    float under = dot(normal, d), plane = under != 0.0 ? dot(normal, ray) / under : 0.0;
    float own = own_z > 0.0 ? 1.0 / own_z : 1.0 / z;
    if (plane > 0.0)
        own = clamp(plane, 0.5 * own, 2.0 * own);
    return stored > own * (1.0 + bias * map_texel());
}

void main()
{
    visibility = 1.0;
    Receiver r = receiver_here();
    vec2 at;
    float own_z;
    vec3 d = r.lifted - map_center;
    int face = r.valid ? map_find(d, at, own_z) : -1;
    if (!r.valid || map_face_count == 0)
        return;
    vec3 axis = normalize(d);
    if (face >= 0)
        axis = map_axes[3 * MAP_FACE(face) + 2];
    own_z = dot(d, axis);
    int row = pattern_here();

    // Blockers: where rays to the light pass the depth of the nearest caster; in further rounds, of
    // the mean blocker so far. A round that finds none leaves the last one's.
    float stored, blocker_z = min(max(nearest, near_share * own_z), own_z);
    for (int round = 0; round < rounds; round++) {
        float sum = 0.0, count = 0.0;
        for (int i = 0; i < blocker_count; i++) {
            vec3 l = texelFetch(taps, ivec2(i, row), 0).xyz;
            if (blocked(crossing(d, axis, own_z, blocker_z, l, search), d, r.normal, stored)) {
                sum += 1.0 / stored;
                count += 1.0;
            }
        }
        if (count == 0.0 && round == 0)
            return;
        if (count == 0.0)
            break;
        blocker_z = min(sum / count, own_z);
    }

    // The filter, as wide as the light is seen past the mean blocker.
    float seen = 0.0;
    for (int i = 0; i < filter_count; i++) {
        vec3 l = texelFetch(taps, ivec2(i, row), 0).xyz;
        if (!blocked(crossing(d, axis, own_z, blocker_z, l, 1.0), d, r.normal, stored))
            seen += 1.0;
    }
    visibility = seen / float(filter_count);
}
