/* bench/bench_planar_tolerance.c: 'penumbra bench planar-tolerance': does a mesh with a promised
 * error keep its promise, with how many triangles, in what time.
 *
 * Per scene: the mesh of -p tolerance=T (1/255 unless --tolerance says otherwise), compared with
 * `exact` at 4,096 samples and lengths along rows, at 100,000 random points of the receiving plane
 * and at as many within the shadow's bounds, where the mesh has something to say:
 *   triangles   penumbra: 0 < intensity < 1 somewhere in them; umbra: all 1
 *   max         largest error, in 1/255
 *   within      share of the points that are off by no more than T, in percent
 *   exact       points of exact visibility asked for
 *   ms, cpu ms  least of three, on the context's threads: wall clock, and processor time of all
 * --steady: the light moves in 100 small steps; jump: how far a point's change differs from the
 * truth's own, worst of 9,216 points and of all steps, and the mean of the steps' worst; error: the
 * worst difference from the truth itself; ms a frame.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <penumbra/penumbra.h>

#include "planar_scenes.h"

#define POINTS 100000

/* The planar suite's meshes, or anything that can be loaded. */
static pnb_scene *load(pnb_context *context, const char *name, pnb_light *light)
{
    static const struct {
        const char *name;
        enum bench_shape shape;
        int rows, columns;
    } meshes[] = {
        {"blob", BENCH_BLOB, 100, 50},
        {"knot", BENCH_KNOT, 500, 10},
        {"box", BENCH_BOX, 0, 0},
        {"slabs", BENCH_SLABS, 0, 0},
    };
    pnb_scene *scene = NULL;
    for (size_t i = 0; i < sizeof(meshes) / sizeof(meshes[0]); i++)
        if (strcmp(name, meshes[i].name) == 0) {
            scene = bench_scene(context, meshes[i].shape, meshes[i].rows, meshes[i].columns);
            *light = (pnb_light){.type = PNB_LIGHT_RECTANGLE,
                                 .color = {1, 1, 1},
                                 .shape.rectangle = {{0.8, 7, 0}, {0.7, 0, 0}, {0, 0, 0.7}}};
            return scene;
        }
    if (pnb_scene_load(context, name, &scene))
        bench_die(context);
    pnb_scene_light(scene, 0, light);
    return scene;
}

static double cpu_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}

static double dice(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15ull;
    uint64_t z = *state;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

struct points {
    float *positions, *normals;
    uint32_t *objects;
    pnb_receivers receivers;
    float *truth, *seen;
};

static struct points make_points(const pnb_shadow_plane *plane, uint32_t object, const double lo[2],
                                 const double hi[2], size_t count)
{
    struct points p = {malloc(count * 12), malloc(count * 12), malloc(count * 4)};
    uint64_t state = 12345;
    for (size_t i = 0; i < count; i++) {
        double u = lo[0] + (hi[0] - lo[0]) * dice(&state),
               v = lo[1] + (hi[1] - lo[1]) * dice(&state);
        for (int k = 0; k < 3; k++) {
            p.positions[3 * i + k] =
                (float)(plane->origin[k] + u * plane->axis_u[k] + v * plane->axis_v[k]);
            p.normals[3 * i + k] = (float)plane->normal[k];
        }
        p.objects[i] = object;
    }
    p.receivers = (pnb_receivers){
        .count = count, .positions = p.positions, .normals = p.normals, .objects = p.objects};
    p.truth = malloc(count * sizeof(float));
    p.seen = malloc(count * sizeof(float));
    return p;
}

static void free_points(struct points *p)
{
    free(p->positions);
    free(p->normals);
    free(p->objects);
    free(p->truth);
    free(p->seen);
}

static pnb_solver *solver_of(pnb_context *context, pnb_scene *scene, const char *method,
                             int samples, const pnb_solver_param *params, size_t count)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {
        .method = method, .samples = samples, .params = params, .param_count = count};
    if (pnb_solver_create(context, scene, &desc, &solver))
        bench_die(context);
    return solver;
}

struct errors {
    double max, within, within_penumbra;
    size_t penumbra;
};

