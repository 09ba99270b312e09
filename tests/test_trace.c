/* Primary hits, shadow rays and the visible surface against a loop over all triangles; the formula
 * of the picture. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

#include "trace/trace.h"

static pnb_context *context;
static pnb_scene *scene;

static int set_up(void **state)
{
    return pnb_context_create(NULL, &context) != PNB_OK ||
           pnb_scene_create(context, &scene) != PNB_OK;
}

static int tear_down(void **state)
{
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return 0;
}

static uint32_t random_state = 1;

static double uniform(void) /* [-1, 1) */
{
    random_state = random_state * 1664525u + 1013904223u;
    return (random_state >> 8) / 8388608.0 - 1;
}

static size_t add_mesh(const float *corners, const float *normals, uint32_t triangles)
{
    uint32_t *indices = malloc(triangles * 3 * sizeof(*indices));
    size_t mesh;
    for (uint32_t i = 0; i < 3 * triangles; i++)
        indices[i] = i;
    pnb_mesh_desc desc = {"mesh", corners, normals, 3 * triangles, indices, triangles};
    assert_int_equal(pnb_scene_add_mesh(scene, &desc, &mesh), PNB_OK);
    free(indices);
    return mesh;
}

/* A soup of small triangles, one in eight without area, placed four times by turns, shears and
 * mirrorings; the second and fourth cast no shadow. */
static void add_soup(void)
{
    enum { TRIANGLES = 200 };
    float corners[TRIANGLES * 9];
    for (int i = 0; i < TRIANGLES; i++) {
        vec3 at = v3(uniform(), uniform(), uniform()), p[3];
        for (int k = 0; k < 3; k++)
            p[k] = v3_mad(at, v3(uniform(), uniform(), uniform()), 0.3);
        if (i % 16 == 0)
            p[2] = p[1];
        else if (i % 16 == 8)
            p[2] = v3_scale(v3_add(p[0], p[1]), 0.5);
        for (int k = 0; k < 3; k++)
            v3_storef(corners + 9 * i + 3 * k, p[k]);
    }
    size_t mesh = add_mesh(corners, NULL, TRIANGLES);
    static const double placements[4][12] = {
        {1, 0, 0, 1, 0, 1, 0, 0.5, 0, 0, 1, 0},
        {0, 0, 1, -1, 0, 1, 0, 0.5, -1, 0, 0, 0},
        {-0.7, 0.3, 0, 1, 0, 0.5, 0.2, -1, 0, 0, 1.5, -1},
        {0.5, 0, 0, -1, 0, -0.5, 0, -1, 0, 0, 0.5, 1},
    };
    for (int i = 0; i < 4; i++) {
        pnb_object object = {.name = "soup", .mesh = mesh, .receives = true, .casts = i % 2 == 0};
        memcpy(object.world_from_mesh, placements[i], sizeof(placements[i]));
        for (int c = 0; c < 3; c++)
            object.color[c] = 0.25 * (i + 1) - 0.1 * c;
        assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
    }
}

/* World-space corners as the tracer has them: floats. */
static void corners_of(size_t object, size_t triangle, vec3 p[3])
{
    pnb_object info;
    pnb_mesh_desc mesh;
    pnb_scene_object(scene, object, &info);
    pnb_scene_mesh(scene, info.mesh, &mesh);
    for (int k = 0; k < 3; k++) {
        float rounded[3];
        v3_storef(rounded,
                  m34_point(info.world_from_mesh,
                            v3_loadf(mesh.positions + 3 * (size_t)mesh.indices[3 * triangle + k])));
        p[k] = v3_loadf(rounded);
    }
}

struct hit {
    size_t object, triangle;
    double t, second; /* of the nearest hit, and of the next one */
    double edge;      /* how near the ray passes to any edge of a triangle, as a barycentric */
};

