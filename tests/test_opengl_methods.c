/* The baselines on OpenGL on every built-in scene that they can do, held to a written error ceiling
 * on whatever device there is (in CI Mesa's software rasteriser); and what reduces to what. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#include "light/light.h"

enum { WIDTH = 160, HEIGHT = 120, PIXELS = WIDTH * HEIGHT };

struct picture {
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
};

static void open_scene(struct picture *picture, const char *name)
{
    char path[128];
    snprintf(path, sizeof(path), "builtin:%s", name);
    if (pnb_context_create(NULL, &picture->context) != PNB_OK ||
        pnb_scene_load(picture->context, path, &picture->scene) != PNB_OK ||
        pnb_surface_create(picture->context, picture->scene, NULL, WIDTH, HEIGHT,
                           &picture->surface) != PNB_OK)
        fail_msg("%s: %s", name, pnb_context_error(picture->context));
    pnb_surface_receivers(picture->surface, &picture->receivers);
}

static void close_scene(struct picture *picture)
{
    pnb_surface_destroy(picture->surface);
    pnb_scene_destroy(picture->scene);
    pnb_context_destroy(picture->context);
}

static void run(struct picture *picture, const char *method, const char *key, const char *value,
                int samples, const pnb_light *light, float *visibility)
{
    pnb_solver *solver;
    pnb_solver_param param = {key, value};
    pnb_solver_desc desc = {
        .method = method, .samples = samples, .params = &param, .param_count = key ? 1 : 0};
    if (pnb_solver_create(picture->context, picture->scene, &desc, &solver) != PNB_OK ||
        pnb_solver_visibility(solver, light, &picture->receivers, visibility) != PNB_OK)
        fail_msg("%s on %s: %s", method, pnb_scene_name(picture->scene),
                 pnb_context_error(picture->context));
    pnb_solver_destroy(solver);
}

/* Share of the pixels where two hard pictures differ. */
static double differ(const float *a, const float *b)
{
    size_t count = 0, wrong = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        assert_int_equal(isnan(a[i]), isnan(b[i]));
        count += !isnan(a[i]);
        wrong += !isnan(a[i]) && fabsf(a[i] - b[i]) > 0.5f;
    }
    return count ? (double)wrong / (double)count : 0;
}

static void middle_of(pnb_context *context, const pnb_light *light, pnb_light *out_point)
{
    struct light_shape shape;
    assert_int_equal(light_shape_init(context, light, &shape), PNB_OK);
    struct light_point middle = light_shape_sample(&shape, 0.5, 0.5);
    *out_point = *light;
    if (light->type == PNB_LIGHT_SUN) {
        out_point->shape.sun.angular_diameter_degrees = 1e-3;
    } else {
        out_point->type = PNB_LIGHT_POINT;
        v3_store(out_point->shape.point.position, middle.p);
    }
    light_shape_finish(context, &shape);
}

/* Too many triangles for a quick test. */
static bool is_heavy(const char *name)
{
    static const char *const heavy[] = {"knot-96k", "knot-768k", "spheres-9x9", "spheres-9x9x9",
                                        "leaves-20k"};
    for (size_t i = 0; i < sizeof(heavy) / sizeof(*heavy); i++)
        if (strcmp(name, heavy[i]) == 0)
            return true;
    return false;
}

/* A point light: all hard methods against one ray a pixel. */
static void test_points(void **state)
{
    static float truth[PIXELS], volume[PIXELS], map[PIXELS], pcss[PIXELS];
    for (size_t s = 0; s < pnb_builtin_count(); s++) {
        pnb_builtin_info info;
        struct picture picture;
        pnb_builtin(s, &info);
        if (is_heavy(info.name))
            continue;
        open_scene(&picture, info.name);
        pnb_light light, point;
        pnb_scene_light(picture.scene, 0, &light);
        middle_of(picture.context, &light, &point);
        run(&picture, "reference", NULL, NULL, 1, &point, truth);
        run(&picture, "hard-volume", NULL, NULL, 0, &point, volume);
        bool sun = light.type == PNB_LIGHT_SUN;
        if (!sun) {
            run(&picture, "hard-map", "path", "opengl", 0, &point, map);
            run(&picture, "pcss", "bias", "1", 0, &point, pcss);
        }
        /* Six pixels; and what a map of 1024 texels makes of leaves. */
        if (differ(volume, truth) > 0.0004 || (!sun && differ(map, truth) > 0.01) ||
            (!sun && differ(pcss, map) > 0.0002))
            fail_msg("%s: volume %.5f, map %.5f, pcss %.5f", info.name, differ(volume, truth),
                     differ(map, truth), differ(pcss, map));
        close_scene(&picture);
    }
}

/* ---- Area lights: a ceiling for every method and scene ---- */

#include "opengl_ceilings.h"

