/* viewer/panel_motion.c: what moves along which path. */
#include "form.h"
#include "motion.h"
#include "panels.h"

struct panel {
    struct view_app *app;
    GtkWidget *what, *path, *size, *period, *play;
};

static void on_path(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    view_motion_settings(panel->app->motion)->path =
        (enum view_path)MIN(gtk_drop_down_get_selected(drop), VIEW_PATH_COUNT - 1);
}

static void on_size(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    if (panel->app->scene)
        view_motion_settings(panel->app->motion)->size =
            gtk_spin_button_get_value(spin) / panel->app->scene->radius;
}

static void on_period(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    view_motion_settings(panel->app->motion)->period = gtk_spin_button_get_value(spin);
}

static void on_play(GtkButton *button, gpointer data)
{
    struct panel *panel = data;
    if (view_motion_running(panel->app->motion))
        view_motion_stop(panel->app->motion);
    else
        view_motion_start(panel->app->motion);
}

static void on_rewind(GtkButton *button, gpointer data)
{
    struct panel *panel = data;
    view_motion_rewind(panel->app->motion);
}

GtkWidget *view_panel_motion_new(struct view_app *app)
{
    struct panel *panel = g_new0(struct panel, 1);
    GtkWidget *box, *page = view_form_page(&box);
    panel->app = app;
    g_object_set_data_full(G_OBJECT(page), "panel", panel, g_free);
    panel->what = view_form_note(box);
    GtkStringList *names = gtk_string_list_new(NULL);
    for (int i = 0; i < VIEW_PATH_COUNT; i++)
        gtk_string_list_append(names, view_path_name((enum view_path)i));
    panel->path = gtk_drop_down_new(G_LIST_MODEL(names), NULL);
    panel->size = view_form_spin(0.001, 1e6, 0.1, 3);
    panel->period = view_form_spin(0.5, 600, 0.5, 1);
    struct view_motion_settings *settings = view_motion_settings(app->motion);
    gtk_spin_button_set_value(GTK_SPIN_BUTTON(panel->period), settings->period);
    GtkWidget *group = view_form_group(box, "Path");
    view_form_row(group, "_Shape", panel->path, NULL);
    view_form_row(group, "_Radius, m", panel->size, NULL);
    view_form_row(group, "_Seconds a round", panel->period, NULL);
    g_signal_connect(panel->path, "notify::selected", G_CALLBACK(on_path), panel);
    g_signal_connect(panel->size, "value-changed", G_CALLBACK(on_size), panel);
    g_signal_connect(panel->period, "value-changed", G_CALLBACK(on_period), panel);

    GtkWidget *buttons = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 6);
    panel->play = gtk_button_new_with_mnemonic("_Play");
    GtkWidget *rewind = gtk_button_new_with_mnemonic("_Back to Start");
    gtk_widget_add_css_class(panel->play, "suggested-action");
    gtk_widget_set_hexpand(panel->play, TRUE);
    g_signal_connect(panel->play, "clicked", G_CALLBACK(on_play), panel);
    g_signal_connect(rewind, "clicked", G_CALLBACK(on_rewind), panel);
    gtk_box_append(GTK_BOX(buttons), panel->play);
    gtk_box_append(GTK_BOX(buttons), rewind);
    gtk_box_append(GTK_BOX(box), buttons);
    return page;
}

void view_panel_motion_refresh(GtkWidget *page)
{
    struct panel *panel = g_object_get_data(G_OBJECT(page), "panel");
    const struct view_app *app = panel->app;
    bool running = view_motion_running(app->motion);
    struct view_pick pick = view_motion_pick(app->motion);
    char *what;
    if (!app->scene)
        return;
    if (pick.type == VIEW_PICK_LIGHT)
        what = g_strdup_printf("%s light %zu.", running ? "Moving" : "Moves", pick.index + 1);
    else if (pick.type == VIEW_PICK_OBJECT && pick.index < app->scene->object_count)
        what = g_strdup_printf("%s %s.", running ? "Moving" : "Moves",
                               app->scene->objects[pick.index].name);
    else
        what = g_strdup("Select a light or an object first: click it in the picture.");
    view_form_set_note(panel->what, what);
    g_free(what);
    view_form_show_value(panel->size, view_motion_settings(app->motion)->size * app->scene->radius,
                         panel);
    gtk_button_set_label(GTK_BUTTON(panel->play), running ? "_Pause" : "_Play");
    gtk_widget_set_sensitive(panel->play, running || pick.type != VIEW_PICK_NONE);
}
