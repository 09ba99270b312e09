/* viewer/handles.h: what a hand can take hold of on the canvas: the selected light or object.
 *
 *        (n)        n   aims the light: drag the tip of its arrow
 *         |
 *    u ---c--- u    c   moves; u, v size; the coloured tips move along x, y, z
 *        / \
 *       x   z
 */
#ifndef VIEWER_HANDLES_H
#define VIEWER_HANDLES_H

#include "app.h"

enum view_handle_type {
    VIEW_HANDLE_NONE,
    VIEW_HANDLE_MOVE,
    VIEW_HANDLE_X,
    VIEW_HANDLE_Y,
    VIEW_HANDLE_Z,
    VIEW_HANDLE_U, /* and at the opposite end */
    VIEW_HANDLE_V,
    VIEW_HANDLE_AIM,
    VIEW_HANDLE_SPIN, /* an object about the vertical */
    VIEW_HANDLE_OTHER /* another light's mark: pressing selects it */
};

struct view_handle {
    enum view_handle_type type;
    vec3 place;
    double x, y;  /* pixels of the canvas */
    double sign;  /* which end of u or v */
    size_t index; /* of another light */
    bool outside; /* the place is out of sight: drawn at the border, towards it */
};

enum { VIEW_HANDLES_MAX = 80 };

/* Those in front of the eye, and the marks that move or select things wherever they are. Sizes are
 * in pixels of the canvas. */
int view_handles_find(const struct view_app *app, const struct view_lens *lens,
                      struct view_handle *out);
/* The one under the pointer; the nearest. VIEW_HANDLE_NONE if there is none. */
struct view_handle view_handles_at(const struct view_app *app, const struct view_lens *lens,
                                   double x, double y);
const char *view_handle_hint(enum view_handle_type type, enum view_pick_type pick);

struct view_grab {
    struct view_handle handle;
    struct view_pick pick;
    bool level;         /* moves horizontally instead of in the picture's plane */
    vec3 anchor, start; /* the handle, and where the pointer met the plane or axis, last time */
    bool anchored;
    double x, y;
    struct view_frame_axes axes; /* when it was taken */
};

void view_grab_begin(struct view_grab *grab, const struct view_app *app,
                     const struct view_lens *lens, const struct view_handle *handle, double x,
                     double y);
/* The pointer has moved: changes app->state (not yet posted). True if anything changed. */
bool view_grab_drag(struct view_grab *grab, struct view_app *app, const struct view_lens *lens,
                    double x, double y, bool level);

/* Outlines of lights, the selected one's handles. */
void view_handles_draw(const struct view_app *app, const struct view_lens *lens, cairo_t *cr,
                       const struct view_handle *hot);
/* The pixels that drawing may touch. */
void view_handles_bounds(const struct view_app *app, const struct view_lens *lens,
                         graphene_rect_t *out);

#endif
