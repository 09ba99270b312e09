/* map/raster.c: triangles to depth, row by row.
 *
 * A row's half-plane cuts a triangle in a segment (a0, r0) - (a1, r1), whatever the sample; each
 * sample's map then gets the segment's texels between u0 = (a0 - s)/r0 and u1, with q = 1/r linear
 * in u. So one walk over triangles and rows fills the maps of all samples. Texels take what lies at
 * their middle; the nearest (greatest q) stays, so the order of triangles does not matter.
 *
 * No clipping but r >= near_r: a half-plane has nothing behind the sample. The two ends of a
 * segment come from edges that neighbouring triangles share, computed from the vertex on the
 * positive side to the one on the negative side in both, so surfaces have no cracks.
 *
 * Parallel over bands of MAP_BAND rows. Cost per triangle and row some 20 ns and 5 ns a map, per
 * texel covered 0.3 ns.
 */
#include "map/raster.h"

#include <string.h>

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define MAP_WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define MAP_WIDE
#endif

#define U_MOST 1e6 /* directions nearer to the line's own than this are one */

struct raster_job {
    struct map_set *set;
    size_t first; /* map */
};

struct range {
    float low, high;
};

/* The directions under which a sample at s sees the triangle: bounds from its extent along the line
 * and its least and greatest distance from the line. */
static void widen(const float *const p[3], float s, float r_low, float r_high, struct range *range)
{
    float a_low = fminf(p[0][0], fminf(p[1][0], p[2][0])) - s;
    float a_high = fmaxf(p[0][0], fmaxf(p[1][0], p[2][0])) - s;
    range->low = fminf(range->low, a_low < 0 ? a_low / r_low : a_low / r_high);
    range->high = fmaxf(range->high, a_high > 0 ? a_high / r_low : a_high / r_high);
}

static float nearest_r(const float *const p[3], float near_r)
{
    float best = INFINITY;
    bool positive = true, negative = true;
    for (int k = 0; k < 3; k++) {
        const float *a = p[k], *b = p[(k + 1) % 3];
        float dy = b[1] - a[1], dz = b[2] - a[2], length = dy * dy + dz * dz;
        float t = length > 0 ? -(a[1] * dy + a[2] * dz) / length : 0;
        t = fminf(fmaxf(t, 0), 1);
        float y = a[1] + t * dy, z = a[2] + t * dz, cross = a[1] * b[2] - a[2] * b[1];
        best = fminf(best, y * y + z * z);
        positive = positive && cross > 0;
        negative = negative && cross < 0;
    }
    return positive || negative ? near_r : fmaxf(sqrtf(best), near_r);
}

/* The least q at which a sample's rays within the given directions end: on an open floor that all
 * of them meet, or at the scene's far corner. */
static double far_q(const struct map_set *set, double s, const struct range *u)
{
    const struct map_geometry *g = set->geometry;
    double best = set->far_q;
    for (size_t k = 0; k < g->floor_count && set->arc_count == 1; k++) {
        const struct map_arc *arc = &set->arcs[0];
        if (!set->floor_open[k] || arc->range > M_PI / 2)
            continue;
        vec3 n = g->floors[k].normal;
        double na = v3_dot(n, set->axis), ny = v3_dot(n, set->y), nz = v3_dot(n, set->z);
        double d = g->floors[k].offset - v3_dot(n, set->origin), least = INFINITY;
        for (int i = 0; i < 2; i++) {
            double phi = arc->low + (i ? arc->range : 0);
            double nd = ny * cos(phi) + nz * sin(phi);
            least = fmin(least, (na * (double)u->low + nd) / (d - na * s));
            least = fmin(least, (na * (double)u->high + nd) / (d - na * s));
        }
        best = fmax(best, 0.98 * least);
    }
    return best;
}

