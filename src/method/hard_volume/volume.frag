// Behind the receiver: what is left counts up, what is entered counts down.
flat in float weight;

out float count;

void main()
{
    count = gl_FrontFacing ? -weight : weight;
}
