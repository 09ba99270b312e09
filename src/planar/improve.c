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

#include <string.h>

struct quad {
    uint32_t a, b, c, d;
};

/* Exact: differences fit 31 bits, squares 62, their sum 63. */
static inline int64_t length2(struct planar_point a, struct planar_point b)
{
    int64_t dx = (int64_t)a.x - b.x, dy = (int64_t)a.y - b.y;
    return dx * dx + dy * dy;
}

/* Is c-d better than a-b? Without branches where they would be foretold wrongly. */
static inline bool better(const struct planar_point *p, const struct planar_improve *how,
                          struct quad q, int32_t level)
{
    if (how->avoid && (level >= how->avoid_above || level <= how->avoid_below)) {
        /* Even faces: their shape does not matter. */
        bool old = how->avoid[q.a] || how->avoid[q.b], new = how->avoid[q.c] || how->avoid[q.d];
        return old && !new;
    }
    if (how->rule == PLANAR_RULE_DELAUNAY)
        return planar_in_circle(p[q.a], p[q.b], p[q.c], p[q.d]);
    if (how->rule != PLANAR_RULE_NEAREST)
        return false;
    int saved = 0; /* flat triangles */
    if (how->values) {
        float a = how->values[q.a], b = how->values[q.b], c = how->values[q.c],
              d = how->values[q.d];
        int old = (a == b) & (c == a), old2 = (a == b) & (d == a);
        int new = (c == d) & (a == c), new2 = (c == d) & (b == c);
        saved = old + old2 - new - new2;
    }
    bool shorter = length2(p[q.c], p[q.d]) < length2(p[q.a], p[q.b]);
    return (saved > 0) | ((saved == 0) & shorter);
}

/* The sides to look at again. Those after `reached` are still to come in the first round. */
struct list {
    uint32_t *stack;
    uint8_t *queued;
    size_t count;
    uint32_t reached;
};

/* half has come to lie beside other: told to other, and looked at again. Sides of faces are as many
 * as diagonals, and none foretells the other: no branches here. */
static inline size_t moved(struct planar_triangle *t, uint32_t *restrict stack,
                           uint8_t *restrict queued, size_t count, uint32_t reached, uint32_t half,
                           uint32_t other)
{
    bool inner = other != PLANAR_NONE;
    uint32_t nowhere, key = half < other ? half : other, to = inner ? other : half;
    bool again = inner & (key <= reached);
    uint32_t *back = &t[to / 3].near[to % 3];
    *(inner ? back : &nowhere) = half;
    uint8_t old = queued[key];
    queued[key] = old | again;
    stack[count] = key;
    return count + (again & !old);
}

/* Exchanges the diagonal that is side k of triangle i, if that is better and possible. */
static inline bool exchange(const struct planar_result *result, const struct planar_improve *how,
                            struct list *list, uint32_t i, uint32_t k)
{
    struct planar_triangle *t = result->triangles;
    const struct planar_point *p = result->points;
    uint32_t other = t[i].near[k];
    if (other == PLANAR_NONE)
        return false;
    uint32_t j = other / 3, m = other - 3 * j;
    uint32_t k1 = k == 2 ? 0 : k + 1, k2 = k == 0 ? 2 : k - 1;
    uint32_t m1 = m == 2 ? 0 : m + 1, m2 = m == 0 ? 2 : m - 1;
    struct quad q = {t[i].v[k], t[i].v[k1], t[i].v[k2], t[j].v[m2]};
    if (!better(p, how, q, t[i].level) || planar_orient(p[q.a], p[q.d], p[q.c]) <= 0 ||
        planar_orient(p[q.d], p[q.b], p[q.c]) <= 0)
        return false;
    uint32_t bc = t[i].near[k1], ca = t[i].near[k2], ad = t[j].near[m1], db = t[j].near[m2];
    size_t count = list->count;
    uint32_t reached = list->reached;
    uint32_t *restrict stack = list->stack;
    uint8_t *restrict queued = list->queued;
    t[i].v[0] = q.a;
    t[i].v[1] = t[j].v[0] = q.d;
    t[j].v[1] = q.b;
    t[i].v[2] = t[j].v[2] = q.c;
    t[i].near[0] = ad;
    t[i].near[1] = 3 * j + 2;
    t[i].near[2] = ca;
    t[j].near[0] = db;
    t[j].near[1] = bc;
    t[j].near[2] = 3 * i + 1;
    count = moved(t, stack, queued, count, reached, 3 * i, ad);
    count = moved(t, stack, queued, count, reached, 3 * i + 2, ca);
    count = moved(t, stack, queued, count, reached, 3 * j, db);
    list->count = moved(t, stack, queued, count, reached, 3 * j + 1, bc);
    return true;
}

size_t planar_improve(struct planar_workspace *w, const struct planar_result *result,
                      const struct planar_improve *how)
{
    const struct planar_triangle *t = result->triangles;
    size_t halves = 3 * result->triangle_count, exchanged = 0;
    w->stack_count = w->queued_count = 0;
    /* Two lists by turns. A diagonal is on a list once at most; one place more for what is not put
     * there. */
    if (!ROOM(w, queued, halves) || !ROOM(w, stack, 2 * halves + 2)) {
        w->no_memory = false; /* the triangles stay as they are */
        return 0;
    }
    if (halves > 0)
        memset(w->queued, 0, halves);
    struct list list = {w->stack, w->queued, 0, 0};
    /* Once over all sides, then those around what was exchanged. */
    for (uint32_t i = 0; i < result->triangle_count; i++)
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t other = t[i].near[k];
            if (other <= 3 * i + k || other == PLANAR_NONE)
                continue;
            if (how->even_from > 0 && t[i].level >= how->even_from)
                continue;
            if (how->avoid && (t[i].level >= how->avoid_above || t[i].level <= how->avoid_below) &&
                !how->avoid[t[i].v[k]] && !how->avoid[t[i].v[k == 2 ? 0 : k + 1]])
                continue;
            list.reached = 3 * i + k;
            exchanged += exchange(result, how, &list, i, k);
        }
    list.reached = PLANAR_NONE;
    /* Round by round: the last exchange's sides come up later, when what it wrote has arrived. Both
     * rules end; the bound is against surprises. */
    size_t bound = 100 * halves + 10000;
    for (uint32_t *other = w->stack + halves + 1; list.count > 0 && exchanged < bound;) {
        uint32_t *now = list.stack;
        size_t count = list.count;
        list.stack = other;
        list.count = 0;
        other = now;
        for (size_t i = 0; i < count; i++) {
            list.queued[now[i]] = 0;
            exchanged += exchange(result, how, &list, now[i] / 3, now[i] % 3);
        }
    }
    return exchanged;
}
