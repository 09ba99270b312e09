/* scene/write_json.c: the scene as a scene file, its meshes beside it as Wavefront OBJ.
 *
 * BASE.json refers to BASE-MESH.obj, one for each mesh that is used; characters that file systems
 * dislike become '-', and a name that is taken gets a number. Planes stay planes while they are
 * square and flat. A placement that scale, turns and shift cannot say (sheared, flattened) is baked
 * into a mesh of its own. Numbers keep every bit. Each file is written whole or not at all; when
 * one fails those already written are removed again. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include <penumbra/image.h>

#include "scene/write.h"

struct writer {
    pnb_scene *scene;
    pnb_context *context;
    const char *path;
    char *stem;   /* path without .json */
    char **files; /* mesh files written, full path */
    size_t file_count, file_capacity;
    char **file_of_mesh; /* per mesh of the scene: one of files, or NULL */
};

static void print_vector(struct buffer *out, const double *v)
{
    buffer_add(out, "[", 1);
    for (int i = 0; i < 3; i++) {
        if (i)
            buffer_add(out, ", ", 2);
        buffer_number(out, v[i]);
    }
    buffer_add(out, "]", 1);
}

static void print_member(struct buffer *out, const char *key, const double *v)
{
    buffer_print(out, ", \"%s\": ", key);
    print_vector(out, v);
}

static void print_light(struct buffer *out, const pnb_light *light)
{
    buffer_print(out, "{\"type\": \"%s\"", pnb_light_type_name(light->type));
    if (light->name && *light->name) {
        buffer_print(out, ", \"name\": ");
        buffer_json_string(out, light->name);
    }
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        print_member(out, "center", light->shape.rectangle.center);
        print_member(out, "half_u", light->shape.rectangle.half_u);
        print_member(out, "half_v", light->shape.rectangle.half_v);
        break;
    case PNB_LIGHT_DISK:
        print_member(out, "center", light->shape.disk.center);
        print_member(out, "normal", light->shape.disk.normal);
        buffer_print(out, ", \"radius\": ");
        buffer_number(out, light->shape.disk.radius);
        break;
    case PNB_LIGHT_POLYGON:
        buffer_print(out, ", \"vertices\": [");
        for (size_t i = 0; i < light->shape.polygon.vertex_count; i++) {
            if (i)
                buffer_print(out, ", ");
            print_vector(out, light->shape.polygon.vertices + 3 * i);
        }
        buffer_print(out, "]");
        break;
    case PNB_LIGHT_LINE:
        print_member(out, "from", light->shape.line.from);
        print_member(out, "to", light->shape.line.to);
        break;
    case PNB_LIGHT_POINT: print_member(out, "position", light->shape.point.position); break;
    case PNB_LIGHT_SUN:
        print_member(out, "direction", light->shape.sun.direction);
        buffer_print(out, ", \"angular_diameter_degrees\": ");
        buffer_number(out, light->shape.sun.angular_diameter_degrees);
        break;
    }
    print_member(out, "color", light->color);
    buffer_print(out, "}");
}

/* Lines of three numbers. */
static void print_floats(struct buffer *out, const char *key, const float *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        buffer_print(out, "%s", key);
        for (int c = 0; c < 3; c++) {
            buffer_add(out, " ", 1);
            buffer_float(out, values[3 * i + (size_t)c]);
        }
        buffer_add(out, "\n", 1);
    }
}

static pnb_status write_obj(struct writer *w, const struct mesh *mesh, const char *path)
{
    struct buffer out;
    buffer_init(w->context, &out);
    buffer_print(&out, "# written by penumbra %s\no mesh\n", pnb_version());
    print_floats(&out, "v", mesh->positions, mesh->vertex_count);
    if (mesh->normals)
        print_floats(&out, "vn", mesh->normals, mesh->vertex_count);
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        uint32_t a = mesh->indices[3 * i] + 1, b = mesh->indices[3 * i + 1] + 1,
                 c = mesh->indices[3 * i + 2] + 1;
        if (mesh->normals)
            buffer_print(&out, "f %u//%u %u//%u %u//%u\n", a, a, b, b, c, c);
        else
            buffer_print(&out, "f %u %u %u\n", a, b, c);
    }
    pnb_status status = out.failed ? status_no_memory(w->context, out.size)
                                   : pnb_file_write(w->context, path, out.bytes, out.size);
    buffer_finish(&out);
    return status;
}

