/* bench/bench_exact.c: 'penumbra bench exact': time and error of `exact` against ray tracing.
 *
 * Per scene and light: one frame of `exact` (best of a few) and of `reference` at as many samples,
 * through the same public calls, and the errors of both against 65,536 rays on a random choice of
 * penumbra pixels that face the whole light. Frame times leave out what is made once per mesh.
 * At equal error: the reference's time is scaled to the number of samples that would bring it to
 * exact's error, by the slope that it has between 1,024 and 4,096 samples.
 *
 * Lights are horizontal squares over the scene that are seen under 12 (M) or 40 (L) degrees from
 * the casters' middle; r: turned by 30 degrees. Then a disk and an L-shaped polygon.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

struct options {
    int width, height, samples, truth_samples, truth_pixels, runs;
    bool json, curves;
    const char *scene;  /* only this one */
    const char *lights; /* only these labels, separated by commas */
};

struct row {
    char scene[64], light[16];
    size_t triangles;
    bool closed;
    double exact_ms, reference_ms, prepare_ms, exact_rmse, reference_rmse, exact_p99;
    double speed, equal_speed;
    double values[PNB_COUNTER_MAX];
    char names[PNB_COUNTER_MAX][32];
    size_t counter_count;
};

static void die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", pnb_context_error(context));
    exit(1);
}

/* Bounds of the casters that are no planes. */
static void caster_bounds(const pnb_scene *scene, double *low, double *high)
{
    for (int a = 0; a < 3; a++)
        low[a] = INFINITY, high[a] = -INFINITY;
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(scene, i, &object);
        pnb_scene_mesh(scene, object.mesh, &mesh);
        if (object.plane || !object.casts)
            continue;
        const double *m = object.world_from_mesh;
        for (size_t v = 0; v < mesh.vertex_count; v++)
            for (int a = 0; a < 3; a++) {
                const float *p = mesh.positions + 3 * v;
                double x =
                    m[4 * a] * p[0] + m[4 * a + 1] * p[1] + m[4 * a + 2] * p[2] + m[4 * a + 3];
                low[a] = fmin(low[a], x);
                high[a] = fmax(high[a], x);
            }
    }
}

static double polygon[18];

