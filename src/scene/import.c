/* scene/import.c: scenes and meshes from files that the importer reads.
 *
 * scene_import():      objects with their placements (a mesh shown by several nodes is kept once),
 *                      base colours, the first camera, lights, emissive flat parts as lights; what
 *                      is missing is supplied.
 * scene_import_mesh(): every triangle of the file in one mesh, placements applied.
 *
 * A file either gives a scene that passes every check of pnb_scene_add_*, or an error that names
 * it. Lights that mean nothing (no area, say) are left out with a note: the file may be fine
 * without. */
#include "scene/import.h"

#include <string.h>

#define NOTES_MAX            32         /* of one file; the rest is counted */
#define MERGED_TRIANGLES_MAX (1u << 27) /* of one merged mesh: instances multiply */

/* "FILE: what the context's last error says". */
static pnb_status fail_in_file(pnb_context *context, pnb_status status, const char *file)
{
    char why[sizeof(context->error)];
    memcpy(why, context->error, sizeof(why));
    why[sizeof(why) - 1] = 0;
    return status_fail(context, status, file, "%s", why);
}

/* File name without folder and ending, cut to what a name may be; the caller's buffer. */
static const char *base_name(const char *path, char *buffer, size_t size)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    const char *dot = strrchr(base, '.');
    size_t length = dot && dot != base ? (size_t)(dot - base) : strlen(base);
    if (length >= size)
        length = size - 1;
    memcpy(buffer, base, length);
    buffer[length] = 0;
    return buffer;
}

static double clamp_albedo(double value)
{
    return value < 0 ? 0 : value > 1 ? 1 : value; /* NaN stays, and is refused with its object */
}

static pnb_status add_objects(pnb_scene *scene, const struct scene_import_data *data)
{
    for (size_t i = 0; i < data->mesh_count; i++) {
        const struct scene_import_mesh *mesh = &data->meshes[i];
        pnb_mesh_desc desc = {mesh->name,         mesh->positions, mesh->normals,
                              mesh->vertex_count, mesh->indices,   mesh->triangle_count};
        pnb_status status = pnb_scene_add_mesh(scene, &desc, NULL);
        if (status != PNB_OK)
            return status;
    }
    for (size_t i = 0; i < data->object_count; i++) {
        const struct scene_import_object *from = &data->objects[i];
        pnb_object object = {.name = from->name,
                             .mesh = from->mesh,
                             .casts = from->casts,
                             .receives = from->receives,
                             .plane = from->plane};
        memcpy(object.world_from_mesh, from->world_from_mesh, sizeof(object.world_from_mesh));
        for (int c = 0; c < 3; c++)
            object.color[c] = clamp_albedo(from->color[c]);
        for (int c = 0; c < 3; c++)
            object.emission[c] = from->emission[c] > 0 ? from->emission[c] : 0;
        pnb_status status = pnb_scene_add_object(scene, &object, NULL);
        if (status != PNB_OK)
            return status;
    }
    return PNB_OK;
}

static void set_surroundings(pnb_scene *scene, const struct scene_import_data *data)
{
    bool fine = data->has_surroundings;
    for (int c = 0; c < 3; c++)
        fine = fine && isfinite(data->ambient[c]) && data->ambient[c] >= 0 &&
               isfinite(data->background[c]) && data->background[c] >= 0;
    if (!fine)
        return;
    pnb_scene_set_ambient(scene, data->ambient);
    pnb_scene_set_background(scene, data->background);
}

static pnb_status add_lights(pnb_scene *scene, const struct scene_import_data *data)
{
    pnb_context *context = scene->context;
    for (size_t i = 0; i < data->light_count; i++) {
        pnb_status status = pnb_scene_add_light(scene, &data->lights[i], NULL);
        if (status == PNB_ERROR_SCENE)
            scene_note(scene, "light '%s' is left out: %s", data->lights[i].name,
                       pnb_context_error(context));
        else if (status != PNB_OK)
            return status;
    }
    for (size_t i = 0; i < data->object_count; i++) {
        const double *emission = data->objects[i].emission;
        if (!(emission[0] > 0 || emission[1] > 0 || emission[2] > 0))
            continue;
        pnb_status status = scene_import_emissive(scene, data, i);
        if (status != PNB_OK)
            return status;
    }
    return PNB_OK;
}

/* The first camera that means something becomes the scene's. Its target is the point of its axis
 * that is nearest to the middle of the scene. */
