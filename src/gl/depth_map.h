/* gl/depth_map.h: a depth map of a scene's casters seen from a point of the light: one fitted
 * perspective picture where all casters lie within a cone, else up to six faces of a cube. */
#ifndef GL_DEPTH_MAP_H
#define GL_DEPTH_MAP_H

#include "gl/frame.h"

#define GL_DEPTH_MAP_FACES 6

struct gl_depth_map {
    struct gl_device *device;
    int size;
    struct gl_texture *texture; /* LAYERS, R32F: 1 / distance along the face's axis; 0: nothing */
    struct gl_texture *depth;
    struct gl_target *targets[GL_DEPTH_MAP_FACES];
    struct gl_program *program;
    int capacity; /* layers that the texture has: 1 or 6 */
    /* Of the last draw: from where, and the faces. A point at d from the center has z = d.Z,
     * (x, y) = (d.X, d.Y) / z; the texture spans shift +- reach. */
    vec3 center;
    int face_count; /* 0: nothing casts */
    vec3 axes[GL_DEPTH_MAP_FACES][3];
    double shift[2], reach[2];
    double nearest; /* distance of the nearest caster's box from center, or less */
    float packed_axes[9 * GL_DEPTH_MAP_FACES];
};

pnb_status gl_depth_map_create(struct gl_device *device, int size, struct gl_depth_map **out_map);
void gl_depth_map_destroy(struct gl_depth_map *map);

/* From center. normal: the lit side of an area light, behind which nothing is needed, or zero.
 * Floors with center on their scene's side are left out. */
pnb_status gl_depth_map_draw(struct gl_depth_map *map, const struct gl_occluders *occluders,
                             vec3 center, vec3 normal);

/* The uniforms that gl/depth_map.glsl wants, GL_DEPTH_MAP_UNIFORMS of them, to be put anywhere in a
 * draw's list. The map must outlive the draw. */
#define GL_DEPTH_MAP_UNIFORMS 6
void gl_depth_map_uniforms(const struct gl_depth_map *map, struct gl_uniform *uniforms);

#endif
