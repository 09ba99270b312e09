/* method/exact/exact_scene.c: the occluders: clusters per mesh, instances per object.
 *
 * Clusters stay in mesh space. Moving an object changes its instance only, O(objects); deforming a
 * mesh refits its clusters, O(its triangles), and drops its coarser levels. A placement that
 * flattens its mesh cannot be inverted: such an object gets clusters of its own, made in world
 * space and made anew when it moves.
 */
#include <stdlib.h>
#include <string.h>

#include "method/exact/exact.h"

static bool invert(const double *m, double *out)
{
    double det = m34_det(m), scale = 1;
    for (int c = 0; c < 3; c++)
        scale *= v3_length(v3(m[c], m[4 + c], m[8 + c]));
    if (!(fabs(det) > 1e-9 * scale) || !isfinite(1 / det))
        return false;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[4 * r + c] =
                (m[4 * c1 + r1] * m[4 * c2 + r2] - m[4 * c1 + r2] * m[4 * c2 + r1]) / det;
        }
    vec3 t = m34_vector(out, v3(m[3], m[7], m[11]));
    out[3] = -t.x, out[7] = -t.y, out[11] = -t.z;
    return true;
}

static pnb_status bake(pnb_context *context, const struct mesh *mesh, const double *placement,
                       struct clusters **out_clusters)
{
    float *positions = memory_alloc(context, mesh->vertex_count, 3 * sizeof(float));
    if (!positions)
        return status_no_memory(context, mesh->vertex_count * 3 * sizeof(float));
    for (size_t v = 0; v < mesh->vertex_count; v++)
        v3_storef(positions + 3 * v, m34_point(placement, v3_loadf(mesh->positions + 3 * v)));
    pnb_mesh_desc desc = {mesh->name,         positions,     NULL,
                          mesh->vertex_count, mesh->indices, mesh->triangle_count};
    struct mesh flat;
    pnb_status status = mesh_init(context, &flat, &desc);
    memory_free(context, positions);
    if (status != PNB_OK)
        return status;
    status = clusters_create(context, &flat, out_clusters);
    mesh_finish(context, &flat);
    return status;
}

/* How many times longer a length becomes at most: Gershgorin's bound, of the transposed matrix
 * times itself; exact for rotations and scales. */
static double stretch(const double *m)
{
    vec3 c[3];
    double longest = 0, skew = 0;
    for (int i = 0; i < 3; i++) {
        c[i] = v3(m[i], m[4 + i], m[8 + i]);
        longest = fmax(longest, v3_dot(c[i], c[i]));
    }
    for (int i = 0; i < 3; i++)
        skew = fmax(skew, fabs(v3_dot(c[i], c[(i + 1) % 3])) + fabs(v3_dot(c[i], c[(i + 2) % 3])));
    return sqrt(longest + skew);
}

/* Where the baked vertices are before they are rounded to single precision. */
static pnb_status place_baked(pnb_context *context, const struct mesh *mesh,
                              const double *placement, const struct clusters *clusters,
                              vec3 **out_places)
{
    vec3 *places = memory_calloc(context, clusters->vertex_count + 1, sizeof(*places));
    *out_places = places;
    if (!places)
        return status_no_memory(context, (clusters->vertex_count + 1) * sizeof(*places));
    for (size_t v = 0; v < mesh->vertex_count; v++)
        if (clusters->vertex[v] != MESH_NONE)
            places[clusters->vertex[v]] = m34_point(placement, v3_loadf(mesh->positions + 3 * v));
    return PNB_OK;
}

static void bound_instance(struct exact_instance *instance)
{
    const struct cluster_node *root = &instance->clusters->nodes[0];
    instance->bounds.low = v3(INFINITY, INFINITY, INFINITY);
    instance->bounds.high = v3(-INFINITY, -INFINITY, -INFINITY);
    for (int i = 0; i < 8; i++) {
        vec3 p = v3(i & 1 ? root->high[0] : root->low[0], i & 2 ? root->high[1] : root->low[1],
                    i & 4 ? root->high[2] : root->low[2]);
        p = m34_point(instance->world_from_mesh, p);
        instance->bounds.low = v3_min(instance->bounds.low, p);
        instance->bounds.high = v3_max(instance->bounds.high, p);
    }
}

static double middle_of(const struct exact_instance *instance, int axis)
{
    vec3 middle = v3_add(instance->bounds.low, instance->bounds.high);
    return axis == 0 ? middle.x : axis == 1 ? middle.y : middle.z;
}

static int compare_along(const void *a, const void *b, int axis)
{
    const struct exact_instance *p = a, *q = b;
    double x = middle_of(p, axis), y = middle_of(q, axis);
    if (x != y)
        return x < y ? -1 : 1;
    return (p->object > q->object) - (p->object < q->object);
}
static int compare_x(const void *a, const void *b)
{
    return compare_along(a, b, 0);
}
static int compare_y(const void *a, const void *b)
{
    return compare_along(a, b, 1);
}
static int compare_z(const void *a, const void *b)
{
    return compare_along(a, b, 2);
}

