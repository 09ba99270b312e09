/* Edge adjacency: known solids, broken meshes, the real meshes, and a slow twin. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/mesh.h"
#include "mesh/shape.h"
#include "mesh/simplify.h"
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

static const struct mesh_edges *edges_of(struct mesh *mesh, const float *positions, size_t vertices,
                                         const uint32_t *indices, size_t triangles)
{
    pnb_mesh_desc desc = {"test", positions, NULL, vertices, indices, triangles};
    const struct mesh_edges *edges;
    assert_int_equal(mesh_init(context, mesh, &desc), PNB_OK);
    assert_int_equal(mesh_get_edges(context, mesh, &edges), PNB_OK);
    assert_null(mesh_edges_validate(mesh, edges));
    return edges;
}

static void tetrahedron_is_closed(void **state)
{
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t t[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    struct mesh mesh;
    const struct mesh_edges *e = edges_of(&mesh, p, 4, t, 4);
    assert_int_equal(e->edge_count, 6);
    assert_int_equal(e->use_count, 12);
    assert_int_equal(e->open_count + e->non_manifold_count + e->inconsistent_count, 0);
    assert_int_equal(e->degenerate_triangle_count, 0);
    mesh_finish(context, &mesh);
}

static void welding_takes_minus_zero_as_zero(void **state)
{
    /* Two triangles of a square with all six corners given apart. */
    static const float p[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, -0.0f, -0.0f, 0, 1, 1, -0.0f, 0, 1, 0};
    static const uint32_t t[] = {0, 1, 2, 3, 4, 5};
    struct mesh mesh;
    const struct mesh_edges *e = edges_of(&mesh, p, 6, t, 2);
    assert_int_equal(e->welded_count, 4);
    assert_int_equal(e->edge_count, 5);
    assert_int_equal(e->open_count, 4);
    assert_int_equal(e->inconsistent_count, 0);
    mesh_finish(context, &mesh);
}

static void broken_meshes_are_counted(void **state)
{
    static const float p[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0.5f, 0, 0};
    struct mesh mesh;
    /* Both run 0 -> 1. */
    static const uint32_t clash[] = {0, 1, 2, 0, 1, 3};
    const struct mesh_edges *e = edges_of(&mesh, p, 6, clash, 2);
    assert_int_equal(e->inconsistent_count, 1);
    assert_int_equal(e->open_count, 4);
    mesh_finish(context, &mesh);
    /* Three pages of a book. */
    static const uint32_t book[] = {0, 1, 2, 1, 0, 3, 0, 1, 4};
    e = edges_of(&mesh, p, 6, book, 3);
    assert_int_equal(e->non_manifold_count, 1);
    assert_int_equal(e->inconsistent_count, 1);
    assert_int_equal(e->open_count, 6);
    mesh_finish(context, &mesh);
    /* A line, a doubled corner, a point. */
    static const uint32_t degenerate[] = {0, 5, 1, 0, 0, 2, 3, 3, 3};
    e = edges_of(&mesh, p, 6, degenerate, 3);
    assert_int_equal(e->degenerate_triangle_count, 3);
    assert_int_equal(e->use_count, 5);
    mesh_finish(context, &mesh);
    e = edges_of(&mesh, p, 0, degenerate, 0);
    assert_int_equal(e->edge_count, 0);
    mesh_finish(context, &mesh);
}

static bool same_place(const float *p, uint32_t a, uint32_t b)
{
    return p[3 * a] == p[3 * b] && p[3 * a + 1] == p[3 * b + 1] && p[3 * a + 2] == p[3 * b + 2];
}

