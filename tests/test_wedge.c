/* test_wedge.c: the wedges on the device against their slow twin; what the blending must reach;
 * lights and meshes that are hard; random scenes. Ceilings of all scenes: opengl_ceilings.h. */
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
#include "wedge_random.h"
#include "wedge_twin.h"

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT };

struct picture {
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
};

static void take(struct picture *picture)
{
    if (pnb_surface_create(picture->context, picture->scene, NULL, WIDTH, HEIGHT,
                           &picture->surface) != PNB_OK)
        fail_msg("%s", pnb_context_error(picture->context));
    pnb_surface_receivers(picture->surface, &picture->receivers);
    pnb_scene_light(picture->scene, 0, &picture->light);
}

static void open_scene(struct picture *picture, const char *name)
{
    char path[128];
    snprintf(path, sizeof(path), "builtin:%s", name);
    if (pnb_context_create(NULL, &picture->context) != PNB_OK ||
        pnb_scene_load(picture->context, path, &picture->scene) != PNB_OK)
        fail_msg("%s", pnb_context_error(picture->context));
    take(picture);
}

static void close_scene(struct picture *picture)
{
    pnb_surface_destroy(picture->surface);
    pnb_scene_destroy(picture->scene);
    pnb_context_destroy(picture->context);
}

static pnb_solver *open_solver(struct picture *picture, const char *method,
                               const pnb_solver_param *params, size_t count)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {.method = method, .params = params, .param_count = count};
    pnb_status status = pnb_solver_create(picture->context, picture->scene, &desc, &solver);
    if (status == PNB_ERROR_DEVICE)
        skip();
    if (status != PNB_OK)
        fail_msg("%s", pnb_context_error(picture->context));
    return solver;
}

static void run(struct picture *picture, const char *method, const pnb_solver_param *params,
                size_t count, float *visibility)
{
    pnb_solver *solver = open_solver(picture, method, params, count);
    if (pnb_solver_visibility(solver, &picture->light, &picture->receivers, visibility) != PNB_OK)
        fail_msg("%s", pnb_context_error(picture->context));
    pnb_solver_destroy(solver);
}

struct twin_job {
    const struct wedge_twin *twin;
    const struct light_shape *shape;
    const pnb_receivers *receivers;
    double lift;
    struct wedge_twin_answer *answers;
};

static void twin_body(void *user, size_t begin, size_t end, int worker)
{
    const struct twin_job *job = user;
    for (size_t i = begin; i < end; i++) {
        vec3 p = v3_loadf(job->receivers->positions + 3 * i);
        vec3 n = v3_loadf(job->receivers->normals + 3 * i);
        job->answers[i] = (struct wedge_twin_answer){NAN, NAN, NAN};
        /* The twin knows no horizon. */
        if (v3_finite(p) && light_shape_faces(job->shape, p, n))
            job->answers[i] = wedge_twin_at(job->twin, v3_mad(p, n, job->lift));
    }
}

