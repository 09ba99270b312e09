/* planar/public.c: the sweep for the outside (include/penumbra/planar.h): doubles to grid and back.
 */
#include <penumbra/planar.h>

#include <math.h>

#include "planar/inside.h"

struct pnb_planar {
    pnb_context *context;
    struct planar_workspace *workspace;
    struct planar_input input;
    struct planar_result result;
    struct planar_chains chains;
    double center[2], step; /* input = center + step x grid */
    double *points;
    pnb_planar_edge *edges;
    uint32_t *triangles;
    int32_t *levels;
    pnb_planar_trapezoid *trapezoids;
    size_t point_capacity, edge_capacity, triangle_capacity, level_capacity, trapezoid_capacity;
};

pnb_status pnb_planar_create(pnb_context *context, pnb_planar **out_planar)
{
    pnb_planar *p = memory_calloc(context, 1, sizeof(*p));
    *out_planar = NULL;
    if (!p)
        return status_no_memory(context, sizeof(*p));
    p->context = context;
    pnb_status status = planar_workspace_create(context, &p->workspace);
    if (status) {
        memory_free(context, p);
        return status;
    }
    *out_planar = p;
    return PNB_OK;
}

void pnb_planar_destroy(pnb_planar *p)
{
    if (!p)
        return;
    planar_workspace_destroy(p->workspace);
    planar_input_finish(p->context, &p->input);
    planar_chains_finish(p->context, &p->chains);
    void *blocks[] = {p->points, p->edges, p->triangles, p->levels, p->trapezoids};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(p->context, blocks[i]);
    memory_free(p->context, p);
}

static pnb_status read_input(pnb_planar *p, const pnb_planar_desc *desc)
{
    struct planar_input *in = &p->input;
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < 2 * desc->point_count; i++) {
        double x = desc->points[i];
        if (!isfinite(x))
            return status_fail(p->context, PNB_ERROR_ARGUMENT, "planar sweep",
                               "point %zu is not finite", i / 2);
        lo[i % 2] = fmin(lo[i % 2], x);
        hi[i % 2] = fmax(hi[i % 2], x);
    }
    double half = 0;
    for (int k = 0; k < 2 && desc->point_count > 0; k++) {
        p->center[k] = 0.5 * lo[k] + 0.5 * hi[k];
        half = fmax(half, 0.5 * hi[k] - 0.5 * lo[k]);
    }
    p->step = half > 0 ? half / (PLANAR_LIMIT - 1) : 1;
    in->point_count = in->segment_count = 0;
    pnb_status status = planar_input_reserve(p->context, in, desc->point_count, desc->edge_count);
    for (size_t i = 0; i < desc->point_count && !status; i++) {
        int32_t at[2];
        for (int k = 0; k < 2; k++)
            at[k] = (int32_t)floor((desc->points[2 * i + k] - p->center[k]) / p->step + 0.5);
        in->points[in->point_count++] = (struct planar_point){at[0], at[1]};
    }
    for (size_t i = 0; i < desc->edge_count && !status; i++)
        in->segments[in->segment_count++] = (struct planar_segment){
            desc->edges[2 * i], desc->edges[2 * i + 1], desc->weights ? desc->weights[i] : 1};
    return status;
}

static double height_at(const struct planar_result *r, uint32_t edge, double x)
{
    struct planar_point a = r->points[r->edges[edge].left], b = r->points[r->edges[edge].right];
    return a.y + ((double)b.y - a.y) * ((x - a.x) / ((double)b.x - a.x));
}

