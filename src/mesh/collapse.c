/* mesh/collapse.c: see the header.
 *
 * In passes: the cost of all edges, sorted; then, from the cheapest on, every edge is collapsed
 * none of whose ends another one of the pass has moved. A pass stops at the median cost, so that no
 * edge is taken much before its turn, and takes about a sixth of the vertices. Cost: O(n) per pass,
 * and some four passes to half the triangles.
 *
 * An edge a b is not collapsed where a and b have other than two neighbours in common (the surface
 * would pinch), where a triangle would turn over or become a sliver, or where a or b are fixed. An
 * edge between a fixed vertex and a free one is collapsed to the fixed one.
 */
#include "mesh/collapse.h"

#include <string.h>

#define PASSES_MAX    60
#define LEAST_GAIN    200  /* a pass that removes less than one in so many triangles is the last */
#define MIDDLE_WEIGHT 1e-3 /* draws to the edge's middle where planes leave the place open */
#define LEAST_TURN    0.2  /* cosine between a triangle's normal before and after */
#define LEAST_SHAPE   0.02 /* twice the area over the square of the longest side */
#define NEIGHBOURS    64   /* a vertex with more is left alone */

struct pass {
    struct collapse *c;
    uint32_t *first, *use; /* triangles of a vertex: use[first[v] .. first[v + 1]] */
    float *cost;           /* [3 t + k]: of the side from corner k to the next, or -1 */
    uint32_t *order;       /* sides by cost */
    uint32_t *remap;       /* vertex -> what it was collapsed to */
    bool *moved;
};

