/* scene/emissive.c: flat parts of an emissive object as lights.
 *
 *   triangles -> patches: grown over shared edges as long as the plane stays the first triangle's
 *             -> the patch's border, directed as its triangles run -> rectangle or polygon
 *
 * A patch with holes, or whose border touches itself, becomes one light per triangle, if they are
 * few. An object with more than a dozen different planes is taken as curved and gives no light but
 * a note. Lights shine along the front of their triangles. A double-sided material shines along
 * that side too, unless the rest of the scene lies behind it and nothing before it. The object
 * stays to be seen, but casts no shadow, nor is one cast on it: a lamp is not in its own way.
 *
 * World space, double precision. O(triangles) with the mesh's edge structure. Triangles without
 * area belong to no patch. */
#include <stdio.h>
#include <string.h>

#include "geom/tolerance.h"
#include "scene/import.h"

#define PLANES_MAX        12  /* more: a curved surface */
#define PATCHES_MAX       256 /* of one object */
#define LOOSE_TRIANGLES   32  /* of a patch that is no simple polygon */
#define SAME_PLANE_COSINE 0.9999

struct emitter {
    pnb_scene *scene;
    const struct mesh *mesh;
    const struct mesh_edges *edges;
    const pnb_object *object;
    double color[3];
    double side;      /* 1: along the triangles' front, -1: against it */
    double front;     /* -1 if the placement mirrors */
    double size;      /* of the object, for tolerances */
    uint32_t *patch;  /* per triangle; MESH_NONE: none */
    uint32_t *edge;   /* per corner: the edge that starts there */
    uint32_t *queue;  /* triangles */
    uint32_t *next;   /* per welded vertex: where the border goes on; MESH_NONE: not on it */
    double *vertices; /* of a border */
    size_t lights, failed;
};

static uint32_t welded(const struct emitter *emitter, size_t corner)
{
    return emitter->edges->welded[emitter->mesh->indices[corner]];
}

static vec3 world(const struct emitter *emitter, uint32_t welded_vertex)
{
    size_t vertex = emitter->edges->welded_vertex[welded_vertex];
    return m34_point(emitter->object->world_from_mesh,
                     v3_loadf(emitter->mesh->positions + 3 * vertex));
}

/* Twice the area along the triangle's front. */
static vec3 triangle_cross(const struct emitter *emitter, size_t triangle)
{
    vec3 a = world(emitter, welded(emitter, 3 * triangle));
    vec3 b = world(emitter, welded(emitter, 3 * triangle + 1));
    vec3 c = world(emitter, welded(emitter, 3 * triangle + 2));
    return v3_scale(v3_cross(v3_sub(b, a), v3_sub(c, a)), emitter->front);
}

static bool has_area(const struct emitter *emitter, vec3 cross)
{
    return v3_length(cross) > TOLERANCE_DEGENERATE * emitter->size * emitter->size;
}

/* For each corner the edge to the next corner; MESH_NONE where both are at one place. */
static void name_edges(struct emitter *emitter)
{
    const struct mesh_edges *edges = emitter->edges;
    memset(emitter->edge, 0xff, emitter->mesh->triangle_count * 3 * sizeof(*emitter->edge));
    for (size_t e = 0; e < edges->edge_count; e++) {
        const struct mesh_edge *edge = &edges->edges[e];
        for (uint32_t k = 0; k < edge->use_count; k++) {
            uint32_t use = edges->uses[edge->first_use + k];
            size_t triangle = use / 2;
            uint32_t from = edge->vertex[use % 2], to = edge->vertex[1 - use % 2];
            for (size_t c = 0; c < 3; c++)
                if (welded(emitter, 3 * triangle + c) == from &&
                    welded(emitter, 3 * triangle + (c + 1) % 3) == to)
                    emitter->edge[3 * triangle + c] = (uint32_t)e;
        }
    }
}

