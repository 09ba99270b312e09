/* bench_wedge.c: the paper's figure 12 again: frames a second of the wedges over the number of
 * polygons, spheres of 762 triangles, and what blending costs. Visibility alone, the least of some
 * frames of each, taken in turns. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

static const char usage[] =
    "usage: penumbra bench wedge [--json] [-s WxH] [--frames N] [--spheres N]\n\n"
    "Frames a second of wedge and wedge-blend over 1 to 27 spheres of 762 triangles, with\n"
    "silhouettes from the light's centre and from each point.\n";

/* What blending may cost in the mean, and the CPU's set-up of a frame. */
#define RATIO_MOST 1.3
#define SHARE_MOST (1.0 / 3)

static const char *const methods[2] = {"wedge", "wedge-blend"};
static const char *const rules[2] = {"center", "point"};

struct result {
    double ms[2], setup_ms[2]; /* of the two methods */
};

/* The first count spheres of a cube of 27, with its ground, light and camera. */
static pnb_status make_scene(pnb_context *context, int count, pnb_scene **out_scene)
{
    pnb_scene *all, *scene = NULL;
    pnb_status status = pnb_scene_load(context, "builtin:spheres-3x3x3", &all);
    if (status != PNB_OK)
        return status;
    status = pnb_scene_create(context, &scene);
    int spheres = 0;
    for (size_t i = 0; i < pnb_scene_mesh_count(all) && status == PNB_OK; i++) {
        pnb_mesh_desc mesh;
        pnb_scene_mesh(all, i, &mesh);
        status = pnb_scene_add_mesh(scene, &mesh, NULL);
    }
    for (size_t i = 0; i < pnb_scene_object_count(all) && status == PNB_OK; i++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(all, i, &object);
        pnb_scene_mesh(all, object.mesh, &mesh);
        if (mesh.triangle_count == 762 && spheres++ >= count)
            continue;
        status = pnb_scene_add_object(scene, &object, NULL);
    }
    if (status == PNB_OK) {
        pnb_light light;
        pnb_camera camera;
        pnb_scene_light(all, 0, &light);
        pnb_scene_camera(all, &camera);
        status = pnb_scene_add_light(scene, &light, NULL);
        if (status == PNB_OK)
            status = pnb_scene_set_camera(scene, &camera);
    }
    pnb_scene_destroy(all);
    *out_scene = scene;
    return status;
}

static double counter(const pnb_solver_report *report, const char *name)
{
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, name) == 0)
            return report->counters[i].value;
    return 0;
}

static pnb_status measure(pnb_context *context, pnb_scene *scene, const pnb_receivers *receivers,
                          const char *rule, int frames, struct result *result, char *device)
{
    pnb_solver *solvers[2] = {NULL, NULL};
    pnb_status status = PNB_OK;
    pnb_light light;
    float *visibility = malloc(receivers->count * sizeof(*visibility));
    pnb_scene_light(scene, 0, &light);
    for (int m = 0; m < 2 && status == PNB_OK; m++) {
        pnb_solver_param param = {"silhouettes", rule};
        pnb_solver_desc desc = {.method = methods[m], .params = &param, .param_count = 1};
        status = pnb_solver_create(context, scene, &desc, &solvers[m]);
        result->ms[m] = result->setup_ms[m] = 1e30;
    }
    for (int frame = 0; frame <= frames; frame++)
        for (int m = 0; m < 2 && status == PNB_OK && visibility; m++) {
            pnb_solver_report report;
            status = pnb_solver_visibility(solvers[m], &light, receivers, visibility);
            pnb_solver_get_report(solvers[m], &report);
            snprintf(device, 256, "%s", report.device);
            double setup = counter(&report, "setup_ms");
            if (frame == 0) /* textures are made */
                continue;
            if (report.visibility_ms < result->ms[m])
                result->ms[m] = report.visibility_ms;
            if (setup < result->setup_ms[m])
                result->setup_ms[m] = setup;
        }
    for (int m = 0; m < 2; m++)
        pnb_solver_destroy(solvers[m]);
    free(visibility);
    return status;
}

