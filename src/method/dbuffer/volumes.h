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
 *   v1 - p1   v2 - p2
 *
 */
struct dbuffer_piece {
    float v1[3], v2[3]; /* the solid lies on the left */
    float p1[2], p2[2];
    /* The edge's line: of a fan, that of the edge that comes into its vertex. Umbra: the outline's
     * too; DBUFFER_NONE where it is the edge itself, or has no plane. Indices of lines. */
    float line, outline_line;
    /* Umbra: the outline, seen from the light's centre, of the solid before the edge, in the same
     * direction; the edge itself where it is that, or where the way to it is lost. Zero: of an open
     * mesh. outline_p is its own extrusion point; zero where it has none. */
    float outline1[3], outline2[3], outline_p[2];
};

/* A silhouette face that the light's centre lies behind: the gap, seen from there, between the
 * outline and the umbra volume. What bounds the light behind it is the outline edge v1 v2, with
 * the extrusion point p of an umbra; where there is none, p = 0 and v1 is the face's normal. */
struct dbuffer_face {
    float corners[3][3];
    float v1[3], v2[3], p[2], line;
};

/* What a pixel needs of a silhouette edge: where it runs, and the lines of the edges before and
 * after it, marked where the outline is reflex at the corner. */
#define DBUFFER_NONE   (-1.0f)
#define DBUFFER_REFLEX 0.5f
struct dbuffer_line {
    float v1[3], before;
    float v2[3], after;
};

struct dbuffer_volumes {
    pnb_context *context;
    /* By [0: umbra, 1: penumbra]. */
    struct dbuffer_pieces {
        struct dbuffer_piece *pieces;
        size_t count, capacity;
    } quads[2], fans[2];
    size_t edges[2]; /* silhouette edges */
    struct dbuffer_line *lines;
    size_t line_count, line_capacity;
    struct dbuffer_face *faces;
    size_t face_count, face_capacity;
    size_t skipped_edges; /* their line meets the light's disk */
    size_t concave_edges; /* of closed objects: hidden from the light by their own solid */
    /* Scratch, kept from frame to frame. */
    uint8_t *facing;
    uint32_t *across; /* 3 per triangle: edges */
    size_t facing_capacity, across_capacity;
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