/* The device's answer is the twin's, but for what floats leave open. */
static void compare_with_twin(const char *scene, const pnb_light *light_wanted, bool center,
                              bool gravity, const char *parts)
{
    static float added[PIXELS], multiplied[PIXELS], blended[PIXELS];
    static struct wedge_twin_answer answers[PIXELS], whole_answers[PIXELS];
    struct picture picture;
    open_scene(&picture, scene);
    if (light_wanted)
        picture.light = *light_wanted;
    const pnb_solver_param params[3] = {{"silhouettes", center ? "center" : "point"},
                                        {"overlap", gravity ? "gravity" : "rectangle"},
                                        {"parts", parts}};
    run(&picture, "wedge", params, 1, added);
    run(&picture, "wedge-probabilistic", params, 1, multiplied);
    run(&picture, "wedge-blend", params, 3, blended);

    struct gl_occluders *occluders;
    struct wedge_parts *wedges;
    struct wedge_light *light;
    struct wedge_cells one, cells;
    size_t pieces;
    struct light_shape shape;
    bool changed;
    assert_int_equal(light_shape_init(picture.context, &picture.light, &shape), PNB_OK);
    assert_int_equal(gl_occluders_create(picture.scene, true, &occluders), PNB_OK);
    assert_int_equal(wedge_parts_create(picture.scene, occluders, &wedges), PNB_OK);
    assert_int_equal(wedge_lights_create(picture.context, &shape, occluders, &light, &pieces),
                     PNB_OK);
    assert_int_equal(pieces, 1);
    assert_int_equal(wedge_parts_cut(wedges, light, &changed), PNB_OK);
    int count_cells = atoi(parts);
    wedge_cells_init(light, 1, &one);
    wedge_cells_init(light, count_cells, &cells);
    bool lines = !light->rectangle || count_cells == 8;
    struct wedge_twin twin = {
        wedges, light, center, gravity, cells.columns, cells.bins, lines ? &cells : NULL};
    struct wedge_twin whole = twin; /* of one cell, where nothing is blended */
    whole.columns = whole.rows = 1;
    whole.cells = light->rectangle ? NULL : &one;
    struct twin_job job = {&twin, &shape, &picture.receivers, scene_receiver_lift(picture.scene),
                           answers};
    struct twin_job other = job;
    other.twin = &whole;
    other.answers = whole_answers;
    parallel_for(picture.context, PIXELS, 64, twin_body, &job);
    parallel_for(picture.context, PIXELS, 64, twin_body, &other);
    size_t count = 0, wrong = 0;
    for (size_t i = 0; i < PIXELS; i++) {
        if (isnan(answers[i].wedge))
            continue;
        count++;
        wrong += fabs(multiplied[i] - whole_answers[i].probabilistic) > 2e-3 ||
                 fabs(blended[i] - answers[i].blend) > 5e-3 ||
                 /* `wedge` is not continuous where the middle of the light is just hidden. */
                 fabs(added[i] - whole_answers[i].wedge) > 2e-3;
    }
    if (count < 100 || wrong > count / 100)
        fail_msg("%s, %s, %s, %s: %zu of %zu pixels differ from the twin's", scene, params[0].value,
                 params[1].value, parts, wrong, count);
    wedge_parts_destroy(wedges);
    gl_occluders_destroy(occluders);
    light_shape_finish(picture.context, &shape);
    memory_free(picture.context, light);
    close_scene(&picture);
}

static void test_twin(void **state)
{
    static const double corners[] = {-0.7, 3, -0.5, 0.9, 3, 0.1, 0.2, 3, 0.8, -0.6, 3, 0.4};
    const pnb_light disk = {.type = PNB_LIGHT_DISK,
                            .shape.disk = {{0.3, 3, 0.2}, {-0.1, -1, 0}, 0.6}};
    const pnb_light polygon = {.type = PNB_LIGHT_POLYGON, .shape.polygon = {corners, 4}};
    compare_with_twin("prism", NULL, false, true, "4");
    compare_with_twin("prism", NULL, true, false, "1");
    compare_with_twin("two-boxes", NULL, false, false, "4");
    compare_with_twin("two-boxes", NULL, true, true, "4");
    compare_with_twin("pole", NULL, false, true, "8");
    compare_with_twin("light-in-solid", NULL, false, false, "16");
    compare_with_twin("caster-through-light-plane", NULL, true, true, "4");
    compare_with_twin("caster-through-light-plane", NULL, false, true, "16");
    compare_with_twin("two-boxes", &disk, false, true, "4");
    compare_with_twin("two-boxes", &disk, true, true, "16");
    compare_with_twin("pole", &polygon, false, true, "8");
    compare_with_twin("two-boxes", &polygon, false, true, "1");
}

static pnb_errors measure(struct picture *picture, const float *visibility, const float *truth,
                          size_t *out_over)
{
    static uint8_t mask[PIXELS];
    pnb_errors errors;
    pnb_measure_facing(&picture->light, &picture->receivers, mask);
    assert_int_equal(pnb_measure(picture->context, visibility, truth, mask, PIXELS, &errors),
                     PNB_OK);
    *out_over = 0;
    for (size_t i = 0; i < PIXELS; i++)
        *out_over += mask[i] && visibility[i] < truth[i] - 0.1f;
    return errors;
}

/* Blending where silhouettes overlap: at most half the error of adding, less than multiplying, a
 * quarter of the pixels that are darker than they should be by a tenth. */
static void test_blending(void **state)
{
    static const char *const scenes[] = {"two-boxes", "spheres-3x3x3", "fence"};
    static float truth[PIXELS], visibility[PIXELS];
    static const char *const methods[] = {"wedge", "wedge-probabilistic", "wedge-blend"};
    for (size_t s = 0; s < 3; s++) {
        struct picture picture;
        double rmse[3];
        size_t over[3];
        open_scene(&picture, scenes[s]);
        run(&picture, "exact", NULL, 0, truth);
        for (int m = 0; m < 3; m++) {
            run(&picture, methods[m], NULL, 0, visibility);
            rmse[m] = measure(&picture, visibility, truth, &over[m]).rmse;
        }
        if (rmse[2] > 0.5 * rmse[0] || rmse[2] >= rmse[1] || 4 * over[2] > over[0])
            fail_msg("%s: rmse %.4f %.4f %.4f, too dark %zu %zu %zu", scenes[s], rmse[0], rmse[1],
                     rmse[2], over[0], over[1], over[2]);
        close_scene(&picture);
    }
}