static bool add_camera(pnb_scene *scene, const struct scene_import_data *data)
{
    double low[3], high[3];
    if (!pnb_scene_bounds(scene, low, high))
        return false;
    vec3 middle = v3_scale(v3_add(v3_load(low), v3_load(high)), 0.5);
    double extent = v3_length(v3_sub(v3_load(high), v3_load(low)));
    for (size_t i = 0; i < data->camera_count; i++) {
        const struct scene_import_camera *from = &data->cameras[i];
        pnb_camera camera = {.vertical_fov_degrees = from->vertical_fov_degrees};
        vec3 eye = v3_load(from->eye), forward = v3_normalize(v3_load(from->direction));
        double distance = v3_dot(v3_sub(middle, eye), forward);
        if (!(distance > 0.05 * extent))
            distance = extent > 0 ? 0.05 * extent : 1;
        v3_store(camera.eye, eye);
        v3_store(camera.target, v3_mad(eye, forward, distance));
        v3_store(camera.up, v3_load(from->up));
        if (pnb_scene_set_camera(scene, &camera) != PNB_OK) {
            scene_note(scene, "a camera is left out: %s", pnb_context_error(scene->context));
            continue;
        }
        if (i + 1 < data->camera_count)
            scene_note(scene, "%zu more cameras are left out: the first one is used",
                       data->camera_count - i - 1);
        return true;
    }
    return false;
}

/* from: NULL, or the name of the file that the notes are about. */
static void add_notes(pnb_scene *scene, const struct scene_import_data *data, const char *from)
{
    size_t count = data->note_count < NOTES_MAX ? data->note_count : NOTES_MAX;
    for (size_t i = 0; i < count; i++)
        scene_note(scene, "%s%s%s", from ? from : "", from ? ": " : "", data->notes[i]);
    if (count < data->note_count)
        scene_note(scene, "%s%s%zu more remarks", from ? from : "", from ? ": " : "",
                   data->note_count - count);
}

pnb_status scene_import_assemble(pnb_context *context, const char *file,
                                 const struct scene_import_data *data, pnb_scene **out_scene)
{
    char name[256];
    *out_scene = NULL;
    size_t triangles = 0;
    for (size_t i = 0; i < data->object_count && triangles == 0; i++)
        triangles = data->meshes[data->objects[i].mesh].triangle_count;
    if (triangles == 0)
        return status_fail(context, PNB_ERROR_FORMAT, file, "no triangles in it");
    pnb_scene *scene;
    pnb_status status = pnb_scene_create(context, &scene);
    if (status != PNB_OK)
        return status;
    add_notes(scene, data, NULL);
    set_surroundings(scene, data);
    status = scene_set_name(scene, base_name(file, name, sizeof(name)));
    if (status == PNB_OK)
        status = add_objects(scene, data);
    if (status == PNB_OK)
        status = add_lights(scene, data);
    if (status == PNB_OK)
        status = scene_supply(scene, add_camera(scene, data));
    if (status != PNB_OK) {
        pnb_scene_destroy(scene);
        return fail_in_file(context, status, file);
    }
    *out_scene = scene;
    return PNB_OK;
}

pnb_status scene_import_within(pnb_context *context, const char *path,
                               const struct scene_import_limits *limits, pnb_scene **out_scene)
{
    unsigned char *bytes;
    size_t size;
    struct scene_import_data data;
    *out_scene = NULL;
    pnb_status status = scene_import_run(context, path, limits, &bytes, &size);
    if (status != PNB_OK)
        return status;
    status = scene_import_decode(context, path, bytes, size, &data);
    if (status == PNB_OK) {
        status = scene_import_assemble(context, path, &data, out_scene);
        scene_import_data_finish(context, &data);
    }
    memory_free(context, bytes);
    return status;
}

pnb_status scene_import(pnb_context *context, const char *path, pnb_scene **out_scene)
{
    return scene_import_within(context, path, NULL, out_scene);
}

/* Arrays of a mesh under construction. */
struct merged {
    float *positions, *normals;
    uint32_t *indices;
    size_t vertex_count, triangle_count;
    bool any_normals;
};

