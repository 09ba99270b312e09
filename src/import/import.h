/* import/import.h: the importer's parts. A program of its own: one file in, one stream out, no
 * state worth cleaning up; whatever goes wrong ends it with a line on standard error. */
#ifndef IMPORT_IMPORT_H
#define IMPORT_IMPORT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <jansson.h>

#include "scene/import_stream.h"

/* Ends the process. */
_Noreturn void import_fail(int exit_status, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void *import_alloc(size_t count, size_t size); /* zeros; never NULL */
void import_free(void *block);

/* The stream: begin a record, fill it with exactly its size, in multiples of 4. */
void writer_open(int fd); /* with the stream's header */
void writer_close(void);  /* with the END record */
void writer_record(enum import_record kind, size_t size);
void writer_bytes(const void *bytes, size_t size);
void writer_u32(uint32_t value);
void writer_numbers(const double *values, size_t count);
void writer_text(const char *text);
size_t writer_text_size(const char *text);
void writer_note(const char *format, ...) __attribute__((format(printf, 1, 2)));
void writer_camera(const char *name, const double numbers[IMPORT_CAMERA_NUMBERS]);
void writer_light(const char *name, unsigned type, const double numbers[IMPORT_LIGHT_NUMBERS]);

/* One vertex for each distinct (position, normal); order of first use. normals NULL: by position.
 * Fills the caller's arrays; both may be as long as the input. O(n). Returns the number of vertices
 * kept; unused vertices are dropped. */
size_t weld_vertices(const float *positions, const float *normals, size_t vertex_count,
                     uint32_t *indices, size_t index_count, float *out_positions,
                     float *out_normals);

/* out = a x b, row-major 3x4; out is neither of them. */
void matrix_multiply(const double *a, const double *b, double *out);

/* The JSON of a .gltf or .glb file, or NULL: another kind of file, or not readable as such. */
json_t *gltf_read(const char *path);
/* Cameras and lights of the glTF scene: those nodes that assimp knows nothing of, or mixes up when
 * several of them share one light. */
void gltf_write_cameras_and_lights(json_t *gltf);
/* KHR_materials_emissive_strength of a material, else 1. */
double gltf_emissive_strength(json_t *gltf, size_t material);

/* What this project's own files say beyond glTF, in extras: ambient light and background of the
 * scene; of a node, flags of IMPORT_OBJECT (0: none said). json may be NULL. */
void gltf_write_surroundings(json_t *gltf);
uint32_t gltf_object_flags(json_t *node);
/* The scene's only root, or NULL: there are more, or gltf is NULL. */
json_t *gltf_root(json_t *gltf);
/* Child number index of a node that should have count of them, or, for a NULL node at the top, that
 * root of the scene; NULL: unknown. */
json_t *gltf_child(json_t *gltf, json_t *node, bool top, size_t index, size_t count);

/* Everything of a file; gltf may be NULL. */
void convert_file(const char *path, json_t *gltf);

#endif