/* One convex occluder is as good as exact. */
static void test_convex(void **state)
{
    static const char *const scenes[] = {"prism", "pole", "two-boxes"};
    static float truth[PIXELS], visibility[PIXELS];
    for (size_t s = 0; s < 3; s++) {
        struct picture picture;
        size_t over;
        open_scene(&picture, scenes[s]);
        run(&picture, "exact", NULL, 0, truth);
        run(&picture, "wedge-blend", NULL, 0, visibility);
        double rmse = measure(&picture, visibility, truth, &over).rmse;
        if (rmse > 0.01)
            fail_msg("%s: rmse %.4f", scenes[s], rmse);
        close_scene(&picture);
    }
}

/* A light that shrinks to a point gives the hard shadow. */
static void test_small_light(void **state)
{
    static float hard[PIXELS], soft[PIXELS];
    static const char *const methods[] = {"wedge", "wedge-probabilistic", "wedge-blend"};
    static const double sides[] = {1e-3, 1e-5};
    struct picture picture;
    open_scene(&picture, "two-boxes");
    for (int k = 0; k < 2; k++) {
        double *u = picture.light.shape.rectangle.half_u, *v = picture.light.shape.rectangle.half_v;
        double length = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
        for (int c = 0; c < 3; c++) {
            u[c] *= sides[k] / length;
            v[c] *= sides[k] / length;
        }
        run(&picture, "hard-volume", NULL, 0, hard);
        for (int m = 0; m < 3; m++) {
            run(&picture, methods[m], NULL, 0, soft);
            size_t wrong = 0;
            for (size_t i = 0; i < PIXELS; i++)
                wrong += fabsf(soft[i] - hard[i]) > 0.5f;
            if (wrong > 4)
                fail_msg("%s, %g m: %zu pixels", methods[m], sides[k], wrong);
        }
    }
    close_scene(&picture);
}

/* Moving and bending is the same as starting anew. */
static void test_update(void **state)
{
    static float after[PIXELS], fresh[PIXELS];
    struct picture picture;
    pnb_object object;
    open_scene(&picture, "two-boxes");
    pnb_solver *solver = open_solver(&picture, "wedge-blend", NULL, 0);
    assert_int_equal(pnb_solver_visibility(solver, &picture.light, &picture.receivers, after),
                     PNB_OK);
    pnb_scene_object(picture.scene, 1, &object);
    object.world_from_mesh[3] += 0.4;
    assert_int_equal(pnb_scene_set_placement(picture.scene, 1, object.world_from_mesh), PNB_OK);
    assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &picture.light, &picture.receivers, after),
                     PNB_OK);
    pnb_solver_destroy(solver);
    run(&picture, "wedge-blend", NULL, 0, fresh);
    assert_memory_equal(after, fresh, sizeof(fresh));
    close_scene(&picture);
}

/* Tiles of other sizes give the same picture: lists reject nothing that matters. */
static void test_tiles(void **state)
{
    static float first[PIXELS], other[PIXELS];
    struct picture picture;
    open_scene(&picture, "fence");
    const pnb_solver_param small = {"tile", "4"}, large = {"tile", "64"};
    run(&picture, "wedge-blend", &small, 1, first);
    run(&picture, "wedge-blend", &large, 1, other);
    for (size_t i = 0; i < PIXELS; i++)
        if (!isnan(first[i]) && fabsf(first[i] - other[i]) > 1e-3f)
            fail_msg("pixel %zu: %g and %g", i, first[i], other[i]);
    close_scene(&picture);
}

