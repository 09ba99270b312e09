/* method/planar/refine.c: a shadow mesh with a promised error.
 *
 * A Delaunay triangulation of the part of the plane that the shadow can reach starts as a plain
 * grid. Each new triangle is tested: the exact shadow at ten points of it against what its corners
 * interpolate to. Where the difference exceeds SAFETY x tolerance, the worst point becomes a vertex
 * (or the middle of the longest side, where the triangle is thin). In rounds: all tests of a round
 * are one call for visibility; a triangle that an insertion of the same round has changed waits for
 * the next. So triangles are few where the shadow is smooth.
 *
 * Where an occluder stands on the plane the shadow jumps along the line of contact. The outline of
 * its foot (its cross-section just above the plane) is kept as edges of the mesh; below the foot
 * the shadow is 1, outside each triangle has values of its own at points of the line, asked for a
 * little inside the triangle. Around a corner of the foot the shadow depends on the direction
 * alone, at any distance: refinement ends at SMALLEST of the shadow's size. Only closed occluders
 * have a foot. The part of the plane behind a one-sided light is treated like one.
 *
 * Coordinates are on the grid of planar/, insertion and in-circle test are exact. Cost: about 40
 * visibilities per triangle in the end. Deterministic.
 */
#include "method/planar/refine.h"

#define SAFETY         0.9
#define SMALLEST       (1.0 / 6000)
#define TESTS          10
#define ROUNDS_MAX     60
#define TRIANGLES_MAX  4000000
#define FOOT_EDGES_MAX 3000 /* more: no foot, the jump is refined like anything else */
#define NUDGE          0.02 /* of the way from a corner to the triangle's middle */

/* Where tests are made: weights of the three corners. */
static const double tests[TESTS][3] = {
    {1 / 3.0, 1 / 3.0, 1 / 3.0}, {0.5, 0.5, 0},      {0, 0.5, 0.5},      {0.5, 0, 0.5},
    {0.62, 0.19, 0.19},          {0.19, 0.62, 0.19}, {0.19, 0.19, 0.62}, {0.44, 0.44, 0.12},
    {0.12, 0.44, 0.44},          {0.44, 0.12, 0.44},
};

static struct planar_point test_point(const struct delaunay *m, const struct planar_triangle *t,
                                      int k)
{
    double x = 0, y = 0;
    for (int c = 0; c < 3; c++) {
        x += tests[k][c] * m->points[t->v[c]].x;
        y += tests[k][c] * m->points[t->v[c]].y;
    }
    return (struct planar_point){(int32_t)floor(x + 0.5), (int32_t)floor(y + 0.5)};
}

static double length2(struct planar_point a, struct planar_point b)
{
    double dx = (double)a.x - b.x, dy = (double)a.y - b.y;
    return dx * dx + dy * dy;
}

/* 1 - visibility at grid points. */
static pnb_status shadows(struct shadow_builder *b, const struct shadow_plane *plane,
                          const pnb_light *light, const struct planar_point *points, size_t count,
                          float *out)
{
    double *xy = memory_alloc(b->context, 2 * count, sizeof(*xy));
    if (!xy)
        return status_no_memory(b->context, 16 * count);
    for (size_t i = 0; i < count; i++) {
        xy[2 * i] = plane->center[0] + points[i].x / plane->scale;
        xy[2 * i + 1] = plane->center[1] + points[i].y / plane->scale;
    }
    double started = clock_ms();
    pnb_status status = shadow_truth(b, plane, light, xy, count, out);
    b->times.values_ms += clock_ms() - started;
    b->times.evaluations += count;
    for (size_t i = 0; i < count && !status; i++)
        out[i] = 1 - out[i];
    memory_free(b->context, xy);
    return status;
}

struct candidate {
    uint32_t triangle;
    struct planar_point p;
    float value;
};

/* A triangle under test: its points are TESTS (or none, where it is too small) and three nudged
 * corners (or none, where the shadow does not jump). */
struct trial {
    uint32_t triangle, first;
    bool tested, nudged;
};

struct refining {
    struct shadow_builder *b;
    struct shadow_plane *plane;
    const pnb_light *light;
    double tolerance, smallest; /* grid units */
    struct delaunay m;
    struct reach_foot foot;
    struct planar_point *points;
    struct trial *trials;
    float *found;
    struct candidate *candidates;
    size_t points_capacity, trial_capacity, found_capacity, candidate_capacity;
};

