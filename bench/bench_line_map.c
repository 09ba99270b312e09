/* bench/bench_line_map.c: 'penumbra bench line-map': what soft shadow maps for linear lights give
 * and cost.
 *
 *   errors   RMSE over the penumbra and time on every built-in scene with a linear light: line-map
 *            and sampled-maps with k = 2, 3, 5 maps, the ray tracer with 10 samples, samples=auto
 *   edges    the area lights that are taken by their edges
 *   fixed    a frame with maps at hand: look-up with channels over plain look-up in the same maps
 *   rebuild  building maps and channels, by map size
 * Truth: the ray tracer with TRUTH samples. Times are the best of ROUNDS.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/measure.h>

#include "method/line_map/line_map.h"

#define ROUNDS 3

struct setting {
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
    uint8_t *mask;
    float *truth, *visibility;
};

struct result {
    pnb_errors errors;
    double ms, maps, skins, texels, map_ms, skin_ms, look_up_ms;
};

static int threads, width = 800, height = 600, truth_samples = 1024;
static bool as_json, opengl, first_row = true;

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", context ? pnb_context_error(context) : "no context");
    exit(1);
}

static void setting_init(struct setting *s, const char *path)
{
    memset(s, 0, sizeof(*s));
    if (pnb_context_create(&(pnb_context_desc){.threads = threads}, &s->context) != PNB_OK)
        die(NULL);
    if (pnb_scene_load(s->context, path, &s->scene) != PNB_OK ||
        pnb_surface_create(s->context, s->scene, NULL, width, height, &s->surface) != PNB_OK)
        die(s->context);
    pnb_surface_receivers(s->surface, &s->receivers);
    pnb_scene_light(s->scene, 0, &s->light);
    s->visibility = malloc(s->receivers.count * sizeof(float));
    s->truth = malloc(s->receivers.count * sizeof(float));
    s->mask = malloc(s->receivers.count);
    if (!s->visibility || !s->truth || !s->mask)
        exit(1);
    pnb_measure_facing(&s->light, &s->receivers, s->mask);
}

static void setting_finish(struct setting *s)
{
    free(s->visibility);
    free(s->truth);
    free(s->mask);
    pnb_surface_destroy(s->surface);
    pnb_scene_destroy(s->scene);
    pnb_context_destroy(s->context);
}

static double counter(const pnb_solver_report *report, const char *name)
{
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, name) == 0)
            return report->counters[i].value;
    return 0;
}

static struct result run_with(struct setting *s, const char *method, int samples,
                              const pnb_solver_param *params, size_t count, int rounds, float *out)
{
    struct result result = {.ms = INFINITY};
    pnb_solver_desc desc = {method, samples, params, count};
    pnb_solver *solver;
    pnb_solver_report report;
    if (pnb_solver_create(s->context, s->scene, &desc, &solver) != PNB_OK)
        die(s->context);
    for (int i = 0; i < rounds; i++) {
        if (pnb_solver_visibility(solver, &s->light, &s->receivers, out) != PNB_OK)
            die(s->context);
        pnb_solver_get_report(solver, &report);
        if (report.visibility_ms > result.ms)
            continue;
        result.ms = report.visibility_ms;
        result.maps = counter(&report, "maps");
        result.skins = counter(&report, "skins");
        result.texels = counter(&report, "skin texels");
        result.map_ms = counter(&report, "map ms");
        result.skin_ms = counter(&report, "skin ms");
        result.look_up_ms = counter(&report, "look-up ms");
    }
    pnb_solver_destroy(solver);
    if (out != s->truth && pnb_measure(s->context, out, s->truth, s->mask, s->receivers.count,
                                       &result.errors) != PNB_OK)
        die(s->context);
    return result;
}

static struct result run(struct setting *s, const char *method, int samples, const char *key,
                         const char *value, int rounds, float *out)
{
    return run_with(s, method, samples, &(pnb_solver_param){key, value}, key ? 1 : 0, rounds, out);
}

static void row(const char *scene, const char *method, int k, const struct result *r)
{
    if (as_json)
        printf("%s\n{\"scene\": \"%s\", \"method\": \"%s\", \"samples\": %d, \"maps\": %.0f, "
               "\"rmse\": %.5f, \"mean_error\": %.5f, \"p99_error\": %.5f, \"max_error\": %.5f, "
               "\"umbra_leak\": %.5f, \"lit_darkening\": %.5f, \"ms\": %.2f, \"skins\": %.0f, "
               "\"map_ms\": %.2f, \"skin_ms\": %.2f, \"look_up_ms\": %.2f}",
               first_row ? "" : ",", scene, method, k, r->maps, r->errors.rmse,
               r->errors.mean_error, r->errors.p99_error, r->errors.max_error, r->errors.umbra_leak,
               r->errors.lit_darkening, r->ms, r->skins, r->map_ms, r->skin_ms, r->look_up_ms);
    else
        printf("%-16s %-24s %3d %5.0f  %7.4f %+8.4f %7.4f %6.3f %6.3f %8.1f %9.0f\n", scene, method,
               k, r->maps, r->errors.rmse, r->errors.mean_error, r->errors.p99_error,
               r->errors.umbra_leak, r->errors.lit_darkening, r->ms, r->skins);
    fflush(stdout);
    first_row = false;
}

static void scene_errors(const char *name, bool line)
{
    static const int ks[] = {2, 3, 5};
    struct setting s;
    char path[80];
    snprintf(path, sizeof(path), "builtin:%s", name);
    setting_init(&s, path);
    run(&s, "reference", truth_samples, NULL, NULL, 1, s.truth);
    struct result r = run(&s, "reference", 10, NULL, NULL, ROUNDS, s.visibility);
    row(name, "reference", 10, &r);
    for (size_t i = 0; i < 3; i++) {
        r = run(&s, "line-map", ks[i], NULL, NULL, ROUNDS, s.visibility);
        row(name, "line-map", ks[i], &r);
        if (opengl) {
            r = run(&s, "line-map", ks[i], "path", "opengl", ROUNDS, s.visibility);
            row(name, "line-map opengl", ks[i], &r);
        }
        if (line) {
            r = run(&s, "line-map", ks[i], "between", "dark", ROUNDS, s.visibility);
            row(name, "between=dark", ks[i], &r);
            static const pnb_solver_param paper[3][2] = {
                {{"between", "dark"}, {"transition", "linear"}},
                {{"between", "dark"}, {"overlap", "nearest"}},
                {{"between", "dark"}, {"edges", "other"}},
            };
            for (int p = 0; p < 3; p++) {
                char label[48];
                snprintf(label, sizeof(label), "between=dark %s", paper[p][1].value);
                r = run_with(&s, "line-map", ks[i], paper[p], 2, 1, s.visibility);
                row(name, label, ks[i], &r);
            }
        }
        r = run(&s, "sampled-maps", ks[i], NULL, NULL, ROUNDS, s.visibility);
        row(name, "sampled-maps", ks[i], &r);
        if (line) {
            r = run(&s, "sampled-maps", ks[i], "placement", "ends", 1, s.visibility);
            row(name, "sampled-maps ends", ks[i], &r);
        }
    }
    r = run(&s, "line-map", 0, "samples", "auto", 1, s.visibility);
    row(name, "line-map auto", 0, &r);
    setting_finish(&s);
}

/* Every built-in scene whose first light is of the type. */
static void errors(pnb_light_type type, const char *only)
{
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_context *context;
        pnb_scene *scene;
        pnb_light light;
        char path[80];
        pnb_builtin(i, &info);
        if (only && strcmp(info.name, only) != 0)
            continue;
        snprintf(path, sizeof(path), "builtin:%s", info.name);
        if (pnb_context_create(NULL, &context) != PNB_OK)
            die(NULL);
        if (pnb_scene_load(context, path, &scene) != PNB_OK)
            die(context);
        pnb_scene_light(scene, 0, &light);
        bool fits = light.type == type;
        pnb_scene_destroy(scene);
        pnb_context_destroy(context);
        if (fits)
            scene_errors(info.name, type == PNB_LIGHT_LINE);
    }
}

