/* viewer/app.h: the viewer as its parts see it: the scene and state at hand, what is selected, and
 * the calls by which any part changes them.
 *
 * All of it belongs to the main thread. A part that changes app->state calls view_app_changed();
 * the others then hear of it through view_app_refresh() of the window.
 */
#ifndef VIEWER_APP_H
#define VIEWER_APP_H

#include <gtk/gtk.h>

#include "camera.h"
#include "history.h"
#include "options.h"
#include "worker.h"

enum view_pick_type { VIEW_PICK_NONE, VIEW_PICK_LIGHT, VIEW_PICK_OBJECT };

struct view_pick {
    enum view_pick_type type;
    size_t index;
};

/* Why things move: bits. */
enum { VIEW_MOVING_HAND = 1, VIEW_MOVING_MOTION = 2, VIEW_MOVING_SIZE = 4, VIEW_MOVING_EDIT = 8 };

struct view_app {
    const struct view_options *options;
    GtkApplication *application;
    struct view_worker *worker;

    struct view_scene *scene; /* NULL: none yet */
    struct view_state state;
    struct view_frame *frame; /* the newest; NULL: none yet */
    struct view_pick pick;
    struct view_history *history;
    unsigned moving;
    guint edit_timer;
    bool at_rest;   /* the worker has nothing left to do for the newest state */
    bool failed;    /* the last command of the worker failed */
    double divider; /* of the wipe, share of the canvas */
    char *pending_screenshot;
    int exit_status;

    int64_t started_us, first_frame_us, first_full_us;

    struct view_window *window;
    struct view_motion *motion;
    struct view_script *script;
};

/* ---- app.c ---- */

struct view_app *view_app_create(GtkApplication *application, const struct view_options *options,
                                 int64_t started_us);
void view_app_destroy(struct view_app *app);

void view_app_open(struct view_app *app, const char *path);
void view_app_save(struct view_app *app, const char *path);
/* Of the picture at rest: waits for it. */
void view_app_screenshot(struct view_app *app, const char *path);
/* As it is on the screen, without handles. */
void view_app_shot_as_shown(struct view_app *app, const char *path);
void view_app_stop(struct view_app *app);

/* app->state has changed: the worker gets it, the parts refresh. */
void view_app_changed(struct view_app *app);
/* As above, by a control that comes in bursts (a spin button): counts as movement for a while. */
void view_app_edited(struct view_app *app);
void view_app_set_moving(struct view_app *app, unsigned why, bool on);
void view_app_select(struct view_app *app, enum view_pick_type type, size_t index);
void view_app_set_method(struct view_app *app, int side, const pnb_method_info *info);
void view_app_add_light(struct view_app *app, pnb_light_type type);
void view_app_remove_light(struct view_app *app, size_t index);
/* by: -1 undoes the last change of lights or objects, 1 does it again. */
void view_app_undo(struct view_app *app, int by);
void view_app_reset_camera(struct view_app *app);
void view_app_frame_selection(struct view_app *app);

/* Sizes of the scene for drawing and limits. */
vec3 view_app_middle(const struct view_app *app);
double view_app_sun_distance(const struct view_app *app);
double view_app_smallest(const struct view_app *app); /* half extent of a light */
/* Where the selection is; false if there is none. */
bool view_app_pick_place(const struct view_app *app, struct view_pick pick, vec3 *out);
void view_app_pick_move(struct view_app *app, struct view_pick pick, vec3 by);

#endif
