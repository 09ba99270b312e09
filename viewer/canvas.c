/* viewer/canvas.c: the picture, what lies over it, and the hand on it.
 *
 * A frame of fewer pixels is scaled up. Left of the divider lies the first side. Dragging a handle
 * moves what is selected, dragging elsewhere orbits, with the middle button or Shift it pans, and
 * the wheel zooms; a press without a drag selects the light or object below.
 */
#include "canvas.h"

#include <gsk/gskcairorenderer.h>
#include <string.h>

#include "area.h"
#include "focus.h"
#include "handles.h"
#include "window.h"

#define CLICK_PX       4.0
#define ORBIT_DEGREES  0.35 /* per pixel */
#define RESIZE_REST_MS 160

enum hand { HAND_NONE, HAND_GRAB, HAND_ORBIT, HAND_PAN, HAND_DIVIDER };

struct _ViewCanvas {
    GtkWidget parent_instance;
    struct view_app *app;
    struct view_frame *frame;
    struct view_area *area;           /* the sides that OpenGL draws here */
    GskRenderNode *nodes[VIEW_SIDES]; /* NULL: a side of the area's */
    bool made;                        /* the nodes are the frame's */
    bool cairo; /* GTK draws without OpenGL: the area's sides are read back for it */
    graphene_rect_t node_area;
    bool handles;
    struct view_canvas_shown shown;

    enum hand hand;
    double press_x, press_y, x, y;
    bool moved, inside;
    struct view_grab grab;
    struct view_handle hot;
    guint resize_timer;
};

G_DEFINE_TYPE(ViewCanvas, view_canvas, GTK_TYPE_WIDGET)

static struct view_lens lens_of(ViewCanvas *canvas)
{
    int width = gtk_widget_get_width(GTK_WIDGET(canvas));
    int height = gtk_widget_get_height(GTK_WIDGET(canvas));
    return view_lens_make(&canvas->app->state.camera, MAX(width, 1), MAX(height, 1));
}

/* ---- frames ---- */

/* GTK's cairo renderer takes textures through floating point, which costs more than the picture:
 * there the pixels are painted as they are. */
static GskRenderNode *paint_pixels(struct view_frame *frame, int side, const graphene_rect_t *all)
{
    GskRenderNode *node = gsk_cairo_node_new(all);
    cairo_t *cr = gsk_cairo_node_get_draw_context(node);
    cairo_surface_t *surface = cairo_image_surface_create_for_data(
        frame->bgra[side], CAIRO_FORMAT_RGB24, frame->width, frame->height, frame->width * 4);
    cairo_scale(cr, (double)all->size.width / frame->width,
                (double)all->size.height / frame->height);
    cairo_set_source_surface(cr, surface, 0, 0);
    cairo_pattern_set_filter(cairo_get_source(cr), CAIRO_FILTER_BILINEAR);
    cairo_pattern_set_extend(cairo_get_source(cr), CAIRO_EXTEND_PAD);
    cairo_paint(cr);
    cairo_destroy(cr);
    /* What the node has recorded is its own copy from here on. */
    cairo_surface_finish(surface);
    cairo_surface_destroy(surface);
    return node;
}

static GskRenderNode *make_texture(struct view_frame *frame, int side, const graphene_rect_t *all)
{
    gsize stride = (gsize)frame->width * 4;
    GBytes *bytes =
        g_bytes_new_with_free_func(frame->bgra[side], stride * (gsize)frame->height,
                                   (GDestroyNotify)view_frame_unref, view_frame_ref(frame));
    GdkTexture *texture = gdk_memory_texture_new(frame->width, frame->height,
                                                 GDK_MEMORY_B8G8R8A8_PREMULTIPLIED, bytes, stride);
    GskRenderNode *node = gsk_texture_node_new(texture, all);
    g_object_unref(texture);
    g_bytes_unref(bytes);
    return node;
}

