/* method/planar/build.c: silhouettes to a filled soft shadow (Boehl and Stuerzlinger, section 3).
 *
 *   light samples -> silhouettes of all occluders, projected           silhouette/point
 *                 -> one outline per sample (winding number above 0)   planar_sweep, K times
 *                 -> all outlines at once: rings, faces by level,
 *                    triangles of the faces                            planar_sweep, once
 *                 -> strips from ring to ring,                         planar_strips
 *                    or the sweep's triangles and exchange of diagonals  planar_improve
 *                 -> values: (ring - 1) / (K - 1), mean at crossings; or exact visibility
 *
 * Ring i bounds the region that at least i outlines cover; a face of level i lies between ring i
 * and ring i + 1, so the paper's strips are sets of faces. Every outline is swept with a frame
 * around the domain, so that the outside (level 0) is a face too.
 *
 * Leaks: a crossing on the innermost ring (ring K with another) has less than the umbra's
 * intensity, one on the outermost more than nothing. In the umbra diagonals give way at such
 * points, outside the triangle between the point's two neighbours on the ring is added (both:
 * mend).
 *
 * Where several outlines share an edge (an occluder that touches the plane) the shadow itself
 * jumps: corners there get the value nearest to the mean that lies between the rings of their own
 * face.
 *
 * Samples that are below the plane, and parts of the plane on a one-sided light's dark side, count
 * as covered.
 */
#include <string.h>

#include "method/planar/room.h"

/* Distance of a sun's samples, in sizes of the receiver. */
#define FAR 1e6
/* intensity=exact: how far from its face's rings the value at a corner may be. */
#define BESIDE 0.2

pnb_status shadow_builder_init(pnb_context *context, pnb_scene *scene, struct shadow_builder *b)
{
    *b = (struct shadow_builder){.context = context, .scene = scene};
    pnb_status status = planar_workspace_create(context, &b->workspace);
    return status ? status : planar_workspace_create(context, &b->spare);
}

void shadow_builder_finish(struct shadow_builder *b)
{
    if (!b->context)
        return;
    pnb_solver_destroy(b->truth);
    for (int k = 0; k < SILHOUETTE_SAMPLES_MAX; k++)
        silhouette_outline_finish(b->context, &b->outlines[k]);
    planar_input_finish(b->context, &b->outline);
    planar_input_finish(b->context, &b->levels);
    planar_input_finish(b->context, &b->parted);
    planar_workspace_destroy(b->workspace);
    planar_workspace_destroy(b->spare);
    void *blocks[] = {b->ring_lo, b->ring_hi, b->leak, b->jump, b->value, b->slot};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(b->context, blocks[i]);
    *b = (struct shadow_builder){0};
}

pnb_status shadow_builder_update(struct shadow_builder *b, pnb_update update)
{
    return b->truth ? pnb_solver_update(b->truth, update) : PNB_OK;
}

void shadow_part_finish(pnb_context *context, struct shadow_part *part)
{
    memory_free(context, part->points);
    memory_free(context, part->triangles);
    memory_free(context, part->edges);
    *part = (struct shadow_part){0};
}

pnb_status shadow_truth(struct shadow_builder *b, const struct shadow_plane *plane,
                        const pnb_light *light, const double *points, size_t count,
                        float *visibility)
{
    if (!b->truth) {
        bool exact = pnb_method_find("exact") != NULL;
        b->truth_method = exact ? "exact" : "reference";
        pnb_solver_param area = {"exact-area", "on"};
        pnb_solver_desc desc = {.method = b->truth_method,
                                .samples = b->truth_samples > 0 ? b->truth_samples : 1024,
                                .params = &area,
                                .param_count = exact ? 1 : 0};
        pnb_status status = pnb_solver_create(b->context, b->scene, &desc, &b->truth);
        if (status)
            return status;
    }
    float *positions = memory_alloc(b->context, 3 * count, sizeof(*positions));
    float *normals = memory_alloc(b->context, 3 * count, sizeof(*normals));
    uint32_t *objects = memory_alloc(b->context, count, sizeof(*objects));
    pnb_status status = PNB_OK;
    if (!positions || !normals || !objects)
        status = status_no_memory(b->context, 28 * count);
    for (size_t i = 0; i < count && !status; i++) {
        v3_storef(positions + 3 * i,
                  silhouette_from_plane(&plane->frame, v3(points[2 * i], points[2 * i + 1], 0)));
        v3_storef(normals + 3 * i, plane->frame.n);
        objects[i] = (uint32_t)plane->object;
    }
    if (!status) {
        pnb_receivers receivers = {
            .count = count, .positions = positions, .normals = normals, .objects = objects};
        status = pnb_solver_visibility(b->truth, light, &receivers, visibility);
    }
    memory_free(b->context, positions);
    memory_free(b->context, normals);
    memory_free(b->context, objects);
    return status;
}

