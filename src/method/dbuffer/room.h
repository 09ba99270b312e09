/* method/dbuffer/room.h: what the room's files share: the D-buffer on the device, and a pass over
 * its faces. */
#ifndef DBUFFER_ROOM_H
#define DBUFFER_ROOM_H

#include "method/dbuffer/map.h"
#include "method/dbuffer/volumes.h"
#include "method/opengl.h"

struct gl_depth_map;

#define DBUFFER_LINES 256
enum { OCCLUDER, UMBRA, PENUMBRA, KINDS };

struct dbuffer {
    struct gl_device *device;
    int size, layers; /* size as asked for; 0: map.size says */
    double bias;
    struct dbuffer_volumes volumes;
    struct dbuffer_map map;
    struct gl_buffer *quads[2], *fans[2]; /* umbra, penumbra */
    struct gl_buffer *faces;
    struct gl_texture *lines; /* DBUFFER_LINES a row, two texels each */
    float *face_vertices;
    size_t face_capacity;
    struct gl_program *draw[KINDS][2]; /* by layer; of volumes, the quads */
    struct gl_program *draw_fan[KINDS][2], *draw_face[2], *evaluate, *point;
    struct gl_texture *textures[KINDS][2], *depth; /* LAYERS; as many as faces */
    struct gl_target *targets[KINDS][2][DBUFFER_FACES];
    int face_count, texture_size; /* that the textures have */
    struct gl_depth_map *point_map;
};

/* One D-buffer being drawn. */
struct dbuffer_pass {
    struct dbuffer *b;
    const struct gl_occluders *occluders;
    const struct silhouette_disk *disk;
    double per_far, gap, far_z;
    float axes[9 * DBUFFER_FACES];
    int face;
};

/* draw.c */
pnb_status dbuffer_programs_create(pnb_solver *solver, struct dbuffer *b);
/* The map's size, as many faces, or more; the same while that fits. */
pnb_status dbuffer_textures_reserve(struct dbuffer *b);
void dbuffer_textures_destroy(struct dbuffer *b);
pnb_status dbuffer_volumes_upload(pnb_solver *solver, struct dbuffer *b);
/* All faces, all layers. */
void dbuffer_draw_faces(struct dbuffer_pass *pass);

#endif