void map_directions(const struct map_set *set, const struct map_sample *sample, double *out_low,
                    double *out_high)
{
    const struct map_geometry *g = set->geometry;
    const double places[3] = {sample->at, sample->neighbour_low, sample->neighbour_high};
    struct range range[3];
    for (int k = 0; k < 3; k++)
        range[k] = (struct range){INFINITY, -INFINITY};
    size_t floor = 0;
    for (size_t t = 0; t < g->passive_first; t++) {
        if (t >= g->caster_count) {
            while (floor < g->floor_count &&
                   t >= g->floors[floor].first_triangle + g->floors[floor].triangle_count)
                floor++;
            if (floor < g->floor_count && set->floor_open[floor])
                continue;
        }
        const float *p[3];
        float far = 0;
        for (int k = 0; k < 3; k++) {
            p[k] = set->points + 3 * (size_t)g->indices[3 * t + (size_t)k];
            far = fmaxf(far, p[k][1] * p[k][1] + p[k][2] * p[k][2]);
        }
        float near = nearest_r(p, (float)set->near_r);
        far = fmaxf(sqrtf(far), near);
        for (int k = 0; k < 3; k++)
            widen(p, (float)places[k], near, far, &range[k]);
    }
    *out_low = range[0].low;
    *out_high = range[0].high;
    for (int k = 1; k < 3 && *out_low <= *out_high; k++) {
        double shift = (places[k] - places[0]) * far_q(set, places[k], &range[k]);
        if (places[k] == places[0])
            continue;
        *out_low = fmin(*out_low, (double)range[k].low + shift);
        *out_high = fmax(*out_high, (double)range[k].high + shift);
    }
    *out_low = fmax(*out_low, -U_MOST);
    *out_high = fmin(*out_high, U_MOST);
}

static pnb_status reserve(struct map_set *set, struct map *map)
{
    size_t texels = (size_t)set->rows * (size_t)set->columns;
    map->q = memory_alloc(set->context, texels, sizeof(float));
    if (set->geometry->passive_first < set->geometry->triangle_count)
        map->passive = memory_alloc(set->context, texels, sizeof(float));
    bool passive = set->geometry->passive_first == set->geometry->triangle_count || map->passive;
    return map->q && passive ? PNB_OK : status_no_memory(set->context, texels * sizeof(float));
}

/* Columns. */
static pnb_status lay_out(struct map_set *set, const struct map_sample *sample, struct map *map)
{
    size_t columns = (size_t)set->columns;
    double low, high;
    *map = (struct map){.at = sample->at};
    map->u = memory_alloc(set->context, columns, sizeof(float));
    if (!map->u)
        return status_no_memory(set->context, columns * sizeof(float));
    map_directions(set, sample, &low, &high);
    if (!(low <= high))
        low = high = 0;
    double w_low = map_spread(set, (float)low), w_high = map_spread(set, (float)high);
    /* Two texels and more beyond the outermost casters, so that their edges show. */
    double range = fmax((w_high - w_low) * (1 + 6.0 / (double)columns), 1e-4);
    w_low = 0.5 * (w_low + w_high - range);
    map->low = (float)w_low;
    map->scale = (float)((double)columns / range);
    for (size_t c = 0; c < columns; c++) {
        double w = w_low + ((double)c + 0.5) * range / (double)columns;
        double u = w;
        if (set->wide && w > 1)
            u = 1 / fmax(2 - w, 1 / U_MOST);
        else if (set->wide && w < -1)
            u = -1 / fmax(2 + w, 1 / U_MOST);
        map->u[c] = (float)u;
    }
    return PNB_OK;
}

MAP_WIDE static void fill(const float *restrict u, float *restrict q, int first, int last, float u0,
                          float q0, float slope)
{
    for (int c = first; c < last; c++) {
        float value = q0 + (u[c] - u0) * slope;
        q[c] = q[c] > value ? q[c] : value;
    }
}

static int column_after(const struct map_set *set, const struct map *map, float u)
{
    float x = ceilf((map_spread(set, u) - map->low) * map->scale - 0.5f);
    return x <= 0 ? 0 : x >= (float)set->columns ? set->columns : (int)x;
}

