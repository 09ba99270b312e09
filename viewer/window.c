/* viewer/window.c: the window: header bar, banner, canvas, side bar, status line.
 *
 * The side bar's values follow a movement ten times a second only, and so does the graph: drawing
 * them would cost more than the picture.
 */
#include "window.h"

#include "actions.h"
#include "focus.h"
#include "panels.h"
#include "script.h"

#define FOLLOW_MS 100

struct view_window {
    struct view_app *app;
    GtkWidget *window, *canvas, *title, *subtitle;
    GtkWidget *banner, *banner_text;
    GtkWidget *side, *stack, *panel_method, *panel_light, *panel_object, *panel_motion, *graph;
    GtkWidget *readout, *info, *stage, *progress, *stop;
    char *error, *dismissed, *notice;
    guint follow_timer, notice_timer;
    bool said_stopped; /* what the notice says */
    gulong before_paint, after_paint;
    GdkFrameClock *clock;
    int64_t paint_us;
    bool drawn, figures;
    uint64_t graphed; /* serial */
    int graphed_width;
};

GtkWidget *view_window_widget(struct view_window *window)
{
    return window->window;
}

ViewCanvas *view_window_canvas(struct view_window *window)
{
    return VIEW_CANVAS(window->canvas);
}

/* ---- banner ---- */

/* A failed command comes before what a method says of the scene. */
static void show_banner(struct view_window *window)
{
    const struct view_frame *frame = window->app->frame;
    if (frame && (frame->window[0] || frame->window[1]) && !frame->drawn && !window->error)
        return; /* it may have something to say once it is drawn */
    const char *text = window->error;
    for (int side = 0; frame && !text && side < VIEW_SIDES; side++)
        if (frame->message[side][0])
            text = frame->message[side];
    if (text && g_strcmp0(text, window->dismissed) == 0)
        text = NULL;
    if (text)
        gtk_label_set_text(GTK_LABEL(window->banner_text), text);
    gtk_info_bar_set_revealed(GTK_INFO_BAR(window->banner), text != NULL);
}

static void on_banner(GtkInfoBar *bar, int response, gpointer data)
{
    struct view_window *window = data;
    g_clear_pointer(&window->error, g_free);
    g_free(window->dismissed);
    window->dismissed = g_strdup(gtk_label_get_text(GTK_LABEL(window->banner_text)));
    show_banner(window);
}

void view_window_error(struct view_window *window, const char *text)
{
    g_free(window->error);
    window->error = g_strdup(text);
    g_clear_pointer(&window->dismissed, g_free);
    show_banner(window);
    if (text && !window->app->options->quiet)
        view_complain("viewer", text);
}

const char *view_window_banner(struct view_window *window)
{
    return gtk_info_bar_get_revealed(GTK_INFO_BAR(window->banner))
               ? gtk_label_get_text(GTK_LABEL(window->banner_text))
               : "";
}

/* ---- status line ---- */

const char *view_window_readout(struct view_window *window)
{
    return gtk_label_get_text(GTK_LABEL(window->readout));
}

const char *view_window_info(struct view_window *window)
{
    return gtk_label_get_text(GTK_LABEL(window->info));
}

bool view_window_draws(struct view_window *window)
{
    const struct view_state *state = &window->app->state;
    bool wanted = view_method_on_opengl(&state->methods[0]) ||
                  (state->compare && view_method_on_opengl(&state->methods[1]));
    return wanted ? view_canvas_draws(view_window_canvas(window)) : state->window;
}

static void show_readout(struct view_window *window, const char *hint)
{
    const struct view_app *app = window->app;
    const struct view_frame *frame = app->frame;
    int x, y, side;
    GString *text = g_string_new(NULL);
    if (window->notice) {
        g_string_append(text, window->notice);
    } else if (frame && app->scene &&
               view_canvas_pixel(view_window_canvas(window), &x, &y, &side)) {
        size_t pixel = (size_t)y * (size_t)frame->width + (size_t)x;
        float v = frame->visibility[side][pixel];
        uint32_t object = frame->objects[pixel];
        if (!frame->picked)
            ; /* nothing is known of it before all is at rest */
        else if (object >= app->scene->object_count)
            g_string_append(text, "background");
        else if (isnan(v))
            g_string_append_printf(text, "%s   no visibility here",
                                   app->scene->objects[object].name);
        else
            g_string_append_printf(text, "%s   visibility %.3f", app->scene->objects[object].name,
                                   (double)v);
        if (frame->picked && object < app->scene->object_count && !isnan(v) &&
            frame->truth_samples > 0)
            g_string_append_printf(text, "   truth %.3f   error %+.3f", (double)frame->truth[pixel],
                                   (double)(v - frame->truth[pixel]));
        if (hint)
            g_string_append_printf(text, "%s%s", text->len ? "   ·   " : "", hint);
    }
    if (text->len == 0 && app->scene)
        g_string_append(text, "Drag the yellow light; drag elsewhere to turn; F1: all keys");
    gtk_label_set_text(GTK_LABEL(window->readout), text->str);
    g_string_free(text, TRUE);
}

