/* planar.h: the sweep by itself: directed edges in; regions by winding number, boundary chains and
 * triangulations out. Pure 2-D: knows no mesh and no light.
 *
 * An edge from a to b with weight w raises the winding number by w on its right. At every point the
 * weights that arrive and those that leave must be equal, so that the edges close.
 *
 * Inside, coordinates are integers: 2^30 steps over the larger side of the input's bounds. Points
 * that fall on one step are one; a crossing is rounded to a step. All decisions are exact on that
 * grid, so results never contradict themselves.
 */
#ifndef PENUMBRA_PLANAR_H
#define PENUMBRA_PLANAR_H

#include <penumbra/context.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum pnb_planar_fill {
    PNB_PLANAR_FILL_NONE = 0,
    PNB_PLANAR_FILL_SWEEP,    /* triangles as the sweep leaves them: fastest */
    PNB_PLANAR_FILL_DELAUNAY, /* constrained Delaunay */
    PNB_PLANAR_FILL_TRAPEZOIDS
} pnb_planar_fill;

typedef struct pnb_planar_desc {
    const double *points; /* point_count x 2, finite */
    size_t point_count;
    const uint32_t *edges;  /* edge_count x 2: from, to */
    const int32_t *weights; /* edge_count, or NULL: 1 each */
    size_t edge_count;
    pnb_planar_fill fill;
    int32_t min_level, max_level; /* winding numbers that are filled; both 0: 1 and above */
} pnb_planar_desc;

/* left comes before right by x, then y. A vertical edge's "above" is its left side. */
typedef struct pnb_planar_edge {
    uint32_t left, right;
    int32_t below, above; /* winding numbers on both sides */
} pnb_planar_edge;

/* Views, valid until the next sweep. Edges meet in their ends only. Triangles are
 * counter-clockwise, use the points above, cover each filled region once and have no T-junctions.
 * Trapezoids: two vertical sides at x[0] and x[1], below y0[0]-y0[1], above y1[0]-y1[1]. */
typedef struct pnb_planar_trapezoid {
    double x[2], y0[2], y1[2];
    int32_t level;
} pnb_planar_trapezoid;

typedef struct pnb_planar_view {
    const double *points; /* point_count x 2 */
    size_t point_count;
    const pnb_planar_edge *edges;
    size_t edge_count;
    const uint32_t *triangles; /* triangle_count x 3 */
    const int32_t *triangle_levels;
    size_t triangle_count;
    const pnb_planar_trapezoid *trapezoids;
    size_t trapezoid_count;
} pnb_planar_view;

typedef struct pnb_planar pnb_planar;

PNB_API pnb_status pnb_planar_create(pnb_context *context, pnb_planar **out_planar);
PNB_API void pnb_planar_destroy(pnb_planar *planar);

/* O((n + k) log n) for n edges with k crossings; memory is reused from call to call.
 * PNB_ERROR_ARGUMENT: the edges do not close, an index out of range, a coordinate not finite. */
PNB_API pnb_status pnb_planar_sweep(pnb_planar *planar, const pnb_planar_desc *desc);
PNB_API void pnb_planar_get(const pnb_planar *planar, pnb_planar_view *out_view);

/* The boundary of {winding number >= level} of the last sweep as closed chains, the inside on the
 * right (outer boundaries clockwise, holes counter-clockwise); chains touch and do not cross.
 * starts: chain_count + 1 entries into points. Valid until the next call. */
PNB_API pnb_status pnb_planar_chains(pnb_planar *planar, int32_t level, const uint32_t **out_points,
                                     const uint32_t **out_starts, size_t *out_chain_count);

#ifdef __cplusplus
}
#endif
#endif
