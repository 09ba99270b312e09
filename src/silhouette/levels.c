/* silhouette/levels.c: coarser meshes by edge collapse (mesh/collapse.h), fitted to the mesh.
 *
 * Where the collapse puts vertices is a little outside of round bodies. So they are moved along
 * their normals by a few steps of least squares over points of the mesh, weighted by area: the
 * level then runs through the middle. What is left is a small difference in area (a closed convex
 * body's shadow is a quarter of its surface in the mean over all directions, Cauchy), which one
 * common offset takes away, as far as it is no larger than the mean distance: a rough surface is
 * larger than the smooth one through its middle.
 *
 * Distances: the collapse says which vertex each of the mesh's has come to; from there on the
 * nearest triangle is searched by walking, so that what is found is no less than the distance. That
 * the level is nowhere far from the mesh follows: the mesh, its vertices moved to where they were
 * found, covers the level, as a loop that is pulled tight covers what it is pulled to.
 *
 * Cost: O(n log n) per level, all levels about twice the first. Degenerate input: a level that has
 * open borders which the mesh has not, or hardly fewer triangles than the level before, or has lost
 * its shape, is not kept, and none after it is tried. Vertices on open borders and on edges of
 * three and more triangles stay, so that soups and loose leaves have no levels.
 */
#include "silhouette/levels.h"

#include <float.h>
#include <string.h>

#include "mesh/collapse.h"

#define LEVEL_FEWER   2.0   /* times fewer triangles than the level before */
#define LEVEL_LEAST   40    /* triangles; below that a level is no gain */
#define LEVEL_WORST   0.046 /* of the mesh's size: a level that is off by more is no use */
#define LEVEL_SAMPLES 4     /* points per triangle of the level at which distances are taken */
#define FIT_STEPS     6     /* of least squares */
#define FIT_DAMPING   0.9
#define WALK          6     /* vertices to walk over to the nearest place */
#define LEVEL_DENSE   50000 /* triangles from which on the first step is twice as large */

/* The nearest place on a surface. */
struct place {
    uint32_t slot; /* MESH_NONE: none yet */
    float weight[3];
    double distance2;
};

/* The weights of a triangle's corners at its point nearest to p (Ericson, Real-Time Collision
 * Detection, 5.1.5). */
static void nearest_weights(vec3 p, vec3 a, vec3 b, vec3 c, double out[3])
{
    vec3 ab = v3_sub(b, a), ac = v3_sub(c, a), ap = v3_sub(p, a);
    double d1 = v3_dot(ab, ap), d2 = v3_dot(ac, ap);
    out[0] = 1, out[1] = out[2] = 0;
    if (d1 <= 0 && d2 <= 0)
        return;
    vec3 bp = v3_sub(p, b);
    double d3 = v3_dot(ab, bp), d4 = v3_dot(ac, bp);
    if (d3 >= 0 && d4 <= d3) {
        out[0] = 0, out[1] = 1;
        return;
    }
    double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) {
        out[1] = d1 / (d1 - d3), out[0] = 1 - out[1];
        return;
    }
    vec3 cp = v3_sub(p, c);
    double d5 = v3_dot(ab, cp), d6 = v3_dot(ac, cp);
    if (d6 >= 0 && d5 <= d6) {
        out[0] = 0, out[2] = 1;
        return;
    }
    double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) {
        out[2] = d2 / (d2 - d6), out[0] = 1 - out[2];
        return;
    }
    double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0 && d4 - d3 + (d5 - d6) > 0) {
        out[2] = (d4 - d3) / (d4 - d3 + (d5 - d6));
        out[0] = 0, out[1] = 1 - out[2];
        return;
    }
    double sum = va + vb + vc;
    if (!(sum > 0))
        return;
    out[1] = vb / sum, out[2] = vc / sum;
    out[0] = 1 - out[1] - out[2];
}

static vec3 place_point(const struct clusters *c, const struct place *place)
{
    vec3 q = v3(0, 0, 0);
    for (int i = 0; i < 3; i++)
        q = v3_mad(q, v3_loadf(c->positions[c->corners[place->slot][i]]), place->weight[i]);
    return q;
}

