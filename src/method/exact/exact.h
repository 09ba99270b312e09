/* method/exact/exact.h: the parts of the room `exact`. See README.md for the algorithm. */
#ifndef METHOD_EXACT_EXACT_H
#define METHOD_EXACT_EXACT_H

#include "base/base.h"
#include "geom/vec.h"
#include "light/light.h"
#include "method/method.h"
#include "silhouette/clusters.h"
#include "silhouette/levels.h"
#include "silhouette/parts.h"

/* ---- the light and its samples (exact_light.c) ---- */

/* Sample positions: rows over a parallelogram that contains the light. Row j lies at
 * r = (j + row_shift) / rows; the part of it inside the light is cut into `bins` cells of equal
 * length, counted from its left end: s bins * scale[j] + base[j]. Each cell holds one sample,
 * place[j] behind its left end. Arrays over the grid are column-major: [column][stride], stride
 * being rows rounded up to whole vectors, so that a vector holds one column of many rows. */
#define EXACT_ROWS_MAX 144 /* a vector more than there are */

struct exact_grid {
    int rows, bins, stride;
    int fold; /* column k has bit k >> fold in the mask of touched columns */
    float row_shift;
    float scale[EXACT_ROWS_MAX], base[EXACT_ROWS_MAX], place[EXACT_ROWS_MAX];
    int32_t length[EXACT_ROWS_MAX]; /* of the row's part inside, in 1/256 bins: its weight */
    int32_t *weight;                /* [bins]: share of the cell inside the light, in 1/256 */
    int32_t *before; /* [bins + 1]: sum of the weights of the cells before this one */
    int32_t *inner;  /* [bins + 1]: -1 where the border before the cell may be moved */
    double total;    /* sum of weight x length */
    double per_bin, per_row, first_row; /* 1 / bins, 1 / rows, place of row 0 from the middle */
    int words;                          /* of 32 samples as bits in a row */
    uint32_t need[2 * EXACT_ROWS_MAX]; /* [row][word], bit k: cell k of the word weighs something */
};

/* center + (s - 1/2) u + (r - 1/2) v. Suns: directions center + ..., infinitely far. Lines have no
 * v and points no u either: what is missing is made up per tile, at right angles to the view. */
struct exact_light {
    pnb_light_type type;
    bool sun, one_sided; /* one_sided: shines to the side of normal */
    vec3 center, u, v, normal;
    struct exact_grid grid;
    /* Areas of the light are known in closed form, over its own coordinates 0 <= u, v <= 1, of a
     * place x, y on the grid: u = x to_u, v = x v_x + y v_y + v_0. */
    bool closed;
    float to_u, v_x, v_y, v_0;
    int samples; /* of the pattern: the next one of some fixed numbers */
};

pnb_status exact_light_init(pnb_context *context, const pnb_light *light, int samples, bool area,
                            struct exact_light *out_light);
void exact_light_finish(pnb_context *context, struct exact_light *light);

/* ---- coverage of the grid (exact_cover.c, exact_kernel.inc) ---- */

/* cells: [bins + 2][stride]. Column 0: the number of occluders at the row's left end; column k: its
 * change from sample k - 2 to sample k - 1 (the row's ends being the first and the last border).
 * A cell's lower half is that number; its upper half the sum of change x (true place of the
 * crossing
 * - border between the two samples' cells), in 1/256 cells: cell = upper * 65536 + lower, both with
 * sign. */
struct exact_cover {
    const struct exact_grid *grid;
    int32_t *cells;
    /* [stride + 1]: change from row to row of the number of occluders whose border lies left of the
     * light; it adds to column 0. */
    int32_t *left;
    uint32_t *touched; /* columns that may hold anything */
    bool area;         /* use the upper halves */
    int unit; /* by how much one occluder changes the count: 2 for closed ones, 1 for sheets */
    /* Not NULL: no cells but a bit per sample, [words][stride]; for exact_kernel.inc alone. */
    uint32_t *hidden;
};

/* Rows have at most this many samples for samples as bits. */
#define EXACT_MASK_BINS 64

/* Edges that matter to a block of receivers: the offset of the first field, the change of the
 * count, and the enlargements at the ends (the bits of floats). */
struct exact_picks {
    int32_t *at, *change, *sight[2];
};

static inline int exact_cell_change(int32_t cell)
{
    return (int16_t)cell;
}
static inline int exact_cell_rest(int32_t cell)
{
    return (int32_t)((uint32_t)cell + 0x8000u) >> 16;
}
static inline int32_t exact_cell_add(int32_t cell, int change, int rest)
{
    return (int32_t)((uint32_t)cell + (uint32_t)change * ((uint32_t)rest * 65536u + 1));
}

/* A receiver in the tile's light frame; see exact_tile.inc. */
struct exact_eye {
    float a, b, h;
    float scale; /* a and b of an occluder point are enlarged by scale / (h - its h) */
    float x, y;  /* place on the grid, in bins and rows, of a point with the eye's own a, b */
};

