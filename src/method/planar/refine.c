/* method/planar/refine.c: a shadow mesh with a promised error.
 *
 * A triangulation of the part of the plane that the shadow can reach (tiling.c) starts from the
 * shadow's kinks or from a plain grid (kinks.c). Every triangle must have samples of the exact
 * shadow all over: in each of its ninths at least one. Where a sample is off by more than SAFETY x
 * tolerance it becomes a vertex, diagonals are exchanged, and the triangles that have changed are
 * looked at again. In rounds: all that a round asks about is one call for visibility, and samples
 * stay with the triangles that come to hold them. Then vertices that are not needed go
 * (decimate.c), and what that has changed is looked at again.
 *
 * Where an occluder stands on the plane the shadow jumps along the line of contact. The outline of
 * its foot (its cross-section just above the plane) is kept as sides of the mesh; below the foot
 * the shadow is 1, outside each triangle has values of its own at points of the line. Around a
 * corner of the foot the shadow depends on the direction alone, at any distance: refinement ends at
 * SMALLEST of the shadow's size. Only closed occluders have a foot. The part of the plane behind a
 * one-sided light is treated like one.
 *
 * Cost: some 15 visibilities per triangle in the end. Deterministic.
 */
#include <stdlib.h>

#include "method/planar/refine.h"

#define SAFETY        0.75
#define SMALLEST      (1.0 / 8000)
#define CELLS         9   /* each triangle has a sample in each of its ninths */
#define SAMPLES_LEAST 5   /* with fewer a triangle is not split: first more samples */
#define KEEP_SLACK    0.6 /* a kept mesh loses vertices only where this much of the limit is kept */
#define KEEP_GROWTH   1.5 /* a kept mesh that has grown this much is made anew */
#define KEEP_ROOM     0.25 /* of the reach: by how much more a kept mesh covers */
#define ROUNDS_MAX    40
#define TRIANGLES_MAX 400000

struct wanted {
    struct planar_point p;
    uint32_t tile; /* or what else it is wanted for */
};

struct refining {
    struct shadow_builder *b;
    struct shadow_plane *plane;
    const pnb_light *light;
    double tolerance, smallest; /* grid units */
    struct tiling *m;
    struct wanted *wanted;
    float *found;
    size_t wanted_count, wanted_capacity, found_capacity;
};

