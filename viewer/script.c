/* viewer/script.c: drives the window as a hand would. */
#include "script.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "canvas.h"
#include "focus.h"
#include "handles.h"
#include "measure.h"
#include "motion.h"
#include "window.h"

#define WAIT_MOST_MS 240000

enum wait {
    WAIT_NONE,
    WAIT_SCENE,
    WAIT_FULL,
    WAIT_REST,
    WAIT_TIME,
    WAIT_SAVED,
    WAIT_OPENED,
    WAIT_DRAG,
    WAIT_BANNER,
    WAIT_NO_BANNER,
    WAIT_ANSWER,
    WAIT_PROGRESS
};

struct view_script {
    struct view_app *app;
    char **lines;
    int next;
    enum wait wait;
    char *wanted; /* text that the banner shall hold, or what `asked` shall be */
    char *asked;
    char found[300]; /* what it is instead */
    guint poll;
    uint64_t old_scene;
    int64_t deadline_us;
    guint timer, idle;
    bool failed, saved; /* since the command */
    bool done;
    struct view_measure *measure;
    char *picture;    /* of the window, to be written when it has been laid out */
    GString *results; /* JSON objects */
    vec3 mark;
};

static const struct {
    const char *name, *text;
} builtin_scripts[] = {
    {"first", "wait full\nprint\n"},
    {"drag", "wait full\ndrag light\nwait full\nprint\n"},
    {"drag-object", "wait full\ndrag object\nwait full\nprint\n"},
    {"orbit", "wait full\ndrag camera\nwait full\nprint\n"},
    {"repaint", "wait full\ndrag nothing\nwait full\nprint\n"},
};

static void run(struct view_script *script);

/* ---- end ---- */

static void finish(struct view_script *script)
{
    if (script->done)
        return;
    script->done = true;
    gtk_window_close(GTK_WINDOW(view_window_widget(script->app->window)));
}

static void fail(struct view_script *script, const char *why)
{
    if (script->done)
        return;
    char what[400];
    const char *line = script->next > 0 ? script->lines[script->next - 1] : "";
    g_snprintf(what, sizeof(what), "script line %d '%s'", script->next, line);
    view_complain(what, why);
    script->app->exit_status = 1;
    finish(script);
}

static void print_results(struct view_script *script)
{
    const struct view_app *app = script->app;
    const struct view_scene *scene = app->scene;
    double first = (double)app->first_frame_us * 1e-3, full = (double)app->first_full_us * 1e-3;
    if (app->options->json)
        printf("{\"scene\": \"%s\", \"first_picture_ms\": %.1f, \"first_whole_picture_ms\": %.1f, "
               "\"load_ms\": %.1f, \"triangles\": %zu, \"resident_kb\": %ld, \"renderer\": \"%s\", "
               "\"device\": \"%s\", \"drags\": [%s]}\n",
               scene ? scene->name : "", first, full, scene ? (double)scene->load_us * 1e-3 : 0,
               scene ? scene->triangle_count : 0, view_resident_kb(),
               G_OBJECT_TYPE_NAME(
                   gtk_native_get_renderer(GTK_NATIVE(view_window_widget(app->window)))),
               app->frame ? app->frame->device : "", script->results->str);
    else
        printf("first picture %.0f ms, first with all pixels %.0f ms, memory %ld MB\n", first, full,
               view_resident_kb() / 1024);
    fflush(stdout);
    g_string_truncate(script->results, 0);
}

/* ---- waiting ---- */

static gboolean on_timer(gpointer data)
{
    struct view_script *script = data;
    script->timer = 0;
    if (script->wait == WAIT_TIME) {
        script->wait = WAIT_NONE;
        if (script->picture && !view_window_picture(script->app->window, script->picture))
            fail(script, "cannot be written");
        g_clear_pointer(&script->picture, g_free);
        run(script);
    } else {
        char why[400];
        bool asked = script->wait == WAIT_ANSWER;
        g_snprintf(why, sizeof(why), "waited too long%s%s", asked ? "; it is " : "",
                   asked ? script->found : "");
        fail(script, why);
    }
    return G_SOURCE_REMOVE;
}

