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

flat in vec3 line_a, line_b;
flat in vec2 tangent;
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
#endif

out vec4 distances; // from c to the volume, to the silhouette; the angle of the tangent; 1

void main()
{
    ivec3 texel = ivec3(gl_FragCoord.xy, face);
    float occluder = texelFetch(occluder_texture, texel, 0).r;
    vec3 ray = map_ray(face, vec2(texel.xy));
    float q, s, angle;
#ifdef UMBRA
    // Only what the centre does not see can be umbra.
    if (occluder == 0.0)
        discard;
#endif

#ifdef FACE
    float d = length(at);
    if (tangent == vec2(0.0)) {
        // No edge to go by: the light above the face's own plane is seen from the face itself,
        // half of it from far away.
        float trace = abs(dot(line_a, at)) / max(length(line_a.xy) * radius, 1e-20);
        float t = 0.5 * max(0.0, 1.0 - trace);
        s = 0.9 * d;
        q = s * d / (s + 2.0 * t * (d - s));
        angle = atan(line_a.y, line_a.x);
    } else
#endif
        if (line_a == line_b) {
        // A fan: the cone over an arc of the rim.
        s = line_a.z / ray.z;
        vec2 off = line_a.xy - s * ray.xy;
        float b = length(off);
        if (!(s > 0.0) || b >= radius * 0.99999)
            discard;
        q = radius * s / (radius - b);
        angle = atan(off.y, off.x);
    } else {
        // The plane through the edge and its extrusion point.
        vec3 origin = vec3(tangent, 0.0);
        vec3 normal = cross(line_a - origin, line_b - origin);
        q = dot(normal, line_a) / dot(normal, ray);
        if (!(q > 0.0) || q * per_far > 1e4)
            discard;
        // Where the line from the extrusion point passes the edge.
        vec3 along = line_b - line_a, sight = q * ray - origin;
        vec3 across = cross(along, sight);
        float k = -dot(cross(line_a - origin, sight), across) / dot(across, across);
        s = (line_a.z + k * along.z) / ray.z;
        angle = atan(tangent.y, tangent.x);
        if (!(s > 0.0))
            discard;
        s = min(s, 0.99999 * q);
    }

#ifdef UMBRA
#ifndef FACE
    if (q <= occluder)
        discard;
#endif
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
    else if (q <= texelFetch(first_texture, texel, 0).r * 1.00001)
        discard;
#endif
#endif
#else
    // What enters the penumbra behind the first occluder is not seen by the centre.
    if (occluder > 0.0 && q >= occluder)
        discard;
#ifdef SECOND
    if (q <= texelFetch(first_texture, texel, 0).r * 1.00001)
        discard;
#endif
#endif
    distances = vec4(q, s, angle, 1.0);
    gl_FragDepth = min(q * per_far, 1.0);
}
