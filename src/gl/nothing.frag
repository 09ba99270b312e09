// For programs that write depth or stencil only, where a fragment shader is demanded.
void main()
{
}
