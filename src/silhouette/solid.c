/* silhouette/solid.c: is a mesh the surface of one solid that is all but convex?
 *
 * Every edge joins two triangles that run along it in opposite directions, all triangles are
 * connected, vertices - edges + triangles = 2, and what lies above the plane of a triangle is a
 * vertex of its neighbours and not far above: dents from edge to edge, as the triangles of a sphere
 * have where they are not those of its hull.
 *
 * Seen from outside, such a solid's outline runs once around what it hides, but for slivers at its
 * limb: a ray that leaves through triangle A and enters again is above A's plane from there on, so
 * that all it meets later are neighbours of A. Three entries at most are taken for granted.
 *
 * Cost: O(vertices x triangles) for small closed meshes, O(edges) for larger ones, which are said
 * to be none. Solids turned inside out are none either.
 */
#include "silhouette/clusters.h"

/* Triangles at most: a solid is looked at as a whole. */
#define SOLID_MOST 2048

/* Shares of its size: by so much a vertex may lie above any triangle's plane, being rounded; and
 * above that of a neighbour. */
#define SOLID_ROOM 2e-6f
#define SOLID_DENT 0.02f

static bool closed(const struct clusters *c)
{
    for (size_t e = 0; e < c->edge_count; e++)
        if (cluster_edge_odd(&c->edges[e]))
            return false;
    return c->vertex_count + c->slot_count == c->edge_count + 2;
}

/* Slots are joined along edges until nothing changes. */
static bool connected(const struct clusters *c)
{
    uint16_t part[SOLID_MOST];
    for (size_t s = 0; s < c->slot_count; s++)
        part[s] = (uint16_t)s;
    size_t parts = c->slot_count;
    for (size_t e = 0; e < c->edge_count; e++) {
        uint16_t a = (uint16_t)(c->edges[e].use[0] / 2), b = (uint16_t)(c->edges[e].use[1] / 2);
        while (part[a] != a)
            a = part[a] = part[part[a]];
        while (part[b] != b)
            b = part[b] = part[part[b]];
        parts -= a != b;
        part[a > b ? a : b] = a > b ? b : a;
    }
    return parts == 1;
}

/* Does a triangle that has a vertex in common with slot s have the vertex v? */
static bool neighbours(const struct clusters *c, size_t s, uint32_t v)
{
    const uint32_t *own = c->corners[s];
    for (size_t t = 0; t < c->slot_count; t++) {
        const uint32_t *q = c->corners[t];
        if (q[0] != v && q[1] != v && q[2] != v)
            continue;
        for (int i = 0; i < 9; i++)
            if (own[i / 3] == q[i % 3])
                return true;
    }
    return false;
}

/* How high vertices lie above the planes of their neighbours; negative: above others, or too high.
 */
static float deepest_dent(const struct clusters *c, float size)
{
    float room = SOLID_ROOM * size, most = SOLID_DENT * size, dent = 0;
    for (size_t s = 0; s < c->slot_count; s++) {
        const float(*planes)[CLUSTER_SIZE] =
            (const float(*)[CLUSTER_SIZE])c->planes[s / CLUSTER_SIZE];
        const float *center = c->clusters[s / CLUSTER_SIZE].center;
        size_t i = s % CLUSTER_SIZE;
        float n[3] = {planes[0][i], planes[1][i], planes[2][i]}, d = planes[3][i];
        if (!(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0.5f))
            return -1;
        for (uint32_t v = 0; v < c->vertex_count; v++) {
            const float *p = c->positions[v];
            float height = n[0] * (p[0] - center[0]) + n[1] * (p[1] - center[1]) +
                           n[2] * (p[2] - center[2]) - d;
            if (height <= room)
                continue;
            if (!(height <= most) || !neighbours(c, s, v))
                return -1;
            dent = height > dent ? height : dent;
        }
    }
    return dent;
}

void clusters_find_solid(struct clusters *c)
{
    c->solid = false;
    c->dent = c->radius = 0;
    if (c->slot_count < 4 || c->slot_count > SOLID_MOST || !closed(c) || !connected(c))
        return;
    const struct cluster_node *root = &c->nodes[0];
    float size = 0, square = 0;
    for (int i = 0; i < 3; i++) {
        size = fmaxf(size, root->high[i] - root->low[i]);
        c->center[i] = 0.5f * (root->low[i] + root->high[i]);
    }
    float depth = deepest_dent(c, size);
    if (depth < 0)
        return;
    c->solid = true;
    c->dent = depth / size;
    for (size_t v = 0; v < c->vertex_count; v++) {
        float d[3] = {c->positions[v][0] - c->center[0], c->positions[v][1] - c->center[1],
                      c->positions[v][2] - c->center[2]};
        square = fmaxf(square, d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    }
    c->radius = sqrtf(square) * 1.00001f;
}
