/* cli/compare_scene.c: one scene compared: the truth, then every method and file against it.
 *
 *   check: can the methods do it? -> surface -> truth (many rays) -> each method: visibility,
 *   figures, picture, error -> error maps at one common scale
 *
 * Pictures differ only by the light that is compared: the other lights of a scene are shaded with
 * their true visibility in all of them. The truth's light samples are another set than those of
 * the method `reference`, so that its error is not flattered. */
#define _GNU_SOURCE
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define OTHER_SAMPLES_MAX 1024 /* of the lights that are not compared */

/* One scene at work: what is needed only until its section is written. */
struct bench {
    struct cli_session *session;
    const struct cli_options *options;
    const pnb_image *images; /* one per options->images */
    struct compare_scene *result;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
    size_t pixels;
    uint8_t *mask;
    float **visibilities; /* per light: the truth */
    float *truth;         /* of these the compared one's */
    float *truth_rgb;
    float *rgb, *visibility; /* the entry at hand */
};

static bool add_text(char ***texts, size_t *count, const char *text)
{
    char **grown = realloc(*texts, (*count + 1) * sizeof(*grown));
    if (!grown)
        return false;
    *texts = grown;
    grown[*count] = strdup(text);
    if (!grown[*count])
        return false;
    (*count)++;
    return true;
}

static void free_texts(char **texts, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(texts[i]);
    free(texts);
}

static int no_memory(void)
{
    return cli_error("memory", "none left");
}

/* ---- progress ---- */

/* About milliseconds of a slow machine. A sample of a ray is some 8 ns; others take about as long
 * as their repetitions for the median, and grow with the scene, the wedges most. */
static double entry_units(const struct cli_options *options, size_t triangles, const char *name,
                          int samples)
{
    double pixels = (double)options->width * options->height;
    double growth = 1 + (double)triangles / (strncmp(name, "wedge", 5) == 0 ? 2e3 : 5e4);
    return strcmp(name, "reference") == 0 ? pixels * samples * 8e-6
                                          : (150 + pixels * 1e-3) * growth;
}

/* Left out for the number of triangles. */
static bool too_many(const struct cli_choice *choice, size_t triangles)
{
    return choice->most_triangles && triangles > choice->most_triangles;
}

static double choice_units(const struct cli_options *options, size_t triangles,
                           const struct cli_choice *choice)
{
    return too_many(choice, triangles) ? 0
                                       : entry_units(options, triangles, choice->method,
                                                     choice->samples ? choice->samples : 1024);
}

double compare_scene_units(const struct cli_options *options, int truth_samples, size_t triangles)
{
    double units = entry_units(options, triangles, "reference", truth_samples);
    for (size_t i = 0; i < options->choice_count; i++)
        units += choice_units(options, triangles, &options->choices[i]);
    if (options->choice_count == 0)
        units += entry_units(options, triangles, "reference", 1360) +
                 entry_units(options, triangles, "", 0) * (double)pnb_method_count();
    return units;
}

static void step(struct bench *bench, const char *what, double units)
{
    char text[64];
    snprintf(text, sizeof(text), "%.30s: %.28s", report_scene_name(bench->result), what);
    if (bench->session->bar.total > 0)
        cli_session_step(bench->session, text, units);
}

/* ---- pictures ---- */

static int encode_picture(struct bench *bench, const float *rgb, struct compare_png *png)
{
    pnb_image image = {bench->result->width, bench->result->height, 3, (float *)rgb};
    if (pnb_image_encode_png(bench->session->context, &image, true, &png->bytes, &png->size) !=
        PNB_OK)
        return cli_session_fail(bench->session);
    return CLI_GO_ON;
}

/* Grey as light would look, in codes from 1; 0, a dull blue, where there is no figure, so that it
 * is not taken for umbra. png: malloc()ed. */
