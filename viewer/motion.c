/* viewer/motion.c: moves a light or object along a path through where it stood.
 *
 * The place is a function of the time alone, so a slow method shows fewer places, not a slower
 * motion. What moves takes steps from its last place; a hand that drags it meanwhile drags its path
 * along.
 */
#include "motion.h"

#include "window.h"

struct view_motion {
    struct view_app *app;
    struct view_motion_settings settings;
    struct view_pick pick;
    vec3 offset; /* from the path's origin, now */
    int64_t started_us;
    guint tick;
};

struct view_motion *view_motion_create(struct view_app *app)
{
    struct view_motion *motion = g_new0(struct view_motion, 1);
    motion->app = app;
    motion->settings = (struct view_motion_settings){VIEW_PATH_CIRCLE, 0.4, 6};
    return motion;
}

void view_motion_destroy(struct view_motion *motion)
{
    if (motion && motion->tick)
        gtk_widget_remove_tick_callback(view_window_widget(motion->app->window), motion->tick);
    g_free(motion);
}

struct view_motion_settings *view_motion_settings(struct view_motion *motion)
{
    return &motion->settings;
}

const char *view_path_name(enum view_path path)
{
    static const char *const names[VIEW_PATH_COUNT] = {"Circle", "To and fro", "Figure of eight",
                                                       "Up and down"};
    return names[path];
}

bool view_motion_running(const struct view_motion *motion)
{
    return motion->tick != 0;
}

struct view_pick view_motion_pick(const struct view_motion *motion)
{
    return motion->tick ? motion->pick : motion->app->pick;
}

/* Offset at a phase in radians; zero at phase 0. */
static vec3 path_at(enum view_path path, double phase, double size)
{
    switch (path) {
    case VIEW_PATH_CIRCLE: return v3(size * (cos(phase) - 1), 0, size * sin(phase));
    case VIEW_PATH_LINE: return v3(size * sin(phase), 0, 0);
    case VIEW_PATH_EIGHT: return v3(size * sin(phase), 0, 0.5 * size * sin(2 * phase));
    case VIEW_PATH_RISE: return v3(0, 0.5 * size * sin(phase), 0);
    }
    return v3(0, 0, 0);
}

static void go_to(struct view_motion *motion, vec3 offset)
{
    vec3 by = v3_sub(offset, motion->offset);
    motion->offset = offset;
    view_app_pick_move(motion->app, motion->pick, by);
}

static gboolean on_tick(GtkWidget *widget, GdkFrameClock *clock, gpointer data)
{
    struct view_motion *motion = data;
    double seconds = (double)(gdk_frame_clock_get_frame_time(clock) - motion->started_us) * 1e-6;
    double phase = 2 * M_PI * fmax(seconds, 0) / motion->settings.period;
    go_to(motion, path_at(motion->settings.path, phase,
                          motion->settings.size * motion->app->scene->radius));
    view_app_changed(motion->app);
    return G_SOURCE_CONTINUE;
}

void view_motion_start(struct view_motion *motion)
{
    GtkWidget *widget = view_window_widget(motion->app->window);
    if (motion->tick || !motion->app->scene || motion->app->pick.type == VIEW_PICK_NONE)
        return;
    motion->pick = motion->app->pick;
    motion->offset = v3(0, 0, 0);
    motion->started_us = gdk_frame_clock_get_frame_time(gtk_widget_get_frame_clock(widget));
    motion->tick = gtk_widget_add_tick_callback(widget, on_tick, motion, NULL);
    view_app_set_moving(motion->app, VIEW_MOVING_MOTION, true);
    view_window_refresh(motion->app->window);
}

void view_motion_stop(struct view_motion *motion)
{
    if (!motion->tick)
        return;
    gtk_widget_remove_tick_callback(view_window_widget(motion->app->window), motion->tick);
    motion->tick = 0;
    view_app_set_moving(motion->app, VIEW_MOVING_MOTION, false);
    view_window_refresh(motion->app->window);
}

void view_motion_forget(struct view_motion *motion)
{
    motion->offset = v3(0, 0, 0);
}

void view_motion_rewind(struct view_motion *motion)
{
    bool ran = motion->tick != 0;
    view_motion_stop(motion);
    if (!ran && (motion->pick.type != motion->app->pick.type ||
                 motion->pick.index != motion->app->pick.index))
        return;
    go_to(motion, v3(0, 0, 0));
    view_app_changed(motion->app);
}
