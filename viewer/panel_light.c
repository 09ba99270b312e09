/* viewer/panel_light.c: the lights: which, shape, place, size, orientation, colour. */
#include <string.h>

#include "focus.h"
#include "form.h"
#include "panels.h"

struct panel {
    struct view_app *app;
    GtkWidget *list, *remove, *shape, *body;
    size_t listed; /* lights in the list */
    GtkWidget *place[3], *size[2], *angle[3], *color, *strength;
    GtkWidget *place_group, *size_group, *size_row[2], *angle_group;
};

static struct view_light *light_of(struct panel *panel)
{
    struct view_state *state = &panel->app->state;
    return state->light < state->light_count ? &state->lights[state->light] : NULL;
}

static struct view_frame_axes axes_of(struct panel *panel)
{
    return view_light_axes(light_of(panel), view_app_middle(panel->app),
                           view_app_sun_distance(panel->app));
}

/* ---- handlers ---- */

static void on_list(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    guint index = gtk_drop_down_get_selected(drop);
    if (index != GTK_INVALID_LIST_POSITION && index < panel->app->state.light_count)
        view_app_select(panel->app, VIEW_PICK_LIGHT, index);
}

static void on_shape(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    pnb_light_type type = (pnb_light_type)gtk_drop_down_get_selected(drop);
    if (!light || light->light.type == type || type >= PNB_LIGHT_TYPE_COUNT)
        return;
    struct view_frame_axes axes = axes_of(panel);
    view_light_reshape(light, type, &axes, view_app_smallest(panel->app));
    if (type == PNB_LIGHT_SUN)
        memcpy(light->light.color, (double[3]){1, 1, 1}, sizeof(light->light.color));
    view_app_changed(panel->app);
}

static void on_place(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    if (!light)
        return;
    struct view_frame_axes axes = axes_of(panel);
    const double now[3] = {axes.center.x, axes.center.y, axes.center.z};
    double by[3] = {0};
    for (int k = 0; k < 3; k++)
        if (GTK_WIDGET(spin) == panel->place[k] && view_form_differs(panel->place[k], now[k]))
            by[k] = gtk_spin_button_get_value(spin) - now[k];
    if (by[0] == 0 && by[1] == 0 && by[2] == 0)
        return;
    view_light_move(light, v3_load(by), view_app_middle(panel->app),
                    view_app_sun_distance(panel->app));
    view_app_edited(panel->app);
}

/* What the size spin buttons show. */
static void sizes_of(struct panel *panel, const struct view_frame_axes *axes, double out[2])
{
    const pnb_light *light = &light_of(panel)->light;
    out[0] = 2 * axes->half_u;
    out[1] = 2 * axes->half_v;
    if (light->type == PNB_LIGHT_SUN)
        out[0] = light->shape.sun.angular_diameter_degrees;
}

static void on_size(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    if (!light)
        return;
    struct view_frame_axes axes = axes_of(panel);
    double now[2];
    sizes_of(panel, &axes, now);
    int k = GTK_WIDGET(spin) == panel->size[1];
    if (!view_form_differs(panel->size[k], now[k]))
        return;
    now[k] = gtk_spin_button_get_value(spin);
    double half = light->light.type == PNB_LIGHT_SUN ? tan(now[0] * M_PI / 360) : 0.5 * now[0];
    view_light_resize(light, &axes, half, light->light.type == PNB_LIGHT_SUN ? half : 0.5 * now[1],
                      light->light.type == PNB_LIGHT_SUN ? 1e-5 : view_app_smallest(panel->app));
    view_app_edited(panel->app);
}

/* A line's angles are those of its own direction. */
static void angles_of(struct panel *panel, const struct view_frame_axes *axes, double out[3])
{
    struct view_frame_axes shown = *axes;
    if (light_of(panel)->light.type == PNB_LIGHT_LINE) {
        shown.n = axes->u;
        shown.u = axes->n;
    }
    view_axes_angles(&shown, &out[0], &out[1], &out[2]);
}

