/* planar/fill.c: triangles of a face while the sweep passes over it (Hertel and Mehlhorn's
 * sweep-line triangulation).
 *
 * The gap between two neighbours of the status keeps the chain of those points to its left that
 * are not yet surrounded by triangles, from the lower edge's last point to the upper edge's:
 *
 *        upper edge ----o            A new point v on the lower or upper edge, or in between, takes
 *                      /             every chain point that it sees from the right: the chain seen
 *        (filled)     o              from v always consists of two convex parts that meet at the
 *                      \             point that came last, so seeing is one orientation test each
 *                       o  <- last   and the work per point is constant over the sweep.
 *                      /
 *        lower edge --o
 *
 * No triangle without area arises: three points in a line are left for a later point. What remains
 * when a gap closes can only be the chain's two ends; anything else means that rounding has turned
 * an edge over an old point, and the sweep is done again the careful way.
 *
 * Every link of a chain knows the half-edge behind it, so the triangles come out with neighbours.
 */
#include "planar/inside.h"

#define LINK_DIAGONAL 0x80000000u

static uint32_t new_node(struct planar_workspace *w, uint32_t point)
{
    uint32_t n = w->free_node;
    if (n != PLANAR_NONE) {
        w->free_node = w->nodes[n].up;
    } else {
        if (!ROOM(w, nodes, 1))
            return 0;
        n = (uint32_t)w->nodes_count++;
    }
    w->nodes[n] = (struct chain_node){point, PLANAR_NONE, PLANAR_NONE, PLANAR_NONE};
    return n;
}

static void free_node(struct planar_workspace *w, uint32_t n)
{
    w->nodes[n].up = w->free_node;
    w->free_node = n;
}

/* Tells the two sides of a link of each other. */
static void connect(struct planar_workspace *w, uint32_t owner, uint32_t half)
{
    struct planar_triangle *t = w->triangles;
    if (owner == PLANAR_NONE)
        return;
    if (owner & LINK_DIAGONAL) {
        struct diagonal *d = &w->diagonals[(owner & ~LINK_DIAGONAL) >> 1];
        uint32_t side = owner & 1;
        d->half[side] = half;
        if (d->half[!side] == PLANAR_NONE)
            return;
        owner = d->half[!side];
    }
    t[owner / 3].near[owner % 3] = half;
    t[half / 3].near[half % 3] = owner;
}

/* Triangle (a, v, b) with v on the right; lower, upper: the owners behind (a, v) or (v, b), and
 * behind (b, a). Returns its number. */
static uint32_t emit(struct planar_workspace *w, uint32_t a, uint32_t v, uint32_t b, int32_t level)
{
    if (!ROOM(w, triangles, 1))
        return 0;
    w->triangles[w->triangles_count] =
        (struct planar_triangle){{a, v, b}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, level};
    return (uint32_t)w->triangles_count++;
}

void fill_start(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point)
{
    edge->low = edge->high = edge->last = new_node(w, point);
}

/* The point is on the gap's upper edge, or becomes the upper end of its lower part; owner: what
 * lies behind the link between the chain's end and the point. */
static void attach_top(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                       int32_t level, uint32_t owner)
{
    struct planar_point v = w->points[point];
    uint32_t top = edge->high;
    while (top != edge->low) {
        uint32_t below = w->nodes[top].down;
        uint32_t a = w->nodes[below].point, b = w->nodes[top].point;
        if (planar_orient(w->points[a], v, w->points[b]) <= 0)
            break;
        uint32_t t = emit(w, a, point, b, level);
        if (w->no_memory)
            return;
        connect(w, owner, 3 * t + 1);                 /* v -> b */
        connect(w, w->nodes[below].owner, 3 * t + 2); /* b -> a */
        owner = 3 * t;                                /* a -> v */
        free_node(w, top);
        top = below;
    }
    uint32_t n = new_node(w, point);
    if (w->no_memory)
        return;
    w->nodes[n].down = top;
    w->nodes[top].up = n;
    w->nodes[top].owner = owner;
    edge->high = edge->last = n;
}