static int encode_visibility(struct bench *bench, const float *visibility, struct compare_png *png)
{
    pnb_context *context = bench->session->context;
    uint8_t colors[256][3] = {{64, 80, 96}}, *grey;
    size_t size;
    pnb_image image;
    for (int code = 1; code < 256; code++)
        memset(colors[code], (int)((code - 1) * 255.0 / 254 + 0.5), 3);
    if (pnb_image_create(context, bench->result->width, bench->result->height, 1, &image) != PNB_OK)
        return cli_session_fail(bench->session);
    for (size_t i = 0; i < bench->pixels; i++)
        image.data[i] = isnan(visibility[i])
                            ? 0
                            : (float)((1 + floor(compare_srgb(visibility[i]) * 254 + 0.5)) / 255);
    pnb_status status = pnb_image_encode_png(context, &image, false, &grey, &size);
    pnb_image_finish(context, &image);
    if (status != PNB_OK)
        return cli_session_fail(bench->session);
    bool good = compare_png_palette(grey, size, colors, png);
    pnb_bytes_free(context, grey);
    return good ? CLI_GO_ON : no_memory();
}

/* The picture with this visibility of the compared light, into bench->rgb. */
static int shade(struct bench *bench, const float *visibility)
{
    size_t index = bench->result->light_index;
    float *kept = bench->visibilities[index];
    bench->visibilities[index] = (float *)visibility;
    pnb_status status =
        pnb_surface_shade(bench->surface, (const float *const *)bench->visibilities, bench->rgb);
    bench->visibilities[index] = kept;
    return status == PNB_OK ? CLI_GO_ON : cli_session_fail(bench->session);
}

/* ---- solving ---- */

static int solve_truth(struct bench *bench, int samples)
{
    struct cli_session *session = bench->session;
    struct compare_scene *result = bench->result;
    /* Another scramble than the method's default. */
    const pnb_method_info *reference = pnb_method_find("reference");
    pnb_solver_param seed = {"seed", "9001"};
    bool seeded = false;
    for (size_t i = 0; reference && i < reference->param_count; i++)
        seeded |= strcmp(reference->params[i].key, "seed") == 0;

    for (size_t i = 0; i < result->light_count; i++) {
        bool compared = i == result->light_index;
        pnb_solver_desc desc = {
            .method = "reference",
            .samples = compared || samples < OTHER_SAMPLES_MAX ? samples : OTHER_SAMPLES_MAX,
            .params = &seed,
            .param_count = seeded};
        pnb_solver *solver = NULL;
        pnb_light light;
        pnb_scene_light(bench->scene, i, &light);
        bench->visibilities[i] = malloc(bench->pixels * sizeof(float));
        if (!bench->visibilities[i])
            return no_memory();
        pnb_status status = pnb_solver_create(session->context, bench->scene, &desc, &solver);
        if (status == PNB_OK)
            status =
                pnb_solver_visibility(solver, &light, &bench->receivers, bench->visibilities[i]);
        if (status == PNB_OK && compared) {
            pnb_solver_report report;
            pnb_solver_get_report(solver, &report);
            result->truth_ms = report.visibility_ms;
            result->truth_samples = report.samples;
        }
        pnb_solver_destroy(solver);
        if (status != PNB_OK)
            return cli_session_fail(session);
    }
    bench->truth = bench->visibilities[result->light_index];

    pnb_measure_facing(&bench->light, &bench->receivers, bench->mask);
    for (size_t i = 0; i < bench->pixels; i++) {
        float t = bench->truth[i];
        result->surface_pixels += !isnan(bench->receivers.positions[3 * i]);
        if (!bench->mask[i] || isnan(t))
            continue;
        result->facing_pixels++;
        result->umbra_pixels += t == 0;
        result->lit_pixels += t == 1;
        result->penumbra_pixels += t > 0 && t < 1;
    }
    int done = shade(bench, bench->truth);
    if (done == CLI_GO_ON) {
        memcpy(bench->truth_rgb, bench->rgb, bench->pixels * 3 * sizeof(float));
        done = encode_picture(bench, bench->rgb, &result->truth_picture);
    }
    return done == CLI_GO_ON ? encode_visibility(bench, bench->truth, &result->truth_visibility)
                             : done;
}

/* Figures and error per pixel of a visibility. */
static int judge(struct bench *bench, struct compare_entry *entry, const float *visibility)
{
    entry->error = malloc(bench->pixels * sizeof(float));
    if (!entry->error)
        return no_memory();
    if (pnb_measure(bench->session->context, visibility, bench->truth, bench->mask, bench->pixels,
                    &entry->errors) != PNB_OK)
        return cli_session_fail(bench->session);
    for (size_t i = 0; i < bench->pixels; i++)
        entry->error[i] = bench->mask[i] ? visibility[i] - bench->truth[i] : NAN;
    if (entry->errors.pixels == 0)
        add_text(&entry->warnings, &entry->warning_count,
                 "not one pixel could be compared: all are NaN or turned away from the light");
    return CLI_GO_ON;
}

