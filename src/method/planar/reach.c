/* method/planar/reach.c: where on a receiver shadows can fall, and along which lines they jump.
 *
 * Reach: the box around the projections of all occluders from points on the light's border. Jumps:
 * the outline of the foot of every closed occluder that stands on the plane (its cross-section just
 * above it), and the line in which a one-sided light's plane meets the receiver.
 */
#include "method/planar/refine.h"

#define FOOT_HEIGHT 2.0 /* lifts above the plane: where a foot's outline is taken */
#define GRID_START  16  /* cells along the longer side at the beginning */

pnb_status reach_find_foot(struct shadow_builder *b, const struct shadow_plane *plane,
                           const struct reach *region, struct reach_foot *foot)
{
    struct silhouette_outline outline = {0};
    struct planar_input in = {0};
    struct planar_result r = {0};
    double height = FOOT_HEIGHT * scene_receiver_lift(b->scene);
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < plane->occluder_count && !status; i++)
        if (plane->occluders[i].lowest <= height / 2)
            status = silhouette_cross_section(b->context, &plane->occluders[i], height, &outline);
    if (!status)
        status = planar_input_reserve(b->context, &in, outline.point_count + 8,
                                      outline.segment_count + 8);
    for (size_t i = 0; i < outline.point_count && !status; i++) {
        double x = (outline.points[2 * i] - plane->center[0]) * plane->scale;
        double y = (outline.points[2 * i + 1] - plane->center[1]) * plane->scale;
        /* Beyond the shadow's reach nobody looks. */
        x = fmin(fmax(x, region->lo.x - 1000.0), region->hi.x + 1000.0);
        y = fmin(fmax(y, region->lo.y - 1000.0), region->hi.y + 1000.0);
        in.points[in.point_count++] =
            (struct planar_point){(int32_t)floor(x + 0.5), (int32_t)floor(y + 0.5)};
    }
    for (size_t i = 0; i < outline.segment_count && !status; i++)
        in.segments[in.segment_count++] = (struct planar_segment){
            outline.segments[i].a, outline.segments[i].b, outline.segments[i].weight};
    /* The dark side counts for more than all feet together, whichever way they turn. */
    for (int i = 0; i < region->dark_count && !region->dark_apart && !status; i++) {
        uint32_t n = (uint32_t)in.point_count;
        in.points[in.point_count++] = region->dark[i];
        in.segments[in.segment_count++] = (struct planar_segment){
            n, i + 1 < region->dark_count ? n + 1 : n + 1 - (uint32_t)region->dark_count, 1 << 20};
    }
    if (!status)
        status = planar_sweep(b->workspace, in.points, in.point_count, in.segments,
                              in.segment_count, NULL, &r);
    for (size_t i = 0; i < r.edge_count && !status; i++) {
        const struct planar_edge *e = &r.edges[i];
        if ((e->below == 0) == (e->above == 0))
            continue;
        if (!memory_reserve(b->context, (void **)&foot->ends, &foot->capacity, 2 * foot->count, 2,
                            sizeof(*foot->ends))) {
            status = status_no_memory(b->context, 0);
            break;
        }
        bool below = e->below != 0; /* inside on the right */
        foot->ends[2 * foot->count] = r.points[below ? e->left : e->right];
        foot->ends[2 * foot->count++ + 1] = r.points[below ? e->right : e->left];
    }
    silhouette_outline_finish(b->context, &outline);
    planar_input_finish(b->context, &in);
    return status;
}

static struct planar_point on_grid(const struct shadow_plane *plane, const double *p)
{
    return (struct planar_point){(int32_t)floor((p[0] - plane->center[0]) * plane->scale + 0.5),
                                 (int32_t)floor((p[1] - plane->center[1]) * plane->scale + 0.5)};
}

