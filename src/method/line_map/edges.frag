// Discontinuities, the paper's section 3.2, as skins.c finds them: 3x3 Laplacian of Gaussian of q,
// and a step between this texel and the next of its row that the surface's own slope does not
// explain. 1: the occluder is this texel, 2/255 above: the next; 0: none.
#include "method/line_map/frame.glsl"

uniform sampler2DArray depths;
uniform int layer;
uniform vec3 place;
uniform sampler2D row_frame;
uniform vec2 least_step; // a share of q; metres

out vec4 mark;

float depth_at(int c, int row)
{
    return texelFetch(depths, ivec3(c, row, layer), 0).x;
}

float least(float q)
{
    return q * (least_step.x + least_step.y * q / (1.0 + least_step.y * q));
}

float response(int c, int row, int above, int below, int columns)
{
    c = columns > 2 ? clamp(c, 1, columns - 2) : 0;
    if (columns <= 2)
        return depth_at(columns - 1, row) - depth_at(0, row);
    float corners = depth_at(c - 1, above) + depth_at(c + 1, above) + depth_at(c - 1, below) +
                    depth_at(c + 1, below);
    float sides = depth_at(c, above) + depth_at(c, below) + depth_at(c - 1, row) +
                  depth_at(c + 1, row);
    return (corners + 2.0 * sides - 12.0 * depth_at(c, row)) / 16.0;
}

void main()
{
    int c = int(gl_FragCoord.x), row = int(gl_FragCoord.y), columns = int(map_size.x);
    mark = vec4(0.0);
    if (c + 1 >= columns)
        return;
    float a = depth_at(c, row), b = depth_at(c + 1, row);
    float bound = least(max(a, b)), jump = abs(b - a);
    if (!(jump > bound))
        return;
    float u = column_u(place, c), next = column_u(place, c + 1), slope = -1.0;
    if (c > 0)
        slope = abs(a - depth_at(c - 1, row)) / (u - column_u(place, c - 1)) * (next - u);
    if (c + 2 < columns) {
        float after = abs(depth_at(c + 2, row) - b) / (column_u(place, c + 2) - next) * (next - u);
        slope = slope < 0.0 ? after : min(slope, after);
    }
    if (!(jump - max(slope, 0.0) > bound))
        return;
    vec4 beside = texelFetch(row_frame, ivec2(row, 0), 0);
    int above = int(beside.z), below = int(beside.w);
    float most = max(abs(response(c, row, above, below, columns)),
                     abs(response(c + 1, row, above, below, columns)));
    if (most > 0.25 * bound)
        mark = vec4(a > b ? 1.0 : 2.0 / 255.0, 0.0, 0.0, 0.0);
}