static void keep_report(struct compare_entry *entry, const pnb_solver_report *report)
{
    char processor[256];
    entry->samples = report->samples;
    entry->prepare_ms = report->prepare_ms;
    snprintf(entry->device, sizeof(entry->device), "%s",
             cli_device(report, processor, sizeof(processor)));
    for (size_t i = 0; i < report->warning_count; i++)
        add_text(&entry->warnings, &entry->warning_count, report->warnings[i]);
    size_t used = 0;
    for (size_t i = 0; i < report->counter_count && used + 1 < sizeof(entry->counters); i++) {
        double value = report->counters[i].value;
        int n = snprintf(entry->counters + used, sizeof(entry->counters) - used,
                         value == floor(value) ? "%s%s %.15g" : "%s%s %.4g", i ? ", " : "",
                         report->counters[i].name, value);
        used = used + (size_t)n < sizeof(entry->counters) ? used + (size_t)n
                                                          : sizeof(entry->counters) - 1;
    }
}

static void free_entry(pnb_context *context, struct compare_entry *entry)
{
    free(entry->error);
    free(entry->params);
    pnb_bytes_free(context, entry->picture.bytes);
    free(entry->visibility.bytes);
    free(entry->error_map.bytes);
    free_texts(entry->warnings, entry->warning_count);
}

/* Nothing was chosen: all methods, and a series of the reference instead of its one default. */
static bool chooses_freely(const struct cli_options *options)
{
    return options->choice_count == 0 && options->image_count == 0;
}

/* Methods that cannot do the scene are then left out. */
static bool compares_all(const struct cli_options *options)
{
    return chooses_freely(options) || options->all_methods;
}

/* Several scenes go on without a method that cannot do one of them, and a choice of all methods
 * without those that cannot; else it is an error. */
static bool tolerates(const struct bench *bench, pnb_status status)
{
    return (compares_all(bench->options) || bench->result->one_of_several) &&
           (status == PNB_ERROR_UNSUPPORTED || status == PNB_ERROR_DEVICE);
}

static void remove_entry(struct bench *bench, size_t index, const char *note)
{
    struct compare_scene *result = bench->result;
    struct compare_entry *entry = &result->entries[index];
    add_text(&result->notes, &result->note_count, note);
    free_entry(bench->session->context, entry);
    result->entry_count--;
    memmove(entry, entry + 1, (result->entry_count - index) * sizeof(*entry));
}

/* With the reason that the context has. A method that was asked for by name is worth a warning. */
static void leave_out(struct bench *bench, size_t index)
{
    struct compare_scene *result = bench->result;
    struct compare_entry *entry = &result->entries[index];
    char note[1600];
    snprintf(note, sizeof(note), "%s is left out: %s", entry->label,
             pnb_context_error(bench->session->context));
    remove_entry(bench, index, note);
    if (!compares_all(bench->options)) {
        snprintf(note, sizeof(note), "%s: %s", result->path, result->notes[result->note_count - 1]);
        cli_session_warn(bench->session, note);
    }
}

pnb_status compare_entry_solver(pnb_context *context, pnb_scene *scene,
                                const struct compare_entry *entry, pnb_solver **out_solver)
{
    pnb_solver_desc desc = {.method = entry->name,
                            .samples = entry->samples,
                            .params = entry->params,
                            .param_count = entry->param_count};
    return pnb_solver_create(context, scene, &desc, out_solver);
}

/* Before any long work: each method makes its solver and a frame without receivers. Those that
 * cannot are left out, or end the comparison. */
static int check_methods(struct bench *bench)
{
    struct compare_scene *result = bench->result;
    for (size_t i = 0; i < result->entry_count;) {
        const struct compare_entry *entry = &result->entries[i];
        pnb_solver *solver = NULL;
        pnb_status status = PNB_OK;
        if (entry->method)
            status = compare_entry_solver(bench->session->context, bench->scene, entry, &solver);
        if (solver)
            status = pnb_solver_visibility(solver, &bench->light, &(pnb_receivers){0}, NULL);
        pnb_solver_destroy(solver);
        if (status == PNB_OK)
            i++;
        else if (tolerates(bench, status))
            leave_out(bench, i);
        else
            return cli_session_fail(bench->session);
    }
    return CLI_GO_ON;
}