static void wait_for(struct view_script *script, enum wait wait, guint milliseconds)
{
    script->wait = wait;
    if (script->timer)
        g_source_remove(script->timer);
    script->timer = g_timeout_add(milliseconds, on_timer, script);
}

static bool shown_now(const struct view_app *app)
{
    struct view_canvas_shown shown = view_canvas_get_shown(view_window_canvas(app->window));
    return app->scene && shown.full && shown.serial == app->state.serial && !app->moving;
}

enum answer { ANSWER_UNKNOWN, ANSWER_NO, ANSWER_YES };
static enum answer ask(struct view_script *script, const char *what, const char *text);

static bool reached(struct view_script *script)
{
    const struct view_app *app = script->app;
    const char *banner = view_window_banner(app->window);
    switch (script->wait) {
    case WAIT_NONE: return true;
    case WAIT_SCENE: return app->scene != NULL;
    case WAIT_FULL: return shown_now(app);
    case WAIT_REST: return app->at_rest && shown_now(app);
    case WAIT_SAVED: return script->saved || script->failed;
    case WAIT_OPENED: return script->failed || (app->scene && app->scene->id != script->old_scene);
    case WAIT_BANNER: return *banner && strstr(banner, script->wanted);
    case WAIT_NO_BANNER: return !*banner;
    case WAIT_ANSWER: return ask(script, script->asked, script->wanted) == ANSWER_YES;
    case WAIT_PROGRESS: return view_window_busy(app->window);
    default: return false;
    }
}

static gboolean on_idle(gpointer data)
{
    struct view_script *script = data;
    script->idle = 0;
    if (script->wait != WAIT_NONE && reached(script)) {
        script->wait = WAIT_NONE;
        if (script->timer)
            g_source_remove(script->timer);
        if (script->poll)
            g_source_remove(script->poll);
        script->timer = script->poll = 0;
        run(script);
    }
    return G_SOURCE_REMOVE;
}

void view_script_notify(struct view_script *script)
{
    if (script && !script->done && !script->idle)
        script->idle = g_idle_add(on_idle, script);
}

void view_script_failed(struct view_script *script)
{
    if (!script)
        return;
    script->failed = true;
    if (script->wait == WAIT_SCENE || script->wait == WAIT_FULL || script->wait == WAIT_REST)
        fail(script, "the scene did not open");
    view_script_notify(script);
}

void view_script_saved(struct view_script *script)
{
    if (!script)
        return;
    script->saved = true;
    view_script_notify(script);
}

void view_script_painted(struct view_script *script, int64_t now_us)
{
    if (!script || script->done)
        return;
    if (script->wait == WAIT_DRAG && view_measure_painted(script->measure, now_us)) {
        char *json = view_measure_json(script->measure);
        g_string_append_printf(script->results, "%s%s", script->results->len ? ", " : "", json);
        g_free(json);
        if (!script->app->options->json) {
            char *text = view_measure_text(script->measure);
            printf("%s\n", text);
            g_free(text);
        }
        g_clear_pointer(&script->measure, view_measure_destroy);
        wait_for(script, WAIT_TIME, 1);
        return;
    }
    view_script_notify(script);
}

/* ---- commands ---- */

static int handle_named(const char *name)
{
    static const struct {
        const char *name;
        int type;
    } names[] = {{"move", VIEW_HANDLE_MOVE}, {"x", VIEW_HANDLE_X},      {"y", VIEW_HANDLE_Y},
                 {"z", VIEW_HANDLE_Z},       {"u", VIEW_HANDLE_U},      {"v", VIEW_HANDLE_V},
                 {"aim", VIEW_HANDLE_AIM},   {"spin", VIEW_HANDLE_SPIN}};
    for (gsize i = 0; i < G_N_ELEMENTS(names); i++)
        if (strcmp(name, names[i].name) == 0)
            return names[i].type;
    return VIEW_HANDLE_NONE;
}

static int shape_named(const char *name)
{
    for (int i = 0; i < PNB_LIGHT_TYPE_COUNT; i++)
        if (strcmp(name, pnb_light_type_name((pnb_light_type)i)) == 0)
            return i;
    return -1;
}

