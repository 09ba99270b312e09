/* method/exact/exact_tile.c: some tens of neighbouring receivers share the search for the edges
 * that can matter to any of them.
 *
 * Light frame. With c the middle of the receivers, L that of the light and n its normal, a point is
 *     x = c + (a / bins) u + (b / rows) v + h (c - L),   h = n.(x - c) / n.(c - L)
 * so that the light lies at h = -1, the receivers about h = 0, and the way from c to the middle of
 * the light along a = b = 0. Seen from an eye p, an occluder's point x falls on the grid at
 *     bins / 2 + p.a + (x.a - p.a) (1 + p.h) / (p.h - x.h)
 * All numbers are of the size of the light in bins, and x - c is subtracted before anything is
 * multiplied: single precision does. A sun's frame has h = -n.(x - c) along its direction, and
 *     bins / 2 + (x.a - p.a) / (p.h - x.h).
 *
 * The chain. Turn every triangle of the occluders towards the eye; the number of triangles between
 * the eye and a point of the light is the winding number of their borders around it, and a sample
 * is hidden where it is above zero. Each edge counts with the sum of its triangles' turns: nothing
 * inside a sheet that faces one way, twice on a silhouette, once on an open border. What the shaft
 * from the receivers to the light cannot touch is left out; the border of what is kept then counts
 * too. A triangle is `dropped`, seen from the `front` or `back` by all receivers, or `open`.
 *
 * Kept triangles lie with all corners between the receivers' heights and the light's, with some
 * room. Others that reach into the shaft (about the receivers' own surface, or through the light's
 * plane) are `loose`: they are dropped from the chain and clipped one by one, in double precision
 * (exact_cover.c). Where no frame makes sense (a receiver in a line light's axis, or in the light's
 * plane) all triangles near are loose.
 *
 * Cost: O(clusters in the shaft) per tile, then O(edges kept) per receiver.
 */
#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "method/exact/exact.h"

enum { DROPPED = 0, FRONT, BACK, OPEN, MIXED }; /* MIXED: of clusters */

#define PLANES_MAX 7

struct frame {
    bool loose; /* no frame: rows are the world's axes, and all triangles are loose */
    vec3 c;
    vec3 rows[3];                     /* a, b, h of x - c */
    vec3 view_u, view_v, view_center; /* the light; center relative to c unless a sun's */
    double reach;
    double planes[PLANES_MAX][4]; /* over a, b, h, 1: above zero means out of the shaft */
    int plane_count;
    double h_low, h_high; /* corners in between are kept in the chain */
    struct exact_eye eyes[EXACT_TILE];
    vec3 extent; /* half the size of the receivers' box around c, world */
};

static bool frame_axes(const struct exact_light *light, struct frame *f, vec3 *out_normal,
                       double *out_height)
{
    vec3 d = v3_sub(f->c, light->center);
    f->view_u = light->u, f->view_v = light->v;
    f->view_center = light->sun ? light->center : v3_scale(d, -1);
    f->reach = light->sun ? 0 : 1 - TOLERANCE_LIGHT_GAP;
    double distance = v3_length(d);
    vec3 n = light->normal;
    if (light->type == PNB_LIGHT_LINE) {
        n = v3_mad(d, light->u, -v3_dot(d, light->u) / v3_dot(light->u, light->u));
        *out_height = v3_length(n);
        n = v3_normalize(n);
        f->view_v = v3_scale(v3_cross(n, light->u), 1);
    } else if (light->type == PNB_LIGHT_POINT) {
        n = v3_normalize(d);
        *out_height = distance;
        v3_frame(n, &f->view_u, &f->view_v);
        f->view_u = v3_scale(f->view_u, distance);
        f->view_v = v3_scale(f->view_v, distance);
    } else if (light->sun) {
        n = light->normal;
        *out_height = 1;
        *out_normal = n;
        return true;
    } else {
        *out_height = v3_dot(n, d);
    }
    *out_normal = n;
    return *out_height > distance * (1.0 / 4096) && *out_height > 0;
}

