/* hunt.c: looks for errors in every method at once: all built-in scenes under all shapes of light,
 * the shared models, and random scenes that are made to hurt (soups, slivers, duplicates, zero
 * areas, scales from 1e-4 to 1e4, lights inside occluders, on their vertices, in the ground).
 *
 *   hunt [RANDOM [FIRST [METHOD]]]        1000 random scenes from seed 0, all methods
 *   hunt quick [RANDOM [FIRST [METHOD]]]  the random scenes alone
 *   hunt case NAME [METHOD]               one case, as a surprise names it; HUNT_SCENE=FILE.json
 *                                         in the environment writes it as a scene file
 *
 * Asked of every method that does not refuse: visibility in [0,1], NaN only for what is no receiver
 * or (planes only) none of its; the same bytes when asked again and with another number of threads;
 * after objects moved and pnb_solver_update() the same as a new solver; no crash, no hang. Each
 * method runs in a process of its own; when it dies the hunt goes on behind the case. Errors
 * against rays are collected, and judged only where they are gross, or those of `exact`.
 *
 * The last line counts the surprises; exit status 1 if there are any. Surprises that are known and
 * written in the methods' documents are counted apart: hunt_known[].
 */
#define _GNU_SOURCE
#include <penumbra/penumbra.h>

#include <dirent.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, TRUTH_SAMPLES = 256 };

/* Of the processor (all threads), and on the clock for who waits for ever. */
enum { LIMIT_S = 90, PATIENCE_S = 1200 };

/* No approximation takes light for dark on so many pixels. */
#define GROSS_ERROR 0.9
#define GROSS_SHARE 0.04
#define EXACT_BOUND 0.2 /* `exact` beyond this at some pixel is a surprise: 256 rays are noisy */

/* ---- cases ---- */

struct hunted {
    char name[200]; /* "prism/disk", "cow.obj/own", "random 17" */
    char path[400]; /* "" for random ones */
    int light;      /* -1: the scene's own, else a pnb_light_type */
    uint64_t seed;
};

static struct hunted *cases;
static size_t case_count;
static bool talkative; /* one case alone */

