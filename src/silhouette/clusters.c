/* silhouette/clusters.c: cuts a mesh into clusters, pairs its edges, bounds positions and planes.
 *
 * Top-down halving at multiples of CLUSTER_SIZE, so that all clusters but the last are full; along
 * the widest axis of the triangles' centroids, or of their normals where few triangles look many
 * ways (the two sheets of a thin part then part company). O(n log n) by quick-select.
 */
#include "silhouette/clusters.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

/* Normals decide the cut below this many triangles, once they span this much of [-1, 1]. */
#define NORMAL_CUT_TRIANGLES 1024
#define NORMAL_CUT_SPAN      1.0f

struct triangle {
    float key[6]; /* centroid, unit normal */
    uint32_t index;
};

struct builder {
    pnb_context *context;
    const struct mesh *mesh;
    const struct mesh_edges *edges;
    struct clusters *clusters;
    struct triangle *triangles;
    size_t count;
};

static vec3 triangle_normal(const float *a, const float *b, const float *c)
{
    vec3 p = v3_loadf(a), q = v3_loadf(b), r = v3_loadf(c);
    return v3_normalize(v3_cross(v3_sub(q, p), v3_sub(r, p)));
}

/* Quick-select: the k smallest by key[axis] come first; ties by index, so the result is unique. */
static bool before(const struct triangle *a, const struct triangle *b, int axis)
{
    if (a->key[axis] != b->key[axis])
        return a->key[axis] < b->key[axis];
    return a->index < b->index;
}

static void select_smallest(struct triangle *t, size_t count, size_t k, int axis)
{
    size_t low = 0, high = count;
    while (high - low > 1) {
        struct triangle pivot = t[low + (high - low) / 2];
        size_t i = low, j = high;
        for (;;) {
            while (before(&t[i], &pivot, axis))
                i++;
            while (before(&pivot, &t[j - 1], axis))
                j--;
            if (i + 1 >= j)
                break;
            struct triangle swap = t[i];
            t[i] = t[j - 1];
            t[j - 1] = swap;
            i++, j--;
        }
        /* t[low, i) <= pivot <= t[i, high) */
        size_t cut = i == low ? low + 1 : i;
        if (k == cut)
            return;
        if (k < cut)
            high = cut;
        else
            low = cut;
    }
}

static int cut_axis(const struct triangle *t, size_t count)
{
    float low[6], high[6];
    for (int a = 0; a < 6; a++)
        low[a] = FLT_MAX, high[a] = -FLT_MAX;
    for (size_t i = 0; i < count; i++)
        for (int a = 0; a < 6; a++) {
            low[a] = t[i].key[a] < low[a] ? t[i].key[a] : low[a];
            high[a] = t[i].key[a] > high[a] ? t[i].key[a] : high[a];
        }
    int best = 0;
    for (int a = 1; a < 3; a++)
        if (high[a] - low[a] > high[best] - low[best])
            best = a;
    if (count > NORMAL_CUT_TRIANGLES)
        return best;
    int turn = 3;
    for (int a = 4; a < 6; a++)
        if (high[a] - low[a] > high[turn] - low[turn])
            turn = a;
    return high[turn] - low[turn] > NORMAL_CUT_SPAN ? turn : best;
}

static void build_nodes(struct builder *b, size_t first, size_t count)
{
    struct clusters *c = b->clusters;
    struct cluster_node *node = &c->nodes[c->node_count++];
    node->first = (uint32_t)(first / CLUSTER_SIZE);
    node->count = (uint32_t)((count + CLUSTER_SIZE - 1) / CLUSTER_SIZE);
    if (node->count > 1) {
        size_t left = (size_t)(node->count / 2) * CLUSTER_SIZE;
        select_smallest(b->triangles + first, count, left, cut_axis(b->triangles + first, count));
        build_nodes(b, first, left);
        build_nodes(b, first + left, count - left);
    }
    node->next = (uint32_t)c->node_count;
}

