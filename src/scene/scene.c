/* scene/scene.c: the scene as a container: what is added is checked and copied. */
#include "scene/scene.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "geom/tolerance.h"

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

pnb_status pnb_scene_create(pnb_context *context, pnb_scene **out_scene)
{
    *out_scene = NULL;
    pnb_scene *scene = memory_calloc(context, 1, sizeof(*scene));
    if (!scene)
        return status_no_memory(context, sizeof(*scene));
    scene->context = context;
    scene->camera = (pnb_camera){{0, 2, 6}, {0, 0.5, 0}, {0, 1, 0}, 45};
    for (int c = 0; c < 3; c++) {
        scene->ambient[c] = 0.15;
        scene->background[c] = 1;
    }
    if (scene_set_name(scene, "scene") != PNB_OK) {
        pnb_scene_destroy(scene);
        return PNB_ERROR_MEMORY;
    }
    *out_scene = scene;
    return PNB_OK;
}

static void light_finish(pnb_context *context, pnb_light *light)
{
    memory_free(context, (char *)light->name);
    if (light->type == PNB_LIGHT_POLYGON)
        memory_free(context, (double *)light->shape.polygon.vertices);
}

void pnb_scene_destroy(pnb_scene *scene)
{
    if (!scene)
        return;
    pnb_context *context = scene->context;
    for (size_t i = 0; i < scene->mesh_count; i++)
        mesh_finish(context, &scene->meshes[i]);
    for (size_t i = 0; i < scene->object_count; i++)
        memory_free(context, (char *)scene->objects[i].info.name);
    pnb_scene_clear_lights(scene);
    for (size_t i = 0; i < scene->note_count; i++)
        memory_free(context, scene->notes[i]);
    memory_free(context, scene->meshes);
    memory_free(context, scene->objects);
    memory_free(context, scene->lights);
    memory_free(context, scene->notes);
    memory_free(context, scene->name);
    memory_free(context, scene);
}

pnb_status scene_set_name(pnb_scene *scene, const char *name)
{
    char *copy = memory_strdup(scene->context, name);
    if (!copy)
        return status_no_memory(scene->context, strlen(name) + 1);
    memory_free(scene->context, scene->name);
    scene->name = copy;
    return PNB_OK;
}

