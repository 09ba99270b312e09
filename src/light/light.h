/* light/light.h: light shapes inside the library: frames, areas, sample positions. */
#ifndef LIGHT_LIGHT_H
#define LIGHT_LIGHT_H

#include <penumbra/light.h>

#include "base/base.h"
#include "geom/vec.h"

/* A light made ready for evaluation: what follows from its description, in world space.
 *
 * Samples: (u, v) in [0,1)^2 maps to the light by equal areas. Planar lights lie in the plane
 * through `origin` with unit normal `normal` (the lit side) and axes axis_u, axis_v. */
struct light_shape {
    pnb_light light; /* borrowed pointers */
    vec3 normal;     /* area lights: lit side; sun: the direction towards the sun */
    double area;     /* area, length; 1 for a point; the sun: solid angle */
    /* Rectangle: origin is the corner center - half_u - half_v, axes are 2 half_u, 2 half_v.
     * Disk: center; axes have length radius. Polygon: origin the first vertex, unit axes.
     * Line: from; axis_u = to - from. Point: position. Sun: axes span the disk of directions: a
     * direction towards the sun is normalised(normal + a axis_u + b axis_v) with (a, b) in the unit
     * disk. */
    vec3 origin, axis_u, axis_v;
    /* Polygon: triangulation, indices into the light's vertices, and their cumulated share of area.
     */
    uint32_t *triangles; /* triangle_count x 3 */
    double *share;       /* triangle_count */
    size_t triangle_count;
};

pnb_status light_shape_init(pnb_context *context, const pnb_light *light,
                            struct light_shape *shape);
void light_shape_finish(pnb_context *context, struct light_shape *shape);

/* The point (w = 1) or, for the sun, the unit direction towards it (w = 0) of sample (u, v). */
struct light_point {
    vec3 p;
    double w;
};
struct light_point light_shape_sample(const struct light_shape *shape, double u, double v);

/* Owen-scrambled Sobol points: sample index i of a sequence, scrambled by seed; in [0,1). */
void light_sobol_owen(uint32_t index, uint32_t seed, float *out_u, float *out_v);

/* How much of the light lies above the plane through p with normal n; none where p is not on the
 * light's lit side. Heights of zero do not count as above. */
enum light_facing { LIGHT_FACING_NONE = 0, LIGHT_FACING_SOME, LIGHT_FACING_ALL };
enum light_facing light_shape_facing(const struct light_shape *shape, vec3 p, vec3 n);
/* Lines, points and the sun have no other side. */
bool light_shape_lit_side(const struct light_shape *shape, vec3 p);

/* True if every point of the light lies above the plane through p with normal n, and p on the
 * light's lit side. */
bool light_shape_faces(const struct light_shape *shape, vec3 p, vec3 n);

#endif