/* The triangle on the other side of a corner's edge, or MESH_NONE. */
static uint32_t across(const struct emitter *emitter, size_t corner)
{
    uint32_t e = emitter->edge[corner];
    if (e == MESH_NONE || emitter->edges->edges[e].use_count != 2)
        return MESH_NONE;
    const uint32_t *uses = emitter->edges->uses + emitter->edges->edges[e].first_use;
    uint32_t triangle = (uint32_t)(corner / 3);
    uint32_t other = uses[0] / 2 == triangle ? uses[1] : uses[0];
    uint32_t own = uses[0] / 2 == triangle ? uses[0] : uses[1];
    return other % 2 != own % 2 ? other / 2 : MESH_NONE; /* both the same way: no common front */
}

/* Marks the patch of a triangle, fills the queue with its triangles; returns their number. */
static size_t grow(struct emitter *emitter, uint32_t seed, uint32_t patch)
{
    size_t count = 0;
    vec3 normal = v3_normalize(triangle_cross(emitter, seed));
    vec3 point = world(emitter, welded(emitter, 3 * (size_t)seed));
    emitter->queue[count++] = seed;
    emitter->patch[seed] = patch;
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++) {
            uint32_t other = across(emitter, 3 * (size_t)emitter->queue[i] + c);
            if (other == MESH_NONE || emitter->patch[other] != MESH_NONE)
                continue;
            vec3 cross = triangle_cross(emitter, other);
            bool flat =
                has_area(emitter, cross) && v3_dot(v3_normalize(cross), normal) > SAME_PLANE_COSINE;
            for (size_t k = 0; k < 3 && flat; k++) {
                vec3 p = world(emitter, welded(emitter, 3 * (size_t)other + k));
                flat = fabs(v3_dot(v3_sub(p, point), normal)) <=
                       TOLERANCE_LIGHT_PLANARITY * emitter->size;
            }
            if (!flat)
                continue;
            emitter->patch[other] = patch;
            emitter->queue[count++] = other;
        }
    }
    return count;
}

/* Links the patch's border. Returns the number of its edges; 0 if a vertex has two ways to go on.
 */
static size_t link_border(struct emitter *emitter, size_t count, uint32_t *out_first)
{
    size_t length = 0;
    bool simple = true;
    for (size_t i = 0; i < count; i++) {
        size_t triangle = emitter->queue[i];
        for (size_t c = 0; c < 3; c++) {
            uint32_t other = across(emitter, 3 * triangle + c);
            if (other != MESH_NONE && emitter->patch[other] == emitter->patch[triangle])
                continue;
            uint32_t from = welded(emitter, 3 * triangle + c);
            simple = simple && emitter->next[from] == MESH_NONE;
            emitter->next[from] = welded(emitter, 3 * triangle + (c + 1) % 3);
            *out_first = from;
            length++;
        }
    }
    return simple ? length : 0;
}

static void unlink_border(struct emitter *emitter, size_t count)
{
    for (size_t i = 0; i < count; i++)
        for (size_t c = 0; c < 3; c++)
            emitter->next[welded(emitter, 3 * (size_t)emitter->queue[i] + c)] = MESH_NONE;
}

/* Walks the border into vertices, leaving out those on a straight line. 0: not one closed loop. */
static size_t walk_border(struct emitter *emitter, uint32_t first, size_t length)
{
    size_t walked = 0, kept = 0;
    uint32_t at = first;
    do {
        v3_store(emitter->vertices + 3 * walked++, world(emitter, at));
        at = emitter->next[at];
    } while (at != MESH_NONE && at != first && walked < length);
    if (at != first || walked != length)
        return 0;
    for (size_t i = 0; i < walked; i++) {
        vec3 before = v3_load(emitter->vertices + 3 * (kept > 0 ? kept - 1 : walked - 1));
        vec3 here = v3_load(emitter->vertices + 3 * i);
        vec3 after = v3_load(emitter->vertices + 3 * (i + 1 < walked ? i + 1 : 0));
        vec3 in = v3_sub(here, before), out = v3_sub(after, here);
        if (v3_length(v3_cross(in, out)) > 1e-6 * v3_length(in) * v3_length(out))
            v3_store(emitter->vertices + 3 * kept++, here);
    }
    return kept;
}

