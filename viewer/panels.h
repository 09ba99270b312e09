/* viewer/panels.h: the pages of the side bar. Each makes its widget and brings it up to date. */
#ifndef VIEWER_PANELS_H
#define VIEWER_PANELS_H

#include "app.h"

GtkWidget *view_panel_method_new(struct view_app *app);
void view_panel_method_refresh(GtkWidget *panel);
void view_panel_method_figures(GtkWidget *panel); /* a new frame's */

GtkWidget *view_panel_light_new(struct view_app *app);
void view_panel_light_refresh(GtkWidget *panel);

GtkWidget *view_panel_object_new(struct view_app *app);
void view_panel_object_refresh(GtkWidget *panel);

GtkWidget *view_panel_motion_new(struct view_app *app);
void view_panel_motion_refresh(GtkWidget *panel);

/* The frame-time graph. */
GtkWidget *view_graph_new(void);
void view_graph_add(GtkWidget *graph, const struct view_frame *frame, double draw_ms);
void view_graph_redraw(GtkWidget *graph);

#endif
