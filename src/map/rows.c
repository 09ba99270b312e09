/* map/rows.c: the frame that a set's maps share: which rows, which triangles cross which rows, and
 * where a receiver lies.
 *
 * Rows cover the angles around the line at which something casts, and no others: the complement of
 * the largest gap. A triangle whose shadow in the plane across the line holds the line itself (it
 * is pierced by the line or its extension) lies at every angle. Between rows nothing is
 * interpolated.
 *
 * Degenerate input: a scene without casters gives an empty set in which everything is seen;
 * geometry nearer to the line than near_r (TOLERANCE_LIGHT_GAP of the scene's size) does not count,
 * so that a lamp may touch a ceiling.
 */
#include <string.h>

#include "geom/tolerance.h"
#include "map/map.h"
#include "map/raster.h"

#define SECTORS 4096 /* resolution of the search for the largest gap */
#define MARGIN  1e-6 /* of angle, radians: room for rounding at the first and last row */
#define TURN    (2 * M_PI)
#define WIDE    3.0 /* directions beyond this are spread unevenly */

struct frame_job {
    struct map_set *set;
    float *angles;     /* per vertex */
    float *arcs;       /* per triangle: from, to >= from; to < from: all around */
    uint32_t *workers; /* bins: counts */
};

static void vertex_body(void *user, size_t begin, size_t end, int worker)
{
    struct frame_job *job = user;
    struct map_set *set = job->set;
    for (size_t i = begin; i < end; i++) {
        vec3 d = v3_sub(v3_loadf(set->geometry->positions + 3 * i), set->origin);
        float y = (float)v3_dot(d, set->y), z = (float)v3_dot(d, set->z);
        set->points[3 * i] = (float)v3_dot(d, set->axis);
        set->points[3 * i + 1] = y;
        set->points[3 * i + 2] = z;
        job->angles[i] = atan2f(z, y);
    }
}

/* Where the triangle's projection along the line lies relative to the line: it holds it, or it
 * spans an arc of less than half a turn. */
static void arc_body(void *user, size_t begin, size_t end, int worker)
{
    struct frame_job *job = user;
    const struct map_set *set = job->set;
    for (size_t t = begin; t < end; t++) {
        const uint32_t *index = set->geometry->indices + 3 * t;
        const float *p[3];
        float cross[3], low = 0, high = 0;
        for (int k = 0; k < 3; k++)
            p[k] = set->points + 3 * (size_t)index[k];
        for (int k = 0; k < 3; k++) {
            const float *a = p[k], *b = p[(k + 1) % 3];
            cross[k] = a[1] * b[2] - a[2] * b[1];
        }
        bool around = (cross[0] >= 0 && cross[1] >= 0 && cross[2] >= 0) ||
                      (cross[0] <= 0 && cross[1] <= 0 && cross[2] <= 0);
        float area = cross[0] + cross[1] + cross[2];
        float first = job->angles[index[0]];
        for (int k = 1; k < 3; k++) {
            float turn = job->angles[index[k]] - first;
            if (turn > (float)M_PI)
                turn -= (float)TURN;
            if (turn < -(float)M_PI)
                turn += (float)TURN;
            low = fminf(low, turn);
            high = fmaxf(high, turn);
        }
        /* All three of one sign also where the triangle is edge-on to the line. */
        if ((around && area != 0) || high - low > (float)(M_PI - 1e-3)) {
            job->arcs[2 * t] = 0;
            job->arcs[2 * t + 1] = -1;
        } else {
            job->arcs[2 * t] = first + low - (float)MARGIN;
            job->arcs[2 * t + 1] = first + high + (float)MARGIN;
        }
    }
}

/* Marks the sectors of the triangles [begin, end) by differences; returns false if one is all
 * around. */
static bool mark_sectors(const float *arcs, size_t begin, size_t end, int32_t *change)
{
    for (size_t t = begin; t < end; t++) {
        double from = arcs[2 * t], to = arcs[2 * t + 1];
        if (to < from)
            return false;
        int a = (int)floor(from * (SECTORS / TURN)), b = (int)floor(to * (SECTORS / TURN));
        int shift = a < 0 ? SECTORS : 0;
        a += shift;
        b += shift;
        if (a >= SECTORS) {
            a -= SECTORS;
            b -= SECTORS;
        }
        change[a]++;
        if (b + 1 <= SECTORS) {
            change[b + 1]--;
        } else {
            change[SECTORS]--;
            change[0]++;
            change[b + 1 - SECTORS]--;
        }
    }
    return true;
}

