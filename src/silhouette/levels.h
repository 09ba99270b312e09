/* silhouette/levels.h: a mesh and coarser ones with nearly the same outlines, each cut into
 * clusters: what is seen small is taken from a coarser level.
 *
 * Each level has about half the triangles of the one before, and its own vertices: they are moved
 * until the mesh itself lies as much outside of the level as inside, so that outlines, and with
 * them shadows, neither shrink nor grow. How far a level is off is measured, not estimated.
 *
 * Memory: the levels together as much as the mesh's clusters, or half of it where the mesh is
 * dense. Build: O(n log n).
 */
#ifndef SILHOUETTE_LEVELS_H
#define SILHOUETTE_LEVELS_H

#include "silhouette/clusters.h"

#define LEVELS_MAX 16

struct level {
    struct clusters *clusters;
    size_t triangle_count;
    double distance; /* the largest found between mesh and level, mesh space */
    double mean;     /* root of the mean square, over the mesh's area */
    double side;     /* mean length of its triangles' longest sides */
    double error;    /* (mean^2 side)^(1/3) or 0.4 distance: rises from level to level */
};

/* level[0]: the mesh itself, whose clusters are the caller's. */
struct levels {
    struct level level[LEVELS_MAX];
    size_t count;
    size_t bytes; /* of all but the mesh's own clusters */
};

/* Coarser levels of a mesh that is cut into clusters already; they must outlive the levels. Meshes
 * that cannot be made coarser (soups, boxes, few triangles) get none. */
pnb_status levels_create(pnb_context *context, struct clusters *clusters,
                         struct levels **out_levels);
void levels_destroy(pnb_context *context, struct levels *levels);

#endif
