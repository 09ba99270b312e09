/* viewer/area.h: the GtkGLArea below the canvas's handles, in whose context methods on OpenGL draw.
 */
#ifndef VIEWER_AREA_H
#define VIEWER_AREA_H

#include "app.h"

struct view_area;

/* No context is made before view_area_ready(). */
struct view_area *view_area_create(struct view_app *app, GtkWidget *canvas);
void view_area_destroy(struct view_area *area);
/* Makes the context the first time. False where the canvas is not on a screen yet, or it cannot be
 * had; then view_area_why_not() is a line. */
bool view_area_ready(struct view_area *area);
const char *view_area_why_not(const struct view_area *area);
GtkWidget *view_area_widget(struct view_area *area); /* NULL: none */
void view_area_allocate(struct view_area *area, int width, int height);
/* To be drawn with the canvas, once. */
void view_area_set_frame(struct view_area *area, struct view_frame *frame);
/* What is drawn has to be shown again. */
void view_area_queue(struct view_area *area);
/* The frame's own sides as bytes, drawn if they were not yet. False: it is not the area's. */
bool view_area_read(struct view_area *area, struct view_frame *frame);

#endif
