// V(t), and V(t1, t2, alpha).
//
// A straight edge cuts a cap off the disk: t is the share of the diameter that it takes, the cap's
// height. V_FORM: 0 the paper's, 1 the disk's own, 2 for small occluders.
const float PI = 3.14159265;

float cap_exact(float t)
{
    float x = 1.0 - 2.0 * clamp(t, 0.0, 1.0);
    return (acos(x) - x * sqrt(max(0.0, 1.0 - x * x))) / PI;
}

float cap(float t)
{
    t = clamp(t, 0.0, 1.0);
#if V_FORM == 0
    return t * t * (3.0 - 2.0 * t);
#elif V_FORM == 1
    return cap_exact(t);
#else
    return sqrt(t);
#endif
}

// The share of the disk beyond both of two lines, at h1, h2 in [-1, 1] radii from its middle, whose
// normals stand alpha apart: the common arc from one chord's end to the other's, closed over the
// point where the chords cross (Green's theorem).
float beyond_both(float h1, float h2, float alpha)
{
    alpha = abs(alpha);
    alpha = alpha > PI ? 2.0 * PI - alpha : alpha;
    h1 = clamp(h1, -1.0, 1.0);
    h2 = clamp(h2, -1.0, 1.0);
    float least = min(cap_exact(0.5 - 0.5 * h1), cap_exact(0.5 - 0.5 * h2));
    float a1 = acos(h1), a2 = acos(h2);
    if (least <= 0.0 || alpha <= abs(a1 - a2))
        return least;
    // Both arcs together around the whole rim: what is left of the disk are two caps.
    if (alpha + a1 + a2 >= 2.0 * PI)
        return max(0.0, cap_exact(0.5 - 0.5 * h1) + cap_exact(0.5 - 0.5 * h2) - 1.0);
    if (alpha >= a1 + a2)
        return 0.0;
    float from = alpha - a2;
    float y = (h2 - h1 * cos(alpha)) / sin(alpha);
    float area = 0.5 * (a1 - from) + 0.5 * h1 * (y - sin(a1)) +
                 0.5 * (h1 * sin(from) - y * cos(from));
    return clamp(area / PI, 0.0, least);
}

// The lines that edges cut the disk along, seen from a receiver.
uniform highp sampler2D lines; // 256 a row; v1, the line before; v2, the line after (volumes.h)
uniform float radius;

const float ALONG = 0.5; // of edges on one side: the cosine between their lines
const float WIDER = 0.2; // radii
const vec3 NO_LINE = vec3(1.0, 0.0, -3.0);

// The occluder's side of an edge's line on the unit disk, n.p >= h, as (n, h).
vec3 line_at(float index, vec3 x, out vec2 next)
{
    ivec2 at = ivec2(2 * (int(index) % 256), int(index) / 256);
    vec4 a = texelFetch(lines, at, 0), b = texelFetch(lines, at + ivec2(1, 0), 0);
    next = vec2(a.w, b.w);
    // The occluder is where the plane through x, a, b is positive: it is on the left.
    vec3 n = cross(a.xyz - x, b.xyz - x);
    float size = length(n.xy);
    if (index < 0.0 || min(a.z, b.z) >= x.z || size <= 0.0)
        return NO_LINE;
    return vec3(n.xy / size, clamp(dot(n, x) / (size * radius), -2.0, 2.0));
}

// The share of the disk on the far side of three lines at once, by Green's theorem: pi a is half of
// the arcs that are left, less half of h times what is left of each chord. Every arc begins and
// ends where a chord does, so the arcs' sum, less than 2 pi, is that of their ends less that of
// their beginnings.
float beyond_all(vec3 l[3])
{
    float arcs = 0.0, chords = 0.0, most = max(l[0].z, max(l[1].z, l[2].z));
    if (most >= 1.0)
        return 0.0;
    if (most <= -1.0)
        return 1.0;
    for (int i = 0; i < 3; i++) {
        float h = l[i].z;
        if (h <= -1.0)
            continue;
        float whole = sqrt(1.0 - h * h), low = -whole, high = whole;
        vec2 along = vec2(-l[i].y, l[i].x);
        for (int j = 0; j < 3; j++) {
            if (j == i || l[j].z <= -1.0)
                continue;
            // Of two lines that are one, the first counts.
            float slope = dot(l[j].xy, along), over = dot(l[j].xy, l[i].xy) * h - l[j].z;
            if (abs(slope) < 1e-5)
                high = over < (j < i ? 1e-5 : -1e-5) ? low : high;
            else if (slope > 0.0)
                low = max(low, -over / slope);
            else
                high = min(high, -over / slope);
        }
        if (high <= low)
            continue;
        float angle = atan(l[i].y, l[i].x), spread = acos(h);
        chords += h * (high - low);
        arcs += (high == whole ? angle + spread : 0.0) - (low == -whole ? angle - spread : 0.0);
    }
    arcs -= 2.0 * PI * floor(arcs / (2.0 * PI));
    arcs = arcs > 2.0 * acos(most) + 1e-3 ? 0.0 : arcs;
    return clamp(0.5 * (arcs - chords) / PI, 0.0, cap_exact(0.5 - 0.5 * most));
}

