/* The D-buffer: faces and edges seen from a disk against brute force over the rim, volumes whose
 * planes touch what they should, a straight edge against the disk's segment, the boundaries of
 * umbra and penumbra against the convex occluder's own geometry, a light without extent, ceilings
 * per scene, bad input. */
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

#include "../bench/dbuffer_boundary.h"
#include "method/dbuffer/map.h"
#include "method/dbuffer/volumes.h"
#include "scene/scene.h"

static pnb_context *context;
static bool device; /* OpenGL can be had */

static int setup(void **state)
{
    struct gl_device *probe;
    if (pnb_context_create(&(pnb_context_desc){.threads = 2}, &context) != PNB_OK)
        return 1;
    device = gl_device_create(context, &probe) == PNB_OK;
    if (device)
        gl_device_destroy(probe);
    return 0;
}

static int teardown(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

static void need_device(void)
{
    if (!device) {
        print_message("no OpenGL device: %s\n", pnb_context_error(context));
        skip();
    }
}

static double random_in(double low, double high)
{
    static uint64_t seed = 1;
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(seed >> 11) / (double)(1ull << 53);
}

static vec3 random_point(double size)
{
    double x = random_in(-size, size), y = random_in(-size, size);
    return v3(x, y, random_in(-size, size));
}

static vec3 rim(const struct silhouette_disk *disk, int i, int count)
{
    double a = 2 * M_PI * i / count;
    return silhouette_disk_to_world(disk, v3(disk->radius * cos(a), disk->radius * sin(a), 0));
}

/* ---- silhouette/disk.h ---- */

static void faces_against_the_rim(void **state)
{
    size_t found[3] = {0};
    for (int i = 0; i < 3000; i++) {
        struct silhouette_disk disk;
        silhouette_disk_init(&disk, random_point(2), random_point(1), random_in(0.01, 2));
        vec3 n = i % 10 == 0 ? disk.normal : v3_normalize(random_point(1));
        float plane[4] = {0, 0, 0, (float)random_in(-2, 2)};
        v3_storef(plane, n);
        double low = INFINITY, high = -INFINITY;
        for (int k = 0; k < 720; k++) {
            double h = v3_dot(v3_loadf(plane), rim(&disk, k, 720)) + plane[3];
            low = fmin(low, h);
            high = fmax(high, h);
        }
        enum silhouette_facing facing = silhouette_disk_facing(&disk, plane);
        double step = 2e-5 * disk.radius; /* the rim between two of the points, and rounding */
        if (high > step)
            assert_int_not_equal(facing, SILHOUETTE_NONE_FRONTFACING);
        if (high < -step)
            assert_int_equal(facing, SILHOUETTE_NONE_FRONTFACING);
        if (low > step)
            assert_int_equal(facing, SILHOUETTE_ALL_FRONTFACING);
        if (low < -step)
            assert_int_not_equal(facing, SILHOUETTE_ALL_FRONTFACING);
        found[facing]++;
    }
    assert_true(found[0] > 200 && found[1] > 200 && found[2] > 200);
    const float none[4] = {0, 0, 0, 0};
    struct silhouette_disk disk;
    silhouette_disk_init(&disk, v3(0, 0, 0), v3(0, 0, 1), 1);
    assert_int_equal(silhouette_disk_facing(&disk, none), SILHOUETTE_NONE_FRONTFACING);
}

static double det(vec3 p, vec3 a, vec3 b, vec3 x)
{
    return v3_dot(v3_cross(v3_sub(a, p), v3_sub(b, p)), v3_sub(x, p));
}

static void tangent_planes_touch_the_rim(void **state)
{
    size_t skipped = 0;
    for (int i = 0; i < 5000; i++) {
        double r = random_in(0.01, 2), points[2][2];
        vec3 a = random_point(3), b = random_point(3);
        a.z = random_in(0.1, 3);
        b.z = i % 3 == 0 ? a.z : i % 3 == 1 ? a.z * (1 + 1e-9) : random_in(0.1, 3);
        /* Where the line meets the light's plane. */
        double w = b.z - a.z;
        vec3 at = w != 0 ? v3_mad(a, v3_sub(b, a), -a.z / w) : v3(INFINITY, 0, 0);
        bool outside = hypot(at.x, at.y) > r;
        bool ok = silhouette_disk_tangents(r, a, b, points);
        if (fabs(hypot(at.x, at.y) - r) > 1e-6 * r)
            assert_int_equal(ok, outside);
        if (!ok) {
            skipped++;
            continue;
        }
        for (int k = 0; k < 2; k++) {
            vec3 p = v3(points[k][0], points[k][1], 0);
            double size = v3_length(v3_cross(v3_sub(a, p), v3_sub(b, p)));
            assert_true(fabs(v3_length(p) - r) < 1e-6 * r);
            double center = det(p, a, b, v3(0, 0, 0));
            assert_true(k == 0 ? center < 0 : center > 0);
            for (int j = 0; j < 90; j++) {
                vec3 q = v3(r * cos(j * M_PI / 45), r * sin(j * M_PI / 45), 0);
                assert_true((k == 0 ? -1 : 1) * det(p, a, b, q) > -1e-6 * size * r);
            }
        }
    }
    assert_true(skipped > 20);
}

/* ---- Volumes ---- */

static struct gl_occluders *occluders_of(pnb_scene *scene)
{
    struct gl_occluders *occluders;
    assert_int_equal(gl_occluders_create(scene, true, &occluders), PNB_OK);
    return occluders;
}

/* Every quad's plane leaves the occluder on one side, and the disk on that side (umbra) or on the
 * other (penumbra); the volume closes: each quad's end is another one's beginning. */
static void check_volume(const struct dbuffer_piece *pieces, size_t count, bool penumbra,
                         const vec3 *points, size_t point_count, double radius)
{
    for (size_t i = 0; i < count; i++) {
        const struct dbuffer_piece *piece = &pieces[i];
        vec3 a = v3_loadf(piece->v1), b = v3_loadf(piece->v2);
        vec3 p = v3(piece->p1[0], piece->p1[1], 0);
        double scale = v3_length(v3_cross(v3_sub(a, p), v3_sub(b, p)));
        for (size_t k = 0; k < point_count; k++)
            assert_true(det(p, a, b, points[k]) < 1e-4 * scale);
        for (int j = 0; j < 60; j++) {
            vec3 q = v3(radius * cos(j * M_PI / 30), radius * sin(j * M_PI / 30), 0);
            double side = det(p, a, b, q);
            assert_true(penumbra ? side > -1e-4 * scale : side < 1e-4 * scale);
        }
        int begins = 0;
        for (size_t k = 0; k < count; k++)
            begins += memcmp(pieces[k].v1, piece->v2, sizeof(piece->v1)) == 0;
        assert_true(begins >= 1);
    }
}

static void volumes_of_a_convex_occluder(void **state)
{
    pnb_scene *scene;
    assert_int_equal(scene_builtin(context, "prism", &scene), PNB_OK);
    struct gl_occluders *o = occluders_of(scene);
    struct dbuffer_volumes volumes;
    dbuffer_volumes_init(context, &volumes);
    size_t umbra = 0, both = 0;
    for (int i = 0; i < 300; i++) {
        struct silhouette_disk disk;
        double a = random_in(0, 2 * M_PI), r = pow(10, random_in(-2, 0.3));
        vec3 c = v3(2.5 * cos(a), random_in(2, 5), 2.5 * sin(a));
        silhouette_disk_init(&disk, c, v3_sub(v3(0, random_in(0, 1), 0), c), r);
        /* The ground is no matter here: only the prism, object 1. */
        struct gl_occluders alone = *o;
        alone.objects = o->objects + 1;
        alone.object_count = 1;
        assert_int_equal(dbuffer_volumes_build(&volumes, &alone, &disk), PNB_OK);
        vec3 points[6];
        double lowest = INFINITY;
        for (size_t k = 0; k < 6; k++) {
            points[k] = silhouette_disk_from_world(&disk, v3_loadf(o->positions + 3 * (k + 4)));
            lowest = fmin(lowest, points[k].z);
        }
        if (volumes.skipped_edges > 0 || lowest < 0.01)
            continue;
        check_volume(volumes.quads[0].pieces, volumes.quads[0].count, false, points, 6, r);
        check_volume(volumes.quads[1].pieces, volumes.quads[1].count, true, points, 6, r);
        umbra += volumes.edges[0] > 0;
        both += volumes.edges[0] >= 3 && volumes.edges[1] >= 3;
    }
    assert_true(umbra > 100 && both > 100);
    dbuffer_volumes_finish(&volumes);
    gl_occluders_destroy(o);
    pnb_scene_destroy(scene);
}

/* ---- Pictures ---- */

enum { W = 240, H = 180, N = W * H };

struct shot {
    pnb_scene *scene;
    pnb_surface *surface;
    pnb_receivers receivers;
    pnb_light light;
};

/* As an object where it is. */
static void add_mesh(pnb_scene *scene, const pnb_mesh_desc *mesh)
{
    pnb_object object = {.name = mesh->name,
                         .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                         .color = {1, 1, 1},
                         .casts = true,
                         .receives = true};
    assert_int_equal(pnb_scene_add_mesh(scene, mesh, &object.mesh), PNB_OK);
    assert_int_equal(pnb_scene_add_object(scene, &object, NULL), PNB_OK);
}

static void shot_begin(struct shot *shot, const char *name, int width, int height)
{
    assert_int_equal(scene_builtin(context, name, &shot->scene), PNB_OK);
    assert_int_equal(pnb_surface_create(context, shot->scene, NULL, width, height, &shot->surface),
                     PNB_OK);
    pnb_surface_receivers(shot->surface, &shot->receivers);
    pnb_scene_light(shot->scene, 0, &shot->light);
}

static void shot_end(struct shot *shot)
{
    pnb_surface_destroy(shot->surface);
    pnb_scene_destroy(shot->scene);
}

static pnb_light disk_light(vec3 center, vec3 normal, double radius)
{
    pnb_light light = {.type = PNB_LIGHT_DISK, .color = {1, 1, 1}};
    v3_store(light.shape.disk.center, center);
    v3_store(light.shape.disk.normal, normal);
    light.shape.disk.radius = radius;
    return light;
}

static pnb_status ask(struct shot *shot, const char *method, const char *params, float *out)
{
    pnb_solver_param list[8];
    pnb_solver_desc desc = {method, 0, list, 0};
    char text[256];
    snprintf(text, sizeof(text), "%s", params);
    for (char *word = strtok(text, " "); word; word = strtok(NULL, " ")) {
        char *equal = strchr(word, '=');
        *equal = 0;
        list[desc.param_count++] = (pnb_solver_param){word, equal + 1};
    }
    pnb_solver *solver;
    pnb_status status = pnb_solver_create(context, shot->scene, &desc, &solver);
    if (status == PNB_OK) {
        status = pnb_solver_visibility(solver, &shot->light, &shot->receivers, out);
        pnb_solver_destroy(solver);
    }
    return status;
}

static void in_range(const float *v, const pnb_receivers *receivers)
{
    for (size_t i = 0; i < receivers->count; i++) {
        bool none = !isfinite(receivers->positions[3 * i]);
        if (none ? !isnan(v[i]) : !(v[i] >= 0 && v[i] <= 1))
            fail_msg("visibility %g of receiver %zu", (double)v[i], i);
    }
}

static float truth[N], v[N], w[N];
static uint8_t mask[N];

/* Truth, mask and figures of shot->light. */
static pnb_errors errors_of(struct shot *shot, const char *params, bool again)
{
    pnb_errors errors;
    if (!again) {
        assert_int_equal(ask(shot, "exact", "", truth), PNB_OK);
        pnb_measure_facing(&shot->light, &shot->receivers, mask);
    }
    if (ask(shot, "dbuffer", params, v) != PNB_OK)
        fail_msg("%s", pnb_context_error(context));
    in_range(v, &shot->receivers);
    assert_int_equal(pnb_measure(context, v, truth, mask, N, &errors), PNB_OK);
    return errors;
}

/* A wide box whose one edge crosses the light: V is the disk's segment, for edges that are parallel
 * to the light and for those that slant. */
static void straight_edge_is_exact(void **state)
{
    need_device();
    for (int slant = 0; slant < 2; slant++) {
        static const char text[] =
            "{\"camera\": {\"eye\": [0, 5, 6], \"target\": [0, 0, 0], \"up\": [0, 1, 0],"
            " \"vertical_fov_degrees\": 20}, \"lights\": [], \"objects\": ["
            "{\"name\": \"ground\", \"plane\": {\"point\": [0, 0, 0], \"normal\": [0, 1, 0],"
            " \"half_size\": 9}}]}";
        /* A slab from x = 0 to -8, 0.01 thick; slanted: its far side is higher. */
        double low = slant ? 0.7 : 1, high = slant ? 1.3 : 1;
        float c[24];
        for (int i = 0; i < 8; i++) {
            double z = i & 2 ? 5 : -5;
            v3_storef(c + 3 * i, v3(i & 1 ? 0 : -8, (z > 0 ? low : high) + (i & 4 ? 0.01 : 0), z));
        }
        static const uint32_t indices[36] = {0, 1, 2, 2, 1, 3, 4, 6, 5, 5, 6, 7, 0, 4, 1, 1, 4, 5,
                                             2, 3, 6, 6, 3, 7, 0, 2, 4, 4, 2, 6, 1, 5, 3, 3, 5, 7};
        struct shot shot;
        assert_int_equal(pnb_scene_parse(context, text, sizeof(text) - 1, ".", &shot.scene),
                         PNB_OK);
        pnb_mesh_desc mesh = {"slab", c, NULL, 8, indices, 12};
        add_mesh(shot.scene, &mesh);
        assert_int_equal(pnb_surface_create(context, shot.scene, NULL, W, H, &shot.surface),
                         PNB_OK);
        pnb_surface_receivers(shot.surface, &shot.receivers);
        vec3 center = v3(0.1, 3, 0.2);
        shot.light = disk_light(center, v3(0, -1, 0), 0.5);
        assert_int_equal(ask(&shot, "dbuffer", "size=2048", v), PNB_OK);
        double worst = 0, sum = 0;
        size_t count = 0;
        for (size_t i = 0; i < N; i++) {
            vec3 p = v3_loadf(shot.receivers.positions + 3 * i);
            if (!v3_finite(p) || fabs(p.y) > 1e-4 || fabs(p.z) > 1)
                continue;
            /* Where the plane of p and the edge meets the light: u x + w z = e. */
            vec3 a = v3(0, low, 5), b = v3(0, high, -5);
            vec3 n = v3_cross(v3_sub(a, p), v3_sub(b, p));
            double t = v3_dot(n, v3_sub(center, p)) / hypot(n.x, n.z) / 0.5;
            t = n.x < 0 ? -t : t;
            double x = fmin(1, fmax(-1, t)), want = 1 - (acos(x) - x * sqrt(1 - x * x)) / M_PI;
            worst = fmax(worst, fabs(v[i] - want));
            sum += (v[i] - want) * (v[i] - want);
            count += want > 0 && want < 1;
        }
        print_message("%s edge: %zu pixels of penumbra, RMSE %.4f, worst %.4f\n",
                      slant ? "slanted" : "parallel", count, sqrt(sum / (double)count), worst);
        assert_true(count > 500);
        assert_true(sqrt(sum / (double)count) < (slant ? 0.008 : 0.004));
        assert_true(worst < 0.03);
        shot_end(&shot);
    }
}

/* How far a disk reaches over the outline of a convex occluder's shadow on the light's plane, seen
 * from x (light space): below 0 the disk lies wholly inside (umbra), above 2 r wholly outside. */
static double reach_over(const vec3 *points, size_t count, vec3 x, double radius)
{
    double px[16], py[16], deepest = INFINITY, distance = INFINITY;
    bool inside = true;
    for (size_t i = 0; i < count; i++) {
        double k = x.z / (x.z - points[i].z);
        px[i] = x.x + (points[i].x - x.x) * k;
        py[i] = x.y + (points[i].y - x.y) * k;
    }
    /* The hull's edges: pairs with all others on one side. */
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < count; j++) {
            double ex = px[j] - px[i], ey = py[j] - py[i], length = hypot(ex, ey);
            bool edge = i != j && length > 1e-9;
            for (size_t k = 0; k < count && edge; k++)
                edge = ex * (py[k] - py[i]) - ey * (px[k] - px[i]) > -1e-9 * length;
            if (!edge)
                continue;
            double off = (-ex * py[i] + ey * px[i]) / length; /* of the centre: left is inside */
            inside = inside && off > 0;
            deepest = fmin(deepest, off);
            double along = fmin(1, fmax(0, -(px[i] * ex + py[i] * ey) / (length * length)));
            distance = fmin(distance, hypot(px[i] + along * ex, py[i] + along * ey));
        }
    return radius + (inside ? -deepest : distance);
}

