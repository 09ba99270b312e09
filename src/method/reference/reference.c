/* method/reference/reference.c: the truth: N shadow rays per receiver.
 *
 * Input: receivers (world points with geometric normals), a light. Output: the share of N
 * Owen-scrambled Sobol samples of the light that each receiver sees, by METHODS' definition: the
 * sample lies above the receiver's tangent plane, the receiver on the light's lit side, and nothing
 * lies on the open segment between them. Rays start TOLERANCE_RECEIVER_LIFT off the surface and end
 * TOLERANCE_LIGHT_GAP short of the light; both sides of a triangle block.
 *
 * Packets hold 16 samples of one pixel that follow one another along the Morton curve of the unit
 * square: a 4x4 patch of the cells of a stratified set, so the 16 rays leave one point in a thin
 * bundle, and the next packet's bundle lies beside it. (`penumbra bench reference` compares forms:
 * packets of 16 neighbouring pixels that aim at one cell reach 0.3 to 0.7 of the throughput, single
 * rays 0.25 to 0.75, packets of 8 0.7 to 1.0, streams 0.8 to 1.2.) Where 16 does not divide N,
 * packets run on into the next pixel. Bundles narrower than COHERENT_RAD are announced to Embree as
 * coherent.
 *
 * Sample sets are tables. A tile is 4x4 pixels of an image, or 16 consecutive points, and block b
 * of the tables holds 16 sets that are scrambled apart; a tile takes the block that a hash of its
 * number names, so its pixels never share a set and two tiles share theirs with chance 1 / blocks.
 * The noise of neighbouring pixels is thus independent. Blocks fill TABLE_BYTES, at most
 * BLOCKS_MAX. They are made once (prepare), their places on the light once a frame.
 *
 * A point light takes one ray; receivers that face the light nowhere take none. Cost: N rays per
 * receiver, and N x 320 bytes a block. Results depend on tiles alone, never on threads.
 * Degenerate input: a receiver whose position or normal is not finite gets NaN; a sample at the
 * receiver's very place is not above its plane and counts as unseen.
 */
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "light/light.h"
#include "method/method.h"
#include "method/reference/reference.h"

#define TILE         4
#define TABLE_BYTES  (4u << 20)
#define BLOCKS_MAX   64
#define COHERENT_RAD 0.06
#define BATCH        8

/* The loop around the tracing call is built for wide vectors as well, chosen at load time. Same
 * results: subtraction and comparison only, and no contraction. */
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)
#define REFERENCE_WIDE __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define REFERENCE_WIDE
#endif

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

