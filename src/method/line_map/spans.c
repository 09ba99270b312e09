/* method/line_map/spans.c: what a map shows: its discontinuities, and the occluders between them.
 *
 * Beyond the paper (between=spans). Rows make the problem two-dimensional: what the maps see in a
 * row's half-plane are surfaces that are known as places (a, r), not only as directions. From a
 * receiver p = (a_p, r_p) in the same row a place e, r_e < r_p, appears on the light at
 *
 *     s = a_p + (a_e - a_p) r_p / (r_p - r_e)
 *
 * so a straight piece of a surface hides the interval between its two ends, and p sees what the
 * union of the intervals leaves:
 *
 *     light   s_i ---[=====]--[==]------- s_j        hidden: [ ]
 *                     \   /   | /
 *                      ---    |-      pieces of the row
 *                         \ | / /
 *     receiver               p
 *
 * The channels end the light at the first occluder; this also finds what is seen beyond thin ones,
 * and parts of the light that no sample sees.
 *
 * A run of texels between two discontinuities is one surface. It is cut (Douglas and Peucker; what
 * is straight in space is straight in (u, q)) until its pieces stay within CUT texels of depth.
 * Receivers lie on such surfaces themselves: only what stands LINE_MAP_LIFT texels above their
 * plane, and LINE_MAP_BESIDE nearer to the light, hides anything.
 *
 * What is hidden from all samples is not known. Cost: O(texels) to scan a map, some 30 to 100 ns a
 * receiver that asks. Memory: 16 bytes a piece, 20 a discontinuity.
 */
#include <string.h>

#include "method/line_map/line_map.h"

#define CUT   1.0f /* texels off the surface: coarser pieces shadow themselves, finer ones cost */
#define DEPTH 24   /* of the recursion */
#define GRAIN 16   /* rows scanned at a time */

/* Some rows of one map. */
struct scan {
    struct line_map_jump *jumps;
    struct line_map_piece *pieces;
    size_t jump_count, jump_capacity, piece_count, piece_capacity;
};

struct scan_job {
    struct line_map_light *light;
    size_t map;
    struct line_map_view *view;
    struct scan *scans; /* one per GRAIN rows */
    bool failed;
};

/* A place of the row: (a, r) of direction u at depth q. */
struct place {
    float a, r;
};

static struct place place(const struct map *map, float u, float q)
{
    return (struct place){(float)map->at + u / q, 1 / q};
}

/* One row of one map. */
struct row {
    pnb_context *context;
    struct scan *scan;
    const struct map_set *set;
    const struct map *map;
    const float *q;
    float tolerance;                  /* share of q */
    float floors[MAP_FLOORS_MOST][3]; /* of the open floors: a, r, offset */
};

/* Floors that the maps need not cover hide nothing from what lies above them. */
static bool on_floor(const struct row *row, struct place p0, struct place p1)
{
    for (int k = 0; k < row->set->open_floor_count && k < MAP_FLOORS_MOST; k++) {
        const float *f = row->floors[k];
        float h0 = f[0] * p0.a + f[1] * p0.r - f[2], h1 = f[0] * p1.a + f[1] * p1.r - f[2];
        if (h0 < row->tolerance * p0.r && h1 < row->tolerance * p1.r)
            return true;
    }
    return false;
}

static bool add_piece(const struct row *row, struct place p0, struct place p1)
{
    struct scan *scan = row->scan;
    if (!isfinite(p0.a + p0.r + p1.a + p1.r) || on_floor(row, p0, p1))
        return true;
    if (!memory_reserve(row->context, (void **)&scan->pieces, &scan->piece_capacity,
                        scan->piece_count, 1, sizeof(*scan->pieces)))
        return false;
    scan->pieces[scan->piece_count++] = (struct line_map_piece){{p0.a, p0.r}, {p1.a, p1.r}};
    return true;
}

/* Columns first to last of one surface, prolonged to the directions low and high. */
static bool add_run(const struct row *row, int first, int last, float low, float high, int depth)
{
    const float *u = row->map->u, *q = row->q;
    float slope = last > first ? (q[last] - q[first]) / (u[last] - u[first]) : 0;
    float most = row->tolerance * q[first];
    int worst = -1;
    for (int c = first + 1; c < last; c++) {
        float off = fabsf(q[c] - (q[first] + (u[c] - u[first]) * slope));
        if (off > most) {
            most = off;
            worst = c;
        }
    }
    if (worst < 0 || depth == 0) {
        float q_low = fmaxf(q[first] + (low - u[first]) * slope, 0.5f * q[first]);
        float q_high = fmaxf(q[last] + (high - u[last]) * slope, 0.5f * q[last]);
        return add_piece(row, place(row->map, low, q_low), place(row->map, high, q_high));
    }
    return add_run(row, first, worst, low, u[worst], depth - 1) &&
           add_run(row, worst, last, u[worst], high, depth - 1);
}

