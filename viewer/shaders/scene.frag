// What a pixel shows: the geometric normal and the object, and the normal to shade with, both turned
// towards the eye.
in vec3 relative;
in vec3 leaning;
flat in vec3 flat_normal;

uniform float object; // its index + 1

layout(location = 0) out vec4 surface;
layout(location = 1) out vec4 shading;

void main()
{
    vec3 n = dot(flat_normal, flat_normal) > 0.0 ? normalize(flat_normal) : -normalize(relative);
    if (dot(n, relative) > 0.0)
        n = -n;
    vec3 s = dot(leaning, leaning) > 0.0 ? normalize(leaning) : n;
    float side = dot(s, n);
    s = side == 0.0 ? n : side < 0.0 ? -s : s;
    surface = vec4(n, object);
    shading = vec4(s, 0.0);
}