void scene_note(pnb_scene *scene, const char *format, ...)
{
    char text[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    if (!memory_reserve(scene->context, (void **)&scene->notes, &scene->note_capacity,
                        scene->note_count, 1, sizeof(*scene->notes)))
        return;
    char *copy = memory_strdup(scene->context, text);
    if (copy)
        scene->notes[scene->note_count++] = copy;
}

pnb_status pnb_scene_add_mesh(pnb_scene *scene, const pnb_mesh_desc *mesh, size_t *out_index)
{
    if (!mesh)
        return status_missing(scene->context, "mesh");
    if (!memory_reserve(scene->context, (void **)&scene->meshes, &scene->mesh_capacity,
                        scene->mesh_count, 1, sizeof(*scene->meshes)))
        return status_no_memory(scene->context, sizeof(*scene->meshes));
    pnb_status status = mesh_init(scene->context, &scene->meshes[scene->mesh_count], mesh);
    if (status != PNB_OK)
        return status;
    if (out_index)
        *out_index = scene->mesh_count;
    scene->mesh_count++;
    scene->geometry_version++;
    return PNB_OK;
}

static pnb_status check_placement(pnb_scene *scene, const char *name, const double *m)
{
    for (int i = 0; i < 12; i++)
        if (!isfinite(m[i]))
            return status_fail(scene->context, PNB_ERROR_SCENE, name,
                               "its placement is not finite");
    return PNB_OK;
}

/* Every vertex must stay finite as a float in world space. */
static pnb_status check_reach(pnb_scene *scene, const char *name, const struct mesh *mesh,
                              const double *m)
{
    vec3 low, high;
    mesh_bounds(mesh, &low, &high);
    for (int corner = 0; corner < 8 && mesh->triangle_count > 0; corner++) {
        vec3 p = v3(corner & 1 ? high.x : low.x, corner & 2 ? high.y : low.y,
                    corner & 4 ? high.z : low.z);
        if (!(v3_max_abs(m34_point(m, p)) < 1e18))
            return status_fail(scene->context, PNB_ERROR_SCENE, name, "coordinates beyond 1e18");
    }
    return PNB_OK;
}

pnb_status pnb_scene_add_object(pnb_scene *scene, const pnb_object *object, size_t *out_index)
{
    pnb_context *context = scene->context;
    if (!object)
        return status_missing(context, "object");
    const char *name = object->name && *object->name ? object->name : "object";
    if (object->mesh >= scene->mesh_count)
        return status_fail(context, PNB_ERROR_ARGUMENT, name, "mesh %zu does not exist",
                           object->mesh);
    pnb_object copy = *object;
    bool unset = true;
    for (int i = 0; i < 12; i++)
        unset = unset && copy.world_from_mesh[i] == 0;
    if (unset)
        memcpy(copy.world_from_mesh, identity, sizeof(identity));
    for (int c = 0; c < 3; c++)
        if (!isfinite(copy.color[c]) || !isfinite(copy.emission[c]))
            return status_fail(context, PNB_ERROR_SCENE, name, "its colour is not finite");
    pnb_status status = check_placement(scene, name, copy.world_from_mesh);
    if (status == PNB_OK)
        status = check_reach(scene, name, &scene->meshes[copy.mesh], copy.world_from_mesh);
    if (status != PNB_OK)
        return status;
    if (!memory_reserve(context, (void **)&scene->objects, &scene->object_capacity,
                        scene->object_count, 1, sizeof(*scene->objects)) ||
        !(copy.name = memory_strdup(context, name)))
        return status_no_memory(context, sizeof(*scene->objects));
    scene->objects[scene->object_count].info = copy;
    if (out_index)
        *out_index = scene->object_count;
    scene->object_count++;
    scene->geometry_version++;
    return PNB_OK;
}

static pnb_status light_copy(pnb_scene *scene, const pnb_light *light, pnb_light *out_copy)
{
    pnb_context *context = scene->context;
    pnb_status status = pnb_light_check(context, light);
    if (status != PNB_OK)
        return status;
    *out_copy = *light;
    if (light->name && !(out_copy->name = memory_strdup(context, light->name)))
        return status_no_memory(context, strlen(light->name));
    if (light->type == PNB_LIGHT_POLYGON) {
        size_t count = light->shape.polygon.vertex_count;
        double *vertices = memory_alloc(context, count * 3, sizeof(double));
        if (!vertices) {
            memory_free(context, (char *)out_copy->name);
            return status_no_memory(context, count * 3 * sizeof(double));
        }
        memcpy(vertices, light->shape.polygon.vertices, count * 3 * sizeof(double));
        out_copy->shape.polygon.vertices = vertices;
    }
    return PNB_OK;
}

pnb_status pnb_scene_add_light(pnb_scene *scene, const pnb_light *light, size_t *out_index)
{
    if (!memory_reserve(scene->context, (void **)&scene->lights, &scene->light_capacity,
                        scene->light_count, 1, sizeof(*scene->lights)))
        return status_no_memory(scene->context, sizeof(*scene->lights));
    pnb_status status = light_copy(scene, light, &scene->lights[scene->light_count]);
    if (status != PNB_OK)
        return status;
    if (out_index)
        *out_index = scene->light_count;
    scene->light_count++;
    return PNB_OK;
}

pnb_status pnb_scene_set_light(pnb_scene *scene, size_t index, const pnb_light *light)
{
    if (index >= scene->light_count)
        return status_fail(scene->context, PNB_ERROR_ARGUMENT, "light", "light %zu does not exist",
                           index);
    pnb_light copy;
    pnb_status status = light_copy(scene, light, &copy);
    if (status != PNB_OK)
        return status;
    light_finish(scene->context, &scene->lights[index]);
    scene->lights[index] = copy;
    return PNB_OK;
}

void pnb_scene_clear_lights(pnb_scene *scene)
{
    for (size_t i = 0; i < scene->light_count; i++)
        light_finish(scene->context, &scene->lights[i]);
    scene->light_count = 0;
}

pnb_status pnb_scene_set_camera(pnb_scene *scene, const pnb_camera *camera)
{
    if (!camera)
        return status_missing(scene->context, "camera");
    vec3 eye = v3_load(camera->eye), target = v3_load(camera->target), up = v3_load(camera->up);
    vec3 forward = v3_sub(target, eye);
    if (!v3_finite(eye) || !v3_finite(target) || !v3_finite(up))
        return status_fail(scene->context, PNB_ERROR_SCENE, "camera",
                           "eye, target or up is not finite");
    if (!(v3_length(forward) > 0) || !isfinite(v3_length(forward)))
        return status_fail(scene->context, PNB_ERROR_SCENE, "camera",
                           "eye and target are the same point");
    if (!(v3_length(v3_cross(v3_normalize(forward), v3_normalize(up))) > 1e-6))
        return status_fail(scene->context, PNB_ERROR_SCENE, "camera",
                           "up is zero or along the view");
    if (!(camera->vertical_fov_degrees > 0 && camera->vertical_fov_degrees < 180))
        return status_fail(scene->context, PNB_ERROR_SCENE, "camera",
                           "vertical_fov_degrees must lie between 0 and 180");
    scene->camera = *camera;
    return PNB_OK;
}

void pnb_scene_set_ambient(pnb_scene *scene, const double ambient[3])
{
    memcpy(scene->ambient, ambient, sizeof(scene->ambient));
}

void pnb_scene_set_background(pnb_scene *scene, const double background[3])
{
    memcpy(scene->background, background, sizeof(scene->background));
}

void pnb_scene_set_exposure(pnb_scene *scene, double exposure)
{
    scene->exposure = exposure;
}

pnb_status pnb_scene_set_placement(pnb_scene *scene, size_t object,
                                   const double world_from_mesh[12])
{
    if (object >= scene->object_count)
        return status_fail(scene->context, PNB_ERROR_ARGUMENT, "object",
                           "object %zu does not exist", object);
    if (!world_from_mesh)
        return status_missing(scene->context, "world_from_mesh");
    pnb_object *info = &scene->objects[object].info;
    pnb_status status = check_placement(scene, info->name, world_from_mesh);
    if (status == PNB_OK)
        status = check_reach(scene, info->name, &scene->meshes[info->mesh], world_from_mesh);
    if (status != PNB_OK)
        return status;
    memcpy(info->world_from_mesh, world_from_mesh, sizeof(info->world_from_mesh));
    scene->placement_version++;
    return PNB_OK;
}

pnb_status pnb_scene_set_vertices(pnb_scene *scene, size_t mesh_index, const float *positions,
                                  const float *normals)
{
    if (mesh_index >= scene->mesh_count)
        return status_fail(scene->context, PNB_ERROR_ARGUMENT, "mesh", "mesh %zu does not exist",
                           mesh_index);
    struct mesh *mesh = &scene->meshes[mesh_index];
    pnb_mesh_desc desc = {mesh->name,         positions,     normals,
                          mesh->vertex_count, mesh->indices, mesh->triangle_count};
    struct mesh changed;
    pnb_status status = mesh_init(scene->context, &changed, &desc);
    if (status != PNB_OK)
        return status;
    mesh_finish(scene->context, mesh);
    *mesh = changed;
    scene->geometry_version++;
    return PNB_OK;
}

const char *pnb_scene_name(const pnb_scene *scene)
{
    return scene->name;
}

size_t pnb_scene_mesh_count(const pnb_scene *scene)
{
    return scene->mesh_count;
}

size_t pnb_scene_object_count(const pnb_scene *scene)
{
    return scene->object_count;
}

size_t pnb_scene_light_count(const pnb_scene *scene)
{
    return scene->light_count;
}

size_t pnb_scene_note_count(const pnb_scene *scene)
{
    return scene->note_count;
}

const char *pnb_scene_note(const pnb_scene *scene, size_t index)
{
    return index < scene->note_count ? scene->notes[index] : "";
}

void pnb_scene_mesh(const pnb_scene *scene, size_t index, pnb_mesh_desc *out_mesh)
{
    static const struct mesh none;
    const struct mesh *mesh = index < scene->mesh_count ? &scene->meshes[index] : &none;
    *out_mesh = (pnb_mesh_desc){mesh->name,         mesh->positions, mesh->normals,
                                mesh->vertex_count, mesh->indices,   mesh->triangle_count};
}

void pnb_scene_object(const pnb_scene *scene, size_t index, pnb_object *out_object)
{
    *out_object = index < scene->object_count ? scene->objects[index].info : (pnb_object){0};
}

void pnb_scene_light(const pnb_scene *scene, size_t index, pnb_light *out_light)
{
    *out_light = index < scene->light_count ? scene->lights[index] : (pnb_light){0};
}

void pnb_scene_camera(const pnb_scene *scene, pnb_camera *out_camera)
{
    *out_camera = scene->camera;
}

void pnb_scene_ambient(const pnb_scene *scene, double out_ambient[3])
{
    memcpy(out_ambient, scene->ambient, sizeof(scene->ambient));
}

void pnb_scene_background(const pnb_scene *scene, double out_background[3])
{
    memcpy(out_background, scene->background, sizeof(scene->background));
}

pnb_status pnb_scene_mesh_info(pnb_scene *scene, size_t index, pnb_mesh_info *out_info)
{
    memset(out_info, 0, sizeof(*out_info));
    if (index >= scene->mesh_count)
        return status_fail(scene->context, PNB_ERROR_ARGUMENT, "mesh", "mesh %zu does not exist",
                           index);
    struct mesh *mesh = &scene->meshes[index];
    const struct mesh_edges *edges;
    pnb_status status = mesh_get_edges(scene->context, mesh, &edges);
    if (status != PNB_OK)
        return status;
    *out_info = (pnb_mesh_info){
        .name = mesh->name,
        .vertex_count = mesh->vertex_count,
        .triangle_count = mesh->triangle_count,
        .welded_vertex_count = edges->welded_count,
        .edge_count = edges->edge_count,
        .open_edge_count = edges->open_count,
        .non_manifold_edge_count = edges->non_manifold_count,
        .inconsistent_edge_count = edges->inconsistent_count,
        .degenerate_triangle_count = edges->degenerate_triangle_count,
        .closed = mesh->triangle_count > 0 && edges->open_count == 0 &&
                  edges->non_manifold_count == 0 && edges->inconsistent_count == 0,
    };
    vec3 low, high;
    mesh_bounds(mesh, &low, &high);
    v3_store(out_info->bounds_min, low);
    v3_store(out_info->bounds_max, high);
    return PNB_OK;
}

bool pnb_scene_bounds(const pnb_scene *scene, double out_min[3], double out_max[3])
{
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3(-INFINITY, -INFINITY, -INFINITY);
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        vec3 a, b;
        mesh_bounds(&scene->meshes[object->mesh], &a, &b);
        for (int corner = 0; corner < 8 && a.x <= b.x; corner++) {
            vec3 p = m34_point(
                object->world_from_mesh,
                v3(corner & 1 ? b.x : a.x, corner & 2 ? b.y : a.y, corner & 4 ? b.z : a.z));
            low = v3_min(low, p);
            high = v3_max(high, p);
        }
    }
    v3_store(out_min, low);
    v3_store(out_max, high);
    return low.x <= high.x;
}

