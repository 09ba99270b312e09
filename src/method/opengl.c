/* method/opengl.c: what the methods on OpenGL share: the device, the frame, the occluders, the two
 * doors.
 *
 *   receivers -> upload -> frame -> the room's draw() -> finish -> resolve -> read back
 *   an engine's depth texture -> frame -> the room's draw() -> resolve into the engine's texture
 *
 * The clock of visibility runs while the room draws, until all is drawn; uploading the receivers,
 * which is the same work for every method, and reading back are the counters upload_ms and read_ms.
 * The counter processor_ms is the processor time of all threads while the room draws: on a software
 * rasteriser the whole cost, whatever else the machine does; with a GPU the share of the CPU.
 * The last pass (resolve) is the same for all: 0 for receivers on the light's dark side or with the
 * whole light below their horizon, 1 where there is no receiver.
 *
 * Memory on the device: 16 + 16 + 4 + 4 + 4 bytes a pixel, the occluders, and the room's own.
 */
#define _POSIX_C_SOURCE 200809L
#include "method/opengl.h"

#include <string.h>
#include <time.h>

#include <penumbra/opengl.h>

#define CORNERS_MAX   64 /* of a light in the resolve shader */
#define LONG_FRAME_MS 2000.0

struct opengl_solver {
    struct opengl_state state;
    bool room_created, warm;
    struct gl_texture *visibility, *resolved; /* R32F of the frame's size */
    struct gl_target *resolved_target;
    struct gl_program *resolve;
};

bool opengl_wanted(const pnb_solver *solver)
{
    return solver->adopts || strcmp(solver_param(solver, "path"), "opengl") == 0;
}

#define PROGRESS_EVERY_MS 50.0

pnb_status opengl_progress(pnb_solver *solver, struct opengl_state *state, double share,
                           double *last_ms)
{
    double now = clock_ms();
    if (*last_ms == 0)
        *last_ms = now;
    if (!solver->context->desc.progress || now - *last_ms < PROGRESS_EVERY_MS)
        return PNB_OK;
    gl_device_finish(state->device);
    *last_ms = clock_ms();
    return parallel_for_progress(solver->context, "visibility", share, share, 0, 1, NULL, NULL);
}

static pnb_status upload_occluders(struct opengl_solver *gl, bool edges, pnb_scene *scene)
{
    pnb_status status = gl->state.occluders
                            ? gl_occluders_update(scene, &gl->state.occluders)
                            : gl_occluders_create(scene, edges, &gl->state.occluders);
    return status == PNB_OK ? gl_occluders_upload(gl->state.device, gl->state.occluders) : status;
}

static pnb_status prepare(pnb_solver *solver, struct opengl_solver *gl)
{
    struct gl_program_desc desc = {.vertex = "gl/cover.vert", .fragment = "method/resolve.frag"};
    pnb_status status = gl_program_create(gl->state.device, &desc, &gl->resolve);
    if (status == PNB_OK)
        status = gl_frame_create(gl->state.device, &gl->state.frame);
    if (status == PNB_OK)
        status = upload_occluders(gl, solver->method->opengl->edges, solver->scene);
    if (status == PNB_OK) {
        gl->room_created = true;
        status = solver->method->opengl->create(solver, &gl->state);
    }
    return status;
}

/* What went wrong while drawing counts where nothing did before it. */
static pnb_status end(struct opengl_solver *gl, pnb_status status)
{
    pnb_status ended = gl_device_end(gl->state.device);
    return status == PNB_OK ? ended : status;
}

pnb_status opengl_create(pnb_solver *solver)
{
    struct opengl_solver *gl = solver->opengl = memory_calloc(solver->context, 1, sizeof(*gl));
    if (!gl)
        return status_no_memory(solver->context, sizeof(*gl));
    pnb_status status = solver->adopts ? gl_device_adopt(solver->context, &gl->state.device)
                                       : gl_device_create(solver->context, &gl->state.device);
    if (status == PNB_OK)
        status = gl_device_begin(gl->state.device);
    if (status != PNB_OK)
        return status;
    status = end(gl, prepare(solver, gl));
    if (status == PNB_OK) {
        solver->report.device = gl_device_get_info(gl->state.device)->renderer;
        const struct gl_occluders *o = gl->state.occluders;
        log_info(solver->context, "%s: %s, %zu triangles", solver->method->info.name,
                 solver->report.device, o->triangle_count);
    }
    return status;
}