static void drop_nodes(ViewCanvas *canvas)
{
    for (int side = 0; side < VIEW_SIDES; side++)
        g_clear_pointer(&canvas->nodes[side], gsk_render_node_unref);
    canvas->made = false;
}

static bool is_own(const struct view_frame *frame)
{
    return frame && (frame->window[0] || frame->window[1]);
}

static void drop_frame(ViewCanvas *canvas)
{
    drop_nodes(canvas);
    view_frame_unref(canvas->frame);
    canvas->frame = NULL;
}

/* The picture's nodes are kept while the frame stays, so that drawing what lies over it anew costs
 * nothing below it. */
static void need_nodes(ViewCanvas *canvas, const graphene_rect_t *all)
{
    if (canvas->made && graphene_rect_equal(all, &canvas->node_area))
        return;
    GskRenderer *renderer = gtk_native_get_renderer(gtk_widget_get_native(GTK_WIDGET(canvas)));
    bool cairo = renderer && G_TYPE_CHECK_INSTANCE_TYPE(renderer, GSK_TYPE_CAIRO_RENDERER);
    drop_nodes(canvas);
    canvas->made = true;
    canvas->cairo = cairo;
    if (cairo && is_own(canvas->frame))
        view_area_read(canvas->area, canvas->frame);
    canvas->node_area = *all;
    for (int side = 0; side < (canvas->frame->compare ? VIEW_SIDES : 1); side++)
        if (cairo || !canvas->frame->window[side])
            canvas->nodes[side] = cairo ? paint_pixels(canvas->frame, side, all)
                                        : make_texture(canvas->frame, side, all);
}

void view_canvas_set_frame(ViewCanvas *canvas, struct view_frame *frame)
{
    drop_frame(canvas);
    canvas->frame = view_frame_ref(frame);
    if (is_own(frame))
        view_area_set_frame(canvas->area, frame);
    gtk_widget_queue_draw(GTK_WIDGET(canvas));
}

void view_canvas_set_handles(ViewCanvas *canvas, bool shown)
{
    canvas->handles = shown;
    gtk_widget_queue_draw(GTK_WIDGET(canvas));
}

struct view_canvas_shown view_canvas_get_shown(ViewCanvas *canvas)
{
    return canvas->shown;
}

bool view_canvas_draws(ViewCanvas *canvas)
{
    return view_area_ready(canvas->area);
}

const char *view_canvas_why_not(ViewCanvas *canvas)
{
    return view_area_why_not(canvas->area);
}

void view_canvas_read(ViewCanvas *canvas)
{
    if (is_own(canvas->frame))
        view_area_read(canvas->area, canvas->frame);
}

void view_canvas_divide(ViewCanvas *canvas, double divider)
{
    canvas->app->divider = CLAMP(divider, 0.01, 0.99);
    if (is_own(canvas->frame))
        view_area_queue(canvas->area);
    gtk_widget_queue_draw(GTK_WIDGET(canvas));
}

/* ---- drawing ---- */

static void draw_label(ViewCanvas *canvas, GtkSnapshot *snapshot, const char *text, double x,
                       double y, double align)
{
    PangoLayout *layout = gtk_widget_create_pango_layout(GTK_WIDGET(canvas), text);
    int width, height;
    pango_layout_get_pixel_size(layout, &width, &height);
    const GdkRGBA back = {0, 0, 0, 0.55f}, ink = {1, 1, 1, 1};
    float left = (float)(x - align * (width + 16));
    graphene_rect_t box = GRAPHENE_RECT_INIT(left, (float)y, (float)width + 16, (float)height + 8);
    GskRoundedRect rounded;
    gsk_rounded_rect_init_from_rect(&rounded, &box, 6);
    gtk_snapshot_push_rounded_clip(snapshot, &rounded);
    gtk_snapshot_append_color(snapshot, &back, &box);
    gtk_snapshot_save(snapshot);
    gtk_snapshot_translate(snapshot, &GRAPHENE_POINT_INIT(left + 8, (float)y + 4));
    gtk_snapshot_append_layout(snapshot, layout, &ink);
    gtk_snapshot_restore(snapshot);
    gtk_snapshot_pop(snapshot);
    g_object_unref(layout);
}

