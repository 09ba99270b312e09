// A silhouette face that the light's centre lies behind, drawn as part of the umbra volume.
in vec3 position; // light space
in vec3 v1, v2;   // its outline edge; where there is none, p = 0 and v1 is its normal
in vec2 p;
uniform mat4 clip_from_light;

flat out vec3 line_a, line_b, outline_a, outline_b;
flat out vec2 tangent, corners, outline_tangent;
out vec3 at;

void main()
{
    line_a = v1;
    line_b = v2;
    outline_a = p == vec2(0.0) ? vec3(0.0) : v1;
    outline_b = p == vec2(0.0) ? vec3(0.0) : v2;
    tangent = p;
    corners = vec2(100.0);
    outline_tangent = vec2(0.0);
    at = position;
    gl_Position = clip_from_light * vec4(position, 1.0);
}
