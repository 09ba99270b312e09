uniform sampler2D count;

out float visibility;

void main()
{
    visibility = texelFetch(count, ivec2(gl_FragCoord.xy), 0).r > 0.5 ? 0.0 : 1.0;
}
