/* trace/trace.h: primary hits and shadow rays. The only folder that includes Embree. */
#ifndef TRACE_TRACE_H
#define TRACE_TRACE_H

#include "base/base.h"
#include "scene/scene.h"

struct trace;

/* A hierarchy over the scene's objects in world space. casters_only: leave out objects that cast no
 * shadow. Built in parallel by Embree. */
pnb_status trace_create(pnb_scene *scene, bool casters_only, struct trace **out_trace);
void trace_destroy(struct trace *trace);

/* The hierarchy over all objects, one for all who keep it: built where there is none of that kind
 * or the scene has changed since; given back by trace_release(), in the scene's lifetime. moves:
 * one whose objects follow placements at little cost, with all who keep it; old, if it is such a
 * one, rather than another. */
pnb_status trace_share(pnb_scene *scene, bool moves, struct trace *old, struct trace **out_trace);
void trace_release(struct trace *trace); /* NULL is fine */
/* Whether the scene still is as it was built for. */
bool trace_current(const struct trace *trace);
bool trace_moves(const struct trace *trace);
/* The shared one, if there is one, it is current and does not move, without keeping it; else NULL.
 */
struct trace *trace_shared(pnb_scene *scene);

/* Sixteen rays, one array per component. valid: -1 for rays to trace, 0 for others. */
#define TRACE_WIDTH 16
struct trace_rays {
    float org_x[TRACE_WIDTH], org_y[TRACE_WIDTH], org_z[TRACE_WIDTH], tnear[TRACE_WIDTH];
    float dir_x[TRACE_WIDTH], dir_y[TRACE_WIDTH], dir_z[TRACE_WIDTH], time[TRACE_WIDTH];
    float tfar[TRACE_WIDTH];
    uint32_t mask[TRACE_WIDTH], id[TRACE_WIDTH], flags[TRACE_WIDTH];
} __attribute__((aligned(64)));

/* tnear 0, tfar infinite, mask all ones, the rest zero. */
void trace_rays_init(struct trace_rays *rays);

/* Sets tfar to minus infinity where anything lies between tnear and tfar; both faces block. Leaves
 * the rest of the rays as it was. Any thread. coherent: a thin bundle; a matter of speed alone. */
void trace_occluded(const struct trace *trace, const int32_t valid[TRACE_WIDTH], bool coherent,
                    struct trace_rays *rays);

/* The first hit of each valid ray: object TRACE_NONE where there is none. */
#define TRACE_NONE 0xffffffffu
struct trace_hits {
    uint32_t object[TRACE_WIDTH], triangle[TRACE_WIDTH];
    float u[TRACE_WIDTH], v[TRACE_WIDTH]; /* p = (1 - u - v) corner 0 + u corner 1 + v corner 2 */
};
void trace_closest(const struct trace *trace, const int32_t valid[TRACE_WIDTH],
                   struct trace_rays *rays, struct trace_hits *hits);

/* The world-space corners that Embree has for a triangle of an object. */
void trace_triangle(const struct trace *trace, uint32_t object, uint32_t triangle,
                    vec3 out_corners[3]);

/* For the benchmark: Embree's own RTCScene. */
void *trace_embree_scene(const struct trace *trace);

#endif
