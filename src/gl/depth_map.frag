// 1 / distance along the face's axis, which is linear across a flat surface.
uniform float largest; // nearer to the light than this says: does not count

out float inverse;

void main()
{
    if (gl_FragCoord.w > largest)
        discard;
    inverse = gl_FragCoord.w;
}
