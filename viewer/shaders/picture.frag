// A side's picture in sRGB: shaded, or the visibility of one light, or its error.
uniform sampler2D surface_map, light_map, visibility_map, truth_map, material_map, color_map;
uniform int show; // view_show
uniform float error_factor; // 0.5 / scale
uniform vec3 ambient, background;
uniform float emission_factor; // exposure x pi

layout(location = 0) out vec4 color;

vec3 encoded(vec3 x)
{
    x = clamp(x, 0.0, 1.0);
    return mix(1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, 12.92 * x,
               vec3(lessThanEqual(x, vec3(0.0031308))));
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float object = texelFetch(surface_map, pixel, 0).w;
    bool none = object < 0.5;
    if (show == 0) {
        vec3 value = background;
        if (!none) {
            int row = int(object + 0.5) - 1;
            vec3 albedo = texelFetch(material_map, ivec2(0, row), 0).rgb;
            vec3 emission = texelFetch(material_map, ivec2(1, row), 0).rgb;
            value = albedo * (ambient + texelFetch(light_map, pixel, 0).rgb) +
                    emission_factor * emission;
        }
        color = vec4(encoded(value), 1.0);
        return;
    }
    float v = texelFetch(visibility_map, pixel, 0).r;
    none = none || v < 0.0;
    if (show == 1) {
        color = vec4(none ? vec3(62.0, 66.0, 92.0) / 255.0 : encoded(vec3(v)), 1.0);
        return;
    }
    // The truth's rows run from the top; it is NaN, here below 0, where there is none.
    int height = textureSize(truth_map, 0).y;
    float truth = texelFetch(truth_map, ivec2(pixel.x, height - 1 - pixel.y), 0).r;
    int size = textureSize(color_map, 0).x - 1; // the last one stands for none
    float t = clamp(0.5 + (v - truth) * error_factor, 0.0, 1.0);
    int index = none || truth < 0.0 ? size : int(t * float(size - 1) + 0.5);
    color = vec4(texelFetch(color_map, ivec2(index, 0), 0).rgb, 1.0);
}