/* The must of the method: umbra and outer boundary within 1.5 texels for 99 % of the pixels about
 * them, at 1024^2. */
static void boundaries_are_right(void **state)
{
    enum { BW = 640, BH = 480, SIZE = 1024 };
    static float value[BW * BH];
    need_device();
    static const double radii[] = {0.05, 0.15, 0.3, 0.6};
    for (size_t round = 0; round < 4; round++) {
        struct shot shot;
        shot_begin(&shot, "prism", BW, BH);
        vec3 center = v3(0.3, 3.2, 0.4);
        shot.light = disk_light(center, v3_sub(v3(0, 0.5, 0), center), radii[round]);
        assert_int_equal(ask(&shot, "dbuffer", "size=1024", value), PNB_OK);
        struct silhouette_disk disk;
        silhouette_disk_init(&disk, center, v3_sub(v3(0, 0.5, 0), center), radii[round]);
        struct gl_occluders *o = occluders_of(shot.scene);
        double far_z = 0;
        for (size_t i = 0; i < shot.receivers.count; i++) {
            vec3 p = v3_loadf(shot.receivers.positions + 3 * i);
            if (v3_finite(p))
                far_z = fmax(far_z, silhouette_disk_from_world(&disk, p).z);
        }
        struct dbuffer_map map;
        dbuffer_map_fit(o, &disk, far_z, SIZE, &map);
        assert_int_equal(map.face_count, 1);
        double texel = 2 * fmax(map.reach[0], map.reach[1]) / SIZE;
        vec3 points[6];
        for (size_t k = 0; k < 6; k++)
            points[k] = silhouette_disk_from_world(&disk, v3_loadf(o->positions + 3 * (k + 4)));
        size_t near[2] = {0}, wrong[2] = {0};
        for (size_t i = 0; i < shot.receivers.count; i++) {
            vec3 p = v3_loadf(shot.receivers.positions + 3 * i);
            if (!v3_finite(p) || fabs(p.y) > 1e-4)
                continue;
            /* All places within 1.5 texels on one side of a boundary: so is the picture. */
            vec3 x = silhouette_disk_from_world(&disk, p);
            double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
            for (int ring = 0; ring < 2; ring++)
                for (int k = 0; k < 12; k++) {
                    double step = (ring ? 4 : 1.5) * texel * v3_length(x);
                    vec3 y = v3_add(p, v3(step * cos(k * M_PI / 6), 0, step * sin(k * M_PI / 6)));
                    double reach =
                        reach_over(points, 6, silhouette_disk_from_world(&disk, y), radii[round]);
                    low[ring] = fmin(low[ring], reach);
                    high[ring] = fmax(high[ring], reach);
                }
            const double limit[2] = {0, 2 * radii[round]};
            for (int k = 0; k < 2; k++) {
                if (low[1] >= limit[k] || high[1] <= limit[k])
                    continue;
                near[k]++;
                bool in = k == 0 ? value[i] <= 1e-7f : value[i] < 1;
                wrong[k] += (high[0] < limit[k] && !in) || (low[0] > limit[k] && in);
            }
        }
        print_message("radius %.2f: umbra's boundary %zu pixels, %zu off; outer %zu, %zu off\n",
                      radii[round], near[0], wrong[0], near[1], wrong[1]);
        for (int k = 0; k < 2; k++) {
            assert_true(near[k] > 200 || (k == 0 && radii[round] > 0.5));
            assert_true((double)wrong[k] <= 0.01 * (double)near[k]);
        }
        gl_occluders_destroy(o);
        shot_end(&shot);
    }
}