/* The rows' range of angles: all but the largest gap. */
static void find_rows(struct map_set *set, const float *arcs)
{
    const struct map_geometry *g = set->geometry;
    int32_t change[SECTORS + 1];
    memset(change, 0, sizeof(change));
    bool gaps = mark_sectors(arcs, 0, g->caster_count, change);
    size_t covered = g->caster_count;
    for (size_t k = 0; k < g->floor_count && gaps; k++) {
        if (set->floor_open[k])
            continue;
        size_t first = g->floors[k].first_triangle, count = g->floors[k].triangle_count;
        gaps = mark_sectors(arcs, first, first + count, change);
        covered += count;
    }
    set->empty = gaps && covered == 0;
    set->phi_low = 0;
    double range = TURN;
    set->round = true;
    if (gaps && !set->empty) {
        int run = 0, best = 0, best_end = 0;
        int32_t depth = 0;
        bool busy[SECTORS];
        for (int i = 0; i < SECTORS; i++) {
            depth += change[i];
            busy[i] = depth > 0;
        }
        for (int i = 0; i < 2 * SECTORS; i++) {
            run = busy[i % SECTORS] ? 0 : run + 1;
            if (run > best && run <= SECTORS) {
                best = run;
                best_end = (i + 1) % SECTORS;
            }
        }
        if (best > 2) {
            /* From the gap's end to its begin; then to the arcs' own ends within the outer sectors.
             */
            double low = best_end * (TURN / SECTORS);
            range = (SECTORS - best) * (TURN / SECTORS);
            double least = range, most = 0;
            for (size_t t = 0; t < g->passive_first; t++) {
                if (t >= g->caster_count) {
                    bool open = false;
                    for (size_t k = 0; k < g->floor_count; k++)
                        open =
                            open || (set->floor_open[k] && t >= g->floors[k].first_triangle &&
                                     t < g->floors[k].first_triangle + g->floors[k].triangle_count);
                    if (open)
                        continue;
                }
                double from = arcs[2 * t] - low, length = arcs[2 * t + 1] - arcs[2 * t];
                from -= TURN * floor(from / TURN);
                if (from > TURN - 1e-5)
                    from -= TURN;
                least = fmin(least, from);
                most = fmax(most, from + length);
            }
            set->round = false;
            set->phi_low = low + fmax(least, 0);
            range = fmin(range, most) - fmax(least, 0);
            range = fmax(range, 1e-4);
        }
    }
    set->phi_step = range / set->rows;
}

/* The rows that a triangle may cross, generously; first > last: none. */
static void find_triangle_rows(struct map_set *set, const float *arcs)
{
    double per_row = 1 / set->phi_step;
    for (size_t t = 0; t < set->geometry->triangle_count; t++) {
        double from = arcs[2 * t], to = arcs[2 * t + 1];
        int first = 0, last = set->rows - 1;
        if (to >= from) {
            double low = from - set->phi_low;
            low -= TURN * floor(low / TURN);
            double high = low + (to - from);
            int a = (int)floor(low * per_row - 0.5), b = (int)ceil(high * per_row - 0.5);
            /* The same arc one turn earlier. */
            int c = (int)ceil((high - TURN) * per_row - 0.5);
            bool late = a < set->rows, early = c >= 0;
            first = early ? 0 : a;
            last = late ? b : c;
            if (!late && !early)
                last = first - 1;
            first = first < 0 ? 0 : first;
            last = last >= set->rows ? set->rows - 1 : last;
        }
        set->first_row[t] = first;
        set->last_row[t] = last;
    }
}

