// The last pass of every method on OpenGL: receivers that cannot see the light, whatever stands
// between, get 0: those on its dark side, and those whose tangent plane has all of it below.
#include "gl/receiver.glsl"

uniform sampler2D visibility;
uniform vec4 light_corners[64]; // w = 1: a place, 0: a direction
uniform int light_corner_count; // 0: unknown, no limit
uniform vec3 light_half_u, light_half_v; // half axes of round lights around their corner
uniform int light_one_sided;
uniform vec3 light_origin, light_normal;

out float resolved;

bool may_see(Receiver r)
{
    if (light_one_sided != 0 && dot(r.position - light_origin, light_normal) <= 0.0)
        return false;
    float height = light_corner_count == 0 ? 1.0 : -1e30;
    for (int i = 0; i < light_corner_count; i++)
        height = max(height, dot(r.normal, light_corners[i].xyz - light_corners[i].w * r.position));
    height += length(vec2(dot(r.normal, light_half_u), dot(r.normal, light_half_v)));
    return height > 0.0;
}

void main()
{
    Receiver r = receiver_here();
    float v = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).r;
    resolved = !r.valid ? 1.0 : may_see(r) ? clamp(v, 0.0, 1.0) : 0.0;
}
