/* Soft shadow maps: the paper's two-dimensional case, depth maps against rays, error ceilings per
 * scene, undersampling and its end, degenerate input, a thousand random scenes. */
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

#include "map/map.h"
#include "scene/scene.h"
#include "trace/trace.h"

static pnb_context *context;

static int setup(void **state)
{
    return pnb_context_create(&(pnb_context_desc){.threads = 2}, &context) != PNB_OK;
}

static int teardown(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

/* Both paths; on OpenGL where there is a device, which CI has. */
static const char *const paths[] = {"cpu", "opengl"};
static int path_count = 1;

static void find_paths(void)
{
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(scene_builtin(context, "blocker", &scene), PNB_OK);
    pnb_solver_desc desc = {"line-map", 2, &(pnb_solver_param){"path", "opengl"}, 1};
    pnb_status status = pnb_solver_create(context, scene, &desc, &solver);
    path_count = status == PNB_OK ? 2 : 1;
    if (status == PNB_OK)
        pnb_solver_destroy(solver);
    else if (getenv("CI"))
        fail_msg("no OpenGL: %s", pnb_context_error(context));
    pnb_scene_destroy(scene);
}

static void add_triangles(pnb_scene *scene, const float *corners, size_t count, bool casts)
{
    uint32_t *indices = malloc(count * 12);
    for (uint32_t i = 0; i < count * 3; i++)
        indices[i] = i;
    pnb_mesh_desc mesh = {"mesh", corners, NULL, count * 3, indices, count};
    pnb_object object = {.name = "object",
                         .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                         .color = {1, 1, 1},
                         .casts = casts,
                         .receives = true};
    assert_int_equal(pnb_scene_add_mesh(scene, &mesh, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
    free(indices);
}

static void add_quad(pnb_scene *scene, double x0, double x1, double z0, double z1, double y,
                     bool casts)
{
    float c[18] = {(float)x0, (float)y, (float)z0, (float)x1, (float)y, (float)z0,
                   (float)x1, (float)y, (float)z1, (float)x0, (float)y, (float)z0,
                   (float)x1, (float)y, (float)z1, (float)x0, (float)y, (float)z1};
    add_triangles(scene, c, 2, casts);
}

static pnb_light line_light(vec3 from, vec3 to)
{
    pnb_light light = {.type = PNB_LIGHT_LINE, .color = {1, 1, 1}};
    v3_store(light.shape.line.from, from);
    v3_store(light.shape.line.to, to);
    return light;
}

static pnb_status ask(pnb_scene *scene, const char *method, int samples,
                      const pnb_solver_param *params, size_t param_count, const pnb_light *light,
                      const pnb_receivers *receivers, float *out)
{
    pnb_solver *solver;
    pnb_solver_desc desc = {method, samples, params, param_count};
    pnb_status status = pnb_solver_create(scene->context, scene, &desc, &solver);
    if (status == PNB_OK) {
        status = pnb_solver_visibility(solver, light, receivers, out);
        pnb_solver_destroy(solver);
    }
    return status;
}

/* Section 3.1: a half plane at height 2 hides x < 0. From (x, 0) its edge appears on the light y =
 * 4 + m x1 at x1 = -x / (1 + m x / 2), the paper's equation 1. */
static void one_edge(void **state)
{
    enum { N = 401 };
    static float p[N * 3], n[N * 3], v[N];
    for (int passive = 0; passive < 2; passive++)
        for (int tilted = 0; tilted < 2; tilted++) {
            double m = tilted ? 0.6 : 0;
            pnb_scene *scene;
            assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
            add_quad(scene, -4, 0, -1, 1, 2, true);
            add_quad(scene, -20, 20, -20, 20, 0, !passive);
            pnb_light light = line_light(v3(-1, 4 - m, 0), v3(1, 4 + m, 0));
            for (int i = 0; i < N; i++) {
                v3_storef(p + 3 * i, v3(-2 + 4.0 * i / (N - 1), 0, 0.1));
                v3_storef(n + 3 * i, v3(0, 1, 0));
            }
            pnb_receivers receivers = {.count = N, .positions = p, .normals = n};
            double rmse[2];
            for (int linear = 0; linear < 2; linear++) {
                const pnb_solver_param params[2] = {{"transition", linear ? "linear" : "rational"},
                                                    {"between", "dark"}};
                double sum = 0;
                assert_int_equal(ask(scene, "line-map", 2, params, 2, &light, &receivers, v),
                                 PNB_OK);
                for (int i = 0; i < N; i++) {
                    double x = p[3 * i], edge = -x / (1 + m * x / 2);
                    double truth = (1 - fmin(fmax(edge, -1), 1)) / 2;
                    sum += (v[i] - truth) * (v[i] - truth);
                    if (!linear)
                        assert_true(fabs(v[i] - truth) < 0.006);
                }
                rmse[linear] = sqrt(sum / N);
            }
            print_message("slope %.1f, ground %s: rational %.5f, linear %.5f\n", m,
                          passive ? "casts nothing" : "casts", rmse[0], rmse[1]);
            assert_true(rmse[0] < 0.003);
            /* The linear transition needs the surface that the skin ends on. */
            assert_true(passive || (tilted ? rmse[1] > 0.02 : rmse[1] < 0.003));
            pnb_scene_destroy(scene);
        }
}

/* A texel's middle by a ray from the sample: the slow twin of the scan conversion. */
static void maps_are_what_rays_hit(void **state)
{
    static const char *const names[] = {"blocker", "slanted-tube", "jack-tube", "tube-inside"};
    for (size_t k = 0; k < 4; k++) {
        pnb_scene *scene;
        struct map_geometry *geometry;
        struct map_set *set;
        struct trace *trace;
        pnb_light light;
        assert_int_equal(scene_builtin(context, names[k], &scene), PNB_OK);
        assert_int_equal(map_geometry_create(scene, &geometry), PNB_OK);
        assert_int_equal(trace_create(scene, true, &trace), PNB_OK);
        pnb_scene_light(scene, 0, &light);
        vec3 from = v3_load(light.shape.line.from), to = v3_load(light.shape.line.to);
        vec3 along = v3_sub(to, from);
        struct map_set_desc desc = {geometry, from, v3_normalize(along), v3_length(along), 97, 89};
        assert_int_equal(map_set_create(&desc, &set), PNB_OK);
        double at = 0.3 * set->length;
        assert_int_equal(map_set_add(set, &(struct map_sample){at, 0, set->length}, 1), PNB_OK);
        const struct map *map = &set->maps[0];
        size_t wrong = 0, texels = (size_t)set->rows * 89;
        for (size_t i = 0; i < texels; i++) {
            size_t row = i / 89, column = i % 89;
            vec3 out = v3_mad(v3_scale(set->y, set->row_cos[row]), set->z, set->row_sin[row]);
            vec3 direction = v3_mad(out, set->axis, map->u[column]);
            vec3 start = v3_mad(from, set->axis, at);
            struct trace_rays rays;
            struct trace_hits hits;
            int32_t valid[TRACE_WIDTH] __attribute__((aligned(64))) = {-1};
            trace_rays_init(&rays);
            rays.org_x[0] = (float)start.x;
            rays.org_y[0] = (float)start.y;
            rays.org_z[0] = (float)start.z;
            rays.dir_x[0] = (float)direction.x;
            rays.dir_y[0] = (float)direction.y;
            rays.dir_z[0] = (float)direction.z;
            trace_closest(trace, valid, &rays, &hits);
            double q = hits.object[0] == TRACE_NONE ? 0 : 1 / (double)rays.tfar[0];
            wrong += fabs(q - map->q[i]) > 1e-4 * (q + 0.01);
        }
        print_message("%s: %zu of %zu texels differ from rays\n", names[k], wrong, texels);
        assert_true(wrong <= texels / 500);
        map_set_destroy(set);
        map_geometry_destroy(geometry);
        trace_destroy(trace);
        pnb_scene_destroy(scene);
    }
}

struct ceiling {
    const char *scene;
    double two, three, five, automatic; /* RMSE; 0: not asked */
};

static void errors_stay_below_ceilings(void **state)
{
    static const struct ceiling cases[] = {
        {"blocker", 0.004, 0.004, 0.004, 0.004}, {"overlap", 0.004, 0.004, 0.004, 0.004},
        {"jack-tube", 0.03, 0.012, 0.01, 0.01},  {"slanted-tube", 0.014, 0.01, 0.01, 0.01},
        {"tube-inside", 0.02, 0.02, 0.02, 0.02}, {"triangle-light", 0.2, 0.2, 0.2, 0},
    };
    enum { W = 240, H = 180 };
    static float truth[W * H], both[2][W * H];
    static uint8_t mask[W * H];
    find_paths();
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
        const struct ceiling *c = &cases[k];
        const double ceilings[4] = {c->two, c->three, c->five, c->automatic};
        static const int counts[4] = {2, 3, 5, 0};
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        pnb_light light;
        assert_int_equal(scene_builtin(context, c->scene, &scene), PNB_OK);
        assert_int_equal(pnb_surface_create(context, scene, NULL, W, H, &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        pnb_scene_light(scene, 0, &light);
        assert_int_equal(ask(scene, "reference", 1024, NULL, 0, &light, &receivers, truth), PNB_OK);
        pnb_measure_facing(&light, &receivers, mask);
        for (int i = 0; i < 4; i++) {
            pnb_errors errors;
            if (ceilings[i] <= 0)
                continue;
            int on = counts[i] == 3 ? path_count : 1;
            for (int path = 0; path < on; path++) {
                const pnb_solver_param param[2] = {{"samples", counts[i] ? "given" : "auto"},
                                                   {"path", paths[path]}};
                float *v = both[path];
                assert_int_equal(ask(scene, "line-map", counts[i], param, 2, &light, &receivers, v),
                                 PNB_OK);
                assert_int_equal(pnb_measure(context, v, truth, mask, W * H, &errors), PNB_OK);
                print_message("%-16s k %d %s: RMSE %.4f, ceiling %.3f\n", c->scene, counts[i],
                              paths[path], errors.rmse, ceilings[i]);
                if (!(errors.rmse <= ceilings[i]))
                    fail_msg("%s, %d samples, %s: RMSE %.4f above %.3f", c->scene, counts[i],
                             paths[path], errors.rmse, ceilings[i]);
            }
            if (on < 2)
                continue;
            assert_int_equal(pnb_measure(context, both[1], both[0], mask, W * H, &errors), PNB_OK);
            if (!(errors.rmse <= 0.01))
                fail_msg("%s, %d samples: the paths differ by %.4f", c->scene, counts[i],
                         errors.rmse);
        }
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
}

/* The paper's figure 6: between two blockers the ground sees the light's middle and neither end. */
static void undersampling_ends_at_three(void **state)
{
    pnb_scene *scene;
    pnb_light light;
    const float p[3] = {0, 0, 0}, n[3] = {0, 1, 0};
    const double truth = 0.6 * 2.6 / 1.16 / 2.4;
    float v;
    pnb_receivers receivers = {.count = 1, .positions = p, .normals = n};
    pnb_solver_param paper = {"between", "dark"};
    assert_int_equal(scene_builtin(context, "overlap", &scene), PNB_OK);
    pnb_scene_light(scene, 0, &light);
    assert_int_equal(ask(scene, "line-map", 2, &paper, 1, &light, &receivers, &v), PNB_OK);
    assert_true(v == 0);
    assert_int_equal(ask(scene, "line-map", 3, &paper, 1, &light, &receivers, &v), PNB_OK);
    assert_true(fabs(v - truth) < 0.05);
    /* The occluders that both maps see leave the middle open. */
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &light, &receivers, &v), PNB_OK);
    assert_true(fabs(v - truth) < 0.01);
    pnb_scene_destroy(scene);
}

static void in_range(const float *v, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!(v[i] >= 0 && v[i] <= 1))
            fail_msg("visibility %g of receiver %zu", (double)v[i], i);
}

static void degenerate_input(void **state)
{
    enum { N = 400 };
    static float p[N * 3], n[N * 3], v[N];
    pnb_scene *scene;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    for (int i = 0; i < N; i++) {
        v3_storef(p + 3 * i, v3(-2 + 0.2 * (i % 20), 0, -2 + 0.2 * (double)(i / 20)));
        v3_storef(n + 3 * i, v3(0, 1, 0));
    }
    pnb_receivers receivers = {.count = N, .positions = p, .normals = n};
    pnb_light above = line_light(v3(-1, 2, 0), v3(1, 2, 0));

    /* Nothing casts; then a ground alone, and under an open scene no discontinuity at all. */
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &above, &receivers, v), PNB_OK);
    for (int i = 0; i < N; i++)
        assert_true(v[i] == 1);
    add_quad(scene, -4, 4, -4, 4, 0, true);
    assert_int_equal(ask(scene, "line-map", 3, NULL, 0, &above, &receivers, v), PNB_OK);
    for (int i = 0; i < N; i++)
        assert_true(v[i] == 1);

    /* Receivers below the light's level see nothing of it from behind; half of it where their
     * plane cuts it. */
    pnb_light below = line_light(v3(-1, -2, 0), v3(1, -2, 0));
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &below, &receivers, v), PNB_OK);
    for (int i = 0; i < N; i++)
        assert_true(v[i] == 0);
    pnb_light through = line_light(v3(0, -1, 0.05), v3(0, 1, 0.05));
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &through, &receivers, v), PNB_OK);
    for (int i = 0; i < N; i++)
        if (!(fabs(v[i] - 0.5) < 0.01))
            fail_msg("receiver %d: %g of a light that the ground cuts in two", i, (double)v[i]);

    /* Beneath the ground, facing up: the ground is in the way though no map holds it. */
    for (int i = 0; i < N; i++)
        p[3 * i + 1] = -0.5f;
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &above, &receivers, v), PNB_OK);
    for (int i = 0; i < N; i++)
        assert_true(v[i] == 0);
    for (int i = 0; i < N; i++)
        p[3 * i + 1] = 0;

    /* A light that touches, lies in and pierces an occluder; receivers on the light's line. */
    add_quad(scene, -0.5, 0.5, -0.5, 0.5, 1, true);
    const pnb_light lights[] = {
        line_light(v3(-1, 1, 0), v3(1, 1, 0)),         line_light(v3(-0.5, 1, -0.5), v3(0, 2, 0)),
        line_light(v3(0.1, 0.5, 0), v3(0, 1.5, 0.1)),  line_light(v3(-2, 0.5, 0), v3(-1, 0.5, 0)),
        line_light(v3(0, 0, 0), v3(0, 3, 0)),          line_light(v3(-1, 0, 0), v3(1, 0, 0)),
        line_light(v3(0, 1e-6, 0), v3(1e-6, 1e-6, 0)), line_light(v3(-1e6, 9, 0), v3(1e6, 9, 0)),
    };
    static const char *const sizes[] = {"2", "3", "64"};
    for (size_t k = 0; k < sizeof(lights) / sizeof(*lights); k++)
        for (int s = 0; s < 3; s++) {
            const pnb_solver_param params[2] = {{"size", sizes[s]}, {"overlap", "nearest"}};
            assert_int_equal(
                ask(scene, "line-map", 2 + s, params, 1 + (size_t)s % 2, &lights[k], &receivers, v),
                PNB_OK);
            in_range(v, N);
            assert_int_equal(ask(scene, "sampled-maps", 3, params, 1, &lights[k], &receivers, v),
                             PNB_OK);
            in_range(v, N);
        }

    /* What is refused, and with a reason; receivers that are none. */
    pnb_light none = line_light(v3(1, 1, 1), v3(1, 1, 1));
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &none, &receivers, v), PNB_ERROR_SCENE);
    assert_int_equal(ask(scene, "line-map", 1, NULL, 0, &above, &receivers, v), PNB_ERROR_ARGUMENT);
    pnb_light sun = {.type = PNB_LIGHT_SUN,
                     .color = {1, 1, 1},
                     .shape.sun = {.direction = {0, -1, 0}, .angular_diameter_degrees = 1}};
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &sun, &receivers, v),
                     PNB_ERROR_UNSUPPORTED);
    p[0] = NAN;
    assert_int_equal(ask(scene, "line-map", 2, NULL, 0, &above, &receivers, v), PNB_OK);
    assert_true(isnan(v[0]));
    in_range(v + 1, N - 1);
    pnb_scene_destroy(scene);
}

