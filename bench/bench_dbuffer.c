/* bench/bench_dbuffer.c: 'penumbra bench dbuffer': the paper's Table 1 remade.
 *
 * Four scenes stand for the paper's (224, 960, 5,760 and 1,440 triangles of occluder), at 300^2,
 * 600^2 and 1000^2 pixels: frames per second, the share of the frame that goes into finding
 * silhouettes and volumes (the CPU's part), and the time as a ratio to hard-map on OpenGL, which is
 * measured in turns with it. A frame is what pnb_solver_report.visibility_ms holds: nothing is kept
 * from the frame before. The processor time beside it is that of the whole call, uploading the
 * receivers and reading back included: on a software rasteriser, and a machine that does other
 * work, it is the steadier figure.
 *
 * --boundary: instead, how many pixels about the boundaries of umbrae and penumbrae lie on the
 * wrong side of them by more than 1.5 texels (dbuffer_boundary.h). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include <penumbra/penumbra.h>

#include "dbuffer_boundary.h"

#define METHODS_MAX 8
enum { BOUNDARY_WIDTH = 640, BOUNDARY_HEIGHT = 480 };

static const struct {
    const char *scene;
    int triangles;
    double paper[3]; /* frames per second on a QuadroFX 3000 */
} scenes[] = {
    {"distance-1", 224, {212, 120, 61}},
    {"light-size-2", 960, {107, 75, 45}},
    {"complex", 5760, {14.2, 13.0, 12.1}},
    {"complex-1440", 1440, {28.4, 21.3, 16.9}},
};
static const int sizes[] = {300, 600, 1000};

struct column {
    const char *title, *method;
    pnb_solver_param params[4];
    size_t param_count;
};

struct cell {
    double ms, processor_ms, volumes_ms;
};

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", pnb_context_error(context));
    exit(1);
}

static double processor_ms(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return 1e3 * (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-3 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static double counter(const pnb_solver_report *report, const char *name)
{
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, name) == 0)
            return report->counters[i].value;
    return 0;
}

/* All columns in turns, the best of some runs each. */
static void measure(pnb_context *context, const char *name, int size, const struct column *columns,
                    size_t count, int runs, struct cell *cells, char *device, size_t device_size)
{
    char path[64];
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
    pnb_solver *solvers[METHODS_MAX];
    pnb_solver_report report;
    snprintf(path, sizeof(path), "builtin:%s", name);
    if (pnb_scene_load(context, path, &scene) != PNB_OK ||
        pnb_surface_create(context, scene, NULL, size, size, &surface) != PNB_OK)
        die(context);
    pnb_surface_receivers(surface, &receivers);
    pnb_scene_light(scene, 0, &light);
    float *visibility = malloc(receivers.count * sizeof(*visibility));
    if (!visibility)
        exit(1);
    for (size_t c = 0; c < count; c++) {
        pnb_solver_desc desc = {columns[c].method, 0, columns[c].params, columns[c].param_count};
        if (pnb_solver_create(context, scene, &desc, &solvers[c]) != PNB_OK)
            die(context);
        cells[c] = (struct cell){INFINITY, INFINITY, INFINITY};
    }
    /* The first round warms up. */
    for (int run = 0; run <= runs; run++)
        for (size_t c = 0; c < count; c++) {
            double before = processor_ms();
            if (pnb_solver_visibility(solvers[c], &light, &receivers, visibility) != PNB_OK)
                die(context);
            pnb_solver_get_report(solvers[c], &report);
            double spent = processor_ms() - before;
            if (run == 0)
                continue;
            cells[c].ms = fmin(cells[c].ms, report.visibility_ms);
            cells[c].processor_ms = fmin(cells[c].processor_ms, spent);
            cells[c].volumes_ms = fmin(cells[c].volumes_ms, counter(&report, "volumes_ms"));
            snprintf(device, device_size, "%s", report.device);
        }
    for (size_t c = 0; c < count; c++)
        pnb_solver_destroy(solvers[c]);
    free(visibility);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
}

/* ---- Boundaries ---- */

