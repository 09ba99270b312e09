/* mesh/simplify.h: a coarser mesh, by meshoptimizer: what a shadow blurs away need not be
 * projected.
 */
#ifndef MESH_SIMPLIFY_H
#define MESH_SIMPLIFY_H

#include "mesh/mesh.h"

/* Welds, then collapses edges to one of their ends (quadric error) while that costs no more than
 * error (mesh space; INFINITY: none), the open border kept where it is. A closed mesh stays closed;
 * a mesh of which nothing would be left stays as it is. error is meshoptimizer's estimate, a mean
 * over a vertex' planes, not a bound of the distance. out is the caller's to finish. O(n log n). */
pnb_status mesh_simplify(pnb_context *context, struct mesh *mesh, double error, struct mesh *out);

#endif
