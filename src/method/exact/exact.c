/* method/exact/exact.c: visibility of area lights without noise: the record, and a frame's work.
 *
 * create: clusters per mesh (exact_scene.c). visibility: the light becomes a grid of samples
 * (exact_light.c); receivers are grouped to tiles of up to 256 neighbours, 16x16 pixels of an image
 * or runs along a Morton curve; each tile is solved by itself (exact_bounds.inc, exact_tile.inc).
 * Nothing is kept between frames. Results depend on the tile's receivers alone, never on threads.
 */
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "method/exact/exact.h"

#define TILE_SIDE 16

struct exact {
    struct exact_scene *scene;
    const struct exact_kernel *kernel;
    const char *area; /* the parameter exact-area */
    bool triangles_only, levels;
    struct exact_work *works;
    int work_count;
};

static void finish_works(pnb_solver *solver)
{
    struct exact *exact = solver->state;
    for (int i = 0; i < exact->work_count; i++)
        exact_work_finish(&exact->works[i]);
    memory_free(solver->context, exact->works);
    exact->works = NULL;
    exact->work_count = 0;
}

static pnb_status init_works(pnb_solver *solver)
{
    struct exact *exact = solver->state;
    finish_works(solver);
    int count = pnb_context_threads(solver->context);
    exact->works = memory_calloc(solver->context, (size_t)count, sizeof(*exact->works));
    if (!exact->works)
        return status_no_memory(solver->context, (size_t)count * sizeof(*exact->works));
    for (exact->work_count = 0; exact->work_count < count;)
        if (!exact_work_init(solver->context, exact->scene, &exact->works[exact->work_count++]))
            return status_no_memory(solver->context, exact->scene->slots_max);
    return PNB_OK;
}

static pnb_status exact_create(pnb_solver *solver)
{
    struct exact *exact = memory_calloc(solver->context, 1, sizeof(*exact));
    if (!exact)
        return status_no_memory(solver->context, sizeof(*exact));
    solver->state = exact;
    const char *cpu = getenv("PNB_CPU");
    exact->kernel = exact_kernel_choose(cpu);
    if (!exact->kernel)
        return status_fail(solver->context, PNB_ERROR_DEVICE, "PNB_CPU",
                           "'%s' is none of c, avx2, avx512 or lacks on this processor", cpu);
    exact->area = solver_param(solver, "exact-area");
    exact->triangles_only = strcmp(solver_param(solver, "path"), "triangles") == 0;
    exact->levels = strcmp(solver_param(solver, "levels"), "auto") == 0 && !exact->triangles_only;
    pnb_status status = exact_scene_create(solver->scene, exact->levels, &exact->scene);
    if (status == PNB_OK)
        status = init_works(solver);
    return status;
}

static void exact_destroy(pnb_solver *solver)
{
    struct exact *exact = solver->state;
    if (!exact)
        return;
    finish_works(solver);
    exact_scene_destroy(solver->context, exact->scene);
    memory_free(solver->context, exact);
}

static pnb_status exact_update(pnb_solver *solver, pnb_update update)
{
    struct exact *exact = solver->state;
    const pnb_scene *scene = solver->scene;
    if (scene->object_count != exact->scene->object_count ||
        scene->mesh_count != exact->scene->mesh_count)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "update",
                           "objects or meshes were added; make a new solver");
    size_t slots = exact->scene->slots_max, clusters = exact->scene->clusters_max;
    size_t vertices = exact->scene->vertices_max, instances = exact->scene->instance_capacity;
    pnb_status status = exact_scene_update(solver->scene, exact->scene, update);
    if (status == PNB_OK &&
        (exact->scene->slots_max > slots || exact->scene->clusters_max > clusters ||
         exact->scene->vertices_max > vertices || exact->scene->instance_capacity > instances))
        status = init_works(solver);
    return status;
}

struct frame_job {
    struct exact_job job;
    struct exact_work *works;
    const pnb_receivers *receivers;
    const uint32_t *order; /* of receivers that are no image, along a curve */
    size_t tiles_x;
    size_t within[EXACT_TILE]; /* of an image's tile: where its receivers are, from the first */
};