static void add_case(const char *name, const char *path, int light, uint64_t seed)
{
    if (case_count % 256 == 0)
        cases = realloc(cases, (case_count + 256) * sizeof(*cases));
    if (!cases)
        exit(2);
    struct hunted *c = &cases[case_count++];
    *c = (struct hunted){.light = light, .seed = seed};
    snprintf(c->path, sizeof(c->path), "%s", path);
    if (*path)
        snprintf(c->name, sizeof(c->name), "%s/%s", name,
                 light < 0 ? "own" : pnb_light_type_name((pnb_light_type)light));
    else
        snprintf(c->name, sizeof(c->name), "random %llu", (unsigned long long)seed);
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static void add_models(void)
{
    const char *folder = getenv("PNB_MODELS"), *names[256];
    size_t count = 0;
    char path[400];
    if (!folder)
        folder = HUNT_MODELS;
    DIR *listing = opendir(folder);
    for (struct dirent *entry; listing && (entry = readdir(listing)) && count < 256;)
        if (strstr(entry->d_name, ".obj"))
            names[count++] = strdup(entry->d_name);
    if (listing)
        closedir(listing);
    qsort(names, count, sizeof(*names), by_name);
    for (size_t i = 0; i < count; i++)
        for (int light = -1; light < PNB_LIGHT_TYPE_COUNT; light += 2) {
            snprintf(path, sizeof(path), "%s/%s", folder, names[i]);
            add_case(names[i], path, light, 0);
        }
}

static void list_cases(long random, long first, bool quick)
{
    for (size_t i = 0; i < pnb_builtin_count() && !quick; i++) {
        pnb_builtin_info info;
        char path[200];
        pnb_builtin(i, &info);
        snprintf(path, sizeof(path), "builtin:%s", info.name);
        for (int light = -1; light < PNB_LIGHT_TYPE_COUNT; light++)
            add_case(info.name, path, light, i);
    }
    if (!quick)
        add_models();
    for (long i = 0; i < random; i++)
        add_case("", "", -1, (uint64_t)(first + i));
}

/* ---- random scenes ---- */

static uint64_t state;

static double uniform(void)
{
    state += 0x9e3779b97f4a7c15u;
    uint64_t x = state;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return (double)((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

static double between(double low, double high)
{
    return low + (high - low) * uniform();
}

static int below(int count)
{
    return (int)(uniform() * count);
}

static void random_vector(double size, double *out)
{
    for (int a = 0; a < 3; a++)
        out[a] = between(-size, size);
}

/* A mesh of at most some hundreds of triangles about the origin, of size 1. */
static pnb_status add_random_mesh(pnb_scene *scene, size_t *index)
{
    static const int box[12][3] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5},
                                   {0, 4, 5}, {0, 5, 1}, {2, 3, 7}, {2, 7, 6},
                                   {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
    float positions[600][3];
    uint32_t indices[600][3];
    size_t vertices = 0, triangles = 0;
    int kind = below(7);
    switch (kind) {
    case 0: /* a box, perhaps flat, perhaps twice in the same place */
    case 1:
        for (int copy = 0; copy <= (below(5) == 0); copy++) {
            double flat = below(4) == 0 ? 0 : 1;
            for (int t = 0; t < 12; t++)
                for (int k = 0; k < 3; k++)
                    indices[triangles + (size_t)t][k] = (uint32_t)(vertices + (size_t)box[t][k]);
            for (int v = 0; v < 8; v++) {
                positions[vertices + (size_t)v][0] = (v & 1) ? 0.5f : -0.5f;
                positions[vertices + (size_t)v][1] = (v & 2) ? (float)(0.5 * flat) : -0.5f;
                positions[vertices + (size_t)v][2] = (v & 4) ? 0.5f : -0.5f;
            }
            vertices += 8, triangles += 12;
        }
        break;
    case 2: /* an open quad */
    case 3: /* a soup, now and then of slivers, of zero areas, of equal corners */
        triangles = kind == 2 ? 2 : 1 + (size_t)below(60);
        for (size_t t = 0; t < triangles; t++) {
            double center[3], size = between(0.05, 0.6);
            random_vector(0.5, center);
            for (int k = 0; k < 3; k++) {
                for (int a = 0; a < 3; a++)
                    positions[3 * t + (size_t)k][a] =
                        (float)(center[a] + size * between(-1, 1) * (a == below(9) ? 1e-6 : 1));
                indices[t][k] = (uint32_t)(3 * t + (size_t)k);
            }
            if (below(12) == 0)
                indices[t][2] = indices[t][below(2)];
        }
        vertices = 3 * triangles;
        break;
    case 4: /* a fan around one edge: not manifold */
        positions[0][0] = positions[0][1] = positions[0][2] = 0;
        positions[1][0] = positions[1][2] = 0, positions[1][1] = 1;
        triangles = 3 + (size_t)below(8);
        vertices = 2 + triangles;
        for (size_t t = 0; t < triangles; t++) {
            double angle = 6.2831853 * (double)t / (double)triangles;
            positions[2 + t][0] = (float)cos(angle), positions[2 + t][1] = 0.5f;
            positions[2 + t][2] = (float)sin(angle);
            indices[t][0] = t % 2, indices[t][1] = 1 - t % 2, indices[t][2] = (uint32_t)(2 + t);
        }
        break;
    default: { /* a ball, open at the poles now and then */
        uint32_t around = 4 + (uint32_t)below(12), up = 3 + (uint32_t)below(8);
        for (uint32_t j = 0; j <= up; j++)
            for (uint32_t i = 0; i < around; i++) {
                double theta = 3.14159265 * j / up, phi = 6.2831853 * i / around;
                positions[vertices][0] = (float)(0.5 * sin(theta) * cos(phi));
                positions[vertices][1] = (float)(0.5 * cos(theta));
                positions[vertices++][2] = (float)(0.5 * sin(theta) * sin(phi));
            }
        for (uint32_t j = below(4) == 0; j < up; j++)
            for (uint32_t i = 0; i < around; i++) {
                uint32_t p = j * around + i, q = j * around + (i + 1) % around;
                const uint32_t quad[6] = {p, q, p + around, q, q + around, p + around};
                memcpy(indices[triangles], quad, sizeof(quad));
                triangles += 2;
            }
    }
    }
    pnb_mesh_desc mesh = {.positions = positions[0],
                          .vertex_count = vertices,
                          .indices = indices[0],
                          .triangle_count = triangles};
    return pnb_scene_add_mesh(scene, &mesh, index);
}

static void random_placement(double scale, bool spread, double *m)
{
    double axis[3], place[3], size = scale * between(0.1, 1.5);
    random_vector(1, axis);
    random_vector(spread ? 2 * scale : 0.5 * scale, place);
    double length = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]) + 1e-9;
    double angle = below(3) ? between(0, 6.28) : 0, c = cos(angle), s = sin(angle);
    for (int a = 0; a < 3; a++)
        axis[a] /= length;
    for (int row = 0; row < 3; row++)
        for (int col = 0; col < 3; col++) {
            double cross =
                row == col ? 0 : axis[3 - row - col] * ((col - row + 3) % 3 == 1 ? -1.0 : 1.0);
            m[4 * row + col] =
                size * ((row == col ? c : 0) + axis[row] * axis[col] * (1 - c) + s * cross);
        }
    m[3] = place[0], m[7] = below(4) ? fabs(place[1]) + 0.5 * size : place[1], m[11] = place[2];
    if (below(12) == 0) /* mirrored, or flat */
        for (int row = 0; row < 3; row++)
            m[4 * row] *= below(2) ? -1 : 1e-5;
}

/* Vertices of a polygon light: a regular one, now and then a star. */
static double polygon_vertices[3 * 10];

static void random_light(double scale, int type, pnb_light *light)
{
    double center[3] = {between(-2, 2) * scale, between(0.2, 4) * scale, between(-2, 2) * scale};
    double size = scale * (below(6) == 0 ? 1e-3 : below(6) == 0 ? 4 : between(0.05, 0.8)), tilt[3];
    if (below(8) == 0)
        center[1] = 0; /* in the ground */
    random_vector(below(3) ? 0.2 : 1, tilt);
    *light = (pnb_light){.type = (pnb_light_type)type, .color = {1, 1, 1}};
    double *a = light->shape.rectangle.half_u, *b = light->shape.rectangle.half_v;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        memcpy(light->shape.rectangle.center, center, sizeof(center));
        for (int k = 0; k < 3; k++) {
            a[k] = size * ((k == 0) + tilt[k]);
            b[k] = size * between(0.2, 1) * ((k == 2) + tilt[(k + 1) % 3]);
        }
        break;
    case PNB_LIGHT_DISK:
        memcpy(light->shape.disk.center, center, sizeof(center));
        for (int k = 0; k < 3; k++)
            light->shape.disk.normal[k] = tilt[k] - (k == 1);
        light->shape.disk.radius = size;
        break;
    case PNB_LIGHT_POLYGON: {
        int corners = 3 + below(6);
        bool star = below(3) == 0 && corners > 4;
        for (int i = 0; i < corners; i++) {
            double angle = 6.2831853 * i / corners, r = size * (star && i % 2 ? 0.4 : 1);
            polygon_vertices[3 * i] = center[0] + r * cos(angle);
            polygon_vertices[3 * i + 1] = center[1];
            polygon_vertices[3 * i + 2] = center[2] + r * sin(angle);
        }
        light->shape.polygon.vertices = polygon_vertices;
        light->shape.polygon.vertex_count = (size_t)corners;
        break;
    }
    case PNB_LIGHT_LINE:
        for (int k = 0; k < 3; k++) {
            light->shape.line.from[k] = center[k] - size * ((k == 0) + tilt[k]);
            light->shape.line.to[k] = center[k] + size * ((k == 0) + tilt[k]);
        }
        break;
    case PNB_LIGHT_POINT: memcpy(light->shape.point.position, center, sizeof(center)); break;
    case PNB_LIGHT_SUN:
        for (int k = 0; k < 3; k++)
            light->shape.sun.direction[k] = tilt[k] - (k == 1);
        light->shape.sun.angular_diameter_degrees = between(0.1, 20);
        break;
    }
}

static pnb_status add_ground(pnb_scene *scene, double half)
{
    const float positions[4][3] = {{(float)-half, 0, (float)-half},
                                   {(float)-half, 0, (float)half},
                                   {(float)half, 0, (float)half},
                                   {(float)half, 0, (float)-half}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    pnb_mesh_desc mesh = {
        .positions = positions[0], .vertex_count = 4, .indices = indices, .triangle_count = 2};
    pnb_object object = {.name = "ground",
                         .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                         .color = {0.8, 0.8, 0.8},
                         .casts = true,
                         .receives = true,
                         .plane = true};
    pnb_status status = pnb_scene_add_mesh(scene, &mesh, &object.mesh);
    return status == PNB_OK ? pnb_scene_add_object(scene, &object, NULL) : status;
}

static pnb_status make_random(pnb_context *context, uint64_t seed, pnb_scene **out)
{
    pnb_scene *scene = NULL;
    pnb_light light;
    state = seed * 0x2545f4914f6cdd1du + 1;
    double scale = below(3) ? 1 : pow(10, between(-4, 4));
    int objects = below(7);
    pnb_status status = pnb_scene_create(context, &scene);
    if (status == PNB_OK && (below(6) || objects == 0))
        status = add_ground(scene, scale * between(2, 20));
    for (int i = 0; i < objects && status == PNB_OK; i++) {
        pnb_object object = {
            .color = {0.7, 0.5, 0.4}, .casts = below(10) > 0, .receives = below(10) > 0};
        status = add_random_mesh(scene, &object.mesh);
        random_placement(scale, below(3) > 0, object.world_from_mesh);
        if (status == PNB_OK)
            status = pnb_scene_add_object(scene, &object, NULL);
    }
    pnb_camera camera = {.eye = {between(-2, 2) * scale, between(0.3, 4) * scale, 5 * scale},
                         .target = {0, 0.3 * scale, 0},
                         .up = {0, 1, 0},
                         .vertical_fov_degrees = between(20, 90)};
    if (status == PNB_OK)
        status = pnb_scene_set_camera(scene, &camera);
    random_light(scale, below(PNB_LIGHT_TYPE_COUNT), &light);
    if (status == PNB_OK)
        status = pnb_scene_add_light(scene, &light, NULL);
    *out = scene;
    return status;
}

/* The scene's light as another shape, about as large and in its place. */
static pnb_status change_light(pnb_scene *scene, int type, uint64_t seed)
{
    double low[3], high[3];
    if (!pnb_scene_bounds(scene, low, high))
        return PNB_OK;
    double size = 0;
    pnb_light light;
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_scene_object(scene, i, &object);
        if (object.plane)
            continue;
        pnb_mesh_info info;
        if (pnb_scene_mesh_info(scene, object.mesh, &info) == PNB_OK)
            for (int a = 0; a < 3; a++)
                size = fmax(size, fabs(object.world_from_mesh[4 * a + a]) *
                                      (info.bounds_max[a] - info.bounds_min[a]));
    }
    state = seed * 977 + (uint64_t)type;
    random_light(size > 0 ? size : 1, type, &light);
    pnb_scene_clear_lights(scene);
    return pnb_scene_add_light(scene, &light, NULL);
}

/* For people: the light of the case at hand. */
static void print_light(const pnb_light *light)
{
    const double *numbers = light->shape.rectangle.center;
    size_t count = 9;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: break;
    case PNB_LIGHT_DISK: count = 7; break;
    case PNB_LIGHT_POLYGON:
        numbers = light->shape.polygon.vertices;
        count = 3 * light->shape.polygon.vertex_count;
        break;
    case PNB_LIGHT_LINE: count = 6; break;
    case PNB_LIGHT_POINT: count = 3; break;
    case PNB_LIGHT_SUN: count = 4; break;
    }
    printf("light: %s", pnb_light_type_name(light->type));
    for (size_t i = 0; i < count; i++)
        printf("%s%.9g", i % 3 ? "," : "  ", numbers[i]);
    printf("\n");
    fflush(stdout);
}