/* The same against exact's boundaries, which any occluder has; what falls short is in
 * docs/dbuffer.md. */
static void boundaries_of_scenes(void **state)
{
    enum { BW = 320, BH = 240 };
    static float value[BW * BH];
    static const struct {
        const char *scene;
        double umbra, outer; /* at least this share within 1.5 texels */
    } cases[] = {{"distance-1", 0, 0.99},      {"distance-2", 0.97, 0.99},
                 {"distance-3", 0.98, 0.99},   {"distance-4", 0.99, 0.99},
                 {"light-size-1", 0.98, 0.99}, {"light-size-2", 0.94, 0.99}};
    need_device();
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
        pnb_scene *scene;
        pnb_light light;
        struct boundary b;
        assert_int_equal(scene_builtin(context, cases[k].scene, &scene), PNB_OK);
        pnb_scene_light(scene, 0, &light);
        assert_int_equal(boundary_measure(context, scene, &light, BW, BH, 1024, &b, NULL, value),
                         PNB_OK);
        print_message("%s: umbra's boundary %zu pixels, %zu off; outer %zu, %zu off\n",
                      cases[k].scene, b.near[0], b.off[0], b.near[1], b.off[1]);
        assert_true(b.near[1] > 60);
        assert_true((double)b.off[0] <= (1 - cases[k].umbra) * (double)b.near[0]);
        assert_true((double)b.off[1] <= (1 - cases[k].outer) * (double)b.near[1]);
        pnb_scene_destroy(scene);
    }
}

