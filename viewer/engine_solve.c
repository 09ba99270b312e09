/* viewer/engine_solve.c: surfaces, solvers and the visibility of every light on a side. */
#include "engine_inside.h"

#include <stdlib.h>
#include <string.h>

double engine_milliseconds_since(int64_t started)
{
    return (double)(g_get_monotonic_time() - started) * 1e-3;
}

bool engine_make_room(struct view_engine *engine, size_t pixels)
{
    size_t lights = engine->state.light_count;
    if (lights <= engine->light_capacity && pixels <= engine->pixel_capacity &&
        pixels * 4 >= engine->pixel_capacity)
        return true;
    engine_free_arrays(engine);
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
        engine_free_arrays(engine);
    return good;
}

pnb_status engine_need_surface(struct view_engine *engine, struct surface *slot, int width,
                               int height, bool exact)
{
    const pnb_camera *camera = &engine->state.camera;
    bool shown = slot->surface && slot->geometry == engine->geometry && slot->width == width &&
                 slot->height == height && memcmp(&slot->camera, camera, sizeof(*camera)) == 0;
    bool settles = exact && engine->settled != engine->geometry;
    if (shown && !settles) {
        engine->times.primary = 0;
        return PNB_OK;
    }
    int64_t started = g_get_monotonic_time();
    pnb_status status = PNB_OK;
    if (!slot->surface) {
        status = pnb_surface_create(engine->context, engine->scene, camera, width, height,
                                    &slot->surface);
    } else {
        /* One to be where the objects are, and one that finds nothing moved. */
        if (!shown)
            status = pnb_surface_update(slot->surface, camera, width, height);
        if (status == PNB_OK && settles)
            status = pnb_surface_update(slot->surface, camera, width, height);
    }
    if (status == PNB_OK && exact)
        engine->settled = engine->geometry;
    engine->times.primary = engine_milliseconds_since(started);
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

pnb_status engine_need_solver(struct view_engine *engine, struct solver *solver,
                              const struct view_method *method)
{
    if (solver->tried && view_method_equal(&solver->method, method)) {
        if (!solver->solver)
            return PNB_ERROR_UNSUPPORTED;
        if (solver->geometry == engine->geometry)
            return PNB_OK;
        int64_t started = g_get_monotonic_time();
        pnb_status status = pnb_solver_update(solver->solver, PNB_UPDATE_PLACEMENTS);
        engine->times.update += engine_milliseconds_since(started);
        if (status == PNB_OK) {
            solver->geometry = engine->geometry;
            return PNB_OK;
        }
        if (status == PNB_ERROR_CANCELLED)
            return status;
    }
    engine_drop_solver(solver);
    int64_t started = g_get_monotonic_time();
    pnb_status status = create_solver(engine, method, &solver->solver);
    engine->times.update += engine_milliseconds_since(started);
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

pnb_status engine_solve_side(struct view_engine *engine, int s, const pnb_receivers *receivers)
{
    struct side *side = &engine->sides[s];
    const struct view_method *method = &engine->state.methods[s];
    side->message[0] = 0;
    side->samples = 0;
    pnb_status status = engine_need_solver(engine, &side->solver, method);
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
    engine->times.visibility[s] = engine_milliseconds_since(started);
    pnb_solver_report report;
    pnb_solver_get_report(side->solver.solver, &report);
    side->samples = report.samples;
    return PNB_OK;
}