static void draw_scale(ViewCanvas *canvas, GtkSnapshot *snapshot, double width, double height)
{
    enum { STOPS = 17 };
    GskColorStop stops[STOPS];
    for (int i = 0; i < STOPS; i++) {
        double rgb[3], t = (double)i / (STOPS - 1);
        pnb_colormap_diverging(t, rgb);
        for (int c = 0; c < 3; c++)
            rgb[c] = rgb[c] <= 0.0031308 ? 12.92 * rgb[c] : 1.055 * pow(rgb[c], 1 / 2.4) - 0.055;
        stops[i] = (GskColorStop){(float)t, {(float)rgb[0], (float)rgb[1], (float)rgb[2], 1}};
    }
    float x = (float)(0.5 * width - 90), y = (float)(height - 56);
    graphene_rect_t bar = GRAPHENE_RECT_INIT(x, y, 180, 10);
    gtk_snapshot_append_linear_gradient(snapshot, &bar, &GRAPHENE_POINT_INIT(x, y),
                                        &GRAPHENE_POINT_INIT(x + 180, y), stops, STOPS);
    char text[96];
    g_snprintf(text, sizeof(text), "too dark −%g      error      +%g too bright",
               canvas->frame->error_scale, canvas->frame->error_scale);
    draw_label(canvas, snapshot, text, 0.5 * width, y + 16, 0.5);
}

static void draw_divider(ViewCanvas *canvas, GtkSnapshot *snapshot, double width, double height)
{
    const GdkRGBA dark = {0, 0, 0, 0.6f}, light = {1, 1, 1, 0.9f};
    float x = (float)(canvas->app->divider * width);
    gtk_snapshot_append_color(snapshot, &dark, &GRAPHENE_RECT_INIT(x - 2, 0, 4, (float)height));
    gtk_snapshot_append_color(snapshot, &light, &GRAPHENE_RECT_INIT(x - 1, 0, 2, (float)height));
    graphene_rect_t grip = GRAPHENE_RECT_INIT(x - 7, (float)(0.5 * height - 22), 14, 44);
    GskRoundedRect rounded;
    gsk_rounded_rect_init_from_rect(&rounded, &grip, 7);
    gtk_snapshot_push_rounded_clip(snapshot, &rounded);
    gtk_snapshot_append_color(snapshot, &light, &grip);
    for (int i = -1; i <= 1; i++)
        gtk_snapshot_append_color(
            snapshot, &dark, &GRAPHENE_RECT_INIT(x - 3, (float)(0.5 * height + 6 * i - 1), 6, 2));
    gtk_snapshot_pop(snapshot);
}

static void draw_names(ViewCanvas *canvas, GtkSnapshot *snapshot, double width)
{
    const struct view_frame *frame = canvas->frame;
    double x = canvas->app->divider * width;
    for (int side = 0; side < VIEW_SIDES; side++) {
        char text[128];
        if (frame->message[side][0])
            g_snprintf(text, sizeof(text), "%s: no shadow", frame->methods[side]->name);
        else
            g_snprintf(text, sizeof(text), "%s", frame->methods[side]->name);
        if (side == 0)
            draw_label(canvas, snapshot, text, x - 12, 40, 1); /* below marks at the border */
        else
            draw_label(canvas, snapshot, text, x + 12, 40, 0);
    }
}

static void append_side(ViewCanvas *canvas, GtkSnapshot *snapshot, int side)
{
    if (canvas->frame->window[side] && !canvas->cairo)
        gtk_widget_snapshot_child(GTK_WIDGET(canvas), view_area_widget(canvas->area), snapshot);
    else if (canvas->nodes[side])
        gtk_snapshot_append_node(snapshot, canvas->nodes[side]);
}