/* Lists longer than the masks: of a part that masks leave out nothing may count. */
static void test_long_lists(void **state)
{
    enum { WIDE = 200, HIGH = 150 };
    static float first[WIDE * HIGH], other[WIDE * HIGH];
    struct picture picture;
    open_scene(&picture, "spheres-9x9");
    pnb_surface_destroy(picture.surface);
    assert_int_equal(
        pnb_surface_create(picture.context, picture.scene, NULL, WIDE, HIGH, &picture.surface),
        PNB_OK);
    pnb_surface_receivers(picture.surface, &picture.receivers);
    const pnb_solver_param small = {"tile", "2"}, large = {"tile", "16"};
    run(&picture, "wedge-blend", &small, 1, first);
    run(&picture, "wedge-blend", &large, 1, other);
    for (size_t i = 0; i < WIDE * HIGH; i++)
        if (!isnan(first[i]) && fabsf(first[i] - other[i]) > 1e-3f)
            fail_msg("pixel %zu: %g and %g", i, first[i], other[i]);
    close_scene(&picture);
}

/* A triangle without area in a tear that it closes changes nothing. */
static void test_no_area(void **state)
{
    static const float corners[] = {-0.5f, 1.2f, 0,    0.5f, 1.2f, 0,    0, 1.2f,
                                    0.7f,  0,    1.7f, 0.2f, 0,    1.2f, 0};
    static const uint32_t whole[] = {0, 1, 2, 1, 0, 3, 2, 1, 3, 0, 2, 3};
    static const uint32_t torn[] = {0, 1, 2, 4, 0, 3, 1, 4, 3, 0, 4, 1, 2, 1, 3, 0, 2, 3};
    static const char *const methods[] = {"wedge", "wedge-probabilistic", "wedge-blend"};
    static float visibility[6][PIXELS];
    for (int i = 0; i < 6; i++) {
        struct picture picture;
        open_scene(&picture, "two-boxes");
        for (size_t k = 0; k < picture.scene->object_count; k++)
            picture.scene->objects[k].info.casts = false;
        const pnb_mesh_desc mesh = {
            .name = "tetrahedron",
            .positions = corners,
            .vertex_count = 5,
            .indices = i < 3 ? whole : torn,
            .triangle_count = i < 3 ? 4 : 6,
        };
        pnb_object object = {.name = "tetrahedron",
                             .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                             .casts = true};
        assert_int_equal(pnb_scene_add_mesh(picture.scene, &mesh, &object.mesh), PNB_OK);
        assert_int_equal(pnb_scene_add_object(picture.scene, &object, NULL), PNB_OK);
        run(&picture, methods[i % 3], NULL, 0, visibility[i]);
        close_scene(&picture);
    }
    for (int m = 0; m < 3; m++) {
        size_t shaded = 0;
        for (size_t i = 0; i < PIXELS; i++) {
            shaded += visibility[m][i] < 0.5f;
            if (!isnan(visibility[m][i]) && fabsf(visibility[m][i] - visibility[m + 3][i]) > 1e-3f)
                fail_msg("%s, pixel %zu: %g and %g", methods[m], i, visibility[m][i],
                         visibility[m + 3][i]);
        }
        assert_true(shaded > 20);
    }
}

/* Open meshes are warned of, other lights refused, a scene without casters is lit. */
static void test_bad_input(void **state)
{
    static float visibility[PIXELS];
    struct picture picture;
    pnb_solver_report report;
    open_scene(&picture, "leaves");
    pnb_solver *solver = open_solver(&picture, "wedge-blend", NULL, 0);
    pnb_solver_get_report(solver, &report);
    assert_true(report.warning_count > 0 && strstr(report.warnings[0], "without a partner"));
    pnb_solver_destroy(solver);
    close_scene(&picture);

    open_scene(&picture, "blocker"); /* a line */
    solver = open_solver(&picture, "wedge", NULL, 0);
    assert_int_equal(pnb_solver_visibility(solver, &picture.light, &picture.receivers, visibility),
                     PNB_ERROR_UNSUPPORTED);
    pnb_solver_destroy(solver);
    close_scene(&picture);

    open_scene(&picture, "two-boxes");
    for (size_t i = 0; i < picture.scene->object_count; i++)
        picture.scene->objects[i].info.casts = false;
    run(&picture, "wedge-blend", NULL, 0, visibility);
    static uint8_t mask[PIXELS];
    pnb_measure_facing(&picture.light, &picture.receivers, mask);
    for (size_t i = 0; i < PIXELS; i++)
        assert_true(!mask[i] || visibility[i] == 1);
    close_scene(&picture);
}

