// What the fragments of a piece have in common.
flat out vec3 line_a, line_b, outline_a, outline_b;
flat out vec2 tangent, lines_of, outline_tangent;
flat out vec4 plane, outline_plane; // through the line and its extrusion point: n, n.a
flat out float angle;               // of the extrusion point
flat out float outline_angle;       // 100: there is no such plane

vec4 plane_through(vec3 a, vec3 b, vec2 p)
{
    vec3 n = cross(a - vec3(p, 0.0), b - vec3(p, 0.0));
    return vec4(n, dot(n, a));
}

void pass_piece(vec3 a, vec3 b, vec2 p, vec2 lines, vec3 outline1, vec3 outline2, vec2 outline_p)
{
    line_a = a;
    line_b = b;
    tangent = p;
    lines_of = lines;
    plane = plane_through(a, b, p);
    angle = p == vec2(0.0) ? 0.0 : atan(p.y, p.x);
    outline_a = outline1;
    outline_b = outline2;
    outline_tangent = outline_p;
    outline_plane = plane_through(outline1, outline2, outline_p);
    outline_angle = outline_p == vec2(0.0) ? 100.0 : atan(outline_p.y, outline_p.x);
}
