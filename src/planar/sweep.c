/* planar/sweep.c: the sweep line (Boehl and Stuerzlinger, sections 3.1 and 3.2, in one).
 *
 * A vertical line moves over the plane by x (then y). The status holds the edges that it cuts, from
 * below to above; winding numbers are summed up along it. At each point: edges that arrive are
 * done, edges that pass through it are cut there, edges that leave take their place, sorted by
 * direction; neighbours that have not met before are tested, and where they cross a point is made,
 * rounded to the grid, at which both are cut.
 *
 * The paper cuts an edge against all others when it is inserted; here only neighbours of the status
 * are compared, so that n edges with k crossings cost O((n + k) log n). Where a chain merely bends,
 * the new edge takes the old one's place without a search. The status is an array: a search is a
 * binary one, an insertion moves memory.
 *
 * Exact: one predicate (planar_orient) makes every decision. A point on an edge, coincident edges,
 * many edges through one point, vertical edges: all usual cases, not special ones. Not exact is
 * only the rounding of a crossing to the grid, which bends both edges by up to 1.5 grid units (2.9
 * where an edge's end takes the crossing). Of the four grid points around a crossing and the ends
 * one is taken that leaves all order as it is: that of neighbours, and that of points already
 * passed that lie near an edge (`grazed`). If there is none (`trouble`), the input is rounded by
 * snap.c and swept again.
 *
 * Invariants: edges meet in end points only; below + delta = above; the winding numbers around a
 * point agree (else: the segments do not close).
 */
#include "planar/inside.h"

#include <stdlib.h>
#include <string.h>

#define STARTERS_MAX   64
#define BEND_DEPTH_MAX 40
#define HINT_REACH     8
#define TOLD_PLACES    48

static inline int64_t side(const struct sweep_edge *e, struct planar_point p)
{
    return planar_orient(e->l, e->r, p);
}

static inline int32_t above(const struct sweep_edge *e)
{
    return e->below + e->delta;
}

static inline struct planar_point point_of(int64_t key)
{
    /* y is the low half, whose sign has been taken off the high one. */
    int32_t y = (int32_t)(uint32_t)((uint64_t)key & 0xffffffffu);
    return (struct planar_point){(int32_t)((key - y) / ((int64_t)1 << 32)), y};
}

static void heap_push(struct planar_workspace *w, struct crossing c)
{
    if (!ROOM(w, heap, 1))
        return;
    size_t i = w->heap_count++;
    while (i > 0 && c.key < w->heap[(i - 1) / 2].key) {
        w->heap[i] = w->heap[(i - 1) / 2];
        i = (i - 1) / 2;
    }
    w->heap[i] = c;
}

static inline struct crossing heap_pop(struct planar_workspace *w)
{
    struct crossing *heap = w->heap, top = heap[0], c = heap[--w->heap_count];
    size_t i = 0, n = w->heap_count;
    for (size_t child; (child = 2 * i + 1) < n; i = child) {
        child += (child + 1 < n) & (heap[child + 1 < n ? child + 1 : child].key < heap[child].key);
        if (heap[child].key >= c.key)
            break;
        heap[i] = heap[child];
    }
    heap[i] = c;
    return top;
}

/* Where in the status an edge is: mostly where it was put, or a few places off. The status' length:
 * further off. */
static size_t find_near(const struct planar_workspace *w, uint32_t edge)
{
    const uint32_t *status = w->status;
    size_t n = w->status_count, hint = w->work[edge].hint;
    for (size_t d = 0; d <= HINT_REACH; d++) {
        if (hint + d < n && status[hint + d] == edge)
            return hint + d;
        if (d <= hint && hint - d < n && status[hint - d] == edge)
            return hint - d;
    }
    return n;
}

/* The first of the status that p does not lie above. */
static inline size_t first_at_or_above(const struct planar_workspace *w, struct planar_point p)
{
    const uint32_t *status = w->status;
    size_t a = 0, n = w->status_count;
    while (n > 0) {
        size_t half = n / 2;
        bool over = side(&w->work[status[a + half]], p) > 0;
        a = over ? a + half + 1 : a;
        n = over ? n - half - 1 : half;
    }
    return a;
}

/* Those of the status that run through p: [*lo, *hi). */
static void find_range(struct planar_workspace *w, struct planar_point p, uint32_t ends, size_t *lo,
                       size_t *hi)
{
    const uint32_t *status = w->status;
    const struct sweep_edge *work = w->work;
    size_t n = w->status_count;
    size_t first, last;
    size_t at = n;
    if (ends != PLANAR_NONE && planar_same(work[ends].r, p))
        at = find_near(w, ends);
    if (at < n) {
        first = at;
        last = first + 1;
        while (first > 0) {
            int64_t s = side(&work[status[first - 1]], p);
            if (s > 0)
                break;
            if (s < 0)
                w->trouble = true;
            first--;
        }
    } else {
        first = last = first_at_or_above(w, p);
    }
    while (last < n) {
        int64_t s = side(&work[status[last]], p);
        if (s < 0)
            break;
        if (s > 0)
            w->trouble = true;
        last++;
    }
    *lo = first;
    *hi = last;
}

