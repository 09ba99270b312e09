/* Fuzz target: the importer's answer, as the library decodes it. An importer that went wrong may
 * say anything; what comes of it is an error or a scene that keeps its promises. */
#include <stdint.h>
#include <stdlib.h>

#include "scene/import.h"

static void check_scene(pnb_scene *scene)
{
    for (size_t i = 0; i < pnb_scene_mesh_count(scene); i++) {
        pnb_mesh_desc mesh;
        pnb_mesh_info info;
        pnb_scene_mesh(scene, i, &mesh);
        for (size_t k = 0; k < mesh.triangle_count * 3; k++)
            if (mesh.indices[k] >= mesh.vertex_count)
                abort();
        for (size_t k = 0; k < mesh.vertex_count * 3; k++)
            if (!isfinite(mesh.positions[k]))
                abort();
        if (pnb_scene_mesh_info(scene, i, &info) != PNB_OK)
            abort();
    }
    for (size_t i = 0; i < pnb_scene_light_count(scene); i++) {
        pnb_light light;
        pnb_scene_light(scene, i, &light);
        if (pnb_light_check(scene->context, &light) != PNB_OK)
            abort();
    }
    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    if (pnb_scene_set_camera(scene, &camera) != PNB_OK || pnb_scene_object_count(scene) == 0 ||
        pnb_scene_light_count(scene) == 0)
        abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pnb_context *context;
    pnb_scene *scene;
    struct scene_import_data import;
    if (pnb_context_create(&(pnb_context_desc){.threads = 1}, &context) != PNB_OK)
        return 0;
    if (scene_import_decode(context, "fuzz", data, size, &import) == PNB_OK) {
        if (scene_import_assemble(context, "fuzz", &import, &scene) == PNB_OK)
            check_scene(scene);
        else if (scene || !*pnb_context_error(context))
            abort();
        pnb_scene_destroy(scene);
        scene_import_data_finish(context, &import);
    }
    pnb_context_destroy(context);
    return 0;
}