/* ---- one method on one case ---- */

enum fate { FATE_DONE, FATE_REFUSED, FATE_SURPRISE };

struct finding {
    size_t index; /* of the case */
    enum fate fate;
    double rmse, worst, milliseconds;
    char text[300];
};

static void surprise(struct finding *finding, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void surprise(struct finding *finding, const char *format, ...)
{
    if (finding->fate == FATE_SURPRISE)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(finding->text, sizeof(finding->text), format, arguments);
    va_end(arguments);
    finding->fate = FATE_SURPRISE;
}

static void check_values(const pnb_method_info *method, const pnb_receivers *receivers,
                         const float *visibility, struct finding *finding)
{
    size_t outside = 0, missing = 0, invented = 0, first = 0;
    for (size_t i = 0; i < receivers->count; i++) {
        bool none = isnan(receivers->positions[3 * i]);
        bool bad = false;
        if (isnan(visibility[i]))
            bad = !none && method->receivers == PNB_RECEIVERS_ANY, missing += bad;
        else if (none)
            bad = true, invented++;
        else
            bad = !(visibility[i] >= 0 && visibility[i] <= 1), outside += bad;
        if (bad && outside + missing + invented == 1)
            first = i;
    }
    if (outside + missing + invented)
        surprise(finding, "%zu outside [0,1], %zu NaN, %zu where nothing is; first at %zu: %g",
                 outside, missing, invented, first, visibility[first]);
}

static void compare_values(const pnb_method_info *method, const pnb_light *light,
                           const pnb_receivers *receivers, const float *visibility,
                           const float *truth, struct finding *finding)
{
    static uint8_t mask[PIXELS], moved_mask[PIXELS];
    static float moved[3 * PIXELS];
    double sum = 0, extent = 0;
    size_t count = 0, worst = 0, upside_down = 0;
    pnb_measure_facing(light, receivers, mask);
    /* In the plane of the light rounding decides: only what a small step does not change. */
    for (size_t i = 0; i < 3 * receivers->count; i++)
        if (isfinite(receivers->positions[i]))
            extent = fmax(extent, fabs(receivers->positions[i]));
    for (int side = -1; side <= 1; side += 2) {
        pnb_receivers near = *receivers;
        for (size_t i = 0; i < 3 * receivers->count; i++)
            moved[i] =
                (float)(receivers->positions[i] + side * 3e-5 * extent * receivers->normals[i]);
        near.positions = moved;
        pnb_measure_facing(light, &near, moved_mask);
        for (size_t i = 0; i < receivers->count; i++)
            mask[i] &= moved_mask[i];
    }
    for (size_t i = 0; i < receivers->count; i++) {
        double error = fabs(visibility[i] - truth[i]);
        if (!mask[i] || isnan(error))
            continue;
        sum += error * error;
        count++;
        upside_down += error > GROSS_ERROR;
        if (error > finding->worst) {
            finding->worst = error;
            worst = i;
        }
    }
    finding->rmse = count ? sqrt(sum / (double)count) : 0;
    /* A point light is all or nothing: there a touch decides. */
    if (strcmp(method->name, "exact") == 0 && finding->worst > EXACT_BOUND &&
        light->type != PNB_LIGHT_POINT && finding->rmse > 0.01)
        surprise(finding, "off by %.3g at pixel %zu, RMSE %.3g", finding->worst, worst,
                 finding->rmse);
    /* Hard shadows of a large light are wrong by nature: they are looked at under points. */
    bool hard = strncmp(method->name, "hard-", 5) == 0 && light->type != PNB_LIGHT_POINT;
    if (!hard && upside_down > 30 && (double)upside_down > GROSS_SHARE * (double)count)
        surprise(finding, "light where it is dark or dark where it is lit: %zu of %zu pixels",
                 upside_down, count);
}

static pnb_status solve(pnb_solver *solver, const pnb_light *light, const pnb_receivers *receivers,
                        float *out)
{
    memset(out, 0x7f, receivers->count * sizeof(*out)); /* what is not written shows */
    return pnb_solver_visibility(solver, light, receivers, out);
}

/* Moves the last object a little: update must give what a new solver gives. */
static void check_update(pnb_context *context, pnb_scene *scene, const pnb_solver_desc *desc,
                         pnb_solver *solver, const pnb_light *light, struct finding *finding)
{
    static float updated[PIXELS], fresh[PIXELS];
    size_t objects = pnb_scene_object_count(scene);
    pnb_object object;
    pnb_surface *surface = NULL;
    pnb_solver *other = NULL;
    pnb_receivers receivers;
    if (objects < 2)
        return;
    pnb_scene_object(scene, objects - 1, &object);
    object.world_from_mesh[3] += 0.1 * fabs(object.world_from_mesh[0]);
    if (pnb_scene_set_placement(scene, objects - 1, object.world_from_mesh) != PNB_OK ||
        pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface) != PNB_OK)
        return;
    pnb_surface_receivers(surface, &receivers);
    pnb_status a = pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS);
    if (a == PNB_OK)
        a = solve(solver, light, &receivers, updated);
    pnb_status b = pnb_solver_create(context, scene, desc, &other);
    if (b == PNB_OK)
        b = solve(other, light, &receivers, fresh);
    size_t differ = 0;
    for (size_t i = 0; a == PNB_OK && b == PNB_OK && i < receivers.count; i++)
        differ +=
            !(fabsf(updated[i] - fresh[i]) <= 1e-3f) && !(isnan(updated[i]) && isnan(fresh[i]));
    if (a != b)
        surprise(finding, "after an update %s, as new %s", pnb_status_name(a), pnb_status_name(b));
    else if (differ)
        surprise(finding, "after an update %zu pixels differ from a new solver's", differ);
    pnb_solver_destroy(other);
    pnb_surface_destroy(surface);
}