/* The triangle's part on one row, into every map. */
static void draw_row(const struct raster_job *job, const float *const p[3], int row, bool passive)
{
    const struct map_set *set = job->set;
    float c = set->row_cos[row], s = set->row_sin[row], h[3];
    for (int k = 0; k < 3; k++)
        h[k] = c * p[k][2] - s * p[k][1];
    int side = (h[0] >= 0) + (h[1] >= 0) * 2 + (h[2] >= 0) * 4;
    if (side == 0 || side == 7)
        return;
    /* The vertex that is alone on its side. */
    static const int8_t lone[7] = {-1, 0, 1, 2, 2, 1, 0};
    int m = lone[side];
    float a[2], r[2];
    for (int k = 0; k < 2; k++) {
        int o = (m + 1 + k) % 3;
        const float *from = h[m] >= 0 ? p[m] : p[o], *to = h[m] >= 0 ? p[o] : p[m];
        float h_from = h[m] >= 0 ? h[m] : h[o], h_to = h[m] >= 0 ? h[o] : h[m];
        float t = h_from / (h_from - h_to);
        float r_from = c * from[1] + s * from[2], r_to = c * to[1] + s * to[2];
        a[k] = from[0] + t * (to[0] - from[0]);
        r[k] = r_from + t * (r_to - r_from);
    }
    float near = (float)set->near_r;
    if (r[0] < near && r[1] < near)
        return;
    for (int k = 0; k < 2; k++)
        if (r[k] < near) {
            float t = (near - r[k]) / (r[1 - k] - r[k]);
            a[k] += t * (a[1 - k] - a[k]);
            r[k] = near;
        }
    /* From the end that is farther from the line: the other one's q and u may be huge. */
    if (r[0] < r[1]) {
        float swap_a = a[0], swap_r = r[0];
        a[0] = a[1], r[0] = r[1];
        a[1] = swap_a, r[1] = swap_r;
    }
    float dr = r[1] - r[0], da = a[1] - a[0];
    float q0 = 1 / r[0], q1 = 1 / r[1], q_low = fminf(q0, q1), q_high = fmaxf(q0, q1);
    for (size_t i = job->first; i < set->count; i++) {
        const struct map *map = &set->maps[i];
        float u0 = (a[0] - (float)map->at) * q0, u1 = (a[1] - (float)map->at) * q1;
        int first = column_after(set, map, fminf(u0, u1));
        int last = column_after(set, map, fmaxf(u0, u1));
        if (first >= last)
            continue;
        size_t at = (size_t)row * (size_t)set->columns;
        float *q = (passive ? map->passive : map->q) + at;
        /* The line through both ends: q (dr (a0 - s) - da r0) = dr u - da. */
        float slope = dr / (dr * (a[0] - (float)map->at) - da * r[0]);
        if (last - first == 1) {
            float value = fminf(fmaxf(q0 + (map->u[first] - u0) * slope, q_low), q_high);
            q[first] = fmaxf(q[first], value);
        } else {
            fill(map->u, q, first, last, u0, q0, slope);
        }
    }
}

static void band_body(void *user, size_t begin, size_t end, int worker)
{
    const struct raster_job *job = user;
    const struct map_set *set = job->set;
    const struct map_geometry *g = set->geometry;
    for (size_t band = begin; band < end; band++) {
        int low = (int)band * MAP_BAND, high = low + MAP_BAND;
        high = high > set->rows ? set->rows : high;
        size_t texels = (size_t)(high - low) * (size_t)set->columns;
        for (size_t i = job->first; i < set->count; i++) {
            size_t at = (size_t)low * (size_t)set->columns;
            memset(set->maps[i].q + at, 0, texels * sizeof(float));
            if (set->maps[i].passive)
                memset(set->maps[i].passive + at, 0, texels * sizeof(float));
        }
        for (uint32_t k = set->band_start[band]; k < set->band_start[band + 1]; k++) {
            uint32_t t = set->band_triangles[k];
            const float *p[3];
            for (int i = 0; i < 3; i++)
                p[i] = set->points + 3 * (size_t)g->indices[3 * (size_t)t + (size_t)i];
            int first = set->first_row[t] > low ? set->first_row[t] : low;
            int last = set->last_row[t] < high - 1 ? set->last_row[t] : high - 1;
            for (int row = first; row <= last; row++)
                draw_row(job, p, row, t >= g->passive_first);
        }
    }
}

pnb_status map_set_lay_out(struct map_set *set, const struct map_sample *samples, size_t count)
{
    if (!memory_reserve(set->context, (void **)&set->maps, &set->capacity, set->count, count,
                        sizeof(*set->maps)))
        return status_no_memory(set->context, count * sizeof(*set->maps));
    for (size_t i = 0; i < count; i++) {
        pnb_status status = lay_out(set, &samples[i], &set->maps[set->count++]);
        if (status != PNB_OK)
            return status;
    }
    return PNB_OK;
}

pnb_status map_set_add(struct map_set *set, const struct map_sample *samples, size_t count)
{
    struct raster_job job = {set, set->count};
    pnb_status status = map_set_lay_out(set, samples, count);
    for (size_t i = job.first; i < set->count && status == PNB_OK; i++)
        status = reserve(set, &set->maps[i]);
    if (status == PNB_OK)
        parallel_for(set->context, set->bands, 1, band_body, &job);
    return status;
}