/* Writes a mesh under a name that no other has; *out_file stays the writer's. */
static pnb_status add_file(struct writer *w, const struct mesh *mesh, char **out_file)
{
    char part[64];
    size_t used = 0;
    for (const char *c = mesh->name; *c && used < 48; c++)
        part[used++] = isalnum((unsigned char)*c) || *c == '_' ? *c : '-';
    part[used] = 0;
    size_t size = strlen(w->stem) + sizeof(part) + 32;
    char *path = memory_alloc(w->context, size, 1);
    if (!path || !memory_reserve(w->context, (void **)&w->files, &w->file_capacity, w->file_count,
                                 1, sizeof(*w->files))) {
        memory_free(w->context, path);
        return status_no_memory(w->context, size);
    }
    snprintf(path, size, "%s-%s.obj", w->stem, part);
    /* Every round that finds the name taken rules out one number, so this ends. */
    for (size_t number = w->file_count + 1, i = 0; i < w->file_count; i++)
        if (strcasecmp(w->files[i], path) == 0) {
            snprintf(path, size, "%s-%s-%zu.obj", w->stem, part, number++);
            i = (size_t)-1;
        }
    pnb_status status = write_obj(w, mesh, path);
    if (status != PNB_OK) {
        memory_free(w->context, path);
        return status;
    }
    *out_file = w->files[w->file_count++] = path;
    return PNB_OK;
}

/* A plane's point, normal and half size, if the object still is a square. */
static bool read_plane(const struct mesh *mesh, const pnb_object *object, vec3 *out_point,
                       vec3 *out_normal, double *out_half)
{
    vec3 p[4];
    if (!object->plane || mesh->vertex_count != 4 || mesh->triangle_count != 2)
        return false;
    for (int i = 0; i < 4; i++)
        p[i] = m34_point(object->world_from_mesh, v3_loadf(mesh->positions + 3 * i));
    vec3 u = v3_scale(v3_sub(p[1], p[0]), 0.5), v = v3_scale(v3_sub(p[3], p[0]), 0.5);
    double half = v3_length(u), reach = half + v3_max_abs(p[0]) + v3_max_abs(p[2]);
    vec3 point = v3_scale(v3_add(v3_add(p[0], p[1]), v3_add(p[2], p[3])), 0.25);
    vec3 normal = v3_normalize(v3_cross(u, v));
    /* Rounding of the corners to floats. */
    double slack = 1e-6 * reach;
    if (!(half > 0) || fabs(v3_length(v) - half) > slack || fabs(v3_dot(u, v)) > slack * half ||
        v3_length(v3_sub(v3_sub(p[2], p[1]), v3_sub(p[3], p[0]))) > slack)
        return false;
    /* What rounding left of zeros and ones. */
    double *n[3] = {&normal.x, &normal.y, &normal.z};
    for (int c = 0; c < 3; c++)
        if (fabs(*n[c]) < 1e-7)
            *n[c] = 0;
    *out_point = point;
    *out_normal = v3_normalize(normal);
    *out_half = half;
    return true;
}

/* Turns about x, then y, then z. */
static void turn_degrees(const double r[9], double out[3])
{
    double y = asin(fmax(-1, fmin(1, -r[6])));
    bool locked = fabs(r[6]) > 1 - 1e-12;
    double x = locked ? atan2(-r[5], r[4]) : atan2(r[7], r[8]);
    double z = locked ? 0 : atan2(r[3], r[0]);
    out[0] = x * 180 / M_PI;
    out[1] = y * 180 / M_PI;
    out[2] = z * 180 / M_PI;
    for (int i = 0; i < 3; i++)
        out[i] = out[i] == 0 ? 0 : out[i]; /* no minus zero */
}

static pnb_status print_mesh_object(struct writer *w, struct buffer *out, const pnb_object *object)
{
    const struct mesh *mesh = &w->scene->meshes[object->mesh];
    struct write_placement placement;
    char *file = NULL;
    bool plain = write_decompose(object->world_from_mesh, &placement);
    if (plain) {
        file = w->file_of_mesh[object->mesh];
        pnb_status status = file ? PNB_OK : add_file(w, mesh, &file);
        if (status != PNB_OK)
            return status;
        w->file_of_mesh[object->mesh] = file;
    } else {
        struct mesh baked;
        pnb_status status = write_bake(w->context, mesh, object->world_from_mesh, &baked);
        if (status != PNB_OK)
            return status;
        status = add_file(w, &baked, &file);
        mesh_finish(w->context, &baked);
        if (status != PNB_OK)
            return status;
    }
    const char *slash = strrchr(file, '/');
    buffer_print(out, ", \"mesh\": ");
    buffer_json_string(out, slash ? slash + 1 : file);
    if (!plain)
        return PNB_OK;
    const double *s = placement.scale, *t = placement.translate;
    double degrees[3];
    turn_degrees(placement.turn, degrees);
    if (fabs(s[0] - 1) > 1e-12 || fabs(s[1] - 1) > 1e-12 || fabs(s[2] - 1) > 1e-12) {
        if (fabs(s[1] - s[0]) <= 1e-12 * s[0] && fabs(s[2] - s[0]) <= 1e-12 * s[0]) {
            buffer_print(out, ", \"scale\": ");
            buffer_number(out, s[0]);
        } else {
            print_member(out, "scale", s);
        }
    }
    if (degrees[0] != 0 || degrees[1] != 0 || degrees[2] != 0)
        print_member(out, "rotate_degrees", degrees);
    if (t[0] != 0 || t[1] != 0 || t[2] != 0)
        print_member(out, "translate", t);
    return PNB_OK;
}