static void view_canvas_snapshot(GtkWidget *widget, GtkSnapshot *snapshot)
{
    ViewCanvas *canvas = VIEW_CANVAS(widget);
    struct view_app *app = canvas->app;
    float width = (float)gtk_widget_get_width(widget);
    float height = (float)gtk_widget_get_height(widget);
    graphene_rect_t all = GRAPHENE_RECT_INIT(0, 0, width, height);
    const GdkRGBA empty = {0.2f, 0.2f, 0.22f, 1};
    if (!canvas->frame) {
        gtk_snapshot_append_color(snapshot, &empty, &all);
        return;
    }
    struct view_frame *frame = canvas->frame;
    need_nodes(canvas, &all);
    gtk_snapshot_push_clip(snapshot, &all);
    if (frame->compare) {
        float x = (float)round(app->divider * width);
        gtk_snapshot_push_clip(snapshot, &GRAPHENE_RECT_INIT(0, 0, x, height));
        append_side(canvas, snapshot, 0);
        gtk_snapshot_pop(snapshot);
        gtk_snapshot_push_clip(snapshot, &GRAPHENE_RECT_INIT(x, 0, width - x, height));
        append_side(canvas, snapshot, 1);
        gtk_snapshot_pop(snapshot);
        draw_divider(canvas, snapshot, width, height);
        draw_names(canvas, snapshot, width);
    } else {
        append_side(canvas, snapshot, 0);
    }
    if (frame->show == VIEW_SHOW_ERROR && frame->truth_samples > 0)
        draw_scale(canvas, snapshot, width, height);
    else if (frame->show == VIEW_SHOW_ERROR)
        draw_label(canvas, snapshot,
                   app->moving ? "Visibility; its error when nothing moves"
                               : "Visibility; waiting for the truth",
                   0.5 * width, height - 40, 0.5);
    if (canvas->handles && app->scene) {
        struct view_lens lens = lens_of(canvas);
        graphene_rect_t bounds;
        view_handles_bounds(app, &lens, &bounds);
        if (bounds.size.width > 0 && bounds.size.height > 0) {
            cairo_t *cr = gtk_snapshot_append_cairo(snapshot, &bounds);
            view_handles_draw(app, &lens, cr, &canvas->hot);
            cairo_destroy(cr);
        }
    }
    gtk_snapshot_pop(snapshot);
    if (canvas->shown.serial != frame->serial || canvas->shown.width != frame->width)
        canvas->shown.count++;
    canvas->shown.serial = frame->serial;
    canvas->shown.width = frame->width;
    canvas->shown.height = frame->height;
    canvas->shown.full = frame->full;
    canvas->shown.wanted_us = frame->wanted_us;
    view_window_drawn(app->window);
}

/* ---- size ---- */

static gboolean resize_ended(gpointer data)
{
    ViewCanvas *canvas = data;
    canvas->resize_timer = 0;
    view_app_set_moving(canvas->app, VIEW_MOVING_SIZE, false);
    return G_SOURCE_REMOVE;
}

static void view_canvas_size_allocate(GtkWidget *widget, int width, int height, int baseline)
{
    ViewCanvas *canvas = VIEW_CANVAS(widget);
    struct view_app *app = canvas->app;
    int scale = gtk_widget_get_scale_factor(widget);
    bool first = app->state.width == 0;
    view_area_allocate(canvas->area, width, height);
    if (app->state.width == width * scale && app->state.height == height * scale)
        return;
    app->state.width = width * scale;
    app->state.height = height * scale;
    if (!first) {
        if (canvas->resize_timer)
            g_source_remove(canvas->resize_timer);
        canvas->resize_timer = g_timeout_add(RESIZE_REST_MS, resize_ended, canvas);
        view_app_set_moving(app, VIEW_MOVING_SIZE, true);
    }
    view_app_changed(app);
}