static pnb_status write_output(pnb_planar *p)
{
    const struct planar_result *r = &p->result;
    if (!memory_reserve(p->context, (void **)&p->points, &p->point_capacity, 0, r->point_count,
                        2 * sizeof(*p->points)) ||
        !memory_reserve(p->context, (void **)&p->edges, &p->edge_capacity, 0, r->edge_count,
                        sizeof(*p->edges)) ||
        !memory_reserve(p->context, (void **)&p->triangles, &p->triangle_capacity, 0,
                        r->triangle_count, 3 * sizeof(*p->triangles)) ||
        !memory_reserve(p->context, (void **)&p->levels, &p->level_capacity, 0, r->triangle_count,
                        sizeof(*p->levels)) ||
        !memory_reserve(p->context, (void **)&p->trapezoids, &p->trapezoid_capacity, 0,
                        r->trapezoid_count, sizeof(*p->trapezoids)))
        return status_no_memory(p->context, r->point_count * 16);
    for (size_t i = 0; i < r->point_count; i++) {
        p->points[2 * i] = p->center[0] + p->step * r->points[i].x;
        p->points[2 * i + 1] = p->center[1] + p->step * r->points[i].y;
    }
    for (size_t i = 0; i < r->edge_count; i++)
        p->edges[i] = (pnb_planar_edge){r->edges[i].left, r->edges[i].right, r->edges[i].below,
                                        r->edges[i].above};
    for (size_t i = 0; i < r->triangle_count; i++) {
        for (int k = 0; k < 3; k++)
            p->triangles[3 * i + k] = r->triangles[i].v[k];
        p->levels[i] = r->triangles[i].level;
    }
    for (size_t i = 0; i < r->trapezoid_count; i++) {
        const struct planar_trapezoid *t = &r->trapezoids[i];
        double x[2] = {t->x0, t->x1};
        p->trapezoids[i].level = t->level;
        for (int k = 0; k < 2; k++) {
            p->trapezoids[i].x[k] = p->center[0] + p->step * x[k];
            p->trapezoids[i].y0[k] = p->center[1] + p->step * height_at(r, t->lower, x[k]);
            p->trapezoids[i].y1[k] = p->center[1] + p->step * height_at(r, t->upper, x[k]);
        }
    }
    return PNB_OK;
}

pnb_status pnb_planar_sweep(pnb_planar *p, const pnb_planar_desc *desc)
{
    bool usual = desc->min_level == 0 && desc->max_level == 0;
    struct planar_options options = {.triangulate = desc->fill == PNB_PLANAR_FILL_SWEEP ||
                                                    desc->fill == PNB_PLANAR_FILL_DELAUNAY,
                                     .trapezoids = desc->fill == PNB_PLANAR_FILL_TRAPEZOIDS,
                                     .min_level = usual ? 1 : desc->min_level,
                                     .max_level = usual ? INT32_MAX : desc->max_level};
    p->result = (struct planar_result){0};
    pnb_status status = read_input(p, desc);
    if (!status)
        status = planar_sweep(p->workspace, p->input.points, p->input.point_count,
                              p->input.segments, p->input.segment_count, &options, &p->result);
    if (!status && desc->fill == PNB_PLANAR_FILL_DELAUNAY)
        planar_improve(p->workspace, &p->result,
                       &(struct planar_improve){.rule = PLANAR_RULE_DELAUNAY});
    if (!status)
        status = write_output(p);
    if (status)
        p->result = (struct planar_result){0};
    return status;
}

void pnb_planar_get(const pnb_planar *p, pnb_planar_view *out)
{
    *out = (pnb_planar_view){.points = p->points,
                             .point_count = p->result.point_count,
                             .edges = p->edges,
                             .edge_count = p->result.edge_count,
                             .triangles = p->triangles,
                             .triangle_levels = p->levels,
                             .triangle_count = p->result.triangle_count,
                             .trapezoids = p->trapezoids,
                             .trapezoid_count = p->result.trapezoid_count};
}

pnb_status pnb_planar_chains(pnb_planar *p, int32_t level, const uint32_t **out_points,
                             const uint32_t **out_starts, size_t *out_chain_count)
{
    planar_chains_finish(p->context, &p->chains);
    pnb_status status = planar_rings(p->workspace, &p->result, level, &p->chains);
    *out_points = p->chains.points;
    *out_starts = p->chains.starts;
    *out_chain_count = p->chains.chain_count;
    return status;
}
