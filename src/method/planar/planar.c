/* method/planar/planar.c: the method `planar`: geometric area shadows on planes (Boehl and
 * Stuerzlinger 2006), looked up at the receivers.
 *
 *   create: receiver planes, occluders in their frames, edges
 *   visibility: a mesh per plane and convex piece of the light (build.c, or refine.c when a
 * tolerance is asked for), then 1 - interpolated shadow at each receiver (locate.c)
 *
 * Receivers that are not on such a plane get NaN. All CPU; the meshes are built on one thread, the
 * look-ups run on all.
 */
#include <string.h>

#include "method/planar/room.h"

struct lookup {
    pnb_context *context;
    const struct shadow_plane *plane;
    const struct shadow_locator *locator;
    const pnb_receivers *receivers;
    double near; /* how far from the plane a receiver may be */
    double weight;
    bool first;
    float *visibility;
    double milliseconds;
};

static const char *const placements[] = {"optimised", "border", "random"};
static const char *const mends[] = {"even", "triangles", "no"};
static const char *const fills[] = {"sweep", "nearest", "delaunay"};

static int word(const char *text, const char *const *words, int count)
{
    for (int i = 0; i < count; i++)
        if (strcmp(text, words[i]) == 0)
            return i;
    return 0;
}

void shadow_settings_read(const pnb_solver *solver, struct shadow_settings *s)
{
    *s = (struct shadow_settings){
        .samples = solver->samples,
        .placement = (enum shadow_placement)word(solver_param(solver, "placement"), placements, 3),
        .intensity =
            strcmp(solver_param(solver, "intensity"), "exact") == 0 ? SHADOW_EXACT : SHADOW_RING,
        .fill = (enum planar_rule)word(solver_param(solver, "fill"), fills, 3),
        .mend = (enum shadow_mend)word(solver_param(solver, "mend"), mends, 3),
        .join = solver_param_number(solver, "join"),
        .reconnect = solver_param_number(solver, "reconnect"),
        .tolerance = solver_param_number(solver, "tolerance"),
        .keep = strcmp(solver_param(solver, "keep"), "yes") == 0,
        .simplify = solver_param_number(solver, "simplify"),
    };
}

static void forget_planes(pnb_solver *solver)
{
    struct planar_state *state = solver->state;
    for (size_t i = 0; i < state->plane_count; i++)
        shadow_plane_finish(solver->context, &state->planes[i]);
    memory_free(solver->context, state->planes);
    state->planes = NULL;
    state->plane_count = 0;
}

/* The planes, lit from the side of `towards`. */
static pnb_status make_planes(pnb_solver *solver, vec3 towards)
{
    struct planar_state *state = solver->state;
    pnb_context *context = solver->context;
    pnb_scene *scene = solver->scene;
    const char *name = solver_param(solver, "receiver");
    bool all = strcmp(name, "all") == 0;
    forget_planes(solver);
    state->planes = memory_calloc(context, scene->object_count + 1, sizeof(*state->planes));
    if (!state->planes)
        return status_no_memory(context, scene->object_count * sizeof(*state->planes));
    size_t object = 0;
    pnb_status status = shadow_coarse_update(context, scene, &state->settings, &state->coarse);
    if (status)
        return status;
    if (!all || !shadow_next_receiver(scene, towards, &object)) {
        status = shadow_find_receiver(context, scene, all ? "" : name, towards, &object);
        all = false;
    }
    while (!status) {
        status = shadow_plane_init(context, scene, state->coarse.meshes, object, towards,
                                   &state->planes[state->plane_count]);
        if (status)
            break;
        struct shadow_plane *plane = &state->planes[state->plane_count++];
        if (plane->open_meshes > 0)
            solver_warn(
                solver,
                "occluders are not closed (%zu open and %zu non-manifold edges): both sides "
                "of every triangle cast",
                plane->open_edges, plane->non_manifold_edges);
        object++;
        if (!all || !shadow_next_receiver(scene, towards, &object))
            break;
    }
    return status;
}

static pnb_status planar_create(pnb_solver *solver)
{
    struct planar_state *state = memory_calloc(solver->context, 1, sizeof(*state));
    if (!state)
        return status_no_memory(solver->context, sizeof(*state));
    solver->state = state;
    shadow_settings_read(solver, &state->settings);
    if (state->settings.samples > SHADOW_SAMPLES_MAX)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "samples",
                           "planar takes at most %d", SHADOW_SAMPLES_MAX);
    pnb_status status = shadow_builder_init(solver->context, solver->scene, &state->builder);
    if (status)
        return status;
    if (state->settings.samples > SHADOW_SAMPLES_MANY && state->settings.tolerance == 0)
        solver_warn(solver,
                    "%d samples are as many rings, whose crossings grow with the square of their "
                    "number; -p tolerance=0.004 is more exact and much faster",
                    state->settings.samples);
    /* The promise can be no better than what it is measured by. */
    if (state->settings.tolerance > 0 && state->settings.tolerance < SHADOW_FINE)
        state->builder.truth_samples = 4096;
    vec3 towards = v3(0, 1e9, 0);
    if (solver->scene->light_count > 0) {
        struct light_shape shape;
        if (!light_shape_init(solver->context, &solver->scene->lights[0], &shape)) {
            towards = shadow_light_middle(&shape, v3(0, 0, 0), 1e9);
            light_shape_finish(solver->context, &shape);
        }
    }
    return make_planes(solver, towards);
}

