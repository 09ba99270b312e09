// Corners of a shadow volume: where they are, or at infinity away from the light.
in vec3 position; // world
in float code;    // sides: weight, + 8 at infinity
uniform mat4 clip_from_world;
uniform vec4 light; // w = 0: a direction towards it
uniform float cap;  // 1: near caps, -1: far caps (which run the other way), 0: sides

flat out float weight;
invariant gl_Position;

void main()
{
    bool far = cap < 0.0 || (cap == 0.0 && code > 7.0);
    weight = cap != 0.0 ? cap : code - (far ? 8.0 : 0.0);
    vec4 world = far ? vec4(position * light.w - light.xyz, 0.0) : vec4(position, 1.0);
    gl_Position = clip_from_world * world;
}