static struct hit first_hit(vec3 origin, vec3 direction, bool casters_only)
{
    struct hit hit = {PNB_NO_OBJECT, 0, INFINITY, INFINITY, INFINITY};
    for (size_t o = 0; o < pnb_scene_object_count(scene); o++) {
        pnb_object info;
        pnb_mesh_desc mesh;
        pnb_scene_object(scene, o, &info);
        pnb_scene_mesh(scene, info.mesh, &mesh);
        for (size_t i = 0; i < mesh.triangle_count && (info.casts || !casters_only); i++) {
            vec3 p[3];
            corners_of(o, i, p);
            vec3 e1 = v3_sub(p[1], p[0]), e2 = v3_sub(p[2], p[0]);
            vec3 n = v3_cross(e1, e2), from = v3_sub(origin, p[0]);
            double d = -v3_dot(direction, n);
            if (v3_length(n) < 1e-12 || d == 0)
                continue;
            vec3 q = v3_cross(direction, from);
            double t = v3_dot(from, n) / d, u = v3_dot(e2, q) / -d, v = v3_dot(e1, q) / d;
            if (t <= 0)
                continue;
            double inside = fmin(fmin(u, v), 1 - u - v);
            if (t < hit.second + 1e-3)
                hit.edge = fmin(hit.edge, fabs(inside));
            if (inside < 0)
                continue;
            if (t < hit.t) {
                hit.second = hit.t;
                hit = (struct hit){o, i, t, hit.second, hit.edge};
            } else if (t < hit.second) {
                hit.second = t;
            }
        }
    }
    return hit;
}

/* Where two triangles lie at one depth or a ray meets an edge, floats may decide otherwise. */
static bool clear_cut(const struct hit *hit)
{
    return hit->edge > 1e-4 && !(hit->second - hit->t < 1e-4);
}

static void surface_is_the_nearest_triangle(void **state)
{
    enum { WIDTH = 83, HEIGHT = 61 };
    const pnb_camera camera = {{0.3, 0.4, 5}, {0.1, -0.2, 0}, {0.1, 1, 0}, 50};
    add_soup();
    pnb_surface *surface;
    pnb_surface_view view;
    assert_int_equal(pnb_surface_create(context, scene, &camera, WIDTH, HEIGHT, &surface), PNB_OK);
    pnb_surface_get(surface, &view);
    vec3 eye = v3_load(camera.eye), forward = v3_normalize(v3_sub(v3_load(camera.target), eye));
    vec3 right = v3_normalize(v3_cross(forward, v3_load(camera.up)));
    vec3 up = v3_cross(right, forward);
    double half = tan(25 * M_PI / 180);
    int seen = 0, none = 0, doubtful = 0;
    for (int j = 0; j < HEIGHT; j++)
        for (int i = 0; i < WIDTH; i++) {
            size_t pixel = (size_t)j * WIDTH + (size_t)i;
            double x = (2 * (i + 0.5) / WIDTH - 1) * half * WIDTH / HEIGHT;
            double y = (1 - 2 * (j + 0.5) / HEIGHT) * half;
            vec3 direction = v3_mad(v3_mad(forward, right, x), up, y);
            struct hit hit = first_hit(eye, direction, false);
            vec3 p = v3_loadf(view.positions + 3 * pixel), n = v3_loadf(view.normals + 3 * pixel);
            if (!clear_cut(&hit)) {
                doubtful++;
                continue;
            }
            assert_int_equal(view.objects[pixel], hit.object);
            if (hit.object == PNB_NO_OBJECT) {
                none++;
                assert_true(isnan(p.x) && isnan(p.y) && isnan(p.z) && isnan(n.x) &&
                            isnan(view.shading_normals[3 * pixel]) && isnan(view.depth[pixel]));
                continue;
            }
            seen++;
            vec3 corner[3];
            corners_of(hit.object, hit.triangle, corner);
            vec3 normal =
                v3_normalize(v3_cross(v3_sub(corner[1], corner[0]), v3_sub(corner[2], corner[0])));
            /* On the pixel's ray, on the triangle's plane, seen from its front. */
            assert_true(v3_length(v3_sub(p, v3_mad(eye, direction, hit.t))) < 2e-4);
            assert_true(fabs(v3_dot(v3_sub(p, corner[0]), normal)) < 2e-6);
            assert_true(fabs(fabs(v3_dot(n, normal)) - 1) < 1e-6);
            assert_true(v3_dot(n, direction) < 0);
            assert_true(fabs(v3_length(n) - 1) < 1e-6);
            assert_true(fabs(view.depth[pixel] - hit.t) < 2e-4); /* direction has depth 1 */
            /* Without vertex normals: flat. */
            assert_memory_equal(view.shading_normals + 3 * pixel, view.normals + 3 * pixel,
                                3 * sizeof(float));
        }
    assert_true(seen > WIDTH * HEIGHT / 5 && none > 100 && doubtful < WIDTH * HEIGHT / 50);
    pnb_surface_destroy(surface);
}

