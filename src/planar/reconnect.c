/* planar/reconnect.c: iso-density lines (Boehl and Stuerzlinger, section 3.3.1, Figure 4).
 *
 * Where outlines cross, the rings i and i + 1 touch, and the point there has the mean of their
 * intensities, which bends the gradient of all triangles around it. The paper proposes to take the
 * point out and to connect what is left across:
 *
 *      a0    b1                 a0 -- b1     ring i + 1 below, ring i above (or the other way
 *        \  /                                round); the new lines cut the corners of two opposite
 *         X          ->                      faces, and the level between the two rings flows
 *        /  \                                through
 *      b0    a1                 b0 -- a1
 *
 * The paper joins the neighbouring points. Long edges (a box' shadow) would lose half a penumbra
 * that way, so the new lines begin at a share of the shorter edge from X; with share 1/2 and
 * crossings at both ends of an edge they meet in its middle. New lines may cross others: the result
 * is swept again, as the paper says, and the caller says how often. Linear.
 */
#include "planar/inside.h"

#include <math.h>

/* The edges at a point: up to four, and how many there are. */
struct star {
    uint32_t edges[4];
    uint32_t count;
};

struct corner {
    uint32_t in, out; /* edges along which a ring's boundary arrives and leaves */
};

static int32_t outer_ring(const struct planar_edge *e)
{
    return e->below < e->above ? e->below : e->above;
}

/* Weight of the boundary that runs along the edge into the point. */
static int32_t flow(const struct planar_edge *e, uint32_t point)
{
    int32_t w = e->below - e->above;
    return e->right == point ? w : -w;
}

/* Two rings, one inside the other, that touch here and do nothing else? */
static bool find_corners(const struct planar_result *r, const struct star *star, uint32_t point,
                         struct corner *out)
{
    if (star->count != 4)
        return false;
    int32_t outer = INT32_MAX, inner = INT32_MIN;
    for (int k = 0; k < 4; k++) {
        const struct planar_edge *e = &r->edges[star->edges[k]];
        int32_t ring = outer_ring(e);
        if (e->below + e->above - 2 * ring != 1)
            return false;
        outer = ring < outer ? ring : outer;
        inner = ring > inner ? ring : inner;
    }
    if (inner != outer + 1)
        return false;
    int found[2][2] = {{0}};
    for (int k = 0; k < 4; k++) {
        const struct planar_edge *e = &r->edges[star->edges[k]];
        int which = outer_ring(e) == inner;
        bool in = flow(e, point) > 0;
        *(in ? &out[which].in : &out[which].out) = star->edges[k];
        found[which][in]++;
    }
    return found[0][0] == 1 && found[0][1] == 1 && found[1][0] == 1 && found[1][1] == 1;
}

static double length(const struct planar_result *r, uint32_t edge)
{
    struct planar_point a = r->points[r->edges[edge].left], b = r->points[r->edges[edge].right];
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    return sqrt(dx * dx + dy * dy);
}

/* The point of the edge at a distance from one of its ends. */
static struct planar_point along(const struct planar_result *r, uint32_t edge, uint32_t from,
                                 double distance)
{
    const struct planar_edge *e = &r->edges[edge];
    struct planar_point a = r->points[from], b = r->points[e->left == from ? e->right : e->left];
    double t = distance / length(r, edge);
    return (struct planar_point){a.x + (int32_t)floor(t * ((double)b.x - a.x) + 0.5),
                                 a.y + (int32_t)floor(t * ((double)b.y - a.y) + 0.5)};
}

pnb_status planar_reconnect(struct planar_workspace *w, const struct planar_result *r, double share,
                            struct planar_input *out, size_t *out_count)
{
    pnb_context *context = w->context;
    size_t n = r->point_count, edges = r->edge_count;
    *out_count = 0;
    out->point_count = out->segment_count = 0;
    struct star *stars = memory_calloc(context, n, sizeof(*stars));
    /* The points that each edge begins and ends with now. */
    uint32_t *ends = memory_alloc(context, 2 * edges, sizeof(*ends));
    bool *parted = memory_alloc(context, n, sizeof(*parted));
    pnb_status status = stars && ends && parted
                            ? planar_input_reserve(context, out, n + 4 * n, edges + 2 * n)
                            : status_no_memory(context, n * sizeof(*stars));
    for (uint32_t i = 0; i < edges && !status; i++) {
        uint32_t at[2] = {r->edges[i].left, r->edges[i].right};
        for (int k = 0; k < 2; k++) {
            struct star *s = &stars[at[k]];
            if (s->count < 4)
                s->edges[s->count] = i;
            s->count++;
            ends[2 * (size_t)i + (size_t)k] = at[k];
        }
    }
    for (size_t i = 0; i < n && !status; i++)
        out->points[out->point_count++] = r->points[i];
    for (uint32_t i = 0; i < n && !status; i++) {
        struct corner c[2];
        parted[i] = find_corners(r, &stars[i], i, c);
    }
    for (uint32_t i = 0; i < n && !status; i++) {
        struct corner c[2];
        if (!parted[i] || !find_corners(r, &stars[i], i, c))
            continue;
        ++*out_count;
        for (int which = 0; which < 2; which++) {
            uint32_t pair[2] = {c[which].in, c[which].out}, p[2];
            for (int k = 0; k < 2; k++) {
                const struct planar_edge *e = &r->edges[pair[k]];
                uint32_t other = e->left == i ? e->right : e->left;
                double part = parted[other] ? fmin(share, 0.5) : share;
                p[k] = other;
                if (part < 1) {
                    p[k] = (uint32_t)out->point_count;
                    out->points[out->point_count++] =
                        along(r, pair[k], i, part * length(r, pair[k]));
                }
                ends[2 * (size_t)pair[k] + (e->right == i)] = p[k];
            }
            out->segments[out->segment_count++] =
                (struct planar_segment){p[0], p[1], flow(&r->edges[c[which].in], i)};
        }
    }
    for (size_t i = 0; i < edges && !status; i++)
        out->segments[out->segment_count++] = (struct planar_segment){
            ends[2 * i], ends[2 * i + 1], r->edges[i].below - r->edges[i].above};
    memory_free(context, stars);
    memory_free(context, ends);
    memory_free(context, parted);
    return status;
}
