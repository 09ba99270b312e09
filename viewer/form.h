/* viewer/form.h: rows of the side panels, all made alike. */
#ifndef VIEWER_FORM_H
#define VIEWER_FORM_H

#include <gtk/gtk.h>
#include <stdbool.h>

/* A scrolling column; groups are added to the box. */
GtkWidget *view_form_page(GtkWidget **out_box);
/* A titled list in the column (title NULL: none). */
GtkWidget *view_form_group(GtkWidget *box, const char *title);
/* A row: a label and what it is for. Returns the row. */
GtkWidget *view_form_row(GtkWidget *group, const char *label, GtkWidget *control,
                         const char *tooltip);
GtkWidget *view_form_spin(double minimum, double maximum, double step, int digits);
/* Dim, wrapped text. */
GtkWidget *view_form_note(GtkWidget *box);
void view_form_set_note(GtkWidget *note, const char *text);
/* Empties a group. */
void view_form_clear(GtkWidget *group);

/* Shows a value without telling the handler; leaves a text that is being typed alone. */
void view_form_show_value(GtkWidget *spin, double value, gpointer owner);
/* True if the control now says something else than `value`, beyond rounding of its digits. */
bool view_form_differs(GtkWidget *spin, double value);

#endif
