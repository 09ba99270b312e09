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
#include <string.h>

#include "method/planar/room.h"

#define GRID_START     16
#define SAFETY         0.9
#define SMALLEST       (1.0 / 6000)
#define TESTS          10
#define ROUNDS_MAX     60
#define TRIANGLES_MAX  4000000
#define FOOT_HEIGHT    2.0  /* lifts above the plane: where a foot's outline is taken */
#define FOOT_EDGES_MAX 3000 /* more: no foot, the jump is refined like anything else */
#define NUDGE          0.02 /* of the way from a corner to the triangle's middle */

struct corners {
    float value[3];
    uint8_t fixed; /* bit k: side k is part of the foot's outline */
    bool inside;   /* below a foot */
};

struct mesh2 {
    pnb_context *context;
    struct planar_point *points;
    float *values;
    size_t point_count, point_capacity, value_capacity;
    uint8_t *jump; /* per point: on the foot's outline */
    size_t jump_capacity;
    struct planar_triangle *triangles; /* level: 0: new, -1: tested */
    struct corners *corners;           /* per triangle */
    size_t triangle_count, triangle_capacity, corner_capacity;
    uint32_t *stack;
    size_t stack_count, stack_capacity;
    bool no_memory;
};

static bool room(struct mesh2 *m)
{
    m->no_memory = m->no_memory ||
                   !memory_reserve(m->context, (void **)&m->points, &m->point_capacity,
                                   m->point_count, 1, sizeof(*m->points)) ||
                   !memory_reserve(m->context, (void **)&m->values, &m->value_capacity,
                                   m->point_count, 1, sizeof(*m->values)) ||
                   !memory_reserve(m->context, (void **)&m->jump, &m->jump_capacity, m->point_count,
                                   1, sizeof(*m->jump)) ||
                   !memory_reserve(m->context, (void **)&m->corners, &m->corner_capacity,
                                   m->triangle_count, 2, sizeof(*m->corners)) ||
                   !memory_reserve(m->context, (void **)&m->triangles, &m->triangle_capacity,
                                   m->triangle_count, 2, sizeof(*m->triangles));
    return !m->no_memory;
}

struct side {
    uint32_t near;
    bool fixed;
};

static struct side side_of(const struct mesh2 *m, uint32_t t, uint32_t k)
{
    return (struct side){m->triangles[t].near[k], m->corners[t].fixed >> k & 1};
}

static void fix(struct mesh2 *m, uint32_t half)
{
    uint32_t other = m->triangles[half / 3].near[half % 3];
    m->corners[half / 3].fixed |= (uint8_t)(1 << half % 3);
    if (other != PLANAR_NONE)
        m->corners[other / 3].fixed |= (uint8_t)(1 << other % 3);
}

static void link2(struct mesh2 *m, uint32_t half, struct side other)
{
    m->triangles[half / 3].near[half % 3] = other.near;
    if (other.near != PLANAR_NONE)
        m->triangles[other.near / 3].near[other.near % 3] = half;
    if (other.fixed)
        fix(m, half);
}

static struct side free_side(uint32_t half)
{
    return (struct side){half, false};
}

static void push(struct mesh2 *m, uint32_t half)
{
    if (!memory_reserve(m->context, (void **)&m->stack, &m->stack_capacity, m->stack_count, 1,
                        sizeof(*m->stack))) {
        m->no_memory = true;
        return;
    }
    m->stack[m->stack_count++] = half;
}

static void set(struct mesh2 *m, uint32_t t, uint32_t a, uint32_t b, uint32_t c)
{
    m->triangles[t] =
        (struct planar_triangle){{a, b, c}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, 0};
    m->corners[t] = (struct corners){{m->values[a], m->values[b], m->values[c]}, 0, false};
}

/* Lawson: sides opposite to the new point. */
static void legalize(struct mesh2 *m)
{
    while (m->stack_count > 0 && !m->no_memory) {
        uint32_t half = m->stack[--m->stack_count], i = half / 3, k = half % 3;
        struct planar_triangle *t = m->triangles;
        uint32_t other = t[i].near[k];
        if (other == PLANAR_NONE || (m->corners[i].fixed >> k & 1))
            continue;
        uint32_t j = other / 3, l = other % 3;
        uint32_t a = t[i].v[k], b = t[i].v[(k + 1) % 3], c = t[i].v[(k + 2) % 3],
                 d = t[j].v[(l + 2) % 3];
        if (!planar_in_circle(m->points[a], m->points[b], m->points[c], m->points[d]) ||
            planar_orient(m->points[a], m->points[d], m->points[c]) <= 0 ||
            planar_orient(m->points[d], m->points[b], m->points[c]) <= 0)
            continue;
        struct side bc = side_of(m, i, (k + 1) % 3), ca = side_of(m, i, (k + 2) % 3);
        struct side ad = side_of(m, j, (l + 1) % 3), db = side_of(m, j, (l + 2) % 3);
        set(m, i, a, d, c);
        set(m, j, d, b, c);
        link2(m, 3 * i, ad);
        link2(m, 3 * i + 1, free_side(3 * j + 2));
        link2(m, 3 * i + 2, ca);
        link2(m, 3 * j, db);
        link2(m, 3 * j + 1, bc);
        push(m, 3 * i);
        push(m, 3 * j);
    }
}

