/* viewer/measure.h: a measured drag: moves the pointer at every tick of the frame clock and notes
 * when new frames reach the screen.
 */
#ifndef VIEWER_MEASURE_H
#define VIEWER_MEASURE_H

#include "app.h"

struct view_measure;

/* NOTHING: the same picture again and again, which is GTK's share of time and memory. */
enum view_measure_what {
    VIEW_MEASURE_LIGHT,
    VIEW_MEASURE_OBJECT,
    VIEW_MEASURE_CAMERA,
    VIEW_MEASURE_NOTHING
};

/* NULL if there is nothing to take hold of. */
struct view_measure *view_measure_begin(struct view_app *app, enum view_measure_what what,
                                        int frames);
/* True once the frames have been shown; the pointer is released then. */
bool view_measure_painted(struct view_measure *measure, int64_t now_us);
/* As an object of JSON. */
char *view_measure_json(const struct view_measure *measure);
/* For people. */
char *view_measure_text(const struct view_measure *measure);
void view_measure_destroy(struct view_measure *measure);

/* Kilobytes of memory that the process has now. */
long view_resident_kb(void);

#endif
