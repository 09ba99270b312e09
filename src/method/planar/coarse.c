/* method/planar/coarse.c: coarser occluders (Boehl and Stuerzlinger, section 4: details are blurred
 * by the penumbra). Once per mesh; a tolerance mesh keeps the real ones. */
#include "mesh/simplify.h"
#include "method/planar/room.h"

void shadow_coarse_finish(pnb_context *context, struct shadow_coarse *coarse)
{
    for (size_t i = 0; i < coarse->mesh_count; i++)
        mesh_finish(context, &coarse->meshes[i]);
    memory_free(context, coarse->meshes);
    *coarse = (struct shadow_coarse){0};
}

/* Metres per unit of a mesh: the most that any of the objects that cast it are scaled by. */
static double largest_scale(const pnb_scene *scene, size_t mesh)
{
    double scale = 0;
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *o = &scene->objects[i].info;
        for (int k = 0; k < 3 && o->mesh == mesh && o->casts; k++) {
            const double *m = o->world_from_mesh;
            scale = fmax(scale, v3_length(v3(m[k], m[4 + k], m[8 + k])));
        }
    }
    return scale;
}

pnb_status shadow_coarse_update(pnb_context *context, pnb_scene *scene,
                                const struct shadow_settings *settings,
                                struct shadow_coarse *coarse)
{
    if (coarse->meshes && coarse->version == scene->geometry_version)
        return PNB_OK;
    shadow_coarse_finish(context, coarse);
    if (settings->tolerance > 0 || settings->simplify == 0)
        return PNB_OK;
    coarse->meshes = memory_calloc(context, scene->mesh_count, sizeof(*coarse->meshes));
    if (!coarse->meshes)
        return status_no_memory(context, scene->mesh_count * sizeof(*coarse->meshes));
    coarse->version = scene->geometry_version;
    for (size_t i = 0; i < scene->mesh_count; i++) {
        double scale = largest_scale(scene, i);
        double error = scale > 0 ? settings->simplify / scale : INFINITY;
        pnb_status status =
            mesh_simplify(context, &scene->meshes[i], error, &coarse->meshes[coarse->mesh_count]);
        if (status)
            return status;
        coarse->triangles_before += scene->meshes[i].triangle_count;
        coarse->triangles_after += coarse->meshes[coarse->mesh_count++].triangle_count;
    }
    return PNB_OK;
}
