/* viewer/panel_object.c: the objects: which, where, what they do to light. */
#include <string.h>

#include "focus.h"
#include "form.h"
#include "panels.h"

struct panel {
    struct view_app *app;
    GtkWidget *list, *body, *note, *facts, *place[3], *turn;
    const struct view_scene *listed;
};

static bool picked(struct panel *panel, size_t *out)
{
    const struct view_app *app = panel->app;
    *out = app->pick.index;
    return app->scene && app->pick.type == VIEW_PICK_OBJECT &&
           app->pick.index < app->state.object_count;
}

static void on_list(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    guint index = gtk_drop_down_get_selected(drop);
    if (index == GTK_INVALID_LIST_POSITION)
        return;
    if (index == 0)
        view_app_select(panel->app, VIEW_PICK_NONE, 0);
    else
        view_app_select(panel->app, VIEW_PICK_OBJECT, index - 1);
}

static void on_place(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    size_t object;
    vec3 middle;
    if (!picked(panel, &object) || !view_app_pick_place(panel->app, panel->app->pick, &middle))
        return;
    const double now[3] = {middle.x, middle.y, middle.z};
    double by[3] = {0};
    for (int k = 0; k < 3; k++)
        if (GTK_WIDGET(spin) == panel->place[k] && view_form_differs(panel->place[k], now[k]))
            by[k] = gtk_spin_button_get_value(spin) - now[k];
    if (by[0] == 0 && by[1] == 0 && by[2] == 0)
        return;
    view_app_pick_move(panel->app, panel->app->pick, v3_load(by));
    view_app_edited(panel->app);
}

static double heading(const double m[12])
{
    return atan2(m[0], m[8]) * 180 / M_PI;
}

static void on_turn(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    size_t object;
    vec3 middle;
    if (!picked(panel, &object) || !view_app_pick_place(panel->app, panel->app->pick, &middle))
        return;
    double *m = panel->app->state.placements[object];
    double now = heading(m) - heading(panel->app->scene->objects[object].world_from_mesh);
    double by = (gtk_spin_button_get_value(spin) - now) * M_PI / 180;
    if (!isfinite(by) || fabs(by) < 1e-6)
        return;
    for (int column = 0; column < 4; column++) {
        vec3 p = v3(m[column], m[4 + column], m[8 + column]);
        p = column == 3 ? v3_add(middle, v3_turn(v3_sub(p, middle), v3(0, 1, 0), by))
                        : v3_turn(p, v3(0, 1, 0), by);
        m[column] = p.x;
        m[4 + column] = p.y;
        m[8 + column] = p.z;
    }
    view_app_edited(panel->app);
}

static void on_reset(GtkButton *button, gpointer data)
{
    struct panel *panel = data;
    size_t object;
    if (!picked(panel, &object))
        return;
    memcpy(panel->app->state.placements[object], panel->app->scene->objects[object].world_from_mesh,
           sizeof(panel->app->state.placements[object]));
    view_app_changed(panel->app);
}