/* Collects the points that new triangles ask about. */
static pnb_status collect(struct refining *r, size_t *out_trials, size_t *out_points)
{
    struct delaunay *m = &r->m;
    size_t count = 0, points = 0;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        struct planar_triangle *t = &m->triangles[i];
        struct delaunay_corners *corner = &m->corners[i];
        if (t->level < 0)
            continue;
        t->level = -1;
        struct planar_point a = m->points[t->v[0]], b = m->points[t->v[1]], c = m->points[t->v[2]];
        double x = ((double)a.x + b.x + c.x) / 3, y = ((double)a.y + b.y + c.y) / 3;
        bool jumps = m->jump[t->v[0]] || m->jump[t->v[1]] || m->jump[t->v[2]];
        corner->inside = r->foot.count > 0 && reach_in_foot(&r->foot, x, y);
        if (corner->inside) {
            corner->value[0] = corner->value[1] = corner->value[2] = 1;
            continue;
        }
        double longest = fmax(length2(a, b), fmax(length2(b, c), length2(c, a)));
        struct trial trial = {i, (uint32_t)points, longest >= r->smallest * r->smallest, jumps};
        if (!trial.tested && !trial.nudged)
            continue;
        if (!memory_reserve(m->context, (void **)&r->points, &r->points_capacity, points, TESTS + 3,
                            sizeof(*r->points)) ||
            !memory_reserve(m->context, (void **)&r->trials, &r->trial_capacity, count, 1,
                            sizeof(*r->trials)))
            return status_no_memory(m->context, 0);
        for (int k = 0; k < TESTS && trial.tested; k++)
            r->points[points++] = test_point(m, t, k);
        for (int k = 0; k < 3 && trial.nudged; k++) {
            struct planar_point p = m->points[t->v[k]];
            r->points[points++] = (struct planar_point){p.x + (int32_t)(NUDGE * (x - p.x)),
                                                        p.y + (int32_t)(NUDGE * (y - p.y))};
        }
        r->trials[count++] = trial;
    }
    *out_trials = count;
    *out_points = points;
    return PNB_OK;
}

/* Corner values where the shadow jumps; the worst point of each triangle that is off. */
static size_t judge(struct refining *r, size_t trials)
{
    struct delaunay *m = &r->m;
    size_t wanted = 0;
    for (size_t i = 0; i < trials; i++) {
        const struct trial *trial = &r->trials[i];
        const struct planar_triangle *t = &m->triangles[trial->triangle];
        struct delaunay_corners *corner = &m->corners[trial->triangle];
        const float *found = r->found + trial->first;
        for (int k = 0; k < 3 && trial->nudged; k++)
            if (m->jump[t->v[k]])
                corner->value[k] = found[(trial->tested ? TESTS : 0) + k];
        if (!trial->tested)
            continue;
        double worst = 0;
        int at = 0;
        for (int k = 0; k < TESTS; k++) {
            /* The middle of a side on the foot's line has two values. */
            if (k >= 1 && k <= 3 && (corner->fixed >> (k - 1) & 1))
                continue;
            double linear = 0;
            for (int c = 0; c < 3; c++)
                linear += tests[k][c] * corner->value[c];
            double error = fabs(linear - found[k]);
            if (error > worst) {
                worst = error;
                at = k;
            }
        }
        if (worst <= SAFETY * r->tolerance)
            continue;
        /* Thin triangles: the middle of the longest side. */
        double l[3];
        int longest = 0;
        for (int k = 0; k < 3; k++) {
            l[k] = length2(m->points[t->v[k]], m->points[t->v[(k + 1) % 3]]);
            longest = l[k] > l[longest] ? k : longest;
        }
        double area =
            (double)planar_orient(m->points[t->v[0]], m->points[t->v[1]], m->points[t->v[2]]);
        if (area < 0.4 * l[longest])
            at = 1 + longest;
        r->candidates[wanted++] =
            (struct candidate){trial->triangle, r->points[trial->first + (size_t)at], found[at]};
    }
    return wanted;
}