/* The tile's frame; false: the receivers are too far apart for one, split them. */
static bool frame_init(const struct exact_job *job, const struct exact_point *points, size_t count,
                       struct frame *f)
{
    const struct exact_light *light = job->light;
    double sink = light->sun ? 0 : 0.75 * job->lift;
    vec3 low = points[0].p, high = points[0].p;
    for (size_t i = 1; i < count; i++) {
        low = v3_min(low, points[i].p);
        high = v3_max(high, points[i].p);
    }
    f->c = v3_scale(v3_add(low, high), 0.5);
    f->extent = v3_scale(v3_sub(high, low), 0.5);
    /* The box's middle may lie on the light's other side; its receivers do not. */
    if (light->one_sided && count > 1 && !(v3_dot(light->normal, v3_sub(f->c, light->center)) > 0))
        return false;

    vec3 n;
    double height;
    f->loose = !frame_axes(light, f, &n, &height);
    if (f->loose && count > 1)
        return false;
    double bins = light->grid.bins, rows = light->grid.rows;
    f->plane_count = 0;
    if (f->loose) {
        /* The box around the receiver and the light. */
        f->rows[0] = v3(1, 0, 0), f->rows[1] = v3(0, 1, 0), f->rows[2] = v3(0, 0, 1);
        for (int i = 0; i < 4; i++) {
            vec3 corner = v3_mad(f->view_center, f->view_u, i & 1 ? 0.5 : -0.5);
            corner = v3_add(f->c, v3_mad(corner, f->view_v, i & 2 ? 0.5 : -0.5));
            low = v3_min(low, corner);
            high = v3_max(high, corner);
        }
        low = v3_sub(low, f->c), high = v3_sub(high, f->c);
        double slack = 1e-6 * v3_max_abs(v3_sub(high, low));
        const double bounds[6] = {low.x, low.y, low.z, high.x, high.y, high.z};
        for (int i = 0; i < 6; i++) {
            double *plane = f->planes[f->plane_count++];
            memset(plane, 0, 4 * sizeof(*plane));
            plane[i % 3] = i < 3 ? -1 : 1;
            plane[3] = (i < 3 ? bounds[i] : -bounds[i]) - slack;
        }
        f->h_low = 1, f->h_high = 0;
        memset(&f->eyes[0], 0, sizeof(f->eyes[0]));
        return true;
    }

    /* Dual vectors of u and v, then the oblique third axis. */
    vec3 cross = v3_cross(f->view_u, f->view_v);
    double area2 = v3_dot(cross, cross);
    vec3 du = v3_scale(v3_cross(f->view_v, cross), bins / area2);
    vec3 dv = v3_scale(v3_cross(cross, f->view_u), rows / area2);
    if (light->sun) {
        f->rows[2] = n; /* the way the light travels */
        f->rows[0] = v3_mad(du, n, -v3_dot(du, n));
        f->rows[1] = v3_mad(dv, n, -v3_dot(dv, n));
    } else {
        vec3 d = v3_sub(f->c, light->center);
        f->rows[2] = v3_scale(n, 1 / height);
        f->rows[0] = v3_mad(du, f->rows[2], -v3_dot(du, d));
        f->rows[1] = v3_mad(dv, f->rows[2], -v3_dot(dv, d));
    }

