/* cli/compare_motion.c: how much more a method's picture jumps between frames than the truth does.
 *
 * The light (or the occluder with the most triangles) moves along a short straight path across the
 * view. With V the visibility and T the truth, the jump of a pixel from one frame to the next is
 *
 *     j = (V' - V) - (T' - T)
 *
 * An error that stays where it is makes none; one that swims or pops does. Flicker is the root mean
 * square of j over all steps and the pixels of the penumbra (truth strictly between 0 and 1 in one
 * of both frames, or |j| > 1/255); popping its 99.9th percentile. Pixels count that face the whole
 * light and show the same resting surface in all frames.
 *
 * The truth has noise: the same samples in all frames, so most of it stays where it is.
 */
#include "compare_motion.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TRUTH_SAMPLES 1024
#define RAYS          64   /* of the reference, where it would be the truth again */
#define LIGHT_PATH    0.06 /* of the distance from the light to what the camera looks at */
#define OBJECT_PATH   0.25 /* of the occluder's diagonal */
#define SUN_PATH_RAD  0.06

struct filming {
    struct cli_session *session;
    struct compare_motion *motion;
    bool occluder;
    pnb_scene *scene;
    size_t object; /* that moves */
    double path[3];
    pnb_light light;
    double placement[12];
    size_t pixels;
    pnb_surface **surfaces; /* one, or one per frame */
    uint8_t *mask;          /* pixels that count in all frames */
    float *truth;           /* frames x pixels */
    float *frames;          /* the same of the entry at hand */
    float *jumps;           /* those of the penumbra, for the percentile */
    size_t row;             /* of the slices */
};

static int no_memory(void)
{
    return cli_error("memory", "none left");
}

/* ---- progress: about milliseconds ---- */

static double truth_units(const struct compare_motion *motion)
{
    return motion->frames * (double)motion->width * motion->height * TRUTH_SAMPLES * 8e-6;
}

static double entry_units(const struct compare_motion *motion)
{
    return motion->frames * 30.0;
}

/* ---- what moves ---- */

static void light_center(const pnb_light *light, double *center)
{
    memset(center, 0, 3 * sizeof(*center));
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: memcpy(center, light->shape.rectangle.center, 24); break;
    case PNB_LIGHT_DISK: memcpy(center, light->shape.disk.center, 24); break;
    case PNB_LIGHT_POINT: memcpy(center, light->shape.point.position, 24); break;
    case PNB_LIGHT_LINE:
        for (int a = 0; a < 3; a++)
            center[a] = 0.5 * (light->shape.line.from[a] + light->shape.line.to[a]);
        break;
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < 3 * light->shape.polygon.vertex_count; i++)
            center[i % 3] +=
                light->shape.polygon.vertices[i] / (double)light->shape.polygon.vertex_count;
        break;
    case PNB_LIGHT_SUN: break;
    }
}

/* The light at the share t of its path, from -1/2 to 1/2. vertices: room for those of a polygon. */
static pnb_light move_light(const struct filming *filming, double t, double *vertices)
{
    pnb_light light = filming->light;
    double d[3];
    for (int a = 0; a < 3; a++)
        d[a] = t * filming->path[a];
    double *points[2] = {NULL, NULL};
    switch (light.type) {
    case PNB_LIGHT_RECTANGLE: points[0] = light.shape.rectangle.center; break;
    case PNB_LIGHT_DISK: points[0] = light.shape.disk.center; break;
    case PNB_LIGHT_POINT: points[0] = light.shape.point.position; break;
    case PNB_LIGHT_LINE:
        points[0] = light.shape.line.from;
        points[1] = light.shape.line.to;
        break;
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < 3 * light.shape.polygon.vertex_count; i++)
            vertices[i] = light.shape.polygon.vertices[i] + d[i % 3];
        light.shape.polygon.vertices = vertices;
        break;
    case PNB_LIGHT_SUN: points[0] = light.shape.sun.direction; break;
    }
    for (int k = 0; k < 2 && points[k]; k++)
        for (int a = 0; a < 3; a++)
            points[k][a] += d[a];
    return light;
}

static int move_object(const struct filming *filming, double t)
{
    double placement[12];
    memcpy(placement, filming->placement, sizeof(placement));
    for (int a = 0; a < 3; a++)
        placement[4 * a + 3] += t * filming->path[a];
    return pnb_scene_set_placement(filming->scene, filming->object, placement) == PNB_OK
               ? CLI_GO_ON
               : cli_session_fail(filming->session);
}