/* Edges come in blocks of 16, one array of 16 floats per field. */
#define EXACT_LANES 16
enum { /* an edge whose weight is known for the whole tile */
       FIXED_A0,
       FIXED_B0,
       FIXED_H0,
       FIXED_A1,
       FIXED_B1,
       FIXED_H1,
       FIXED_WEIGHT,
       FIXED_FIELDS
};
enum { /* an edge whose weight depends on the side of two planes on which the eye lies */
       OPEN_A0,
       OPEN_B0,
       OPEN_H0,
       OPEN_A1,
       OPEN_B1,
       OPEN_H1,
       OPEN_P0,
       OPEN_P1 = OPEN_P0 + 4,
       OPEN_W0 = OPEN_P1 + 4,
       OPEN_W1,
       OPEN_FIELDS
};

/* The rows above a point left of the light change by weight. */
struct exact_step {
    float b, h;
    int weight;
};

struct exact_edges {
    float *fixed, *open;                  /* blocks */
    size_t fixed_count, open_count;       /* edges */
    size_t fixed_capacity, open_capacity; /* floats */
    struct exact_step *steps;
    size_t step_count, step_capacity;
};

struct exact_job;
struct exact_work;
struct exact_point;

/* Bounds of receivers and of their normals. */
struct exact_box {
    float low[3], high[3], normal_low[3], normal_high[3];
};

struct exact_kernel {
    const char *name;
    /* The bounds of 16 rows of 16 receivers, stride floats from row to row; false: one is no
     * number. */
    bool (*bound)(const float *positions, const float *normals, size_t stride,
                  struct exact_box *box);
    /* True: receivers in the box are all lit. Else notes for tile() which instances may hide the
     * light from them. */
    bool (*survey)(const struct exact_job *job, struct exact_work *work,
                   const struct exact_box *box);
    /* Visibility of up to EXACT_TILE receivers, all on the light's lit side (a single one may lie
     * behind it by its lift); reorders them. */
    void (*tile)(const struct exact_job *job, struct exact_work *work, struct exact_point *points,
                 size_t count);
    /* The visible share of grid->total. */
    double (*resolve)(const struct exact_cover *cover);
};

/* The best one that the processor has, or the one that PNB_CPU names (c, avx2, avx512); NULL if
 * that is none or the processor lacks it. */
const struct exact_kernel *exact_kernel_choose(const char *name);
extern const struct exact_kernel exact_kernel_c, exact_kernel_avx2, exact_kernel_avx512;

size_t exact_cover_size(const struct exact_grid *grid);  /* cells */
void exact_cover_clear(const struct exact_cover *cover); /* the touched columns */

/* What an eye sees of the light: e(s, r) = center + (s - 1/2) u + (r - 1/2) v is the vector from
 * the eye to the light. reach: occluders count up to this share of e; 0: without end. */
struct exact_view {
    vec3 center, u, v;
    double reach;
};

/* Linear in bins x and row j of the grid: base + x step_x + j step_j. */
struct exact_linear {
    double base, step_x, step_j;
};

/* The four inequalities f >= 0 between which a triangle, corners relative to the eye, hides the
 * light; false: it hides none of the grid. trivial: bits of those that hold everywhere. */
bool exact_triangle_linear(const struct exact_grid *grid, const struct exact_view *view,
                           const vec3 corners[3], struct exact_linear f[4], unsigned *trivial);
/* Where n.e + lift <= 0. */
bool exact_below_linear(const struct exact_grid *grid, const struct exact_view *view, vec3 n,
                        double lift, struct exact_linear *f, unsigned *trivial);

/* One triangle, its corners relative to the eye, clipped in homogeneous coordinates: any position.
 * Double precision. False: it covers nothing. */
bool exact_cover_triangle(const struct exact_cover *cover, const struct exact_view *view,
                          const vec3 corners[3]);
/* All samples with n.e + lift <= 0: those below the receiver's tangent plane. */
bool exact_cover_below(const struct exact_cover *cover, const struct exact_view *view, vec3 n,
                       double lift);
/* For grids of one row, and as the twin of the vector versions. */
double exact_cover_resolve(const struct exact_cover *cover);

/* ---- occluders (exact_scene.c) ---- */

struct exact_bounds { /* world */
    vec3 low, high;
};

struct exact_instance {
    const struct clusters *clusters;
    const struct levels *levels; /* NULL: none but the clusters */
    double stretch; /* a length in the mesh is at most so many times longer in the world */
    double world_from_mesh[12], mesh_from_world[12];
    const vec3 *places; /* NULL, or the vertices in world space, in double precision */
    struct exact_bounds bounds;
    size_t object; /* of the scene */
};

/* Instances are sorted along a curve; so many of them share bounds. */
#define EXACT_GROUP 8

