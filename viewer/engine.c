/* viewer/engine.c: one scene, its solvers and its surfaces, and the steps from a state to a frame.
 *
 * state -> placements and lights into the scene -> surface (kept while the camera, the objects and
 * the size stay) -> visibility of every light on every side -> bytes. Nothing about lights is kept
 * from frame to frame; at rest a side that is finished is not solved again when only the way of
 * showing it changes.
 *
 * Sides that the window draws by itself (state.window, a method on OpenGL) are left out here; the
 * window tells what they took (view_engine_drawn), from which their number of pixels follows. At
 * rest that goes up by steps, so that the window's thread is never held for longer than
 * VIEW_BLOCK_MS; where that cannot be, the worker does the method in a context without a window.
 */
#include "engine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "pacing.h"
#include "shade.h"

#define ROUGH_FIRST_MS 150.0 /* at rest: a rough frame first if the whole one may take longer */
#define TRUTH_FIRST    64
#define NAN_FLOAT      ((float)NAN)

enum step { STEP_NONE, STEP_MOVING, STEP_ROUGH, STEP_FULL, STEP_SHOW, STEP_TRUTH };

struct surface {
    pnb_surface *surface;
    pnb_camera camera;
    int width, height;
    uint64_t geometry;
};

struct solver {
    pnb_solver *solver; /* NULL: none, or creating it failed: error */
    struct view_method method;
    uint64_t geometry;
    bool tried;
    char error[256];
};

struct side {
    struct solver solver;
    float **visibility; /* one array per light */
    char message[256];
    int samples;
    bool headless; /* on OpenGL, but not in the window's context, for this reason */
    char refusal[128];
    bool given; /* the window has given the visibility that it drew */
    bool whole; /* visibility is that of the state at rest, all pixels */
};

struct view_engine {
    pnb_context *context;
    struct view_team *team;
    struct view_frame_pool *pool;
    char error[600];

    pnb_scene *scene;
    uint64_t scene_id, geometry; /* geometry: counts the times that an object moved */
    struct view_material *materials;
    size_t object_count;

    struct view_state state;
    bool wanted; /* state is one of this scene */
    enum step next;
    const char *label;
    char label_text[64];

    struct surface full, rough;
    struct side sides[VIEW_SIDES];
    size_t light_capacity, pixel_capacity; /* of the visibility arrays */
    float *rgb, *truth;
    int truth_samples;
    struct view_emitter *emitters;
    struct view_pacing pacing;
    bool waiting;     /* for the window */
    double window_ms; /* of the last frame with sides that it drew, and its level; < 0: none */
    int window_level;
    int rest_level; /* of the next step at rest */
    uint64_t content;
    struct view_times times;
    char light_error[256];
};

static void reset_pacing(struct view_engine *engine)
{
    view_pacing_reset(&engine->pacing);
    engine->rest_level = engine->pacing.level;
    engine->window_level = -1;
}

/* ---- life ---- */

struct view_engine *
view_engine_create(int threads, bool (*progress)(void *user, const char *stage, double fraction),
                   void *user)
{
    struct view_engine *engine = g_new0(struct view_engine, 1);
    pnb_context_desc desc = {.threads = threads, .progress = progress, .user = user};
    if (pnb_context_create(&desc, &engine->context) != PNB_OK) {
        g_free(engine);
        return NULL;
    }
    engine->team = view_team_create(pnb_context_threads(engine->context));
    engine->pool = view_frame_pool_create();
    reset_pacing(engine);
    return engine;
}

static void drop_solver(struct solver *solver)
{
    pnb_solver_destroy(solver->solver);
    view_method_finish(&solver->method);
    *solver = (struct solver){0};
}

static void drop_surface(struct surface *surface)
{
    pnb_surface_destroy(surface->surface);
    *surface = (struct surface){0};
}

static void free_arrays(struct view_engine *engine)
{
    for (int s = 0; s < VIEW_SIDES; s++) {
        for (size_t k = 0; engine->sides[s].visibility && k < engine->light_capacity; k++)
            free(engine->sides[s].visibility[k]);
        free(engine->sides[s].visibility);
        engine->sides[s].visibility = NULL;
        engine->sides[s].whole = false;
    }
    free(engine->rgb);
    free(engine->truth);
    engine->rgb = engine->truth = NULL;
    engine->truth_samples = 0;
    engine->light_capacity = engine->pixel_capacity = 0;
}

static void drop_emitters(struct view_engine *engine)
{
    for (size_t i = 0; engine->emitters && i < engine->state.light_count; i++)
        view_emitter_finish(&engine->emitters[i]);
    g_free(engine->emitters);
    engine->emitters = NULL;
}

static void drop_scene(struct view_engine *engine)
{
    drop_emitters(engine);
    for (int s = 0; s < VIEW_SIDES; s++)
        drop_solver(&engine->sides[s].solver);
    drop_surface(&engine->full);
    drop_surface(&engine->rough);
    free_arrays(engine);
    if (engine->wanted)
        view_state_finish(&engine->state);
    engine->wanted = false;
    engine->next = STEP_NONE;
    g_free(engine->materials);
    engine->materials = NULL;
    pnb_scene_destroy(engine->scene);
    engine->scene = NULL;
}