    /* Eyes, and the planes that bound all their shafts: |a| <= bins/2 at the light. */
    double right = -INFINITY, left = INFINITY, top = -INFINITY, bottom = INFINITY;
    double h_min = INFINITY, h_max = -INFINITY;
    double half[2] = {0.5 * bins, 0.5 * rows};
    for (size_t i = 0; i < count; i++) {
        vec3 d = v3_sub(points[i].p, f->c);
        double a = v3_dot(f->rows[0], d), b = v3_dot(f->rows[1], d), h = v3_dot(f->rows[2], d);
        struct exact_eye *eye = &f->eyes[i];
        *eye = (struct exact_eye){.a = (float)a, .b = (float)b, .h = (float)h};
        h_min = fmin(h_min, h), h_max = fmax(h_max, h);
        double row_base = half[1] - light->grid.row_shift;
        if (light->sun) {
            eye->scale = 1;
            eye->x = (float)half[0], eye->y = (float)row_base;
            right = fmax(right, a + half[0] * h), left = fmin(left, a - half[0] * h);
            top = fmax(top, b + half[1] * h), bottom = fmin(bottom, b - half[1] * h);
        } else {
            double eta = 1 + h;
            eye->scale = (float)eta;
            eye->x = (float)(half[0] + a), eye->y = (float)(row_base + b);
            right = fmax(right, (a - half[0]) / eta), left = fmin(left, (a + half[0]) / eta);
            top = fmax(top, (b - half[1]) / eta), bottom = fmin(bottom, (b + half[1]) / eta);
        }
    }
    bool around = light->type == PNB_LIGHT_LINE || light->type == PNB_LIGHT_POINT;
    if (around && count > 1 && !(h_min > -0.5 && h_max < 1))
        return false;
    double slack = 0.01;
    if (light->sun) {
        const double sides[4][4] = {{1, 0, half[0], -right - slack},
                                    {-1, 0, half[0], left - slack},
                                    {0, 1, half[1], -top - slack},
                                    {0, -1, half[1], bottom - slack}};
        memcpy(f->planes, sides, sizeof(sides));
    } else {
        const double sides[4][4] = {{1, 0, -right, -half[0] - right - slack},
                                    {-1, 0, left, -half[0] + left - slack},
                                    {0, 1, -top, -half[1] - top - slack},
                                    {0, -1, bottom, -half[1] + bottom - slack}};
        memcpy(f->planes, sides, sizeof(sides));
    }
    const double behind[4] = {0, 0, 1, -h_max};
    memcpy(f->planes[4], behind, sizeof(behind));
    f->plane_count = 5;
    double room = fmax((h_max - h_min) / 16, 1e-5);
    if (light->sun)
        room = fmax((h_max - h_min) / 16, 1e-6 * v3_max_abs(v3_add(f->c, f->extent)));
    f->h_high = h_min - room;
    f->h_low = -INFINITY;
    if (!light->sun) {
        const double beyond[4] = {0, 0, -1, -1 + TOLERANCE_LIGHT_GAP * (1 + h_min)};
        memcpy(f->planes[f->plane_count++], beyond, sizeof(beyond));
        f->h_low = -1 + TOLERANCE_LIGHT_GAP * (1 + h_max);
    }

    /* Where all receivers look the same way, nothing below their tangent planes matters. The planes
     * are those before the lift, but for a quarter of it: their own surface must not count. */
    vec3 up = points[0].n;
    bool flat = v3_dot(up, up) > 0;
    double floor = INFINITY;
    for (size_t i = 0; i < count && flat; i++) {
        flat = v3_max_abs(v3_sub(points[i].n, up)) < 1e-6;
        floor = fmin(floor, v3_dot(up, v3_sub(points[i].p, f->c)));
    }
    if (flat) {
        /* up.(x - c) - floor in a, b, h: up = sum of rows times up along the frame's axes. */
        double *plane = f->planes[f->plane_count++];
        vec3 third = light->sun ? n : v3_sub(f->c, light->center);
        plane[0] = -v3_dot(up, f->view_u) / bins;
        plane[1] = -v3_dot(up, f->view_v) / rows;
        plane[2] = -v3_dot(up, third);
        plane[3] = floor - sink;
    }
    return true;
}

/* One instance in the tile's frame. */
struct local {
    const struct exact_instance *instance;
    float origin[3];  /* c in mesh space, rounded */
    float rows[3][4]; /* a, b, h of a mesh point minus origin: three factors and a constant */
    float extent[3];  /* half the size of the receivers' box, mesh space */
    float center[3];  /* its middle minus origin */
    float planes[PLANES_MAX][4]; /* over the mesh point minus origin */
    float normals[3][3];         /* plane over (a, b, h) = normals x mesh normal */
    float turn;                  /* -1 where the frame mirrors */
};

static void local_init(const struct frame *f, const struct exact_instance *instance,
                       struct local *l)
{
    const double *m = instance->world_from_mesh, *inverse = instance->mesh_from_world;
    l->instance = instance;
    vec3 c = m34_point(inverse, f->c);
    l->origin[0] = (float)c.x, l->origin[1] = (float)c.y, l->origin[2] = (float)c.z;
    vec3 origin = v3_loadf(l->origin);
    vec3 error = v3_sub(m34_point(m, origin), f->c);
    double rows[3][4];
    for (int r = 0; r < 3; r++) {
        vec3 row = f->rows[r];
        rows[r][0] = row.x * m[0] + row.y * m[4] + row.z * m[8];
        rows[r][1] = row.x * m[1] + row.y * m[5] + row.z * m[9];
        rows[r][2] = row.x * m[2] + row.y * m[6] + row.z * m[10];
        rows[r][3] = v3_dot(row, error);
        for (int i = 0; i < 4; i++)
            l->rows[r][i] = (float)rows[r][i];
    }
    for (int p = 0; p < f->plane_count; p++)
        for (int i = 0; i < 4; i++) {
            double sum = i == 3 ? f->planes[p][3] : 0;
            for (int r = 0; r < 3; r++)
                sum += f->planes[p][r] * rows[r][i];
            l->planes[p][i] = (float)sum;
        }
    vec3 middle = v3_sub(c, origin);
    v3_storef(l->center, middle);
    const double e[3] = {f->extent.x, f->extent.y, f->extent.z};
    for (int i = 0; i < 3; i++) {
        double sum = 0;
        for (int k = 0; k < 3; k++)
            sum += fabs(inverse[4 * i + k]) * e[k];
        l->extent[i] = (float)(sum * 1.000001);
    }

