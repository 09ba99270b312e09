/* method/planar/refine.h: the parts of refinement: a Delaunay mesh with fixed sides (delaunay.c),
 * and where the shadow can be and where it jumps (reach.c). */
#ifndef METHOD_PLANAR_REFINE_H
#define METHOD_PLANAR_REFINE_H

#include "method/planar/room.h"

struct delaunay_corners {
    float value[3];
    uint8_t fixed; /* bit k: side k is part of the foot's outline */
    bool inside;   /* below a foot */
};

struct delaunay {
    pnb_context *context;
    struct planar_point *points;
    float *values;
    size_t point_count, point_capacity, value_capacity;
    uint8_t *jump; /* per point: on the foot's outline */
    size_t jump_capacity;
    struct planar_triangle *triangles; /* level: 0: new, -1: tested */
    struct delaunay_corners *corners;  /* per triangle */
    size_t triangle_count, triangle_capacity, corner_capacity;
    uint32_t *stack;
    size_t stack_count, stack_capacity;
    bool no_memory;
};

/* The triangle that holds p, walking from `from`. *out_side: the side that p lies on, or 3. */
uint32_t delaunay_find(const struct delaunay *m, struct planar_point p, uint32_t from,
                       int *out_side);
/* p lies in triangle t, on its side `side` (3: inside), as delaunay_find() says. */
void delaunay_insert(struct delaunay *m, struct planar_point p, float value, uint32_t t, int side);
/* Two triangles over a box; then points of a grid, cells along the longer side. */
void delaunay_start(struct delaunay *m, struct planar_point lo, struct planar_point hi);
void delaunay_add_grid(struct delaunay *m, struct planar_point lo, struct planar_point hi,
                       int cells);
/* A point of a line along which values jump; its number, or PLANAR_NONE outside the mesh. */
uint32_t delaunay_add_point(struct delaunay *m, struct planar_point p);
/* Makes a-b an edge of the mesh, or a chain of edges through points put between them. */
void delaunay_force_edge(struct delaunay *m, uint32_t a, uint32_t b, int depth);

/* What is to be meshed, grid units. */
struct reach {
    struct planar_point lo, hi;               /* all of it */
    struct planar_point shadow_lo, shadow_hi; /* where occluders' shadows can be */
    int start;                                /* cells along the longer side at the beginning */
    struct planar_point dark[8];              /* the part on the light's dark side, a polygon */
    int dark_count;
};

/* The outlines of what stands on the plane. */
struct reach_foot {
    struct planar_point *ends; /* two per edge */
    size_t count, capacity;
};

bool reach_in_foot(const struct reach_foot *foot, double x, double y);
pnb_status reach_find_foot(struct shadow_builder *b, const struct shadow_plane *plane,
                           const struct reach *region, struct reach_foot *foot);
/* False: no shadow can fall on the receiver. */
bool reach_find_region(struct shadow_plane *plane, const struct shadow_cluster *clusters,
                       size_t count, const struct light_shape *shape, double far, struct reach *r);

#endif
