/* bench_wedge_errors.c: errors of the wedges on the built-in scenes, beside pcss: RMSE over the
 * penumbra, and the share of the pixels facing the light that come out too dark (V below the truth
 * by more than 0.1), which is what overlapping silhouettes do to added wedges.
 *
 * Scenes and lights that a method cannot do are left out ("-"). What the methods must reach is
 * judged at the end, from the columns named wedge, wedge-probabilistic, wedge-blend and pcss. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

static const char usage[] =
    "usage: penumbra bench wedge-errors [--json] [-s WxH] [--truth N] [--methods LIST] "
    "[SCENE...]\n\n"
    "Errors of the wedges and of pcss against N ray-traced samples (default 4,096) on built-in\n"
    "scenes: those named, or every one that the wedges can do. LIST is of NAME[:KEY=VALUE...],\n"
    "default wedge,wedge-probabilistic,wedge-blend,pcss. Sizes default to 160x120.\n";

#define COLUMNS_MAX 16
#define PARAMS_MAX  4
#define TOO_DARK    0.1f

struct column {
    char text[128]; /* cut up: the name and the params point into it */
    char label[128];
    pnb_solver_param params[PARAMS_MAX];
    size_t param_count;
    double rmse, dark, leak, ms; /* of the scene at hand; rmse below 0: cannot do it */
};

struct bench {
    pnb_context *context;
    struct column columns[COLUMNS_MAX];
    int column_count;
    int width, height, truth_samples;
    bool json;
    int rows, beaten; /* scenes; those where pcss has the smaller RMSE than wedge-blend */
};

static bool parse_methods(struct bench *bench, const char *list)
{
    while (*list) {
        size_t length = strcspn(list, ",");
        struct column *c = &bench->columns[bench->column_count];
        if (bench->column_count == COLUMNS_MAX || length == 0 || length >= sizeof(c->text))
            return false;
        memcpy(c->text, list, length);
        memcpy(c->label, list, length);
        for (char *at = strchr(c->text, ':'); at; at = strchr(at, ':')) {
            *at++ = 0;
            char *value = strchr(at, '=');
            if (!value || c->param_count == PARAMS_MAX)
                return false;
            *value++ = 0;
            c->params[c->param_count++] = (pnb_solver_param){at, value};
            at = value;
        }
        bench->column_count++;
        list += length + (list[length] == ',');
    }
    return bench->column_count > 0;
}

static pnb_status solve(struct bench *bench, pnb_scene *scene, const pnb_solver_desc *desc,
                        const pnb_receivers *receivers, float *visibility, double *out_ms)
{
    pnb_solver *solver;
    pnb_solver_report report;
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    pnb_status status = pnb_solver_create(bench->context, scene, desc, &solver);
    if (status != PNB_OK)
        return status;
    for (int frame = 0; frame < 2 && status == PNB_OK; frame++) /* the first one warms up */
        if (frame == 0 || out_ms)
            status = pnb_solver_visibility(solver, &light, receivers, visibility);
    pnb_solver_get_report(solver, &report);
    if (out_ms)
        *out_ms = report.visibility_ms;
    pnb_solver_destroy(solver);
    return status;
}

static pnb_status run_column(struct bench *bench, pnb_scene *scene, const pnb_receivers *receivers,
                             const uint8_t *mask, const float *truth, float *visibility,
                             struct column *c)
{
    pnb_solver_desc desc = {.method = c->text, .params = c->params, .param_count = c->param_count};
    c->rmse = -1;
    pnb_status status = solve(bench, scene, &desc, receivers, visibility, &c->ms);
    if (status == PNB_ERROR_UNSUPPORTED)
        return PNB_OK;
    pnb_errors errors;
    if (status == PNB_OK)
        status = pnb_measure(bench->context, visibility, truth, mask, receivers->count, &errors);
    if (status != PNB_OK)
        return status;
    size_t dark = 0, count = 0;
    for (size_t i = 0; i < receivers->count; i++) {
        count += mask[i];
        dark += mask[i] && visibility[i] < truth[i] - TOO_DARK;
    }
    c->rmse = errors.rmse;
    c->leak = errors.umbra_leak;
    c->dark = (double)dark / (double)(count ? count : 1);
    return PNB_OK;
}

static const struct column *find(const struct bench *bench, const char *label)
{
    for (int i = 0; i < bench->column_count; i++)
        if (strcmp(bench->columns[i].label, label) == 0 && bench->columns[i].rmse >= 0)
            return &bench->columns[i];
    return NULL;
}

static void judge(struct bench *bench, const char *name)
{
    const struct column *added = find(bench, "wedge"),
                        *product = find(bench, "wedge-probabilistic"),
                        *blend = find(bench, "wedge-blend"), *pcss = find(bench, "pcss");
    if (blend && pcss)
        bench->beaten += pcss->rmse < blend->rmse;
    if (bench->json || !added || !product || !blend ||
        (strcmp(name, "spheres-9x9") != 0 && strcmp(name, "two-boxes") != 0))
        return;
    bool half = blend->rmse <= 0.5 * added->rmse, less = blend->rmse < product->rmse;
    bool dark = blend->dark <= 0.25 * added->dark;
    printf("  %s: RMSE %.2f of wedge's (at most 0.5): %s; below probabilistic's: %s; too dark %.2f "
           "%% of pixels, wedge %.2f %% (at most a quarter): %s\n",
           name, blend->rmse / added->rmse, half ? "pass" : "FAIL", less ? "pass" : "FAIL",
           100 * blend->dark, 100 * added->dark, dark ? "pass" : "FAIL");
}

