/* method/planar/merge.c: the shadows of a light's convex pieces as one mesh (Boehl and
 * Stuerzlinger, section 4: the results for clusters of samples are merged without interpolation).
 *
 * Each part has a mesh of its own over the same plane; the light's shadow is the sum of their
 * intensities, each times its piece's share of the area. On every cell of the overlay of all
 * triangles that sum is linear. So the sides of all triangles are swept together, the triangle's
 * number as its weight, which keeps sides between triangles of one level; the faces come out as
 * triangles, and each takes from every part the plane of that triangle which holds its middle.
 * Corners of one place may differ where a part jumps. O((n + k) log n), k crossings of sides.
 */
#include <string.h>

#include "method/planar/room.h"

/* A weight that no few others are likely to cancel; at most 2^24. */
static int32_t weight_of(size_t part, size_t triangle)
{
    uint64_t x = (uint64_t)part << 40 | triangle;
    x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
    x = (x ^ x >> 27) * 0x94d049bb133111ebu;
    return 1 + (int32_t)((x ^ x >> 31) & 0xffffff);
}

static pnb_status add_part(pnb_context *context, const struct shadow_part *part, size_t number,
                           const struct shadow_part *grid, struct planar_input *in)
{
    pnb_status status =
        planar_input_reserve(context, in, part->point_count, 3 * part->triangle_count);
    uint32_t first = (uint32_t)in->point_count;
    for (size_t i = 0; i < part->point_count && !status; i++) {
        double at[2];
        for (int k = 0; k < 2; k++) {
            double g = floor((part->points[2 * i + k] - grid->origin[k]) * grid->scale + 0.5);
            at[k] = fmax(-PLANAR_LIMIT, fmin(PLANAR_LIMIT, g));
        }
        in->points[in->point_count++] = (struct planar_point){(int32_t)at[0], (int32_t)at[1]};
    }
    for (size_t i = 0; i < part->triangle_count && !status; i++)
        for (int k = 0; k < 3; k++) /* clockwise: the inside on the right */
            in->segments[in->segment_count++] =
                (struct planar_segment){first + part->triangles[i].v[(k + 1) % 3],
                                        first + part->triangles[i].v[k], weight_of(number, i)};
    return status;
}

/* The part's intensity at q, by the plane of the triangle that holds p. */
static double extend(const struct shadow_part *part, uint32_t triangle, const double *q)
{
    const struct shadow_triangle *t = &part->triangles[triangle];
    const double *a = part->points + 2 * (size_t)t->v[0], *b = part->points + 2 * (size_t)t->v[1],
                 *c = part->points + 2 * (size_t)t->v[2];
    double det = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    double u = ((q[0] - a[0]) * (c[1] - a[1]) - (q[1] - a[1]) * (c[0] - a[0])) / det;
    double v = ((b[0] - a[0]) * (q[1] - a[1]) - (b[1] - a[1]) * (q[0] - a[0])) / det;
    return t->value[0] + u * ((double)t->value[1] - t->value[0]) +
           v * ((double)t->value[2] - t->value[0]);
}

static pnb_status fill_values(pnb_context *context, const struct shadow_part *parts, size_t count,
                              struct shadow_part *out)
{
    for (size_t p = 0; p < count; p++) {
        if (parts[p].triangle_count == 0)
            continue;
        struct shadow_locator locator;
        pnb_status status = shadow_locator_init(context, &parts[p], &locator);
        if (status)
            return status;
        for (size_t i = 0; i < out->triangle_count; i++) {
            struct shadow_triangle *t = &out->triangles[i];
            double middle[2] = {0};
            for (int k = 0; k < 3; k++)
                for (int axis = 0; axis < 2; axis++)
                    middle[axis] += out->points[2 * (size_t)t->v[k] + axis] / 3;
            uint32_t hint = PLANAR_NONE; /* becomes the triangle found, where there is one */
            shadow_at(&locator, middle[0], middle[1], &hint);
            for (int k = 0; k < 3 && hint != PLANAR_NONE; k++)
                t->value[k] += (float)(parts[p].weight *
                                       extend(&parts[p], hint, out->points + 2 * (size_t)t->v[k]));
        }
        shadow_locator_finish(context, &locator);
    }
    for (size_t i = 0; i < out->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            out->triangles[i].value[k] = fminf(1, fmaxf(0, out->triangles[i].value[k]));
    return PNB_OK;
}

pnb_status shadow_merge(struct shadow_builder *b, const struct shadow_part *parts, size_t count,
                        struct shadow_part *out)
{
    struct planar_input in = {0};
    struct planar_result r = {0};
    pnb_status status = PNB_OK;
    for (size_t p = 0; p < count && !status; p++)
        status = add_part(b->context, &parts[p], p, &parts[0], &in);
    struct planar_options options = {.triangulate = true, .min_level = 1, .max_level = INT32_MAX};
    if (!status)
        status = planar_sweep(b->workspace, in.points, in.point_count, in.segments,
                              in.segment_count, &options, &r);
    planar_input_finish(b->context, &in);
    if (status)
        return status;
    planar_improve(b->workspace, &r, &(struct planar_improve){.rule = PLANAR_RULE_DELAUNAY});
    out->point_count = out->triangle_count = out->edge_count = 0;
    if (!memory_reserve(b->context, (void **)&out->points, &out->point_capacity, 0, r.point_count,
                        2 * sizeof(*out->points)) ||
        !memory_reserve(b->context, (void **)&out->triangles, &out->triangle_capacity, 0,
                        r.triangle_count, sizeof(*out->triangles)))
        return status_no_memory(b->context, r.point_count * 16);
    for (size_t i = 0; i < r.point_count; i++) {
        out->points[2 * i] = parts[0].origin[0] + r.points[i].x / parts[0].scale;
        out->points[2 * i + 1] = parts[0].origin[1] + r.points[i].y / parts[0].scale;
    }
    out->point_count = r.point_count;
    for (size_t i = 0; i < r.triangle_count; i++) {
        struct shadow_triangle *t = &out->triangles[out->triangle_count++];
        *t = (struct shadow_triangle){.level = -1};
        memcpy(t->v, r.triangles[i].v, sizeof(t->v));
    }
    out->rings = 0;
    out->weight = 1;
    memcpy(out->origin, parts[0].origin, sizeof(out->origin));
    out->scale = parts[0].scale;
    return fill_values(b->context, parts, count, out);
}
