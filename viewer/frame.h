/* viewer/frame.h: a finished picture with its figures, handed from the worker to the window.
 *
 * Frames are counted references; the last one out gives the memory back to the pool that it came
 * from, so that a running viewer allocates nothing.
 */
#ifndef VIEWER_FRAME_H
#define VIEWER_FRAME_H

#include "state.h"

struct view_times { /* milliseconds */
    double update, primary, visibility[VIEW_SIDES], shade;
};

struct view_frame {
    int references;
    struct view_frame_pool *pool;
    size_t capacity; /* pixels that the arrays hold */

    uint64_t scene_id, serial;
    int width, height; /* pixels */
    bool full;         /* as many as the canvas has */
    bool moving;
    bool compare;
    /* Sides that the window draws by itself (gpu.h), with this state; they have no bytes here, and
     * no visibility before it is drawn at rest. */
    bool window[VIEW_SIDES];
    struct view_state state;
    int level;         /* of the pacing */
    double worker_ms;  /* what the worker's part took */
    double window_ms;  /* what the window's took, once it has drawn */
    bool drawn, told;  /* its own sides by the window; and the window's texts know of it */
    uint64_t content;  /* another whenever the window has to solve again */
    char refusal[128]; /* why the window does not draw a method on OpenGL; "" */
    enum view_show show;
    double error_scale;
    size_t light; /* of the visibility */
    int64_t wanted_us;
    struct view_times times;
    double exposure; /* in use */

    uint8_t *bgra[VIEW_SIDES]; /* width x height x 4, sRGB, as GTK and cairo take it */
    float *visibility[VIEW_SIDES];
    float *truth;
    uint32_t *objects;
    bool picked;       /* objects are known */
    int truth_samples; /* 0: no truth */
    const pnb_method_info *methods[VIEW_SIDES];
    int samples[VIEW_SIDES];
    pnb_errors errors[VIEW_SIDES]; /* if there is a truth */
    char message[VIEW_SIDES][256]; /* why a side has no shadow; "" */
    char device[128];
    char warning[256]; /* the first one of the solvers; "" */
};

/* What the window tells the worker of a frame that it has drawn. */
struct view_drawn {
    uint64_t scene_id, serial;
    int level;
    double ms;    /* all of it, the worker's part too */
    bool late;    /* it was not finished in time (view_state.patience_ms) */
    bool refused; /* the context cannot do it */
    char why[128];
};

struct view_frame_pool *view_frame_pool_create(void);
/* Frames in flight stay valid. */
void view_frame_pool_unref(struct view_frame_pool *pool);

/* Everything zero but the arrays, which hold width x height pixels, and room for `capacity`, so
 * that frames of fewer pixels and of all of them share memory. NULL: out of memory. */
struct view_frame *view_frame_acquire(struct view_frame_pool *pool, int width, int height,
                                      size_t capacity);
struct view_frame *view_frame_ref(struct view_frame *frame);
void view_frame_unref(struct view_frame *frame);

#endif