/* Where two edges that are known to cross do so: the grid point below and to the left, and what is
 * left over. */
static struct planar_point crossing_cell(const struct sweep_edge *f, const struct sweep_edge *g,
                                         double *rest_x, double *rest_y)
{
    /* f.l + t (f.r - f.l), t = cross(g.l - f.l, dg) / cross(df, dg): numerator and denominator are
     * exact, the quotient is right to 2^-51, the product to 2^-21 grid units. */
    int64_t dfx = f->r.x - f->l.x, dfy = f->r.y - f->l.y;
    int64_t dgx = g->r.x - g->l.x, dgy = g->r.y - g->l.y;
    int64_t number = (g->l.x - f->l.x) * dgy - (g->l.y - f->l.y) * dgx;
    int64_t by = dfx * dgy - dfy * dgx;
    double t = (double)number / (double)by;
    double x = t * (double)dfx, y = t * (double)dfy;
    /* Rounding down: what is above 0 is cut off. */
    int64_t fx = (int64_t)(x + 0x1p31) - ((int64_t)1 << 31);
    int64_t fy = (int64_t)(y + 0x1p31) - ((int64_t)1 << 31);
    *rest_x = x - (double)fx;
    *rest_y = y - (double)fy;
    return (struct planar_point){f->l.x + (int32_t)fx, f->l.y + (int32_t)fy};
}

/* Remembers of an edge of the status that the point at hand nearly touches it; s: side(e, p). */
static inline void note_graze(struct sweep_edge *e, uint32_t id, int64_t s)
{
    int64_t dx = e->r.x - e->l.x, dy = labs((long)e->r.y - e->l.y);
    if (llabs(s) > 4 * (dx + dy)) /* at least 4 grid units times the edge's length */
        return;
    if (e->grazed == 0)
        e->graze = id;
    e->grazed += e->grazed == 0 || e->graze != id;
}

/* Would a bend at c put one of count points, all of them passed, on the other side of the edge? */
static bool any_changes_side(const struct sweep_edge *e, struct planar_point c,
                             const struct planar_point *points, size_t count)
{
    int64_t from = planar_key(e->l), to = planar_key(c);
    bool changes = false;
    for (size_t i = 0; i < count; i++) {
        int64_t key = planar_key(points[i]), old = side(e, points[i]),
                new = planar_orient(e->l, c, points[i]);
        changes |= key > from && key < to && !((old > 0 && new > 0) || (old < 0 && new < 0));
    }
    return changes;
}

/* May the edge be bent so that its left part ends at c? Where one point is near all that is asked
 * is its side; where there are several, rare, all that have been passed are gone through. */
static inline bool may_bend(const struct planar_workspace *w, const struct sweep_edge *e,
                            struct planar_point c)
{
    if (e->grazed == 0 || side(e, c) == 0)
        return true;
    if (e->grazed == 1)
        return !any_changes_side(e, c, &w->points[e->graze], 1);
    return !any_changes_side(e, c, w->points, w->passed) &&
           !any_changes_side(e, c, w->points + w->input_points, w->points_count - w->input_points);
}

/* Cuts an edge of the status at p; the rest starts there later. Returns the rest or PLANAR_NONE. */
static uint32_t cut(struct planar_workspace *w, uint32_t id, struct planar_point p)
{
    if (planar_same(w->work[id].r, p) || !ROOM(w, work, 1))
        return PLANAR_NONE;
    struct sweep_edge *e = &w->work[id];
    uint32_t rest = (uint32_t)w->work_count++;
    w->work[rest] = (struct sweep_edge){.l = p,
                                        .r = e->r,
                                        .rid = e->rid,
                                        .delta = e->delta,
                                        .next = PLANAR_NONE,
                                        .hint = PLANAR_NONE};
    e->r = p;
    e->rid = PLANAR_NONE;
    return rest;
}

/* An edge, cut at c, and a neighbour: is the neighbour's left end, if the edge had begun before,
 * still on the same side (above: 1, below: -1)? Both begin in one point: is the neighbour's right
 * end? If the neighbour had begun before, the cut changes nothing. */
static inline bool keeps_side(const struct sweep_edge *e, struct planar_point c,
                              const struct sweep_edge *neighbour, int64_t way)
{
    bool same = planar_same(e->l, neighbour->l);
    struct planar_point q = {same ? neighbour->r.x : neighbour->l.x,
                             same ? neighbour->r.y : neighbour->l.y};
    return planar_before(neighbour->l, e->l) | (way * planar_orient(e->l, c, q) > 0);
}

