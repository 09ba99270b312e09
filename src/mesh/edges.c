/* mesh/edges.c: which triangles share an edge.
 *
 * Vertices at equal positions count as one here (a texture seam is no hole); the mesh's own
 * vertices stay apart. Positions are equal when their three floats are, with -0 equal to 0: no
 * tolerance, so that two thin walls never grow together.
 *
 *   corners -> welded vertices -> (low, high) pairs -> edge of each corner -> uses by counting sort
 *
 * Two open-addressed tables, one over positions and one over pairs: O(vertices + triangles) time,
 * about 60 bytes per triangle while it runs. Edges and welded vertices are numbered in the order in
 * which the mesh first names them, uses within an edge by triangle: the same mesh gives the same
 * structure.
 *
 * Degenerate input: a triangle with two corners at one place uses the edge between its two places
 * twice, once each way; one with all three at one place has no edge. Vertices that no triangle uses
 * are welded too, but have no edge. */
#include "mesh/mesh.h"

#include <string.h>

/* Finaliser of MurmurHash3 (public domain): every input bit reaches every output bit. */
static uint64_t mix(uint64_t x)
{
    x ^= x >> 33;
    x *= 0xff51afd7ed558ccdull;
    x ^= x >> 33;
    x *= 0xc4ceb9fe1a85ec53ull;
    x ^= x >> 33;
    return x;
}

/* An empty table of a power of two entries, at most half full with count keys. */
static uint32_t *table_create(pnb_context *context, size_t count, size_t *out_mask)
{
    size_t size = 16;
    while (size < count * 2)
        size *= 2;
    uint32_t *table = memory_alloc(context, size, sizeof(*table));
    if (table)
        memset(table, 0xff, size * sizeof(*table));
    *out_mask = size - 1;
    return table;
}

/* The bits of a position, -0 made 0. */
static void position_key(const float *p, uint32_t key[3])
{
    for (int c = 0; c < 3; c++) {
        float value = p[c] + 0.0f;
        memcpy(&key[c], &value, sizeof(value));
    }
}

static pnb_status weld(pnb_context *context, const struct mesh *mesh, struct mesh_edges *edges)
{
    size_t mask;
    uint32_t *table = table_create(context, mesh->vertex_count, &mask);
    edges->welded = memory_alloc(context, mesh->vertex_count, sizeof(uint32_t));
    edges->welded_vertex = memory_alloc(context, mesh->vertex_count, sizeof(uint32_t));
    if (!table || !edges->welded || !edges->welded_vertex) {
        memory_free(context, table);
        return status_no_memory(context, mesh->vertex_count * 16);
    }
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        uint32_t key[3];
        position_key(mesh->positions + 3 * i, key);
        size_t slot = mix(mix((uint64_t)key[0] << 32 | key[1]) ^ key[2]) & mask;
        for (; table[slot] != MESH_NONE; slot = (slot + 1) & mask) {
            uint32_t other[3];
            position_key(mesh->positions + 3 * (size_t)edges->welded_vertex[table[slot]], other);
            if (memcmp(key, other, sizeof(key)) == 0)
                break;
        }
        if (table[slot] == MESH_NONE) {
            table[slot] = edges->welded_count;
            edges->welded_vertex[edges->welded_count++] = (uint32_t)i;
        }
        edges->welded[i] = table[slot];
    }
    memory_free(context, table);
    return PNB_OK;
}

/* Finds the edge of each corner (from it to the next corner), MESH_NONE where both ends coincide.
 */
