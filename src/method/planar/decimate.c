/* method/planar/decimate.c: fewer triangles from the samples that are known already.
 *
 * A vertex is taken out by drawing it onto a neighbour: of its n triangles n - 2 remain. The
 * patch's samples, and the vertex itself, say what the error would be; of the neighbours that keep
 * it below the limit the one with the least cost is taken. Easy ones go first: passes with a rising
 * limit. Vertices on a line along which the shadow jumps go only along that line, where it is
 * straight.
 *
 * The fit moves a vertex's value to where the squared errors around it are least: linear pieces
 * through a curve's points lie on one side of it, pieces that cut through it need half as many
 * vertices.
 */
#include <math.h>

#include "method/planar/refine.h"

#define STRAIGHT 2.0 /* grid units: how far from the line a vertex on it may lie */

/* The two neighbours of a vertex on a jump's line, as places in its star; false: not straight. */
static bool along_line(const struct tiling *m, const uint32_t *ring, const uint32_t *tiles,
                       const int *corners, int n, uint32_t v, int *ends)
{
    int count = 0;
    for (int i = 0; i < n; i++)
        if (m->tiles[tiles[i]].fixed >> corners[i] & 1) {
            if (count == 2)
                return false;
            ends[count++] = i;
        }
    if (count != 2)
        return false;
    struct planar_point a = m->vertices[ring[ends[0]]].p, b = m->vertices[ring[ends[1]]].p,
                        p = m->vertices[v].p;
    double dx = (double)b.x - a.x, dy = (double)b.y - a.y;
    return fabs((double)planar_orient(a, b, p)) <= STRAIGHT * sqrt(dx * dx + dy * dy) &&
           ((double)p.x - a.x) * dx + ((double)p.y - a.y) * dy > 0 &&
           ((double)b.x - p.x) * dx + ((double)b.y - p.y) * dy > 0;
}

static void fix_between(struct tiling *m, const uint32_t *tiles, int count, uint32_t a, uint32_t b)
{
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            struct tiling_tile *t = &m->tiles[tiles[i]];
            uint32_t p = t->v[k], q = t->v[(k + 1) % 3];
            if ((p != a || q != b) && (p != b || q != a))
                continue;
            t->fixed |= (uint8_t)(1 << k);
            /* Where the vertex lay beside the line, the side is one of the patch's outline. */
            if (t->near[k] != PLANAR_NONE)
                m->tiles[t->near[k] / 3].fixed |= (uint8_t)(1 << t->near[k] % 3);
        }
}

/* What a plan makes of a point that it holds. */
static double plan_at(const struct tiling *m, const struct tiling_plan *p, struct planar_point q)
{
    struct planar_point c[3];
    double value = 0, w[3];
    for (int k = 0; k < 3; k++)
        c[k] = m->vertices[p->v[k]].p;
    for (int k = 0; k < 3; k++) {
        w[k] = (double)planar_orient(c[(k + 1) % 3], c[(k + 2) % 3], q);
        if (w[k] < 0)
            return NAN;
        value += w[k] * m->vertices[p->v[k]].value;
    }
    return value / (w[0] + w[1] + w[2]);
}

/* The patch's triangles when v is drawn onto the j-th of its ring; their number, 0: it cannot be.
 */
static int draw_onto(const struct tiling *m, const uint32_t *ring, const uint32_t *tiles, int n,
                     int j, double thinnest, struct tiling_plan *plans)
{
    int count = 0;
    for (int i = 0; i < n; i++) {
        if (i == j || (i + 1) % n == j)
            continue;
        struct tiling_plan *p = &plans[count++];
        *p = (struct tiling_plan){
            {ring[j], ring[i], ring[(i + 1) % n]}, m->tiles[tiles[i]].inside, {0}, 0, 0};
        if (planar_orient(m->vertices[p->v[0]].p, m->vertices[p->v[1]].p, m->vertices[p->v[2]].p) <=
            0)
            return 0;
        double height = tiling_height2(m, p->v);
        if (height < m->thin2 && height < thinnest)
            return 0;
    }
    return count;
}

/* Takes v out if that is possible with no error above `limit`. Notes in v->need the least error
 * with which it could go (above `most`: just that). */
