/* tests/viewer/test_viewer_parts.c: the viewer's shading against the library's, lights under a
 * hand, the camera, and how many pixels a frame may have. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "camera.h"
#include "lights.h"
#include "pacing.h"
#include "shade.h"

static uint64_t random_state = 1;

static double uniform(void)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (double)(random_state >> 11) / 9007199254740992.0;
}

static vec3 direction(void)
{
    for (;;) {
        vec3 v = v3(2 * uniform() - 1, 2 * uniform() - 1, 2 * uniform() - 1);
        double length = v3_length(v);
        if (length > 0.1 && length < 1)
            return v3_scale(v, 1 / length);
    }
}

static const double l_corners[18] = {-1, 3, -1, 1, 3, -1, 1, 3, 0, 0, 3, 0, 0, 3, 1, -1, 3, 1};

static pnb_light test_light(int kind)
{
    pnb_light light = {.type = (pnb_light_type)kind, .color = {1, 1, 1}};
    switch (light.type) {
    case PNB_LIGHT_RECTANGLE:
        light.shape.rectangle.center[1] = 3;
        light.shape.rectangle.half_u[0] = 0.8;
        light.shape.rectangle.half_v[2] = 0.5;
        light.shape.rectangle.half_v[0] = 0.2;
        break;
    case PNB_LIGHT_DISK:
        light.shape.disk.center[1] = 3;
        light.shape.disk.normal[0] = 0.4;
        light.shape.disk.normal[1] = -1;
        light.shape.disk.radius = 0.7;
        break;
    case PNB_LIGHT_POLYGON:
        light.shape.polygon.vertices = l_corners;
        light.shape.polygon.vertex_count = 6;
        break;
    case PNB_LIGHT_LINE:
        light.shape.line.from[0] = -1;
        light.shape.line.to[0] = 1.5;
        light.shape.line.from[1] = light.shape.line.to[1] = 2.5;
        break;
    case PNB_LIGHT_POINT: light.shape.point.position[1] = 2; break;
    case PNB_LIGHT_SUN:
        light.shape.sun.direction[0] = 0.4;
        light.shape.sun.direction[1] = -1;
        light.shape.sun.angular_diameter_degrees = 5;
        break;
    }
    return light;
}

/* Within 0.4 % of the brightest value there is: less than a step of 8 bits; clipped disks, which
 * become polygons, within 1 %. */
static void irradiance_is_the_library_s(void **state)
{
    enum { POINTS = 4096 };
    static float positions[POINTS][3], normals[POINTS][3], truth[POINTS][3];
    view_irradiance_fn *const kernels[] = {view_irradiance_plain, view_irradiance_best()};
    pnb_context *context;
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (int kind = 0; kind < PNB_LIGHT_TYPE_COUNT; kind++) {
        pnb_light light = test_light(kind);
        float brightest = 0;
        for (int i = 0; i < POINTS; i++) {
            vec3 n = i % 3 ? v3(0, 1, 0) : direction();
            const double p[3] = {8 * uniform() - 4, 2 * uniform() - 1, 8 * uniform() - 4};
            const double m[3] = {n.x, n.y, n.z};
            for (int c = 0; c < 3; c++) {
                positions[i][c] = (float)p[c];
                normals[i][c] = (float)m[c];
            }
        }
        assert_int_equal(
            pnb_light_irradiance(context, &light, positions[0], normals[0], POINTS, truth[0]),
            PNB_OK);
        for (int i = 0; i < POINTS; i++)
            brightest = fmaxf(brightest, truth[i][0]);
        struct view_emitter emitter;
        view_emitter_init(&emitter, &light);
        for (size_t k = 0; k < 2; k++)
            for (int first = 0; first < POINTS; first += VIEW_LANES) {
                struct view_points at;
                float out[VIEW_LANES];
                for (int i = 0; i < VIEW_LANES; i++)
                    for (int c = 0; c < 3; c++) {
                        at.p[c][i] = positions[first + i][c];
                        at.n[c][i] = normals[first + i][c];
                    }
                kernels[k](&emitter, &at, out);
                for (int i = 0; i < VIEW_LANES; i++) {
                    float error = fabsf(out[i] - truth[first + i][0]);
                    float allowed = light.type == PNB_LIGHT_DISK ? 0.01f : 0.004f;
                    if (!(error <= allowed * brightest))
                        print_message("kind %d point %d: %g, library %g\n", kind, first + i,
                                      (double)out[i], (double)truth[first + i][0]);
                    assert_true(error <= allowed * brightest);
                }
            }
        view_emitter_finish(&emitter);
    }
    pnb_context_destroy(context);
}

