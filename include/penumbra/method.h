/* method.h: methods, and solvers.
 *
 * A method is a record: what it is, what it can do, which parameters it takes. A solver is a method
 * at work on one scene:
 *
 *   create (once per mesh)  ->  visibility (each frame: light and receivers in, visibility out)  ->
 * destroy update (objects moved, or vertices deformed)
 */
#ifndef PENUMBRA_METHOD_H
#define PENUMBRA_METHOD_H

#include <penumbra/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum pnb_param_type {
    PNB_PARAM_INTEGER = 0,
    PNB_PARAM_NUMBER,
    PNB_PARAM_CHOICE, /* one of the words in choices, separated by '|' */
    PNB_PARAM_TEXT
} pnb_param_type;

typedef struct pnb_param_info {
    const char *key;
    pnb_param_type type;
    const char *default_value;
    double minimum, maximum; /* of integers and numbers */
    const char *choices;
    const char *summary; /* one line */
} pnb_param_info;

/* Where a method runs, and which surfaces it can do. */
typedef enum pnb_processor { PNB_PROCESSOR_CPU = 0, PNB_PROCESSOR_OPENGL } pnb_processor;
typedef enum pnb_receiver_kind { PNB_RECEIVERS_ANY = 0, PNB_RECEIVERS_PLANES } pnb_receiver_kind;

typedef struct pnb_method_info {
    const char *name;
    const char *title;   /* a few words */
    const char *paper;   /* author, title, year; "" for none */
    const char *summary; /* a sentence or two */
    unsigned lights;     /* PNB_LIGHT_BIT()s of the light types that it can do */
    pnb_receiver_kind receivers;
    pnb_processor processor;
    bool
        opengl_path; /* a method of the CPU with a second path on OpenGL, by its parameter "path" */
    bool samples;    /* takes a number of light samples */
    int default_samples;
    const pnb_param_info *params;
    size_t param_count;
} pnb_method_info;

/* The registry: all methods of this build, in a fixed order. NULL beyond the last one. */
PNB_API size_t pnb_method_count(void);
PNB_API const pnb_method_info *pnb_method(size_t index);
PNB_API const pnb_method_info *pnb_method_find(const char *name); /* NULL: none of that name */

/* How the text of a numeric parameter is read: "0.25" or a fraction "1/255". False: it is none. */
PNB_API bool pnb_param_number(const char *text, double *out_number);

typedef struct pnb_solver pnb_solver;

/* A parameter as text, as on the command line. */
typedef struct pnb_solver_param {
    const char *key, *value;
} pnb_solver_param;

typedef struct pnb_solver_desc {
    const char *method; /* NULL: the default, pnb_default_method() */
    int samples;        /* light samples of methods that sample; 0: the method's default */
    const pnb_solver_param *params;
    size_t param_count;
} pnb_solver_desc;

/* The name of the method that is used when none is asked for. */
PNB_API const char *pnb_default_method(void);

typedef struct pnb_counter {
    const char *name; /* "lit", "umbra", "rays", ... */
    double value;
} pnb_counter;

#define PNB_COUNTER_MAX 16

/* What the last calls of a solver did. */
typedef struct pnb_solver_report {
    double prepare_ms;    /* create, and updates: what is done once per mesh */
    double visibility_ms; /* the last pnb_solver_visibility() */
    int samples; /* light samples in use: of the solver, then of its last visibility; 0: the method
                    does not sample. Some round the number asked for, and points need one. */
    const char *device; /* "" on the CPU, else the OpenGL renderer */
    pnb_counter counters[PNB_COUNTER_MAX];
    size_t counter_count;
    const char *const *warnings; /* lines; the solver's, until it is destroyed */
    size_t warning_count;
} pnb_solver_report;

/* Builds what the method keeps per mesh. The scene must outlive the solver. PNB_ERROR_ARGUMENT:
 * unknown method or parameter, value out of range. */
PNB_API pnb_status pnb_solver_create(pnb_context *context, pnb_scene *scene,
                                     const pnb_solver_desc *desc, pnb_solver **out_solver);
PNB_API void pnb_solver_destroy(pnb_solver *solver);

typedef enum pnb_update {
    PNB_UPDATE_PLACEMENTS = 0, /* objects moved: pnb_scene_set_placement() */
    PNB_UPDATE_VERTICES        /* meshes deformed: pnb_scene_set_vertices() */
} pnb_update;

/* Tells the solver what changed in the scene. Lights and receivers are arguments of a frame: moving
 * them needs no update. What it costs is the method's: `exact` keeps meshes in their own space, so
 * placements are O(objects), vertices a refit, O(triangles of all meshes), and a rebuild of the
 * meshes whose vertices at one position came apart; `reference` builds its hierarchy anew for
 * both. Added objects or meshes want a new solver. */
PNB_API pnb_status pnb_solver_update(pnb_solver *solver, pnb_update update);

/* Visibility of the light at each receiver: the share of the light's area that the point sees, in
 * [0,1]; NaN where the receiver is none, or is one that the method cannot do. Nothing about light
 * or receivers is kept between calls. visibility: receivers->count floats, the caller's.
 * PNB_ERROR_UNSUPPORTED names the methods that can do this light. Same bytes for every thread
 * count. */
PNB_API pnb_status pnb_solver_visibility(pnb_solver *solver, const pnb_light *light,
                                         const pnb_receivers *receivers, float *visibility);

/* Of the last call; valid until the next one. */
PNB_API void pnb_solver_get_report(const pnb_solver *solver, pnb_solver_report *out_report);

#ifdef __cplusplus
}
#endif
#endif
