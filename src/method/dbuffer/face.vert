// A silhouette face that the light's centre lies behind, drawn as part of the umbra volume.
in vec3 position; // light space
in vec3 v1, v2;   // its outline edge; where there is none, p = 0 and v1 is its normal
in vec2 p;
uniform mat4 clip_from_light;

flat out vec3 line_a, line_b;
flat out vec2 tangent;
out vec3 at;

void main()
{
    line_a = v1;
    line_b = v2;
    tangent = p;
    at = position;
    gl_Position = clip_from_light * vec4(position, 1.0);
}
