// Look-ups in a depth map (gl/depth_map.h).
//
// A texel holds 1 / z, z the distance along its face's axis; 0: nothing there.
uniform highp sampler2DArray map_texture;
uniform vec3 map_center;
uniform int map_face_count;
uniform vec3 map_axes[18]; // three for each face: x, y, z
uniform int map_size;      // texels of a side
uniform vec4 map_fit;      // shift, reach: the texture spans shift - reach to shift + reach

// With MAP_ONE_FACE the map has one: no loop, and no array that is looked into by a number.
#ifdef MAP_ONE_FACE
#define MAP_FACE(face) 0
#else
#define MAP_FACE(face) (face)
#endif

// Where on the map a point at d from the center lies: the face, or -1; its place in [0,1]^2.
int map_find(vec3 d, out vec2 at, out float z)
{
#ifdef MAP_ONE_FACE
    z = dot(d, map_axes[2]);
    vec2 slope = vec2(dot(d, map_axes[0]), dot(d, map_axes[1])) / z;
    at = 0.5 + 0.5 * (slope - map_fit.xy) / map_fit.zw;
    bool inside = map_face_count > 0 && z > 0.0 && all(greaterThanEqual(at, vec2(0.0))) &&
                  all(lessThanEqual(at, vec2(1.0)));
    return inside ? 0 : -1;
#else
    for (int face = 0; face < map_face_count; face++) {
        z = dot(d, map_axes[3 * face + 2]);
        if (z <= 0.0)
            continue;
        vec2 slope = vec2(dot(d, map_axes[3 * face]), dot(d, map_axes[3 * face + 1])) / z;
        at = 0.5 + 0.5 * (slope - map_fit.xy) / map_fit.zw;
        if (all(greaterThanEqual(at, vec2(0.0))) && all(lessThanEqual(at, vec2(1.0))))
            return face;
    }
    at = vec2(0.0);
    z = 1.0;
    return -1;
#endif
}

// The direction, with z = 1, in which a place of a face looks.
vec3 map_ray(int face, vec2 at)
{
    vec2 slope = map_fit.xy + map_fit.zw * (2.0 * at - 1.0);
    int first = 3 * MAP_FACE(face);
    return map_axes[first + 2] + slope.x * map_axes[first] + slope.y * map_axes[first + 1];
}

// 1 / z of the receiver's own plane where the map's texel (or any place of the face) looks: flat
// receivers need no bias for the slope. Kept within half and twice the receiver's own.
float map_plane(vec3 d, vec3 normal, int face, vec2 at, float z)
{
    float own = 1.0 / z, under = dot(normal, d);
    float plane = under != 0.0 ? dot(normal, map_ray(face, at)) / under : own;
    return plane > 0.0 ? clamp(plane, 0.5 * own, 2.0 * own) : own;
}

// A texel's width at distance 1, the wider side.
float map_texel()
{
    return 2.0 * max(map_fit.z, map_fit.w) / float(map_size);
}

// Whether the center sees the point. bias: texels.
bool map_seen(vec3 p, vec3 normal, float bias)
{
    vec2 at;
    float z;
    vec3 d = p - map_center;
    int face = map_find(d, at, z);
    if (face < 0)
        return true;
    int size = map_size;
    ivec2 texel = min(ivec2(at * float(size)), ivec2(size - 1));
    float stored = texelFetch(map_texture, ivec3(texel, face), 0).r;
    float own = map_plane(d, normal, face, (vec2(texel) + 0.5) / float(size), z);
    return stored <= own * (1.0 + bias * map_texel());
}