static void point_light_is_hard_map(void **state)
{
    need_device();
    struct shot shot;
    static const char *const names[] = {"complex-1440", "light-inside-caster"};
    for (int k = 0; k < 2; k++) {
        shot_begin(&shot, names[k], W, H);
        pnb_light point = {.type = PNB_LIGHT_POINT, .color = {1, 1, 1}};
        v3_store(point.shape.point.position, k == 0 ? v3(-1.5, 4, 0.9) : v3(0, 1, 0));
        shot.light = point;
        assert_int_equal(ask(&shot, "dbuffer", k == 0 ? "size=512" : "", v), PNB_OK);
        assert_int_equal(ask(&shot, "hard-map", k == 0 ? "size=512 path=opengl" : "path=opengl", w),
                         PNB_OK);
        assert_memory_equal(v, w, sizeof(v));
        shot_end(&shot);
    }
    /* A disk as small as that is one too. */
    shot_begin(&shot, "light-size-1", W, H);
    shot.light.shape.disk.radius = 1e-7;
    assert_int_equal(ask(&shot, "dbuffer", "size=512", v), PNB_OK);
    assert_int_equal(ask(&shot, "hard-map", "size=512 path=opengl", w), PNB_OK);
    assert_memory_equal(v, w, sizeof(v));
    shot_end(&shot);
}

