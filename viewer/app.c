/* viewer/app.c: the scene and state at hand, and every change of them.
 *
 * Each change raises the state's serial number and posts a copy to the worker; frames carry the
 * serial that they were made for, so that one can tell the picture at rest from one on its way.
 */
#include "app.h"

#include <string.h>

#include "motion.h"
#include "script.h"
#include "window.h"

#define EDIT_REST_MS     250
#define VIEW_FIRST_SCENE "builtin:jack-in-the-box"

/* ---- events of the worker ---- */

static void take_param(struct view_method *method, const char *text)
{
    const char *equals = strchr(text, '=');
    size_t length = (size_t)(equals - text);
    for (size_t i = 0; i < method->info->param_count; i++) {
        const char *key = method->info->params[i].key;
        if (strlen(key) != length || strncmp(key, text, length) != 0)
            continue;
        g_free(method->values[i]);
        method->values[i] = g_strdup(equals + 1);
    }
}

static void take_method_options(struct view_app *app)
{
    const struct view_options *options = app->options;
    for (int i = 0; i < VIEW_METHODS_MAX; i++) {
        const struct view_choice *choice = &options->choices[i];
        struct view_method *method = &app->state.methods[i];
        if (choice->method) {
            view_method_finish(method);
            view_method_init(method, pnb_method_find(choice->method));
        }
        method->samples = method->info->samples ? choice->samples : 0;
        for (int p = 0; p < choice->param_count; p++)
            take_param(method, choice->params[p]);
    }
    app->state.compare = options->method_count > 1;
}

static void on_scene(void *user, struct view_scene *scene)
{
    struct view_app *app = user;
    view_motion_stop(app->motion);
    view_scene_unref(app->scene);
    app->scene = view_scene_ref(scene);
    view_state_enter(&app->state, scene);
    view_history_enter(app->history, &app->state);
    app->pick = (struct view_pick){scene->light_count ? VIEW_PICK_LIGHT : VIEW_PICK_NONE, 0};
    view_window_scene_opened(app->window);
    view_app_changed(app);
    view_script_notify(app->script);
}

static void on_frame(void *user, struct view_frame *frame)
{
    struct view_app *app = user;
    if (!app->scene || frame->scene_id != app->scene->id)
        return;
    view_frame_unref(app->frame);
    app->frame = view_frame_ref(frame);
    view_window_frame(app->window);
    bool current = frame->full && !frame->moving && frame->serial == app->state.serial;
    if (app->pending_screenshot && current) {
        view_worker_screenshot(app->worker, frame, app->divider, false, app->pending_screenshot);
        g_clear_pointer(&app->pending_screenshot, g_free);
    }
    view_script_notify(app->script);
}

static void on_progress(void *user, const char *stage, double fraction)
{
    struct view_app *app = user;
    view_window_progress(app->window, stage, fraction);
    view_script_notify(app->script);
}

static void on_failed(void *user, const char *what)
{
    struct view_app *app = user;
    app->failed = true;
    view_window_error(app->window, what);
    view_script_failed(app->script);
}

static void on_saved(void *user, const char *path)
{
    struct view_app *app = user;
    app->failed = false;
    view_window_saved(app->window, path);
    view_script_saved(app->script);
}

static void on_rest(void *user, uint64_t serial, bool stopped)
{
    struct view_app *app = user;
    if (serial != app->state.serial || app->state.moving)
        return;
    app->at_rest = true;
    view_window_rest(app->window, stopped);
    view_script_notify(app->script);
}

/* ---- life ---- */

struct view_app *view_app_create(GtkApplication *application, const struct view_options *options,
                                 int64_t started_us)
{
    struct view_app *app = g_new0(struct view_app, 1);
    app->options = options;
    app->application = application;
    app->started_us = started_us;
    app->divider = 0.5;
    view_state_init(&app->state);
    app->history = view_history_create();
    take_method_options(app);
    app->state.full_size = options->full_size;
    const struct view_worker_events events = {.scene = on_scene,
                                              .frame = on_frame,
                                              .progress = on_progress,
                                              .failed = on_failed,
                                              .saved = on_saved,
                                              .rest = on_rest,
                                              .user = app};
    app->worker = view_worker_create(options->threads, &events);
    view_worker_open(app->worker, options->scene ? options->scene : VIEW_FIRST_SCENE,
                     options->light_count ? options->lights : NULL);
    app->motion = view_motion_create(app);
    app->window = view_window_create(app);
    app->script = view_script_create(app);
    return app;
}

void view_app_destroy(struct view_app *app)
{
    if (!app)
        return;
    if (app->edit_timer)
        g_source_remove(app->edit_timer);
    view_script_destroy(app->script);
    view_motion_destroy(app->motion);
    view_worker_destroy(app->worker);
    view_window_destroy(app->window);
    view_frame_unref(app->frame);
    view_scene_unref(app->scene);
    view_state_finish(&app->state);
    view_history_destroy(app->history);
    g_free(app->pending_screenshot);
    g_free(app);
}

