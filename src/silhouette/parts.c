/* silhouette/parts.c: the connected parts of a mesh, each with clusters of its own.
 *
 * Triangles are joined by their welded vertices (union-find). Parts are numbered by their first
 * triangle. The first part that is no solid ends the work: most meshes of many parts (leaves,
 * soups) are found out by one small part.
 */
#include <string.h>

#include "silhouette/parts.h"

/* Parts at most, and triangles of a part: as clusters_find_solid() has it. */
#define PARTS_MOST    4096
#define PARTS_LARGEST 2048

struct splitter {
    pnb_context *context;
    struct mesh *mesh;
    const uint32_t *welded;
    uint32_t *root;   /* per welded vertex */
    uint32_t *number; /* per welded vertex that is a root: the part */
    uint32_t *start;  /* [count + 1]: triangles of a part in sorted */
    uint32_t *sorted; /* triangles */
    uint32_t *local;  /* per vertex: its number in its part */
    float *positions; /* of one part */
    uint32_t *indices;
};

static uint32_t find(uint32_t *root, uint32_t v)
{
    while (root[v] != v)
        v = root[v] = root[root[v]];
    return v;
}

/* Sorts triangles by parts; returns how many there are. */
static size_t sort_triangles(struct splitter *s, size_t welded_count)
{
    const struct mesh *mesh = s->mesh;
    for (size_t v = 0; v < welded_count; v++)
        s->root[v] = (uint32_t)v, s->number[v] = MESH_NONE;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        for (int i = 1; i < 3; i++) {
            uint32_t a = find(s->root, s->welded[mesh->indices[3 * t]]);
            uint32_t b = find(s->root, s->welded[mesh->indices[3 * t + (size_t)i]]);
            s->root[a > b ? a : b] = a > b ? b : a;
        }
    size_t count = 0;
    memset(s->start, 0, (mesh->triangle_count + 1) * sizeof(*s->start));
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *number = &s->number[find(s->root, s->welded[mesh->indices[3 * t]])];
        if (*number == MESH_NONE)
            *number = (uint32_t)count++;
        s->start[*number + 1]++;
    }
    for (size_t i = 0; i < count; i++)
        s->start[i + 1] += s->start[i];
    for (size_t t = mesh->triangle_count; t > 0; t--) {
        uint32_t part = s->number[find(s->root, s->welded[mesh->indices[3 * (t - 1)]])];
        s->sorted[--s->start[part + 1]] = (uint32_t)(t - 1);
    }
    /* Now start[i + 1] is where part i begins. */
    memmove(s->start, s->start + 1, count * sizeof(*s->start));
    s->start[count] = (uint32_t)mesh->triangle_count;
    return count;
}

/* Makes part i; *solid: whether it is one. */
static pnb_status make_part(struct splitter *s, struct parts *parts, size_t i, bool *solid)
{
    const struct mesh *mesh = s->mesh;
    size_t vertices = 0, triangles = s->start[i + 1] - s->start[i];
    uint32_t *vertex = parts->vertex + parts->first[i];
    for (size_t t = 0; t < triangles; t++)
        for (size_t k = 0; k < 3; k++) {
            uint32_t v = mesh->indices[3 * (size_t)s->sorted[s->start[i] + t] + k];
            if (s->local[v] == MESH_NONE) {
                memcpy(s->positions + 3 * vertices, mesh->positions + 3 * (size_t)v,
                       3 * sizeof(float));
                vertex[vertices] = v;
                s->local[v] = (uint32_t)vertices++;
            }
            s->indices[3 * t + k] = s->local[v];
        }
    parts->first[i + 1] = parts->first[i] + vertices;
    parts->largest = vertices > parts->largest ? vertices : parts->largest;
    pnb_mesh_desc desc = {mesh->name, s->positions, NULL, vertices, s->indices, triangles};
    struct mesh piece;
    pnb_status status = mesh_init(s->context, &piece, &desc);
    if (status != PNB_OK)
        return status;
    status = clusters_create(s->context, &piece, &parts->clusters[i]);
    mesh_finish(s->context, &piece);
    *solid = status == PNB_OK && parts->clusters[i]->solid;
    return status;
}

