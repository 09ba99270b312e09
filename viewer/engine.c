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
 * state.patience_ms; where that cannot be, the worker does the method in a context without a
 * window.
 *
 * engine_want.c: what the next step is; engine_solve.c: surfaces and visibility; engine_frame.c:
 * bytes and frames.
 */
#include "engine_inside.h"

#include <stdlib.h>
#include <string.h>

#define TRUTH_FIRST 64

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
    engine_reset_pacing(engine);
    return engine;
}

void engine_drop_solver(struct solver *solver)
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

void engine_free_arrays(struct view_engine *engine)
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

static void drop_scene(struct view_engine *engine)
{
    engine_drop_emitters(engine);
    for (int s = 0; s < VIEW_SIDES; s++)
        engine_drop_solver(&engine->sides[s].solver);
    drop_surface(&engine->full);
    drop_surface(&engine->rough);
    engine_free_arrays(engine);
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

bool engine_fail(struct view_engine *engine)
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
        return engine_fail(engine);
    }
    drop_scene(engine);
    engine->scene = scene;
    engine->scene_id = id;
    engine->geometry = engine->settled = 0;
    read_materials(engine);
    engine_reset_pacing(engine);
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
    return status == PNB_OK ? true : engine_fail(engine);
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
    pnb_status status = values ? engine_need_solver(engine, &solver, &method) : PNB_ERROR_MEMORY;
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
        *out_frame =
            engine_compose(engine, &engine->full, engine->full.width, engine->full.height, true);
    }
    engine->times = (struct view_times){0};
    free(values);
    engine_drop_solver(&solver);
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
        status = engine_make_frame(engine, engine->state.full_size ? 0 : engine->pacing.level,
                                   engine->state.full_size, out_frame);
        engine->next = STEP_NONE;
        break;
    case STEP_ROUGH: {
        bool known = engine->pacing.known;
        status = engine_make_frame(engine, engine->rest_level, false, out_frame);
        if (*out_frame && engine_any_in_window(engine)) {
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
        status = engine_make_frame(engine, 0, true, out_frame);
        if (status == PNB_OK)
            engine->next = wants_truth(engine) ? STEP_TRUTH : STEP_NONE;
        break;
    case STEP_TRUTH:
        /* Its figures want the visibility of both sides. */
        for (int s = 0; s < VIEW_SIDES; s++)
            engine->waiting =
                engine->waiting || (engine_in_window(engine, s) && !engine->sides[s].given);
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
        engine_fail(engine);
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
    if (!engine_make_room(engine, pixels)) {
        g_strlcpy(engine->error, "memory: none left for a picture", sizeof(engine->error));
        return false;
    }
    pnb_status status =
        engine_need_surface(engine, &engine->full, frame->width, frame->height, true);
    pnb_receivers receivers;
    for (int s = 0; s < VIEW_SIDES && status == PNB_OK; s++) {
        if (!frame->window[s])
            continue;
        pnb_surface_receivers(engine->full.surface, &receivers);
        status = engine_solve_side(engine, s, &receivers);
        bytes[s] = g_malloc(4 * pixels);
        if (status == PNB_OK)
            engine_draw_bytes(engine, s, &engine->full, true, frame->truth_samples > 0, bytes[s]);
    }
    engine->times = (struct view_times){0};
    return status == PNB_OK ? true : engine_fail(engine);
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
    return status == PNB_OK ? true : engine_fail(engine);
}
