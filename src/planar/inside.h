/* planar/inside.h: what the files of this folder share: the workspace of a sweep. */
#ifndef PLANAR_INSIDE_H
#define PLANAR_INSIDE_H

#include "planar/planar.h"

/* An edge at work: one cache line. Before it starts it waits in the list of its left point. */
struct sweep_edge {
    struct planar_point l, r;
    uint32_t lid, rid; /* points; rid of an edge that ends at a crossing is known when it gets there
                        */
    int32_t delta;     /* winding number above minus below */
    int32_t below;
    uint32_t next; /* in the list of edges that start at one point */
    uint32_t hint; /* where in the status it was last */
    /* The gap above this edge: chain of points that its triangles still wait for, from this edge's
     * last point up to the next edge's. */
    uint32_t low, high, last;
    int32_t gap_x; /* where its trapezoid begins */
    /* Points already passed that lie within some grid units of the edge: how many, and the first
     * one's number. An edge is not bent to the other side of them. */
    int32_t grazed;
    uint32_t graze;
};

/* A point of a gap's chain. owner: what lies to the left of the link to the node above: a half-edge
 * of a triangle, PLANAR_NONE, or a diagonal (LINK_DIAGONAL). */
struct chain_node {
    uint32_t point, down, up, owner;
};

struct crossing {
    int64_t key;    /* planar_key() of the point */
    uint32_t first; /* edges that start here */
    uint32_t ends;  /* an edge that ends here: a hint */
};

struct diagonal {
    uint32_t half[2];
};

/* A face's rim, or a hole's; see strips.c. */
struct planar_loop {
    uint32_t first, count; /* in the walk */
    int32_t level;
    uint32_t turns;  /* from one ring to the other */
    bool hole, left; /* left: neither strip nor ears */
    struct planar_point lo, hi;
};

#define GROWING(type, name)                                                                        \
    type *name;                                                                                    \
    size_t name##_count, name##_capacity

struct sort_item {
    uint32_t x, index;
};

struct planar_workspace {
    pnb_context *context;
    bool no_memory;

    GROWING(struct planar_point, points);
    GROWING(struct sweep_edge, work);
    GROWING(struct planar_edge, edges);
    GROWING(struct planar_triangle, triangles);
    GROWING(struct planar_trapezoid, trapezoids);
    GROWING(uint32_t, status);
    GROWING(struct crossing, heap);
    GROWING(struct chain_node, nodes);
    GROWING(struct diagonal, diagonals);
    GROWING(uint32_t, rank);     /* input point -> sorted point */
    GROWING(uint32_t, first);    /* sorted point -> list of edges that start there */
    GROWING(uint32_t, incoming); /* sorted point -> an edge that ends there: a hint */
    GROWING(struct sort_item, sorted);
    GROWING(struct sort_item, spare);
    GROWING(uint32_t, stack); /* of planar_improve() */
    GROWING(uint8_t, queued);
    GROWING(uint32_t, slots); /* of planar_outline(); scratch */

    /* Of planar_strips(). */
    GROWING(uint32_t, next); /* half-edge -> the one that follows around the face on its left */
    GROWING(uint32_t, leaving);
    GROWING(uint32_t, leaving_next);
    GROWING(uint32_t, walk);
    GROWING(struct planar_loop, loops);
    GROWING(uint32_t, holes);
    GROWING(struct planar_point, given_points); /* of the spare one: what is swept again */
    GROWING(struct planar_segment, given_segments);
    GROWING(uint32_t, given_ids);
    GROWING(float, values);

    size_t input_points, passed; /* points of the input come first; those that the sweep has met */
    uint32_t free_node;
    int32_t min_level, max_level, base;
    int32_t threshold; /* above 0: only edges where the winding number passes it are kept */
    bool triangulate, trapezoid;
    bool trouble;                    /* rounding contradicted itself: the careful way is needed */
    bool unclosed;                   /* the segments do not close ... */
    struct planar_point unclosed_at; /* ... here */
};

/* Makes room for `more` elements; sets no_memory and returns false when there is none. */
#define ROOM(w, name, more)                                                                        \
    ((w)->name##_count + (more) <= (w)->name##_capacity ||                                         \
     workspace_grow(w, (void **)&(w)->name, &(w)->name##_capacity, (w)->name##_count, more,        \
                    sizeof(*(w)->name)))
bool workspace_grow(struct planar_workspace *w, void **array, size_t *capacity, size_t count,
                    size_t more, size_t size);

/* fill.c: triangles of a gap while the sweep goes on. edge: the gap's lower edge. */
void fill_start(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point);
void fill_split(struct planar_workspace *w, struct sweep_edge *below, struct sweep_edge *top,
                uint32_t point);
void fill_attach_top(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                     int32_t level);
void fill_attach_bottom(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                        int32_t level);
void fill_close(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point, int32_t level);
void fill_join(struct planar_workspace *w, struct sweep_edge *below, struct sweep_edge *top);

/* sort.c: ranks of the points in sweep order, equal ones sharing a rank; fills points, rank. */
bool sort_points(struct planar_workspace *w, const struct planar_point *points, size_t count);

#endif
