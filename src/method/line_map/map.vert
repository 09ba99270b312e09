// One triangle of the scene, instanced: the rectangle of rows and columns that it may cover in the
// map of the sample at `place`. What is exact is left to map.frag.
#include "method/line_map/frame.glsl"

in vec3 corner_a; // (a, y, z) in the set's frame
in vec3 corner_b;
in vec3 corner_c;
in vec2 rows; // first, one past the last

uniform vec3 place;
uniform float near_r;

flat out vec3 side_a; // planes through the sample and an edge
flat out vec3 side_b;
flat out vec3 side_c;
flat out vec3 depth_plane; // q = dot(depth_plane, direction)
flat out vec2 depth_range;

bool before(vec3 p, vec3 q)
{
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
}

// Computed alike for both triangles at an edge, so that surfaces have no cracks.
vec3 side(vec3 p, vec3 q)
{
    return before(p, q) ? cross(p, q) : -cross(q, p);
}

float nearest_to_line(vec2 p, vec2 q)
{
    vec2 along = q - p;
    float square = dot(along, along);
    float t = square > 0.0 ? clamp(-dot(p, along) / square, 0.0, 1.0) : 0.0;
    return length(p + t * along);
}

float turn(vec2 p, vec2 q)
{
    return p.x * q.y - p.y * q.x;
}

void main()
{
    vec3 a = corner_a - vec3(place.x, 0.0, 0.0);
    vec3 b = corner_b - vec3(place.x, 0.0, 0.0);
    vec3 c = corner_c - vec3(place.x, 0.0, 0.0);
    side_a = side(a, b);
    side_b = side(b, c);
    side_c = side(c, a);
    vec3 normal = cross(b - a, c - a);
    depth_plane = normal / dot(normal, a);

    float near = min(nearest_to_line(a.yz, b.yz),
                     min(nearest_to_line(b.yz, c.yz), nearest_to_line(c.yz, a.yz)));
    float t0 = turn(a.yz, b.yz), t1 = turn(b.yz, c.yz), t2 = turn(c.yz, a.yz);
    if ((t0 > 0.0 && t1 > 0.0 && t2 > 0.0) || (t0 < 0.0 && t1 < 0.0 && t2 < 0.0))
        near = 0.0;
    near = max(near, near_r);
    float far = max(max(length(a.yz), max(length(b.yz), length(c.yz))), near);
    depth_range = vec2(1.0 / far, 1.0 / near);

    float a_low = min(a.x, min(b.x, c.x)), a_high = max(a.x, max(b.x, c.x));
    float u_low = a_low < 0.0 ? a_low / near : a_low / far;
    float u_high = a_high > 0.0 ? a_high / near : a_high / far;
    vec2 columns = vec2((spread(u_low) - place.y) * place.z - 1.0,
                        (spread(u_high) - place.y) * place.z + 1.0);
    columns = clamp(columns, vec2(0.0), vec2(map_size.x));
    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1);
    vec2 at = vec2(mix(floor(columns.x), ceil(columns.y), corner.x),
                   mix(rows.x, rows.y, corner.y));
    gl_Position = vec4(at / map_size * 2.0 - 1.0, 0.0, 1.0);
}
