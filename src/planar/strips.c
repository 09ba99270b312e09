/* planar/strips.c: the faces between rings filled by strips (Boehl and Stuerzlinger,
 * section 3.3.1).
 *
 * Nearly every face of level i is bounded by two chains, one of ring i and one of ring i + 1, which
 * meet in two points, crossings of the two:
 *
 *        b1 ---- b2 --- b3         ring i + 1    From one of the two points to the other the next
 *       /  \    / \    /  \                      triangle takes the next point of the one chain or
 *      P    \  /   \  /    Q                     of the other, whichever is nearer to the far end
 * of \    a1 ---- a2 --/        ring i        the last side: the paper's rule, linear in time.
 *
 * If all triangles of such a strip turn out counter-clockwise they tile the face, and nothing else
 * needs to be looked at: a map of a disk onto the plane that is nowhere turned over, and one to one
 * on the rim, is one to one. So what the paper detects by geometry afterwards (strips that run into
 * filled area) is one sign per triangle. Where the strip fails (bays), or a face has other than two
 * such points, its ears are cut off if it has few corners. The rest, and faces with holes, are
 * swept once more, by themselves, with triangles and exchange of diagonals (fill.c, improve.c).
 *
 * The faces are found by walking along half-edges: half-edge 2 e has the face below edge e on its
 * left and runs from right to left, 2 e + 1 has the one above and runs from left to right. The
 * sweep ends the edges of one point together, from below to above; only those that start there need
 * to be sorted. O(edges), apart from the faces that are swept again.
 */
#include <string.h>

#include "planar/inside.h"

#define STARTERS_MAX 64
#define EARS_MAX     64
#define NO_EAR       INT32_MAX
#define INNER        0x80000000u /* in a walk: the edge that follows is one of the inner ring */

static inline uint32_t origin_of(const struct planar_result *r, uint32_t half)
{
    const struct planar_edge *e = &r->edges[half >> 1];
    return half & 1 ? e->left : e->right;
}

/* The edges around a point that is none of a mere bend. arriving: the first of those that end
 * there; leaving: list of those that start there. */
static bool link_point(struct planar_workspace *w, const struct planar_result *r, uint32_t point,
                       uint32_t arriving, uint32_t leaving)
{
    uint32_t right[STARTERS_MAX], *next = w->next, left_count = 0, right_count = 0;
    const struct planar_point *p = r->points;
    if (arriving != PLANAR_NONE)
        while (arriving + left_count < r->edge_count &&
               r->edges[arriving + left_count].right == point)
            left_count++;
    for (uint32_t e = leaving; e != PLANAR_NONE; e = w->leaving_next[e]) {
        if (right_count == STARTERS_MAX)
            return false;
        struct planar_point end = p[r->edges[e].right];
        uint32_t i = right_count++;
        for (; i > 0 && planar_orient(p[point], p[r->edges[right[i - 1]].right], end) < 0; i--)
            right[i] = right[i - 1];
        right[i] = e;
    }
    for (uint32_t i = 0; i + 1 < left_count; i++)
        next[2 * (arriving + i) + 1] = 2 * (arriving + i + 1);
    for (uint32_t i = 0; i + 1 < right_count; i++)
        next[2 * right[i + 1]] = 2 * right[i] + 1;
    uint32_t lowest_left = 2 * arriving, highest_left = 2 * (arriving + left_count - 1) + 1;
    if (right_count == 0) {
        next[highest_left] = lowest_left;
        return true;
    }
    uint32_t lowest_right = 2 * right[0], highest_right = 2 * right[right_count - 1] + 1;
    if (left_count > 0)
        next[highest_left] = highest_right;
    next[lowest_right] = left_count > 0 ? lowest_left : highest_right;
    return true;
}

