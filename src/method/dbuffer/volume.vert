// Extrudes a piece of a volume (dbuffer/volumes.h): one instance each, six vertices, two triangles:
// v1, v2 and the points where the lines away from p1 and p2 reach the farthest receiver.
in vec3 v1, v2; // light space
in vec4 p;      // p1, p2: in the light's plane
in vec2 lines; // the edge's and the outline's index
in vec3 outline1, outline2;
in vec2 outline_p;
uniform mat4 clip_from_light;
uniform float far_z; // the farthest receiver's height; 0: none is the farthest

#include "method/dbuffer/piece.glsl"

vec4 extrude(vec3 v, vec2 from)
{
    vec3 away = v - vec3(from, 0.0);
    return far_z > 0.0 ? vec4(v + max(far_z / v.z - 1.0, 0.0) * away, 1.0) : vec4(away, 0.0);
}

void main()
{
    // Corners 0, 1, 2 and 0, 2, 3.
    int k = gl_VertexID < 3 ? gl_VertexID : gl_VertexID == 3 ? 0 : gl_VertexID - 2;
    vec4 at = k == 0   ? vec4(v1, 1.0)
              : k == 1 ? vec4(v2, 1.0)
              : k == 2 ? extrude(v2, p.zw)
                       : extrude(v1, p.xy);
    pass_piece(v1, v2, p.xy, lines, outline1, outline2, outline_p);
    gl_Position = clip_from_light * at;
}