static bool do_wait(struct view_script *script, const char *what)
{
    char *end;
    long ms = strtol(what, &end, 10);
    if (end != what && !*end)
        wait_for(script, WAIT_TIME, (guint)CLAMP(ms, 0, WAIT_MOST_MS));
    else if (strcmp(what, "scene") == 0)
        wait_for(script, WAIT_SCENE, WAIT_MOST_MS);
    else if (strcmp(what, "full") == 0)
        wait_for(script, WAIT_FULL, WAIT_MOST_MS);
    else if (strcmp(what, "rest") == 0)
        wait_for(script, WAIT_REST, WAIT_MOST_MS);
    else
        return false;
    if (script->app->failed && !script->app->scene)
        fail(script, "the scene did not open");
    return true;
}

static enum answer answer(struct view_script *script, bool yes, const char *found)
{
    g_strlcpy(script->found, found, sizeof(script->found));
    return yes ? ANSWER_YES : ANSWER_NO;
}

/* Whether something is so; what it is instead stays in the script. */
static enum answer ask(struct view_script *script, const char *what, const char *text)
{
    struct view_app *app = script->app;
    const char *info = view_window_info(app->window);
    if (strcmp(what, "method") == 0 || strcmp(what, "second") == 0) {
        int side = what[0] == 's';
        const char *name =
            side && !app->state.compare ? "off" : app->state.methods[side].info->name;
        return answer(script, strcmp(name, text) == 0, name);
    }
    if (strcmp(what, "window") == 0 || strcmp(what, "headless") == 0) {
        bool own = app->frame && app->frame->window[atoi(text)];
        return answer(script, own == (what[0] == 'w'), info);
    }
    if (strcmp(what, "info") == 0)
        return answer(script, strstr(info, text) != NULL, info);
    if (strcmp(what, "readout") == 0) {
        const char *readout = view_window_readout(app->window);
        return answer(script, strstr(readout, text) != NULL, readout);
    }
    if (strcmp(what, "scene") == 0) {
        const char *name = app->scene ? app->scene->name : "";
        return answer(script, strstr(name, text) && shown_now(app), name);
    }
    if (strcmp(what, "focus") == 0) {
        const char *name = view_focus_now(GTK_WINDOW(view_window_widget(app->window)));
        return answer(script, strcmp(name, text) == 0, name);
    }
    if (strcmp(what, "moved") == 0 || strcmp(what, "still") == 0) {
        vec3 place;
        if (!view_app_pick_place(app, app->pick, &place))
            return ANSWER_UNKNOWN;
        bool moved = v3_length(v3_sub(place, script->mark)) > 1e-6 * app->scene->radius;
        bool yes = moved == (what[0] == 'm');
        if (yes)
            script->mark = place;
        return answer(script, yes, moved ? "it has moved" : "it has not moved");
    }
    return ANSWER_UNKNOWN;
}

static bool do_expect(struct view_script *script, const char *what, const char *text)
{
    g_free(script->wanted);
    script->wanted = g_strdup(text);
    if (strcmp(what, "banner") == 0) {
        wait_for(script, WAIT_BANNER, 10000);
        return true;
    }
    if (strcmp(what, "no-banner") == 0) {
        wait_for(script, WAIT_NO_BANNER, 10000);
        return true;
    }
    if (strcmp(what, "progress") == 0) {
        wait_for(script, WAIT_PROGRESS, 20000);
        return true;
    }
    enum answer found = ask(script, what, text);
    if (found == ANSWER_NO)
        fail(script, script->found);
    return found != ANSWER_UNKNOWN;
}

static gboolean on_poll(gpointer data)
{
    view_script_notify(data);
    return G_SOURCE_CONTINUE;
}

/* As expect, but until it is so. */
static bool do_await(struct view_script *script, const char *what, const char *text)
{
    g_free(script->wanted);
    g_free(script->asked);
    script->wanted = g_strdup(text);
    script->asked = g_strdup(what);
    script->poll = g_timeout_add(50, on_poll, script);
    wait_for(script, WAIT_ANSWER, 30000);
    return true;
}

