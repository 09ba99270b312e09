/* method/solver.c: a method at work on a scene: parameters, clock, counters, warnings.
 *
 * What every method shares is done here once, so that a room holds its algorithm only: parameters
 * are resolved with their defaults and checked against the record before create() sees them, lights
 * are checked and refused before visibility() sees them, and both are timed.
 */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method/method.h"

#define SAMPLES_MAX 262144

bool pnb_param_number(const char *text, double *out_number)
{
    char *end;
    errno = 0;
    double number = strtod(text, &end);
    if (end != text && *end == '/') {
        const char *below = end + 1;
        double divisor = strtod(below, &end);
        number = end != below && divisor != 0 ? number / divisor : NAN;
    }
    *out_number = number;
    return end != text && *end == 0 && isfinite(number) && errno != ERANGE;
}

static bool choice_has(const char *choices, const char *word)
{
    size_t length = strlen(word);
    for (const char *c = choices; c && length > 0;) {
        const char *bar = strchr(c, '|');
        size_t size = bar ? (size_t)(bar - c) : strlen(c);
        if (size == length && memcmp(c, word, size) == 0)
            return true;
        c = bar ? bar + 1 : NULL;
    }
    return false;
}

static pnb_status check_value(pnb_context *context, const pnb_param_info *info, const char *value)
{
    double number;
    switch (info->type) {
    case PNB_PARAM_INTEGER:
    case PNB_PARAM_NUMBER:
        if (!pnb_param_number(value, &number))
            return status_fail(context, PNB_ERROR_ARGUMENT, info->key, "'%s' is not a number",
                               value);
        if (info->type == PNB_PARAM_INTEGER && number != floor(number))
            return status_fail(context, PNB_ERROR_ARGUMENT, info->key, "'%s' is not a whole number",
                               value);
        if (number < info->minimum || number > info->maximum)
            return status_fail(context, PNB_ERROR_ARGUMENT, info->key,
                               "%s lies outside %.10g to %.10g", value, info->minimum,
                               info->maximum);
        return PNB_OK;
    case PNB_PARAM_CHOICE:
        if (!choice_has(info->choices, value))
            return status_fail(context, PNB_ERROR_ARGUMENT, info->key, "'%s' is none of %s", value,
                               info->choices);
        return PNB_OK;
    case PNB_PARAM_TEXT: return PNB_OK;
    }
    return PNB_OK;
}

static pnb_status resolve(pnb_solver *solver, const pnb_solver_desc *desc)
{
    pnb_context *context = solver->context;
    const pnb_method_info *info = &solver->method->info;

    solver->samples = info->samples ? info->default_samples : 0;
    if (desc->samples != 0) {
        if (!info->samples)
            return status_fail(context, PNB_ERROR_ARGUMENT, info->name,
                               "takes no number of samples");
        if (desc->samples < 1 || desc->samples > SAMPLES_MAX)
            return status_fail(context, PNB_ERROR_ARGUMENT, "samples", "%d lies outside 1 to %d",
                               desc->samples, SAMPLES_MAX);
        solver->samples = desc->samples;
    }

    solver->values = memory_calloc(context, info->param_count, sizeof(*solver->values));
    if (!solver->values)
        return status_no_memory(context, info->param_count * sizeof(*solver->values));
    if (desc->param_count > 0 && !desc->params)
        return status_missing(context, "params");
    for (size_t i = 0; i < desc->param_count; i++) {
        if (!desc->params[i].key)
            return status_missing(context, "a parameter's key");
        const char *key = desc->params[i].key, *value = desc->params[i].value;
        size_t k = 0;
        while (k < info->param_count && strcmp(info->params[k].key, key) != 0)
            k++;
        if (k == info->param_count) {
            char known[256] = "";
            for (size_t j = 0, used = 0; j < info->param_count && used < sizeof(known); j++)
                used += (size_t)snprintf(known + used, sizeof(known) - used, "%s%s", j ? ", " : "",
                                         info->params[j].key);
            return status_fail(context, PNB_ERROR_ARGUMENT, key,
                               "the method %s has no such parameter%s%s", info->name,
                               *known ? "; it has " : "", known);
        }
        pnb_status status = check_value(context, &info->params[k], value ? value : "");
        if (status != PNB_OK)
            return status;
        memory_free(context, solver->values[k]);
        solver->values[k] = memory_strdup(context, value ? value : "");
        if (!solver->values[k])
            return status_no_memory(context, 1);
    }
    for (size_t k = 0; k < info->param_count; k++) {
        if (solver->values[k])
            continue;
        const char *value = info->params[k].default_value;
        solver->values[k] = memory_strdup(context, value ? value : "");
        if (!solver->values[k])
            return status_no_memory(context, 1);
    }
    return PNB_OK;
}