/* Level, to the right of the camera, so that shadows cross the view. */
static void across(const pnb_scene *scene, double *out)
{
    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    double x = camera.target[0] - camera.eye[0], z = camera.target[2] - camera.eye[2];
    double length = hypot(x, z);
    out[0] = length > 0 ? -z / length : 1;
    out[1] = 0;
    out[2] = length > 0 ? x / length : 0;
}

static int find_occluder(struct filming *filming, double *diagonal)
{
    size_t most = 0;
    for (size_t i = 0; i < pnb_scene_object_count(filming->scene); i++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(filming->scene, i, &object);
        pnb_scene_mesh(filming->scene, object.mesh, &mesh);
        if (!object.casts || object.plane || mesh.triangle_count <= most)
            continue;
        pnb_mesh_info info;
        if (pnb_scene_mesh_info(filming->scene, object.mesh, &info) != PNB_OK)
            return cli_session_fail(filming->session);
        most = mesh.triangle_count;
        filming->object = i;
        memcpy(filming->placement, object.world_from_mesh, sizeof(filming->placement));
        *diagonal = 0;
        for (int a = 0; a < 3; a++) {
            double side = 0; /* of the box around the placed box */
            for (int b = 0; b < 3; b++)
                side += fabs(object.world_from_mesh[4 * a + b]) *
                        (info.bounds_max[b] - info.bounds_min[b]);
            *diagonal += side * side;
        }
        *diagonal = sqrt(*diagonal);
    }
    return most ? CLI_GO_ON : cli_error(filming->motion->path, "has no occluder that could move");
}

static int choose_path(struct filming *filming)
{
    struct compare_motion *motion = filming->motion;
    double direction[3], length = 0;
    across(filming->scene, direction);
    if (filming->occluder) {
        int done = find_occluder(filming, &length);
        if (done != CLI_GO_ON)
            return done;
        length *= OBJECT_PATH * motion->share;
        snprintf(motion->what, sizeof(motion->what), "an occluder moves %.3g m in %d steps", length,
                 motion->frames - 1);
    } else if (filming->light.type == PNB_LIGHT_SUN) {
        const double *d = filming->light.shape.sun.direction;
        double angle = SUN_PATH_RAD * motion->share;
        length = angle * sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        snprintf(motion->what, sizeof(motion->what), "the sun turns by %.2g degrees in %d steps",
                 angle * 57.29578, motion->frames - 1);
    } else {
        pnb_camera camera;
        double center[3], away = 0;
        pnb_scene_camera(filming->scene, &camera);
        light_center(&filming->light, center);
        for (int a = 0; a < 3; a++)
            away += (center[a] - camera.target[a]) * (center[a] - camera.target[a]);
        length = LIGHT_PATH * motion->share * sqrt(away);
        snprintf(motion->what, sizeof(motion->what), "the light moves %.3g m in %d steps", length,
                 motion->frames - 1);
    }
    for (int a = 0; a < 3; a++)
        filming->path[a] = length * direction[a];
    return CLI_GO_ON;
}

/* ---- frames ---- */

static double share(const struct filming *filming, int frame)
{
    return frame / (double)(filming->motion->frames - 1) - 0.5;
}

static pnb_surface *surface_of(const struct filming *filming, int frame)
{
    return filming->surfaces[filming->occluder ? frame : 0];
}

/* All frames of a solver, visibility by visibility. *milliseconds: the median. */
static int film(struct filming *filming, pnb_solver *solver, float *frames, double *milliseconds)
{
    struct cli_session *session = filming->session;
    size_t vertices =
        filming->light.type == PNB_LIGHT_POLYGON ? filming->light.shape.polygon.vertex_count : 0;
    double *moved = malloc((3 * vertices + 1) * sizeof(*moved));
    double *times = calloc((size_t)filming->motion->frames, sizeof(*times));
    int result = moved && times ? CLI_GO_ON : no_memory();
    for (int f = 0; f < filming->motion->frames && result == CLI_GO_ON; f++) {
        pnb_light light = filming->light;
        pnb_receivers receivers;
        pnb_solver_report report;
        pnb_status status = PNB_OK;
        if (filming->occluder) {
            result = move_object(filming, share(filming, f));
            status = pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS);
        } else {
            light = move_light(filming, share(filming, f), moved);
        }
        pnb_surface_receivers(surface_of(filming, f), &receivers);
        if (status == PNB_OK && result == CLI_GO_ON)
            status = pnb_solver_visibility(solver, &light, &receivers,
                                           frames + (size_t)f * filming->pixels);
        if (status != PNB_OK)
            result = cli_session_fail(session);
        pnb_solver_get_report(solver, &report);
        times[f] = report.visibility_ms;
        if (result == CLI_GO_ON && cli_session_stopped())
            result = cli_error("compare", "cancelled");
    }
    if (result == CLI_GO_ON)
        *milliseconds = cli_median(times, (size_t)filming->motion->frames);
    free(moved);
    free(times);
    return result;
}

