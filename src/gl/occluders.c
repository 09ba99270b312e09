/* gl/occluders.c: the casting objects of a scene in world space, with edges and face planes.
 *
 * Per object: vertices welded by position (mesh/edges.c), triangles by welded vertices, mirrored
 * placements and closed meshes whose faces point inwards turned so that faces are counter-clockwise
 * from outside. Edges pair their uses: first
 * those that run in opposite directions, then the rest among themselves (same_way), and the last
 * one of an odd number stays alone. Cost: O(vertices + triangles), once per mesh or placement.
 * Memory: 12 bytes a vertex, 28 a triangle, 20 an edge.
 *
 * Methods that draw triangles only ask for no edges: then vertices and faces are as the meshes have
 * them, no object counts as closed, and nothing is welded or paired.
 */
#include <string.h>

#include "gl/frame.h"

struct sums {
    size_t vertices, triangles, edges, objects;
};

static pnb_status count_all(pnb_scene *scene, bool with_edges, struct sums *sums)
{
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        struct mesh *mesh = &scene->meshes[object->mesh];
        const struct mesh_edges *edges;
        if (!object->casts || mesh->triangle_count == 0)
            continue;
        sums->triangles += mesh->triangle_count;
        sums->objects++;
        if (!with_edges) {
            sums->vertices += mesh->vertex_count;
            continue;
        }
        pnb_status status = mesh_get_edges(scene->context, mesh, &edges);
        if (status != PNB_OK)
            return status;
        sums->vertices += edges->welded_count;
        for (size_t e = 0; e < edges->edge_count; e++)
            sums->edges += (edges->edges[e].use_count + 1u) / 2u;
    }
    if (sums->vertices > UINT32_MAX / 2 || sums->triangles > INT32_MAX / 3 ||
        sums->edges > INT32_MAX)
        return status_fail(scene->context, PNB_ERROR_UNSUPPORTED, scene->name,
                           "more triangles than OpenGL methods count");
    return PNB_OK;
}

static void add_plane(struct gl_occluders *o, size_t t)
{
    vec3 c[3];
    for (int k = 0; k < 3; k++)
        c[k] = v3_loadf(o->positions + 3 * (size_t)o->indices[3 * t + (size_t)k]);
    vec3 u = v3_sub(c[1], c[0]), v = v3_sub(c[2], c[0]);
    double size = fmax(v3_max_abs(u), v3_max_abs(v));
    vec3 n = v3(0, 0, 0);
    if (size > 0)
        n = v3_cross(v3_scale(u, 1 / size), v3_scale(v, 1 / size));
    float *plane = o->planes + 4 * t;
    memset(plane, 0, 4 * sizeof(*plane));
    if (!(v3_max_abs(n) > 1e-15))
        return;
    n = v3_normalize(n);
    v3_storef(plane, n);
    plane[3] = (float)-v3_dot(n, c[0]);
}

/* The pairs of one edge's uses. */
static void add_edge(struct gl_occluders *o, const struct mesh_edges *edges,
                     const struct mesh_edge *edge, uint32_t first_vertex, uint32_t first_triangle,
                     bool mirrored)
{
    const uint32_t *uses = edges->uses + edge->first_use;
    uint32_t low = edge->vertex[0] + first_vertex, high = edge->vertex[1] + first_vertex;
    uint32_t next[2] = {0, 0}; /* walks along the uses of either direction */
    uint32_t left[2] = {0, 0};
    for (uint32_t i = 0; i < edge->use_count; i++)
        left[uses[i] & 1]++;
    while (left[0] + left[1] > 0) {
        uint32_t triangles[2] = {MESH_NONE, MESH_NONE};
        int directions[2];
        directions[0] = left[0] > 0 ? 0 : 1;
        directions[1] = directions[0] == 0 && left[1] > 0 ? 1 : directions[0];
        for (int k = 0; k < 2; k++) {
            int d = directions[k];
            if (left[d] == 0)
                continue;
            while ((uses[next[d]] & 1u) != (uint32_t)d)
                next[d]++;
            triangles[k] = (uses[next[d]++] >> 1) + first_triangle;
            left[d]--;
        }
        /* Mirroring swaps two corners of each triangle: it runs the other way along its edges. */
        bool forward = (directions[0] == 0) != mirrored;
        o->edges[o->edge_count++] = (struct gl_edge){.a = forward ? low : high,
                                                     .b = forward ? high : low,
                                                     .first = triangles[0],
                                                     .second = triangles[1],
                                                     .same_way = triangles[1] != MESH_NONE &&
                                                                 directions[0] == directions[1]};
    }
}