static uint64_t random_state = 7;

static double uniform(void)
{
    uint64_t z = random_state += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static vec3 anywhere(bool round)
{
    vec3 p = v3(4 * uniform() - 2, 4 * uniform() - 2, 4 * uniform() - 2);
    if (round) /* many coincidences */
        p = v3(floor(p.x + 0.5), floor(p.y + 0.5), floor(p.z + 0.5));
    return p;
}

static void a_thousand_random_scenes(void **state)
{
    enum { N = 64 };
    static const char *const sizes[] = {"2", "7", "32"};
    for (int k = 0; k < 1000; k++) {
        pnb_scene *scene;
        bool round = uniform() < 0.5;
        assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
        for (int object = 0; object < 2; object++) {
            float corners[9 * 12];
            size_t count = 1 + (size_t)(12 * uniform());
            for (size_t i = 0; i < 3 * count; i++)
                v3_storef(corners + 3 * i, anywhere(round));
            add_triangles(scene, corners, count, object == 0 || uniform() < 0.7);
        }
        float p[N * 3], n[N * 3], v[N];
        for (int i = 0; i < N; i++) {
            v3_storef(p + 3 * i, anywhere(round));
            v3_storef(n + 3 * i,
                      v3_normalize(v3(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5)));
        }
        pnb_receivers receivers = {.count = N, .positions = p, .normals = n};
        pnb_light light = line_light(anywhere(round), anywhere(round));
        pnb_solver_param params[5] = {{"size", sizes[(int)(3 * uniform())]},
                                      {"samples", uniform() < 0.1 ? "auto" : "given"},
                                      {"overlap", uniform() < 0.3 ? "nearest" : "least"},
                                      {"transition", uniform() < 0.3 ? "linear" : "rational"},
                                      {"between", uniform() < 0.3 ? "dark" : "spans"}};
        pnb_status status =
            ask(scene, "line-map", 2 + (int)(4 * uniform()), params, 5, &light, &receivers, v);
        if (status == PNB_OK)
            in_range(v, N);
        else
            assert_int_equal(status, PNB_ERROR_SCENE); /* a light of no length */
        pnb_scene_destroy(scene);
    }
}

/* The same on OpenGL: one solver, whose triangles change. */
static void a_thousand_random_scenes_on_opengl(void **state)
{
    enum { N = 64, TRIANGLES = 9 };
    find_paths();
    if (path_count < 2)
        skip();
    const pnb_camera camera = {{0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 45};
    float corners[2][9 * TRIANGLES];
    pnb_scene *scene;
    pnb_solver *solver;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    for (int object = 0; object < 2; object++) {
        for (size_t i = 0; i < 3 * TRIANGLES; i++)
            v3_storef(corners[object] + 3 * i, anywhere(false));
        add_triangles(scene, corners[object], TRIANGLES, object == 0);
    }
    pnb_solver_desc desc = {"line-map", 3, (pnb_solver_param[]){{"path", "opengl"}, {"size", "24"}},
                            2};
    assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
    for (int k = 0; k < 1000; k++) {
        bool round = uniform() < 0.5;
        float p[N * 3], n[N * 3], v[N];
        for (size_t object = 0; object < 2; object++) {
            for (size_t i = 0; i < 3 * TRIANGLES; i++)
                v3_storef(corners[object] + 3 * i, anywhere(round));
            assert_int_equal(pnb_scene_set_vertices(scene, object, corners[object], NULL), PNB_OK);
        }
        assert_int_equal(pnb_solver_update(solver, PNB_UPDATE_VERTICES), PNB_OK);
        for (int i = 0; i < N; i++) {
            double depth = 5 + 8 * uniform(), half = tan(M_PI / 8) * depth;
            v3_storef(p + 3 * i, v3(half * ((i % 8 + 0.5) / 4 - 1), half * (1 - (i / 8 + 0.5) / 4),
                                    9 - depth));
            v3_storef(n + 3 * i,
                      v3_normalize(v3(uniform() - 0.5, uniform() - 0.5, uniform() - 0.5)));
        }
        pnb_receivers receivers = {
            .count = N, .positions = p, .normals = n, .width = 8, .height = 8, .camera = &camera};
        pnb_light light = line_light(anywhere(round), anywhere(round));
        pnb_status status = pnb_solver_visibility(solver, &light, &receivers, v);
        if (status == PNB_OK)
            in_range(v, N);
        else if (status != PNB_ERROR_SCENE) /* a light of no length */
            fail_msg("%s", pnb_context_error(context));
    }
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
}

static void threads_do_not_matter(void **state)
{
    enum { W = 160, H = 120 };
    static float v[2][W * H];
    for (int k = 0; k < 2; k++) {
        pnb_context *own;
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        pnb_light light;
        assert_int_equal(pnb_context_create(&(pnb_context_desc){.threads = k ? 5 : 1}, &own),
                         PNB_OK);
        assert_int_equal(scene_builtin(own, "jack-tube", &scene), PNB_OK);
        assert_int_equal(pnb_surface_create(own, scene, NULL, W, H, &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        pnb_scene_light(scene, 0, &light);
        assert_int_equal(ask(scene, "line-map", 3, NULL, 0, &light, &receivers, v[k]), PNB_OK);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
        pnb_context_destroy(own);
    }
    assert_memory_equal(v[0], v[1], sizeof(v[0]));
}

/* The baseline against the same points by rays. */
static void sampled_maps_are_right(void **state)
{
    enum { W = 160, H = 120 };
    static float truth[W * H], v[W * H];
    static uint8_t mask[W * H];
    static const char *const names[] = {"blocker", "jack-in-the-box", "disk", "triangle-light"};
    for (size_t k = 0; k < 4; k++) {
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        pnb_light light;
        pnb_errors errors;
        assert_int_equal(scene_builtin(context, names[k], &scene), PNB_OK);
        assert_int_equal(pnb_surface_create(context, scene, NULL, W, H, &surface), PNB_OK);
        pnb_surface_receivers(surface, &receivers);
        pnb_scene_light(scene, 0, &light);
        pnb_measure_facing(&light, &receivers, mask);
        assert_int_equal(ask(scene, "reference", 1024, NULL, 0, &light, &receivers, truth), PNB_OK);
        assert_int_equal(ask(scene, "sampled-maps", 64, NULL, 0, &light, &receivers, v), PNB_OK);
        assert_int_equal(pnb_measure(context, v, truth, mask, W * H, &errors), PNB_OK);
        print_message("%-16s 64 maps: RMSE %.4f\n", names[k], errors.rmse);
        assert_true(errors.rmse < 0.05);
        assert_int_equal(ask(scene, "hard-map", 0, NULL, 0, &light, &receivers, v), PNB_OK);
        for (size_t i = 0; i < W * H; i++)
            assert_true(isnan(v[i]) || v[i] == 0 || v[i] == 1);
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_edge),
        cmocka_unit_test(maps_are_what_rays_hit),
        cmocka_unit_test(errors_stay_below_ceilings),
        cmocka_unit_test(undersampling_ends_at_three),
        cmocka_unit_test(degenerate_input),
        cmocka_unit_test(a_thousand_random_scenes),
        cmocka_unit_test(a_thousand_random_scenes_on_opengl),
        cmocka_unit_test(threads_do_not_matter),
        cmocka_unit_test(sampled_maps_are_right),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