    /* n.(A^-1 y) = (A^-T n).y: the inverse's columns are the frame's axes in mesh space. */
    vec3 ra = v3_load(rows[0]), rb = v3_load(rows[1]), rh = v3_load(rows[2]);
    vec3 axes[3] = {v3_cross(rb, rh), v3_cross(rh, ra), v3_cross(ra, rb)};
    double det = v3_dot(ra, axes[0]);
    for (int r = 0; r < 3; r++)
        v3_storef(l->normals[r], v3_scale(axes[r], 1 / det));
    l->turn = det < 0 ? -1 : 1;
}

static inline float box_low(const float q[4], const float origin[3], const float low[3],
                            const float high[3])
{
    float sum = q[3];
    for (int i = 0; i < 3; i++) {
        float a = q[i] * (low[i] - origin[i]), b = q[i] * (high[i] - origin[i]);
        sum += a < b ? a : b;
    }
    return sum;
}

/* Every face counts 1 out of the shaft, 2 on its border, 0 inside. */
static bool box_outside(const struct local *l, int plane_count, const float low[3],
                        const float high[3], bool *all_inside)
{
    *all_inside = true;
    for (int p = 0; p < plane_count; p++) {
        const float *q = l->planes[p];
        float least = q[3], most = q[3];
        for (int i = 0; i < 3; i++) {
            float a = q[i] * (low[i] - l->origin[i]), b = q[i] * (high[i] - l->origin[i]);
            least += a < b ? a : b;
            most += a < b ? b : a;
        }
        if (least > 0)
            return true;
        if (most > 0)
            *all_inside = false;
    }
    return false;
}

static inline void to_frame(const struct local *l, const float *p, float out[3])
{
    float x = p[0] - l->origin[0], y = p[1] - l->origin[1], z = p[2] - l->origin[2];
    for (int r = 0; r < 3; r++)
        out[r] = l->rows[r][0] * x + l->rows[r][1] * y + l->rows[r][2] * z + l->rows[r][3];
}

/* Which side of all its triangles' planes all receivers are on. */
static int cluster_side(const struct local *l, const struct cluster *k)
{
    float low = -k->offset_high, high = -k->offset_low, size = 0;
    for (int i = 0; i < 3; i++) {
        float middle = l->center[i] + (l->origin[i] - k->center[i]);
        float q0 = middle - l->extent[i], q1 = middle + l->extent[i];
        float n0 = k->normal_low[i], n1 = k->normal_high[i];
        float a = n0 * q0, b = n0 * q1, c = n1 * q0, d = n1 * q1;
        float ab0 = a < b ? a : b, ab1 = a < b ? b : a, cd0 = c < d ? c : d, cd1 = c < d ? d : c;
        low += ab0 < cd0 ? ab0 : cd0;
        high += ab1 > cd1 ? ab1 : cd1;
        size += fabsf(middle) + l->extent[i];
    }
    float slack = 4e-6f * size;
    return low > slack ? FRONT : high < -slack ? BACK : MIXED;
}

static void triangle_sides(const struct local *l, const struct cluster *k,
                           const float (*planes)[CLUSTER_SIZE], uint8_t *state)
{
    float middle[3], slack = 0;
    for (int i = 0; i < 3; i++) {
        middle[i] = l->center[i] + (l->origin[i] - k->center[i]);
        slack += fabsf(middle[i]) + l->extent[i];
    }
    slack *= 4e-6f;
    for (int t = 0; t < CLUSTER_SIZE; t++) {
        float height = planes[0][t] * middle[0] + planes[1][t] * middle[1] +
                       planes[2][t] * middle[2] - planes[3][t];
        float reach = fabsf(planes[0][t]) * l->extent[0] + fabsf(planes[1][t]) * l->extent[1] +
                      fabsf(planes[2][t]) * l->extent[2] + slack;
        state[t] = (uint8_t)(height > reach ? FRONT : height < -reach ? BACK : OPEN);
    }
}

