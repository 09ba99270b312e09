/* method/planar/kinks.c: the mesh that refinement starts from.
 *
 * Where the light has corners the shadow has kinks: along the outlines of the shadows of its
 * corners. Their arrangement (with the feet of what stands on the plane, and the meshed box around
 * all) is swept and triangulated, so that the strips of a penumbra, however narrow, are there from
 * the beginning, as are lines along which the shadow of a line light jumps. The outlines are only
 * hints: curved ones are thinned out first (Douglas, Peucker), by up to BEND of the shadow's size
 * (with 1/600 of it the feet of a fence's pickets were lost), and where too many remain the mesh
 * starts from the feet alone and a grid.
 */
#include <math.h>
#include <stdlib.h>

#include "method/planar/refine.h"

#define BEND       (1.0 / 4800)
#define POINTS_MAX 60000
#define FOOT       (1 << 16) /* winding numbers: more than there are outlines */
#define BOX        (1 << 22) /* more than there are feet */

static pnb_status add(struct shadow_builder *b, struct planar_input *in, struct planar_point p,
                      struct planar_point q, int32_t weight)
{
    pnb_status status = planar_input_reserve(b->context, in, 2, 1);
    if (status || planar_same(p, q))
        return status;
    uint32_t n = (uint32_t)in->point_count;
    in->points[n] = p;
    in->points[n + 1] = q;
    in->point_count += 2;
    in->segments[in->segment_count++] = (struct planar_segment){n, n + 1, weight};
    return PNB_OK;
}

static double off_line(struct planar_point a, struct planar_point b, struct planar_point p)
{
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    double px = (double)p.x - a.x, py = (double)p.y - a.y, l = dx * dx + dy * dy;
    double t = l > 0 ? fmin(1, fmax(0, (px * dx + py * dy) / l)) : 0;
    return hypot(px - t * dx, py - t * dy);
}

/* Adds chain[from..to] with points left out that lie within `bend` of what remains. */
static pnb_status add_thinned(struct shadow_builder *b, struct planar_input *in,
                              const struct planar_point *chain, size_t from, size_t to, double bend,
                              int depth)
{
    double worst = 0;
    size_t at = from;
    for (size_t i = from + 1; i < to; i++) {
        double d = off_line(chain[from], chain[to], chain[i]);
        if (d > worst) {
            worst = d;
            at = i;
        }
    }
    if (worst <= bend || depth > 60)
        return add(b, in, chain[from], chain[to], 1);
    pnb_status status = add_thinned(b, in, chain, from, at, bend, depth + 1);
    return status ? status : add_thinned(b, in, chain, at, to, bend, depth + 1);
}

/* The closed chains of the segments of b->levels, thinned. */
static pnb_status add_outlines(struct shadow_builder *b, double bend, struct planar_input *in)
{
    const struct planar_input *from = &b->levels;
    size_t n = from->point_count, count = from->segment_count;
    uint32_t *first = memory_alloc(b->context, n + 1, sizeof(*first));
    uint32_t *next = memory_alloc(b->context, count + 1, sizeof(*next));
    struct planar_point *chain = memory_alloc(b->context, count + 2, sizeof(*chain));
    pnb_status status = PNB_OK;
    if (!first || !next || !chain)
        status = status_no_memory(b->context, (n + count) * 8);
    for (size_t i = 0; i < n && !status; i++)
        first[i] = PLANAR_NONE;
    for (size_t i = count; i-- > 0 && !status;) {
        next[i] = first[from->segments[i].a];
        first[from->segments[i].a] = (uint32_t)i;
    }
    for (size_t i = 0; i < count && !status; i++) {
        uint32_t at = from->segments[i].a, begin = at;
        size_t length = 0;
        while (first[at] != PLANAR_NONE) {
            uint32_t e = first[at];
            chain[length++] = from->points[at];
            first[at] = next[e];
            at = from->segments[e].b;
            if (at == begin)
                break;
        }
        if (length < 2)
            continue;
        chain[length] = chain[0];
        /* Two halves, so that the ends of each differ. */
        size_t far = 1;
        for (size_t k = 1; k < length; k++)
            if (off_line(chain[0], chain[0], chain[k]) > off_line(chain[0], chain[0], chain[far]))
                far = k;
        status = add_thinned(b, in, chain, 0, far, bend, 0);
        if (!status)
            status = add_thinned(b, in, chain, far, length, bend, 0);
    }
    memory_free(b->context, first);
    memory_free(b->context, next);
    memory_free(b->context, chain);
    return status;
}

struct half {
    uint64_t key;
    uint32_t half;
};

static int by_key(const void *a, const void *b)
{
    const struct half *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->half > y->half) - (x->half < y->half);
}

