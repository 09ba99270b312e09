/* viewer/engine_want.c: the state that is wanted, what of the last one still holds, and which step
 * is next: with sides of the window by what those took there.
 */
#include "engine_inside.h"

#include <string.h>

void engine_reset_pacing(struct view_engine *engine)
{
    view_pacing_reset(&engine->pacing);
    engine->rest_level = engine->pacing.level;
    engine->window_level = -1;
}

void engine_drop_emitters(struct view_engine *engine)
{
    for (size_t i = 0; engine->emitters && i < engine->state.light_count; i++)
        view_emitter_finish(&engine->emitters[i]);
    g_free(engine->emitters);
    engine->emitters = NULL;
}

/* ---- the wanted state ---- */

static bool same_lights(const struct view_state *a, const struct view_state *b)
{
    bool same = a->light_count == b->light_count;
    for (size_t i = 0; same && i < a->light_count; i++)
        same = view_light_equal(&a->lights[i].light, &b->lights[i].light);
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

bool engine_in_window(const struct view_engine *engine, int s)
{
    return engine->state.window && !engine->sides[s].headless &&
           (s == 0 || engine->state.compare) && view_method_on_opengl(&engine->state.methods[s]);
}

bool engine_any_in_window(const struct view_engine *engine)
{
    return engine_in_window(engine, 0) || engine_in_window(engine, 1);
}

static void leave_window(struct view_engine *engine, const char *why)
{
    for (int s = 0; s < VIEW_SIDES; s++) {
        struct side *side = &engine->sides[s];
        if (!engine_in_window(engine, s))
            continue;
        side->headless = true;
        side->whole = false;
        g_strlcpy(side->refusal, why, sizeof(side->refusal));
    }
    engine_reset_pacing(engine);
}

/* The next step at rest, by what the window's last frame took: all pixels if that keeps within its
 * patience, else as many as surely do. */
static enum step window_step(struct view_engine *engine)
{
    int level = engine->window_level;
    double ms = fmax(engine->window_ms, 0.01), patience = fmax(engine->state.patience_ms, 0.01);
    engine->rest_level = engine->pacing.level;
    if (level < 0)
        return STEP_ROUGH;
    if (view_pacing_predict(level, ms) <= patience)
        return STEP_FULL;
    int next = level - (int)floor(2 * log2(patience / ms));
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
    else if (engine_any_in_window(engine))
        engine->next = window_step(engine);
    else if (!engine->pacing.known ||
             view_pacing_predict(engine->pacing.level, 42) > ROUGH_FIRST_MS)
        engine->next = STEP_ROUGH;
}

void view_engine_drawn(struct view_engine *engine, const struct view_drawn *drawn)
{
    if (!engine->wanted || drawn->scene_id != engine->scene_id || !engine_any_in_window(engine))
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
    bool patient = old && old->patience_ms == state->patience_ms;
    bool sized = !old || old->width != state->width || old->height != state->height;
    for (int s = 0; s < VIEW_SIDES; s++) {
        struct side *side = &engine->sides[s];
        bool same = old && view_method_equal(&old->methods[s], &state->methods[s]);
        other = other || !same;
        if (!seen || lights || !same || !patient)
            side->whole = false;
        if (!same || sized || !patient || old->window != state->window)
            side->headless = false;
        if (!same && (s == 0 || state->compare))
            engine_reset_pacing(engine);
    }
    if (old && (old->compare != state->compare || old->window != state->window))
        engine_reset_pacing(engine);
    if (!seen || lights || old->light != state->light)
        engine->truth_samples = 0;
    if (other) {
        engine->content++;
        for (int s = 0; s < VIEW_SIDES; s++)
            engine->sides[s].given = false;
    }

    engine_drop_emitters(engine);
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
