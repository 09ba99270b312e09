// In shadow: within a volume, or turned away from the light's middle (where closed objects have
// their caps, so that counts mean nothing there).
#include "gl/receiver.glsl"

uniform sampler2D count;
uniform vec4 light; // w = 0: a direction towards it

out float visibility;

void main()
{
    Receiver r = receiver_here();
    bool above = dot(r.normal, light.xyz - light.w * r.position) > 0.0;
    visibility = above && texelFetch(count, ivec2(gl_FragCoord.xy), 0).r < 0.5 ? 1.0 : 0.0;
}
