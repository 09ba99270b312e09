// A silhouette face that the light's centre lies behind, drawn as part of the umbra volume.
in vec3 position; // light space
in vec3 v1, v2;   // its outline edge; where there is none, p = 0 and v1 is its normal
in vec2 p;
in float line;
uniform mat4 clip_from_light;

#include "method/dbuffer/piece.glsl"

out vec3 at;

void main()
{
    bool edge = p != vec2(0.0);
    pass_piece(v1, v2, p, vec2(line, -1.0), edge ? v1 : vec3(0.0), edge ? v2 : vec3(0.0), vec2(0.0));
    at = position;
    gl_Position = clip_from_light * vec4(position, 1.0);
}