void view_engine_destroy(struct view_engine *engine)
{
    if (!engine)
        return;
    drop_scene(engine);
    view_team_destroy(engine->team);
    view_frame_pool_unref(engine->pool);
    pnb_context_destroy(engine->context);
    g_free(engine);
}

const char *view_engine_error(const struct view_engine *engine)
{
    return engine ? engine->error : "memory: none left";
}

static bool fail(struct view_engine *engine)
{
    g_strlcpy(engine->error, pnb_context_error(engine->context), sizeof(engine->error));
    return false;
}

/* ---- commands ---- */

static void read_materials(struct view_engine *engine)
{
    engine->object_count = pnb_scene_object_count(engine->scene);
    engine->materials = g_new0(struct view_material, engine->object_count + 1);
    for (size_t i = 0; i < engine->object_count; i++) {
        pnb_object object;
        pnb_scene_object(engine->scene, i, &object);
        struct view_material *material = &engine->materials[i];
        for (int c = 0; c < 3; c++)
            material->color[c] = (float)object.color[c];
        material->receives = object.receives;
    }
}

/* What a surface shows by itself comes through the exposure. */
static void set_emission(struct view_engine *engine, double exposure)
{
    for (size_t i = 0; i < engine->object_count; i++) {
        pnb_object object;
        pnb_scene_object(engine->scene, i, &object);
        for (int c = 0; c < 3; c++)
            engine->materials[i].emission[c] = (float)(exposure * G_PI * object.emission[c]);
    }
}

bool view_engine_open(struct view_engine *engine, const char *path, char **lights, uint64_t id,
                      struct view_scene **out_scene)
{
    pnb_scene *scene = NULL;
    int64_t started = g_get_monotonic_time();
    engine->label = "Opening";
    pnb_status status = pnb_scene_load(engine->context, path, &scene);
    if (status == PNB_OK && lights && lights[0])
        pnb_scene_clear_lights(scene);
    for (size_t i = 0; status == PNB_OK && lights && lights[i]; i++)
        status = pnb_scene_add_light_json(scene, lights[i], NULL);
    engine->label = NULL;
    if (status != PNB_OK) {
        pnb_scene_destroy(scene);
        return fail(engine);
    }
    drop_scene(engine);
    engine->scene = scene;
    engine->scene_id = id;
    engine->geometry = 0;
    read_materials(engine);
    reset_pacing(engine);
    *out_scene = view_scene_describe(scene, path, id);
    /* What the file says of the exposure is what differs from the automatic one. */
    double given = pnb_scene_exposure(scene);
    pnb_scene_set_exposure(scene, 0);
    if (given != pnb_scene_exposure(scene)) {
        pnb_scene_set_exposure(scene, given);
        (*out_scene)->exposure = given;
    }
    (*out_scene)->load_us = g_get_monotonic_time() - started;
    return true;
}

bool view_engine_save(struct view_engine *engine, const char *path)
{
    if (!engine->scene) {
        g_snprintf(engine->error, sizeof(engine->error), "%s: no scene is open", path);
        return false;
    }
    bool glb = g_str_has_suffix(path, ".glb");
    pnb_status status =
        glb ? pnb_scene_write_glb(engine->scene, path) : pnb_scene_write_json(engine->scene, path);
    return status == PNB_OK ? true : fail(engine);
}

/* ---- the wanted state ---- */

static bool same_light(const pnb_light *a, const pnb_light *b)
{
    if (a->type != b->type || memcmp(a->color, b->color, sizeof(a->color)) != 0)
        return false;
    switch (a->type) {
    case PNB_LIGHT_RECTANGLE:
        return memcmp(&a->shape.rectangle, &b->shape.rectangle, sizeof(a->shape.rectangle)) == 0;
    case PNB_LIGHT_DISK: return memcmp(&a->shape.disk, &b->shape.disk, sizeof(a->shape.disk)) == 0;
    case PNB_LIGHT_POLYGON:
        return a->shape.polygon.vertex_count == b->shape.polygon.vertex_count &&
               memcmp(a->shape.polygon.vertices, b->shape.polygon.vertices,
                      a->shape.polygon.vertex_count * 3 * sizeof(double)) == 0;
    case PNB_LIGHT_LINE: return memcmp(&a->shape.line, &b->shape.line, sizeof(a->shape.line)) == 0;
    case PNB_LIGHT_POINT:
        return memcmp(&a->shape.point, &b->shape.point, sizeof(a->shape.point)) == 0;
    case PNB_LIGHT_SUN: return memcmp(&a->shape.sun, &b->shape.sun, sizeof(a->shape.sun)) == 0;
    }
    return false;
}

