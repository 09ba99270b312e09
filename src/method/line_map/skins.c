/* method/line_map/skins.c: depth discontinuities, the skins that hang from them, and the visibility
 * channels that they are drawn into (the paper's section 3.2).
 *
 * Rows of all maps are the same half-planes, so a skin, the polygon between an occluder's texel and
 * the receiver's texel beside it, stays in its row when it is warped: from u_i at the occluder's
 * q_o to u_i at the receiver's q_r in map i it becomes
 *
 *     u_j = u_i + (s_i - s_j) q,   q from q_o to q_r                      in map j
 *
 * and its depth there is q_skin(u) = (u - u_i) / (s_i - s_j). Texels of map j whose surface lies
 * behind it (q_p < q_skin) do not see sample i: the penumbra. Skins are drawn with their front
 * alone, that is where the occluder is on the side away from j; the backs bound nothing that j
 * sees.
 *
 * Transition. A surface at (u_p, q_p) behind the edge (u_o, q_o), both in map j, sees the light
 * from s_j to s*, where s* - s_j = (u_o - u_p) / (q_o - q_p): the paper's equation 1 (x1 = t x2 /
 * ((n - m) x2 + s)) in these coordinates, exact for any receiver. The paper shades linearly between
 * the skin's ends instead: (u_p - u_o) / (u_r - u_o), the same where light and receiver are
 * parallel.
 *
 * Thick occluders. From below a box the light ends at its lower edge, which the other sample may
 * not see, but this one does. So edges of map j's own discontinuities are drawn into its channel as
 * well, as if sample i saw them (edges=both; edges=other: the paper's, without).
 *
 * Overlapping skins. The light that p sees from s_j on ends at the nearest s*, so the least share
 * stays (overlap=least); the paper's depth buffer keeps the skin nearest to sample j.
 *
 * Discontinuities. A 3x3 Laplacian of Gaussian (1 2 1; 2 -12 2; 1 2 1) / 16 of q: q is linear
 * across flat surfaces, so slanted floors give nothing. A pair of texels in a row is an edge where
 * the response is a quarter step or more at one of them and the step between the two, less the
 * surface's own slope on its flatter side, is more than the threshold in metres of r.
 *
 * Parallel over rows. Cost: about 1 ns a texel for the filter, 1 ns a texel of skin.
 */
#include <string.h>

#include "method/line_map/line_map.h"

#define STEP_TEXELS 2.0 /* automatic threshold: a step of so many texels' width */
#define SLACK       LINE_MAP_SLACK

/* Loops over texels are built for wide vectors as well, chosen at load time. Same results: no
 * contraction, and every operation is rounded alike. */
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define LINE_MAP_WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define LINE_MAP_WIDE
#endif

struct warp_worker {
    float *surface; /* columns: the nearest of casters and others */
    float *depth;   /* columns: overlap=nearest */
    uint64_t skins, texels;
    char padding[64];
};

struct warp_job {
    struct line_map_light *light;
    size_t begin, end;
    struct warp_worker *workers;
};

/* The least difference of q that is a step down from q, as a share of q. */
struct step {
    float fixed, metres;
};

static inline float least_step(struct step step, float q)
{
    return q * (step.fixed + step.metres * q / (1 + step.metres * q));
}

LINE_MAP_WIDE static void filter_row(const float *restrict above, const float *restrict row,
                                     const float *restrict below, int columns, struct step step,
                                     float *restrict response, uint8_t *restrict mark)
{
    for (int c = 1; c + 1 < columns; c++) {
        float corners = above[c - 1] + above[c + 1] + below[c - 1] + below[c + 1];
        float sides = above[c] + below[c] + row[c - 1] + row[c + 1];
        response[c] = (corners + 2 * sides - 12 * row[c]) * (1.0f / 16);
    }
    response[0] = columns > 2 ? response[1] : row[columns - 1] - row[0];
    response[columns - 1] = columns > 2 ? response[columns - 2] : response[0];
    for (int c = 0; c < columns; c++)
        mark[c] = fabsf(response[c]) > 0.25f * least_step(step, row[c]);
}

/* Whether the surfaces of texels c and c + 1, each prolonged as it runs on its own side, part by
 * more than least. Columns may be spaced unevenly. */
static bool is_step(const float *u, const float *q, int columns, int c, float least)
{
    float gap = u[c + 1] - u[c], before = INFINITY, after = INFINITY;
    if (c > 0)
        before = fabsf(q[c] - q[c - 1]) / (u[c] - u[c - 1]) * gap;
    if (c + 2 < columns)
        after = fabsf(q[c + 2] - q[c + 1]) / (u[c + 2] - u[c + 1]) * gap;
    float slope = fminf(before, after);
    return fabsf(q[c + 1] - q[c]) - (isfinite(slope) ? slope : 0) > least;
}

