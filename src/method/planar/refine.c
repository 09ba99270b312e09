/* method/planar/refine.c: a shadow mesh with a promised error.
 *
 * A Delaunay triangulation of the part of the plane that the shadow can reach starts as a plain
 * grid. Each new triangle is tested: the exact shadow at ten points of it against what its corners
 * interpolate to. Where the difference exceeds SAFETY x tolerance, the worst point becomes a vertex
 * (or the middle of the longest side, where the triangle is thin). In rounds: all tests of a round
 * are one call for visibility; a triangle that an insertion of the same round has changed waits for
 * the next. So triangles are few where the shadow is smooth.
 *
 * Where the shadow jumps, along the line in which an occluder touches the plane, no mesh of
 * continuous values can follow; there refinement ends at SMALLEST of the shadow's size. What lies
 * under the occluder's foot and outside it differs by a step across that width.
 *
 * Coordinates are on the grid of planar/, insertion and in-circle test are exact. Cost: about 40
 * visibilities per triangle in the end. Deterministic.
 */
#include <string.h>

#include "method/planar/room.h"

#define GRID_START    16
#define SAFETY        0.7
#define SMALLEST      (1.0 / 1500)
#define TESTS         10
#define ROUNDS_MAX    60
#define TRIANGLES_MAX 4000000

struct mesh2 {
    pnb_context *context;
    struct planar_point *points;
    float *values;
    size_t point_count, point_capacity, value_capacity;
    struct planar_triangle *triangles; /* level: the round that made it, -1 - round once tested */
    size_t triangle_count, triangle_capacity;
    uint32_t *stack;
    size_t stack_count, stack_capacity;
    int32_t round;
    bool no_memory;
};

static bool room(struct mesh2 *m)
{
    m->no_memory = m->no_memory ||
                   !memory_reserve(m->context, (void **)&m->points, &m->point_capacity,
                                   m->point_count, 1, sizeof(*m->points)) ||
                   !memory_reserve(m->context, (void **)&m->values, &m->value_capacity,
                                   m->point_count, 1, sizeof(*m->values)) ||
                   !memory_reserve(m->context, (void **)&m->triangles, &m->triangle_capacity,
                                   m->triangle_count, 2, sizeof(*m->triangles));
    return !m->no_memory;
}

static void link2(struct mesh2 *m, uint32_t half, uint32_t other)
{
    m->triangles[half / 3].near[half % 3] = other;
    if (other != PLANAR_NONE)
        m->triangles[other / 3].near[other % 3] = half;
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
        (struct planar_triangle){{a, b, c}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, m->round};
}