/* Can the status' edges i and i + 1 both be cut at c, all order kept? */
static inline bool fits(const struct planar_workspace *w, size_t i, struct planar_point p,
                        struct planar_point c)
{
    const struct sweep_edge *f = &w->work[w->status[i]], *g = &w->work[w->status[i + 1]];
    bool apart = !planar_same(f->l, g->l);
    bool fit = planar_before(p, c) & !planar_before(f->r, c) & !planar_before(g->r, c) & apart;
    /* Which of the two began first does not matter: one of the two tests is idle. */
    fit &= keeps_side(f, c, g, 1) & keeps_side(g, c, f, -1);
    if (i > 0)
        fit &= keeps_side(f, c, &w->work[w->status[i - 1]], -1);
    if (i + 2 < w->status_count)
        fit &= keeps_side(g, c, &w->work[w->status[i + 2]], 1);
    return fit && may_bend(w, f, c) && may_bend(w, g, c);
}

/* Do the status' edges i and i + 1 cross to the right of p? Then cut them there: at the nearest
 * grid point, or at another corner of the grid cell or the end of one of them if that would put
 * something out of order. */
static void cut_pair(struct planar_workspace *w, size_t i, struct planar_point p, int depth);

static inline void check_pair(struct planar_workspace *w, size_t i, struct planar_point p,
                              int depth)
{
    const struct sweep_edge *f = &w->work[w->status[i]], *g = &w->work[w->status[i + 1]];
    /* Is the end that comes first on the wrong side of the other edge? Which one that is nobody can
     * foretell: no branch for it. */
    int64_t first = -(int64_t)planar_before(g->r, f->r); /* all ones: g's */
    const struct sweep_edge *line = first ? f : g;
    struct planar_point end = {first ? g->r.x : f->r.x, first ? g->r.y : f->r.y};
    int64_t s = side(line, end);
    if (((s ^ ~first) - ~first) < 0)
        cut_pair(w, i, p, depth);
}

static void cut_pair(struct planar_workspace *w, size_t i, struct planar_point p, int depth)
{
    uint32_t fi = w->status[i], gi = w->status[i + 1];
    const struct sweep_edge *f = &w->work[fi], *g = &w->work[gi];
    double rest_x, rest_y;
    struct planar_point cell = crossing_cell(f, g, &rest_x, &rest_y), c = cell;
    bool found = false;
    int nearest = (rest_x >= 0.5) | (rest_y >= 0.5) << 1;
    for (int k = 0; k < 4 && !found; k++) {
        int corner = nearest ^ k;
        c = (struct planar_point){cell.x + (corner & 1), cell.y + (corner >> 1)};
        found = fits(w, i, p, c);
    }
    for (int k = 0; k < 2 && !found; k++) {
        c = k ? g->r : f->r;
        found = abs(c.x - cell.x) <= 2 && abs(c.y - cell.y) <= 2 && fits(w, i, p, c);
    }
    if (!found || depth > BEND_DEPTH_MAX) {
        w->trouble = true;
        return;
    }
    uint32_t a = cut(w, fi, c), b = cut(w, gi, c);
    uint32_t first = a != PLANAR_NONE ? a : b;
    if (a != PLANAR_NONE)
        w->work[a].next = b;
    if (w->no_memory)
        return;
    heap_push(w, (struct crossing){planar_key(c), first, fi});
    if (w->no_memory)
        return;
    /* Both are bent a little: they may cross their other neighbours now. */
    if (i > 0)
        check_pair(w, i - 1, p, depth + 1);
    if (i + 2 < w->status_count && !w->trouble)
        check_pair(w, i + 1, p, depth + 1);
}

static inline bool filled(const struct planar_workspace *w, int32_t level)
{
    return level >= w->min_level && level <= w->max_level;
}

static void end_trapezoid(struct planar_workspace *w, uint32_t lower, uint32_t upper, int32_t x)
{
    struct sweep_edge *e = &w->work[lower];
    if (filled(w, above(e)) && e->gap_x < x && ROOM(w, trapezoids, 1))
        w->trapezoids[w->trapezoids_count++] =
            (struct planar_trapezoid){e->gap_x, x, lower, upper, above(e)};
    e->gap_x = x;
}

/* Puts an edge that starts at p among the others, in order of direction. Coincident ones become
 * one.
 */