#define BORDER (PLANAR_LIMIT - 8)

struct grid {
    double x, y, scale;
    double limit; /* points nearer than this to (x, y) lie inside the border */
};

static int32_t to_grid(double d, double scale)
{
    double g = floor(d * scale + 0.5);
    return g > BORDER ? BORDER : g < -BORDER ? -BORDER : (int32_t)g;
}

static struct planar_point grid_point(const struct grid *g, double x, double y)
{
    return (struct planar_point){to_grid(x - g->x, g->scale), to_grid(y - g->y, g->scale)};
}

static void add_piece(struct planar_input *in, struct planar_point a, struct planar_point b,
                      int32_t weight)
{
    if (planar_same(a, b))
        return;
    uint32_t n = (uint32_t)in->point_count;
    in->points[n] = a;
    in->points[n + 1] = b;
    in->point_count += 2;
    in->segments[in->segment_count++] = (struct planar_segment){n, n + 1, weight};
}

/* A segment that leaves the domain: cut at the lines of its border, each piece then moved onto the
 * border if it lies outside. Winding numbers inside stay what they are. */
static pnb_status add_far_segment(pnb_context *context, struct planar_input *in,
                                  const struct grid *g, const double *a, const double *b,
                                  int32_t weight)
{
    double cuts[6] = {0, 1, 1, 1, 1, 1};
    int count = 1;
    double limit = BORDER / g->scale, origin[2] = {g->x, g->y};
    for (int axis = 0; axis < 2; axis++)
        for (int s = -1; s <= 1; s += 2) {
            double from = a[axis] - origin[axis], to = b[axis] - origin[axis];
            double t = (s * limit - from) / (to - from);
            if (t > 0 && t < 1) {
                int i = count++;
                for (; i > 1 && cuts[i - 1] > t; i--)
                    cuts[i] = cuts[i - 1];
                cuts[i] = t;
            }
        }
    cuts[count++] = 1;
    pnb_status status = planar_input_reserve(context, in, 2 * (size_t)count, (size_t)count);
    if (status)
        return status;
    struct planar_point last = grid_point(g, a[0], a[1]);
    for (int i = 1; i < count; i++) {
        struct planar_point next = i + 1 == count ? grid_point(g, b[0], b[1])
                                                  : grid_point(g, a[0] + cuts[i] * (b[0] - a[0]),
                                                               a[1] + cuts[i] * (b[1] - a[1]));
        add_piece(in, last, next, weight);
        last = next;
    }
    return PNB_OK;
}

static pnb_status add_outline(pnb_context *context, struct planar_input *in, const struct grid *g,
                              const struct silhouette_outline *o)
{
    bool inside = true;
    for (size_t i = 0; i < o->point_count && inside; i++)
        inside = fabs(o->points[2 * i] - g->x) < g->limit &&
                 fabs(o->points[2 * i + 1] - g->y) < g->limit;
    if (inside) {
        pnb_status status = planar_input_reserve(context, in, o->point_count, o->segment_count);
        if (status)
            return status;
        uint32_t first = (uint32_t)in->point_count;
        for (size_t i = 0; i < o->point_count; i++)
            in->points[in->point_count++] = grid_point(g, o->points[2 * i], o->points[2 * i + 1]);
        for (size_t i = 0; i < o->segment_count; i++)
            in->segments[in->segment_count++] = (struct planar_segment){
                first + o->segments[i].a, first + o->segments[i].b, o->segments[i].weight};
        return PNB_OK;
    }
    for (size_t i = 0; i < o->segment_count; i++) {
        const struct silhouette_segment *s = &o->segments[i];
        pnb_status status = add_far_segment(context, in, g, o->points + 2 * (size_t)s->a,
                                            o->points + 2 * (size_t)s->b, s->weight);
        if (status)
            return status;
    }
    return PNB_OK;
}

/* A clockwise box of half size `half`. */
static pnb_status add_box(pnb_context *context, struct planar_input *in, int32_t half,
                          int32_t weight)
{
    pnb_status status = planar_input_reserve(context, in, 8, 4);
    if (status)
        return status;
    struct planar_point p[4] = {{-half, -half}, {-half, half}, {half, half}, {half, -half}};
    for (int i = 0; i < 4; i++)
        add_piece(in, p[i], p[(i + 1) % 4], weight);
    return PNB_OK;
}

