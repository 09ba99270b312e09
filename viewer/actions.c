/* viewer/actions.c: everything that a button, a menu or a key does, as named actions.
 *
 * Keys with Control or of the function row work everywhere. Single letters work while the canvas
 * has the focus, so that they can be typed elsewhere.
 */
#include "actions.h"

#include <string.h>

#include "canvas.h"
#include "focus.h"
#include "motion.h"
#include "window.h"

static struct view_app *app_of(gpointer data)
{
    return data;
}

static GtkWindow *window_of(gpointer data)
{
    return GTK_WINDOW(view_window_widget(app_of(data)->window));
}

/* ---- files ---- */

static void on_open_response(GtkNativeDialog *dialog, int response, gpointer data)
{
    if (response == GTK_RESPONSE_ACCEPT) {
        GFile *file = gtk_file_chooser_get_file(GTK_FILE_CHOOSER(dialog));
        char *path = file ? g_file_get_path(file) : NULL;
        if (path)
            view_app_open(app_of(data), path);
        else
            view_window_error(app_of(data)->window, "open: that is no local file");
        g_free(path);
        g_clear_object(&file);
    }
    g_object_unref(dialog);
}

static void add_filter(GtkFileChooser *chooser, const char *name, const char *const *patterns)
{
    GtkFileFilter *filter = gtk_file_filter_new();
    gtk_file_filter_set_name(filter, name);
    for (int i = 0; patterns[i]; i++)
        gtk_file_filter_add_pattern(filter, patterns[i]);
    gtk_file_chooser_add_filter(chooser, filter);
    g_object_unref(filter);
}

static void do_open(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    GtkFileChooserNative *dialog = gtk_file_chooser_native_new(
        "Open a Scene", window_of(data), GTK_FILE_CHOOSER_ACTION_OPEN, "_Open", "_Cancel");
    add_filter(GTK_FILE_CHOOSER(dialog), "Scenes and meshes",
               (const char *const[]){"*.json", "*.glb", "*.gltf", "*.obj", "*.ply", "*.stl",
                                     "*.off", "*.dae", "*.fbx", "*.3ds", "*.x3d", "*.blend", NULL});
    add_filter(GTK_FILE_CHOOSER(dialog), "All files", (const char *const[]){"*", NULL});
    g_signal_connect(dialog, "response", G_CALLBACK(on_open_response), data);
    gtk_native_dialog_show(GTK_NATIVE_DIALOG(dialog));
}

static char *with_ending(char *path, const char *ending, const char *other)
{
    if (g_str_has_suffix(path, ending) || (other && g_str_has_suffix(path, other)))
        return path;
    char *longer = g_strconcat(path, ending, NULL);
    g_free(path);
    return longer;
}

static void on_save_response(GtkNativeDialog *dialog, int response, gpointer data)
{
    if (response == GTK_RESPONSE_ACCEPT) {
        GFile *file = gtk_file_chooser_get_file(GTK_FILE_CHOOSER(dialog));
        char *path = file ? g_file_get_path(file) : NULL;
        bool picture = g_object_get_data(G_OBJECT(dialog), "picture") != NULL;
        if (path) {
            path = picture ? with_ending(path, ".png", NULL) : with_ending(path, ".json", ".glb");
            if (picture)
                view_app_screenshot(app_of(data), path);
            else
                view_app_save(app_of(data), path);
        } else {
            view_window_error(app_of(data)->window, "save: that is no local file");
        }
        g_free(path);
        g_clear_object(&file);
    }
    g_object_unref(dialog);
}

static void ask_for_name(struct view_app *app, bool picture)
{
    if (!app->scene)
        return;
    GtkFileChooserNative *dialog = gtk_file_chooser_native_new(
        picture ? "Save a Screenshot" : "Save the Scene", window_of(app),
        GTK_FILE_CHOOSER_ACTION_SAVE, "_Save", "_Cancel");
    const char *name =
        g_str_has_prefix(app->scene->name, "builtin:") ? app->scene->name + 8 : app->scene->name;
    const char *dot = strrchr(name, '.');
    int length = dot && dot > name ? (int)(dot - name) : (int)strlen(name);
    char *file = g_strdup_printf("%.*s%s", length, name, picture ? ".png" : ".json");
    gtk_file_chooser_set_current_name(GTK_FILE_CHOOSER(dialog), file);
    g_free(file);
    if (picture)
        g_object_set_data(G_OBJECT(dialog), "picture", dialog);
    g_signal_connect(dialog, "response", G_CALLBACK(on_save_response), app);
    gtk_native_dialog_show(GTK_NATIVE_DIALOG(dialog));
}