/* Lawson: sides opposite to the new point p, which is corner 2 of their triangle's side. */
static void legalize(struct mesh2 *m)
{
    while (m->stack_count > 0 && !m->no_memory) {
        uint32_t half = m->stack[--m->stack_count], i = half / 3, k = half % 3;
        struct planar_triangle *t = m->triangles;
        uint32_t other = t[i].near[k];
        if (other == PLANAR_NONE)
            continue;
        uint32_t j = other / 3, l = other % 3;
        uint32_t a = t[i].v[k], b = t[i].v[(k + 1) % 3], c = t[i].v[(k + 2) % 3],
                 d = t[j].v[(l + 2) % 3];
        if (!planar_in_circle(m->points[a], m->points[b], m->points[c], m->points[d]))
            continue;
        uint32_t bc = t[i].near[(k + 1) % 3], ca = t[i].near[(k + 2) % 3];
        uint32_t ad = t[j].near[(l + 1) % 3], db = t[j].near[(l + 2) % 3];
        set(m, i, a, d, c);
        set(m, j, d, b, c);
        link2(m, 3 * i, ad);
        link2(m, 3 * i + 1, 3 * j + 2);
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
    m->points[m->point_count] = p;
    m->values[m->point_count++] = value;
    uint32_t u = (uint32_t)m->triangle_count;
    if (side == 3) {
        uint32_t a = old.v[0], b = old.v[1], c = old.v[2];
        m->triangle_count += 2;
        set(m, t, a, b, n);
        set(m, u, b, c, n);
        set(m, u + 1, c, a, n);
        link2(m, 3 * t, old.near[0]);
        link2(m, 3 * u, old.near[1]);
        link2(m, 3 * (u + 1), old.near[2]);
        link2(m, 3 * t + 1, 3 * u + 2);
        link2(m, 3 * u + 1, 3 * (u + 1) + 2);
        link2(m, 3 * (u + 1) + 1, 3 * t + 2);
        push(m, 3 * t);
        push(m, 3 * u);
        push(m, 3 * (u + 1));
    } else {
        /* On the side a-b; the triangle beyond, if any, is a d b. */
        uint32_t a = old.v[side], b = old.v[(side + 1) % 3], c = old.v[(side + 2) % 3];
        uint32_t bc = old.near[(side + 1) % 3], ca = old.near[(side + 2) % 3];
        uint32_t beyond = old.near[side];
        if (beyond == PLANAR_NONE) {
            m->triangle_count += 1;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * t + 2, 3 * u + 1);
            push(m, 3 * t);
            push(m, 3 * u);
        } else {
            uint32_t s = beyond / 3, l = beyond % 3;
            const struct planar_triangle far = m->triangles[s];
            uint32_t d = far.v[(l + 2) % 3], ad = far.near[(l + 1) % 3], db = far.near[(l + 2) % 3];
            m->triangle_count += 2;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            set(m, s, a, d, n);
            set(m, u + 1, d, b, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * s, ad);
            link2(m, 3 * (u + 1), db);
            link2(m, 3 * t + 1, 3 * s + 2);
            link2(m, 3 * s + 1, 3 * (u + 1) + 2);
            link2(m, 3 * (u + 1) + 1, 3 * u + 2);
            link2(m, 3 * u + 1, 3 * t + 2);
            push(m, 3 * t);
            push(m, 3 * u);
            push(m, 3 * s);
            push(m, 3 * (u + 1));
        }
    }
    legalize(m);
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

/* The part of the receiver that the shadow can reach, grid units. */
static bool reach(struct shadow_plane *plane, const struct shadow_cluster *clusters, size_t count,
                  const struct light_shape *shape, double far, struct planar_point *out_lo,
                  struct planar_point *out_hi)
{
    enum { per_cluster = 24 };
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    bool everything = false;
    vec3 normal = v3(v3_dot(shape->normal, plane->frame.u), v3_dot(shape->normal, plane->frame.v),
                     v3_dot(shape->normal, plane->frame.n));
    bool one_sided = shape->light.type == PNB_LIGHT_RECTANGLE ||
                     shape->light.type == PNB_LIGHT_DISK || shape->light.type == PNB_LIGHT_POLYGON;
    everything = one_sided && !(normal.z < 0 && fabs(normal.x) + fabs(normal.y) < 1e-6);
    for (size_t c = 0; c < count; c++) {
        vec3 samples[per_cluster];
        shadow_samples(&clusters[c], SHADOW_BORDER, per_cluster, plane->frame.origin, far, samples);
        for (int k = 0; k < per_cluster; k++) {
            vec3 l = silhouette_to_plane(&plane->frame, samples[k]);
            for (size_t i = 0; i < plane->occluder_count; i++) {
                const struct silhouette_occluder *o = &plane->occluders[i];
                if (o->highest >= 0.999 * l.z) {
                    everything = true;
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
    for (int axis = 0; axis < 2; axis++) {
        /* 24 points of the border are not all of it. */
        double room = 0.1 * (hi[axis] - lo[axis]);
        lo[axis] = everything ? plane->lo[axis] : fmax(plane->lo[axis], lo[axis] - room);
        hi[axis] = everything ? plane->hi[axis] : fmin(plane->hi[axis], hi[axis] + room);
        if (!(lo[axis] < hi[axis]))
            return false;
    }
    *out_lo = (struct planar_point){(int32_t)floor((lo[0] - plane->center[0]) * plane->scale),
                                    (int32_t)floor((lo[1] - plane->center[1]) * plane->scale)};
    *out_hi = (struct planar_point){(int32_t)ceil((hi[0] - plane->center[0]) * plane->scale),
                                    (int32_t)ceil((hi[1] - plane->center[1]) * plane->scale)};
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
    /* Two triangles, then the grid's other points. */
    struct planar_point corners[4] = {lo, {hi.x, lo.y}, hi, {lo.x, hi.y}};
    for (int i = 0; i < 4 && room(m); i++) {
        m->points[m->point_count] = corners[i];
        m->values[m->point_count++] = 0;
    }
    if (!room(m))
        return;
    m->triangle_count = 2;
    set(m, 0, 0, 1, 2);
    set(m, 1, 0, 2, 3);
    link2(m, 2, 3);
    double w = (double)hi.x - lo.x, h = (double)hi.y - lo.y;
    int nx = GRID_START, ny = GRID_START;
    if (w > h)
        ny = (int)fmax(2, GRID_START * h / w + 0.5);
    else
        nx = (int)fmax(2, GRID_START * w / h + 0.5);
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

pnb_status shadow_refine(struct shadow_builder *b, struct shadow_plane *plane,
                         const pnb_light *light, const struct shadow_settings *settings,
                         struct shadow_part *part)
{
    pnb_context *context = b->context;
    struct mesh2 m = {.context = context};
    struct light_shape shape;
    struct shadow_cluster *clusters = NULL;
    size_t cluster_count = 0;
    struct planar_point lo, hi, *points = NULL;
    uint32_t *tested = NULL;
    float *found = NULL;
    struct candidate *candidates = NULL;
    size_t points_capacity = 0, tested_capacity = 0, found_capacity = 0, candidate_capacity = 0;
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
    if (status || !reach(plane, clusters, cluster_count, &shape, far, &lo, &hi))
        goto end;
    start(&m, lo, hi);
    if (m.no_memory) {
        status = status_no_memory(context, 0);
        goto end;
    }
    status = shadows(b, plane, light, m.points, m.point_count, m.values);
    double smallest = SMALLEST * fmax((double)hi.x - lo.x, (double)hi.y - lo.y);
    for (int round = 0; round < ROUNDS_MAX && !status; round++) {
        /* Test points of all triangles that are new. */
        size_t count = 0;
        for (uint32_t i = 0; i < m.triangle_count && !status; i++) {
            struct planar_triangle *t = &m.triangles[i];
            if (t->level < 0)
                continue;
            double longest = fmax(length2(m.points[t->v[0]], m.points[t->v[1]]),
                                  fmax(length2(m.points[t->v[1]], m.points[t->v[2]]),
                                       length2(m.points[t->v[2]], m.points[t->v[0]])));
            t->level = -1;
            if (longest < smallest * smallest)
                continue;
            if (!memory_reserve(context, (void **)&points, &points_capacity, TESTS * count, TESTS,
                                sizeof(*points)) ||
                !memory_reserve(context, (void **)&tested, &tested_capacity, count, 1,
                                sizeof(*tested))) {
                status = status_no_memory(context, 0);
                break;
            }
            for (int k = 0; k < TESTS; k++)
                points[TESTS * count + (size_t)k] = test_point(&m, t, k);
            tested[count++] = i;
        }
        if (count == 0 || status || m.triangle_count > TRIANGLES_MAX)
            break;
        if (!memory_reserve(context, (void **)&found, &found_capacity, 0, TESTS * count,
                            sizeof(*found)) ||
            !memory_reserve(context, (void **)&candidates, &candidate_capacity, 0, count,
                            sizeof(*candidates))) {
            status = status_no_memory(context, 0);
            break;
        }
        status = shadows(b, plane, light, points, TESTS * count, found);
        /* The worst point of each triangle that is off. */
        size_t wanted = 0;
        for (size_t i = 0; i < count && !status; i++) {
            const struct planar_triangle *t = &m.triangles[tested[i]];
            double worst = 0;
            int at = 0;
            for (int k = 0; k < TESTS; k++) {
                double linear = 0;
                for (int c = 0; c < 3; c++)
                    linear += tests[k][c] * m.values[t->v[c]];
                double error = fabs(linear - found[TESTS * i + (size_t)k]);
                if (error > worst) {
                    worst = error;
                    at = k;
                }
            }
            if (worst <= SAFETY * settings->tolerance)
                continue;
            /* Thin triangles: the middle of the longest side. */
            double l[3];
            int longest = 0;
            for (int k = 0; k < 3; k++) {
                l[k] = length2(m.points[t->v[k]], m.points[t->v[(k + 1) % 3]]);
                longest = l[k] > l[longest] ? k : longest;
            }
            double area =
                (double)planar_orient(m.points[t->v[0]], m.points[t->v[1]], m.points[t->v[2]]);
            if (area < 0.4 * l[longest])
                at = 1 + longest;
            candidates[wanted++] = (struct candidate){tested[i], points[TESTS * i + (size_t)at],
                                                      found[TESTS * i + (size_t)at]};
        }
        m.round = 1;
        for (size_t i = 0; i < wanted && !m.no_memory; i++) {
            int side;
            uint32_t t = find(&m, candidates[i].p, candidates[i].triangle, &side);
            if (t != PLANAR_NONE && m.triangles[t].level < 0)
                insert(&m, candidates[i].p, candidates[i].value, t, side);
        }
        if (m.no_memory)
            status = status_no_memory(context, 0);
        if (wanted == 0)
            break;
    }
    if (status)
        goto end;
    if (!memory_reserve(context, (void **)&part->points, &part->point_capacity, 0, m.point_count,
                        2 * sizeof(*part->points)) ||
        !memory_reserve(context, (void **)&part->triangles, &part->triangle_capacity, 0,
                        m.triangle_count, sizeof(*part->triangles))) {
        status = status_no_memory(context, m.point_count * 16);
        goto end;
    }
    for (size_t i = 0; i < m.point_count; i++) {
        part->points[2 * i] = plane->center[0] + m.points[i].x / plane->scale;
        part->points[2 * i + 1] = plane->center[1] + m.points[i].y / plane->scale;
    }
    part->point_count = m.point_count;
    for (size_t i = 0; i < m.triangle_count; i++) {
        const struct planar_triangle *t = &m.triangles[i];
        float a = m.values[t->v[0]], c = m.values[t->v[1]], d = m.values[t->v[2]];
        if (a == 0 && c == 0 && d == 0)
            continue;
        part->triangles[part->triangle_count++] =
            (struct shadow_triangle){{t->v[0], t->v[1], t->v[2]}, {a, c, d}, -1};
    }
end:
    memory_free(context, m.points);
    memory_free(context, m.values);
    memory_free(context, m.triangles);
    memory_free(context, m.stack);
    memory_free(context, points);
    memory_free(context, tested);
    memory_free(context, found);
    memory_free(context, candidates);
    memory_free(context, clusters);
    light_shape_finish(context, &shape);
    return status;
}
