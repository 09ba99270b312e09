/* mesh/mesh.c: storage and checks of a triangle mesh. */
#include "mesh/mesh.h"

#include <string.h>

pnb_status mesh_init(pnb_context *context, struct mesh *mesh, const pnb_mesh_desc *desc)
{
    const char *name = desc->name && *desc->name ? desc->name : "mesh";
    memset(mesh, 0, sizeof(*mesh));

    if (desc->vertex_count > 0x7fffffffu || desc->triangle_count > 0x7fffffffu / 3)
        return status_fail(context, PNB_ERROR_SCENE, name, "more than 2^31 vertices or corners");
    if ((desc->vertex_count > 0 && !desc->positions) ||
        (desc->triangle_count > 0 && !desc->indices))
        return status_fail(context, PNB_ERROR_ARGUMENT, name, "no positions or no indices given");
    for (size_t i = 0; i < desc->vertex_count * 3; i++)
        if (!isfinite(desc->positions[i]))
            return status_fail(context, PNB_ERROR_SCENE, name, "vertex %zu: position is not finite",
                               i / 3);
    for (size_t i = 0; i < desc->triangle_count * 3; i++)
        if (desc->indices[i] >= desc->vertex_count)
            return status_fail(context, PNB_ERROR_SCENE, name,
                               "triangle %zu: index %u out of range (%zu vertices)", i / 3,
                               desc->indices[i], desc->vertex_count);

    mesh->vertex_count = desc->vertex_count;
    mesh->triangle_count = desc->triangle_count;
    mesh->name = memory_strdup(context, name);
    /* One float more: Embree reads 16 bytes at the last vertex. */
    mesh->positions = memory_calloc(context, desc->vertex_count * 3 + 1, sizeof(float));
    mesh->indices = memory_alloc(context, desc->triangle_count * 3, sizeof(uint32_t));
    if (desc->normals)
        mesh->normals = memory_alloc(context, desc->vertex_count * 3, sizeof(float));
    if (!mesh->name || !mesh->positions || !mesh->indices || (desc->normals && !mesh->normals)) {
        mesh_finish(context, mesh);
        return status_no_memory(context, desc->vertex_count * 24 + desc->triangle_count * 12);
    }
    if (desc->vertex_count > 0)
        memcpy(mesh->positions, desc->positions, desc->vertex_count * 3 * sizeof(float));
    if (desc->triangle_count > 0)
        memcpy(mesh->indices, desc->indices, desc->triangle_count * 3 * sizeof(uint32_t));

    /* Normals: unit length; one that is not usable becomes zero, which reads as "take the flat
     * one". */
    for (size_t i = 0; mesh->normals && i < desc->vertex_count; i++) {
        vec3 n = v3_loadf(desc->normals + 3 * i);
        v3_storef(mesh->normals + 3 * i, v3_finite(n) ? v3_normalize(n) : v3(0, 0, 0));
    }

    mesh->bounds_min = v3(INFINITY, INFINITY, INFINITY);
    mesh->bounds_max = v3(-INFINITY, -INFINITY, -INFINITY);
    for (size_t i = 0; i < mesh->triangle_count * 3; i++) {
        vec3 p = v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[i]);
        mesh->bounds_min = v3_min(mesh->bounds_min, p);
        mesh->bounds_max = v3_max(mesh->bounds_max, p);
    }
    return PNB_OK;
}

static void edges_destroy(pnb_context *context, struct mesh_edges *edges)
{
    if (!edges)
        return;
    memory_free(context, edges->welded);
    memory_free(context, edges->welded_vertex);
    memory_free(context, edges->edges);
    memory_free(context, edges->uses);
    memory_free(context, edges);
}

void mesh_finish(pnb_context *context, struct mesh *mesh)
{
    memory_free(context, mesh->name);
    memory_free(context, mesh->positions);
    memory_free(context, mesh->normals);
    memory_free(context, mesh->indices);
    edges_destroy(context, mesh->edges);
    memset(mesh, 0, sizeof(*mesh));
}

void mesh_bounds(const struct mesh *mesh, vec3 *out_min, vec3 *out_max)
{
    *out_min = mesh->bounds_min;
    *out_max = mesh->bounds_max;
}
