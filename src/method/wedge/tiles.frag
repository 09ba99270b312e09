// The box of the receivers of each tile, in light space; low > high where a tile has none.
#include "gl/receiver.glsl"

uniform vec3 light_center, light_x_axis, light_y_axis, light_normal;
uniform ivec2 frame_size;
uniform int tile_size;

layout(location = 0) out vec4 out_low;
layout(location = 1) out vec4 out_high;

void main()
{
    ivec2 corner = ivec2(gl_FragCoord.xy) * tile_size;
    vec3 low = vec3(1e30), high = vec3(-1e30);
    for (int j = 0; j < tile_size; j++)
        for (int i = 0; i < tile_size; i++) {
            Receiver r = receiver_at(min(corner + ivec2(i, j), frame_size - 1));
            vec3 d = r.lifted - light_center;
            vec3 p = vec3(dot(light_x_axis, d), dot(light_y_axis, d), dot(light_normal, d));
            bool lit = r.valid && p.z > 0.0;
            low = lit ? min(low, p) : low;
            high = lit ? max(high, p) : high;
        }
    out_low = vec4(low, 0.0);
    out_high = vec4(high, 0.0);
}
