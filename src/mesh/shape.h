/* mesh/shape.h: meshes made by rule, for built-in scenes and tests. Each call appends to what is
 * there. Every closed shape is a closed, consistently oriented 2-manifold after welding, outward;
 * its triangle count stands beside it. */
#ifndef MESH_SHAPE_H
#define MESH_SHAPE_H

#include "mesh/mesh.h"

struct shape {
    pnb_context *context;
    float *positions; /* vertex_count x 3 */
    float *normals;   /* vertex_count x 3; zero where the shape is meant to look flat */
    uint32_t *indices;
    size_t vertex_count, vertex_capacity, normal_capacity;
    size_t triangle_count, index_capacity;
    bool smooth; /* some normal is not zero */
    bool failed; /* out of memory: every call after that does nothing */
};

void shape_init(pnb_context *context, struct shape *shape);
void shape_finish(struct shape *shape);
/* Borrows the shape's arrays. */
pnb_mesh_desc shape_desc(const struct shape *shape, const char *name);

/* Number of the new vertex. */
uint32_t shape_vertex(struct shape *shape, vec3 position, vec3 normal);
void shape_triangle(struct shape *shape, uint32_t a, uint32_t b, uint32_t c);

/* Eight corners: bit 0 of the corner's number is x, bit 1 y, bit 2 z. 12 triangles. */
void shape_hexahedron(struct shape *shape, const vec3 corners[8]);
void shape_box(struct shape *shape, vec3 low, vec3 high);
/* Box around center with half axes u, v, w (right-handed). */
void shape_beam(struct shape *shape, vec3 center, vec3 u, vec3 v, vec3 w);
/* Skin over rings of `count` points each, ring after ring in points: from one ring to the next
 * outward is to the right of the way along the ring. Joined from the last ring to the first
 * (closed: 2 rings count triangles), or ended by flat convex caps (2 (rings - 1) count + 2 (count -
 * 2)). A prism is two rings, counter-clockwise seen from the second one's side. */
void shape_loft(struct shape *shape, const vec3 *points, size_t rings, size_t count, bool closed);
/* Round rod, cone (radius 0 at one end) or frustum with flat caps. count sides, 4 count - 4
 * triangles (a cone: 2 count - 2). Its side is smooth. */
void shape_rod(struct shape *shape, vec3 from, vec3 to, double radius_from, double radius_to,
               size_t count);
/* 383 vertices in 17 rings and two poles: 762 triangles, the spheres of the wedge paper. */
void shape_sphere_762(struct shape *shape, vec3 center, double radius);
/* A tube around a closed curve: curve(user, t, p) with t in [0,1) and curve(1) = curve(0);
 * section(user, t, angle) is the radius there. The frame of the section does not twist against the
 * curve's own and closes. 2 along around triangles. */
struct shape_tube {
    vec3 (*curve)(const void *user, double t);
    double (*section)(const void *user, double t, double angle);
    const void *user;
    size_t along, around;
    bool open; /* two ends with flat caps: 2 (along - 1) around + 2 (around - 2) triangles */
};
void shape_tube(struct shape *shape, const struct shape_tube *tube);
/* Ring around y in the plane y = 0. 2 along around triangles. */
void shape_torus(struct shape *shape, double major, double minor, size_t along, size_t around);
/* An open parallelogram of two triangles, facing u x v. */
void shape_quad(struct shape *shape, vec3 center, vec3 half_u, vec3 half_v);

/* Moves the vertices from first_vertex on: p -> m p. */
void shape_transform(struct shape *shape, size_t first_vertex, const double m[12]);

/* Six times the signed volume that the triangles enclose, over 6. */
double shape_volume(const float *positions, const uint32_t *indices, size_t triangle_count);

#endif