/* Every pair of corners compared: the obvious way. */
static void slow_twin_agrees(void **state)
{
    uint32_t seed = 1;
    for (int round = 0; round < 200; round++) {
        enum { VERTICES = 40, TRIANGLES = 60 };
        float p[VERTICES * 3];
        uint32_t t[TRIANGLES * 3];
        for (int i = 0; i < VERTICES * 3; i++) {
            seed = seed * 1664525u + 1013904223u;
            p[i] = (float)((int)(seed >> 24) % 3 - 1) * (round % 2 ? 0.5f : -1.0f);
        }
        for (int i = 0; i < TRIANGLES * 3; i++) {
            seed = seed * 1664525u + 1013904223u;
            t[i] = (seed >> 8) % VERTICES;
        }
        struct mesh mesh;
        const struct mesh_edges *e = edges_of(&mesh, p, VERTICES, t, TRIANGLES);
        size_t open = 0, many = 0, clash = 0, edge_count = 0;
        for (int i = 0; i < TRIANGLES * 3; i++) {
            uint32_t a = t[i], b = t[i % 3 == 2 ? i - 2 : i + 1];
            if (same_place(p, a, b))
                continue;
            int along = 0, against = 0;
            bool first = true;
            for (int j = 0; j < TRIANGLES * 3; j++) {
                uint32_t c = t[j], d = t[j % 3 == 2 ? j - 2 : j + 1];
                bool same = same_place(p, a, c) && same_place(p, b, d);
                bool turned = same_place(p, a, d) && same_place(p, b, c);
                along += same;
                against += turned;
                first = first && !((same || turned) && j < i);
            }
            if (!first)
                continue;
            edge_count++;
            open += along + against == 1;
            many += along + against > 2;
            clash += (size_t)(along > 1) + (size_t)(against > 1);
        }
        assert_int_equal(e->edge_count, edge_count);
        assert_int_equal(e->open_count, open);
        assert_int_equal(e->non_manifold_count, many);
        assert_int_equal(e->inconsistent_count, clash);
        mesh_finish(context, &mesh);
    }
}

/* Positions and faces (as fans) of an OBJ file, no more. */
static bool read_obj(const char *name, struct mesh *mesh)
{
    char path[1024], line[4096];
    const char *models = getenv("PNB_MODELS"), *source = getenv("PNB_SOURCE_DIR");
    if (models)
        snprintf(path, sizeof(path), "%s/%s", models, name);
    else
        snprintf(path, sizeof(path), "%s/../shared/models/%s", source ? source : ".", name);
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    float *p = malloc(sizeof(float) * 3 * 400000);
    uint32_t *t = malloc(sizeof(uint32_t) * 3 * 400000);
    size_t vertices = 0, triangles = 0;
    while (fgets(line, sizeof(line), file)) {
        if (line[0] == 'v' && line[1] == ' ') {
            float *q = p + 3 * vertices++;
            assert_int_equal(sscanf(line + 2, "%f %f %f", q, q + 1, q + 2), 3);
        } else if (line[0] == 'f' && line[1] == ' ') {
            uint32_t face[64];
            int corners = 0;
            for (char *word = strtok(line + 2, " \r\n"); word; word = strtok(NULL, " \r\n"))
                face[corners++] = (uint32_t)atoi(word) - 1;
            for (int i = 2; i < corners; i++) {
                t[3 * triangles] = face[0];
                t[3 * triangles + 1] = face[i - 1];
                t[3 * triangles++ + 2] = face[i];
            }
        }
    }
    fclose(file);
    pnb_mesh_desc desc = {name, p, NULL, vertices, t, triangles};
    assert_int_equal(mesh_init(context, mesh, &desc), PNB_OK);
    free(p);
    free(t);
    return true;
}

