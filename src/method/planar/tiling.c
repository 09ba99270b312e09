/* method/planar/tiling.c: a triangulation that carries samples of the shadow.
 *
 * Every triangle keeps a list of the places in it where the exact shadow is known. All changes
 * (a vertex put in, a diagonal exchanged, a vertex taken out) replace a patch of triangles by
 * another one of the same outline; the patch's samples are dealt out to the new triangles, so that
 * what a change does to the error is known before it is made, without asking for visibility again.
 *
 * Diagonals are exchanged while that lowers the sum of
 *     cost = (sum of squared errors) / tolerance^2 + SHAPE x (how far from equilateral)
 * so triangles grow long along the shadow's edges, where the shadow hardly changes, and are plump
 * where it does not matter.
 *
 * Corners on a line along which the shadow jumps have a value per triangle, the one that fits its
 * samples best. Fixed sides are never exchanged. Coordinates are on the grid of planar/,
 * orientation is exact: the mesh stays a tiling.
 */
#include <math.h>

#include "method/planar/refine.h"

#define SHAPE 0.02 /* cost of an equilateral triangle; in proportion to perimeter^2 / area */

void tiling_finish(struct tiling *m)
{
    void *blocks[] = {m->vertices,     m->tiles,         m->samples, m->free_tiles,
                      m->free_samples, m->free_vertices, m->stack,   m->gathered};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(m->context, blocks[i]);
    *m = (struct tiling){.context = m->context};
}

static bool room(struct tiling *m)
{
    m->no_memory = m->no_memory ||
                   !memory_reserve(m->context, (void **)&m->vertices, &m->vertex_capacity,
                                   m->vertex_count, 4, sizeof(*m->vertices)) ||
                   !memory_reserve(m->context, (void **)&m->tiles, &m->tile_capacity, m->tile_count,
                                   TILING_STAR_MAX, sizeof(*m->tiles));
    return !m->no_memory;
}

static void push(struct tiling *m, uint32_t half)
{
    if (!memory_reserve(m->context, (void **)&m->stack, &m->stack_capacity, m->stack_count, 1,
                        sizeof(*m->stack)))
        m->no_memory = true;
    else
        m->stack[m->stack_count++] = half;
}

void tiling_push_tile(struct tiling *m, uint32_t t)
{
    for (uint32_t k = 0; k < 3; k++)
        push(m, 3 * t + k);
}

static double distance2(struct planar_point a, struct planar_point b)
{
    double dx = (double)a.x - b.x, dy = (double)a.y - b.y;
    return dx * dx + dy * dy;
}

double tiling_height2(const struct tiling *m, const uint32_t *v)
{
    struct planar_point a = m->vertices[v[0]].p, b = m->vertices[v[1]].p, c = m->vertices[v[2]].p;
    double area = (double)planar_orient(a, b, c);
    double longest = fmax(distance2(a, b), fmax(distance2(b, c), distance2(c, a)));
    return area <= 0 ? 0 : area * area / longest;
}

void tiling_gather(struct tiling *m, const uint32_t *tiles, int count)
{
    m->gathered_count = 0;
    for (int i = 0; i < count; i++) {
        const struct tiling_tile *t = &m->tiles[tiles[i]];
        if (!memory_reserve(m->context, (void **)&m->gathered, &m->gathered_capacity,
                            m->gathered_count, t->count + 1, sizeof(*m->gathered))) {
            m->no_memory = true;
            return;
        }
        for (uint32_t s = t->first; s != PLANAR_NONE; s = m->samples[s].next) {
            const struct tiling_sample *sample = &m->samples[s];
            m->gathered[m->gathered_count++] =
                (struct tiling_gathered){sample->p.x, sample->p.y, sample->truth, s, (uint32_t)i};
        }
    }
}

/* Solves the n x n system a x = b in place, a being symmetric and positive. */
static void solve(double a[3][3], double *b, int n)
{
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++) {
            double f = a[j][i] / a[i][i];
            for (int k = i; k < n; k++)
                a[j][k] -= f * a[i][k];
            b[j] -= f * b[i];
        }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
}