static void bound_cluster(struct clusters *c, size_t index)
{
    struct cluster *k = &c->clusters[index];
    size_t first = index * CLUSTER_SIZE;
    size_t count = c->slot_count - first < CLUSTER_SIZE ? c->slot_count - first : CLUSTER_SIZE;
    for (int a = 0; a < 3; a++)
        k->low[a] = FLT_MAX, k->high[a] = -FLT_MAX;
    for (size_t i = 0; i < count; i++)
        for (int v = 0; v < 3; v++)
            for (int a = 0; a < 3; a++) {
                float x = c->positions[c->corners[first + i][v]][a];
                k->low[a] = x < k->low[a] ? x : k->low[a];
                k->high[a] = x > k->high[a] ? x : k->high[a];
            }
    for (int a = 0; a < 3; a++) {
        k->center[a] = (float)(0.5 * ((double)k->low[a] + k->high[a]));
        k->normal_low[a] = FLT_MAX, k->normal_high[a] = -FLT_MAX;
    }
    k->offset_low = FLT_MAX, k->offset_high = -FLT_MAX;
    vec3 center = v3_loadf(k->center);
    memset(c->planes[index], 0, sizeof(c->planes[index]));
    for (size_t i = 0; i < count; i++) {
        const float *p[3];
        for (int v = 0; v < 3; v++)
            p[v] = c->positions[c->corners[first + i][v]];
        vec3 n = triangle_normal(p[0], p[1], p[2]);
        if (!v3_finite(n))
            n = v3(0, 0, 0);
        float nf[3] = {(float)n.x, (float)n.y, (float)n.z};
        vec3 nr = v3_loadf(nf);
        /* The mean over the corners: rounding of n then tilts the plane about the middle. */
        double d = 0;
        for (int v = 0; v < 3; v++)
            d += v3_dot(nr, v3_sub(v3_loadf(p[v]), center)) / 3;
        float df = (float)d;
        for (int a = 0; a < 3; a++) {
            c->planes[index][a][i] = nf[a];
            k->normal_low[a] = nf[a] < k->normal_low[a] ? nf[a] : k->normal_low[a];
            k->normal_high[a] = nf[a] > k->normal_high[a] ? nf[a] : k->normal_high[a];
        }
        c->planes[index][3][i] = df;
        k->offset_low = df < k->offset_low ? df : k->offset_low;
        k->offset_high = df > k->offset_high ? df : k->offset_high;
    }
}

static void bound_all(struct clusters *c)
{
    for (size_t i = 0; i < c->cluster_count; i++)
        bound_cluster(c, i);
    /* Children come after their parent. */
    for (size_t i = c->node_count; i-- > 0;) {
        struct cluster_node *node = &c->nodes[i];
        if (node->count == 1) {
            memcpy(node->low, c->clusters[node->first].low, sizeof(node->low));
            memcpy(node->high, c->clusters[node->first].high, sizeof(node->high));
            continue;
        }
        const struct cluster_node *l = &c->nodes[i + 1], *r = &c->nodes[l->next];
        for (int a = 0; a < 3; a++) {
            node->low[a] = l->low[a] < r->low[a] ? l->low[a] : r->low[a];
            node->high[a] = l->high[a] > r->high[a] ? l->high[a] : r->high[a];
        }
    }
}

struct keyed_edge {
    uint64_t key; /* owner cluster, other cluster */
    struct cluster_edge edge;
};

static int compare_keyed(const void *a, const void *b)
{
    const struct keyed_edge *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    bool odd[2] = {cluster_edge_odd(&x->edge), cluster_edge_odd(&y->edge)};
    if (odd[0] != odd[1])
        return odd[0] ? -1 : 1;
    for (int i = 0; i < 2; i++)
        if (x->edge.use[i] != y->edge.use[i])
            return x->edge.use[i] < y->edge.use[i] ? -1 : 1;
    return 0;
}