static struct errors judge(const struct points *p, double tolerance)
{
    struct errors e = {0};
    size_t within = 0, within_penumbra = 0, count = 0;
    for (size_t i = 0; i < p->receivers.count; i++) {
        if (isnan(p->seen[i]) || isnan(p->truth[i]))
            continue;
        double off = fabs(p->seen[i] - p->truth[i]);
        bool penumbra = p->truth[i] > 0 && p->truth[i] < 1;
        count++;
        within += off <= tolerance;
        e.penumbra += penumbra;
        within_penumbra += penumbra && off <= tolerance;
        e.max = fmax(e.max, off);
    }
    e.within = count ? 100.0 * (double)within / (double)count : 100;
    e.within_penumbra = e.penumbra ? 100.0 * (double)within_penumbra / (double)e.penumbra : 100;
    return e;
}

/* The worst points, for humans. */
static void show_places(const struct points *p, const char *where)
{
    enum { most = 6 };
    size_t worst[most] = {0}, count = 0;
    for (size_t i = 0; i < p->receivers.count; i++) {
        double off = fabs(p->seen[i] - p->truth[i]);
        if (isnan(off))
            continue;
        size_t k = count < most ? count++ : most;
        for (; k > 0 && off > fabs(p->seen[worst[k - 1]] - p->truth[worst[k - 1]]); k--)
            if (k < most)
                worst[k] = worst[k - 1];
        if (k < most)
            worst[k] = i;
    }
    for (size_t k = 0; k < count; k++) {
        size_t i = worst[k];
        printf("  %s (%.6f %.6f %.6f): visibility %.5f, exact %.5f\n", where, p->positions[3 * i],
               p->positions[3 * i + 1], p->positions[3 * i + 2], p->seen[i], p->truth[i]);
    }
}

static void measure(const char *name, double tolerance, bool json, bool places, bool first)
{
    pnb_context *context;
    pnb_scene *scene;
    char text[32];
    snprintf(text, sizeof(text), "%.9g", tolerance);
    pnb_solver_param param = {"tolerance", text};
    if (pnb_context_create(NULL, &context))
        exit(1);
    pnb_light light;
    scene = load(context, name, &light);
    pnb_solver_desc desc = {.params = &param, .param_count = 1};
    double best = 1e30, best_cpu = 1e30;
    pnb_shadow *shadow = NULL;
    pnb_solver_report report;
    for (int i = 0; i < 3; i++) {
        pnb_shadow_destroy(shadow);
        double begin = cpu_ms();
        if (pnb_shadow_create(context, scene, &light, &desc, &shadow))
            bench_die(context);
        pnb_shadow_get_report(shadow, &report);
        best_cpu = fmin(best_cpu, cpu_ms() - begin);
        best = fmin(best, report.visibility_ms);
        if (report.visibility_ms > 3000)
            break;
    }
    pnb_shadow_view view;
    pnb_shadow_get(shadow, &view);
    size_t penumbra = 0, umbra = 0;
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < view.triangle_count; i++) {
        int full = 0;
        for (int k = 0; k < 3; k++) {
            uint32_t v = view.indices[3 * i + k];
            full += view.intensities[v] >= 1;
            for (int axis = 0; axis < 2; axis++) {
                lo[axis] = fmin(lo[axis], view.coordinates[2 * v + axis]);
                hi[axis] = fmax(hi[axis], view.coordinates[2 * v + axis]);
            }
        }
        umbra += full == 3;
        penumbra += full < 3;
    }
    pnb_shadow_plane plane;
    pnb_shadow_get_plane(shadow, 0, &plane);
    double all_lo[2] = {-plane.half_u, -plane.half_v}, all_hi[2] = {plane.half_u, plane.half_v};
    for (int axis = 0; axis < 2; axis++) {
        lo[axis] = fmax(lo[axis], all_lo[axis]);
        hi[axis] = fmin(hi[axis], all_hi[axis]);
    }
    pnb_solver_param area = {"exact-area", "on"};
    pnb_solver *exact = solver_of(context, scene, "exact", 4096, &area, 1);
    pnb_solver *planar = solver_of(context, scene, "planar", 0, &param, 1);
    struct errors e[2];
    for (int k = 0; k < 2; k++) {
        struct points p =
            make_points(&plane, view.planes[0], k ? lo : all_lo, k ? hi : all_hi, POINTS);
        if (pnb_solver_visibility(exact, &light, &p.receivers, p.truth) ||
            pnb_solver_visibility(planar, &light, &p.receivers, p.seen))
            bench_die(context);
        e[k] = judge(&p, tolerance);
        if (places)
            show_places(&p, k ? "shadow" : "plane");
        free_points(&p);
    }
    double evaluations = 0;
    for (size_t i = 0; i < report.counter_count; i++)
        if (strcmp(report.counters[i].name, "evaluations") == 0)
            evaluations = report.counters[i].value;
    if (json)
        printf("%s\n {\"scene\": \"%s\", \"tolerance\": %g, \"penumbra_triangles\": %zu, "
               "\"umbra_triangles\": %zu, \"max_error\": %g, \"within_percent\": %g, "
               "\"penumbra_points\": %zu, \"penumbra_max_error\": %g, "
               "\"penumbra_within_percent\": %g, \"evaluations\": %g, \"ms\": %g, \"cpu_ms\": %g}",
               first ? "" : ",", name, tolerance, penumbra, umbra, e[0].max, e[0].within,
               e[1].penumbra, e[1].max, e[1].within_penumbra, evaluations, best, best_cpu);
    else
        printf("%-28s %8zu %8zu | %6.2f %8.3f | %8zu %6.2f %8.3f | %8.0f %8.1f %8.1f\n", name,
               penumbra, umbra, 255 * e[0].max, e[0].within, e[1].penumbra, 255 * e[1].max,
               e[1].within_penumbra, evaluations, best, best_cpu);
    fflush(stdout);
    pnb_solver_destroy(exact);
    pnb_solver_destroy(planar);
    pnb_shadow_destroy(shadow);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* A point of an area light, to be moved. */
