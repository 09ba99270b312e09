/* viewer/panel_method.c: the methods of both sides, their parameters as the registry lists them,
 * and the figures against the truth. */
#include <string.h>

#include "form.h"
#include "panels.h"

struct side_form {
    struct panel *panel;
    int side;
    GtkWidget *drop, *note, *group, *figures;
    const pnb_method_info *shown; /* whose parameters the group holds */
    GtkWidget *samples;
    GtkWidget **controls; /* one per parameter */
};

struct panel {
    struct view_app *app;
    struct side_form sides[VIEW_SIDES];
    GtkWidget *compare, *second, *scale, *truth, *exposure;
};

static struct view_method *method_of(struct side_form *form)
{
    return &form->panel->app->state.methods[form->side];
}

/* ---- parameters ---- */

static void on_samples(GtkSpinButton *spin, gpointer data)
{
    struct side_form *form = data;
    method_of(form)->samples = gtk_spin_button_get_value_as_int(spin);
    view_app_edited(form->panel->app);
}

static void set_param(struct side_form *form, GtkWidget *control, const char *value)
{
    size_t index = GPOINTER_TO_SIZE(g_object_get_data(G_OBJECT(control), "param"));
    struct view_method *method = method_of(form);
    bool is_default = strcmp(value, method->info->params[index].default_value) == 0;
    if (g_strcmp0(is_default ? NULL : value, method->values[index]) == 0)
        return;
    g_free(method->values[index]);
    method->values[index] = is_default ? NULL : g_strdup(value);
    view_app_edited(form->panel->app);
}

static void on_number(GtkSpinButton *spin, gpointer data)
{
    char text[G_ASCII_DTOSTR_BUF_SIZE];
    g_ascii_formatd(text, sizeof(text), "%.9g", gtk_spin_button_get_value(spin));
    set_param(data, GTK_WIDGET(spin), text);
}

static void on_choice(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    GtkStringObject *item = gtk_drop_down_get_selected_item(drop);
    if (item)
        set_param(data, GTK_WIDGET(drop), gtk_string_object_get_string(item));
}

static void on_text(GtkEditable *entry, gpointer data)
{
    set_param(data, GTK_WIDGET(entry), gtk_editable_get_text(entry));
}

static GtkWidget *make_choice(const pnb_param_info *info, const char *value)
{
    char **words = g_strsplit(info->choices, "|", -1);
    GtkWidget *drop = gtk_drop_down_new_from_strings((const char *const *)words);
    for (guint i = 0; words[i]; i++)
        if (strcmp(words[i], value) == 0)
            gtk_drop_down_set_selected(GTK_DROP_DOWN(drop), i);
    g_strfreev(words);
    return drop;
}

static GtkWidget *make_control(struct side_form *form, size_t index)
{
    const struct view_method *method = method_of(form);
    const pnb_param_info *info = &method->info->params[index];
    const char *value = method->values[index] ? method->values[index] : info->default_value;
    GtkWidget *control;
    switch (info->type) {
    case PNB_PARAM_CHOICE: control = make_choice(info, value); break;
    case PNB_PARAM_INTEGER:
    case PNB_PARAM_NUMBER: {
        bool whole = info->type == PNB_PARAM_INTEGER;
        double range = info->maximum - info->minimum;
        double step = whole ? 1 : range <= 2 ? 0.01 : 0.1;
        control = view_form_spin(info->minimum, info->maximum, step, whole ? 0 : 3);
        gtk_spin_button_set_value(GTK_SPIN_BUTTON(control), g_ascii_strtod(value, NULL));
        break;
    }
    default:
        control = gtk_entry_new();
        gtk_editable_set_text(GTK_EDITABLE(control), value);
        gtk_editable_set_width_chars(GTK_EDITABLE(control), 10);
        gtk_editable_set_max_width_chars(GTK_EDITABLE(control), 10);
        break;
    }
    g_object_set_data(G_OBJECT(control), "param", GSIZE_TO_POINTER(index));
    if (info->type == PNB_PARAM_CHOICE)
        g_signal_connect(control, "notify::selected", G_CALLBACK(on_choice), form);
    else if (info->type == PNB_PARAM_TEXT)
        g_signal_connect(control, "changed", G_CALLBACK(on_text), form);
    else
        g_signal_connect(control, "value-changed", G_CALLBACK(on_number), form);
    return control;
}