/* Pairs up the uses of every edge and sorts the pairs by their clusters. */
static pnb_status build_edges(struct builder *b, const uint32_t *slot_of)
{
    struct clusters *c = b->clusters;
    pnb_context *context = b->context;
    const struct mesh_edges *me = b->edges;
    size_t bound = 0;
    for (size_t e = 0; e < me->edge_count; e++)
        bound += (me->edges[e].use_count + 1) / 2;
    struct keyed_edge *keyed = memory_alloc(context, bound, sizeof(*keyed));
    struct keyed_edge *sorted = memory_alloc(context, bound, sizeof(*sorted));
    size_t *start = memory_calloc(context, c->cluster_count + 1, sizeof(*start));
    pnb_status status = PNB_OK;
    if (!keyed || !sorted || !start) {
        status = status_no_memory(context, bound * sizeof(*keyed));
        goto done;
    }

    size_t count = 0;
    for (size_t e = 0; e < me->edge_count; e++) {
        const struct mesh_edge *edge = &me->edges[e];
        struct cluster_edge pair = {{c->vertex[me->welded_vertex[edge->vertex[0]]],
                                     c->vertex[me->welded_vertex[edge->vertex[1]]]},
                                    {MESH_NONE, MESH_NONE}};
        for (uint32_t u = 0; u < edge->use_count; u++) {
            uint32_t use = me->uses[edge->first_use + u];
            uint32_t slot = slot_of[use / 2];
            if (slot == MESH_NONE)
                continue;
            use = slot * 2 + (use & 1);
            if (pair.use[0] == MESH_NONE) {
                pair.use[0] = use;
                continue;
            }
            pair.use[1] = use;
            uint32_t k0 = pair.use[0] / 2 / CLUSTER_SIZE, k1 = use / 2 / CLUSTER_SIZE;
            keyed[count].key = k0 < k1 ? (uint64_t)k0 << 32 | k1 : (uint64_t)k1 << 32 | k0;
            keyed[count++].edge = pair;
            pair.use[0] = pair.use[1] = MESH_NONE;
        }
        if (pair.use[0] != MESH_NONE) {
            uint32_t k0 = pair.use[0] / 2 / CLUSTER_SIZE;
            keyed[count].key = (uint64_t)k0 << 32 | k0;
            keyed[count++].edge = pair;
        }
    }

    /* Counting sort by owner, then each owner's few edges by the other cluster. */
    for (size_t i = 0; i < count; i++)
        start[(keyed[i].key >> 32) + 1]++;
    for (size_t k = 0; k < c->cluster_count; k++)
        start[k + 1] += start[k];
    for (size_t i = 0; i < count; i++)
        sorted[start[keyed[i].key >> 32]++] = keyed[i];
    for (size_t k = c->cluster_count; k > 0; k--)
        start[k] = start[k - 1];
    start[0] = 0;
    size_t pairs = 0;
    for (size_t k = 0; k < c->cluster_count; k++) {
        qsort(sorted + start[k], start[k + 1] - start[k], sizeof(*sorted), compare_keyed);
        for (size_t i = start[k]; i < start[k + 1]; i++)
            if ((uint32_t)sorted[i].key != k &&
                (i == start[k] || sorted[i].key != sorted[i - 1].key))
                pairs++;
    }

    c->edge_count = count;
    c->border_count = 2 * pairs;
    c->edges = memory_alloc(context, count, sizeof(*c->edges));
    c->borders = memory_alloc(context, c->border_count, sizeof(*c->borders));
    if (!c->edges || !c->borders) {
        status = status_no_memory(context, count * sizeof(*c->edges));
        goto done;
    }
    for (size_t i = 0; i < count; i++) {
        c->edges[i] = sorted[i].edge;
        uint32_t k0 = (uint32_t)(sorted[i].key >> 32), k1 = (uint32_t)sorted[i].key;
        if (k0 == k1) {
            if (c->clusters[k0].edge_count++ == 0)
                c->clusters[k0].edge_first = (uint32_t)i;
            c->clusters[k0].odd_count += cluster_edge_odd(&sorted[i].edge);
        } else if (i == 0 || sorted[i].key != sorted[i - 1].key) {
            c->clusters[k0].border_count++;
            c->clusters[k1].border_count++;
        }
    }
    uint32_t sum = 0;
    for (size_t k = 0; k < c->cluster_count; k++) {
        c->clusters[k].border_first = sum;
        sum += c->clusters[k].border_count;
        c->clusters[k].border_count = 0;
    }
    for (size_t i = 0; i < count;) {
        size_t end = i;
        while (end < count && sorted[end].key == sorted[i].key)
            end++;
        uint32_t k[2] = {(uint32_t)(sorted[i].key >> 32), (uint32_t)sorted[i].key};
        for (int side = 0; side < 2 && k[0] != k[1]; side++) {
            struct cluster *cluster = &c->clusters[k[side]];
            c->borders[cluster->border_first + cluster->border_count++] =
                (struct cluster_border){k[1 - side], (uint32_t)i, (uint32_t)(end - i) & 0x3fffffffu,
                                        side == 0, cluster_edge_odd(&sorted[i].edge)};
        }
        i = end;
    }
done:
    memory_free(context, keyed);
    memory_free(context, sorted);
    memory_free(context, start);
    return status;
}