static double *place_of(pnb_light *light)
{
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: return light->shape.rectangle.center;
    case PNB_LIGHT_DISK: return light->shape.disk.center;
    case PNB_LIGHT_POINT: return light->shape.point.position;
    default: return NULL;
    }
}

/* The light moves 0.3 m in a hundred steps; how far a method's change at a point differs from the
 * truth's own. */
static void steadiness(const char *name, bool json, bool first)
{
    enum { side = 96, steps = 100, points = side * side };
    static const struct {
        const char *name;
        int samples;
        pnb_solver_param params[2];
        size_t count;
    } modes[] = {
        {"rings, 3 samples", 3, {{NULL, NULL}}, 0},
        {"rings, 16 samples", 16, {{NULL, NULL}}, 0},
        {"intensity=exact, 16 samples", 16, {{"intensity", "exact"}}, 1},
        {"tolerance=1/64", 0, {{"tolerance", "0.015625"}}, 1},
        {"tolerance=1/64 keep=yes", 0, {{"tolerance", "0.015625"}, {"keep", "yes"}}, 2},
    };
    enum { mode_count = sizeof(modes) / sizeof(modes[0]) };
    static float positions[3 * points], normals[3 * points];
    static float truth[2][points], seen[mode_count][2][points];
    for (int i = 0; i < points; i++) {
        positions[3 * i] = (float)(4 * (2 * (i % side + 0.5) / side - 1));
        positions[3 * i + 2] = (float)(4 * (2 * (i / side + 0.5) / side - 1));
        normals[3 * i + 1] = 1;
    }
    pnb_receivers receivers = {.count = points, .positions = positions, .normals = normals};
    pnb_context *context;
    pnb_light begin;
    pnb_solver *solvers[mode_count];
    double worst[mode_count] = {0}, mean[mode_count] = {0}, ms[mode_count] = {0},
           error[mode_count] = {0};
    if (pnb_context_create(NULL, &context))
        exit(1);
    pnb_scene *scene = load(context, name, &begin);
    if (!place_of(&begin)) {
        fprintf(stderr, "penumbra: error: %s: its light is none that can be moved here\n", name);
        exit(1);
    }
    pnb_solver_param area = {"exact-area", "on"};
    pnb_solver *exact = solver_of(context, scene, "exact", 4096, &area, 1);
    for (int m = 0; m < mode_count; m++)
        solvers[m] =
            solver_of(context, scene, "planar", modes[m].samples, modes[m].params, modes[m].count);
    for (int step = 0; step <= steps; step++) {
        pnb_light light = begin;
        place_of(&light)[0] += 0.3 * step / steps;
        place_of(&light)[2] += 0.1 * step / steps;
        int now = step & 1, old = !now;
        if (pnb_solver_visibility(exact, &light, &receivers, truth[now]))
            bench_die(context);
        for (int m = 0; m < mode_count; m++) {
            if (pnb_solver_visibility(solvers[m], &light, &receivers, seen[m][now]))
                bench_die(context);
            pnb_solver_report report;
            pnb_solver_get_report(solvers[m], &report);
            double jump = 0;
            for (int i = 0; i < points; i++) {
                if (isnan(seen[m][now][i]))
                    continue;
                error[m] = fmax(error[m], fabs(seen[m][now][i] - truth[now][i]));
                if (step > 0)
                    jump = fmax(jump, fabs(seen[m][now][i] - seen[m][old][i] -
                                           (truth[now][i] - truth[old][i])));
            }
            if (step > 0) {
                worst[m] = fmax(worst[m], jump);
                mean[m] += jump / steps;
                ms[m] += report.visibility_ms / steps;
            }
        }
    }
    if (json)
        printf("%s\n {\"scene\": \"%s\", \"steady\": [", first ? "" : ",", name);
    for (int m = 0; m < mode_count; m++) {
        if (json)
            printf("%s\n  {\"mode\": \"%s\", \"worst_jump\": %g, \"mean_jump\": %g, "
                   "\"max_error\": %g, \"ms\": %g}",
                   m ? "," : "", modes[m].name, worst[m], mean[m], error[m], ms[m]);
        else
            printf("%-28s %-28s %8.3f %8.3f %8.3f %8.1f\n", name, modes[m].name, worst[m], mean[m],
                   error[m], ms[m]);
        pnb_solver_destroy(solvers[m]);
    }
    if (json)
        printf("]}");
    fflush(stdout);
    pnb_solver_destroy(exact);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static void help(void)
{
    printf("usage: penumbra bench planar-tolerance [--json] [--steady | --tolerance T] [--places] "
           "[SCENE...]\n"
           "--places shows the worst points. "
           "SCENE is anything that penumbra loads, or one of the planar suite's meshes: blob knot "
           "box slabs\n");
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {
        "builtin:two-boxes", "builtin:pole", "builtin:knot", "builtin:disk", "builtin:blocker",
        "builtin:room",      "blob",         "knot",         "box",          "slabs"};
    static const char *const moving[] = {"builtin:two-boxes", "builtin:knot", "builtin:pole"};
    double tolerance = 1.0 / 255;
    bool json = false, first = true, steady = false, places = false;
    const char *const *scenes = usual;
    int count = sizeof(usual) / sizeof(usual[0]), i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--json") == 0) {
            json = true;
        } else if (strcmp(argv[i], "--steady") == 0) {
            steady = true;
        } else if (strcmp(argv[i], "--places") == 0) {
            places = true;
        } else if (strcmp(argv[i], "--tolerance") == 0 && i + 1 < argc && atof(argv[i + 1]) > 0) {
            tolerance = atof(argv[++i]);
        } else {
            help();
            return strcmp(argv[i], "--help") ? 2 : 0;
        }
    }
    if (steady) {
        scenes = moving;
        count = sizeof(moving) / sizeof(moving[0]);
    }
    if (i < argc) {
        scenes = (const char *const *)argv + i;
        count = argc - i;
    }
    if (json)
        printf("{\"suite\": \"planar-tolerance\", \"rows\": [");
    else if (steady)
        printf("%-28s %-28s %8s %8s %8s %8s\n", "scene", "mode", "jump", "mean", "error", "ms");
    else
        printf("%-28s %8s %8s | %6s %8s | %8s %6s %8s | %8s %8s %8s\n", "scene", "penumbra",
               "umbra", "max", "within", "penumbra", "max", "within", "exact", "ms", "cpu ms");
    for (int k = 0; k < count; k++) {
        if (steady)
            steadiness(scenes[k], json, first);
        else
            measure(scenes[k], tolerance, json, places && !json, first);
        first = false;
    }
    if (json)
        printf("\n]}\n");
    return 0;
}