/* Whether any occluder has a border: of such, every edge is an outline. The edges are there since
 * the first method wanted them. */
static int find_open(struct bench *bench)
{
    for (size_t i = 0; i < pnb_scene_object_count(bench->scene); i++) {
        pnb_object object;
        pnb_mesh_info info;
        pnb_scene_object(bench->scene, i, &object);
        if (!object.casts || object.plane)
            continue;
        if (pnb_scene_mesh_info(bench->scene, object.mesh, &info) != PNB_OK)
            return cli_session_fail(bench->session);
        bench->result->open |= !info.closed;
    }
    return CLI_GO_ON;
}

/* What would take long here, and says little. */
static int too_dear(struct bench *bench, size_t index, bool *left_out)
{
    struct compare_scene *result = bench->result;
    const struct compare_entry *entry = &result->entries[index];
    const struct cli_choice *choice = entry->choice;
    int done = choice && choice->closed_only ? find_open(bench) : CLI_GO_ON;
    *left_out =
        choice && choice->most_triangles &&
        (result->triangle_count > choice->most_triangles || (choice->closed_only && result->open));
    if (*left_out && done == CLI_GO_ON) {
        char note[400];
        snprintf(note, sizeof(note), "%s is left out: %s", entry->label, choice->why);
        remove_entry(bench, index, note);
    }
    return done;
}

/* *left_out: the method cannot do it after all; entry is then the next one. */
static int run_method(struct bench *bench, struct compare_entry *entry, bool *left_out)
{
    struct cli_session *session = bench->session;
    pnb_solver *solver = NULL;
    pnb_solver_report report;
    pnb_status status = compare_entry_solver(bench->session->context, bench->scene, entry, &solver);
    if (status == PNB_OK)
        status = cli_solve(session, solver, &bench->light, &bench->receivers, true,
                           bench->visibility, &report, &entry->processor_ms);
    if (status == PNB_OK) {
        entry->milliseconds = report.visibility_ms;
        keep_report(entry, &report);
    }
    pnb_solver_destroy(solver);
    *left_out = tolerates(bench, status);
    if (*left_out) {
        leave_out(bench, (size_t)(entry - bench->result->entries));
        return CLI_GO_ON;
    }
    if (status != PNB_OK)
        return cli_session_fail(session);
    int result = judge(bench, entry, bench->visibility);
    if (entry->figures_only)
        return result;
    if (result == CLI_GO_ON)
        result = encode_visibility(bench, bench->visibility, &entry->visibility);
    if (result == CLI_GO_ON)
        result = shade(bench, bench->visibility);
    return result == CLI_GO_ON ? encode_picture(bench, bench->rgb, &entry->picture) : result;
}

static double luminance(const float *rgb)
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* A picture has no visibility: its error in luminance is added to the true visibility, and that is
 * measured. So umbra, lit and penumbra are those of the truth, and 1/255 is a step of luminance. */
static int judge_picture(struct bench *bench, struct compare_entry *entry, const pnb_image *image)
{
    double ours = 0, both = 0;
    bool clipped = cli_has_ending(entry->name, ".png"); /* holds nothing brighter than white */
    for (size_t i = 0; i < bench->pixels; i++) {
        float truth[3];
        for (int k = 0; k < 3; k++) {
            truth[k] = bench->truth_rgb[3 * i + (size_t)k];
            if (clipped)
                truth[k] = fminf(fmaxf(truth[k], 0), 1);
        }
        double y = luminance(image->data + 3 * i), t = luminance(truth);
        bench->visibility[i] = (float)(bench->truth[i] + (y - t));
        if (bench->mask[i] && isfinite(y)) {
            ours += t * t;
            both += t * y;
        }
    }
    double gain = ours > 0 ? both / ours : 1;
    if (fabs(gain - 1) > 0.02) {
        char text[200];
        snprintf(text, sizeof(text),
                 "the picture is %.3g times as bright as the truth on the whole; the figures "
                 "contain that",
                 gain);
        add_text(&entry->warnings, &entry->warning_count, text);
    }
    int result = judge(bench, entry, bench->visibility);
    return result == CLI_GO_ON ? encode_picture(bench, image->data, &entry->picture) : result;
}