int main(int argc, char **argv)
{
    static const int counts[] = {1, 2, 4, 8, 12, 16, 23, 27};
    enum { COUNTS = sizeof(counts) / sizeof(*counts) };
    bool json = false;
    int width = 800, height = 600, frames = 3, most = 27;
    for (int i = 1; i < argc; i++) {
        const char *next = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--json") == 0) {
            json = true;
        } else if (strcmp(argv[i], "-s") == 0 && sscanf(next, "%dx%d", &width, &height) == 2 &&
                   width > 0 && height > 0 && width <= 8192 && height <= 8192) {
            i++;
        } else if (strcmp(argv[i], "--frames") == 0 && (frames = atoi(next)) > 0) {
            i++;
        } else if (strcmp(argv[i], "--spheres") == 0 && (most = atoi(next)) > 0) {
            i++;
        } else {
            fputs(usage, strcmp(argv[i], "--help") == 0 ? stdout : stderr);
            return strcmp(argv[i], "--help") == 0 ? 0 : 2;
        }
    }
    pnb_context *context;
    char device[256] = "";
    double sum[2] = {0, 0}, share = 0; /* the CPU's of a frame: the largest of all rows */
    int rows = 0;
    pnb_status status = pnb_context_create(NULL, &context);
    if (status != PNB_OK)
        return 1;
    if (json)
        printf("{\"suite\": \"wedge\", \"width\": %d, \"height\": %d, \"rows\": [", width, height);
    else
        printf("%d x %d; frames/s of wedge and wedge-blend, cost of blending, set-up on the CPU\n"
               "polygons   center: added blended ratio   point: added blended ratio   set-up ms\n",
               width, height);
    for (int i = 0; i < COUNTS && status == PNB_OK && counts[i] <= most; i++) {
        pnb_scene *scene = NULL;
        pnb_surface *surface = NULL;
        struct result results[2];
        status = make_scene(context, counts[i], &scene);
        if (status == PNB_OK)
            status = pnb_surface_create(context, scene, NULL, width, height, &surface);
        for (int r = 0; r < 2 && status == PNB_OK; r++) {
            pnb_receivers receivers;
            pnb_surface_receivers(surface, &receivers);
            status = measure(context, scene, &receivers, rules[r], frames, &results[r], device);
        }
        if (status == PNB_OK) {
            double ratio[2];
            for (int r = 0; r < 2; r++)
                sum[r] += ratio[r] = results[r].ms[1] / results[r].ms[0];
            rows++;
            for (int m = 0; m < 2; m++)
                for (int r = 0; r < 2; r++)
                    share = fmax(share, results[r].setup_ms[m] / results[r].ms[m]);
            if (json)
                printf("%s\n {\"polygons\": %d, \"center_wedge_ms\": %g, \"center_blend_ms\": %g, "
                       "\"point_wedge_ms\": %g, \"point_blend_ms\": %g, \"setup_ms\": %g}",
                       i ? "," : "", counts[i] * 762, results[0].ms[0], results[0].ms[1],
                       results[1].ms[0], results[1].ms[1], results[1].setup_ms[1]);
            else
                printf("%8d   %13.2f %7.2f %5.2f   %12.2f %7.2f %5.2f   %9.3f\n", counts[i] * 762,
                       1e3 / results[0].ms[0], 1e3 / results[0].ms[1], ratio[0],
                       1e3 / results[1].ms[0], 1e3 / results[1].ms[1], ratio[1],
                       results[1].setup_ms[1]);
            fflush(stdout);
        }
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    double center = sum[0] / (rows ? rows : 1), point = sum[1] / (rows ? rows : 1);
    bool cheap = fmax(center, point) <= RATIO_MOST, light = share < SHARE_MOST;
    if (json)
        printf("],\n \"mean_ratio_center\": %g, \"mean_ratio_point\": %g, \"setup_share\": %g, "
               "\"pass\": %s, \"device\": \"%s\"}\n",
               center, point, share, cheap && light ? "true" : "false", device);
    else
        printf(
            "mean ratio %.2f (center), %.2f (point), at most %.1f: %s (the paper: 1.21); set-up on "
            "the CPU at most %.3f %% of a frame, below a third: %s. Device: %s\n",
            center, point, RATIO_MOST, cheap ? "pass" : "FAIL", 100 * share,
            light ? "pass" : "FAIL", device);
    if (status != PNB_OK)
        fprintf(stderr, "penumbra-bench-wedge: error: %s\n", pnb_context_error(context));
    pnb_context_destroy(context);
    return status != PNB_OK;
}