static void view_canvas_measure(GtkWidget *widget, GtkOrientation orientation, int for_size,
                                int *minimum, int *natural, int *minimum_baseline,
                                int *natural_baseline)
{
    ViewCanvas *canvas = VIEW_CANVAS(widget);
    const struct view_options *options = canvas->app->options;
    bool across = orientation == GTK_ORIENTATION_HORIZONTAL;
    *natural = across ? options->width : options->height;
    *minimum = MIN(across ? 240 : 180, *natural);
    *minimum_baseline = *natural_baseline = -1;
}

/* ---- the hand ---- */

static bool near_divider(ViewCanvas *canvas, double x)
{
    double width = gtk_widget_get_width(GTK_WIDGET(canvas));
    return canvas->app->state.compare && fabs(x - canvas->app->divider * width) < 8;
}

static void set_cursor(ViewCanvas *canvas)
{
    const char *name = "default";
    if (canvas->hand == HAND_GRAB || canvas->hand == HAND_ORBIT || canvas->hand == HAND_PAN)
        name = "grabbing";
    else if (canvas->hot.type == VIEW_HANDLE_OTHER)
        name = "pointer";
    else if (canvas->hot.type != VIEW_HANDLE_NONE)
        name = "grab";
    else if (canvas->hand == HAND_DIVIDER || near_divider(canvas, canvas->x))
        name = "col-resize";
    gtk_widget_set_cursor_from_name(GTK_WIDGET(canvas), name);
}

void view_canvas_press(ViewCanvas *canvas, double x, double y, guint button, GdkModifierType mods)
{
    struct view_app *app = canvas->app;
    if (!app->scene)
        return;
    struct view_lens lens = lens_of(canvas);
    struct view_handle handle = {VIEW_HANDLE_NONE};
    if (canvas->handles && button == GDK_BUTTON_PRIMARY)
        handle = view_handles_at(app, &lens, x, y);
    canvas->press_x = canvas->x = x;
    canvas->press_y = canvas->y = y;
    canvas->moved = false;
    if (handle.type == VIEW_HANDLE_OTHER) {
        view_app_select(app, VIEW_PICK_LIGHT, handle.index);
        handle.type = VIEW_HANDLE_MOVE; /* selected and held at once */
    }
    if (handle.type != VIEW_HANDLE_NONE) {
        canvas->hand = HAND_GRAB;
        view_grab_begin(&canvas->grab, app, &lens, &handle, x, y);
    } else if (button == GDK_BUTTON_PRIMARY && near_divider(canvas, x)) {
        canvas->hand = HAND_DIVIDER;
    } else if (button == GDK_BUTTON_PRIMARY && !(mods & GDK_SHIFT_MASK)) {
        canvas->hand = HAND_ORBIT;
    } else {
        canvas->hand = HAND_PAN;
    }
    gtk_widget_grab_focus(GTK_WIDGET(canvas));
    set_cursor(canvas);
}

static void drag_to(ViewCanvas *canvas, double x, double y, GdkModifierType mods)
{
    struct view_app *app = canvas->app;
    double dx = x - canvas->x, dy = y - canvas->y;
    double width = gtk_widget_get_width(GTK_WIDGET(canvas));
    double height = gtk_widget_get_height(GTK_WIDGET(canvas));
    struct view_lens lens = lens_of(canvas);
    bool changed = true;
    if (canvas->hand == HAND_DIVIDER) {
        view_canvas_divide(canvas, x / width);
        return;
    }
    view_app_set_moving(app, VIEW_MOVING_HAND, true);
    if (canvas->hand == HAND_GRAB)
        changed = view_grab_drag(&canvas->grab, app, &lens, x, y, mods & GDK_SHIFT_MASK);
    else if (canvas->hand == HAND_ORBIT)
        view_camera_orbit(&app->state.camera, -dx * ORBIT_DEGREES, dy * ORBIT_DEGREES);
    else
        view_camera_pan(&app->state.camera, dx, dy, height);
    if (changed)
        view_app_changed(app);
}