/* The whole pass: a picture within one step of the library's, but for a few pixels within four. */
static void pictures_are_the_library_s(void **state)
{
    static const char *const scenes[] = {"builtin:two-boxes", "builtin:disk",
                                         "builtin:room",      "builtin:outdoor",
                                         "builtin:jack-tube", "builtin:three-lights"};
    enum { WIDTH = 160, HEIGHT = 120, COUNT = WIDTH * HEIGHT };
    static float rgb[COUNT * 3];
    static uint8_t fast[COUNT * 4], exact[COUNT * 4];
    pnb_context *context;
    struct view_team *team = view_team_create(2);
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (size_t k = 0; k < sizeof(scenes) / sizeof(scenes[0]); k++) {
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_surface_view view;
        assert_int_equal(pnb_scene_load(context, scenes[k], &scene), PNB_OK);
        assert_int_equal(pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface), PNB_OK);
        assert_int_equal(pnb_surface_shade(surface, NULL, rgb), PNB_OK);
        view_encode(team, rgb, COUNT, exact);
        pnb_surface_get(surface, &view);
        size_t lights = pnb_scene_light_count(scene), objects = pnb_scene_object_count(scene);
        struct view_emitter *emitters = calloc(lights, sizeof(*emitters));
        struct view_material *materials = calloc(objects, sizeof(*materials));
        struct view_shading shading = {.view = &view,
                                       .materials = materials,
                                       .emitters = emitters,
                                       .emitter_count = lights,
                                       .exposure = pnb_scene_exposure(scene)};
        double ambient[3], background[3];
        pnb_scene_ambient(scene, ambient);
        pnb_scene_background(scene, background);
        for (int c = 0; c < 3; c++) {
            shading.ambient[c] = (float)ambient[c];
            shading.background[c] = (float)background[c];
        }
        for (size_t i = 0; i < lights; i++) {
            pnb_light light;
            pnb_scene_light(scene, i, &light);
            view_emitter_init(&emitters[i], &light);
        }
        for (size_t i = 0; i < objects; i++) {
            pnb_object object;
            pnb_scene_object(scene, i, &object);
            materials[i].receives = object.receives;
            for (int c = 0; c < 3; c++) {
                materials[i].color[c] = (float)object.color[c];
                materials[i].emission[c] = (float)(shading.exposure * M_PI * object.emission[c]);
            }
        }
        view_shade(team, &shading, fast);
        int far = 0;
        for (int i = 0; i < COUNT * 4; i++) {
            int error = abs(fast[i] - exact[i]);
            if (error > 4)
                print_message("%s %d: %d, library %d\n", scenes[k], i / 4, fast[i], exact[i]);
            assert_true(error <= 4);
            far += error > 1;
        }
        assert_true(far < COUNT / 50);
        for (size_t i = 0; i < lights; i++)
            view_emitter_finish(&emitters[i]);
        free(emitters);
        free(materials);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    view_team_destroy(team);
    pnb_context_destroy(context);
}

/* Every byte that the library's PNG has, for every value near a threshold. */
static void encoding_is_the_library_s(void **state)
{
    enum { COUNT = 4096 };
    static float values[COUNT * 3];
    static uint8_t bytes[COUNT * 4];
    char path[] = "/tmp/penumbra-encode-XXXXXX.png";
    int file = mkstemps(path, 4);
    pnb_context *context;
    pnb_image read;
    struct view_team *team = view_team_create(1);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (int i = 0; i < COUNT * 3; i++)
        values[i] = i < 300 ? (float)i / 250 - 0.1f : (float)(uniform() * (i % 2 ? 0.02 : 1));
    view_encode(team, values, COUNT, bytes);
    pnb_image image = {64, 64, 3, values};
    assert_int_equal(pnb_image_write(context, path, &image), PNB_OK);
    assert_int_equal(pnb_image_read(context, path, &read), PNB_OK);
    for (int i = 0; i < COUNT; i++)
        for (int c = 0; c < 3; c++) {
            double x = read.data[read.channels * i + c];
            double e = x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
            assert_int_equal(bytes[4 * i + 2 - c], (int)(e * 255 + 0.5));
        }
    pnb_image_finish(context, &read);
    unlink(path);
    view_team_destroy(team);
    pnb_context_destroy(context);
}

/* Any number of moves, turns and sizes leaves a light that the library takes, and its axes are unit
 * and square. */
