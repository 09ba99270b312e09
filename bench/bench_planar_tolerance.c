/* bench/bench_planar_tolerance.c: 'penumbra bench planar-tolerance': does a mesh with a promised
 * error keep its promise, with how many triangles, in what time.
 *
 * Per scene: the mesh of -p tolerance=T (1/255 unless --tolerance says otherwise), compared with
 * `exact` at 4,096 samples and lengths along rows, at 100,000 random points of the receiving plane
 * and at as many within the shadow's bounds, where the mesh has something to say:
 *   triangles   penumbra: 0 < intensity < 1 somewhere in them; umbra: all 1
 *   max         largest error, in 1/255
 *   within      share of the points that are off by no more than T, in percent
 *   ms          least of three, wall clock, on the context's threads
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#define POINTS 100000

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", pnb_context_error(context));
    exit(1);
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
        die(context);
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

static void measure(const char *name, double tolerance, const char *extra_key,
                    const char *extra_value, bool json, bool first)
{
    pnb_context *context;
    pnb_scene *scene;
    char text[32];
    snprintf(text, sizeof(text), "%.9g", tolerance);
    pnb_solver_param params[2] = {{"tolerance", text}, {extra_key, extra_value}};
    size_t param_count = extra_key ? 2 : 1;
    if (pnb_context_create(NULL, &context) || pnb_scene_load(context, name, &scene))
        die(context);
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    pnb_solver_desc desc = {.params = params, .param_count = param_count};
    double best = 1e30;
    pnb_shadow *shadow = NULL;
    pnb_solver_report report;
    for (int i = 0; i < 3; i++) {
        pnb_shadow_destroy(shadow);
        if (pnb_shadow_create(context, scene, &light, &desc, &shadow))
            die(context);
        pnb_shadow_get_report(shadow, &report);
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
    pnb_solver *planar = solver_of(context, scene, "planar", 0, params, param_count);
    struct errors e[2];
    for (int k = 0; k < 2; k++) {
        struct points p =
            make_points(&plane, view.planes[0], k ? lo : all_lo, k ? hi : all_hi, POINTS);
        if (pnb_solver_visibility(exact, &light, &p.receivers, p.truth) ||
            pnb_solver_visibility(planar, &light, &p.receivers, p.seen))
            die(context);
        e[k] = judge(&p, tolerance);
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
               "\"penumbra_within_percent\": %g, \"evaluations\": %g, \"ms\": %g}",
               first ? "" : ",", name, tolerance, penumbra, umbra, e[0].max, e[0].within,
               e[1].penumbra, e[1].max, e[1].within_penumbra, evaluations, best);
    else
        printf("%-28s %8zu %8zu | %6.2f %8.3f | %8zu %6.2f %8.3f | %8.0f %8.1f\n", name, penumbra,
               umbra, 255 * e[0].max, e[0].within, e[1].penumbra, 255 * e[1].max,
               e[1].within_penumbra, evaluations, best);
    fflush(stdout);
    pnb_solver_destroy(exact);
    pnb_solver_destroy(planar);
    pnb_shadow_destroy(shadow);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static void help(void)
{
    printf("usage: penumbra bench planar-tolerance [--json] [--tolerance T] [SCENE...]\n");
}

int main(int argc, char **argv)
{
    static const char *const usual[] = {"builtin:two-boxes", "builtin:pole", "builtin:knot",
                                        "builtin:disk"};
    double tolerance = 1.0 / 255;
    bool json = false, first = true;
    const char *const *scenes = usual;
    int count = sizeof(usual) / sizeof(usual[0]), i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--json") == 0) {
            json = true;
        } else if (strcmp(argv[i], "--tolerance") == 0 && i + 1 < argc && atof(argv[i + 1]) > 0) {
            tolerance = atof(argv[++i]);
        } else {
            help();
            return strcmp(argv[i], "--help") ? 2 : 0;
        }
    }
    if (i < argc) {
        scenes = (const char *const *)argv + i;
        count = argc - i;
    }
    if (json)
        printf("{\"suite\": \"planar-tolerance\", \"rows\": [");
    else
        printf("%-28s %8s %8s | %6s %8s | %8s %6s %8s | %8s %8s\n", "scene", "penumbra", "umbra",
               "max", "within", "penumbra", "max", "within", "exact", "ms");
    for (int k = 0; k < count; k++) {
        measure(scenes[k], tolerance, NULL, NULL, json, first);
        first = false;
    }
    if (json)
        printf("\n]}\n");
    return 0;
}
