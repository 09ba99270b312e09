/* silhouette/clusters.h: a mesh cut into clusters of neighbouring triangles, made once per mesh, so
 * that the silhouette seen from a small region can be found without looking at every edge.
 *
 * Triangles are sorted so that cluster i holds the slots [64 i, 64 i + 64) (the last one fewer).
 * Vertices are those of the mesh welded by position. Edges are kept with the cluster that holds
 * both their triangles (interior), or in a list per pair of clusters that meet (border).
 *
 * Memory: about 70 bytes per triangle. Build: O(n log n). Refit: O(n).
 */
#ifndef SILHOUETTE_CLUSTERS_H
#define SILHOUETTE_CLUSTERS_H

#include "base/base.h"
#include "geom/vec.h"
#include "mesh/mesh.h"

#define CLUSTER_SIZE 64

/* An edge and the one or two triangles that use it; an edge of three or more triangles is several
 * of these. A use is slot * 2 + (1 if the triangle runs along it from vertex[1] to vertex[0]). */
struct cluster_edge {
    uint32_t vertex[2];
    uint32_t use[2]; /* use[1]: MESH_NONE at an open border */
};

/* An edge is odd unless two triangles run along it in opposite directions: open borders, and
 * sheets whose orientation changes. Only odd edges count between triangles that face alike. */
static inline bool cluster_edge_odd(const struct cluster_edge *edge)
{
    return edge->use[1] == MESH_NONE || ((edge->use[0] ^ edge->use[1]) & 1) == 0;
}

/* Edges between two clusters; both hold an entry, one of them is the owner. */
struct cluster_border {
    uint32_t other; /* cluster */
    uint32_t first, count : 30, owner : 1;
    uint32_t odd : 1; /* holds an odd edge */
};

/* Planes have unit normals n and offsets d to the cluster's centre c: n.(p - c) - d is the height
 * of p over the triangle's plane; a triangle without area has n = 0, d = 0. */
struct cluster {
    float low[3], high[3]; /* bounds of the triangles */
    float center[3];
    float normal_low[3], normal_high[3], offset_low, offset_high;
    uint32_t edge_first, edge_count; /* interior, the odd ones first */
    uint32_t odd_count;
    uint32_t border_first, border_count; /* into borders */
};

/* A node covers the clusters [first, first + count); its left child follows it. */
struct cluster_node {
    float low[3], high[3];
    uint32_t first, count; /* count 1: leaf */
    uint32_t next;         /* the node after this one's subtree */
};

struct clusters {
    size_t vertex_count, slot_count, cluster_count, edge_count, border_count, node_count;
    float (*positions)[4]; /* vertex_count; the fourth is zero */
    size_t mesh_vertex_count;
    uint32_t *vertex;       /* mesh_vertex_count: the mesh's vertex -> ours, or MESH_NONE */
    uint32_t (*corners)[3]; /* slot_count */
    float (*planes)[4][CLUSTER_SIZE]; /* cluster_count: nx, ny, nz, d; zeros behind the last slot */
    struct cluster *clusters;
    struct cluster_edge *edges;
    struct cluster_border *borders;
    struct cluster_node *nodes;
    bool solid; /* the surface of one solid that is all but convex; never of many triangles */
    float dent; /* a solid's: how deep dents are, as a share of its size */
    float center[3], radius; /* a solid\'s: a sphere around it */
    size_t bytes;            /* of all of these */
};

/* Triangles with two equal corners are left out. A mesh of no triangle gives no cluster. */
pnb_status clusters_create(pnb_context *context, struct mesh *mesh, struct clusters **out_clusters);
void clusters_destroy(pnb_context *context, struct clusters *clusters);

/* Takes the mesh's new positions; false: vertices that were one have come apart, create anew. */
bool clusters_refit(struct clusters *clusters, const struct mesh *mesh);

/* Sets solid, dent, center and radius. */
void clusters_find_solid(struct clusters *clusters);

/* Are the mesh's positions those of the clusters? */
bool clusters_fit(const struct clusters *clusters, const struct mesh *mesh);

/* For tests: NULL, or what is wrong. */
const char *clusters_validate(const struct clusters *clusters);

#endif
