/* viewer/focus.c: the way of the focus through the window, as the Tab key takes it.
 *
 * For tests: the walk emits what the key does (GtkWidget::move-focus), so that it goes where the
 * key goes. A control is what is seen, sensitive and focusable; parts of one (the text of a spin
 * button) count for it. A list takes one station, its rows are reached by arrows.
 */
#include "focus.h"

#include <stdio.h>

enum { STATIONS_MAX = 300 };

#define NAME_KEY "view-name"

void view_focus_name(GtkWidget *widget, const char *name)
{
    gtk_accessible_update_property(GTK_ACCESSIBLE(widget), GTK_ACCESSIBLE_PROPERTY_LABEL, name, -1);
    g_object_set_data_full(G_OBJECT(widget), NAME_KEY, g_strdup(name), g_free);
}

/* The first text below, which is what a button is called by. */
static const char *text_below(GtkWidget *widget)
{
    if (GTK_IS_LABEL(widget))
        return gtk_label_get_text(GTK_LABEL(widget));
    for (GtkWidget *child = gtk_widget_get_first_child(widget); child;
         child = gtk_widget_get_next_sibling(child)) {
        const char *text = text_below(child);
        if (text && *text)
            return text;
    }
    return NULL;
}

static const char *name_of(GtkWidget *widget)
{
    const char *name = g_object_get_data(G_OBJECT(widget), NAME_KEY);
    GList *labels = gtk_widget_list_mnemonic_labels(widget);
    if (!name && labels)
        name = gtk_label_get_text(GTK_LABEL(labels->data));
    g_list_free(labels);
    if (!name && (GTK_IS_BUTTON(widget) || GTK_IS_LABEL(widget) || GTK_IS_MENU_BUTTON(widget) ||
                  GTK_IS_LIST_BOX_ROW(widget)))
        name = text_below(widget);
    return name;
}

static bool is_control(GtkWidget *widget)
{
    return gtk_widget_get_mapped(widget) && gtk_widget_is_sensitive(widget) &&
           gtk_widget_get_focusable(widget) && gtk_widget_get_can_focus(widget);
}

/* The outermost widget that is one control to its user, for a part of it. */
static GtkWidget *whole(GtkWidget *widget)
{
    static const char *const wholes[] = {"GtkSpinButton",  "GtkDropDown", "GtkMenuButton",
                                         "GtkColorButton", "GtkEntry",    NULL};
    for (GtkWidget *at = widget; at; at = gtk_widget_get_parent(at))
        if (g_strv_contains(wholes, G_OBJECT_TYPE_NAME(at)))
            return at;
    return widget;
}

const char *view_focus_now(GtkWindow *window)
{
    GtkWidget *focus = gtk_window_get_focus(window);
    const char *name = focus ? name_of(whole(focus)) : NULL;
    return name ? name : "";
}

static void find_controls(GtkWidget *widget, GPtrArray *out)
{
    if (!gtk_widget_get_mapped(widget) || GTK_IS_POPOVER(widget))
        return;
    if (is_control(widget)) {
        GtkWidget *control = whole(widget);
        if (!g_ptr_array_find(out, control, NULL))
            g_ptr_array_add(out, control);
    }
    for (GtkWidget *child = gtk_widget_get_first_child(widget); child;
         child = gtk_widget_get_next_sibling(child))
        find_controls(child, out);
}

/* It has been reached, or hands the focus on to what it holds, as lists and pages do. */
static bool holds_one_of(GtkWidget *control, const GPtrArray *seen)
{
    for (guint i = 0; i < seen->len; i++) {
        GtkWidget *station = g_ptr_array_index(seen, i);
        if (station == control || gtk_widget_is_ancestor(station, control))
            return true;
    }
    return false;
}

bool view_focus_walk(GtkWindow *window, GtkWidget *from, char *why, size_t size)
{
    GPtrArray *all = g_ptr_array_new(), *seen = g_ptr_array_new();
    bool good = true;
    gtk_widget_grab_focus(from);
    for (int i = 0; i < STATIONS_MAX; i++) {
        GtkWidget *focus = gtk_window_get_focus(window);
        GtkWidget *station = focus ? whole(focus) : NULL;
        if (i > 0 && station == from)
            break;
        /* Behind the last control none has it; the next step is to the first. */
        if (station && !g_ptr_array_find(seen, station, NULL)) {
            const char *name = name_of(station);
            g_ptr_array_add(seen, station);
            printf("%u %s '%s'\n", seen->len, G_OBJECT_TYPE_NAME(station), name ? name : "");
            if (good && (!name || !*name)) {
                g_snprintf(why, size, "a %s has no name", G_OBJECT_TYPE_NAME(station));
                good = false;
            }
        }
        g_signal_emit_by_name(window, "move-focus", GTK_DIR_TAB_FORWARD);
    }
    find_controls(GTK_WIDGET(window), all);
    for (guint i = 0; i < all->len; i++) {
        GtkWidget *control = g_ptr_array_index(all, i);
        const char *name = name_of(control);
        if (holds_one_of(control, seen))
            continue;
        printf("never: %s '%s'\n", G_OBJECT_TYPE_NAME(control), name ? name : "");
        if (good)
            g_snprintf(why, size, "%s '%s' is never reached", G_OBJECT_TYPE_NAME(control),
                       name ? name : "");
        good = false;
    }
    fflush(stdout);
    g_ptr_array_free(all, TRUE);
    g_ptr_array_free(seen, TRUE);
    gtk_widget_grab_focus(from);
    return good;
}
