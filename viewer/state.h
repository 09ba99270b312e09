/* viewer/state.h: what the viewer knows of a scene, and what it wants to see of it.
 *
 * The worker thread owns the scene. The window has a description of it (struct view_scene, made
 * once) and the values that a hand changes (struct view_state), of which the worker gets a copy.
 */
#ifndef VIEWER_STATE_H
#define VIEWER_STATE_H

#include <glib.h>
#include <penumbra/penumbra.h>

#include "lights.h"

/* A copy of the scene in a context of its own, for the window's thread: what the library's door for
 * engines works on. */
struct view_twin {
    pnb_context *context;
    pnb_scene *scene;
    int64_t stop_us; /* work that lasts beyond it is cancelled; 0: it is not */
};

/* Never changes after it was made, but for the twin. */
struct view_object {
    char *name;
    double world_from_mesh[12];
    double mesh_middle[3], mesh_radius; /* of the mesh's bounds; mesh space, and world metres */
    double color[3];
    bool casts, receives, plane;
};

struct view_scene {
    int references;
    uint64_t id; /* another for each opening */
    char *path, *name;
    char **notes; /* ends with NULL */
    struct view_object *objects;
    size_t object_count;
    struct view_light *lights;
    size_t light_count;
    pnb_camera camera;
    double exposure;          /* as the file says; 0: automatic */
    double middle[3], radius; /* of what casts, or else of everything */
    double floor;             /* height of the lowest point */
    size_t triangle_count;
    int64_t load_us;
    struct view_twin *twin; /* the window's thread's; NULL: no memory */
};

struct view_scene *view_scene_ref(struct view_scene *scene);
void view_scene_unref(struct view_scene *scene);
/* Copies out of the library's scene. */
struct view_scene *view_scene_describe(const pnb_scene *scene, const char *path, uint64_t id);

enum view_show { VIEW_SHOW_PICTURE, VIEW_SHOW_VISIBILITY, VIEW_SHOW_ERROR };

/* A method and its settings; values[i] belongs to info->params[i], NULL: the default. */
struct view_method {
    const pnb_method_info *info;
    int samples; /* 0: the default */
    char **values;
};

void view_method_init(struct view_method *method, const pnb_method_info *info);
void view_method_copy(struct view_method *to, const struct view_method *from);
void view_method_finish(struct view_method *method);
bool view_method_equal(const struct view_method *a, const struct view_method *b);
/* Runs on OpenGL, with its parameters as they are. */
bool view_method_on_opengl(const struct view_method *method);

enum { VIEW_SIDES = 2 };

struct view_state {
    uint64_t scene_id, serial;
    int64_t wanted_us;
    int width, height; /* pixels of the canvas; 0: not known yet */
    pnb_camera camera;
    struct view_light *lights;
    size_t light_count;
    double (*placements)[12];
    size_t object_count;
    struct view_method methods[VIEW_SIDES];
    bool compare; /* both sides, or the first alone */
    enum view_show show;
    double error_scale;
    size_t light;      /* the one whose visibility is shown and read out */
    bool moving;       /* a hand or an animation is at work: speed before pixels */
    bool full_size;    /* never fewer pixels, not even while moving */
    int truth_samples; /* refine the truth up to this many; 0: no truth */
    double exposure;   /* 0: automatic */
    bool window;       /* methods on OpenGL are drawn in the window's own context */
    int patience_ms;   /* for which a frame may hold the window up, else the worker makes it */
};

/* Everything as the scene says. methods, show and the like stay; their first values are defaults.
 */
void view_state_init(struct view_state *state);
void view_state_enter(struct view_state *state, const struct view_scene *scene);
void view_state_copy(struct view_state *to, const struct view_state *from);
void view_state_finish(struct view_state *state);

/* Where an object is now: the middle of its bounds, in the world. */
vec3 view_object_middle(const struct view_object *object, const double world_from_mesh[12]);

#endif
