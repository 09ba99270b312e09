/* method/wedge/parts.c: the occluders as connected parts, and each part's edges and faces as items
 * for the device.
 *
 * A part is a set of triangles joined by vertices: what the paper calls an occluder with its
 * silhouette. An object of many pieces (a fence, a tree of leaves) is many parts, so that their
 * penumbrae are blended and not added.
 *
 * Within a part, edges and faces are sorted along a Morton curve, so that the 32 items of a group
 * lie close together and can be rejected by one box. Parts of few items (leaves, pickets) share
 * groups, sorted along a curve themselves; a part never stands in two of these. O(n log n) once per
 * mesh; 80 bytes an item.
 *
 * A part whose box reaches through the light's plane gets its faces as edge items besides: each is
 * the line along which the plane cuts it, so that the outline stays closed. Which parts these are
 * is looked up for each frame, O(parts); only a change packs anew.
 */
#include <stdlib.h>
#include <string.h>

#include "method/wedge/wedge.h"

struct keyed {
    uint64_t key; /* part in the high half, place on the Morton curve in the low one */
    uint32_t index;
};

static int by_key(const void *x, const void *y)
{
    const struct keyed *a = x, *b = y;
    if (a->key != b->key)
        return a->key < b->key ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

static uint32_t spread(uint32_t x)
{
    x &= 0x3ff;
    x = (x | x << 16) & 0x30000ffu;
    x = (x | x << 8) & 0x300f00fu;
    x = (x | x << 4) & 0x30c30c3u;
    return (x | x << 2) & 0x9249249u;
}

static uint32_t morton(vec3 p, vec3 low, vec3 high)
{
    vec3 d = v3_sub(high, low);
    uint32_t x = (uint32_t)(d.x > 0 ? fmin(1023, (p.x - low.x) / d.x * 1024) : 0);
    uint32_t y = (uint32_t)(d.y > 0 ? fmin(1023, (p.y - low.y) / d.y * 1024) : 0);
    uint32_t z = (uint32_t)(d.z > 0 ? fmin(1023, (p.z - low.z) / d.z * 1024) : 0);
    return spread(x) | spread(y) << 1 | spread(z) << 2;
}

static uint32_t root(uint32_t *parent, uint32_t i)
{
    while (parent[i] != i) {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    return i;
}

static vec3 vertex(const struct gl_occluders *o, uint32_t i)
{
    return v3_loadf(o->positions + 3 * (size_t)i);
}

/* The part of each vertex; counts the parts. Vertices without a triangle belong to none. */
static pnb_status find_parts(const struct gl_occluders *o, uint32_t *part_of_vertex,
                             size_t *out_count)
{
    uint32_t *parent = memory_alloc(o->context, o->vertex_count, sizeof(*parent));
    if (!parent)
        return status_no_memory(o->context, o->vertex_count * sizeof(*parent));
    for (size_t i = 0; i < o->vertex_count; i++) {
        parent[i] = (uint32_t)i;
        part_of_vertex[i] = MESH_NONE;
    }
    for (size_t t = 0; t < o->triangle_count; t++)
        for (size_t k = 1; k < 3; k++) {
            uint32_t a = root(parent, o->indices[3 * t]), b = root(parent, o->indices[3 * t + k]);
            parent[a > b ? a : b] = a > b ? b : a;
        }
    size_t count = 0;
    for (size_t i = 0; i < 3 * o->triangle_count; i++) {
        uint32_t r = root(parent, o->indices[i]);
        if (part_of_vertex[r] == MESH_NONE)
            part_of_vertex[r] = (uint32_t)count++;
    }
    for (size_t i = 0; i < o->vertex_count; i++)
        part_of_vertex[i] = part_of_vertex[root(parent, (uint32_t)i)];
    memory_free(o->context, parent);
    *out_count = count;
    return PNB_OK;
}

static void sort_out(struct keyed *keyed, size_t count, uint32_t *out)
{
    qsort(keyed, count, sizeof(*keyed), by_key);
    for (size_t i = 0; i < count; i++)
        out[i] = keyed[i].index;
}

static void put(float *to, const struct gl_occluders *o, uint32_t i)
{
    memcpy(to, o->positions + 3 * (size_t)i, 3 * sizeof(float));
}

/* A face of no area has no plane and no side: all its edges take it for seen from its front, so
 * that what they add is closed. (All zero would say that there is no face.) */
static void put_plane(float *to, const struct gl_occluders *o, uint32_t face, float sign)
{
    const float *plane = o->planes + 4 * (size_t)face;
    bool none = plane[0] == 0 && plane[1] == 0 && plane[2] == 0;
    for (int i = 0; i < 4; i++)
        to[i] = sign * (none ? (float)(i == 3) : plane[i]);
}

static struct wedge_item edge_item(const struct gl_occluders *o, uint32_t e, bool closed)
{
    const struct gl_edge *edge = &o->edges[e];
    struct wedge_item item = {.kind = WEDGE_ITEM_EDGE, .sign = 1, .k = closed ? 0.5f : 1};
    bool swap = edge->a > edge->b;
    put(item.a, o, swap ? edge->b : edge->a);
    put(item.b, o, swap ? edge->a : edge->b);
    item.sign = swap ? -1 : 1;
    put_plane(item.first, o, edge->first, 1);
    if (edge->second != MESH_NONE)
        put_plane(item.second, o, edge->second, edge->same_way ? -1 : 1);
    return item;
}

static struct wedge_item face_item(const struct gl_occluders *o, uint32_t f, bool closed)
{
    uint32_t v[3];
    memcpy(v, o->indices + 3 * (size_t)f, sizeof(v));
    struct wedge_item item = {.kind = WEDGE_ITEM_FACE, .sign = 1, .k = closed ? 0.5f : 1};
    static const int steps[3] = {0, 1, 0}; /* bubble sort; each swap turns the face */
    for (int s = 0; s < 3; s++) {
        uint32_t *pair = v + steps[s];
        if (pair[0] > pair[1]) {
            uint32_t t = pair[0];
            pair[0] = pair[1];
            pair[1] = t;
            item.sign = -item.sign;
        }
    }
    put(item.a, o, v[0]);
    put(item.b, o, v[1]);
    put(item.c, o, v[2]);
    put_plane(item.first, o, f, 1);
    return item;
}

/* Parts of so few items that one group holds them, even if the light's plane cuts them. */
static bool is_small(const struct wedge_part *part)
{
    return part->edge_count + 2 * part->face_count <= WEDGE_GROUP;
}

static size_t round_up(size_t count)
{
    return (count + WEDGE_GROUP - 1) / WEDGE_GROUP * WEDGE_GROUP;
}

/* Where each part's items stand; returns how many there are, rounded up to whole groups. */
static size_t lay_out(struct wedge_parts *parts)
{
    size_t at = 0;
    for (size_t i = 0; i < parts->part_count; i++) {
        struct wedge_part *part = &parts->parts[i];
        size_t edges = part->edge_count + (part->cut ? part->face_count : 0);
        bool small = is_small(part);
        if (!small || at % WEDGE_GROUP + edges + part->face_count > WEDGE_GROUP)
            at = round_up(at);
        part->first_item = at;
        part->first_face_item = at + (small ? edges : round_up(edges));
        at = part->first_face_item + part->face_count;
        if (!small)
            at = round_up(at);
        part->item_count = at - part->first_item;
    }
    return round_up(at);
}

static void describe_groups(const struct wedge_parts *parts, struct wedge_group *groups)
{
    uint32_t last = MESH_NONE;
    for (size_t i = 0; i < parts->part_count; i++) {
        const struct wedge_part *part = &parts->parts[i];
        for (size_t k = part->first_item; k < part->first_item + part->item_count; k++) {
            struct wedge_group *group = &groups[k / WEDGE_GROUP];
            uint32_t bit = 1u << k % WEDGE_GROUP;
            if (bit == 1) {
                group->part = (uint32_t)i;
                group->kind = is_small(part)               ? WEDGE_GROUP_MIXED
                              : k >= part->first_face_item ? WEDGE_GROUP_FACES
                                                           : WEDGE_GROUP_EDGES;
            } else if (last != i) {
                group->starts |= bit;
            }
            group->faces |= k >= part->first_face_item ? bit : 0;
            last = (uint32_t)i;
        }
    }
}

static void fill(const struct wedge_parts *parts, struct wedge_item *items)
{
    for (size_t i = 0; i < parts->part_count; i++) {
        const struct wedge_part *part = &parts->parts[i];
        struct wedge_item *e = items + part->first_item, *f = items + part->first_face_item;
        for (size_t k = 0; k < part->edge_count; k++)
            *e++ = edge_item(parts->occluders, parts->edges[part->first_edge + k], part->closed);
        for (size_t k = 0; k < part->face_count; k++) {
            f[k] = face_item(parts->occluders, parts->faces[part->first_face + k], part->closed);
            if (part->cut) {
                *e = f[k];
                e++->kind = WEDGE_ITEM_CUT;
            }
        }
    }
}

static pnb_status pack(struct wedge_parts *parts)
{
    pnb_context *context = parts->context;
    size_t count = lay_out(parts);
    parts->packed = false;
    struct wedge_item *items = memory_calloc(context, count, sizeof(*items));
    struct wedge_group *groups = memory_calloc(context, count / WEDGE_GROUP, sizeof(*groups));
    if (!items || !groups) {
        memory_free(context, items);
        memory_free(context, groups);
        return status_no_memory(context, count * sizeof(*items));
    }
    describe_groups(parts, groups);
    fill(parts, items);
    memory_free(context, parts->items);
    memory_free(context, parts->groups);
    parts->items = items;
    parts->groups = groups;
    parts->group_count = count / WEDGE_GROUP;
    parts->packed = true;
    return PNB_OK;
}

/* Boxes and counts of the parts. */
static void measure(struct wedge_parts *parts, const uint32_t *part_of_vertex)
{
    const struct gl_occluders *o = parts->occluders;
    for (size_t i = 0; i < parts->part_count; i++)
        parts->parts[i] = (struct wedge_part){.closed = true,
                                              .low = v3(INFINITY, INFINITY, INFINITY),
                                              .high = v3(-INFINITY, -INFINITY, -INFINITY)};
    for (size_t t = 0; t < o->triangle_count; t++) {
        struct wedge_part *part = &parts->parts[part_of_vertex[o->indices[3 * t]]];
        for (size_t k = 0; k < 3; k++) {
            vec3 p = vertex(o, o->indices[3 * t + k]);
            part->low = v3_min(part->low, p);
            part->high = v3_max(part->high, p);
        }
        part->face_count++;
    }
    for (size_t e = 0; e < o->edge_count; e++) {
        const struct gl_edge *edge = &o->edges[e];
        struct wedge_part *part = &parts->parts[part_of_vertex[edge->a]];
        part->closed = part->closed && edge->second != MESH_NONE && !edge->same_way;
        part->edge_count++;
    }
}

/* Numbers the parts anew: large ones first, then small ones along a curve. */
static pnb_status order_parts(struct wedge_parts *parts, uint32_t *part_of_vertex)
{
    const struct gl_occluders *o = parts->occluders;
    struct keyed *keyed = memory_alloc(parts->context, parts->part_count, sizeof(*keyed));
    uint32_t *number = memory_alloc(parts->context, parts->part_count, sizeof(*number));
    pnb_status status = keyed && number
                            ? PNB_OK
                            : status_no_memory(parts->context, parts->part_count * sizeof(*keyed));
    for (size_t i = 0; i < parts->part_count && status == PNB_OK; i++) {
        const struct wedge_part *part = &parts->parts[i];
        vec3 middle = v3_scale(v3_add(part->low, part->high), 0.5);
        uint64_t key = 1 + (uint64_t)morton(middle, o->scene_low, o->scene_high);
        keyed[i] = (struct keyed){is_small(part) ? key : 0, (uint32_t)i};
    }
    if (status == PNB_OK) {
        qsort(keyed, parts->part_count, sizeof(*keyed), by_key);
        for (size_t i = 0; i < parts->part_count; i++)
            number[keyed[i].index] = (uint32_t)i;
        for (size_t i = 0; i < o->vertex_count; i++)
            if (part_of_vertex[i] != MESH_NONE)
                part_of_vertex[i] = number[part_of_vertex[i]];
    }
    memory_free(parts->context, keyed);
    memory_free(parts->context, number);
    return status;
}

/* Boxes, then edges and faces sorted part by part. */
static pnb_status gather(struct wedge_parts *parts, uint32_t *part_of_vertex)
{
    const struct gl_occluders *o = parts->occluders;
    measure(parts, part_of_vertex);
    pnb_status status = order_parts(parts, part_of_vertex);
    if (status != PNB_OK)
        return status;
    measure(parts, part_of_vertex);
    size_t most = o->edge_count > o->triangle_count ? o->edge_count : o->triangle_count;
    struct keyed *keyed = memory_alloc(parts->context, most, sizeof(*keyed));
    if (!keyed)
        return status_no_memory(parts->context, most * sizeof(*keyed));
    for (size_t e = 0; e < o->edge_count; e++) {
        const struct gl_edge *edge = &o->edges[e];
        uint32_t p = part_of_vertex[edge->a];
        const struct wedge_part *part = &parts->parts[p];
        vec3 middle = v3_scale(v3_add(vertex(o, edge->a), vertex(o, edge->b)), 0.5);
        keyed[e] =
            (struct keyed){(uint64_t)p << 32 | morton(middle, part->low, part->high), (uint32_t)e};
    }
    sort_out(keyed, o->edge_count, parts->edges);
    for (size_t t = 0; t < o->triangle_count; t++) {
        uint32_t p = part_of_vertex[o->indices[3 * t]];
        vec3 middle = v3(0, 0, 0);
        for (size_t k = 0; k < 3; k++)
            middle = v3_mad(middle, vertex(o, o->indices[3 * t + k]), 1.0 / 3);
        keyed[t] = (struct keyed){(uint64_t)p << 32 |
                                      morton(middle, parts->parts[p].low, parts->parts[p].high),
                                  (uint32_t)t};
    }
    sort_out(keyed, o->triangle_count, parts->faces);
    memory_free(parts->context, keyed);
    size_t edges = 0, faces = 0;
    for (size_t i = 0; i < parts->part_count; i++) {
        struct wedge_part *part = &parts->parts[i];
        part->first_edge = edges;
        part->first_face = faces;
        edges += part->edge_count;
        faces += part->face_count;
    }
    return PNB_OK;
}

/* Edges that want a partner, of objects that are not a scene's planes. */
static size_t count_open(pnb_scene *scene, const struct gl_occluders *o)
{
    size_t count = 0;
    for (size_t i = 0; i < o->object_count; i++) {
        const struct gl_occluder *object = &o->objects[i];
        if (scene->objects[object->object].info.plane)
            continue;
        for (size_t e = 0; e < object->edge_count; e++) {
            const struct gl_edge *edge = &o->edges[object->first_edge + e];
            count += edge->second == MESH_NONE || edge->same_way;
        }
    }
    return count;
}

pnb_status wedge_parts_create(pnb_scene *scene, const struct gl_occluders *o,
                              struct wedge_parts **out_parts)
{
    pnb_context *context = o->context;
    *out_parts = NULL;
    struct wedge_parts *parts = memory_calloc(context, 1, sizeof(*parts));
    uint32_t *part_of_vertex = memory_alloc(context, o->vertex_count, sizeof(*part_of_vertex));
    pnb_status status = PNB_OK;
    if (!parts || !part_of_vertex)
        status = status_no_memory(context, o->vertex_count * sizeof(*part_of_vertex));
    if (parts)
        parts->context = context;
    if (status == PNB_OK) {
        parts->occluders = o;
        parts->open_count = count_open(scene, o);
        status = find_parts(o, part_of_vertex, &parts->part_count);
    }
    if (status == PNB_OK) {
        parts->parts = memory_alloc(context, parts->part_count, sizeof(*parts->parts));
        parts->faces = memory_alloc(context, o->triangle_count, sizeof(*parts->faces));
        parts->edges = memory_alloc(context, o->edge_count, sizeof(*parts->edges));
        if (!parts->parts || !parts->faces || !parts->edges)
            status = status_no_memory(context, o->triangle_count * sizeof(*parts->faces));
    }
    if (status == PNB_OK)
        status = gather(parts, part_of_vertex);
    if (status == PNB_OK)
        status = pack(parts);
    memory_free(context, part_of_vertex);
    if (status != PNB_OK) {
        wedge_parts_destroy(parts);
        return status;
    }
    *out_parts = parts;
    return PNB_OK;
}

void wedge_parts_destroy(struct wedge_parts *parts)
{
    if (!parts)
        return;
    pnb_context *context = parts->context;
    memory_free(context, parts->parts);
    memory_free(context, parts->faces);
    memory_free(context, parts->edges);
    memory_free(context, parts->items);
    memory_free(context, parts->groups);
    memory_free(context, parts);
}

pnb_status wedge_parts_cut(struct wedge_parts *parts, const struct wedge_light *light,
                           bool *out_changed)
{
    *out_changed = !parts->packed;
    vec3 n = light->normal;
    for (size_t i = 0; i < parts->part_count; i++) {
        struct wedge_part *part = &parts->parts[i];
        vec3 middle = v3_scale(v3_add(part->low, part->high), 0.5);
        vec3 half = v3_scale(v3_sub(part->high, part->low), 0.5);
        double z = v3_dot(n, v3_sub(middle, light->center)) - light->gap;
        double reach = fabs(n.x) * half.x + fabs(n.y) * half.y + fabs(n.z) * half.z;
        /* A whisker more than rounding may add. */
        bool cut = fabs(z) <= reach + light->gap;
        *out_changed = *out_changed || cut != part->cut;
        part->cut = cut;
    }
    return *out_changed ? pack(parts) : PNB_OK;
}
