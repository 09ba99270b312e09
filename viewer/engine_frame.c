/* viewer/engine_frame.c: from visibility to a frame: at rest by the library, to the last bit as a
 * file would have it, while something moves by the viewer's own shading.
 */
#include "engine_inside.h"

#include <stdlib.h>
#include <string.h>

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

void engine_draw_bytes(struct view_engine *engine, int s, const struct surface *surface, bool whole,
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
    if (state->light < state->light_count && (side->given || !engine_in_window(engine, s)))
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
    frame->window[s] = engine_in_window(engine, s);
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

struct view_frame *engine_compose(struct view_engine *engine, const struct surface *surface,
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
            engine_draw_bytes(engine, s, surface, full && !state->moving, truth, frame->bgra[s]);
        copy_visibility(engine, s, pixels, frame->visibility[s]);
        if (s == 0 && engine->light_error[0])
            g_strlcpy(frame->message[s], engine->light_error, sizeof(frame->message[s]));
    }
    if (truth) {
        memcpy(frame->truth, engine->truth, pixels * sizeof(float));
        frame->truth_samples = engine->truth_samples;
        measure(engine, surface, frame);
    }
    engine->times.shade = engine_milliseconds_since(started);
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
    if (engine_any_in_window(engine))
        view_state_copy(&frame->state, state);
    engine->times = (struct view_times){0};
    return frame;
}

pnb_status engine_make_frame(struct view_engine *engine, int level, bool full,
                             struct view_frame **out_frame)
{
    const struct view_state *state = &engine->state;
    int width = state->width, height = state->height, sides = state->compare ? VIEW_SIDES : 1;
    bool rest = full && !state->moving, solved = false, all_window = true;
    view_pacing_size(level, state->width, state->height, &width, &height);
    bool whole_size = width == state->width && height == state->height;
    if (!engine_make_room(engine, (size_t)state->width * (size_t)state->height))
        return PNB_ERROR_MEMORY;
    for (int s = 0; s < sides; s++)
        all_window = all_window && engine_in_window(engine, s);
    struct surface *surface = whole_size ? &engine->full : &engine->rough;
    int64_t started = g_get_monotonic_time();
    /* At rest one is wanted for what the pointer meets, and for the truth. */
    bool needed = !all_window || rest;
    engine->times.primary = 0;
    pnb_status status = needed ? engine_need_surface(engine, surface, width, height, rest) : PNB_OK;
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
        if (!engine_in_window(engine, s)) {
            status = engine_solve_side(engine, s, &receivers);
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
        engine_compose(engine, needed ? surface : NULL, width, height, full || whole_size);
    if (!frame)
        return PNB_ERROR_MEMORY;
    double total = engine_milliseconds_since(started) - before;
    /* At rest the library shades, and the surface is found anew: neither is a frame's cost. */
    if (!state->moving)
        total = solved ? frame->times.visibility[0] + frame->times.visibility[1] + 4 : 0;
    frame->level = level;
    frame->worker_ms = total;
    if (solved && !engine_any_in_window(engine))
        view_pacing_learn(&engine->pacing, level, total);
    return PNB_OK;
}
