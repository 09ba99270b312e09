/* viewer/script.h: drives the window as a hand would, for measurements, tests and pictures.
 *
 * A script is a name (first, drag, drag-object, orbit, repaint) or a file of lines:
 *   wait scene|full|rest|MILLISECONDS   what the worker has to reach first
 *   open PATH, drop PATH                then waits until it is open or has failed
 *   save PATH, screenshot PATH (as `render` makes it), shown PATH (as it is on the
 *                                     screen, without handles), window PATH
 *   method NAME, second NAME|off, samples N, param KEY=VALUE, truth N
 *   patience MILLISECONDS               for a frame of OpenGL in the window
 *   show picture|visibility|error, divider SHARE, page NAME, theme light|dark
 *   select light|object INDEX|NAME, add-light SHAPE, remove-light, shape SHAPE
 *   point X Y, press X Y|HANDLE, move X Y, move-by DX DY, release, click X Y    pixels
 *   step DX DY, zoom FACTOR, action NAME
 *   drag light|object|camera|nothing    a measured drag of --frames frames
 *   play, stop
 *   expect banner|no-banner|readout|progress|moved|still|method|second|info|scene|focus [TEXT]
 *   expect window|headless 0|1          where that side's method on OpenGL was drawn
 *   await ...                           as expect, until it is so
 *   where HANDLE, say TEXT, print, quit
 *   tab                                 prints the way of the focus; every control must be on it
 * HANDLE: move, x, y, z, u, v, aim, spin. Lines that begin with # are comments. A script that
 * cannot go on says why and ends the program with status 1.
 */
#ifndef VIEWER_SCRIPT_H
#define VIEWER_SCRIPT_H

#include "app.h"

struct view_script;

/* NULL if no script is asked for; the calls below take NULL. */
struct view_script *view_script_create(struct view_app *app);
void view_script_destroy(struct view_script *script);

void view_script_notify(struct view_script *script);
void view_script_failed(struct view_script *script);
void view_script_saved(struct view_script *script);
/* The frame clock has put something on the screen. */
void view_script_painted(struct view_script *script, int64_t now_us);

#endif