/* The part of the domain where n . (p - l) <= 0: the dark side of a one-sided light. */
static pnb_status add_dark_side(pnb_context *context, struct planar_input *in, const struct grid *g,
                                vec3 l, vec3 n)
{
    double half = BORDER / g->scale;
    double corner[4][2] = {{-half, -half}, {-half, half}, {half, half}, {half, -half}};
    double poly[8][2], s[4];
    int count = 0;
    for (int i = 0; i < 4; i++)
        s[i] = n.x * (corner[i][0] + g->x - l.x) + n.y * (corner[i][1] + g->y - l.y) - n.z * l.z;
    for (int i = 0; i < 4; i++) {
        int j = (i + 1) % 4;
        if (s[i] <= 0)
            memcpy(poly[count++], corner[i], sizeof(corner[i]));
        if ((s[i] <= 0) != (s[j] <= 0)) {
            double t = s[i] / (s[i] - s[j]);
            poly[count][0] = corner[i][0] + t * (corner[j][0] - corner[i][0]);
            poly[count++][1] = corner[i][1] + t * (corner[j][1] - corner[i][1]);
        }
    }
    pnb_status status = planar_input_reserve(context, in, 2 * (size_t)count, (size_t)count);
    for (int i = 0; i < count && !status; i++) {
        int j = (i + 1) % count;
        add_piece(in, grid_point(g, poly[i][0] + g->x, poly[i][1] + g->y),
                  grid_point(g, poly[j][0] + g->x, poly[j][1] + g->y), 1);
    }
    return status;
}

static bool scratch_room(struct shadow_builder *b, size_t points)
{
    if (points <= b->scratch)
        return true;
    size_t n = points + points / 2;
    void **blocks[] = {(void **)&b->ring_lo, (void **)&b->ring_hi, (void **)&b->leak,
                       (void **)&b->jump,    (void **)&b->value,   (void **)&b->slot};
    static const size_t sizes[] = {4, 4, 1, 1, 4, 4};
    for (int i = 0; i < 6; i++) {
        void *block = memory_realloc(b->context, *blocks[i], n, sizes[i]);
        if (!block)
            return false;
        *blocks[i] = block;
    }
    b->scratch = n;
    return true;
}

/* On which rings each point lies, and what follows from that. */
static void ring_values(struct shadow_builder *b, const struct planar_result *r, int rings)
{
    for (size_t i = 0; i < r->point_count; i++) {
        b->ring_lo[i] = INT32_MAX;
        b->ring_hi[i] = 0;
        b->leak[i] = b->jump[i] = 0;
    }
    for (size_t i = 0; i < r->edge_count; i++) {
        const struct planar_edge *e = &r->edges[i];
        int32_t lo = e->below < e->above ? e->below : e->above, hi = e->below + e->above - lo;
        if (hi == 0)
            continue; /* the frame */
        uint32_t ends[2] = {e->left, e->right};
        for (int k = 0; k < 2; k++) {
            uint32_t v = ends[k];
            b->ring_lo[v] = lo + 1 < b->ring_lo[v] ? lo + 1 : b->ring_lo[v];
            b->ring_hi[v] = hi > b->ring_hi[v] ? hi : b->ring_hi[v];
            b->jump[v] |= hi - lo > 1;
        }
    }
    for (size_t i = 0; i < r->point_count; i++) {
        if (b->ring_hi[i] == 0) {
            b->value[i] = 0;
            continue;
        }
        b->value[i] =
            rings > 1 ? (float)((0.5 * (b->ring_lo[i] + b->ring_hi[i]) - 1) / (rings - 1)) : 1;
        b->leak[i] = rings > 1 && !b->jump[i] &&
                     ((b->ring_hi[i] == rings && b->ring_lo[i] < rings) ||
                      (b->ring_lo[i] == 1 && b->ring_hi[i] > 1));
    }
}

/* Values at a triangle's corners. */
static inline void corner_values(const struct shadow_builder *b, int rings, enum shadow_mend mend,
                                 struct shadow_triangle *t)
{
    bool even = rings == 1 || (t->level >= rings && mend == SHADOW_MEND_EVEN);
    for (int k = 0; k < 3; k++) {
        float value = even ? t->level > 0 : b->value[t->v[k]];
        if (!even && b->jump[t->v[k]]) {
            float lo = (float)(t->level - 1) / (float)(rings - 1),
                  hi = (float)t->level / (float)(rings - 1);
            value = value < lo ? lo : value > hi ? hi : value;
        }
        t->value[k] = value < 0 ? 0 : value > 1 ? 1 : value;
    }
}