static void planar_destroy(pnb_solver *solver)
{
    struct planar_state *state = solver->state;
    if (!state)
        return;
    forget_planes(solver);
    shadow_part_finish(solver->context, &state->part);
    shadow_coarse_finish(solver->context, &state->coarse);
    shadow_builder_finish(&state->builder);
    memory_free(solver->context, state);
}

static pnb_status planar_update(pnb_solver *solver, pnb_update update)
{
    struct planar_state *state = solver->state;
    pnb_status status = shadow_builder_update(&state->builder, update);
    if (!status && state->plane_count > 0)
        status =
            make_planes(solver, v3_mad(state->planes[0].frame.origin, state->planes[0].frame.n, 1));
    return status;
}

static void lookup_body(void *user, size_t begin, size_t end, int worker)
{
    const struct lookup *job = user;
    const pnb_receivers *r = job->receivers;
    const struct shadow_plane *plane = job->plane;
    uint32_t hint = PLANAR_NONE;
    for (size_t i = begin; i < end; i++) {
        vec3 p = v3_loadf(r->positions + 3 * i), n = v3_loadf(r->normals + 3 * i);
        if (!v3_finite(p) || !v3_finite(n))
            continue;
        double facing = v3_dot(n, plane->frame.n);
        vec3 q = silhouette_to_plane(&plane->frame, p);
        if (fabs(q.z) > job->near || fabs(facing) < 0.999)
            continue;
        if (r->objects ? r->objects[i] != plane->object
                       : q.x < plane->lo[0] || q.x > plane->hi[0] || q.y < plane->lo[1] ||
                             q.y > plane->hi[1])
            continue;
        /* The other side of the plane sees nothing of the light. */
        double shadow = facing > 0 ? shadow_at(job->locator, q.x, q.y, &hint) : 1;
        float seen = (float)(job->weight * (1 - fmin(1, fmax(0, shadow))));
        job->visibility[i] = job->first ? seen : job->visibility[i] + seen;
    }
}

static pnb_status look_up(void *user, const struct shadow_plane *plane, struct shadow_part *part,
                          bool first)
{
    struct lookup *job = user;
    struct shadow_locator locator;
    double started = clock_ms();
    pnb_status status = shadow_locator_init(job->context, part, &locator);
    if (status)
        return status;
    job->plane = plane;
    job->locator = &locator;
    job->weight = part->weight;
    job->first = first;
    parallel_for(job->context, job->receivers->count, 4096, lookup_body, job);
    shadow_locator_finish(job->context, &locator);
    job->milliseconds += clock_ms() - started;
    return PNB_OK;
}

pnb_status shadow_visit(pnb_solver *solver, const pnb_light *light, shadow_visitor *visit,
                        void *user)
{
    struct planar_state *state = solver->state;
    pnb_context *context = solver->context;
    struct light_shape shape;
    struct shadow_cluster *clusters = NULL;
    size_t cluster_count = 0, triangles = 0;
    pnb_status status = light_shape_init(context, light, &shape);
    if (status)
        return status;
    status = shadow_clusters(context, &shape, &clusters, &cluster_count);
    memset(&state->builder.times, 0, sizeof(state->builder.times));
    for (size_t i = 0; i < state->plane_count && !status; i++) {
        struct shadow_plane *plane = &state->planes[i];
        vec3 towards = shadow_light_middle(&shape, plane->frame.origin, 1e6);
        if (v3_dot(v3_sub(towards, plane->frame.origin), plane->frame.n) < 0) {
            size_t object = plane->object;
            shadow_plane_finish(context, plane);
            status = shadow_plane_init(context, solver->scene, state->coarse.meshes, object,
                                       towards, plane);
        }
        /* A point's shadow has no penumbra to be refined: its outline is the truth. */
        bool refine = state->settings.tolerance > 0 && shape.light.type != PNB_LIGHT_POINT;
        for (size_t c = 0; c < (refine ? 1 : cluster_count) && !status; c++) {
            status = refine ? shadow_refine(&state->builder, plane, light, &state->settings,
                                            &state->part)
                            : shadow_build(&state->builder, plane, &shape, &clusters[c],
                                           &state->settings, &state->part);
            triangles += state->part.triangle_count;
            if (!status)
                status = visit(user, plane, &state->part, c == 0);
        }
    }
    const struct shadow_times *t = &state->builder.times;
    if (t->unfinished)
        solver_warn(solver,
                    "the tolerance is not kept everywhere: the mesh has reached its limit of "
                    "triangles; ask for a larger one");
    solver_count(solver, "triangles", (double)triangles);
    if (state->coarse.meshes)
        solver_count(solver, "occluder_triangles", (double)state->coarse.triangles_after);
    solver_count(solver, "silhouette_edges", (double)t->silhouette_edges);
    solver_count(solver, "crossings", (double)t->crossings);
    solver_count(solver, "careful_sweeps", (double)t->careful);
    solver_count(solver, "evaluations", (double)t->evaluations);
    solver_count(solver, "silhouettes_ms", t->silhouettes_ms);
    solver_count(solver, "outlines_ms", t->outlines_ms);
    solver_count(solver, "rings_ms", t->rings_ms);
    solver_count(solver, "fill_ms", t->fill_ms);
    solver_count(solver, "values_ms", t->values_ms);
    memory_free(context, clusters);
    light_shape_finish(context, &shape);
    return status;
}

