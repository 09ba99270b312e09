/* cli/compare_curves.c: how cost and error grow with triangles, with the light, with the picture.
 *
 * The scenes are made of those of builtin:spheres-9x9: the first k of its 81 spheres of 762
 * triangles, from the middle outwards, under its own rectangular light, or that light scaled. So is
 * the series of figure 12 of Forest, Barthe, Paulin (2006).
 */
#include "compare_curves.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 320, HEIGHT = 240, SPHERES = 9, TRUTH_SAMPLES = 512, NO_TRUTH = 1 };

static const int sphere_counts[] = {1, 4, 9, 23, 49, 81};
static const double light_scales[] = {0.125, 0.25, 0.5, 1, 2, 4};
static const int widths[] = {160, 320, 640, 960};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

static int no_memory(void)
{
    return cli_error("memory", "none left");
}

/* ---- scenes ---- */

struct ranked {
    size_t object;
    double away;
};

static int by_distance(const void *a, const void *b)
{
    const struct ranked *p = a, *q = b;
    if (p->away != q->away)
        return p->away < q->away ? -1 : 1;
    return (p->object > q->object) - (p->object < q->object);
}

static pnb_status copy_object(pnb_scene *from, pnb_scene *to, size_t index)
{
    pnb_object object;
    pnb_mesh_desc mesh;
    pnb_scene_object(from, index, &object);
    pnb_scene_mesh(from, object.mesh, &mesh);
    pnb_status status = pnb_scene_add_mesh(to, &mesh, &object.mesh);
    return status == PNB_OK ? pnb_scene_add_object(to, &object, NULL) : status;
}

/* The ground, and the spheres nearest to the middle. */
static pnb_status copy_objects(pnb_scene *from, pnb_scene *to, int spheres)
{
    size_t count = pnb_scene_object_count(from), casting = 0;
    struct ranked *ranked = calloc(count + 1, sizeof(*ranked));
    pnb_status status = ranked ? PNB_OK : PNB_ERROR_MEMORY;
    for (size_t i = 0; i < count && status == PNB_OK; i++) {
        pnb_object object;
        pnb_scene_object(from, i, &object);
        const double *m = object.world_from_mesh;
        if (object.plane)
            status = copy_object(from, to, i);
        else
            ranked[casting++] = (struct ranked){i, m[3] * m[3] + m[11] * m[11]};
    }
    if (ranked)
        qsort(ranked, casting, sizeof(*ranked), by_distance);
    for (size_t i = 0; i < casting && i < (size_t)spheres && status == PNB_OK; i++)
        status = copy_object(from, to, ranked[i].object);
    free(ranked);
    return status;
}

static int make_scene(struct cli_session *session, int spheres, double scale, pnb_scene **out,
                      double *light_size)
{
    pnb_scene *from = NULL, *to = NULL;
    pnb_camera camera;
    pnb_light light;
    pnb_status status = pnb_scene_load(session->context, "builtin:spheres-9x9", &from);
    if (status == PNB_OK)
        status = pnb_scene_create(session->context, &to);
    if (status == PNB_OK)
        status = copy_objects(from, to, spheres);
    if (status == PNB_OK) {
        pnb_scene_camera(from, &camera);
        status = pnb_scene_set_camera(to, &camera);
    }
    if (status == PNB_OK) {
        pnb_scene_light(from, 0, &light);
        double *sides[2] = {light.shape.rectangle.half_u, light.shape.rectangle.half_v};
        *light_size = 0;
        for (int a = 0; a < 3; a++) {
            sides[0][a] *= scale;
            sides[1][a] *= scale;
            *light_size += sides[0][a] * sides[0][a];
        }
        *light_size = 2 * sqrt(*light_size);
        status = pnb_scene_add_light(to, &light, NULL);
    }
    pnb_scene_destroy(from);
    if (status == PNB_OK) {
        *out = to;
        return CLI_GO_ON;
    }
    pnb_scene_destroy(to);
    return cli_session_fail(session);
}

/* ---- measuring ---- */