/* RMSE against exact at 240x180. */
static void errors_stay_below_ceilings(void **state)
{
    need_device();
    static const struct {
        const char *scene;
        double two, one, paper; /* layers=2; layers=1; layers=2 with the paper's V(t) */
    } cases[] = {
        {"distance-1", 0.024, 0.035, 0.041},
        {"distance-2", 0.016, 0.016, 0.036},
        {"distance-3", 0.018, 0.018, 0.037},
        {"distance-4", 0.023, 0.023, 0.04},
        {"light-size-1", 0.034, 0.08, 0.043},
        {"light-size-2", 0.031, 0.085, 0.042},
        {"light-size-3", 0.062, 0.102, 0.068},
        {"light-size-4", 0.111, 0.135, 0.11},
        {"complex", 0.057, 0.09, 0.062},
        {"disk", 0.037, 0.057, 0.047},
        {"triangle-light", 0.036, 0.036, 0.05},
        {"prism", 0.075, 0, 0}, /* no umbra under its own light */
    };
    for (size_t k = 0; k < sizeof(cases) / sizeof(*cases); k++) {
        struct shot shot;
        shot_begin(&shot, cases[k].scene, W, H);
        const double ceilings[3] = {cases[k].two, cases[k].one, cases[k].paper};
        static const char *const params[3] = {"", "layers=1", "v=paper"};
        for (int i = 0; i < 3 && ceilings[i] > 0; i++) {
            pnb_errors errors = errors_of(&shot, params[i], i > 0);
            print_message("%-16s %-10s RMSE %.4f, ceiling %.3f, umbra leak %.4f\n", cases[k].scene,
                          params[i], errors.rmse, ceilings[i], errors.umbra_leak);
            if (!(errors.rmse <= ceilings[i]))
                fail_msg("%s %s: RMSE %.4f above %.3f", cases[k].scene, params[i], errors.rmse,
                         ceilings[i]);
        }
        shot_end(&shot);
    }
}