static pnb_status planar_visibility(pnb_solver *solver, const pnb_light *light,
                                    const pnb_receivers *receivers, float *visibility)
{
    for (size_t i = 0; i < receivers->count; i++)
        visibility[i] = NAN;
    struct lookup job = {.context = solver->context,
                         .receivers = receivers,
                         .near = 8 * scene_receiver_lift(solver->scene),
                         .visibility = visibility};
    pnb_status status = shadow_visit(solver, light, look_up, &job);
    solver_count(solver, "look_up_ms", job.milliseconds);
    return status;
}

static const pnb_param_info params[] = {
    {.key = "receiver",
     .type = PNB_PARAM_TEXT,
     .default_value = "",
     .summary =
         "object whose plane receives, or 'all' planes and slabs; default: the largest plane"},
    {.key = "placement",
     .type = PNB_PARAM_CHOICE,
     .default_value = "optimised",
     .choices = "optimised|border|random",
     .summary = "where on the light the samples lie; 'border' is the paper's advice"},
    {.key = "intensity",
     .type = PNB_PARAM_CHOICE,
     .default_value = "ring",
     .choices = "ring|exact",
     .summary =
         "values by the number of the ring (the paper), or exact visibility at the vertices"},
    {.key = "fill",
     .type = PNB_PARAM_CHOICE,
     .default_value = "nearest",
     .choices = "nearest|delaunay|sweep",
     .summary =
         "triangles between rings: the paper's nearest point, constrained Delaunay, as swept"},
    {.key = "mend",
     .type = PNB_PARAM_CHOICE,
     .default_value = "even",
     .choices = "even|triangles|no",
     .summary =
         "leaks at crossings on the innermost and outermost ring: an even umbra, the paper's "
         "triangles, or left"},
    {.key = "join",
     .type = PNB_PARAM_NUMBER,
     .default_value = "0",
     .minimum = 0,
     .maximum = 1e6,
     .summary = "metres: lines nearer than this become one"},
    {.key = "reconnect",
     .type = PNB_PARAM_NUMBER,
     .default_value = "0",
     .minimum = 0,
     .maximum = 1,
     .summary =
         "iso-density lines: share of the edges at a crossing of rings that gives way; 0: the "
         "crossing stays, with the mean of its rings"},
    {.key = "tolerance",
     .type = PNB_PARAM_NUMBER,
     .default_value = "0",
     .minimum = 0,
     .maximum = 1,
     .summary = "refine the mesh until it is this near the exact shadow; 0: rings"},
    {.key = "keep",
     .type = PNB_PARAM_CHOICE,
     .default_value = "no",
     .choices = "no|yes",
     .summary = "with a tolerance: go on from the last frame's mesh instead of a new one; steadier "
                "under a light that moves little"},
    {.key = "simplify",
     .type = PNB_PARAM_NUMBER,
     .default_value = "0",
     .minimum = 0,
     .maximum = 1e6,
     .summary = "metres: rings of occluders simplified until they are about this far off; 0: as "
                "they are"},
};

const struct method method_planar = {
    .info =
        {
            .name = "planar",
            .title = "planar shadow geometry",
            .paper = "Boehl, Stuerzlinger: Real-Time Computation of Area Shadows - A Geometrical "
                     "Algorithm, 2006",
            .summary =
                "Silhouettes seen from light samples, projected onto a plane and merged by "
                "winding number into rings; the strips between them are triangles with linear "
                "intensity. Also as a mesh: penumbra shadow.",
            .lights = PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) | PNB_LIGHT_BIT(PNB_LIGHT_LINE) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POINT) | PNB_LIGHT_BIT(PNB_LIGHT_SUN),
            .receivers = PNB_RECEIVERS_PLANES,
            .processor = PNB_PROCESSOR_CPU,
            .samples = true,
            .default_samples = 16,
            .params = params,
            .param_count = sizeof(params) / sizeof(params[0]),
        },
    .create = planar_create,
    .destroy = planar_destroy,
    .update = planar_update,
    .visibility = planar_visibility,
};