/* [0, 1), the same numbers on every run. */
static double dice(struct refining *r)
{
    r->m->random += 0x9e3779b97f4a7c15ull;
    uint64_t z = r->m->random;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static pnb_status want(struct refining *r, struct planar_point p, uint32_t tile)
{
    if (!memory_reserve(r->b->context, (void **)&r->wanted, &r->wanted_capacity, r->wanted_count, 1,
                        sizeof(*r->wanted)))
        return status_no_memory(r->b->context, 0);
    r->wanted[r->wanted_count++] = (struct wanted){p, tile};
    return PNB_OK;
}

/* 1 - visibility at the wanted points to r->found. */
static pnb_status evaluate(struct refining *r)
{
    struct shadow_builder *b = r->b;
    const struct shadow_plane *plane = r->plane;
    size_t count = r->wanted_count;
    double *xy = memory_alloc(b->context, 2 * count + 1, sizeof(*xy));
    bool room = memory_reserve(b->context, (void **)&r->found, &r->found_capacity, 0, count,
                               sizeof(*r->found));
    if (!xy || !room) {
        memory_free(b->context, xy);
        return status_no_memory(b->context, 16 * count);
    }
    for (size_t i = 0; i < count; i++) {
        xy[2 * i] = plane->center[0] + r->wanted[i].p.x / plane->scale;
        xy[2 * i + 1] = plane->center[1] + r->wanted[i].p.y / plane->scale;
    }
    double started = clock_ms();
    pnb_status status = PNB_OK;
    if (count > 0)
        status = shadow_truth(b, plane, r->light, xy, count, r->found);
    b->times.values_ms += clock_ms() - started;
    b->times.evaluations += count;
    for (size_t i = 0; i < count && !status; i++)
        r->found[i] = 1 - r->found[i];
    memory_free(b->context, xy);
    return status;
}

static bool too_small(const struct refining *r, const struct tiling_tile *t)
{
    const struct tiling_vertex *v = r->m->vertices;
    return (double)planar_orient(v[t->v[0]].p, v[t->v[1]].p, v[t->v[2]].p) <
           r->smallest * r->smallest;
}

/* Which ninth of a triangle a point with weights w lies in. */
static int cell_of(const double *w)
{
    int i = (int)fmin(2, 3 * w[0]), j = (int)fmin(2, 3 * w[1]), k = (int)fmin(2, 3 * w[2]);
    /* i + j + k is 2 in upright ninths, 1 in the others. */
    static const int upright[3][3] = {{0, 1, 2}, {3, 4, 0}, {5, 0, 0}};
    if (i + j + k >= 2)
        return i + j <= 2 ? upright[i][j] : 5;
    return i == 1 ? 6 : j == 1 ? 7 : 8;
}

/* A random point of a ninth. */
static void point_in_cell(struct refining *r, int cell, double *w)
{
    static const int at[9][3] = {{0, 0, 2}, {0, 1, 1}, {0, 2, 0}, {1, 0, 1}, {1, 1, 0},
                                 {2, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double a = dice(r), b = dice(r);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    double c[3] = {a, b, 1 - a - b};
    for (int k = 0; k < 3; k++)
        w[k] = (at[cell][k] + (cell < 6 ? c[k] : 1 - c[k])) / 3;
}

/* Which flank of a corner a point near it lies on: 0, 1, or -1. Around a corner that jumps the
 * shadow depends on the direction. */
static int flank_of(const double *w, int corner)
{
    double a = w[(corner + 1) % 3], b = w[(corner + 2) % 3];
    if (w[corner] < 2 / 3.0)
        return -1;
    return a > 3 * b ? 0 : b > 3 * a ? 1 : -1;
}

static void point_at_flank(struct refining *r, int corner, int flank, double *w)
{
    double rest = 0.05 + 0.25 * dice(r), side = 0.85 + 0.12 * dice(r);
    w[corner] = 1 - rest;
    w[(corner + 1) % 3] = rest * (flank ? 1 - side : side);
    w[(corner + 2) % 3] = rest * (flank ? side : 1 - side);
}

static pnb_status want_in(struct refining *r, uint32_t tile, const struct planar_point *p,
                          const double *w)
{
    double x = 0, y = 0;
    for (int k = 0; k < 3; k++) {
        x += w[k] * p[k].x;
        y += w[k] * p[k].y;
    }
    struct planar_point q = {(int32_t)floor(x + 0.5), (int32_t)floor(y + 0.5)};
    if (planar_orient(p[0], p[1], q) > 0 && planar_orient(p[1], p[2], q) > 0 &&
        planar_orient(p[2], p[0], q) > 0)
        return want(r, q, tile);
    return PNB_OK;
}

/* Asks for samples in every ninth of a changed triangle that has none, and on the flanks of corners
 * that jump. */
static pnb_status collect(struct refining *r)
{
    struct tiling *m = r->m;
    pnb_status status = PNB_OK;
    r->wanted_count = 0;
    for (uint32_t i = 0; i < m->tile_count && !status; i++) {
        struct tiling_tile *t = &m->tiles[i];
        if (t->v[0] == PLANAR_NONE || !t->stale)
            continue;
        t->stale = false;
        if (t->inside || too_small(r, t))
            continue;
        struct planar_point p[3];
        for (int k = 0; k < 3; k++)
            p[k] = m->vertices[t->v[k]].p;
        double area = (double)planar_orient(p[0], p[1], p[2]), w[3];
        unsigned seen = 0, flanks = 0;
        for (uint32_t s = t->first; s != PLANAR_NONE; s = m->samples[s].next) {
            struct planar_point q = m->samples[s].p;
            for (int k = 0; k < 3; k++)
                w[k] = (double)planar_orient(p[(k + 1) % 3], p[(k + 2) % 3], q) / area;
            seen |= 1u << cell_of(w);
            for (int k = 0; k < 3; k++) {
                int flank = flank_of(w, k);
                flanks |= flank < 0 ? 0 : 1u << (2 * k + flank);
            }
        }
        for (int f = 0; f < 6 && !status; f++) {
            if (!m->vertices[t->v[f / 2]].jump || (flanks >> f & 1))
                continue;
            point_at_flank(r, f / 2, f % 2, w);
            seen |= 1u << cell_of(w);
            status = want_in(r, i, p, w);
        }
        for (int cell = 0; cell < CELLS && !status; cell++) {
            if (seen >> cell & 1)
                continue;
            point_in_cell(r, cell, w);
            status = want_in(r, i, p, w);
        }
    }
    return status;
}

/* Hands the evaluated points to their triangles. */
static void deal(struct refining *r)
{
    struct tiling *m = r->m;
    for (size_t i = 0; i < r->wanted_count; i++)
        tiling_add_sample(m, r->wanted[i].p, r->found[i], r->wanted[i].tile);
    for (size_t i = 0; i < r->wanted_count && !m->no_memory; i++) {
        uint32_t t = r->wanted[i].tile;
        if (i > 0 && t == r->wanted[i - 1].tile)
            continue;
        tiling_measure(m, t);
        tiling_push_tile(m, t);
    }
    tiling_exchange(m);
}

/* Splits a triangle at its worst sample, or a fixed side of it that the sample lies beside. */
static void split(struct refining *r, uint32_t i)
{
    struct tiling *m = r->m;
    struct tiling_tile *t = &m->tiles[i];
    struct planar_point p[3];
    for (int k = 0; k < 3; k++)
        p[k] = m->vertices[t->v[k]].p;
    double area = (double)planar_orient(p[0], p[1], p[2]), worst = -1;
    uint32_t at = PLANAR_NONE;
    double weights[3] = {0};
    for (uint32_t s = t->first; s != PLANAR_NONE; s = m->samples[s].next) {
        struct planar_point q = m->samples[s].p;
        double w[3] = {(double)planar_orient(p[1], p[2], q) / area,
                       (double)planar_orient(p[2], p[0], q) / area,
                       (double)planar_orient(p[0], p[1], q) / area};
        double e = fabs(w[0] * t->value[0] + w[1] * t->value[1] + w[2] * t->value[2] -
                        m->samples[s].truth);
        if (e > worst) {
            worst = e;
            at = s;
            for (int k = 0; k < 3; k++)
                weights[k] = w[k];
        }
    }
    struct tiling_sample sample = m->samples[at];
    for (int k = 0; k < 3; k++) {
        if (!(t->fixed >> k & 1) || weights[(k + 2) % 3] > 0.15)
            continue;
        struct planar_point a = p[k], b = p[(k + 1) % 3];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
        double f = (((double)sample.p.x - a.x) * dx + ((double)sample.p.y - a.y) * dy) /
                   (dx * dx + dy * dy);
        f = fmin(0.9, fmax(0.1, f));
        if (dx * dx + dy * dy < r->smallest * r->smallest)
            continue;
        struct planar_point q = {(int32_t)floor(a.x + f * dx + 0.5),
                                 (int32_t)floor(a.y + f * dy + 0.5)};
        if (tiling_split_side(m, q, 1, i, k) != PLANAR_NONE) {
            tiling_exchange(m);
            return;
        }
    }
    tiling_drop_sample(m, i, at);
    uint32_t before = (uint32_t)m->vertex_count;
    if (tiling_insert(m, sample.p, sample.truth, i) != before)
        tiling_measure(m, i);
    tiling_exchange(m);
}

struct rank {
    float error;
    uint32_t tile;
};

static int by_error(const void *a, const void *b)
{
    const struct rank *x = a, *y = b;
    if (x->error != y->error)
        return x->error > y->error ? -1 : 1;
    return (x->tile > y->tile) - (x->tile < y->tile);
}

static bool splits(const struct refining *r, uint32_t i)
{
    const struct tiling_tile *t = &r->m->tiles[i];
    return t->v[0] != PLANAR_NONE && t->error > SAFETY * r->tolerance &&
           t->count >= SAMPLES_LEAST && !too_small(r, t);
}

/* Splits what is off, worst first, as long as the samples there are suffice. */
static pnb_status split_all(struct refining *r)
{
    struct tiling *m = r->m;
    for (int pass = 0; pass < 8 && !m->no_memory; pass++) {
        struct rank *ranks = memory_alloc(m->context, m->tile_count, sizeof(*ranks));
        if (!ranks)
            return status_no_memory(m->context, m->tile_count * sizeof(*ranks));
        size_t count = 0;
        for (uint32_t i = 0; i < m->tile_count; i++)
            if (splits(r, i))
                ranks[count++] = (struct rank){m->tiles[i].error, i};
        qsort(ranks, count, sizeof(*ranks), by_error);
        for (size_t i = 0; i < count && !m->no_memory; i++)
            if (splits(r, ranks[i].tile) && m->tiles[ranks[i].tile].error >= 0.5 * ranks[i].error)
                split(r, ranks[i].tile);
        memory_free(m->context, ranks);
        if (count == 0)
            break;
    }
    return m->no_memory ? status_no_memory(m->context, 0) : PNB_OK;
}

static pnb_status rounds(struct refining *r)
{
    struct tiling *m = r->m;
    pnb_status status = PNB_OK;
    for (int round = 0; round < ROUNDS_MAX && !status; round++) {
        status = collect(r);
        if (!status && r->wanted_count == 0)
            break;
        if (!status)
            status = evaluate(r);
        if (status)
            break;
        deal(r);
        status = split_all(r);
        if (m->tile_count - m->free_tile_count > TRIANGLES_MAX) {
            r->b->times.unfinished = true;
            break;
        }
    }
    return status;
}

/* The corners of all of the light, plane space. */
static pnb_status light_corners(const struct refining *r, const struct shadow_cluster *clusters,
                                size_t count, double far, vec3 **out, size_t *out_count)
{
    enum { per_cluster = 16 };
    vec3 *corners = memory_alloc(r->b->context, per_cluster * count, sizeof(*corners));
    *out = corners;
    *out_count = 0;
    if (!corners)
        return status_no_memory(r->b->context, per_cluster * count * sizeof(*corners));
    for (size_t c = 0; c < count; c++) {
        vec3 p[per_cluster];
        int n = shadow_corners(&clusters[c], r->plane->frame.origin, far, per_cluster, p);
        for (int i = 0; i < n; i++) {
            vec3 q = silhouette_to_plane(&r->plane->frame, p[i]);
            bool known = false; /* pieces of a polygon share corners */
            for (size_t k = 0; k < *out_count; k++)
                known |= corners[k].x == q.x && corners[k].y == q.y && corners[k].z == q.z;
            if (!known)
                corners[(*out_count)++] = q;
        }
    }
    return PNB_OK;
}

static void add_grid(struct refining *r, const struct reach *region)
{
    struct tiling *m = r->m;
    double w = (double)region->shadow_hi.x - region->shadow_lo.x,
           h = (double)region->shadow_hi.y - region->shadow_lo.y;
    int cells = region->start;
    int nx = (int)fmax(2, w > h ? cells : cells * w / h + 0.5);
    int ny = (int)fmax(2, w > h ? cells * h / w + 0.5 : cells);
    uint32_t at = 0;
    for (int j = 0; j <= ny; j++)
        for (int i = 0; i <= nx; i++) {
            struct planar_point p = {region->shadow_lo.x + (int32_t)(w * i / nx),
                                     region->shadow_lo.y + (int32_t)(h * j / ny)};
            uint32_t t = tiling_find(m, p, at);
            if (t == PLANAR_NONE)
                continue;
            tiling_insert(m, p, 0, at = t);
            tiling_exchange(m);
        }
}

static pnb_status start(struct refining *r, const struct reach *region,
                        const struct light_shape *shape, const struct shadow_cluster *clusters,
                        size_t cluster_count, double far)
{
    struct tiling *m = r->m;
    struct reach_foot foot = {0};
    vec3 *corners = NULL;
    size_t corner_count = 0;
    bool kinks = false;
    pnb_status status = reach_find_foot(r->b, r->plane, region, &foot);
    if (!status)
        status = light_corners(r, clusters, cluster_count, far, &corners, &corner_count);
    if (!status)
        status =
            kinks_start(r->b, r->plane, shape, corners, corner_count, region, &foot, m, &kinks);
    memory_free(r->b->context, foot.ends);
    memory_free(r->b->context, corners);
    for (uint32_t i = 0; i < m->tile_count && !status; i++)
        tiling_measure(m, i);
    if (!status && !kinks)
        add_grid(r, region);
    if (m->no_memory)
        return status_no_memory(m->context, 0);
    r->wanted_count = 0;
    for (uint32_t v = 0; v < m->vertex_count && !status; v++)
        status = want(r, m->vertices[v].p, PLANAR_NONE);
    if (!status)
        status = evaluate(r);
    for (uint32_t v = 0; v < m->vertex_count && !status; v++)
        m->vertices[v].truth = m->vertices[v].value = r->found[v];
    for (uint32_t i = 0; i < m->tile_count && !status; i++) {
        tiling_measure(m, i);
        m->tiles[i].stale = true;
    }
    return status;
}

static pnb_status refine(struct refining *r)
{
    double limit = SAFETY * r->tolerance;
    pnb_status status = rounds(r);
    for (int i = 0; i < 2 && !status; i++) {
        for (int k = 0; k < 2 && i == 0; k++)
            tiling_fit(r->m, limit);
        tiling_decimate(r->m, limit);
        for (int k = 0; k < 2 - i; k++)
            tiling_fit(r->m, limit);
        status = rounds(r);
    }
    return status;
}

/* Samples that a kept mesh can do without: those of a ninth, or a flank, that has others. */
static void thin_samples(struct refining *r)
{
    struct tiling *m = r->m;
    for (uint32_t i = 0; i < m->tile_count; i++) {
        struct tiling_tile *t = &m->tiles[i];
        if (t->v[0] == PLANAR_NONE || t->count <= CELLS)
            continue;
        struct planar_point p[3];
        for (int k = 0; k < 3; k++)
            p[k] = m->vertices[t->v[k]].p;
        double area = (double)planar_orient(p[0], p[1], p[2]), w[3];
        unsigned seen = 0;
        for (uint32_t s = t->first, next; s != PLANAR_NONE; s = next) {
            next = m->samples[s].next;
            for (int k = 0; k < 3; k++)
                w[k] =
                    (double)planar_orient(p[(k + 1) % 3], p[(k + 2) % 3], m->samples[s].p) / area;
            unsigned bits = 1u << cell_of(w);
            for (int k = 0; k < 3; k++)
                if (m->vertices[t->v[k]].jump && flank_of(w, k) >= 0)
                    bits = 1u << (CELLS + 2 * k + flank_of(w, k));
            if (seen & bits)
                tiling_drop_sample(m, i, s);
            seen |= bits;
        }
    }
}

/* The last frame's mesh under this frame's light: all that it knows is asked for anew; triangles
 * that are off are split, vertices that are clearly not needed go. */
static pnb_status go_on(struct refining *r)
{
    struct tiling *m = r->m;
    double limit = SAFETY * r->tolerance;
    pnb_status status = PNB_OK;
    thin_samples(r);
    r->wanted_count = 0;
    for (uint32_t v = 0; v < m->vertex_count && !status; v++)
        if (m->vertices[v].tile != PLANAR_NONE)
            status = want(r, m->vertices[v].p, v);
    size_t vertices = r->wanted_count;
    for (uint32_t i = 0; i < m->tile_count && !status; i++)
        for (uint32_t s = m->tiles[i].first; s != PLANAR_NONE && !status; s = m->samples[s].next)
            status = want(r, m->samples[s].p, s);
    if (!status)
        status = evaluate(r);
    if (status)
        return status;
    for (size_t i = 0; i < r->wanted_count; i++) {
        uint32_t index = r->wanted[i].tile;
        if (i >= vertices) {
            m->samples[index].truth = r->found[i];
            continue;
        }
        /* The fit's share is kept, but in the umbra and where all is lit. */
        struct tiling_vertex *v = &m->vertices[index];
        double value = (double)v->value - v->truth + r->found[i];
        bool even = r->found[i] <= 0 || r->found[i] >= 1;
        v->truth = r->found[i];
        v->value = even ? v->truth : (float)fmin(1, fmax(0, value));
    }
    for (uint32_t i = 0; i < m->tile_count && !m->no_memory; i++) {
        if (m->tiles[i].v[0] == PLANAR_NONE)
            continue;
        tiling_measure(m, i);
        m->tiles[i].stale = true;
        if (m->tiles[i].error > limit)
            tiling_push_tile(m, i);
    }
    tiling_exchange(m);
    status = rounds(r);
    if (!status) {
        tiling_decimate(m, KEEP_SLACK * limit);
        status = rounds(r);
    }
    return status;
}

/* Whether the mesh of the last frame will do for this one. */
static bool can_go_on(const struct tiling *kept, const struct reach *region)
{
    return kept && kept->tile_count > 0 && (region->dark_count == 0 || region->dark_apart) &&
           region->lo.x >= kept->lo.x && region->lo.y >= kept->lo.y && region->hi.x <= kept->hi.x &&
           region->hi.y <= kept->hi.y &&
           (double)(kept->tile_count - kept->free_tile_count) <
               KEEP_GROWTH * (double)kept->tiles_at_start;
}

/* Room for the shadow to move. */
static void widen(const struct shadow_plane *plane, struct reach *region)
{
    double more =
        KEEP_ROOM * fmax((double)region->hi.x - region->lo.x, (double)region->hi.y - region->lo.y);
    double lo[2], hi[2];
    for (int axis = 0; axis < 2; axis++) {
        lo[axis] = (plane->lo[axis] - plane->center[axis]) * plane->scale;
        hi[axis] = (plane->hi[axis] - plane->center[axis]) * plane->scale;
    }
    region->lo.x = (int32_t)fmax(ceil(lo[0]), region->lo.x - more);
    region->lo.y = (int32_t)fmax(ceil(lo[1]), region->lo.y - more);
    region->hi.x = (int32_t)fmin(floor(hi[0]), region->hi.x + more);
    region->hi.y = (int32_t)fmin(floor(hi[1]), region->hi.y + more);
}

void shadow_forget_kept(pnb_context *context, struct shadow_plane *plane)
{
    if (plane->kept)
        tiling_finish(plane->kept);
    memory_free(context, plane->kept);
    plane->kept = NULL;
}

static pnb_status copy_out(const struct tiling *m, const struct shadow_plane *plane,
                           const struct reach *region, struct shadow_part *part)
{
    size_t more = region->dark_apart ? (size_t)region->dark_count : 0;
    if (!memory_reserve(m->context, (void **)&part->points, &part->point_capacity, 0,
                        m->vertex_count + more, 2 * sizeof(*part->points)) ||
        !memory_reserve(m->context, (void **)&part->triangles, &part->triangle_capacity, 0,
                        m->tile_count + more, sizeof(*part->triangles)))
        return status_no_memory(m->context, m->vertex_count * 16);
    for (size_t i = 0; i < m->vertex_count + more; i++) {
        struct planar_point p =
            i < m->vertex_count ? m->vertices[i].p : region->dark[i - m->vertex_count];
        part->points[2 * i] = plane->center[0] + p.x / plane->scale;
        part->points[2 * i + 1] = plane->center[1] + p.y / plane->scale;
    }
    part->point_count = m->vertex_count + more;
    for (size_t i = 0; i < m->tile_count; i++) {
        const struct tiling_tile *t = &m->tiles[i];
        const float *v = t->value;
        if (t->v[0] != PLANAR_NONE && (v[0] != 0 || v[1] != 0 || v[2] != 0))
            part->triangles[part->triangle_count++] =
                (struct shadow_triangle){{t->v[0], t->v[1], t->v[2]}, {v[0], v[1], v[2]}, -1};
    }
    /* The dark side, a convex polygon. */
    uint32_t first = (uint32_t)m->vertex_count;
    for (uint32_t i = 1; i + 1 < more; i++) {
        struct shadow_triangle t = {{first, first + i, first + i + 1}, {1, 1, 1}, -1};
        int64_t turn = planar_orient(region->dark[0], region->dark[i], region->dark[i + 1]);
        if (turn < 0)
            t = (struct shadow_triangle){{first, first + i + 1, first + i}, {1, 1, 1}, -1};
        if (turn != 0)
            part->triangles[part->triangle_count++] = t;
    }
    return PNB_OK;
}

pnb_status shadow_refine(struct shadow_builder *b, struct shadow_plane *plane,
                         const pnb_light *light, const struct shadow_settings *settings,
                         struct shadow_part *part)
{
    pnb_context *context = b->context;
    struct tiling mesh = {.context = context};
    struct refining r = {
        .b = b, .plane = plane, .light = light, .tolerance = settings->tolerance, .m = &mesh};
    struct light_shape shape;
    struct shadow_cluster *clusters = NULL;
    size_t cluster_count = 0;
    struct reach region;
    part->point_count = part->triangle_count = part->edge_count = 0;
    part->rings = 0;
    part->weight = 1;
    part->origin[0] = plane->center[0];
    part->origin[1] = plane->center[1];
    part->scale = plane->scale;
    pnb_status status = light_shape_init(context, light, &shape);
    if (status)
        return status;
    status = shadow_clusters(context, &shape, &clusters, &cluster_count);
    double far = 1e6 * fmax(plane->hi[0] - plane->lo[0], plane->hi[1] - plane->lo[1]);
    if (!status && reach_find_region(plane, clusters, cluster_count, &shape, far, &region)) {
        r.smallest = SMALLEST * fmax((double)region.shadow_hi.x - region.shadow_lo.x,
                                     (double)region.shadow_hi.y - region.shadow_lo.y);
        bool on = settings->keep && can_go_on(plane->kept, &region);
        if (settings->keep && !on) {
            shadow_forget_kept(context, plane);
            plane->kept = memory_calloc(context, 1, sizeof(*plane->kept));
            if (!plane->kept)
                status = status_no_memory(context, sizeof(*plane->kept));
            else
                *plane->kept = mesh;
            widen(plane, &region);
        }
        if (settings->keep && plane->kept)
            r.m = plane->kept;
        r.m->tolerance = settings->tolerance;
        r.m->thin2 = r.smallest * r.smallest / 4096;
        if (!status && on) {
            status = go_on(&r);
        } else if (!status) {
            status = start(&r, &region, &shape, clusters, cluster_count, far);
            if (!status)
                status = refine(&r);
            r.m->lo = region.lo;
            r.m->hi = region.hi;
            r.m->tiles_at_start = r.m->tile_count - r.m->free_tile_count;
        }
        if (!status)
            status = copy_out(r.m, plane, &region, part);
    }
    if (status)
        shadow_forget_kept(context, plane);
    tiling_finish(&mesh);
    void *blocks[] = {r.wanted, r.found, clusters};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(context, blocks[i]);
    light_shape_finish(context, &shape);
    return status;
}
