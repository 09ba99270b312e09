/* test_exact.c: clusters, instruction sets, updates and analytic cases of the method `exact`. */
#define _POSIX_C_SOURCE 200809L /* setenv */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exact_twin.h"
#include "scene/scene.h"

static pnb_context *new_context(int threads)
{
    pnb_context *context;
    pnb_context_desc desc = {.threads = threads};
    assert_int_equal(pnb_context_create(&desc, &context), PNB_OK);
    return context;
}

static void solve(pnb_context *context, const struct twin_case *c, const char *area, float *out)
{
    pnb_solver_param params[] = {{"exact-area", area}};
    pnb_solver_desc desc = {"exact", 1024, params, 1};
    pnb_solver *solver;
    assert_int_equal(pnb_solver_create(context, c->scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &c->light, &c->receivers, out), PNB_OK);
    pnb_solver_destroy(solver);
}

static void test_clusters(void **state)
{
    pnb_context *context = new_context(1);
    for (uint64_t seed = 0; seed < 60; seed++) {
        struct twin_case c;
        assert_true(twin_case_init(context, seed, &c));
        for (size_t m = 0; m < c.scene->mesh_count; m++) {
            struct clusters *clusters;
            assert_int_equal(clusters_create(context, &c.scene->meshes[m], &clusters), PNB_OK);
            assert_null(clusters_validate(clusters));
            assert_true(clusters_refit(clusters, &c.scene->meshes[m]));
            clusters_destroy(context, clusters);
        }
        twin_case_finish(&c);
    }
    pnb_context_destroy(context);
}

/* Same bits for every instruction set, thread count and run. */
static void test_same_bits(void **state)
{
    static const char *const names[] = {"c", "avx2", "avx512"};
    pnb_context *one = new_context(1), *three = new_context(3);
    for (uint64_t seed = 0; seed < 40; seed++) {
        struct twin_case c;
        assert_true(twin_case_init(one, seed, &c));
        float first[TWIN_RECEIVERS], other[TWIN_RECEIVERS];
        for (int area = 0; area < 3; area++) {
            static const char *const areas[] = {"off", "on", "auto"};
            setenv("PNB_CPU", "c", 1);
            solve(one, &c, areas[area], first);
            for (int i = 0; i < 3; i++) {
                if (!exact_kernel_choose(names[i]))
                    continue;
                setenv("PNB_CPU", names[i], 1);
                solve(one, &c, areas[area], other);
                assert_memory_equal(first, other, sizeof(first));
            }
            unsetenv("PNB_CPU");
            struct twin_case d;
            assert_true(twin_case_init(three, seed, &d));
            solve(three, &d, areas[area], other);
            assert_memory_equal(first, other, sizeof(first));
            twin_case_finish(&d);
        }
        twin_case_finish(&c);
    }
    setenv("PNB_CPU", "mmx", 1);
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(pnb_scene_create(one, &scene), PNB_OK);
    assert_int_equal(pnb_solver_create(one, scene, &(pnb_solver_desc){.method = "exact"}, &solver),
                     PNB_ERROR_DEVICE);
    unsetenv("PNB_CPU");
    pnb_scene_destroy(scene);
    pnb_context_destroy(one);
    pnb_context_destroy(three);
}

/* The kernels' resolve against the plain one, on random grids. */
static void test_resolve(void **state)
{
    pnb_context *context = new_context(1);
    struct twin_random random = {7};
    pnb_light light = {.type = PNB_LIGHT_DISK, .shape.disk = {{0, 0, 0}, {0, 1, 0}, 1}};
    struct exact_light shape;
    assert_int_equal(exact_light_init(context, &light, 1024, true, &shape), PNB_OK);
    size_t size = exact_cover_size(&shape.grid);
    int32_t *cells = calloc(size, sizeof(*cells));
    int32_t left[EXACT_ROWS_MAX] = {0};
    uint32_t touched = 0;
    struct exact_cover cover = {&shape.grid, cells, left, &touched, true, 2};
    static const char *const names[] = {"c", "avx2", "avx512"};
    for (int run = 0; run < 300; run++) {
        memset(cells, 0, size * sizeof(*cells));
        memset(left, 0, sizeof(left));
        touched = 0x1ffff;
        cover.unit = 1 + run % 2;
        for (int row = 0; row < shape.grid.rows && run % 3 == 0; row += 3) {
            int by = twin_below(&random, 3), end = twin_below(&random, shape.grid.rows);
            left[row] += row < end ? by : 0;
            left[end] -= row < end ? by : 0;
        }
        for (int i = twin_below(&random, 400); i > 0; i--) {
            int row = twin_below(&random, shape.grid.rows),
                a = twin_below(&random, shape.grid.bins);
            int b = a + twin_below(&random, shape.grid.bins - a), by = 1 + twin_below(&random, 2);
            for (int end = 0; end < 2; end++) {
                int at = (end ? b : a) * shape.grid.stride + row, c = end ? -by : by;
                cells[at] = exact_cell_add(cells[at], c, twin_below(&random, 513) - 256);
            }
        }
        double plain = exact_cover_resolve(&cover);
        for (int i = 0; i < 3; i++) {
            const struct exact_kernel *kernel = exact_kernel_choose(names[i]);
            if (kernel)
                assert_true(kernel->resolve(&cover) == plain);
        }
    }
    free(cells);
    exact_light_finish(context, &shape);
    pnb_context_destroy(context);
}