static void shadow_rays_meet_casters_alone(void **state)
{
    add_soup();
    for (int casters_only = 0; casters_only < 2; casters_only++) {
        struct trace *trace;
        assert_int_equal(trace_create(scene, casters_only, &trace), PNB_OK);
        int blocked = 0, free = 0;
        for (int packet = 0; packet < 100; packet++) {
            struct trace_rays rays, kept;
            struct trace_hits hits;
            int32_t valid[TRACE_WIDTH] __attribute__((aligned(64)));
            trace_rays_init(&rays);
            for (int k = 0; k < TRACE_WIDTH; k++) {
                valid[k] = k % 5 == 3 ? 0 : -1;
                rays.org_x[k] = (float)(3 * uniform());
                rays.org_y[k] = (float)(3 * uniform());
                rays.org_z[k] = (float)(3 * uniform());
                rays.dir_x[k] = (float)(3 * uniform()) - rays.org_x[k];
                rays.dir_y[k] = (float)(3 * uniform()) - rays.org_y[k];
                rays.dir_z[k] = (float)(3 * uniform()) - rays.org_z[k];
                rays.tfar[k] = 1;
            }
            kept = rays;
            trace_occluded(trace, valid, packet % 2, &rays);
            struct trace_rays whole = kept;
            trace_closest(trace, valid, &whole, &hits);
            for (int k = 0; k < TRACE_WIDTH; k++) {
                assert_true(rays.org_x[k] == kept.org_x[k] && rays.dir_z[k] == kept.dir_z[k]);
                if (!valid[k]) {
                    assert_true(rays.tfar[k] == 1);
                    continue;
                }
                vec3 origin = v3(kept.org_x[k], kept.org_y[k], kept.org_z[k]);
                vec3 direction = v3(kept.dir_x[k], kept.dir_y[k], kept.dir_z[k]);
                struct hit hit = first_hit(origin, direction, casters_only);
                if (!clear_cut(&hit) || fabs(hit.t - 1) < 1e-4)
                    continue;
                bool hidden = hit.t < 1;
                assert_true((rays.tfar[k] < 0) == hidden);
                assert_true((hits.object[k] != TRACE_NONE) == hidden);
                blocked += hidden, free += !hidden;
                if (!hidden)
                    continue;
                assert_int_equal(hits.object[k], hit.object);
                assert_int_equal(hits.triangle[k], hit.triangle);
                vec3 corner[3];
                trace_triangle(trace, hits.object[k], hits.triangle[k], corner);
                vec3 p =
                    v3_add(v3_scale(corner[0], 1 - (double)hits.u[k] - hits.v[k]),
                           v3_add(v3_scale(corner[1], hits.u[k]), v3_scale(corner[2], hits.v[k])));
                assert_true(v3_length(v3_sub(p, v3_mad(origin, direction, hit.t))) < 1e-4);
            }
        }
        assert_true(blocked > 100 && free > 100);
        trace_destroy(trace);
    }
}

static void nothing_is_seen_in_an_empty_scene(void **state)
{
    const float flat[9] = {0, 0, 0, 1, 1, 1, 2, 2, 2};
    for (int pass = 0; pass < 3; pass++) {
        /* No object at all; a mesh of no triangle; a triangle of no area. */
        if (pass > 0) {
            pnb_object object = {.mesh = add_mesh(flat, NULL, pass == 1 ? 0 : 1), .casts = true};
            assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
        }
        pnb_surface *surface;
        pnb_surface_view view;
        float rgb[3 * 7 * 5];
        assert_int_equal(pnb_surface_create(context, scene, NULL, 7, 5, &surface), PNB_OK);
        pnb_surface_get(surface, &view);
        pnb_scene_set_background(scene, (const double[]){0.25, 0.5, 2});
        assert_int_equal(pnb_surface_shade(surface, NULL, rgb), PNB_OK);
        for (int i = 0; i < 35; i++) {
            assert_int_equal(view.objects[i], PNB_NO_OBJECT);
            assert_true(isnan(view.depth[i]));
            assert_true(rgb[3 * i] == 0.25f && rgb[3 * i + 1] == 0.5f && rgb[3 * i + 2] == 2);
        }
        pnb_surface_destroy(surface);
    }
}