static void try_slot(const struct clusters *c, vec3 p, uint32_t slot, struct place *best)
{
    const uint32_t *v = c->corners[slot];
    vec3 q[3] = {v3_loadf(c->positions[v[0]]), v3_loadf(c->positions[v[1]]),
                 v3_loadf(c->positions[v[2]])};
    double w[3];
    nearest_weights(p, q[0], q[1], q[2], w);
    vec3 d = v3_sub(p, v3_mad(v3_mad(v3_scale(q[0], w[0]), q[1], w[1]), q[2], w[2]));
    double distance2 = v3_dot(d, d);
    if (distance2 < best->distance2) {
        best->distance2 = distance2;
        best->slot = slot;
        for (int i = 0; i < 3; i++)
            best->weight[i] = (float)w[i];
    }
}

/* A level and which of its triangles meet in a vertex: use[first[v] .. first[v + 1]]. */
struct rings {
    const struct clusters *c;
    uint32_t *first, *use;
};

static pnb_status rings_init(pnb_context *context, const struct clusters *c, struct rings *rings)
{
    rings->c = c;
    rings->first = memory_calloc(context, c->vertex_count + 2, sizeof(*rings->first));
    rings->use = memory_alloc(context, 3 * c->slot_count, sizeof(*rings->use));
    if (!rings->first || !rings->use)
        return status_no_memory(context, 3 * c->slot_count * sizeof(*rings->use));
    for (size_t s = 0; s < c->slot_count; s++)
        for (int k = 0; k < 3; k++)
            rings->first[c->corners[s][k] + 2]++;
    for (size_t v = 0; v < c->vertex_count; v++)
        rings->first[v + 2] += rings->first[v + 1];
    for (size_t s = 0; s < c->slot_count; s++)
        for (int k = 0; k < 3; k++)
            rings->use[rings->first[c->corners[s][k] + 1]++] = (uint32_t)s;
    return PNB_OK;
}

static void rings_finish(pnb_context *context, struct rings *rings)
{
    memory_free(context, rings->first);
    memory_free(context, rings->use);
}

/* The nearest place about a vertex, and about those that are nearer. No farther than the nearest
 * place of all, which may lie on another part of the surface: a bound of that distance. */
static struct place nearest(const struct rings *rings, vec3 p, uint32_t v)
{
    struct place best = {MESH_NONE, {0, 0, 0}, INFINITY};
    for (int step = 0; step < WALK; step++) {
        double before = best.distance2;
        for (uint32_t i = rings->first[v]; i < rings->first[v + 1]; i++)
            try_slot(rings->c, p, rings->use[i], &best);
        if (!(best.distance2 < before))
            break;
        int k = best.weight[1] > best.weight[0] ? 1 : 0;
        k = best.weight[2] > best.weight[k] ? 2 : k;
        uint32_t next = rings->c->corners[best.slot][k];
        if (next == v)
            break;
        v = next;
    }
    return best;
}

/* The normal of a triangle times twice its area. */
static vec3 slot_cross(const struct clusters *c, size_t slot)
{
    const uint32_t *v = c->corners[slot];
    vec3 a = v3_loadf(c->positions[v[0]]);
    return v3_cross(v3_sub(v3_loadf(c->positions[v[1]]), a),
                    v3_sub(v3_loadf(c->positions[v[2]]), a));
}

static double surface_of(const struct clusters *c)
{
    double sum = 0;
    for (size_t s = 0; s < c->slot_count; s++)
        sum += 0.5 * v3_length(slot_cross(c, s));
    return sum;
}

static size_t odd_of(const struct clusters *c)
{
    size_t odd = 0;
    for (size_t e = 0; e < c->edge_count; e++)
        odd += cluster_edge_odd(&c->edges[e]);
    return odd;
}

static void vertex_normals(const struct clusters *c, vec3 *normals)
{
    for (size_t v = 0; v < c->vertex_count; v++)
        normals[v] = v3(0, 0, 0);
    for (size_t s = 0; s < c->slot_count; s++) {
        vec3 n = slot_cross(c, s);
        for (int i = 0; i < 3; i++)
            normals[c->corners[s][i]] = v3_add(normals[c->corners[s][i]], n);
    }
    for (size_t v = 0; v < c->vertex_count; v++) {
        double length = v3_length(normals[v]);
        normals[v] = length > 0 ? v3_scale(normals[v], 1 / length) : v3(0, 0, 0);
    }
}

/* What making the levels of a mesh needs. */
struct maker {
    pnb_context *context;
    const struct clusters *fine;
    struct collapse collapse;
    float *area; /* a third of that of the triangles about each of the mesh's vertices */
    double surface;
    size_t odd;
};