/* A place a little inside triangle t, near its corner k. */
static void beside_corner(const struct shadow_part *part, const struct shadow_triangle *t, int k,
                          double *out)
{
    for (int axis = 0; axis < 2; axis++) {
        double p = part->points[2 * (size_t)t->v[k] + axis];
        double q = part->points[2 * (size_t)t->v[(k + 1) % 3] + axis];
        double r = part->points[2 * (size_t)t->v[(k + 2) % 3] + axis];
        out[axis] = p + 0.02 * (0.5 * (q + r) - p);
    }
}

/* Whether a corner needs a value of its own: the shadow jumps there, or the point's value is none
 * that a face of this level can have. The second finds points of a line of contact that are not
 * known as such: where another shadow's outlines cross that line, each outline rounds its crossing
 * by itself, and they coincide no more. */
static bool is_beside(const struct shadow_builder *b, const struct shadow_triangle *t, int k,
                      int rings)
{
    if (b->jump[t->v[k]])
        return true;
    double per = rings > 1 ? 1.0 / (rings - 1) : 1, value = b->value[t->v[k]];
    return value < (t->level - 1) * per - BESIDE || value > t->level * per + BESIDE;
}

/* Exact visibility instead of ring numbers. Where the shadow jumps each face asks a little inside
 * itself. */
static pnb_status exact_values(struct shadow_builder *b, const struct shadow_plane *plane,
                               const pnb_light *light, int rings, struct shadow_part *part)
{
    size_t count = part->point_count, corners = 0;
    pnb_status status = shadow_truth(b, plane, light, part->points, count, b->value);
    for (size_t i = 0; i < count && !status; i++)
        b->value[i] = 1 - b->value[i];
    for (size_t i = 0; i < part->triangle_count && !status; i++)
        for (int k = 0; k < 3; k++) {
            struct shadow_triangle *t = &part->triangles[i];
            t->value[k] = b->value[t->v[k]];
            corners += is_beside(b, t, k, rings);
        }
    if (status || corners == 0)
        return status;
    double *points = memory_alloc(b->context, 2 * corners, sizeof(*points));
    float *visibility = memory_alloc(b->context, corners, sizeof(*visibility));
    if (!points || !visibility)
        status = status_no_memory(b->context, 20 * corners);
    for (int pass = 0; pass < 2 && !status; pass++) {
        size_t at = 0;
        for (size_t i = 0; i < part->triangle_count; i++)
            for (int k = 0; k < 3; k++) {
                struct shadow_triangle *t = &part->triangles[i];
                if (!is_beside(b, t, k, rings))
                    continue;
                if (pass == 0)
                    beside_corner(part, t, k, points + 2 * at);
                else
                    t->value[k] = 1 - visibility[at];
                at++;
            }
        if (pass == 0)
            status = shadow_truth(b, plane, light, points, corners, visibility);
    }
    memory_free(b->context, points);
    memory_free(b->context, visibility);
    return status;
}

/* A triangle outside the outermost ring that mends a leak: its two sides at a leaking point are
 * edges of the ring. */
static bool mends(const struct shadow_builder *b, const struct planar_triangle *t)
{
    for (int k = 0; k < 3; k++)
        if (b->leak[t->v[k]] && t->near[k] == PLANAR_NONE && t->near[(k + 2) % 3] == PLANAR_NONE)
            return true;
    return false;
}