static bool same_lights(const struct view_state *a, const struct view_state *b)
{
    bool same = a->light_count == b->light_count;
    for (size_t i = 0; same && i < a->light_count; i++)
        same = same_light(&a->lights[i].light, &b->lights[i].light);
    return same;
}

/* The scene as the new state has it; what no longer holds is dropped. */
static void apply_objects(struct view_engine *engine, const struct view_state *state)
{
    bool moved = false;
    for (size_t i = 0; i < state->object_count; i++) {
        if (engine->wanted && memcmp(state->placements[i], engine->state.placements[i],
                                     sizeof(*state->placements)) == 0)
            continue;
        pnb_object object;
        pnb_scene_object(engine->scene, i, &object);
        if (memcmp(object.world_from_mesh, state->placements[i], sizeof(*state->placements)) == 0)
            continue;
        if (pnb_scene_set_placement(engine->scene, i, state->placements[i]) == PNB_OK)
            moved = true;
    }
    if (moved)
        engine->geometry++;
}

static void apply_lights(struct view_engine *engine, const struct view_state *state)
{
    pnb_status status = PNB_OK;
    engine->light_error[0] = 0;
    if (pnb_scene_light_count(engine->scene) != state->light_count) {
        pnb_scene_clear_lights(engine->scene);
        for (size_t i = 0; i < state->light_count && status == PNB_OK; i++)
            status = pnb_scene_add_light(engine->scene, &state->lights[i].light, NULL);
    } else {
        for (size_t i = 0; i < state->light_count && status == PNB_OK; i++)
            status = pnb_scene_set_light(engine->scene, i, &state->lights[i].light);
    }
    if (status != PNB_OK)
        g_strlcpy(engine->light_error, pnb_context_error(engine->context),
                  sizeof(engine->light_error));
}

/* ---- sides of the window ---- */

static bool in_window(const struct view_engine *engine, int s)
{
    return engine->state.window && !engine->sides[s].headless &&
           (s == 0 || engine->state.compare) && view_method_on_opengl(&engine->state.methods[s]);
}

static bool any_in_window(const struct view_engine *engine)
{
    return in_window(engine, 0) || in_window(engine, 1);
}

static void leave_window(struct view_engine *engine, const char *why)
{
    for (int s = 0; s < VIEW_SIDES; s++) {
        struct side *side = &engine->sides[s];
        if (!in_window(engine, s))
            continue;
        side->headless = true;
        side->whole = false;
        g_strlcpy(side->refusal, why, sizeof(side->refusal));
    }
    reset_pacing(engine);
}

/* The next step at rest, by what the window's last frame took: all pixels if that keeps within
 * VIEW_BLOCK_MS, else as many as surely do. */
static enum step window_step(struct view_engine *engine)
{
    int level = engine->window_level;
    double ms = fmax(engine->window_ms, 0.01);
    engine->rest_level = engine->pacing.level;
    if (level < 0)
        return STEP_ROUGH;
    if (view_pacing_predict(level, ms) <= VIEW_BLOCK_MS)
        return STEP_FULL;
    int next = level - (int)floor(2 * log2(VIEW_BLOCK_MS / ms));
    if (next < level) {
        engine->rest_level = MAX(next, 1);
        return STEP_ROUGH;
    }
    leave_window(engine, "too slow for the window");
    return STEP_ROUGH;
}

static void choose_step(struct view_engine *engine)
{
    const struct view_state *state = &engine->state;
    bool whole = engine->sides[0].whole && (!state->compare || engine->sides[1].whole);
    engine->next = state->moving ? STEP_MOVING : STEP_FULL;
    engine->rest_level = engine->pacing.level;
    if (state->moving)
        return;
    if (whole)
        engine->next = STEP_SHOW;
    else if (any_in_window(engine))
        engine->next = window_step(engine);
    else if (!engine->pacing.known ||
             view_pacing_predict(engine->pacing.level, 42) > ROUGH_FIRST_MS)
        engine->next = STEP_ROUGH;
}

void view_engine_drawn(struct view_engine *engine, const struct view_drawn *drawn)
{
    if (!engine->wanted || drawn->scene_id != engine->scene_id || !any_in_window(engine))
        return;
    bool current = drawn->serial == engine->state.serial;
    if (drawn->late || drawn->refused) {
        leave_window(engine, drawn->refused ? drawn->why : "too slow for the window");
        engine->waiting = false;
        choose_step(engine);
        return;
    }
    engine->window_ms = drawn->ms;
    engine->window_level = drawn->level;
    view_pacing_learn(&engine->pacing, drawn->level, drawn->ms);
    if (engine->waiting && current && engine->next == STEP_ROUGH) {
        engine->waiting = false;
        choose_step(engine);
    }
}

