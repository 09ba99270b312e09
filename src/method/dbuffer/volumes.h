/* method/dbuffer/volumes.h: the umbra and penumbra volumes of a frame's occluders, as pieces that a
 * vertex shader extrudes. Knows no OpenGL.
 *
 * All in light space (silhouette/disk.h). */
#ifndef DBUFFER_VOLUMES_H
#define DBUFFER_VOLUMES_H

#include "gl/frame.h"
#include "silhouette/disk.h"

/* A quad from v1 and v2 away from the extrusion point p1 = p2; or, where v1 = v2, one triangle of a
 * fan from that vertex, between the directions away from p1 and p2, which then lie on the rim or,
 * between two arcs, just outside it, so that the fan's triangles cover the cone over the arc.
 *
 *        p1 = p2                    p1 .. p2
 *          / \                        \/
 *        v1---v2                     v1 = v2
 *        /     \                      /\
 *   v1 - p1   v2 - p2 (at infinity)                                            */
struct dbuffer_piece {
    float v1[3], v2[3];
    float p1[2], p2[2];
    float object; /* of the occluders, counted from 1 */
    float kind;   /* 0: umbra volume; 1: penumbra volume */
};

/* A silhouette face that the light's centre lies behind, seen from there: the gap between the
 * outline from the centre and the umbra volume. What bounds the light behind it is the nearest
 * outline edge v1 v2, with the extrusion point p of an umbra. */
struct dbuffer_face {
    float corners[3][3];
    float v1[3], v2[3], p[2];
    float object;
};

struct dbuffer_volumes {
    pnb_context *context;
    struct dbuffer_piece *umbra, *penumbra;
    size_t umbra_count, umbra_capacity, penumbra_count, penumbra_capacity;
    struct dbuffer_face *faces;
    size_t face_count, face_capacity;
    size_t umbra_edges, penumbra_edges; /* silhouette edges of either kind */
    size_t skipped_edges;               /* their line meets the light's disk */
    size_t concave_edges; /* of closed objects: hidden from the light by their own solid */
    /* Scratch, kept from frame to frame. */
    uint8_t *facing;
    float *rise; /* height of the centre over the face's plane, in radii that the plane reaches */
    uint32_t *across; /* 3 per triangle: edges */
    size_t facing_capacity, rise_capacity, across_capacity;
    struct dbuffer_link *links;
    size_t link_count, link_capacity;
    uint32_t *heads;
    size_t head_capacity;
};

void dbuffer_volumes_init(pnb_context *context, struct dbuffer_volumes *volumes);
void dbuffer_volumes_finish(struct dbuffer_volumes *volumes);
/* Replaces what volumes holds. O(triangles + edges). */
pnb_status dbuffer_volumes_build(struct dbuffer_volumes *volumes,
                                 const struct gl_occluders *occluders,
                                 const struct silhouette_disk *disk);

#endif