/* ---- files ---- */

void view_app_open(struct view_app *app, const char *path)
{
    app->failed = false;
    view_window_error(app->window, NULL);
    view_worker_open(app->worker, path, NULL);
}

void view_app_save(struct view_app *app, const char *path)
{
    view_window_error(app->window, NULL);
    view_worker_save(app->worker, path);
}

void view_app_screenshot(struct view_app *app, const char *path)
{
    view_window_error(app->window, NULL);
    struct view_frame *frame = app->frame;
    if (frame && frame->full && !frame->moving && frame->serial == app->state.serial) {
        view_worker_screenshot(app->worker, frame, app->divider, false, path);
    } else {
        g_free(app->pending_screenshot);
        app->pending_screenshot = g_strdup(path);
    }
}

void view_app_stop(struct view_app *app)
{
    view_worker_stop(app->worker);
}

void view_app_shot_as_shown(struct view_app *app, const char *path)
{
    view_window_error(app->window, NULL);
    if (!app->frame)
        return;
    view_canvas_read(view_window_canvas(app->window));
    view_worker_screenshot(app->worker, app->frame, app->divider, true, path);
}

/* ---- changes ---- */

void view_app_changed(struct view_app *app)
{
    if (!app->scene)
        return;
    if (!app->moving)
        view_history_note(app->history, &app->state);
    app->state.serial++;
    app->state.wanted_us = g_get_monotonic_time();
    app->state.moving = app->moving != 0;
    app->state.window = view_window_draws(app->window);
    app->at_rest = false;
    if (app->state.width > 0)
        view_worker_show(app->worker, &app->state);
    view_window_refresh(app->window);
}

void view_app_set_moving(struct view_app *app, unsigned why, bool on)
{
    unsigned moving = on ? app->moving | why : app->moving & ~why;
    bool ended = app->moving && !moving;
    app->moving = moving;
    if (ended)
        view_app_changed(app);
}

static gboolean edit_ended(gpointer data)
{
    struct view_app *app = data;
    app->edit_timer = 0;
    view_app_set_moving(app, VIEW_MOVING_EDIT, false);
    return G_SOURCE_REMOVE;
}

void view_app_edited(struct view_app *app)
{
    if (app->edit_timer)
        g_source_remove(app->edit_timer);
    app->edit_timer = g_timeout_add(EDIT_REST_MS, edit_ended, app);
    view_app_set_moving(app, VIEW_MOVING_EDIT, true);
    view_app_changed(app);
}

void view_app_undo(struct view_app *app, int by)
{
    if (!app->scene)
        return;
    /* What is under way ends and is an entry of its own; a hand lets go first. */
    view_motion_stop(app->motion);
    if (app->edit_timer) {
        g_source_remove(app->edit_timer);
        edit_ended(app);
    }
    if (app->moving || !view_history_go(app->history, by, &app->state))
        return;
    view_motion_forget(app->motion);
    if (app->pick.type == VIEW_PICK_LIGHT && app->pick.index >= app->state.light_count)
        app->pick = (struct view_pick){app->state.light_count ? VIEW_PICK_LIGHT : VIEW_PICK_NONE,
                                       app->state.light};
    view_app_changed(app);
}

void view_app_select(struct view_app *app, enum view_pick_type type, size_t index)
{
    if (!app->scene)
        return;
    if ((type == VIEW_PICK_LIGHT && index >= app->state.light_count) ||
        (type == VIEW_PICK_OBJECT && index >= app->state.object_count))
        type = VIEW_PICK_NONE;
    bool same = app->pick.type == type && app->pick.index == index;
    app->pick = (struct view_pick){type, index};
    if (type == VIEW_PICK_LIGHT && app->state.light != index) {
        app->state.light = index;
        view_app_changed(app);
    } else if (!same) {
        view_window_refresh(app->window);
    }
}

void view_app_set_method(struct view_app *app, int side, const pnb_method_info *info)
{
    struct view_method *method = &app->state.methods[side];
    if (!info || method->info == info)
        return;
    view_method_finish(method);
    view_method_init(method, info);
    view_app_changed(app);
}