void view_engine_given(struct view_engine *engine, uint64_t content, int s, const float *values,
                       size_t count)
{
    struct side *side = &engine->sides[s];
    const struct view_state *state = &engine->state;
    if (!engine->wanted || content != engine->content || side->given || !side->visibility ||
        state->light >= engine->light_capacity || count > engine->pixel_capacity)
        return;
    memcpy(side->visibility[state->light], values, count * sizeof(float));
    side->given = true;
    if (engine->next == STEP_TRUTH)
        engine->waiting = false;
}

bool view_engine_waits(const struct view_engine *engine)
{
    return engine->waiting;
}

void view_engine_want(struct view_engine *engine, const struct view_state *state)
{
    if (!engine->scene || state->scene_id != engine->scene_id || state->width < 1 ||
        state->height < 1) {
        return;
    }
    const struct view_state *old = engine->wanted ? &engine->state : NULL;
    uint64_t geometry = engine->geometry;
    int64_t started = g_get_monotonic_time();
    apply_objects(engine, state);
    bool lights = !old || !same_lights(old, state);
    if (lights)
        apply_lights(engine, state);
    if (!old || memcmp(&old->camera, &state->camera, sizeof(old->camera)) != 0)
        pnb_scene_set_camera(engine->scene, &state->camera);
    pnb_scene_set_exposure(engine->scene, state->exposure);
    engine->times.update = (double)(g_get_monotonic_time() - started) * 1e-3;

    bool seen = old && geometry == engine->geometry && old->width == state->width &&
                old->height == state->height &&
                memcmp(&old->camera, &state->camera, sizeof(old->camera)) == 0;
    bool other = !seen || lights || old->light != state->light || old->compare != state->compare ||
                 old->window != state->window;
    bool sized = !old || old->width != state->width || old->height != state->height;
    for (int s = 0; s < VIEW_SIDES; s++) {
        struct side *side = &engine->sides[s];
        bool same = old && view_method_equal(&old->methods[s], &state->methods[s]);
        other = other || !same;
        if (!seen || lights || !same)
            side->whole = false;
        if (!same || sized || old->window != state->window)
            side->headless = false;
        if (!same && (s == 0 || state->compare))
            reset_pacing(engine);
    }
    if (old && (old->compare != state->compare || old->window != state->window))
        reset_pacing(engine);
    if (!seen || lights || old->light != state->light)
        engine->truth_samples = 0;
    if (other) {
        engine->content++;
        for (int s = 0; s < VIEW_SIDES; s++)
            engine->sides[s].given = false;
    }

    drop_emitters(engine);
    if (engine->wanted)
        view_state_finish(&engine->state);
    view_state_copy(&engine->state, state);
    engine->wanted = true;
    engine->waiting = false;
    choose_step(engine);
}

bool view_engine_busy(const struct view_engine *engine)
{
    return engine->next != STEP_NONE;
}

bool view_engine_yields(const struct view_engine *engine)
{
    return engine->next == STEP_FULL || engine->next == STEP_TRUTH || engine->next == STEP_SHOW;
}

void view_engine_give_up(struct view_engine *engine)
{
    engine->next = STEP_NONE;
    engine->waiting = false;
}

uint64_t view_engine_serial(const struct view_engine *engine)
{
    return engine->wanted ? engine->state.serial : 0;
}

const char *view_engine_label(const struct view_engine *engine)
{
    return engine->label;
}

/* ---- parts of a frame ---- */

static double milliseconds_since(int64_t started)
{
    return (double)(g_get_monotonic_time() - started) * 1e-3;
}

static bool make_room(struct view_engine *engine, size_t pixels)
{
    size_t lights = engine->state.light_count;
    if (lights <= engine->light_capacity && pixels <= engine->pixel_capacity &&
        pixels * 4 >= engine->pixel_capacity)
        return true;
    free_arrays(engine);
    engine->light_capacity = lights;
    engine->pixel_capacity = pixels;
    engine->rgb = malloc(pixels * 3 * sizeof(float));
    engine->truth = malloc(pixels * sizeof(float));
    bool good = engine->rgb && engine->truth;
    for (int s = 0; s < VIEW_SIDES; s++) {
        engine->sides[s].visibility = calloc(lights + 1, sizeof(float *));
        for (size_t k = 0; good && k < lights; k++) {
            engine->sides[s].visibility[k] = malloc(pixels * sizeof(float));
            good = engine->sides[s].visibility[k] != NULL;
        }
    }
    if (!good)
        free_arrays(engine);
    return good;
}

static pnb_status need_surface(struct view_engine *engine, struct surface *slot, int width,
                               int height)
{
    const pnb_camera *camera = &engine->state.camera;
    if (slot->surface && slot->geometry == engine->geometry && slot->width == width &&
        slot->height == height && memcmp(&slot->camera, camera, sizeof(*camera)) == 0) {
        engine->times.primary = 0;
        return PNB_OK;
    }
    int64_t started = g_get_monotonic_time();
    pnb_status status = PNB_OK;
    if (!slot->surface)
        status = pnb_surface_create(engine->context, engine->scene, camera, width, height,
                                    &slot->surface);
    else
        status = pnb_surface_update(slot->surface, camera, width, height);
    engine->times.primary = milliseconds_since(started);
    if (status != PNB_OK) {
        slot->width = 0; /* it may show nothing */
        return status;
    }
    slot->camera = *camera;
    slot->width = width;
    slot->height = height;
    slot->geometry = engine->geometry;
    return PNB_OK;
}