static void write_picture(pnb_context *context, const char *folder, const char *name,
                          const float *visibility, const uint8_t *mark)
{
    char path[512];
    pnb_image image;
    snprintf(path, sizeof(path), "%s/%s.png", folder, name);
    if (pnb_image_create(context, BOUNDARY_WIDTH, BOUNDARY_HEIGHT, 3, &image) != PNB_OK)
        die(context);
    for (size_t i = 0; i < BOUNDARY_WIDTH * BOUNDARY_HEIGHT; i++) {
        float grey = visibility[i] == visibility[i] ? 0.2f + 0.6f * visibility[i] : 0.1f;
        float *to = image.data + 3 * i;
        to[0] = mark[i] & 4 ? 1 : mark[i] & 8 ? 0 : grey;
        to[1] = mark[i] & 12 ? 0 : grey;
        to[2] = mark[i] & 4 ? 0 : mark[i] & 8 ? 1 : grey;
    }
    if (pnb_image_write(context, path, &image) != PNB_OK)
        die(context);
    pnb_image_finish(context, &image);
}

static void boundaries(pnb_context *context, bool json, int size, const char *folder)
{
    static const struct {
        const char *scene, *title;
        double radius; /* of a disk 3.2 m over the prism; 0: the scene's own light */
    } rows[] = {{"prism", "prism-0.05", 0.05},       {"prism", "prism-0.2", 0.2},
                {"prism", "prism-0.8", 0.8},         {"distance-1", "distance-1", 0},
                {"distance-2", "distance-2", 0},     {"distance-3", "distance-3", 0},
                {"distance-4", "distance-4", 0},     {"light-size-1", "light-size-1", 0},
                {"light-size-2", "light-size-2", 0}, {"light-size-3", "light-size-3", 0},
                {"light-size-4", "light-size-4", 0}};
    static float visibility[BOUNDARY_WIDTH * BOUNDARY_HEIGHT];
    static uint8_t mark[BOUNDARY_WIDTH * BOUNDARY_HEIGHT];
    printf(json ? "{\"rows\": ["
                : "pixels about a boundary, and the share within 1.5 texels of it\n");
    for (size_t i = 0; i < sizeof(rows) / sizeof(*rows); i++) {
        char path[64];
        pnb_scene *scene;
        pnb_light light;
        struct boundary b;
        snprintf(path, sizeof(path), "builtin:%s", rows[i].scene);
        if (pnb_scene_load(context, path, &scene) != PNB_OK)
            die(context);
        pnb_scene_light(scene, 0, &light);
        if (rows[i].radius > 0)
            light = (pnb_light){.type = PNB_LIGHT_DISK,
                                .color = {1, 1, 1},
                                .shape.disk = {{0.3, 3.2, 0.4}, {0, -1, 0}, rows[i].radius}};
        if (boundary_measure(context, scene, &light, BOUNDARY_WIDTH, BOUNDARY_HEIGHT, size, &b,
                             mark, visibility) != PNB_OK)
            die(context);
        double within[2];
        for (int k = 0; k < 2; k++)
            within[k] = b.near[k] ? 1 - (double)b.off[k] / (double)b.near[k] : 1;
        if (json)
            printf("%s\n  {\"scene\": \"%s\", \"size\": %d, \"texel\": %.4g, "
                   "\"umbra_pixels\": %zu, \"umbra_within\": %.5f, \"outer_pixels\": %zu, "
                   "\"outer_within\": %.5f}",
                   i ? "," : "", rows[i].title, b.size, b.texel, b.near[0], within[0], b.near[1],
                   within[1]);
        else
            printf("%-14s %d^2  texel %.2f mrad  umbra %6zu %7.2f %%  outer %6zu %7.2f %%\n",
                   rows[i].title, b.size, 1e3 * b.texel, b.near[0], 100 * within[0], b.near[1],
                   100 * within[1]);
        if (folder)
            write_picture(context, folder, rows[i].title, visibility, mark);
        pnb_scene_destroy(scene);
    }
    if (json)
        printf("\n]}\n");
}

static int usage(void)
{
    printf("usage: penumbra bench dbuffer [--json] [--runs N] [--all]\n"
           "       penumbra bench dbuffer --boundary [--json] [--size N] [--pictures DIR]\n\n"
           "  --runs N   frames per cell (default 5); the best one counts\n"
           "  --all      beside it hard-volume, pcss, and dbuffer's other choices\n"
           "  --boundary instead: pixels within 1.5 texels of the boundaries\n"
           "  --size N   texels of the D-buffer there (default 1024)\n"
           "  --pictures DIR  and where not: pixels of the umbra's in red, the outer one's in "
           "blue\n");
    return 0;
}