static int run_image(struct bench *bench, struct compare_entry *entry, const pnb_image *image)
{
    entry->milliseconds = entry->prepare_ms = entry->processor_ms = NAN;
    entry->picture_only = image->channels == 3;
    if (entry->picture_only)
        return judge_picture(bench, entry, image);
    int result = judge(bench, entry, image->data);
    if (result == CLI_GO_ON)
        result = encode_visibility(bench, image->data, &entry->visibility);
    if (result == CLI_GO_ON)
        result = shade(bench, image->data);
    return result == CLI_GO_ON ? encode_picture(bench, bench->rgb, &entry->picture) : result;
}

/* ---- what is compared ---- */

/* The parameters of the choice, and of -p those that the method has and the choice does not set. */
static bool take_params(struct compare_entry *entry, const struct cli_choice *choice,
                        const struct cli_options *options)
{
    entry->params = calloc(choice->param_count + options->param_count + 1, sizeof(*entry->params));
    if (!entry->params)
        return false;
    for (size_t i = 0; i < choice->param_count; i++)
        entry->params[entry->param_count++] = choice->params[i];
    for (size_t p = 0; p < options->param_count; p++) {
        const char *key = options->params[p].key;
        bool known = false, own = false;
        for (size_t i = 0; i < entry->method->param_count; i++)
            known |= strcmp(key, entry->method->params[i].key) == 0;
        for (size_t i = 0; i < choice->param_count; i++)
            own |= strcmp(key, choice->params[i].key) == 0;
        if (known && !own)
            entry->params[entry->param_count++] = options->params[p];
    }
    return true;
}

static bool add_entry(struct compare_scene *scene, const struct cli_choice *choice,
                      const struct cli_options *options)
{
    struct compare_entry *entry = &scene->entries[scene->entry_count++];
    const pnb_method_info *method = pnb_method_find(choice->method);
    entry->method = method;
    entry->name = method->name;
    entry->figures_only = choice->figures_only;
    if (method->samples)
        entry->samples = choice->samples    ? choice->samples
                         : options->samples ? options->samples
                                            : method->default_samples;
    snprintf(entry->label, sizeof(entry->label), "%s", choice->label);
    return take_params(entry, choice, options);
}

/* Without --methods: all of them, and a series of the reference instead of its one default. */
static bool add_defaults(struct compare_scene *scene, const struct cli_options *options)
{
    static const int series[] = {16, 64, 256, 1024};
    bool good = true;
    for (size_t i = 0; i < pnb_method_count() && good; i++) {
        struct cli_choice choice = {.method = pnb_method(i)->name};
        snprintf(choice.label, sizeof(choice.label), "%s", choice.method);
        if (strcmp(choice.method, "reference") != 0 || options->samples) {
            good = add_entry(scene, &choice, options);
            continue;
        }
        for (int k = 0; k < 4 && good; k++) {
            choice.samples = series[k];
            snprintf(choice.label, sizeof(choice.label), "%s:%d", choice.method, series[k]);
            good = add_entry(scene, &choice, options);
        }
    }
    return good;
}

static int choose_entries(struct bench *bench)
{
    struct compare_scene *result = bench->result;
    const struct cli_options *options = bench->options;
    size_t most = options->choice_count + pnb_method_count() + 4 + options->image_count;
    result->entries = calloc(most, sizeof(*result->entries));
    bool good = result->entries != NULL;
    if (good && chooses_freely(options))
        good = add_defaults(result, options);
    for (size_t i = 0; i < options->choice_count && good; i++) {
        good = add_entry(result, &options->choices[i], options);
        result->entries[result->entry_count - 1].choice = &options->choices[i];
    }
    if (!good)
        return no_memory();
    for (size_t i = 0; i < options->image_count; i++) {
        struct compare_entry *entry = &result->entries[result->entry_count++];
        const char *slash = strrchr(options->images[i], '/');
        entry->name = options->images[i];
        snprintf(entry->label, sizeof(entry->label), "%.120s", slash ? slash + 1 : entry->name);
        for (size_t k = 0; k + 1 < result->entry_count; k++)
            if (strcmp(result->entries[k].label, entry->label) == 0)
                snprintf(entry->label, sizeof(entry->label), "%.100s (%zu)",
                         slash ? slash + 1 : entry->name, i + 1);
    }
    return CLI_GO_ON;
}

