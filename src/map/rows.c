/* map/rows.c: the frame that a set's maps share: which rows, which triangles cross which rows, and
 * where a receiver lies.
 *
 * Rows cover the angles around the line at which something casts, and no others: the arcs between
 * up to MAP_ARCS gaps, each from its first caster to its last, so that an object's outline along
 * the line lies on the border of a row. Their number grows with the turn that is covered, by the
 * quarter. A triangle whose shadow in the plane across the line holds the line itself (it is
 * pierced by the line or its extension) lies at every angle. Between rows nothing is interpolated.
 *
 * Degenerate input: a scene without casters gives an empty set in which everything is seen;
 * geometry nearer to the line than near_r (TOLERANCE_LIGHT_GAP of the scene's size) does not count,
 * so that a lamp may touch a ceiling.
 */
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "map/map.h"
#include "map/raster.h"

#define SECTORS MAP_SECTORS /* resolution of the search for gaps */
#define GAP     4           /* sectors, the least gap that rows leave out */
#define MARGIN  1e-6        /* of angle, radians: room for rounding at the first and last row */
#define TURN    (2 * M_PI)
#define WIDE    3.0 /* directions beyond this are spread unevenly */

struct frame_job {
    struct map_set *set;
    float *angles; /* per vertex */
    float *arcs;   /* per triangle: from, to >= from; to < from: all around */
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

struct gap {
    int begin, length;
};

static int longer_first(const void *a, const void *b)
{
    const struct gap *p = a, *q = b;
    return p->length != q->length ? q->length - p->length : p->begin - q->begin;
}

static int by_begin(const void *a, const void *b)
{
    const struct gap *p = a, *q = b;
    return p->begin - q->begin;
}

/* The runs of sectors that nothing lies in: the MAP_ARCS longest, in order around the line. */
static int find_gaps(const int32_t *change, struct gap *gaps)
{
    bool busy[SECTORS];
    struct gap all[SECTORS / 2 + 1];
    int32_t depth = 0;
    int count = 0, start = -1;
    for (int i = 0; i < SECTORS; i++) {
        depth += change[i];
        busy[i] = depth > 0;
        if (start < 0 && busy[i])
            start = i;
    }
    /* Once around from a busy sector, so that no run is cut in two. */
    for (int i = start, run = 0; i <= start + SECTORS; i++) {
        if (!busy[i % SECTORS]) {
            run++;
        } else {
            if (run >= GAP)
                all[count++] = (struct gap){(i - run) % SECTORS, run};
            run = 0;
        }
    }
    qsort(all, (size_t)count, sizeof(*all), longer_first);
    count = count < MAP_ARCS ? count : MAP_ARCS;
    memcpy(gaps, all, (size_t)count * sizeof(*gaps));
    qsort(gaps, (size_t)count, sizeof(*gaps), by_begin);
    return count;
}

/* Whether maps must cover triangle t. */
static bool covered(const struct map_set *set, size_t t)
{
    const struct map_geometry *g = set->geometry;
    if (t < g->caster_count)
        return true;
    for (size_t k = 0; k < g->floor_count; k++)
        if (!set->floor_open[k] && t >= g->floors[k].first_triangle &&
            t < g->floors[k].first_triangle + g->floors[k].triangle_count)
            return true;
    return false;
}

static double turned(double angle) /* into [0, turn) */
{
    angle -= TURN * floor(angle / TURN);
    return angle < TURN ? angle : 0;
}

/* The arcs between the gaps, trimmed to what lies in them. */
static void find_arcs(struct map_set *set, const float *arcs)
{
    const struct map_geometry *g = set->geometry;
    int32_t change[SECTORS + 1];
    struct gap gaps[MAP_ARCS];
    double least[MAP_ARCS], most[MAP_ARCS];
    memset(change, 0, sizeof(change));
    bool open = mark_sectors(arcs, 0, g->caster_count, change);
    size_t casters = g->caster_count;
    for (size_t k = 0; k < g->floor_count && open; k++) {
        if (set->floor_open[k])
            continue;
        size_t first = g->floors[k].first_triangle, count = g->floors[k].triangle_count;
        open = mark_sectors(arcs, first, first + count, change);
        casters += count;
    }
    set->empty = open && casters == 0;
    int count = open && !set->empty ? find_gaps(change, gaps) : 0;
    set->round = count == 0;
    set->arc_count = set->round ? 1 : count;
    memset(set->sector_arc, set->round ? 0 : MAP_NO_ARC, SECTORS);
    set->arcs[0] = (struct map_arc){.low = 0, .range = TURN};
    for (int i = 0; i < count; i++) {
        const struct gap *next = &gaps[(i + 1) % count];
        int begin = gaps[i].begin + gaps[i].length, end = next->begin;
        while (end <= begin)
            end += SECTORS;
        set->arcs[i].low = turned(begin * (TURN / SECTORS));
        set->arcs[i].range = (end - begin) * (TURN / SECTORS);
        for (int k = begin; k < end; k++)
            set->sector_arc[k % SECTORS] = (uint8_t)i;
        least[i] = set->arcs[i].range;
        most[i] = 0;
    }
    for (size_t t = 0; t < g->passive_first && count > 0; t++) {
        if (!covered(set, t))
            continue;
        int sector = (int)(turned(arcs[2 * t]) * (SECTORS / TURN));
        int i = set->sector_arc[sector < SECTORS ? sector : 0];
        if (i == MAP_NO_ARC) {
            /* Rounding at a sector's border: the arc stays as it is. */
            sector = (sector + 1) % SECTORS;
            if (set->sector_arc[sector] == MAP_NO_ARC)
                continue;
            i = set->sector_arc[sector];
            least[i] = 0;
        }
        double from = turned(arcs[2 * t] - set->arcs[i].low);
        from = from > TURN - 1e-3 ? 0 : from;
        least[i] = fmin(least[i], from);
        most[i] = fmax(most[i], from + ((double)arcs[2 * t + 1] - arcs[2 * t]));
    }
    for (int i = 0; i < count; i++) {
        struct map_arc *arc = &set->arcs[i];
        double end = fmin(most[i], arc->range);
        arc->low = turned(arc->low + least[i]);
        arc->range = fmax(end - least[i], 1e-6);
    }
}

/* Shares the rows out by angle. */
static pnb_status make_rows(struct map_set *set, int per_quarter)
{
    pnb_context *context = set->context;
    double total = 0;
    for (int i = 0; i < set->arc_count; i++)
        total += set->arcs[i].range;
    int wanted = per_quarter * (int)fmax(1, fmin(4, ceil(total / (M_PI / 2) - 1e-9)));
    set->rows = 0;
    set->phi_step = 0;
    for (int i = 0; i < set->arc_count; i++) {
        struct map_arc *arc = &set->arcs[i];
        arc->first_row = set->rows;
        arc->row_count = (int)fmax(1, floor(arc->range / total * wanted + 0.5));
        arc->step = arc->range / arc->row_count;
        set->rows += arc->row_count;
        set->phi_step = fmax(set->phi_step, arc->step);
    }
    size_t rows = (size_t)set->rows;
    set->row_cos = memory_alloc(context, rows, sizeof(float));
    set->row_sin = memory_alloc(context, rows, sizeof(float));
    set->row_above = memory_alloc(context, rows, sizeof(int32_t));
    set->row_below = memory_alloc(context, rows, sizeof(int32_t));
    if (!set->row_cos || !set->row_sin || !set->row_above || !set->row_below)
        return status_no_memory(context, rows * 16);
    for (int i = 0; i < set->arc_count; i++) {
        const struct map_arc *arc = &set->arcs[i];
        for (int k = 0; k < arc->row_count; k++) {
            int v = arc->first_row + k, last = arc->first_row + arc->row_count - 1;
            double phi = arc->low + (k + 0.5) * arc->step;
            set->row_cos[v] = (float)cos(phi);
            set->row_sin[v] = (float)sin(phi);
            set->row_above[v] = k > 0 ? v - 1 : set->round ? last : v;
            set->row_below[v] = v < last ? v + 1 : set->round ? arc->first_row : v;
        }
    }
    return PNB_OK;
}

/* The rows of an arc that angles [from, to] may cross, generously, added to [*first, *last]. */
static void add_rows(const struct map_arc *arc, double from, double to, int *first, int *last)
{
    double low = turned(from - arc->low), high = low + (to - from), per_row = 1 / arc->step;
    for (int turn = 0; turn < 2; turn++) {
        double a = floor((low - turn * TURN) * per_row - 0.5);
        double b = ceil((high - turn * TURN) * per_row - 0.5);
        if (!(b >= 0) || !(a < arc->row_count))
            continue;
        int begin = arc->first_row + (a > 0 ? (int)a : 0);
        int end = arc->first_row + (b < arc->row_count ? (int)b : arc->row_count - 1);
        *first = begin < *first ? begin : *first;
        *last = end > *last ? end : *last;
    }
}

/* The rows that each triangle may cross; first > last: none. */
static void rows_body(void *user, size_t begin, size_t end, int worker)
{
    struct frame_job *job = user;
    struct map_set *set = job->set;
    for (size_t t = begin; t < end; t++) {
        double from = job->arcs[2 * t], to = job->arcs[2 * t + 1];
        int first = set->rows, last = -1;
        if (to < from) {
            first = 0;
            last = set->rows - 1;
        } else {
            for (int i = 0; i < set->arc_count; i++)
                add_rows(&set->arcs[i], from, to, &first, &last);
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
        if (!set->floor_open[k])
            continue;
        float *f = set->floors[set->open_floor_count++];
        f[0] = (float)v3_dot(floor->normal, set->axis);
        f[1] = (float)v3_dot(floor->normal, set->y);
        f[2] = (float)v3_dot(floor->normal, set->z);
        f[3] = (float)(floor->offset - v3_dot(floor->normal, set->origin));
    }
    const vec3 rows[3] = {set->axis, set->y, set->z};
    for (int k = 0; k < 3; k++)
        v3_storef(set->frame + 3 * k, rows[k]);
    v3_storef(set->start, set->origin);
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
    set->columns = desc->columns;
    set->origin = desc->origin;
    set->axis = desc->axis;
    set->length = desc->length;
    v3_frame(set->axis, &set->y, &set->z);
    struct frame_job job = {.set = set};
    size_t vertices = g->vertex_count, triangles = g->triangle_count;
    set->points = memory_alloc(context, vertices * 3, sizeof(float));
    set->first_row = memory_alloc(context, triangles, sizeof(int32_t));
    set->last_row = memory_alloc(context, triangles, sizeof(int32_t));
    set->arcs = memory_calloc(context, MAP_ARCS, sizeof(*set->arcs));
    set->sector_arc = memory_alloc(context, SECTORS, 1);
    set->floor_open = memory_calloc(context, g->floor_count, sizeof(bool));
    set->floors = memory_calloc(context, g->floor_count, sizeof(*set->floors));
    job.angles = memory_alloc(context, vertices, sizeof(float));
    job.arcs = memory_alloc(context, triangles * 2, sizeof(float));
    pnb_status status = PNB_OK;
    if (!set->points || !set->first_row || !set->last_row || !set->arcs || !set->sector_arc ||
        !set->floor_open || !set->floors || !job.angles || !job.arcs)
        status = status_no_memory(context, vertices * 16 + triangles * 16);
    if (status == PNB_OK) {
        describe(set);
        parallel_for(context, vertices, 4096, vertex_body, &job);
        parallel_for(context, triangles, 4096, arc_body, &job);
        find_arcs(set, job.arcs);
        status = make_rows(set, desc->rows);
    }
    if (status == PNB_OK) {
        parallel_for(context, triangles, 4096, rows_body, &job);
        if (!desc->laid_out)
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
    memory_free(context, set->row_above);
    memory_free(context, set->row_below);
    memory_free(context, set->arcs);
    memory_free(context, set->sector_arc);
    memory_free(context, set->floor_open);
    memory_free(context, set->floors);
    memory_free(context, set);
}

/* The angle of (y, z) in [0, turn], to 3e-7: the arc tangent's odd polynomial of Cephes' atanf on
 * [0, tan(turn / 16)], reached by folding. Twice as fast as the C library's. */
static float angle_of(float y, float z)
{
    float ay = fabsf(y), az = fabsf(z), low = fminf(ay, az), high = fmaxf(ay, az);
    bool second = low > 0.41421356f * high;
    float t = second ? (low - high) / (low + high) : high > 0 ? low / high : 0;
    float s = t * t;
    float angle = (((8.05374449538e-2f * s - 1.38776856032e-1f) * s + 1.99777106478e-1f) * s -
                   3.33329491539e-1f) *
                      s * t +
                  t;
    angle += second ? (float)(M_PI / 4) : 0;
    angle = az > ay ? (float)(M_PI / 2) - angle : angle;
    angle = y < 0 ? (float)M_PI - angle : angle;
    return z < 0 ? (float)TURN - angle : angle;
}

void map_locate(const struct map_set *set, const float position[3], const float normal[3],
                struct map_point *out)
{
    const float *f = set->frame, lift = (float)set->geometry->lift;
    float d[3], p[3], n[3];
    for (int k = 0; k < 3; k++)
        d[k] = position[k] - set->start[k];
    for (int k = 0; k < 3; k++) {
        p[k] = f[3 * k] * d[0] + f[3 * k + 1] * d[1] + f[3 * k + 2] * d[2];
        n[k] = f[3 * k] * normal[0] + f[3 * k + 1] * normal[1] + f[3 * k + 2] * normal[2];
    }
    float plane = n[0] * p[0] + n[1] * p[1] + n[2] * p[2];
    out->height_low = -plane;
    out->height_high = n[0] * (float)set->length - plane;
    out->a = p[0] + lift * n[0];
    out->y = p[1] + lift * n[1];
    out->z = p[2] + lift * n[2];
    out->row = -1;
    out->below_floor = false;
    for (int k = 0; k < set->open_floor_count; k++) {
        const float *floor = set->floors[k];
        out->below_floor = out->below_floor ||
                           floor[0] * out->a + floor[1] * out->y + floor[2] * out->z < floor[3];
    }
    if (set->empty)
        return;
    float phi = angle_of(out->y, out->z);
    int sector = (int)(phi * (float)(SECTORS / TURN));
    int index = set->sector_arc[sector < SECTORS ? sector : SECTORS - 1];
    if (index == MAP_NO_ARC)
        return;
    const struct map_arc *arc = &set->arcs[index];
    double off = phi - arc->low;
    off += off < -M_PI ? TURN : 0;
    int row = (int)floor(off / arc->step);
    if (set->round)
        row = row < 0 ? 0 : row >= arc->row_count ? arc->row_count - 1 : row;
    if (row < 0 || row >= arc->row_count)
        return;
    out->row = arc->first_row + row;
    out->r = fmaxf(sqrtf(out->y * out->y + out->z * out->z), (float)set->near_r);
    out->q = 1 / out->r;
    out->na = n[0];
    out->nd = n[1] * set->row_cos[out->row] + n[2] * set->row_sin[out->row];
    out->d = plane + lift;
}

bool map_beneath_floor(const struct map_set *set, const struct map_point *point, double at)
{
    const struct map_geometry *g = set->geometry;
    vec3 light = v3_mad(set->origin, set->axis, at), p = v3_mad(set->origin, set->axis, point->a);
    p = v3_mad(v3_mad(p, set->y, point->y), set->z, point->z);
    for (size_t k = 0; k < g->floor_count; k++) {
        const struct map_floor *floor = &g->floors[k];
        double below = v3_dot(floor->normal, p) - floor->offset;
        if (!set->floor_open[k] || !(below < 0))
            continue;
        /* Where the segment crosses the floor's plane: in one of its triangles? */
        double above = v3_dot(floor->normal, light) - floor->offset;
        vec3 x = v3_mad(p, v3_sub(light, p), below / (below - above));
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