static void print_row(const struct bench *bench, const char *name)
{
    if (bench->json) {
        printf("%s\n {\"scene\": \"%s\", \"methods\": [", bench->rows ? "," : "", name);
        bool first = true;
        for (int i = 0; i < bench->column_count; i++) {
            const struct column *c = &bench->columns[i];
            if (c->rmse < 0)
                continue;
            printf("%s{\"name\": \"%s\", \"rmse\": %g, \"too_dark\": %g, \"umbra_leak\": %g, "
                   "\"milliseconds\": %g}",
                   first ? "" : ", ", c->label, c->rmse, c->dark, c->leak, c->ms);
            first = false;
        }
        printf("]}");
    } else {
        printf("| %s", name);
        for (int i = 0; i < bench->column_count; i++)
            if (bench->columns[i].rmse < 0)
                printf(" | -");
            else
                printf(" | %.4f, %.2f %%", bench->columns[i].rmse, 100 * bench->columns[i].dark);
        printf(" |\n");
    }
    fflush(stdout);
}

/* A scene that none of the wedges can do is no row. */
static pnb_status run_scene(struct bench *bench, const char *name)
{
    char path[128];
    pnb_scene *scene = NULL;
    pnb_surface *surface = NULL;
    pnb_receivers receivers = {0};
    snprintf(path, sizeof(path), "builtin:%s", name);
    pnb_status status = pnb_scene_load(bench->context, path, &scene);
    if (status == PNB_OK)
        status =
            pnb_surface_create(bench->context, scene, NULL, bench->width, bench->height, &surface);
    if (status == PNB_OK)
        pnb_surface_receivers(surface, &receivers);
    float *truth = malloc(2 * receivers.count * sizeof(float) + 1);
    uint8_t *mask = malloc(receivers.count + 1);
    bool any = false;
    if (status == PNB_OK && truth && mask) {
        pnb_light light;
        pnb_scene_light(scene, 0, &light);
        pnb_measure_facing(&light, &receivers, mask);
        pnb_solver_desc desc = {.method = "reference", .samples = bench->truth_samples};
        status = solve(bench, scene, &desc, &receivers, truth, NULL);
        for (int i = 0; i < bench->column_count && status == PNB_OK; i++) {
            struct column *c = &bench->columns[i];
            status = run_column(bench, scene, &receivers, mask, truth, truth + receivers.count, c);
            any = any || (c->rmse >= 0 && strncmp(c->text, "wedge", 5) == 0);
        }
        if (status == PNB_OK && any) {
            print_row(bench, name);
            judge(bench, name);
            bench->rows++;
        }
    }
    free(truth);
    free(mask);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    return status;
}

/* The built-in scenes' names one after another; a light of a kind that no wedge takes shows when
 * it is tried. */
static pnb_status run_all(struct bench *bench)
{
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < pnb_builtin_count() && status == PNB_OK; i++) {
        pnb_builtin_info info;
        pnb_builtin(i, &info);
        status = run_scene(bench, info.name);
    }
    return status;
}

static void print_head(const struct bench *bench)
{
    if (bench->json) {
        printf(
            "{\"suite\": \"wedge-errors\", \"width\": %d, \"height\": %d, \"truth_samples\": %d, "
            "\"rows\": [",
            bench->width, bench->height, bench->truth_samples);
        return;
    }
    printf("%d x %d; RMSE over the penumbra, share of pixels too dark by more than 0.1\n\n| scene",
           bench->width, bench->height);
    for (int i = 0; i < bench->column_count; i++)
        printf(" | %s", bench->columns[i].label);
    printf(" |\n|");
    for (int i = 0; i <= bench->column_count; i++)
        printf(" --- |");
    printf("\n");
}

int main(int argc, char **argv)
{
    struct bench bench = {.width = 160, .height = 120, .truth_samples = 4096};
    const char *methods = "wedge,wedge-probabilistic,wedge-blend,pcss";
    int names = argc;
    for (int i = 1; i < argc; i++) {
        const char *next = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--json") == 0) {
            bench.json = true;
        } else if (strcmp(argv[i], "-s") == 0 &&
                   sscanf(next, "%dx%d", &bench.width, &bench.height) == 2 && bench.width > 0 &&
                   bench.height > 0 && bench.width <= 8192 && bench.height <= 8192) {
            i++;
        } else if (strcmp(argv[i], "--truth") == 0 && (bench.truth_samples = atoi(next)) > 0) {
            i++;
        } else if (strcmp(argv[i], "--methods") == 0) {
            methods = next;
            i++;
        } else if (argv[i][0] != '-') {
            names = i;
            break;
        } else {
            fputs(usage, strcmp(argv[i], "--help") == 0 ? stdout : stderr);
            return strcmp(argv[i], "--help") == 0 ? 0 : 2;
        }
    }
    if (!parse_methods(&bench, methods)) {
        fputs(usage, stderr);
        return 2;
    }
    if (pnb_context_create(NULL, &bench.context) != PNB_OK)
        return 1;
    pnb_status status = PNB_OK;
    print_head(&bench);
    for (int i = names; i < argc && status == PNB_OK; i++)
        status = run_scene(&bench, argv[i]);
    if (names == argc)
        status = run_all(&bench);
    if (bench.json)
        printf("]}\n");
    else
        printf("\nwedge-blend has a smaller RMSE than pcss on %d of %d scenes\n",
               bench.rows - bench.beaten, bench.rows);
    if (status != PNB_OK)
        fprintf(stderr, "penumbra-bench-wedge-errors: error: %s\n",
                pnb_context_error(bench.context));
    pnb_context_destroy(bench.context);
    return status != PNB_OK;
}
