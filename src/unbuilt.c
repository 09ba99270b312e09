/* unbuilt.c: weak stand-ins for what is not written yet, so that everything links. Goes away. */
#include <penumbra/penumbra.h>

#include "light/light.h"
#include "method/method.h"
#include "scene/scene.h"
#include "trace/trace.h"

#pragma GCC diagnostic ignored "-Wmissing-prototypes"
#define WEAK __attribute__((weak))
#define FAIL(c) return status_fail((c), PNB_ERROR_UNSUPPORTED, __func__, "not built yet")

WEAK pnb_status pnb_light_check(pnb_context *c, const pnb_light *l) { return PNB_OK; }
WEAK const char *pnb_light_type_name(pnb_light_type t) { return "light"; }
WEAK pnb_status pnb_light_irradiance(pnb_context *c, const pnb_light *l, const float *p, const float *n, size_t k, float *e) { FAIL(c); }
WEAK pnb_status light_shape_init(pnb_context *c, const pnb_light *l, struct light_shape *s) { FAIL(c); }
WEAK void light_shape_finish(pnb_context *c, struct light_shape *s) {}
WEAK struct light_point light_shape_sample(const struct light_shape *s, double u, double v) { return (struct light_point){{0, 0, 0}, 0}; }
WEAK void light_sobol_owen(uint32_t i, uint32_t s, float *u, float *v) { *u = *v = 0; }
WEAK bool light_shape_faces(const struct light_shape *s, vec3 p, vec3 n) { return true; }
WEAK pnb_status pnb_scene_write_json(pnb_scene *s, const char *p) { FAIL(s->context); }
WEAK pnb_status pnb_scene_write_glb(pnb_scene *s, const char *p) { FAIL(s->context); }
WEAK size_t pnb_builtin_count(void) { return 0; }
WEAK void pnb_builtin(size_t i, pnb_builtin_info *o) {}
WEAK pnb_status scene_builtin(pnb_context *c, const char *n, pnb_scene **s) { FAIL(c); }
WEAK pnb_status scene_import(pnb_context *c, const char *p, pnb_scene **s) { FAIL(c); }
WEAK pnb_status scene_import_mesh(pnb_scene *s, const char *p, size_t *m) { FAIL(s->context); }
WEAK pnb_status scene_supply(pnb_scene *s, bool b) { FAIL(s->context); }
WEAK pnb_status pnb_surface_create(pnb_context *c, pnb_scene *s, const pnb_camera *k, int w, int h, pnb_surface **o) { FAIL(c); }
WEAK void pnb_surface_destroy(pnb_surface *s) {}
WEAK void pnb_surface_get(const pnb_surface *s, pnb_surface_view *o) {}
WEAK void pnb_surface_receivers(const pnb_surface *s, pnb_receivers *o) {}
WEAK pnb_status pnb_surface_shade(const pnb_surface *s, const float *const *v, float *rgb) { return PNB_ERROR_UNSUPPORTED; }
WEAK size_t pnb_method_count(void) { return 0; }
WEAK const pnb_method_info *pnb_method(size_t i) { return NULL; }
WEAK const pnb_method_info *pnb_method_find(const char *n) { return NULL; }
WEAK const char *pnb_default_method(void) { return "reference"; }
WEAK pnb_status pnb_solver_create(pnb_context *c, pnb_scene *s, const pnb_solver_desc *d, pnb_solver **o) { FAIL(c); }
WEAK void pnb_solver_destroy(pnb_solver *s) {}
WEAK pnb_status pnb_solver_update(pnb_solver *s, pnb_update u) { FAIL(s->context); }
WEAK pnb_status pnb_solver_visibility(pnb_solver *s, const pnb_light *l, const pnb_receivers *r, float *v) { FAIL(s->context); }
WEAK void pnb_solver_get_report(const pnb_solver *s, pnb_solver_report *o) {}