/* One convex occluder, the light from small to very large. */
static void one_convex_occluder(void **state)
{
    need_device();
    static const double radii[] = {0.05, 0.2, 0.4, 0.8};
    static const double ceilings[] = {0.01, 0.02, 0.01, 0.01};
    struct shot shot;
    shot_begin(&shot, "prism", W, H);
    for (int k = 0; k < 4; k++) {
        vec3 center = v3(0.3, 3.2, 0.4);
        shot.light = disk_light(center, v3(0, -1, 0), radii[k]);
        double paper = errors_of(&shot, "v=paper", false).rmse;
        double rmse = errors_of(&shot, "", true).rmse;
        print_message("prism, radius %.2f: RMSE %.4f, the paper's V(t) %.4f\n", radii[k], rmse,
                      paper);
        assert_true(rmse < ceilings[k]);
        assert_true(paper < 0.035);
    }
    shot_end(&shot);
}

static void bad_input(void **state)
{
    need_device();
    static const char *const names[] = {"light-in-solid", "light-inside-caster",
                                        "caster-through-light-plane", "leaves", "room"};
    struct shot shot;
    for (size_t k = 0; k < sizeof(names) / sizeof(*names); k++) {
        shot_begin(&shot, names[k], W, H);
        if (ask(&shot, "dbuffer", "size=256", v) != PNB_OK)
            fail_msg("%s: %s", names[k], pnb_context_error(context));
        in_range(v, &shot.receivers);
        shot_end(&shot);
    }
    /* The light in the middle of the occluder, touching it, flat on the ground, and huge. */
    static const struct {
        double center[3], normal[3], radius;
    } lights[] = {{{0, 0.9, 0}, {0, -1, 0}, 0.1},  {{0, 1.2, 0}, {0, -1, 0}, 0.5},
                  {{0, 0.7, 0}, {0, -1, 0}, 0.3},  {{0.5, 0, 0.5}, {0, 1, 0}, 0.3},
                  {{0, 0, 0}, {0, 1, 0}, 0.5},     {{0, 3, 0}, {0, -1, 0}, 1000},
                  {{0, 3, 0}, {1, 0, 0}, 0.5},     {{0, 3, 0}, {0, 1, 0}, 0.5},
                  {{1e6, 1e6, 0}, {-1, -1, 0}, 10}};
    shot_begin(&shot, "prism", W, H);
    for (size_t k = 0; k < sizeof(lights) / sizeof(*lights); k++)
        for (int layers = 1; layers <= 2; layers++) {
            shot.light =
                disk_light(v3_load(lights[k].center), v3_load(lights[k].normal), lights[k].radius);
            if (ask(&shot, "dbuffer", layers == 1 ? "size=64 layers=1" : "size=64", v) != PNB_OK)
                fail_msg("light %zu: %s", k, pnb_context_error(context));
            in_range(v, &shot.receivers);
        }
    /* No pixels of an image, no camera: refused in one line. */
    pnb_receivers receivers = shot.receivers;
    receivers.camera = NULL;
    shot.receivers = receivers;
    assert_int_equal(ask(&shot, "dbuffer", "", v), PNB_ERROR_UNSUPPORTED);
    assert_int_equal(ask(&shot, "dbuffer", "size=1", v), PNB_ERROR_ARGUMENT);
    assert_int_equal(ask(&shot, "dbuffer", "v=cubic", v), PNB_ERROR_ARGUMENT);
    shot_end(&shot);
}