static pnb_status create_solver(struct view_engine *engine, const struct view_method *method,
                                pnb_solver **out)
{
    const pnb_method_info *info = method->info;
    pnb_solver_param *params = g_new0(pnb_solver_param, info->param_count + 1);
    pnb_solver_desc desc = {
        .method = info->name, .samples = info->samples ? method->samples : 0, .params = params};
    for (size_t i = 0; i < info->param_count; i++)
        if (method->values[i])
            params[desc.param_count++] = (pnb_solver_param){info->params[i].key, method->values[i]};
    pnb_status status = pnb_solver_create(engine->context, engine->scene, &desc, out);
    g_free(params);
    return status;
}

/* The side's solver is there and knows where the objects are. */
static pnb_status need_solver(struct view_engine *engine, struct solver *solver,
                              const struct view_method *method)
{
    if (solver->tried && view_method_equal(&solver->method, method)) {
        if (!solver->solver)
            return PNB_ERROR_UNSUPPORTED;
        if (solver->geometry == engine->geometry)
            return PNB_OK;
        int64_t started = g_get_monotonic_time();
        pnb_status status = pnb_solver_update(solver->solver, PNB_UPDATE_PLACEMENTS);
        engine->times.update += milliseconds_since(started);
        if (status == PNB_OK) {
            solver->geometry = engine->geometry;
            return PNB_OK;
        }
        if (status == PNB_ERROR_CANCELLED)
            return status;
    }
    drop_solver(solver);
    int64_t started = g_get_monotonic_time();
    pnb_status status = create_solver(engine, method, &solver->solver);
    engine->times.update += milliseconds_since(started);
    if (status == PNB_ERROR_CANCELLED)
        return status;
    view_method_copy(&solver->method, method);
    solver->geometry = engine->geometry;
    solver->tried = true;
    if (status != PNB_OK)
        g_strlcpy(solver->error, pnb_context_error(engine->context), sizeof(solver->error));
    return status;
}

static void no_visibility(struct view_engine *engine, int s, size_t pixels, const char *why)
{
    for (size_t k = 0; k < engine->state.light_count; k++)
        for (size_t i = 0; i < pixels; i++)
            engine->sides[s].visibility[k][i] = NAN_FLOAT;
    g_strlcpy(engine->sides[s].message, why, sizeof(engine->sides[s].message));
}

/* Every light on one side. Only PNB_ERROR_CANCELLED is returned; other failures become the side's
 * message and a picture without shadows. */
static pnb_status solve_side(struct view_engine *engine, int s, const pnb_receivers *receivers)
{
    struct side *side = &engine->sides[s];
    const struct view_method *method = &engine->state.methods[s];
    side->message[0] = 0;
    side->samples = 0;
    pnb_status status = need_solver(engine, &side->solver, method);
    if (status == PNB_ERROR_CANCELLED)
        return status;
    if (status != PNB_OK) {
        no_visibility(engine, s, receivers->count, side->solver.error);
        return PNB_OK;
    }
    int64_t started = g_get_monotonic_time();
    for (size_t k = 0; k < engine->state.light_count; k++) {
        if (engine->state.light_count > 1)
            g_snprintf(engine->label_text, sizeof(engine->label_text), "%s, light %zu of %zu",
                       method->info->name, k + 1, engine->state.light_count);
        else
            g_strlcpy(engine->label_text, method->info->name, sizeof(engine->label_text));
        engine->label = engine->label_text;
        status = pnb_solver_visibility(side->solver.solver, &engine->state.lights[k].light,
                                       receivers, side->visibility[k]);
        engine->label = NULL;
        if (status == PNB_ERROR_CANCELLED)
            return status;
        if (status != PNB_OK) {
            no_visibility(engine, s, receivers->count, pnb_context_error(engine->context));
            break;
        }
    }
    engine->times.visibility[s] = milliseconds_since(started);
    pnb_solver_report report;
    pnb_solver_get_report(side->solver.solver, &report);
    side->samples = report.samples;
    return PNB_OK;
}

static void need_emitters(struct view_engine *engine)
{
    if (engine->emitters)
        return;
    engine->emitters = g_new0(struct view_emitter, engine->state.light_count + 1);
    for (size_t i = 0; i < engine->state.light_count; i++)
        view_emitter_init(&engine->emitters[i], &engine->state.lights[i].light);
}