static struct exact_point lifted_point(const struct frame_job *frame, size_t index)
{
    vec3 p = v3_loadf(frame->receivers->positions + 3 * index);
    vec3 n = v3_loadf(frame->receivers->normals + 3 * index);
    return (struct exact_point){index, v3_mad(p, n, frame->job.lift), n};
}

static void add_point(const struct frame_job *frame, struct exact_work *work, size_t index,
                      struct exact_point *points, size_t *count)
{
    vec3 p = v3_loadf(frame->receivers->positions + 3 * index);
    struct exact_point point = lifted_point(frame, index);
    if (!v3_finite(p) || !v3_finite(point.n)) {
        frame->job.visibility[index] = NAN;
        return;
    }
    const struct exact_light *light = frame->job.light;
    if (light->one_sided && !(v3_dot(light->normal, v3_sub(p, light->center)) > 0)) {
        frame->job.visibility[index] = 0;
        work->stats.umbra++;
    } else if (light->one_sided && !(v3_dot(light->normal, v3_sub(point.p, light->center)) > 0)) {
        /* Only the lift takes it behind the light: the receiver itself counts. A tile of its own,
         * since that of its neighbours has to lie before the light. */
        frame->job.kernel->tile(&frame->job, work, &point, 1);
    } else {
        points[(*count)++] = point;
    }
}

static const uint8_t morton_x[16] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
static const uint8_t morton_y[16] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};

/* A tile of an image is in the order of the Morton curve: runs of 4, 8, 16, 64 are blocks. */
static inline size_t tile_x(unsigned i)
{
    return morton_x[i & 15] + 4u * morton_x[i >> 4];
}
static inline size_t tile_y(unsigned i)
{
    return morton_y[i & 15] + 4u * morton_y[i >> 4];
}

/* All look the same way, as on a plane. */
static bool points_flat(const struct exact_point *points, size_t count)
{
    vec3 up = points[0].n;
    for (size_t i = 1; i < count; i++)
        if (!(fabs(points[i].n.x - up.x) < 1e-6 && fabs(points[i].n.y - up.y) < 1e-6 &&
              fabs(points[i].n.z - up.z) < 1e-6))
            return false;
    return v3_dot(up, up) > 0;
}

/* The bounds of the points as they are in the receivers. */
static void bound_points(const pnb_receivers *receivers, const struct exact_point *points,
                         size_t count, struct exact_box *box)
{
    for (int k = 0; k < 3; k++) {
        box->low[k] = box->normal_low[k] = INFINITY;
        box->high[k] = box->normal_high[k] = -INFINITY;
    }
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            float p = receivers->positions[3 * points[i].index + (size_t)k];
            float n = receivers->normals[3 * points[i].index + (size_t)k];
            box->low[k] = p < box->low[k] ? p : box->low[k];
            box->high[k] = p > box->high[k] ? p : box->high[k];
            box->normal_low[k] = n < box->normal_low[k] ? n : box->normal_low[k];
            box->normal_high[k] = n > box->normal_high[k] ? n : box->normal_high[k];
        }
}

/* A whole tile of an image of which all receivers see all of the light. known: its occluders are
 * noted, or they may be any. */
static bool tile_lit(const struct frame_job *frame, struct exact_work *work, size_t first,
                     bool *known)
{
    const pnb_receivers *receivers = frame->receivers;
    size_t width = (size_t)receivers->width;
    struct exact_box box;
    *known = frame->job.kernel->bound(receivers->positions + 3 * first,
                                      receivers->normals + 3 * first, 3 * width, &box);
    if (!*known || !frame->job.kernel->survey(&frame->job, work, &box))
        return false;
    for (size_t y = 0; y < TILE_SIDE; y++)
        for (size_t x = 0; x < TILE_SIDE; x++)
            frame->job.visibility[first + y * width + x] = 1;
    work->stats.lit += TILE_SIDE * TILE_SIDE;
    work->stats.tiles++;
    return true;
}