/* Sizes of all objects together. */
static pnb_status merged_init(pnb_context *context, const char *file,
                              const struct scene_import_data *data, struct merged *merged)
{
    size_t vertices = 0, triangles = 0;
    memset(merged, 0, sizeof(*merged));
    for (size_t i = 0; i < data->object_count; i++) {
        const struct scene_import_mesh *mesh = &data->meshes[data->objects[i].mesh];
        vertices += mesh->vertex_count;
        triangles += mesh->triangle_count;
        merged->any_normals = merged->any_normals || mesh->normals;
        if (triangles > MERGED_TRIANGLES_MAX || vertices > MERGED_TRIANGLES_MAX)
            return status_fail(context, PNB_ERROR_MEMORY, file,
                               "more than %u triangles as one mesh", MERGED_TRIANGLES_MAX);
    }
    if (triangles == 0)
        return status_fail(context, PNB_ERROR_FORMAT, file, "no triangles in it");
    merged->positions = memory_alloc(context, vertices, 12);
    merged->normals = merged->any_normals ? memory_calloc(context, vertices, 12) : NULL;
    merged->indices = memory_alloc(context, triangles, 12);
    if (!merged->positions || !merged->indices || (merged->any_normals && !merged->normals))
        return status_no_memory(context, vertices * 24 + triangles * 12);
    return PNB_OK;
}

static void merged_finish(pnb_context *context, struct merged *merged)
{
    memory_free(context, merged->positions);
    memory_free(context, merged->normals);
    memory_free(context, merged->indices);
}

/* Appends one object in world space. Triangles keep their front: a mirroring placement turns them
 * round. Where only some objects have normals, those of the others stay zero, which reads as flat.
 */
static pnb_status merged_add(pnb_context *context, const char *file, struct merged *merged,
                             const struct scene_import_object *object,
                             const struct scene_import_mesh *mesh)
{
    const double *m = object->world_from_mesh;
    size_t first = merged->vertex_count;
    for (size_t i = 0; i < mesh->vertex_count; i++) {
        vec3 p = m34_point(m, v3_loadf(mesh->positions + 3 * i));
        v3_storef(merged->positions + 3 * (first + i), p);
        if (mesh->normals)
            v3_storef(merged->normals + 3 * (first + i),
                      v3_normalize(m34_normal(m, v3_loadf(mesh->normals + 3 * i))));
    }
    bool mirrored = m34_det(m) < 0;
    uint32_t *out = merged->indices + 3 * merged->triangle_count;
    for (size_t i = 0; i < mesh->triangle_count * 3; i++) {
        if (mesh->indices[i] >= mesh->vertex_count)
            return status_fail(context, PNB_ERROR_SCENE, file,
                               "mesh '%s': triangle %zu refers to vertex %u of %zu", mesh->name,
                               i / 3, mesh->indices[i], mesh->vertex_count);
        size_t corner = mirrored ? i - i % 3 + 2 - i % 3 : i;
        out[corner] = (uint32_t)(first + mesh->indices[i]);
    }
    merged->vertex_count += mesh->vertex_count;
    merged->triangle_count += mesh->triangle_count;
    return PNB_OK;
}

static pnb_status merge(pnb_scene *scene, const char *path, const struct scene_import_data *data,
                        size_t *out_mesh)
{
    char name[256];
    struct merged merged;
    pnb_context *context = scene->context;
    pnb_status status = merged_init(context, path, data, &merged);
    for (size_t i = 0; i < data->object_count && status == PNB_OK; i++)
        status = merged_add(context, path, &merged, &data->objects[i],
                            &data->meshes[data->objects[i].mesh]);
    if (status == PNB_OK) {
        pnb_mesh_desc desc = {base_name(path, name, sizeof(name)),
                              merged.positions,
                              merged.normals,
                              merged.vertex_count,
                              merged.indices,
                              merged.triangle_count};
        status = pnb_scene_add_mesh(scene, &desc, out_mesh);
        if (status != PNB_OK)
            status = fail_in_file(context, status, path);
    }
    if (status == PNB_OK)
        add_notes(scene, data, name);
    merged_finish(context, &merged);
    return status;
}

pnb_status scene_import_mesh(pnb_scene *scene, const char *path, size_t *out_mesh)
{
    unsigned char *bytes;
    size_t size;
    struct scene_import_data data;
    pnb_status status = scene_import_run(scene->context, path, NULL, &bytes, &size);
    if (status != PNB_OK)
        return status;
    status = scene_import_decode(scene->context, path, bytes, size, &data);
    if (status == PNB_OK) {
        status = merge(scene, path, &data, out_mesh);
        scene_import_data_finish(scene->context, &data);
    }
    memory_free(scene->context, bytes);
    return status;
}