void view_canvas_motion(ViewCanvas *canvas, double x, double y, GdkModifierType mods)
{
    struct view_app *app = canvas->app;
    if (canvas->hand != HAND_NONE) {
        double far = hypot(x - canvas->press_x, y - canvas->press_y);
        canvas->moved = canvas->moved || far > CLICK_PX || canvas->hand == HAND_DIVIDER;
        if (canvas->moved)
            drag_to(canvas, x, y, mods);
        if (canvas->moved) {
            canvas->x = x;
            canvas->y = y;
        }
    } else {
        canvas->x = x;
        canvas->y = y;
        struct view_handle hot = {VIEW_HANDLE_NONE};
        if (canvas->handles && app->scene) {
            struct view_lens lens = lens_of(canvas);
            hot = view_handles_at(app, &lens, x, y);
        }
        if (hot.type != canvas->hot.type || hot.sign != canvas->hot.sign) {
            canvas->hot = hot;
            gtk_widget_queue_draw(GTK_WIDGET(canvas));
        }
        set_cursor(canvas);
    }
    canvas->inside = true;
    view_window_pointer(app->window, view_handle_hint(canvas->hot.type, app->pick.type));
}

/* What a press without a drag meant. */
static void click(ViewCanvas *canvas)
{
    struct view_app *app = canvas->app;
    int x, y, side;
    if (canvas->hand != HAND_ORBIT || !view_canvas_pixel(canvas, &x, &y, &side))
        return;
    uint32_t object = canvas->frame->objects[(size_t)y * (size_t)canvas->frame->width + (size_t)x];
    if (!canvas->frame->picked)
        return;
    if (object != PNB_NO_OBJECT)
        view_app_select(app, VIEW_PICK_OBJECT, object);
    else
        view_app_select(app, VIEW_PICK_NONE, 0);
}

void view_canvas_release(ViewCanvas *canvas)
{
    if (canvas->hand != HAND_NONE && !canvas->moved)
        click(canvas);
    canvas->hand = HAND_NONE;
    view_app_set_moving(canvas->app, VIEW_MOVING_HAND, false);
    set_cursor(canvas);
}

bool view_canvas_pixel(ViewCanvas *canvas, int *x, int *y, int *side)
{
    double width = gtk_widget_get_width(GTK_WIDGET(canvas));
    double height = gtk_widget_get_height(GTK_WIDGET(canvas));
    const struct view_frame *frame = canvas->frame;
    if (!frame || !canvas->inside || canvas->x < 0 || canvas->y < 0 || canvas->x >= width ||
        canvas->y >= height)
        return false;
    *x = CLAMP((int)(canvas->x / width * frame->width), 0, frame->width - 1);
    *y = CLAMP((int)(canvas->y / height * frame->height), 0, frame->height - 1);
    *side = frame->compare && canvas->x >= canvas->app->divider * width ? 1 : 0;
    return true;
}

bool view_canvas_find_handle(ViewCanvas *canvas, int type, double *x, double *y)
{
    struct view_lens lens = lens_of(canvas);
    struct view_handle all[VIEW_HANDLES_MAX];
    int count = view_handles_find(canvas->app, &lens, all);
    for (int i = 0; i < count; i++)
        if ((int)all[i].type == type) {
            *x = all[i].x;
            *y = all[i].y;
            return true;
        }
    return false;
}

void view_canvas_step(ViewCanvas *canvas, int dx, int dy, GdkModifierType mods)
{
    struct view_app *app = canvas->app;
    if (!app->scene)
        return;
    struct view_lens lens = lens_of(canvas);
    vec3 place;
    if (mods & GDK_CONTROL_MASK) { /* the selection */
        if (!view_app_pick_place(app, app->pick, &place))
            return;
        double step = 12 * view_lens_pixel_size(&lens, place);
        vec3 right = v3_unit(v3(lens.right.x, 0, lens.right.z), v3(1, 0, 0));
        vec3 away = v3_cross(v3(0, 1, 0), right);
        vec3 up = mods & GDK_SHIFT_MASK ? v3(0, 1, 0) : away;
        view_app_pick_move(app, app->pick, v3_mad(v3_scale(right, dx * step), up, dy * step));
    } else if (mods & GDK_SHIFT_MASK) {
        view_camera_pan(&app->state.camera, -24.0 * dx, 24.0 * dy,
                        gtk_widget_get_height(GTK_WIDGET(canvas)));
    } else {
        view_camera_orbit(&app->state.camera, 4.0 * dx, 4.0 * dy);
    }
    view_app_edited(app);
}

