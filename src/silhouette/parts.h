/* silhouette/parts.h: a mesh that is a set of solids (a fence of pickets), each with clusters of
 * its own: what one of them hides can be told by its outline, and those out of the way are left at
 * once.
 */
#ifndef SILHOUETTE_PARTS_H
#define SILHOUETTE_PARTS_H

#include "silhouette/clusters.h"

struct parts {
    size_t count;
    struct clusters **clusters;
    size_t *first;                     /* count + 1: a part's vertices in `vertex` */
    uint32_t *vertex;                  /* of the mesh */
    size_t mesh_vertex_count, largest; /* largest: vertices of any part */
    size_t bytes;
};

/* NULL if the mesh is in one piece, in very many, or if one of them is no solid. O(n log n). */
pnb_status parts_create(pnb_context *context, struct mesh *mesh, struct parts **out_parts);
void parts_destroy(pnb_context *context, struct parts *parts);

/* Takes the mesh's new positions. Parts that cease to be solids stay parts. torn: vertices that
 * were one have come apart, create anew. */
pnb_status parts_refit(pnb_context *context, struct parts *parts, const struct mesh *mesh,
                       bool *out_torn);

#endif