static void do_save(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    ask_for_name(data, false);
}

static void do_screenshot(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    ask_for_name(data, true);
}

static void do_builtin(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    char *path = g_strconcat("builtin:", g_variant_get_string(parameter, NULL), NULL);
    view_app_open(app_of(data), path);
    g_free(path);
}

/* ---- what is shown ---- */

static const char *const show_names[] = {"picture", "visibility", "error"};

static void do_show(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    const char *name = g_variant_get_string(parameter, NULL);
    for (int i = 0; i < 3; i++)
        if (strcmp(name, show_names[i]) == 0)
            app->state.show = (enum view_show)i;
    view_app_changed(app);
    view_actions_refresh(app);
}

static void do_compare(GSimpleAction *action, GVariant *value, gpointer data)
{
    struct view_app *app = data;
    app->state.compare = g_variant_get_boolean(value);
    view_app_changed(app);
    view_actions_refresh(app);
}

static void do_handles(GSimpleAction *action, GVariant *value, gpointer data)
{
    g_simple_action_set_state(action, value);
    view_canvas_set_handles(view_window_canvas(app_of(data)->window), g_variant_get_boolean(value));
}

static void do_side(GSimpleAction *action, GVariant *value, gpointer data)
{
    GtkWidget *side = g_object_get_data(G_OBJECT(window_of(data)), "side");
    g_simple_action_set_state(action, value);
    gtk_widget_set_visible(side, g_variant_get_boolean(value));
}

static void do_theme(GSimpleAction *action, GVariant *value, gpointer data)
{
    const char *name = g_variant_get_string(value, NULL);
    GtkSettings *settings = gtk_settings_get_default();
    bool system = GPOINTER_TO_INT(g_object_get_data(G_OBJECT(window_of(data)), "dark"));
    bool dark = strcmp(name, "dark") == 0 || (strcmp(name, "system") == 0 && system);
    g_simple_action_set_state(action, value);
    g_object_set(settings, "gtk-application-prefer-dark-theme", dark, NULL);
}

/* Locked: the factor from light to picture stays as it is, so that strength and distance of lights
 * show; else it follows the lights, as in 'render'. */
static void do_exposure(GSimpleAction *action, GVariant *value, gpointer data)
{
    struct view_app *app = data;
    g_simple_action_set_state(action, value);
    app->state.exposure = 0;
    if (g_variant_get_boolean(value) && app->frame)
        app->state.exposure = app->frame->exposure;
    view_app_changed(app);
}

static void do_fullscreen(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    if (gtk_window_is_fullscreen(window_of(data)))
        gtk_window_unfullscreen(window_of(data));
    else
        gtk_window_fullscreen(window_of(data));
}

/* ---- the rest ---- */

static void do_reset_camera(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_app_reset_camera(data);
}

static void do_frame_selection(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_app_frame_selection(data);
}

static void do_zoom(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_canvas_zoom(view_window_canvas(app_of(data)->window), g_variant_get_double(parameter));
}

static void do_play(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    if (view_motion_running(app->motion))
        view_motion_stop(app->motion);
    else
        view_motion_start(app->motion);
}

static void do_rewind(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_motion_rewind(app_of(data)->motion);
}

static void do_stop(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_motion_stop(app_of(data)->motion);
    view_app_stop(data);
    gtk_widget_grab_focus(GTK_WIDGET(view_window_canvas(app_of(data)->window)));
}

static void do_method(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    size_t count = pnb_method_count(), index = 0;
    int by = g_variant_get_int32(parameter);
    for (size_t i = 0; i < count; i++)
        if (pnb_method(i) == app->state.methods[0].info)
            index = i;
    view_app_set_method(app, 0, pnb_method((index + count + (size_t)(by + (int)count)) % count));
}

static void do_swap(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    struct view_method first = app->state.methods[0];
    app->state.methods[0] = app->state.methods[1];
    app->state.methods[1] = first;
    view_app_changed(app);
}

static void do_add_light(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_app_add_light(data, PNB_LIGHT_RECTANGLE);
    view_window_page(app_of(data)->window, "light");
}

static void do_remove_light(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    if (app_of(data)->pick.type == VIEW_PICK_LIGHT)
        view_app_remove_light(data, app_of(data)->pick.index);
}

static void do_undo(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_app_undo(data, -1);
}

static void do_redo(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_app_undo(data, 1);
}

static void do_next_light(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    size_t count = app->state.light_count;
    if (count > 0)
        view_app_select(app, VIEW_PICK_LIGHT,
                        app->pick.type == VIEW_PICK_LIGHT ? (app->pick.index + 1) % count
                                                          : app->state.light);
}

