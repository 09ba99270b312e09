// A side's picture, scaled to the canvas.
uniform sampler2D picture;
in vec2 place;
layout(location = 0) out vec4 color;

void main()
{
    color = vec4(texture(picture, place).rgb, 1.0);
}
