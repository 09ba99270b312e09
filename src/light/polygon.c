/* light/polygon.c: the polygon of a polygonal light in its own plane: is it simple, its triangles.
 *
 * Input: n points of the plane, the polygon's outline counter-clockwise (positive area). Simple
 * means that edges meet only at the corners that they share. O(n^2) each; lights have few corners.
 * Corners in a straight line are fine: they give no triangle of their own.
 */
#include "light/polygon.h"

#include "geom/tolerance.h"

static double area2(const double *a, const double *b, const double *c)
{
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

double polygon_area(const double *points, size_t count)
{
    double sum = 0;
    for (size_t i = 1; i + 1 < count; i++)
        sum += area2(points, points + 2 * i, points + 2 * i + 2);
    return 0.5 * sum;
}

static bool between(const double *a, const double *b, const double *p)
{
    return fmin(a[0], b[0]) <= p[0] && p[0] <= fmax(a[0], b[0]) && fmin(a[1], b[1]) <= p[1] &&
           p[1] <= fmax(a[1], b[1]);
}

/* Closed segments ab and cd have a point in common. */
static bool segments_meet(const double *a, const double *b, const double *c, const double *d)
{
    double s = area2(a, b, c), t = area2(a, b, d), u = area2(c, d, a), v = area2(c, d, b);
    if (((s > 0 && t < 0) || (s < 0 && t > 0)) && ((u > 0 && v < 0) || (u < 0 && v > 0)))
        return true;
    return (s == 0 && between(a, b, c)) || (t == 0 && between(a, b, d)) ||
           (u == 0 && between(c, d, a)) || (v == 0 && between(c, d, b));
}

bool polygon_simple(const double *points, size_t count, size_t *out_first, size_t *out_second)
{
    for (size_t i = 0; i < count; i++) {
        const double *a = points + 2 * i, *b = points + 2 * ((i + 1) % count);
        for (size_t j = i + 1; j < count; j++) {
            const double *c = points + 2 * j, *d = points + 2 * ((j + 1) % count);
            bool meet;
            if (j == i + 1)
                /* Neighbours share a corner; they overlap if the second runs back on the first. */
                meet = area2(a, b, d) == 0 &&
                       (b[0] - a[0]) * (d[0] - c[0]) + (b[1] - a[1]) * (d[1] - c[1]) < 0;
            else if (i == 0 && j == count - 1)
                meet = area2(c, d, b) == 0 &&
                       (d[0] - c[0]) * (b[0] - a[0]) + (d[1] - c[1]) * (b[1] - a[1]) < 0;
            else
                meet = segments_meet(a, b, c, d);
            if (meet) {
                *out_first = i;
                *out_second = j;
                return false;
            }
        }
    }
    return true;
}

/* No other corner of the remaining outline lies in the closed triangle a b c, corners at the very
 * places of a, b, c aside. */
static bool is_ear(const double *points, const uint32_t *next, uint32_t a, uint32_t b, uint32_t c)
{
    const double *pa = points + 2 * a, *pb = points + 2 * b, *pc = points + 2 * c;
    for (uint32_t k = next[c]; k != a; k = next[k]) {
        const double *p = points + 2 * k;
        if (area2(pa, pb, p) >= 0 && area2(pb, pc, p) >= 0 && area2(pc, pa, p) >= 0 &&
            !(p[0] == pa[0] && p[1] == pa[1]) && !(p[0] == pc[0] && p[1] == pc[1]))
            return false;
    }
    return true;
}

size_t polygon_triangulate(const double *points, size_t count, uint32_t *next, uint32_t *previous,
                           uint32_t *triangles)
{
    double flat = 2 * TOLERANCE_DEGENERATE * fabs(polygon_area(points, count));
    size_t triangle_count = 0, left = count, tried = 0;
    for (size_t i = 0; i < count; i++) {
        next[i] = (uint32_t)((i + 1) % count);
        previous[i] = (uint32_t)((i + count - 1) % count);
    }
    uint32_t b = 0;
    while (left >= 3) {
        uint32_t a = previous[b], c = next[b];
        double area = area2(points + 2 * a, points + 2 * b, points + 2 * c);
        bool straight = fabs(area) <= flat;
        /* After a full round without an ear, rounding has hidden it: take any convex corner. */
        bool cut = straight || (area > 0 && (tried > left || is_ear(points, next, a, b, c)));
        if (!cut && tried <= 2 * left) {
            tried++;
            b = c;
            continue;
        }
        if (area > flat) {
            triangles[3 * triangle_count + 0] = a;
            triangles[3 * triangle_count + 1] = b;
            triangles[3 * triangle_count + 2] = c;
            triangle_count++;
        }
        next[a] = c;
        previous[c] = a;
        left--;
        tried = 0;
        b = c;
    }
    return triangle_count;
}