static pnb_status find_edges(pnb_context *context, const struct mesh *mesh,
                             struct mesh_edges *edges, uint32_t *edge_of_corner)
{
    size_t corners = mesh->triangle_count * 3, mask, capacity = 0;
    uint32_t *table = table_create(context, corners, &mask);
    if (!table)
        return status_no_memory(context, corners * 8);
    for (size_t i = 0; i < corners; i++) {
        size_t next = i % 3 == 2 ? i - 2 : i + 1;
        uint32_t a = edges->welded[mesh->indices[i]], b = edges->welded[mesh->indices[next]];
        edge_of_corner[i] = MESH_NONE;
        if (a == b)
            continue;
        uint32_t low = a < b ? a : b, high = a < b ? b : a;
        size_t slot = mix((uint64_t)low << 32 | high) & mask;
        for (; table[slot] != MESH_NONE; slot = (slot + 1) & mask) {
            const struct mesh_edge *edge = &edges->edges[table[slot]];
            if (edge->vertex[0] == low && edge->vertex[1] == high)
                break;
        }
        if (table[slot] == MESH_NONE) {
            if (!memory_reserve(context, (void **)&edges->edges, &capacity, edges->edge_count, 1,
                                sizeof(*edges->edges))) {
                memory_free(context, table);
                return status_no_memory(context, edges->edge_count * sizeof(*edges->edges));
            }
            edges->edges[edges->edge_count] = (struct mesh_edge){{low, high}, 0, 0};
            table[slot] = (uint32_t)edges->edge_count++;
        }
        edge_of_corner[i] = table[slot];
        edges->edges[table[slot]].use_count++;
        edges->use_count++;
    }
    memory_free(context, table);
    return PNB_OK;
}

/* Directions of an edge along which more than one triangle runs: 0, 1 or 2. A consistently oriented
 * surface has none; an edge with two sheets through it that agree among themselves has two. */
static size_t clashes(const uint32_t *uses, size_t count)
{
    size_t reversed = 0;
    for (size_t i = 0; i < count; i++)
        reversed += uses[i] & 1;
    return (reversed > 1) + (count - reversed > 1);
}

/* Lists the uses of each edge by triangle, and counts what is wrong with it. */
static pnb_status list_uses(pnb_context *context, const struct mesh *mesh, struct mesh_edges *edges,
                            const uint32_t *edge_of_corner)
{
    edges->uses = memory_alloc(context, edges->use_count, sizeof(uint32_t));
    if (!edges->uses)
        return status_no_memory(context, edges->use_count * sizeof(uint32_t));
    uint32_t first = 0;
    for (size_t i = 0; i < edges->edge_count; i++) {
        edges->edges[i].first_use = first;
        first += edges->edges[i].use_count;
        edges->edges[i].use_count = 0;
    }
    for (size_t i = 0; i < mesh->triangle_count * 3; i++) {
        if (edge_of_corner[i] == MESH_NONE)
            continue;
        struct mesh_edge *edge = &edges->edges[edge_of_corner[i]];
        bool reversed = edges->welded[mesh->indices[i]] != edge->vertex[0];
        edges->uses[edge->first_use + edge->use_count++] = (uint32_t)(i / 3) * 2 + reversed;
    }
    for (size_t i = 0; i < edges->edge_count; i++) {
        const struct mesh_edge *edge = &edges->edges[i];
        const uint32_t *uses = edges->uses + edge->first_use;
        edges->open_count += edge->use_count == 1;
        edges->non_manifold_count += edge->use_count > 2;
        edges->inconsistent_count += clashes(uses, edge->use_count);
    }
    return PNB_OK;
}

/* Zero area: the cross product of two sides is zero or below what rounding of the float corners
 * leaves of it. */
static bool triangle_degenerate(const struct mesh *mesh, const struct mesh_edges *edges, size_t t)
{
    const uint32_t *index = mesh->indices + 3 * t;
    uint32_t a = edges->welded[index[0]], b = edges->welded[index[1]], c = edges->welded[index[2]];
    if (a == b || b == c || c == a)
        return true;
    vec3 p = v3_loadf(mesh->positions + 3 * (size_t)index[0]);
    vec3 u = v3_sub(v3_loadf(mesh->positions + 3 * (size_t)index[1]), p);
    vec3 v = v3_sub(v3_loadf(mesh->positions + 3 * (size_t)index[2]), p);
    /* Scaled, so that neither tiny nor huge triangles leave the range of doubles. */
    double size = fmax(v3_max_abs(u), v3_max_abs(v));
    u = v3_scale(u, 1 / size);
    v = v3_scale(v, 1 / size);
    return !(v3_max_abs(v3_cross(u, v)) > 1e-15);
}

