// The bounds of what a square of pixels shows, relative to the eye: one fragment for SIDE x SIDE of
// them. Where they show nothing w stays 0.
uniform sampler2D depth_map, surface_map;
uniform vec3 view_forward, view_right, view_up; // to the picture's middle and its borders
uniform float view_near;
uniform int view_reversed;
uniform int side; // SIDE

layout(location = 0) out vec4 low;
layout(location = 1) out vec4 high;

void main()
{
    ivec2 size = textureSize(depth_map, 0), first = side * ivec2(gl_FragCoord.xy);
    ivec2 end = min(first + side, size);
    low = vec4(3e38, 3e38, 3e38, 0.0);
    high = vec4(-3e38, -3e38, -3e38, 0.0);
    for (int y = first.y; y < end.y; y++)
        for (int x = first.x; x < end.x; x++) {
            ivec2 pixel = ivec2(x, y);
            if (texelFetch(surface_map, pixel, 0).w < 0.5)
                continue;
            float depth = texelFetch(depth_map, pixel, 0).r;
            float away = view_near / (view_reversed != 0 ? depth : 1.0 - depth);
            vec2 place = 2.0 * (vec2(pixel) + 0.5) / vec2(size) - 1.0;
            vec3 p = away * (view_forward + place.x * view_right + place.y * view_up);
            low = vec4(min(low.xyz, p), 1.0);
            high = vec4(max(high.xyz, p), 1.0);
        }
}