static void do_next_object(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    struct view_app *app = data;
    size_t count = app->state.object_count;
    if (count > 0)
        view_app_select(app, VIEW_PICK_OBJECT,
                        app->pick.type == VIEW_PICK_OBJECT ? (app->pick.index + 1) % count : 0);
}

static void do_page(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    view_window_page(app_of(data)->window, g_variant_get_string(parameter, NULL));
}

static void do_shortcuts(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    GtkBuilder *builder = gtk_builder_new_from_resource("/penumbra/shortcuts.ui");
    GtkWindow *window = GTK_WINDOW(gtk_builder_get_object(builder, "shortcuts"));
    gtk_window_set_transient_for(window, window_of(data));
    gtk_window_present(window);
    g_object_unref(builder);
}

static void do_about(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    gtk_show_about_dialog(
        window_of(data), "program-name", "penumbra", "version", pnb_version(), "comments",
        "Soft shadows from area lights, every method beside the truth.", "license-type",
        GTK_LICENSE_MIT_X11, "logo-icon-name", "weather-clear-symbolic", NULL);
}

static void do_quit(GSimpleAction *action, GVariant *parameter, gpointer data)
{
    gtk_window_close(window_of(data));
}

static const GActionEntry entries[] = {
    {"open", do_open},
    {"save", do_save},
    {"screenshot", do_screenshot},
    {"builtin", do_builtin, "s"},
    {"show", do_show, "s", "'picture'"},
    {"compare", NULL, NULL, "false", do_compare},
    {"handles", NULL, NULL, "true", do_handles},
    {"side", NULL, NULL, "true", do_side},
    {"theme", NULL, "s", "'system'", do_theme},
    {"exposure", NULL, NULL, "false", do_exposure},
    {"fullscreen", do_fullscreen},
    {"reset-camera", do_reset_camera},
    {"frame-selection", do_frame_selection},
    {"zoom", do_zoom, "d"},
    {"play", do_play},
    {"rewind", do_rewind},
    {"stop", do_stop},
    {"method", do_method, "i"},
    {"swap", do_swap},
    {"add-light", do_add_light},
    {"remove-light", do_remove_light},
    {"undo", do_undo},
    {"redo", do_redo},
    {"next-light", do_next_light},
    {"next-object", do_next_object},
    {"page", do_page, "s"},
    {"shortcuts", do_shortcuts},
    {"about", do_about},
    {"quit", do_quit},
};

/* ---- keys ---- */

static const struct {
    const char *action, *keys[3];
} everywhere[] = {
    {"win.open", {"<Control>o"}},
    {"win.save", {"<Control>s"}},
    {"win.screenshot", {"<Control>p"}},
    {"win.undo", {"<Control>z"}},
    {"win.redo", {"<Control><Shift>z", "<Control>y"}},
    {"win.quit", {"<Control>q", "<Control>w"}},
    {"win.shortcuts", {"<Control>question", "F1"}},
    {"win.side", {"F9"}},
    {"win.fullscreen", {"F11"}},
    {"win.stop", {"Escape"}},
    {"win.add-light", {"<Control>l"}},
    {"win.compare", {"<Control>d"}},
    {"win.page('method')", {"<Alt>1"}},
    {"win.page('light')", {"<Alt>2"}},
    {"win.page('object')", {"<Alt>3"}},
    {"win.page('motion')", {"<Alt>4"}},
};

static const struct {
    const char *key, *action;
} alone[] = {
    {"1", "win.show('picture')"},
    {"2", "win.show('visibility')"},
    {"3", "win.show('error')"},
    {"c", "win.compare"},
    {"x", "win.swap"},
    {"m", "win.method(1)"},
    {"<Shift>m", "win.method(-1)"},
    {"h", "win.handles"},
    {"l", "win.next-light"},
    {"o", "win.next-object"},
    {"Delete", "win.remove-light"},
    {"f", "win.frame-selection"},
    {"Home", "win.reset-camera"},
    {"space", "win.play"},
    {"BackSpace", "win.rewind"},
    {"plus", "win.zoom(0.9)"},
    {"equal", "win.zoom(0.9)"},
    {"minus", "win.zoom(1.1)"},
    {"e", "win.exposure"},
    {"KP_Add", "win.zoom(0.9)"},
    {"KP_Subtract", "win.zoom(1.1)"},
};