static size_t add_starter(struct planar_workspace *w, uint32_t *starters, size_t count,
                          struct planar_point p, uint32_t id)
{
    struct sweep_edge *e = &w->work[id];
    size_t i = count;
    for (; i > 0; i--) {
        struct sweep_edge *o = &w->work[starters[i - 1]];
        int64_t turn = planar_orient(p, o->r, e->r);
        if (turn > 0)
            break;
        if (turn == 0) {
            /* One direction: the shorter takes both, what is left of the longer starts at its end.
             */
            if (planar_before(e->r, o->r)) {
                struct sweep_edge t = *o;
                o->r = e->r;
                o->rid = e->rid;
                o->delta += e->delta;
                e->l = o->r;
                e->r = t.r;
                e->rid = t.rid;
                e->delta = t.delta;
            } else {
                o->delta += e->delta;
                if (planar_same(e->r, o->r))
                    return count;
                e->l = o->r;
            }
            e->next = PLANAR_NONE;
            heap_push(w, (struct crossing){planar_key(e->l), id, PLANAR_NONE});
            return count;
        }
    }
    for (size_t j = count; j > i; j--)
        starters[j] = starters[j - 1];
    starters[i] = id;
    return count + 1;
}

static inline void finish_edge(struct planar_workspace *w, uint32_t id, uint32_t point)
{
    struct sweep_edge *e = &w->work[id];
    int32_t below = e->below, over = above(e), t = w->threshold;
    e->rid = point;
    e->next = (uint32_t)w->edges_count; /* from here on: its number in the result */
    w->trouble |= e->lid == point;
    if ((t == 0 || (below < t) != (over < t)) && ROOM(w, edges, 1))
        w->edges[w->edges_count++] = (struct planar_edge){e->lid, point, below, over};
}

/* After edges have come or gone below place `from` of the status: where the next ones are now. */
static inline void tell_places(struct planar_workspace *w, size_t from)
{
    size_t end = from + TOLD_PLACES < w->status_count ? from + TOLD_PLACES : w->status_count;
    for (size_t i = from; i < end; i++)
        w->work[w->status[i]].hint = (uint32_t)i;
}

/* Edges have come to the status, from `at` to `last`, and begin at p: what that means to the edges
 * below and above them (NULL: none), of which over and under are the sides of p. */
static inline void look_beside(struct planar_workspace *w, size_t at, size_t last,
                               struct planar_point p, uint32_t id, struct sweep_edge *lower,
                               int64_t over, struct sweep_edge *upper, int64_t under)
{
    if (lower)
        note_graze(lower, id, over);
    if (upper)
        note_graze(upper, id, under);
    /* From here on edges may move in memory: a crossing adds some. */
    if (lower)
        check_pair(w, at - 1, p, 0);
    if (upper && !w->trouble)
        check_pair(w, last, p, 0);
}

/* The usual point: where a chain merely bends, and no other edge passes. The new edge takes the old
 * one's place. False, and nothing done: the point is another one. */
static bool pass_on(struct planar_workspace *w, struct planar_point p, uint32_t id, uint32_t first,
                    uint32_t ends)
{
    struct sweep_edge *old = &w->work[ends], *new = &w->work[first];
    if (new->next != PLANAR_NONE || old->delta != new->delta || !planar_same(old->r, p))
        return false;
    size_t at = find_near(w, ends), n = w->status_count;
    if (at == n)
        return false;
    uint32_t *status = w->status;
    struct sweep_edge *lower = at > 0 ? &w->work[status[at - 1]] : NULL;
    struct sweep_edge *upper = at + 1 < n ? &w->work[status[at + 1]] : NULL;
    int64_t over = lower ? side(lower, p) : 1, under = upper ? side(upper, p) : -1;
    if (over <= 0 || under >= 0 || !ROOM(w, edges, 1))
        return false;
    new->below = old->below;
    new->lid = id;
    new->hint = (uint32_t)at;
    if (w->triangulate) {
        if (lower && filled(w, old->below))
            fill_attach_top(w, lower, id, old->below);
        if (upper && filled(w, above(old))) {
            fill_attach_bottom(w, old, id, above(old));
            new->low = old->low;
            new->high = old->high;
            new->last = old->last;
        }
    }
    finish_edge(w, ends, id);
    status[at] = first;
    if (new->rid != PLANAR_NONE)
        w->incoming[new->rid] = first;
    look_beside(w, at, at, p, id, lower, over, upper, under);
    return true;
}

/* The usual crossing: two edges that meet nowhere else and no third one. Their rests change places.
 * False, and nothing done: it is another one. */