static void lights_survive_hands(void **state)
{
    pnb_context *context;
    vec3 middle = v3(0, 1, 0);
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (int round = 0; round < 600; round++) {
        struct view_light light;
        pnb_light first = test_light(round % PNB_LIGHT_TYPE_COUNT);
        view_light_copy(&light, &first);
        for (int step = 0; step < 12; step++) {
            struct view_frame_axes axes = view_light_axes(&light, middle, 3);
            assert_true(fabs(v3_dot(axes.u, axes.n)) < 1e-6);
            assert_true(fabs(v3_length(axes.n) - 1) < 1e-6 && fabs(v3_length(axes.u) - 1) < 1e-6);
            switch ((int)(uniform() * 6)) {
            case 0: view_light_move(&light, v3_scale(direction(), 3), middle, 3); break;
            case 1: view_light_turn(&light, direction(), 7 * uniform()); break;
            case 2:
                view_light_resize(&light, &axes, 2 * uniform() - 1, 2 * uniform() - 1, 1e-3);
                break;
            case 3: {
                vec3 u, n;
                view_axes_from_angles(360 * uniform() - 180, 180 * uniform() - 90,
                                      360 * uniform() - 180, &u, &n);
                view_light_aim(&light, &axes, u, n);
                break;
            }
            case 4:
                view_light_reshape(&light, (pnb_light_type)(uniform() * PNB_LIGHT_TYPE_COUNT),
                                   &axes, 1e-3);
                break;
            default: view_light_move(&light, v3(NAN, 0, 0), middle, 3); break;
            }
            pnb_status status = pnb_light_check(context, &light.light);
            if (status != PNB_OK)
                print_message("%s\n", pnb_context_error(context));
            assert_int_equal(status, PNB_OK);
        }
        view_light_finish(&light);
    }
    pnb_context_destroy(context);
}

static void angles_go_there_and_back(void **state)
{
    for (int round = 0; round < 1000; round++) {
        double azimuth = 358 * uniform() - 179, elevation = 178 * uniform() - 89;
        double twist = 358 * uniform() - 179, a, e, t;
        struct view_frame_axes axes = {{0, 0, 0}};
        view_axes_from_angles(azimuth, elevation, twist, &axes.u, &axes.n);
        axes.v = v3_cross(axes.n, axes.u);
        view_axes_angles(&axes, &a, &e, &t);
        assert_true(fabs(a - azimuth) < 1e-6 && fabs(e - elevation) < 1e-6 &&
                    fabs(t - twist) < 1e-6);
    }
}

static void rays_meet_what_they_project(void **state)
{
    pnb_camera camera = {{3, 4, 5}, {0, 1, 0}, {0, 1, 0}, 40};
    for (int round = 0; round < 1000; round++) {
        view_camera_orbit(&camera, 40 * uniform() - 20, 40 * uniform() - 20);
        view_camera_zoom(&camera, 0.8 + 0.4 * uniform(), 3);
        struct view_lens lens = view_lens_make(&camera, 800, 600);
        vec3 p = v3_scale(direction(), 1.5), q;
        double x, y;
        assert_true(v3_finite(lens.eye) && v3_length(lens.right) > 0.99);
        if (!view_lens_project(&lens, p, &x, &y))
            continue;
        vec3 ray = view_lens_ray(&lens, x, y);
        vec3 off = v3_cross(v3_sub(p, lens.eye), ray);
        assert_true(v3_length(off) < 1e-6 * (1 + v3_length(lens.eye)));
        if (view_lens_on_plane(&lens, x, y, p, lens.forward, 1e6, &q))
            assert_true(v3_length(v3_sub(p, q)) < 1e-6 * (1 + v3_length(lens.eye)));
    }
}

/* A method of 1 us a pixel settles near the budget; one whose cost is fixed keeps its pixels. */
static void pacing_settles(void **state)
{
    for (int kind = 0; kind < 4; kind++) {
        struct view_pacing pacing;
        int width, height, changes = 0, last = -1;
        double ms = 0;
        view_pacing_reset(&pacing);
        for (int frame = 0; frame < 300; frame++) {
            int level = pacing.level;
            view_pacing_size(pacing.level, 800, 600, &width, &height);
            double pixels = (double)width * height;
            ms = kind == 0   ? pixels * 1e-3
                 : kind == 1 ? pixels * 2e-6
                 : kind == 2 ? 90 + pixels * 1e-6
                             : pixels * 0.3;
            view_pacing_learn(&pacing, level, ms);
            changes += frame > 100 && level != last;
            last = level;
        }
        if (kind == 0)
            assert_true(ms < 50 && ms > 15 && changes == 0);
        else if (kind == 1)
            assert_int_equal(width, 800);
        else if (kind == 2)
            assert_true(width >= 90);
        else /* 144 seconds for all pixels */
            assert_true(ms < 300);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(irradiance_is_the_library_s),
        cmocka_unit_test(pictures_are_the_library_s),
        cmocka_unit_test(encoding_is_the_library_s),
        cmocka_unit_test(lights_survive_hands),
        cmocka_unit_test(angles_go_there_and_back),
        cmocka_unit_test(rays_meet_what_they_project),
        cmocka_unit_test(pacing_settles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