static pnb_status make_parts(struct splitter *s, size_t count, struct parts **out_parts)
{
    const struct mesh *mesh = s->mesh;
    struct parts *parts = memory_calloc(s->context, 1, sizeof(*parts));
    if (!parts)
        return status_no_memory(s->context, sizeof(*parts));
    parts->count = count;
    parts->mesh_vertex_count = mesh->vertex_count;
    parts->clusters = memory_calloc(s->context, count, sizeof(*parts->clusters));
    parts->first = memory_calloc(s->context, count + 1, sizeof(*parts->first));
    parts->vertex = memory_alloc(s->context, mesh->vertex_count, sizeof(*parts->vertex));
    pnb_status status = PNB_OK;
    if (!parts->clusters || !parts->first || !parts->vertex)
        status = status_no_memory(s->context, mesh->vertex_count * sizeof(*parts->vertex));
    bool solid = true;
    memset(s->local, 0xff, mesh->vertex_count * sizeof(*s->local));
    for (size_t i = 0; i < count && status == PNB_OK && solid; i++)
        status = make_part(s, parts, i, &solid);
    if (status != PNB_OK || !solid) {
        parts_destroy(s->context, parts);
        return status;
    }
    parts->bytes = sizeof(*parts) + count * (sizeof(*parts->clusters) + sizeof(*parts->first)) +
                   mesh->vertex_count * sizeof(*parts->vertex);
    for (size_t i = 0; i < count; i++)
        parts->bytes += parts->clusters[i]->bytes;
    *out_parts = parts;
    return PNB_OK;
}

pnb_status parts_create(pnb_context *context, struct mesh *mesh, struct parts **out_parts)
{
    *out_parts = NULL;
    const struct mesh_edges *edges;
    pnb_status status = mesh_get_edges(context, mesh, &edges);
    if (status != PNB_OK || edges->open_count > 0 || edges->non_manifold_count > 0 ||
        edges->degenerate_triangle_count > 0 || mesh->triangle_count < 8)
        return status;
    size_t triangles = mesh->triangle_count, vertices = mesh->vertex_count;
    struct splitter s = {
        .context = context,
        .mesh = mesh,
        .welded = edges->welded,
        .root = memory_alloc(context, edges->welded_count, sizeof(uint32_t)),
        .number = memory_alloc(context, edges->welded_count, sizeof(uint32_t)),
        .start = memory_alloc(context, triangles + 1, sizeof(uint32_t)),
        .sorted = memory_alloc(context, triangles, sizeof(uint32_t)),
        .local = memory_alloc(context, vertices, sizeof(uint32_t)),
        .positions = memory_alloc(context, vertices, 3 * sizeof(float)),
        .indices = memory_alloc(context, triangles, 3 * sizeof(uint32_t)),
    };
    if (!s.root || !s.number || !s.start || !s.sorted || !s.local || !s.positions || !s.indices) {
        status = status_no_memory(context, triangles * 20 + vertices * 16);
    } else {
        size_t count = sort_triangles(&s, edges->welded_count), largest = 0;
        for (size_t i = 0; i < count; i++)
            if (s.start[i + 1] - s.start[i] > largest)
                largest = s.start[i + 1] - s.start[i];
        if (count > 1 && count <= PARTS_MOST && largest <= PARTS_LARGEST)
            status = make_parts(&s, count, out_parts);
    }
    memory_free(context, s.root);
    memory_free(context, s.number);
    memory_free(context, s.start);
    memory_free(context, s.sorted);
    memory_free(context, s.local);
    memory_free(context, s.positions);
    memory_free(context, s.indices);
    return status;
}

void parts_destroy(pnb_context *context, struct parts *parts)
{
    if (!parts)
        return;
    for (size_t i = 0; i < parts->count && parts->clusters; i++)
        clusters_destroy(context, parts->clusters[i]);
    memory_free(context, parts->clusters);
    memory_free(context, parts->first);
    memory_free(context, parts->vertex);
    memory_free(context, parts);
}

pnb_status parts_refit(pnb_context *context, struct parts *parts, const struct mesh *mesh,
                       bool *out_torn)
{
    *out_torn = mesh->vertex_count != parts->mesh_vertex_count;
    float *positions = memory_alloc(context, parts->largest, 3 * sizeof(float));
    if (!positions)
        return status_no_memory(context, parts->largest * 3 * sizeof(float));
    for (size_t i = 0; i < parts->count && !*out_torn; i++) {
        struct mesh piece = {.positions = positions,
                             .vertex_count = parts->first[i + 1] - parts->first[i]};
        for (size_t v = 0; v < piece.vertex_count; v++)
            memcpy(positions + 3 * v,
                   mesh->positions + 3 * (size_t)parts->vertex[parts->first[i] + v],
                   3 * sizeof(float));
        *out_torn = !clusters_refit(parts->clusters[i], &piece);
    }
    memory_free(context, positions);
    return PNB_OK;
}