static bool swap(struct planar_workspace *w, struct planar_point p, uint32_t first, uint32_t ends)
{
    uint32_t second = w->work[first].next;
    if (second == PLANAR_NONE || w->work[second].next != PLANAR_NONE)
        return false;
    size_t at = find_near(w, ends), n = w->status_count;
    if (at + 1 >= n)
        return false;
    uint32_t *status = w->status;
    struct sweep_edge *f = &w->work[status[at]], *g = &w->work[status[at + 1]];
    struct sweep_edge *a = &w->work[first], *b = &w->work[second];
    /* As cut_pair() leaves them: the first rest is that of f. */
    if (!planar_same(f->r, p) || !planar_same(g->r, p) || a->delta != f->delta ||
        b->delta != g->delta || planar_orient(p, b->r, a->r) <= 0)
        return false;
    struct sweep_edge *lower = at > 0 ? &w->work[status[at - 1]] : NULL;
    struct sweep_edge *upper = at + 2 < n ? &w->work[status[at + 2]] : NULL;
    int64_t over = lower ? side(lower, p) : 1, under = upper ? side(upper, p) : -1;
    if (over <= 0 || under >= 0 || !ROOM(w, edges, 2) || !ROOM(w, points, 1))
        return false;
    uint32_t id = (uint32_t)w->points_count;
    w->points[w->points_count++] = p;
    if (w->triangulate) {
        int32_t level = f->below, middle = above(f), top = above(g);
        if (lower && filled(w, level))
            fill_attach_top(w, lower, id, level);
        if (filled(w, middle))
            fill_close(w, f, id, middle);
        if (upper && filled(w, top)) {
            fill_attach_bottom(w, g, id, top);
            a->low = g->low;
            a->high = g->high;
            a->last = g->last;
        }
        if (filled(w, level + b->delta))
            fill_start(w, b, id);
        if (w->no_memory || w->trouble)
            return true;
    }
    b->below = f->below;
    a->below = f->below + b->delta;
    a->lid = b->lid = id;
    b->hint = (uint32_t)at;
    a->hint = (uint32_t)at + 1;
    finish_edge(w, status[at], id);
    finish_edge(w, status[at + 1], id);
    status[at] = second;
    status[at + 1] = first;
    if (a->rid != PLANAR_NONE)
        w->incoming[a->rid] = first;
    if (b->rid != PLANAR_NONE)
        w->incoming[b->rid] = second;
    look_beside(w, at, at + 1, p, id, lower, over, upper, under);
    return true;
}

/* The usual place where two edges start, between two others. False, and nothing done: it is another
 * one. */
static bool open_pair(struct planar_workspace *w, struct planar_point p, uint32_t id,
                      uint32_t first)
{
    uint32_t second = w->work[first].next;
    if (second == PLANAR_NONE || w->work[second].next != PLANAR_NONE)
        return false;
    int64_t turn = planar_orient(p, w->work[first].r, w->work[second].r);
    if (turn == 0 || w->work[first].delta + w->work[second].delta != 0 ||
        w->work[first].delta == 0 || !ROOM(w, status, 2))
        return false;
    uint32_t *status = w->status, low = turn > 0 ? first : second, high = turn > 0 ? second : first;
    size_t at = first_at_or_above(w, p), n = w->status_count;
    struct sweep_edge *f = &w->work[low], *g = &w->work[high];
    struct sweep_edge *lower = at > 0 ? &w->work[status[at - 1]] : NULL;
    struct sweep_edge *upper = at < n ? &w->work[status[at]] : NULL;
    int64_t over = lower ? side(lower, p) : 1, under = upper ? side(upper, p) : -1;
    if (under >= 0)
        return false;
    int32_t level = lower ? above(lower) : w->base;
    f->below = level;
    g->below = level + f->delta;
    f->lid = g->lid = id;
    f->hint = (uint32_t)at;
    g->hint = (uint32_t)at + 1;
    if (w->triangulate) {
        if (lower && upper && filled(w, level))
            fill_split(w, lower, g, id);
        if (filled(w, g->below))
            fill_start(w, f, id);
        if (w->no_memory || w->trouble)
            return true;
    }
    memmove(status + at + 2, status + at, (n - at) * sizeof(*status));
    status[at] = low;
    status[at + 1] = high;
    w->status_count += 2;
    tell_places(w, at + 2);
    w->incoming[f->rid] = low;
    w->incoming[g->rid] = high;
    look_beside(w, at, at + 1, p, id, lower, over, upper, under);
    return true;
}

/* The usual place where two edges end, between two others. False, and nothing done: it is another
 * one. */
