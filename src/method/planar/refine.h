/* method/planar/refine.h: the parts of refinement: a triangulation that carries samples of the
 * shadow (tiling.c), its decimation (decimate.c), where the shadow can be and where it jumps
 * (reach.c), and their driver (refine.c). */
#ifndef METHOD_PLANAR_REFINE_H
#define METHOD_PLANAR_REFINE_H

#include "method/planar/room.h"

/* A place where the exact shadow is known. */
struct tiling_sample {
    struct planar_point p;
    float truth;
    uint32_t next; /* in its triangle's list */
};

struct tiling_vertex {
    struct planar_point p;
    float truth;   /* the exact shadow here */
    float value;   /* what is interpolated */
    float need;    /* the error that taking it out would cost, when last tried */
    uint32_t tile; /* one of its triangles; PLANAR_NONE: the vertex is gone */
    bool jump;     /* on a line along which the shadow jumps: no value of its own */
    bool border;   /* of the meshed region */
};

/* Counter-clockwise. near[k]: the half-edge (3 x tile + side) on the other side of the side from
 * v[k] to v[(k + 1) % 3]. */
struct tiling_tile {
    uint32_t v[3], near[3]; /* v[0] PLANAR_NONE: a hole in the array */
    float value[3];         /* of the corners; those that jump are fitted to the samples */
    float error;            /* largest |interpolated - truth| of the samples */
    float cost;             /* what exchanges of diagonals lower */
    uint32_t first, count;  /* samples */
    uint8_t fixed;          /* bit k: side k lies on a line along which the shadow jumps */
    bool inside;            /* below a foot, where all is umbra */
    bool stale;             /* changed since its samples were looked at */
    uint8_t seen;           /* bit k: thinning has tried corner k, and nothing has changed since */
};

/* A triangle that may come to be. */
struct tiling_plan {
    uint32_t v[3];
    bool inside;
    float value[3], error;
    double cost;
};

struct tiling_gathered {
    double x, y;
    float truth;
    uint32_t sample;
    uint32_t plan;
};

#define TILING_STAR_MAX 48

struct tiling {
    pnb_context *context;
    double tolerance;
    double thin2; /* squared: triangles of a smaller height are not made on purpose */
    struct tiling_vertex *vertices;
    size_t vertex_count, vertex_capacity;
    struct tiling_tile *tiles;
    size_t tile_count, tile_capacity;
    struct tiling_sample *samples;
    size_t sample_count, sample_capacity;
    uint32_t *free_tiles, *free_samples, *free_vertices;
    size_t free_tile_count, free_tile_capacity, free_sample_count, free_sample_capacity,
        free_vertex_count, free_vertex_capacity;
    uint32_t *stack; /* half-edges to be looked at */
    size_t stack_count, stack_capacity;
    struct tiling_gathered *gathered;
    size_t gathered_count, gathered_capacity;
    bool no_memory;
    /* Of a mesh that is kept between frames. */
    struct planar_point lo, hi; /* what it covers */
    size_t tiles_at_start;
    uint64_t random;
};

void tiling_finish(struct tiling *m);
/* The triangle that holds p, walking from `from`; PLANAR_NONE outside. */
uint32_t tiling_find(const struct tiling *m, struct planar_point p, uint32_t from);
/* A new vertex in tile t, which holds p; its number, or that of the vertex that is there. */
uint32_t tiling_insert(struct tiling *m, struct planar_point p, float truth, uint32_t t);
/* The same, p being (rounded) a point of side k of t: both triangles there are split. */
uint32_t tiling_split_side(struct tiling *m, struct planar_point p, float truth, uint32_t t, int k);
void tiling_add_sample(struct tiling *m, struct planar_point p, float truth, uint32_t t);
/* Takes a sample out; its triangle is t. */
void tiling_drop_sample(struct tiling *m, uint32_t t, uint32_t sample);
/* A vertex that no triangle has any more. */
void tiling_forget_vertex(struct tiling *m, uint32_t v);
/* Values, error and cost from the samples there are. */
void tiling_measure(struct tiling *m, uint32_t t);
void tiling_push_tile(struct tiling *m, uint32_t t);
/* Exchanges diagonals, beginning with those on the stack, until the sum of costs falls no more. */
void tiling_exchange(struct tiling *m);
/* The triangles around v in turn, all of them; 0: more than TILING_STAR_MAX, or v on the border. */
int tiling_star(const struct tiling *m, uint32_t v, uint32_t *tiles, int *corners);
/* Samples of tiles to m->gathered; measures plans (of one patch) against them; replaces the patch.
 */
void tiling_gather(struct tiling *m, const uint32_t *tiles, int count);
void tiling_plan(struct tiling *m, struct tiling_plan *plans, int count);
void tiling_replace(struct tiling *m, const uint32_t *tiles, int tile_count,
                    const struct tiling_plan *plans, int plan_count);
double tiling_height2(const struct tiling *m, const uint32_t *v);
const char *tiling_validate(const struct tiling *m); /* NULL, or what is wrong */

/* decimate.c: takes out vertices as long as no sample is off by more than `limit`. */
size_t tiling_decimate(struct tiling *m, double limit);
/* Moves the vertices' values towards the best fit of the samples around them. */
void tiling_fit(struct tiling *m, double limit);

/* What is to be meshed, grid units. */
struct reach {
    struct planar_point lo, hi;               /* all of it */
    struct planar_point shadow_lo, shadow_hi; /* where occluders' shadows can be */
    int start;                                /* cells along the longer side at the beginning */
    struct planar_point dark[8];              /* the part on the light's dark side, a polygon */
    int dark_count;
    bool dark_apart; /* it does not meet the box from lo to hi */
};

/* The outlines of what stands on the plane. */
struct reach_foot {
    struct planar_point *ends; /* two per edge, the foot on its right */
    size_t count, capacity;
};

pnb_status reach_find_foot(struct shadow_builder *b, const struct shadow_plane *plane,
                           const struct reach *region, struct reach_foot *foot);
/* False: no shadow can fall on the receiver. */
bool reach_find_region(struct shadow_plane *plane, const struct shadow_cluster *clusters,
                       size_t count, const struct light_shape *shape, double far, struct reach *r);

/* kinks.c: the first mesh, values not yet known. out_kinks: it has the shadow's kinks, no grid is
 * needed. corners: of the light, plane space. */
pnb_status kinks_start(struct shadow_builder *b, struct shadow_plane *plane,
                       const struct light_shape *shape, const vec3 *corners, size_t corner_count,
                       const struct reach *region, const struct reach_foot *foot, struct tiling *m,
                       bool *out_kinks);

#endif