static int make_surfaces(struct filming *filming)
{
    struct compare_motion *motion = filming->motion;
    int count = filming->occluder ? motion->frames : 1, result = CLI_GO_ON;
    filming->surfaces = calloc((size_t)count, sizeof(*filming->surfaces));
    if (!filming->surfaces)
        return no_memory();
    for (int f = 0; f < count && result == CLI_GO_ON; f++) {
        if (filming->occluder)
            result = move_object(filming, share(filming, f));
        if (result == CLI_GO_ON &&
            pnb_surface_create(filming->session->context, filming->scene, NULL, motion->width,
                               motion->height, &filming->surfaces[f]) != PNB_OK)
            result = cli_session_fail(filming->session);
    }
    return result;
}

/* Pixels that face the light in every frame and whose surface rests. */
static int mark_pixels(struct filming *filming)
{
    size_t vertices =
        filming->light.type == PNB_LIGHT_POLYGON ? filming->light.shape.polygon.vertex_count : 0;
    double *moved = malloc((3 * vertices + 1) * sizeof(*moved));
    uint8_t *facing = malloc(filming->pixels);
    bool good = moved && facing;
    if (good)
        memset(filming->mask, 1, filming->pixels);
    pnb_surface_view first, view;
    pnb_surface_get(surface_of(filming, 0), &first);
    for (int f = 0; f < filming->motion->frames && good; f++) {
        pnb_light light =
            filming->occluder ? filming->light : move_light(filming, share(filming, f), moved);
        pnb_receivers receivers;
        pnb_surface_receivers(surface_of(filming, f), &receivers);
        pnb_surface_get(surface_of(filming, f), &view);
        pnb_measure_facing(&light, &receivers, facing);
        for (size_t i = 0; i < filming->pixels; i++) {
            bool rests = !filming->occluder || (view.objects[i] == first.objects[i] &&
                                                view.objects[i] != filming->object);
            filming->mask[i] &= facing[i] && rests;
        }
    }
    free(moved);
    free(facing);
    return good ? CLI_GO_ON : no_memory();
}

/* The row in which the truth moves most. */
static void choose_row(struct filming *filming)
{
    double most = -1;
    for (int y = 0; y < filming->motion->height; y++) {
        double sum = 0;
        for (int f = 1; f < filming->motion->frames; f++)
            for (int x = 0; x < filming->motion->width; x++) {
                size_t i = (size_t)y * (size_t)filming->motion->width + (size_t)x;
                const float *now = filming->truth + (size_t)f * filming->pixels;
                double change = fabs(now[i] - now[i - filming->pixels]);
                if (filming->mask[i] && isfinite(change))
                    sum += change;
            }
        if (sum > most) {
            most = sum;
            filming->row = (size_t)y;
        }
    }
}

