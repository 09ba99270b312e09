/* viewer/canvas.h: the picture, what lies over it, and the hand on it. */
#ifndef VIEWER_CANVAS_H
#define VIEWER_CANVAS_H

#include "app.h"

#define VIEW_TYPE_CANVAS (view_canvas_get_type())
G_DECLARE_FINAL_TYPE(ViewCanvas, view_canvas, VIEW, CANVAS, GtkWidget)

GtkWidget *view_canvas_new(struct view_app *app);
void view_canvas_set_frame(ViewCanvas *canvas, struct view_frame *frame);
/* Whether lights and handles are drawn over the picture. */
void view_canvas_set_handles(ViewCanvas *canvas, bool shown);

/* What the controllers call; scripts call it too. Pixels of the widget. */
void view_canvas_press(ViewCanvas *canvas, double x, double y, guint button, GdkModifierType mods);
void view_canvas_motion(ViewCanvas *canvas, double x, double y, GdkModifierType mods);
void view_canvas_release(ViewCanvas *canvas);
/* By arrow keys: dx, dy are -1, 0, 1. */
void view_canvas_step(ViewCanvas *canvas, int dx, int dy, GdkModifierType mods);
void view_canvas_zoom(ViewCanvas *canvas, double factor);
/* A handle of the selection in pixels of the widget; false if it is not in sight. */
bool view_canvas_find_handle(ViewCanvas *canvas, int type, double *x, double *y);

/* The context in which sides on OpenGL are drawn, made at the first call; false: it cannot be. */
bool view_canvas_draws(ViewCanvas *canvas);
/* Why it cannot; "" if it can or was not asked for. */
const char *view_canvas_why_not(ViewCanvas *canvas);
/* Sides of the window's own are read into the frame's bytes. */
void view_canvas_read(ViewCanvas *canvas);
/* The divider has moved. */
void view_canvas_divide(ViewCanvas *canvas, double divider);

/* What the last drawing showed. */
struct view_canvas_shown {
    uint64_t serial;
    int width, height; /* of the frame */
    bool full;
    int64_t wanted_us;
    unsigned count; /* different frames drawn so far */
};
struct view_canvas_shown view_canvas_get_shown(ViewCanvas *canvas);

/* The frame's pixel under the pointer; false outside of picture or canvas. */
bool view_canvas_pixel(ViewCanvas *canvas, int *x, int *y, int *side);

#endif