/* The runs between a row's discontinuities, up to where these are. */
static bool add_row(const struct row *row, const struct line_map_jump *jumps, size_t count)
{
    bool whole = true;
    for (size_t i = 0; i <= count && whole; i++) {
        const struct line_map_jump *before = i > 0 ? &jumps[i - 1] : NULL;
        const struct line_map_jump *after = i < count ? &jumps[i] : NULL;
        int first = before ? before->column + 1 : 0;
        int last = after ? after->column : row->set->columns - 1;
        if (first > last || !(row->q[first] > 0))
            continue;
        float low = before ? before->u : row->map->u[first];
        float high = after ? after->u : row->map->u[last];
        whole = add_run(row, first, last, low, high, DEPTH);
    }
    return whole;
}

static void scan_body(void *user, size_t begin, size_t end, int worker)
{
    struct scan_job *job = user;
    struct line_map_light *light = job->light;
    const struct map_set *set = light->set;
    const struct map *map = &set->maps[job->map];
    size_t columns = (size_t)set->columns;
    float *response = memory_alloc(light->context, columns, sizeof(float));
    uint8_t *mark = memory_calloc(light->context, columns + 16, 1);
    if (!response || !mark)
        job->failed = true;
    for (size_t block = begin; block < end && response && mark; block++) {
        struct scan *scan = &job->scans[block];
        size_t last = (block + 1) * GRAIN;
        last = last < (size_t)set->rows ? last : (size_t)set->rows;
        for (size_t row = block * GRAIN; row < last; row++) {
            size_t count = 0, before = scan->jump_count;
            bool whole = memory_reserve(light->context, (void **)&scan->jumps, &scan->jump_capacity,
                                        before, columns, sizeof(*scan->jumps));
            if (whole)
                count =
                    line_map_find_jumps(light, map, (int)row, response, mark, scan->jumps + before);
            scan->jump_count += count;
            /* Counts for now. */
            job->view->jump_start[row + 1] = (uint32_t)count;
            job->view->piece_start[row + 1] = (uint32_t)scan->piece_count;
            if (whole && light->method->spans) {
                struct row r = {.context = light->context,
                                .scan = scan,
                                .set = set,
                                .map = map,
                                .q = map->q + row * columns,
                                .tolerance = CUT * map_texel(set, map)};
                for (int k = 0; k < set->open_floor_count && k < MAP_FLOORS_MOST; k++) {
                    const float *f = set->floors[k];
                    r.floors[k][0] = f[0];
                    r.floors[k][1] = f[1] * set->row_cos[row] + f[2] * set->row_sin[row];
                    r.floors[k][2] = f[3];
                }
                whole = add_row(&r, scan->jumps + before, count);
            }
            job->view->piece_start[row + 1] =
                (uint32_t)scan->piece_count - job->view->piece_start[row + 1];
            if (!whole)
                job->failed = true;
        }
    }
    memory_free(light->context, response);
    memory_free(light->context, mark);
}

void line_map_forget_views(struct line_map_light *light)
{
    for (size_t i = 0; i < light->view_count; i++) {
        memory_free(light->context, light->views[i].jumps);
        memory_free(light->context, light->views[i].pieces);
        memory_free(light->context, light->views[i].jump_start);
        memory_free(light->context, light->views[i].piece_start);
    }
    memory_free(light->context, light->views);
    light->views = NULL;
    light->view_count = light->view_capacity = 0;
}

/* The blocks of rows one after another. */
static bool join(struct scan_job *job, size_t blocks)
{
    pnb_context *context = job->light->context;
    struct line_map_view *view = job->view;
    size_t rows = (size_t)job->light->set->rows;
    for (size_t row = 0; row < rows; row++) {
        view->jump_start[row + 1] += view->jump_start[row];
        view->piece_start[row + 1] += view->piece_start[row];
    }
    size_t jumps = view->jump_start[rows], pieces = view->piece_start[rows];
    view->jumps = memory_alloc(context, jumps, sizeof(*view->jumps));
    view->pieces = memory_alloc(context, pieces, sizeof(*view->pieces));
    if (!view->jumps || !view->pieces)
        return false;
    jumps = pieces = 0;
    for (size_t i = 0; i < blocks; i++) {
        const struct scan *scan = &job->scans[i];
        if (scan->jump_count)
            memcpy(view->jumps + jumps, scan->jumps, scan->jump_count * sizeof(*view->jumps));
        if (scan->piece_count)
            memcpy(view->pieces + pieces, scan->pieces, scan->piece_count * sizeof(*view->pieces));
        jumps += scan->jump_count;
        pieces += scan->piece_count;
    }
    return true;
}

