/* method/dbuffer/map.h: where a D-buffer's texels look, from the light's centre. Knows no OpenGL.
 */
#ifndef DBUFFER_MAP_H
#define DBUFFER_MAP_H

#include "gl/frame.h"
#include "silhouette/disk.h"

#define DBUFFER_FACES 5

/* A face's texel at slope (a, b) holds what the ray Z + a X + b Y meets; slopes run from shift -
 * reach to shift + reach over the texture. Light space. */
struct dbuffer_map {
    int face_count; /* 0: nothing casts */
    vec3 axes[DBUFFER_FACES][3];
    double shift[2], reach[2];
    int size; /* texels of a face's side */
};

/* One face fitted around all directions in which a penumbra can lie, where these stay within a
 * cone; else five faces of a cube, the one that looks along the normal first, less those that no
 * penumbra meets. far_z: the farthest receiver's height over the light's plane, 0: unknown; size:
 * texels of a face's side, 0: 512, or 1024 where so few would make little of the light's radius. */
void dbuffer_map_fit(const struct gl_occluders *occluders, const struct silhouette_disk *disk,
                     double far_z, int size, struct dbuffer_map *map);

/* Whether an object can shadow anything for a light at center: floors do not (gl/frame.h). */
bool dbuffer_casts(const struct gl_occluder *object, const struct silhouette_disk *disk);

/* Column-major, of light space or, for world_axes, of world space relative to the centre; depth is
 * 0 everywhere, so that nothing is clipped but what lies behind the face. */
void dbuffer_map_matrix(const struct dbuffer_map *map, int face, const struct silhouette_disk *disk,
                        bool from_world, double out_matrix[16]);

#endif