static void add_quad(double y, const float *normals, bool receives, double emission)
{
    const float h = (float)y;
    const float corners[18] = {-9, h, -9, -9, h, 9, 9, h, 9, -9, h, -9, 9, h, 9, 9, h, -9};
    pnb_object object = {.mesh = add_mesh(corners, normals, 2),
                         .color = {0.5, 0.25, 1},
                         .casts = true,
                         .receives = receives,
                         .emission = {emission, 0, 2 * emission}};
    assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
}

/* Vertex normals lean to one side: shading uses them, turned towards the eye, and the visibility's
 * normal stays geometric, from above and from below. */
static void shading_normals_lean(void **state)
{
    float normals[18];
    for (int i = 0; i < 6; i++)
        v3_storef(normals + 3 * i, v3_normalize(v3(0.6, 0.8, 0)));
    add_quad(0, normals, true, 0);
    for (int side = -1; side <= 1; side += 2) {
        const pnb_camera camera = {{0, 3.0 * side, 0}, {0, 0, 0}, {0, 0, 1}, 40};
        pnb_surface *surface;
        pnb_surface_view view;
        assert_int_equal(pnb_surface_create(context, scene, &camera, 8, 8, &surface), PNB_OK);
        pnb_surface_get(surface, &view);
        for (int i = 0; i < 64; i++) {
            assert_true(fabs(view.normals[3 * i + 1] - side) < 1e-6);
            assert_true(fabs(view.shading_normals[3 * i] - 0.6 * side) < 1e-6);
            assert_true(fabs(view.shading_normals[3 * i + 1] - 0.8 * side) < 1e-6);
        }
        pnb_surface_destroy(surface);
    }
}

/* albedo x (ambient + exposure x sum of irradiance x visibility) + exposure x pi x emission */
static void pictures_follow_their_formula(void **state)
{
    enum { PIXELS = 9 * 9 };
    const pnb_camera camera = {{0, 3, 0}, {0, 0, 0}, {0, 0, 1}, 40};
    const pnb_light lights[2] = {
        {.type = PNB_LIGHT_POINT, .color = {8, 4, 2}, .shape.point = {{0.5, 2, 0}}},
        {.type = PNB_LIGHT_RECTANGLE,
         .color = {1, 2, 3},
         .shape.rectangle = {{-1, 4, 0}, {1, 0, 0}, {0, 0, 1}}},
    };
    const double ambient[3] = {0.1, 0.2, 0.3};
    for (int receives = 0; receives < 2; receives++) {
        pnb_scene_destroy(scene);
        assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
        add_quad(0, NULL, receives, 0.125);
        for (int i = 0; i < 2; i++)
            assert_int_equal(pnb_scene_add_light(scene, &lights[i], NULL), PNB_OK);
        pnb_scene_set_ambient(scene, ambient);
        pnb_scene_set_exposure(scene, 0.75);
        pnb_surface *surface;
        pnb_surface_view view;
        assert_int_equal(pnb_surface_create(context, scene, &camera, 9, 9, &surface), PNB_OK);
        pnb_surface_get(surface, &view);

        float half[PIXELS], irradiance[2][3 * PIXELS], rgb[3 * PIXELS], plain[3 * PIXELS];
        for (int i = 0; i < PIXELS; i++)
            half[i] = i % 3 == 0 ? NAN : i % 3 == 1 ? 0.5f : 0;
        for (int k = 0; k < 2; k++)
            assert_int_equal(pnb_light_irradiance(context, &lights[k], view.positions,
                                                  view.shading_normals, PIXELS, irradiance[k]),
                             PNB_OK);
        const float *visibility[2] = {half, NULL};
        assert_int_equal(pnb_surface_shade(surface, visibility, rgb), PNB_OK);
        assert_int_equal(pnb_surface_shade(surface, NULL, plain), PNB_OK);
        pnb_object object;
        pnb_scene_object(scene, 0, &object);
        for (int i = 0; i < PIXELS; i++)
            for (int c = 0; c < 3; c++) {
                double v = receives && i % 3 == 1 ? 0.5 : receives && i % 3 == 2 ? 0 : 1;
                double light = irradiance[0][3 * i + c] * v + (double)irradiance[1][3 * i + c];
                double all = (double)irradiance[0][3 * i + c] + irradiance[1][3 * i + c];
                double shown = 0.75 * M_PI * object.emission[c];
                assert_true(irradiance[0][3 * i + c] > 0 && irradiance[1][3 * i + c] > 0);
                assert_float_equal(rgb[3 * i + c],
                                   object.color[c] * (ambient[c] + 0.75 * light) + shown, 1e-6);
                assert_float_equal(plain[3 * i + c],
                                   object.color[c] * (ambient[c] + 0.75 * all) + shown, 1e-6);
            }
        pnb_surface_destroy(surface);
    }
}

