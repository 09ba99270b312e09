/* scene/import.h: the library's side of the import: start the importer, decode its answer, make a
 * scene of it. Nothing that comes out of the importer is trusted. */
#ifndef SCENE_IMPORT_H
#define SCENE_IMPORT_H

#include "scene/scene.h"

struct scene_import_limits {
    size_t memory_bytes; /* address space of the importer; 0: 4 GiB, or 32 times the file */
    size_t answer_bytes; /* of its answer, which is held in memory; 0: 2 GiB */
    double seconds;      /* wall clock, and processor time; 0: 120 */
};

/* The importer's answer for a file: scene/import_stream.h, as bytes. The caller frees them. Fails
 * with "FILE: WHY" for a file that cannot be read or is of an unknown kind, and for an importer
 * that crashes, takes too long, wants too much memory or cannot be started. limits NULL: the
 * defaults. No process and no descriptor stays behind. */
pnb_status scene_import_run(pnb_context *context, const char *path,
                            const struct scene_import_limits *limits, unsigned char **out_bytes,
                            size_t *out_size);

struct scene_import_mesh {
    char *name;
    const float *positions, *normals; /* in the answer; normals may be NULL */
    const uint32_t *indices;
    size_t vertex_count, triangle_count;
};

struct scene_import_object {
    char *name;
    uint32_t mesh;
    bool double_sided, casts, receives, plane;
    double world_from_mesh[12], color[3], emission[3];
};

struct scene_import_camera {
    double eye[3], direction[3], up[3];
    double vertical_fov_degrees;
};

/* A decoded answer. */
struct scene_import_data {
    struct scene_import_mesh *meshes;
    size_t mesh_count, mesh_capacity;
    struct scene_import_object *objects;
    size_t object_count, object_capacity;
    struct scene_import_camera *cameras;
    size_t camera_count, camera_capacity;
    pnb_light *lights; /* names are the data's; not yet checked */
    size_t light_count, light_capacity;
    bool has_surroundings; /* ambient and background: given */
    double ambient[3], background[3];
    char **notes;
    size_t note_count, note_capacity;
};

/* Reads an answer; out_data refers to the bytes, which must lie aligned for float and outlive it.
 * Checks sizes, counts, references and text; geometry is checked when it is added to a scene.
 * file: for the error text. On failure out_data is empty. */
pnb_status scene_import_decode(pnb_context *context, const char *file, const unsigned char *bytes,
                               size_t size, struct scene_import_data *out_data);
void scene_import_data_finish(pnb_context *context, struct scene_import_data *data);

/* A scene of an answer; what it lacks is supplied. */
pnb_status scene_import_assemble(pnb_context *context, const char *file,
                                 const struct scene_import_data *data, pnb_scene **out_scene);

/* scene_import() under other limits. */
pnb_status scene_import_within(pnb_context *context, const char *path,
                               const struct scene_import_limits *limits, pnb_scene **out_scene);

/* Flat parts of an emissive object become lights of the scene: scene/emissive.c. */
pnb_status scene_import_emissive(pnb_scene *scene, const struct scene_import_data *data,
                                 size_t object);

#endif