size_t pnb_scene_triangle_count(const pnb_scene *scene)
{
    size_t count = 0;
    for (size_t i = 0; i < scene->object_count; i++)
        count += scene->meshes[scene->objects[i].info.mesh].triangle_count;
    return count;
}

double scene_receiver_lift(const pnb_scene *scene)
{
    double low[3], high[3];
    if (!pnb_scene_bounds(scene, low, high))
        return 0;
    return TOLERANCE_RECEIVER_LIFT * fmax(v3_max_abs(v3_load(low)), v3_max_abs(v3_load(high)));
}

void scene_frame_camera(vec3 bounds_min, vec3 bounds_max, vec3 direction, pnb_camera *out_camera)
{
    vec3 center = v3_scale(v3_add(bounds_min, bounds_max), 0.5);
    double radius = 0.5 * v3_length(v3_sub(bounds_max, bounds_min));
    if (!(radius > 0))
        radius = 1;
    const double fov = 45;
    double distance = radius / sin(0.5 * fov * M_PI / 180);
    v3_store(out_camera->target, center);
    v3_store(out_camera->eye, v3_mad(center, v3_normalize(direction), distance));
    v3_store(out_camera->up, v3(0, 1, 0));
    out_camera->vertical_fov_degrees = fov;
}

pnb_status scene_add_plane(pnb_scene *scene, const char *name, vec3 point, vec3 normal,
                           double half_size, const double color[3], size_t *out_object)
{
    if (!v3_finite(point) || !v3_finite(normal) || !(v3_length(normal) > 0))
        return status_fail(scene->context, PNB_ERROR_SCENE, name,
                           "plane without a point or normal");
    if (!isfinite(half_size) || !(half_size > 0))
        return status_fail(scene->context, PNB_ERROR_SCENE, name, "half_size must be above zero");
    vec3 n = v3_normalize(normal), u, v;
    /* A ground plane's sides run along x and z. */
    if (fabs(n.y) > 0.999999) {
        u = v3(1, 0, 0);
        v = v3_cross(n, u);
    } else {
        v3_frame(n, &u, &v);
    }
    float positions[12];
    static const int side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 4; i++)
        v3_storef(positions + 3 * i,
                  v3_mad(v3_mad(point, u, half_size * side[i][0]), v, half_size * side[i][1]));
    pnb_mesh_desc mesh = {name, positions, NULL, 4, indices, 2};
    pnb_object object = {.name = name, .casts = true, .receives = true, .plane = true};
    memcpy(object.color, color, sizeof(object.color));
    pnb_status status = pnb_scene_add_mesh(scene, &mesh, &object.mesh);
    if (status == PNB_OK)
        status = pnb_scene_add_object(scene, &object, out_object);
    return status;
}
