// A skin, warped into the map of another sample: from the occluder's texel to the receiver's beside
// it, one row high (the paper's figure 4). One instance per discontinuity.
#include "method/line_map/frame.glsl"

in vec2 texel; // column and row in the map that it was found in

uniform sampler2DArray depths;
uniform int source_layer;
uniform vec3 source;   // place of the map that the discontinuity was found in
uniform vec3 into;     // place of the map that it is drawn into
uniform float shift;   // from `into` to the sample whose light ends here
uniform bool own;      // source is into: as if the other sample saw the edge, too
uniform float slack_texels;

flat out vec4 skin;     // u, near_u, near_q, 1 / shift
flat out vec2 skin_end; // slack, 1 / (far_u - near_u)

void main()
{
    int c = int(texel.x), row = int(texel.y);
    float a = texelFetch(depths, ivec3(c, row, source_layer), 0).x;
    float b = texelFetch(depths, ivec3(c + 1, row, source_layer), 0).x;
    float u = column_u(source, c), next = column_u(source, c + 1), middle = 0.5 * (u + next);
    // Between the two texels; on the nearer surface's where columns are far apart.
    float edge_u = abs(middle) > 2.0 ? (a > b ? u : next) : middle;
    float near_q = max(a, b), far_q = min(a, b);
    skin = vec4(edge_u, 0.0, near_q, 1.0 / shift);
    skin_end.y = 1.0 / (shift * (far_q - near_q));
    if (own) {
        skin.x -= shift * near_q;
        far_q *= 0.5; // what the ray from the other sample meets is not known
    }
    skin.y = skin.x + shift * near_q;
    float far_u = skin.x + shift * far_q;
    skin_end.x = abs(skin.w) / into.z * slack_texels;
    float low = (spread(min(skin.y, far_u)) - into.y) * into.z - slack_texels;
    float high = (spread(max(skin.y, far_u)) - into.y) * into.z + slack_texels;
    vec2 columns = clamp(floor(vec2(low, high)), vec2(0.0), vec2(map_size.x));
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec2 at = vec2(mix(columns.x, columns.y, corner.x), texel.y + corner.y);
    gl_Position = vec4(at / map_size * 2.0 - 1.0, 0.0, 1.0);
}
