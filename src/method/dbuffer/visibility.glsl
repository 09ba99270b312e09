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

// An edge's cap of height t <= 1/2 around an angle, cut by its corner.
struct Cut {
    float t, angle, area; // area: by V(t), cut
};

// A volume's texel (volume.frag), for a receiver at d.
Cut cut_at(vec4 volume, float d)
{
    float q = volume.x, s = volume.y;
    Cut cut = Cut(0.0, volume.z, 0.0);
    if (!(q > 0.0 && d > q))
        return cut;
    // Eq. 3, re-derived.
    cut.t = min(0.5, 0.5 * s * (d - q) / (q * (d - s)));
    cut.area = cap(cut.t);
    if (volume.w > 1e7)
        return cut;
    float h = 1.0 - 2.0 * cut.t, packed_corner = abs(volume.w) - (volume.w < 0.0 ? 1.0 : 0.0);
    float b = floor(packed_corner / 4096.0), a = packed_corner - 4096.0 * b;
    float next = ((b + 0.5) / 4096.0 - 0.5) * 2.0 * PI, cut_area;
    if (volume.w < 0.0) {
        float last = ((a + 0.5) / 4096.0 - 0.5) * 2.0 * PI;
        cut_area = beyond_both(h * cos(volume.z - last), h * cos(volume.z - next), last - next);
    } else {
        // The vertex stands off by less, the farther the receiver.
        float off = ((a + 0.5) / 4096.0 - 0.5) * 16.0 * (q - s) * d / (q * (d - s));
        float turn = next - volume.z;
        cut_area = beyond_both(h, h * cos(turn) + off * sin(turn), turn);
    }
    float whole = cap_exact(cut.t);
    cut.area *= whole > 0.0 ? clamp(cut_area / whole, 0.0, 1.0) : 1.0;
    return cut;
}

// What two cuts have in common, and what they take together.
float cuts_overlap(Cut a, Cut b)
{
    float whole_a = cap_exact(a.t), whole_b = cap_exact(b.t);
    if (a.area <= 0.0 || b.area <= 0.0 || whole_a <= 0.0 || whole_b <= 0.0)
        return 0.0;
    float both = beyond_both(1.0 - 2.0 * a.t, 1.0 - 2.0 * b.t, a.angle - b.angle);
    return min(min(a.area, b.area), both * (a.area / whole_a) * (b.area / whole_b));
}

float cuts_union(Cut a, Cut b)
{
    return a.area + b.area - cuts_overlap(a, b);
}
