/* scene/import_stream.h: what the importer (the program penumbra-import) says to the library.
 *
 * The importer reads a file that nobody trusts with a library that may fall over it, in a process
 * of its own, and writes what it found to a pipe as one stream:
 *
 *   magic "PNBSTRM" and a zero, u32 version, u32 zero
 *   records: u32 kind, u32 zero, u64 size, then size bytes; the last one is IMPORT_END with size 0
 *
 * Numbers are little-endian (both ends run on one machine, and that is what penumbra runs on);
 * every field is a multiple of 4 bytes, so that arrays lie aligned in the stream and are used where
 * they lie. Text is u32 length, its bytes, and zeros up to the next multiple of 4.
 *
 *   MESH: text name, u32 vertices, u32 triangles, u32 flags, f32 x 3 positions, f32 x 3 normals if
 *   flagged, u32 x 3 indices
 *
 *   OBJECT: text name, u32 mesh (by order in the stream, before this record), u32 flags, f64 x 12
 *   world_from_mesh, f64 x 3 colour, f64 x 3 emission
 *
 *   CAMERA: text name, f64 x 3 eye, f64 x 3 direction, f64 x 3 up, f64 vertical field of view in
 *   degrees
 *
 *   LIGHT: text name, u32 type (pnb_light_type, but no polygon or line), u32 zero, f64 x 3 colour,
 *   f64 x 9 shape: the numbers of pnb_light's structs in their order, zeros after them
 *
 *   NOTE: text
 *
 *   SURROUNDINGS: f64 x 3 ambient, f64 x 3 background
 */
#ifndef SCENE_IMPORT_STREAM_H
#define SCENE_IMPORT_STREAM_H

#define IMPORT_MAGIC                "PNBSTRM" /* 8 bytes with its zero */
#define IMPORT_VERSION              1u
#define IMPORT_TEXT_MAX             1024
#define IMPORT_OBJECT_NUMBERS       18
#define IMPORT_CAMERA_NUMBERS       10
#define IMPORT_LIGHT_NUMBERS        12
#define IMPORT_SURROUNDINGS_NUMBERS 6

enum import_record {
    IMPORT_END = 0,
    IMPORT_MESH,
    IMPORT_OBJECT,
    IMPORT_CAMERA,
    IMPORT_LIGHT,
    IMPORT_NOTE,
    IMPORT_SURROUNDINGS
};

/* Flags of a mesh, and of an object. */
#define IMPORT_HAS_NORMALS 1u

#define IMPORT_DOUBLE_SIDED 1u
#define IMPORT_CASTS_NOT    2u
#define IMPORT_RECEIVES_NOT 4u
#define IMPORT_PLANE        8u

/* Exit status of the importer; the reason is the first line of its standard error. */
enum import_exit {
    IMPORT_DONE = 0,
    IMPORT_BAD_FILE = 1,
    IMPORT_BAD_CALL = 2,
    IMPORT_NO_MEMORY = 3
};

#endif
