/* bench/bench_opengl.c: 'penumbra bench opengl': what a frame of every method on OpenGL costs, as a
 * ratio to hard-map on OpenGL in the same run.
 *
 * Every method draws in turn, round after round, so that what else the machine does falls on all
 * alike; the time is the least of the rounds, from the first draw until all is drawn, without
 * upload of the receivers and read back, which are the same for all. Beside it the processor time
 * of all threads, which on a software rasteriser is the whole cost and does not depend on what else
 * the machine does: there it makes the ratio. Errors are against exact.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#define METHODS_MAX 32

struct entry {
    const pnb_method_info *info;
    pnb_solver *solver;
    double least_ms, processor_ms;
    pnb_errors errors;
};

static int rounds = 5, threads;
static bool as_json, first = true, software;

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", context ? pnb_context_error(context) : "no context");
    exit(1);
}

static bool on_opengl(const pnb_method_info *info)
{
    return info->processor == PNB_PROCESSOR_OPENGL || info->opengl_path;
}

static double cost(const struct entry *entry)
{
    return software ? entry->processor_ms : entry->least_ms;
}

static void print(const char *scene, int width, int height, const struct entry *entry, double base,
                  const char *device)
{
    double ms = entry->least_ms, ratio = base > 0 ? cost(entry) / base : 0;
    const pnb_errors *e = &entry->errors;
    if (as_json) {
        printf("%s\n  {\"scene\": \"%s\", \"width\": %d, \"height\": %d, \"method\": \"%s\", "
               "\"milliseconds\": %.4f, \"processor_milliseconds\": %.4f, \"ratio\": %.4f, "
               "\"rmse\": %.5f, \"umbra_leak\": %.5f, "
               "\"device\": \"%s\"}",
               first ? "" : ",", scene, width, height, entry->info->name, ms, entry->processor_ms,
               ratio, e->rmse, e->umbra_leak, device);
    } else {
        if (first)
            printf("%s; least of %d rounds\n%-16s %9s  %-20s %9s %9s %9s  %7s %7s\n", device,
                   rounds, "scene", "size", "method", "ms", "cpu ms", "x hard-map", "rmse", "leak");
        char size[32];
        snprintf(size, sizeof(size), "%dx%d", width, height);
        printf("%-16s %9s  %-20s %9.2f %9.2f %9.2f  %7.4f %7.4f\n", scene, size, entry->info->name,
               ms, entry->processor_ms, ratio, e->rmse, e->umbra_leak);
    }
    first = false;
    fflush(stdout);
}

static void measure(const char *scene_name, int width, int height)
{
    pnb_context *context = NULL;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
    char path[128];
    snprintf(path, sizeof(path), "builtin:%s", scene_name);
    if (pnb_context_create(&(pnb_context_desc){.threads = threads}, &context) != PNB_OK)
        die(NULL);
    if (pnb_scene_load(context, path, &scene) != PNB_OK ||
        pnb_surface_create(context, scene, NULL, width, height, &surface) != PNB_OK)
        die(context);
    pnb_surface_receivers(surface, &receivers);
    pnb_scene_light(scene, 0, &light);
    float *visibility = malloc(receivers.count * sizeof(float));
    float *truth = malloc(receivers.count * sizeof(float));
    uint8_t *mask = malloc(receivers.count);
    if (!visibility || !truth || !mask)
        die(NULL);
    pnb_solver *exact;
    if (pnb_solver_create(context, scene, &(pnb_solver_desc){.method = "exact"}, &exact) ||
        pnb_solver_visibility(exact, &light, &receivers, truth))
        die(context);
    pnb_solver_destroy(exact);
    pnb_measure_facing(&light, &receivers, mask);

    struct entry entries[METHODS_MAX];
    size_t count = 0;
    for (size_t m = 0; m < pnb_method_count() && count < METHODS_MAX; m++) {
        const pnb_method_info *info = pnb_method(m);
        if (!on_opengl(info) || !(info->lights & PNB_LIGHT_BIT(light.type)))
            continue;
        struct entry *entry = &entries[count++];
        *entry = (struct entry){.info = info, .least_ms = HUGE_VAL, .processor_ms = HUGE_VAL};
        pnb_solver_param param = {"path", "opengl"};
        pnb_solver_desc desc = {
            .method = info->name, .params = &param, .param_count = info->opengl_path};
        if (pnb_solver_create(context, scene, &desc, &entry->solver) != PNB_OK)
            die(context);
    }
    const char *device = "";
    pnb_solver_report report;
    for (int round = 0; round < rounds; round++)
        for (size_t i = 0; i < count; i++) {
            if (pnb_solver_visibility(entries[i].solver, &light, &receivers, visibility) != PNB_OK)
                die(context);
            pnb_solver_get_report(entries[i].solver, &report);
            if (report.visibility_ms < entries[i].least_ms)
                entries[i].least_ms = report.visibility_ms;
            for (size_t k = 0; k < report.counter_count; k++)
                if (strcmp(report.counters[k].name, "processor_ms") == 0 &&
                    report.counters[k].value < entries[i].processor_ms)
                    entries[i].processor_ms = report.counters[k].value;
            device = report.device;
            software = strstr(device, "llvmpipe") || strstr(device, "softpipe");
            if (round == 0 && pnb_measure(context, visibility, truth, mask, receivers.count,
                                          &entries[i].errors) != PNB_OK)
                die(context);
        }
    double base = 0;
    for (size_t i = 0; i < count; i++)
        if (strcmp(entries[i].info->name, "hard-map") == 0)
            base = cost(&entries[i]);
    for (size_t i = 0; i < count; i++)
        print(scene_name, width, height, &entries[i], base, device);
    for (size_t i = 0; i < count; i++)
        pnb_solver_destroy(entries[i].solver);
    free(visibility);
    free(truth);
    free(mask);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

int main(int argc, char **argv)
{
    static const char *const scenes[] = {"prism",   "disk",        "two-boxes",
                                         "complex", "spheres-9x9", "knot-96k"};
    static const int sizes[][2] = {{300, 300}, {600, 600}, {1000, 1000}};
    const char *scene = NULL;
    int width = 0, height = 0;
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--json") == 0) {
            as_json = true;
        } else if (strcmp(argv[i], "--rounds") == 0 && atoi(value) > 0) {
            rounds = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--threads") == 0) {
            threads = atoi(argv[++i]);
        } else if (strcmp(argv[i], "--scene") == 0) {
            scene = argv[++i];
        } else if (strcmp(argv[i], "--size") == 0 && sscanf(value, "%dx%d", &width, &height) == 2) {
            i++;
        } else if (strcmp(argv[i], "--help") == 0) {
            printf("usage: penumbra bench opengl [--json] [--rounds N] [--threads N] [--scene "
                   "NAME] [--size WxH]\n\n"
                   "A frame of every method on OpenGL on built-in scenes in several sizes: "
                   "milliseconds, and how\nmany times hard-map's. Without a device it says so.\n");
            return 0;
        } else {
            fprintf(stderr, "penumbra: error: %s: unknown option\n", argv[i]);
            return 2;
        }
    }
    if (as_json)
        printf("[");
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++)
        for (size_t k = 0; k < sizeof(sizes) / sizeof(*sizes); k++) {
            if ((scene && s > 0) || (width > 0 && k > 0))
                continue;
            measure(scene ? scene : scenes[s], width > 0 ? width : sizes[k][0],
                    width > 0 ? height : sizes[k][1]);
        }
    if (as_json)
        printf("\n]\n");
    return 0;
}
