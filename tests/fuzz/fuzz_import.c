/* Fuzz target: a mesh or scene file through the importer's process. The first byte picks the
 * ending, the rest is the file. Whatever happens to the importer, the library answers with an error
 * that names the file, or with a scene. The importer is found as usual; PNB_IMPORTER names another
 * one. */
#define _GNU_SOURCE
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "scene/import.h"

static const char *const endings[] = {"obj", "glb", "gltf", "ply", "stl", "off",
                                      "dae", "fbx", "3ds",  "lwo", "ac",  "x"};

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char path[128];
    pnb_context *context;
    pnb_scene *scene = NULL;
    const char *folder = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : "/tmp";
    if (size < 1)
        return 0;
    const char *ending = endings[data[0] % (sizeof(endings) / sizeof(endings[0]))];
    snprintf(path, sizeof(path), "%s/pnb-fuzz-import-%d.%s", folder, (int)getpid(), ending);
    FILE *file = fopen(path, "wb");
    if (!file)
        return 0;
    bool written = fwrite(data + 1, 1, size - 1, file) == size - 1;
    if (fclose(file) == 0 && written &&
        pnb_context_create(&(pnb_context_desc){.threads = 1}, &context) == PNB_OK) {
        struct scene_import_limits limits = {
            .memory_bytes = 512 << 20, .answer_bytes = 64 << 20, .seconds = 2};
        if (scene_import_within(context, path, &limits, &scene) != PNB_OK) {
            if (scene || !strstr(pnb_context_error(context), path))
                abort();
        } else if (pnb_scene_triangle_count(scene) == 0 || pnb_scene_light_count(scene) == 0) {
            abort();
        }
        pnb_scene_destroy(scene);
        pnb_context_destroy(context);
    }
    unlink(path);
    return 0;
}