static pnb_status copy_part(struct shadow_builder *b, const struct planar_result *r,
                            const struct grid *g, int rings, enum shadow_mend mend,
                            struct shadow_part *part)
{
    part->point_count = part->triangle_count = part->edge_count = 0;
    if (!memory_reserve(b->context, (void **)&part->points, &part->point_capacity, 0,
                        r->point_count, 2 * sizeof(*part->points)) ||
        !memory_reserve(b->context, (void **)&part->triangles, &part->triangle_capacity, 0,
                        r->triangle_count, sizeof(*part->triangles)) ||
        !memory_reserve(b->context, (void **)&part->edges, &part->edge_capacity, 0, r->edge_count,
                        sizeof(*part->edges)))
        return status_no_memory(b->context, r->point_count * 16);
    double step = 1 / g->scale;
    for (size_t i = 0; i < r->point_count; i++) {
        part->points[2 * i] = g->x + r->points[i].x * step;
        part->points[2 * i + 1] = g->y + r->points[i].y * step;
    }
    part->point_count = r->point_count;
    for (size_t i = 0; i < r->triangle_count; i++) {
        const struct planar_triangle *t = &r->triangles[i];
        if (t->level <= 0 && !mends(b, t))
            continue;
        struct shadow_triangle *out = &part->triangles[part->triangle_count++];
        out->level = t->level;
        for (int k = 0; k < 3; k++)
            out->v[k] = t->v[k];
        corner_values(b, rings, mend, out);
    }
    for (size_t i = 0; i < r->edge_count; i++)
        if (r->edges[i].below > 0 || r->edges[i].above > 0)
            part->edges[part->edge_count++] = r->edges[i];
    part->rings = rings;
    part->origin[0] = g->x;
    part->origin[1] = g->y;
    part->scale = g->scale;
    return PNB_OK;
}

/* The outlines of samples [first, first + count), swept one by one and added to b->levels. */
static pnb_status add_outlines(struct shadow_builder *b, struct shadow_plane *plane,
                               const struct light_shape *shape, const struct grid *grid,
                               const vec3 *samples, size_t count)
{
    pnb_status status = PNB_OK;
    double started = clock_ms();
    for (size_t k = 0; k < count; k++)
        b->outlines[k].point_count = b->outlines[k].segment_count = 0;
    for (size_t i = 0; i < plane->occluder_count && !status; i++)
        status =
            silhouette_from_points(b->context, &plane->occluders[i], samples, count, b->outlines);
    double found = clock_ms();
    b->times.silhouettes_ms += found - started;
    bool one_sided = shape->light.type == PNB_LIGHT_RECTANGLE ||
                     shape->light.type == PNB_LIGHT_DISK || shape->light.type == PNB_LIGHT_POLYGON;
    vec3 lit = v3(v3_dot(shape->normal, plane->frame.u), v3_dot(shape->normal, plane->frame.v),
                  v3_dot(shape->normal, plane->frame.n));
    for (size_t k = 0; k < count && !status; k++) {
        struct planar_input *in = &b->outline;
        in->point_count = in->segment_count = 0;
        b->times.silhouette_edges += b->outlines[k].segment_count;
        status = add_outline(b->context, in, grid, &b->outlines[k]);
        if (!status && samples[k].z <= 0)
            status = add_box(b->context, in, BORDER, 1);
        else if (!status && one_sided && (lit.x != 0 || lit.y != 0 || lit.z > 0))
            status = add_dark_side(b->context, in, grid, samples[k], lit);
        struct planar_options options = {.threshold = 1};
        struct planar_result r;
        if (!status)
            status = planar_sweep(b->workspace, in->points, in->point_count, in->segments,
                                  in->segment_count, &options, &r);
        if (!status) {
            b->times.careful += r.snapped;
            status = planar_outline(b->workspace, &r, 1, &b->levels);
        }
    }
    b->times.outlines_ms += clock_ms() - found;
    return status;
}

/* Iso-density lines: new lines may cross others, so some rounds of it. */
static pnb_status part_rings(struct shadow_builder *b, double share)
{
    enum { rounds = 3 };
    pnb_status status = PNB_OK;
    size_t parted = 1;
    for (int i = 0; i < rounds && parted > 0 && !status; i++) {
        struct planar_result r;
        status = planar_sweep(b->workspace, b->levels.points, b->levels.point_count,
                              b->levels.segments, b->levels.segment_count, NULL, &r);
        if (!status)
            status = planar_reconnect(b->workspace, &r, share, &b->parted, &parted);
        struct planar_input t = b->levels;
        b->levels = b->parted;
        b->parted = t;
    }
    return status;
}

pnb_status shadow_outlines(struct shadow_builder *b, struct shadow_plane *plane,
                           const struct light_shape *shape, const vec3 *samples, size_t count)
{
    struct grid grid = {plane->center[0], plane->center[1], plane->scale,
                        (PLANAR_LIMIT - 16) / plane->scale};
    pnb_status status = PNB_OK;
    b->levels.point_count = b->levels.segment_count = 0;
    for (size_t k = 0; k < count && !status; k += SILHOUETTE_SAMPLES_MAX)
        status =
            add_outlines(b, plane, shape, &grid, samples + k,
                         count - k < SILHOUETTE_SAMPLES_MAX ? count - k : SILHOUETTE_SAMPLES_MAX);
    return status;
}