static pnb_status fill_bins(struct map_set *set)
{
    size_t bands = (size_t)(set->rows + MAP_BAND - 1) / MAP_BAND, total = 0;
    size_t triangles = set->geometry->triangle_count;
    set->bands = bands;
    set->band_start = memory_calloc(set->context, bands + 2, sizeof(uint32_t));
    if (!set->band_start)
        return status_no_memory(set->context, bands * sizeof(uint32_t));
    for (size_t t = 0; t < triangles; t++)
        for (int b = set->first_row[t] / MAP_BAND;
             set->first_row[t] <= set->last_row[t] && b <= set->last_row[t] / MAP_BAND; b++) {
            set->band_start[b + 2]++;
            total++;
        }
    if (total > UINT32_MAX)
        return status_fail(set->context, PNB_ERROR_UNSUPPORTED, "depth maps", "too many triangles");
    for (size_t b = 0; b < bands; b++)
        set->band_start[b + 2] += set->band_start[b + 1];
    set->band_triangles = memory_alloc(set->context, total, sizeof(uint32_t));
    if (!set->band_triangles)
        return status_no_memory(set->context, total * sizeof(uint32_t));
    for (size_t t = 0; t < triangles; t++)
        for (int b = set->first_row[t] / MAP_BAND;
             set->first_row[t] <= set->last_row[t] && b <= set->last_row[t] / MAP_BAND; b++)
            set->band_triangles[set->band_start[b + 1]++] = (uint32_t)t;
    return PNB_OK;
}

static void describe(struct map_set *set)
{
    const struct map_geometry *g = set->geometry;
    vec3 end = v3_mad(set->origin, set->axis, set->length);
    double far = 0;
    for (int k = 0; k < 8; k++) {
        vec3 corner = v3(k & 1 ? g->high.x : g->low.x, k & 2 ? g->high.y : g->low.y,
                         k & 4 ? g->high.z : g->low.z);
        vec3 d = v3_sub(corner, set->origin);
        far = fmax(far, hypot(v3_dot(d, set->y), v3_dot(d, set->z)));
    }
    set->far_q = isfinite(far) && far > 0 ? 1 / far : 0;
    set->near_r = fmax(TOLERANCE_LIGHT_GAP * (isfinite(far) ? far : 0), 1e-30);
    for (size_t k = 0; k < g->floor_count; k++) {
        const struct map_floor *floor = &g->floors[k];
        set->floor_open[k] = v3_dot(floor->normal, set->origin) > floor->offset + g->lift &&
                             v3_dot(floor->normal, end) > floor->offset + g->lift;
    }
}

pnb_status map_set_create(const struct map_set_desc *desc, struct map_set **out_set)
{
    const struct map_geometry *g = desc->geometry;
    pnb_context *context = g->context;
    *out_set = NULL;
    struct map_set *set = memory_calloc(context, 1, sizeof(*set));
    if (!set)
        return status_no_memory(context, sizeof(*set));
    set->geometry = g;
    set->context = context;
    set->rows = desc->rows;
    set->columns = desc->columns;
    set->origin = desc->origin;
    set->axis = desc->axis;
    set->length = desc->length;
    v3_frame(set->axis, &set->y, &set->z);
    struct frame_job job = {.set = set};
    size_t vertices = g->vertex_count, triangles = g->triangle_count, rows = (size_t)set->rows;
    set->points = memory_alloc(context, vertices * 3, sizeof(float));
    set->first_row = memory_alloc(context, triangles, sizeof(int32_t));
    set->last_row = memory_alloc(context, triangles, sizeof(int32_t));
    set->row_cos = memory_alloc(context, rows, sizeof(float));
    set->row_sin = memory_alloc(context, rows, sizeof(float));
    set->floor_open = memory_calloc(context, g->floor_count, sizeof(bool));
    job.angles = memory_alloc(context, vertices, sizeof(float));
    job.arcs = memory_alloc(context, triangles * 2, sizeof(float));
    pnb_status status = PNB_OK;
    if (!set->points || !set->first_row || !set->last_row || !set->row_cos || !set->row_sin ||
        !set->floor_open || !job.angles || !job.arcs)
        status = status_no_memory(context, vertices * 16 + triangles * 16);
    if (status == PNB_OK) {
        describe(set);
        parallel_for(context, vertices, 4096, vertex_body, &job);
        parallel_for(context, triangles, 4096, arc_body, &job);
        find_rows(set, job.arcs);
        find_triangle_rows(set, job.arcs);
        for (size_t v = 0; v < rows; v++) {
            double phi = set->phi_low + ((double)v + 0.5) * set->phi_step;
            set->row_cos[v] = (float)cos(phi);
            set->row_sin[v] = (float)sin(phi);
        }
        status = fill_bins(set);
    }
    if (status == PNB_OK) {
        const struct map_sample ends[2] = {{0, 0, set->length}, {set->length, 0, set->length}};
        double low, high;
        for (int k = 0; k < 2; k++) {
            map_directions(set, &ends[k], &low, &high);
            set->wide = set->wide || low < -WIDE || high > WIDE;
        }
    }
    memory_free(context, job.angles);
    memory_free(context, job.arcs);
    if (status != PNB_OK) {
        map_set_destroy(set);
        return status;
    }
    *out_set = set;
    return PNB_OK;
}