static bool grow(struct exact_work *work, void **array, size_t *capacity, size_t count,
                 size_t extra, size_t size)
{
    if (count + extra <= *capacity)
        return true;
    if (!memory_reserve(work->context, array, capacity, count, extra, size)) {
        work->no_memory = true;
        return false;
    }
    return true;
}

/* A place for one more edge in blocks of EXACT_LANES; new blocks are zeroed: zero weights. */
static float *new_edge(struct exact_work *work, float **blocks, size_t *capacity, size_t *count,
                       size_t fields)
{
    size_t lane = *count % EXACT_LANES, used = *count / EXACT_LANES * fields * EXACT_LANES;
    if (lane == 0) {
        if (!grow(work, (void **)blocks, capacity, used, fields * EXACT_LANES, sizeof(float)))
            return NULL;
        memset(*blocks + used, 0, fields * EXACT_LANES * sizeof(float));
    }
    (*count)++;
    return *blocks + used + lane;
}

/* True if the edge cannot meet a row's samples: wholly right of, above or below the light. */
static inline bool edge_misses(const struct frame *f, const float a[3], const float b[3])
{
    static const int sides[3] = {0, 2, 3};
    for (int i = 0; i < 3; i++) {
        const double *p = f->planes[sides[i]];
        int axis = sides[i] / 2;
        float n = (float)p[axis], h = (float)p[2], d = (float)p[3];
        if (n * a[axis] + h * a[2] + d > 0 && n * b[axis] + h * b[2] + d > 0)
            return true;
    }
    return false;
}

static void plane_in_frame(const struct local *l, uint32_t slot, float out[4])
{
    const struct clusters *c = l->instance->clusters;
    const float(*planes)[CLUSTER_SIZE] = c->planes[slot / CLUSTER_SIZE];
    uint32_t i = slot % CLUSTER_SIZE;
    float n[3] = {planes[0][i], planes[1][i], planes[2][i]};
    const float *k = c->clusters[slot / CLUSTER_SIZE].center;
    float center[3];
    to_frame(l, k, center);
    for (int r = 0; r < 3; r++)
        out[r] = l->normals[r][0] * n[0] + l->normals[r][1] * n[1] + l->normals[r][2] * n[2];
    out[3] = -(out[0] * center[0] + out[1] * center[1] + out[2] * center[2]) - planes[3][i];
}

static void visit_edges(const struct frame *f, const struct local *l, struct exact_work *work,
                        size_t first, size_t count)
{
    static const int8_t turned[2][4] = {{0, 1, -1, 3}, {0, -1, 1, 3}};
    const struct clusters *c = l->instance->clusters;
    struct exact_edges *edges = &work->edges;
    for (size_t e = first; e < first + count; e++) {
        const struct cluster_edge *edge = &c->edges[e];
        int s0 = turned[edge->use[0] & 1][work->state[edge->use[0] / 2]];
        int s1 =
            edge->use[1] == MESH_NONE ? 0 : turned[edge->use[1] & 1][work->state[edge->use[1] / 2]];
        bool open = s0 == 3 || s1 == 3;
        if (!open && s0 + s1 == 0)
            continue;
        float a[3], b[3];
        to_frame(l, c->positions[edge->vertex[0]], a);
        to_frame(l, c->positions[edge->vertex[1]], b);
        if (edge_misses(f, a, b))
            continue;
        if (cluster_edge_odd(edge))
            work->unit = 1;
        if (!open) {
            float *out = new_edge(work, &edges->fixed, &edges->fixed_capacity, &edges->fixed_count,
                                  FIXED_FIELDS);
            if (!out)
                return;
            for (int i = 0; i < 3; i++) {
                out[(FIXED_A0 + i) * EXACT_LANES] = a[i];
                out[(FIXED_A1 + i) * EXACT_LANES] = b[i];
            }
            out[FIXED_WEIGHT * EXACT_LANES] = l->turn * (float)(s0 + s1);
            continue;
        }
        float *out =
            new_edge(work, &edges->open, &edges->open_capacity, &edges->open_count, OPEN_FIELDS);
        if (!out)
            return;
        for (int i = 0; i < 3; i++) {
            out[(OPEN_A0 + i) * EXACT_LANES] = a[i];
            out[(OPEN_A1 + i) * EXACT_LANES] = b[i];
        }
        for (int side = 0; side < 2; side++) {
            if ((side ? s1 : s0) == 0)
                continue; /* weight 0 */
            float plane[4];
            plane_in_frame(l, edge->use[side] / 2, plane);
            for (int i = 0; i < 4; i++)
                out[((side ? OPEN_P1 : OPEN_P0) + i) * EXACT_LANES] = plane[i];
            out[((side ? OPEN_W1 : OPEN_W0)) * EXACT_LANES] =
                edge->use[side] & 1 ? -l->turn : l->turn;
        }
    }
}