/* The triangle that holds p, walking from `from`. *out_side: the side that p lies on, or 3. */
static uint32_t find(const struct mesh2 *m, struct planar_point p, uint32_t from, int *out_side)
{
    uint32_t t = from;
    for (size_t steps = 0; steps < 4 * m->triangle_count + 16; steps++) {
        int on = 3, leave = 3;
        for (int i = 0; i < 3; i++) {
            int k = (i + (int)(steps % 3)) % 3; /* no fixed order, or a walk could go in circles */
            const struct planar_triangle *x = &m->triangles[t];
            int64_t s = planar_orient(m->points[x->v[k]], m->points[x->v[(k + 1) % 3]], p);
            if (s < 0) {
                leave = k;
                break;
            }
            if (s == 0)
                on = k;
        }
        if (leave == 3) {
            *out_side = on;
            return t;
        }
        uint32_t next = m->triangles[t].near[leave];
        if (next == PLANAR_NONE)
            return PLANAR_NONE;
        t = next / 3;
    }
    return PLANAR_NONE;
}

static void insert(struct mesh2 *m, struct planar_point p, float value, uint32_t t, int side)
{
    if (!room(m))
        return;
    uint32_t n = (uint32_t)m->point_count;
    const struct planar_triangle old = m->triangles[t];
    for (int k = 0; k < 3; k++)
        if (planar_same(m->points[old.v[k]], p))
            return;
    m->points[n] = p;
    m->values[n] = value;
    m->jump[n] = 0;
    m->point_count++;
    uint32_t u = (uint32_t)m->triangle_count;
    if (side == 3) {
        uint32_t a = old.v[0], b = old.v[1], c = old.v[2];
        struct side ab = side_of(m, t, 0), bc = side_of(m, t, 1), ca = side_of(m, t, 2);
        m->triangle_count += 2;
        set(m, t, a, b, n);
        set(m, u, b, c, n);
        set(m, u + 1, c, a, n);
        link2(m, 3 * t, ab);
        link2(m, 3 * u, bc);
        link2(m, 3 * (u + 1), ca);
        link2(m, 3 * t + 1, free_side(3 * u + 2));
        link2(m, 3 * u + 1, free_side(3 * (u + 1) + 2));
        link2(m, 3 * (u + 1) + 1, free_side(3 * t + 2));
        push(m, 3 * t);
        push(m, 3 * u);
        push(m, 3 * (u + 1));
    } else {
        /* On the side a-b; the triangle beyond, if any, is a d b. */
        uint32_t k = (uint32_t)side;
        uint32_t a = old.v[k], b = old.v[(k + 1) % 3], c = old.v[(k + 2) % 3];
        struct side ab = side_of(m, t, k), bc = side_of(m, t, (k + 1) % 3),
                    ca = side_of(m, t, (k + 2) % 3);
        m->jump[n] = ab.fixed;
        if (ab.near == PLANAR_NONE) {
            m->triangle_count += 1;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * t + 2, free_side(3 * u + 1));
            push(m, 3 * t);
            push(m, 3 * u);
        } else {
            uint32_t s = ab.near / 3, l = ab.near % 3;
            uint32_t d = m->triangles[s].v[(l + 2) % 3];
            struct side ad = side_of(m, s, (l + 1) % 3), db = side_of(m, s, (l + 2) % 3);
            m->triangle_count += 2;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            set(m, s, a, d, n);
            set(m, u + 1, d, b, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * s, ad);
            link2(m, 3 * (u + 1), db);
            /* a-n and n-b are what a-b was. */
            link2(m, 3 * t + 1, (struct side){3 * s + 2, ab.fixed});
            link2(m, 3 * s + 1, free_side(3 * (u + 1) + 2));
            link2(m, 3 * (u + 1) + 1, (struct side){3 * u + 2, ab.fixed});
            link2(m, 3 * u + 1, free_side(3 * t + 2));
            push(m, 3 * t);
            push(m, 3 * u);
            push(m, 3 * s);
            push(m, 3 * (u + 1));
        }
    }
    legalize(m);
}

