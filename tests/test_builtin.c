/* The built-in scenes: each can be made, is the same every time, and consists of closed, outward
 * meshes where it should; those that papers give numbers for have these numbers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "light/light.h"
#include "mesh/shape.h"
#include "scene/scene.h"

static pnb_context *context;

static int setup(void **state)
{
    return pnb_context_create(NULL, &context) != PNB_OK;
}

static int teardown(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

static void every_scene_is_sound(void **state)
{
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_scene *scene;
        pnb_builtin(i, &info);
        assert_true(*info.name && *info.title && info.source);
        for (size_t k = 0; k < i; k++) {
            pnb_builtin_info other;
            pnb_builtin(k, &other);
            assert_string_not_equal(info.name, other.name);
        }
        double start = clock_ms();
        if (scene_builtin(context, info.name, &scene) != PNB_OK)
            fail_msg("%s: %s", info.name, pnb_context_error(context));
        char name[80];
        snprintf(name, sizeof(name), "builtin:%s", info.name);
        assert_string_equal(pnb_scene_name(scene), name);
        assert_true(pnb_scene_light_count(scene) > 0 && pnb_scene_object_count(scene) > 1);
        assert_true(pnb_scene_exposure(scene) > 0);
        print_message("%-28s %7zu triangles %6.1f ms\n", info.name, pnb_scene_triangle_count(scene),
                      clock_ms() - start);

        /* Nothing lies below the ground: contact is contact, not burial. */
        double low[3], high[3];
        assert_true(pnb_scene_bounds(scene, low, high));
        assert_true(low[1] > -0.11);

        for (size_t m = 0; m < pnb_scene_mesh_count(scene); m++) {
            pnb_mesh_info mesh;
            pnb_mesh_desc desc;
            assert_int_equal(pnb_scene_mesh_info(scene, m, &mesh), PNB_OK);
            pnb_scene_mesh(scene, m, &desc);
            assert_int_equal(mesh.degenerate_triangle_count, 0);
            assert_int_equal(mesh.non_manifold_edge_count, 0);
            assert_int_equal(mesh.inconsistent_edge_count, 0);
            if (strcmp(mesh.name, "ground") == 0 || strcmp(mesh.name, "leaves") == 0)
                continue;
            if (!mesh.closed ||
                !(shape_volume(desc.positions, desc.indices, desc.triangle_count) > 0))
                fail_msg("%s: mesh %s is open or inside out", info.name, mesh.name);
        }
        pnb_scene_destroy(scene);
    }
}

static void lights_face_the_scene(void **state)
{
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_scene *scene;
        pnb_builtin(i, &info);
        assert_int_equal(scene_builtin(context, info.name, &scene), PNB_OK);
        for (size_t k = 0; k < pnb_scene_light_count(scene); k++) {
            pnb_light light;
            float target[3], up[3] = {0, 1, 0}, irradiance[3];
            pnb_camera camera;
            pnb_scene_light(scene, k, &light);
            pnb_scene_camera(scene, &camera);
            v3_storef(target, v3_load(camera.target));
            target[1] = 0;
            assert_int_equal(pnb_light_irradiance(context, &light, target, up, 1, irradiance),
                             PNB_OK);
            if (!(irradiance[1] > 0))
                fail_msg("%s: light %zu does not reach the ground", info.name, k);
        }
        pnb_scene_destroy(scene);
    }
}