static void test_twin(void **state)
{
    /* Point lights on occluders' vertices, seen edge-on. */
    static const uint64_t touching[] = {350, 662, 1422, 1559, 1600, 2388};
    pnb_context *context = new_context(0);
    for (uint64_t i = 0; i < 36; i++) {
        uint64_t seed = i < 30 ? 5000 + i : touching[i - 30];
        struct twin_case c;
        assert_true(twin_case_init(context, seed, &c));
        float visibility[TWIN_RECEIVERS], area[TWIN_RECEIVERS], closed[TWIN_RECEIVERS];
        double truth[TWIN_RECEIVERS];
        solve(context, &c, "off", visibility);
        solve(context, &c, "on", area);
        solve(context, &c, "auto", closed);
        twin_visibility(context, &c, 1024, truth);
        for (size_t k = 0; k < c.receivers.count; k++) {
            assert_true(fabs(visibility[k] - truth[k]) < 0.005);
            if (c.light.type != PNB_LIGHT_POINT)
                assert_true(fabs(area[k] - truth[k]) < 0.08);
            if (c.light.type == PNB_LIGHT_RECTANGLE)
                assert_true(fabs(closed[k] - truth[k]) < 0.02);
        }
        twin_case_finish(&c);
    }
    pnb_context_destroy(context);
}

/* Moving objects and vertices, and solving, is the same as starting anew. */
static void test_update(void **state)
{
    pnb_context *context = new_context(1);
    struct twin_random random = {99};
    for (uint64_t seed = 0; seed < 30; seed++) {
        struct twin_case c;
        assert_true(twin_case_init(context, seed, &c));
        pnb_solver *solver;
        pnb_solver_desc desc = {.method = "exact"};
        float moved[TWIN_RECEIVERS], anew[TWIN_RECEIVERS];
        assert_int_equal(pnb_solver_create(context, c.scene, &desc, &solver), PNB_OK);
        for (size_t o = 0; o < pnb_scene_object_count(c.scene); o++) {
            pnb_object object;
            pnb_scene_object(c.scene, o, &object);
            object.world_from_mesh[3] += 0.1 * twin_uniform(&random);
            object.world_from_mesh[5] *= twin_below(&random, 4) ? 1 : 0;
            assert_int_equal(pnb_scene_set_placement(c.scene, o, object.world_from_mesh), PNB_OK);
        }
        assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS), PNB_OK);
        pnb_mesh_desc mesh;
        pnb_scene_mesh(c.scene, 0, &mesh);
        float *positions = malloc(mesh.vertex_count * 3 * sizeof(float));
        bool tear = seed % 2;
        for (size_t v = 0; v < 3 * mesh.vertex_count; v++)
            positions[v] =
                mesh.positions[v] * 1.25f + (tear ? 0.05f * (float)twin_uniform(&random) : 0);
        assert_int_equal(pnb_scene_set_vertices(c.scene, 0, positions, NULL), PNB_OK);
        free(positions);
        assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_VERTICES), PNB_OK);
        assert_int_equal(pnb_solver_visibility(solver, &c.light, &c.receivers, moved), PNB_OK);
        pnb_solver_destroy(solver);
        assert_int_equal(pnb_solver_create(context, c.scene, &desc, &solver), PNB_OK);
        assert_int_equal(pnb_solver_visibility(solver, &c.light, &c.receivers, anew), PNB_OK);
        pnb_solver_destroy(solver);
        for (size_t i = 0; i < c.receivers.count; i++)
            assert_true(fabsf(moved[i] - anew[i]) < 2e-3f);
        twin_case_finish(&c);
    }
    pnb_context_destroy(context);
}