static bool close_pair(struct planar_workspace *w, struct planar_point p, uint32_t id,
                       uint32_t ends)
{
    size_t at = find_near(w, ends), n = w->status_count;
    uint32_t *status = w->status;
    if (at == n)
        return false;
    at -= at > 0 && planar_same(w->work[status[at - 1]].r, p);
    if (at + 1 >= n)
        return false;
    struct sweep_edge *f = &w->work[status[at]], *g = &w->work[status[at + 1]];
    struct sweep_edge *lower = at > 0 ? &w->work[status[at - 1]] : NULL;
    struct sweep_edge *upper = at + 2 < n ? &w->work[status[at + 2]] : NULL;
    int64_t over = lower ? side(lower, p) : 1, under = upper ? side(upper, p) : -1;
    if (!planar_same(f->r, p) || !planar_same(g->r, p) || f->delta + g->delta != 0 || over <= 0 ||
        under >= 0)
        return false;
    if (w->triangulate) {
        int32_t level = f->below;
        if (lower && filled(w, level))
            fill_attach_top(w, lower, id, level);
        if (filled(w, above(f)))
            fill_close(w, f, id, above(f));
        if (upper && filled(w, level)) {
            fill_attach_bottom(w, g, id, level);
            if (lower)
                fill_join(w, lower, g);
        }
        if (w->no_memory || w->trouble)
            return true;
    }
    finish_edge(w, status[at], id);
    finish_edge(w, status[at + 1], id);
    memmove(status + at, status + at + 2, (n - at - 2) * sizeof(*status));
    w->status_count -= 2;
    tell_places(w, at);
    if (lower)
        note_graze(lower, id, over);
    if (upper)
        note_graze(upper, id, under);
    if (lower && upper)
        check_pair(w, at - 1, p, 0);
    return true;
}

/* One point of the sweep. first: the list of the edges that start there; ends: hint, an edge that
 * ends there; id: the point's number, or PLANAR_NONE for a crossing. */
static void meet(struct planar_workspace *w, struct planar_point p, uint32_t id, uint32_t first,
                 uint32_t ends)
{
    uint32_t small[STARTERS_MAX], *starters = small, *large = NULL;
    size_t lo, hi;
    find_range(w, p, ends, &lo, &hi);
    if (w->trouble)
        return;
    size_t list = 0;
    for (uint32_t e = first; e != PLANAR_NONE; e = w->work[e].next)
        list++;
    if (list + (hi - lo) == 0)
        return;
    if (list + (hi - lo) > STARTERS_MAX) {
        starters = large = memory_alloc(w->context, list + (hi - lo), sizeof(*large));
        w->no_memory |= !large;
    }
    if (w->no_memory || !ROOM(w, work, hi - lo + 2) || !ROOM(w, status, list + (hi - lo)) ||
        !ROOM(w, edges, hi - lo) || !ROOM(w, points, 1)) {
        memory_free(w->context, large);
        return;
    }
    int32_t level = lo > 0 ? above(&w->work[w->status[lo - 1]]) : w->base;
    int32_t top_level = hi > lo ? above(&w->work[w->status[hi - 1]]) : level;
    /* Edges that start here, and the rests of those that pass through. */
    size_t count = 0;
    for (uint32_t e = first; e != PLANAR_NONE;) {
        uint32_t next = w->work[e].next;
        count = add_starter(w, starters, count, p, e);
        e = next;
    }
    for (size_t i = lo; i < hi; i++) {
        if (!planar_same(w->work[w->status[i]].r, p)) {
            uint32_t rest = cut(w, w->status[i], p);
            count = add_starter(w, starters, count, p, rest);
        }
    }
    size_t kept = 0;
    int32_t sum = level;
    for (size_t i = 0; i < count; i++) {
        struct sweep_edge *e = &w->work[starters[i]];
        if (e->delta == 0)
            continue;
        e->below = sum;
        sum += e->delta;
        starters[kept++] = starters[i];
    }
    count = kept;
    if (sum != top_level) {
        w->unclosed = true;
        w->unclosed_at = p;
        memory_free(w->context, large);
        return;
    }
    size_t ended = hi - lo;
    if (count + ended == 0) {
        memory_free(w->context, large);
        return;
    }
    if (id == PLANAR_NONE) {
        id = (uint32_t)w->points_count;
        w->points[w->points_count++] = p;
    }
    uint32_t *status = w->status;
    struct sweep_edge *lower = lo > 0 ? &w->work[status[lo - 1]] : NULL;
    bool bounded = hi < w->status_count;
    struct sweep_edge *highest = count > 0 ? &w->work[starters[count - 1]] : NULL;

    /* Faces: the gaps that this point touches. */
    if (w->trapezoid) {
        if (lower && (ended || bounded))
            end_trapezoid(w, status[lo - 1], status[lo], p.x);
        for (size_t i = lo; i < hi; i++)
            if (i + 1 < w->status_count)
                end_trapezoid(w, status[i], status[i + 1], p.x);
        for (size_t i = 0; i < count; i++)
            w->work[starters[i]].gap_x = p.x;
    }
    if (w->triangulate) {
        if (ended) {
            struct sweep_edge *upper = &w->work[status[hi - 1]];
            if (lower && filled(w, level))
                fill_attach_top(w, lower, id, level);
            for (size_t i = lo; i + 1 < hi; i++) {
                struct sweep_edge *e = &w->work[status[i]];
                if (filled(w, above(e)))
                    fill_close(w, e, id, above(e));
            }
            if (bounded && filled(w, top_level)) {
                fill_attach_bottom(w, upper, id, top_level);
                if (highest) {
                    highest->low = upper->low;
                    highest->high = upper->high;
                    highest->last = upper->last;
                } else if (lower) {
                    fill_join(w, lower, upper);
                }
            }
        } else if (lower && bounded && filled(w, level)) {
            fill_split(w, lower, highest, id);
        }
        for (size_t i = 0; i + 1 < count; i++) {
            struct sweep_edge *e = &w->work[starters[i]];
            if (filled(w, above(e)))
                fill_start(w, e, id);
        }
        if (w->no_memory || w->trouble) {
            memory_free(w->context, large);
            return;
        }
    }
    for (size_t i = lo; i < hi; i++)
        finish_edge(w, status[i], id);

    /* Put the new edges in the place of the old. */
    if (count != ended) {
        size_t tail = w->status_count - hi;
        memmove(status + lo + count, status + hi, tail * sizeof(*status));
        w->status_count = lo + count + tail;
        tell_places(w, lo + count);
    }
    for (size_t i = 0; i < count; i++) {
        struct sweep_edge *e = &w->work[starters[i]];
        status[lo + i] = starters[i];
        e->lid = id;
        e->hint = (uint32_t)(lo + i);
        if (e->rid != PLANAR_NONE)
            w->incoming[e->rid] = starters[i];
    }
    memory_free(w->context, large);

    if (lo > 0)
        note_graze(&w->work[w->status[lo - 1]], id, side(&w->work[w->status[lo - 1]], p));
    if (lo + count < w->status_count)
        note_graze(&w->work[w->status[lo + count]], id, side(&w->work[w->status[lo + count]], p));

    /* New neighbours. */
    if (lo > 0 && lo < w->status_count)
        check_pair(w, lo - 1, p, 0);
    if (count > 0 && lo + count < w->status_count && !w->trouble)
        check_pair(w, lo + count - 1, p, 0);
}

