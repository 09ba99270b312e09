/* method/method.h: what a method's room gives to the registry, and what a solver keeps. */
#ifndef METHOD_METHOD_H
#define METHOD_METHOD_H

#include <penumbra/method.h>

#include "base/base.h"
#include "scene/scene.h"

struct opengl_method;
struct opengl_solver;

struct method {
    pnb_method_info info;
    /* solver->state is the method's own. Fills solver->samples; parameters by solver_param(). */
    pnb_status (*create)(pnb_solver *solver);
    /* Also after a create() that failed: state is then what create() left, or NULL. */
    void (*destroy)(pnb_solver *solver);
    pnb_status (*update)(pnb_solver *solver, pnb_update update);
    /* The light is checked and one of info.lights. Writes every element of visibility. Sets
     * report.samples where it is not solver->samples. */
    pnb_status (*visibility)(pnb_solver *solver, const pnb_light *light,
                             const pnb_receivers *receivers, float *visibility);
    const struct opengl_method *opengl; /* of methods on OpenGL (method/opengl.h), else NULL */
};

struct pnb_solver {
    const struct method *method;
    pnb_context *context;
    pnb_scene *scene;
    int samples;
    char **values; /* one per info.params, resolved with the defaults */
    void *state;
    struct opengl_solver *opengl; /* of a solver on OpenGL (method/opengl.h), else NULL */
    bool adopts;                  /* pnb_gl_solver_create(): lives in the caller's context */
    double drawn_ms; /* < 0, or what visibility() measured itself: report.visibility_ms */
    pnb_solver_report report;
    char **warnings;
    size_t warning_capacity;
};

/* pnb_solver_create() and pnb_gl_solver_create(). */
pnb_status solver_make(pnb_context *context, pnb_scene *scene, const pnb_solver_desc *desc,
                       bool adopts, pnb_solver **out_solver);
/* The light is sound and one of the method's. */
pnb_status solver_check_light(const pnb_solver *solver, const pnb_light *light);

const char *solver_param(const pnb_solver *solver, const char *key);
double solver_param_number(const pnb_solver *solver, const char *key);
int solver_param_integer(const pnb_solver *solver, const char *key);
/* Sets a counter of the report (adds it when new). */
void solver_count(pnb_solver *solver, const char *name, double value);
/* A line for the report, once; also logged. */
void solver_warn(pnb_solver *solver, const char *format, ...) __attribute__((format(printf, 2, 3)));

const struct method *method_find(const char *name); /* NULL: none of that name */
/* "a, b, c": the methods that can do the lights of any of the bits, or any receivers; "none". */
void method_list_lights(unsigned bits, char *text, size_t size);
void method_list_any_receivers(char *text, size_t size);

/* The rooms, each defined in its own folder. */
extern const struct method method_exact;
extern const struct method method_reference;
extern const struct method method_planar;
extern const struct method method_wedge;
extern const struct method method_wedge_probabilistic;
extern const struct method method_wedge_blend;
extern const struct method method_line_map;
extern const struct method method_sampled_maps;
extern const struct method method_hard_map;
extern const struct method method_hard_volume;
extern const struct method method_pcss;
extern const struct method method_dbuffer;

#endif