static const struct ceiling *find_ceiling(const char *scene, const char *method)
{
    for (size_t i = 0; i < sizeof(ceilings) / sizeof(*ceilings); i++)
        if (strcmp(ceilings[i].scene, scene) == 0 && strcmp(ceilings[i].method, method) == 0)
            return &ceilings[i];
    return NULL;
}

/* One method on one scene. With PNB_WRITE_CEILINGS set, writes the table's lines instead. */
static void hold(struct picture *picture, const pnb_method_info *method, const pnb_light *light,
                 const float *truth, const uint8_t *mask)
{
    static float visibility[PIXELS];
    const char *scene = pnb_scene_name(picture->scene) + strlen("builtin:");
    const struct ceiling *ceiling = find_ceiling(scene, method->name);
    if (!ceiling && !getenv("PNB_WRITE_CEILINGS"))
        return; /* a method with tests of its own */
    pnb_solver_param params[] = {{"path", "opengl"}, {"size", "512"}};
    bool sampled = strcmp(method->name, "sampled-maps") == 0;
    pnb_solver_desc desc = {.method = method->name,
                            .samples = sampled ? 4 : 0,
                            .params = params,
                            .param_count = !method->opengl_path ? 0
                                           : sampled            ? 2
                                                                : 1};
    pnb_solver *solver;
    pnb_errors errors;
    pnb_context *context = picture->context;
    if (pnb_solver_create(context, picture->scene, &desc, &solver) != PNB_OK ||
        pnb_solver_visibility(solver, light, &picture->receivers, visibility) != PNB_OK ||
        pnb_measure(context, visibility, truth, mask, PIXELS, &errors) != PNB_OK)
        fail_msg("%s on %s: %s", method->name, scene, pnb_context_error(context));
    pnb_solver_destroy(solver);
    for (size_t i = 0; i < PIXELS; i++)
        if (!(visibility[i] >= 0 && visibility[i] <= 1) && !isnan(truth[i]))
            fail_msg("%s on %s: pixel %zu is %g", method->name, scene, i, visibility[i]);
    double darkest = errors.lit_darkening, leak = errors.umbra_leak;
    if (getenv("PNB_WRITE_CEILINGS")) {
        printf("    {\"%s\", \"%s\", %.3f, %.3f, %.3f},\n", scene, method->name,
               ceil(1000 * (errors.rmse * 1.04 + 0.002)) / 1000,
               fmin(1, ceil(1000 * (leak * 1.05 + 0.004)) / 1000),
               fmin(1, ceil(1000 * (darkest * 1.05 + 0.003)) / 1000));
        return;
    }
    if (errors.rmse > ceiling->rmse || leak > ceiling->leak || darkest > ceiling->darkening)
        fail_msg("%s on %s: rmse %.4f of %.3f, leak %.4f of %.3f, darkening %.4f of %.3f",
                 method->name, scene, errors.rmse, ceiling->rmse, leak, ceiling->leak, darkest,
                 ceiling->darkening);
}

static void test_areas(void **state)
{
    static float truth[PIXELS];
    static uint8_t mask[PIXELS];
    for (size_t s = 0; s < pnb_builtin_count(); s++) {
        pnb_builtin_info info;
        struct picture picture;
        pnb_light light;
        pnb_builtin(s, &info);
        if (is_heavy(info.name))
            continue;
        open_scene(&picture, info.name);
        pnb_scene_light(picture.scene, 0, &light);
        run(&picture, "exact", NULL, NULL, 0, &light, truth);
        pnb_measure_facing(&light, &picture.receivers, mask);
        for (size_t m = 0; m < pnb_method_count(); m++) {
            const pnb_method_info *method = pnb_method(m);
            /* line-map's paths are held together by its own test. */
            if ((method->processor == PNB_PROCESSOR_OPENGL || method->opengl_path) &&
                strcmp(method->name, "line-map") != 0 &&
                (method->lights & PNB_LIGHT_BIT(light.type)))
                hold(&picture, method, &light, truth, mask);
        }
        close_scene(&picture);
    }
}

/* A light that shrinks to a point gives what the point gives. */
static void test_small_light(void **state)
{
    static float hard[PIXELS], soft[PIXELS];
    struct picture picture;
    open_scene(&picture, "disk");
    pnb_light light;
    pnb_scene_light(picture.scene, 0, &light);
    light.shape.disk.radius = 1e-6;
    run(&picture, "hard-map", "path", "opengl", 0, &light, hard);
    run(&picture, "pcss", "bias", "1", 0, &light, soft);
    assert_true(differ(soft, hard) < 0.0005);
    run(&picture, "sampled-maps", "path", "opengl", 8, &light, soft);
    assert_true(differ(soft, hard) < 0.0005);
    run(&picture, "hard-volume", NULL, NULL, 0, &light, soft);
    assert_true(differ(soft, hard) < 0.01);
    run(&picture, "hard-map", NULL, NULL, 0, &light, soft);
    assert_true(differ(soft, hard) < 0.01);
    close_scene(&picture);
}