/* Where some points of the mesh lie on a level: every stride-th of its vertices and triangles'
 * middles. Sums over them, by weight, are integrals over the mesh (exact for squares). */
struct match {
    const struct maker *maker;
    struct rings rings;
    size_t stride, count;
    struct place *places;
    float (*points)[3], *weights;
};

static void match_body(void *user, size_t begin, size_t end, int worker)
{
    const struct match *m = user;
    const struct clusters *c = m->rings.c, *fine = m->maker->fine;
    for (size_t i = begin; i < end; i++) {
        size_t at = i * m->stride;
        uint32_t v = (uint32_t)at;
        vec3 p;
        if (at < fine->vertex_count) {
            p = v3_loadf(fine->positions[v]);
            m->weights[i] = m->maker->area[v] / 4;
        } else {
            const uint32_t *corners = fine->corners[at - fine->vertex_count];
            vec3 q[3];
            for (int k = 0; k < 3; k++)
                q[k] = v3_loadf(fine->positions[corners[k]]);
            v = corners[0];
            p = v3_scale(v3_add(q[0], v3_add(q[1], q[2])), 1.0 / 3);
            m->weights[i] =
                (float)(0.375 * v3_length(v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]))));
        }
        v3_storef(m->points[i], p);
        v = c->vertex[m->maker->collapse.owner[v]];
        m->places[i] =
            v == MESH_NONE ? (struct place){0, {1, 0, 0}, INFINITY} : nearest(&m->rings, p, v);
    }
}

static pnb_status match_init(const struct maker *maker, const struct clusters *c, struct match *m)
{
    *m = (struct match){.maker = maker};
    size_t wanted = LEVEL_SAMPLES * c->slot_count + 1024;
    size_t points = maker->fine->vertex_count + maker->fine->slot_count;
    m->stride = (points + wanted - 1) / wanted;
    m->count = (points + m->stride - 1) / m->stride;
    m->places = memory_alloc(maker->context, m->count, sizeof(*m->places));
    m->points = memory_alloc(maker->context, m->count, sizeof(*m->points));
    m->weights = memory_alloc(maker->context, m->count, sizeof(*m->weights));
    if (!m->places || !m->points || !m->weights)
        return status_no_memory(maker->context, m->count * sizeof(*m->places));
    return rings_init(maker->context, c, &m->rings);
}

static void match_finish(const struct maker *maker, struct match *m)
{
    memory_free(maker->context, m->places);
    memory_free(maker->context, m->points);
    memory_free(maker->context, m->weights);
    rings_finish(maker->context, &m->rings);
}

