/* planar/predicate.h: the predicates of the plane, exact.
 *
 * Bit budget: |coordinate| <= 2^29 (PLANAR_LIMIT). Differences fit 31 bits, a product of two 61,
 * the difference of two products 62: int64 holds the orientation exactly. The in-circle determinant
 * needs 3 x (61 + 61) bits and some carry: 126, which __int128 holds; a double filter decides
 * nearly all cases first.
 */
#ifndef PLANAR_PREDICATE_H
#define PLANAR_PREDICATE_H

#include <stdbool.h>
#include <stdint.h>

#define PLANAR_LIMIT (1 << 29)

struct planar_point {
    int32_t x, y;
};

/* Twice the signed area of (a, b, c): above 0 when c lies to the left of a -> b. Every order in
 * this folder follows from this one function. */
static inline int64_t planar_orient(struct planar_point a, struct planar_point b,
                                    struct planar_point c)
{
    return (int64_t)(b.x - a.x) * (c.y - a.y) - (int64_t)(b.y - a.y) * (c.x - a.x);
}

/* The order in which the sweep meets points, by x, then by y, as one number: comparing it takes no
 * branch that could be foretold wrongly. */
static inline int64_t planar_key(struct planar_point p)
{
    return (int64_t)p.x * ((int64_t)1 << 32) + p.y;
}

static inline bool planar_before(struct planar_point a, struct planar_point b)
{
    return planar_key(a) < planar_key(b);
}

static inline bool planar_same(struct planar_point a, struct planar_point b)
{
    return ((a.x ^ b.x) | (a.y ^ b.y)) == 0;
}

/* d strictly inside the circle through a, b, c (counter-clockwise). */
static inline bool planar_in_circle(struct planar_point a, struct planar_point b,
                                    struct planar_point c, struct planar_point d)
{
    int64_t ax = a.x - d.x, ay = a.y - d.y, bx = b.x - d.x, by = b.y - d.y, cx = c.x - d.x,
            cy = c.y - d.y;
    int64_t bc = bx * cy - by * cx, ca = cx * ay - cy * ax, ab = ax * by - ay * bx;
    int64_t aa = ax * ax + ay * ay, bb = bx * bx + by * by, cc = cx * cx + cy * cy;
    double p = (double)aa * (double)bc, q = (double)bb * (double)ca, r = (double)cc * (double)ab;
    double det = p + q + r;
    double bound = 1e-15 * ((p < 0 ? -p : p) + (q < 0 ? -q : q) + (r < 0 ? -r : r));
    if (det > bound)
        return true;
    if (det < -bound)
        return false;
    return (__int128)aa * bc + (__int128)bb * ca + (__int128)cc * ab > 0;
}

#endif
