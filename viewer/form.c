/* viewer/form.c: rows of the side panels, all made alike. */
#include "form.h"

#include <math.h>

GtkWidget *view_form_page(GtkWidget **out_box)
{
    GtkWidget *scroll = gtk_scrolled_window_new();
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 12);
    gtk_scrolled_window_set_policy(GTK_SCROLLED_WINDOW(scroll), GTK_POLICY_NEVER,
                                   GTK_POLICY_AUTOMATIC);
    gtk_widget_set_vexpand(scroll, TRUE);
    gtk_widget_add_css_class(box, "page");
    gtk_scrolled_window_set_child(GTK_SCROLLED_WINDOW(scroll), box);
    *out_box = box;
    return scroll;
}

GtkWidget *view_form_group(GtkWidget *box, const char *title)
{
    GtkWidget *list = gtk_list_box_new();
    if (title) {
        GtkWidget *label = gtk_label_new(title);
        gtk_label_set_xalign(GTK_LABEL(label), 0);
        gtk_widget_add_css_class(label, "heading");
        gtk_box_append(GTK_BOX(box), label);
    }
    gtk_list_box_set_selection_mode(GTK_LIST_BOX(list), GTK_SELECTION_NONE);
    gtk_widget_add_css_class(list, "group");
    gtk_box_append(GTK_BOX(box), list);
    return list;
}

GtkWidget *view_form_row(GtkWidget *group, const char *label, GtkWidget *control,
                         const char *tooltip)
{
    GtkWidget *row = gtk_list_box_row_new();
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_HORIZONTAL, 8);
    if (label) {
        GtkWidget *name = gtk_label_new_with_mnemonic(label);
        gtk_label_set_xalign(GTK_LABEL(name), 0);
        gtk_label_set_ellipsize(GTK_LABEL(name), PANGO_ELLIPSIZE_END);
        gtk_widget_set_hexpand(name, TRUE);
        gtk_label_set_mnemonic_widget(GTK_LABEL(name), control);
        gtk_box_append(GTK_BOX(box), name);
    }
    gtk_widget_set_valign(control, GTK_ALIGN_CENTER);
    gtk_box_append(GTK_BOX(box), control);
    gtk_list_box_row_set_child(GTK_LIST_BOX_ROW(row), box);
    gtk_list_box_row_set_activatable(GTK_LIST_BOX_ROW(row), FALSE);
    gtk_widget_set_focusable(row, FALSE);
    if (tooltip)
        gtk_widget_set_tooltip_text(row, tooltip);
    gtk_list_box_append(GTK_LIST_BOX(group), row);
    return row;
}

GtkWidget *view_form_spin(double minimum, double maximum, double step, int digits)
{
    GtkWidget *spin = gtk_spin_button_new_with_range(minimum, maximum, step);
    gtk_spin_button_set_digits(GTK_SPIN_BUTTON(spin), (guint)digits);
    gtk_spin_button_set_numeric(GTK_SPIN_BUTTON(spin), TRUE);
    gtk_editable_set_width_chars(GTK_EDITABLE(spin), 7);
    gtk_editable_set_max_width_chars(GTK_EDITABLE(spin), 7);
    gtk_widget_add_css_class(spin, "numeric");
    return spin;
}

GtkWidget *view_form_note(GtkWidget *box)
{
    GtkWidget *note = gtk_label_new(NULL);
    gtk_label_set_wrap(GTK_LABEL(note), TRUE);
    gtk_label_set_xalign(GTK_LABEL(note), 0);
    gtk_label_set_max_width_chars(GTK_LABEL(note), 34);
    gtk_widget_add_css_class(note, "note");
    gtk_widget_set_visible(note, FALSE);
    gtk_box_append(GTK_BOX(box), note);
    return note;
}

void view_form_set_note(GtkWidget *note, const char *text)
{
    gtk_label_set_text(GTK_LABEL(note), text ? text : "");
    gtk_widget_set_visible(note, text && *text);
}

void view_form_clear(GtkWidget *group)
{
    for (GtkWidget *child; (child = gtk_widget_get_first_child(group));)
        gtk_list_box_remove(GTK_LIST_BOX(group), child);
}

void view_form_show_value(GtkWidget *spin, double value, gpointer owner)
{
    if (fabs(gtk_spin_button_get_value(GTK_SPIN_BUTTON(spin)) - value) < 1e-9)
        return;
    g_signal_handlers_block_matched(spin, G_SIGNAL_MATCH_DATA, 0, 0, NULL, NULL, owner);
    gtk_spin_button_set_value(GTK_SPIN_BUTTON(spin), value);
    g_signal_handlers_unblock_matched(spin, G_SIGNAL_MATCH_DATA, 0, 0, NULL, NULL, owner);
}

bool view_form_differs(GtkWidget *spin, double value)
{
    double half = 0.5 * pow(10, -(double)gtk_spin_button_get_digits(GTK_SPIN_BUTTON(spin)));
    return fabs(gtk_spin_button_get_value(GTK_SPIN_BUTTON(spin)) - value) > half;
}