static void destroy_pictures(struct opengl_solver *gl)
{
    gl_target_destroy(gl->resolved_target);
    gl_texture_destroy(gl->visibility);
    gl_texture_destroy(gl->resolved);
    gl->resolved_target = NULL;
    gl->visibility = gl->resolved = NULL;
}

void opengl_destroy(pnb_solver *solver)
{
    struct opengl_solver *gl = solver->opengl;
    if (!gl)
        return;
    struct gl_device *device = gl->state.device;
    /* Without the context, what it holds went or goes with it; memory is freed all the same. */
    bool current = device && gl_device_begin(device) == PNB_OK;
    if (device) {
        if (gl->room_created)
            solver->method->opengl->destroy(solver, &gl->state);
        destroy_pictures(gl);
        gl_program_destroy(gl->resolve);
        gl_frame_destroy(gl->state.frame);
        gl_occluders_destroy(gl->state.occluders);
    }
    if (current)
        gl_device_end(device);
    gl_device_destroy(device);
    memory_free(solver->context, gl);
    solver->opengl = NULL;
}

pnb_status opengl_update(pnb_solver *solver, pnb_update update)
{
    struct opengl_solver *gl = solver->opengl;
    pnb_status status = gl_device_begin(gl->state.device);
    if (status != PNB_OK)
        return status;
    status = upload_occluders(gl, solver->method->opengl->edges, solver->scene);
    if (status == PNB_OK && solver->method->opengl->changed)
        status = solver->method->opengl->changed(solver, &gl->state);
    return end(gl, status);
}