/* Far from the origin floats are coarse, but points stay on their plane to that coarseness, and the
 * receivers' lift keeps the floor from shadowing itself. */
static void far_away_is_still_lit(void **state)
{
    const float e = 5;
    const float corners[18] = {-e, 0, -e, -e, 0, e, e, 0, e, -e, 0, -e, e, 0, e, e, 0, -e};
    pnb_object object = {.mesh = add_mesh(corners, NULL, 2), .casts = true, .receives = true};
    const double far[12] = {1, 0.3, 0, 2e4, -0.3, 1, 0.2, -3e4, 0, -0.2, 1, 1e4};
    memcpy(object.world_from_mesh, far, sizeof(far));
    assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
    const pnb_camera camera = {{2e4, -3e4 + 8, 1e4}, {2e4, -3e4, 1e4}, {0, 0, 1}, 40};
    const pnb_light light = {.type = PNB_LIGHT_POINT, .shape.point = {{2e4, -3e4 + 9, 1e4}}};
    pnb_surface *surface;
    pnb_surface_view view;
    pnb_receivers receivers;
    pnb_solver *solver;
    float visibility[31 * 31];
    vec3 normal = v3_normalize(m34_normal(far, v3(0, 1, 0)));
    assert_int_equal(pnb_surface_create(context, scene, &camera, 31, 31, &surface), PNB_OK);
    pnb_surface_get(surface, &view);
    pnb_surface_receivers(surface, &receivers);
    assert_int_equal(pnb_solver_create(context, scene, NULL, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, visibility), PNB_OK);
    for (int i = 0; i < 31 * 31; i++) {
        vec3 p = v3_sub(v3_loadf(view.positions + 3 * i), v3(2e4, -3e4, 1e4));
        assert_int_equal(view.objects[i], 0);
        assert_true(fabs(v3_dot(p, normal)) < 0.01); /* floats are 0.002 apart there */
        assert_true(visibility[i] == 1);
    }
    pnb_solver_destroy(solver);
    pnb_surface_destroy(surface);
}

static bool cancelling;

static bool may_cancel(void *user, const char *stage, double fraction)
{
    return !cancelling;
}

/* The updated surface shows what one made anew does, to the bit. */
static void check_updated(pnb_surface *surface, const pnb_camera *camera, int width, int height)
{
    pnb_surface *fresh;
    pnb_surface_view a, b;
    pnb_receivers receivers;
    size_t count = (size_t)width * (size_t)height;
    assert_int_equal(pnb_surface_create(context, scene, camera, width, height, &fresh), PNB_OK);
    assert_int_equal(pnb_surface_update(surface, camera, width, height), PNB_OK);
    pnb_surface_get(fresh, &a);
    pnb_surface_get(surface, &b);
    assert_int_equal(b.width, width);
    assert_int_equal(b.height, height);
    assert_memory_equal(a.positions, b.positions, count * 12);
    assert_memory_equal(a.normals, b.normals, count * 12);
    assert_memory_equal(a.shading_normals, b.shading_normals, count * 12);
    assert_memory_equal(a.depth, b.depth, count * 4);
    assert_memory_equal(a.objects, b.objects, count * 4);
    pnb_surface_receivers(surface, &receivers);
    assert_int_equal(receivers.count, count);
    pnb_camera expected;
    pnb_scene_camera(scene, &expected);
    assert_memory_equal(receivers.camera, camera ? camera : &expected, sizeof(expected));
    pnb_surface_destroy(fresh);
}

