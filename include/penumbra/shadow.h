/* shadow.h: mesh, light and plane in, shadow geometry out: the soft shadow on flat receivers as
 * triangles with an intensity per vertex, and as rings of equal intensity. Made by the method
 * "planar", without pixels. */
#ifndef PENUMBRA_SHADOW_H
#define PENUMBRA_SHADOW_H

#include <penumbra/method.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct pnb_shadow pnb_shadow;

/* Views of the shadow's own arrays. Intensity: 1 - visibility: 0 lit, 1 umbra; linear over each
 * triangle. Triangles run counter-clockwise seen from the light's side and tile the shadow without
 * overlap or T-junction; where the shadow itself jumps (an occluder that touches the plane) there
 * are several vertices at one place. */
typedef struct pnb_shadow_view {
    size_t vertex_count, triangle_count;
    const float *positions;   /* vertex_count x 3, world, on the plane */
    const float *coordinates; /* vertex_count x 2, metres along the plane's axes */
    const float *intensities; /* vertex_count */
    const uint32_t *indices;  /* triangle_count x 3 */
    size_t plane_count;     /* receivers; with more than one, coordinates belong to each its own */
    const uint32_t *planes; /* plane_count: the scene's objects */
    const uint32_t *first_triangles; /* plane_count + 1 */
    int ring_count; /* outlines of this many light samples; 0: the mesh was refined to a tolerance
                     */
} pnb_shadow_view;

/* A receiver: a point of it, and the axes that coordinates run along; axis_u x axis_v = normal, on
 * the light's side. */
typedef struct pnb_shadow_plane {
    double origin[3], axis_u[3], axis_v[3], normal[3];
    double half_u, half_v; /* the receiver is within these of the origin */
} pnb_shadow_plane;

/* desc: samples and parameters of the method "planar" (its method member is ignored); NULL: the
 * defaults. The light need not be the scene's. */
PNB_API pnb_status pnb_shadow_create(pnb_context *context, pnb_scene *scene, const pnb_light *light,
                                     const pnb_solver_desc *desc, pnb_shadow **out_shadow);
PNB_API void pnb_shadow_destroy(pnb_shadow *shadow);
PNB_API void pnb_shadow_get(const pnb_shadow *shadow, pnb_shadow_view *out_view);
PNB_API void pnb_shadow_get_plane(const pnb_shadow *shadow, size_t plane,
                                  pnb_shadow_plane *out_plane);
/* What making it took, counters and warnings. */
PNB_API void pnb_shadow_get_report(const pnb_shadow *shadow, pnb_solver_report *out_report);

/* By the file's ending:
 *   .obj      vertices with grey 1 - intensity as colour, world space
 *   .ply      binary, with a float property "intensity" and red green blue alpha, world space
 *   .glb      black, unlit, vertex alpha = intensity, alpha-blended: to lie under a model
 *   .svg      a linear gradient per triangle, multiplied over what is below; one plane
 *   .pdf      a gradient mesh, one plane
 *   .geojson  umbra, outer boundary and every ring as polygons with holes, metres in the plane
 * lift: metres by which world-space files raise the shadow above the plane, so that the two do not
 * fight for the same depth; below 0: a ten-thousandth of the receiver's size. The file is whole or
 * absent. */
PNB_API pnb_status pnb_shadow_write(pnb_shadow *shadow, const char *path, double lift);

#ifdef __cplusplus
}
#endif
#endif