static pnb_status resize_pictures(struct opengl_solver *gl)
{
    const struct gl_frame *frame = gl->state.frame;
    if (gl->resolved_target && gl_texture_width(gl->visibility) == frame->width &&
        gl_texture_height(gl->visibility) == frame->height)
        return PNB_OK;
    destroy_pictures(gl);
    struct gl_texture_desc desc = {
        .format = GL_FORMAT_R32F, .width = frame->width, .height = frame->height};
    pnb_status status = gl_texture_create(gl->state.device, &desc, &gl->visibility);
    if (status == PNB_OK)
        status = gl_texture_create(gl->state.device, &desc, &gl->resolved);
    struct gl_target_desc target = {.colors = {{gl->resolved, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(gl->state.device, &target, &gl->resolved_target);
    if (status != PNB_OK)
        destroy_pictures(gl);
    return status;
}

/* ---- Which receivers see nothing whatever stands between ---- */

/* Twice the area that o, a, b turn around, in the polygon's plane. */
static double turn(vec3 o, vec3 a, vec3 b, vec3 normal)
{
    return v3_dot(v3_cross(v3_sub(a, o), v3_sub(b, o)), normal);
}

/* A convex outline's corners decide how high a polygon reaches over any plane. More corners than
 * fit (convex ones at that) stand for no limit: 0. */
static int polygon_corners(const struct light_shape *shape, float corners[4 * CORNERS_MAX])
{
    const double *vertices = shape->light.shape.polygon.vertices;
    size_t count = shape->light.shape.polygon.vertex_count;
    size_t start = 0;
    for (size_t i = 1; i < count; i++)
        if (v3_dot(v3_load(vertices + 3 * i), shape->axis_u) <
            v3_dot(v3_load(vertices + 3 * start), shape->axis_u))
            start = i;
    /* Wrapping: from each corner to the one that has all others on its left. */
    size_t at = start;
    int used = 0;
    do {
        if (used == CORNERS_MAX)
            return 0;
        vec3 here = v3_load(vertices + 3 * at);
        v3_storef(corners + 4 * used, here);
        corners[4 * used++ + 3] = 1;
        size_t next = at == 0 ? 1 : 0;
        for (size_t i = 0; i < count; i++) {
            vec3 p = v3_load(vertices + 3 * i), q = v3_load(vertices + 3 * next);
            double side = turn(here, q, p, shape->normal);
            if (i != at && (side < 0 ||
                            (side == 0 && v3_length(v3_sub(p, here)) > v3_length(v3_sub(q, here)))))
                next = i;
        }
        at = next;
    } while (at != start);
    return used;
}

/* Corners (w = 1 a place, 0 a direction), and the round lights' half axes. */
static int light_corners(const struct light_shape *shape, float corners[4 * CORNERS_MAX],
                         bool *out_round)
{
    *out_round = false;
    switch (shape->light.type) {
    case PNB_LIGHT_RECTANGLE:
        for (int i = 0; i < 4; i++) {
            vec3 p = shape->origin;
            p = i & 1 ? v3_add(p, shape->axis_u) : p;
            p = i & 2 ? v3_add(p, shape->axis_v) : p;
            v3_storef(corners + 4 * i, p);
            corners[4 * i + 3] = 1;
        }
        return 4;
    case PNB_LIGHT_POLYGON: return polygon_corners(shape, corners);
    case PNB_LIGHT_LINE:
        v3_storef(corners, shape->origin);
        v3_storef(corners + 4, v3_add(shape->origin, shape->axis_u));
        corners[3] = corners[7] = 1;
        return 2;
    case PNB_LIGHT_DISK:
        *out_round = true;
        v3_storef(corners, shape->origin);
        corners[3] = 1;
        return 1;
    case PNB_LIGHT_POINT:
        v3_storef(corners, shape->origin);
        corners[3] = 1;
        return 1;
    case PNB_LIGHT_SUN:
        *out_round = true;
        v3_storef(corners, shape->normal);
        corners[3] = 0;
        return 1;
    }
    return 0;
}

static void draw_resolve(struct opengl_solver *gl, const struct light_shape *shape,
                         struct gl_target *target)
{
    float corners[4 * CORNERS_MAX];
    bool round;
    int count = light_corners(shape, corners, &round);
    const vec3 none = v3(0, 0, 0);
    bool one_sided = shape->light.type == PNB_LIGHT_RECTANGLE ||
                     shape->light.type == PNB_LIGHT_DISK || shape->light.type == PNB_LIGHT_POLYGON;
    const vec3 *half_u = round ? &shape->axis_u : &none, *half_v = round ? &shape->axis_v : &none;
    struct gl_draw draw = {
        .program = gl->resolve,
        .target = target,
        .uniforms = {gl_sampler("frame_position", gl->state.frame->position),
                     gl_sampler("frame_normal", gl->state.frame->normal),
                     gl_sampler("visibility", gl->visibility),
                     gl_floats("light_corners", GL_UNIFORM_VEC4, corners, count),
                     gl_int("light_corner_count", count), gl_vec3("light_half_u", &half_u->x),
                     gl_vec3("light_half_v", &half_v->x), gl_int("light_one_sided", one_sided),
                     gl_vec3("light_origin", &shape->origin.x),
                     gl_vec3("light_normal", &shape->normal.x)}};
    gl_draw_cover(gl->state.device, &draw);
}

/* ---- Receivers in, visibility out ---- */

static double processor_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* Rows from the top again; NaN where there is no receiver. */
static void copy_out(const pnb_receivers *receivers, const float *rows, float *visibility)
{
    size_t width = (size_t)receivers->width, height = (size_t)receivers->height;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            size_t i = y * width + x;
            const float *p = receivers->positions + 3 * i, *n = receivers->normals + 3 * i;
            bool none = !isfinite(p[0] + p[1] + p[2] + n[0] + n[1] + n[2]);
            visibility[i] = none ? NAN : rows[(height - 1 - y) * width + x];
        }
}

static pnb_status draw_and_read(pnb_solver *solver, const struct light_shape *shape,
                                const pnb_light *light, const pnb_receivers *receivers,
                                float *visibility)
{
    struct opengl_solver *gl = solver->opengl;
    struct gl_device *device = gl->state.device;
    double started = clock_ms();
    pnb_status status = gl_frame_update(gl->state.frame, solver->scene, receivers);
    if (status == PNB_OK)
        status = resize_pictures(gl);
    if (status != PNB_OK)
        return status;
    gl_device_finish(device);
    double uploaded = clock_ms(), begun = uploaded, drawn = uploaded, processor;
    bool slow;
    /* Drivers finish compiling at the first draw of a program: the solver's first frame is drawn
     * twice, and the first time counts as preparation; unless it takes so long that compiling is a
     * small share of it. */
    do {
        begun = drawn;
        gl->state.lost_ms = 0;
        processor = processor_ms();
        status = solver->method->opengl->draw(solver, &gl->state, shape, light, gl->state.frame,
                                              gl->visibility);
        if (status != PNB_OK)
            return status;
        draw_resolve(gl, shape, gl->resolved_target);
        gl_device_finish(device);
        drawn = clock_ms();
        processor = processor_ms() - processor;
        begun += gl->state.lost_ms;
        slow = drawn - begun > LONG_FRAME_MS;
    } while (!gl->warm && (gl->warm = true) && !slow);
    solver->report.prepare_ms += begun - uploaded;
    float *rows = memory_alloc(solver->context, receivers->count, sizeof(*rows));
    if (!rows)
        return status_no_memory(solver->context, receivers->count * sizeof(*rows));
    status = gl_texture_read(gl->resolved, 0, rows);
    if (status == PNB_OK)
        copy_out(receivers, rows, visibility);
    memory_free(solver->context, rows);
    solver->drawn_ms = drawn - begun;
    solver_count(solver, "processor_ms", processor);
    solver_count(solver, "upload_ms", uploaded - started);
    solver_count(solver, "read_ms", clock_ms() - drawn);
    return status;
}

pnb_status opengl_visibility(pnb_solver *solver, const pnb_light *light,
                             const pnb_receivers *receivers, float *visibility)
{
    struct opengl_solver *gl = solver->opengl;
    struct light_shape shape;
    if (receivers->count == 0)
        return PNB_OK;
    pnb_status status = light_shape_init(solver->context, light, &shape);
    if (status != PNB_OK)
        return status;
    status = gl_device_begin(gl->state.device);
    if (status == PNB_OK)
        status = end(gl, draw_and_read(solver, &shape, light, receivers, visibility));
    light_shape_finish(solver->context, &shape);
    return status;
}

/* ---- An engine's textures in and out ---- */

pnb_status pnb_gl_solver_create(pnb_context *context, pnb_scene *scene, const pnb_solver_desc *desc,
                                pnb_solver **out_solver)
{
    return solver_make(context, scene, desc, true, out_solver);
}

static pnb_status adopt_view(struct opengl_solver *gl, const pnb_gl_view *view,
                             struct gl_frame_source *source)
{
    struct gl_device *device = gl->state.device;
    pnb_context *context = gl_device_context(device);
    int width, height;
    pnb_status status =
        gl_texture_look(device, view->depth_texture, true, "depth_texture", &width, &height);
    if (status != PNB_OK)
        return status;
    *source = (struct gl_frame_source){.normals_biased = view->normals_biased,
                                       .x = view->x,
                                       .y = view->y,
                                       .width = view->width,
                                       .height = view->height,
                                       .zero_to_one = view->clip_zero_to_one,
                                       .reversed = view->depth_reversed};
    if (view->width == 0 && view->height == 0) {
        source->width = width - view->x;
        source->height = height - view->y;
    }
    if (view->x < 0 || view->y < 0 || source->width < 1 || source->height < 1 ||
        source->x > width - source->width || source->y > height - source->height)
        return status_fail(context, PNB_ERROR_ARGUMENT, "depth_texture",
                           "the viewport leaves its %dx%d texels", width, height);
    for (int i = 0; i < 16; i++)
        source->clip_from_world[i] = view->clip_from_world[i];
    for (int i = 0; i < 16; i++)
        if (!isfinite(source->clip_from_world[i]))
            return status_fail(context, PNB_ERROR_ARGUMENT, "clip_from_world", "not finite");
    source->low = v3_loadf(view->low);
    source->high = v3_loadf(view->high);
    vec3 extent = v3_sub(source->high, source->low);
    if (!v3_finite(extent) || extent.x < 0 || extent.y < 0 || extent.z < 0)
        return status_fail(context, PNB_ERROR_ARGUMENT, "low, high", "no box");
    source->bounded = extent.x > 0 || extent.y > 0 || extent.z > 0;
    status = gl_texture_adopt(device, view->depth_texture, GL_FORMAT_DEPTH32F, width, height,
                              &source->depth);
    if (status == PNB_OK && view->normal_texture)
        status =
            gl_texture_look(device, view->normal_texture, false, "normal_texture", &width, &height);
    if (status == PNB_OK && view->normal_texture &&
        (source->x > width - source->width || source->y > height - source->height))
        status = status_fail(context, PNB_ERROR_ARGUMENT, "normal_texture",
                             "the viewport leaves its %dx%d texels", width, height);
    if (status == PNB_OK && view->normal_texture)
        status = gl_texture_adopt(device, view->normal_texture, GL_FORMAT_RGBA16F, width, height,
                                  &source->normal);
    return status;
}

static pnb_status draw_into(pnb_solver *solver, const struct light_shape *shape,
                            const pnb_light *light, const struct gl_frame_source *source,
                            unsigned visibility_texture)
{
    struct opengl_solver *gl = solver->opengl;
    struct gl_device *device = gl->state.device;
    int width, height;
    pnb_status status =
        gl_texture_look(device, visibility_texture, false, "visibility_texture", &width, &height);
    if (status == PNB_OK && (width != source->width || height != source->height))
        status = status_fail(solver->context, PNB_ERROR_ARGUMENT, "visibility_texture",
                             "%dx%d texels; the viewport has %dx%d", width, height, source->width,
                             source->height);
    if (status == PNB_OK)
        status = gl_frame_from_depth(gl->state.frame, solver->scene, source);
    if (status == PNB_OK)
        status = resize_pictures(gl);
    struct gl_texture *out = NULL;
    struct gl_target *target = NULL;
    if (status == PNB_OK)
        status = gl_texture_adopt(device, visibility_texture, GL_FORMAT_R32F, width, height, &out);
    struct gl_target_desc desc = {.colors = {{out, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(device, &desc, &target);
    if (status == PNB_OK)
        status = solver->method->opengl->draw(solver, &gl->state, shape, light, gl->state.frame,
                                              gl->visibility);
    if (status == PNB_OK)
        draw_resolve(gl, shape, target);
    gl_target_destroy(target);
    gl_texture_destroy(out);
    return status;
}

pnb_status pnb_gl_solver_visibility(pnb_solver *solver, const pnb_light *light,
                                    const pnb_gl_view *view, unsigned visibility_texture)
{
    struct opengl_solver *gl = solver->opengl;
    pnb_status status = solver_check_light(solver, light);
    if (status != PNB_OK)
        return status;
    if (!gl || !solver->adopts)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "solver",
                           "not made by pnb_gl_solver_create()");
    if (!view)
        return status_missing(solver->context, "view");
    struct light_shape shape;
    status = light_shape_init(solver->context, light, &shape);
    if (status != PNB_OK)
        return status;
    solver->report.counter_count = 0;
    double started = clock_ms();
    status = gl_device_begin(gl->state.device);
    if (status == PNB_OK) {
        struct gl_frame_source source = {0};
        status = adopt_view(gl, view, &source);
        if (status == PNB_OK)
            status = draw_into(solver, &shape, light, &source, visibility_texture);
        gl_texture_destroy(source.depth);
        gl_texture_destroy(source.normal);
        status = end(gl, status);
    }
    solver->report.visibility_ms = clock_ms() - started;
    light_shape_finish(solver->context, &shape);
    return status;
}