static pnb_status build(struct builder *b)
{
    struct clusters *c = b->clusters;
    pnb_context *context = b->context;
    const struct mesh *mesh = b->mesh;
    const struct mesh_edges *me = b->edges;

    /* Keep the triangles with three distinct corners. */
    b->triangles = memory_alloc(context, mesh->triangle_count, sizeof(*b->triangles));
    uint32_t *slot_of = memory_alloc(context, mesh->triangle_count, sizeof(*slot_of));
    uint32_t *ours = memory_alloc(context, me->welded_count, sizeof(*ours));
    c->mesh_vertex_count = mesh->vertex_count;
    c->vertex = memory_alloc(context, mesh->vertex_count, sizeof(*c->vertex));
    pnb_status status = PNB_OK;
    if (!b->triangles || !slot_of || !ours || !c->vertex) {
        status = status_no_memory(context, mesh->triangle_count * sizeof(*b->triangles));
        goto done;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        const uint32_t *v = mesh->indices + 3 * t;
        slot_of[t] = MESH_NONE;
        if (me->welded[v[0]] == me->welded[v[1]] || me->welded[v[1]] == me->welded[v[2]] ||
            me->welded[v[2]] == me->welded[v[0]])
            continue;
        const float *p[3] = {mesh->positions + 3 * v[0], mesh->positions + 3 * v[1],
                             mesh->positions + 3 * v[2]};
        struct triangle *triangle = &b->triangles[b->count++];
        vec3 n = triangle_normal(p[0], p[1], p[2]);
        for (int a = 0; a < 3; a++)
            triangle->key[a] = (p[0][a] + p[1][a] + p[2][a]) / 3;
        v3_storef(triangle->key + 3, v3_finite(n) ? n : v3(0, 0, 0));
        triangle->index = (uint32_t)t;
    }

    c->slot_count = b->count;
    c->cluster_count = (b->count + CLUSTER_SIZE - 1) / CLUSTER_SIZE;
    c->vertex_count = me->welded_count;
    c->positions = memory_calloc(context, c->vertex_count, sizeof(*c->positions));
    c->corners = memory_alloc(context, c->slot_count, sizeof(*c->corners));
    c->planes = memory_calloc(context, c->cluster_count, sizeof(*c->planes));
    c->clusters = memory_calloc(context, c->cluster_count, sizeof(*c->clusters));
    c->nodes = memory_alloc(context, 2 * c->cluster_count, sizeof(*c->nodes));
    if (!c->positions || !c->corners || !c->planes || !c->clusters || !c->nodes) {
        status = status_no_memory(context, c->slot_count * 40);
        goto done;
    }
    if (b->count > 0)
        build_nodes(b, 0, b->count);

    /* Number the vertices in the order of the slots: neighbours in space are neighbours in memory.
     */
    memset(ours, 0xff, me->welded_count * sizeof(*ours));
    uint32_t vertices = 0;
    for (size_t s = 0; s < c->slot_count; s++) {
        const uint32_t *v = mesh->indices + 3 * (size_t)b->triangles[s].index;
        slot_of[b->triangles[s].index] = (uint32_t)s;
        for (int i = 0; i < 3; i++) {
            uint32_t welded = me->welded[v[i]];
            if (ours[welded] == MESH_NONE) {
                memcpy(c->positions[vertices], mesh->positions + 3 * (size_t)v[i],
                       3 * sizeof(float));
                ours[welded] = vertices++;
            }
            c->corners[s][i] = ours[welded];
        }
    }
    c->vertex_count = vertices;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        c->vertex[v] = ours[me->welded[v]];

    status = build_edges(b, slot_of);
    if (status == PNB_OK)
        bound_all(c);
done:
    memory_free(context, b->triangles);
    memory_free(context, slot_of);
    memory_free(context, ours);
    return status;
}