/* Values for corners that jump: least squares, with a little weight on the samples' mean. */
static void fit_corners(const struct tiling *m, struct tiling_plan *p, uint32_t index,
                        const bool *free, const double *x0, const double *gx, const double *gy,
                        const double *base)
{
    double a[3][3] = {{0}}, b[3] = {0}, mean = 0;
    int slot[3], n = 0, count = 0;
    for (int k = 0; k < 3; k++)
        slot[k] = free[k] ? n++ : -1;
    for (size_t i = 0; i < m->gathered_count; i++) {
        const struct tiling_gathered *g = &m->gathered[i];
        if (g->plan != index)
            continue;
        double w[3], rest = g->truth;
        for (int k = 0; k < 3; k++) {
            w[k] = base[k] + gx[k] * (g->x - x0[0]) + gy[k] * (g->y - x0[1]);
            if (!free[k])
                rest -= w[k] * p->value[k];
        }
        for (int k = 0; k < 3; k++)
            for (int l = 0; l < 3 && free[k]; l++)
                if (free[l])
                    a[slot[k]][slot[l]] += w[k] * w[l];
        for (int k = 0; k < 3; k++)
            if (free[k])
                b[slot[k]] += w[k] * rest;
        mean += g->truth;
        count++;
    }
    for (int k = 0; k < 3 && count == 0; k++)
        if (!free[k]) {
            mean += p->value[k];
            count++;
        }
    mean = count > 0 ? mean / count : 0;
    for (int k = 0; k < n; k++) {
        a[k][k] += 0.01;
        b[k] += 0.01 * mean;
    }
    solve(a, b, n);
    for (int k = 0; k < 3; k++)
        if (free[k])
            p->value[k] = (float)fmin(1, fmax(0, b[slot[k]]));
}

/* Measures a plan against the gathered samples that it was dealt. */
static void measure(const struct tiling *m, struct tiling_plan *p, uint32_t index)
{
    struct planar_point c[3];
    bool free[3], any = false;
    for (int k = 0; k < 3; k++) {
        const struct tiling_vertex *v = &m->vertices[p->v[k]];
        c[k] = v->p;
        free[k] = v->jump && !p->inside;
        any |= free[k];
        p->value[k] = p->inside ? 1 : free[k] ? 0 : v->value;
    }
    double area = (double)planar_orient(c[0], c[1], c[2]);
    double around = distance2(c[0], c[1]) + distance2(c[1], c[2]) + distance2(c[2], c[0]);
    p->error = 0;
    p->cost = SHAPE * around / (2 * sqrt(3) * area);
    if (p->inside)
        return;
    /* Weight of corner k at (x, y): base + gx (x - x0) + gy (y - y0). */
    double x0[2] = {c[0].x, c[0].y}, gx[3], gy[3], base[3] = {1, 0, 0};
    for (int k = 0; k < 3; k++) {
        struct planar_point q = c[(k + 1) % 3], r = c[(k + 2) % 3];
        gx[k] = -((double)r.y - q.y) / area;
        gy[k] = ((double)r.x - q.x) / area;
    }
    if (any)
        fit_corners(m, p, index, free, x0, gx, gy, base);
    double fx = 0, fy = 0, f0 = p->value[0], sum = 0, worst = 0;
    for (int k = 0; k < 3; k++) {
        fx += gx[k] * p->value[k];
        fy += gy[k] * p->value[k];
    }
    for (size_t i = 0; i < m->gathered_count; i++) {
        const struct tiling_gathered *g = &m->gathered[i];
        if (g->plan != index)
            continue;
        double e = f0 + fx * (g->x - x0[0]) + fy * (g->y - x0[1]) - g->truth;
        sum += e * e;
        worst = fmax(worst, fabs(e));
    }
    p->error = (float)worst;
    p->cost += sum / (m->tolerance * m->tolerance);
}

static bool holds(const struct tiling *m, const uint32_t *v, struct planar_point p)
{
    for (int k = 0; k < 3; k++)
        if (planar_orient(m->vertices[v[k]].p, m->vertices[v[(k + 1) % 3]].p, p) < 0)
            return false;
    return true;
}

void tiling_plan(struct tiling *m, struct tiling_plan *plans, int count)
{
    for (size_t i = 0; i < m->gathered_count; i++) {
        struct tiling_gathered *g = &m->gathered[i];
        struct planar_point p = {(int32_t)g->x, (int32_t)g->y};
        g->plan = 0;
        for (int k = 0; k < count; k++)
            if (holds(m, plans[k].v, p)) {
                g->plan = (uint32_t)k;
                break;
            }
    }
    for (int k = 0; k < count; k++)
        measure(m, &plans[k], (uint32_t)k);
}