/* What is to be meshed, grid units. */
struct region {
    struct planar_point lo, hi;               /* all of it */
    struct planar_point shadow_lo, shadow_hi; /* where occluders' shadows can be */
    int start;                                /* cells along the longer side at the beginning */
    struct planar_point dark[8];              /* the part on the light's dark side, a polygon */
    int dark_count;
};

/* The outlines of what stands on the plane. */
struct foot {
    struct planar_point *ends; /* two per edge */
    size_t count, capacity;
};

static bool in_foot(const struct foot *foot, double x, double y)
{
    bool in = false;
    for (size_t i = 0; i < foot->count; i++) {
        struct planar_point a = foot->ends[2 * i], b = foot->ends[2 * i + 1];
        if ((a.y > y) != (b.y > y) &&
            x < a.x + (y - a.y) / ((double)b.y - a.y) * ((double)b.x - a.x))
            in = !in;
    }
    return in;
}

static pnb_status find_foot(struct shadow_builder *b, const struct shadow_plane *plane,
                            const struct region *region, struct foot *foot)
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
    for (int i = 0; i < region->dark_count && !status; i++) {
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
        foot->ends[2 * foot->count] = r.points[e->left];
        foot->ends[2 * foot->count++ + 1] = r.points[e->right];
    }
    silhouette_outline_finish(b->context, &outline);
    planar_input_finish(b->context, &in);
    return status;
}

static uint32_t add_foot_point(struct mesh2 *m, struct planar_point p)
{
    int side;
    uint32_t t = find(m, p, (uint32_t)m->triangle_count - 1, &side);
    if (t == PLANAR_NONE)
        return PLANAR_NONE;
    for (int k = 0; k < 3; k++)
        if (planar_same(m->points[m->triangles[t].v[k]], p)) {
            m->jump[m->triangles[t].v[k]] = 1;
            return m->triangles[t].v[k];
        }
    size_t before = m->point_count;
    insert(m, p, 1, t, side);
    if (m->point_count == before)
        return PLANAR_NONE;
    m->jump[before] = 1;
    return (uint32_t)before;
}

/* Makes a-b an edge of the mesh, or a chain of edges through points put between them. */
static void force_edge(struct mesh2 *m, uint32_t a, uint32_t b, int depth)
{
    if (a == PLANAR_NONE || b == PLANAR_NONE || a == b || m->no_memory)
        return;
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++) {
        const uint32_t *v = m->triangles[i / 3].v;
        if (v[i % 3] == a && v[(i % 3 + 1) % 3] == b) {
            fix(m, i);
            return;
        }
    }
    if (depth > 10)
        return;
    struct planar_point p = m->points[a], q = m->points[b];
    struct planar_point middle = {(int32_t)floor(0.5 * ((double)p.x + q.x)),
                                  (int32_t)floor(0.5 * ((double)p.y + q.y))};
    uint32_t c = add_foot_point(m, middle);
    force_edge(m, a, c, depth + 1);
    force_edge(m, c, b, depth + 1);
}

/* Where tests are made: weights of the three corners. */
static const double tests[TESTS][3] = {
    {1 / 3.0, 1 / 3.0, 1 / 3.0}, {0.5, 0.5, 0},      {0, 0.5, 0.5},      {0.5, 0, 0.5},
    {0.62, 0.19, 0.19},          {0.19, 0.62, 0.19}, {0.19, 0.19, 0.62}, {0.44, 0.44, 0.12},
    {0.12, 0.44, 0.44},          {0.44, 0.12, 0.44},
};

static struct planar_point test_point(const struct mesh2 *m, const struct planar_triangle *t, int k)
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

static struct planar_point on_grid(const struct shadow_plane *plane, const double *p)
{
    return (struct planar_point){(int32_t)floor((p[0] - plane->center[0]) * plane->scale + 0.5),
                                 (int32_t)floor((p[1] - plane->center[1]) * plane->scale + 0.5)};
}

/* The part of the receiver's box behind a one-sided light's plane. */
static void find_dark_side(const struct shadow_plane *plane, const struct light_shape *shape,
                           struct region *r)
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