static void solve_points(const struct frame_job *frame, struct exact_work *work,
                         struct exact_point *points, size_t count, const size_t *quarter,
                         bool known)
{
    const struct exact_kernel *kernel = frame->job.kernel;
    if (!known) {
        struct exact_box box;
        bound_points(frame->receivers, points, count, &box);
        if (kernel->survey(&frame->job, work, &box)) {
            for (size_t i = 0; i < count; i++)
                frame->job.visibility[points[i].index] = 1;
            work->stats.lit += count;
            work->stats.tiles++;
            return;
        }
    }
    if (points_flat(points, count)) {
        kernel->tile(&frame->job, work, points, count);
        return;
    }
    /* Curved ones are close to their own surface's triangles: fewer at a time. */
    for (int i = 0; i < 4; i++)
        if (quarter[i + 1] > quarter[i])
            kernel->tile(&frame->job, work, points + quarter[i], quarter[i + 1] - quarter[i]);
}

static void tile_body(void *user, size_t begin, size_t end, int worker)
{
    const struct frame_job *frame = user;
    struct exact_work *work = &frame->works[worker];
    const pnb_receivers *receivers = frame->receivers;
    size_t width = (size_t)receivers->width, height = (size_t)receivers->height;
    for (size_t tile = begin; tile < end; tile++) {
        struct exact_point points[EXACT_TILE];
        size_t count = 0, quarter[5] = {0}, x0 = 0, y0 = 0;
        bool known = false;
        work->surveyed = false;
        if (!frame->order) {
            x0 = tile % frame->tiles_x * TILE_SIDE, y0 = tile / frame->tiles_x * TILE_SIDE;
            if (x0 + TILE_SIDE <= width && y0 + TILE_SIDE <= height &&
                tile_lit(frame, work, y0 * width + x0, &known))
                continue;
        }
        if (work->surveyed) {
            /* All are numbers on the light's lit side. */
            for (unsigned i = 0; i < EXACT_TILE; i++)
                points[i] = lifted_point(frame, y0 * width + x0 + frame->within[i]);
            for (size_t i = 0; i < 5; i++)
                quarter[i] = i * (EXACT_TILE / 4);
            solve_points(frame, work, points, EXACT_TILE, quarter, known);
            continue;
        }
        for (unsigned i = 0; i < EXACT_TILE; i++) {
            if (frame->order) {
                if (tile * EXACT_TILE + i < receivers->count)
                    add_point(frame, work, frame->order[tile * EXACT_TILE + i], points, &count);
            } else {
                size_t x = x0 + tile_x(i), y = y0 + tile_y(i);
                if (x < width && y < height)
                    add_point(frame, work, y * width + x, points, &count);
            }
            if (i % (EXACT_TILE / 4) == EXACT_TILE / 4 - 1)
                quarter[i / (EXACT_TILE / 4) + 1] = count;
        }
        if (count > 0)
            solve_points(frame, work, points, count, quarter, known);
    }
}

/* A light that is a point, receiver by receiver. */
static void point_body(void *user, size_t begin, size_t end, int worker)
{
    const struct frame_job *frame = user;
    struct exact_stats *stats = &frame->works[worker].stats;
    vec3 light = frame->job.light->center;
    for (size_t i = begin; i < end; i++) {
        struct exact_point point = lifted_point(frame, i);
        float *visibility = &frame->job.visibility[i];
        if (!v3_finite(point.p) || !v3_finite(point.n)) {
            *visibility = NAN;
            continue;
        }
        vec3 e = v3_sub(light, point.p);
        bool below = v3_dot(point.n, point.n) > 0 && v3_dot(point.n, e) + frame->job.lift <= 0;
        *visibility = !below && exact_point_seen(frame->job.scene, point.p, light);
        stats->lit += *visibility > 0;
        stats->umbra += *visibility == 0;
    }
}

struct place {
    uint64_t key;
    uint32_t index;
};