static bool do_param(struct view_app *app, const char *text)
{
    struct view_method *method = &app->state.methods[0];
    const char *equals = strchr(text, '=');
    for (size_t i = 0; equals && i < method->info->param_count; i++) {
        const char *key = method->info->params[i].key;
        if (strlen(key) != (size_t)(equals - text) || strncmp(key, text, strlen(key)) != 0)
            continue;
        g_free(method->values[i]);
        method->values[i] = g_strdup(equals + 1);
        view_app_changed(app);
        return true;
    }
    return false;
}

static bool do_select(struct view_script *script, const char *kind, const char *name)
{
    struct view_app *app = script->app;
    size_t index = (size_t)strtol(name, NULL, 10);
    bool light = strcmp(kind, "light") == 0;
    for (size_t i = 0; !light && i < app->scene->object_count; i++)
        if (strcmp(app->scene->objects[i].name, name) == 0)
            index = i;
    if (!light && (name[0] < '0' || name[0] > '9') &&
        (index >= app->scene->object_count || strcmp(app->scene->objects[index].name, name) != 0))
        return false;
    view_app_select(app, light ? VIEW_PICK_LIGHT : VIEW_PICK_OBJECT, index);
    return view_app_pick_place(app, app->pick, &script->mark);
}

static bool do_drag(struct view_script *script, const char *what)
{
    enum view_measure_what kind = strcmp(what, "object") == 0    ? VIEW_MEASURE_OBJECT
                                  : strcmp(what, "camera") == 0  ? VIEW_MEASURE_CAMERA
                                  : strcmp(what, "nothing") == 0 ? VIEW_MEASURE_NOTHING
                                                                 : VIEW_MEASURE_LIGHT;
    script->measure = view_measure_begin(script->app, kind, script->app->options->frames);
    if (!script->measure)
        return false;
    wait_for(script, WAIT_DRAG, (guint)MIN(4000.0 * script->app->options->frames + 60000, 1e9));
    return true;
}

static bool do_pointer(struct view_script *script, const char *command, char **words)
{
    struct view_app *app = script->app;
    ViewCanvas *canvas = view_window_canvas(app->window);
    static const GdkModifierType no_mods = 0;
    double *at = g_object_get_data(G_OBJECT(canvas), "script-pointer");
    if (!at) {
        at = g_new0(double, 2);
        g_object_set_data_full(G_OBJECT(canvas), "script-pointer", at, g_free);
    }
    if (strcmp(command, "release") == 0) {
        view_canvas_release(canvas);
        return true;
    }
    if (!words[1])
        return false;
    int handle = handle_named(words[1]);
    if (handle != VIEW_HANDLE_NONE) {
        if (!view_canvas_find_handle(canvas, handle, &at[0], &at[1]))
            return false;
    } else if (words[2]) {
        bool by = strcmp(command, "move-by") == 0;
        at[0] = (by ? at[0] : 0) + g_ascii_strtod(words[1], NULL);
        at[1] = (by ? at[1] : 0) + g_ascii_strtod(words[2], NULL);
    } else {
        return false;
    }
    if (strcmp(command, "press") == 0) {
        view_app_pick_place(app, app->pick, &script->mark);
        view_canvas_press(canvas, at[0], at[1], GDK_BUTTON_PRIMARY, no_mods);
    } else if (strcmp(command, "click") == 0) {
        view_canvas_motion(canvas, at[0], at[1], no_mods);
        view_canvas_press(canvas, at[0], at[1], GDK_BUTTON_PRIMARY, no_mods);
        view_canvas_release(canvas);
    } else {
        view_canvas_motion(canvas, at[0], at[1], no_mods);
    }
    return true;
}

/* Where a handle is on the screen, if the window lies in its corner. */
static bool do_where(struct view_app *app, const char *name)
{
    GtkWidget *canvas = GTK_WIDGET(view_window_canvas(app->window));
    GtkWidget *window = view_window_widget(app->window);
    double x, y, left, top;
    if (!view_canvas_find_handle(VIEW_CANVAS(canvas), handle_named(name), &x, &y) ||
        !gtk_widget_translate_coordinates(canvas, window, x, y, &x, &y))
        return false;
    gtk_native_get_surface_transform(GTK_NATIVE(window), &left, &top);
    printf("%s %.0f %.0f\n", name, x + left, y + top);
    fflush(stdout);
    return true;
}