void tiling_measure(struct tiling *m, uint32_t t)
{
    struct tiling_tile *tile = &m->tiles[t];
    struct tiling_plan p = {{tile->v[0], tile->v[1], tile->v[2]}, tile->inside, {0}, 0, 0};
    tiling_gather(m, &t, 1);
    if (m->no_memory)
        return;
    measure(m, &p, 0);
    for (int k = 0; k < 3; k++)
        tile->value[k] = p.value[k];
    tile->error = p.error;
    tile->cost = (float)p.cost;
    tile->seen = 0;
}

void tiling_replace(struct tiling *m, const uint32_t *old, int old_count,
                    const struct tiling_plan *plans, int plan_count)
{
    struct {
        uint32_t a, b, near;
        bool fixed;
    } rim[TILING_STAR_MAX + 2];
    int rim_count = 0;
    uint32_t ids[TILING_STAR_MAX];
    if (!room(m))
        return;
    /* The patch's outline. */
    for (int i = 0; i < old_count; i++) {
        const struct tiling_tile *t = &m->tiles[old[i]];
        for (int k = 0; k < 3; k++) {
            bool inner = false;
            for (int j = 0; j < old_count && t->near[k] != PLANAR_NONE; j++)
                inner |= t->near[k] / 3 == old[j];
            if (inner)
                continue;
            rim[rim_count].a = t->v[k];
            rim[rim_count].b = t->v[(k + 1) % 3];
            rim[rim_count].near = t->near[k];
            rim[rim_count++].fixed = t->fixed >> k & 1;
        }
    }
    for (int i = 0; i < plan_count; i++)
        ids[i] = i < old_count            ? old[i]
                 : m->free_tile_count > 0 ? m->free_tiles[--m->free_tile_count]
                                          : (uint32_t)m->tile_count++;
    for (int i = plan_count; i < old_count; i++) {
        m->tiles[old[i]].v[0] = PLANAR_NONE;
        m->tiles[old[i]].first = PLANAR_NONE;
        m->tiles[old[i]].count = 0;
        if (!memory_reserve(m->context, (void **)&m->free_tiles, &m->free_tile_capacity,
                            m->free_tile_count, 1, sizeof(*m->free_tiles)))
            m->no_memory = true;
        else
            m->free_tiles[m->free_tile_count++] = old[i];
    }
    for (int i = 0; i < plan_count; i++) {
        const struct tiling_plan *p = &plans[i];
        struct tiling_tile *t = &m->tiles[ids[i]];
        *t = (struct tiling_tile){.near = {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE},
                                  .first = PLANAR_NONE,
                                  .error = p->error,
                                  .cost = (float)p->cost,
                                  .inside = p->inside,
                                  .stale = true};
        for (int k = 0; k < 3; k++) {
            t->v[k] = p->v[k];
            t->value[k] = p->value[k];
            m->vertices[p->v[k]].tile = ids[i];
        }
    }
    /* Sides: with the outline, or with one another. */
    for (int i = 0; i < plan_count; i++) {
        struct tiling_tile *t = &m->tiles[ids[i]];
        for (int k = 0; k < 3; k++) {
            uint32_t a = t->v[k], b = t->v[(k + 1) % 3], half = 3 * ids[i] + (uint32_t)k;
            bool done = false;
            for (int j = 0; j < rim_count && !done; j++) {
                if (rim[j].a != a || rim[j].b != b)
                    continue;
                t->near[k] = rim[j].near;
                if (rim[j].near != PLANAR_NONE)
                    m->tiles[rim[j].near / 3].near[rim[j].near % 3] = half;
                t->fixed |= (uint8_t)(rim[j].fixed << k);
                done = true;
            }
            for (int j = 0; j < plan_count && !done; j++)
                for (uint32_t l = 0; l < 3 && !done; l++)
                    if (plans[j].v[l] == b && plans[j].v[(l + 1) % 3] == a) {
                        t->near[k] = 3 * ids[j] + l;
                        done = true;
                    }
        }
    }
    for (size_t i = 0; i < m->gathered_count; i++) {
        const struct tiling_gathered *g = &m->gathered[i];
        struct tiling_tile *t = &m->tiles[ids[g->plan]];
        m->samples[g->sample].next = t->first;
        t->first = g->sample;
        t->count++;
    }
}