/* Moves the level's vertices to where its surface runs through the middle of the mesh's. */
static pnb_status fit(const struct match *m, struct mesh *mesh, struct clusters *c)
{
    const struct maker *maker = m->maker;
    pnb_context *context = maker->context;
    float *rest = memory_alloc(context, m->count, sizeof(*rest));
    float(*turn)[3] = memory_alloc(context, m->count, sizeof(*turn));
    vec3 *normals = memory_alloc(context, c->vertex_count, sizeof(*normals));
    double *move = memory_calloc(context, c->vertex_count, sizeof(*move));
    double(*sums)[2] = memory_alloc(context, c->vertex_count, sizeof(*sums));
    bool *border = memory_calloc(context, c->vertex_count, sizeof(*border));
    pnb_status status = PNB_OK;
    if (!rest || !turn || !normals || !move || !sums || !border) {
        status = status_no_memory(context, m->count * sizeof(*turn));
        goto done;
    }
    /* Open borders stay where they are. */
    for (size_t e = 0; e < c->edge_count; e++)
        for (int i = 0; i < 2 && c->edges[e].use[1] == MESH_NONE; i++)
            border[c->edges[e].vertex[i]] = true;
    vertex_normals(c, normals);
    for (size_t i = 0; i < m->count; i++) {
        const struct place *place = &m->places[i];
        vec3 n = v3_normalize(slot_cross(c, place->slot));
        vec3 d = v3_sub(v3_loadf(m->points[i]), place_point(c, place));
        rest[i] = (float)v3_dot(n, d);
        for (int k = 0; k < 3; k++)
            turn[i][k] = place->weight[k] * (float)v3_dot(n, normals[c->corners[place->slot][k]]);
    }
    for (int step = 0; step < FIT_STEPS; step++) {
        memset(sums, 0, c->vertex_count * sizeof(*sums));
        for (size_t i = 0; i < m->count; i++) {
            const uint32_t *v = c->corners[m->places[i].slot];
            double left = rest[i], weight = m->weights[i];
            for (int k = 0; k < 3; k++)
                left -= turn[i][k] * move[v[k]];
            for (int k = 0; k < 3; k++) {
                sums[v[k]][0] += weight * turn[i][k] * left;
                sums[v[k]][1] += weight * fabsf(turn[i][k]);
            }
        }
        for (size_t v = 0; v < c->vertex_count; v++)
            if (sums[v][1] > 0 && !border[v])
                move[v] += FIT_DAMPING * sums[v][0] / sums[v][1];
    }
    for (size_t v = 0; v < c->vertex_count; v++)
        v3_storef(c->positions[v], v3_mad(v3_loadf(c->positions[v]), normals[v], move[v]));

    /* The rest of the difference in area: its slope by a small offset. */
    double square = 0, weights = 0;
    for (size_t i = 0; i < m->count; i++) {
        const uint32_t *v = c->corners[m->places[i].slot];
        double left = rest[i], weight = m->weights[i];
        for (int k = 0; k < 3; k++)
            left -= turn[i][k] * move[v[k]];
        square += weight * left * left;
        weights += weight;
    }
    double mean = weights > 0 ? sqrt(square / weights) : 0;
    double before = surface_of(c);
    for (size_t v = 0; v < c->vertex_count; v++)
        if (!border[v])
            v3_storef(c->positions[v], v3_mad(v3_loadf(c->positions[v]), normals[v], mean));
    double slope = surface_of(c) - before;
    double offset = slope != 0 ? (maker->surface - before) / slope : 0;
    offset = offset < -1 ? -1 : offset > 1 ? 1 : offset;
    if (!isfinite(offset))
        offset = 0;
    for (size_t v = 0; v < c->vertex_count; v++)
        if (!border[v])
            v3_storef(c->positions[v],
                      v3_mad(v3_loadf(c->positions[v]), normals[v], mean * (offset - 1)));
    /* The clusters take their bounds from the mesh. */
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (c->vertex[v] != MESH_NONE)
            memcpy(mesh->positions + 3 * v, c->positions[c->vertex[v]], 3 * sizeof(float));
    clusters_refit(c, mesh);
done:
    memory_free(context, rest);
    memory_free(context, turn);
    memory_free(context, normals);
    memory_free(context, move);
    memory_free(context, sums);
    memory_free(context, border);
    return status;
}

static void measure(const struct match *m, struct level *level)
{
    const struct clusters *c = level->clusters;
    double square = 0, weights = 0, worst = 0;
    for (size_t i = 0; i < m->count; i++) {
        double weight = m->weights[i];
        square += weight * m->places[i].distance2;
        weights += weight;
        worst = fmax(worst, m->places[i].distance2);
    }
    level->distance = sqrt(worst);
    level->mean = weights > 0 ? sqrt(square / weights) : 0;
    double side = 0, area = 0;
    for (size_t t = 0; t < c->slot_count; t++) {
        double longest = 0, a = v3_length(slot_cross(c, t));
        for (int k = 0; k < 3; k++)
            longest = fmax(longest,
                           v3_length(v3_sub(v3_loadf(c->positions[c->corners[t][k]]),
                                            v3_loadf(c->positions[c->corners[t][(k + 1) % 3]]))));
        side += a * longest;
        area += a;
    }
    level->side = area > 0 ? side / area : 0;
    level->error = fmax(cbrt(level->mean * level->mean * level->side), 0.4 * level->distance);
}

static double extent_of(const struct clusters *c)
{
    double extent = 0;
    for (int a = 0; a < 3; a++)
        extent = fmax(extent, (double)c->nodes[0].high[a] - c->nodes[0].low[a]);
    return extent;
}