static void on_angle(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    if (!light)
        return;
    struct view_frame_axes axes = axes_of(panel);
    double angles[3];
    vec3 u, n;
    bool changed = false;
    angles_of(panel, &axes, angles);
    for (int k = 0; k < 3; k++)
        if (GTK_WIDGET(spin) == panel->angle[k] && view_form_differs(panel->angle[k], angles[k])) {
            angles[k] = gtk_spin_button_get_value(spin);
            changed = true;
        }
    if (!changed)
        return;
    view_axes_from_angles(angles[0], angles[1], angles[2], &u, &n);
    if (light->light.type == PNB_LIGHT_LINE)
        view_light_aim(light, &axes, n, v3_unit(v3_cross(n, v3_cross(axes.n, n)), u));
    else
        view_light_aim(light, &axes, u, n);
    view_app_edited(panel->app);
}

/* Colours are radiometric and may exceed 1: shown as a hue of full brightness and a strength. */
static double strength_of(const pnb_light *light)
{
    double most = fmax(light->color[0], fmax(light->color[1], light->color[2]));
    return most > 0 ? most : 0;
}

static double to_linear(double e)
{
    return e <= 0.04045 ? e / 12.92 : pow((e + 0.055) / 1.055, 2.4);
}

static double from_linear(double x)
{
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055;
}

static void on_color(GtkColorButton *button, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    GdkRGBA rgba;
    if (!light)
        return;
    gtk_color_chooser_get_rgba(GTK_COLOR_CHOOSER(button), &rgba);
    double strength = strength_of(&light->light);
    double rgb[3] = {to_linear(rgba.red), to_linear(rgba.green), to_linear(rgba.blue)};
    for (int c = 0; c < 3; c++)
        light->light.color[c] = rgb[c] * (strength > 0 ? strength : 1);
    view_app_edited(panel->app);
}

static void on_strength(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    double value = gtk_spin_button_get_value(spin);
    if (!light || !view_form_differs(panel->strength, strength_of(&light->light)))
        return;
    double now = strength_of(&light->light);
    for (int c = 0; c < 3; c++)
        light->light.color[c] = now > 0 ? light->light.color[c] * value / now : value;
    view_app_edited(panel->app);
}

static void on_add(GtkButton *button, gpointer data)
{
    struct panel *panel = data;
    struct view_light *light = light_of(panel);
    view_app_add_light(panel->app, light ? light->light.type : PNB_LIGHT_RECTANGLE);
}

static void on_remove(GtkButton *button, gpointer data)
{
    struct panel *panel = data;
    view_app_remove_light(panel->app, panel->app->state.light);
}

/* ---- widgets ---- */

static GtkWidget *spin_row(struct panel *panel, GtkWidget *group, const char *label, double least,
                           double most, double step, int digits, GCallback handler,
                           GtkWidget **out_row)
{
    GtkWidget *spin = view_form_spin(least, most, step, digits);
    GtkWidget *row = view_form_row(group, label, spin, NULL);
    g_signal_connect(spin, "value-changed", handler, panel);
    if (out_row)
        *out_row = row;
    return spin;
}

static GtkWidget *list_row(struct panel *panel)
{
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 6);
    GtkWidget *add = gtk_button_new_from_icon_name("list-add-symbolic");
    panel->list = gtk_drop_down_new(G_LIST_MODEL(gtk_string_list_new(NULL)), NULL);
    panel->remove = gtk_button_new_from_icon_name("list-remove-symbolic");
    gtk_widget_set_hexpand(panel->list, TRUE);
    gtk_widget_set_tooltip_text(add, "Add a light");
    gtk_widget_set_tooltip_text(panel->remove, "Remove this light");
    view_focus_name(panel->list, "Light");
    view_focus_name(add, "Add a light");
    view_focus_name(panel->remove, "Remove this light");
    g_signal_connect(add, "clicked", G_CALLBACK(on_add), panel);
    g_signal_connect(panel->remove, "clicked", G_CALLBACK(on_remove), panel);
    g_signal_connect(panel->list, "notify::selected", G_CALLBACK(on_list), panel);
    gtk_box_append(GTK_BOX(box), panel->list);
    gtk_box_append(GTK_BOX(box), add);
    gtk_box_append(GTK_BOX(box), panel->remove);
    return box;
}