static bool exchange(struct tiling *m, uint32_t half)
{
    uint32_t i = half / 3, k = half % 3;
    const struct tiling_tile *t = &m->tiles[i];
    if (t->v[0] == PLANAR_NONE || t->near[k] == PLANAR_NONE || (t->fixed >> k & 1))
        return false;
    uint32_t j = t->near[k] / 3, l = t->near[k] % 3;
    const struct tiling_tile *u = &m->tiles[j];
    uint32_t a = t->v[k], b = t->v[(k + 1) % 3], c = t->v[(k + 2) % 3], d = u->v[(l + 2) % 3];
    struct tiling_plan plans[2] = {{{a, d, c}, t->inside, {0}, 0, 0},
                                   {{d, b, c}, t->inside, {0}, 0, 0}};
    struct planar_point pd = m->vertices[d].p, pc = m->vertices[c].p;
    if (planar_orient(pd, pc, m->vertices[a].p) <= 0 ||
        planar_orient(pc, pd, m->vertices[b].p) <= 0)
        return false;
    double thin = fmin(tiling_height2(m, plans[0].v), tiling_height2(m, plans[1].v));
    if (thin < m->thin2 && thin < tiling_height2(m, t->v) && thin < tiling_height2(m, u->v))
        return false;
    uint32_t pair[2] = {i, j};
    tiling_gather(m, pair, 2);
    if (m->no_memory)
        return false;
    for (size_t n = 0; n < m->gathered_count; n++) {
        struct tiling_gathered *g = &m->gathered[n];
        struct planar_point p = {(int32_t)g->x, (int32_t)g->y};
        g->plan = planar_orient(pd, pc, p) < 0;
    }
    double before = (double)t->cost + u->cost;
    measure(m, &plans[0], 0);
    if (plans[0].cost >= before)
        return false;
    measure(m, &plans[1], 1);
    if (plans[0].cost + plans[1].cost >= before * (1 - 1e-4))
        return false;
    tiling_replace(m, pair, 2, plans, 2);
    tiling_push_tile(m, i);
    tiling_push_tile(m, j);
    return true;
}

void tiling_exchange(struct tiling *m)
{
    while (m->stack_count > 0 && !m->no_memory)
        exchange(m, m->stack[--m->stack_count]);
}

uint32_t tiling_find(const struct tiling *m, struct planar_point p, uint32_t from)
{
    uint32_t t = from;
    for (size_t i = 0; i < m->tile_count && (t >= m->tile_count || m->tiles[t].v[0] == PLANAR_NONE);
         i++)
        t = (uint32_t)i;
    for (size_t steps = 0; steps < 4 * m->tile_count + 16; steps++) {
        int leave = 3;
        for (int i = 0; i < 3; i++) {
            int k = (i + (int)(steps % 3)) % 3; /* no fixed order, or a walk could go in circles */
            const struct tiling_tile *x = &m->tiles[t];
            if (planar_orient(m->vertices[x->v[k]].p, m->vertices[x->v[(k + 1) % 3]].p, p) < 0) {
                leave = k;
                break;
            }
        }
        if (leave == 3)
            return t;
        uint32_t next = m->tiles[t].near[leave];
        if (next == PLANAR_NONE)
            return PLANAR_NONE;
        t = next / 3;
    }
    return PLANAR_NONE;
}

static uint32_t add_vertex(struct tiling *m, struct planar_point p, float truth)
{
    if (!room(m))
        return PLANAR_NONE;
    uint32_t v = m->free_vertex_count > 0 ? m->free_vertices[--m->free_vertex_count]
                                          : (uint32_t)m->vertex_count++;
    m->vertices[v] =
        (struct tiling_vertex){.p = p, .truth = truth, .value = truth, .tile = PLANAR_NONE};
    return v;
}

void tiling_forget_vertex(struct tiling *m, uint32_t v)
{
    m->vertices[v].tile = PLANAR_NONE;
    if (!memory_reserve(m->context, (void **)&m->free_vertices, &m->free_vertex_capacity,
                        m->free_vertex_count, 1, sizeof(*m->free_vertices)))
        m->no_memory = true;
    else
        m->free_vertices[m->free_vertex_count++] = v;
}

