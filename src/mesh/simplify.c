/* mesh/simplify.c: meshoptimizer's simplifier on welded vertices. */
#include "mesh/simplify.h"

#include <meshoptimizer.h>
#include <string.h>

pnb_status mesh_simplify(pnb_context *context, struct mesh *mesh, double error, struct mesh *out)
{
    const struct mesh_edges *edges;
    *out = (struct mesh){0};
    pnb_status status = mesh_get_edges(context, mesh, &edges);
    if (status)
        return status;
    size_t corners = 3 * mesh->triangle_count, n = edges->welded_count;
    float *positions = memory_alloc(context, 3 * n, sizeof(*positions));
    unsigned *given = memory_alloc(context, corners, sizeof(*given));
    unsigned *left = memory_alloc(context, corners, sizeof(*left));
    if (!positions || !given || !left)
        status = status_no_memory(context, 12 * n + 8 * corners);
    if (!status) {
        for (size_t i = 0; i < n; i++)
            memcpy(positions + 3 * i, mesh->positions + 3 * (size_t)edges->welded_vertex[i],
                   3 * sizeof(*positions));
        for (size_t i = 0; i < corners; i++)
            given[i] = edges->welded[mesh->indices[i]];
        float scale = meshopt_simplifyScale(positions, n, 3 * sizeof(*positions));
        double relative = scale > 0 ? error / scale : 0;
        size_t count = corners;
        if (corners > 0 && scale > 0)
            count = meshopt_simplify(left, given, corners, positions, n, 3 * sizeof(*positions), 0,
                                     (float)fmin(relative, 1e30), meshopt_SimplifyLockBorder, NULL);
        if (count == 0 || corners == 0 || !(scale > 0)) {
            count = corners;
            if (corners > 0)
                memcpy(left, given, corners * sizeof(*left));
        }
        /* Only what is used. */
        if (count > 0)
            n = meshopt_optimizeVertexFetch(positions, left, count, positions, n,
                                            3 * sizeof(*positions));
        status = mesh_init(context, out,
                           &(pnb_mesh_desc){.name = mesh->name,
                                            .positions = positions,
                                            .vertex_count = n,
                                            .indices = left,
                                            .triangle_count = count / 3});
    }
    memory_free(context, positions);
    memory_free(context, given);
    memory_free(context, left);
    return status;
}