static void real_meshes_have_known_counts(void **state)
{
    static const struct {
        const char *name;
        size_t triangles, open, non_manifold, inconsistent;
    } expected[] = {
        {"spot.obj", 5856, 0, 0, 0},       {"cow.obj", 5804, 0, 0, 0},
        {"fandisk.obj", 12946, 0, 0, 0},   {"rocker-arm.obj", 20088, 0, 0, 0},
        {"nefertiti.obj", 99938, 0, 0, 0}, {"stanford-bunny.obj", 69451, 223, 0, 0},
        {"teapot.obj", 6320, 160, 0, 0},   {"suzanne.obj", 968, SIZE_MAX, 1, 2},
    };
    for (size_t i = 0; i < sizeof(expected) / sizeof(expected[0]); i++) {
        struct mesh mesh;
        const struct mesh_edges *e;
        if (!read_obj(expected[i].name, &mesh)) {
            print_message("SKIP: no folder with the real meshes\n");
            skip();
        }
        double start = clock_ms();
        assert_int_equal(mesh_get_edges(context, &mesh, &e), PNB_OK);
        print_message("%-20s %6zu triangles: %zu edges, %zu open, %zu non-manifold, %zu "
                      "inconsistent, %zu degenerate; %.1f ms\n",
                      expected[i].name, mesh.triangle_count, e->edge_count, e->open_count,
                      e->non_manifold_count, e->inconsistent_count, e->degenerate_triangle_count,
                      clock_ms() - start);
        assert_null(mesh_edges_validate(&mesh, e));
        assert_int_equal(mesh.triangle_count, expected[i].triangles);
        if (expected[i].open != SIZE_MAX)
            assert_int_equal(e->open_count, expected[i].open);
        else
            assert_true(e->open_count > 0);
        assert_int_equal(e->non_manifold_count, expected[i].non_manifold);
        assert_int_equal(e->inconsistent_count, expected[i].inconsistent);
        mesh_finish(context, &mesh);
    }
}

/* A coarser mesh: closed stays closed, nothing moves by much, boxes stay boxes. */
static void simplified_meshes_stay_closed(void **state)
{
    static const char *const scenes[] = {"builtin:knot", "builtin:spheres-3x3x3",
                                         "builtin:two-boxes", "builtin:leaves"};
    for (size_t i = 0; i < 4; i++) {
        pnb_scene *scene;
        assert_int_equal(pnb_scene_load(context, scenes[i], &scene), PNB_OK);
        for (size_t m = 0; m < scene->mesh_count; m++) {
            struct mesh *mesh = &scene->meshes[m], coarse;
            double size = v3_length(v3_sub(mesh->bounds_max, mesh->bounds_min));
            assert_int_equal(mesh_simplify(context, mesh, 0.005 * size, &coarse), PNB_OK);
            const struct mesh_edges *before, *after;
            assert_int_equal(mesh_get_edges(context, mesh, &before), PNB_OK);
            assert_int_equal(mesh_get_edges(context, &coarse, &after), PNB_OK);
            assert_null(mesh_edges_validate(&coarse, after));
            if (before->open_count + before->non_manifold_count == 0) {
                assert_int_equal(after->open_count, 0);
                double v0 = shape_volume(mesh->positions, mesh->indices, mesh->triangle_count);
                double v1 = shape_volume(coarse.positions, coarse.indices, coarse.triangle_count);
                print_message("%s, mesh %zu: %zu to %zu triangles, volume x %.4f\n", scenes[i], m,
                              mesh->triangle_count, coarse.triangle_count, v1 / v0);
                assert_true(fabs(v1 / v0 - 1) < 0.1);
                assert_true(coarse.triangle_count <= mesh->triangle_count);
            }
            assert_true(v3_length(v3_sub(coarse.bounds_max, mesh->bounds_max)) < 0.03 * size);
            mesh_finish(context, &coarse);
            /* Without a limit something is left all the same. */
            assert_int_equal(mesh_simplify(context, mesh, INFINITY, &coarse), PNB_OK);
            assert_true(coarse.triangle_count > 0 || mesh->triangle_count == 0);
            mesh_finish(context, &coarse);
        }
        pnb_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tetrahedron_is_closed),
        cmocka_unit_test(welding_takes_minus_zero_as_zero),
        cmocka_unit_test(broken_meshes_are_counted),
        cmocka_unit_test(slow_twin_agrees),
        cmocka_unit_test(real_meshes_have_known_counts),
        cmocka_unit_test(simplified_meshes_stay_closed),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