static int by_size(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Figures of an entry from its frames. largest: per pixel. */
static void judge(struct filming *filming, struct compare_motion_entry *entry, float *largest)
{
    struct compare_motion *motion = filming->motion;
    size_t count = 0;
    double sum = 0, truth_sum = 0, own_sum = 0;
    for (size_t i = 0; i < filming->pixels; i++)
        largest[i] = filming->mask[i] ? 0 : NAN;
    for (int f = 0; f + 1 < motion->frames; f++) {
        const float *t = filming->truth + (size_t)f * filming->pixels, *u = t + filming->pixels;
        const float *v = filming->frames + (size_t)f * filming->pixels, *w = v + filming->pixels;
        double step = 0;
        size_t step_count = 0;
        for (size_t i = 0; i < filming->pixels; i++) {
            if (!filming->mask[i])
                continue;
            float change = u[i] - t[i], own = w[i] - v[i], jump = own - change;
            if (isnan(jump)) {
                largest[i] = NAN;
                continue;
            }
            if (fabsf(jump) > largest[i])
                largest[i] = fabsf(jump);
            bool penumbra = (t[i] > 0 && t[i] < 1) || (u[i] > 0 && u[i] < 1);
            if (!penumbra && fabsf(jump) <= 1 / 255.0f)
                continue;
            filming->jumps[count++] = fabsf(jump);
            step += (double)jump * jump;
            truth_sum += (double)change * change;
            own_sum += (double)own * own;
            step_count++;
        }
        entry->steps[f] = step_count ? sqrt(step / (double)step_count) : 0;
        sum += step;
    }
    entry->pixels = count;
    if (!count)
        return;
    entry->flicker = sqrt(sum / (double)count);
    entry->truth_change = sqrt(truth_sum / (double)count);
    entry->change = sqrt(own_sum / (double)count);
    qsort(filming->jumps, count, sizeof(*filming->jumps), by_size);
    entry->popping = filming->jumps[(size_t)(0.999 * (double)(count - 1))];
    entry->largest = filming->jumps[count - 1];
}

/* One row over time: frames run downwards. */
static int draw_slice(struct filming *filming, const float *frames, struct compare_png *png)
{
    const struct compare_motion *motion = filming->motion;
    pnb_image image;
    pnb_context *context = filming->session->context;
    if (pnb_image_create(context, motion->width, motion->frames, 1, &image) != PNB_OK)
        return cli_session_fail(filming->session);
    for (int f = 0; f < motion->frames; f++)
        for (int x = 0; x < motion->width; x++) {
            size_t i = filming->row * (size_t)motion->width + (size_t)x;
            float v = frames[(size_t)f * filming->pixels + i];
            image.data[f * motion->width + x] = isnan(v) ? 1 : v;
        }
    pnb_status status = pnb_image_encode_png(context, &image, true, &png->bytes, &png->size);
    pnb_image_finish(context, &image);
    return status == PNB_OK ? CLI_GO_ON : cli_session_fail(filming->session);
}

/* The largest jump of each pixel; all maps of a scene end at the same one. */
static int draw_jumps(struct filming *filming, struct compare_motion_entry *entry,
                      const float *largest)
{
    const struct compare_motion *motion = filming->motion;
    pnb_context *context = filming->session->context;
    pnb_image image;
    if (pnb_image_create(context, motion->width, motion->height, 1, &image) != PNB_OK)
        return cli_session_fail(filming->session);
    for (size_t i = 0; i < filming->pixels; i++)
        image.data[i] =
            isnan(largest[i])
                ? 0
                : (float)(1 + floor(fmin(largest[i] / COMPARE_JUMP_SCALE, 1) * 254)) / 255;
    uint8_t colors[256][3] = {{68, 68, 68}}, *grey;
    for (int code = 1; code < 256; code++) {
        double rgb[3];
        pnb_colormap_sequential((code - 1) / 254.0, rgb);
        for (int k = 0; k < 3; k++)
            colors[code][k] = (uint8_t)(compare_srgb(rgb[k]) * 255 + 0.5);
    }
    size_t size;
    pnb_status status = pnb_image_encode_png(context, &image, false, &grey, &size);
    pnb_image_finish(context, &image);
    if (status != PNB_OK)
        return cli_session_fail(filming->session);
    bool good = compare_png_palette(grey, size, colors, &entry->jumps);
    pnb_bytes_free(context, grey);
    return good ? CLI_GO_ON : no_memory();
}

static void step(struct filming *filming, const char *what, double units)
{
    char text[64];
    snprintf(text, sizeof(text), "%.24s, motion: %.24s", filming->motion->title, what);
    cli_session_step(filming->session, text, units);
}

static int run_entry(struct filming *filming, const struct compare_entry *from, float *largest)
{
    struct compare_motion *motion = filming->motion;
    struct compare_motion_entry *entry = &motion->entries[motion->entry_count];
    pnb_solver *solver = NULL;
    int result = CLI_GO_ON;
    step(filming, from->label, entry_units(motion));
    *entry = (struct compare_motion_entry){.method = from->method,
                                           .steps = calloc((size_t)motion->frames, sizeof(double))};
    snprintf(entry->label, sizeof(entry->label), "%s", from->label);
    if (!entry->steps)
        return no_memory();
    motion->entry_count++;
    if (compare_entry_solver(filming->session->context, filming->scene, from, &solver) != PNB_OK)
        result = cli_session_fail(filming->session);
    if (result == CLI_GO_ON)
        result = film(filming, solver, filming->frames, &entry->milliseconds);
    pnb_solver_destroy(solver);
    if (result != CLI_GO_ON)
        return result;
    judge(filming, entry, largest);
    result = draw_slice(filming, filming->frames, &entry->slice);
    return result == CLI_GO_ON ? draw_jumps(filming, entry, largest) : result;
}

static int run_truth(struct filming *filming)
{
    pnb_solver_param seed = {"seed", "9001"};
    pnb_solver_desc desc = {
        .method = "reference", .samples = TRUTH_SAMPLES, .params = &seed, .param_count = 1};
    pnb_solver *solver = NULL;
    double milliseconds;
    step(filming, "truth", truth_units(filming->motion));
    if (pnb_solver_create(filming->session->context, filming->scene, &desc, &solver) != PNB_OK)
        return cli_session_fail(filming->session);
    int result = film(filming, solver, filming->truth, &milliseconds);
    pnb_solver_destroy(solver);
    if (result != CLI_GO_ON)
        return result;
    choose_row(filming);
    return draw_slice(filming, filming->truth, &filming->motion->truth_slice);
}

double compare_motion_units(const struct compare_motion *motion, size_t entries)
{
    return truth_units(motion) + (double)entries * entry_units(motion);
}

int compare_motion_run(struct cli_session *session, const struct compare_scene *scene,
                       bool occluder, struct compare_motion *motion)
{
    struct filming filming = {.session = session, .motion = motion, .occluder = occluder};
    motion->path = scene->path;
    motion->title = report_scene_name(scene);
    motion->truth_samples = TRUTH_SAMPLES;
    motion->entries = calloc(scene->entry_count + 1, sizeof(*motion->entries));
    filming.pixels = (size_t)motion->width * (size_t)motion->height;
    size_t all = filming.pixels * (size_t)motion->frames;
    filming.mask = malloc(filming.pixels);
    filming.truth = malloc(all * sizeof(float));
    filming.frames = malloc(all * sizeof(float));
    filming.jumps = malloc(all * sizeof(float));
    float *largest = malloc(filming.pixels * sizeof(float));
    bool room = motion->entries && filming.mask && filming.truth && filming.frames &&
                filming.jumps && largest;
    int result = room ? cli_scene_load(session, scene->path, &filming.scene) : no_memory();
    if (result == CLI_GO_ON) {
        pnb_scene_light(filming.scene, scene->light_index, &filming.light);
        result = choose_path(&filming);
    }
    if (result == CLI_GO_ON)
        result = make_surfaces(&filming);
    if (result == CLI_GO_ON)
        result = mark_pixels(&filming);
    if (result == CLI_GO_ON)
        result = run_truth(&filming);
    for (size_t i = 0; i < scene->entry_count && result == CLI_GO_ON; i++) {
        struct compare_entry entry = scene->entries[i];
        if (!entry.method || entry.figures_only)
            continue;
        bool rays = strcmp(entry.name, "reference") == 0 && entry.samples >= TRUTH_SAMPLES;
        if (rays) {
            entry.samples = RAYS;
            snprintf(entry.label, sizeof(entry.label), "%s:%d", entry.name, RAYS);
        }
        result = run_entry(&filming, &entry, largest);
    }
    for (int f = 0; filming.surfaces && f < (occluder ? motion->frames : 1); f++)
        pnb_surface_destroy(filming.surfaces[f]);
    free(filming.surfaces);
    pnb_scene_destroy(filming.scene);
    free(filming.mask);
    free(filming.truth);
    free(filming.frames);
    free(filming.jumps);
    free(largest);
    return result;
}

void compare_motion_finish(pnb_context *context, struct compare_motion *motion)
{
    for (size_t i = 0; i < motion->entry_count; i++) {
        struct compare_motion_entry *entry = &motion->entries[i];
        free(entry->steps);
        free(entry->jumps.bytes);
        pnb_bytes_free(context, entry->slice.bytes);
    }
    free(motion->entries);
    pnb_bytes_free(context, motion->truth_slice.bytes);
}
