in vec3 position; // world
uniform vec3 center;
uniform mat4 clip_from_relative;

void main()
{
    gl_Position = clip_from_relative * vec4(position - center, 1.0);
}
