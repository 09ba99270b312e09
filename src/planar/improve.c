/* planar/improve.c: better triangles by exchange of diagonals.
 *
 * The sweep's triangles tile every face; their shape is an accident. Two neighbours in one face
 * make a quadrilateral a d b c; where it is convex its diagonal a-b can be exchanged for c-d:
 *
 *          c                 c
 *        / | \             /   \       edges of the arrangement are never exchanged, so the tiling
 *      a --+-- b   <->   a       b     stays one at every step: what the paper has to detect and to
 *        \ | /             \   /       withdraw (a strip that runs back into filled area) cannot
 *          d                 d         arise
 *
 * NEAREST is the paper's strip between two rings (section 3.3.1): triangles should have points on
 * both rings, and of the two next points the nearer one is taken. As a rule for diagonals: fewer
 * triangles with three equal values, then the shorter diagonal. What stays flat are the bays that
 * do not see the other ring. Number of flat triangles and length of the diagonals only fall, so it
 * ends.
 *
 * DELAUNAY: Lawson's rule, which ends in the constrained Delaunay triangulation.
 *
 * Faces named by avoid_above and avoid_below (umbra and outside) are even: there only avoid counts.
 * avoid (the leaks at crossings on the innermost and the outermost ring): a diagonal that ends at
 * such a point gives way where it can, so that only the triangle between the point's two neighbours
 * on the ring is left to interpolate.
 */
#include "planar/inside.h"

struct quad {
    uint32_t a, b, c, d;
};

static bool flat(const float *v, uint32_t a, uint32_t b, uint32_t c)
{
    return v[a] == v[b] && v[b] == v[c];
}

static double length2(struct planar_point a, struct planar_point b)
{
    double dx = (double)a.x - b.x, dy = (double)a.y - b.y;
    return dx * dx + dy * dy;
}

/* Is c-d better than a-b? */
static bool better(const struct planar_point *p, const struct planar_improve *how, struct quad q,
                   int32_t level)
{
    if (how->avoid && (level >= how->avoid_above || level <= how->avoid_below)) {
        bool old = how->avoid[q.a] || how->avoid[q.b], new = how->avoid[q.c] || how->avoid[q.d];
        if (old != new)
            return old;
        return false; /* even faces: their shape does not matter */
    }
    switch (how->rule) {
    case PLANAR_RULE_SWEEP: return false;
    case PLANAR_RULE_NEAREST: {
        const float *v = how->values;
        if (v) {
            int old = flat(v, q.a, q.b, q.c) + flat(v, q.b, q.a, q.d);
            int new = flat(v, q.a, q.d, q.c) + flat(v, q.d, q.b, q.c);
            if (old != new)
                return new < old;
        }
        return length2(p[q.c], p[q.d]) < length2(p[q.a], p[q.b]);
    }
    case PLANAR_RULE_DELAUNAY: return planar_in_circle(p[q.a], p[q.b], p[q.c], p[q.d]);
    }
    return false;
}

static void relink(struct planar_triangle *t, uint32_t half, uint32_t other)
{
    t[half / 3].near[half % 3] = other;
    if (other != PLANAR_NONE)
        t[other / 3].near[other % 3] = half;
}

static void push(struct planar_workspace *w, uint32_t half)
{
    uint32_t other = w->triangles[half / 3].near[half % 3];
    if (other == PLANAR_NONE)
        return;
    uint32_t key = half < other ? half : other;
    if (w->queued[key] || !ROOM(w, stack, 1))
        return;
    w->queued[key] = 1;
    w->stack[w->stack_count++] = key;
}

size_t planar_improve(struct planar_workspace *w, const struct planar_result *result,
                      const struct planar_improve *how)
{
    struct planar_triangle *t = result->triangles;
    const struct planar_point *p = result->points;
    size_t halves = 3 * result->triangle_count, exchanged = 0;
    w->stack_count = w->queued_count = 0;
    if (!ROOM(w, queued, halves) || !ROOM(w, stack, halves)) {
        w->no_memory = false; /* the triangles stay as they are */
        return 0;
    }
    for (size_t i = 0; i < halves; i++)
        w->queued[i] = 0;
    for (uint32_t i = 0; i < halves; i++) {
        const struct planar_triangle *x = &t[i / 3];
        if (x->near[i % 3] <= i || x->near[i % 3] == PLANAR_NONE)
            continue;
        if (how->avoid && (x->level >= how->avoid_above || x->level <= how->avoid_below) &&
            !how->avoid[x->v[i % 3]] && !how->avoid[x->v[(i + 1) % 3]])
            continue;
        push(w, i);
    }
    /* Both rules end; the bound is against surprises. */
    size_t bound = 100 * halves + 10000;
    while (w->stack_count > 0 && exchanged < bound) {
        uint32_t half = w->stack[--w->stack_count];
        w->queued[half] = 0;
        uint32_t i = half / 3, k = half % 3, other = t[i].near[k];
        if (other == PLANAR_NONE)
            continue;
        uint32_t j = other / 3, m = other % 3;
        uint32_t k1 = (k + 1) % 3, k2 = (k + 2) % 3, m1 = (m + 1) % 3, m2 = (m + 2) % 3;
        struct quad q = {t[i].v[k], t[i].v[k1], t[i].v[k2], t[j].v[m2]};
        if (!better(p, how, q, t[i].level) || planar_orient(p[q.a], p[q.d], p[q.c]) <= 0 ||
            planar_orient(p[q.d], p[q.b], p[q.c]) <= 0)
            continue;
        uint32_t bc = t[i].near[k1], ca = t[i].near[k2], ad = t[j].near[m1], db = t[j].near[m2];
        t[i] = (struct planar_triangle){{q.a, q.d, q.c}, {0, 0, 0}, t[i].level};
        t[j] = (struct planar_triangle){{q.d, q.b, q.c}, {0, 0, 0}, t[j].level};
        relink(t, 3 * i, ad);
        relink(t, 3 * i + 1, 3 * j + 2);
        relink(t, 3 * i + 2, ca);
        relink(t, 3 * j, db);
        relink(t, 3 * j + 1, bc);
        exchanged++;
        push(w, 3 * i);
        push(w, 3 * i + 2);
        push(w, 3 * j);
        push(w, 3 * j + 1);
    }
    w->no_memory = false;
    return exchanged;
}
