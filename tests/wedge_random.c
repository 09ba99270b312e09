/* wedge_random.c: random scenes for the wedges. Values must lie in [0,1] wherever there is a
 * surface, and no row or column of pixels may be wrong where its neighbours are right. */
#include "wedge_random.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/shape.h"
#include "scene/scene.h"

enum { WIDTH = 96, HEIGHT = 72, PIXELS = WIDTH * HEIGHT };

/* Longer runs than this of pixels wrong by more than STREAK_ERROR, between two that are right, are
 * streaks. */
#define STREAK_LENGTH 8
#define STREAK_ERROR  0.35f

static double uniform(uint64_t *state, double low, double high)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15ull;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ z >> 27) * 0x94d049bb133111ebull;
    return low + (high - low) * (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static vec3 anywhere(uint64_t *r, double low, double high)
{
    double x = uniform(r, -1.5, 1.5), y = uniform(r, low, high);
    return v3(x, y, uniform(r, -1.5, 1.5));
}

static void add_shape(uint64_t *r, struct shape *shape, double light_height, bool *open)
{
    double top = uniform(r, 0, 1) < 0.2 ? light_height + 0.4 : 0.7 * light_height;
    vec3 c = anywhere(r, 0.1, top);
    switch ((int)uniform(r, 0, 5)) {
    case 0: shape_sphere_762(shape, c, uniform(r, 0.1, 0.5)); break;
    case 1: {
        vec3 half = v3(uniform(r, 0.05, 0.6), uniform(r, 0.05, 0.6), uniform(r, 0.05, 0.6));
        if (uniform(r, 0, 1) < 0.3)
            c.y = half.y; /* stands on the ground */
        shape_box(shape, v3_sub(c, half), v3_add(c, half));
        break;
    }
    case 2: {
        size_t first = shape->vertex_count;
        shape_torus(shape, uniform(r, 0.2, 0.5), uniform(r, 0.05, 0.15), 18, 8);
        const double m[12] = {1, 0, 0, c.x, 0, 0.6, -0.8, c.y, 0, 0.8, 0.6, c.z};
        shape_transform(shape, first, m);
        break;
    }
    case 3:
        *open = true;
        shape_quad(shape, c, v3(uniform(r, 0.1, 0.5), uniform(r, -0.2, 0.2), 0.1),
                   v3(0.1, uniform(r, -0.3, 0.3), uniform(r, 0.1, 0.5)));
        break;
    default: shape_rod(shape, c, anywhere(r, 0.1, top), uniform(r, 0.02, 0.2), 0.1, 9); break;
    }
}

static pnb_status make(pnb_context *context, uint64_t seed, pnb_scene **out_scene, bool *open)
{
    uint64_t r = seed * 77 + 5;
    static const double gray[3] = {0.7, 0.7, 0.7};
    pnb_status status = pnb_scene_create(context, out_scene);
    if (status != PNB_OK)
        return status;
    pnb_scene *scene = *out_scene;
    status = scene_add_plane(scene, "ground", v3(0, 0, 0), v3(0, 1, 0), 6, gray, NULL);
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE, .color = {1, 1, 1}};
    vec3 center = v3(uniform(&r, -1, 1), uniform(&r, 1.6, 3.5), uniform(&r, -1, 1));
    /* Half of them parallel to the axes: what is symmetric lines up with pixels and edges. */
    vec3 u = v3(1, 0, 0), v = v3(0, 0, 1);
    if (seed % 2) {
        vec3 n = v3_normalize(v3(uniform(&r, -1, 1), -1, uniform(&r, -1, 1)));
        v3_frame(n, &u, &v);
        if (v3_cross(u, v).y > 0)
            u = v3_scale(u, -1);
    } else {
        center.x = center.z = 0;
    }
    double size = pow(10, uniform(&r, -2, 0));
    if (v3_cross(u, v).y > 0)
        v = v3_scale(v, -1);
    v3_store(light.shape.rectangle.center, center);
    v3_store(light.shape.rectangle.half_u, v3_scale(u, size));
    v3_store(light.shape.rectangle.half_v, v3_scale(v, size * uniform(&r, 0.2, 1)));
    /* Some disks and triangles in the same place. */
    double normal[3], corners[9];
    if (seed % 8 == 3) {
        v3_store(normal, v3_cross(u, v));
        light = (pnb_light){.type = PNB_LIGHT_DISK, .color = {1, 1, 1}, .shape.disk.radius = size};
        v3_store(light.shape.disk.center, center);
        memcpy(light.shape.disk.normal, normal, sizeof(normal));
    } else if (seed % 8 == 6) {
        v3_store(corners, v3_mad(center, u, -size));
        v3_store(corners + 3, v3_mad(center, u, size));
        v3_store(corners + 6, v3_mad(center, v, size));
        light = (pnb_light){
            .type = PNB_LIGHT_POLYGON, .color = {1, 1, 1}, .shape.polygon = {corners, 3}};
    }
    if (status == PNB_OK)
        status = pnb_scene_add_light(scene, &light, NULL);
    int count = 1 + (int)uniform(&r, 0, 6);
    for (int i = 0; i < count && status == PNB_OK; i++) {
        struct shape shape;
        pnb_object object = {.name = "object", .casts = true, .receives = true};
        static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
        shape_init(context, &shape);
        add_shape(&r, &shape, center.y, open);
        pnb_mesh_desc mesh = shape_desc(&shape, "mesh");
        memcpy(object.world_from_mesh, identity, sizeof(identity));
        memcpy(object.color, gray, sizeof(gray));
        status = pnb_scene_add_mesh(scene, &mesh, &object.mesh);
        if (status == PNB_OK)
            status = pnb_scene_add_object(scene, &object, NULL);
        shape_finish(&shape);
    }
    pnb_camera camera = {
        .eye = {0, 2.5, 5}, .target = {0, 0.4, 0}, .up = {0, 1, 0}, .vertical_fov_degrees = 45};
    if (seed % 3 == 0) /* often within a penumbra or an umbra */
        v3_store(camera.eye, anywhere(&r, 0.2, 1.2));
    if (status == PNB_OK)
        status = pnb_scene_set_camera(scene, &camera);
    return status;
}