uint32_t tiling_split_side(struct tiling *m, struct planar_point p, float truth, uint32_t i, int k)
{
    struct tiling_tile *t = &m->tiles[i];
    uint32_t a = t->v[k], b = t->v[(k + 1) % 3], c = t->v[(k + 2) % 3], other = t->near[k];
    uint32_t d = other == PLANAR_NONE ? PLANAR_NONE : m->tiles[other / 3].v[(other % 3 + 2) % 3];
    bool fixed = t->fixed >> k & 1, inside = t->inside;
    bool beyond = d != PLANAR_NONE && m->tiles[other / 3].inside;
    struct planar_point pa = m->vertices[a].p, pb = m->vertices[b].p, pc = m->vertices[c].p;
    if (planar_same(p, pa) || planar_same(p, pb))
        return planar_same(p, pa) ? a : b;
    /* Rounding may have put p beside the side. */
    if (planar_orient(pa, p, pc) <= 0 || planar_orient(p, pb, pc) <= 0)
        return PLANAR_NONE;
    if (d != PLANAR_NONE && (planar_orient(p, pa, m->vertices[d].p) <= 0 ||
                             planar_orient(pb, p, m->vertices[d].p) <= 0))
        return PLANAR_NONE;
    if (d == PLANAR_NONE && planar_orient(pa, pb, p) != 0)
        return PLANAR_NONE;
    uint32_t n = add_vertex(m, p, truth), patch[2] = {i, other / 3};
    if (n == PLANAR_NONE)
        return n;
    m->vertices[n].jump = fixed;
    m->vertices[n].border = d == PLANAR_NONE;
    struct tiling_plan plans[4] = {{{c, a, n}, inside, {0}, 0, 0},
                                   {{b, c, n}, inside, {0}, 0, 0},
                                   {{a, d, n}, beyond, {0}, 0, 0},
                                   {{d, b, n}, beyond, {0}, 0, 0}};
    int olds = d == PLANAR_NONE ? 1 : 2;
    tiling_gather(m, patch, olds);
    if (m->no_memory)
        return PLANAR_NONE;
    tiling_plan(m, plans, 2 * olds);
    tiling_replace(m, patch, olds, plans, 2 * olds);
    /* The halves of the side are what it was. */
    uint32_t tiles[TILING_STAR_MAX] = {m->vertices[n].tile};
    for (int step = 0; step < 2 * olds; step++) {
        struct tiling_tile *u = &m->tiles[tiles[0]];
        uint32_t next = PLANAR_NONE;
        for (int s = 0; s < 3; s++) {
            uint32_t v = u->v[s], w = u->v[(s + 1) % 3];
            if (fixed && ((v == n && (w == a || w == b)) || (w == n && (v == a || v == b))))
                u->fixed |= (uint8_t)(1 << s);
            if (v == n)
                next = u->near[(s + 2) % 3];
        }
        tiling_push_tile(m, tiles[0]);
        if (next == PLANAR_NONE) {
            /* On the border: the other triangle lies the other way round. */
            for (int s = 0; s < 3; s++)
                if (u->v[s] == n)
                    next = u->near[s];
            if (next == PLANAR_NONE)
                break;
        }
        tiles[0] = next / 3;
    }
    return n;
}

uint32_t tiling_insert(struct tiling *m, struct planar_point p, float truth, uint32_t i)
{
    const struct tiling_tile *t = &m->tiles[i];
    uint32_t v[3] = {t->v[0], t->v[1], t->v[2]};
    bool inside = t->inside;
    for (int k = 0; k < 3; k++)
        if (planar_same(m->vertices[v[k]].p, p))
            return v[k];
    for (int k = 0; k < 3; k++)
        if (planar_orient(m->vertices[v[k]].p, m->vertices[v[(k + 1) % 3]].p, p) == 0)
            return tiling_split_side(m, p, truth, i, k);
    uint32_t n = add_vertex(m, p, truth);
    if (n == PLANAR_NONE)
        return n;
    struct tiling_plan plans[3];
    for (int k = 0; k < 3; k++)
        plans[k] = (struct tiling_plan){{v[k], v[(k + 1) % 3], n}, inside, {0}, 0, 0};
    tiling_gather(m, &i, 1);
    if (m->no_memory)
        return PLANAR_NONE;
    tiling_plan(m, plans, 3);
    tiling_replace(m, &i, 1, plans, 3);
    uint32_t ring[TILING_STAR_MAX];
    int corner[TILING_STAR_MAX], count = tiling_star(m, n, ring, corner);
    for (int k = 0; k < count; k++)
        tiling_push_tile(m, ring[k]);
    return n;
}