/* One set, sorted along the curve (along u for lines). */
static void fill_set(const struct tables *job, size_t set, struct sample *row)
{
    struct reference *r = job->reference;
    uint32_t seed = hash32((uint32_t)set * 0x9e3779b9u + hash32(job->seed + 0x7f4a7c15u));
    for (uint32_t i = 0; i < r->samples; i++) {
        light_sobol_owen(i, seed, &row[i].u, &row[i].v);
        row[i].morton = job->line ? (uint32_t)(row[i].u * 0x1p24f)
                                  : spread((uint32_t)(row[i].u * 65536.0f)) |
                                        spread((uint32_t)(row[i].v * 65536.0f)) << 1;
    }
    qsort(row, r->samples, sizeof(*row), compare_samples);
    float *uv = r->uv + set * 2 * r->samples;
    for (uint32_t i = 0; i < r->samples; i++) {
        uv[i] = row[i].u;
        uv[r->samples + i] = row[i].v;
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
    parallel_for(context, r->blocks * REFERENCE_TILE, 1, fill_body, &job);
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
    size_t block_floats = (size_t)r->samples * REFERENCE_TILE;
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
    for (size_t set = begin; set < end; set++) {
        const float *uv = r->uv + set * 2 * r->samples;
        float *target = r->targets + set * 3 * r->samples;
        for (size_t i = 0; i < r->samples; i++) {
            struct light_point l = light_shape_sample(frame->shape, uv[i], uv[r->samples + i]);
            target[i] = (float)l.p.x;
            target[r->samples + i] = (float)l.p.y;
            target[2 * (size_t)r->samples + i] = (float)l.p.z;
        }
    }
}

/* The receiver of a tile's lane; false: there is none. */
static bool tile_receiver(const struct reference_frame *frame, size_t tile, size_t lane,
                          size_t *out_index)
{
    const pnb_receivers *receivers = frame->receivers;
    if (receivers->width > 0) {
        size_t x = tile % frame->tiles_x * TILE + lane % TILE;
        size_t y = tile / frame->tiles_x * TILE + lane / TILE;
        *out_index = y * (size_t)receivers->width + x;
        return x < (size_t)receivers->width && y < (size_t)receivers->height;
    }
    *out_index = tile * REFERENCE_TILE + lane;
    return *out_index < receivers->count;
}

/* The receivers of a tile that face some of the light; the others' visibility is written. */
void reference_tile_begin(const struct reference_frame *frame, size_t tile,
                          struct reference_tile *t)
{
    const struct reference *r = frame->reference;
    size_t block = hash32((uint32_t)tile ^ 0x5bf03635u) % r->blocks;
    t->count = 0;
    for (size_t lane = 0; lane < REFERENCE_TILE; lane++) {
        size_t index;
        if (!tile_receiver(frame, tile, lane, &index))
            continue;
        vec3 p = v3_loadf(frame->receivers->positions + 3 * index);
        vec3 n = v3_loadf(frame->receivers->normals + 3 * index);
        if (!v3_finite(p) || !v3_finite(n)) {
            frame->visibility[index] = NAN;
            continue;
        }
        enum light_facing facing = light_shape_facing(frame->shape, p, n);
        if (facing == LIGHT_FACING_NONE) {
            frame->visibility[index] = 0;
            continue;
        }
        struct reference_receiver *at = &t->receivers[t->count++];
        vec3 lifted = v3_mad(p, n, frame->lift);
        v3_storef(at->origin, lifted);
        v3_storef(at->normal, n);
        /* A sample's height over the tangent plane is n.dir + lift, for the sun n.dir. */
        at->height = frame->sun ? 0 : (float)v3_dot(v3_sub(lifted, p), n);
        at->whole = facing == LIGHT_FACING_ALL;
        at->index = index;
        at->seen = 0;
        at->targets = r->targets + (block * REFERENCE_TILE + lane) * 3 * r->samples;
        double distance2 = 1;
        if (!frame->sun) {
            vec3 d = v3_sub(frame->middle, p);
            distance2 = v3_dot(d, d);
        }
        at->coherent = frame->packet_area < COHERENT_RAD * COHERENT_RAD * distance2;
    }
}

/* Sets one receiver's part of a packet: lanes [first, last) get its samples from sample on. */
__attribute__((always_inline)) static inline void
aim(const struct reference_frame *frame, const struct reference_receiver *at, int first, int last,
    size_t sample, struct trace_rays *restrict rays, int32_t *restrict valid)
{
    const float *restrict x = at->targets + sample - first;
    const float *restrict y = x + frame->reference->samples, *restrict z =
                                                                 y + frame->reference->samples;
    /* The sun's samples are directions. */
    float keep = frame->sun ? 0.0f : 1.0f;
    float ox = keep * at->origin[0], oy = keep * at->origin[1], oz = keep * at->origin[2];
    float nx = at->normal[0], ny = at->normal[1], nz = at->normal[2], height = at->height;
    for (int lane = first; lane < last; lane++) {
        rays->dir_x[lane] = x[lane] - ox;
        rays->dir_y[lane] = y[lane] - oy;
        rays->dir_z[lane] = z[lane] - oz;
        rays->tfar[lane] = frame->tfar;
        valid[lane] = -1;
    }
    if (!at->whole)
        for (int lane = first; lane < last; lane++) {
            float h = nx * rays->dir_x[lane] + ny * rays->dir_y[lane] + nz * rays->dir_z[lane];
            valid[lane] = -(int32_t)(h + height > 0);
        }
}

__attribute__((always_inline)) static inline void
set_origin(const struct reference_receiver *at, int first, int last, struct trace_rays *rays)
{
    for (int lane = first; lane < last; lane++) {
        rays->org_x[lane] = at->origin[0];
        rays->org_y[lane] = at->origin[1];
        rays->org_z[lane] = at->origin[2];
    }
}

void reference_packet(const struct reference_frame *frame, const struct reference_receiver *at,
                      size_t sample, struct trace_rays *rays, int32_t *valid)
{
    set_origin(at, 0, TRACE_WIDTH, rays);
    aim(frame, at, 0, TRACE_WIDTH, sample, rays, valid);
}

/* GCC and clang vectors: left to itself, the compiler unrolls the lanes instead. */
typedef float float16 __attribute__((vector_size(64), aligned(4), may_alias));
typedef int32_t int16 __attribute__((vector_size(64), aligned(4), may_alias));

/* A whole packet: aim() in vectors, the same operations. */
#define aim_whole(frame, at, sample, rays, valid)                                                  \
    __extension__({                                                                                \
        const float *x_ = (at)->targets + (sample), *y_ = x_ + (frame)->reference->samples,        \
                    *z_ = y_ + (frame)->reference->samples;                                        \
        float keep_ = (frame)->sun ? 0.0f : 1.0f;                                                  \
        float16 dx_ = *(const float16 *)x_ - keep_ * (at)->origin[0];                              \
        float16 dy_ = *(const float16 *)y_ - keep_ * (at)->origin[1];                              \
        float16 dz_ = *(const float16 *)z_ - keep_ * (at)->origin[2];                              \
        float16 h_ = (at)->normal[0] * dx_ + (at)->normal[1] * dy_ + (at)->normal[2] * dz_;        \
        int16 valid_ = (h_ + (at)->height > 0) | ((at)->whole ? -1 : 0);                           \
        *(float16 *)(rays)->dir_x = dx_;                                                           \
        *(float16 *)(rays)->dir_y = dy_;                                                           \
        *(float16 *)(rays)->dir_z = dz_;                                                           \
        *(float16 *)(rays)->tfar = (float16){0} + (frame)->tfar;                                   \
        *(int16 *)(valid) = valid_;                                                                \
        valid_;                                                                                    \
    })

/* N a multiple of 16: whole packets per receiver. Packets are written, traced and read in batches:
 * Embree loads whole cache lines that were just stored in smaller pieces, and the other way round,
 * which would stall on each packet. */
REFERENCE_WIDE
static uint64_t trace_whole(const struct reference_frame *frame, struct reference_tile *t,
                            struct trace_rays rays[BATCH])
{
    uint64_t traced = 0;
    int32_t valid[BATCH][TRACE_WIDTH] __attribute__((aligned(64)));
    int packets = (int)(frame->samples / TRACE_WIDTH);
    for (int k = 0; k < t->count; k++) {
        struct reference_receiver *at = &t->receivers[k];
        int16 seen = {0}, above = {0}; /* minus the counts, per lane */
        for (int b = 0; b < BATCH && b < packets; b++)
            set_origin(at, 0, TRACE_WIDTH, &rays[b]);
        for (int first = 0; first < packets; first += BATCH) {
            int count = packets - first < BATCH ? packets - first : BATCH;
            for (int b = 0; b < count; b++)
                above +=
                    aim_whole(frame, at, (size_t)(first + b) * TRACE_WIDTH, &rays[b], valid[b]);
            for (int b = 0; b < count; b++)
                trace_occluded(frame->reference->trace, valid[b], at->coherent, &rays[b]);
            for (int b = 0; b < count; b++)
                seen += *(const int16 *)valid[b] & (*(const float16 *)rays[b].tfar > 0);
        }
        for (int lane = 0; lane < TRACE_WIDTH; lane++) {
            at->seen -= (uint32_t)seen[lane];
            traced += (uint32_t)-above[lane];
        }
    }
    return traced;
}

/* Any N: packets are filled from one receiver after the other. */
static uint64_t trace_mixed(const struct reference_frame *frame, struct reference_tile *t)
{
    uint64_t traced = 0;
    struct trace_rays rays;
    int32_t valid[TRACE_WIDTH] __attribute__((aligned(64)));
    int owner[TRACE_WIDTH];
    int k = 0;
    size_t sample = 0;
    trace_rays_init(&rays);
    while (k < t->count) {
        int lane = 0;
        memset(valid, 0, sizeof(valid));
        while (lane < TRACE_WIDTH && k < t->count) {
            size_t left = frame->samples - sample;
            int last = left < (size_t)(TRACE_WIDTH - lane) ? lane + (int)left : TRACE_WIDTH;
            set_origin(&t->receivers[k], lane, last, &rays);
            aim(frame, &t->receivers[k], lane, last, sample, &rays, valid);
            for (int i = lane; i < last; i++)
                owner[i] = k;
            sample += (size_t)(last - lane);
            lane = last;
            if (sample == frame->samples) {
                sample = 0;
                k++;
            }
        }
        trace_occluded(frame->reference->trace, valid, false, &rays);
        for (int i = 0; i < lane; i++) {
            t->receivers[owner[i]].seen += (uint32_t)(valid[i] & (rays.tfar[i] > 0));
            traced += (uint32_t)-valid[i];
        }
    }
    return traced;
}

static void trace_body(void *user, size_t begin, size_t end, int worker)
{
    const struct reference_frame *frame = user;
    uint64_t traced = 0;
    struct trace_rays rays[BATCH];
    for (int b = 0; b < BATCH; b++)
        trace_rays_init(&rays[b]);
    for (size_t tile = begin; tile < end; tile++) {
        struct reference_tile t;
        reference_tile_begin(frame, tile, &t);
        if (frame->samples % TRACE_WIDTH == 0)
            traced += trace_whole(frame, &t, rays);
        else
            traced += trace_mixed(frame, &t);
        for (int k = 0; k < t.count; k++)
            frame->visibility[t.receivers[k].index] =
                (float)t.receivers[k].seen / (float)frame->samples;
    }
    frame->rays[worker].count += traced;
}

/* Something in the middle of the light, and the share of its area that a packet aims at. */
static void describe_bundle(struct reference_frame *frame)
{
    const struct light_shape *shape = frame->shape;
    struct light_point middle = light_shape_sample(shape, 0.5, 0.5);
    double share = fmin(1, (double)TRACE_WIDTH / frame->samples);
    frame->middle = middle.p;
    frame->packet_area = shape->area * share;
    if (shape->light.type == PNB_LIGHT_LINE)
        frame->packet_area *= shape->area * share;
    else if (shape->light.type == PNB_LIGHT_POINT)
        frame->packet_area = 0;
}

pnb_status reference_frame_init(pnb_solver *solver, const pnb_light *light,
                                const pnb_receivers *receivers, float *visibility,
                                struct light_shape *shape, struct reference_frame *frame)
{
    struct reference *r = solver->state;
    pnb_context *context = solver->context;
    pnb_status status = light_shape_init(context, light, shape);
    if (status != PNB_OK)
        return status;
    bool sun = light->type == PNB_LIGHT_SUN;
    *frame = (struct reference_frame){
        .reference = r,
        .shape = shape,
        .receivers = receivers,
        .visibility = visibility,
        .samples = light->type == PNB_LIGHT_POINT ? 1 : r->samples,
        .lift = scene_receiver_lift(solver->scene),
        .sun = sun,
        .tfar = sun ? INFINITY : (float)(1 - TOLERANCE_LIGHT_GAP),
    };
    solver->report.samples = (int)frame->samples;
    describe_bundle(frame);
    frame->tiles = (receivers->count + REFERENCE_TILE - 1) / REFERENCE_TILE;
    if (receivers->width > 0) {
        frame->tiles_x = (size_t)(receivers->width + TILE - 1) / TILE;
        frame->tiles = frame->tiles_x * (size_t)((receivers->height + TILE - 1) / TILE);
    }
    size_t workers = (size_t)pnb_context_threads(context);
    frame->rays = memory_calloc(context, workers, sizeof(*frame->rays));
    if (!frame->rays)
        status = status_no_memory(context, workers * sizeof(*frame->rays));
    if (status == PNB_OK)
        status = fill_tables(solver, light->type == PNB_LIGHT_LINE);
    if (status == PNB_OK)
        parallel_for(context, r->blocks * REFERENCE_TILE, 1, target_body, frame);
    else
        reference_frame_finish(solver, frame);
    return status;
}

void reference_frame_finish(pnb_solver *solver, struct reference_frame *frame)
{
    memory_free(solver->context, frame->rays);
    light_shape_finish(solver->context, (struct light_shape *)frame->shape);
}

static pnb_status reference_visibility(pnb_solver *solver, const pnb_light *light,
                                       const pnb_receivers *receivers, float *visibility)
{
    struct light_shape shape;
    struct reference_frame frame;
    pnb_status status = reference_frame_init(solver, light, receivers, visibility, &shape, &frame);
    if (status != PNB_OK)
        return status;
    status = parallel_for_progress(solver->context, "visibility", 0, 1, frame.tiles, 16, trace_body,
                                   &frame);
    uint64_t rays = 0;
    for (int i = 0; i < pnb_context_threads(solver->context); i++)
        rays += frame.rays[i].count;
    solver_count(solver, "rays", (double)rays);
    reference_frame_finish(solver, &frame);
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