/* Takes triangles that do not lie between receivers and light out of the chain. */
static void loosen(const struct frame *f, const struct local *l, struct exact_work *work,
                   uint32_t cluster)
{
    const struct clusters *c = l->instance->clusters;
    size_t first = (size_t)cluster * CLUSTER_SIZE;
    size_t end = first + CLUSTER_SIZE < c->slot_count ? first + CLUSTER_SIZE : c->slot_count;
    for (size_t s = first; s < end; s++) {
        float q[3][3];
        float low = INFINITY, high = -INFINITY;
        for (int v = 0; v < 3; v++) {
            to_frame(l, c->positions[c->corners[s][v]], q[v]);
            low = q[v][2] < low ? q[v][2] : low;
            high = q[v][2] > high ? q[v][2] : high;
        }
        if (!f->loose && low >= f->h_low && high <= f->h_high)
            continue;
        work->state[s] = DROPPED;
        bool outside = false;
        for (int p = 0; p < f->plane_count && !outside; p++) {
            outside = true;
            for (int v = 0; v < 3; v++)
                outside &= f->planes[p][0] * q[v][0] + f->planes[p][1] * q[v][1] +
                               f->planes[p][2] * q[v][2] + f->planes[p][3] >
                           0;
        }
        if (outside)
            continue;
        if (!grow(work, (void **)&work->loose, &work->loose_capacity, work->loose_count, 1,
                  sizeof(*work->loose)))
            return;
        if (c->clusters[cluster].odd_count > 0)
            work->unit = 1;
        for (int v = 0; v < 3; v++)
            work->loose[work->loose_count][v] = v3_sub(
                m34_point(l->instance->world_from_mesh, v3_loadf(c->positions[c->corners[s][v]])),
                f->c);
        work->loose_count++;
    }
}

static void gather(const struct frame *f, const struct exact_instance *instance,
                   struct exact_work *work)
{
    struct local l;
    local_init(f, instance, &l);
    const struct clusters *c = instance->clusters;
    size_t kept = 0;

    /* The clusters that the shaft can touch. */
    for (size_t i = 0; i < c->node_count;) {
        const struct cluster_node *node = &c->nodes[i];
        bool inside;
        if (box_outside(&l, f->plane_count, node->low, node->high, &inside)) {
            i = node->next;
            continue;
        }
        if (inside || node->count == 1) {
            for (uint32_t k = 0; k < node->count; k++)
                work->kept[kept++] = node->first + k;
            i = node->next;
        } else {
            i++;
        }
    }
    if (kept == 0)
        return;

    /* The sides of their triangles. */
    for (size_t i = 0; i < kept; i++) {
        uint32_t k = work->kept[i];
        const struct cluster *cluster = &c->clusters[k];
        uint8_t *state = work->state + (size_t)k * CLUSTER_SIZE;
        int side = f->loose ? MIXED : cluster_side(&l, cluster);
        if (side == MIXED)
            triangle_sides(&l, cluster, (const float(*)[CLUSTER_SIZE])c->planes[k], state);
        else
            memset(state, side, CLUSTER_SIZE);
        float up[4], down[4];
        for (int j = 0; j < 4; j++)
            up[j] = l.rows[2][j], down[j] = -l.rows[2][j];
        float h_low = box_low(up, l.origin, cluster->low, cluster->high);
        float h_high = -box_low(down, l.origin, cluster->low, cluster->high);
        float slack = 1e-6f * (fabsf(h_low) + fabsf(h_high));
        if (f->loose || h_low - slack < f->h_low || h_high + slack > f->h_high) {
            loosen(f, &l, work, k);
            side = MIXED;
        }
        work->cluster_state[k] = (uint8_t)side;
    }