static void try_case(const struct hunted *c, const pnb_method_info *method, struct finding *finding)
{
    static float truth[PIXELS], first[PIXELS], second[PIXELS];
    pnb_context *contexts[2] = {NULL, NULL};
    pnb_scene *scene = NULL;
    pnb_surface *surface = NULL;
    pnb_solver *solver = NULL, *reference = NULL;
    pnb_receivers receivers;
    pnb_light light;
    /* Rays are dear, and more of them hunt no better. */
    const pnb_solver_desc desc = {.method = method->name,
                                  .samples = strcmp(method->name, "reference") ? 0 : 16};
    for (int turn = 0; turn < 2; turn++) {
        pnb_context *context;
        pnb_context_desc threads = {.threads = turn ? 1 : 3};
        if (pnb_context_create(&threads, &contexts[turn]) != PNB_OK)
            exit(2);
        context = contexts[turn];
        pnb_status status = *c->path ? pnb_scene_load(context, c->path, &scene)
                                     : make_random(context, c->seed, &scene);
        if (status == PNB_OK && c->light >= 0)
            status = change_light(scene, c->light, c->seed);
        if (status == PNB_OK)
            status = pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface);
        if (status != PNB_OK) {
            finding->fate = FATE_REFUSED;
            goto next;
        }
        pnb_surface_receivers(surface, &receivers);
        pnb_scene_light(scene, 0, &light);
        if (talkative && turn == 0) {
            print_light(&light);
            if (getenv("HUNT_SCENE") && pnb_scene_write_json(scene, getenv("HUNT_SCENE")) != PNB_OK)
                fprintf(stderr, "hunt: %s\n", pnb_context_error(context));
        }
        float *visibility = turn ? second : first;
        status = pnb_solver_create(context, scene, &desc, &solver);
        if (status == PNB_OK)
            status = solve(solver, &light, &receivers, visibility);
        if (status == PNB_ERROR_UNSUPPORTED || status == PNB_ERROR_DEVICE ||
            status == PNB_ERROR_SCENE) {
            finding->fate = FATE_REFUSED;
            snprintf(finding->text, sizeof(finding->text), "%.290s", pnb_context_error(context));
        } else if (status != PNB_OK) {
            surprise(finding, "%s: %.250s", pnb_status_name(status), pnb_context_error(context));
        }
        if (status != PNB_OK)
            goto next;
        if (turn == 0) {
            pnb_solver_report report;
            pnb_solver_get_report(solver, &report);
            finding->milliseconds = report.visibility_ms;
            check_values(method, &receivers, first, finding);
            if (solve(solver, &light, &receivers, second) != PNB_OK ||
                memcmp(first, second, sizeof(first)) != 0)
                surprise(finding, "asked again it answers otherwise");
            pnb_solver_desc rays = {.method = "reference", .samples = TRUTH_SAMPLES};
            if (pnb_solver_create(context, scene, &rays, &reference) == PNB_OK &&
                pnb_solver_visibility(reference, &light, &receivers, truth) == PNB_OK)
                compare_values(method, &light, &receivers, first, truth, finding);
            check_update(context, scene, &desc, solver, &light, finding);
        } else if (memcmp(first, second, sizeof(first)) != 0) {
            surprise(finding, "one thread answers otherwise than three");
        }
    next:
        pnb_solver_destroy(reference);
        pnb_solver_destroy(solver);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
        pnb_context_destroy(contexts[turn]);
        solver = reference = NULL;
        surface = NULL;
        scene = NULL;
        if (finding->fate == FATE_REFUSED)
            return;
    }
}