/* Halves the instances along the widest axis of their middles, at multiples of EXACT_GROUP. */
static void sort_instances(struct exact_instance *instances, size_t count)
{
    static int (*const compare[3])(const void *, const void *) = {compare_x, compare_y, compare_z};
    if (count <= EXACT_GROUP)
        return;
    double widest = -1;
    int axis = 0;
    for (int a = 0; a < 3; a++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            double x = middle_of(&instances[i], a);
            low = x < low ? x : low, high = x > high ? x : high;
        }
        if (high - low > widest)
            widest = high - low, axis = a;
    }
    qsort(instances, count, sizeof(*instances), compare[axis]);
    size_t groups = (count + EXACT_GROUP - 1) / EXACT_GROUP, left = groups / 2 * EXACT_GROUP;
    sort_instances(instances, left);
    sort_instances(instances + left, count - left);
}

static void group_instances(struct exact_scene *exact)
{
    sort_instances(exact->instances, exact->instance_count);
    for (size_t i = 0; i < exact->instance_count; i++) {
        struct exact_bounds *group = &exact->groups[i / EXACT_GROUP];
        const struct exact_bounds *bounds = &exact->instances[i].bounds;
        if (i % EXACT_GROUP == 0)
            *group = *bounds;
        group->low = v3_min(group->low, bounds->low);
        group->high = v3_max(group->high, bounds->high);
    }
}

/* An instance of the clusters, placed as from is. */
static void add_instance(struct exact_scene *exact, const struct exact_instance *from,
                         const struct clusters *clusters, const struct levels *levels)
{
    struct exact_instance *instance = &exact->instances[exact->instance_count];
    if (clusters->cluster_count == 0)
        return;
    *instance = *from;
    instance->clusters = clusters;
    instance->levels = levels;
    instance->stretch = stretch(instance->world_from_mesh);
    bound_instance(instance);
    exact->instance_count++;
    exact->triangle_count += clusters->slot_count;
    if (clusters->slot_count > exact->slots_max)
        exact->slots_max = clusters->slot_count;
    if (clusters->cluster_count > exact->clusters_max)
        exact->clusters_max = clusters->cluster_count;
    if (clusters->vertex_count > exact->vertices_max)
        exact->vertices_max = clusters->vertex_count;
}

static pnb_status place(pnb_scene *scene, struct exact_scene *exact)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    exact->instance_count = 0;
    exact->slots_max = exact->clusters_max = exact->vertices_max = exact->triangle_count = 0;
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        clusters_destroy(scene->context, exact->baked[i]);
        memory_free(scene->context, exact->places[i]);
        exact->baked[i] = NULL;
        exact->places[i] = NULL;
        if (!object->casts)
            continue;
        struct exact_instance placed = {.object = i};
        memcpy(placed.world_from_mesh, object->world_from_mesh, sizeof(identity));
        if (!invert(placed.world_from_mesh, placed.mesh_from_world)) {
            pnb_status status = bake(scene->context, &scene->meshes[object->mesh],
                                     object->world_from_mesh, &exact->baked[i]);
            if (status == PNB_OK)
                status = place_baked(scene->context, &scene->meshes[object->mesh],
                                     object->world_from_mesh, exact->baked[i], &exact->places[i]);
            if (status != PNB_OK)
                return status;
            placed.places = exact->places[i];
            memcpy(placed.world_from_mesh, identity, sizeof(identity));
            memcpy(placed.mesh_from_world, identity, sizeof(identity));
            add_instance(exact, &placed, exact->baked[i], NULL);
            continue;
        }
        const struct parts *parts = exact->parts[object->mesh];
        for (size_t k = 0; parts && k < parts->count; k++)
            add_instance(exact, &placed, parts->clusters[k], NULL);
        if (!parts)
            add_instance(exact, &placed, exact->meshes[object->mesh], exact->levels[object->mesh]);
    }
    group_instances(exact);
    exact->bytes = sizeof(*exact) + exact->instance_capacity * sizeof(*exact->instances);
    for (size_t i = 0; i < exact->mesh_count; i++) {
        exact->bytes += exact->meshes[i] ? exact->meshes[i]->bytes : 0;
        exact->bytes += exact->parts[i] ? exact->parts[i]->bytes : 0;
        exact->bytes += exact->levels[i] ? exact->levels[i]->bytes : 0;
    }
    for (size_t i = 0; i < exact->object_count; i++)
        if (exact->baked[i])
            exact->bytes += exact->baked[i]->bytes +
                            (exact->baked[i]->vertex_count + 1) * sizeof(*exact->places[i]);
    return PNB_OK;
}

static pnb_status create_clusters(pnb_scene *scene, struct exact_scene *exact, size_t mesh)
{
    pnb_status status = parts_create(scene->context, &scene->meshes[mesh], &exact->parts[mesh]);
    if (status == PNB_OK && !exact->parts[mesh])
        status = clusters_create(scene->context, &scene->meshes[mesh], &exact->meshes[mesh]);
    return status;
}