void map_set_destroy(struct map_set *set)
{
    if (!set)
        return;
    pnb_context *context = set->context;
    for (size_t i = 0; i < set->count; i++) {
        memory_free(context, set->maps[i].u);
        memory_free(context, set->maps[i].q);
        memory_free(context, set->maps[i].passive);
    }
    memory_free(context, set->maps);
    memory_free(context, set->points);
    memory_free(context, set->first_row);
    memory_free(context, set->last_row);
    memory_free(context, set->band_start);
    memory_free(context, set->band_triangles);
    memory_free(context, set->row_cos);
    memory_free(context, set->row_sin);
    memory_free(context, set->floor_open);
    memory_free(context, set);
}

void map_locate(const struct map_set *set, const float position[3], const float normal[3],
                struct map_point *out)
{
    vec3 p = v3_loadf(position), n = v3_loadf(normal);
    vec3 d = v3_sub(p, set->origin);
    double na = v3_dot(n, set->axis), height = -v3_dot(n, d);
    out->height_low = (float)height;
    out->height_high = (float)(height + na * set->length);
    out->p = v3_mad(p, n, set->geometry->lift);
    d = v3_sub(out->p, set->origin);
    float y = (float)v3_dot(d, set->y), z = (float)v3_dot(d, set->z);
    out->a = (float)v3_dot(d, set->axis);
    out->r = fmaxf(sqrtf(y * y + z * z), (float)set->near_r);
    out->q = 1 / out->r;
    out->row = -1;
    out->below_floor = false;
    for (size_t k = 0; k < set->geometry->floor_count; k++)
        if (set->floor_open[k])
            out->below_floor = out->below_floor || v3_dot(set->geometry->floors[k].normal, out->p) <
                                                       set->geometry->floors[k].offset;
    if (set->empty)
        return;
    double phi = (double)atan2f(z, y) - set->phi_low;
    phi += phi < 0 ? TURN : 0;
    phi += phi < 0 ? TURN : 0;
    phi -= phi >= TURN ? TURN : 0;
    double row = phi / set->phi_step;
    if (!(row < set->rows)) {
        if (!set->round)
            return;
        row = set->rows - 1;
    }
    out->row = (int)row;
    double ny = v3_dot(n, set->y), nz = v3_dot(n, set->z);
    out->na = (float)na;
    out->nd = (float)(ny * set->row_cos[out->row] + nz * set->row_sin[out->row]);
    out->d = (float)v3_dot(n, d);
}

bool map_beneath_floor(const struct map_set *set, const struct map_point *point, double at)
{
    const struct map_geometry *g = set->geometry;
    vec3 light = v3_mad(set->origin, set->axis, at);
    for (size_t k = 0; k < g->floor_count; k++) {
        const struct map_floor *floor = &g->floors[k];
        double below = v3_dot(floor->normal, point->p) - floor->offset;
        if (!set->floor_open[k] || !(below < 0))
            continue;
        /* Where the segment crosses the floor's plane: in one of its triangles? */
        double above = v3_dot(floor->normal, light) - floor->offset;
        vec3 x = v3_mad(point->p, v3_sub(light, point->p), below / (below - above));
        for (size_t t = 0; t < floor->triangle_count; t++) {
            const uint32_t *index = g->indices + 3 * (floor->first_triangle + t);
            double side[3];
            for (int i = 0; i < 3; i++) {
                vec3 a = v3_loadf(g->positions + 3 * (size_t)index[i]);
                vec3 b = v3_loadf(g->positions + 3 * (size_t)index[(i + 1) % 3]);
                side[i] = v3_dot(floor->normal, v3_cross(v3_sub(b, a), v3_sub(x, a)));
            }
            if ((side[0] >= 0 && side[1] >= 0 && side[2] >= 0) ||
                (side[0] <= 0 && side[1] <= 0 && side[2] <= 0))
                return true;
        }
    }
    return false;
}