static void make_light(const pnb_scene *scene, char shape, double degrees, double turn,
                       pnb_light *light)
{
    double low[3], high[3], center[3], radius = 0;
    caster_bounds(scene, low, high);
    for (int a = 0; a < 3; a++) {
        center[a] = 0.5 * (low[a] + high[a]);
        radius += 0.25 * (high[a] - low[a]) * (high[a] - low[a]);
    }
    radius = sqrt(radius);
    const double way[3] = {0.25, 1, 0.15};
    double length = sqrt(way[0] * way[0] + 1 + way[2] * way[2]), distance = 3 * radius;
    double half = distance * tan(degrees * M_PI / 360), c = cos(turn), s = sin(turn), at[3];
    for (int a = 0; a < 3; a++)
        at[a] = center[a] + way[a] / length * distance;
    memset(light, 0, sizeof(*light));
    for (int a = 0; a < 3; a++)
        light->color[a] = 1;
    if (shape == 'd') {
        light->type = PNB_LIGHT_DISK;
        memcpy(light->shape.disk.center, at, sizeof(at));
        light->shape.disk.normal[1] = -1;
        light->shape.disk.radius = half;
    } else if (shape == 'L') {
        static const double corners[6][2] = {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
        for (int i = 0; i < 6; i++) {
            double x = half * (corners[i][0] - 1), z = half * (corners[i][1] - 1);
            polygon[3 * i] = at[0] + x;
            polygon[3 * i + 1] = at[1];
            polygon[3 * i + 2] = at[2] + z;
        }
        light->type = PNB_LIGHT_POLYGON;
        light->shape.polygon.vertices = polygon;
        light->shape.polygon.vertex_count = 6;
    } else {
        light->type = PNB_LIGHT_RECTANGLE;
        memcpy(light->shape.rectangle.center, at, sizeof(at));
        double *u = light->shape.rectangle.half_u, *v = light->shape.rectangle.half_v;
        u[0] = half * c, u[2] = half * s;
        v[0] = -half * s, v[2] = half * c; /* u x v points down */
    }
}

static pnb_solver *make_solver(pnb_context *context, pnb_scene *scene, const char *method,
                               int samples)
{
    pnb_solver_desc desc = {.method = method, .samples = samples};
    pnb_solver *solver;
    if (pnb_solver_create(context, scene, &desc, &solver) != PNB_OK)
        die(context);
    return solver;
}

static double frame(pnb_context *context, pnb_solver *solver, const pnb_light *light,
                    const pnb_receivers *receivers, float *visibility, int runs,
                    pnb_solver_report *report)
{
    double best = INFINITY;
    for (int i = 0; i < runs; i++) {
        if (pnb_solver_visibility(solver, light, receivers, visibility) != PNB_OK)
            die(context);
        pnb_solver_get_report(solver, report);
        best = fmin(best, report->visibility_ms);
    }
    return best;
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

struct subset {
    size_t count, *pixels;
    float *positions, *normals, *truth;
};

static double rmse(const struct subset *s, const float *visibility, double *p99)
{
    double sum = 0;
    float *errors = malloc((s->count + 1) * sizeof(*errors));
    size_t count = 0;
    for (size_t i = 0; i < s->count; i++) {
        float e = visibility[s->pixels[i]] - s->truth[i];
        if ((s->truth[i] <= 0 || s->truth[i] >= 1) && fabsf(e) <= 1.0f / 255)
            continue;
        errors[count++] = fabsf(e);
        sum += (double)e * e;
    }
    qsort(errors, count, sizeof(*errors), compare_floats);
    if (p99)
        *p99 = count ? errors[(size_t)(0.99 * (double)(count - 1))] : 0;
    free(errors);
    return count ? sqrt(sum / (double)count) : 0;
}

/* Truth on a random choice of the pixels that either method sees partly shadowed. */
static void choose(pnb_context *context, pnb_solver *truth, const struct options *o,
                   const pnb_light *light, const pnb_receivers *receivers, const float *a,
                   const float *b, struct subset *s)
{
    uint8_t *facing = malloc(receivers->count);
    size_t *partly = malloc((receivers->count + 1) * sizeof(*partly)), count = 0;
    pnb_measure_facing(light, receivers, facing);
    for (size_t i = 0; i < receivers->count; i++)
        if (facing[i] && ((a[i] > 0 && a[i] < 1) || (b[i] > 0 && b[i] < 1)))
            partly[count++] = i;
    s->count = count < (size_t)o->truth_pixels ? count : (size_t)o->truth_pixels;
    s->pixels = malloc((s->count + 1) * sizeof(*s->pixels));
    s->positions = malloc((s->count + 1) * 3 * sizeof(float));
    s->normals = malloc((s->count + 1) * 3 * sizeof(float));
    s->truth = malloc((s->count + 1) * sizeof(float));
    uint64_t state = 1;
    for (size_t i = 0; i < s->count; i++) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        size_t k = i + (size_t)((double)(state >> 11) * 0x1p-53 * (double)(count - i));
        s->pixels[i] = partly[k];
        partly[k] = partly[i];
        memcpy(s->positions + 3 * i, receivers->positions + 3 * s->pixels[i], 3 * sizeof(float));
        memcpy(s->normals + 3 * i, receivers->normals + 3 * s->pixels[i], 3 * sizeof(float));
    }
    pnb_receivers points = {.count = s->count, .positions = s->positions, .normals = s->normals};
    if (s->count > 0 && pnb_solver_visibility(truth, light, &points, s->truth) != PNB_OK)
        die(context);
    free(facing);
    free(partly);
}

static double at_points(pnb_context *context, pnb_scene *scene, int samples, const pnb_light *light,
                        const struct subset *s)
{
    pnb_receivers points = {.count = s->count, .positions = s->positions, .normals = s->normals};
    float *v = malloc((s->count + 1) * sizeof(*v));
    pnb_solver *solver = make_solver(context, scene, "reference", samples);
    if (s->count > 0 && pnb_solver_visibility(solver, light, &points, v) != PNB_OK)
        die(context);
    pnb_solver_destroy(solver);
    double sum = 0;
    for (size_t i = 0; i < s->count; i++)
        sum += (double)(v[i] - s->truth[i]) * (v[i] - s->truth[i]);
    free(v);
    return s->count ? sqrt(sum / (double)s->count) : 0;
}

static void measure(pnb_context *context, const struct options *o, const char *name, char shape,
                    double degrees, double turn, const char *label, struct row *row)
{
    char path[80];
    pnb_scene *scene;
    snprintf(path, sizeof(path), "builtin:%s", name);
    if (pnb_scene_load(context, path, &scene) != PNB_OK)
        die(context);
    pnb_surface *surface;
    if (pnb_surface_create(context, scene, NULL, o->width, o->height, &surface) != PNB_OK)
        die(context);
    pnb_receivers receivers;
    pnb_surface_receivers(surface, &receivers);
    pnb_light light;
    make_light(scene, shape, degrees, turn, &light);
    float *exact = malloc(receivers.count * sizeof(float));
    float *traced = malloc(receivers.count * sizeof(float));
    memset(row, 0, sizeof(*row));
    snprintf(row->scene, sizeof(row->scene), "%s", name);
    snprintf(row->light, sizeof(row->light), "%s", label);
    row->triangles = pnb_scene_triangle_count(scene);
    row->closed = strncmp(name, "leaves", 6) != 0;

    pnb_solver_report report;
    pnb_solver *solver = make_solver(context, scene, "exact", o->samples);
    row->exact_ms = frame(context, solver, &light, &receivers, exact, o->runs, &report);
    row->prepare_ms = report.prepare_ms;
    row->counter_count = report.counter_count;
    for (size_t i = 0; i < report.counter_count; i++) {
        snprintf(row->names[i], sizeof(row->names[i]), "%s", report.counters[i].name);
        row->values[i] = report.counters[i].value;
    }
    pnb_solver_destroy(solver);
    solver = make_solver(context, scene, "reference", o->samples);
    row->reference_ms = frame(context, solver, &light, &receivers, traced, 1, &report);
    pnb_solver_destroy(solver);

    struct subset subset;
    pnb_solver *truth = make_solver(context, scene, "reference", o->truth_samples);
    choose(context, truth, o, &light, &receivers, exact, traced, &subset);
    pnb_solver_destroy(truth);
    row->exact_rmse = rmse(&subset, exact, &row->exact_p99);
    row->reference_rmse = rmse(&subset, traced, NULL);
    row->speed = row->reference_ms / row->exact_ms;
    double e1 = at_points(context, scene, o->samples, &light, &subset);
    double e4 = at_points(context, scene, 4 * o->samples, &light, &subset);
    double slope = e1 > e4 && e4 > 0 ? log(e1 / e4) / log(4) : 0.5;
    row->equal_speed =
        row->exact_rmse > 0 && row->reference_rmse > 0
            ? row->speed * pow(row->reference_rmse / row->exact_rmse, 1 / fmax(slope, 0.4))
            : row->speed;

    free(subset.pixels);
    free(subset.positions);
    free(subset.normals);
    free(subset.truth);
    free(exact);
    free(traced);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
}

static double counter(const struct row *row, const char *name)
{
    for (size_t i = 0; i < row->counter_count; i++)
        if (strcmp(row->names[i], name) == 0)
            return row->values[i];
    return 0;
}

static void print_row(const struct options *o, const struct row *row, bool first)
{
    if (o->json) {
        printf(
            "%s\n  {\"scene\": \"%s\", \"light\": \"%s\", \"triangles\": %zu, \"exact_ms\": %.3f, "
            "\"reference_ms\": %.1f, \"prepare_ms\": %.1f, \"exact_rmse\": %.6f, "
            "\"exact_p99\": %.6f, \"reference_rmse\": %.6f, \"speed\": %.2f, "
            "\"speed_at_equal_error\": %.2f, \"lit\": %.0f, \"umbra\": %.0f, \"sampled\": %.0f, "
            "\"closed_form\": %.0f, \"edges_per_tile\": %.1f, \"loose_per_tile\": %.1f, "
            "\"bytes_per_triangle\": %.1f}",
            first ? "" : ",", row->scene, row->light, row->triangles, row->exact_ms,
            row->reference_ms, row->prepare_ms, row->exact_rmse, row->exact_p99,
            row->reference_rmse, row->speed, row->equal_speed, counter(row, "lit"),
            counter(row, "umbra"), counter(row, "sampled"), counter(row, "closed_form"),
            counter(row, "edges_per_tile"), counter(row, "loose_per_tile"),
            counter(row, "bytes_per_triangle"));
    } else {
        printf("| %s | %s | %zu | %.1f | %.0f | %.1f | %.1f | %.2f | %.2f | %.1f | %.0f |\n",
               row->scene, row->light, row->triangles, row->exact_ms, row->reference_ms, row->speed,
               row->equal_speed, 1e3 * row->exact_rmse, 1e3 * row->reference_rmse,
               1e3 * row->exact_p99, counter(row, "edges_per_tile"));
    }
    fflush(stdout);
}

static void print_head(const struct options *o)
{
    if (o->json)
        return;
    printf("\n| scene | light | triangles | exact ms | reference ms | times | at equal error | "
           "RMSE x 1e-3 | reference's | p99 x 1e-3 | edges a tile |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
}

static bool listed(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *c = list; c; c = strchr(c, ',') ? strchr(c, ',') + 1 : NULL)
        if (strncmp(c, word, length) == 0 && (c[length] == 0 || c[length] == ','))
            return true;
    return !list;
}

static int usage(void)
{
    printf("usage: penumbra bench exact [--json] [--size WxH] [--samples N] [--runs N]\n"
           "         [--truth N] [--pixels N] [--scene NAME]\n"
           "         [--lights LABEL,...] [--no-curves]\n\n"
           "Time and error of the method exact against ray tracing, scene by scene.\n");
    return 0;
}

int main(int argc, char **argv)
{
    struct options o = {800, 600, 1024, 65536, 1000, 3, false, true, NULL, NULL};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--help") == 0)
            return usage();
        if (strcmp(argv[i], "--json") == 0)
            o.json = true;
        else if (strcmp(argv[i], "--no-curves") == 0)
            o.curves = false;
        else if (strcmp(argv[i], "--size") == 0 &&
                 sscanf(value, "%dx%d", &o.width, &o.height) == 2 && o.width > 0 && o.height > 0)
            i++;
        else if (strcmp(argv[i], "--samples") == 0 && (o.samples = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--runs") == 0 && (o.runs = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--truth") == 0 && (o.truth_samples = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--pixels") == 0 && (o.truth_pixels = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--lights") == 0 && *value)
            o.lights = argv[++i];
        else if (strcmp(argv[i], "--scene") == 0 && *value)
            o.scene = argv[++i];
        else {
            fprintf(stderr, "penumbra: error: %s: unknown option, see --help\n", argv[i]);
            return 2;
        }
    }
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    if (o.json)
        printf("{\"suite\": \"exact\", \"threads\": %d, \"samples\": %d, \"rows\": [",
               pnb_context_threads(context), o.samples);
    else
        printf("%d threads, %dx%d, %d samples, truth %d samples on %d penumbra pixels\n",
               pnb_context_threads(context), o.width, o.height, o.samples, o.truth_samples,
               o.truth_pixels);

    static const char *const scenes[] = {"prism",         "fence",         "spheres-9x9",
                                         "spheres-3x3x3", "spheres-9x9x9", "knot-96k",
                                         "knot-768k",     "leaves-20k"};
    static const struct {
        char shape;
        double degrees, turn;
        const char *label;
    } lights[] = {{'r', 12, 0, "M"},          {'r', 40, 0, "L"},       {'r', 12, M_PI / 6, "M r"},
                  {'r', 40, M_PI / 6, "L r"}, {'d', 12, 0, "disk 12"}, {'L', 12, 0, "L-shape 12"}};
    double log_sum = 0, least = INFINITY, error_sum = 0, reference_sum = 0, leaves = INFINITY;
    double worst_rmse = 0, worst_p99 = 0;
    int closed = 0, rows = 0, printed = 0;
    struct row row;
    print_head(&o);
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++)
        for (size_t l = 0; l < sizeof(lights) / sizeof(*lights); l++) {
            if ((o.scene && strcmp(o.scene, scenes[s]) != 0) || !listed(o.lights, lights[l].label))
                continue;
            measure(context, &o, scenes[s], lights[l].shape, lights[l].degrees, lights[l].turn,
                    lights[l].label, &row);
            print_row(&o, &row, printed++ == 0);
            worst_rmse = fmax(worst_rmse, row.exact_rmse);
            worst_p99 = fmax(worst_p99, row.exact_p99);
            if (row.exact_rmse > 0 && row.reference_rmse > 0) {
                error_sum += log(row.exact_rmse);
                reference_sum += log(row.reference_rmse);
                rows++;
            }
            if (row.closed) {
                log_sum += log(row.speed);
                least = fmin(least, row.speed);
                closed++;
            } else if (lights[l].degrees == 12) {
                leaves = fmin(leaves, row.speed);
            }
        }
    if (!o.json)
        printf(
            "\nclosed meshes: %.1f times in the geometric mean, least %.1f; leaves at 12 degrees "
            "%.1f; RMSE %.2f against %.2f x 1e-3 in the geometric mean, worst %.2f, p99 %.1f\n",
            exp(log_sum / fmax(closed, 1)), least, leaves, 1e3 * exp(error_sum / fmax(rows, 1)),
            1e3 * exp(reference_sum / fmax(rows, 1)), 1e3 * worst_rmse, 1e3 * worst_p99);

    if (o.curves && !o.scene) {
        static const char *const knots[] = {"knot", "knot-96k", "knot-768k"};
        static const double sizes[] = {3, 6, 12, 24, 40};
        if (!o.json)
            printf("\nOver the number of triangles, and over the light's size:\n");
        print_head(&o);
        for (size_t i = 0; i < 3; i++) {
            measure(context, &o, knots[i], 'r', 12, 0, "12", &row);
            print_row(&o, &row, printed++ == 0);
        }
        for (size_t i = 0; i < 5; i++) {
            char label[16];
            snprintf(label, sizeof(label), "%g", sizes[i]);
            measure(context, &o, "knot-96k", 'r', sizes[i], 0, label, &row);
            print_row(&o, &row, printed++ == 0);
        }
    }
    if (o.json)
        printf(
            "\n],\n\"geometric_mean_closed\": %.2f, \"least_closed\": %.2f, \"least_leaves_12\": "
            "%.2f, \"worst_rmse\": %.6f, \"worst_p99\": %.6f}\n",
            exp(log_sum / fmax(closed, 1)), least, isfinite(leaves) ? leaves : 0, worst_rmse,
            worst_p99);
    pnb_context_destroy(context);
    return 0;
}