/* The least round number that 99 % of every entry's penumbra stays within, so that colours can be
 * compared across maps; at most a half, lest one bad method hides all others. */
static double common_scale(const struct compare_scene *scene)
{
    static const double round[] = {0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5};
    const size_t count = sizeof(round) / sizeof(round[0]);
    double largest = 0;
    for (size_t i = 0; i < scene->entry_count; i++)
        if (!scene->entries[i].figures_only)
            largest = fmax(largest, scene->entries[i].errors.p99_error);
    for (size_t k = 0; k < count; k++)
        if (largest <= round[k])
            return round[k];
    return round[count - 1];
}

/* Codes with fine steps near 0, where good methods differ (0.00006 there, 0.016 at the ends), and a
 * palette that colours them. */
static int draw_error_map(struct bench *bench, struct compare_entry *entry,
                          const uint8_t (*colors)[3])
{
    const struct compare_scene *scene = bench->result;
    pnb_context *context = bench->session->context;
    pnb_image codes;
    if (pnb_image_create(context, scene->width, scene->height, 1, &codes) != PNB_OK)
        return cli_session_fail(bench->session);
    for (size_t i = 0; i < bench->pixels; i++) {
        double size = fmin(fabs(entry->error[i]), 1);
        codes.data[i] =
            isnan(entry->error[i])
                ? 0
                : (float)((128 + round(copysign(127 * sqrt(size), entry->error[i]))) / 255);
    }
    uint8_t *grey;
    size_t size;
    pnb_status status = pnb_image_encode_png(context, &codes, false, &grey, &size);
    pnb_image_finish(context, &codes);
    if (status != PNB_OK)
        return cli_session_fail(bench->session);
    bool good = compare_png_palette(grey, size, colors, &entry->error_map);
    pnb_bytes_free(context, grey);
    return good ? CLI_GO_ON : no_memory();
}

static int draw_error_maps(struct bench *bench)
{
    struct compare_scene *result = bench->result;
    uint8_t colors[256][3];
    int done = CLI_GO_ON;
    result->error_scale = common_scale(result);
    compare_error_colors(result->error_scale, colors);
    for (size_t i = 0; i < result->entry_count && done == CLI_GO_ON; i++)
        if (!result->entries[i].figures_only)
            done = draw_error_map(bench, &result->entries[i], colors);
    return done;
}

/* The scene, its light, what is compared. */
static int load(struct bench *bench)
{
    const struct cli_options *options = bench->options;
    struct compare_scene *result = bench->result;
    int done = CLI_GO_ON;
    if (result->given)
        bench->scene = result->given;
    else
        done = cli_scene_load(bench->session, result->path, &bench->scene);
    if (done != CLI_GO_ON)
        return done;
    result->width = options->width, result->height = options->height;
    result->light_index = options->light_index;
    result->light_count = pnb_scene_light_count(bench->scene);
    result->triangle_count = pnb_scene_triangle_count(bench->scene);
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_builtin(i, &info);
        if (strncmp(result->path, "builtin:", 8) == 0 && strcmp(result->path + 8, info.name) == 0)
            result->title = info.title;
    }
    bench->pixels = (size_t)result->width * (size_t)result->height;
    if (result->light_count == 0)
        return cli_error(result->path, "has no light, so there is nothing to compare");
    pnb_scene_light(bench->scene, result->light_index, &bench->light);
    result->light_type = pnb_light_type_name(bench->light.type);
    done = choose_entries(bench);
    /* A choice of all needs no check: who cannot is left out when it is his turn. */
    return done == CLI_GO_ON && !compares_all(options) ? check_methods(bench) : done;
}

