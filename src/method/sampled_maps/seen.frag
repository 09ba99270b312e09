// One sample's share of the visibility.
#include "gl/receiver.glsl"
#include "gl/depth_map.glsl"

uniform float bias, share;

out float visibility;

void main()
{
    Receiver r = receiver_here();
    bool above = dot(r.normal, map_center - r.position) > 0.0;
    visibility = r.valid && above && map_seen(r.lifted, r.normal, bias) ? share : 0.0;
}