static uint64_t spread(uint64_t x) /* 21 bits, two zeros after each */
{
    x &= 0x1fffff;
    x = (x | x << 32) & 0x1f00000000ffffull;
    x = (x | x << 16) & 0x1f0000ff0000ffull;
    x = (x | x << 8) & 0x100f00f00f00f00full;
    x = (x | x << 4) & 0x10c30c30c30c30c3ull;
    return (x | x << 2) & 0x1249249249249249ull;
}

static int compare_places(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->index > y->index) - (x->index < y->index);
}

/* Points of no order: along the Morton curve of their bounds; those that are no number come last.
 */
static pnb_status order_points(pnb_context *context, const pnb_receivers *receivers,
                               uint32_t **out_order)
{
    size_t count = receivers->count;
    uint32_t *order = memory_alloc(context, count, sizeof(*order));
    struct place *places = memory_alloc(context, count, sizeof(*places));
    if (!order || !places || count > UINT32_MAX) {
        memory_free(context, order);
        memory_free(context, places);
        return status_no_memory(context, count * sizeof(*places));
    }
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3(-INFINITY, -INFINITY, -INFINITY);
    for (size_t i = 0; i < count; i++) {
        vec3 p = v3_loadf(receivers->positions + 3 * i);
        if (v3_finite(p))
            low = v3_min(low, p), high = v3_max(high, p);
    }
    double size = v3_max_abs(v3_sub(high, low));
    double scale = size > 0 && isfinite(size) ? 2097151 / size : 0;
    for (size_t i = 0; i < count; i++) {
        vec3 p = v3_loadf(receivers->positions + 3 * i);
        places[i].index = (uint32_t)i;
        places[i].key = UINT64_MAX;
        if (v3_finite(p)) {
            vec3 q = v3_scale(v3_sub(p, low), scale);
            places[i].key =
                spread((uint64_t)q.x) | spread((uint64_t)q.y) << 1 | spread((uint64_t)q.z) << 2;
        }
    }
    qsort(places, count, sizeof(*places), compare_places);
    for (size_t i = 0; i < count; i++)
        order[i] = places[i].index;
    memory_free(context, places);
    *out_order = order;
    return PNB_OK;
}

/* How far the picture of an outline may be off, in samples along a row, by the measure of
 * exact_levels.inc. Measured: 0.3 adds 5 % to the error of the knots, 12 % to that of 729 spheres,
 * 0.2 a half and 5 %.
 */
#define DETAIL      0.2
#define DETAIL_AREA 0.0125 /* where lengths are measured instead */

static double exact_detail(const pnb_light *light, bool area)
{
    if (light->type == PNB_LIGHT_POINT)
        return 0;
    return area ? DETAIL_AREA : DETAIL;
}