/* Does the mesh enclose a negative volume: do its faces run clockwise from outside? */
static bool inside_out(const struct mesh *mesh)
{
    double volume = 0;
    vec3 origin = v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[0]);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        vec3 c[3];
        for (size_t k = 0; k < 3; k++)
            c[k] = v3_sub(v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[3 * t + k]), origin);
        volume += v3_dot(c[0], v3_cross(c[1], c[2]));
    }
    return volume < 0;
}

static void add_object(pnb_scene *scene, size_t index, struct gl_occluders *o)
{
    const pnb_object *object = &scene->objects[index].info;
    const struct mesh *mesh = &scene->meshes[object->mesh];
    const struct mesh_edges *edges = o->with_edges ? mesh->edges : NULL;
    bool closed = edges && edges->open_count == 0 && edges->non_manifold_count == 0 &&
                  edges->inconsistent_count == 0;
    bool mirrored = (m34_det(object->world_from_mesh) < 0) != (closed && inside_out(mesh));
    uint32_t first_vertex = (uint32_t)o->vertex_count, first_triangle = (uint32_t)o->triangle_count;
    struct gl_occluder *occluder = &o->objects[o->object_count++];
    *occluder = (struct gl_occluder){.object = index,
                                     .first_index = 3 * o->triangle_count,
                                     .index_count = 3 * mesh->triangle_count,
                                     .first_edge = o->edge_count,
                                     .closed = closed,
                                     .low = v3(INFINITY, INFINITY, INFINITY),
                                     .high = v3(-INFINITY, -INFINITY, -INFINITY)};
    size_t vertex_count = edges ? edges->welded_count : mesh->vertex_count;
    for (size_t i = 0; i < vertex_count; i++) {
        size_t from = edges ? edges->welded_vertex[i] : i;
        vec3 p = m34_point(object->world_from_mesh, v3_loadf(mesh->positions + 3 * from));
        v3_storef(o->positions + 3 * (o->vertex_count + i), p);
    }
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        uint32_t *to = o->indices + 3 * (o->triangle_count + t);
        for (int k = 0; k < 3; k++) {
            int corner = mirrored ? (3 - k) % 3 : k;
            uint32_t vertex = mesh->indices[3 * t + (size_t)corner];
            to[k] = (edges ? edges->welded[vertex] : vertex) + first_vertex;
            vec3 p = v3_loadf(o->positions + 3 * (size_t)to[k]);
            occluder->low = v3_min(occluder->low, p);
            occluder->high = v3_max(occluder->high, p);
        }
        add_plane(o, o->triangle_count + t);
    }
    o->vertex_count += vertex_count;
    o->triangle_count += mesh->triangle_count;
    for (size_t e = 0; edges && e < edges->edge_count; e++)
        add_edge(o, edges, &edges->edges[e], first_vertex, first_triangle, mirrored);
    occluder->edge_count = o->edge_count - occluder->first_edge;
    occluder->open_count = edges ? edges->open_count : 0;
    occluder->non_manifold_count = edges ? edges->non_manifold_count : 0;
    o->low = v3_min(o->low, occluder->low);
    o->high = v3_max(o->high, occluder->high);
}

/* ---- Floors ---- */

#define FLOOR_TOLERANCE 1e-6 /* of the scene's size */
#define FLOORS_MAX      16

/* The sides of a plane on which an object has something: bit 0 above, bit 1 below. */
static int sides(const struct gl_occluders *o, const pnb_scene *scene, size_t object, vec3 normal,
                 double offset, double tolerance)
{
    const pnb_object *info = &scene->objects[object].info;
    const struct mesh *mesh = &scene->meshes[info->mesh];
    int found = 0;
    for (size_t i = 0; i < mesh->vertex_count && found != 3 && mesh->triangle_count > 0; i++) {
        vec3 p = m34_point(info->world_from_mesh, v3_loadf(mesh->positions + 3 * i));
        double h = v3_dot(normal, p) - offset;
        found |= h > tolerance ? 1 : h < -tolerance ? 2 : 0;
    }
    return found;
}

