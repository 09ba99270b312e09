/* method/opengl.h: what the methods on OpenGL share: device, occluders and frame on the device, and
 * both doors: receivers in and visibility out (pnb_solver_visibility), and an engine's own context
 * (penumbra/opengl.h). A room gives a struct opengl_method; its struct method points to it and
 * takes the four functions below. */
#ifndef METHOD_OPENGL_H
#define METHOD_OPENGL_H

#include "gl/frame.h"
#include "light/light.h"
#include "method/method.h"

struct opengl_state {
    struct gl_device *device;
    struct gl_occluders *occluders; /* uploaded */
    struct gl_frame *frame;         /* of the last receivers; textures are kept for the next */
    void *room;                     /* the room's own */
    double lost_ms; /* draw(): in attempts that came to nothing and that later frames do without */
};

/* All are called between gl_device_begin() and gl_device_end(). */
struct opengl_method {
    /* Programs and whatever is kept per mesh; occluders are there. Fills state->room. */
    pnb_status (*create)(pnb_solver *solver, struct opengl_state *state);
    void (*destroy)(pnb_solver *solver,
                    struct opengl_state *state); /* also after a failed create */
    /* Occluders were made anew (moved or deformed); NULL: nothing to do. */
    pnb_status (*changed)(pnb_solver *solver, struct opengl_state *state);
    /* One frame, nothing kept from an earlier one but memory: V in [0,1] for every pixel of the
     * frame into an R32F texture of its size (anything where there is no receiver). Points on the
     * light's dark side are handled by the caller of this function: they become 0. */
    pnb_status (*draw)(pnb_solver *solver, struct opengl_state *state,
                       const struct light_shape *shape, const pnb_light *light,
                       const struct gl_frame *frame, struct gl_texture *visibility);
    bool edges; /* occluders come with edges, welded, and with what is closed */
};

/* Whether a solver of a method with two paths is to take the one on OpenGL: its parameter "path"
 * says so, or it lives in the caller's context. */
bool opengl_wanted(const pnb_solver *solver);

/* Between the passes of a long draw(): every now and then waits until they are drawn and reports
 * the share. *last_ms: 0 at first. PNB_ERROR_CANCELLED: the caller has asked to stop. Nothing
 * without a progress callback. */
pnb_status opengl_progress(pnb_solver *solver, struct opengl_state *state, double share,
                           double *last_ms);

pnb_status opengl_create(pnb_solver *solver);
void opengl_destroy(pnb_solver *solver);
pnb_status opengl_update(pnb_solver *solver, pnb_update update);
pnb_status opengl_visibility(pnb_solver *solver, const pnb_light *light,
                             const pnb_receivers *receivers, float *visibility);

#endif