static bool is_wrong(const float *v, const float *truth, int x, int y)
{
    if (x < 0 || y < 0 || x >= WIDTH || y >= HEIGHT)
        return false;
    int i = y * WIDTH + x;
    return fabsf(v[i] - truth[i]) > STREAK_ERROR;
}

/* The longest run along one axis of wrong pixels both of whose neighbours across are right. */
static int longest_streak(const float *v, const float *truth, const uint8_t *mask, bool columns)
{
    int longest = 0;
    for (int j = 0; j < (columns ? WIDTH : HEIGHT); j++) {
        int length = 0;
        for (int i = 0; i < (columns ? HEIGHT : WIDTH); i++) {
            int x = columns ? j : i, y = columns ? i : j;
            bool alone = mask[y * WIDTH + x] && is_wrong(v, truth, x, y) &&
                         !is_wrong(v, truth, x - columns, y - !columns) &&
                         !is_wrong(v, truth, x + columns, y + !columns);
            length = alone ? length + 1 : 0;
            longest = length > longest ? length : longest;
        }
    }
    return longest;
}

static pnb_status solve(pnb_context *context, pnb_scene *scene, const pnb_receivers *receivers,
                        const char *method, float *visibility)
{
    pnb_light light;
    pnb_solver *solver;
    pnb_scene_light(scene, 0, &light);
    pnb_solver_desc desc = {.method = method};
    pnb_status status = pnb_solver_create(context, scene, &desc, &solver);
    if (status != PNB_OK)
        return status;
    status = pnb_solver_visibility(solver, &light, receivers, visibility);
    pnb_solver_destroy(solver);
    return status;
}

static pnb_status judge(pnb_context *context, pnb_scene *scene, const pnb_receivers *receivers,
                        bool open, struct wedge_random_result *result)
{
    static const char *const methods[] = {"wedge", "wedge-probabilistic", "wedge-blend"};
    static float truth[PIXELS], v[PIXELS];
    static uint8_t mask[PIXELS];
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    pnb_measure_facing(&light, receivers, mask);
    pnb_status status = solve(context, scene, receivers, "exact", truth);
    for (int m = 0; m < 3 && status == PNB_OK; m++) {
        double sum = 0;
        status = solve(context, scene, receivers, methods[m], v);
        result->pixels = result->gross = 0;
        for (int i = 0; i < PIXELS && status == PNB_OK; i++) {
            if (isnan(truth[i]))
                continue;
            if (!(v[i] >= 0 && v[i] <= 1))
                result->what = "a visibility outside [0,1]";
            if (!mask[i])
                continue;
            double error = (double)v[i] - (double)truth[i];
            sum += error * error;
            result->pixels++;
            result->gross += fabs(error) > 0.5;
        }
        result->rmse[m] = sqrt(sum / (double)(result->pixels ? result->pixels : 1));
    }
    if (status != PNB_OK)
        return status;
    int rows = longest_streak(v, truth, mask, false);
    int columns = longest_streak(v, truth, mask, true);
    result->streak = rows > columns ? rows : columns;
    if (!result->what && result->streak > STREAK_LENGTH)
        result->what = "a streak";
    if (!result->what && !open && result->gross > 10 + result->pixels / 200)
        result->what = "too many pixels are grossly wrong";
    return PNB_OK;
}

pnb_status wedge_random_run(pnb_context *context, uint64_t seed, struct wedge_random_result *result)
{
    pnb_scene *scene = NULL;
    pnb_surface *surface = NULL;
    pnb_receivers receivers;
    bool open = false;
    memset(result, 0, sizeof(*result));
    pnb_status status = make(context, seed, &scene, &open);
    if (status == PNB_OK)
        status = pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface);
    if (status == PNB_OK) {
        pnb_surface_receivers(surface, &receivers);
        status = judge(context, scene, &receivers, open, result);
    }
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    return status;
}