static void sweep_once(struct planar_workspace *w, const struct planar_point *points,
                       size_t point_count, const struct planar_segment *segments,
                       size_t segment_count, struct planar_result *result)
{
    w->trouble = w->unclosed = false;
    w->work_count = w->edges_count = w->triangles_count = w->trapezoids_count = 0;
    w->status_count = w->heap_count = w->nodes_count = w->diagonals_count = 0;
    w->first_count = w->incoming_count = 0;
    w->free_node = PLANAR_NONE;
    w->passed = 0;
    if (!sort_points(w, points, point_count))
        return;
    size_t n = w->points_count;
    if (!ROOM(w, first, n) || !ROOM(w, incoming, n) ||
        !ROOM(w, work, segment_count + segment_count / 4 + 16) ||
        !ROOM(w, edges, segment_count + 16))
        return;
    for (size_t i = 0; i < n; i++)
        w->first[i] = w->incoming[i] = PLANAR_NONE;
    for (size_t i = 0; i < segment_count; i++) {
        uint32_t a = w->rank[segments[i].a], b = w->rank[segments[i].b];
        if (a == b)
            continue;
        /* A segment to the right has its right side below. */
        uint32_t l = a < b ? a : b, r = a < b ? b : a;
        w->work[w->work_count] =
            (struct sweep_edge){.l = w->points[l],
                                .r = w->points[r],
                                .rid = r,
                                .delta = a < b ? -segments[i].weight : segments[i].weight,
                                .next = w->first[l],
                                .hint = PLANAR_NONE};
        w->first[l] = (uint32_t)w->work_count++;
    }
    result->input_point_count = w->input_points = n;
    for (size_t i = 0; !w->no_memory && !w->trouble && !w->unclosed;) {
        if (w->heap_count == 0 || (i < n && planar_key(w->points[i]) < w->heap[0].key)) {
            if (i == n)
                break;
            struct planar_point p = w->points[i];
            uint32_t id = (uint32_t)i++, first = w->first[id], ends = w->incoming[id];
            w->passed = i;
            bool done = false;
            if (w->trapezoid)
                ;
            else if (ends == PLANAR_NONE)
                done = first != PLANAR_NONE && open_pair(w, p, id, first);
            else if (first == PLANAR_NONE)
                done = close_pair(w, p, id, ends);
            else
                done = pass_on(w, p, id, first, ends);
            if (!done)
                meet(w, p, id, first, ends);
            continue;
        }
        /* A crossing, maybe several at one point, maybe at a point of the input. */
        struct crossing c = heap_pop(w);
        struct planar_point at = point_of(c.key);
        uint32_t id = PLANAR_NONE, list = c.first;
        if (i < n && planar_same(w->points[i], at)) {
            id = (uint32_t)i;
            for (uint32_t e = w->first[i], next; e != PLANAR_NONE; e = next) {
                next = w->work[e].next;
                w->work[e].next = list;
                list = e;
            }
            w->passed = ++i;
        }
        while (w->heap_count > 0 && w->heap[0].key == c.key) {
            struct crossing more = heap_pop(w);
            for (uint32_t e = more.first, next; e != PLANAR_NONE; e = next) {
                next = w->work[e].next;
                w->work[e].next = list;
                list = e;
            }
        }
        if (id != PLANAR_NONE || list == PLANAR_NONE || w->trapezoid || !swap(w, at, list, c.ends))
            meet(w, at, id, list, c.ends);
    }
    w->trouble |= w->status_count > 0 && !w->no_memory && !w->unclosed;
    for (size_t i = 0; i < w->trapezoids_count; i++) {
        w->trapezoids[i].lower = w->work[w->trapezoids[i].lower].next;
        w->trapezoids[i].upper = w->work[w->trapezoids[i].upper].next;
    }
}