/* ---- the hunt ---- */

/* Surprises that the methods' documents tell of: method, case (prefix), what. */
static const struct {
    const char *method, *name, *text;
} hunt_known[] = {
    {"dbuffer", "random 701", "light where it is dark"}, /* the light is around the occluder */
    {"wedge", "random 748", "light where it is dark"},   /* parts are added */
};

static bool is_known(const char *method, const char *name, const char *text)
{
    for (size_t i = 0; i < sizeof(hunt_known) / sizeof(hunt_known[0]); i++)
        if (*hunt_known[i].method && strcmp(hunt_known[i].method, method) == 0 &&
            strncmp(hunt_known[i].name, name, strlen(hunt_known[i].name)) == 0 &&
            strstr(text, hunt_known[i].text))
            return true;
    return false;
}

struct tally {
    size_t done, refused, surprises, known;
    double rmse_sum, worst_rmse, milliseconds, slowest;
    size_t worst_case, slowest_case;
};

static void take(const pnb_method_info *method, const struct finding *finding, struct tally *tally)
{
    const char *name = cases[finding->index].name;
    if (finding->fate == FATE_REFUSED) {
        tally->refused++;
        return;
    }
    tally->done++;
    tally->rmse_sum += finding->rmse;
    tally->milliseconds += finding->milliseconds;
    if (finding->rmse > tally->worst_rmse) {
        tally->worst_rmse = finding->rmse;
        tally->worst_case = finding->index;
    }
    if (finding->milliseconds > tally->slowest) {
        tally->slowest = finding->milliseconds;
        tally->slowest_case = finding->index;
    }
    if (finding->fate == FATE_SURPRISE) {
        bool known = is_known(method->name, name, finding->text);
        tally->known += known;
        tally->surprises += !known;
        printf("%s %s: %s: %s\n", known ? "known   " : "SURPRISE", method->name, name,
               finding->text);
        fflush(stdout);
    }
}

