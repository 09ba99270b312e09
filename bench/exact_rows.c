/* bench/exact_rows.c: see exact_rows.h.
 *
 * Lights are horizontal squares, disks, L-shapes, lines, suns over the scene, of the size asked
 * seen from the casters' middle, or the scene's own first one. Frame times leave out what is made
 * once per mesh. At equal error: the reference's time is scaled to the number of samples that would
 * bring it to exact's error, by the slope that it has between as many samples and four times as
 * many.
 */
#include "exact_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void bench_die(pnb_context *context)
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

static void make_light(const pnb_scene *scene, const struct light_desc *desc, pnb_light *light)
{
    if (desc->shape == SHAPE_OWN) {
        pnb_scene_light(scene, 0, light);
        return;
    }
    double low[3], high[3], center[3], radius = 0;
    caster_bounds(scene, low, high);
    for (int a = 0; a < 3; a++) {
        center[a] = 0.5 * (low[a] + high[a]);
        radius += 0.25 * (high[a] - low[a]) * (high[a] - low[a]);
    }
    radius = sqrt(radius);
    const double way[3] = {0.25, 1, 0.15};
    double length = sqrt(way[0] * way[0] + 1 + way[2] * way[2]), distance = 3 * radius;
    double half = distance * tan(desc->degrees * M_PI / 360), at[3];
    double c = cos(desc->turn), s = sin(desc->turn);
    for (int a = 0; a < 3; a++)
        at[a] = center[a] + way[a] / length * distance;
    memset(light, 0, sizeof(*light));
    for (int a = 0; a < 3; a++)
        light->color[a] = 1;
    if (desc->shape == SHAPE_DISK) {
        light->type = PNB_LIGHT_DISK;
        memcpy(light->shape.disk.center, at, sizeof(at));
        light->shape.disk.normal[1] = -1;
        light->shape.disk.radius = half;
    } else if (desc->shape == SHAPE_L) {
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
    } else if (desc->shape == SHAPE_LINE) {
        light->type = PNB_LIGHT_LINE;
        const double along[3] = {half * c, 0, half * s};
        for (int a = 0; a < 3; a++) {
            light->shape.line.from[a] = at[a] - along[a];
            light->shape.line.to[a] = at[a] + along[a];
        }
    } else if (desc->shape == SHAPE_POINT) {
        light->type = PNB_LIGHT_POINT;
        memcpy(light->shape.point.position, at, sizeof(at));
    } else if (desc->shape == SHAPE_SUN) {
        light->type = PNB_LIGHT_SUN;
        for (int a = 0; a < 3; a++)
            light->shape.sun.direction[a] = -way[a];
        light->shape.sun.angular_diameter_degrees = desc->degrees;
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
        bench_die(context);
    return solver;
}

static double frame(pnb_context *context, pnb_solver *solver, const pnb_light *light,
                    const pnb_receivers *receivers, float *visibility, int runs,
                    pnb_solver_report *report)
{
    double best = INFINITY;
    for (int i = 0; i < runs; i++) {
        if (pnb_solver_visibility(solver, light, receivers, visibility) != PNB_OK)
            bench_die(context);
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
        bench_die(context);
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
        bench_die(context);
    pnb_solver_destroy(solver);
    double sum = 0;
    for (size_t i = 0; i < s->count; i++)
        sum += (double)(v[i] - s->truth[i]) * (v[i] - s->truth[i]);
    free(v);
    return s->count ? sqrt(sum / (double)s->count) : 0;
}

void bench_exact_row(pnb_context *context, const struct options *o, const char *path,
                     const struct light_desc *desc, struct row *row)
{
    const char *name = strrchr(path, path[0] == 'b' && strchr(path, ':') ? ':' : '/');
    name = name ? name + 1 : path;
    pnb_scene *scene;
    if (pnb_scene_load(context, path, &scene) != PNB_OK)
        bench_die(context);
    pnb_surface *surface;
    if (pnb_surface_create(context, scene, NULL, o->width, o->height, &surface) != PNB_OK)
        bench_die(context);
    pnb_receivers receivers;
    pnb_surface_receivers(surface, &receivers);
    pnb_light light;
    make_light(scene, desc, &light);
    float *exact = malloc(receivers.count * sizeof(float));
    float *traced = malloc(receivers.count * sizeof(float));
    memset(row, 0, sizeof(*row));
    snprintf(row->scene, sizeof(row->scene), "%s", name);
    snprintf(row->light, sizeof(row->light), "%s", desc->label);
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
    row->penumbra = subset.count;
    for (size_t i = 0; i < receivers.count; i++)
        row->apart += fabsf(exact[i] - traced[i]) > 0.1f;
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