/* Between the two texels; on the nearer surface's where columns are far apart. */
static float edge_place(const float *u, int c, bool near_left)
{
    float middle = 0.5f * (u[c] + u[c + 1]);
    return fabsf(middle) > 2 ? u[near_left ? c : c + 1] : middle;
}

void line_map_least_step(const struct line_map *method, const struct map_set *set,
                         const struct map *map, double *out_fixed, double *out_metres)
{
    float texels = (float)STEP_TEXELS * map_texel(set, map);
    *out_fixed = method->threshold > 0 ? 0 : (double)(texels / (1 + texels));
    *out_metres = method->threshold > 0 ? method->threshold : 0;
}

size_t line_map_find_jumps(const struct line_map_light *light, const struct map *map, int row,
                           float *response, uint8_t *mark, struct line_map_jump *jumps)
{
    const struct map_set *set = light->set;
    const int columns = set->columns;
    double fixed, metres;
    line_map_least_step(light->method, set, map, &fixed, &metres);
    struct step step = {(float)fixed, (float)metres};
    int up = set->row_above[row], down = set->row_below[row];
    const float *q = map->q + (size_t)row * (size_t)columns;
    filter_row(map->q + (size_t)up * (size_t)columns, q, map->q + (size_t)down * (size_t)columns,
               columns, step, response, mark);
    size_t count = 0;
    for (int c = 0; c + 1 < columns; c++) {
        uint64_t eight[2];
        memcpy(&eight[0], mark + c, 8);
        memcpy(&eight[1], mark + c + 1, 8);
        if (!(eight[0] | eight[1])) {
            c += 7;
            continue;
        }
        float a = q[c], b = q[c + 1], near = fmaxf(a, b), least = least_step(step, near);
        float most = fmaxf(fabsf(response[c]), fabsf(response[c + 1]));
        if (most > 0.25f * least && is_step(map->u, q, columns, c, least))
            jumps[count++] =
                (struct line_map_jump){edge_place(map->u, c, a > b), near, fminf(a, b), a > b, c};
    }
    return count;
}

/* One skin in the map that it is warped into. */
struct skin {
    float u, near_u, far_u;       /* the line through the edge; where its ends appear */
    float near_q, inverse, slack; /* inverse: 1 / (s_i - s_j) */
    float across;                 /* 1 / (u_r - u_o), for the linear transition */
};

LINE_MAP_WIDE static void draw_rational(const struct skin *skin, const float *restrict u,
                                        const float *restrict surface, int first, int last,
                                        uint16_t *restrict share)
{
    const float line_u = skin->u, near_u = skin->near_u, near_q = skin->near_q;
    const float inverse = skin->inverse, slack = skin->slack;
    for (int c = first; c < last; c++) {
        float q = surface[c], behind = (u[c] - line_u) * inverse + slack;
        float seen = (near_u - u[c]) / (near_q - q) * inverse;
        seen = seen > 0 ? seen : 0;
        seen = seen < 1 ? seen : 1;
        int32_t value = (int32_t)(seen * LINE_MAP_SHARE_ONE + 0.5f);
        value = q < behind && q < near_q ? value : LINE_MAP_NO_SKIN;
        int32_t old = share[c];
        share[c] = (uint16_t)(value < old ? value : old);
    }
}

/* The paper's choices, one or both of them. */
static void draw_other(const struct line_map *method, const struct skin *skin, const float *u,
                       const float *surface, int first, int last, float *depth, uint16_t *share)
{
    for (int c = first; c < last; c++) {
        float q = surface[c], line = (u[c] - skin->u) * skin->inverse;
        if (!(q < line + skin->slack) || !(q < skin->near_q))
            continue;
        float seen = (u[c] - skin->near_u) * skin->across;
        if (!method->linear)
            seen = (skin->near_u - u[c]) / (skin->near_q - q) * skin->inverse;
        seen = fminf(fmaxf(seen, 0), 1);
        uint16_t value = (uint16_t)(seen * LINE_MAP_SHARE_ONE + 0.5f);
        if (method->nearest && line > depth[c]) {
            depth[c] = line;
            share[c] = value;
        } else if (!method->nearest && value < share[c]) {
            share[c] = value;
        }
    }
}

/* Draws edges into the channel of map `into`: those of map `from`, or its own as if from saw them.
 */
