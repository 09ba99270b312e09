// |c x_o|, a true distance; with SECOND, that of the next entry into an occluder behind the first.
in vec3 relative;
uniform float per_far; // 1 / (a distance that nothing exceeds)
uniform float gap;     // what is nearer to the light does not count
#ifdef SECOND
uniform highp sampler2DArray first_texture;
uniform int face, closed;
#endif

out float distance_out;

void main()
{
    float d = length(relative);
    if (d < gap)
        discard;
#ifdef SECOND
    float first = texelFetch(first_texture, ivec3(gl_FragCoord.xy, face), 0).r;
    // Seen along +Z in a right-handed frame, the outside of a face runs clockwise.
    if (first == 0.0 || d <= first * 1.0005 || (closed != 0 && gl_FrontFacing))
        discard;
#endif
    distance_out = d;
    gl_FragDepth = d * per_far;
}
