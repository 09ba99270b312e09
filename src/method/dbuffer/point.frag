// A light without extent: one look-up, as hard-map does it.
#include "gl/receiver.glsl"
#include "gl/depth_map.glsl"

uniform float bias; // texels

out float visibility;

void main()
{
    Receiver receiver = receiver_here();
    bool above = dot(receiver.normal, map_center - receiver.position) > 0.0;
    bool seen = receiver.valid && above && map_seen(receiver.lifted, receiver.normal, bias);
    visibility = seen ? 1.0 : 0.0;
}
