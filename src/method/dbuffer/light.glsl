// The D-buffer's own space and its faces (dbuffer_map.c).
//
// Light space: origin in the disk's centre c, z along its normal. A face looks along Z; its texel at
// slope (a, b) holds what the ray Z + a X + b Y meets; slopes run from shift - reach to
// shift + reach.
uniform vec3 map_axes[18]; // three for each face: X, Y, Z
uniform vec4 map_fit;      // shift, reach
uniform int map_face_count;
uniform float map_size; // texels

// Along the middle of a texel; of unit length.
vec3 map_ray(int face, vec2 texel)
{
    vec2 slope = map_fit.xy + map_fit.zw * (2.0 * (texel + 0.5) / map_size - 1.0);
    return normalize(map_axes[3 * face + 2] + slope.x * map_axes[3 * face] +
                     slope.y * map_axes[3 * face + 1]);
}

// The face that sees a direction, or -1, and where on it, in texels (middles at halves).
int map_find(vec3 d, out vec2 at)
{
    for (int face = 0; face < map_face_count; face++) {
        float z = dot(d, map_axes[3 * face + 2]);
        if (z <= 0.0)
            continue;
        vec2 slope = vec2(dot(d, map_axes[3 * face]), dot(d, map_axes[3 * face + 1])) / z;
        at = map_size * (0.5 + 0.5 * (slope - map_fit.xy) / map_fit.zw);
        if (all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(map_size))))
            return face;
    }
    at = vec2(0.0);
    return -1;
}

// A unit vector as an integer below 2^24, which a float holds: the octahedron around it, unfolded
// into a square of 4096^2 (1/2048 in each direction).
float pack_normal(vec3 n)
{
    n /= abs(n.x) + abs(n.y) + abs(n.z);
    vec2 at = n.xy;
    if (n.z < 0.0)
        at = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    vec2 whole = floor((0.5 + 0.5 * at) * 4095.0 + 0.5);
    return whole.x + 4096.0 * whole.y;
}

vec3 unpack_normal(float number)
{
    float high = floor(number / 4096.0);
    vec2 at = vec2(number - 4096.0 * high, high) * (2.0 / 4095.0) - 1.0;
    vec3 n = vec3(at, 1.0 - abs(at.x) - abs(at.y));
    if (n.z < 0.0)
        n.xy = (1.0 - abs(n.yx)) * vec2(n.x < 0.0 ? -1.0 : 1.0, n.y < 0.0 ? -1.0 : 1.0);
    return normalize(n);
}