static pnb_status add_polygon(struct emitter *emitter, size_t count)
{
    double *v = emitter->vertices;
    pnb_light light = {.type = PNB_LIGHT_POLYGON, .name = emitter->object->name};
    memcpy(light.color, emitter->color, sizeof(light.color));

    /* Counter-clockwise seen from where it shines to. */
    if (emitter->side * emitter->front < 0)
        for (size_t i = 0; i < count / 2; i++)
            for (size_t c = 0; c < 3; c++) {
                double swap = v[3 * i + c];
                v[3 * i + c] = v[3 * (count - 1 - i) + c];
                v[3 * (count - 1 - i) + c] = swap;
            }
    light.shape.polygon.vertices = v;
    light.shape.polygon.vertex_count = count;
    if (count == 4) {
        vec3 a = v3_load(v), b = v3_load(v + 3), c = v3_load(v + 6), d = v3_load(v + 9);
        vec3 ab = v3_sub(b, a), ad = v3_sub(d, a);
        double diagonal = v3_length(v3_sub(c, a));
        if (v3_length(v3_sub(v3_add(ab, ad), v3_sub(c, a))) < 1e-5 * diagonal &&
            fabs(v3_dot(ab, ad)) < 1e-5 * v3_length(ab) * v3_length(ad)) {
            light.type = PNB_LIGHT_RECTANGLE;
            v3_store(light.shape.rectangle.center, v3_scale(v3_add(a, c), 0.5));
            v3_store(light.shape.rectangle.half_u, v3_scale(ab, 0.5));
            v3_store(light.shape.rectangle.half_v, v3_scale(ad, 0.5));
        }
    }
    pnb_status status = pnb_scene_add_light(emitter->scene, &light, NULL);
    if (status == PNB_OK)
        emitter->lights++;
    else if (status == PNB_ERROR_SCENE)
        emitter->failed++;
    return status;
}

/* The patch in the queue as a light, or as several. */
static pnb_status add_patch(struct emitter *emitter, size_t count)
{
    uint32_t first = 0;
    size_t length = link_border(emitter, count, &first);
    size_t corners = length > 0 ? walk_border(emitter, first, length) : 0;
    unlink_border(emitter, count);
    if (corners >= 3) {
        pnb_status status = add_polygon(emitter, corners);
        if (status != PNB_ERROR_SCENE)
            return status;
        emitter->failed--;
    }
    if (count > LOOSE_TRIANGLES) {
        emitter->failed++;
        return PNB_OK;
    }
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++)
            v3_store(emitter->vertices + 3 * c,
                     world(emitter, welded(emitter, 3 * (size_t)emitter->queue[i] + c)));
        pnb_status status = add_polygon(emitter, 3);
        if (status != PNB_OK && status != PNB_ERROR_SCENE)
            return status;
    }
    return PNB_OK;
}

/* -1 for a plane that has other objects behind it only. */
static double lit_side(const struct emitter *emitter, size_t index, uint32_t triangle)
{
    const pnb_scene *scene = emitter->scene;
    vec3 normal = v3_normalize(triangle_cross(emitter, triangle));
    vec3 point = world(emitter, welded(emitter, 3 * (size_t)triangle));
    bool before = false, behind = false;
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        vec3 low, high;
        mesh_bounds(&scene->meshes[object->mesh], &low, &high);
        for (int corner = 0; corner < 8 && i != index && low.x <= high.x; corner++) {
            vec3 p = v3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                        corner & 4 ? high.z : low.z);
            double height = v3_dot(v3_sub(m34_point(object->world_from_mesh, p), point), normal);
            before = before || height > TOLERANCE_LIGHT_PLANARITY * emitter->size;
            behind = behind || height < -TOLERANCE_LIGHT_PLANARITY * emitter->size;
        }
    }
    return behind && !before ? -1 : 1;
}

