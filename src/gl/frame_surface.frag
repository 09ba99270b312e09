// Positions and normals from an engine's depth texture.
//
// A normal that is not given comes from the two neighbours, one in x and one in y, whose depths
// continue the pixel's own best: across an edge the difference would be no surface.
uniform sampler2D engine_depth, engine_normal;
uniform int has_normals, normals_biased, zero_to_one;
uniform ivec2 corner; // of the viewport in the textures
uniform vec2 size;    // of the viewport
uniform float background; // the depth that means none
uniform mat4 relative_from_clip; // clip to world, relative to the eye
uniform vec3 eye;
uniform float lift, lift_per_square;

layout(location = 0) out vec4 position;
layout(location = 1) out vec4 normal;

float depth_at(ivec2 pixel)
{
    return texelFetch(engine_depth, corner + clamp(pixel, ivec2(0), ivec2(size) - 1), 0).r;
}

vec3 relative_at(ivec2 pixel, float depth)
{
    vec2 ndc = 2.0 * (vec2(pixel) + 0.5) / size - 1.0;
    float z = zero_to_one != 0 ? depth : 2.0 * depth - 1.0;
    vec4 p = relative_from_clip * vec4(ndc, z, 1.0);
    return p.xyz / p.w;
}

// The tangent along one axis: of the two sides, the one where three pixels lie on a line best.
vec3 tangent(ivec2 pixel, ivec2 along, float depth, vec3 here)
{
    float before = depth_at(pixel - along), after = depth_at(pixel + along);
    float bend_before = abs(depth_at(pixel - 2 * along) - 2.0 * before + depth);
    float bend_after = abs(depth_at(pixel + 2 * along) - 2.0 * after + depth);
    ivec2 low = pixel - along, high = pixel + along;
    bool first = low.x < 0 || low.y < 0, last = high.x >= int(size.x) || high.y >= int(size.y);
    bool use_before = last || (!first && bend_before < bend_after);
    return use_before ? here - relative_at(low, before) : relative_at(high, after) - here;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = depth_at(pixel);
    if (depth == background) {
        position = vec4(0.0);
        normal = vec4(0.0);
        return;
    }
    vec3 here = relative_at(pixel, depth), n;
    if (has_normals != 0) {
        n = texelFetch(engine_normal, corner + pixel, 0).xyz;
        n = normals_biased != 0 ? 2.0 * n - 1.0 : n;
    } else {
        n = cross(tangent(pixel, ivec2(1, 0), depth, here),
                  tangent(pixel, ivec2(0, 1), depth, here));
    }
    n = dot(n, n) > 0.0 ? normalize(n) : -normalize(here);
    if (dot(n, here) > 0.0)
        n = -n;
    position = vec4(eye + here, 1.0);
    normal = vec4(n, max(lift, lift_per_square * dot(here, here)));
}