/* Which half-edge follows which around the face on its left. */
static bool link_halves(struct planar_workspace *w, const struct planar_result *r)
{
    size_t points = r->point_count, edges = r->edge_count;
    w->next_count = w->leaving_count = w->leaving_next_count = w->slots_count = 0;
    if (!ROOM(w, next, 2 * edges) || !ROOM(w, leaving, points) || !ROOM(w, leaving_next, edges) ||
        !ROOM(w, slots, points))
        return false;
    uint32_t *leaving = w->leaving, *arriving = w->slots;
    memset(leaving, 0xff, points * sizeof(*leaving));
    memset(arriving, 0xff, points * sizeof(*arriving));
    for (size_t e = edges; e-- > 0;) {
        w->leaving_next[e] = leaving[r->edges[e].left];
        leaving[r->edges[e].left] = (uint32_t)e;
        arriving[r->edges[e].right] = (uint32_t)e;
    }
    for (uint32_t i = 0; i < points; i++) {
        uint32_t a = arriving[i], l = leaving[i];
        bool bend = a != PLANAR_NONE && l != PLANAR_NONE && w->leaving_next[l] == PLANAR_NONE &&
                    (a + 1 == edges || r->edges[a + 1].right != i);
        if (bend) {
            w->next[2 * a + 1] = 2 * l + 1;
            w->next[2 * l] = 2 * a;
        } else if (a != PLANAR_NONE || l != PLANAR_NONE) {
            if (!link_point(w, r, i, a, l))
                return false;
        }
    }
    return true;
}

/* INNER if the half-edge is one of an inner ring of its face. */
static inline uint32_t ring_of(const struct planar_result *r, uint32_t half, int32_t level)
{
    const struct planar_edge *e = &r->edges[half >> 1];
    return (half & 1 ? e->below : e->above) > level ? INNER : 0;
}

/* Walks around a face, leaves its points in w->walk, and takes its half-edges out. */
static bool walk_around(struct planar_workspace *w, const struct planar_result *r, uint32_t half,
                        int32_t level)
{
    if (!ROOM(w, loops, 1))
        return false;
    uint32_t *walk = w->walk + w->walk_count, count = 0, turns = 0;
    uint32_t begun = ring_of(r, half, level), before = begun;
    do {
        uint32_t next = w->next[half], inner = ring_of(r, half, level);
        turns += inner != before;
        before = inner;
        walk[count++] = origin_of(r, half) | inner;
        w->next[half] = PLANAR_NONE;
        half = next;
    } while (w->next[half] != PLANAR_NONE);
    w->loops[w->loops_count++] = (struct planar_loop){.first = (uint32_t)w->walk_count,
                                                      .count = count,
                                                      .level = level,
                                                      .turns = turns + (before != begun)};
    w->walk_count += count;
    return true;
}

/* Runs clockwise: the rim of a hole. And the box around it. */
static bool look_around(struct planar_workspace *w, const struct planar_point *p,
                        struct planar_loop *loop)
{
    const uint32_t *walk = w->walk + loop->first;
    struct planar_point base = p[walk[0] & ~INNER], last = base, lo = base, hi = base;
    uint64_t area = 0; /* its terms may turn over, its sum does not */
    for (uint32_t i = 1; i < loop->count; i++) {
        struct planar_point at = p[walk[i] & ~INNER];
        area += (uint64_t)planar_orient(base, last, at);
        last = at;
        lo.x = at.x < lo.x ? at.x : lo.x;
        lo.y = at.y < lo.y ? at.y : lo.y;
        hi.x = at.x > hi.x ? at.x : hi.x;
        hi.y = at.y > hi.y ? at.y : hi.y;
    }
    loop->lo = lo;
    loop->hi = hi;
    loop->hole = (int64_t)area <= 0;
    return loop->hole;
}

/* Exact: differences fit 31 bits, squares 62, their sum 63. */
static inline int64_t length2(struct planar_point a, struct planar_point b)
{
    int64_t dx = (int64_t)a.x - b.x, dy = (int64_t)a.y - b.y;
    return dx * dx + dy * dy;
}