GtkWidget *view_panel_light_new(struct view_app *app)
{
    static const char *const axis_names[3] = {"x", "y (up)", "z"};
    static const char *const place_names[3] = {"Position x", "Position y, up", "Position z"};
    static const char *const shapes[] = {"Rectangle", "Disk", "Polygon", "Line",
                                         "Point",     "Sun",  NULL};
    struct panel *panel = g_new0(struct panel, 1);
    GtkWidget *box, *page = view_form_page(&box);
    panel->app = app;
    g_object_set_data_full(G_OBJECT(page), "panel", panel, g_free);
    gtk_box_append(GTK_BOX(box), list_row(panel));
    panel->body = gtk_box_new(GTK_ORIENTATION_VERTICAL, 12);
    gtk_box_append(GTK_BOX(box), panel->body);

    GtkWidget *group = view_form_group(panel->body, NULL);
    panel->shape = gtk_drop_down_new_from_strings(shapes);
    view_form_row(group, "_Shape", panel->shape, NULL);
    g_signal_connect(panel->shape, "notify::selected", G_CALLBACK(on_shape), panel);
    panel->color = gtk_color_button_new();
    view_form_row(group, "_Colour", panel->color, NULL);
    g_signal_connect(panel->color, "notify::rgba", G_CALLBACK(on_color), panel);
    panel->strength =
        spin_row(panel, group, "Stren_gth", 0, 1e6, 0.1, 3, G_CALLBACK(on_strength), NULL);

    group = panel->size_group = view_form_group(panel->body, "Size");
    panel->size[0] = spin_row(panel, group, "_Width, m", 0.0001, 1e6, 0.05, 3, G_CALLBACK(on_size),
                              &panel->size_row[0]);
    panel->size[1] = spin_row(panel, group, "_Height, m", 0.0001, 1e6, 0.05, 3, G_CALLBACK(on_size),
                              &panel->size_row[1]);

    group = panel->place_group = view_form_group(panel->body, "Position, m");
    for (int k = 0; k < 3; k++) {
        panel->place[k] =
            spin_row(panel, group, axis_names[k], -1e6, 1e6, 0.05, 3, G_CALLBACK(on_place), NULL);
        view_focus_name(panel->place[k], place_names[k]);
    }

    group = panel->angle_group = view_form_group(panel->body, "Orientation, degrees");
    panel->angle[0] =
        spin_row(panel, group, "_Azimuth", -180, 180, 5, 1, G_CALLBACK(on_angle), NULL);
    panel->angle[1] =
        spin_row(panel, group, "_Elevation", -90, 90, 5, 1, G_CALLBACK(on_angle), NULL);
    panel->angle[2] = spin_row(panel, group, "_Twist", -180, 180, 5, 1, G_CALLBACK(on_angle), NULL);
    gtk_spin_button_set_wrap(GTK_SPIN_BUTTON(panel->angle[0]), TRUE);
    gtk_spin_button_set_wrap(GTK_SPIN_BUTTON(panel->angle[2]), TRUE);
    return page;
}

static void show_list(struct panel *panel)
{
    const struct view_state *state = &panel->app->state;
    GtkStringList *names = GTK_STRING_LIST(gtk_drop_down_get_model(GTK_DROP_DOWN(panel->list)));
    g_signal_handlers_block_by_func(panel->list, on_list, panel);
    for (size_t i = 0; i < state->light_count; i++) {
        char text[64];
        g_snprintf(text, sizeof(text), "Light %zu: %s", i + 1,
                   pnb_light_type_name(state->lights[i].light.type));
        const char *old = i < panel->listed ? gtk_string_list_get_string(names, (guint)i) : NULL;
        if (g_strcmp0(old, text) != 0)
            gtk_string_list_splice(names, (guint)i, old ? 1 : 0, (const char *const[]){text, NULL});
    }
    if (panel->listed > state->light_count)
        gtk_string_list_splice(names, (guint)state->light_count,
                               (guint)(panel->listed - state->light_count), NULL);
    panel->listed = state->light_count;
    if (state->light_count > 0)
        gtk_drop_down_set_selected(GTK_DROP_DOWN(panel->list), (guint)state->light);
    g_signal_handlers_unblock_by_func(panel->list, on_list, panel);
    gtk_widget_set_sensitive(panel->list, state->light_count > 0);
    gtk_widget_set_sensitive(panel->remove, state->light_count > 0);
}