/* Cameras, sizes, moved objects, other vertices, another object; two surfaces that share. */
static void updated_is_created(void **state)
{
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    const pnb_context_desc desc = {.progress = may_cancel};
    assert_int_equal(pnb_context_create(&desc, &context), PNB_OK);
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    add_soup();
    const pnb_camera cameras[3] = {{{0, 1, 6}, {0, 0, 0}, {0, 1, 0}, 45},
                                   {{5, 2, -3}, {0, 0.5, 0}, {0, 1, 0}, 60},
                                   {{0.2, 0, 0.1}, {1, 1, 1}, {0, 0, 1}, 90}};
    pnb_surface *one, *two;
    assert_int_equal(pnb_surface_create(context, scene, &cameras[0], 40, 30, &one), PNB_OK);
    assert_int_equal(pnb_surface_create(context, scene, NULL, 8, 8, &two), PNB_OK);
    for (int i = 0; i < 3; i++) {
        check_updated(one, &cameras[i], 40 - 13 * i, 30 + 50 * i);
        check_updated(two, &cameras[2 - i], 64, 48);
    }
    check_updated(two, NULL, 1, 1);
    for (int i = 0; i < 4; i++) {
        pnb_object object;
        pnb_scene_object(scene, (size_t)i, &object);
        object.world_from_mesh[3] += 0.3;
        assert_int_equal(pnb_scene_set_placement(scene, (size_t)i, object.world_from_mesh), PNB_OK);
        check_updated(i % 2 ? one : two, &cameras[i % 3], 33, 21);
        check_updated(i % 2 ? two : one, &cameras[i % 3], 20, 30);
        if (i > 1)
            check_updated(one, &cameras[i % 3], 20, 30); /* at rest again */
    }
    /* Turned far, step by step, one after the other: the boxes follow. */
    for (int i = 0; i < 24; i++) {
        size_t index = (size_t)i % pnb_scene_object_count(scene);
        pnb_object object;
        pnb_scene_object(scene, index, &object);
        double turned[12], c = cos(0.5), s = sin(0.5), *m = object.world_from_mesh;
        for (int k = 0; k < 4; k++) {
            turned[k] = c * m[k] + s * m[8 + k];
            turned[4 + k] = m[4 + k];
            turned[8 + k] = c * m[8 + k] - s * m[k];
        }
        assert_int_equal(pnb_scene_set_placement(scene, index, turned), PNB_OK);
        check_updated(i % 3 ? one : two, &cameras[0], 48, 36);
    }
    pnb_mesh_desc mesh;
    pnb_scene_mesh(scene, 0, &mesh);
    float *moved = malloc(mesh.vertex_count * 12);
    for (size_t i = 0; i < 3 * mesh.vertex_count; i++)
        moved[i] = 1.2f * mesh.positions[i];
    assert_int_equal(pnb_scene_set_vertices(scene, 0, moved, NULL), PNB_OK);
    free(moved);
    check_updated(one, &cameras[1], 40, 30);
    add_quad(0.3, NULL, 1, 0);
    check_updated(two, &cameras[1], 40, 30);
    /* The first one out does not take it from the other. */
    pnb_surface_destroy(one);
    check_updated(two, &cameras[0], 50, 20);

    /* What is refused changes nothing; what is cancelled shows nothing, and can be done again. */
    pnb_surface_view before, after;
    const pnb_camera blind = {{0, 0, 0}, {0, 1, 0}, {0, 2, 0}, 45};
    pnb_surface_get(two, &before);
    assert_int_equal(pnb_surface_update(two, &blind, 5, 5), PNB_ERROR_SCENE);
    assert_int_equal(pnb_surface_update(two, &cameras[0], 0, 5), PNB_ERROR_ARGUMENT);
    pnb_surface_get(two, &after);
    assert_memory_equal(&before, &after, sizeof(before));
    cancelling = true;
    assert_int_equal(pnb_surface_update(two, &cameras[0], 200, 150), PNB_ERROR_CANCELLED);
    cancelling = false;
    pnb_surface_get(two, &after);
    assert_int_equal(after.width, 200);
    for (int i = 0; i < 200 * 150; i++)
        assert_true(after.objects[i] == PNB_NO_OBJECT && isnan(after.depth[i]));
    check_updated(two, &cameras[0], 200, 150);
    pnb_surface_destroy(two);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(surface_is_the_nearest_triangle),
        TEST(shadow_rays_meet_casters_alone),
        TEST(nothing_is_seen_in_an_empty_scene),
        TEST(shading_normals_lean),
        TEST(pictures_follow_their_formula),
        TEST(far_away_is_still_lit),
        TEST(updated_is_created),
    };
    return cmocka_run_group_tests_name("trace", tests, NULL, NULL);
}