/* The strip between the two halves of a face's turns. False, and nothing done: it has none. */
static bool fill_strip(struct planar_workspace *w, const struct planar_point *p,
                       const struct planar_loop *loop)
{
    const uint32_t *walk = w->walk + loop->first;
    uint32_t n = loop->count, begin = 0, at, a_last = 0, turns = 0;
    while ((walk[begin] & INNER) || !(walk[begin > 0 ? begin - 1 : n - 1] & INNER))
        begin++;
    /* One chain as it runs, the other one backwards; both with both ends. */
    uint32_t *a = w->walk + w->walk_count, before = 0; /* room for n + 2 more */
    for (at = begin;; at = at + 1 < n ? at + 1 : 0) {
        turns += (walk[at] & INNER) != before;
        before = walk[at] & INNER;
        a[a_last] = walk[at] & ~INNER;
        if (2 * turns >= loop->turns)
            break;
        a_last++;
    }
    uint32_t *b = a + a_last + 1, b_last = n - a_last;
    for (uint32_t j = b_last; j > 0; j--) {
        b[j] = walk[at] & ~INNER;
        at = at + 1 < n ? at + 1 : 0;
    }
    b[0] = a[0];

    struct planar_triangle *out = w->triangles + w->triangles_count;
    uint32_t i = a_last > b_last, j = !i;
    for (uint32_t left = n - 2; left > 0; left--) {
        uint32_t first = a[i], last = b[j], may_a = i < a_last, may_b = j < b_last;
        uint32_t next_a = a[i + may_a], next_b = b[j + may_b];
        bool take_a =
            may_a & ((!may_b) | (length2(p[next_a], p[last]) <= length2(p[next_b], p[first])));
        uint32_t to = take_a ? next_a : next_b;
        if (planar_orient(p[first], p[to], p[last]) <= 0) {
            take_a = !take_a;
            to = take_a ? next_a : next_b;
            if (!(take_a ? may_a : may_b) || planar_orient(p[first], p[to], p[last]) <= 0)
                return false;
        }
        *out++ = (struct planar_triangle){
            {first, to, last}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, loop->level};
        i += take_a;
        j += !take_a;
    }
    w->triangles_count = (size_t)(out - w->triangles);
    return true;
}

/* A face of few points, and no hole, taken apart by its ears: always the one whose cut is shortest,
 * triangles with three equal values last. O(points^2). */
struct ears {
    struct planar_point p[EARS_MAX];
    uint32_t id[EARS_MAX];
    float value[EARS_MAX];
    int32_t cut[EARS_MAX]; /* in the order of its length; NO_EAR: the corner is none */
    uint8_t before[EARS_MAX], after[EARS_MAX];
    uint64_t hollow; /* bits: the face has half a turn there, or more */
};

static inline void measure_ear(struct ears *e, uint32_t i)
{
    uint32_t a = e->before[i], b = e->after[i];
    bool flat = (e->value[a] == e->value[i]) & (e->value[b] == e->value[i]);
    bool hollow = planar_orient(e->p[a], e->p[i], e->p[b]) <= 0;
    union {
        float f;
        int32_t bits;
    } length = {.f = (float)length2(e->p[a], e->p[b])}; /* below 2^63: bits below 0x5f800000 */
    e->hollow = (e->hollow & ~((uint64_t)1 << i)) | (uint64_t)hollow << i;
    e->cut[i] = hollow ? NO_EAR : (length.bits >> 1) + (flat ? 0x30000000 : 0);
}

/* If any corner lies in an ear, a hollow one does. */
static bool ear_is_free(const struct ears *e, uint32_t i)
{
    uint32_t a = e->before[i], b = e->after[i];
    struct planar_point pa = e->p[a], pb = e->p[b], pi = e->p[i];
    for (uint64_t rest = e->hollow & ~((uint64_t)1 << a | (uint64_t)1 << b); rest;
         rest &= rest - 1) {
        struct planar_point q = e->p[__builtin_ctzll(rest)];
        if (planar_orient(pa, pi, q) >= 0 && planar_orient(pi, pb, q) >= 0 &&
            planar_orient(pb, pa, q) >= 0)
            return false;
    }
    return true;
}

static bool fill_ears(struct planar_workspace *w, const struct planar_point *p, const float *values,
                      const struct planar_loop *loop)
{
    struct ears e;
    uint32_t n = loop->count;
    if (n < 3 || n > EARS_MAX)
        return false;
    e.hollow = 0;
    for (uint32_t i = 0; i < n; i++) {
        e.id[i] = w->walk[loop->first + i] & ~INNER;
        e.p[i] = p[e.id[i]];
        e.value[i] = values ? values[e.id[i]] : (float)i;
        e.before[i] = (uint8_t)(i > 0 ? i - 1 : n - 1);
        e.after[i] = (uint8_t)(i + 1 < n ? i + 1 : 0);
    }
    for (uint32_t i = 0; i < n; i++)
        measure_ear(&e, i);
    struct planar_triangle *out = w->triangles + w->triangles_count;
    for (uint32_t left = n;;) {
        int32_t least = NO_EAR;
        uint32_t best = 0;
        for (uint32_t i = 0; i < n; i++)
            least = e.cut[i] < least ? e.cut[i] : least;
        if (least == NO_EAR)
            return false;
        while (e.cut[best] != least)
            best++;
        e.cut[best] = NO_EAR; /* gone, or none until one of its neighbours goes */
        if (left > 3 && !ear_is_free(&e, best))
            continue;
        uint32_t a = e.before[best], b = e.after[best];
        *out++ = (struct planar_triangle){
            {e.id[a], e.id[best], e.id[b]}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, loop->level};
        if (left-- == 3)
            break;
        e.after[a] = (uint8_t)b;
        e.before[b] = (uint8_t)a;
        measure_ear(&e, a);
        measure_ear(&e, b);
    }
    w->triangles_count = (size_t)(out - w->triangles);
    return true;
}

