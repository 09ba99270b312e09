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
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "canvas.h"
#include "handles.h"
#include "window.h"

enum { TENTHS = 10 };

/* Of the process, in kilobytes: pages in memory; those of them that belong to no file and are not
 * shared with the X server; and what malloc() has given out and not had back, which does not grow
 * where nothing is lost. */
struct memory {
    int frame;
    long resident, anonymous, heap;
};

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
    long resident_most;
    struct memory memory[TENTHS + 1]; /* [0]: after the first hundredth */
    int memory_count;
    bool done;
};

static struct memory memory_now(int frame)
{
    struct memory memory = {.frame = frame};
    long total = 0, resident = 0, shared = 0, page_kb = sysconf(_SC_PAGESIZE) / 1024;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file && fscanf(file, "%ld %ld %ld", &total, &resident, &shared) != 3)
        resident = shared = 0;
    if (file)
        fclose(file);
    memory.resident = resident * page_kb;
    memory.anonymous = (resident - shared) * page_kb;
#ifdef __GLIBC__
    struct mallinfo2 info = mallinfo2();
    memory.heap = (long)((info.uordblks + info.hblkhd) / 1024);
#endif
    return memory;
}

long view_resident_kb(void)
{
    return memory_now(0).resident;
}

static gboolean on_tick(GtkWidget *widget, GdkFrameClock *clock, gpointer data)
{
    struct view_measure *measure = data;
    double phase = 2 * M_PI * ++measure->ticks / 150.0;
    ViewCanvas *canvas = view_window_canvas(measure->app->window);
    if (measure->what == VIEW_MEASURE_NOTHING) {
        gtk_widget_queue_draw(GTK_WIDGET(canvas));
        return G_SOURCE_CONTINUE;
    }
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
    if (good && (what == VIEW_MEASURE_LIGHT || what == VIEW_MEASURE_OBJECT))
        good = view_canvas_find_handle(canvas, VIEW_HANDLE_MOVE, &x, &y);
    if (!good)
        return NULL;
    struct view_measure *measure = g_new0(struct view_measure, 1);
    measure->app = app;
    measure->what = what;
    measure->wanted = frames;
    measure->x = x;
    measure->y = y;
    /* All of it now and written to, so that what grows later is not the measure. */
    guint room = (guint)MIN(frames + 1, 1 << 20);
    measure->times = g_array_sized_new(FALSE, TRUE, sizeof(double), room);
    measure->lags = g_array_sized_new(FALSE, TRUE, sizeof(double), room);
    g_array_set_size(g_array_set_size(measure->times, room), 0);
    g_array_set_size(g_array_set_size(measure->lags, room), 0);
    measure->shown = view_canvas_get_shown(canvas).count;
    if (what != VIEW_MEASURE_NOTHING)
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
    if (measure->what != VIEW_MEASURE_NOTHING)
        view_canvas_release(view_window_canvas(measure->app->window));
}

static void note_memory(struct view_measure *measure)
{
    int frame = (int)measure->times->len, next = measure->memory_count;
    struct memory memory = memory_now(frame);
    measure->resident_most = MAX(measure->resident_most, memory.resident);
    int due = next == 0 ? measure->wanted / 100 : (int)((long long)measure->wanted * next / TENTHS);
    if (next <= TENTHS && frame >= MAX(due, 1))
        measure->memory[measure->memory_count++] = memory;
}

bool view_measure_painted(struct view_measure *measure, int64_t now_us)
{
    struct view_canvas_shown shown =
        view_canvas_get_shown(view_window_canvas(measure->app->window));
    if (measure->done || (shown.count == measure->shown && measure->what != VIEW_MEASURE_NOTHING))
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
        note_memory(measure);
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

static const char *const what_names[] = {"light", "object", "camera", "nothing"};

/* The first and the last of the drag. */
static void ends_of(const struct view_measure *measure, struct memory *begin, struct memory *end)
{
    *begin = *end = (struct memory){0};
    if (measure->memory_count == 0)
        return;
    *begin = measure->memory[MIN(1, measure->memory_count - 1)];
    *end = measure->memory[measure->memory_count - 1];
}

static char *memory_json(const struct view_measure *measure)
{
    GString *text = g_string_new(NULL);
    for (int i = 0; i < measure->memory_count; i++) {
        const struct memory *m = &measure->memory[i];
        g_string_append_printf(text,
                               "%s{\"frame\": %d, \"resident_kb\": %ld, \"anonymous_kb\": %ld, "
                               "\"heap_kb\": %ld}",
                               i ? ", " : "", m->frame, m->resident, m->anonymous, m->heap);
    }
    return g_string_free(text, FALSE);
}

char *view_measure_json(const struct view_measure *measure)
{
    const struct view_app *app = measure->app;
    struct figures f = figures_of(measure);
    double n = fmax(f.frames, 1);
    struct memory begin, end;
    ends_of(measure, &begin, &end);
    char *memory = memory_json(measure);
    char *json = g_strdup_printf(
        "{\"drag\": \"%s\", \"method\": \"%s\", \"width\": %d, \"height\": %d, \"frames\": %.0f, "
        "\"frames_per_second\": %.2f, \"milliseconds\": {\"median\": %.2f, \"mean\": %.2f, "
        "\"p99\": %.2f, \"most\": %.2f}, \"lag_milliseconds\": {\"median\": %.2f, \"p99\": %.2f}, "
        "\"stages\": {\"update\": %.2f, \"surface\": %.2f, \"visibility\": %.2f, \"shade\": %.2f}, "
        "\"frames_of_all_pixels\": %d, \"least_width\": %d, \"least_height\": %d, "
        "\"resident_kb\": {\"begin\": %ld, \"end\": %ld, \"most\": %ld}, \"memory\": [%s]}",
        what_names[measure->what], app->state.methods[0].info->name, app->state.width,
        app->state.height, f.frames, f.mean > 0 ? 1000 / f.mean : 0, f.median, f.mean, f.p99,
        f.most, f.lag_median, f.lag_p99, measure->update / n, measure->primary / n,
        measure->visibility / n, measure->shade / n, measure->full, measure->least_width,
        measure->least_height, begin.resident, end.resident, measure->resident_most, memory);
    g_free(memory);
    return json;
}

char *view_measure_text(const struct view_measure *measure)
{
    struct figures f = figures_of(measure);
    struct memory begin, end;
    ends_of(measure, &begin, &end);
    return g_strdup_printf(
        "drag %s: %.0f frames, %.1f a second; ms a frame: median %.1f, 99 %% below %.1f, most "
        "%.1f; lag: median %.1f, 99 %% below %.1f; %.0f %% with all pixels, least %dx%d; memory "
        "%.1f to %.1f MB, in use %.1f to %.1f MB",
        what_names[measure->what], f.frames, f.mean > 0 ? 1000 / f.mean : 0, f.median, f.p99,
        f.most, f.lag_median, f.lag_p99, 100.0 * measure->full / fmax(f.frames, 1),
        measure->least_width, measure->least_height, (double)begin.resident / 1024,
        (double)end.resident / 1024, (double)begin.heap / 1024, (double)end.heap / 1024);
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