static void build_params(struct side_form *form)
{
    const struct view_method *method = method_of(form);
    const pnb_method_info *info = method->info;
    view_form_clear(form->group);
    form->shown = info;
    form->samples = NULL;
    if (info->samples) {
        form->samples = view_form_spin(1, 65536, 1, 0);
        gtk_spin_button_set_value(GTK_SPIN_BUTTON(form->samples),
                                  method->samples ? method->samples : info->default_samples);
        g_signal_connect(form->samples, "value-changed", G_CALLBACK(on_samples), form);
        view_form_row(form->group, "Light samples", form->samples,
                      "Positions on the light at which the method looks");
    }
    for (size_t i = 0; i < info->param_count; i++)
        view_form_row(form->group, info->params[i].key, make_control(form, i),
                      info->params[i].summary);
    gtk_widget_set_visible(form->group, info->samples || info->param_count > 0);
    char *text = *info->paper ? g_strdup_printf("%s\n%s", info->summary, info->paper)
                              : g_strdup(info->summary);
    view_form_set_note(form->note, text);
    g_free(text);
}

/* ---- choosing ---- */

static void on_method(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct side_form *form = data;
    view_app_set_method(form->panel->app, form->side, pnb_method(gtk_drop_down_get_selected(drop)));
}

static void on_compare(GtkSwitch *toggle, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    bool on = gtk_switch_get_active(toggle);
    if (panel->app->state.compare == on)
        return;
    panel->app->state.compare = on;
    view_app_changed(panel->app);
}

static void on_scale(GtkSpinButton *spin, gpointer data)
{
    struct panel *panel = data;
    panel->app->state.error_scale = gtk_spin_button_get_value(spin);
    view_app_changed(panel->app);
}

static const int truth_choices[] = {0, 256, 1024, 4096, 16384};
static const char *const truth_names[] = {"Off", "256", "1024", "4096", "16384", NULL};

static void on_truth(GtkDropDown *drop, GParamSpec *spec, gpointer data)
{
    struct panel *panel = data;
    guint index = gtk_drop_down_get_selected(drop);
    if (index >= G_N_ELEMENTS(truth_choices) ||
        panel->app->state.truth_samples == truth_choices[index])
        return;
    panel->app->state.truth_samples = truth_choices[index];
    view_app_changed(panel->app);
}

static GtkWidget *method_drop(void)
{
    GtkStringList *names = gtk_string_list_new(NULL);
    for (size_t i = 0; i < pnb_method_count(); i++)
        gtk_string_list_append(names, pnb_method(i)->name);
    GtkWidget *drop = gtk_drop_down_new(G_LIST_MODEL(names), NULL);
    gtk_widget_set_size_request(drop, 170, -1);
    return drop;
}

static void add_side(struct panel *panel, GtkWidget *box, int side)
{
    struct side_form *form = &panel->sides[side];
    form->panel = panel;
    form->side = side;
    form->drop = method_drop();
    GtkWidget *group = view_form_group(box, side == 0 ? "Method" : NULL);
    view_form_row(group, side == 0 ? "_Method" : "_Second", form->drop,
                  "How visibility is computed");
    g_signal_connect(form->drop, "notify::selected", G_CALLBACK(on_method), form);
    form->note = view_form_note(box);
    form->group = view_form_group(box, NULL);
    form->figures = gtk_label_new(NULL);
    gtk_label_set_xalign(GTK_LABEL(form->figures), 0);
    gtk_label_set_wrap(GTK_LABEL(form->figures), TRUE);
    gtk_label_set_max_width_chars(GTK_LABEL(form->figures), 34);
    gtk_widget_add_css_class(form->figures, "figures");
    gtk_widget_add_css_class(form->figures, "numeric");
    gtk_widget_set_visible(form->figures, FALSE);
    gtk_box_append(GTK_BOX(box), form->figures);
}