/* All patches; first only counted, so that a curved surface gives no light at all. */
static pnb_status add_patches(struct emitter *emitter, size_t index, bool double_sided)
{
    const struct mesh *mesh = emitter->mesh;
    vec3 planes[PLANES_MAX];
    size_t plane_count = 0, patch_count = 0;
    for (int pass = 0; pass < 2; pass++) {
        memset(emitter->patch, 0xff, mesh->triangle_count * sizeof(*emitter->patch));
        for (size_t t = 0; t < mesh->triangle_count; t++) {
            vec3 cross = triangle_cross(emitter, t);
            if (emitter->patch[t] != MESH_NONE || !has_area(emitter, cross))
                continue;
            vec3 normal = v3_normalize(cross);
            size_t count = grow(emitter, (uint32_t)t, (uint32_t)t);
            if (pass == 1) {
                emitter->side = double_sided ? lit_side(emitter, index, (uint32_t)t) : 1;
                pnb_status status = add_patch(emitter, count);
                if (status != PNB_OK)
                    return status;
                continue;
            }
            size_t plane = 0;
            while (plane < plane_count && v3_dot(planes[plane], normal) < SAME_PLANE_COSINE)
                plane++;
            if (plane == PLANES_MAX || ++patch_count > PATCHES_MAX) {
                emitter->failed++;
                return PNB_OK;
            }
            if (plane == plane_count)
                planes[plane_count++] = normal;
        }
    }
    return PNB_OK;
}

pnb_status scene_import_emissive(pnb_scene *scene, const struct scene_import_data *data,
                                 size_t index)
{
    pnb_context *context = scene->context;
    const struct scene_import_object *from = &data->objects[index];
    struct pnb_object *object = &scene->objects[index].info;
    struct mesh *mesh = &scene->meshes[object->mesh];
    struct emitter emitter = {.scene = scene, .mesh = mesh, .object = object};
    vec3 low, high;
    pnb_status status = mesh_get_edges(context, mesh, &emitter.edges);
    if (status != PNB_OK)
        return status;
    memcpy(emitter.color, from->emission, sizeof(emitter.color));
    mesh_bounds(mesh, &low, &high);
    emitter.size = v3_length(m34_vector(object->world_from_mesh, v3_sub(high, low)));
    emitter.front = m34_det(object->world_from_mesh) < 0 ? -1 : 1;

    size_t triangles = mesh->triangle_count;
    emitter.patch = memory_alloc(context, triangles, sizeof(uint32_t));
    emitter.edge = memory_alloc(context, triangles * 3, sizeof(uint32_t));
    emitter.queue = memory_alloc(context, triangles, sizeof(uint32_t));
    emitter.next = memory_alloc(context, emitter.edges->welded_count, sizeof(uint32_t));
    emitter.vertices = memory_alloc(context, triangles * 3 + 3, 3 * sizeof(double));
    if (emitter.patch && emitter.edge && emitter.queue && emitter.next && emitter.vertices) {
        memset(emitter.next, 0xff, emitter.edges->welded_count * sizeof(uint32_t));
        name_edges(&emitter);
        status = add_patches(&emitter, index, from->double_sided);
    } else {
        status = status_no_memory(context, triangles * 96);
    }
    memory_free(context, emitter.patch);
    memory_free(context, emitter.edge);
    memory_free(context, emitter.queue);
    memory_free(context, emitter.next);
    memory_free(context, emitter.vertices);
    if (status != PNB_OK)
        return status;

    if (emitter.lights > 0) {
        object->casts = object->receives = false;
        scene_note(scene, "emissive object '%s': %zu flat part%s taken as light%s", object->name,
                   emitter.lights, emitter.lights > 1 ? "s" : "", emitter.lights > 1 ? "s" : "");
    }
    if (emitter.failed > 0)
        scene_note(scene, "emissive object '%s' %s: no light", object->name,
                   emitter.lights > 0 ? "has parts that are no polygon" : "is not flat");
    return PNB_OK;
}