static void add_keys(struct view_app *app)
{
    for (gsize i = 0; i < G_N_ELEMENTS(everywhere); i++)
        gtk_application_set_accels_for_action(app->application, everywhere[i].action,
                                              everywhere[i].keys);
    GtkEventController *controller = gtk_shortcut_controller_new();
    for (gsize i = 0; i < G_N_ELEMENTS(alone); i++) {
        char *name = NULL;
        GVariant *target = NULL;
        if (!g_action_parse_detailed_name(alone[i].action, &name, &target, NULL))
            continue;
        GtkShortcut *shortcut = gtk_shortcut_new(gtk_shortcut_trigger_parse_string(alone[i].key),
                                                 gtk_named_action_new(name));
        gtk_shortcut_set_arguments(shortcut, target);
        gtk_shortcut_controller_add_shortcut(GTK_SHORTCUT_CONTROLLER(controller), shortcut);
        g_free(name);
        if (target)
            g_variant_unref(target);
    }
    /* Wherever the focus is: an entry keeps the keys that it types, a button its space. */
    gtk_widget_add_controller(view_window_widget(app->window), controller);
}

/* ---- the header bar ---- */

static GMenuModel *make_menu(void)
{
    GMenu *menu = g_menu_new(), *part = g_menu_new(), *theme = g_menu_new();
    g_menu_append(part, "_Save Scene…", "win.save");
    g_menu_append(part, "Save S_creenshot…", "win.screenshot");
    g_menu_append_section(menu, NULL, G_MENU_MODEL(part));
    g_object_unref(part);
    part = g_menu_new();
    g_menu_append(part, "_Undo", "win.undo");
    g_menu_append(part, "_Redo", "win.redo");
    g_menu_append_section(menu, NULL, G_MENU_MODEL(part));
    g_object_unref(part);
    part = g_menu_new();
    g_menu_append(part, "Lights and _Handles", "win.handles");
    g_menu_append(part, "Lock _Exposure", "win.exposure");
    g_menu_append(part, "Side _Bar", "win.side");
    g_menu_append(part, "_Reset Camera", "win.reset-camera");
    g_menu_append(part, "_Full Screen", "win.fullscreen");
    g_menu_append_section(menu, NULL, G_MENU_MODEL(part));
    g_object_unref(part);
    part = g_menu_new();
    g_menu_append(theme, "As the _System", "win.theme::system");
    g_menu_append(theme, "_Light", "win.theme::light");
    g_menu_append(theme, "_Dark", "win.theme::dark");
    g_menu_append_submenu(part, "_Theme", G_MENU_MODEL(theme));
    g_menu_append_section(menu, NULL, G_MENU_MODEL(part));
    g_object_unref(part);
    g_object_unref(theme);
    part = g_menu_new();
    g_menu_append(part, "_Keyboard Shortcuts", "win.shortcuts");
    g_menu_append(part, "_About penumbra", "win.about");
    g_menu_append_section(menu, NULL, G_MENU_MODEL(part));
    g_object_unref(part);
    return G_MENU_MODEL(menu);
}

static void on_builtin_row(GtkListBox *list, GtkListBoxRow *row, gpointer popover)
{
    const char *name = g_object_get_data(G_OBJECT(row), "name");
    gtk_popover_popdown(GTK_POPOVER(popover));
    gtk_widget_activate_action(GTK_WIDGET(list), "win.builtin", "s", name);
}

/* The built-in scenes, in a list that scrolls. */
static GtkWidget *make_scenes(void)
{
    GtkWidget *popover = gtk_popover_new(), *scroll = gtk_scrolled_window_new();
    GtkWidget *list = gtk_list_box_new();
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_builtin(i, &info);
        GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 0);
        GtkWidget *name = gtk_label_new(info.name), *title = gtk_label_new(info.title);
        gtk_label_set_xalign(GTK_LABEL(name), 0);
        gtk_label_set_xalign(GTK_LABEL(title), 0);
        gtk_widget_add_css_class(title, "note");
        gtk_box_append(GTK_BOX(box), name);
        gtk_box_append(GTK_BOX(box), title);
        gtk_list_box_append(GTK_LIST_BOX(list), box);
        GtkListBoxRow *row = gtk_list_box_get_row_at_index(GTK_LIST_BOX(list), (int)i);
        g_object_set_data_full(G_OBJECT(row), "name", g_strdup(info.name), g_free);
    }
    gtk_list_box_set_selection_mode(GTK_LIST_BOX(list), GTK_SELECTION_NONE);
    g_signal_connect(list, "row-activated", G_CALLBACK(on_builtin_row), popover);
    gtk_scrolled_window_set_child(GTK_SCROLLED_WINDOW(scroll), list);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scroll), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
    gtk_scrolled_window_set_min_content_height(GTK_SCROLLED_WINDOW(scroll), 420);
    gtk_popover_set_child(GTK_POPOVER(popover), scroll);
    return popover;
}