/* The clusters of what the collapse has come to, and how far they are off. */
static pnb_status make_level(const struct maker *maker, struct level *level, bool *out_good)
{
    pnb_context *context = maker->context;
    const struct collapse *collapse = &maker->collapse;
    *out_good = false;
    float *positions = memory_alloc(context, collapse->vertex_count, 3 * sizeof(float));
    if (!positions)
        return status_no_memory(context, collapse->vertex_count * 3 * sizeof(float));
    for (size_t v = 0; v < collapse->vertex_count; v++)
        v3_storef(positions + 3 * v, collapse->positions[v]);
    pnb_mesh_desc desc = {.name = "level",
                          .positions = positions,
                          .vertex_count = collapse->vertex_count,
                          .indices = &collapse->triangles[0][0],
                          .triangle_count = collapse->triangle_count};
    struct mesh mesh;
    struct match match = {0};
    pnb_status status = mesh_init(context, &mesh, &desc);
    memory_free(context, positions);
    if (status != PNB_OK)
        return status;
    status = clusters_create(context, &mesh, &level->clusters);
    struct clusters *c = level->clusters;
    if (status != PNB_OK || c->slot_count == 0 || odd_of(c) > maker->odd)
        goto done;
    status = match_init(maker, c, &match);
    if (status == PNB_OK) {
        parallel_for(context, match.count, 1024, match_body, &match);
        status = fit(&match, &mesh, c);
    }
    if (status == PNB_OK) {
        parallel_for(context, match.count, 1024, match_body, &match);
        measure(&match, level);
        level->triangle_count = c->slot_count;
        *out_good = level->distance <= LEVEL_WORST * extent_of(maker->fine);
    }
done:
    match_finish(maker, &match);
    mesh_finish(context, &mesh);
    return status;
}

static pnb_status make_coarser(struct maker *m, struct levels *levels)
{
    pnb_context *context = m->context;
    const struct clusters *fine = m->fine;
    m->area = memory_calloc(context, fine->vertex_count, sizeof(*m->area));
    if (!m->area)
        return status_no_memory(context, fine->vertex_count * sizeof(*m->area));
    for (size_t s = 0; s < fine->slot_count; s++) {
        double area = v3_length(slot_cross(fine, s));
        m->surface += 0.5 * area;
        for (int k = 0; k < 3; k++)
            m->area[fine->corners[s][k]] += (float)(area / 6);
    }
    m->odd = odd_of(fine);

    pnb_status status =
        collapse_init(context, (const float(*)[4])fine->positions, fine->vertex_count,
                      (const uint32_t(*)[3])fine->corners, fine->slot_count, &m->collapse);
    while (levels->count < LEVELS_MAX && status == PNB_OK) {
        size_t before = m->collapse.triangle_count;
        double fewer =
            levels->count == 1 && before >= LEVEL_DENSE ? LEVEL_FEWER * LEVEL_FEWER : LEVEL_FEWER;
        size_t wanted = (size_t)((double)before / fewer);
        if (wanted < LEVEL_LEAST)
            break;
        status = collapse_to(context, &m->collapse, wanted);
        if (status != PNB_OK || m->collapse.triangle_count > before / 4 * 3)
            break;
        struct level level = {0};
        bool good;
        status = make_level(m, &level, &good);
        if (!good) {
            clusters_destroy(context, level.clusters);
            break;
        }
        levels->bytes += level.clusters->bytes;
        level.error = fmax(level.error, levels->level[levels->count - 1].error);
        levels->level[levels->count++] = level;
    }
    collapse_finish(context, &m->collapse);
    memory_free(context, m->area);
    return status;
}

pnb_status levels_create(pnb_context *context, struct clusters *clusters,
                         struct levels **out_levels)
{
    *out_levels = NULL;
    struct levels *levels = memory_calloc(context, 1, sizeof(*levels));
    if (!levels)
        return status_no_memory(context, sizeof(*levels));
    levels->level[0] = (struct level){.clusters = clusters, .triangle_count = clusters->slot_count};
    levels->bytes = sizeof(*levels);
    levels->count = 1;
    struct maker maker = {.context = context, .fine = clusters};
    pnb_status status = PNB_OK;
    if (clusters->slot_count >= LEVEL_FEWER * LEVEL_LEAST)
        status = make_coarser(&maker, levels);
    if (status != PNB_OK) {
        levels_destroy(context, levels);
        return status;
    }
    *out_levels = levels;
    return PNB_OK;
}

void levels_destroy(pnb_context *context, struct levels *levels)
{
    for (size_t i = 1; levels && i < levels->count; i++)
        clusters_destroy(context, levels->level[i].clusters);
    memory_free(context, levels);
}
