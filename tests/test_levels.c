/* test_levels.c: coarser levels of meshes: how far they are off, and what pictures lose by them. */
#define _POSIX_C_SOURCE 200809L /* setenv */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <penumbra/penumbra.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method/exact/exact.h"
#include "scene/scene.h"
#include "silhouette/levels.h"

static pnb_context *new_context(int threads)
{
    pnb_context *context;
    pnb_context_desc desc = {.threads = threads};
    assert_int_equal(pnb_context_create(&desc, &context), PNB_OK);
    return context;
}

static pnb_scene *load(pnb_context *context, const char *name)
{
    char path[1024];
    pnb_scene *scene;
    snprintf(path, sizeof(path), "%s%s", strchr(name, '/') ? "" : "builtin:", name);
    if (pnb_scene_load(context, path, &scene) != PNB_OK)
        fail_msg("%s", pnb_context_error(context));
    return scene;
}

/* Squared distance from p to the triangle, the slow and obvious way: its plane if the foot is
 * inside, else the nearest of its sides. */
static double distance2(vec3 p, const vec3 q[3])
{
    vec3 n = v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]));
    double least = INFINITY, height = v3_dot(n, v3_sub(p, q[0])), nn = v3_dot(n, n);
    bool inside = nn > 0;
    for (int i = 0; i < 3; i++) {
        vec3 a = q[i], e = v3_sub(q[(i + 1) % 3], a), d = v3_sub(p, a);
        double t = v3_dot(e, e) > 0 ? v3_dot(d, e) / v3_dot(e, e) : 0;
        vec3 x = v3_mad(d, e, -fmin(fmax(t, 0), 1));
        least = fmin(least, v3_dot(x, x));
        inside &= v3_dot(v3_cross(e, d), n) >= 0;
    }
    return inside ? height * height / nn : least;
}

static double distance_to(const struct clusters *c, vec3 p)
{
    double least = INFINITY;
    for (size_t s = 0; s < c->slot_count; s++) {
        vec3 q[3];
        for (int k = 0; k < 3; k++)
            q[k] = v3_loadf(c->positions[c->corners[s][k]]);
        least = fmin(least, distance2(p, q));
    }
    return sqrt(least);
}

static vec3 middle_of(const struct clusters *c, size_t slot)
{
    vec3 sum = v3(0, 0, 0);
    for (int k = 0; k < 3; k++)
        sum = v3_add(sum, v3_loadf(c->positions[c->corners[slot][k]]));
    return v3_scale(sum, 1.0 / 3);
}

/* Area of the picture along a direction, every layer counted. */
static double picture_of(const struct clusters *c, vec3 along)
{
    double sum = 0;
    for (size_t s = 0; s < c->slot_count; s++) {
        vec3 q[3];
        for (int k = 0; k < 3; k++)
            q[k] = v3_loadf(c->positions[c->corners[s][k]]);
        sum += fabs(v3_dot(along, v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]))));
    }
    return sum;
}

static size_t odd_edges(const struct clusters *c)
{
    size_t odd = 0;
    for (size_t e = 0; e < c->edge_count; e++)
        odd += cluster_edge_odd(&c->edges[e]);
    return odd;
}

/* Levels are closed where the mesh is, lie no farther from it than they say, both ways, and show as
 * large a picture from everywhere while they are near it. */
