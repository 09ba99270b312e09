/* viewer/measure.c: a measured drag.
 *
 * The pointer moves at every tick, as under a hand, along an ellipse round the place where it was
 * pressed. A frame's time is that from one new frame on the screen to the next; its lag, that from
 * the pointer's motion to the screen.
 */
#include "measure.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "canvas.h"
#include "handles.h"
#include "window.h"

struct view_measure {
    struct view_app *app;
    enum view_measure_what what;
    int wanted;
    double x, y; /* where the pointer was pressed */
    guint tick;
    int ticks;
    unsigned shown; /* the canvas's count */
    int64_t last_us;
    GArray *times, *lags;                      /* milliseconds */
    double update, primary, visibility, shade; /* sums, milliseconds */
    int full, least_width, least_height;
    long resident_begin, resident_end, resident_most;
    bool done;
};

long view_resident_kb(void)
{
    long total = 0, resident = 0;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file && fscanf(file, "%ld %ld", &total, &resident) != 2)
        resident = 0;
    if (file)
        fclose(file);
    return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

static gboolean on_tick(GtkWidget *widget, GdkFrameClock *clock, gpointer data)
{
    struct view_measure *measure = data;
    double phase = 2 * M_PI * ++measure->ticks / 150.0;
    ViewCanvas *canvas = view_window_canvas(measure->app->window);
    view_canvas_motion(canvas, measure->x + 90 * sin(phase), measure->y + 45 * (1 - cos(phase)), 0);
    return G_SOURCE_CONTINUE;
}

/* The first object that casts and is no plane. */
static bool select_object(struct view_app *app)
{
    for (size_t i = 0; i < app->scene->object_count; i++)
        if (app->scene->objects[i].casts && !app->scene->objects[i].plane) {
            view_app_select(app, VIEW_PICK_OBJECT, i);
            return true;
        }
    return false;
}

struct view_measure *view_measure_begin(struct view_app *app, enum view_measure_what what,
                                        int frames)
{
    ViewCanvas *canvas = view_window_canvas(app->window);
    double x = 20, y = 20;
    bool good = app->scene != NULL;
    if (good && what == VIEW_MEASURE_LIGHT) {
        view_app_select(app, VIEW_PICK_LIGHT, app->state.light);
        good = app->pick.type == VIEW_PICK_LIGHT;
    } else if (good && what == VIEW_MEASURE_OBJECT) {
        good = select_object(app);
    }
    if (good && what != VIEW_MEASURE_CAMERA)
        good = view_canvas_find_handle(canvas, VIEW_HANDLE_MOVE, &x, &y);
    if (!good)
        return NULL;
    struct view_measure *measure = g_new0(struct view_measure, 1);
    measure->app = app;
    measure->what = what;
    measure->wanted = frames;
    measure->x = x;
    measure->y = y;
    measure->times = g_array_new(FALSE, FALSE, sizeof(double));
    measure->lags = g_array_new(FALSE, FALSE, sizeof(double));
    measure->shown = view_canvas_get_shown(canvas).count;
    view_canvas_press(canvas, x, y, GDK_BUTTON_PRIMARY, 0);
    measure->tick =
        gtk_widget_add_tick_callback(view_window_widget(app->window), on_tick, measure, NULL);
    return measure;
}

static void stop_ticking(struct view_measure *measure)
{
    if (measure->tick)
        gtk_widget_remove_tick_callback(view_window_widget(measure->app->window), measure->tick);
    measure->tick = 0;
}

static void end_drag(struct view_measure *measure)
{
    stop_ticking(measure);
    measure->done = true;
    measure->resident_end = view_resident_kb();
    view_canvas_release(view_window_canvas(measure->app->window));
}