static uint64_t key_of(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static pnb_status take_over(struct shadow_builder *b, const struct planar_result *r,
                            struct tiling *m)
{
    size_t fixed_count = 0;
    uint32_t *number = memory_alloc(b->context, r->point_count + 1, sizeof(*number));
    struct half *halves = memory_alloc(b->context, 3 * r->triangle_count + 1, sizeof(*halves));
    struct half *fixed = memory_alloc(b->context, r->edge_count + 1, sizeof(*fixed));
    pnb_status status = PNB_OK;
    if (!number || !halves || !fixed ||
        !memory_reserve(m->context, (void **)&m->vertices, &m->vertex_capacity, 0, r->point_count,
                        sizeof(*m->vertices)) ||
        !memory_reserve(m->context, (void **)&m->tiles, &m->tile_capacity, 0,
                        r->triangle_count + TILING_STAR_MAX, sizeof(*m->tiles)))
        status = status_no_memory(b->context, r->triangle_count * sizeof(*m->tiles));
    for (size_t i = 0; i < r->point_count && !status; i++)
        number[i] = PLANAR_NONE;
    for (size_t i = 0; i < r->edge_count && !status; i++) {
        int32_t step = abs(r->edges[i].below - r->edges[i].above);
        if (step > FOOT / 2 && step < BOX / 2)
            fixed[fixed_count++].key = key_of(r->edges[i].left, r->edges[i].right);
    }
    for (size_t i = 0; i < fixed_count && !status; i++)
        fixed[i].half = 0;
    if (!status)
        qsort(fixed, fixed_count, sizeof(*fixed), by_key);
    for (uint32_t i = 0; i < r->triangle_count && !status; i++) {
        const struct planar_triangle *t = &r->triangles[i];
        struct tiling_tile *tile = &m->tiles[m->tile_count++];
        *tile = (struct tiling_tile){.near = {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE},
                                     .first = PLANAR_NONE,
                                     .stale = true,
                                     .inside = t->level - BOX > FOOT / 2};
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t p = t->v[k];
            struct half half = {key_of(p, t->v[(k + 1) % 3]), 3 * i + k};
            if (number[p] == PLANAR_NONE) {
                number[p] = (uint32_t)m->vertex_count;
                m->vertices[m->vertex_count++] = (struct tiling_vertex){.p = r->points[p]};
            }
            tile->v[k] = number[p];
            m->vertices[number[p]].tile = i;
            halves[3 * i + k] = half;
            struct half wanted = {half.key, 0};
            if (bsearch(&wanted, fixed, fixed_count, sizeof(*fixed), by_key))
                tile->fixed |= (uint8_t)(1 << k);
        }
    }
    size_t half_count = 3 * m->tile_count;
    if (!status)
        qsort(halves, half_count, sizeof(*halves), by_key);
    for (size_t i = 0; i < half_count && !status; i++) {
        uint32_t h = halves[i].half;
        struct tiling_tile *t = &m->tiles[h / 3];
        struct tiling_vertex *p = &m->vertices[t->v[h % 3]],
                             *q = &m->vertices[t->v[(h % 3 + 1) % 3]];
        if (i + 1 < half_count && halves[i + 1].key == halves[i].key) {
            uint32_t other = halves[++i].half;
            t->near[h % 3] = other;
            m->tiles[other / 3].near[other % 3] = h;
        } else {
            p->border = q->border = true;
        }
        if (t->fixed >> h % 3 & 1)
            p->jump = q->jump = true;
    }
    memory_free(b->context, number);
    memory_free(b->context, halves);
    memory_free(b->context, fixed);
    return status;
}

pnb_status kinks_start(struct shadow_builder *b, struct shadow_plane *plane,
                       const struct light_shape *shape, const vec3 *corners, size_t corner_count,
                       const struct reach *region, const struct reach_foot *foot, struct tiling *m,
                       bool *out_kinks)
{
    double size = fmax((double)region->shadow_hi.x - region->shadow_lo.x,
                       (double)region->shadow_hi.y - region->shadow_lo.y);
    pnb_status status = PNB_OK;
    *out_kinks = true;
    for (int attempt = 0; attempt < 2 && !status; attempt++) {
        struct planar_input in = {0};
        struct planar_result r = {0};
        if (*out_kinks) {
            status = shadow_outlines(b, plane, shape, corners, corner_count);
            if (!status)
                status = add_outlines(b, BEND * size, &in);
            if (in.segment_count > POINTS_MAX) {
                in.segment_count = in.point_count = 0;
                *out_kinks = false;
            }
        }
        for (size_t i = 0; i < foot->count && !status; i++)
            status = add(b, &in, foot->ends[2 * i], foot->ends[2 * i + 1], FOOT);
        struct planar_point lo = region->lo, hi = region->hi;
        struct planar_point box[4] = {lo, {lo.x, hi.y}, hi, {hi.x, lo.y}};
        for (int i = 0; i < 4 && !status; i++)
            status = add(b, &in, box[i], box[(i + 1) % 4], BOX);
        struct planar_options options = {
            .triangulate = true, .min_level = BOX / 2, .max_level = INT32_MAX};
        if (!status)
            status = planar_sweep(b->workspace, in.points, in.point_count, in.segments,
                                  in.segment_count, &options, &r);
        planar_input_finish(b->context, &in);
        if (!status && *out_kinks && r.point_count > POINTS_MAX) {
            *out_kinks = false;
            continue;
        }
        if (!status) {
            planar_improve(b->workspace, &r,
                           &(struct planar_improve){.rule = PLANAR_RULE_DELAUNAY});
            status = take_over(b, &r, m);
        }
        break;
    }
    return status;
}