static pnb_status refine(struct refining *r)
{
    struct delaunay *m = &r->m;
    pnb_status status = shadows(r->b, r->plane, r->light, m->points, m->point_count, m->values);
    for (size_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            m->corners[i].value[k] = m->values[m->triangles[i].v[k]];
    for (int round = 0; round < ROUNDS_MAX && !status; round++) {
        size_t trials = 0, points = 0;
        status = collect(r, &trials, &points);
        if (status || trials == 0 || m->triangle_count > TRIANGLES_MAX)
            break;
        if (!memory_reserve(m->context, (void **)&r->found, &r->found_capacity, 0, points,
                            sizeof(*r->found)) ||
            !memory_reserve(m->context, (void **)&r->candidates, &r->candidate_capacity, 0, trials,
                            sizeof(*r->candidates)))
            return status_no_memory(m->context, 0);
        status = shadows(r->b, r->plane, r->light, r->points, points, r->found);
        if (status)
            break;
        size_t wanted = judge(r, trials);
        for (size_t i = 0; i < wanted && !m->no_memory; i++) {
            int side;
            uint32_t t = delaunay_find(m, r->candidates[i].p, r->candidates[i].triangle, &side);
            if (t != PLANAR_NONE && m->triangles[t].level < 0)
                delaunay_insert(m, r->candidates[i].p, r->candidates[i].value, t, side);
        }
        if (m->no_memory)
            return status_no_memory(m->context, 0);
    }
    return status;
}

static pnb_status copy_out(const struct delaunay *m, const struct shadow_plane *plane,
                           struct shadow_part *part)
{
    if (!memory_reserve(m->context, (void **)&part->points, &part->point_capacity, 0,
                        m->point_count, 2 * sizeof(*part->points)) ||
        !memory_reserve(m->context, (void **)&part->triangles, &part->triangle_capacity, 0,
                        m->triangle_count, sizeof(*part->triangles)))
        return status_no_memory(m->context, m->point_count * 16);
    for (size_t i = 0; i < m->point_count; i++) {
        part->points[2 * i] = plane->center[0] + m->points[i].x / plane->scale;
        part->points[2 * i + 1] = plane->center[1] + m->points[i].y / plane->scale;
    }
    part->point_count = m->point_count;
    for (size_t i = 0; i < m->triangle_count; i++) {
        const struct planar_triangle *t = &m->triangles[i];
        const float *v = m->corners[i].value;
        if (v[0] != 0 || v[1] != 0 || v[2] != 0)
            part->triangles[part->triangle_count++] =
                (struct shadow_triangle){{t->v[0], t->v[1], t->v[2]}, {v[0], v[1], v[2]}, -1};
    }
    return PNB_OK;
}

pnb_status shadow_refine(struct shadow_builder *b, struct shadow_plane *plane,
                         const pnb_light *light, const struct shadow_settings *settings,
                         struct shadow_part *part)
{
    pnb_context *context = b->context;
    struct refining r = {.b = b, .plane = plane, .light = light, .tolerance = settings->tolerance};
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
    r.m.context = context;
    status = shadow_clusters(context, &shape, &clusters, &cluster_count);
    double far = 1e6 * fmax(plane->hi[0] - plane->lo[0], plane->hi[1] - plane->lo[1]);
    if (!status && reach_find_region(plane, clusters, cluster_count, &shape, far, &region)) {
        r.smallest = SMALLEST * fmax((double)region.shadow_hi.x - region.shadow_lo.x,
                                     (double)region.shadow_hi.y - region.shadow_lo.y);
        delaunay_start(&r.m, region.lo, region.hi);
        delaunay_add_grid(&r.m, region.shadow_lo, region.shadow_hi, region.start);
        status = reach_find_foot(b, plane, &region, &r.foot);
        if (r.foot.count > FOOT_EDGES_MAX)
            r.foot.count = 0;
        for (size_t i = 0; i < r.foot.count && !status; i++)
            delaunay_force_edge(&r.m, delaunay_add_point(&r.m, r.foot.ends[2 * i]),
                                delaunay_add_point(&r.m, r.foot.ends[2 * i + 1]), 0);
        if (!status && r.m.no_memory)
            status = status_no_memory(context, 0);
        if (!status)
            status = refine(&r);
        if (!status)
            status = copy_out(&r.m, plane, part);
    }
    void *blocks[] = {r.m.points, r.m.values, r.m.jump, r.m.triangles, r.m.corners, r.m.stack,
                      r.points,   r.trials,   r.found,  r.candidates,  r.foot.ends, clusters};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(context, blocks[i]);
    light_shape_finish(context, &shape);
    return status;
}