int main(int argc, char **argv)
{
    static const struct column columns[] = {
        {"hard-map", "hard-map", {{"path", "opengl"}}, 1},
        {"dbuffer", "dbuffer", {{NULL}}, 0},
        {"layers=1", "dbuffer", {{"layers", "1"}}, 1},
        {"as the paper", "dbuffer", {{"layers", "1"}, {"filter", "nearest"}, {"v", "paper"}}, 3},
        {"size=1024", "dbuffer", {{"size", "1024"}}, 1},
        {"hard-volume", "hard-volume", {{NULL}}, 0},
        {"pcss", "pcss", {{NULL}}, 0},
    };
    bool json = false, boundary = false;
    int runs = 5, size = 1024;
    const char *folder = NULL;
    size_t count = 4;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--json") == 0)
            json = true;
        else if (strcmp(argv[i], "--all") == 0)
            count = sizeof(columns) / sizeof(*columns);
        else if (strcmp(argv[i], "--runs") == 0 && i + 1 < argc && atoi(argv[i + 1]) > 0)
            runs = atoi(argv[++i]);
        else if (strcmp(argv[i], "--boundary") == 0)
            boundary = true;
        else if (strcmp(argv[i], "--size") == 0 && i + 1 < argc && atoi(argv[i + 1]) > 0)
            size = atoi(argv[++i]);
        else if (strcmp(argv[i], "--pictures") == 0 && i + 1 < argc)
            folder = argv[++i];
        else if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0)
            return usage();
        else {
            fprintf(stderr, "penumbra: error: %s: unknown option\n", argv[i]);
            return 2;
        }
    }
    pnb_context *context;
    char device[256] = "";
    struct cell cells[METHODS_MAX], first[3][METHODS_MAX];
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    if (boundary) {
        boundaries(context, json, size, folder);
        pnb_context_destroy(context);
        return 0;
    }
    if (json)
        printf("{\"rows\": [");
    else
        printf(
            "frames per second (processor ms a call; volumes: ms on the CPU; to 224: of the rate "
            "at 224 triangles)\n");
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++)
        for (int k = 0; k < 3; k++) {
            measure(context, scenes[s].scene, sizes[k], columns, count, runs, cells, device,
                    sizeof(device));
            if (s == 0)
                memcpy(first[k], cells, sizeof(cells));
            if (!json)
                printf("%-13s %5d triangles, %4d^2, the paper %6.1f\n", scenes[s].scene,
                       scenes[s].triangles, sizes[k], scenes[s].paper[k]);
            for (size_t c = 0; c < count; c++) {
                double ratio = cells[c].ms / cells[0].ms;
                double rate = first[k][c].ms / cells[c].ms;
                if (json)
                    printf("%s\n  {\"scene\": \"%s\", \"triangles\": %d, \"size\": %d, "
                           "\"column\": \"%s\", \"milliseconds\": %.4g, \"processor_ms\": %.4g, "
                           "\"volumes_ms\": %.4g, \"ratio_to_hard_map\": %.4g, "
                           "\"rate_to_224\": %.4g, \"paper_fps\": %g}",
                           s + c + (size_t)k ? "," : "", scenes[s].scene, scenes[s].triangles,
                           sizes[k], columns[c].title, cells[c].ms, cells[c].processor_ms,
                           cells[c].volumes_ms, ratio, rate, scenes[s].paper[k]);
                else
                    printf("    %-13s %7.1f /s  %8.2f ms  (%8.2f processor)  volumes %6.3f ms = "
                           "%4.1f %%  x%-6.1f hard-map  to 224: %.2f\n",
                           columns[c].title, 1e3 / cells[c].ms, cells[c].ms, cells[c].processor_ms,
                           cells[c].volumes_ms, 100 * cells[c].volumes_ms / cells[c].ms, ratio,
                           rate);
            }
        }
    if (json)
        printf("\n], \"device\": \"%s\"}\n", device);
    else
        printf("%s\n", device);
    pnb_context_destroy(context);
    return 0;
}