// What an edge cuts off: the occluder's part of the disk (penumbra) or the open one (umbra), by the
// edge alone: a cap of height t <= 1/2 around an angle; and by the edges before and after it too.
struct Cut {
    float t, angle, area; // area: by V(t)
    vec3 of;              // lines: its own, those before and after
};

// A volume's texel (volume.frag), for a receiver x at d; side: 1 penumbra, -1 umbra.
Cut cut_at(vec4 volume, vec3 x, float d, float side)
{
    float q = volume.x, s = volume.y;
    Cut cut = Cut(0.0, volume.z, 0.0, vec3(q > 0.0 ? volume.w : -1.0, -1.0, -1.0));
    if (!(q > 0.0 && d > q))
        return cut;
    // Eq. 3, re-derived.
    cut.t = min(0.5, 0.5 * s * (d - q) / (q * (d - s)));
    cut.area = cap(cut.t);
    if (volume.w < 0.0)
        return cut;
    // The same from the edge itself, whose line turns as x moves away where it is not parallel to
    // the light.
    vec2 next, none;
    vec3 own = line_at(volume.w, x, next);
    cut.of = vec3(volume.w, floor(next));
    vec3 before = line_at(next.x, x, none), after = line_at(next.y, x, none);
    bvec2 reflex = greaterThan(fract(max(next, 0.0)), vec2(0.25));
    bvec2 turned = bvec2(before.x * own.y > before.y * own.x, own.x * after.y > own.y * after.x);
    if (turned.x != reflex.x)
        before = NO_LINE;
    if (turned.y != reflex.y)
        after = NO_LINE;
    // What says that the centre is seen where it is hidden, or the other way round, is no outline.
    if (side * before.z < 0.0 && reflex.x == (side > 0.0))
        before = NO_LINE;
    if (side * after.z < 0.0 && reflex.y == (side > 0.0))
        after = NO_LINE;
    // The nearest tangent plane opens the most: a neighbour that opens far more hides behind others.
    if (side < 0.0 && !reflex.x && before.z > own.z + WIDER)
        before = NO_LINE;
    if (side < 0.0 && !reflex.y && after.z > own.z + WIDER)
        after = NO_LINE;
    // At other corners the edge alone may say so, and the next one knows better;
    // without one, what the volume says stands.
    if (side * own.z < 0.0 && !(before.z > -2.5 && reflex.x != (side > 0.0)) &&
        !(after.z > -2.5 && reflex.y != (side > 0.0)))
        return cut;
    cut.t = clamp(0.5 - 0.5 * side * own.z, 0.0, 1.0);
    cut.angle = atan(side * own.y, side * own.x);
    cut.area = cap(cut.t);
    // Convex corners: the occluder is what lies behind all lines; reflex ones: the open part is.
    float whole = cap_exact(cut.t), exact = whole;
    bool first = !reflex.x && before.z > -1.0 || !reflex.y && after.z > -1.0;
    bool second = reflex.x && abs(before.z + 1.0) < 2.0 || reflex.y && abs(after.z + 1.0) < 2.0;
    for (int k = first ? 0 : 1; k < (second ? 2 : 1); k++) {
        float sign = k == 0 ? 1.0 : -1.0;
        vec3 l[3];
        l[0] = sign * own;
        l[1] = reflex.x == (k == 1) && before.z > -2.5 ? sign * before : NO_LINE;
        l[2] = reflex.y == (k == 1) && after.z > -2.5 ? sign * after : NO_LINE;
        float share = beyond_all(l);
        exact += (sign == side ? share : 1.0 - share) - whole;
    }
    if (whole > 0.0)
        cut.area = clamp(cut.area * exact / whole, 0.0, 1.0);
    return cut;
}

// What two cuts have in common: the caps that they are, as far as these are cut.
float cuts_overlap(Cut a, Cut b)
{
    float whole_a = cap_exact(a.t), whole_b = cap_exact(b.t);
    if (a.area <= 0.0 || b.area <= 0.0 || whole_a <= 0.0 || whole_b <= 0.0)
        return 0.0;
    float both = beyond_both(1.0 - 2.0 * a.t, 1.0 - 2.0 * b.t, a.angle - b.angle);
    return min(min(a.area, b.area), both * (a.area / whole_a) * (b.area / whole_b));
}

// What they take together; of edges side by side, each has counted the other.
float cuts_union(Cut a, Cut b)
{
    bool same = b.of.x >= 0.0 && (b.of.x == a.of.x || b.of.x == a.of.y || b.of.x == a.of.z);
    return same ? max(a.area, b.area) : a.area + b.area - cuts_overlap(a, b);
}

// What two edges of one occluder let through: past opposite sides of it both; of two that run along
// the same side, one behind the other, what both do.
float cuts_open(Cut a, Cut b)
{
    bool along = b.of.x >= 0.0 && a.of.x != b.of.x && cos(a.angle - b.angle) > ALONG;
    bool same = b.of.x >= 0.0 && (b.of.x == a.of.y || b.of.x == a.of.z);
    return along && !same ? cuts_overlap(a, b) : cuts_union(a, b);
}