static void show_info(struct view_window *window)
{
    const struct view_frame *frame = window->app->frame;
    GString *text = g_string_new(NULL);
    if (frame) {
        const struct view_times *t = &frame->times;
        double total = t->update + t->primary + t->visibility[0] + t->visibility[1] + t->shade;
        g_string_append_printf(text, "%d × %d", frame->width, frame->height);
        if (total > 0.05)
            g_string_append_printf(text, "   %.0f ms", total);
        const char *why_not = view_canvas_why_not(view_window_canvas(window));
        bool opengl = view_method_on_opengl(&window->app->state.methods[0]) ||
                      (frame->compare && view_method_on_opengl(&window->app->state.methods[1]));
        if (frame->window[0] || frame->window[1])
            g_string_append(text, "   OpenGL");
        else if (opengl)
            g_string_append_printf(text, "   OpenGL read back (%s)",
                                   *why_not ? why_not : frame->refusal);
        if (frame->truth_samples > 0)
            g_string_append_printf(text, "   truth %d", frame->truth_samples);
    }
    gtk_label_set_text(GTK_LABEL(window->info), text->str);
    g_string_free(text, TRUE);
}

void view_window_pointer(struct view_window *window, const char *hint)
{
    show_readout(window, hint);
}

static gboolean notice_ended(gpointer data)
{
    struct view_window *window = data;
    window->notice_timer = 0;
    window->said_stopped = false;
    g_clear_pointer(&window->notice, g_free);
    show_readout(window, NULL);
    return G_SOURCE_REMOVE;
}

static void forget_notice(struct view_window *window)
{
    if (window->notice_timer)
        g_source_remove(window->notice_timer);
    notice_ended(window);
}

static void notify(struct view_window *window, char *text)
{
    forget_notice(window);
    window->notice = text;
    window->notice_timer = g_timeout_add_seconds(6, notice_ended, window);
    show_readout(window, NULL);
}

void view_window_saved(struct view_window *window, const char *path)
{
    char *name = g_filename_display_name(path);
    notify(window, g_strdup_printf("Saved %s", name));
    g_free(name);
}

void view_window_progress(struct view_window *window, const char *stage, double fraction)
{
    gtk_widget_set_visible(window->progress, stage != NULL);
    gtk_widget_set_visible(window->stop, stage != NULL);
    gtk_widget_set_visible(window->stage, stage != NULL);
    gtk_widget_set_visible(window->info, stage == NULL);
    if (!stage)
        return;
    gtk_label_set_text(GTK_LABEL(window->stage), stage);
    gtk_progress_bar_set_fraction(GTK_PROGRESS_BAR(window->progress), CLAMP(fraction, 0, 1));
}

bool view_window_busy(struct view_window *window)
{
    return gtk_widget_get_visible(window->progress);
}

void view_window_rest(struct view_window *window, bool stopped)
{
    view_window_progress(window, NULL, 0);
    if (stopped) {
        notify(window, g_strdup("Stopped. The next change starts again."));
        window->said_stopped = true;
    } else if (window->said_stopped) {
        forget_notice(window);
    }
    show_info(window);
}

/* ---- following the state ---- */

static void refresh_now(struct view_window *window)
{
    view_panel_method_refresh(window->panel_method);
    view_panel_light_refresh(window->panel_light);
    view_panel_object_refresh(window->panel_object);
    view_panel_motion_refresh(window->panel_motion);
    if (window->figures)
        view_panel_method_figures(window->panel_method);
    window->figures = false;
    view_actions_refresh(window->app);
    view_graph_redraw(window->graph);
    show_banner(window);
    show_info(window);
    show_readout(window, NULL);
    const struct view_state *state = &window->app->state;
    char *text = state->compare ? g_strdup_printf("%s | %s", state->methods[0].info->title,
                                                  state->methods[1].info->title)
                                : g_strdup(state->methods[0].info->title);
    gtk_label_set_text(GTK_LABEL(window->subtitle), text);
    g_free(text);
}

static gboolean follow(gpointer data)
{
    struct view_window *window = data;
    window->follow_timer = 0;
    refresh_now(window);
    return G_SOURCE_REMOVE;
}