static void set_row_label(GtkWidget *row, const char *text)
{
    GtkWidget *box = gtk_list_box_row_get_child(GTK_LIST_BOX_ROW(row));
    gtk_label_set_text_with_mnemonic(GTK_LABEL(gtk_widget_get_first_child(box)), text);
}

static void show_color(struct panel *panel, const pnb_light *light)
{
    double strength = strength_of(light);
    GdkRGBA rgba = {1, 1, 1, 1};
    if (strength > 0) {
        rgba.red = (float)from_linear(light->color[0] / strength);
        rgba.green = (float)from_linear(light->color[1] / strength);
        rgba.blue = (float)from_linear(light->color[2] / strength);
    }
    g_signal_handlers_block_by_func(panel->color, on_color, panel);
    gtk_color_chooser_set_rgba(GTK_COLOR_CHOOSER(panel->color), &rgba);
    g_signal_handlers_unblock_by_func(panel->color, on_color, panel);
    view_form_show_value(panel->strength, strength, panel);
}

void view_panel_light_refresh(GtkWidget *page)
{
    struct panel *panel = g_object_get_data(G_OBJECT(page), "panel");
    struct view_light *light = light_of(panel);
    show_list(panel);
    gtk_widget_set_visible(panel->body, light != NULL);
    if (!light)
        return;
    pnb_light_type type = light->light.type;
    g_signal_handlers_block_by_func(panel->shape, on_shape, panel);
    gtk_drop_down_set_selected(GTK_DROP_DOWN(panel->shape), (guint)type);
    g_signal_handlers_unblock_by_func(panel->shape, on_shape, panel);
    show_color(panel, &light->light);

    struct view_frame_axes axes = axes_of(panel);
    double sizes[2], angles[3];
    sizes_of(panel, &axes, sizes);
    angles_of(panel, &axes, angles);
    const double place[3] = {axes.center.x, axes.center.y, axes.center.z};
    for (int k = 0; k < 3; k++) {
        view_form_show_value(panel->place[k], place[k], panel);
        view_form_show_value(panel->angle[k], angles[k], panel);
    }
    for (int k = 0; k < 2; k++)
        view_form_show_value(panel->size[k], sizes[k], panel);

    bool flat = type == PNB_LIGHT_RECTANGLE || type == PNB_LIGHT_POLYGON;
    set_row_label(panel->size_row[0], type == PNB_LIGHT_SUN    ? "_Diameter, degrees"
                                      : type == PNB_LIGHT_LINE ? "_Length, m"
                                      : type == PNB_LIGHT_DISK ? "_Diameter, m"
                                                               : "_Width, m");
    gtk_widget_set_visible(panel->size_row[1], flat);
    GtkWidget *size_title = gtk_widget_get_prev_sibling(panel->size_group);
    gtk_widget_set_visible(panel->size_group, type != PNB_LIGHT_POINT);
    gtk_widget_set_visible(size_title, type != PNB_LIGHT_POINT);
    GtkWidget *angle_title = gtk_widget_get_prev_sibling(panel->angle_group);
    gtk_widget_set_visible(panel->angle_group, type != PNB_LIGHT_POINT);
    gtk_widget_set_visible(angle_title, type != PNB_LIGHT_POINT);
    GtkWidget *place_title = gtk_widget_get_prev_sibling(panel->place_group);
    gtk_widget_set_visible(panel->place_group, type != PNB_LIGHT_SUN);
    gtk_widget_set_visible(place_title, type != PNB_LIGHT_SUN);
    gtk_widget_set_visible(gtk_widget_get_parent(gtk_widget_get_parent(panel->angle[2])), flat);
}