void tiling_add_sample(struct tiling *m, struct planar_point p, float truth, uint32_t t)
{
    uint32_t s;
    if (m->free_sample_count > 0) {
        s = m->free_samples[--m->free_sample_count];
    } else {
        if (!memory_reserve(m->context, (void **)&m->samples, &m->sample_capacity, m->sample_count,
                            1, sizeof(*m->samples))) {
            m->no_memory = true;
            return;
        }
        s = (uint32_t)m->sample_count++;
    }
    m->samples[s] = (struct tiling_sample){p, truth, m->tiles[t].first};
    m->tiles[t].first = s;
    m->tiles[t].count++;
}

void tiling_drop_sample(struct tiling *m, uint32_t t, uint32_t sample)
{
    uint32_t *at = &m->tiles[t].first;
    while (*at != PLANAR_NONE && *at != sample)
        at = &m->samples[*at].next;
    if (*at == PLANAR_NONE)
        return;
    *at = m->samples[sample].next;
    m->tiles[t].count--;
    if (!memory_reserve(m->context, (void **)&m->free_samples, &m->free_sample_capacity,
                        m->free_sample_count, 1, sizeof(*m->free_samples)))
        m->no_memory = true;
    else
        m->free_samples[m->free_sample_count++] = sample;
}

int tiling_star(const struct tiling *m, uint32_t v, uint32_t *tiles, int *corners)
{
    uint32_t first = m->vertices[v].tile, t = first;
    int count = 0;
    if (first == PLANAR_NONE)
        return 0;
    do {
        if (count == TILING_STAR_MAX)
            return 0;
        int k = m->tiles[t].v[0] == v ? 0 : m->tiles[t].v[1] == v ? 1 : 2;
        tiles[count] = t;
        corners[count++] = k;
        uint32_t next = m->tiles[t].near[(k + 2) % 3];
        if (next == PLANAR_NONE)
            return 0;
        t = next / 3;
    } while (t != first);
    return count;
}

const char *tiling_validate(const struct tiling *m)
{
    for (uint32_t i = 0; i < m->tile_count; i++) {
        const struct tiling_tile *t = &m->tiles[i];
        if (t->v[0] == PLANAR_NONE)
            continue;
        if (planar_orient(m->vertices[t->v[0]].p, m->vertices[t->v[1]].p, m->vertices[t->v[2]].p) <=
            0)
            return "a triangle is not counter-clockwise";
        uint32_t count = 0;
        for (uint32_t s = t->first; s != PLANAR_NONE; s = m->samples[s].next, count++)
            if (!holds(m, t->v, m->samples[s].p))
                return "a sample lies outside its triangle";
        if (count != t->count)
            return "samples are miscounted";
        for (uint32_t k = 0; k < 3; k++) {
            uint32_t other = t->near[k];
            if (m->vertices[t->v[k]].tile == PLANAR_NONE)
                return "a triangle has a vertex that is gone";
            if (other == PLANAR_NONE) {
                if (!m->vertices[t->v[k]].border || !m->vertices[t->v[(k + 1) % 3]].border)
                    return "a side inside has no neighbour";
                continue;
            }
            const struct tiling_tile *u = &m->tiles[other / 3];
            if (u->v[0] == PLANAR_NONE || u->near[other % 3] != 3 * i + k ||
                u->v[other % 3] != t->v[(k + 1) % 3] || u->v[(other % 3 + 1) % 3] != t->v[k])
                return "neighbours disagree";
            if ((u->fixed >> other % 3 & 1) != (t->fixed >> k & 1))
                return "neighbours disagree about a fixed side";
            if (u->inside != t->inside && !(t->fixed >> k & 1))
                return "a foot's outline is not fixed";
        }
    }
    return NULL;
}