pnb_status shadow_build(struct shadow_builder *b, struct shadow_plane *plane,
                        const struct light_shape *shape, const struct shadow_cluster *cluster,
                        const struct shadow_settings *settings, struct shadow_part *part)
{
    int rings = shadow_sample_count(cluster, settings->samples);
    double size = fmax(plane->hi[0] - plane->lo[0], plane->hi[1] - plane->lo[1]);
    struct grid grid = {plane->center[0], plane->center[1], plane->scale, 0};
    if (settings->join > 0)
        grid.scale = fmin(grid.scale, 1 / settings->join);
    grid.limit = (PLANAR_LIMIT - 16) / plane->scale;
    vec3 *samples = memory_alloc(b->context, (size_t)rings, sizeof(*samples));
    if (!samples)
        return status_no_memory(b->context, (size_t)rings * sizeof(*samples));
    shadow_samples(cluster, settings->placement, rings, plane->frame.origin, FAR * size, samples);
    for (int k = 0; k < rings; k++)
        samples[k] = silhouette_to_plane(&plane->frame, samples[k]);

    b->levels.point_count = b->levels.segment_count = 0;
    pnb_status status = PNB_OK;
    for (int k = 0; k < rings && !status; k += SILHOUETTE_SAMPLES_MAX)
        status = add_outlines(
            b, plane, shape, &grid, samples + k,
            (size_t)(rings - k < SILHOUETTE_SAMPLES_MAX ? rings - k : SILHOUETTE_SAMPLES_MAX));
    memory_free(b->context, samples);
    if (status)
        return status;

    double started = clock_ms();
    if (settings->reconnect > 0 && rings > 1)
        status = part_rings(b, settings->reconnect);
    if (status)
        return status;
    b->times.outline_edges += b->levels.segment_count;
    bool mend = settings->mend != SHADOW_MEND_NOT && rings > 1 && !settings->rings_only;
    /* A hard shadow is even: no points' values to join, and the shape of triangles matters to
     * none but those who ask for Delaunay's. */
    enum planar_rule rule =
        rings == 1 && settings->fill == PLANAR_RULE_NEAREST ? PLANAR_RULE_SWEEP : settings->fill;
    bool strips =
        rule == PLANAR_RULE_NEAREST && settings->mend == SHADOW_MEND_EVEN && !settings->rings_only;
    struct planar_result r = {0};
    double filled = 0;
    for (bool again = true; again && !status;) {
        struct planar_options options = {.triangulate = !settings->rings_only && !strips,
                                         .min_level = 1,
                                         .max_level = INT32_MAX};
        if (mend && !strips) {
            /* With a frame around it the outside is a face of level 0. */
            status = add_box(b->context, &b->levels, PLANAR_LIMIT, 1);
            options.base = -1;
            options.min_level = 0;
        }
        if (!status)
            status = planar_sweep(b->workspace, b->levels.points, b->levels.point_count,
                                  b->levels.segments, b->levels.segment_count, &options, &r);
        if (!status && !scratch_room(b, r.point_count))
            status = status_no_memory(b->context, r.point_count * 18);
        if (status)
            return status;
        ring_values(b, &r, rings);
        b->times.ring_edges += r.edge_count;
        b->times.crossings += r.crossing_count;
        b->times.careful += r.snapped;
        filled = clock_ms();
        b->times.rings_ms += filled - started;
        again = strips &&
                !planar_strips(b->workspace, b->spare,
                               &(struct planar_strips){
                                   .even_from = rings, .values = b->value, .corners = b->leak},
                               &r);
        strips = strips && !again;
        started = clock_ms();
    }
    if (!strips && (rule != PLANAR_RULE_SWEEP || mend))
        b->times.exchanges +=
            planar_improve(b->workspace, &r,
                           &(struct planar_improve){.rule = rule,
                                                    .values = b->value,
                                                    .avoid = mend ? b->leak : NULL,
                                                    .avoid_above = rings,
                                                    .avoid_below = 0});
    status = copy_part(b, &r, &grid, rings, settings->mend, part);
    part->weight = cluster->weight;
    double valued = clock_ms();
    b->times.fill_ms += valued - filled;
    if (!status && settings->intensity == SHADOW_EXACT) {
        status = exact_values(b, plane, &shape->light, rings, part);
        b->times.values_ms += clock_ms() - valued;
    }
    return status;
}