pnb_status planar_sweep(struct planar_workspace *w, const struct planar_point *points,
                        size_t point_count, const struct planar_segment *segments,
                        size_t segment_count, const struct planar_options *options,
                        struct planar_result *out_result)
{
    static const struct planar_options none;
    options = options ? options : &none;
    *out_result = (struct planar_result){0};
    /* All at once, then one by one if something is wrong. */
    uint32_t far = 0, highest = 0;
    for (size_t i = 0; i < point_count; i++) {
        uint32_t x = (uint32_t)points[i].x + PLANAR_LIMIT, y = (uint32_t)points[i].y + PLANAR_LIMIT;
        far |= (x > 2u * PLANAR_LIMIT) | (y > 2u * PLANAR_LIMIT);
    }
    for (size_t i = 0; i < segment_count; i++) {
        uint32_t a = segments[i].a, b = segments[i].b, ends = a > b ? a : b;
        highest = ends > highest ? ends : highest;
    }
    for (size_t i = 0; i < point_count && far; i++)
        if (points[i].x > PLANAR_LIMIT || points[i].x < -PLANAR_LIMIT ||
            points[i].y > PLANAR_LIMIT || points[i].y < -PLANAR_LIMIT)
            return status_fail(w->context, PNB_ERROR_ARGUMENT, "planar sweep",
                               "point %zu at (%d, %d) lies outside the grid of +-%d", i,
                               points[i].x, points[i].y, PLANAR_LIMIT);
    for (size_t i = 0; i < segment_count && highest >= point_count; i++)
        if (segments[i].a >= point_count || segments[i].b >= point_count)
            return status_fail(
                w->context, PNB_ERROR_ARGUMENT, "planar sweep", "segment %zu names point %u of %zu",
                i, segments[i].a >= point_count ? segments[i].a : segments[i].b, point_count);
    w->no_memory = false;
    w->base = options->base;
    w->triangulate = options->triangulate;
    w->trapezoid = options->trapezoids;
    w->threshold = options->trapezoids ? 0 : options->threshold;
    bool usual = options->min_level == 0 && options->max_level == 0 && options->base == 0;
    w->min_level = usual ? 1 : options->min_level;
    w->max_level = usual ? INT32_MAX : options->max_level;
    if (w->min_level <= w->base)
        w->min_level = w->base + 1;

    sweep_once(w, points, point_count, segments, segment_count, out_result);
    struct planar_input given = {(struct planar_point *)points,     point_count,   0,
                                 (struct planar_segment *)segments, segment_count, 0};
    struct planar_input snapped = {0}, next = {0};
    pnb_status status = PNB_OK;
    for (int attempt = 0; w->trouble && !w->no_memory && attempt < 4 && !status; attempt++) {
        out_result->snapped = true;
        status = planar_snap(w->context, attempt == 0 ? &given : &snapped, &next);
        if (status)
            break;
        struct planar_input old = snapped;
        snapped = next;
        next = old;
        planar_input_finish(w->context, &next);
        sweep_once(w, snapped.points, snapped.point_count, snapped.segments, snapped.segment_count,
                   out_result);
    }
    planar_input_finish(w->context, &snapped);
    if (status)
        return status;
    if (w->no_memory)
        return status_no_memory(w->context, 0);
    if (w->unclosed)
        return status_fail(w->context, PNB_ERROR_ARGUMENT, "planar sweep",
                           "the segments do not close at (%d, %d)", w->unclosed_at.x,
                           w->unclosed_at.y);
    if (w->trouble)
        return status_fail(w->context, PNB_ERROR_ARGUMENT, "planar sweep",
                           "rounding to the grid could not be made consistent");
    out_result->points = w->points;
    out_result->point_count = w->points_count;
    out_result->crossing_count = w->points_count - out_result->input_point_count;
    out_result->edges = w->edges;
    out_result->edge_count = w->edges_count;
    out_result->triangles = w->triangles;
    out_result->triangle_count = w->triangles_count;
    out_result->trapezoids = w->trapezoids;
    out_result->trapezoid_count = w->trapezoids_count;
    return PNB_OK;
}