/* Has the face a hole? Maybe, if there is one of its level within its box. */
static bool may_have_hole(const struct planar_workspace *w, const struct planar_loop *loop)
{
    for (size_t i = 0; i < w->holes_count; i++) {
        const struct planar_loop *h = &w->loops[w->holes[i]];
        if (h->level == loop->level && h->lo.x >= loop->lo.x && h->lo.y >= loop->lo.y &&
            h->hi.x <= loop->hi.x && h->hi.y <= loop->hi.y)
            return true;
    }
    return false;
}

/* Strips and ears. Marks the faces that are left, and finds holes. */
static void fill_faces(struct planar_workspace *w, const struct planar_point *p,
                       const struct planar_strips *how)
{
    bool holes = w->holes_count > 0;
    w->triangles_count = 0;
    for (size_t i = 0; i < w->loops_count; i++) {
        struct planar_loop *loop = &w->loops[i];
        loop->left = false;
        if (holes && (loop->hole || may_have_hole(w, loop))) {
            loop->left = true;
        } else if (loop->turns == 0 || !fill_strip(w, p, loop)) {
            if (!holes && look_around(w, p, loop)) {
                w->holes[w->holes_count++] = (uint32_t)i;
                loop->left = true;
            } else {
                loop->left = !fill_ears(w, p, how->values, loop);
            }
        }
    }
}

/* A face to be swept again: its edges, with it on their right, at its level. */
static bool hand_on(struct planar_workspace *w, const struct planar_result *r,
                    struct planar_workspace *spare, const struct planar_loop *loop)
{
    if (!ROOM(spare, given_points, loop->count) || !ROOM(spare, given_segments, loop->count) ||
        !ROOM(spare, given_ids, loop->count))
        return false;
    uint32_t *slots = w->slots, before = 0;
    for (uint32_t i = 0; i <= loop->count; i++) {
        uint32_t v = w->walk[loop->first + (i < loop->count ? i : 0)] & ~INNER;
        if (slots[v] == PLANAR_NONE) {
            slots[v] = (uint32_t)spare->given_points_count++;
            spare->given_points[slots[v]] = r->points[v];
            spare->given_ids[spare->given_ids_count++] = v;
        }
        if (i > 0)
            spare->given_segments[spare->given_segments_count++] =
                (struct planar_segment){slots[v], before, loop->level};
        before = slots[v];
    }
    return true;
}

/* Fills the faces that have been handed on. False: not possible. */
static bool fill_rest(struct planar_workspace *w, struct planar_workspace *spare,
                      const struct planar_strips *how)
{
    struct planar_options options = {.triangulate = true, .min_level = 1, .max_level = INT32_MAX};
    struct planar_result rest;
    size_t n = spare->given_points_count;
    if (planar_sweep(spare, spare->given_points, n, spare->given_segments,
                     spare->given_segments_count, &options, &rest) ||
        rest.snapped || rest.crossing_count > 0)
        return false;
    spare->slots_count = spare->values_count = 0;
    if (!ROOM(spare, slots, n) || !ROOM(spare, values, n))
        return false;
    for (size_t i = 0; i < n; i++) {
        spare->slots[spare->rank[i]] = spare->given_ids[i];
        spare->values[spare->rank[i]] = how->values ? how->values[spare->given_ids[i]] : 0;
    }
    planar_improve(spare, &rest,
                   &(struct planar_improve){.rule = PLANAR_RULE_NEAREST,
                                            .values = how->values ? spare->values : NULL,
                                            .even_from = how->even_from});
    if (!ROOM(w, triangles, rest.triangle_count))
        return false;
    for (size_t i = 0; i < rest.triangle_count; i++) {
        struct planar_triangle t = rest.triangles[i];
        for (int k = 0; k < 3; k++) {
            t.v[k] = spare->slots[t.v[k]];
            t.near[k] = PLANAR_NONE;
        }
        w->triangles[w->triangles_count++] = t;
    }
    return true;
}

/* Is one of points [from, to), which are in order, in the triangle or on its rim, other than its
 * corners? */
