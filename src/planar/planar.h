/* planar/planar.h: the plane cut up by directed edges: winding numbers, outlines, rings,
 * triangulations. Pure 2-D on an integer grid: knows no mesh and no light.
 *
 *   points + weighted directed segments
 *        -> planar_sweep()    edges that meet in end points only, winding number on both sides,
 *                             optionally triangles of every face and trapezoids
 *        -> planar_outline()  the edges where the winding number passes a threshold, as input again
 *        -> planar_rings()    the same as closed chains
 *        -> planar_improve()  better-shaped triangles, by exchange of diagonals
 *        -> planar_strips()   or strips from ring to ring at once, without the sweep's triangles
 *
 * A segment of weight w raises the winding number by w on its right (the paper: the shadow lies on
 * the right of a silhouette edge). Weights may be any integer; at every point those that arrive and
 * those that leave must be equal, so that the edges close.
 */
#ifndef PLANAR_PLANAR_H
#define PLANAR_PLANAR_H

#include "base/base.h"
#include "planar/predicate.h"

#define PLANAR_NONE 0xffffffffu

struct planar_segment {
    uint32_t a, b; /* points */
    int32_t weight;
};

/* left comes before right in the order of the sweep (x, then y). */
struct planar_edge {
    uint32_t left, right;
    int32_t below, above; /* winding numbers; a vertical edge's "above" is its left side */
};

/* Counter-clockwise. near[k]: the half-edge (3 x triangle + side) on the other side of the side
 * from v[k] to v[(k + 1) % 3], or PLANAR_NONE where the side is an edge of the arrangement. */
struct planar_triangle {
    uint32_t v[3], near[3];
    int32_t level;
};

/* A piece of a face between two edges, from x0 to x1 (grid units). */
struct planar_trapezoid {
    int32_t x0, x1;
    uint32_t lower, upper; /* edges */
    int32_t level;
};

struct planar_options {
    int32_t base; /* winding number far away; 0 unless a frame is swept along */
    bool triangulate, trapezoids;
    int32_t min_level, max_level; /* of the faces to be triangulated; 0, 0: 1 and above */
    /* Above 0: of the edges only those where the winding number passes it are wanted (an outline);
     * the result leaves out the others. Not with trapezoids. */
    int32_t threshold;
};

/* What a sweep leaves. All arrays belong to the workspace and last until its next sweep. */
struct planar_result {
    const struct planar_point *points;
    size_t point_count;
    size_t input_point_count; /* distinct ones of the input come first, in sweep order */
    const struct planar_edge *edges;
    size_t edge_count;
    struct planar_triangle *triangles;
    size_t triangle_count;
    const struct planar_trapezoid *trapezoids;
    size_t trapezoid_count;
    size_t crossing_count; /* points that were not in the input */
    bool snapped;          /* the careful way was needed, see snap.c */
};

struct planar_workspace;
pnb_status planar_workspace_create(pnb_context *context, struct planar_workspace **out_workspace);
void planar_workspace_destroy(struct planar_workspace *workspace);

/* O((n + k) log n) for n segments with k crossings. Points that round to one are one; segments of
 * no length are left out; coincident ones add their weights. PNB_ERROR_ARGUMENT: the segments do
 * not close, a coordinate above PLANAR_LIMIT, an index out of range. */
pnb_status planar_sweep(struct planar_workspace *workspace, const struct planar_point *points,
                        size_t point_count, const struct planar_segment *segments,
                        size_t segment_count, const struct planar_options *options,
                        struct planar_result *out_result);

/* Growing input of a sweep. */
struct planar_input {
    struct planar_point *points;
    size_t point_count, point_capacity;
    struct planar_segment *segments;
    size_t segment_count, segment_capacity;
};
void planar_input_finish(pnb_context *context, struct planar_input *input);
pnb_status planar_input_reserve(pnb_context *context, struct planar_input *input,
                                size_t more_points, size_t more_segments);
/* Appends the boundary between winding number >= threshold and below it, weight 1, inside on the
 * right. */
pnb_status planar_outline(struct planar_workspace *workspace, const struct planar_result *result,
                          int32_t threshold, struct planar_input *io_input);

/* Closed chains of the boundary of {winding number >= threshold}, inside on the right; where the
 * region touches itself in a point the chains touch and do not cross. starts has chain_count + 1
 * entries. The caller frees both by memory_free(). */
struct planar_chains {
    uint32_t *points; /* of the result */
    uint32_t *starts;
    size_t chain_count;
};
pnb_status planar_rings(struct planar_workspace *workspace, const struct planar_result *result,
                        int32_t threshold, struct planar_chains *out_chains);
void planar_chains_finish(pnb_context *context, struct planar_chains *chains);

/* The same regions with rings parted where they touch in a crossing (reconnect.c), as input of the
 * next sweep. share: of the shorter edge at a crossing, in (0, 1/2]. out_count: crossings parted.
 */
pnb_status planar_reconnect(struct planar_workspace *workspace, const struct planar_result *result,
                            double share, struct planar_input *out, size_t *out_count);

enum planar_rule {
    PLANAR_RULE_SWEEP = 0, /* as the sweep left them */
    PLANAR_RULE_NEAREST,   /* the paper's: join the two rings, by the nearer of the next points */
    PLANAR_RULE_DELAUNAY   /* constrained Delaunay */
};
/* Exchanges diagonals within faces until the rule holds everywhere. values: one per point, for
 * NEAREST (triangles with three equal values are avoided); may be NULL otherwise. avoid: points
 * that diagonals of faces at level avoid_min and above, or avoid_max and below, should not end at
 * (the paper's leaks); NULL: none. Returns the number of exchanges. */
struct planar_improve {
    enum planar_rule rule;
    const float *values;
    const uint8_t *avoid;
    int32_t avoid_above, avoid_below;
    int32_t even_from; /* above 0: faces at this level and above stay as they are */
};
size_t planar_improve(struct planar_workspace *workspace, const struct planar_result *result,
                      const struct planar_improve *how);

/* The faces at level 1 and above of a result that was swept without triangles and trapezoids and
 * with all edges, filled by the rule NEAREST: strips where two rings make one, else as
 * planar_sweep() and planar_improve() do. Triangles know no neighbours. */
struct planar_strips {
    int32_t even_from;      /* faces at this level and above are filled anyhow */
    const float *values;    /* as of planar_improve() */
    const uint8_t *corners; /* per point: whether a triangle of level 0 is wanted between the two
                             * edges of the outside that meet there (the paper's leaks), if nothing
                             * is in the way; NULL: none */
};
/* false: it cannot be done here, for want of memory or because rounding is in the way: let the
 * sweep fill. spare: another workspace. */
bool planar_strips(struct planar_workspace *workspace, struct planar_workspace *spare,
                   const struct planar_strips *how, struct planar_result *io_result);

/* Tests: NULL, or what is wrong: edges that cross, winding numbers that disagree around a point,
 * triangles that are not counter-clockwise, neighbours that disagree, areas that do not add up.
 * Slow (all pairs of edges whose boxes overlap). */
const char *planar_validate(const struct planar_result *result,
                            const struct planar_options *options);
/* For humans: edges coloured by winding number, triangles thin, as an SVG text. The caller frees.
 */
char *planar_draw_svg(pnb_context *context, const struct planar_result *result);

/* Hot-pixel rounding: the same segments cut so that they meet in end points only (snap.c). */
pnb_status planar_snap(pnb_context *context, const struct planar_input *in,
                       struct planar_input *out);

#endif