    /* Their edges. */
    for (size_t i = 0; i < kept; i++) {
        uint32_t k = work->kept[i];
        const struct cluster *cluster = &c->clusters[k];
        int side = work->cluster_state[k];
        visit_edges(f, &l, work, cluster->edge_first,
                    side == MIXED ? cluster->edge_count : cluster->odd_count);
        for (uint32_t b = 0; b < cluster->border_count; b++) {
            const struct cluster_border *border = &c->borders[cluster->border_first + b];
            int other = work->cluster_state[border->other];
            bool inside = side == other && side != MIXED && !border->odd;
            if ((border->owner || other == DROPPED) && !inside)
                visit_edges(f, &l, work, border->first, border->count);
        }
    }

    for (size_t i = 0; i < kept; i++) {
        memset(work->state + (size_t)work->kept[i] * CLUSTER_SIZE, DROPPED, CLUSTER_SIZE);
        work->cluster_state[work->kept[i]] = DROPPED;
    }
}

static bool instance_outside(const struct frame *f, const struct exact_instance *instance)
{
    for (int p = 0; p < f->plane_count; p++) {
        vec3 q = v3(0, 0, 0);
        for (int r = 0; r < 3; r++)
            q = v3_mad(q, f->rows[r], f->planes[p][r]);
        double least = f->planes[p][3];
        least += fmin(q.x * (instance->low.x - f->c.x), q.x * (instance->high.x - f->c.x));
        least += fmin(q.y * (instance->low.y - f->c.y), q.y * (instance->high.y - f->c.y));
        least += fmin(q.z * (instance->low.z - f->c.z), q.z * (instance->high.z - f->c.z));
        if (least > 0)
            return true;
    }
    return false;
}

/* How much of the light's parallelogram lies above the receiver's tangent plane. */
static int light_above(const struct exact_view *view, vec3 n, double lift)
{
    int above = 0;
    for (int i = 0; i < 4; i++) {
        vec3 e = v3_mad(view->center, view->u, i & 1 ? 0.5 : -0.5);
        e = v3_mad(e, view->v, i & 2 ? 0.5 : -0.5);
        above += v3_dot(n, e) + lift > 0;
    }
    return above;
}

static double point_visibility(const struct exact_job *job, struct exact_work *work,
                               const struct frame *f, const struct exact_point *point,
                               const struct exact_eye *eye)
{
    const struct exact_light *light = job->light;
    struct exact_view view = {f->view_center, f->view_u, f->view_v, f->reach};
    vec3 d = v3_sub(point->p, f->c);
    if (!light->sun)
        view.center = v3_sub(view.center, d);
    if (light->type == PNB_LIGHT_LINE || light->type == PNB_LIGHT_POINT)
        view.v = v3(0, 0, 0);
    if (light->type == PNB_LIGHT_POINT)
        view.u = v3(0, 0, 0);
    /* Samples are compared with the tangent plane of the receiver itself, before it was lifted. */
    double lift = light->sun ? 0 : job->lift;
    bool tangent = v3_dot(point->n, point->n) > 0;
    int above = tangent ? light_above(&view, point->n, lift) : 4;
    if (above == 0)
        return 0;
    const struct exact_edges *edges = &work->edges;
    if (above == 4 && edges->fixed_count + edges->open_count + work->loose_count == 0)
        return 1;

    struct exact_cover cover = {&light->grid, work->cover, work->rest, work->unit};
    exact_cover_clear(&cover);
    if (edges->fixed_count + edges->open_count > 0)
        job->kernel->edges(edges, eye, &cover);
    for (size_t i = 0; i < work->loose_count; i++) {
        vec3 q[3];
        bool below = tangent;
        for (int v = 0; v < 3; v++) {
            q[v] = v3_sub(work->loose[i][v], d);
            below &= v3_dot(point->n, q[v]) <= -0.75 * lift;
        }
        if (!below)
            exact_cover_triangle(&cover, &view, q);
    }
    if (above < 4)
        exact_cover_below(&cover, &view, point->n, lift);
    work->stats.sampled++;
    return light->grid.stride == 1 ? exact_cover_resolve(&cover) : job->kernel->resolve(&cover);
}