static bool holds_point(const struct planar_point *points, size_t from, size_t to,
                        const struct planar_point *t)
{
    int32_t x0 = t[0].x, x1 = t[0].x;
    for (int k = 1; k < 3; k++) {
        x0 = t[k].x < x0 ? t[k].x : x0;
        x1 = t[k].x > x1 ? t[k].x : x1;
    }
    for (size_t n = to - from; n > 0;) {
        size_t half = n / 2;
        bool before = points[from + half].x < x0;
        from += before ? half + 1 : 0;
        n = before ? n - half - 1 : half;
    }
    for (; from < to && points[from].x <= x1; from++) {
        struct planar_point p = points[from];
        if (!planar_same(p, t[0]) && !planar_same(p, t[1]) && !planar_same(p, t[2]) &&
            planar_orient(t[0], t[1], p) >= 0 && planar_orient(t[1], t[2], p) >= 0 &&
            planar_orient(t[2], t[0], p) >= 0)
            return true;
    }
    return false;
}

/* Triangles of level 0 at the points named by corners: between the two edges of the outside that
 * meet there, where nothing else lies in between. An edge serves one triangle. */
static bool fill_corners(struct planar_workspace *w, const struct planar_result *r,
                         const uint8_t *corners)
{
    for (uint32_t half = 0; half < 2 * r->edge_count; half++) {
        const struct planar_edge *e = &r->edges[half >> 1];
        uint32_t to = w->next[half];
        if ((half & 1 ? e->above : e->below) != 0 || to == PLANAR_NONE ||
            !corners[half & 1 ? e->right : e->left] || w->next[to] == PLANAR_NONE)
            continue;
        uint32_t v[3] = {origin_of(r, half), origin_of(r, to), origin_of(r, to ^ 1)};
        struct planar_point t[3] = {r->points[v[0]], r->points[v[1]], r->points[v[2]]};
        if (planar_orient(t[0], t[1], t[2]) <= 0 ||
            holds_point(r->points, 0, r->input_point_count, t) ||
            holds_point(r->points, r->input_point_count, r->point_count, t))
            continue;
        if (!ROOM(w, triangles, 1))
            return false;
        w->triangles[w->triangles_count++] = (struct planar_triangle){
            {v[0], v[1], v[2]}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, 0};
        w->next[half] = w->next[to] = PLANAR_NONE;
    }
    return true;
}

static bool fill(struct planar_workspace *w, struct planar_workspace *spare,
                 const struct planar_strips *how, const struct planar_result *r)
{
    w->triangles_count = w->loops_count = w->holes_count = w->walk_count = 0;
    spare->given_points_count = spare->given_segments_count = spare->given_ids_count = 0;
    if (r->point_count == 0)
        return true;
    if (r->point_count >= INNER || !link_halves(w, r) || !ROOM(w, walk, 4 * r->edge_count + 4))
        return false;
    for (uint32_t half = 0; half < 2 * r->edge_count; half++) {
        const struct planar_edge *e = &r->edges[half >> 1];
        int32_t level = half & 1 ? e->above : e->below;
        if (level > 0 && w->next[half] != PLANAR_NONE && !walk_around(w, r, half, level))
            return false;
    }
    /* Each face has fewer triangles than points. */
    if (!ROOM(w, triangles, w->walk_count) || !ROOM(w, holes, w->loops_count))
        return false;
    /* As if no face had a hole; if there is one, once more. */
    fill_faces(w, r->points, how);
    if (w->holes_count > 0) {
        for (size_t i = 0; i < w->loops_count; i++)
            look_around(w, r->points, &w->loops[i]);
        fill_faces(w, r->points, how);
    }
    memset(w->slots, 0xff, r->point_count * sizeof(*w->slots));
    for (size_t i = 0; i < w->loops_count; i++)
        if (w->loops[i].left && !hand_on(w, r, spare, &w->loops[i]))
            return false;
    if (spare->given_segments_count > 0 && !fill_rest(w, spare, how))
        return false;
    return !how->corners || fill_corners(w, r, how->corners);
}

bool planar_strips(struct planar_workspace *w, struct planar_workspace *spare,
                   const struct planar_strips *how, struct planar_result *io_result)
{
    w->no_memory = spare->no_memory = false;
    bool filled = fill(w, spare, how, io_result);
    io_result->triangles = w->triangles;
    io_result->triangle_count = filled ? w->triangles_count : 0;
    return filled;
}
