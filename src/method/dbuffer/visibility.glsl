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

// The share of the disk that lies in two caps of heights t1, t2 <= 1/2 whose middles stand alpha
// apart: the common arc from one chord's end to the other's, closed over the point where the
// chords cross (Green's theorem).
float caps_overlap(float t1, float t2, float alpha)
{
    t1 = clamp(t1, 0.0, 0.5);
    t2 = clamp(t2, 0.0, 0.5);
    float h1 = 1.0 - 2.0 * t1, h2 = 1.0 - 2.0 * t2;
    float a1 = acos(h1), a2 = acos(h2);
    alpha = abs(alpha);
    alpha = alpha > PI ? 2.0 * PI - alpha : alpha;
    float least = min(cap(t1), cap(t2));
    if (least <= 0.0 || alpha >= a1 + a2)
        return 0.0;
    if (alpha <= abs(a1 - a2))
        return least;
    float from = alpha - a2;
    float y = (h2 - h1 * cos(alpha)) / sin(alpha);
    float area = 0.5 * (a1 - from) + 0.5 * h1 * (y - sin(a1)) +
                 0.5 * (h1 * sin(from) - y * cos(from));
#if V_FORM == 1
    return clamp(area / PI, 0.0, least);
#else
    float exact = min(cap_exact(t1), cap_exact(t2));
    return exact > 0.0 ? least * clamp(area / (PI * exact), 0.0, 1.0) : 0.0;
#endif
}
