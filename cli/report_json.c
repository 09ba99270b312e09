/* cli/report_json.c: a comparison as report.json. The keys that the documents promise, and more. */
#include "compare_curves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static json_t *texts_json(char *const *texts, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, cli_json_text(texts[i]));
    return array;
}

static json_t *entry_json(const struct compare_run *run, const struct compare_entry *entry)
{
    const pnb_errors *errors = &entry->errors;
    const struct {
        const char *key;
        double value;
    } figures[] = {
        {"milliseconds", entry->milliseconds},
        {"processor_milliseconds", entry->processor_ms},
        {"prepare_milliseconds", entry->prepare_ms},
        {"rmse", errors->rmse},
        {"mean_error", errors->mean_error},
        {"max_error", errors->max_error},
        {"p99_error", errors->p99_error},
        {"umbra_leak", errors->umbra_leak},
        {"lit_darkening", errors->lit_darkening},
    };
    json_t *object = json_object();
    json_object_set_new(object, "name", cli_json_text(entry->name));
    json_object_set_new(object, "label", cli_json_text(entry->label));
    json_object_set_new(object, "kind",
                        json_string(entry->method         ? "method"
                                    : entry->picture_only ? "picture"
                                                          : "visibility"));
    if (entry->samples)
        json_object_set_new(object, "samples", json_integer(entry->samples));
    for (size_t i = 0; i < sizeof(figures) / sizeof(figures[0]); i++)
        json_object_set_new(object, figures[i].key, cli_json_number(figures[i].value));
    json_object_set_new(object, "pixels", json_integer((json_int_t)errors->pixels));
    json_object_set_new(object, "penumbra_pixels",
                        json_integer((json_int_t)errors->penumbra_pixels));
    if (entry->method) {
        json_object_set_new(object, "parameters",
                            cli_json_parameters(entry->params, entry->param_count, entry->method));
        json_object_set_new(object, "device", cli_json_text(entry->device));
    }
    json_object_set_new(object, "warnings", texts_json(entry->warnings, entry->warning_count));
    return object;
}

json_t *report_json_scene(const struct compare_run *run, const struct compare_scene *scene)
{
    json_t *methods = json_array();
    for (size_t i = 0; i < scene->entry_count; i++)
        json_array_append_new(methods, entry_json(run, &scene->entries[i]));
    json_t *truth = json_object();
    json_object_set_new(truth, "method", json_string("reference"));
    json_object_set_new(truth, "samples", json_integer(scene->truth_samples));
    json_object_set_new(truth, "milliseconds", cli_json_number(scene->truth_ms));
    json_object_set_new(truth, "penumbra_pixels", json_integer((json_int_t)scene->penumbra_pixels));
    json_object_set_new(truth, "umbra_pixels", json_integer((json_int_t)scene->umbra_pixels));
    json_object_set_new(truth, "lit_pixels", json_integer((json_int_t)scene->lit_pixels));

    json_t *object = json_object();
    json_object_set_new(object, "scene", cli_json_text(scene->path));
    json_object_set_new(object, "width", json_integer(scene->width));
    json_object_set_new(object, "height", json_integer(scene->height));
    json_object_set_new(object, "light", json_integer((json_int_t)scene->light_index));
    json_object_set_new(object, "light_type", json_string(scene->light_type));
    json_object_set_new(object, "triangles", json_integer((json_int_t)scene->triangle_count));
    json_object_set_new(object, "facing_pixels", json_integer((json_int_t)scene->facing_pixels));
    json_object_set_new(object, "truth", truth);
    json_object_set_new(object, "methods", methods);
    json_object_set_new(object, "notes", texts_json(scene->notes, scene->note_count));
    return object;
}

json_t *report_json(const struct compare_run *run, json_t *scenes)
{
    json_t *object = json_object();
    json_object_set_new(object, "program", json_string("penumbra"));
    json_object_set_new(object, "version", json_string(pnb_version()));
    json_object_set_new(object, "date", json_string(run->date));
    json_object_set_new(object, "command", cli_json_text(run->command));
    json_object_set_new(object, "processor", cli_json_text(run->processor));
    json_object_set_new(object, "threads", json_integer(run->threads));
    json_object_set_new(object, "scenes", scenes);
    if (run->curves)
        json_object_set_new(object, "curves", report_json_curves(run->curves));
    if (run->papers)
        json_object_set_new(object, "papers", report_json_papers(run, run->papers));
    return object;
}