static pnb_status exact_visibility(pnb_solver *solver, const pnb_light *light,
                                   const pnb_receivers *receivers, float *visibility)
{
    struct exact *exact = solver->state;
    pnb_context *context = solver->context;
    struct exact_light shape;
    bool area = strcmp(exact->area, "on") == 0 ||
                (strcmp(exact->area, "auto") == 0 && light->type == PNB_LIGHT_LINE);
    pnb_status status = exact_light_init(context, light, solver->samples, area, &shape);
    if (status != PNB_OK)
        return status;
    solver->report.samples = shape.samples;
    uint32_t *order = NULL;
    struct frame_job frame = {
        .job = {.scene = exact->scene,
                .light = &shape,
                .kernel = exact->kernel,
                .lift = scene_receiver_lift(solver->scene),
                .area = area,
                .closed = shape.closed && strcmp(exact->area, "off") != 0,
                .triangles_only = exact->triangles_only,
                .detail = exact->levels ? exact_detail(light, area) : 0,
                .visibility = visibility},
        .works = exact->works,
        .receivers = receivers,
    };
    for (int i = 0; i < exact->work_count; i++)
        if (!exact_work_prepare(&exact->works[i], &shape.grid)) {
            status = status_no_memory(context, exact_cover_size(&shape.grid) * 4);
            goto done;
        }
    parallel_body *body = tile_body;
    size_t tiles, grain = 4;
    if (light->type == PNB_LIGHT_POINT && !exact->triangles_only) {
        body = point_body;
        tiles = receivers->count, grain = 1024;
    } else if (receivers->width > 0 && receivers->height > 0) {
        frame.tiles_x = ((size_t)receivers->width + TILE_SIDE - 1) / TILE_SIDE;
        for (unsigned i = 0; i < EXACT_TILE; i++)
            frame.within[i] = tile_y(i) * (size_t)receivers->width + tile_x(i);
        tiles = frame.tiles_x * (((size_t)receivers->height + TILE_SIDE - 1) / TILE_SIDE);
    } else {
        status = order_points(context, receivers, &order);
        if (status != PNB_OK)
            goto done;
        frame.order = order;
        tiles = (receivers->count + EXACT_TILE - 1) / EXACT_TILE;
    }
    status = parallel_for_progress(context, "visibility", 0, 1, tiles, grain, body, &frame);

    struct exact_stats sum = {0};
    for (int i = 0; i < exact->work_count; i++) {
        const struct exact_stats *s = &exact->works[i].stats;
        sum.lit += s->lit, sum.umbra += s->umbra;
        sum.sampled += s->sampled, sum.closed += s->closed;
        sum.slabs += s->slabs, sum.levels += s->levels;
        sum.edges += s->edges, sum.triangles += s->triangles, sum.tiles += s->tiles;
        if (exact->works[i].no_memory && status == PNB_OK)
            status = status_no_memory(context, exact->works[i].edges.open_capacity);
    }
    solver_count(solver, "lit", (double)sum.lit);
    solver_count(solver, "umbra", (double)sum.umbra);
    solver_count(solver, "closed_form", (double)sum.closed);
    solver_count(solver, "sampled", (double)sum.sampled);
    solver_count(solver, "tiles", (double)sum.tiles);
    solver_count(solver, "edges_per_tile", sum.tiles ? (double)sum.edges / (double)sum.tiles : 0);
    solver_count(solver, "loose_per_tile",
                 sum.tiles ? (double)sum.triangles / (double)sum.tiles : 0);
    solver_count(solver, "mean_level", sum.slabs ? (double)sum.levels / (double)sum.slabs : 0);
    solver_count(solver, "bytes_per_triangle",
                 exact->scene->triangle_count
                     ? (double)exact->scene->bytes / (double)exact->scene->triangle_count
                     : 0);
done:
    memory_free(context, order);
    exact_light_finish(context, &shape);
    return status;
}

static const pnb_param_info params[] = {
    {.key = "exact-area",
     .type = PNB_PARAM_CHOICE,
     .default_value = "auto",
     .choices = "auto|on|off",
     .summary = "measure lengths along the rows of samples instead of counting samples: half the "
                "error at two times the cost; auto: for lines, and areas in closed form where "
                "convex occluders look apart"},
    {.key = "levels",
     .type = PNB_PARAM_CHOICE,
     .default_value = "auto",
     .choices = "auto|off",
     .summary = "auto: take dense meshes from coarser ones where the samples cannot tell; off: "
                "always every triangle"},
    {.key = "path",
     .type = PNB_PARAM_CHOICE,
     .default_value = "silhouette",
     .choices = "silhouette|triangles",
     .summary = "triangles: cover the light triangle by triangle, slow and in double precision"},
};

const struct method method_exact = {
    .info =
        {
            .name = "exact",
            .title = "noise-free area shadows",
            .paper = "",
            .summary = "Winds the silhouettes seen from each receiver around fixed positions on "
                       "the light. No noise, any triangles, no acceleration by rays.",
            .lights = (1u << PNB_LIGHT_TYPE_COUNT) - 1,
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_CPU,
            .samples = true,
            .default_samples = 1024,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = exact_create,
    .destroy = exact_destroy,
    .update = exact_update,
    .visibility = exact_visibility,
};