struct exact_scene {
    struct clusters **meshes; /* per mesh of the scene; NULL: casts nowhere, or has parts */
    struct parts **parts;     /* NULL: in one piece */
    struct levels **levels;   /* per mesh in one piece; NULL: only the clusters */
    struct clusters **baked;  /* per object: made of its own when the placement is not invertible */
    vec3 **places;            /* per object: of the baked vertices, not rounded */
    size_t mesh_count, object_count;
    struct exact_instance *instances;
    struct exact_bounds *groups;
    size_t instance_count, instance_capacity;
    size_t slots_max, clusters_max, vertices_max; /* of any instance's mesh */
    size_t bytes, triangle_count;
};

/* coarser: with coarser levels of meshes that are in one piece. */
pnb_status exact_scene_create(pnb_scene *scene, bool coarser, struct exact_scene **out_scene);
void exact_scene_destroy(pnb_context *context, struct exact_scene *scene);
pnb_status exact_scene_update(pnb_scene *scene, struct exact_scene *exact, pnb_update update);

/* ---- lights without extent (exact_point.c) ---- */

/* Nothing lies between p and the point light; for any number of threads at once. */
bool exact_point_seen(const struct exact_scene *scene, vec3 p, vec3 light);

/* ---- tiles (exact_tile.inc) ---- */

#define EXACT_TILE 256 /* receivers at most */

struct exact_point {
    size_t index; /* of the receiver */
    vec3 p, n;    /* lifted position, normal */
};

struct exact_job {
    const struct exact_scene *scene;
    const struct exact_light *light;
    const struct exact_kernel *kernel;
    double lift;
    bool area;           /* move borders between samples to their place */
    bool closed;         /* areas in closed form where they are known */
    bool triangles_only; /* every triangle by itself: the slow path everywhere */
    double detail;       /* how far a coarser level's picture may be off, in bins; 0: never */
    float *visibility;
};

struct exact_stats {
    size_t lit, umbra, sampled, closed;
    size_t edges, triangles, tiles; /* sums over tiles */
    size_t slabs, levels;           /* slabs of instances looked at, and their levels summed */
};

/* An instance in the tile's shaft; key: less where it is more likely to hide much of the light. */
struct exact_candidate {
    float key;
    uint32_t instance;
};

/* The edges of a solid between a tile's receivers and the light: one outline for each of them. */
struct exact_solid {
    size_t fixed, fixed_end, open, open_end; /* of the solids' edges: multiples of EXACT_LANES */
    float low[3], high[3];                   /* bounds in the tile's frame */
    float dent;                              /* of its mesh */
    float center[3], radius;                 /* a sphere around it, world, from the tile's middle */
};

/* How all of a tile's receivers see a triangle; MIXED: of clusters. */
enum { DROPPED = 0, FRONT, BACK, OPEN, MIXED };

/* What one thread needs; grows as it works. */
struct exact_work {
    pnb_context *context;
    uint8_t *state, *cluster_state;
    uint32_t *kept;
    float (*centers)[3];    /* of clusters, in the tile's frame */
    uint8_t edge_class[32]; /* by two states and whether their turns differ; see exact_work.c */
    uint32_t *list[2];      /* edges that count: fixed, open */
    size_t list_count[2], list_capacity[2];
    struct exact_edges edges, solid_edges;
    struct exact_edges *into; /* the one of them that is gathered */
    struct exact_solid *solids;
    size_t solid_count, solid_capacity;
    bool collapse;          /* edges left of the light to their ends */
    int16_t *vertex_weight; /* zero but for the vertices in ends */
    uint32_t marked[32];    /* vertices */
    uint32_t *ends;
    size_t end_count, end_capacity;
    int unit;           /* of the tile's occluders */
    vec3 (*loose)[3];   /* relative to the tile's middle */
    float *loose_frame; /* the same in the tile's frame, blocks of 9 fields */
    size_t loose_frame_count, loose_frame_capacity;
    size_t loose_count, loose_capacity;
    float *near_frame; /* those near a block of receivers, and their numbers */
    size_t near_capacity;
    int32_t *cells, *left;
    uint32_t touched;
    /* Samples as bits; see exact_block.inc. Aligned parts of one block of memory. */
    void *bits;
    int32_t *hidden, *near, *far, *spare, *steps, *turns;
    struct exact_picks picks[2]; /* decided ones and open ones */
    int32_t *picks_memory;
    size_t picks_capacity;
    bool surveyed;            /* the tile's occluders are among `nearby`; else they may be any */
    uint32_t *nearby, *found; /* instances */
    size_t nearby_count;
    struct exact_candidate *candidates; /* instances */
    struct exact_point scratch[EXACT_TILE];
    struct exact_stats stats;
    bool no_memory;
};

bool exact_work_init(pnb_context *context, const struct exact_scene *scene,
                     struct exact_work *work);
bool exact_work_prepare(struct exact_work *work, const struct exact_grid *grid);
void exact_work_finish(struct exact_work *work);

#endif
