/* planar/rings.c: boundaries of the regions by winding number.
 *
 * planar_outline() gives them as a bag of segments (enough for the next sweep), planar_rings() as
 * closed chains. Both are linear in the edges, apart from the points where a ring touches itself,
 * which sort their few edges by angle.
 */
#include "planar/inside.h"

/* The boundary of {winding >= threshold} along an edge: +1: left to right has the inside on its
 * right, -1: right to left, 0: none. */
static int direction(const struct planar_edge *e, int32_t threshold)
{
    return (e->below >= threshold) - (e->above >= threshold);
}

pnb_status planar_outline(struct planar_workspace *w, const struct planar_result *result,
                          int32_t threshold, struct planar_input *io_input)
{
    pnb_status status =
        planar_input_reserve(w->context, io_input, result->point_count, result->edge_count);
    if (status)
        return status;
    w->slots_count = 0;
    if (!ROOM(w, slots, result->point_count))
        return status_no_memory(w->context, result->point_count * sizeof(*w->slots));
    for (size_t i = 0; i < result->point_count; i++)
        w->slots[i] = PLANAR_NONE;
    for (size_t i = 0; i < result->edge_count; i++) {
        const struct planar_edge *e = &result->edges[i];
        int way = direction(e, threshold);
        if (way == 0)
            continue;
        uint32_t ends[2] = {e->left, e->right};
        for (int k = 0; k < 2; k++) {
            if (w->slots[ends[k]] == PLANAR_NONE) {
                w->slots[ends[k]] = (uint32_t)io_input->point_count;
                io_input->points[io_input->point_count++] = result->points[ends[k]];
            }
        }
        uint32_t l = w->slots[e->left], r = w->slots[e->right];
        io_input->segments[io_input->segment_count++] =
            (struct planar_segment){way > 0 ? l : r, way > 0 ? r : l, 1};
    }
    return PNB_OK;
}

void planar_chains_finish(pnb_context *context, struct planar_chains *chains)
{
    memory_free(context, chains->points);
    memory_free(context, chains->starts);
    *chains = (struct planar_chains){0};
}

/* Which half of the turn a direction lies in, counting clockwise from d: 0: less than half a turn
 * (or none), 1: half and more. */
static int half_turn(struct planar_point o, struct planar_point d, struct planar_point p)
{
    int64_t turn = planar_orient(o, d, p);
    if (turn != 0)
        return turn > 0;
    int64_t dot = (int64_t)(d.x - o.x) * (p.x - o.x) + (int64_t)(d.y - o.y) * (p.y - o.y);
    return dot < 0;
}

/* Turning clockwise about o from direction d: does p come before q? */
static bool clockwise_before(struct planar_point o, struct planar_point d, struct planar_point p,
                             struct planar_point q)
{
    int hp = half_turn(o, d, p), hq = half_turn(o, d, q);
    if (hp != hq)
        return hp < hq;
    return planar_orient(o, p, q) < 0;
}

pnb_status planar_rings(struct planar_workspace *w, const struct planar_result *result,
                        int32_t threshold, struct planar_chains *out_chains)
{
    *out_chains = (struct planar_chains){0};
    pnb_context *context = w->context;
    size_t n = result->point_count, ring_edges = 0, self_touching = 0;
    for (size_t i = 0; i < result->edge_count; i++)
        ring_edges += direction(&result->edges[i], threshold) != 0;
    /* Edges that leave each point, as lists. */
    struct leaving {
        uint32_t to, next;
        bool used;
    } *edges = memory_alloc(context, ring_edges, sizeof(*edges));
    uint32_t *first = memory_alloc(context, n, sizeof(*first));
    uint32_t *points = memory_alloc(context, ring_edges, sizeof(*points));
    uint32_t *starts = memory_alloc(context, ring_edges + 1, sizeof(*starts));
    if (!edges || !first || !points || !starts) {
        memory_free(context, edges);
        memory_free(context, first);
        memory_free(context, points);
        memory_free(context, starts);
        return status_no_memory(context, ring_edges * sizeof(*edges));
    }
    for (size_t i = 0; i < n; i++)
        first[i] = PLANAR_NONE;
    size_t count = 0;
    for (size_t i = 0; i < result->edge_count; i++) {
        const struct planar_edge *e = &result->edges[i];
        int way = direction(e, threshold);
        if (way == 0)
            continue;
        uint32_t from = way > 0 ? e->left : e->right, to = way > 0 ? e->right : e->left;
        edges[count] = (struct leaving){to, first[from], false};
        self_touching += first[from] != PLANAR_NONE;
        first[from] = (uint32_t)count++;
    }
    size_t used = 0, chains = 0;
    starts[0] = 0;
    for (size_t i = 0; i < n; i++) {
        for (uint32_t e = first[i]; e != PLANAR_NONE; e = edges[e].next) {
            if (edges[e].used)
                continue;
            uint32_t from = (uint32_t)i, at = e;
            for (;;) {
                points[used++] = from;
                edges[at].used = true;
                uint32_t to = edges[at].to, best = PLANAR_NONE;
                /* Through the inside, which lies to the right: the first edge that leaves when one
                 * turns from the way back counter-clockwise ... i.e. the last one clockwise. */
                for (uint32_t o = first[to]; o != PLANAR_NONE; o = edges[o].next)
                    if (best == PLANAR_NONE ||
                        clockwise_before(result->points[to], result->points[from],
                                         result->points[edges[best].to],
                                         result->points[edges[o].to]))
                        best = o;
                if (best == PLANAR_NONE || edges[best].used)
                    break;
                from = to;
                at = best;
            }
            starts[++chains] = (uint32_t)used;
        }
    }
    memory_free(context, edges);
    memory_free(context, first);
    *out_chains = (struct planar_chains){points, starts, chains};
    return PNB_OK;
}