GtkWidget *view_panel_method_new(struct view_app *app)
{
    struct panel *panel = g_new0(struct panel, 1);
    GtkWidget *box, *page = view_form_page(&box);
    panel->app = app;
    g_object_set_data_full(G_OBJECT(page), "panel", panel, g_free);
    add_side(panel, box, 0);

    panel->compare = gtk_switch_new();
    GtkWidget *group = view_form_group(box, "Comparison");
    view_form_row(group, "_Compare", panel->compare,
                  "A second method right of a divider that you can drag");
    g_signal_connect(panel->compare, "notify::active", G_CALLBACK(on_compare), panel);
    panel->second = gtk_box_new(GTK_ORIENTATION_VERTICAL, 12);
    gtk_box_append(GTK_BOX(box), panel->second);
    add_side(panel, panel->second, 1);

    group = view_form_group(box, "Truth");
    panel->truth = gtk_drop_down_new_from_strings(truth_names);
    view_form_row(group, "_Truth samples", panel->truth,
                  "The truth is ray-traced while nothing moves, with up to this many samples");
    g_signal_connect(panel->truth, "notify::selected", G_CALLBACK(on_truth), panel);
    panel->scale = view_form_spin(0.005, 1, 0.01, 3);
    view_form_row(group, "_Error scale", panel->scale, "The error at the ends of the colours");
    g_signal_connect(panel->scale, "value-changed", G_CALLBACK(on_scale), panel);
    return page;
}

static void show_side(struct side_form *form)
{
    const struct view_method *method = method_of(form);
    for (guint i = 0; i < pnb_method_count(); i++)
        if (pnb_method(i) == method->info &&
            gtk_drop_down_get_selected(GTK_DROP_DOWN(form->drop)) != i) {
            g_signal_handlers_block_by_func(form->drop, on_method, form);
            gtk_drop_down_set_selected(GTK_DROP_DOWN(form->drop), i);
            g_signal_handlers_unblock_by_func(form->drop, on_method, form);
        }
    if (form->shown != method->info)
        build_params(form);
    if (form->samples)
        view_form_show_value(
            form->samples, method->samples ? method->samples : method->info->default_samples, form);
}

void view_panel_method_refresh(GtkWidget *page)
{
    struct panel *panel = g_object_get_data(G_OBJECT(page), "panel");
    const struct view_state *state = &panel->app->state;
    for (int side = 0; side < VIEW_SIDES; side++)
        show_side(&panel->sides[side]);
    gtk_switch_set_active(GTK_SWITCH(panel->compare), state->compare);
    gtk_widget_set_visible(panel->second, state->compare);
    view_form_show_value(panel->scale, state->error_scale, panel);
    for (guint i = 0; i < G_N_ELEMENTS(truth_choices); i++)
        if (truth_choices[i] == state->truth_samples &&
            gtk_drop_down_get_selected(GTK_DROP_DOWN(panel->truth)) != i)
            gtk_drop_down_set_selected(GTK_DROP_DOWN(panel->truth), i);
}

void view_panel_method_figures(GtkWidget *page)
{
    struct panel *panel = g_object_get_data(G_OBJECT(page), "panel");
    const struct view_frame *frame = panel->app->frame;
    for (int side = 0; side < VIEW_SIDES; side++) {
        GtkWidget *label = panel->sides[side].figures;
        bool any = frame && frame->truth_samples > 0 && (side == 0 || frame->compare) &&
                   frame->errors[side].pixels > 0;
        if (any) {
            const pnb_errors *e = &frame->errors[side];
            char *text = g_strdup_printf("Error over the penumbra, truth of %d samples:\n"
                                         "RMSE %.4f    mean %+.4f\n"
                                         "99 %% below %.4f    largest %.3f\n"
                                         "umbra leaks %.2f %%    light darkened %.2f %%",
                                         frame->truth_samples, e->rmse, e->mean_error, e->p99_error,
                                         e->max_error, 100 * e->umbra_leak, 100 * e->lit_darkening);
            gtk_label_set_text(GTK_LABEL(label), text);
            g_free(text);
        }
        gtk_widget_set_visible(label, any);
    }
}
