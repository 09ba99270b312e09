// An object's corners, into the picture and into the world relative to the eye.
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 face; // of the triangle, mesh space, any length
layout(location = 2) in vec3 smooth_normal; // zero where the mesh has none

uniform mat4 clip_from_relative;
uniform mat4 relative_from_mesh; // to the world, relative to the eye
uniform mat3 normal_from_mesh;

out vec3 relative;
out vec3 leaning;
flat out vec3 flat_normal;

void main()
{
    vec4 at = relative_from_mesh * vec4(corner, 1.0);
    vec3 lean = normal_from_mesh * smooth_normal;
    relative = at.xyz;
    flat_normal = normal_from_mesh * face;
    leaning = dot(lean, lean) > 0.0 ? normalize(lean) : vec3(0.0);
    gl_Position = clip_from_relative * vec4(at.xyz, 1.0);
}
