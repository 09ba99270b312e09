/* mesh/mesh.h: a triangle mesh and its edges. */
#ifndef MESH_MESH_H
#define MESH_MESH_H

#include <penumbra/scene.h>

#include "base/base.h"
#include "geom/vec.h"

#define MESH_NONE 0xffffffffu

/* An edge between two distinct welded vertices, with the triangles that use it. */
struct mesh_edge {
    uint32_t vertex[2]; /* welded vertices, vertex[0] < vertex[1] */
    uint32_t first_use; /* into mesh_edges.uses */
    uint32_t use_count; /* 1: open, 2: usual, 3 and more: non-manifold */
};

/* Adjacency after welding by equal positions; the mesh's own vertices stay as they are. */
struct mesh_edges {
    uint32_t *welded; /* vertex_count: mesh vertex -> welded vertex */
    uint32_t welded_count;
    uint32_t *welded_vertex; /* welded_count: welded vertex -> one mesh vertex at its position */
    struct mesh_edge *edges;
    size_t edge_count;
    /* A use is triangle * 2 + (1 if the triangle runs along it from vertex[1] to vertex[0]), sorted
     * by triangle within an edge. */
    uint32_t *uses;
    size_t use_count;
    size_t open_count, non_manifold_count, inconsistent_count;
    size_t degenerate_triangle_count; /* their edges are kept where the two ends differ */
};

struct mesh {
    char *name;
    float *positions;  /* vertex_count x 3 */
    float *normals;    /* vertex_count x 3, or NULL */
    uint32_t *indices; /* triangle_count x 3 */
    size_t vertex_count, triangle_count;
    vec3 bounds_min, bounds_max; /* of the vertices that triangles use; inf if there is none */
    struct mesh_edges *edges;    /* made by mesh_get_edges(); NULL before that */
};

/* Copies and checks: PNB_ERROR_SCENE names the first index out of range or the first position that
 * is not finite. */
pnb_status mesh_init(pnb_context *context, struct mesh *mesh, const pnb_mesh_desc *desc);
void mesh_finish(pnb_context *context, struct mesh *mesh);

/* O(n) by hashing; kept in the mesh. */
pnb_status mesh_get_edges(pnb_context *context, struct mesh *mesh,
                          const struct mesh_edges **out_edges);
/* For tests: NULL, or what is wrong with the structure. */
const char *mesh_edges_validate(const struct mesh *mesh, const struct mesh_edges *edges);

/* Mesh space, known since mesh_init(). */
void mesh_bounds(const struct mesh *mesh, vec3 *out_min, vec3 *out_max);

#endif