static void attach_bottom(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                          int32_t level, uint32_t owner)
{
    struct planar_point v = w->points[point];
    uint32_t bottom = edge->low;
    while (bottom != edge->high) {
        uint32_t above = w->nodes[bottom].up;
        uint32_t a = w->nodes[bottom].point, b = w->nodes[above].point;
        if (planar_orient(w->points[a], v, w->points[b]) <= 0)
            break;
        uint32_t t = emit(w, a, point, b, level);
        if (w->no_memory)
            return;
        connect(w, owner, 3 * t);                      /* a -> v */
        connect(w, w->nodes[bottom].owner, 3 * t + 2); /* b -> a */
        owner = 3 * t + 1;                             /* v -> b */
        free_node(w, bottom);
        bottom = above;
    }
    uint32_t n = new_node(w, point);
    if (w->no_memory)
        return;
    w->nodes[n].up = bottom;
    w->nodes[n].owner = owner;
    w->nodes[bottom].down = n;
    edge->low = edge->last = n;
}

void fill_attach_top(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                     int32_t level)
{
    attach_top(w, edge, point, level, PLANAR_NONE);
}

void fill_attach_bottom(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point,
                        int32_t level)
{
    attach_bottom(w, edge, point, level, PLANAR_NONE);
}

/* Both edges of the gap end at the point. */
void fill_close(struct planar_workspace *w, struct sweep_edge *edge, uint32_t point, int32_t level)
{
    struct planar_point v = w->points[point];
    uint32_t top = edge->high, owner = PLANAR_NONE;
    while (top != edge->low) {
        uint32_t below = w->nodes[top].down;
        uint32_t a = w->nodes[below].point, b = w->nodes[top].point;
        if (planar_orient(w->points[a], v, w->points[b]) <= 0) {
            w->trouble = true;
            return;
        }
        uint32_t t = emit(w, a, point, b, level);
        if (w->no_memory)
            return;
        connect(w, owner, 3 * t + 1);
        connect(w, w->nodes[below].owner, 3 * t + 2);
        owner = 3 * t;
        free_node(w, top);
        top = below;
    }
    free_node(w, top);
}

/* A point inside the gap above `below`, from which edges start; `top` is the highest of them. The
 * point is joined to the gap's last point, which nothing hides. */
void fill_split(struct planar_workspace *w, struct sweep_edge *below, struct sweep_edge *top,
                uint32_t point)
{
    int32_t level = below->below + below->delta;
    if (!ROOM(w, diagonals, 1))
        return;
    uint32_t link = LINK_DIAGONAL | (uint32_t)w->diagonals_count << 1;
    w->diagonals[w->diagonals_count++] = (struct diagonal){{PLANAR_NONE, PLANAR_NONE}};
    /* The last point becomes the end of both parts. */
    uint32_t last = below->last;
    uint32_t copy = new_node(w, w->nodes[last].point);
    if (w->no_memory)
        return;
    w->nodes[copy].up = w->nodes[last].up;
    w->nodes[copy].owner = w->nodes[last].owner;
    if (last == below->high) {
        top->high = copy;
    } else {
        w->nodes[w->nodes[copy].up].down = copy;
        top->high = below->high;
    }
    top->low = top->last = copy;
    below->high = last;
    attach_top(w, below, point, level, link);
    if (!w->no_memory)
        attach_bottom(w, top, point, level, link | 1);
}

/* All edges at a point have ended: the gaps below and above them, both attached to it, are one. */
void fill_join(struct planar_workspace *w, struct sweep_edge *below, struct sweep_edge *top)
{
    uint32_t a = below->high, b = top->low;
    if (b == top->high) {
        below->last = a;
        free_node(w, b);
        return;
    }
    w->nodes[a].up = w->nodes[b].up;
    w->nodes[a].owner = w->nodes[b].owner;
    w->nodes[w->nodes[a].up].down = a;
    below->high = top->high;
    below->last = a;
    free_node(w, b);
}