static void check_levels(pnb_context *context, struct mesh *mesh, const char *name, size_t least)
{
    struct clusters *fine;
    struct levels *levels;
    assert_int_equal(clusters_create(context, mesh, &fine), PNB_OK);
    assert_int_equal(levels_create(context, fine, &levels), PNB_OK);
    if (levels->count < least)
        fail_msg("%s: %zu levels", name, levels->count);
    double size = 0;
    for (int a = 0; a < 3; a++)
        size = fmax(size, (double)fine->nodes[0].high[a] - fine->nodes[0].low[a]);
    for (size_t i = 1; i < levels->count; i++) {
        const struct level *level = &levels->level[i];
        const struct clusters *c = level->clusters;
        assert_null(clusters_validate(c));
        assert_true(odd_edges(c) <= odd_edges(fine));
        assert_true(level->triangle_count < 0.76 * levels->level[i - 1].triangle_count);
        assert_true(level->error >= levels->level[i - 1].error);
        double worst = 0;
        for (size_t k = 0; k < 60; k++) {
            worst = fmax(worst, distance_to(c, middle_of(fine, k * fine->slot_count / 60)));
            worst = fmax(worst, distance_to(fine, middle_of(c, k * c->slot_count / 60)));
        }
        if (!(worst <= 1.1 * level->distance + 1e-6 * size))
            fail_msg("%s: level %zu of %zu triangles is off by %g, not %g", name, i,
                     level->triangle_count, worst, level->distance);
        if (level->distance > 0.005 * size)
            continue;
        static const vec3 ways[3] = {{0.6, 0.8, 0}, {0, -0.28, 0.96}, {0.48, 0.6, 0.64}};
        for (int w = 0; w < 3; w++) {
            double ratio = picture_of(c, ways[w]) / picture_of(fine, ways[w]);
            if (!(fabs(ratio - 1) <= 0.01))
                fail_msg("%s: level %zu is %g times as large as the mesh", name, i, ratio);
        }
    }
    levels_destroy(context, levels);
    clusters_destroy(context, fine);
}

static void test_distances(void **state)
{
    static const char *const scenes[] = {"spheres-3x3x3", "knot", "jack-in-the-box", "complex"};
    pnb_context *context = new_context(2);
    for (size_t i = 0; i < sizeof(scenes) / sizeof(*scenes); i++) {
        pnb_scene *scene = load(context, scenes[i]);
        for (size_t m = 0; m < scene->mesh_count; m++)
            check_levels(context, &scene->meshes[m], scenes[i],
                         scene->meshes[m].triangle_count > 5000 ? 5 : 1);
        pnb_scene_destroy(scene);
    }
    /* Loose leaves cannot be made coarser. */
    pnb_scene *scene = load(context, "leaves");
    for (size_t m = 0; m < scene->mesh_count; m++)
        check_levels(context, &scene->meshes[m], "leaves", 1);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

/* The scene's own light, three times as wide: coarser levels do. */
static void wide_light(pnb_scene *scene, pnb_light *light)
{
    pnb_scene_light(scene, 0, light);
    assert_int_equal(light->type, PNB_LIGHT_RECTANGLE);
    for (int a = 0; a < 3; a++)
        light->shape.rectangle.half_u[a] *= 3, light->shape.rectangle.half_v[a] *= 3;
}

static void solve(pnb_context *context, pnb_scene *scene, const char *levels,
                  const pnb_receivers *receivers, float *out)
{
    pnb_solver_param params[] = {{"levels", levels}};
    pnb_solver_desc desc = {"exact", 1024, params, 1};
    pnb_solver *solver;
    pnb_light light;
    wide_light(scene, &light);
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, receivers, out), PNB_OK);
    pnb_solver_destroy(solver);
}

struct difference {
    double mean, square, most;
    size_t count, changed;
};

static struct difference compare(const float *a, const float *b, size_t count)
{
    struct difference d = {0};
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(isnan(a[i]), isnan(b[i]));
        if (isnan(a[i]) || ((a[i] <= 0 || a[i] >= 1) && a[i] == b[i]))
            continue;
        double e = (double)a[i] - b[i];
        d.mean += e, d.square += e * e, d.most = fmax(d.most, fabs(e)), d.count++;
        d.changed += e != 0;
    }
    d.mean /= (double)d.count + 1e-9;
    d.square = sqrt(d.square / ((double)d.count + 1e-9));
    return d;
}

/* In the penumbra: at most so much off, and neither darker nor brighter. The same bits for every
 * number of threads and instruction set. */
