/* viewer/window.h: the window: header bar, banner, canvas, side bar, status line, menus, keys. */
#ifndef VIEWER_WINDOW_H
#define VIEWER_WINDOW_H

#include "app.h"
#include "canvas.h"

struct view_window;

struct view_window *view_window_create(struct view_app *app);
void view_window_destroy(struct view_window *window);
GtkWidget *view_window_widget(struct view_window *window);
ViewCanvas *view_window_canvas(struct view_window *window);

/* What happened, by the app. */
void view_window_scene_opened(struct view_window *window);
void view_window_frame(struct view_window *window);
void view_window_progress(struct view_window *window, const char *stage, double fraction);
void view_window_rest(struct view_window *window, bool stopped);
void view_window_saved(struct view_window *window, const char *path);
/* text NULL: the error is over. */
void view_window_error(struct view_window *window, const char *text);
/* The state has changed; while something moves the panels follow ten times a second. */
void view_window_refresh(struct view_window *window);
/* The pointer is elsewhere on the canvas; hint: what pressing there does, or NULL. */
void view_window_pointer(struct view_window *window, const char *hint);
/* The canvas has drawn. */
void view_window_drawn(struct view_window *window);

/* Whether sides on OpenGL are drawn in the window's own context; makes that where one is asked for.
 */
bool view_window_draws(struct view_window *window);

/* What the banner says; "" if it is hidden. The read-out and the progress likewise. */
const char *view_window_banner(struct view_window *window);
const char *view_window_readout(struct view_window *window);
const char *view_window_info(struct view_window *window); /* right of the read-out */
bool view_window_busy(struct view_window *window);
/* Files as if they were dropped on the window. */
void view_window_drop(struct view_window *window, const char *path);
/* Opens a page of the side bar: "method", "light", "object", "motion". */
void view_window_page(struct view_window *window, const char *name);
/* The window as a PNG file. */
bool view_window_picture(struct view_window *window, const char *path);

#endif