/* Room for the instances of all objects, whichever of them cast. */
static pnb_status reserve_instances(pnb_scene *scene, struct exact_scene *exact)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->object_count; i++) {
        const struct parts *parts = exact->parts[scene->objects[i].info.mesh];
        count += parts ? parts->count : 1;
    }
    if (count <= exact->instance_capacity)
        return PNB_OK;
    memory_free(scene->context, exact->instances);
    memory_free(scene->context, exact->groups);
    exact->instances = memory_calloc(scene->context, count, sizeof(*exact->instances));
    exact->groups = memory_calloc(scene->context, count, sizeof(*exact->groups));
    exact->instance_capacity = count;
    if (!exact->groups || !exact->instances)
        return status_no_memory(scene->context, count * sizeof(*exact->instances));
    return PNB_OK;
}

pnb_status exact_scene_create(pnb_scene *scene, bool coarser, struct exact_scene **out_scene)
{
    pnb_context *context = scene->context;
    *out_scene = NULL;
    struct exact_scene *exact = memory_calloc(context, 1, sizeof(*exact));
    if (!exact)
        return status_no_memory(context, sizeof(*exact));
    exact->mesh_count = scene->mesh_count;
    exact->object_count = scene->object_count;
    exact->meshes = memory_calloc(context, scene->mesh_count, sizeof(*exact->meshes));
    exact->baked = memory_calloc(context, scene->object_count, sizeof(*exact->baked));
    exact->parts = memory_calloc(context, scene->mesh_count, sizeof(*exact->parts));
    exact->levels = memory_calloc(context, scene->mesh_count, sizeof(*exact->levels));
    pnb_status status = PNB_OK;
    exact->places = memory_calloc(context, scene->object_count, sizeof(*exact->places));
    if (!exact->meshes || !exact->baked || !exact->places || !exact->parts || !exact->levels)
        status = status_no_memory(context, scene->object_count * sizeof(*exact->baked));
    for (size_t i = 0; i < scene->object_count && status == PNB_OK; i++) {
        size_t mesh = scene->objects[i].info.mesh;
        if (scene->objects[i].info.casts && !exact->meshes[mesh] && !exact->parts[mesh])
            status = create_clusters(scene, exact, mesh);
        if (status == PNB_OK && coarser && exact->meshes[mesh] && !exact->levels[mesh])
            status = levels_create(context, exact->meshes[mesh], &exact->levels[mesh]);
    }
    if (status == PNB_OK)
        status = reserve_instances(scene, exact);
    if (status == PNB_OK)
        status = place(scene, exact);
    if (status != PNB_OK) {
        exact_scene_destroy(context, exact);
        return status;
    }
    *out_scene = exact;
    return PNB_OK;
}

void exact_scene_destroy(pnb_context *context, struct exact_scene *exact)
{
    if (!exact)
        return;
    for (size_t i = 0; i < exact->mesh_count && exact->meshes; i++)
        clusters_destroy(context, exact->meshes[i]);
    for (size_t i = 0; i < exact->object_count && exact->baked; i++)
        clusters_destroy(context, exact->baked[i]);
    for (size_t i = 0; i < exact->mesh_count && exact->parts; i++)
        parts_destroy(context, exact->parts[i]);
    for (size_t i = 0; i < exact->mesh_count && exact->levels; i++)
        levels_destroy(context, exact->levels[i]);
    memory_free(context, exact->levels);
    memory_free(context, exact->parts);
    memory_free(context, exact->meshes);
    for (size_t i = 0; i < exact->object_count && exact->places; i++)
        memory_free(context, exact->places[i]);
    memory_free(context, exact->baked);
    memory_free(context, exact->places);
    memory_free(context, exact->instances);
    memory_free(context, exact->groups);
    memory_free(context, exact);
}

/* The mesh's vertices have moved. */
static pnb_status refit(pnb_scene *scene, struct exact_scene *exact, size_t mesh)
{
    bool torn = false;
    /* Making coarser levels anew is no work for a frame. */
    if (exact->levels[mesh] && !clusters_fit(exact->meshes[mesh], &scene->meshes[mesh])) {
        levels_destroy(scene->context, exact->levels[mesh]);
        exact->levels[mesh] = NULL;
    }
    pnb_status status = PNB_OK;
    if (exact->parts[mesh])
        status = parts_refit(scene->context, exact->parts[mesh], &scene->meshes[mesh], &torn);
    else if (exact->meshes[mesh])
        torn = !clusters_refit(exact->meshes[mesh], &scene->meshes[mesh]);
    if (status != PNB_OK || !torn)
        return status;
    clusters_destroy(scene->context, exact->meshes[mesh]);
    parts_destroy(scene->context, exact->parts[mesh]);
    exact->meshes[mesh] = NULL;
    exact->parts[mesh] = NULL;
    return create_clusters(scene, exact, mesh);
}

pnb_status exact_scene_update(pnb_scene *scene, struct exact_scene *exact, pnb_update update)
{
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < exact->mesh_count && update == PNB_UPDATE_VERTICES; i++)
        if (status == PNB_OK)
            status = refit(scene, exact, i);
    if (status == PNB_OK)
        status = reserve_instances(scene, exact);
    return status == PNB_OK ? place(scene, exact) : status;
}
