/* mesh/collapse.h: step by step to fewer triangles, knowing at each step what became of the mesh's
 * vertices.
 *
 * Edges of least quadric error (Garland and Heckbert, Surface Simplification Using Quadric Error
 * Metrics) are collapsed to the point nearest to all planes that meet there. Closed surfaces stay
 * closed and their topology as it is; vertices at open borders and at edges of three and more
 * triangles stay in place. Every vertex of the mesh ends up at a vertex of the coarser one: the
 * coarser surface is the image of the mesh if its triangles follow them.
 *
 * Unlike mesh/simplify.h: double precision, so that meshes of millions of tiny triangles can be
 * reduced; vertices between the mesh's own. Deterministic for any number of threads.
 */
#ifndef MESH_COLLAPSE_H
#define MESH_COLLAPSE_H

#include "base/base.h"
#include "geom/vec.h"

struct collapse {
    size_t vertex_count, triangle_count; /* left */
    vec3 *positions;                     /* vertex_count */
    uint32_t (*triangles)[3];            /* triangle_count */
    size_t given_count;
    uint32_t *owner; /* given_count: given vertex -> vertex */
    /* Its own. */
    double (*quadrics)[10]; /* vertex_count */
    bool *fixed;            /* vertex_count */
};

/* Of welded vertices, and of triangles with three different corners. */
pnb_status collapse_init(pnb_context *context, const float (*positions)[4], size_t vertex_count,
                         const uint32_t (*triangles)[3], size_t triangle_count,
                         struct collapse *out_collapse);
void collapse_finish(pnb_context *context, struct collapse *collapse);

/* Down to about so many triangles; more where nothing more can be collapsed. O(n log n). */
pnb_status collapse_to(pnb_context *context, struct collapse *collapse, size_t triangle_count);

#endif
