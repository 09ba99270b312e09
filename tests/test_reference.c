/* The reference: analytic visibility, an independent ray tracer, threads, scale, cancelling. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#include "light/light.h"
#include "scene/scene.h"

static const double grey[3] = {0.8, 0.8, 0.8};
static const double placement[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static pnb_context *new_context(int threads)
{
    pnb_context *context;
    assert_int_equal(pnb_context_create(&(pnb_context_desc){.threads = threads}, &context), PNB_OK);
    return context;
}

/* An object of triangles given as corners. */
static void add_triangles(pnb_scene *scene, const float *corners, size_t count, bool casts)
{
    uint32_t *indices = malloc(count * 12);
    for (uint32_t i = 0; i < count * 3; i++)
        indices[i] = i;
    pnb_mesh_desc mesh = {"mesh", corners, NULL, count * 3, indices, count};
    pnb_object object = {.name = "object", .color = {1, 1, 1}, .casts = casts, .receives = true};
    memcpy(object.world_from_mesh, placement, sizeof(placement));
    assert_int_equal(pnb_scene_add_mesh(scene, &mesh, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
    free(indices);
}

/* Axis-aligned quad at height y. */
static void add_quad(pnb_scene *scene, double x0, double x1, double z0, double z1, double y)
{
    float c[18] = {(float)x0, (float)y, (float)z0, (float)x1, (float)y, (float)z0,
                   (float)x1, (float)y, (float)z1, (float)x0, (float)y, (float)z0,
                   (float)x1, (float)y, (float)z1, (float)x0, (float)y, (float)z1};
    add_triangles(scene, c, 2, true);
}

static void add_box(pnb_scene *scene, vec3 low, vec3 high)
{
    static const int face[12][3] = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6},
                                    {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5},
                                    {0, 1, 4}, {1, 5, 4}, {2, 6, 3}, {3, 6, 7}};
    float c[108];
    for (int i = 0; i < 36; i++) {
        int k = face[i / 3][i % 3];
        v3_storef(c + 3 * i,
                  v3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z));
    }
    add_triangles(scene, c, 12, true);
}

static void visibility_at(pnb_context *context, pnb_scene *scene, const pnb_light *light,
                          int samples, const float *positions, const float *normals, size_t count,
                          float *out)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {.method = "reference", .samples = samples};
    pnb_receivers receivers = {.count = count, .positions = positions, .normals = normals};
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, light, &receivers, out), PNB_OK);
    pnb_solver_destroy(solver);
}

static const pnb_light rectangle = {.type = PNB_LIGHT_RECTANGLE,
                                    .color = {1, 1, 1},
                                    .shape.rectangle = {{0, 4, 0}, {1, 0, 0}, {0, 0, 1}}};
static const pnb_light disk = {
    .type = PNB_LIGHT_DISK, .color = {1, 1, 1}, .shape.disk = {{0, 4, 0}, {0, -1, 0}, 1}};
static const pnb_light line = {
    .type = PNB_LIGHT_LINE, .color = {1, 1, 1}, .shape.line = {{-1, 4, 0}, {1, 4, 0}}};
static const pnb_light point = {
    .type = PNB_LIGHT_POINT, .color = {1, 1, 1}, .shape.point = {{0, 4, 0}}};