static bool begin_curve(struct compare_curve *curve, const struct cli_options *options,
                        size_t count)
{
    curve->x = calloc(count, sizeof(double));
    curve->tracks = calloc(options->choice_count, sizeof(*curve->tracks));
    if (!curve->x || !curve->tracks)
        return false;
    curve->count = count;
    curve->track_count = options->choice_count;
    for (size_t i = 0; i < options->choice_count; i++) {
        struct compare_track *track = &curve->tracks[i];
        snprintf(track->label, sizeof(track->label), "%s", options->choices[i].label);
        track->method = pnb_method_find(options->choices[i].method);
        track->ms = calloc(count, sizeof(double));
        track->rmse = calloc(count, sizeof(double));
        if (!track->ms || !track->rmse)
            return false;
        for (size_t k = 0; k < count; k++)
            track->ms[k] = track->rmse[k] = NAN;
    }
    return true;
}

/* One point of the curve: every entry on the scene. */
static int measure(struct cli_session *session, struct cli_options *options,
                   struct compare_curve *curve, size_t at, int spheres, double scale, int width)
{
    pnb_scene *made;
    double light_size;
    int result = make_scene(session, spheres, scale, &made, &light_size);
    if (result != CLI_GO_ON)
        return result;
    char name[64];
    snprintf(name, sizeof(name), "%s %zu/%zu", curve->key, at + 1, curve->count);
    struct compare_scene scene = {.path = name, .given = made, .options = options};
    options->width = width, options->height = width * HEIGHT / WIDTH;
    options->size_given = true;
    result = compare_scene_run(session, NULL, curve->errors ? TRUTH_SAMPLES : NO_TRUTH, &scene);
    curve->x[at] = curve->key[0] == 't'   ? (double)scene.triangle_count
                   : curve->key[0] == 'l' ? light_size
                                          : (double)width * options->height;
    for (size_t i = 0; i < scene.entry_count && result == CLI_GO_ON; i++)
        for (size_t k = 0; k < curve->track_count; k++)
            if (strcmp(curve->tracks[k].label, scene.entries[i].label) == 0) {
                curve->tracks[k].ms[at] = scene.entries[i].milliseconds;
                curve->tracks[k].rmse[at] = scene.entries[i].errors.rmse;
            }
    compare_scene_finish(session->context, &scene);
    pnb_scene_destroy(made);
    return result;
}

double compare_curves_units(void)
{
    struct cli_options options = {.width = WIDTH, .height = HEIGHT};
    size_t points = COUNT(sphere_counts) + COUNT(light_scales) + COUNT(widths);
    return (double)points * compare_scene_units(&options, TRUTH_SAMPLES, 0);
}

int compare_curves_run(struct cli_session *session, struct compare_curves *curves)
{
    struct cli_options options = {.command = session->options->command,
                                  .threads = session->options->threads,
                                  .all_methods = true};
    struct compare_curve *triangles = &curves->curves[0], *light = &curves->curves[1],
                         *pixels = &curves->curves[2];
    *triangles = (struct compare_curve){.key = "triangles",
                                        .title = "triangles",
                                        .x_title = "triangles of the scene",
                                        .errors = true};
    *light = (struct compare_curve){.key = "light-size",
                                    .title = "light size",
                                    .x_title = "side of the light, m",
                                    .errors = true};
    *pixels = (struct compare_curve){
        .key = "pixels", .title = "pixels", .x_title = "pixels of the picture"};
    snprintf(triangles->note, sizeof(triangles->note),
             "1 to 81 spheres of 762 triangles (builtin:spheres-9x9), %d x %d", WIDTH, HEIGHT);
    snprintf(light->note, sizeof(light->note), "%d spheres, %d x %d", SPHERES, WIDTH, HEIGHT);
    snprintf(pixels->note, sizeof(pixels->note), "%d spheres", SPHERES);

    int result = CLI_GO_ON;
    bool good = true;
    for (size_t i = 0; i < pnb_method_count() && good; i++)
        good = cli_add_methods(&options, strcmp(pnb_method(i)->name, "reference") == 0
                                             ? "reference:64"
                                             : pnb_method(i)->name);
    for (size_t i = 0; i < options.choice_count; i++)
        options.choices[i].figures_only = true;
    good = good && begin_curve(triangles, &options, COUNT(sphere_counts)) &&
           begin_curve(light, &options, COUNT(light_scales)) &&
           begin_curve(pixels, &options, COUNT(widths));
    if (!good)
        result = no_memory();
    for (size_t i = 0; i < COUNT(sphere_counts) && result == CLI_GO_ON; i++)
        result = measure(session, &options, triangles, i, sphere_counts[i], 1, WIDTH);
    for (size_t i = 0; i < COUNT(light_scales) && result == CLI_GO_ON; i++)
        result = measure(session, &options, light, i, SPHERES, light_scales[i], WIDTH);
    for (size_t i = 0; i < COUNT(widths) && result == CLI_GO_ON; i++)
        result = measure(session, &options, pixels, i, SPHERES, 1, widths[i]);
    cli_options_finish(&options);
    return result;
}

