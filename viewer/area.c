/* viewer/area.c: the GtkGLArea, and what passes between its context and the worker.
 *
 * A frame is drawn when GTK asks for it, in the window's thread; the worker hears what it took, and
 * at rest gets the visibility, which the error's figures want. Desktop OpenGL 3.3 is asked for
 * first, then ES 3.2. Where neither is to be had the worker does the method without a window.
 */
#include "area.h"

#include "gpu.h"

struct view_area {
    struct view_app *app;
    GtkWidget *canvas, *gl;
    struct view_gpu *gpu;
    struct view_frame *frame;
    bool fresh; /* not drawn yet */
    bool tried;
    char why[200];
};

/* The frame's sides, if they are not drawn yet; the context is current. */
static void draw(struct view_area *area)
{
    struct view_app *app = area->app;
    struct view_frame *frame = area->frame;
    struct view_drawn drawn;
    if (!area->fresh)
        return;
    bool good = view_gpu_draw(area->gpu, app->scene, frame, &drawn);
    area->fresh = false;
    frame->window_ms = drawn.ms;
    frame->drawn = true;
    drawn.ms += frame->worker_ms;
    view_worker_drawn(app->worker, &drawn);
    for (int side = 0; side < VIEW_SIDES && good && frame->full && !frame->moving; side++)
        if (frame->window[side])
            view_worker_given(app->worker, frame, side);
}

static gboolean on_render(GtkGLArea *gl, GdkGLContext *context, gpointer data)
{
    struct view_area *area = data;
    struct view_app *app = area->app;
    struct view_frame *frame = area->frame;
    int scale = gtk_widget_get_scale_factor(GTK_WIDGET(gl));
    if (!area->gpu || !frame || !app->scene || frame->scene_id != app->scene->id)
        return TRUE;
    draw(area);
    gtk_gl_area_attach_buffers(gl);
    view_gpu_show(area->gpu, frame, app->divider, gtk_widget_get_width(GTK_WIDGET(gl)) * scale,
                  gtk_widget_get_height(GTK_WIDGET(gl)) * scale);
    return TRUE;
}

static void drop_gpu(struct view_area *area)
{
    if (!area->gpu)
        return;
    gtk_gl_area_make_current(GTK_GL_AREA(area->gl));
    g_clear_pointer(&area->gpu, view_gpu_destroy);
}

static void on_unrealize(GtkWidget *gl, gpointer data)
{
    struct view_area *area = data;
    drop_gpu(area);
    area->tried = false; /* on another screen it may go otherwise */
}

static void drop_widget(struct view_area *area)
{
    GtkWidget *gl = area->gl;
    if (!gl)
        return;
    drop_gpu(area);
    area->gl = NULL;
    g_signal_handlers_disconnect_by_data(gl, area);
    gtk_widget_unparent(gl);
}

static bool try_context(struct view_area *area, bool es)
{
    area->gl = gtk_gl_area_new();
    GtkGLArea *gl = GTK_GL_AREA(area->gl);
    gtk_gl_area_set_use_es(gl, es);
    gtk_gl_area_set_required_version(gl, 3, es ? 2 : 3);
    gtk_gl_area_set_auto_render(gl, FALSE);
    gtk_widget_set_can_target(area->gl, FALSE);
    gtk_widget_set_can_focus(area->gl, FALSE);
    g_signal_connect(gl, "render", G_CALLBACK(on_render), area);
    g_signal_connect(gl, "unrealize", G_CALLBACK(on_unrealize), area);
    gtk_widget_insert_before(area->gl, area->canvas, gtk_widget_get_first_child(area->canvas));
    if (!gtk_widget_get_realized(area->gl))
        gtk_widget_realize(area->gl);
    gtk_gl_area_make_current(gl);
    const GError *error = gtk_gl_area_get_error(gl);
    GdkGLContext *context = gtk_gl_area_get_context(gl);
    if (error || !context)
        g_strlcpy(area->why, error ? error->message : "the window has no OpenGL",
                  sizeof(area->why));
    else
        area->gpu =
            view_gpu_create(gdk_gl_context_get_use_es(context), area->why, sizeof(area->why));
    if (area->gpu) {
        area->why[0] = 0;
        view_area_allocate(area, gtk_widget_get_width(area->canvas),
                           gtk_widget_get_height(area->canvas));
        return true;
    }
    drop_widget(area);
    return false;
}

bool view_area_ready(struct view_area *area)
{
    if (area->tried || !gtk_widget_get_realized(area->canvas))
        return area->gpu != NULL;
    area->tried = true;
    return try_context(area, false) || try_context(area, true);
}

const char *view_area_why_not(const struct view_area *area)
{
    return area->why;
}

struct view_area *view_area_create(struct view_app *app, GtkWidget *canvas)
{
    struct view_area *area = g_new0(struct view_area, 1);
    area->app = app;
    area->canvas = canvas;
    return area;
}

void view_area_destroy(struct view_area *area)
{
    drop_widget(area);
    view_frame_unref(area->frame);
    g_free(area);
}

GtkWidget *view_area_widget(struct view_area *area)
{
    return area->gl;
}

void view_area_allocate(struct view_area *area, int width, int height)
{
    int unused;
    if (!area->gl || width < 1 || height < 1)
        return;
    gtk_widget_measure(area->gl, GTK_ORIENTATION_HORIZONTAL, -1, &unused, NULL, NULL, NULL);
    gtk_widget_allocate(area->gl, width, height, -1, NULL);
    gtk_gl_area_queue_render(GTK_GL_AREA(area->gl));
}

void view_area_set_frame(struct view_area *area, struct view_frame *frame)
{
    view_frame_unref(area->frame);
    area->frame = view_frame_ref(frame);
    area->fresh = true;
    view_area_queue(area);
}

void view_area_queue(struct view_area *area)
{
    if (area->gl)
        gtk_gl_area_queue_render(GTK_GL_AREA(area->gl));
}

bool view_area_read(struct view_area *area, struct view_frame *frame)
{
    struct view_app *app = area->app;
    if (!area->gpu || area->frame != frame || !app->scene || frame->scene_id != app->scene->id)
        return false;
    gtk_gl_area_make_current(GTK_GL_AREA(area->gl));
    draw(area);
    view_gpu_read(area->gpu, frame);
    return true;
}
