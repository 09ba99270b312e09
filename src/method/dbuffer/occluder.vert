// |c x_o|: the occluders, seen from the light's centre.
in vec3 position; // world
uniform vec3 center;
uniform mat4 clip_from_relative; // depth 0: clipped at the centre itself, not at a near plane

out vec3 relative;

void main()
{
    relative = position - center;
    gl_Position = clip_from_relative * vec4(relative, 1.0);
}