static size_t add_quad(pnb_scene *scene, const float *corners);

/* The box from low to high, outwards or inwards. */
static void box_mesh(const double low[3], const double high[3], bool inwards, float *positions,
                     uint32_t *indices, uint32_t first)
{
    static const uint8_t faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    for (int v = 0; v < 8; v++)
        for (int k = 0; k < 3; k++)
            positions[3 * v + k] = (float)(v >> k & 1 ? high[k] : low[k]);
    for (int t = 0; t < 12; t++)
        for (int i = 0; i < 3; i++) {
            int corner = inwards ? 2 - i : i;
            indices[3 * t + i] = first + faces[t / 2][t % 2 && corner ? corner + 1 : corner];
        }
}

static size_t add_boxes(pnb_scene *scene, const double (*boxes)[2][3], size_t count, bool inwards)
{
    float positions[3 * 8 * 8];
    uint32_t indices[36 * 8];
    for (size_t i = 0; i < count; i++)
        box_mesh(boxes[i][0], boxes[i][1], inwards, positions + 24 * i, indices + 36 * i,
                 (uint32_t)(8 * i));
    pnb_mesh_desc desc = {"boxes", positions, NULL, 8 * count, indices, 12 * count};
    pnb_object object = {
        .name = "boxes", .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .casts = true};
    size_t index;
    assert_int_equal(pnb_scene_add_mesh(scene, &desc, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, &index), PNB_OK);
    return object.mesh;
}

