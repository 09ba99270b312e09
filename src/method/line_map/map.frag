// A texel of a map: where its ray from the sample meets the triangle; q = 1 / r, the greatest stays
// by blending.
#include "method/line_map/frame.glsl"

uniform vec3 place;
uniform sampler2D row_frame; // a texel per row: cosine, sine, row above, row below

flat in vec3 side_a;
flat in vec3 side_b;
flat in vec3 side_c;
flat in vec3 depth_plane;
flat in vec2 depth_range;
out float q;

void main()
{
    vec2 row = texelFetch(row_frame, ivec2(int(gl_FragCoord.y), 0), 0).xy;
    vec3 direction = vec3(unspread(place.y + gl_FragCoord.x / place.z), row);
    float a = dot(side_a, direction), b = dot(side_b, direction), c = dot(side_c, direction);
    bool inside = (a >= 0.0 && b >= 0.0 && c >= 0.0) || (a <= 0.0 && b <= 0.0 && c <= 0.0);
    q = dot(depth_plane, direction);
    if (!inside || !(q > 0.0) || q > depth_range.y * 1.001)
        discard;
    q = clamp(q, depth_range.x, depth_range.y);
}
