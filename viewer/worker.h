/* viewer/worker.h: the thread that owns the scene and its solvers, and makes the frames.
 *
 * The window posts what it wants to see and never waits. All events come back in the main loop.
 */
#ifndef VIEWER_WORKER_H
#define VIEWER_WORKER_H

#include "frame.h"

struct view_worker;

struct view_worker_events {
    void (*scene)(void *user, struct view_scene *scene); /* opened; show() it */
    void (*frame)(void *user, struct view_frame *frame); /* the newest; older ones are left out */
    /* A long step at work; stage NULL: none. */
    void (*progress)(void *user, const char *stage, double fraction);
    void (*failed)(void *user, const char *what); /* a file; one line "WHAT: WHY" */
    void (*saved)(void *user, const char *path);
    /* Nothing left to do for this state. stopped: because stop() was called. */
    void (*rest)(void *user, uint64_t serial, bool stopped);
    void *user;
};

/* threads 0: one per processor. */
struct view_worker *view_worker_create(int threads, const struct view_worker_events *events);
/* Cancels what is under way and waits for it. No event comes after that. */
void view_worker_destroy(struct view_worker *worker);

/* lights: JSON texts that replace the scene's, or NULL; ends with NULL. A failure keeps the scene
 * that is open. */
void view_worker_open(struct view_worker *worker, const char *path, const char *const *lights);
/* Copied; the newest state replaces older ones that were not begun. */
void view_worker_show(struct view_worker *worker, const struct view_state *state);
/* Ends the step under way, and what would follow it, until another state comes. */
void view_worker_stop(struct view_worker *worker);
/* The scene as it stands: .json or .glb. */
void view_worker_save(struct view_worker *worker, const char *path);
/* The frame as a PNG; left of the divider (a share of the width) its first side. shown: as the
 * window has drawn and read back its own sides; else those are done again as `render` does them. */
void view_worker_screenshot(struct view_worker *worker, struct view_frame *frame, double divider,
                            bool shown, const char *path);
/* The window has drawn a frame; it has read the visibility of a side of its own into it. */
void view_worker_drawn(struct view_worker *worker, const struct view_drawn *drawn);
void view_worker_given(struct view_worker *worker, struct view_frame *frame, int side);

#endif