struct look_up {
    const struct line_map_light *light;
    const pnb_receivers *receivers;
    float *visibility;
    bool plain;
};

static void look_up_body(void *user, size_t begin, size_t end, int worker)
{
    const struct look_up *job = user;
    for (size_t i = begin; i < end; i++) {
        const float *p = job->receivers->positions + 3 * i, *n = job->receivers->normals + 3 * i;
        if (!isfinite(p[0]))
            job->visibility[i] = NAN;
        else if (job->plain)
            job->visibility[i] = (float)line_map_look_up_plain(job->light, p, n);
        else
            job->visibility[i] = (float)line_map_look_up(job->light, p, n, NULL);
    }
}

/* Frames with maps at hand, soft and plain in turn. */
static void fixed(const char *name, int k, bool spans)
{
    struct setting s;
    char path[80];
    snprintf(path, sizeof(path), "builtin:%s", name);
    setting_init(&s, path);
    struct line_map method = {
        .size = 1024, .rows = 1024, .columns = 1024, .bias = 1, .own_edges = true, .spans = spans};
    struct line_map_light *light;
    if (map_geometry_create(s.scene, &method.geometry) != PNB_OK ||
        line_map_light_create(&method, v3_load(s.light.shape.line.from),
                              v3_load(s.light.shape.line.to), (size_t)k, &light) != PNB_OK)
        die(s.context);
    const char *between = spans ? "spans" : "dark";
    double best[2] = {INFINITY, INFINITY};
    for (int round = 0; round < 2 * 15; round++) {
        struct look_up job = {light, &s.receivers, s.visibility, round % 2 != 0};
        double started = clock_ms();
        parallel_for(s.context, s.receivers.count, 2048, look_up_body, &job);
        best[round % 2] = fmin(best[round % 2], clock_ms() - started);
    }
    if (as_json)
        printf("%s\n{\"scene\": \"%s\", \"between\": \"%s\", \"samples\": %d, \"soft_ms\": %.3f, "
               "\"plain_ms\": %.3f, "
               "\"ratio\": %.3f}",
               first_row ? "" : ",", name, between, k, best[0], best[1], best[0] / best[1]);
    else
        printf("%-16s between=%-5s k %d: %.2f ms with channels, %.2f ms plain: ratio %.2f\n", name,
               between, k, best[0], best[1], best[0] / best[1]);
    first_row = false;
    line_map_light_destroy(light);
    map_geometry_destroy(method.geometry);
    setting_finish(&s);
}