static bool remove_vertex(struct tiling *m, uint32_t v, double limit, double most)
{
    uint32_t tiles[TILING_STAR_MAX], ring[TILING_STAR_MAX];
    int corners[TILING_STAR_MAX], n = tiling_star(m, v, tiles, corners), ends[2] = {-1, -1};
    struct tiling_vertex *vertex = &m->vertices[v];
    bool changed = false;
    double thinnest = INFINITY;
    for (int i = 0; i < n; i++) {
        const struct tiling_tile *t = &m->tiles[tiles[i]];
        ring[i] = t->v[(corners[i] + 1) % 3];
        changed |= !(t->seen >> corners[i] & 1);
        thinnest = fmin(thinnest, tiling_height2(m, t->v));
    }
    if (n < 3 || (!changed && vertex->need > limit))
        return false;
    for (int i = 0; i < n; i++)
        m->tiles[tiles[i]].seen |= (uint8_t)(1 << corners[i]);
    vertex->need = INFINITY;
    if (vertex->jump && !along_line(m, ring, tiles, corners, n, v, ends))
        return false;
    bool sample = !vertex->jump && !m->tiles[tiles[0]].inside;
    bool gathered = false;
    uint32_t own = PLANAR_NONE;
    struct tiling_plan plans[TILING_STAR_MAX], best[TILING_STAR_MAX];
    double best_cost = INFINITY;
    for (int j = 0; j < n && !m->no_memory; j++) {
        if (vertex->jump && j != ends[0] && j != ends[1])
            continue;
        int count = draw_onto(m, ring, tiles, n, j, thinnest, plans);
        if (count == 0)
            continue;
        /* The vertex itself is where it mostly fails. */
        bool good = true, jumps = m->vertices[ring[j]].jump;
        for (int i = 0; i < n; i++)
            jumps |= m->vertices[ring[i]].jump;
        for (int i = 0; i < count && sample && !jumps; i++) {
            double value = plan_at(m, &plans[i], vertex->p);
            if (!isnan(value)) {
                good = fabs(value - vertex->truth) <= most;
                break;
            }
        }
        if (!good)
            continue;
        if (!gathered) {
            if (sample) {
                tiling_add_sample(m, vertex->p, vertex->truth, tiles[0]);
                own = m->tiles[tiles[0]].first;
            }
            tiling_gather(m, tiles, n);
            gathered = true;
        }
        tiling_plan(m, plans, count);
        double cost = 0, worst = 0;
        for (int i = 0; i < count; i++) {
            cost += plans[i].cost;
            worst = fmax(worst, plans[i].error);
        }
        vertex->need = (float)fmin(vertex->need, worst);
        if (worst <= limit && cost < best_cost) {
            best_cost = cost;
            for (int i = 0; i < count; i++)
                best[i] = plans[i];
        }
    }
    if (best_cost == INFINITY || m->no_memory) {
        if (own != PLANAR_NONE)
            tiling_drop_sample(m, tiles[0], own);
        return false;
    }
    /* The samples were dealt out to the last plans tried. */
    tiling_plan(m, best, n - 2);
    tiling_replace(m, tiles, n, best, n - 2);
    if (vertex->jump)
        fix_between(m, tiles, n - 2, ring[ends[0]], ring[ends[1]]);
    tiling_forget_vertex(m, v);
    for (int i = 0; i < n - 2; i++)
        tiling_push_tile(m, tiles[i]);
    return true;
}

size_t tiling_decimate(struct tiling *m, double limit)
{
    static const double shares[] = {0.25, 0.5, 0.75, 1, 1};
    size_t removed = 0;
    for (size_t pass = 0; pass < sizeof(shares) / sizeof(shares[0]); pass++)
        for (uint32_t v = 0; v < m->vertex_count && !m->no_memory; v++)
            if (!m->vertices[v].border && m->vertices[v].tile != PLANAR_NONE &&
                remove_vertex(m, v, shares[pass] * limit, limit)) {
                removed++;
                tiling_exchange(m);
            }
    return removed;
}

void tiling_fit(struct tiling *m, double limit)
{
    for (uint32_t v = 0; v < m->vertex_count; v++) {
        struct tiling_vertex *vertex = &m->vertices[v];
        if (vertex->tile == PLANAR_NONE || vertex->jump || vertex->border ||
            !(vertex->truth > 0.001f && vertex->truth < 0.999f))
            continue;
        uint32_t tiles[TILING_STAR_MAX];
        int corners[TILING_STAR_MAX], n = tiling_star(m, v, tiles, corners);
        double off = 0, weight = 0, worst = 0, cost = 0;
        for (int i = 0; i < n; i++) {
            const struct tiling_tile *t = &m->tiles[tiles[i]];
            struct planar_point a = vertex->p, b = m->vertices[t->v[(corners[i] + 1) % 3]].p,
                                c = m->vertices[t->v[(corners[i] + 2) % 3]].p;
            double area = (double)planar_orient(a, b, c);
            worst = fmax(worst, t->error);
            cost += t->cost;
            for (uint32_t s = t->first; s != PLANAR_NONE; s = m->samples[s].next) {
                struct planar_point p = m->samples[s].p;
                double wb = (double)planar_orient(a, p, c) / area,
                       wc = (double)planar_orient(a, b, p) / area, wa = 1 - wb - wc;
                double e = wa * t->value[corners[i]] + wb * t->value[(corners[i] + 1) % 3] +
                           wc * t->value[(corners[i] + 2) % 3] - m->samples[s].truth;
                off += wa * e;
                weight += wa * wa;
            }
        }
        off += vertex->value - vertex->truth;
        weight += 1;
        worst = fmax(worst, fabs(vertex->value - vertex->truth));
        float old = vertex->value;
        double wanted = fmin(1, fmax(0, vertex->value - off / weight));
        if (n == 0 || fabs(wanted - vertex->truth) > limit)
            continue;
        vertex->value = (float)wanted;
        double worst_now = fabs(wanted - vertex->truth), cost_now = 0;
        for (int i = 0; i < n; i++) {
            tiling_measure(m, tiles[i]);
            worst_now = fmax(worst_now, m->tiles[tiles[i]].error);
            cost_now += m->tiles[tiles[i]].cost;
        }
        if (cost_now > cost || worst_now > fmax(worst, limit)) {
            vertex->value = old;
            for (int i = 0; i < n; i++)
                tiling_measure(m, tiles[i]);
        }
    }
}