static pnb_status scan_map(struct line_map_light *light, size_t map, struct line_map_view *view)
{
    pnb_context *context = light->context;
    size_t rows = (size_t)light->set->rows, blocks = (rows + GRAIN - 1) / GRAIN;
    struct scan_job job = {light, map, view, memory_calloc(context, blocks, sizeof(struct scan)),
                           false};
    view->jump_start = memory_calloc(context, rows + 1, sizeof(uint32_t));
    view->piece_start = memory_calloc(context, rows + 1, sizeof(uint32_t));
    bool whole = job.scans && view->jump_start && view->piece_start;
    if (whole) {
        parallel_for(context, blocks, 1, scan_body, &job);
        whole = !job.failed && join(&job, blocks);
    }
    for (size_t i = 0; i < blocks && job.scans; i++) {
        memory_free(context, job.scans[i].jumps);
        memory_free(context, job.scans[i].pieces);
    }
    memory_free(context, job.scans);
    return whole ? PNB_OK : status_no_memory(context, rows * 64);
}

pnb_status line_map_scan(struct line_map_light *light)
{
    size_t count = light->set->count, old = light->view_count;
    if (!memory_reserve(light->context, (void **)&light->views, &light->view_capacity, old,
                        count - old, sizeof(*light->views)))
        return status_no_memory(light->context, count * sizeof(*light->views));
    memset(light->views + old, 0, (count - old) * sizeof(*light->views));
    light->view_count = count;
    pnb_status status = PNB_OK;
    for (size_t k = old; k < count && status == PNB_OK; k++)
        status = scan_map(light, k, &light->views[k]);
    return status;
}

/* Into the disjoint intervals kept so far: what it touches melts into it. */
static void cover(struct line_map_cover *cover, float begin, float end)
{
    for (size_t k = 0; k < cover->count;) {
        if (cover->from[k] > end || cover->to[k] < begin) {
            k++;
            continue;
        }
        begin = fminf(begin, cover->from[k]);
        end = fmaxf(end, cover->to[k]);
        cover->count--;
        cover->from[k] = cover->from[cover->count];
        cover->to[k] = cover->to[cover->count];
        k = 0;
    }
    if (cover->count < LINE_MAP_INTERVALS) {
        cover->from[cover->count] = begin;
        cover->to[cover->count++] = end;
    }
}

void line_map_cover(const struct line_map_light *light, const struct map_point *p,
                    struct line_map_cover *out)
{
    const struct map_set *set = light->set;
    const float length = (float)set->length, a_p = p->a, r_p = p->r;
    out->count = 0;
    for (size_t m = 0; m < light->view_count; m++) {
        const struct line_map_view *view = &light->views[m];
        float texel = map_texel(set, &set->maps[m]);
        float least = LINE_MAP_LIFT * texel * r_p, most = r_p * (1 - texel * LINE_MAP_BESIDE);
        for (uint32_t i = view->piece_start[p->row]; i < view->piece_start[p->row + 1]; i++) {
            const struct line_map_piece *piece = &view->pieces[i];
            float a0 = piece->from[0], r0 = piece->from[1], a1 = piece->to[0], r1 = piece->to[1];
            /* Above the receiver's plane, and nearer to the light. */
            float h0 = p->na * a0 + p->nd * r0 - p->d - least;
            float h1 = p->na * a1 + p->nd * r1 - p->d - least;
            if ((r0 > most && r1 > most) || (h0 <= 0 && h1 <= 0))
                continue;
            if (h0 < 0 || h1 < 0) {
                float t = h0 / (h0 - h1), a = a0 + t * (a1 - a0), r = r0 + t * (r1 - r0);
                *(h0 < 0 ? &a0 : &a1) = a;
                *(h0 < 0 ? &r0 : &r1) = r;
                if (r0 > most && r1 > most)
                    continue;
            }
            if (r0 > most) {
                a0 += (most - r0) / (r1 - r0) * (a1 - a0);
                r0 = most;
            } else if (r1 > most) {
                a1 += (most - r1) / (r0 - r1) * (a0 - a1);
                r1 = most;
            }
            float s0 = a_p + (a0 - a_p) * r_p / (r_p - r0);
            float s1 = a_p + (a1 - a_p) * r_p / (r_p - r1);
            float begin = fmaxf(fminf(s0, s1), 0), end = fminf(fmaxf(s0, s1), length);
            if (begin < end)
                cover(out, begin, end);
        }
    }
}

double line_map_uncovered(const struct line_map_cover *cover, double low, double high)
{
    double seen = high - low;
    for (size_t k = 0; k < cover->count; k++)
        seen -= fmax(fmin((double)cover->to[k], high) - fmax((double)cover->from[k], low), 0);
    return fmax(seen, 0);
}
