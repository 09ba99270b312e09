// |c x_uv| and |c x_pv| with |c x_s|: where the ray through the texel's middle meets the umbra or
// penumbra volume, and where it passes the height of the silhouette that the volume hangs on. True
// distances, found per fragment.
//
// All that a tangent plane through an edge says about a point x of the ray is b, how far the ray
// passes the edge at the edge's height: seen from x, the edge then stands b d / (d - s) off the
// light's centre, and that is r at
//
//   q = r s / (r - b),   so   b = r (q - s) / q.
//
// The nearest wins. A convex occluder's umbra is what lies behind all of its tangent planes, so a
// ray leaves it at the first of them; the penumbra is entered at the first as well. (The paper lets
// the farthest win, for occluders behind each other; SECOND sees to those.)
#include "method/dbuffer/light.glsl"

// piece.glsl
flat in vec3 line_a, line_b, outline_a, outline_b;
flat in vec2 tangent, lines_of, outline_tangent;
flat in vec4 plane, outline_plane;
flat in float angle, outline_angle;
#ifdef FACE
in vec3 at;
#endif
uniform float radius, per_far;
uniform int face;
uniform highp sampler2DArray occluder_texture; // |c x_o|
#ifdef LAYERS2
uniform highp sampler2DArray behind_texture; // the next occluder's
#endif
#ifdef SECOND
uniform highp sampler2DArray first_texture;
uniform highp sampler2D lines; // visibility.glsl

// Edges that an edge of the first layer counts itself.
bool counted(float first, float line)
{
    ivec2 at = ivec2(2 * (int(first) % 256), int(first) / 256);
    vec3 known = vec3(first, texelFetch(lines, at, 0).w, texelFetch(lines, at + ivec2(1, 0), 0).w);
    return first >= 0.0 && line >= 0.0 && any(equal(floor(known), vec3(line)));
}
#endif

out vec4 distances; // from c to the volume, to the silhouette; the tangent's angle; the edge's line

// Where the line from x to an extrusion point passes the line ab: a + k (b - a).
float pass_at(vec3 x, vec3 a, vec3 b, vec2 p)
{
    vec3 origin = vec3(p, 0.0), sight = x - origin;
    vec3 across = cross(b - a, sight);
    return -dot(cross(a - origin, sight), across) / dot(across, across);
}

#ifdef UMBRA
// Light past the edge does not come by where something stands right beside the outline that the
// edge belongs to, seen from c, before the ray leaves the umbra.
bool blocked(vec3 e, float q)
{
    vec3 along = outline_b - outline_a;
    if (along == vec3(0.0))
        return false;
    vec3 c = outline_a + clamp(dot(e - outline_a, along) / dot(along, along), 0.0, 1.0) * along;
    float texel = 2.0 * max(map_fit.z, map_fit.w) / map_size;
    c += 3.0 * texel * length(c) * normalize(cross(outline_a, outline_b));
    vec2 beside;
    int other = map_find(c, beside);
    if (other < 0)
        return false;
    float occluder = texelFetch(occluder_texture, ivec3(beside, other), 0).r;
    return occluder > 0.0 && occluder < q;
}
#endif

void main()
{
    ivec3 texel = ivec3(gl_FragCoord.xy, face);
    float occluder = texelFetch(occluder_texture, texel, 0).r;
    vec3 ray = map_ray(face, vec2(texel.xy)), e;
    float q, s, of = angle, line = lines_of.x;
#ifdef FAN
    // The cone over an arc of the rim.
    s = line_a.z / ray.z;
    vec2 off = line_a.xy - s * ray.xy;
    float b = length(off);
    if (!(s > 0.0) || b >= radius * 0.99999)
        discard;
    q = radius * s / (radius - b);
    of = atan(off.y, off.x);
    e = line_a;
#else
    // The plane through the edge and its extrusion point.
    q = plane.w / dot(plane.xyz, ray);
    float k = pass_at(q * ray, line_a, line_b, tangent);
    e = line_a + k * (line_b - line_a);
    s = e.z / ray.z;
#ifdef FACE
    if (tangent == vec2(0.0)) {
        // No edge to go by: the light above the face's own plane is seen from the face itself,
        // half of it from far away.
        float d = length(at);
        float trace = abs(dot(line_a, at)) / max(length(line_a.xy) * radius, 1e-20);
        float t = 0.5 * max(0.0, 1.0 - trace);
        s = 0.9 * d;
        q = s * d / (s + 2.0 * t * (d - s));
        of = atan(line_a.y, line_a.x);
        e = at;
    }
#endif
    if (!(q > 0.0) || q * per_far > 1e4)
        discard;
#ifdef OUTLINE
    // The same solid's outline before the edge takes as much light, or more. Of one solid's side
    // the umbra ends where it ends behind all that bounds it: here the farthest wins.
    float q2 = outline_plane.w / dot(outline_plane.xyz, ray);
    k = pass_at(q2 * ray, outline_a, outline_b, outline_tangent);
    if (outline_angle < 10.0 && k > -0.1 && k < 1.1) {
        if (!(q2 > 0.0) || q2 * per_far > 1e4)
            discard;
        if (q2 > q) {
            q = q2;
            s = mix(outline_a.z, outline_b.z, k) / ray.z;
            of = outline_angle;
            line = lines_of.y;
        }
    }
#endif
    if (!(s > 0.0))
        discard;
    s = min(s, 0.99999 * q);
#endif

#ifdef UMBRA
#ifndef FACE
    if (q <= occluder)
        discard;
#endif
    if (blocked(e, q))
        discard;
#ifdef LAYERS2
    // The second layer is that of the next occluder, where there is one; else the next plane.
    float behind = texelFetch(behind_texture, texel, 0).r;
    if (behind > 0.0) {
        bool next = s > 0.5 * (occluder + behind);
#ifdef SECOND
        if (!next)
            discard;
#else
        if (next)
            discard;
#endif
    }
#ifdef SECOND
    else {
        vec4 first = texelFetch(first_texture, texel, 0);
        if (q <= first.x * 1.00001 || counted(first.w, line))
            discard;
    }
#endif
#endif
#else
    // What enters the penumbra behind the first occluder is not seen by the centre.
    if (occluder > 0.0 && q >= occluder)
        discard;
#ifdef SECOND
    vec4 first = texelFetch(first_texture, texel, 0);
    if (q <= first.x * 1.00001 || counted(first.w, line))
        discard;
#endif
#endif
    distances = vec4(q, s, of, line);
    gl_FragDepth = min(q * per_far, 1.0);
}
