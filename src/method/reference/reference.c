/* method/reference/reference.c: the truth: N shadow rays per receiver.
 *
 * Input: receivers (world points with geometric normals), a light. Output: the share of N
 * Owen-scrambled Sobol samples of the light that each receiver sees, by METHODS' definition: the
 * sample lies above the receiver's tangent plane, the receiver on the light's lit side, and nothing
 * lies on the open segment between them. Rays start TOLERANCE_RECEIVER_LIFT off the surface and end
 * TOLERANCE_LIGHT_GAP short of the light; both sides of a triangle block.
 *
 * Packets. A tile is 4x4 pixels of an image (16 consecutive points otherwise). Ray k of a packet
 * belongs to pixel k of the tile, and packet i of a tile sends each pixel's i-th sample. Each of
 * the 16 lanes has a sample set of its own, scrambled apart; sorted along the Morton curve of the
 * unit square, the i-th samples of all sets fall into the same small cell of the light (exactly one
 * per cell where N is a power of four), so a packet is a thin bundle although its pixels' noise is
 * independent. Neighbouring packets aim at neighbouring cells.
 *
 * Sets are tables: block b holds 16 lanes x N points, made once (prepare); their places on the
 * light are computed once a frame. A tile takes the block that a hash of its number names, so the
 * pixels of one tile never share a set, and two tiles share theirs with chance 1 / blocks. Blocks
 * fill TABLE_BYTES, at most BLOCKS_MAX.
 *
 * A point light takes one ray; receivers that face the light nowhere take none. Cost: N rays per
 * receiver, and N x 16 x 20 bytes a block. Results depend on tiles alone, never on threads.
 * Degenerate input: a receiver whose position or normal is not finite gets NaN; a sample at the
 * receiver's very place is not above its plane and counts as unseen.
 */
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "light/light.h"
#include "method/method.h"
#include "method/reference/reference.h"

#define TILE        4
#define TABLE_BYTES (4u << 20)
#define BLOCKS_MAX  64

struct sample {
    uint32_t morton;
    float u, v;
};

static uint32_t spread(uint32_t x) /* abcd -> 0a0b0c0d */
{
    x = (x | x << 8) & 0x00ff00ffu;
    x = (x | x << 4) & 0x0f0f0f0fu;
    x = (x | x << 2) & 0x33333333u;
    return (x | x << 1) & 0x55555555u;
}

static int compare_samples(const void *a, const void *b)
{
    const struct sample *p = a, *q = b;
    if (p->morton != q->morton)
        return p->morton < q->morton ? -1 : 1;
    return (p->u > q->u) - (p->u < q->u);
}

struct tables {
    struct reference *reference;
    struct sample *scratch; /* one row of N per worker */
    uint32_t seed;
    bool line;
};