static void find_floor(const pnb_scene *scene, struct gl_occluders *o, struct gl_occluder *occluder,
                       double tolerance)
{
    const float *plane = NULL;
    for (size_t t = 0; t < occluder->index_count / 3 && !plane; t++) {
        const float *candidate = o->planes + 4 * (occluder->first_index / 3 + t);
        plane = candidate[0] != 0 || candidate[1] != 0 || candidate[2] != 0 ? candidate : NULL;
    }
    if (!plane)
        return;
    vec3 normal = v3_loadf(plane);
    double offset = -(double)plane[3];
    if (sides(o, scene, occluder->object, normal, offset, tolerance) != 0)
        return; /* not flat */
    int found = 0;
    for (size_t i = 0; i < scene->object_count && found != 3; i++)
        if (i != occluder->object)
            found |= sides(o, scene, i, normal, offset, tolerance);
    if (found == 3 || found == 0)
        return;
    occluder->floor = true;
    occluder->floor_normal = found == 1 ? normal : v3_scale(normal, -1);
    occluder->floor_offset = found == 1 ? offset : -offset;
}

static void find_floors(const pnb_scene *scene, struct gl_occluders *o)
{
    double size = fmax(v3_max_abs(o->scene_low), v3_max_abs(o->scene_high));
    int found = 0;
    for (size_t i = 0; i < o->object_count && found < FLOORS_MAX; i++) {
        find_floor(scene, o, &o->objects[i], FLOOR_TOLERANCE * size);
        found += o->objects[i].floor;
    }
}

pnb_status gl_occluders_create(pnb_scene *scene, bool with_edges,
                               struct gl_occluders **out_occluders)
{
    pnb_context *context = scene->context;
    *out_occluders = NULL;
    struct sums sums = {0};
    pnb_status status = count_all(scene, with_edges, &sums);
    if (status != PNB_OK)
        return status;
    struct gl_occluders *o = memory_calloc(context, 1, sizeof(*o));
    if (!o)
        return status_no_memory(context, sizeof(*o));
    o->context = context;
    o->with_edges = with_edges;
    o->positions = memory_alloc(context, sums.vertices, 3 * sizeof(float));
    o->indices = memory_alloc(context, sums.triangles, 3 * sizeof(uint32_t));
    o->planes = memory_alloc(context, sums.triangles, 4 * sizeof(float));
    o->edges = with_edges ? memory_alloc(context, sums.edges, sizeof(*o->edges)) : NULL;
    o->objects = memory_alloc(context, sums.objects, sizeof(*o->objects));
    if (!o->positions || !o->indices || !o->planes || (with_edges && !o->edges) || !o->objects) {
        gl_occluders_destroy(o);
        return status_no_memory(context, sums.triangles * 28 + sums.edges * sizeof(*o->edges));
    }
    o->low = v3(INFINITY, INFINITY, INFINITY);
    o->high = v3_scale(o->low, -1);
    double low[3], high[3];
    pnb_scene_bounds(scene, low, high);
    o->scene_low = v3_load(low);
    o->scene_high = v3_load(high);
    for (size_t i = 0; i < scene->object_count; i++)
        if (scene->objects[i].info.casts &&
            scene->meshes[scene->objects[i].info.mesh].triangle_count > 0)
            add_object(scene, i, o);
    find_floors(scene, o);
    *out_occluders = o;
    return PNB_OK;
}

void gl_occluders_destroy(struct gl_occluders *o)
{
    if (!o)
        return;
    gl_buffer_destroy(o->position_buffer);
    gl_buffer_destroy(o->index_buffer);
    memory_free(o->context, o->positions);
    memory_free(o->context, o->indices);
    memory_free(o->context, o->planes);
    memory_free(o->context, o->edges);
    memory_free(o->context, o->objects);
    memory_free(o->context, o);
}

pnb_status gl_occluders_update(pnb_scene *scene, struct gl_occluders **occluders)
{
    struct gl_occluders *made;
    pnb_status status = gl_occluders_create(scene, (*occluders)->with_edges, &made);
    if (status != PNB_OK)
        return status;
    gl_occluders_destroy(*occluders);
    *occluders = made;
    return PNB_OK;
}

pnb_status gl_occluders_upload(struct gl_device *device, struct gl_occluders *o)
{
    pnb_status status = PNB_OK;
    if (!o->position_buffer)
        status = gl_buffer_create(device, o->positions, o->vertex_count * 3 * sizeof(float), false,
                                  &o->position_buffer);
    if (status == PNB_OK && !o->index_buffer)
        status = gl_buffer_create(device, o->indices, o->triangle_count * 3 * sizeof(uint32_t),
                                  false, &o->index_buffer);
    return status;
}