static bool do_method(struct view_app *app, int side, const char *name)
{
    if (side == 1) {
        app->state.compare = strcmp(name, "off") != 0;
        if (!app->state.compare) {
            view_app_changed(app);
            return true;
        }
    }
    const pnb_method_info *info = pnb_method_find(name);
    if (!info)
        return false;
    view_app_set_method(app, side, info);
    view_app_changed(app);
    return true;
}

static bool do_show(struct view_app *app, const char *name)
{
    return gtk_widget_activate_action(view_window_widget(app->window), "win.show", "s", name);
}

static bool do_light_shape(struct view_app *app, const char *name)
{
    int shape = shape_named(name);
    if (shape < 0 || app->state.light >= app->state.light_count)
        return false;
    struct view_light *light = &app->state.lights[app->state.light];
    struct view_frame_axes axes =
        view_light_axes(light, view_app_middle(app), view_app_sun_distance(app));
    view_light_reshape(light, (pnb_light_type)shape, &axes, view_app_smallest(app));
    view_app_changed(app);
    return true;
}

static bool do_file(struct view_script *script, const char *command, const char *path)
{
    struct view_app *app = script->app;
    script->failed = script->saved = false;
    script->old_scene = app->scene ? app->scene->id : 0;
    if (strcmp(command, "open") == 0 || strcmp(command, "drop") == 0) {
        wait_for(script, WAIT_OPENED, WAIT_MOST_MS);
        if (command[0] == 'o')
            view_app_open(app, path);
        else
            view_window_drop(app->window, path);
        return true;
    }
    if (strcmp(command, "window") == 0) {
        script->picture = g_strdup(path);
        wait_for(script, WAIT_TIME, 60);
        return true;
    }
    wait_for(script, WAIT_SAVED, WAIT_MOST_MS);
    if (strcmp(command, "save") == 0)
        view_app_save(app, path);
    else if (strcmp(command, "shown") == 0)
        view_app_shot_as_shown(app, path);
    else
        view_app_screenshot(app, path);
    return true;
}

/* words[0] is the command; rest is what follows it. */
static bool run_command(struct view_script *script, char **words, const char *rest)
{
    struct view_app *app = script->app;
    ViewCanvas *canvas = view_window_canvas(app->window);
    const char *command = words[0], *one = words[1] ? words[1] : "";
    const char *two = words[1] && words[2] ? words[2] : "";
    static const char *const files[] = {"open",  "drop",   "save", "screenshot",
                                        "shown", "window", NULL};
    static const char *const pointer[] = {"point",   "press", "move", "move-by",
                                          "release", "click", NULL};
    if (g_strv_contains(files, command))
        return do_file(script, command, rest);
    if (g_strv_contains(pointer, command))
        return do_pointer(script, command, words);
    if (strcmp(command, "wait") == 0)
        return do_wait(script, one);
    if (strcmp(command, "expect") == 0 || strcmp(command, "await") == 0) {
        const char *text = *rest ? rest + strlen(one) + (rest[strlen(one)] == ' ') : "";
        return command[0] == 'e' ? do_expect(script, one, text) : do_await(script, one, text);
    }
    if (strcmp(command, "method") == 0 || strcmp(command, "second") == 0)
        return do_method(app, command[0] == 's', one);
    if (strcmp(command, "samples") == 0) {
        app->state.methods[0].samples = atoi(one);
        view_app_changed(app);
        return true;
    }
    if (strcmp(command, "truth") == 0) {
        app->state.truth_samples = atoi(one);
        view_app_changed(app);
        return true;
    }
    if (strcmp(command, "patience") == 0) {
        app->state.patience_ms = atoi(one);
        view_app_changed(app);
        return true;
    }
    if (strcmp(command, "param") == 0)
        return do_param(app, one);
    if (strcmp(command, "show") == 0)
        return do_show(app, one);
    if (strcmp(command, "divider") == 0) {
        view_canvas_divide(canvas, g_ascii_strtod(one, NULL));
        return true;
    }
    if (strcmp(command, "page") == 0) {
        view_window_page(app->window, one);
        return true;
    }
    if (strcmp(command, "theme") == 0) {
        gtk_widget_activate_action(view_window_widget(app->window), "win.theme", "s", one);
        return true;
    }
    if (strcmp(command, "select") == 0 && app->scene)
        return do_select(script, one, *two ? rest + strlen(one) + 1 : "0");
    if (strcmp(command, "add-light") == 0 && shape_named(one) >= 0) {
        view_app_add_light(app, (pnb_light_type)shape_named(one));
        return true;
    }
    if (strcmp(command, "remove-light") == 0) {
        view_app_remove_light(app, app->state.light);
        return true;
    }
    if (strcmp(command, "shape") == 0)
        return do_light_shape(app, one);
    if (strcmp(command, "step") == 0) {
        view_canvas_step(canvas, atoi(one), atoi(two), 0);
        return true;
    }
    if (strcmp(command, "zoom") == 0) {
        view_canvas_zoom(canvas, g_ascii_strtod(one, NULL));
        return true;
    }
    if (strcmp(command, "action") == 0)
        return gtk_widget_activate_action(view_window_widget(app->window), one, NULL);
    if (strcmp(command, "drag") == 0)
        return do_drag(script, one);
    if (strcmp(command, "where") == 0)
        return do_where(app, one);
    if (strcmp(command, "tab") == 0) {
        char why[200];
        if (!view_focus_walk(GTK_WINDOW(view_window_widget(app->window)), GTK_WIDGET(canvas), why,
                             sizeof(why)))
            fail(script, why);
        return true;
    }
    if (strcmp(command, "say") == 0) {
        printf("%s\n", rest);
        fflush(stdout);
        return true;
    }
    if (strcmp(command, "play") == 0) {
        view_motion_start(app->motion);
        return view_motion_running(app->motion);
    }
    if (strcmp(command, "stop") == 0) {
        view_motion_stop(app->motion);
        view_app_stop(app);
        return true;
    }
    if (strcmp(command, "print") == 0) {
        print_results(script);
        return true;
    }
    return false;
}

