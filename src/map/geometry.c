/* map/geometry.c: the scene's triangles as the maps want them: one run in world space.
 *
 * Casters come first, then floors, then what casts no shadow. A floor is a flat caster that has all
 * other objects on one side of its plane (to FLOOR_TOLERANCE of the scene's size): the ground, the
 * walls of a room. Seen from that side it is a receiver only, and it is large: leaving it out of
 * what maps must cover brings their texels to where the shadows are cast.
 *
 * Cost: O(vertices) and, for each of at most MAP_FLOORS_MOST flat objects, O(vertices) again, once
 * per mesh or placement. Memory: 12 bytes a vertex, 12 a triangle.
 */
#include <string.h>

#include "map/map.h"

#define FLOOR_TOLERANCE 1e-6

struct piece {
    size_t object, first_vertex, vertex_count, triangle_count;
    int kind; /* 0 caster, 1 floor, 2 passive */
    vec3 normal;
    double offset;
};

/* The plane of a flat object; false if it is none. */
static bool flat(const struct map_geometry *g, const uint32_t *indices, struct piece *piece,
                 double tolerance)
{
    vec3 normal = v3(0, 0, 0), base = v3(0, 0, 0);
    double best = 0;
    for (size_t t = 0; t < piece->triangle_count; t++) {
        vec3 c[3];
        for (int k = 0; k < 3; k++)
            c[k] = v3_loadf(g->positions + 3 * (piece->first_vertex + indices[3 * t + k]));
        vec3 n = v3_cross(v3_sub(c[1], c[0]), v3_sub(c[2], c[0]));
        if (v3_length(n) > best) {
            best = v3_length(n);
            normal = n;
            base = c[0];
        }
    }
    if (!(best > 0))
        return false;
    piece->normal = v3_normalize(normal);
    piece->offset = v3_dot(piece->normal, base);
    for (size_t i = 0; i < piece->vertex_count; i++) {
        vec3 p = v3_loadf(g->positions + 3 * (piece->first_vertex + i));
        if (fabs(v3_dot(piece->normal, p) - piece->offset) > tolerance)
            return false;
    }
    return true;
}

/* Turns the plane towards the rest of the scene; false if that lies on both sides. */
static bool is_floor(const struct map_geometry *g, struct piece *piece, double tolerance)
{
    bool above = true, below = true;
    for (size_t i = 0; i < g->vertex_count && (above || below); i++) {
        if (i == piece->first_vertex)
            i += piece->vertex_count;
        if (i >= g->vertex_count)
            break;
        double h = v3_dot(piece->normal, v3_loadf(g->positions + 3 * i)) - piece->offset;
        above = above && h > -tolerance;
        below = below && h < tolerance;
    }
    if (!above && below) {
        piece->normal = v3_scale(piece->normal, -1);
        piece->offset = -piece->offset;
    }
    return above != below;
}

static pnb_status gather(pnb_scene *scene, struct map_geometry *g, struct piece *pieces)
{
    pnb_context *context = g->context;
    size_t count = scene->object_count, vertices = 0, triangles = 0;
    for (size_t i = 0; i < count; i++) {
        const struct mesh *mesh = &scene->meshes[scene->objects[i].info.mesh];
        pieces[i] = (struct piece){.object = i, .first_vertex = vertices};
        pieces[i].kind = scene->objects[i].info.casts ? 0 : 2;
        pieces[i].triangle_count = mesh->triangle_count;
        pieces[i].vertex_count = mesh->triangle_count ? mesh->vertex_count : 0;
        vertices += pieces[i].vertex_count;
        triangles += pieces[i].triangle_count;
    }
    if (vertices > UINT32_MAX || triangles > INT32_MAX)
        return status_fail(context, PNB_ERROR_UNSUPPORTED, scene->name,
                           "more triangles than depth maps count");
    g->positions = memory_alloc(context, vertices * 3, sizeof(float));
    g->indices = memory_alloc(context, triangles * 3, sizeof(uint32_t));
    g->floors = memory_calloc(context, MAP_FLOORS_MOST, sizeof(*g->floors));
    if (!g->positions || !g->indices || !g->floors)
        return status_no_memory(context, (vertices + triangles) * 12);
    g->vertex_count = vertices;
    g->triangle_count = triangles;
    g->low = v3(INFINITY, INFINITY, INFINITY);
    g->high = v3_scale(g->low, -1);
    for (size_t i = 0; i < count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        const struct mesh *mesh = &scene->meshes[object->mesh];
        for (size_t k = 0; k < pieces[i].vertex_count; k++) {
            vec3 p = m34_point(object->world_from_mesh, v3_loadf(mesh->positions + 3 * k));
            v3_storef(g->positions + 3 * (pieces[i].first_vertex + k), p);
            g->low = v3_min(g->low, p);
            g->high = v3_max(g->high, p);
        }
    }
    return PNB_OK;
}