void view_app_add_light(struct view_app *app, pnb_light_type type)
{
    if (!app->scene)
        return;
    struct view_state *state = &app->state;
    struct view_light light = {.light = {.type = PNB_LIGHT_RECTANGLE, .color = {1, 1, 1}}};
    vec3 middle = view_app_middle(app);
    double radius = app->scene->radius, half = 0.2 * radius;
    /* Beside the scene's first one, so that both can be seen. */
    vec3 place = v3_add(middle, v3(-0.6 * radius, 1.8 * radius, 0.6 * radius));
    if (state->light_count > 0) {
        struct view_frame_axes axes =
            view_light_axes(&state->lights[0], middle, view_app_sun_distance(app));
        place = v3_add(axes.center, v3(0.5 * radius, 0, 0));
        memcpy(light.light.color, state->lights[0].light.color, sizeof(light.light.color));
        if (axes.half_u > 0 && state->lights[0].light.type != PNB_LIGHT_SUN)
            half = axes.half_u;
    }
    double color[3];
    memcpy(color, light.light.color, sizeof(color));
    v3_store(light.light.shape.rectangle.center, place);
    struct view_frame_axes axes = {.center = place, .half_u = half, .half_v = half};
    axes.n = v3_unit(v3_sub(middle, place), v3(0, -1, 0));
    axes.u = v3_unit(v3_cross(v3(0, 1, 0), axes.n), v3(1, 0, 0));
    axes.v = v3_cross(axes.n, axes.u);
    v3_store(light.light.shape.rectangle.half_u, v3_scale(axes.u, half));
    v3_store(light.light.shape.rectangle.half_v, v3_scale(axes.v, half));
    view_light_reshape(&light, type, &axes, view_app_smallest(app));
    if (type == PNB_LIGHT_SUN)
        memcpy(light.light.color, (double[3]){1, 1, 1}, sizeof(color));

    state->lights = g_renew(struct view_light, state->lights, state->light_count + 2);
    state->lights[state->light_count] = light;
    state->light = state->light_count++;
    app->pick = (struct view_pick){VIEW_PICK_LIGHT, state->light};
    view_app_changed(app);
}

void view_app_remove_light(struct view_app *app, size_t index)
{
    struct view_state *state = &app->state;
    if (!app->scene || index >= state->light_count)
        return;
    view_light_finish(&state->lights[index]);
    memmove(state->lights + index, state->lights + index + 1,
            (state->light_count - index - 1) * sizeof(*state->lights));
    state->light_count--;
    size_t next = index < state->light_count ? index : state->light_count ? index - 1 : 0;
    state->light = next;
    app->pick = (struct view_pick){state->light_count ? VIEW_PICK_LIGHT : VIEW_PICK_NONE, next};
    view_motion_stop(app->motion);
    view_app_changed(app);
}

void view_app_reset_camera(struct view_app *app)
{
    if (!app->scene)
        return;
    app->state.camera = app->scene->camera;
    view_app_changed(app);
}

void view_app_frame_selection(struct view_app *app)
{
    if (!app->scene)
        return;
    vec3 middle = view_app_middle(app);
    double radius = app->scene->radius * 1.2;
    if (app->pick.type == VIEW_PICK_OBJECT) {
        view_app_pick_place(app, app->pick, &middle);
        radius = app->scene->objects[app->pick.index].mesh_radius * 1.5;
    }
    double aspect = app->state.height > 0 ? (double)app->state.width / app->state.height : 1;
    view_camera_frame(&app->state.camera, middle, radius, aspect);
    view_app_changed(app);
}

/* ---- sizes and the selection ---- */

vec3 view_app_middle(const struct view_app *app)
{
    return app->scene ? v3_load(app->scene->middle) : v3(0, 0, 0);
}

double view_app_sun_distance(const struct view_app *app)
{
    return app->scene ? 1.6 * app->scene->radius : 1;
}

double view_app_smallest(const struct view_app *app)
{
    return app->scene ? 1e-3 * app->scene->radius : 1e-3;
}

bool view_app_pick_place(const struct view_app *app, struct view_pick pick, vec3 *out)
{
    if (!app->scene)
        return false;
    if (pick.type == VIEW_PICK_LIGHT && pick.index < app->state.light_count) {
        *out = view_light_axes(&app->state.lights[pick.index], view_app_middle(app),
                               view_app_sun_distance(app))
                   .center;
        return true;
    }
    if (pick.type == VIEW_PICK_OBJECT && pick.index < app->state.object_count) {
        *out =
            view_object_middle(&app->scene->objects[pick.index], app->state.placements[pick.index]);
        return true;
    }
    return false;
}

void view_app_pick_move(struct view_app *app, struct view_pick pick, vec3 by)
{
    if (!v3_finite(by) || !app->scene)
        return;
    if (pick.type == VIEW_PICK_LIGHT && pick.index < app->state.light_count) {
        view_light_move(&app->state.lights[pick.index], by, view_app_middle(app),
                        view_app_sun_distance(app));
    } else if (pick.type == VIEW_PICK_OBJECT && pick.index < app->state.object_count) {
        double *m = app->state.placements[pick.index];
        m[3] += by.x;
        m[7] += by.y;
        m[11] += by.z;
    }
}