/* whole: by the library, to the last bit as a file would have it. */
static void shade_side(struct view_engine *engine, int s, const struct surface *surface, bool whole,
                       uint8_t *bgra)
{
    struct side *side = &engine->sides[s];
    const float *const *visibility = (const float *const *)side->visibility;
    if (whole && !engine->light_error[0] &&
        pnb_surface_shade(surface->surface, visibility, engine->rgb) == PNB_OK) {
        view_encode(engine->team, engine->rgb, (size_t)surface->width * (size_t)surface->height,
                    bgra);
        return;
    }
    pnb_surface_view view;
    double ambient[3], background[3];
    pnb_surface_get(surface->surface, &view);
    pnb_scene_ambient(engine->scene, ambient);
    pnb_scene_background(engine->scene, background);
    need_emitters(engine);
    struct view_shading shading = {.view = &view,
                                   .materials = engine->materials,
                                   .emitters = engine->emitters,
                                   .emitter_count = engine->state.light_count,
                                   .visibility = visibility,
                                   .exposure = pnb_scene_exposure(engine->scene)};
    set_emission(engine, shading.exposure);
    for (int c = 0; c < 3; c++) {
        shading.ambient[c] = (float)ambient[c];
        shading.background[c] = (float)background[c];
    }
    view_shade(engine->team, &shading, bgra);
}

/* One side's bytes by what has been solved. */
static void draw_bytes(struct view_engine *engine, int s, const struct surface *surface, bool whole,
                       bool truth, uint8_t *bgra)
{
    const struct view_state *state = &engine->state;
    size_t pixels = (size_t)surface->width * (size_t)surface->height;
    const float *visibility =
        state->light < state->light_count ? engine->sides[s].visibility[state->light] : NULL;
    if (state->show == VIEW_SHOW_PICTURE || !visibility)
        shade_side(engine, s, surface, whole, bgra);
    else if (state->show == VIEW_SHOW_ERROR && truth)
        view_show_error(engine->team, visibility, engine->truth, pixels, state->error_scale, bgra);
    else
        view_show_visibility(engine->team, visibility, pixels, bgra);
}

static void copy_visibility(const struct view_engine *engine, int s, size_t pixels, float *to)
{
    const struct view_state *state = &engine->state;
    const struct side *side = &engine->sides[s];
    if (state->light < state->light_count && (side->given || !in_window(engine, s)))
        memcpy(to, side->visibility[state->light], pixels * sizeof(float));
    else
        for (size_t i = 0; i < pixels; i++)
            to[i] = NAN_FLOAT;
}

static void measure(struct view_engine *engine, const struct surface *surface,
                    struct view_frame *frame)
{
    pnb_receivers receivers;
    pnb_surface_receivers(surface->surface, &receivers);
    uint8_t *mask = malloc(receivers.count);
    if (!mask)
        return;
    pnb_measure_facing(&engine->state.lights[engine->state.light].light, &receivers, mask);
    for (int s = 0; s < (engine->state.compare ? VIEW_SIDES : 1); s++)
        pnb_measure(engine->context, frame->visibility[s], engine->truth, mask, receivers.count,
                    &frame->errors[s]);
    free(mask);
}

static void describe_side(struct view_engine *engine, int s, struct view_frame *frame)
{
    struct side *side = &engine->sides[s];
    const struct view_method *method = &engine->state.methods[s];
    frame->methods[s] = method->info;
    frame->window[s] = in_window(engine, s);
    if (frame->window[s])
        return;
    frame->samples[s] = side->samples;
    g_strlcpy(frame->message[s], side->message, sizeof(frame->message[s]));
    if (side->headless)
        g_strlcpy(frame->refusal, side->refusal, sizeof(frame->refusal));
    pnb_solver_report report = {0};
    if (side->solver.solver)
        pnb_solver_get_report(side->solver.solver, &report);
    if (report.device && *report.device)
        g_strlcpy(frame->device, report.device, sizeof(frame->device));
    if (report.warning_count > 0 && !frame->warning[0])
        g_strlcpy(frame->warning, report.warnings[0], sizeof(frame->warning));
}

/* A frame of what has been solved. surface NULL: none is needed, the window draws all of it. */
static struct view_frame *compose(struct view_engine *engine, const struct surface *surface,
                                  int width, int height, bool full)
{
    const struct view_state *state = &engine->state;
    struct view_frame *frame = view_frame_acquire(engine->pool, width, height,
                                                  (size_t)state->width * (size_t)state->height);
    if (!frame)
        return NULL;
    size_t pixels = (size_t)width * (size_t)height;
    bool truth = full && surface && engine->truth_samples > 0 && state->light < state->light_count;
    int64_t started = g_get_monotonic_time();
    frame->picked = surface != NULL;
    if (surface) {
        pnb_surface_view view;
        pnb_surface_get(surface->surface, &view);
        memcpy(frame->objects, view.objects, pixels * sizeof(uint32_t));
    }
    for (int s = 0; s < (state->compare ? VIEW_SIDES : 1); s++) {
        describe_side(engine, s, frame);
        if (!frame->window[s])
            draw_bytes(engine, s, surface, full && !state->moving, truth, frame->bgra[s]);
        copy_visibility(engine, s, pixels, frame->visibility[s]);
        if (s == 0 && engine->light_error[0])
            g_strlcpy(frame->message[s], engine->light_error, sizeof(frame->message[s]));
    }
    if (truth) {
        memcpy(frame->truth, engine->truth, pixels * sizeof(float));
        frame->truth_samples = engine->truth_samples;
        measure(engine, surface, frame);
    }
    engine->times.shade = milliseconds_since(started);
    frame->times = engine->times;
    frame->exposure = pnb_scene_exposure(engine->scene);
    frame->scene_id = engine->scene_id;
    frame->serial = state->serial;
    frame->content = engine->content;
    frame->wanted_us = state->wanted_us;
    frame->full = full;
    frame->moving = state->moving;
    frame->compare = state->compare;
    frame->show = state->show;
    frame->error_scale = state->error_scale;
    frame->light = state->light;
    if (any_in_window(engine))
        view_state_copy(&frame->state, state);
    engine->times = (struct view_times){0};
    return frame;
}