static void run(struct view_script *script)
{
    while (!script->done && script->wait == WAIT_NONE) {
        const char *line = script->lines[script->next];
        if (!line || strcmp(g_strstrip(script->lines[script->next]), "quit") == 0) {
            finish(script);
            return;
        }
        script->next++;
        if (!*line || *line == '#')
            continue;
        char **words = g_strsplit_set(line, " \t", 6);
        const char *rest = line + strlen(words[0]);
        rest += strspn(rest, " \t");
        if (!run_command(script, words, rest))
            fail(script, "cannot be done");
        g_strfreev(words);
    }
    /* It may hold already. */
    view_script_notify(script);
}

/* ---- life ---- */

static gboolean on_begin(gpointer data)
{
    struct view_script *script = data;
    script->idle = 0;
    run(script);
    return G_SOURCE_REMOVE;
}

struct view_script *view_script_create(struct view_app *app)
{
    const char *name = app->options->script;
    char *text = NULL;
    GError *error = NULL;
    if (!name)
        return NULL;
    for (gsize i = 0; i < G_N_ELEMENTS(builtin_scripts); i++)
        if (strcmp(name, builtin_scripts[i].name) == 0)
            text = g_strdup(builtin_scripts[i].text);
    struct view_script *script = g_new0(struct view_script, 1);
    script->app = app;
    script->results = g_string_new(NULL);
    if (!text && !g_file_get_contents(name, &text, NULL, &error)) {
        view_complain(name, error->message);
        g_error_free(error);
        app->exit_status = 1;
        text = g_strdup("");
    }
    script->lines = g_strsplit(text, "\n", -1);
    g_free(text);
    script->idle = g_idle_add(on_begin, script);
    return script;
}

void view_script_destroy(struct view_script *script)
{
    if (!script)
        return;
    if (script->timer)
        g_source_remove(script->timer);
    if (script->idle)
        g_source_remove(script->idle);
    if (script->poll)
        g_source_remove(script->poll);
    view_measure_destroy(script->measure);
    g_free(script->picture);
    g_string_free(script->results, TRUE);
    g_strfreev(script->lines);
    g_free(script->wanted);
    g_free(script->asked);
    g_free(script);
}