/* Three triangles on an edge and others alone on theirs; then an edge whose line meets the light:
 * a picture of numbers in [0,1], and a warning that says what was found. */
static void broken_meshes_are_told(void **state)
{
    need_device();
    static const char text[] =
        "{\"camera\": {\"eye\": [0, 5, 6], \"target\": [0, 0, 0], \"up\": [0, 1, 0],"
        " \"vertical_fov_degrees\": 40}, \"lights\": [], \"objects\": ["
        "{\"name\": \"ground\", \"plane\": {\"point\": [0, 0, 0], \"normal\": [0, 1, 0],"
        " \"half_size\": 9}}]}";
    static const float fins[] = {-1, 1, 0, 1, 1, 0, 0, 1.8f, 0, 0, 0.6f, 1, 0, 0.6f, -1};
    static const uint32_t indices[] = {0, 1, 2, 0, 1, 3, 1, 0, 4};
    struct shot shot;
    assert_int_equal(pnb_scene_parse(context, text, sizeof(text) - 1, ".", &shot.scene), PNB_OK);
    pnb_mesh_desc mesh = {"fins", fins, NULL, 5, indices, 3};
    add_mesh(shot.scene, &mesh);
    assert_int_equal(pnb_surface_create(context, shot.scene, NULL, W, H, &shot.surface), PNB_OK);
    pnb_surface_receivers(shot.surface, &shot.receivers);
    /* Above them; then where the line through two vertices, 0 and 2, meets the disk's centre. */
    const pnb_light lights[] = {disk_light(v3(0, 4, 0), v3(0, -1, 0), 0.3),
                                disk_light(v3(1.5, 3, 0), v3(0, -1, 0), 0.3)};
    for (int k = 0; k < 2; k++)
        for (int layers = 1; layers <= 2; layers++) {
            pnb_solver_param param = {"layers", layers == 1 ? "1" : "2"};
            pnb_solver_desc desc = {"dbuffer", 0, &param, 1};
            pnb_solver *solver;
            pnb_solver_report report;
            assert_int_equal(pnb_solver_create(context, shot.scene, &desc, &solver), PNB_OK);
            assert_int_equal(pnb_solver_visibility(solver, &lights[k], &shot.receivers, v), PNB_OK);
            in_range(v, &shot.receivers);
            size_t dark = 0;
            for (size_t i = 0; i < N; i++)
                dark += v[i] < 0.5f;
            assert_true(dark > 20);
            pnb_solver_get_report(solver, &report);
            bool borders = false, lines = false; /* the ground's four open edges are not told */
            for (size_t i = 0; i < report.warning_count; i++) {
                borders = borders || strstr(report.warnings[i], "(6 open, 1 non-manifold edges)");
                lines = lines || strstr(report.warnings[i], "meet the light");
            }
            double skipped = -1;
            for (size_t i = 0; i < report.counter_count; i++)
                if (strcmp(report.counters[i].name, "skipped_edges") == 0)
                    skipped = report.counters[i].value;
            assert_true(borders);
            assert_true(k == 0 ? skipped == 0 : skipped > 0);
            assert_true(lines == (k == 1));
            pnb_solver_destroy(solver);
        }
    shot_end(&shot);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(faces_against_the_rim),
        cmocka_unit_test(tangent_planes_touch_the_rim),
        cmocka_unit_test(volumes_of_a_convex_occluder),
        cmocka_unit_test(straight_edge_is_exact),
        cmocka_unit_test(boundaries_are_right),
        cmocka_unit_test(boundaries_of_scenes),
        cmocka_unit_test(point_light_is_hard_map),
        cmocka_unit_test(one_convex_occluder),
        cmocka_unit_test(errors_stay_below_ceilings),
        cmocka_unit_test(bad_input),
        cmocka_unit_test(broken_meshes_are_told),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