void compare_curves_finish(struct compare_curves *curves)
{
    for (int c = 0; c < COMPARE_CURVES; c++) {
        struct compare_curve *curve = &curves->curves[c];
        for (size_t i = 0; i < curve->track_count; i++) {
            free(curve->tracks[i].ms);
            free(curve->tracks[i].rmse);
        }
        free(curve->tracks);
        free(curve->x);
    }
}

/* ---- what comes out ---- */

json_t *report_json_curves(const struct compare_curves *curves)
{
    json_t *all = json_array();
    for (int c = 0; c < COMPARE_CURVES; c++) {
        const struct compare_curve *curve = &curves->curves[c];
        json_t *object = json_object(), *xs = json_array(), *methods = json_array();
        for (size_t k = 0; k < curve->count; k++)
            json_array_append_new(xs, cli_json_number(curve->x[k]));
        for (size_t i = 0; i < curve->track_count; i++) {
            json_t *track = json_object(), *ms = json_array(), *rmse = json_array();
            for (size_t k = 0; k < curve->count; k++) {
                json_array_append_new(ms, cli_json_number(curve->tracks[i].ms[k]));
                json_array_append_new(rmse, cli_json_number(curve->tracks[i].rmse[k]));
            }
            json_object_set_new(track, "label", cli_json_text(curve->tracks[i].label));
            json_object_set_new(track, "milliseconds", ms);
            if (curve->errors)
                json_object_set_new(track, "rmse", rmse);
            else
                json_decref(rmse);
            json_array_append_new(methods, track);
        }
        json_object_set_new(object, "over", json_string(curve->key));
        json_object_set_new(object, "note", json_string(curve->note));
        json_object_set_new(object, "x", xs);
        json_object_set_new(object, "methods", methods);
        json_array_append_new(all, object);
    }
    return all;
}

static void put_plot(FILE *page, const struct compare_curve *curve, bool errors)
{
    struct report_curve *lines = calloc(curve->track_count + 1, sizeof(*lines));
    for (size_t i = 0; lines && i < curve->track_count; i++)
        lines[i] = (struct report_curve){.label = curve->tracks[i].label,
                                         .color = report_color(curve->tracks[i].method),
                                         .x = curve->x,
                                         .y = errors ? curve->tracks[i].rmse : curve->tracks[i].ms,
                                         .count = curve->count};
    fprintf(page, "<div><p class=\"panel-title\">%s over %s<span>%s</span></p>",
            errors ? "Error" : "Time", curve->title, curve->note);
    if (lines)
        report_plot_curves(page, lines, curve->track_count, curve->x_title,
                           errors ? "RMSE in the penumbra" : "visibility of one frame, ms");
    fprintf(page, "</div>\n");
    free(lines);
}

void report_html_curves(FILE *page, const struct compare_curves *curves)
{
    fprintf(page,
            "<section id=\"cost\">\n<h2>Cost</h2>\n<p>Every method at its defaults, the "
            "reference with 64 samples. Both axes are logarithmic.</p>\n<div class=\"pair\">");
    for (int c = 0; c < COMPARE_CURVES; c++) {
        put_plot(page, &curves->curves[c], false);
        if (curves->curves[c].errors)
            put_plot(page, &curves->curves[c], true);
    }
    fprintf(page, "</div>\n</section>\n");
}
