/* Any bytes as a scene file, and as a light object alone. Mesh files are not opened: a tetrahedron
 * stands for each. */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "scene/scene_file.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static pnb_status tetrahedron(pnb_scene *scene, const char *path, size_t *out_mesh)
{
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    if (strstr(path, "missing"))
        return status_fail(scene->context, PNB_ERROR_FILE, path, "No such file or directory");
    return pnb_scene_add_mesh(scene, &(pnb_mesh_desc){path, positions, NULL, 4, indices, 4},
                              out_mesh);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pnb_context *context;
    pnb_scene *scene;
    struct scene_file_source source = {.file = "fuzz.json", .import_mesh = tetrahedron};
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 0;
    pnb_status status = scene_file_parse(context, (const char *)data, size, &source, &scene);
    if (status == PNB_OK) {
        /* What was accepted must be usable. */
        double low[3], high[3], exposure = pnb_scene_exposure(scene);
        if (!(exposure > 0) || !isfinite(exposure) || pnb_scene_object_count(scene) == 0 ||
            !pnb_scene_bounds(scene, low, high) || !isfinite(high[0] - low[0]))
            abort();
    } else {
        /* An error is one line that names the file. */
        const char *error = pnb_context_error(context);
        if (scene || strncmp(error, "fuzz.json: ", 11) != 0 || strchr(error, '\n'))
            abort();
    }
    pnb_scene_destroy(scene);

    /* The same bytes as a light of the command line. */
    char *text = malloc(size + 1);
    if (text && pnb_scene_create(context, &scene) == PNB_OK) {
        if (size > 0)
            memcpy(text, data, size);
        text[size] = 0;
        if (pnb_scene_add_light_json(scene, text, NULL) == PNB_OK &&
            pnb_scene_light_count(scene) != 1)
            abort();
        pnb_scene_destroy(scene);
    }
    free(text);
    pnb_context_destroy(context);
    return 0;
}