static void edges_free(pnb_context *context, struct mesh_edges *edges)
{
    memory_free(context, edges->welded);
    memory_free(context, edges->welded_vertex);
    memory_free(context, edges->edges);
    memory_free(context, edges->uses);
    memory_free(context, edges);
}

pnb_status mesh_get_edges(pnb_context *context, struct mesh *mesh,
                          const struct mesh_edges **out_edges)
{
    *out_edges = mesh->edges;
    if (mesh->edges)
        return PNB_OK;
    struct mesh_edges *edges = memory_calloc(context, 1, sizeof(*edges));
    uint32_t *edge_of_corner = memory_alloc(context, mesh->triangle_count * 3, sizeof(uint32_t));
    pnb_status status = PNB_OK;
    if (!edges || !edge_of_corner)
        status = status_no_memory(context, mesh->triangle_count * 3 * sizeof(uint32_t));
    if (status == PNB_OK)
        status = weld(context, mesh, edges);
    if (status == PNB_OK)
        status = find_edges(context, mesh, edges, edge_of_corner);
    if (status == PNB_OK)
        status = list_uses(context, mesh, edges, edge_of_corner);
    memory_free(context, edge_of_corner);
    if (status != PNB_OK) {
        if (edges)
            edges_free(context, edges);
        return status;
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        edges->degenerate_triangle_count += triangle_degenerate(mesh, edges, t);
    mesh->edges = edges;
    *out_edges = edges;
    return PNB_OK;
}

const char *mesh_edges_validate(const struct mesh *mesh, const struct mesh_edges *edges)
{
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        uint32_t w = edges->welded[i];
        if (w >= edges->welded_count)
            return "a vertex is welded to none";
        const float *p = mesh->positions + 3 * i;
        const float *q = mesh->positions + 3 * (size_t)edges->welded_vertex[w];
        if (p[0] != q[0] || p[1] != q[1] || p[2] != q[2])
            return "a vertex is welded to one at another position";
    }
    size_t expected = 0;
    for (size_t i = 0; i < mesh->triangle_count * 3; i++) {
        size_t next = i % 3 == 2 ? i - 2 : i + 1;
        expected += edges->welded[mesh->indices[i]] != edges->welded[mesh->indices[next]];
    }
    if (expected != edges->use_count)
        return "uses were lost or made up";
    size_t first = 0, open = 0, many = 0, clash = 0;
    for (size_t i = 0; i < edges->edge_count; i++) {
        const struct mesh_edge *edge = &edges->edges[i];
        if (edge->vertex[0] >= edge->vertex[1] || edge->vertex[1] >= edges->welded_count)
            return "an edge's vertices are not in order";
        if (edge->first_use != first || edge->use_count < 1)
            return "the uses of the edges do not follow one another";
        first += edge->use_count;
        const uint32_t *uses = edges->uses + edge->first_use;
        for (uint32_t k = 0; k < edge->use_count; k++) {
            size_t triangle = uses[k] >> 1;
            if (triangle >= mesh->triangle_count)
                return "a use names a triangle that does not exist";
            if (k > 0 && uses[k] >> 1 < uses[k - 1] >> 1)
                return "the uses of an edge are not sorted by triangle";
            uint32_t from = edge->vertex[uses[k] & 1], to = edge->vertex[!(uses[k] & 1)];
            bool found = false;
            for (int c = 0; c < 3; c++)
                found = found ||
                        (edges->welded[mesh->indices[3 * triangle + (size_t)c]] == from &&
                         edges->welded[mesh->indices[3 * triangle + (size_t)(c + 1) % 3]] == to);
            if (!found)
                return "a use names a triangle without that edge";
        }
        open += edge->use_count == 1;
        many += edge->use_count > 2;
        clash += clashes(uses, edge->use_count);
    }
    if (first != edges->use_count)
        return "the uses of the edges do not add up";
    if (open != edges->open_count || many != edges->non_manifold_count ||
        clash != edges->inconsistent_count)
        return "the counts are wrong";
    return NULL;
}
