/* viewer/focus.h: the way of the focus through the window, as the Tab key takes it. */
#ifndef VIEWER_FOCUS_H
#define VIEWER_FOCUS_H

#include <gtk/gtk.h>
#include <stdbool.h>

/* An accessible name where no label gives one. */
void view_focus_name(GtkWidget *widget, const char *name);
/* The name of the control that has it; "" if none has. */
const char *view_focus_now(GtkWindow *window);
/* Walks once round, from the canvas back to it, and prints each station: kind and name. False, and
 * why: a control that can have the focus is never reached, or one has no name. */
bool view_focus_walk(GtkWindow *window, GtkWidget *from, char *why, size_t size);

#endif