/* False: no shadow can fall on the receiver. */
static bool find_region(struct shadow_plane *plane, const struct shadow_cluster *clusters,
                        size_t count, const struct light_shape *shape, double far, struct region *r)
{
    enum { per_cluster = 24 };
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    bool everywhere = false;
    *r = (struct region){.start = GRID_START};
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
    r->lo = r->dark_count ? on_grid(plane, plane->lo) : r->shadow_lo;
    r->hi = r->dark_count ? on_grid(plane, plane->hi) : r->shadow_hi;
    return true;
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

static void start(struct mesh2 *m, struct planar_point lo, struct planar_point hi)
{
    struct planar_point corners[4] = {lo, {hi.x, lo.y}, hi, {lo.x, hi.y}};
    for (int i = 0; i < 4 && room(m); i++) {
        m->points[m->point_count] = corners[i];
        m->jump[m->point_count] = 0;
        m->values[m->point_count++] = 0;
    }
    if (!room(m))
        return;
    m->triangle_count = 2;
    set(m, 0, 0, 1, 2);
    set(m, 1, 0, 2, 3);
    link2(m, 2, free_side(3));
}

static void add_grid(struct mesh2 *m, struct planar_point lo, struct planar_point hi, int cells)
{
    double w = (double)hi.x - lo.x, h = (double)hi.y - lo.y;
    int nx = (int)fmax(2, w > h ? cells : cells * w / h + 0.5);
    int ny = (int)fmax(2, w > h ? cells * h / w + 0.5 : cells);
    for (int j = 0; j <= ny; j++)
        for (int i = 0; i <= nx; i++) {
            struct planar_point p = {lo.x + (int32_t)(w * i / nx), lo.y + (int32_t)(h * j / ny)};
            int side;
            uint32_t t = find(m, p, (uint32_t)m->triangle_count - 1, &side);
            if (t != PLANAR_NONE)
                insert(m, p, 0, t, side);
        }
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
    struct mesh2 m;
    struct foot foot;
    struct planar_point *points;
    struct trial *trials;
    float *found;
    struct candidate *candidates;
    size_t points_capacity, trial_capacity, found_capacity, candidate_capacity;
};

/* Collects the points that new triangles ask about. */
static pnb_status collect(struct refining *r, size_t *out_trials, size_t *out_points)
{
    struct mesh2 *m = &r->m;
    size_t count = 0, points = 0;
    for (uint32_t i = 0; i < m->triangle_count; i++) {
        struct planar_triangle *t = &m->triangles[i];
        struct corners *corner = &m->corners[i];
        if (t->level < 0)
            continue;
        t->level = -1;
        struct planar_point a = m->points[t->v[0]], b = m->points[t->v[1]], c = m->points[t->v[2]];
        double x = ((double)a.x + b.x + c.x) / 3, y = ((double)a.y + b.y + c.y) / 3;
        bool jumps = m->jump[t->v[0]] || m->jump[t->v[1]] || m->jump[t->v[2]];
        corner->inside = r->foot.count > 0 && in_foot(&r->foot, x, y);
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
    struct mesh2 *m = &r->m;
    size_t wanted = 0;
    for (size_t i = 0; i < trials; i++) {
        const struct trial *trial = &r->trials[i];
        const struct planar_triangle *t = &m->triangles[trial->triangle];
        struct corners *corner = &m->corners[trial->triangle];
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
    struct mesh2 *m = &r->m;
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
            uint32_t t = find(m, r->candidates[i].p, r->candidates[i].triangle, &side);
            if (t != PLANAR_NONE && m->triangles[t].level < 0)
                insert(m, r->candidates[i].p, r->candidates[i].value, t, side);
        }
        if (m->no_memory)
            return status_no_memory(m->context, 0);
    }
    return status;
}

static pnb_status copy_out(const struct mesh2 *m, const struct shadow_plane *plane,
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
    struct region region;
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
    if (!status && find_region(plane, clusters, cluster_count, &shape, far, &region)) {
        r.smallest = SMALLEST * fmax((double)region.shadow_hi.x - region.shadow_lo.x,
                                     (double)region.shadow_hi.y - region.shadow_lo.y);
        start(&r.m, region.lo, region.hi);
        add_grid(&r.m, region.shadow_lo, region.shadow_hi, region.start);
        status = find_foot(b, plane, &region, &r.foot);
        if (r.foot.count > FOOT_EDGES_MAX)
            r.foot.count = 0;
        for (size_t i = 0; i < r.foot.count && !status; i++)
            force_edge(&r.m, add_foot_point(&r.m, r.foot.ends[2 * i]),
                       add_foot_point(&r.m, r.foot.ends[2 * i + 1]), 0);
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