static uint32_t hash32(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

/* One set: a lane of a block, sorted along the curve (along u for lines). */
static void fill_set(const struct tables *job, size_t set, struct sample *row)
{
    struct reference *r = job->reference;
    size_t block = set / TRACE_WIDTH, lane = set % TRACE_WIDTH;
    uint32_t seed = hash32((uint32_t)set * 0x9e3779b9u + hash32(job->seed + 0x7f4a7c15u));
    for (uint32_t i = 0; i < r->samples; i++) {
        light_sobol_owen(i, seed, &row[i].u, &row[i].v);
        row[i].morton = job->line ? (uint32_t)(row[i].u * 0x1p24f)
                                  : spread((uint32_t)(row[i].u * 65536.0f)) |
                                        spread((uint32_t)(row[i].v * 65536.0f)) << 1;
    }
    qsort(row, r->samples, sizeof(*row), compare_samples);
    for (uint32_t i = 0; i < r->samples; i++) {
        float *uv = r->uv + ((block * r->samples + i) * 2) * TRACE_WIDTH + lane;
        uv[0] = row[i].u;
        uv[TRACE_WIDTH] = row[i].v;
    }
}

static void fill_body(void *user, size_t begin, size_t end, int worker)
{
    const struct tables *job = user;
    for (size_t set = begin; set < end; set++)
        fill_set(job, set, job->scratch + (size_t)worker * job->reference->samples);
}

/* Lines want the order along u, area lights along the curve: made again when that changes. */
static pnb_status fill_tables(pnb_solver *solver, bool line)
{
    struct reference *r = solver->state;
    pnb_context *context = solver->context;
    if (r->filled && r->filled_line == line)
        return PNB_OK;
    size_t rows = (size_t)pnb_context_threads(context);
    struct tables job = {r, memory_alloc(context, rows * r->samples, sizeof(struct sample)),
                         (uint32_t)solver_param_number(solver, "seed"), line};
    if (!job.scratch)
        return status_no_memory(context, rows * r->samples * sizeof(struct sample));
    parallel_for(context, r->blocks * TRACE_WIDTH, 1, fill_body, &job);
    memory_free(context, job.scratch);
    r->filled = true;
    r->filled_line = line;
    return PNB_OK;
}

static pnb_status reference_create(pnb_solver *solver)
{
    pnb_context *context = solver->context;
    struct reference *r = memory_calloc(context, 1, sizeof(*r));
    if (!r)
        return status_no_memory(context, sizeof(*r));
    solver->state = r;
    r->samples = (uint32_t)solver->samples;
    size_t block_floats = (size_t)r->samples * TRACE_WIDTH;
    r->blocks = TABLE_BYTES / (block_floats * 3 * sizeof(float));
    r->blocks = r->blocks < 1 ? 1 : r->blocks > BLOCKS_MAX ? BLOCKS_MAX : r->blocks;
    r->uv = memory_alloc(context, r->blocks * block_floats * 2, sizeof(float));
    r->targets = memory_alloc(context, r->blocks * block_floats * 3, sizeof(float));
    if (!r->uv || !r->targets)
        return status_no_memory(context, r->blocks * block_floats * 5 * sizeof(float));
    pnb_status status = fill_tables(solver, false);
    if (status != PNB_OK)
        return status;
    return trace_create(solver->scene, true, &r->trace);
}

static void reference_destroy(pnb_solver *solver)
{
    struct reference *r = solver->state;
    if (!r)
        return;
    trace_destroy(r->trace);
    memory_free(solver->context, r->uv);
    memory_free(solver->context, r->targets);
    memory_free(solver->context, r);
}

static pnb_status reference_update(pnb_solver *solver, pnb_update update)
{
    struct reference *r = solver->state;
    struct trace *trace;
    pnb_status status = trace_create(solver->scene, true, &trace);
    if (status != PNB_OK)
        return status;
    trace_destroy(r->trace);
    r->trace = trace;
    return PNB_OK;
}

static void target_body(void *user, size_t begin, size_t end, int worker)
{
    const struct reference_frame *frame = user;
    const struct reference *r = frame->reference;
    for (size_t i = begin; i < end; i++) {
        const float *uv = r->uv + i * 2 * TRACE_WIDTH;
        float *target = r->targets + i * 3 * TRACE_WIDTH;
        for (int lane = 0; lane < TRACE_WIDTH; lane++) {
            struct light_point l =
                light_shape_sample(frame->shape, uv[lane], uv[TRACE_WIDTH + lane]);
            target[lane] = (float)l.p.x;
            target[TRACE_WIDTH + lane] = (float)l.p.y;
            target[2 * TRACE_WIDTH + lane] = (float)l.p.z;
        }
    }
}

/* The receivers of a tile, and how each faces the light. */
static bool tile_begin(const struct reference_frame *frame, size_t tile, struct reference_tile *t)
{
    const pnb_receivers *receivers = frame->receivers;
    bool any = false;
    t->all = true;
    t->block = hash32((uint32_t)tile ^ 0x5bf03635u) % frame->reference->blocks;
    for (int lane = 0; lane < TRACE_WIDTH; lane++) {
        size_t index = tile * TRACE_WIDTH + (size_t)lane;
        bool inside = index < receivers->count;
        if (receivers->width > 0) {
            size_t x = tile % frame->tiles_x * TILE + (size_t)lane % TILE;
            size_t y = tile / frame->tiles_x * TILE + (size_t)lane / TILE;
            inside = x < (size_t)receivers->width && y < (size_t)receivers->height;
            index = y * (size_t)receivers->width + x;
        }
        t->index[lane] = inside ? index : SIZE_MAX;
        t->valid[lane] = 0;
        t->seen[lane] = 0;
        for (int c = 0; c < 3; c++)
            t->origin[c][lane] = t->plane[c][lane] = 0;
        t->plane[3][lane] = 0;
        if (!inside)
            continue;
        vec3 p = v3_loadf(receivers->positions + 3 * index);
        vec3 n = v3_loadf(receivers->normals + 3 * index);
        if (!v3_finite(p) || !v3_finite(n)) {
            frame->visibility[index] = NAN;
            t->index[lane] = SIZE_MAX;
            continue;
        }
        enum light_facing facing = light_shape_facing(frame->shape, p, n);
        if (facing == LIGHT_FACING_NONE)
            continue;
        if (facing == LIGHT_FACING_SOME)
            t->all = false;
        any = true;
        t->valid[lane] = -1;
        vec3 lifted = v3_mad(p, n, frame->lift);
        t->origin[0][lane] = (float)lifted.x;
        t->origin[1][lane] = (float)lifted.y;
        t->origin[2][lane] = (float)lifted.z;
        t->plane[0][lane] = (float)n.x;
        t->plane[1][lane] = (float)n.y;
        t->plane[2][lane] = (float)n.z;
        /* Height of a direction's end over the tangent plane: n.dir + lift for segments, n.dir for
         * the sun. */
        t->plane[3][lane] = frame->sun ? 0 : (float)v3_dot(v3_sub(lifted, p), n);
    }
    return any;
}

static void tile_end(const struct reference_frame *frame, const struct reference_tile *t,
                     uint32_t samples)
{
    for (int lane = 0; lane < TRACE_WIDTH; lane++)
        if (t->index[lane] != SIZE_MAX)
            frame->visibility[t->index[lane]] = (float)t->seen[lane] / (float)samples;
}

/* dir = target - origin, tfar, and which rays count; plain loops that compilers turn into wide
 * instructions. */
__attribute__((always_inline)) static inline void
aim_lanes(const float *restrict target, const struct reference_tile *restrict t, float tfar,
          struct trace_rays *restrict rays, int32_t *restrict valid)
{
    for (int lane = 0; lane < TRACE_WIDTH; lane++) {
        rays->dir_x[lane] = target[lane] - t->origin[0][lane];
        rays->dir_y[lane] = target[TRACE_WIDTH + lane] - t->origin[1][lane];
        rays->dir_z[lane] = target[2 * TRACE_WIDTH + lane] - t->origin[2][lane];
        rays->tfar[lane] = tfar;
        valid[lane] = t->valid[lane];
    }
}

/* Drops the rays whose sample is not above the tangent plane. */
static void drop_below(const struct reference_tile *t, const struct trace_rays *rays,
                       int32_t *valid)
{
    for (int lane = 0; lane < TRACE_WIDTH; lane++) {
        float height = t->plane[0][lane] * rays->dir_x[lane] +
                       t->plane[1][lane] * rays->dir_y[lane] +
                       t->plane[2][lane] * rays->dir_z[lane] + t->plane[3][lane];
        valid[lane] &= -(int32_t)(height > 0);
    }
}

static void tile_trace(const struct reference_frame *frame, struct reference_tile *t,
                       uint64_t *rays_traced)
{
    const struct reference *r = frame->reference;
    struct trace_rays rays;
    int32_t valid[TRACE_WIDTH] __attribute__((aligned(64)));
    trace_rays_init(&rays);
    memcpy(rays.org_x, t->origin[0], sizeof(rays.org_x));
    memcpy(rays.org_y, t->origin[1], sizeof(rays.org_y));
    memcpy(rays.org_z, t->origin[2], sizeof(rays.org_z));
    const float *targets = r->targets + t->block * r->samples * 3 * TRACE_WIDTH;
    struct reference_tile still = *t;
    if (frame->sun) /* directions: nothing to subtract */
        memset(still.origin, 0, sizeof(still.origin));
    for (uint32_t i = 0; i < frame->samples; i++) {
        aim_lanes(targets + (size_t)i * 3 * TRACE_WIDTH, &still, frame->tfar, &rays, valid);
        if (!t->all)
            drop_below(t, &rays, valid);
        trace_occluded(r->trace, valid, &rays);
        for (int lane = 0; lane < TRACE_WIDTH; lane++) {
            t->seen[lane] += (uint32_t)(valid[lane] & (rays.tfar[lane] > 0));
            *rays_traced += (uint32_t)-valid[lane];
        }
    }
}

static void trace_body(void *user, size_t begin, size_t end, int worker)
{
    const struct reference_frame *frame = user;
    uint64_t rays = 0;
    for (size_t tile = begin; tile < end; tile++) {
        struct reference_tile t;
        if (tile_begin(frame, tile, &t))
            tile_trace(frame, &t, &rays);
        tile_end(frame, &t, frame->samples);
    }
    frame->rays[worker].count += rays;
}

static pnb_status reference_visibility(pnb_solver *solver, const pnb_light *light,
                                       const pnb_receivers *receivers, float *visibility)
{
    struct reference *r = solver->state;
    pnb_context *context = solver->context;
    struct light_shape shape;
    pnb_status status = light_shape_init(context, light, &shape);
    if (status != PNB_OK)
        return status;
    struct reference_frame frame = {
        .reference = r,
        .shape = &shape,
        .receivers = receivers,
        .visibility = visibility,
        .samples = light->type == PNB_LIGHT_POINT ? 1 : r->samples,
        .lift = scene_receiver_lift(solver->scene),
        .sun = light->type == PNB_LIGHT_SUN,
        .tfar = light->type == PNB_LIGHT_SUN ? INFINITY : (float)(1 - TOLERANCE_LIGHT_GAP),
    };
    size_t tiles = (receivers->count + TRACE_WIDTH - 1) / TRACE_WIDTH;
    if (receivers->width > 0) {
        frame.tiles_x = (size_t)(receivers->width + TILE - 1) / TILE;
        tiles = frame.tiles_x * (size_t)((receivers->height + TILE - 1) / TILE);
    }
    size_t workers = (size_t)pnb_context_threads(context);
    frame.rays = memory_calloc(context, workers, sizeof(*frame.rays));
    if (!frame.rays)
        status = status_no_memory(context, workers * sizeof(*frame.rays));
    if (status == PNB_OK)
        status = fill_tables(solver, light->type == PNB_LIGHT_LINE);
    if (status == PNB_OK) {
        parallel_for(context, r->blocks * r->samples, 1024, target_body, &frame);
        status = parallel_for_progress(context, "visibility", 0, 1, tiles, 16, trace_body, &frame);
    }
    if (status == PNB_OK) {
        uint64_t rays = 0;
        for (size_t i = 0; i < workers; i++)
            rays += frame.rays[i].count;
        solver_count(solver, "rays", (double)rays);
    }
    memory_free(context, frame.rays);
    light_shape_finish(context, &shape);
    return status;
}

static const pnb_param_info params[] = {
    {"seed", PNB_PARAM_INTEGER, "0", 0, 4294967295.0, NULL,
     "another number gives another, equally good set of light samples"},
};

const struct method method_reference = {
    .info =
        {
            .name = "reference",
            .title = "ray-traced reference",
            .paper = "",
            .summary = "The truth: Embree shadow rays to N Owen-scrambled Sobol samples of the "
                       "light per pixel.",
            .lights = PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) | PNB_LIGHT_BIT(PNB_LIGHT_LINE) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POINT) | PNB_LIGHT_BIT(PNB_LIGHT_SUN),
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_CPU,
            .samples = true,
            .default_samples = 1024,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = reference_create,
    .destroy = reference_destroy,
    .update = reference_update,
    .visibility = reference_visibility,
};