static void draw_skins(const struct warp_job *job, const struct map *from, const struct map *into,
                       const struct line_map_jump *edges, size_t count, bool own, uint16_t *share,
                       struct warp_worker *worker)
{
    const struct map_set *set = job->light->set;
    const struct line_map *method = job->light->method;
    const int columns = set->columns;
    float shift = (float)(from->at - into->at);
    bool front_left = into->at > from->at;
    for (size_t e = 0; e < count; e++) {
        if (edges[e].near_left != front_left)
            continue;
        struct skin skin = {.u = edges[e].u, .near_q = edges[e].near_q, .inverse = 1 / shift};
        float far_q = edges[e].far_q;
        skin.across = 1 / (shift * (far_q - skin.near_q));
        if (own) {
            skin.u -= shift * skin.near_q;
            far_q *= 0.5f; /* what the ray from the other sample meets is not known */
        }
        skin.near_u = skin.u + shift * skin.near_q;
        skin.far_u = skin.u + shift * far_q;
        skin.slack = fabsf(skin.inverse) / into->scale * SLACK;
        float low = map_spread(set, fminf(skin.near_u, skin.far_u));
        float high = map_spread(set, fmaxf(skin.near_u, skin.far_u));
        low = (low - into->low) * into->scale - SLACK;
        high = (high - into->low) * into->scale + SLACK;
        if (!(high > 0) || !(low < (float)columns))
            continue;
        int first = low > 0 ? (int)low : 0, last = high < (float)columns ? (int)high : columns;
        worker->skins++;
        worker->texels += (uint64_t)(last - first);
        if (method->linear || method->nearest)
            draw_other(method, &skin, into->u, worker->surface, first, last, worker->depth, share);
        else
            draw_rational(&skin, into->u, worker->surface, first, last, share);
    }
}

/* The channel of map `into` towards map `from`, one row. */
static void draw_row(const struct warp_job *job, const struct map *from, const struct map *into,
                     const struct line_map_jump *from_edges, size_t from_count,
                     const struct line_map_jump *into_edges, size_t into_count, size_t row,
                     uint16_t *channel, struct warp_worker *worker)
{
    const struct line_map *method = job->light->method;
    size_t columns = (size_t)job->light->set->columns, at = row * columns;
    memset(channel + at, 0xff, columns * sizeof(*channel));
    if (from_count + into_count == 0)
        return;
    memcpy(worker->surface, into->q + at, columns * sizeof(float));
    for (size_t c = 0; c < columns && into->passive; c++)
        worker->surface[c] = fmaxf(worker->surface[c], into->passive[at + c]);
    if (method->nearest)
        memset(worker->depth, 0, columns * sizeof(float));
    draw_skins(job, from, into, from_edges, from_count, false, channel + at, worker);
    if (method->own_edges)
        draw_skins(job, from, into, into_edges, into_count, true, channel + at, worker);
}

static void warp_body(void *user, size_t begin, size_t end, int index)
{
    const struct warp_job *job = user;
    const struct map_set *set = job->light->set;
    const struct line_map_view *views = job->light->views;
    struct warp_worker *worker = &job->workers[index];
    for (size_t row = begin; row < end; row++)
        for (size_t k = job->begin; k < job->end; k++) {
            const struct line_map_segment *segment = &job->light->segments[k];
            const struct map *left = &set->maps[segment->left];
            const struct map *right = &set->maps[segment->right];
            const struct line_map_view *l = &views[segment->left], *r = &views[segment->right];
            const struct line_map_jump *ours = l->jumps + l->jump_start[row];
            const struct line_map_jump *theirs = r->jumps + r->jump_start[row];
            size_t our_count = l->jump_start[row + 1] - l->jump_start[row];
            size_t their_count = r->jump_start[row + 1] - r->jump_start[row];
            draw_row(job, left, right, ours, our_count, theirs, their_count, row,
                     segment->from_right, worker);
            draw_row(job, right, left, theirs, their_count, ours, our_count, row,
                     segment->from_left, worker);
        }
}

pnb_status line_map_warp(struct line_map_light *light, size_t begin, size_t end)
{
    pnb_context *context = light->context;
    size_t workers = (size_t)pnb_context_threads(context), columns = (size_t)light->set->columns;
    struct warp_job job = {light, begin, end,
                           memory_calloc(context, workers, sizeof(struct warp_worker))};
    bool whole = job.workers != NULL;
    for (size_t w = 0; w < workers && whole; w++) {
        struct warp_worker *worker = &job.workers[w];
        worker->surface = memory_alloc(context, columns, sizeof(float));
        worker->depth = memory_alloc(context, columns, sizeof(float));
        whole = worker->surface && worker->depth;
    }
    if (whole)
        parallel_for(context, (size_t)light->set->rows, 8, warp_body, &job);
    for (size_t w = 0; w < workers && job.workers; w++) {
        struct warp_worker *worker = &job.workers[w];
        light->method->skins += (double)worker->skins;
        light->method->texels += (double)worker->texels;
        memory_free(context, worker->surface);
        memory_free(context, worker->depth);
    }
    memory_free(context, job.workers);
    return whole ? PNB_OK : status_no_memory(context, workers * columns * 8);
}