/* Surface, sides and frame; the sides that are whole already stay. PNB_ERROR_CANCELLED, or PNB_OK
 * even where a side failed. level 0: all pixels. */
static pnb_status make_frame(struct view_engine *engine, int level, bool full,
                             struct view_frame **out_frame)
{
    const struct view_state *state = &engine->state;
    int width = state->width, height = state->height, sides = state->compare ? VIEW_SIDES : 1;
    bool rest = full && !state->moving, solved = false, all_window = true;
    view_pacing_size(level, state->width, state->height, &width, &height);
    bool whole_size = width == state->width && height == state->height;
    if (!make_room(engine, (size_t)state->width * (size_t)state->height))
        return PNB_ERROR_MEMORY;
    for (int s = 0; s < sides; s++)
        all_window = all_window && in_window(engine, s);
    struct surface *surface = whole_size ? &engine->full : &engine->rough;
    int64_t started = g_get_monotonic_time();
    /* At rest one is wanted for what the pointer meets, and for the truth. */
    bool needed = !all_window || rest;
    engine->times.primary = 0;
    pnb_status status = needed ? need_surface(engine, surface, width, height) : PNB_OK;
    if (status != PNB_OK)
        return status;
    pnb_receivers receivers;
    if (needed)
        pnb_surface_receivers(surface->surface, &receivers);
    for (int s = 0; s < sides; s++) {
        struct side *side = &engine->sides[s];
        if (side->whole && rest)
            continue; /* its time is not that of a frame */
        side->whole = false;
        if (!in_window(engine, s)) {
            status = solve_side(engine, s, &receivers);
            if (status != PNB_OK)
                return status;
            solved = true;
        }
        side->whole = rest;
    }
    if (all_window && rest)
        engine->times.primary = 0; /* the window's picture did not wait for it */
    double before = engine->times.shade;
    struct view_frame *frame = *out_frame =
        compose(engine, needed ? surface : NULL, width, height, full || whole_size);
    if (!frame)
        return PNB_ERROR_MEMORY;
    double total = milliseconds_since(started) - before;
    /* At rest the library shades, and the surface is found anew: neither is a frame's cost. */
    if (!state->moving)
        total = solved ? frame->times.visibility[0] + frame->times.visibility[1] + 4 : 0;
    frame->level = level;
    frame->worker_ms = total;
    if (solved && !any_in_window(engine))
        view_pacing_learn(&engine->pacing, level, total);
    return PNB_OK;
}

/* ---- truth ---- */

static pnb_status refine_truth(struct view_engine *engine, struct view_frame **out_frame)
{
    const struct view_state *state = &engine->state;
    int samples = engine->truth_samples ? engine->truth_samples * 4 : TRUTH_FIRST;
    samples = MIN(samples, state->truth_samples);
    struct solver solver = {0};
    struct view_method method;
    pnb_receivers receivers;
    view_method_init(&method, pnb_method_find("reference"));
    method.samples = samples;
    pnb_surface_receivers(engine->full.surface, &receivers);
    float *values = malloc(receivers.count * sizeof(float));
    pnb_status status = values ? need_solver(engine, &solver, &method) : PNB_ERROR_MEMORY;
    if (status == PNB_OK) {
        g_snprintf(engine->label_text, sizeof(engine->label_text), "Truth, %d samples", samples);
        engine->label = engine->label_text;
        status = pnb_solver_visibility(solver.solver, &state->lights[state->light].light,
                                       &receivers, values);
        engine->label = NULL;
    }
    if (status == PNB_OK) {
        memcpy(engine->truth, values, receivers.count * sizeof(float));
        engine->truth_samples = samples;
        *out_frame = compose(engine, &engine->full, engine->full.width, engine->full.height, true);
    }
    engine->times = (struct view_times){0};
    free(values);
    drop_solver(&solver);
    view_method_finish(&method);
    return status;
}