/* Which meshes are solids, or sets of them. */
static void test_solids(void **state)
{
    static const double boxes[3][2][3] = {
        {{0, 0, 0}, {1, 1, 1}}, {{2, 0, 0}, {3, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    /* One box; two; inside out; two in one place; the sphere of the suite; a knot. */
    add_boxes(scene, boxes, 1, false);
    add_boxes(scene, boxes, 2, false);
    add_boxes(scene, boxes, 1, true);
    add_boxes(scene, (const double[2][2][3]){{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}}, 2,
              false);
    static const bool solid[4] = {true, false, false, false};
    static const size_t count[4] = {0, 2, 0, 0};
    for (int i = 0; i < 4; i++) {
        struct clusters *clusters;
        struct parts *parts;
        assert_int_equal(clusters_create(context, &scene->meshes[i], &clusters), PNB_OK);
        assert_int_equal(clusters->solid, solid[i]);
        assert_true(clusters->dent == 0);
        assert_int_equal(parts_create(context, &scene->meshes[i], &parts), PNB_OK);
        assert_int_equal(parts ? parts->count : 0, count[i]);
        for (size_t k = 0; k < count[i]; k++) {
            assert_null(clusters_validate(parts->clusters[k]));
            assert_true(parts->clusters[k]->solid);
            assert_int_equal(parts->clusters[k]->slot_count, 12);
        }
        bool torn = true;
        if (parts)
            assert_int_equal(parts_refit(context, parts, &scene->meshes[i], &torn), PNB_OK);
        assert_int_equal(torn, parts == NULL);
        parts_destroy(context, parts);
        clusters_destroy(context, clusters);
    }
    pnb_scene_destroy(scene);
    static const char *const scenes[] = {"builtin:spheres-3x3x3", "builtin:knot"};
    for (int i = 0; i < 2; i++) {
        struct clusters *clusters;
        assert_int_equal(pnb_scene_load(context, scenes[i], &scene), PNB_OK);
        assert_int_equal(clusters_create(context, &scene->meshes[1], &clusters), PNB_OK);
        assert_int_equal(clusters->solid, i == 0);
        assert_true(i == 1 || (clusters->dent > 0 && clusters->dent < 0.02f));
        clusters_destroy(context, clusters);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(context);
}

static double counter(const pnb_solver *solver, const char *name)
{
    pnb_solver_report report;
    pnb_solver_get_report(solver, &report);
    for (size_t i = 0; i < report.counter_count; i++)
        if (strcmp(report.counters[i].name, name) == 0)
            return report.counters[i].value;
    fail_msg("no counter %s", name);
    return 0;
}

static double overlap(double a0, double a1, double b0, double b1)
{
    return fmax(0, fmin(a1, b1) - fmax(a0, b0));
}

/* Two boxes over a floor, apart: from below them, their pictures on a square light are those of
 * their lower faces, rectangles whose areas are known. */
static void test_closed_form(void **state)
{
    static const double boxes[2][2][3] = {{{-0.3, 1, -0.3}, {-0.02, 1.001, 0.3}},
                                          {{0.04, 1, -0.25}, {0.4, 1.001, 0.21}}};
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_quad(scene, (const float[]){-4, 0, -4, -4, 0, 4, 4, 0, 4, 4, 0, -4});
    add_boxes(scene, boxes, 2, false);
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                       .shape.rectangle = {{0, 2, 0}, {0.5, 0, 0}, {0, 0, 0.5}}};
    static const char *const modes[] = {"auto", "on", "off"};
    for (int mode = 0; mode < 3; mode++) {
        pnb_solver_param params[] = {{"exact-area", modes[mode]}};
        pnb_solver_desc desc = {"exact", 1024, params, 1};
        pnb_solver *solver;
        assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
        float positions[3 * 16 * 16], normals[3 * 16 * 16], v[16 * 16];
        for (int i = 0; i < 256; i++) {
            positions[3 * i] = (float)(0.05 * (i % 16 - 7.3));
            positions[3 * i + 1] = normals[3 * i] = normals[3 * i + 2] = 0;
            positions[3 * i + 2] = (float)(0.05 * (i / 16 - 7.9));
            normals[3 * i + 1] = 1;
        }
        pnb_receivers receivers = {
            .count = 256, .positions = positions, .normals = normals, .width = 16, .height = 16};
        assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, v), PNB_OK);
        for (int i = 0; i < 256; i++) {
            /* What the upper faces and the sides add is less than 0.002. */
            double x = positions[3 * i], z = positions[3 * i + 2], seen = 1;
            for (int b = 0; b < 2; b++) {
                const double *low = boxes[b][0], *high = boxes[b][1];
                seen -= overlap(2 * low[0] - x, 2 * high[0] - x, -0.5, 0.5) *
                        overlap(2 * low[2] - z, 2 * high[2] - z, -0.5, 0.5);
            }
            assert_true(v[i] < seen + (mode < 2 ? 3e-5 : 0.02));
            assert_true(v[i] > seen - (mode < 2 ? 0.002 : 0.02));
        }
        assert_true(counter(solver, "lit") + counter(solver, "umbra") +
                        counter(solver, "closed_form") + counter(solver, "sampled") ==
                    256);
        assert_true(mode < 2 ? counter(solver, "sampled") == 0
                             : counter(solver, "closed_form") == 0);
        pnb_solver_destroy(solver);
    }
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

static size_t add_quad(pnb_scene *scene, const float *corners)
{
    static const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    pnb_mesh_desc desc = {"quad", corners, NULL, 4, indices, 2};
    pnb_object object = {
        .name = "quad", .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .casts = true};
    size_t index;
    assert_int_equal(pnb_scene_add_mesh(scene, &desc, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, &index), PNB_OK);
    return index;
}

/* A half-plane half way up cuts a square light at known places: lengths along rows are exact. */
static void test_half_plane(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_quad(scene, (const float[]){0, 1, -9, 0, 1, 9, 9, 1, 9, 9, 1, -9});
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                       .shape.rectangle = {{0, 2, 0}, {0.5, 0, 0}, {0, 0, 0.5}}};
    light.shape.rectangle.half_v[2] = 0.5; /* u x v points down */
    pnb_solver *solver;
    assert_int_equal(
        pnb_solver_create(context, scene, &(pnb_solver_desc){.method = "exact"}, &solver), PNB_OK);
    float positions[3 * 41], normals[3 * 41], v[41];
    for (int i = 0; i < 41; i++) {
        positions[3 * i] = (float)(-0.6 + 0.03 * i), positions[3 * i + 1] = 0;
        positions[3 * i + 2] = 0.01f * (float)i;
        normals[3 * i] = normals[3 * i + 2] = 0, normals[3 * i + 1] = 1;
    }
    pnb_receivers receivers = {.count = 41, .positions = positions, .normals = normals};
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, v), PNB_OK);
    for (int i = 0; i < 41; i++) {
        /* The border x = 0 at y = 1 is seen at x = -p on the light. */
        double seen = fmin(fmax(0.5 - positions[3 * i], 0), 1);
        assert_true(fabs(v[i] - seen) < 0.002);
    }
    /* From behind the light, and below the surface. */
    positions[1] = 3;
    normals[4] = -1;
    positions[6] = NAN;
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, v), PNB_OK);
    assert_true(v[0] == 0);
    assert_true(v[1] == 0);
    assert_true(isnan(v[2]));
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* Receivers that only their lift takes behind a slanting light: on its lit side, they see it. */
static void test_behind_by_lift(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_quad(scene, (const float[]){-10, 0, -10, -10, 0, 10, 10, 0, 10, 10, 0, -10});
    add_quad(scene, (const float[]){-1, 0.5f, 0, -1, 0.5f, 1, -1, 1.5f, 1, -1, 1.5f, 0});
    /* Its plane meets the floor at x = -2, where its half with z > 0 is hidden. */
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                       .shape.rectangle = {{0, 2, 0}, {0, 0, 0.5}, {-0.35, -0.35, 0}}};
    double lift = scene_receiver_lift(scene);
    float positions[3 * 8], normals[3 * 8], v[8], alone;
    for (int i = 0; i < 8; i++) {
        positions[3 * i] = (float)(-2 + lift * (0.5 * i - 0.75));
        positions[3 * i + 1] = positions[3 * i + 2] = 0;
        normals[3 * i] = normals[3 * i + 2] = 0, normals[3 * i + 1] = 1;
    }
    static const char *const methods[] = {"exact", "reference"};
    static const char *const paths[] = {"silhouette", "triangles"};
    for (int run = 0; run < 3; run++) {
        pnb_solver_param params[] = {{"path", paths[run % 2]}};
        pnb_solver_desc desc = {methods[run / 2], 1024, params, run < 2};
        pnb_solver *solver;
        assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
        pnb_receivers receivers = {.count = 8, .positions = positions, .normals = normals};
        assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, v), PNB_OK);
        for (int i = 0; i < 8; i++) {
            assert_true(i < 2 ? v[i] == 0 : fabs(v[i] - 0.5) < 0.01);
            receivers = (pnb_receivers){1, positions + 3 * i, normals + 3 * i, 0, 0, NULL, NULL};
            assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, &alone), PNB_OK);
            assert_true(run == 2 || fabsf(v[i] - alone) < 2.01f / 1024);
        }
        pnb_solver_destroy(solver);
    }
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* 600 sheets, half of them in one place: the count wraps nowhere near. */
static void test_deep_stack(void **state)
{
    pnb_context *context = new_context(1);
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    size_t count = 600;
    float *positions = malloc(count * 12 * sizeof(float));
    uint32_t *indices = malloc(count * 6 * sizeof(uint32_t));
    for (size_t i = 0; i < count; i++) {
        const float y = i < 300 ? 1 : 1 + 0.001f * (float)i;
        const float quad[12] = {-1, y, -1, -1, y, 1, 1, y, 1, 1, y, -1};
        const uint32_t k = (uint32_t)(4 * i), two[6] = {k, k + 1, k + 2, k, k + 2, k + 3};
        memcpy(positions + 12 * i, quad, sizeof(quad));
        memcpy(indices + 6 * i, two, sizeof(two));
    }
    pnb_mesh_desc desc = {"stack", positions, NULL, 4 * count, indices, 2 * count};
    pnb_object object = {
        .name = "stack", .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, .casts = true};
    size_t index;
    assert_int_equal(pnb_scene_add_mesh(scene, &desc, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, &index), PNB_OK);
    free(positions);
    free(indices);
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE,
                       .shape.rectangle = {{0, 4, 0}, {0.5, 0, 0}, {0, 0, 0.5}}};
    pnb_solver *solver;
    assert_int_equal(
        pnb_solver_create(context, scene, &(pnb_solver_desc){.method = "exact"}, &solver), PNB_OK);
    const float p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    float v;
    pnb_receivers receivers = {.count = 1, .positions = p, .normals = n};
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, &v), PNB_OK);
    assert_true(v == 0);
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* One frame of a built-in scene. */
static void solve_frame(pnb_context *context, pnb_scene *scene, const char *path, const char *area,
                        int samples, const pnb_receivers *receivers, float *out)
{
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    pnb_solver_param params[] = {{"exact-area", area}, {"path", path}};
    pnb_solver_desc desc = {"exact", samples, params, 2};
    pnb_solver *solver;
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, receivers, out), PNB_OK);
    double finite = 0;
    for (size_t i = 0; i < receivers->count; i++)
        finite += !isnan(out[i]);
    assert_true(counter(solver, "lit") + counter(solver, "umbra") + counter(solver, "closed_form") +
                    counter(solver, "sampled") ==
                finite);
    pnb_solver_destroy(solver);
}