static int run_scene(struct bench *bench, int truth_samples)
{
    struct compare_scene *result = bench->result;
    struct cli_session *session = bench->session;
    int done = load(bench);
    if (done != CLI_GO_ON)
        return done;

    if (pnb_surface_create(session->context, bench->scene, NULL, result->width, result->height,
                           &bench->surface) != PNB_OK)
        return cli_session_fail(session);
    pnb_surface_receivers(bench->surface, &bench->receivers);
    pnb_surface_view view;
    pnb_surface_get(bench->surface, &view);
    result->primary_ms = view.primary_ms;
    bench->mask = malloc(bench->pixels);
    bench->visibilities = calloc(result->light_count, sizeof(*bench->visibilities));
    bench->visibility = malloc(bench->pixels * sizeof(float));
    bench->rgb = malloc(bench->pixels * 3 * sizeof(float));
    bench->truth_rgb = malloc(bench->pixels * 3 * sizeof(float));
    if (!bench->mask || !bench->visibilities || !bench->visibility || !bench->rgb ||
        !bench->truth_rgb)
        return no_memory();

    step(bench, "truth",
         entry_units(bench->options, result->planned_triangles, "reference", truth_samples));
    done = solve_truth(bench, truth_samples);
    size_t image = 0;
    for (size_t i = 0; i < result->entry_count && done == CLI_GO_ON;) {
        struct compare_entry *entry = &result->entries[i];
        bool left_out = false;
        step(bench, entry->label,
             entry->choice ? choice_units(bench->options, result->planned_triangles, entry->choice)
                           : entry_units(bench->options, result->planned_triangles, entry->name,
                                         entry->samples));
        done = too_dear(bench, i, &left_out);
        if (done == CLI_GO_ON && !left_out)
            done = entry->method ? run_method(bench, entry, &left_out)
                                 : run_image(bench, entry, &bench->images[image++]);
        if (done == CLI_GO_ON && cli_session_stopped())
            done = cli_error("compare", "cancelled");
        i += !left_out;
    }
    if (done == CLI_GO_ON)
        done = find_open(bench);
    return done == CLI_GO_ON ? draw_error_maps(bench) : done;
}

static void finish_bench(struct bench *bench)
{
    for (size_t i = 0; bench->visibilities && i < bench->result->light_count; i++)
        free(bench->visibilities[i]);
    free(bench->visibilities);
    free(bench->visibility);
    free(bench->rgb);
    free(bench->truth_rgb);
    free(bench->mask);
    pnb_surface_destroy(bench->surface);
    if (!bench->result->given)
        pnb_scene_destroy(bench->scene);
}

void compare_scene_drop_pictures(pnb_context *context, struct compare_scene *scene)
{
    for (size_t i = 0; i < scene->entry_count; i++) {
        struct compare_entry *entry = &scene->entries[i];
        free(entry->error);
        free(entry->error_map.bytes);
        pnb_bytes_free(context, entry->picture.bytes);
        free(entry->visibility.bytes);
        entry->error = NULL;
        entry->picture = entry->visibility = entry->error_map = (struct compare_png){0};
    }
    pnb_bytes_free(context, scene->truth_picture.bytes);
    free(scene->truth_visibility.bytes);
    scene->truth_picture = scene->truth_visibility = (struct compare_png){0};
}

void compare_scene_finish(pnb_context *context, struct compare_scene *scene)
{
    for (size_t i = 0; i < scene->entry_count; i++)
        free_entry(context, &scene->entries[i]);
    free(scene->entries);
    pnb_bytes_free(context, scene->truth_picture.bytes);
    free(scene->truth_visibility.bytes);
    free_texts(scene->notes, scene->note_count);
}

static struct bench make_bench(struct cli_session *session, const pnb_image *images,
                               struct compare_scene *scene)
{
    return (struct bench){.session = session,
                          .options = scene->options ? scene->options : session->options,
                          .images = images,
                          .result = scene};
}

int compare_scene_run(struct cli_session *session, const pnb_image *images, int truth_samples,
                      struct compare_scene *scene)
{
    struct bench bench = make_bench(session, images, scene);
    const struct cli_options *kept = session->options;
    session->options = bench.options;
    int result = run_scene(&bench, truth_samples);
    session->options = kept;
    finish_bench(&bench);
    return result;
}

int compare_scene_check(struct cli_session *session, struct compare_scene *scene)
{
    struct bench bench = make_bench(session, NULL, scene);
    int result = load(&bench);
    finish_bench(&bench);
    return result;
}