static pnb_status print_object(struct writer *w, struct buffer *out, const pnb_object *object)
{
    vec3 point, normal;
    double half, numbers[3];
    buffer_print(out, "{\"name\": ");
    buffer_json_string(out, object->name);
    if (read_plane(&w->scene->meshes[object->mesh], object, &point, &normal, &half)) {
        v3_store(numbers, point);
        buffer_print(out, ", \"plane\": {\"point\": ");
        print_vector(out, numbers);
        v3_store(numbers, normal);
        print_member(out, "normal", numbers);
        buffer_print(out, ", \"half_size\": ");
        buffer_number(out, half);
        buffer_print(out, "}");
    } else {
        pnb_status status = print_mesh_object(w, out, object);
        if (status != PNB_OK)
            return status;
    }
    print_member(out, "color", object->color);
    if (!object->casts)
        buffer_print(out, ", \"casts\": false");
    if (!object->receives)
        buffer_print(out, ", \"receives\": false");
    buffer_print(out, "}");
    return PNB_OK;
}

static pnb_status print_scene(struct writer *w, struct buffer *out)
{
    const pnb_scene *scene = w->scene;
    buffer_print(out, "{\n  \"camera\": {\"eye\": ");
    print_vector(out, scene->camera.eye);
    print_member(out, "target", scene->camera.target);
    print_member(out, "up", scene->camera.up);
    buffer_print(out, ", \"vertical_fov_degrees\": ");
    buffer_number(out, scene->camera.vertical_fov_degrees);
    buffer_print(out, "},\n  \"ambient\": ");
    print_vector(out, scene->ambient);
    buffer_print(out, ",\n  \"background\": ");
    print_vector(out, scene->background);
    if (scene->exposure > 0) {
        buffer_print(out, ",\n  \"exposure\": ");
        buffer_number(out, scene->exposure);
    }
    buffer_print(out, ",\n  \"lights\": [");
    for (size_t i = 0; i < scene->light_count; i++) {
        buffer_print(out, "%s\n    ", i ? "," : "");
        print_light(out, &scene->lights[i]);
    }
    buffer_print(out, "%s],\n  \"objects\": [", scene->light_count ? "\n  " : "");
    for (size_t i = 0; i < scene->object_count; i++) {
        buffer_print(out, "%s\n    ", i ? "," : "");
        pnb_status status = print_object(w, out, &scene->objects[i].info);
        if (status != PNB_OK)
            return status;
    }
    buffer_print(out, "\n  ]\n}\n");
    return out->failed ? status_no_memory(w->context, out->size) : PNB_OK;
}

pnb_status pnb_scene_write_json(pnb_scene *scene, const char *path)
{
    pnb_context *context = scene->context;
    struct writer w = {.scene = scene, .context = context, .path = path};
    struct buffer out;
    if (!path)
        return status_missing(context, "path");
    if (scene->object_count == 0)
        return status_fail(context, PNB_ERROR_SCENE, path, "the scene has no object");
    w.stem = memory_strdup(context, path);
    w.file_of_mesh = memory_calloc(context, scene->mesh_count, sizeof(char *));
    buffer_init(context, &out);
    pnb_status status = PNB_OK;
    if (!w.stem || !w.file_of_mesh)
        status = status_no_memory(context, strlen(path));
    if (status == PNB_OK) {
        size_t length = strlen(path);
        if (length > 5 && strcasecmp(path + length - 5, ".json") == 0)
            w.stem[length - 5] = 0;
        status = print_scene(&w, &out);
    }
    if (status == PNB_OK)
        status = pnb_file_write(context, path, out.bytes, out.size);
    for (size_t i = 0; i < w.file_count; i++) {
        if (status != PNB_OK)
            unlink(w.files[i]);
        memory_free(context, w.files[i]);
    }
    buffer_finish(&out);
    memory_free(context, w.files);
    memory_free(context, w.file_of_mesh);
    memory_free(context, w.stem);
    return status;
}