/* Frames of many tiles, flat and curved ones, groups of instances, instances behind others: the
 * same bits for every instruction set, and what every triangle by itself gives. */
static void test_frames(void **state)
{
    static const char *const scenes[] = {"fence", "spheres-3x3x3", "spheres-9x9x9", "leaves"};
    static const char *const names[] = {"c", "avx2", "avx512"};
    static const int sizes[4][2] = {{120, 90}, {120, 90}, {40, 30}, {60, 45}};
    pnb_context *context = new_context(2);
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++) {
        char path[64];
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        snprintf(path, sizeof(path), "builtin:%s", scenes[s]);
        assert_int_equal(pnb_scene_load(context, path, &scene), PNB_OK);
        assert_int_equal(
            pnb_surface_create(context, scene, NULL, sizes[s][0], sizes[s][1], &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        float *first = malloc(receivers.count * sizeof(float));
        float *other = malloc(receivers.count * sizeof(float));
        setenv("PNB_CPU", "c", 1);
        solve_frame(context, scene, "silhouette", "off", 1024, &receivers, first);
        for (int i = 1; i < 3; i++) {
            if (!exact_kernel_choose(names[i]))
                continue;
            setenv("PNB_CPU", names[i], 1);
            solve_frame(context, scene, "silhouette", "off", 1024, &receivers, other);
            assert_memory_equal(first, other, receivers.count * sizeof(float));
        }
        unsetenv("PNB_CPU");
        solve_frame(context, scene, "triangles", "off", 1024, &receivers, other);
        size_t off = 0;
        for (size_t i = 0; i < receivers.count; i++) {
            assert_int_equal(isnan(first[i]), isnan(other[i]));
            off += fabsf(first[i] - other[i]) > 2.01f / 1024;
        }
        assert_true(off <= receivers.count / 1000);
        free(first);
        free(other);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(context);
}

static double frame_error(const float *a, const float *b, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += isnan(a[i]) ? 0 : (double)(a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum / (double)count);
}

/* Areas in closed form, where they are known, are nearer to what many samples say than as many
 * samples as usual; the same bits for every instruction set. */
static void test_closed_frames(void **state)
{
    static const char *const scenes[] = {"prism", "spheres-9x9", "spheres-3x3x3", "fence"};
    static const char *const names[] = {"c", "avx2", "avx512"};
    pnb_context *context = new_context(2);
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++) {
        char path[64];
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        snprintf(path, sizeof(path), "builtin:%s", scenes[s]);
        assert_int_equal(pnb_scene_load(context, path, &scene), PNB_OK);
        assert_int_equal(pnb_surface_create(context, scene, NULL, 120, 90, &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        float *v[4];
        for (int i = 0; i < 4; i++)
            v[i] = malloc(receivers.count * sizeof(float));
        solve_frame(context, scene, "silhouette", "off", 4096, &receivers, v[0]);
        solve_frame(context, scene, "silhouette", "off", 1024, &receivers, v[1]);
        setenv("PNB_CPU", "c", 1);
        solve_frame(context, scene, "silhouette", "auto", 1024, &receivers, v[2]);
        for (int i = 1; i < 3; i++) {
            if (!exact_kernel_choose(names[i]))
                continue;
            setenv("PNB_CPU", names[i], 1);
            solve_frame(context, scene, "silhouette", "auto", 1024, &receivers, v[3]);
            assert_memory_equal(v[2], v[3], receivers.count * sizeof(float));
        }
        unsetenv("PNB_CPU");
        double sampled = frame_error(v[1], v[0], receivers.count);
        double closed = frame_error(v[2], v[0], receivers.count);
        assert_true(closed <= sampled);
        assert_true(s > 1 || closed < 0.9 * sampled);
        for (int i = 0; i < 4; i++)
            free(v[i]);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_clusters),       cmocka_unit_test(test_same_bits),
        cmocka_unit_test(test_resolve),        cmocka_unit_test(test_twin),
        cmocka_unit_test(test_update),         cmocka_unit_test(test_half_plane),
        cmocka_unit_test(test_deep_stack),     cmocka_unit_test(test_frames),
        cmocka_unit_test(test_behind_by_lift), cmocka_unit_test(test_solids),
        cmocka_unit_test(test_closed_form),    cmocka_unit_test(test_closed_frames),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
