/* import/weld.c: the reader gives many formats three vertices of their own per triangle; this finds
 * those that agree in position and normal again. Open addressing over the bits of the coordinates
 * (-0 counts as 0; NaNs meet where their bits agree), half full at most. O(n) time; a table of at
 * most 4 bytes x 4 per index. */
#include "import/import.h"

#include <string.h>

struct key {
    uint32_t bits[6];
};

static struct key vertex_key(const float *positions, const float *normals, size_t vertex)
{
    struct key key = {{0}};
    float values[6] = {0};
    for (int c = 0; c < 3; c++) {
        values[c] = positions[3 * vertex + (size_t)c] + 0.0f;
        if (normals)
            values[3 + c] = normals[3 * vertex + (size_t)c] + 0.0f;
    }
    memcpy(key.bits, values, sizeof(values));
    return key;
}

static uint64_t key_hash(const struct key *key)
{
    uint64_t h = 0x9e3779b97f4a7c15u;
    for (int i = 0; i < 6; i++) {
        h = (h ^ key->bits[i]) * 0xff51afd7ed558ccdu;
        h ^= h >> 32;
    }
    return h;
}

size_t weld_vertices(const float *positions, const float *normals, size_t vertex_count,
                     uint32_t *indices, size_t index_count, float *out_positions,
                     float *out_normals)
{
    size_t distinct = vertex_count < index_count ? vertex_count : index_count;
    size_t table_size = 16;
    while (table_size < distinct * 2)
        table_size *= 2;
    uint32_t *table = import_alloc(table_size, sizeof(*table));       /* kept vertex + 1, 0: free */
    uint32_t *kept_of = import_alloc(vertex_count, sizeof(*kept_of)); /* the same, by vertex */
    size_t kept = 0;

    for (size_t i = 0; i < index_count; i++) {
        uint32_t vertex = indices[i];
        if (kept_of[vertex] == 0) {
            struct key key = vertex_key(positions, normals, vertex);
            size_t slot = key_hash(&key) & (table_size - 1);
            for (; table[slot] != 0; slot = (slot + 1) & (table_size - 1)) {
                struct key other =
                    vertex_key(out_positions, normals ? out_normals : NULL, table[slot] - 1);
                if (memcmp(&key, &other, sizeof(key)) == 0)
                    break;
            }
            if (table[slot] == 0) {
                memcpy(out_positions + 3 * kept, key.bits, 12);
                if (normals)
                    memcpy(out_normals + 3 * kept, key.bits + 3, 12);
                table[slot] = (uint32_t)++kept;
            }
            kept_of[vertex] = table[slot];
        }
        indices[i] = kept_of[vertex] - 1;
    }
    import_free(table);
    import_free(kept_of);
    return kept;
}