GtkWidget *view_panel_object_new(struct view_app *app)
{
    static const char *const axis_names[3] = {"x", "y (up)", "z"};
    static const char *const place_names[3] = {"Position x", "Position y, up", "Position z"};
    struct panel *panel = g_new0(struct panel, 1);
    GtkWidget *box, *page = view_form_page(&box);
    panel->app = app;
    g_object_set_data_full(G_OBJECT(page), "panel", panel, g_free);
    panel->list = gtk_drop_down_new(G_LIST_MODEL(gtk_string_list_new(NULL)), NULL);
    view_focus_name(panel->list, "Object");
    gtk_drop_down_set_enable_search(GTK_DROP_DOWN(panel->list), TRUE);
    GtkExpression *expression = gtk_property_expression_new(GTK_TYPE_STRING_OBJECT, NULL, "string");
    gtk_drop_down_set_expression(GTK_DROP_DOWN(panel->list), expression);
    gtk_expression_unref(expression);
    g_signal_connect(panel->list, "notify::selected", G_CALLBACK(on_list), panel);
    gtk_box_append(GTK_BOX(box), panel->list);
    panel->note = view_form_note(box);
    view_form_set_note(panel->note, "Click an object in the picture, or choose one above, to move "
                                    "and turn it.");
    panel->body = gtk_box_new(GTK_ORIENTATION_VERTICAL, 12);
    gtk_box_append(GTK_BOX(box), panel->body);
    GtkWidget *group = view_form_group(panel->body, "Position, m");
    for (int k = 0; k < 3; k++) {
        panel->place[k] = view_form_spin(-1e6, 1e6, 0.05, 3);
        view_form_row(group, axis_names[k], panel->place[k], NULL);
        view_focus_name(panel->place[k], place_names[k]);
        g_signal_connect(panel->place[k], "value-changed", G_CALLBACK(on_place), panel);
    }
    group = view_form_group(panel->body, "Turned about the vertical");
    panel->turn = view_form_spin(-180, 180, 5, 1);
    gtk_spin_button_set_wrap(GTK_SPIN_BUTTON(panel->turn), TRUE);
    view_form_row(group, "_Degrees", panel->turn, NULL);
    g_signal_connect(panel->turn, "value-changed", G_CALLBACK(on_turn), panel);
    panel->facts = view_form_note(panel->body);
    GtkWidget *reset = gtk_button_new_with_mnemonic("_Put Back");
    gtk_widget_set_tooltip_text(reset, "To where the file has it");
    g_signal_connect(reset, "clicked", G_CALLBACK(on_reset), panel);
    gtk_box_append(GTK_BOX(panel->body), reset);
    return page;
}

static void fill_list(struct panel *panel)
{
    const struct view_scene *scene = panel->app->scene;
    const char **names = g_new0(const char *, scene->object_count + 2);
    names[0] = "No object";
    for (size_t i = 0; i < scene->object_count; i++)
        names[i + 1] = scene->objects[i].name;
    GtkStringList *list = gtk_string_list_new(names);
    g_free(names);
    gtk_drop_down_set_model(GTK_DROP_DOWN(panel->list), G_LIST_MODEL(list));
    g_object_unref(list);
    panel->listed = scene;
}

void view_panel_object_refresh(GtkWidget *page)
{
    struct panel *panel = g_object_get_data(G_OBJECT(page), "panel");
    const struct view_app *app = panel->app;
    size_t object;
    if (!app->scene)
        return;
    bool any = picked(panel, &object);
    g_signal_handlers_block_by_func(panel->list, on_list, panel);
    if (panel->listed != app->scene)
        fill_list(panel);
    gtk_drop_down_set_selected(GTK_DROP_DOWN(panel->list), any ? (guint)object + 1 : 0);
    g_signal_handlers_unblock_by_func(panel->list, on_list, panel);
    gtk_widget_set_visible(panel->body, any);
    gtk_widget_set_visible(panel->note, !any);
    if (!any)
        return;
    vec3 middle;
    const struct view_object *info = &app->scene->objects[object];
    view_app_pick_place(app, app->pick, &middle);
    const double place[3] = {middle.x, middle.y, middle.z};
    for (int k = 0; k < 3; k++)
        view_form_show_value(panel->place[k], place[k], panel);
    double turned = heading(app->state.placements[object]) - heading(info->world_from_mesh);
    turned -= 360 * floor((turned + 180) / 360);
    view_form_show_value(panel->turn, turned, panel);
    gtk_widget_set_sensitive(panel->turn, !info->plane);
    view_form_set_note(panel->facts, info->casts && info->receives ? "Casts and receives shadows."
                                     : info->casts    ? "Casts shadows and receives none."
                                     : info->receives ? "Receives shadows and casts none."
                                                      : "Neither casts nor receives shadows.");
}