void view_window_refresh(struct view_window *window)
{
    gtk_widget_queue_draw(window->canvas);
    if (window->app->moving) {
        if (!window->follow_timer)
            window->follow_timer = g_timeout_add(FOLLOW_MS, follow, window);
        return;
    }
    if (window->follow_timer)
        g_source_remove(window->follow_timer);
    window->follow_timer = 0;
    refresh_now(window);
}

void view_window_scene_opened(struct view_window *window)
{
    const struct view_scene *scene = window->app->scene;
    view_window_error(window, NULL);
    gtk_label_set_text(GTK_LABEL(window->title), scene->name);
    char *title = g_strdup_printf("%s - penumbra", scene->name);
    gtk_window_set_title(GTK_WINDOW(window->window), title);
    g_free(title);
    if (scene->notes[0])
        notify(window, g_strjoinv("; ", scene->notes));
}

void view_window_frame(struct view_window *window)
{
    struct view_app *app = window->app;
    view_canvas_set_frame(view_window_canvas(window), app->frame);
    window->figures = true;
    if (app->moving) {
        view_window_refresh(window);
        return;
    }
    view_panel_method_figures(window->panel_method);
    window->figures = false;
    show_banner(window);
    show_info(window);
    show_readout(window, NULL);
}

void view_window_drawn(struct view_window *window)
{
    window->drawn = true;
}

static void on_before_paint(GdkFrameClock *clock, gpointer data)
{
    struct view_window *window = data;
    window->paint_us = g_get_monotonic_time();
}

static void on_after_paint(GdkFrameClock *clock, gpointer data)
{
    struct view_window *window = data;
    struct view_app *app = window->app;
    if (!window->drawn || !app->frame)
        return;
    window->drawn = false;
    int64_t now = g_get_monotonic_time();
    struct view_canvas_shown shown = view_canvas_get_shown(view_window_canvas(window));
    if (!app->first_frame_us)
        app->first_frame_us = now - app->started_us;
    if (!app->first_full_us && shown.full)
        app->first_full_us = now - app->started_us;
    if (shown.serial != window->graphed || shown.width != window->graphed_width) {
        double draw_ms = (double)(now - window->paint_us) * 1e-3 - app->frame->window_ms;
        view_graph_add(window->graph, app->frame, MAX(draw_ms, 0));
        window->graphed = shown.serial;
        window->graphed_width = shown.width;
        if (!app->moving) {
            view_graph_redraw(window->graph);
        }
    }
    if (app->frame->drawn && !app->frame->told && !app->moving) {
        app->frame->told = true;
        show_banner(window);
        show_info(window);
        show_readout(window, NULL);
    }
    view_script_painted(app->script, now);
}

/* ---- making it ---- */

void view_window_page(struct view_window *window, const char *name)
{
    gtk_stack_set_visible_child_name(GTK_STACK(window->stack), name);
}

bool view_window_picture(struct view_window *window, const char *path)
{
    int width = gtk_widget_get_width(window->window);
    int height = gtk_widget_get_height(window->window);
    GtkSnapshot *snapshot = gtk_snapshot_new();
    gtk_snapshot_render_background(snapshot, gtk_widget_get_style_context(window->window), 0, 0,
                                   width, height);
    GTK_WIDGET_GET_CLASS(window->window)->snapshot(window->window, snapshot);
    GskRenderNode *node = gtk_snapshot_free_to_node(snapshot);
    GskRenderer *renderer = gtk_native_get_renderer(GTK_NATIVE(window->window));
    bool good = false;
    if (node && renderer) {
        GdkTexture *texture = gsk_renderer_render_texture(
            renderer, node, &GRAPHENE_RECT_INIT(0, 0, (float)width, (float)height));
        good = gdk_texture_save_to_png(texture, path);
        g_object_unref(texture);
    }
    g_clear_pointer(&node, gsk_render_node_unref);
    return good;
}

void view_window_drop(struct view_window *window, const char *path)
{
    view_app_open(window->app, path);
}

static gboolean on_drop(GtkDropTarget *target, const GValue *value, double x, double y,
                        gpointer data)
{
    GSList *files = gdk_file_list_get_files(g_value_get_boxed(value));
    char *path = files ? g_file_get_path(files->data) : NULL;
    if (path)
        view_window_drop(data, path);
    else
        view_window_error(data, "drop: that is no local file");
    g_free(path);
    g_slist_free(files);
    return path != NULL;
}

/* The button that closes an info bar, which GTK gives no name. */
static GtkWidget *button_below(GtkWidget *widget)
{
    if (GTK_IS_BUTTON(widget))
        return widget;
    for (GtkWidget *child = gtk_widget_get_first_child(widget); child;
         child = gtk_widget_get_next_sibling(child)) {
        GtkWidget *button = button_below(child);
        if (button)
            return button;
    }
    return NULL;
}