static void test_pictures(void **state)
{
    static const struct {
        const char *name;
        double square, mean, most;
    } rows[] = {
        {"spheres-9x9", 0.0015, 0.0005, 0.012},
        {"spheres-9x9x9", 0.0012, 0.0003, 0.012},
        {"knot", 0.0012, 0.0003, 0.012},
        {"knot-96k", 0.0012, 0.0003, 0.012},
    };
    pnb_context *one = new_context(1), *three = new_context(3);
    for (size_t i = 0; i < sizeof(rows) / sizeof(*rows); i++) {
        pnb_scene *scene = load(three, rows[i].name);
        pnb_surface *surface;
        pnb_receivers receivers;
        assert_int_equal(pnb_surface_create(three, scene, NULL, 160, 120, &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        float *off = malloc(receivers.count * sizeof(float));
        float *on = malloc(receivers.count * sizeof(float));
        solve(three, scene, "off", &receivers, off);
        solve(three, scene, "auto", &receivers, on);
        struct difference d = compare(on, off, receivers.count);
        print_message("%-14s %zu of %zu differ, rms %.5f mean %+.5f most %.4f\n", rows[i].name,
                      d.changed, d.count, d.square, d.mean, d.most);
        assert_true(d.square <= rows[i].square && fabs(d.mean) <= rows[i].mean &&
                    d.most <= rows[i].most);
        if (i == 2) {
            static const char *const names[] = {"c", "avx2", "avx512"};
            for (int k = 0; k < 3; k++) {
                if (!exact_kernel_choose(names[k]))
                    continue;
                setenv("PNB_CPU", names[k], 1);
                solve(three, scene, "auto", &receivers, off);
                assert_memory_equal(on, off, receivers.count * sizeof(float));
            }
            unsetenv("PNB_CPU");
            pnb_scene *again = load(one, rows[i].name);
            solve(one, again, "auto", &receivers, off);
            assert_memory_equal(on, off, receivers.count * sizeof(float));
            pnb_scene_destroy(again);
        }
        free(on);
        free(off);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    pnb_context_destroy(one);
    pnb_context_destroy(three);
}

/* Vertices that move take the coarser levels with them: what is left is the mesh itself. */
static void test_deformed(void **state)
{
    pnb_context *context = new_context(2);
    pnb_scene *scene = load(context, "knot");
    pnb_surface *surface;
    pnb_receivers receivers;
    assert_int_equal(pnb_surface_create(context, scene, NULL, 80, 60, &surface), PNB_OK);
    pnb_surface_receivers(surface, &receivers);
    float *a = malloc(receivers.count * sizeof(float)),
          *b = malloc(receivers.count * sizeof(float));
    pnb_solver_desc desc = {.method = "exact", .samples = 1024};
    pnb_solver *solver;
    pnb_light light;
    wide_light(scene, &light);
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_VERTICES), PNB_OK); /* nothing moved */
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, a), PNB_OK);
    solve(context, scene, "auto", &receivers, b);
    assert_memory_equal(a, b, receivers.count * sizeof(float));

    for (size_t m = 0; m < scene->mesh_count; m++) {
        const struct mesh *mesh = &scene->meshes[m];
        float *moved = malloc(mesh->vertex_count * 3 * sizeof(float));
        memcpy(moved, mesh->positions, mesh->vertex_count * 3 * sizeof(float));
        for (size_t v = 0; v < mesh->vertex_count; v++)
            moved[3 * v + 1] *= mesh->triangle_count > 1000 ? 1.1f : 1;
        assert_int_equal(pnb_scene_set_vertices(scene, m, moved, NULL), PNB_OK);
        free(moved);
    }
    assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_VERTICES), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, a), PNB_OK);
    pnb_solver_destroy(solver);
    struct difference d;
    solve(context, scene, "off", &receivers, b);
    d = compare(a, b, receivers.count);
    assert_true(d.most <= 1.01 / 1024); /* clusters cut before the move, or after it */
    free(a);
    free(b);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_distances),
        cmocka_unit_test(test_pictures),
        cmocka_unit_test(test_deformed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