static void sort_pieces(pnb_scene *scene, struct map_geometry *g, struct piece *pieces)
{
    double size = fmax(v3_max_abs(g->low), v3_max_abs(g->high));
    size_t flats = 0, next = 0;
    for (size_t i = 0; i < scene->object_count; i++) {
        const struct mesh *mesh = &scene->meshes[scene->objects[i].info.mesh];
        if (pieces[i].kind != 0 || flats == MAP_FLOORS_MOST || pieces[i].triangle_count == 0 ||
            !flat(g, mesh->indices, &pieces[i], FLOOR_TOLERANCE * size))
            continue;
        flats++;
        if (is_floor(g, &pieces[i], FLOOR_TOLERANCE * size))
            pieces[i].kind = 1;
    }
    for (int kind = 0; kind < 3; kind++) {
        if (kind == 1)
            g->caster_count = next;
        if (kind == 2)
            g->passive_first = next;
        for (size_t i = 0; i < scene->object_count; i++) {
            const struct mesh *mesh = &scene->meshes[scene->objects[i].info.mesh];
            if (pieces[i].kind != kind)
                continue;
            if (kind == 1)
                g->floors[g->floor_count++] = (struct map_floor){pieces[i].normal, pieces[i].offset,
                                                                 next, pieces[i].triangle_count};
            for (size_t k = 0; k < 3 * pieces[i].triangle_count; k++)
                g->indices[3 * next + k] = mesh->indices[k] + (uint32_t)pieces[i].first_vertex;
            next += pieces[i].triangle_count;
        }
    }
}

pnb_status map_geometry_create(pnb_scene *scene, struct map_geometry **out_geometry)
{
    pnb_context *context = scene->context;
    *out_geometry = NULL;
    struct map_geometry *g = memory_calloc(context, 1, sizeof(*g));
    struct piece *pieces = memory_calloc(context, scene->object_count, sizeof(*pieces));
    pnb_status status = PNB_OK;
    if (g)
        g->context = context;
    if (!g || !pieces) {
        status = status_no_memory(context, scene->object_count * sizeof(*pieces));
    } else {
        g->lift = scene_receiver_lift(scene);
        status = gather(scene, g, pieces);
        if (status == PNB_OK)
            sort_pieces(scene, g, pieces);
    }
    memory_free(context, pieces);
    if (status != PNB_OK) {
        map_geometry_destroy(g);
        return status;
    }
    *out_geometry = g;
    return PNB_OK;
}

void map_geometry_destroy(struct map_geometry *g)
{
    if (!g)
        return;
    pnb_context *context = g->context;
    memory_free(context, g->positions);
    memory_free(context, g->indices);
    memory_free(context, g->floors);
    memory_free(context, g);
}

pnb_status map_geometry_update(pnb_scene *scene, struct map_geometry **geometry)
{
    struct map_geometry *made;
    pnb_status status = map_geometry_create(scene, &made);
    if (status != PNB_OK)
        return status;
    map_geometry_destroy(*geometry);
    *geometry = made;
    return PNB_OK;
}