static void quadric_add_plane(double q[10], vec3 n, double d, double weight)
{
    const double v[4] = {n.x, n.y, n.z, d};
    for (int i = 0, k = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            q[k++] += weight * v[i] * v[j];
}

static double quadric_at(const double q[10], vec3 p)
{
    return q[0] * p.x * p.x + q[4] * p.y * p.y + q[7] * p.z * p.z + q[9] +
           2 * (q[1] * p.x * p.y + q[2] * p.x * p.z + q[5] * p.y * p.z + q[3] * p.x + q[6] * p.y +
                q[8] * p.z);
}

/* Where to collapse an edge to and at what cost, all relative to its middle. */
static double edge_cost(const struct collapse *c, uint32_t a, uint32_t b, vec3 *out_place)
{
    vec3 pa = c->positions[a], pb = c->positions[b];
    double q[10];
    for (int i = 0; i < 10; i++)
        q[i] = c->quadrics[a][i] + c->quadrics[b][i];
    if (c->fixed[a] || c->fixed[b]) {
        *out_place = c->fixed[a] ? pa : pb;
        return fmax(quadric_at(q, *out_place), 0);
    }
    vec3 m = v3_scale(v3_add(pa, pb), 0.5);
    /* Q(m + x) + w |x|^2, its gradient zero: (A + w) x = -(A m + b). */
    double w = MIDDLE_WEIGHT * (q[0] + q[4] + q[7]);
    vec3 r0 = v3(q[0] + w, q[1], q[2]), r1 = v3(q[1], q[4] + w, q[5]),
         r2 = v3(q[2], q[5], q[7] + w);
    vec3 g = v3(-(q[0] * m.x + q[1] * m.y + q[2] * m.z + q[3]),
                -(q[1] * m.x + q[4] * m.y + q[5] * m.z + q[6]),
                -(q[2] * m.x + q[5] * m.y + q[7] * m.z + q[8]));
    vec3 c01 = v3_cross(r0, r1), c12 = v3_cross(r1, r2), c20 = v3_cross(r2, r0);
    double det = v3_dot(r0, c12);
    *out_place = m;
    if (det > 0) {
        vec3 x = v3_scale(
            v3_add(v3_add(v3_scale(c12, g.x), v3_scale(c20, g.y)), v3_scale(c01, g.z)), 1 / det);
        vec3 e = v3_sub(pb, pa);
        if (v3_dot(x, x) <= v3_dot(e, e))
            *out_place = v3_add(m, x);
    }
    return fmax(quadric_at(q, *out_place), 0);
}

static vec3 cross_of(vec3 a, vec3 b, vec3 c)
{
    return v3_cross(v3_sub(b, a), v3_sub(c, a));
}

pnb_status collapse_init(pnb_context *context, const float (*positions)[4], size_t vertex_count,
                         const uint32_t (*triangles)[3], size_t triangle_count, struct collapse *c)
{
    *c = (struct collapse){.vertex_count = vertex_count,
                           .triangle_count = triangle_count,
                           .given_count = vertex_count};
    c->positions = memory_alloc(context, vertex_count, sizeof(*c->positions));
    c->triangles = memory_alloc(context, triangle_count, sizeof(*c->triangles));
    c->owner = memory_alloc(context, vertex_count, sizeof(*c->owner));
    c->quadrics = memory_calloc(context, vertex_count, sizeof(*c->quadrics));
    c->fixed = memory_calloc(context, vertex_count, sizeof(*c->fixed));
    /* The next vertex around each corner, to see what is not closed. */
    uint32_t *first = memory_calloc(context, vertex_count + 2, sizeof(*first));
    uint32_t(*around)[2] = memory_alloc(context, 3 * triangle_count, sizeof(*around));
    pnb_status status = PNB_OK;
    if (!c->positions || !c->triangles || !c->owner || !c->quadrics || !c->fixed || !first ||
        !around) {
        status = status_no_memory(context, triangle_count * 24 + vertex_count * 120);
        goto done;
    }
    for (size_t v = 0; v < vertex_count; v++) {
        c->positions[v] = v3_loadf(positions[v]);
        c->owner[v] = (uint32_t)v;
    }
    if (triangle_count > 0)
        memcpy(c->triangles, triangles, triangle_count * sizeof(*c->triangles));
    for (size_t t = 0; t < triangle_count; t++) {
        const uint32_t *v = c->triangles[t];
        vec3 p = c->positions[v[0]];
        vec3 n = cross_of(p, c->positions[v[1]], c->positions[v[2]]);
        double area2 = v3_length(n);
        for (int k = 0; k < 3; k++) {
            first[v[k] + 2]++;
            if (area2 > 0)
                quadric_add_plane(c->quadrics[v[k]], v3_scale(n, 1 / area2), -v3_dot(n, p) / area2,
                                  area2);
        }
    }
    for (size_t v = 0; v < vertex_count; v++)
        first[v + 2] += first[v + 1];
    for (size_t t = 0; t < triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const uint32_t *v = c->triangles[t];
            uint32_t *to = around[first[v[k] + 1]++];
            to[0] = v[(k + 1) % 3], to[1] = v[(k + 2) % 3];
        }
    /* Free: every neighbour comes once after and once before the vertex, and all hang together. */
    for (size_t v = 0; v < vertex_count; v++) {
        const uint32_t(*fan)[2] = (const uint32_t(*)[2])(around + first[v]);
        size_t count = first[v + 1] - first[v], steps = 0;
        if (count < 3 || count > NEIGHBOURS) {
            c->fixed[v] = true;
            continue;
        }
        uint32_t at = fan[0][0];
        do {
            size_t next = count;
            for (size_t i = 0; i < count; i++)
                if (fan[i][0] == at)
                    next = next == count ? i : count + 1;
            if (next >= count)
                break;
            at = fan[next][1];
            steps++;
        } while (at != fan[0][0] && steps <= count);
        c->fixed[v] = steps != count || at != fan[0][0];
    }
done:
    memory_free(context, first);
    memory_free(context, around);
    if (status != PNB_OK)
        collapse_finish(context, c);
    return status;
}

void collapse_finish(pnb_context *context, struct collapse *c)
{
    memory_free(context, c->positions);
    memory_free(context, c->triangles);
    memory_free(context, c->owner);
    memory_free(context, c->quadrics);
    memory_free(context, c->fixed);
    memset(c, 0, sizeof(*c));
}

static void cost_body(void *user, size_t begin, size_t end, int worker)
{
    struct pass *pass = user;
    const struct collapse *c = pass->c;
    for (size_t t = begin; t < end; t++)
        for (int k = 0; k < 3; k++) {
            uint32_t a = c->triangles[t][k], b = c->triangles[t][(k + 1) % 3];
            float *out = &pass->cost[3 * t + (size_t)k];
            *out = -1;
            /* Free vertices have all their sides twice, once in each sense. */
            if ((c->fixed[a] && c->fixed[b]) || a > b)
                continue;
            vec3 place;
            *out = (float)edge_cost(c, a, b, &place);
        }
}

/* The sides that have a cost, by cost: keys of 31 bits, 11 at a time; ties stay in order. */
static size_t sort_sides(const float *cost, size_t count, uint32_t *order, uint32_t *spare)
{
    size_t n = 0;
    for (size_t i = 0; i < count; i++)
        if (cost[i] >= 0)
            spare[n++] = (uint32_t)i;
    for (int shift = 0; shift < 33; shift += 11) {
        size_t start[2049] = {0};
        uint32_t *from = shift == 11 ? order : spare, *to = shift == 11 ? spare : order;
        for (size_t i = 0; i < n; i++) {
            uint32_t key;
            memcpy(&key, &cost[from[i]], sizeof(key));
            start[(key >> shift & 2047) + 1]++;
        }
        for (int b = 0; b < 2048; b++)
            start[b + 1] += start[b];
        for (size_t i = 0; i < n; i++) {
            uint32_t key;
            memcpy(&key, &cost[from[i]], sizeof(key));
            to[start[key >> shift & 2047]++] = from[i];
        }
    }
    return n;
}

/* A triangle as it is by now, turned so that v comes first; false: it is gone. */
static bool triangle_now(const struct pass *pass, uint32_t triangle, uint32_t v, uint32_t out[3])
{
    const uint32_t *t = pass->c->triangles[triangle];
    int k = t[0] == v ? 0 : t[1] == v ? 1 : 2;
    for (int i = 0; i < 3; i++)
        out[i] = pass->remap[t[(k + i) % 3]];
    return out[0] != out[1] && out[1] != out[2] && out[2] != out[0];
}

/* May a's triangles follow it to a new place? Those that other has too will be gone. */
static bool stays_upright(const struct pass *pass, uint32_t a, uint32_t other, vec3 place)
{
    const struct collapse *c = pass->c;
    for (uint32_t i = pass->first[a]; i < pass->first[a + 1]; i++) {
        uint32_t t[3];
        if (!triangle_now(pass, pass->use[i], a, t) || t[1] == other || t[2] == other)
            continue;
        vec3 p1 = c->positions[t[1]], p2 = c->positions[t[2]];
        vec3 before = cross_of(c->positions[a], p1, p2), after = cross_of(place, p1, p2);
        double b2 = v3_dot(before, before), a2 = v3_dot(after, after), dot = v3_dot(before, after);
        vec3 e0 = v3_sub(p1, place), e1 = v3_sub(p2, place), e2 = v3_sub(p2, p1);
        double longest = fmax(v3_dot(e0, e0), fmax(v3_dot(e1, e1), v3_dot(e2, e2)));
        if (b2 > 0 && (dot <= 0 || dot * dot < LEAST_TURN * LEAST_TURN * a2 * b2))
            return false;
        if (a2 < LEAST_SHAPE * LEAST_SHAPE * longest * longest && a2 < b2)
            return false;
    }
    return true;
}

static size_t neighbours(const struct pass *pass, uint32_t v, uint32_t *out)
{
    size_t count = 0;
    for (uint32_t i = pass->first[v]; i < pass->first[v + 1]; i++) {
        uint32_t t[3];
        if (!triangle_now(pass, pass->use[i], v, t))
            continue;
        for (int k = 1; k < 3; k++) {
            bool known = false;
            for (size_t j = 0; j < count; j++)
                known |= out[j] == t[k];
            if (!known && count < NEIGHBOURS)
                out[count++] = t[k];
        }
    }
    return count;
}

/* Collapses b into a at a new place, or does nothing. */
static bool collapse_edge(struct pass *pass, uint32_t a, uint32_t b)
{
    struct collapse *c = pass->c;
    if (pass->moved[a] || pass->moved[b])
        return false;
    if (c->fixed[b]) {
        uint32_t swap = a;
        a = b, b = swap;
    }
    vec3 place;
    edge_cost(c, a, b, &place);
    uint32_t na[NEIGHBOURS], nb[NEIGHBOURS];
    size_t count_a = neighbours(pass, a, na), count_b = neighbours(pass, b, nb), common = 0;
    if (count_a + count_b > NEIGHBOURS / 2 || count_a == NEIGHBOURS)
        return false;
    for (size_t i = 0; i < count_a; i++)
        for (size_t j = 0; j < count_b; j++)
            common += na[i] == nb[j];
    /* At least four triangles are left around a, so that nothing folds flat. */
    if (common != 2 || (!c->fixed[a] && count_a + count_b < 8))
        return false;
    if ((!c->fixed[a] && !stays_upright(pass, a, b, place)) || !stays_upright(pass, b, a, place))
        return false;
    c->positions[a] = place;
    for (int i = 0; i < 10; i++)
        c->quadrics[a][i] += c->quadrics[b][i];
    pass->remap[b] = a;
    pass->moved[a] = pass->moved[b] = true;
    return true;
}

/* Numbers what is left. */
static void compact(struct pass *pass)
{
    struct collapse *c = pass->c;
    uint32_t *number = pass->first; /* done with */
    uint32_t left = 0;
    for (uint32_t v = 0; v < c->vertex_count; v++) {
        if (pass->remap[v] != v)
            continue;
        number[v] = left;
        c->positions[left] = c->positions[v];
        memmove(c->quadrics[left], c->quadrics[v], sizeof(c->quadrics[v]));
        c->fixed[left] = c->fixed[v];
        left++;
    }
    for (size_t v = 0; v < c->given_count; v++)
        c->owner[v] = number[pass->remap[c->owner[v]]];
    size_t kept = 0;
    for (size_t t = 0; t < c->triangle_count; t++) {
        uint32_t v[3];
        for (int k = 0; k < 3; k++)
            v[k] = number[pass->remap[c->triangles[t][k]]];
        if (v[0] != v[1] && v[1] != v[2] && v[2] != v[0])
            memcpy(c->triangles[kept++], v, sizeof(v));
    }
    c->vertex_count = left;
    c->triangle_count = kept;
}

static pnb_status run_pass(pnb_context *context, struct collapse *c, size_t wanted)
{
    struct pass pass = {.c = c};
    size_t sides = 3 * c->triangle_count;
    pass.first = memory_calloc(context, c->vertex_count + 2, sizeof(*pass.first));
    pass.use = memory_alloc(context, sides, sizeof(*pass.use));
    pass.cost = memory_alloc(context, sides, sizeof(*pass.cost));
    pass.order = memory_alloc(context, sides, sizeof(*pass.order));
    pass.remap = memory_alloc(context, c->vertex_count, sizeof(*pass.remap));
    pass.moved = memory_calloc(context, c->vertex_count, sizeof(*pass.moved));
    pnb_status status = PNB_OK;
    if (!pass.first || !pass.use || !pass.cost || !pass.order || !pass.remap || !pass.moved) {
        status = status_no_memory(context, sides * 12);
        goto done;
    }
    parallel_for(context, c->triangle_count, 4096, cost_body, &pass);
    size_t count = sort_sides(pass.cost, sides, pass.order, pass.use);
    for (size_t t = 0; t < c->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            pass.first[c->triangles[t][k] + 2]++;
    for (size_t v = 0; v < c->vertex_count; v++)
        pass.first[v + 2] += pass.first[v + 1];
    for (size_t t = 0; t < c->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            pass.use[pass.first[c->triangles[t][k] + 1]++] = (uint32_t)t;
    for (size_t v = 0; v < c->vertex_count; v++)
        pass.remap[v] = (uint32_t)v;

    size_t left = c->triangle_count;
    for (size_t i = 0; i < count && left > wanted && (i < count / 2 || i < 64); i++) {
        const uint32_t *t = c->triangles[pass.order[i] / 3];
        uint32_t k = pass.order[i] % 3;
        if (collapse_edge(&pass, t[k], t[(k + 1) % 3]))
            left -= 2;
    }
    compact(&pass);
done:
    memory_free(context, pass.first);
    memory_free(context, pass.use);
    memory_free(context, pass.cost);
    memory_free(context, pass.order);
    memory_free(context, pass.remap);
    memory_free(context, pass.moved);
    return status;
}

pnb_status collapse_to(pnb_context *context, struct collapse *c, size_t triangle_count)
{
    pnb_status status = PNB_OK;
    for (int i = 0; i < PASSES_MAX && c->triangle_count > triangle_count && status == PNB_OK; i++) {
        size_t before = c->triangle_count;
        status = run_pass(context, c, triangle_count);
        if (c->triangle_count > before - before / LEAST_GAIN)
            break;
    }
    return status;
}