static GtkWidget *make_banner(struct view_window *window)
{
    window->banner = gtk_info_bar_new();
    window->banner_text = gtk_label_new(NULL);
    gtk_label_set_wrap(GTK_LABEL(window->banner_text), TRUE);
    gtk_label_set_wrap_mode(GTK_LABEL(window->banner_text), PANGO_WRAP_WORD_CHAR);
    gtk_label_set_xalign(GTK_LABEL(window->banner_text), 0);
    gtk_label_set_selectable(GTK_LABEL(window->banner_text), TRUE);
    gtk_widget_set_hexpand(window->banner_text, TRUE);
    gtk_info_bar_add_child(GTK_INFO_BAR(window->banner), window->banner_text);
    gtk_info_bar_set_message_type(GTK_INFO_BAR(window->banner), GTK_MESSAGE_WARNING);
    gtk_info_bar_set_show_close_button(GTK_INFO_BAR(window->banner), TRUE);
    gtk_info_bar_set_revealed(GTK_INFO_BAR(window->banner), FALSE);
    GtkWidget *close = button_below(window->banner);
    if (close)
        view_focus_name(close, "Close the message");
    g_signal_connect(window->banner, "response", G_CALLBACK(on_banner), window);
    return window->banner;
}

static GtkWidget *status_label(GtkWidget *box, bool wide)
{
    GtkWidget *label = gtk_label_new(NULL);
    gtk_label_set_xalign(GTK_LABEL(label), 0);
    gtk_label_set_ellipsize(GTK_LABEL(label), wide ? PANGO_ELLIPSIZE_END : PANGO_ELLIPSIZE_NONE);
    gtk_widget_set_hexpand(label, wide);
    gtk_widget_add_css_class(label, "numeric");
    gtk_box_append(GTK_BOX(box), label);
    return label;
}

static GtkWidget *make_status(struct view_window *window)
{
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 10);
    gtk_widget_add_css_class(box, "status");
    window->readout = status_label(box, true);
    window->stage = status_label(box, false);
    window->progress = gtk_progress_bar_new();
    window->stop = gtk_button_new_with_label("Stop");
    gtk_widget_set_valign(window->progress, GTK_ALIGN_CENTER);
    gtk_widget_set_tooltip_text(window->stop, "Stop this computation (Escape)");
    gtk_actionable_set_action_name(GTK_ACTIONABLE(window->stop), "win.stop");
    gtk_box_append(GTK_BOX(box), window->progress);
    gtk_box_append(GTK_BOX(box), window->stop);
    window->info = status_label(box, false);
    gtk_widget_set_tooltip_text(window->info,
                                "Pixels of this frame, its time, where OpenGL drew it, samples of "
                                "the truth so far");
    gtk_widget_set_visible(window->progress, FALSE);
    gtk_widget_set_visible(window->stop, FALSE);
    gtk_widget_set_visible(window->stage, FALSE);
    gtk_widget_set_size_request(box, -1, 34);
    return box;
}

static GtkWidget *make_side(struct view_window *window)
{
    struct view_app *app = window->app;
    GtkWidget *side = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
    GtkWidget *tabs = gtk_stack_switcher_new();
    window->stack = gtk_stack_new();
    GtkStack *stack = GTK_STACK(window->stack);
    window->panel_method = view_panel_method_new(app);
    window->panel_light = view_panel_light_new(app);
    window->panel_object = view_panel_object_new(app);
    window->panel_motion = view_panel_motion_new(app);
    gtk_stack_add_titled(stack, window->panel_method, "method", "Method");
    gtk_stack_add_titled(stack, window->panel_light, "light", "Light");
    gtk_stack_add_titled(stack, window->panel_object, "object", "Object");
    gtk_stack_add_titled(stack, window->panel_motion, "motion", "Motion");
    gtk_stack_switcher_set_stack(GTK_STACK_SWITCHER(tabs), stack);
    gtk_widget_add_css_class(tabs, "page-tabs");
    window->graph = view_graph_new();
    gtk_box_append(GTK_BOX(side), tabs);
    gtk_box_append(GTK_BOX(side), window->stack);
    gtk_box_append(GTK_BOX(side), window->graph);
    gtk_widget_add_css_class(side, "side");
    gtk_widget_set_size_request(side, 320, -1);
    gtk_widget_set_hexpand(side, FALSE);
    window->side = side;
    return side;
}

