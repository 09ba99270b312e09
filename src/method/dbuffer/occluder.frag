// |c x_o|, a true distance, and the plane that it belongs to; with SECOND, the distance of the next
// entry into an occluder behind the first.
#include "method/dbuffer/light.glsl"

in vec3 relative;
uniform float per_far; // 1 / (a distance that nothing exceeds)
uniform vec3 axis_u, axis_v, axis_n; // world: the light's frame
uniform float gap;     // what is nearer to the light does not count
#ifdef SECOND
uniform highp sampler2DArray first_texture;
uniform int face, closed;
#endif

out vec2 distance_out; // and the plane's normal, in light space, towards c

void main()
{
    vec3 n = cross(dFdx(relative), dFdy(relative));
    float d = length(relative);
    if (d < gap)
        discard;
#ifdef SECOND
    float first = texelFetch(first_texture, ivec3(gl_FragCoord.xy, face), 0).r;
    // Seen along +Z in a right-handed frame, the outside of a face runs clockwise.
    if (first == 0.0 || d <= first * 1.0005 || (closed != 0 && gl_FrontFacing))
        discard;
#endif
    n = vec3(dot(n, axis_u), dot(n, axis_v), dot(n, axis_n)) * (dot(n, relative) > 0.0 ? -1.0 : 1.0);
    float size = length(n);
    distance_out = vec2(d, pack_normal(size > 0.0 ? n / size : vec3(0.0, 0.0, -1.0)));
    gl_FragDepth = d * per_far;
}