/* The same solver for pictures of several sizes, after objects moved and meshes bent, from another
 * thread than the one that made it. */
static void *see_elsewhere(void *user)
{
    void **parts = user;
    if (pnb_solver_visibility(parts[0], parts[1], parts[2], parts[3]) != PNB_OK)
        return NULL;
    return user;
}

static void test_update(void **state)
{
    static float before[PIXELS], after[PIXELS], fresh[PIXELS], small[PIXELS / 4];
    static const char *const methods[] = {"hard-map", "hard-volume", "pcss"};
    for (size_t m = 0; m < sizeof(methods) / sizeof(*methods); m++) {
        struct picture picture;
        open_scene(&picture, "two-boxes");
        pnb_light light;
        pnb_object object;
        pnb_solver *solver;
        pnb_solver_param path = {"path", "opengl"};
        pnb_solver_desc desc = {
            .method = methods[m], .params = &path, .param_count = m == 0 ? 1 : 0};
        pnb_scene_light(picture.scene, 0, &light);
        assert_int_equal(pnb_solver_create(picture.context, picture.scene, &desc, &solver), PNB_OK);
        assert_int_equal(pnb_solver_visibility(solver, &light, &picture.receivers, before), PNB_OK);
        pnb_surface *surface;
        pnb_receivers receivers;
        assert_int_equal(pnb_surface_create(picture.context, picture.scene, NULL, WIDTH / 2,
                                            HEIGHT / 2, &surface),
                         PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, small), PNB_OK);
        pnb_surface_destroy(surface);
        pnb_scene_object(picture.scene, 1, &object);
        object.world_from_mesh[3] += 0.7;
        assert_int_equal(pnb_scene_set_placement(picture.scene, 1, object.world_from_mesh), PNB_OK);
        assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS), PNB_OK);
        void *parts[4] = {solver, &light, &picture.receivers, after};
        pthread_t thread;
        void *result = NULL;
        assert_int_equal(pthread_create(&thread, NULL, see_elsewhere, parts), 0);
        pthread_join(thread, &result);
        assert_non_null(result);
        run(&picture, methods[m], m == 0 ? "path" : NULL, "opengl", 0, &light, fresh);
        assert_memory_equal(after, fresh, sizeof(fresh));
        assert_memory_not_equal(after, before, sizeof(before));
        pnb_solver_destroy(solver);
        close_scene(&picture);
    }
}

/* What OpenGL methods cannot take, and what says so. */
static void test_receivers(void **state)
{
    static float visibility[PIXELS];
    struct picture picture;
    open_scene(&picture, "disk");
    pnb_solver *solver;
    pnb_light light;
    pnb_solver_desc desc = {.method = "pcss"};
    pnb_scene_light(picture.scene, 0, &light);
    assert_int_equal(pnb_solver_create(picture.context, picture.scene, &desc, &solver), PNB_OK);
    pnb_receivers receivers = picture.receivers;
    receivers.width = receivers.height = 0;
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, visibility),
                     PNB_ERROR_UNSUPPORTED);
    assert_non_null(strstr(pnb_context_error(picture.context), "pixels of an image"));
    receivers = picture.receivers;
    pnb_camera camera = *receivers.camera;
    camera.eye[0] += 1;
    receivers.camera = &camera;
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, visibility),
                     PNB_ERROR_ARGUMENT);
    receivers.count = 0, receivers.width = receivers.height = 0;
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, visibility), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, &picture.receivers, visibility), PNB_OK);
    pnb_solver_destroy(solver);
    close_scene(&picture);
}

/* Without a device there is nothing to test, only something to say. */
static int find_device(void **state)
{
    pnb_context *context;
    pnb_scene *scene;
    pnb_solver *solver;
    pnb_solver_desc desc = {.method = "hard-volume"};
    if (pnb_context_create(NULL, &context) != PNB_OK ||
        pnb_scene_load(context, "builtin:prism", &scene) != PNB_OK)
        return -1;
    bool found = pnb_solver_create(context, scene, &desc, &solver) == PNB_OK;
    if (found)
        pnb_solver_destroy(solver);
    else
        printf("%s\n", pnb_context_error(context));
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return found ? 0 : 77;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points),      cmocka_unit_test(test_areas),
        cmocka_unit_test(test_small_light), cmocka_unit_test(test_update),
        cmocka_unit_test(test_receivers),
    };
    int without = find_device(NULL);
    if (without)
        return without;
    return cmocka_run_group_tests_name("opengl-methods", tests, NULL, NULL);
}
