/* viewer/engine_inside.h: what the engine's files share. */
#ifndef VIEWER_ENGINE_INSIDE_H
#define VIEWER_ENGINE_INSIDE_H

#include "engine.h"
#include "pacing.h"
#include "shade.h"

#define NAN_FLOAT      ((float)NAN)
#define ROUGH_FIRST_MS 150.0 /* at rest: a rough frame first if the whole one may take longer */

enum step { STEP_NONE, STEP_MOVING, STEP_ROUGH, STEP_FULL, STEP_SHOW, STEP_TRUTH };

struct surface {
    pnb_surface *surface;
    pnb_camera camera;
    int width, height;
    uint64_t geometry;
};

struct solver {
    pnb_solver *solver; /* NULL: none, or creating it failed: error */
    struct view_method method;
    uint64_t geometry;
    bool tried;
    char error[256];
};

struct side {
    struct solver solver;
    float **visibility; /* one array per light */
    char message[256];
    int samples;
    bool headless; /* on OpenGL, but not in the window's context, for this reason */
    char refusal[128];
    bool given; /* the window has given the visibility that it drew */
    bool whole; /* visibility is that of the state at rest, all pixels */
};

struct view_engine {
    pnb_context *context;
    struct view_team *team;
    struct view_frame_pool *pool;
    char error[600];

    pnb_scene *scene;
    uint64_t scene_id, geometry; /* geometry: counts the times that an object moved */
    uint64_t settled;            /* the count when surfaces were last made as `render` makes them */
    struct view_material *materials;
    size_t object_count;

    struct view_state state;
    bool wanted; /* state is one of this scene */
    enum step next;
    const char *label;
    char label_text[64];

    struct surface full, rough;
    struct side sides[VIEW_SIDES];
    size_t light_capacity, pixel_capacity; /* of the visibility arrays */
    float *rgb, *truth;
    int truth_samples;
    struct view_emitter *emitters;
    struct view_pacing pacing;
    bool waiting;     /* for the window */
    double window_ms; /* of the last frame with sides that it drew, and its level; < 0: none */
    int window_level;
    int rest_level; /* of the next step at rest */
    uint64_t content;
    struct view_times times;
    char light_error[256];
};

/* ---- engine.c ---- */

bool engine_fail(struct view_engine *engine); /* false; the context's error becomes the engine's */
void engine_drop_solver(struct solver *solver);
void engine_free_arrays(struct view_engine *engine);

/* ---- engine_want.c ---- */

void engine_reset_pacing(struct view_engine *engine);
/* Whether the window draws that side. */
bool engine_in_window(const struct view_engine *engine, int s);
bool engine_any_in_window(const struct view_engine *engine);
void engine_drop_emitters(struct view_engine *engine);

/* ---- engine_solve.c ---- */

double engine_milliseconds_since(int64_t started);
/* Visibility of all lights and sides. */
bool engine_make_room(struct view_engine *engine, size_t pixels);
/* exact: to the bit as `render` has it, which one that follows movements need not be. */
pnb_status engine_need_surface(struct view_engine *engine, struct surface *slot, int width,
                               int height, bool exact);
/* The side's solver is there and knows where the objects are. */
pnb_status engine_need_solver(struct view_engine *engine, struct solver *solver,
                              const struct view_method *method);
/* Every light on one side. Only PNB_ERROR_CANCELLED is returned; other failures become the side's
 * message and a picture without shadows. */
pnb_status engine_solve_side(struct view_engine *engine, int s, const pnb_receivers *receivers);

/* ---- engine_frame.c ---- */

/* One side's bytes by what has been solved. whole: by the library, to the last bit as a file would
 * have it. */
void engine_draw_bytes(struct view_engine *engine, int s, const struct surface *surface, bool whole,
                       bool truth, uint8_t *bgra);
/* A frame of what has been solved. surface NULL: none is needed, the window draws all of it. */
struct view_frame *engine_compose(struct view_engine *engine, const struct surface *surface,
                                  int width, int height, bool full);
/* Surface, sides and frame; the sides that are whole already stay. PNB_ERROR_CANCELLED, or PNB_OK
 * even where a side failed. level 0: all pixels. */
pnb_status engine_make_frame(struct view_engine *engine, int level, bool full,
                             struct view_frame **out_frame);

#endif
