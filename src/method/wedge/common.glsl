// What the passes of the wedges share: folded tables, bits, and when a box of occluders cannot
// hide the light from a box of receivers.
//
// Light space: the light is [-1,1]^2 in the plane z = 0, z is the height under it in metres. From a
// receiver p a point a is seen on the light at a.xy + (a.xy - p.xy) a.z / (p.z - a.z).

// Items and groups lie in tables of this width.
#define FOLD 1024
// Of a receiver's height: what is nearer to its own level is cut off (the local near plane).
#define NEAR (1.0 / 8192.0)

// Of a group (struct wedge_group): x: the part of its first item, y: items with which the next part
// begins, z: items that are faces, w: one of these.
#define GROUP_EDGES 0u
#define GROUP_FACES 1u
#define GROUP_MIXED 2u

ivec2 fold(int i)
{
    return ivec2(i & (FOLD - 1), i >> 10);
}

int unfold(ivec2 at)
{
    return at.y * FOLD + at.x;
}

// The lowest set bit's number; a float's exponent, as findLSB() is younger than our dialects.
int lowest_bit(uint bits)
{
    return int(floatBitsToUint(float(bits & (~bits + 1u))) >> 23) - 127;
}

int bit_count(uint v)
{
    v -= (v >> 1u) & 0x55555555u;
    v = (v & 0x33333333u) + ((v >> 2u) & 0x33333333u);
    return int((((v + (v >> 4u)) & 0x0f0f0f0fu) * 0x01010101u) >> 24u);
}

// The least of  p.z (s a - 1) + a.z (1 - s p)  over both boxes, for one axis and side s: positive
// where everything between a_low and a_high is seen beyond the light's border on that side. This is
// the plane through the receiver and the border: a half-wedge's outer plane.
float least_beyond(float a, vec2 a_z, float p, vec2 p_z)
{
    float u = a - 1.0, v = 1.0 - p;
    return min(p_z.x * u, p_z.y * u) + min(a_z.x * v, a_z.y * v);
}

// True if no point of the box low..high is seen from the box of receivers on the light, or, with
// strip, on what lies right of it (x > -1, |y| < 1).
bool misses(vec3 low, vec3 high, vec3 p_low, vec3 p_high, bool strip)
{
    vec2 a_z = vec2(max(low.z, 0.0), max(high.z, 0.0)), p_z = vec2(p_low.z, p_high.z);
    float room = 1e-4 * p_high.z;
    return low.z >= p_high.z * (1.0 - NEAR) ||
           least_beyond(low.y, a_z, p_high.y, p_z) > room ||
           least_beyond(-high.y, a_z, -p_low.y, p_z) > room ||
           least_beyond(-high.x, a_z, -p_low.x, p_z) > room ||
           (!strip && least_beyond(low.x, a_z, p_high.x, p_z) > room);
}

// True if every plane of a group (groups.frag) has all receivers on one side: none of its edges is a
// silhouette. Faces of a closed part: on their front, where they do not close an outline either.
bool faces_alike(vec4 low, vec4 high, vec4 least, vec4 most, vec3 p_low, vec3 p_high, uint kind)
{
    vec3 middle = 0.5 * (low.xyz + high.xyz);
    vec3 q_low = p_low - middle, q_high = p_high - middle;
    vec3 a = least.xyz * q_low, b = least.xyz * q_high, c = most.xyz * q_low,
         d = most.xyz * q_high;
    float s_low = dot(min(min(a, b), min(c, d)), vec3(1.0)) + least.w;
    float s_high = dot(max(max(a, b), max(c, d)), vec3(1.0)) + most.w;
    float room = 1e-4 * (abs(s_low) + abs(s_high));
    bool alike = kind == GROUP_FACES ? low.w > 0.5 && s_low > room : s_low > room || s_high < -room;
    return kind != GROUP_MIXED && alike;
}
