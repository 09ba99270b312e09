// Extrudes a piece of a volume (dbuffer/volumes.h): one instance each, six vertices, two triangles:
// v1, v2 and the points at infinity in the directions away from p1 and p2.
in vec3 v1, v2; // light space
in vec4 p;      // p1, p2: in the light's plane
uniform mat4 clip_from_light;

flat out vec3 line_a, line_b;
flat out vec2 tangent;

void main()
{
    // Corners 0, 1, 2 and 0, 2, 3.
    int k = gl_VertexID < 3 ? gl_VertexID : gl_VertexID == 3 ? 0 : gl_VertexID - 2;
    vec4 corner = k == 0   ? vec4(v1, 1.0)
                  : k == 1 ? vec4(v2, 1.0)
                  : k == 2 ? vec4(v2 - vec3(p.zw, 0.0), 0.0)
                           : vec4(v1 - vec3(p.xy, 0.0), 0.0);
    line_a = v1;
    line_b = v2;
    tangent = p.xy;
    gl_Position = clip_from_light * corner;
}