static GtkWidget *make_title(struct view_window *window)
{
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
    window->title = gtk_label_new("penumbra");
    window->subtitle = gtk_label_new(NULL);
    gtk_widget_add_css_class(window->title, "title");
    gtk_widget_add_css_class(window->subtitle, "subtitle");
    gtk_label_set_ellipsize(GTK_LABEL(window->title), PANGO_ELLIPSIZE_MIDDLE);
    gtk_label_set_ellipsize(GTK_LABEL(window->subtitle), PANGO_ELLIPSIZE_END);
    gtk_label_set_max_width_chars(GTK_LABEL(window->title), 30);
    gtk_label_set_max_width_chars(GTK_LABEL(window->subtitle), 40);
    gtk_box_append(GTK_BOX(box), window->title);
    gtk_box_append(GTK_BOX(box), window->subtitle);
    gtk_widget_set_valign(box, GTK_ALIGN_CENTER);
    return box;
}

static void on_realize(GtkWidget *widget, gpointer data)
{
    struct view_window *window = data;
    window->clock = g_object_ref(gtk_widget_get_frame_clock(widget));
    window->before_paint =
        g_signal_connect(window->clock, "before-paint", G_CALLBACK(on_before_paint), window);
    window->after_paint =
        g_signal_connect(window->clock, "after-paint", G_CALLBACK(on_after_paint), window);
}

static void on_unrealize(GtkWidget *widget, gpointer data)
{
    struct view_window *window = data;
    if (!window->clock)
        return;
    g_signal_handler_disconnect(window->clock, window->before_paint);
    g_signal_handler_disconnect(window->clock, window->after_paint);
    g_clear_object(&window->clock);
}

struct view_window *view_window_create(struct view_app *app)
{
    struct view_window *window = g_new0(struct view_window, 1);
    app->window = window;
    window->app = app;
    GtkCssProvider *css = gtk_css_provider_new();
    gtk_css_provider_load_from_resource(css, "/penumbra/style.css");
    gtk_style_context_add_provider_for_display(gdk_display_get_default(), GTK_STYLE_PROVIDER(css),
                                               GTK_STYLE_PROVIDER_PRIORITY_APPLICATION);
    g_object_unref(css);

    window->window = gtk_application_window_new(app->application);
    g_object_ref(window->window);
    gtk_window_set_icon_name(GTK_WINDOW(window->window), "weather-clear-symbolic");
    window->canvas = view_canvas_new(app);
    GtkWidget *header = gtk_header_bar_new();
    gtk_header_bar_set_title_widget(GTK_HEADER_BAR(header), make_title(window));
    gtk_window_set_titlebar(GTK_WINDOW(window->window), header);
    gtk_window_set_title(GTK_WINDOW(window->window), "penumbra");

    GtkWidget *left = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
    GtkWidget *body = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 0);
    gtk_box_append(GTK_BOX(left), make_banner(window));
    gtk_box_append(GTK_BOX(left), window->canvas);
    gtk_box_append(GTK_BOX(left), make_status(window));
    gtk_box_append(GTK_BOX(body), left);
    gtk_box_append(GTK_BOX(body), make_side(window));
    gtk_window_set_child(GTK_WINDOW(window->window), body);

    view_actions_install(app, header, window->side);
    GtkDropTarget *drop = gtk_drop_target_new(GDK_TYPE_FILE_LIST, GDK_ACTION_COPY);
    g_signal_connect(drop, "drop", G_CALLBACK(on_drop), window);
    gtk_widget_add_controller(window->window, GTK_EVENT_CONTROLLER(drop));
    g_signal_connect(window->window, "realize", G_CALLBACK(on_realize), window);
    g_signal_connect(window->window, "unrealize", G_CALLBACK(on_unrealize), window);
    if (app->options->size_given && app->options->script) { /* exactly, whatever the window has */
        gtk_widget_set_size_request(window->canvas, app->options->width, app->options->height);
        gtk_widget_set_halign(window->canvas, GTK_ALIGN_CENTER);
        gtk_widget_set_valign(window->canvas, GTK_ALIGN_CENTER);
    }
    refresh_now(window);
    gtk_window_present(GTK_WINDOW(window->window));
    gtk_widget_grab_focus(window->canvas);
    return window;
}

void view_window_destroy(struct view_window *window)
{
    if (!window)
        return;
    if (window->follow_timer)
        g_source_remove(window->follow_timer);
    if (window->notice_timer)
        g_source_remove(window->notice_timer);
    gtk_window_destroy(GTK_WINDOW(window->window));
    g_object_unref(window->window);
    g_free(window->error);
    g_free(window->dismissed);
    g_free(window->notice);
    g_free(window);
}