pnb_status clusters_create(pnb_context *context, struct mesh *mesh, struct clusters **out_clusters)
{
    *out_clusters = NULL;
    const struct mesh_edges *edges;
    pnb_status status = mesh_get_edges(context, mesh, &edges);
    if (status != PNB_OK)
        return status;
    struct clusters *c = memory_calloc(context, 1, sizeof(*c));
    if (!c)
        return status_no_memory(context, sizeof(*c));
    struct builder builder = {context, mesh, edges, c, NULL, 0};
    status = build(&builder);
    if (status != PNB_OK) {
        clusters_destroy(context, c);
        return status;
    }
    c->bytes = sizeof(*c) + c->vertex_count * sizeof(*c->positions) +
               c->mesh_vertex_count * sizeof(*c->vertex) + c->slot_count * sizeof(*c->corners) +
               c->cluster_count * (sizeof(*c->planes) + sizeof(*c->clusters)) +
               c->edge_count * sizeof(*c->edges) + c->border_count * sizeof(*c->borders) +
               2 * c->cluster_count * sizeof(*c->nodes);
    clusters_find_solid(c);
    *out_clusters = c;
    return PNB_OK;
}

void clusters_destroy(pnb_context *context, struct clusters *c)
{
    if (!c)
        return;
    memory_free(context, c->positions);
    memory_free(context, c->vertex);
    memory_free(context, c->corners);
    memory_free(context, c->planes);
    memory_free(context, c->clusters);
    memory_free(context, c->edges);
    memory_free(context, c->borders);
    memory_free(context, c->nodes);
    memory_free(context, c);
}

bool clusters_refit(struct clusters *c, const struct mesh *mesh)
{
    if (mesh->vertex_count != c->mesh_vertex_count)
        return false;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (c->vertex[v] != MESH_NONE)
            memcpy(c->positions[c->vertex[v]], mesh->positions + 3 * v, 3 * sizeof(float));
    if (!clusters_fit(c, mesh))
        return false;
    bound_all(c);
    clusters_find_solid(c);
    return true;
}

bool clusters_fit(const struct clusters *c, const struct mesh *mesh)
{
    bool same = mesh->vertex_count == c->mesh_vertex_count;
    for (size_t v = 0; same && v < mesh->vertex_count; v++)
        for (int a = 0; a < 3 && c->vertex[v] != MESH_NONE; a++)
            same &= c->positions[c->vertex[v]][a] == mesh->positions[3 * v + (size_t)a];
    return same;
}

const char *clusters_validate(const struct clusters *c)
{
    size_t uses = 0, interior = 0, border = 0;
    for (size_t e = 0; e < c->edge_count; e++) {
        const struct cluster_edge *edge = &c->edges[e];
        for (int i = 0; i < 2; i++) {
            if (edge->use[i] == MESH_NONE && i == 1)
                continue;
            if (edge->use[i] / 2 >= c->slot_count)
                return "a use out of range";
            const uint32_t *v = c->corners[edge->use[i] / 2];
            bool found = false;
            for (int k = 0; k < 3; k++) {
                uint32_t a = v[k], b = v[(k + 1) % 3];
                found |= edge->use[i] & 1 ? a == edge->vertex[1] && b == edge->vertex[0]
                                          : a == edge->vertex[0] && b == edge->vertex[1];
            }
            if (!found)
                return "a use whose triangle does not run along the edge";
            uses++;
        }
    }
    if (uses != 3 * c->slot_count)
        return "not every side of every triangle is used once";
    for (size_t k = 0; k < c->cluster_count; k++) {
        const struct cluster *cluster = &c->clusters[k];
        interior += cluster->edge_count;
        for (size_t e = 0; e < cluster->edge_count; e++)
            for (int i = 0; i < 2; i++) {
                uint32_t use = c->edges[cluster->edge_first + e].use[i];
                if (use != MESH_NONE && use / 2 / CLUSTER_SIZE != k)
                    return "an interior edge of a triangle outside";
            }
        for (size_t b = 0; b < cluster->border_count; b++) {
            const struct cluster_border *list = &c->borders[cluster->border_first + b];
            border += list->owner ? list->count : 0;
            for (size_t e = 0; e < list->count; e++)
                for (int i = 0; i < 2; i++) {
                    uint32_t of = c->edges[list->first + e].use[i] / 2 / CLUSTER_SIZE;
                    if (of != k && of != list->other)
                        return "a border edge of another pair";
                }
        }
    }
    if (interior + border != c->edge_count)
        return "edges in no list, or in two";
    return NULL;
}
