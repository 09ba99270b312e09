/* viewer/motion.h: moves a light or object along a path. */
#ifndef VIEWER_MOTION_H
#define VIEWER_MOTION_H

#include "app.h"

enum view_path { VIEW_PATH_CIRCLE, VIEW_PATH_LINE, VIEW_PATH_EIGHT, VIEW_PATH_RISE };
enum { VIEW_PATH_COUNT = 4 };

struct view_motion;

struct view_motion_settings {
    enum view_path path;
    double size;   /* of the scene's radius */
    double period; /* seconds */
};

struct view_motion *view_motion_create(struct view_app *app);
void view_motion_destroy(struct view_motion *motion);
struct view_motion_settings *view_motion_settings(struct view_motion *motion);
const char *view_path_name(enum view_path path);

/* Moves the selection from where it is; stop leaves it where it has come to. */
void view_motion_start(struct view_motion *motion);
void view_motion_stop(struct view_motion *motion);
/* Back to where it began. */
void view_motion_rewind(struct view_motion *motion);
/* What moved has been put elsewhere: that is where its path begins. */
void view_motion_forget(struct view_motion *motion);
bool view_motion_running(const struct view_motion *motion);
/* What moves, or would. */
struct view_pick view_motion_pick(const struct view_motion *motion);

#endif
