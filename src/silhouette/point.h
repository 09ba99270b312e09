/* silhouette/point.h: what an occluder's shadow of one point on a plane is bounded by: directed
 * edges, for many points (the samples of a light) in one pass. */
#ifndef SILHOUETTE_POINT_H
#define SILHOUETTE_POINT_H

#include "base/base.h"
#include "geom/vec.h"
#include "mesh/mesh.h"

/* A receiver plane: origin, axes u and v of unit length, normal n = u x v. Plane space: (u, v,
 * height above the plane). */
struct silhouette_plane {
    vec3 origin, u, v, n;
};
vec3 silhouette_to_plane(const struct silhouette_plane *plane, vec3 p_world);
vec3 silhouette_from_plane(const struct silhouette_plane *plane, vec3 p_plane);

/* An edge used by exactly two triangles that run along it in opposite directions. */
struct silhouette_pair {
    uint32_t vertex[2];     /* welded */
    uint32_t with, against; /* triangles that run from vertex[0] to vertex[1], and back */
};

/* A mesh placed over a plane, ready for many light positions. Made again when the mesh is moved;
 * the edges are found once per mesh. */
struct silhouette_occluder {
    const struct mesh *mesh;
    const struct mesh_edges *edges;
    size_t vertex_count; /* welded */
    double *x, *y, *h;   /* vertex_count each, plane space */
    float *face;         /* triangle_count x 4: a sample l is in front when n . l > d */
    struct silhouette_pair *pairs;
    size_t pair_count;
    uint32_t *odd; /* the other edges, indices into edges->edges */
    size_t odd_count;
    double lowest, highest;
    float middle[3]; /* plane space; faces are kept relative to it, for floats' sake */
    uint64_t *front; /* scratch: triangle_count */
    uint32_t *slot;  /* scratch: vertex_count */
    uint32_t stamp;
    uint32_t *stamps;
};
pnb_status silhouette_occluder_init(pnb_context *context, struct mesh *mesh,
                                    const double world_from_mesh[12],
                                    const struct silhouette_plane *plane,
                                    struct silhouette_occluder *occluder);
void silhouette_occluder_finish(pnb_context *context, struct silhouette_occluder *occluder);

#define SILHOUETTE_SAMPLES_MAX 64

/* Points and directed segments in the plane, the shadow on the right; weights add up to how many
 * layers of the occluder lie between the plane and the light. */
struct silhouette_segment {
    uint32_t a, b;
    int32_t weight;
};
struct silhouette_outline {
    double *points; /* x, y */
    size_t point_count, point_capacity;
    struct silhouette_segment *segments;
    size_t segment_count, segment_capacity;
};
void silhouette_outline_finish(pnb_context *context, struct silhouette_outline *outline);

/* Appends each sample's silhouette, projected onto the plane, to outlines[k]. samples: plane space,
 * count <= SILHOUETTE_SAMPLES_MAX. A part of the occluder below the plane casts nothing; nor does
 * one that is not lower than the sample by TOLERANCE_LIGHT_GAP of the sample's height, so
 * coordinates stay finite. A sample that is not above the plane adds nothing: the caller decides
 * what it means.
 */
pnb_status silhouette_from_points(pnb_context *context, struct silhouette_occluder *occluder,
                                  const vec3 *samples, size_t count,
                                  struct silhouette_outline *outlines);

/* Appends the closed curves along which the mesh cuts the height `height` (> its lowest point),
 * seen from above: around its inside they wind once, counter-clockwise or all clockwise. Nothing
 * for meshes that are not closed. */
pnb_status silhouette_cross_section(pnb_context *context,
                                    const struct silhouette_occluder *occluder, double height,
                                    struct silhouette_outline *outline);

#endif