static bool wants_truth(const struct view_engine *engine)
{
    const struct view_state *state = &engine->state;
    return state->light < state->light_count && engine->truth_samples < state->truth_samples &&
           pnb_method_find("reference") && !engine->light_error[0];
}

bool view_engine_step(struct view_engine *engine, struct view_frame **out_frame)
{
    pnb_status status = PNB_OK;
    enum step step = engine->next;
    switch (step) {
    case STEP_NONE: return true;
    case STEP_MOVING:
        status = make_frame(engine, engine->state.full_size ? 0 : engine->pacing.level,
                            engine->state.full_size, out_frame);
        engine->next = STEP_NONE;
        break;
    case STEP_ROUGH: {
        bool known = engine->pacing.known;
        status = make_frame(engine, engine->rest_level, false, out_frame);
        if (*out_frame && any_in_window(engine)) {
            engine->waiting = true; /* its time decides what follows */
            break;
        }
        /* The first one was to learn the cost: if the whole frame is quick, that one is enough. */
        if (*out_frame && !known &&
            view_pacing_predict(engine->pacing.level, 42) < ROUGH_FIRST_MS) {
            view_frame_unref(*out_frame);
            *out_frame = NULL;
        }
        engine->next = STEP_FULL;
        break;
    }
    case STEP_FULL:
    case STEP_SHOW:
        status = make_frame(engine, 0, true, out_frame);
        if (status == PNB_OK)
            engine->next = wants_truth(engine) ? STEP_TRUTH : STEP_NONE;
        break;
    case STEP_TRUTH:
        /* Its figures want the visibility of both sides. */
        for (int s = 0; s < VIEW_SIDES; s++)
            engine->waiting = engine->waiting || (in_window(engine, s) && !engine->sides[s].given);
        if (engine->waiting)
            return true;
        status = refine_truth(engine, out_frame);
        if (status == PNB_OK)
            engine->next = wants_truth(engine) ? STEP_TRUTH : STEP_NONE;
        break;
    }
    if (status == PNB_OK || status == PNB_ERROR_CANCELLED)
        return true;
    engine->next = STEP_NONE;
    if (status == PNB_ERROR_MEMORY)
        g_strlcpy(engine->error, "memory: none left for a picture of this size",
                  sizeof(engine->error));
    else
        fail(engine);
    return false;
}

/* ---- screenshots ---- */

/* The sides that the window drew are done here as `render` does them, into bytes of their own. */
static bool redo_sides(struct view_engine *engine, const struct view_frame *frame,
                       uint8_t *bytes[VIEW_SIDES])
{
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    if (!engine->wanted || engine->state.serial != frame->serial)
        view_engine_want(engine, &frame->state);
    engine->error[0] = 0;
    if (!make_room(engine, pixels)) {
        g_strlcpy(engine->error, "memory: none left for a picture", sizeof(engine->error));
        return false;
    }
    pnb_status status = need_surface(engine, &engine->full, frame->width, frame->height);
    pnb_receivers receivers;
    for (int s = 0; s < VIEW_SIDES && status == PNB_OK; s++) {
        if (!frame->window[s])
            continue;
        pnb_surface_receivers(engine->full.surface, &receivers);
        status = solve_side(engine, s, &receivers);
        bytes[s] = g_malloc(4 * pixels);
        if (status == PNB_OK)
            draw_bytes(engine, s, &engine->full, true, frame->truth_samples > 0, bytes[s]);
    }
    engine->times = (struct view_times){0};
    return status == PNB_OK ? true : fail(engine);
}

bool view_engine_screenshot(struct view_engine *engine, const struct view_frame *frame,
                            double divider, bool shown, const char *path)
{
    pnb_image image;
    uint8_t *bytes[VIEW_SIDES] = {NULL, NULL};
    if (!shown && (frame->window[0] || frame->window[1]) && !redo_sides(engine, frame, bytes)) {
        g_free(bytes[0]);
        g_free(bytes[1]);
        return false;
    }
    pnb_status status = pnb_image_create(engine->context, frame->width, frame->height, 3, &image);
    float linear[256];
    for (int k = 0; k < 256; k++) {
        double e = k / 255.0;
        linear[k] = (float)(e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4));
    }
    int cut = frame->compare ? (int)lround(divider * frame->width) : frame->width;
    for (int y = 0; status == PNB_OK && y < frame->height; y++)
        for (int x = 0; x < frame->width; x++) {
            size_t pixel = (size_t)y * (size_t)frame->width + (size_t)x;
            int s = x < cut ? 0 : 1;
            const uint8_t *from = (bytes[s] ? bytes[s] : frame->bgra[s]) + 4 * pixel;
            for (int c = 0; c < 3; c++)
                image.data[3 * pixel + (size_t)c] = linear[from[2 - c]];
        }
    if (status == PNB_OK) {
        status = pnb_image_write(engine->context, path, &image);
        pnb_image_finish(engine->context, &image);
    }
    g_free(bytes[0]);
    g_free(bytes[1]);
    return status == PNB_OK ? true : fail(engine);
}