void view_canvas_zoom(ViewCanvas *canvas, double factor)
{
    struct view_app *app = canvas->app;
    if (!app->scene)
        return;
    view_camera_zoom(&app->state.camera, factor, app->scene->radius);
    view_app_edited(app);
}

/* ---- controllers ---- */

static GdkModifierType modifiers(GtkEventController *controller)
{
    return gtk_event_controller_get_current_event_state(controller);
}

static void on_drag_begin(GtkGestureDrag *gesture, double x, double y, gpointer data)
{
    guint button = gtk_gesture_single_get_current_button(GTK_GESTURE_SINGLE(gesture));
    view_canvas_press(data, x, y, button, modifiers(GTK_EVENT_CONTROLLER(gesture)));
}

static void on_drag_update(GtkGestureDrag *gesture, double dx, double dy, gpointer data)
{
    double x, y;
    if (gtk_gesture_drag_get_start_point(gesture, &x, &y))
        view_canvas_motion(data, x + dx, y + dy, modifiers(GTK_EVENT_CONTROLLER(gesture)));
}

static void on_drag_end(GtkGestureDrag *gesture, double dx, double dy, gpointer data)
{
    view_canvas_release(data);
}

static void on_motion(GtkEventControllerMotion *controller, double x, double y, gpointer data)
{
    ViewCanvas *canvas = data;
    if (canvas->hand == HAND_NONE)
        view_canvas_motion(canvas, x, y, modifiers(GTK_EVENT_CONTROLLER(controller)));
}

static void on_leave(GtkEventControllerMotion *controller, gpointer data)
{
    ViewCanvas *canvas = data;
    canvas->inside = false;
    if (canvas->hot.type != VIEW_HANDLE_NONE)
        gtk_widget_queue_draw(GTK_WIDGET(canvas));
    canvas->hot.type = VIEW_HANDLE_NONE;
    view_window_pointer(canvas->app->window, NULL);
}

static gboolean on_scroll(GtkEventControllerScroll *controller, double dx, double dy, gpointer data)
{
    view_canvas_zoom(data, pow(1.12, dy));
    return TRUE;
}

static void on_pinch(GtkGestureZoom *gesture, double scale, gpointer data)
{
    ViewCanvas *canvas = data;
    double *last = g_object_get_data(G_OBJECT(gesture), "last");
    if (scale > 0 && last && *last > 0)
        view_canvas_zoom(canvas, *last / scale);
    if (last)
        *last = scale;
}

static void on_pinch_begin(GtkGesture *gesture, GdkEventSequence *sequence, gpointer data)
{
    double *last = g_new(double, 1);
    *last = 1;
    g_object_set_data_full(G_OBJECT(gesture), "last", last, g_free);
}

static gboolean on_key(GtkEventControllerKey *controller, guint key, guint code,
                       GdkModifierType mods, gpointer data)
{
    ViewCanvas *canvas = data;
    switch (key) {
    case GDK_KEY_Left: view_canvas_step(canvas, -1, 0, mods); return TRUE;
    case GDK_KEY_Right: view_canvas_step(canvas, 1, 0, mods); return TRUE;
    case GDK_KEY_Up: view_canvas_step(canvas, 0, 1, mods); return TRUE;
    case GDK_KEY_Down: view_canvas_step(canvas, 0, -1, mods); return TRUE;
    case GDK_KEY_bracketleft:
    case GDK_KEY_bracketright:
        view_canvas_divide(canvas,
                           canvas->app->divider + (key == GDK_KEY_bracketleft ? -0.02 : 0.02));
        return TRUE;
    default: return FALSE;
    }
}