pnb_status solver_make(pnb_context *context, pnb_scene *scene, const pnb_solver_desc *desc,
                       bool adopts, pnb_solver **out_solver)
{
    static const pnb_solver_desc defaults;
    *out_solver = NULL;
    if (!desc)
        desc = &defaults;
    const char *name = desc->method ? desc->method : pnb_default_method();
    const struct method *method = method_find(name);
    if (!method)
        return status_fail(context, PNB_ERROR_ARGUMENT, *name ? name : "method",
                           "no method of that name");
    if (adopts && !method->opengl)
        return status_fail(context, PNB_ERROR_ARGUMENT, name, "is not a method on OpenGL");
    if (!scene)
        return status_missing(context, "scene");
    pnb_solver *solver = memory_calloc(context, 1, sizeof(*solver));
    if (!solver)
        return status_no_memory(context, sizeof(*solver));
    solver->method = method;
    solver->context = context;
    solver->scene = scene;
    solver->adopts = adopts;
    solver->report.device = "";
    pnb_status status = resolve(solver, desc);
    if (status == PNB_OK) {
        double started = clock_ms();
        status = method->create(solver);
        solver->report.samples = solver->samples;
        solver->report.prepare_ms = clock_ms() - started;
    }
    if (status != PNB_OK) {
        pnb_solver_destroy(solver);
        return status;
    }
    *out_solver = solver;
    return PNB_OK;
}

pnb_status pnb_solver_create(pnb_context *context, pnb_scene *scene, const pnb_solver_desc *desc,
                             pnb_solver **out_solver)
{
    return solver_make(context, scene, desc, false, out_solver);
}

/* destroy() of a method is called for solvers whose create() failed, too: state may be NULL. */
void pnb_solver_destroy(pnb_solver *solver)
{
    if (!solver)
        return;
    pnb_context *context = solver->context;
    solver->method->destroy(solver);
    for (size_t k = 0; solver->values && k < solver->method->info.param_count; k++)
        memory_free(context, solver->values[k]);
    memory_free(context, solver->values);
    for (size_t i = 0; i < solver->report.warning_count; i++)
        memory_free(context, solver->warnings[i]);
    memory_free(context, solver->warnings);
    memory_free(context, solver);
}

pnb_status pnb_solver_update(pnb_solver *solver, pnb_update update)
{
    double started = clock_ms();
    pnb_status status = solver->method->update(solver, update);
    solver->report.prepare_ms = clock_ms() - started;
    return status;
}

pnb_status solver_check_light(const pnb_solver *solver, const pnb_light *light)
{
    pnb_context *context = solver->context;
    pnb_status status = pnb_light_check(context, light);
    if (status == PNB_OK && !(solver->method->info.lights & PNB_LIGHT_BIT(light->type))) {
        char able[256];
        method_list_lights(PNB_LIGHT_BIT(light->type), able, sizeof(able));
        return status_fail(context, PNB_ERROR_UNSUPPORTED,
                           light->name && *light->name ? light->name : "light",
                           "the method %s cannot do %s lights; these can: %s",
                           solver->method->info.name, pnb_light_type_name(light->type), able);
    }
    return status;
}

pnb_status pnb_solver_visibility(pnb_solver *solver, const pnb_light *light,
                                 const pnb_receivers *receivers, float *visibility)
{
    pnb_context *context = solver->context;
    pnb_status status = solver_check_light(solver, light);
    if (status == PNB_OK && !receivers)
        status = status_missing(context, "receivers");
    if (status != PNB_OK)
        return status;
    if (receivers->width < 0 || receivers->height < 0 ||
        (receivers->width > 0 &&
         (size_t)receivers->width * (size_t)receivers->height != receivers->count))
        return status_fail(context, PNB_ERROR_ARGUMENT, "receivers",
                           "%zu points do not make an image of %dx%d", receivers->count,
                           receivers->width, receivers->height);
    if (receivers->count > 0 && (!receivers->positions || !receivers->normals || !visibility))
        return status_fail(context, PNB_ERROR_ARGUMENT, "receivers",
                           "no positions, normals or room for the visibility");
    solver->report.counter_count = 0;
    solver->drawn_ms = -1;
    double started = clock_ms();
    status = solver->method->visibility(solver, light, receivers, visibility);
    double passed = clock_ms() - started;
    solver->report.visibility_ms = solver->drawn_ms >= 0 ? solver->drawn_ms : passed;
    return status;
}

void pnb_solver_get_report(const pnb_solver *solver, pnb_solver_report *out_report)
{
    *out_report = solver->report;
    out_report->warnings = (const char *const *)solver->warnings;
}

const char *solver_param(const pnb_solver *solver, const char *key)
{
    for (size_t k = 0; k < solver->method->info.param_count; k++)
        if (strcmp(solver->method->info.params[k].key, key) == 0)
            return solver->values[k];
    return "";
}

double solver_param_number(const pnb_solver *solver, const char *key)
{
    double number;
    return pnb_param_number(solver_param(solver, key), &number) ? number : 0;
}

int solver_param_integer(const pnb_solver *solver, const char *key)
{
    return (int)solver_param_number(solver, key);
}

void solver_count(pnb_solver *solver, const char *name, double value)
{
    pnb_solver_report *report = &solver->report;
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, name) == 0) {
            report->counters[i].value = value;
            return;
        }
    if (report->counter_count < PNB_COUNTER_MAX)
        report->counters[report->counter_count++] = (pnb_counter){name, value};
}

void solver_warn(pnb_solver *solver, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    for (size_t i = 0; i < solver->report.warning_count; i++)
        if (strcmp(solver->warnings[i], text) == 0)
            return;
    log_warning(solver->context, "%s: %s", solver->method->info.name, text);
    if (!memory_reserve(solver->context, (void **)&solver->warnings, &solver->warning_capacity,
                        solver->report.warning_count, 1, sizeof(*solver->warnings)))
        return;
    char *copy = memory_strdup(solver->context, text);
    if (copy)
        solver->warnings[solver->report.warning_count++] = copy;
}