/* A half plane at height 2 that hides x < 0: from (x, 0, 0) its edge appears on the light at -x. */
static void half_plane(void **state)
{
    pnb_context *context = new_context(2);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_quad(scene, -50, 0, -50, 50, 2);
    enum { N = 401 };
    static float p[N * 3], n[N * 3], v[N];
    for (int i = 0; i < N; i++) {
        v3_storef(p + 3 * i, v3(-1.5 + 3.0 * i / (N - 1), 0, 0.1));
        v3_storef(n + 3 * i, v3(0, 1, 0));
    }
    const pnb_light *lights[] = {&rectangle, &disk, &line, &point};
    for (int k = 0; k < 4; k++) {
        visibility_at(context, scene, lights[k], 4096, p, n, N, v);
        double sum = 0;
        for (int i = 0; i < N; i++) {
            double edge = -(double)p[3 * i], truth;
            edge = fmin(fmax(edge, -1), 1);
            if (k == 1) /* share of the unit disk right of x = edge */
                truth = (acos(edge) - edge * sqrt(1 - edge * edge)) / M_PI;
            else if (k == 3)
                truth = edge < 0;
            else
                truth = (1 - edge) / 2;
            double error = v[i] - truth;
            if (k == 3)
                assert_true(fabs(error) < 1e-6 || fabs(p[3 * i]) < 1e-3);
            else
                assert_true(fabs(error) < 0.012);
            if (k != 3)
                sum += error * error;
            if (p[3 * i] > 1.001f)
                assert_true(v[i] == 1);
            if (p[3 * i] < -1.001f)
                assert_true(v[i] == 0);
        }
        assert_true(sqrt(sum / N) < 0.003);
    }
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* A square hole of side 2 a at height 2 in a wide plate: from the middle the hole shows the light's
 * central square of half side 2 a. */
static void square_hole(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    const double a = 0.3;
    add_quad(scene, -9, -a, -9, 9, 2);
    add_quad(scene, a, 9, -9, 9, 2);
    add_quad(scene, -a, a, -9, -a, 2);
    add_quad(scene, -a, a, a, 9, 2);
    const float p[6] = {0, 0, 0, 0.1f, 0, 0.25f}, n[6] = {0, 1, 0, 0, 1, 0};
    float v[2];
    visibility_at(context, scene, &rectangle, 16384, p, n, 2, v);
    assert_true(fabs(v[0] - 0.36) < 0.002);
    /* Shifted by (-.1, -.25): x in [-.7, .5], z in [-.85, .35]. */
    assert_true(fabs(v[1] - 1.2 * 1.2 / 4) < 0.002);
    visibility_at(context, scene, &disk, 16384, p, n, 1, v);
    assert_true(fabs(v[0] - 4 * 0.36 / M_PI) < 0.002);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static void definite_cases(void **state)
{
    pnb_context *context = new_context(2);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    assert_int_equal(scene_add_plane(scene, "ground", v3(0, 0, 0), v3(0, 1, 0), 100, grey, NULL),
                     PNB_OK);
    add_box(scene, v3(5, 1, -1), v3(7, 3, 1));    /* a closed box with receivers inside */
    add_box(scene, v3(-7, -1, -1), v3(-5, 2, 1)); /* one that stands in the ground */
    const float p[] = {0, 0, 0, 6,   2, 0, 6, 1.5f, 0.2f, -6, 0, 0, 0,    5, 0,
                       0, 0, 0, NAN, 0, 0, 0, 0,    0,    3,  4, 0, 0.2f, 4, 0};
    const float n[] = {0, 1,  0, 0, 1, 0, 0,   1, 0, 0,  1, 0, 0, -1, 0,
                       0, -1, 0, 0, 1, 0, NAN, 0, 0, -1, 0, 0, 0, -1, 0};
    const float expected[] = {1, 0, 0, 0, 0, 0, NAN, NAN, 0, 0};
    float v[10];
    for (int samples = 1; samples <= 1024; samples = samples * 3 + 1) {
        visibility_at(context, scene, &rectangle, samples, p, n, 10, v);
        for (int i = 0; i < 10; i++)
            if (isnan(expected[i]))
                assert_true(isnan(v[i]));
            else if (v[i] != expected[i])
                fail_msg("point %d, %d samples: %g", i, samples, v[i]);
    }
    /* A wall sees the half of the light that lies before it. */
    const float pw[3] = {0, 1, 0}, nw[3] = {1, 0, 0};
    visibility_at(context, scene, &rectangle, 1024, pw, nw, 1, v);
    assert_true(v[0] == 0.5f);
    /* A light in a closed box lights the inside only. */
    pnb_light inside = {.type = PNB_LIGHT_RECTANGLE,
                        .color = {1, 1, 1},
                        .shape.rectangle = {{6, 2.5, 0}, {0.3, 0, 0}, {0, 0, 0.3}}};
    const float pi[6] = {6, 1, 0, 6, 0, 0}, ni[6] = {0, 1, 0, 0, 1, 0};
    visibility_at(context, scene, &inside, 256, pi, ni, 2, v);
    assert_true(v[0] == 1 && v[1] == 0);
    /* A lamp flush with a ceiling shines. */
    add_quad(scene, -20, 20, -20, 20, 4);
    visibility_at(context, scene, &rectangle, 256, p, n, 1, v);
    assert_true(v[0] == 1);
    /* The sun is hidden by the ceiling, and seen from beyond it. */
    pnb_light sun = {.type = PNB_LIGHT_SUN, .color = {1, 1, 1}, .shape.sun = {{0.1, -1, 0}, 0.53}};
    const float ps[6] = {0, 0, 0, 60, 0, 0};
    const float nu[6] = {0, 1, 0, 0, 1, 0};
    visibility_at(context, scene, &sun, 64, ps, nu, 2, v);
    assert_true(v[0] == 0 && v[1] == 1);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static void objects_that_do_not_cast(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    const float roof[9] = {-9, 2, -9, 9, 2, -9, 0, 2, 9};
    add_triangles(scene, roof, 1, false);
    const float p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    float v;
    visibility_at(context, scene, &rectangle, 64, p, n, 1, &v);
    assert_true(v == 1);
    add_triangles(scene, roof, 1, true);
    visibility_at(context, scene, &rectangle, 64, p, n, 1, &v);
    assert_true(v == 0);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* ---- an independent ray tracer: Moeller-Trumbore in double on a median-split tree ---- */

struct node {
    vec3 low, high;
    uint32_t first, count; /* leaf: triangles; else the second child is `first` */
};
struct slow {
    vec3 *corners; /* 3 per triangle */
    uint32_t *order;
    struct node *nodes;
    uint32_t count, node_count;
};

static const struct slow *sorting;
static int sorting_axis;
static int by_middle(const void *a, const void *b)
{
    double m[2];
    for (int k = 0; k < 2; k++) {
        const vec3 *c = sorting->corners + 3 * *(const uint32_t *)(k ? b : a);
        vec3 s = v3_add(v3_add(c[0], c[1]), c[2]);
        m[k] = sorting_axis == 0 ? s.x : sorting_axis == 1 ? s.y : s.z;
    }
    return (m[0] > m[1]) - (m[0] < m[1]);
}

static uint32_t slow_build(struct slow *slow, uint32_t first, uint32_t count)
{
    uint32_t self = slow->node_count++;
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3(-INFINITY, -INFINITY, -INFINITY);
    for (uint32_t i = 0; i < count * 3; i++) {
        vec3 c = slow->corners[3 * slow->order[first + i / 3] + i % 3];
        low = v3_min(low, c);
        high = v3_max(high, c);
    }
    struct node node = {low, high, first, count};
    if (count > 4) {
        vec3 d = v3_sub(high, low);
        sorting = slow;
        sorting_axis = d.x >= d.y && d.x >= d.z ? 0 : d.y >= d.z ? 1 : 2;
        qsort(slow->order + first, count, sizeof(uint32_t), by_middle);
        slow_build(slow, first, count / 2);
        node.first = slow_build(slow, first + count / 2, count - count / 2);
        node.count = 0;
    }
    slow->nodes[self] = node;
    return self;
}

static void slow_init(struct slow *slow, const pnb_scene *scene)
{
    size_t count = pnb_scene_triangle_count(scene);
    slow->corners = malloc(count * 3 * sizeof(vec3));
    slow->order = malloc(count * sizeof(uint32_t));
    slow->nodes = malloc((2 * count + 1) * sizeof(struct node));
    slow->count = slow->node_count = 0;
    for (size_t k = 0; k < scene->object_count; k++) {
        const pnb_object *object = &scene->objects[k].info;
        const struct mesh *mesh = &scene->meshes[object->mesh];
        for (size_t i = 0; object->casts && i < mesh->triangle_count * 3; i++) {
            vec3 q = m34_point(object->world_from_mesh,
                               v3_loadf(mesh->positions + 3 * mesh->indices[i]));
            /* World space is float space. */
            slow->corners[3 * slow->count + i] = v3((float)q.x, (float)q.y, (float)q.z);
        }
        if (object->casts)
            slow->count += (uint32_t)mesh->triangle_count;
    }
    for (uint32_t i = 0; i < slow->count; i++)
        slow->order[i] = i;
    if (slow->count > 0)
        slow_build(slow, 0, slow->count);
}

static void slow_finish(struct slow *slow)
{
    free(slow->corners);
    free(slow->order);
    free(slow->nodes);
}

static bool slow_triangle(const vec3 *c, vec3 o, vec3 d, double far)
{
    vec3 e1 = v3_sub(c[1], c[0]), e2 = v3_sub(c[2], c[0]), h = v3_cross(d, e2);
    double det = v3_dot(e1, h);
    if (det == 0)
        return false;
    vec3 s = v3_sub(o, c[0]), q = v3_cross(s, e1);
    double u = v3_dot(s, h) / det, v = v3_dot(d, q) / det, t = v3_dot(e2, q) / det;
    return u >= 0 && v >= 0 && u + v <= 1 && t > 0 && t < far;
}

static bool slow_blocked(const struct slow *slow, vec3 o, vec3 d, double far)
{
    uint32_t stack[64] = {0};
    int top = slow->count > 0 ? 1 : 0;
    vec3 r = v3(1 / d.x, 1 / d.y, 1 / d.z);
    while (top > 0) {
        uint32_t self = stack[--top];
        const struct node *node = &slow->nodes[self];
        vec3 a =
            v3((node->low.x - o.x) * r.x, (node->low.y - o.y) * r.y, (node->low.z - o.z) * r.z);
        vec3 b =
            v3((node->high.x - o.x) * r.x, (node->high.y - o.y) * r.y, (node->high.z - o.z) * r.z);
        vec3 in = v3_min(a, b), out = v3_max(a, b);
        double t0 = fmax(fmax(in.x, in.y), fmax(in.z, 0)),
               t1 = fmin(fmin(out.x, out.y), fmin(out.z, far));
        if (t0 > t1 * (1 + 1e-12) + 1e-12)
            continue;
        if (node->count == 0) {
            stack[top++] = self + 1;
            stack[top++] = node->first;
            continue;
        }
        for (uint32_t i = 0; i < node->count; i++)
            if (slow_triangle(slow->corners + 3 * slow->order[node->first + i], o, d, far))
                return true;
    }
    return false;
}

/* A different sample set: a rank-1 lattice, rotated per receiver. */
static double slow_visibility(const struct slow *slow, const struct light_shape *shape, vec3 p,
                              vec3 n, double lift, int samples, uint32_t pixel)
{
    int seen = 0;
    double su = fmod(pixel * 0.7548776662466927, 1), sv = fmod(pixel * 0.5698402909980532, 1);
    if (!light_shape_lit_side(shape, p))
        return 0;
    vec3 o = v3_mad(p, n, lift);
    for (int i = 0; i < samples; i++) {
        struct light_point l = light_shape_sample(shape, fmod(su + (i + 0.5) / samples, 1),
                                                  fmod(sv + i * 0.6180339887498949, 1));
        vec3 d = l.w > 0 ? v3_sub(l.p, o) : l.p;
        if (v3_dot(l.w > 0 ? v3_sub(l.p, p) : l.p, n) <= 0)
            continue;
        seen += !slow_blocked(slow, o, d, l.w > 0 ? 1 - 1e-5 : INFINITY);
    }
    return (double)seen / samples;
}

/* RMSE over the penumbra in the contract's sense. */
static void compare_with_slow(pnb_context *context, pnb_scene *scene, const char *name, int width,
                              int height)
{
    pnb_surface *surface;
    assert_int_equal(pnb_surface_create(context, scene, NULL, width, height, &surface), PNB_OK);
    pnb_receivers receivers;
    pnb_surface_receivers(surface, &receivers);
    float *fast = malloc(receivers.count * sizeof(float));
    float *truth = malloc(receivers.count * sizeof(float));
    uint8_t *mask = malloc(receivers.count);
    struct slow slow;
    slow_init(&slow, scene);
    for (size_t k = 0; k < scene->light_count; k++) {
        const pnb_light *light = &scene->lights[k];
        struct light_shape shape;
        pnb_solver *solver;
        pnb_solver_desc desc = {.method = "reference", .samples = 1024};
        assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
        assert_int_equal(pnb_solver_visibility(solver, light, &receivers, fast), PNB_OK);
        pnb_solver_destroy(solver);
        assert_int_equal(light_shape_init(context, light, &shape), PNB_OK);
        double lift = scene_receiver_lift(scene), worst = 0;
        size_t off = 0, counted = 0;
        for (size_t i = 0; i < receivers.count; i++) {
            vec3 p = v3_loadf(receivers.positions + 3 * i), n = v3_loadf(receivers.normals + 3 * i);
            truth[i] = NAN;
            if (!v3_finite(p)) {
                assert_true(isnan(fast[i]));
                continue;
            }
            truth[i] =
                (float)slow_visibility(&slow, &shape, p, n, lift, 1536, (uint32_t)i * 17u + 1);
            worst = fmax(worst, fabs(truth[i] - fast[i]));
            off += fabs(truth[i] - fast[i]) > 0.03;
            counted++;
        }
        pnb_errors errors;
        pnb_measure_facing(light, &receivers, mask);
        assert_int_equal(pnb_measure(context, fast, truth, mask, receivers.count, &errors), PNB_OK);
        print_message("%-28s light %zu: %6zu pixels, penumbra %6zu, rmse %.5f, worst %.4f\n", name,
                      k, errors.pixels, errors.penumbra_pixels, errors.rmse, worst);
        assert_true(errors.rmse <= 0.005);
        assert_true(fabs(errors.mean_error) < 0.0015);
        assert_true(off <= counted / 1000);
        light_shape_finish(context, &shape);
    }
    slow_finish(&slow);
    free(fast);
    free(truth);
    free(mask);
    pnb_surface_destroy(surface);
}

static void agrees_on_builtin_scenes(void **state)
{
    static const char *const names[] = {"prism",
                                        "fence",
                                        "leaves",
                                        "room",
                                        "outdoor",
                                        "overlap",
                                        "pole",
                                        "triangle-light",
                                        "knot",
                                        "light-inside-caster",
                                        "caster-through-light-plane"};
    pnb_context *context = new_context(2);
    int found = 0;
    for (size_t i = 0; i < sizeof(names) / sizeof(*names); i++) {
        char path[80];
        pnb_scene *scene;
        snprintf(path, sizeof(path), "builtin:%s", names[i]);
        if (pnb_scene_load(context, path, &scene) != PNB_OK)
            continue;
        found++;
        compare_with_slow(context, scene, names[i], 40, 30);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(context);
    assert_true(found >= 8);
}

static void agrees_on_real_meshes(void **state)
{
    static const char *const names[] = {"cow", "stanford-bunny", "suzanne"};
    const char *models = getenv("PNB_MODELS"), *source = getenv("PNB_SOURCE_DIR");
    char folder[2000], path[2100];
    if (models)
        snprintf(folder, sizeof(folder), "%s", models);
    else
        snprintf(folder, sizeof(folder), "%s/../shared/models", source ? source : ".");
    snprintf(path, sizeof(path), "%s/cow.obj", folder);
    FILE *file = fopen(path, "r");
    if (!file)
        skip();
    fclose(file);
    pnb_context *context = new_context(2);
    for (size_t i = 0; i < sizeof(names) / sizeof(*names); i++) {
        pnb_scene *scene;
        snprintf(path, sizeof(path), "%s/%s.obj", folder, names[i]);
        if (pnb_scene_load(context, path, &scene) != PNB_OK)
            fail_msg("%s", pnb_context_error(context));
        compare_with_slow(context, scene, names[i], 40, 30);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(context);
}

/* A random soup over a ground: open, intersecting. */
static void soup(pnb_scene *scene, double scale)
{
    float c[200 * 9];
    srand(11);
    for (int i = 0; i < 200; i++) {
        vec3 at =
            v3(rand() % 1000 / 250. - 2, 0.2 + rand() % 1000 / 500., rand() % 1000 / 250. - 2);
        for (int k = 0; k < 3; k++)
            v3_storef(c + 9 * i + 3 * k,
                      v3_scale(v3_add(at, v3(rand() % 100 / 200., rand() % 100 / 200.,
                                             rand() % 100 / 200.)),
                               scale));
    }
    assert_int_equal(
        scene_add_plane(scene, "ground", v3(0, 0, 0), v3(0, 1, 0), 10 * scale, grey, NULL), PNB_OK);
    add_triangles(scene, c, 200, true);
    pnb_camera camera = {{0, 3 * scale, 7 * scale}, {0, 0.5 * scale, 0}, {0, 1, 0}, 45};
    assert_int_equal(pnb_scene_set_camera(scene, &camera), PNB_OK);
}

static float *soup_visibility(int threads, double scale, int samples, const pnb_light *light,
                              const char *seed, int width, int height)
{
    pnb_context *context = new_context(threads);
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_solver *solver;
    pnb_receivers receivers;
    float *v = malloc((size_t)width * (size_t)height * sizeof(float));
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    soup(scene, scale);
    assert_int_equal(pnb_surface_create(context, scene, NULL, width, height, &surface), PNB_OK);
    pnb_surface_receivers(surface, &receivers);
    pnb_solver_param param = {"seed", seed};
    pnb_solver_desc desc = {
        .method = "reference", .samples = samples, .params = &param, .param_count = 1};
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, light, &receivers, v), PNB_OK);
    pnb_solver_report report;
    pnb_solver_get_report(solver, &report);
    assert_int_equal(report.counter_count, 1);
    assert_string_equal(report.counters[0].name, "rays");
    assert_true(report.counters[0].value > 0);
    pnb_solver_destroy(solver);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return v;
}

static void same_bytes_for_any_threads(void **state)
{
    const pnb_light *lights[] = {&rectangle, &line, &point};
    for (int samples = 48; samples <= 50; samples += 2)
        for (int k = 0; k < 3; k++) {
            float *one = soup_visibility(1, 1, samples, lights[k], "3", 101, 67);
            float *two = soup_visibility(2, 1, samples, lights[k], "3", 101, 67);
            float *five = soup_visibility(5, 1, samples, lights[k], "3", 101, 67);
            float *other = soup_visibility(5, 1, samples, lights[k], "4", 101, 67);
            assert_memory_equal(one, two, 101 * 67 * sizeof(float));
            assert_memory_equal(one, five, 101 * 67 * sizeof(float));
            if (k == 0)
                assert_memory_not_equal(one, other, 101 * 67 * sizeof(float));
            free(one), free(two), free(five), free(other);
        }
}

static void scale_does_not_matter(void **state)
{
    float *unit = soup_visibility(2, 1, 64, &rectangle, "0", 120, 90);
    for (int k = -1; k <= 1; k += 2) {
        double scale = pow(10, 3 * k);
        pnb_light light = rectangle;
        for (int i = 0; i < 3; i++) {
            light.shape.rectangle.center[i] *= scale;
            light.shape.rectangle.half_u[i] *= scale;
            light.shape.rectangle.half_v[i] *= scale;
        }
        float *scaled = soup_visibility(2, scale, 64, &light, "0", 120, 90);
        int different = 0;
        for (int i = 0; i < 120 * 90; i++) {
            assert_int_equal(isnan(unit[i]), isnan(scaled[i]));
            if (!isnan(unit[i]))
                different += fabsf(unit[i] - scaled[i]) > 1.5f / 64;
        }
        assert_true(different < 20);
        free(scaled);
    }
    free(unit);
}

/* Pixels of one tile must not share their noise: in a smooth penumbra the errors of neighbours are
 * uncorrelated. */
static void noise_of_neighbours_is_independent(void **state)
{
    pnb_context *context = new_context(2);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_quad(scene, -50, 0, -50, 50, 2);
    enum { W = 200, H = 200 };
    float *p = malloc(W * H * 12), *n = malloc(W * H * 12), *v = malloc(W * H * 4);
    for (int i = 0; i < W * H; i++) {
        v3_storef(p + 3 * i, v3(0.3 + 1e-4 * (i % W), 0, 0.1 + 1e-4 * (double)(i / W)));
        v3_storef(n + 3 * i, v3(0, 1, 0));
    }
    /* A rotated light, so that no row of samples runs along the edge. */
    pnb_light light = rectangle;
    memcpy(light.shape.rectangle.half_u, (double[3]){0.8, 0, 0.6}, 24);
    memcpy(light.shape.rectangle.half_v, (double[3]){-0.6, 0, 0.8}, 24);
    pnb_solver *solver;
    pnb_solver_desc desc = {.method = "reference", .samples = 64};
    pnb_receivers receivers = {
        .count = W * H, .positions = p, .normals = n, .width = W, .height = H};
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, v), PNB_OK);
    pnb_solver_destroy(solver);
    double mean = 0, variance = 0, right = 0, down = 0;
    for (int i = 0; i < W * H; i++)
        mean += v[i] / (W * H);
    for (int y = 0; y + 1 < H; y++)
        for (int x = 0; x + 1 < W; x++) {
            double e = v[y * W + x] - mean;
            variance += e * e;
            right += e * (v[y * W + x + 1] - mean);
            down += e * (v[y * W + W + x] - mean);
        }
    assert_true(variance > 0);
    assert_true(fabs(right / variance) < 0.15);
    assert_true(fabs(down / variance) < 0.15);
    free(p), free(n), free(v);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static bool stop_in_visibility(void *user, const char *stage, double fraction)
{
    return strcmp(stage, "visibility") != 0;
}

static void cancelling(void **state)
{
    pnb_context *context;
    pnb_context_desc desc = {.threads = 2, .progress = stop_in_visibility};
    assert_int_equal(pnb_context_create(&desc, &context), PNB_OK);
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    soup(scene, 1);
    assert_int_equal(pnb_solver_create(context, scene, NULL, &solver), PNB_OK);
    const float p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    float v;
    pnb_receivers receivers = {.count = 1, .positions = p, .normals = n};
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, &v),
                     PNB_ERROR_CANCELLED);
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static void parameters_are_checked(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    static const struct {
        const char *method, *key, *value;
        int samples;
    } bad[] = {{"no-such-method", "seed", "0", 0}, {"reference", "sede", "0", 0},
               {"reference", "seed", "x", 0},      {"reference", "seed", "1.5", 0},
               {"reference", "seed", "-1", 0},     {"reference", "seed", "", 0},
               {"reference", "seed", "1e300", 0},  {"reference", "seed", "0", -1},
               {"reference", "seed", "0", 1 << 30}};
    for (size_t i = 0; i < sizeof(bad) / sizeof(*bad); i++) {
        pnb_solver_param param = {bad[i].key, bad[i].value};
        pnb_solver_desc desc = {bad[i].method, bad[i].samples, &param, 1};
        assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_ERROR_ARGUMENT);
        assert_null(solver);
        assert_true(*pnb_context_error(context));
    }
    /* An empty scene is fully lit; receivers that make no image are refused. */
    assert_int_equal(
        pnb_solver_create(context, scene, &(pnb_solver_desc){"reference", 16, NULL, 0}, &solver),
        PNB_OK);
    const float p[6] = {0, 0, 0, 1, 0, 0}, n[6] = {0, 1, 0, 0, 1, 0};
    float v[2];
    pnb_receivers receivers = {.count = 2, .positions = p, .normals = n};
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, v), PNB_OK);
    assert_true(v[0] == 1 && v[1] == 1);
    receivers.width = receivers.height = 2;
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, v), PNB_ERROR_ARGUMENT);
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* Updates see moved objects and deformed meshes. */
static void updates(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    const float roof[9] = {-9, 2, -9, 9, 2, -9, 0, 2, 9}, away[9] = {-9, 5, -9, 9, 5, -9, 0, 5, 9};
    add_triangles(scene, roof, 1, true);
    assert_int_equal(pnb_solver_create(context, scene, NULL, &solver), PNB_OK);
    const float p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    float v;
    pnb_receivers receivers = {.count = 1, .positions = p, .normals = n};
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, &v), PNB_OK);
    assert_true(v == 0);
    double moved[12];
    memcpy(moved, placement, sizeof(moved));
    moved[3] = 100;
    assert_int_equal(pnb_scene_set_placement(scene, 0, moved), PNB_OK);
    assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, &v), PNB_OK);
    assert_true(v == 1);
    assert_int_equal(pnb_scene_set_placement(scene, 0, placement), PNB_OK);
    assert_int_equal(pnb_scene_set_vertices(scene, 0, away, NULL), PNB_OK);
    assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_VERTICES), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &rectangle, &receivers, &v), PNB_OK);
    assert_true(v == 1);
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(half_plane),
        cmocka_unit_test(square_hole),
        cmocka_unit_test(definite_cases),
        cmocka_unit_test(objects_that_do_not_cast),
        cmocka_unit_test(same_bytes_for_any_threads),
        cmocka_unit_test(scale_does_not_matter),
        cmocka_unit_test(noise_of_neighbours_is_independent),
        cmocka_unit_test(cancelling),
        cmocka_unit_test(parameters_are_checked),
        cmocka_unit_test(updates),
        cmocka_unit_test(agrees_on_builtin_scenes),
        cmocka_unit_test(agrees_on_real_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