static void add_controllers(ViewCanvas *canvas)
{
    GtkWidget *widget = GTK_WIDGET(canvas);
    GtkGesture *drag = gtk_gesture_drag_new();
    gtk_gesture_single_set_button(GTK_GESTURE_SINGLE(drag), 0);
    g_signal_connect(drag, "drag-begin", G_CALLBACK(on_drag_begin), canvas);
    g_signal_connect(drag, "drag-update", G_CALLBACK(on_drag_update), canvas);
    g_signal_connect(drag, "drag-end", G_CALLBACK(on_drag_end), canvas);
    gtk_widget_add_controller(widget, GTK_EVENT_CONTROLLER(drag));

    GtkEventController *motion = gtk_event_controller_motion_new();
    g_signal_connect(motion, "motion", G_CALLBACK(on_motion), canvas);
    g_signal_connect(motion, "leave", G_CALLBACK(on_leave), canvas);
    gtk_widget_add_controller(widget, motion);

    GtkEventController *scroll =
        gtk_event_controller_scroll_new(GTK_EVENT_CONTROLLER_SCROLL_VERTICAL);
    g_signal_connect(scroll, "scroll", G_CALLBACK(on_scroll), canvas);
    gtk_widget_add_controller(widget, scroll);

    GtkGesture *pinch = gtk_gesture_zoom_new();
    g_signal_connect(pinch, "begin", G_CALLBACK(on_pinch_begin), canvas);
    g_signal_connect(pinch, "scale-changed", G_CALLBACK(on_pinch), canvas);
    gtk_widget_add_controller(widget, GTK_EVENT_CONTROLLER(pinch));

    GtkEventController *key = gtk_event_controller_key_new();
    g_signal_connect(key, "key-pressed", G_CALLBACK(on_key), canvas);
    gtk_widget_add_controller(widget, key);
}

static void view_canvas_dispose(GObject *object)
{
    ViewCanvas *canvas = VIEW_CANVAS(object);
    if (canvas->resize_timer)
        g_source_remove(canvas->resize_timer);
    canvas->resize_timer = 0;
    drop_frame(canvas);
    g_clear_pointer(&canvas->area, view_area_destroy);
    G_OBJECT_CLASS(view_canvas_parent_class)->dispose(object);
}

static void view_canvas_class_init(ViewCanvasClass *class)
{
    G_OBJECT_CLASS(class)->dispose = view_canvas_dispose;
    GTK_WIDGET_CLASS(class)->snapshot = view_canvas_snapshot;
    GTK_WIDGET_CLASS(class)->size_allocate = view_canvas_size_allocate;
    GTK_WIDGET_CLASS(class)->measure = view_canvas_measure;
    gtk_widget_class_set_css_name(GTK_WIDGET_CLASS(class), "canvas");
    gtk_widget_class_set_accessible_role(GTK_WIDGET_CLASS(class), GTK_ACCESSIBLE_ROLE_IMG);
}

static void view_canvas_init(ViewCanvas *canvas)
{
    canvas->handles = true;
}

GtkWidget *view_canvas_new(struct view_app *app)
{
    ViewCanvas *canvas = g_object_new(VIEW_TYPE_CANVAS, NULL);
    canvas->app = app;
    canvas->area = view_area_create(app, GTK_WIDGET(canvas));
    gtk_widget_set_focusable(GTK_WIDGET(canvas), TRUE);
    gtk_widget_set_hexpand(GTK_WIDGET(canvas), TRUE);
    gtk_widget_set_vexpand(GTK_WIDGET(canvas), TRUE);
    gtk_widget_set_overflow(GTK_WIDGET(canvas), GTK_OVERFLOW_HIDDEN);
    view_focus_name(GTK_WIDGET(canvas), "Picture of the scene");
    add_controllers(canvas);
    return GTK_WIDGET(canvas);
}