/* The cases from *next on in a child, until it is through or dies; *next is where to go on. */
static void run_child(const pnb_method_info *method, size_t *next, size_t end, struct tally *tally)
{
    int ends[2];
    if (pipe(ends) != 0)
        exit(2);
    fflush(stdout);
    pid_t child = fork();
    if (child < 0)
        exit(2);
    if (child == 0) {
        close(ends[0]);
        for (size_t i = *next; i < end; i++) {
            struct finding finding = {.index = i};
            struct itimerval limit = {.it_value = {.tv_sec = LIMIT_S}};
            setitimer(ITIMER_PROF, &limit, NULL);
            alarm(PATIENCE_S);
            try_case(&cases[i], method, &finding);
            if (write(ends[1], &finding, sizeof(finding)) != (ssize_t)sizeof(finding))
                _exit(2);
        }
        _exit(0);
    }
    close(ends[1]);
    struct finding finding;
    size_t got;
    do {
        got = 0;
        for (ssize_t n; got < sizeof(finding) &&
                        (n = read(ends[0], (char *)&finding + got, sizeof(finding) - got)) > 0;)
            got += (size_t)n;
        if (got == sizeof(finding)) {
            take(method, &finding, tally);
            *next = finding.index + 1;
        }
    } while (got == sizeof(finding));
    close(ends[0]);
    int status;
    waitpid(child, &status, 0);
    if (*next < end) {
        struct finding death = {.index = *next};
        if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM))
            surprise(&death, "no answer within %d s of work or %d s", LIMIT_S, PATIENCE_S);
        else if (WIFSIGNALED(status))
            surprise(&death, "crashed: %s", strsignal(WTERMSIG(status)));
        else
            surprise(&death, "ended with status %d", WEXITSTATUS(status));
        take(method, &death, tally);
        ++*next;
    }
}