static void papers_counts_are_kept(void **state)
{
    static const struct {
        const char *name;
        size_t occluders; /* triangles of all objects but the ground, and steps of complex */
    } cases[] = {
        {"prism", 8},
        {"distance-1", 224},
        {"light-size-4", 960},
        {"complex", 5760 + 24},
        {"complex-1440", 1440 + 24},
        {"spheres-9x9", 81 * 762},
        {"spheres-3x3x3", 27 * 762},
        {"spheres-9x9x9", 729 * 762},
        {"fence", 2474 - 2},
        {"knot", 10000},
        {"knot-96k", 96000},
        {"knot-768k", 768000},
        {"leaves", 10000 + 44},
        {"leaves-20k", 20000 + 44},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        pnb_scene *scene;
        assert_int_equal(scene_builtin(context, cases[i].name, &scene), PNB_OK);
        assert_int_equal(pnb_scene_triangle_count(scene), cases[i].occluders + 2);
        if (strncmp(cases[i].name, "spheres", 7) == 0)
            assert_int_equal(pnb_scene_mesh_count(scene), 2);
        pnb_scene_destroy(scene);
    }
}

static void same_scene_every_time(void **state)
{
    pnb_scene *a, *b;
    assert_int_equal(scene_builtin(context, "leaves", &a), PNB_OK);
    assert_int_equal(scene_builtin(context, "leaves", &b), PNB_OK);
    pnb_mesh_desc x, y;
    pnb_scene_mesh(a, 1, &x);
    pnb_scene_mesh(b, 1, &y);
    assert_int_equal(x.vertex_count, y.vertex_count);
    assert_memory_equal(x.positions, y.positions, x.vertex_count * 12);
    pnb_scene_destroy(a);
    pnb_scene_destroy(b);
}

static void unknown_names_point_to_the_list(void **state)
{
    pnb_scene *scene;
    assert_int_equal(pnb_scene_load(context, "builtin:prisn", &scene), PNB_ERROR_FILE);
    assert_null(scene);
    assert_string_equal(
        pnb_context_error(context),
        "builtin:prisn: no built-in scene of that name; \"penumbra scenes\" lists them");
    assert_int_equal(pnb_scene_load(context, "builtin:", &scene), PNB_ERROR_FILE);
}

static void shapes_have_their_volume(void **state)
{
    struct shape shape;
    shape_init(context, &shape);
    shape_box(&shape, v3(-1, 0, 2), v3(1, 3, 2.5));
    assert_true(fabs(shape_volume(shape.positions, shape.indices, 12) - 3) < 1e-6);
    shape_finish(&shape);
    shape_sphere_762(&shape, v3(5, -3, 2), 2);
    assert_int_equal(shape.triangle_count, 762);
    assert_int_equal(shape.vertex_count, 383);
    double volume = shape_volume(shape.positions, shape.indices, 762), ball = 4.0 / 3 * M_PI * 8;
    assert_true(volume < ball && volume > 0.975 * ball);
    shape_finish(&shape);
    shape_torus(&shape, 2, 0.5, 200, 100);
    volume = shape_volume(shape.positions, shape.indices, shape.triangle_count);
    assert_true(fabs(volume / (2 * M_PI * M_PI * 2 * 0.25) - 1) < 2e-3);
    /* Normals point outwards: away from the circle in the middle of the tube. */
    for (size_t i = 0; i < shape.vertex_count; i++) {
        vec3 p = v3_loadf(shape.positions + 3 * i), n = v3_loadf(shape.normals + 3 * i);
        vec3 middle = v3_scale(v3_normalize(v3(p.x, 0, p.z)), 2);
        assert_true(v3_dot(n, v3_normalize(v3_sub(p, middle))) > 0.999);
    }
    shape_finish(&shape);
    shape_rod(&shape, v3(0, 0, 0), v3(3, 0, 4), 1, 0, 400);
    volume = shape_volume(shape.positions, shape.indices, shape.triangle_count);
    assert_true(fabs(volume / (M_PI * 5 / 3) - 1) < 1e-3);
    shape_finish(&shape);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_scene_is_sound),
        cmocka_unit_test(lights_face_the_scene),
        cmocka_unit_test(papers_counts_are_kept),
        cmocka_unit_test(same_scene_every_time),
        cmocka_unit_test(unknown_names_point_to_the_list),
        cmocka_unit_test(shapes_have_their_volume),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
