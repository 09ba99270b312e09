/* viewer/engine.h: one scene, its solvers and its surfaces, and the steps from a state to a frame.
 * Used by the worker's thread alone.
 */
#ifndef VIEWER_ENGINE_H
#define VIEWER_ENGINE_H

#include "frame.h"

struct view_engine;

/* NULL: out of memory. */
struct view_engine *
view_engine_create(int threads, bool (*progress)(void *user, const char *stage, double fraction),
                   void *user);
void view_engine_destroy(struct view_engine *engine);
/* "WHAT: WHY" of what returned false. */
const char *view_engine_error(const struct view_engine *engine);

/* On failure the open scene stays. lights may be NULL. */
bool view_engine_open(struct view_engine *engine, const char *path, char **lights, uint64_t id,
                      struct view_scene **out_scene);
bool view_engine_save(struct view_engine *engine, const char *path);
/* shown: with the bytes that the window has put into the frame for sides of its own; else those are
 * done again as `render` does them. */
bool view_engine_screenshot(struct view_engine *engine, const struct view_frame *frame,
                            double divider, bool shown, const char *path);

/* What the next steps work for. */
void view_engine_want(struct view_engine *engine, const struct view_state *state);
bool view_engine_busy(const struct view_engine *engine);   /* steps are left */
bool view_engine_yields(const struct view_engine *engine); /* the next one may be given up */
/* One step; out_frame stays NULL if it made none. A cancelled step is tried again unless another
 * state is wanted or it is given up. False: it failed, and nothing follows. */
bool view_engine_step(struct view_engine *engine, struct view_frame **out_frame);
/* The window has drawn a frame; the visibility that it found there. */
void view_engine_drawn(struct view_engine *engine, const struct view_drawn *drawn);
void view_engine_given(struct view_engine *engine, uint64_t content, int side, const float *values,
                       size_t count);
bool view_engine_waits(const struct view_engine *engine); /* for the window, before the next step */
void view_engine_give_up(struct view_engine *engine);
uint64_t view_engine_serial(const struct view_engine *engine);
/* What the step under way does, for people; NULL: nothing special. */
const char *view_engine_label(const struct view_engine *engine);

#endif