/* However a light is cut, its cells make up the light; an L is two convex pieces. */
static void test_cells(void **state)
{
    static const double l_shape[] = {0, 2, 0, 0, 2, 2, 1, 2, 2, 1, 2, 1, 2, 2, 1, 2, 2, 0};
    static const double hexagon[] = {0.3, 2, 0.1, 2,   2, 0,   2.4, 2, 1,
                                     1.5, 2, 1.9, 0.2, 2, 1.5, 0,   2, 0.9};
    double down[18], other[18];
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++) { /* lit from below: the other way round */
            down[3 * i + k] = l_shape[3 * (5 - i) + k];
            other[3 * i + k] = hexagon[3 * i + k];
        }
    const pnb_light lights[] = {
        {.type = PNB_LIGHT_RECTANGLE, .shape.rectangle = {{0, 2, 0}, {1, 0, 0.3}, {0, 0, 0.5}}},
        {.type = PNB_LIGHT_DISK, .shape.disk = {{0, 2, 0}, {0.1, -1, 0}, 0.5}},
        {.type = PNB_LIGHT_POLYGON, .shape.polygon = {down, 6}},
        {.type = PNB_LIGHT_POLYGON, .shape.polygon = {l_shape, 6}},
        {.type = PNB_LIGHT_POLYGON, .shape.polygon = {other, 6}},
    };
    static const size_t pieces[] = {1, 1, 2, 2, 1};
    static const int cuts[] = {1, 4, 8, 16};
    struct gl_occluders occluders = {.scene_low = v3(-1, 0, -1), .scene_high = v3(1, 1, 1)};
    pnb_context *context;
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (size_t i = 0; i < sizeof(lights) / sizeof(*lights); i++) {
        struct light_shape shape;
        struct wedge_light *convex;
        struct wedge_cells cells;
        size_t count;
        assert_int_equal(light_shape_init(context, &lights[i], &shape), PNB_OK);
        assert_int_equal(wedge_lights_create(context, &shape, &occluders, &convex, &count), PNB_OK);
        assert_int_equal(count, pieces[i]);
        double share = 0;
        for (size_t k = 0; k < count; k++) {
            double scale = v3_length(v3_cross(convex[k].half_u, convex[k].half_v));
            share += convex[k].share;
            for (int c = 0; c < 4; c++) {
                wedge_cells_init(&convex[k], cuts[c], &cells);
                assert_float_equal(cells.area * scale, convex[k].share * shape.area,
                                   1e-9 * shape.area);
            }
        }
        assert_float_equal(share, 1, 1e-9);
        memory_free(context, convex);
        light_shape_finish(context, &shape);
    }
    pnb_context_destroy(context);
}

/* More edges than a software rasteriser's loops take turns: it says so, and the picture is not torn
 * (it was when loops ended unnoticed: 0.26). */
static void test_many_triangles(void **state)
{
    static float truth[PIXELS], visibility[PIXELS];
    struct picture picture;
    pnb_solver_report report;
    size_t over;
    open_scene(&picture, "knot-96k");
    run(&picture, "exact", NULL, 0, truth);
    pnb_solver *solver = open_solver(&picture, "wedge-blend", NULL, 0);
    for (int frame = 0; frame < 2; frame++) {
        assert_int_equal(
            pnb_solver_visibility(solver, &picture.light, &picture.receivers, visibility), PNB_OK);
        double rmse = measure(&picture, visibility, truth, &over).rmse;
        pnb_solver_get_report(solver, &report);
        if (rmse > 0.06 || report.warning_count > 2)
            fail_msg("frame %d: rmse %.4f, %zu warnings", frame, rmse, report.warning_count);
        for (size_t i = 0; i < report.warning_count; i++)
            assert_non_null(strstr(report.warnings[i], "turns of a loop"));
    }
    pnb_solver_destroy(solver);
    close_scene(&picture);
}

static void test_random(void **state)
{
    struct wedge_random_result result;
    pnb_context *context;
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    for (uint64_t seed = 0; seed < 12; seed++) {
        pnb_status status = wedge_random_run(context, seed, &result);
        if (status == PNB_ERROR_DEVICE)
            skip();
        if (status != PNB_OK)
            fail_msg("seed %d: %s", (int)seed, pnb_context_error(context));
        if (result.what)
            fail_msg("seed %d: %s", (int)seed, result.what);
    }
    pnb_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_twin),           cmocka_unit_test(test_cells),
        cmocka_unit_test(test_blending),       cmocka_unit_test(test_convex),
        cmocka_unit_test(test_small_light),    cmocka_unit_test(test_update),
        cmocka_unit_test(test_tiles),          cmocka_unit_test(test_bad_input),
        cmocka_unit_test(test_many_triangles), cmocka_unit_test(test_random),
        cmocka_unit_test(test_long_lists),     cmocka_unit_test(test_no_area),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