struct order {
    double key;
    size_t index;
};

static int compare_order(const void *a, const void *b)
{
    const struct order *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Cuts the receivers in two along their longest axis: at a wide gap, or in the middle if force.
 * Returns how many come first; 0: no cut. */
static size_t split(const struct exact_point *points, size_t count, bool force,
                    struct exact_point *out)
{
    vec3 low = points[0].p, high = points[0].p;
    for (size_t i = 1; i < count; i++) {
        low = v3_min(low, points[i].p);
        high = v3_max(high, points[i].p);
    }
    vec3 size = v3_sub(high, low);
    double extent = v3_max_abs(size);
    int axis = size.x == extent ? 0 : size.y == extent ? 1 : 2;
    struct order order[EXACT_TILE];
    for (size_t i = 0; i < count; i++)
        order[i] = (struct order){axis == 0   ? points[i].p.x
                                  : axis == 1 ? points[i].p.y
                                              : points[i].p.z,
                                  i};
    qsort(order, count, sizeof(*order), compare_order);
    size_t cut = 0;
    double widest = 0.4 * extent;
    for (size_t i = 1; i < count; i++)
        if (order[i].key - order[i - 1].key > widest) {
            widest = order[i].key - order[i - 1].key;
            cut = i;
        }
    if (cut == 0 && force)
        cut = count / 2;
    for (size_t i = 0; i < count && cut > 0; i++)
        out[i] = points[order[i].index];
    return cut;
}

void exact_tile(const struct exact_job *job, struct exact_work *work,
                const struct exact_point *points, size_t count)
{
    struct frame f;
    struct exact_point parts[EXACT_TILE];
    size_t cut = count > 1 ? split(points, count, false, parts) : 0;
    if (cut == 0 && !frame_init(job, points, count, &f))
        cut = split(points, count, true, parts);
    if (cut > 0) {
        exact_tile(job, work, parts, cut);
        exact_tile(job, work, parts + cut, count - cut);
        return;
    }
    if (job->triangles_only)
        f.h_low = 1, f.h_high = -INFINITY;

    work->edges.fixed_count = work->edges.open_count = work->loose_count = 0;
    work->unit = 2;
    for (size_t i = 0; i < job->scene->instance_count; i++)
        if (!instance_outside(&f, &job->scene->instances[i]))
            gather(&f, &job->scene->instances[i], work);
    work->stats.tiles++;
    work->stats.edges += work->edges.fixed_count + work->edges.open_count;
    work->stats.triangles += work->loose_count;

    for (size_t i = 0; i < count; i++) {
        double v = point_visibility(job, work, &f, &points[i], &f.eyes[i]);
        job->visibility[points[i].index] = (float)v;
        work->stats.lit += v == 1;
        work->stats.umbra += v == 0;
    }
}

bool exact_work_init(pnb_context *context, const struct exact_scene *scene, struct exact_work *work)
{
    memset(work, 0, sizeof(*work));
    work->context = context;
    size_t slots = (scene->slots_max + CLUSTER_SIZE - 1) / CLUSTER_SIZE * CLUSTER_SIZE;
    work->state = memory_calloc(context, slots, 1);
    work->cluster_state = memory_calloc(context, scene->clusters_max, 1);
    work->kept = memory_alloc(context, scene->clusters_max, sizeof(*work->kept));
    return work->state && work->cluster_state && work->kept;
}

bool exact_work_prepare(struct exact_work *work, const struct exact_grid *grid, bool area)
{
    memory_free(work->context, work->cover);
    memory_free(work->context, work->rest);
    size_t size = exact_cover_size(grid);
    work->cover = memory_alloc(work->context, size, sizeof(*work->cover));
    work->rest = area ? memory_alloc(work->context, size, sizeof(*work->rest)) : NULL;
    memset(&work->stats, 0, sizeof(work->stats));
    work->no_memory = false;
    return work->cover && (work->rest || !area);
}

void exact_work_finish(struct exact_work *work)
{
    if (!work->context)
        return;
    memory_free(work->context, work->state);
    memory_free(work->context, work->cluster_state);
    memory_free(work->context, work->kept);
    memory_free(work->context, work->edges.fixed);
    memory_free(work->context, work->edges.open);
    memory_free(work->context, work->loose);
    memory_free(work->context, work->cover);
    memory_free(work->context, work->rest);
}