int main(int argc, char **argv)
{
    bool quick = argc > 1 && strcmp(argv[1], "quick") == 0;
    argc -= quick, argv += quick;
    bool one = argc > 2 && strcmp(argv[1], "case") == 0;
    long random = !one && argc > 1 ? atol(argv[1]) : 1000;
    long first = !one && argc > 2 ? atol(argv[2]) : 0;
    const char *only = argc > 3 ? argv[3] : NULL;
    if (one && strncmp(argv[2], "random ", 7) == 0)
        random = 1, first = atol(argv[2] + 7);
    if (only && !pnb_method_find(only)) {
        fprintf(stderr, "hunt: there is no method '%s'\n", only);
        return 2;
    }
    list_cases(random, first, quick);
    size_t begin = 0, end = case_count, surprises = 0, known = 0;
    for (size_t i = 0; one && i < case_count; i++)
        if (strcmp(cases[i].name, argv[2]) == 0)
            begin = i, end = i + 1;
    talkative = one;
    if (one && end - begin != 1) {
        fprintf(stderr, "hunt: there is no case '%s'\n", argv[2]);
        return 2;
    }
    printf("%zu cases\n", end - begin);
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *method = pnb_method(m);
        struct tally tally = {0};
        if (only && strcmp(only, method->name) != 0)
            continue;
        for (size_t next = begin; next < end;)
            run_child(method, &next, end, &tally);
        printf("%-20s %5zu done, %4zu refused; RMSE against %d rays: mean %.4f, most %.3f (%s); "
               "%.1f ms, "
               "most %.0f (%s); %zu surprises, %zu known\n",
               method->name, tally.done, tally.refused, TRUTH_SAMPLES,
               tally.done ? tally.rmse_sum / (double)tally.done : 0, tally.worst_rmse,
               cases[tally.worst_case].name,
               tally.done ? tally.milliseconds / (double)tally.done : 0, tally.slowest,
               cases[tally.slowest_case].name, tally.surprises, tally.known);
        fflush(stdout);
        surprises += tally.surprises;
        known += tally.known;
    }
    printf("%zu surprises, %zu known\n", surprises, known);
    free(cases);
    return surprises > 0;
}