bool view_measure_painted(struct view_measure *measure, int64_t now_us)
{
    struct view_canvas_shown shown =
        view_canvas_get_shown(view_window_canvas(measure->app->window));
    if (measure->done || shown.count == measure->shown)
        return measure->done;
    measure->shown = shown.count;
    if (measure->last_us) {
        double ms = (double)(now_us - measure->last_us) * 1e-3;
        double lag = (double)(now_us - shown.wanted_us) * 1e-3;
        const struct view_times *t = &measure->app->frame->times;
        g_array_append_val(measure->times, ms);
        g_array_append_val(measure->lags, lag);
        measure->update += t->update;
        measure->primary += t->primary;
        measure->visibility += t->visibility[0] + t->visibility[1];
        measure->shade += t->shade;
        measure->full += shown.full;
        if (!measure->least_width || shown.width < measure->least_width) {
            measure->least_width = shown.width;
            measure->least_height = shown.height;
        }
        long resident = view_resident_kb();
        measure->resident_most = MAX(measure->resident_most, resident);
        if ((int)measure->times->len == MAX(1, measure->wanted / 10))
            measure->resident_begin = resident;
    }
    measure->last_us = now_us;
    if ((int)measure->times->len >= measure->wanted)
        end_drag(measure);
    return measure->done;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double share_of(GArray *values, double share)
{
    if (values->len == 0)
        return 0;
    guint index = (guint)(share * (values->len - 1) + 0.5);
    return g_array_index(values, double, index);
}

struct figures {
    double frames, mean, median, p99, most, lag_median, lag_p99;
};

static struct figures figures_of(const struct view_measure *measure)
{
    struct figures out = {.frames = measure->times->len};
    g_array_sort(measure->times, by_value);
    g_array_sort(measure->lags, by_value);
    for (guint i = 0; i < measure->times->len; i++)
        out.mean += g_array_index(measure->times, double, i) / out.frames;
    out.median = share_of(measure->times, 0.5);
    out.p99 = share_of(measure->times, 0.99);
    out.most = share_of(measure->times, 1);
    out.lag_median = share_of(measure->lags, 0.5);
    out.lag_p99 = share_of(measure->lags, 0.99);
    return out;
}

static const char *const what_names[] = {"light", "object", "camera"};

char *view_measure_json(const struct view_measure *measure)
{
    const struct view_app *app = measure->app;
    struct figures f = figures_of(measure);
    double n = fmax(f.frames, 1);
    return g_strdup_printf(
        "{\"drag\": \"%s\", \"method\": \"%s\", \"width\": %d, \"height\": %d, \"frames\": %.0f, "
        "\"frames_per_second\": %.2f, \"milliseconds\": {\"median\": %.2f, \"mean\": %.2f, "
        "\"p99\": %.2f, \"most\": %.2f}, \"lag_milliseconds\": {\"median\": %.2f, \"p99\": %.2f}, "
        "\"stages\": {\"update\": %.2f, \"surface\": %.2f, \"visibility\": %.2f, \"shade\": %.2f}, "
        "\"frames_of_all_pixels\": %d, \"least_width\": %d, \"least_height\": %d, "
        "\"resident_kb\": {\"begin\": %ld, \"end\": %ld, \"most\": %ld}}",
        what_names[measure->what], app->state.methods[0].info->name, app->state.width,
        app->state.height, f.frames, f.mean > 0 ? 1000 / f.mean : 0, f.median, f.mean, f.p99,
        f.most, f.lag_median, f.lag_p99, measure->update / n, measure->primary / n,
        measure->visibility / n, measure->shade / n, measure->full, measure->least_width,
        measure->least_height, measure->resident_begin, measure->resident_end,
        measure->resident_most);
}

char *view_measure_text(const struct view_measure *measure)
{
    struct figures f = figures_of(measure);
    return g_strdup_printf(
        "drag %s: %.0f frames, %.1f a second; ms a frame: median %.1f, 99 %% below %.1f, most "
        "%.1f; lag: median %.1f, 99 %% below %.1f; %.0f %% with all pixels, least %dx%d; memory "
        "%ld to %ld MB",
        what_names[measure->what], f.frames, f.mean > 0 ? 1000 / f.mean : 0, f.median, f.p99,
        f.most, f.lag_median, f.lag_p99, 100.0 * measure->full / fmax(f.frames, 1),
        measure->least_width, measure->least_height, measure->resident_begin / 1024,
        measure->resident_end / 1024);
}

void view_measure_destroy(struct view_measure *measure)
{
    if (!measure)
        return;
    stop_ticking(measure);
    g_array_free(measure->times, TRUE);
    g_array_free(measure->lags, TRUE);
    g_free(measure);
}
