// One triangle that covers the target: (-1,-1), (3,-1), (-1,3). uv runs over [0,1]^2.
out vec2 uv;

void main()
{
    vec2 corner = vec2(float((gl_VertexID << 1) & 2), float(gl_VertexID & 2));
    uv = corner;
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