/* Whether there is a device for the OpenGL path. */
static void find_opengl(void)
{
    struct setting s;
    pnb_solver *solver;
    setting_init(&s, "builtin:blocker");
    pnb_solver_desc desc = {"line-map", 2, &(pnb_solver_param){"path", "opengl"}, 1};
    opengl = pnb_solver_create(s.context, s.scene, &desc, &solver) == PNB_OK;
    if (opengl)
        pnb_solver_destroy(solver);
    else
        fprintf(stderr, "without the OpenGL path: %s\n", pnb_context_error(s.context));
    setting_finish(&s);
}

static void rebuild(const char *name, int k, const char *where)
{
    struct setting s;
    char path[80], size[16];
    snprintf(path, sizeof(path), "builtin:%s", name);
    setting_init(&s, path);
    for (int n = 256; n <= 4096; n *= 2) {
        snprintf(size, sizeof(size), "%d", n);
        memset(s.truth, 0, s.receivers.count * sizeof(float));
        const pnb_solver_param params[2] = {{"size", size}, {"path", where}};
        struct result r = run_with(&s, "line-map", k, params, 2, ROUNDS, s.visibility);
        if (as_json)
            printf("%s\n{\"scene\": \"%s\", \"path\": \"%s\", \"samples\": %d, \"size\": %d, "
                   "\"map_ms\": %.2f, "
                   "\"skin_ms\": %.2f, \"skins\": %.0f, \"skin_texels\": %.0f}",
                   first_row ? "" : ",", name, where, k, n, r.map_ms, r.skin_ms, r.skins, r.texels);
        else
            printf("%-16s %-6s k %d  %4d^2  maps %7.2f ms  channels %7.2f ms  %8.0f skins  %9.0f "
                   "texels "
                   "of skin\n",
                   name, where, k, n, r.map_ms, r.skin_ms, r.skins, r.texels);
        fflush(stdout);
        first_row = false;
    }
    setting_finish(&s);
}

static void section(const char *name, const char *title)
{
    if (as_json)
        printf("%s\n\"%s\": [", strcmp(name, "errors") == 0 ? "" : "],", name);
    else
        printf("%s%s\n", strcmp(name, "errors") == 0 ? "" : "\n", title);
    first_row = true;
}

int main(int argc, char **argv)
{
    const char *only = NULL;
    bool costs = false;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0) {
            as_json = true;
        } else if (strcmp(argv[i], "--threads") == 0 && i + 1 < argc) {
            threads = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--truth") == 0 && i + 1 < argc) {
            truth_samples = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--scene") == 0 && i + 1 < argc) {
            only = argv[++i];
        } else if (strcmp(argv[i], "--costs") == 0) {
            costs = true;
        } else if (strcmp(argv[i], "--help") == 0) {
            printf(
                "usage: penumbra bench line-map [--json] [--threads N] [--truth N] "
                "[--scene NAME | --costs]\n\n"
                "Errors and times of line-map, sampled-maps and 10 ray-traced samples on the\n"
                "built-in scenes with a linear light, the cost of frames with fixed maps, and of\n"
                "building maps (some two minutes). --scene: the errors of one scene\n"
                "alone; --costs: no errors.\n");
            return 0;
        } else {
            fprintf(stderr, "penumbra: error: %s: unknown option\n", argv[i]);
            return 2;
        }
    }
    find_opengl();
    if (as_json)
        printf("{\"suite\": \"line-map\",");
    section("errors",
            "scene            method                     n  maps     rmse     mean     p99 "
            "  leak   dark       ms     skins");
    if (!costs)
        errors(PNB_LIGHT_LINE, only);
    section("edges", "area lights by their edges");
    if (!costs)
        errors(PNB_LIGHT_POLYGON, only);
    section("fixed", "a frame with fixed maps");
    for (int k = 2; k <= 5 && !only; k++)
        for (int spans = 0; spans < 2; spans++)
            fixed("overlap", k, spans);
    section("rebuild", "building maps and channels");
    if (!only) {
        rebuild("blocker", 2, "cpu");
        rebuild("overlap", 3, "cpu");
        if (opengl) {
            rebuild("blocker", 2, "opengl");
            rebuild("overlap", 3, "opengl");
        }
    }
    if (as_json)
        printf("]\n}\n");
    return 0;
}