/* The part of the receiver's box behind a one-sided light's plane. */
static void find_dark_side(const struct shadow_plane *plane, const struct light_shape *shape,
                           struct reach *r)
{
    pnb_light_type type = shape->light.type;
    if (type != PNB_LIGHT_RECTANGLE && type != PNB_LIGHT_DISK && type != PNB_LIGHT_POLYGON)
        return;
    const struct silhouette_plane *f = &plane->frame;
    vec3 n =
        v3(v3_dot(shape->normal, f->u), v3_dot(shape->normal, f->v), v3_dot(shape->normal, f->n));
    vec3 l = silhouette_to_plane(f, light_shape_sample(shape, 0.5, 0.5).p);
    double corner[4][2] = {{plane->lo[0], plane->lo[1]},
                           {plane->hi[0], plane->lo[1]},
                           {plane->hi[0], plane->hi[1]},
                           {plane->lo[0], plane->hi[1]}};
    double s[4];
    for (int i = 0; i < 4; i++)
        s[i] = n.x * (corner[i][0] - l.x) + n.y * (corner[i][1] - l.y) - n.z * l.z;
    for (int i = 0; i < 4; i++) {
        int j = (i + 1) % 4;
        if (s[i] <= 0)
            r->dark[r->dark_count++] = on_grid(plane, corner[i]);
        if ((s[i] <= 0) != (s[j] <= 0)) {
            double t = s[i] / (s[i] - s[j]), p[2];
            for (int axis = 0; axis < 2; axis++)
                p[axis] = corner[i][axis] + t * (corner[j][axis] - corner[i][axis]);
            r->dark[r->dark_count++] = on_grid(plane, p);
        }
    }
}

/* The dark side is the receiver's box on one side of a line: it meets another box within just where
 * it holds a corner of that. A step's width counts as in it. */
static bool in_dark(const struct reach *r, struct planar_point p)
{
    int left = 0, right = 0;
    for (int i = 0; i < r->dark_count; i++) {
        struct planar_point a = r->dark[i], b = r->dark[(i + 1) % r->dark_count];
        double length = hypot((double)b.x - a.x, (double)b.y - a.y);
        double off = (double)planar_orient(a, b, p) / fmax(length, 1);
        left += off >= -4;
        right += off <= 4;
    }
    return left == r->dark_count || right == r->dark_count;
}

bool reach_find_region(struct shadow_plane *plane, const struct shadow_cluster *clusters,
                       size_t count, const struct light_shape *shape, double far, struct reach *r)
{
    enum { per_cluster = 24 };
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    bool everywhere = false;
    *r = (struct reach){.start = GRID_START};
    for (size_t c = 0; c < count; c++) {
        vec3 samples[per_cluster];
        shadow_samples(&clusters[c], SHADOW_BORDER, per_cluster, plane->frame.origin, far, samples);
        for (int k = 0; k < per_cluster; k++) {
            vec3 l = silhouette_to_plane(&plane->frame, samples[k]);
            for (size_t i = 0; i < plane->occluder_count; i++) {
                const struct silhouette_occluder *o = &plane->occluders[i];
                if (o->highest >= 0.999 * l.z) { /* no end to such a shadow */
                    everywhere = true;
                    continue;
                }
                for (size_t v = 0; v < o->vertex_count; v++) {
                    double h = fmax(o->h[v], 0), s = 1 / (l.z - h);
                    double x = (o->x[v] * l.z - l.x * h) * s, y = (o->y[v] * l.z - l.y * h) * s;
                    lo[0] = fmin(lo[0], x);
                    lo[1] = fmin(lo[1], y);
                    hi[0] = fmax(hi[0], x);
                    hi[1] = fmax(hi[1], y);
                }
            }
        }
    }
    find_dark_side(plane, shape, r);
    bool empty = false;
    for (int axis = 0; axis < 2; axis++) {
        /* 24 points of the border are not all of it. */
        double more = 0.1 * (hi[axis] - lo[axis]);
        lo[axis] = everywhere ? plane->lo[axis] : fmax(plane->lo[axis], lo[axis] - more);
        hi[axis] = everywhere ? plane->hi[axis] : fmin(plane->hi[axis], hi[axis] + more);
        empty |= !(lo[axis] < hi[axis]);
    }
    if (everywhere)
        r->start = 4 * GRID_START;
    if (empty && r->dark_count == 0)
        return false;
    r->shadow_lo = on_grid(plane, empty ? plane->lo : lo);
    r->shadow_hi = on_grid(plane, empty ? plane->hi : hi);
    bool whole = r->dark_count > 0;
    if (whole && !empty) {
        struct planar_point corner[4] = {r->shadow_lo,
                                         {r->shadow_hi.x, r->shadow_lo.y},
                                         r->shadow_hi,
                                         {r->shadow_lo.x, r->shadow_hi.y}};
        bool apart = true;
        for (int i = 0; i < 4; i++)
            apart &= !in_dark(r, corner[i]);
        r->dark_apart = apart;
        whole = !apart;
    }
    r->lo = whole ? on_grid(plane, plane->lo) : r->shadow_lo;
    r->hi = whole ? on_grid(plane, plane->hi) : r->shadow_hi;
    return true;
}
