/* scene/scene_file.h: the scene file's reader, with its surroundings made explicit. */
#ifndef SCENE_SCENE_FILE_H
#define SCENE_SCENE_FILE_H

#include "scene/scene.h"

/* Larger scene files are refused: geometry belongs into meshes. */
#define SCENE_FILE_LIMIT ((size_t)64 << 20)

/* Numbers beyond this are refused: their squares must stay floats in the middle of the range. */
#define SCENE_NUMBER_LIMIT 1e18

struct scene_file_source {
    const char *file;   /* named in errors */
    const char *folder; /* meshes are relative to it; NULL: the current one */
    /* Adds the mesh file at path; NULL: scene_import_mesh(). */
    pnb_status (*import_mesh)(pnb_scene *scene, const char *path, size_t *out_mesh);
};

pnb_status scene_file_parse(pnb_context *context, const char *text, size_t length,
                            const struct scene_file_source *source, pnb_scene **out_scene);

#endif