static GtkWidget *toggle(const char *label, const char *action, const char *tooltip)
{
    GtkWidget *button = gtk_toggle_button_new_with_mnemonic(label);
    gtk_actionable_set_detailed_action_name(GTK_ACTIONABLE(button), action);
    gtk_widget_set_tooltip_text(button, tooltip);
    gtk_widget_set_focus_on_click(button, FALSE);
    return button;
}

static void fill_header(GtkWidget *header)
{
    GtkWidget *open = gtk_button_new_with_mnemonic("_Open");
    gtk_actionable_set_action_name(GTK_ACTIONABLE(open), "win.open");
    gtk_widget_set_tooltip_text(open, "Open a scene or mesh (Ctrl+O); files can be dropped too");
    GtkWidget *scenes = gtk_menu_button_new();
    gtk_menu_button_set_label(GTK_MENU_BUTTON(scenes), "S_cenes");
    gtk_menu_button_set_use_underline(GTK_MENU_BUTTON(scenes), TRUE);
    gtk_menu_button_set_popover(GTK_MENU_BUTTON(scenes), make_scenes());
    gtk_widget_set_tooltip_text(scenes, "The built-in scenes");
    gtk_header_bar_pack_start(GTK_HEADER_BAR(header), open);
    gtk_header_bar_pack_start(GTK_HEADER_BAR(header), scenes);

    GtkWidget *menu = gtk_menu_button_new();
    GMenuModel *model = make_menu();
    gtk_menu_button_set_icon_name(GTK_MENU_BUTTON(menu), "open-menu-symbolic");
    gtk_menu_button_set_menu_model(GTK_MENU_BUTTON(menu), model);
    gtk_menu_button_set_primary(GTK_MENU_BUTTON(menu), TRUE);
    gtk_widget_set_tooltip_text(menu, "Menu (F10)");
    view_focus_name(menu, "Menu");
    g_object_unref(model);
    GtkWidget *shows = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 0);
    gtk_widget_add_css_class(shows, "linked");
    gtk_box_append(GTK_BOX(shows), toggle("_Picture", "win.show::picture", "Shaded (1)"));
    gtk_box_append(GTK_BOX(shows), toggle("_Visibility", "win.show::visibility",
                                          "How much of the light each pixel sees (2)"));
    gtk_box_append(GTK_BOX(shows),
                   toggle("_Error", "win.show::error", "Difference from the ray-traced truth (3)"));
    GtkWidget *compare =
        toggle("_Compare", "win.compare", "A second method right of a divider (C, Ctrl+D)");
    gtk_header_bar_pack_end(GTK_HEADER_BAR(header), menu);
    gtk_header_bar_pack_end(GTK_HEADER_BAR(header), compare);
    gtk_header_bar_pack_start(GTK_HEADER_BAR(header), shows);
}

void view_actions_install(struct view_app *app, GtkWidget *header, GtkWidget *side)
{
    GtkWidget *window = view_window_widget(app->window);
    gboolean dark;
    g_object_get(gtk_settings_get_default(), "gtk-application-prefer-dark-theme", &dark, NULL);
    g_object_set_data(G_OBJECT(window), "side", side);
    g_object_set_data(G_OBJECT(window), "dark", GINT_TO_POINTER(dark));
    g_action_map_add_action_entries(G_ACTION_MAP(window), entries, G_N_ELEMENTS(entries), app);
    fill_header(header);
    add_keys(app);
}

static void set_state(struct view_app *app, const char *name, GVariant *value)
{
    GAction *action =
        g_action_map_lookup_action(G_ACTION_MAP(view_window_widget(app->window)), name);
    if (action)
        g_simple_action_set_state(G_SIMPLE_ACTION(action), value);
}

static void set_enabled(struct view_app *app, const char *name, bool on)
{
    GAction *action =
        g_action_map_lookup_action(G_ACTION_MAP(view_window_widget(app->window)), name);
    if (action)
        g_simple_action_set_enabled(G_SIMPLE_ACTION(action), on);
}

void view_actions_refresh(struct view_app *app)
{
    set_enabled(app, "undo", view_history_can(app->history, -1));
    set_enabled(app, "redo", view_history_can(app->history, 1));
    set_state(app, "show", g_variant_new_string(show_names[app->state.show]));
    set_state(app, "compare", g_variant_new_boolean(app->state.compare));
    set_state(app, "exposure", g_variant_new_boolean(app->state.exposure > 0));
}
