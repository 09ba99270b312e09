/* scene/scene_file.c: reads the scene file.
 *
 * JSON by Jansson, then a strict walk: every key is known, every value has its type, every number
 * is finite and below 1e18 in size, else one line says
 *
 *     FILE: line 3, column 7: '}' expected near 'x'          (syntax)
 *     FILE: lights[1].radiuss: unknown key (known here: ...)  (meaning)
 *
 * What may be left out: `up` and `vertical_fov_degrees` of a camera (Y, 45), the camera (it frames
 * the objects; a note says so), the lights (a rectangle above and to the side; a note says so; an
 * empty list stays empty), names, colours (lights 1, objects 0.8), placements. Objects are a must.
 * The same mesh named by several objects is imported once. Time is linear in the text, nesting is
 * limited by Jansson (2,048). */
#include "scene/scene_file.h"

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* Where we are in the file: a chain up to the root, printed when something is wrong. */
struct place {
    const struct place *up;
    const char *key; /* NULL: an element of an array */
    size_t index;
};

struct known_mesh {
    const char *path; /* as the file says it; the JSON tree's */
    size_t mesh;
};

struct reader {
    pnb_context *context;
    pnb_scene *scene;
    const struct scene_file_source *source;
    struct known_mesh *meshes;
    size_t mesh_count, mesh_capacity;
};

/* Prints the place as lights[1].radius; returns the used length (cut at size). */
static size_t place_print(const struct place *place, char *text, size_t size)
{
    size_t used = place->up ? place_print(place->up, text, size) : 0;
    int more = 0;
    if (place->key)
        more = snprintf(text + used, size - used, "%s%.80s", used ? "." : "", place->key);
    else if (place->up)
        more = snprintf(text + used, size - used, "[%zu]", place->index);
    used += more > 0 ? (size_t)more : 0;
    return used < size ? used : size - 1;
}

static pnb_status fail_at(struct reader *r, const struct place *place, const char *why, ...)
    __attribute__((format(printf, 3, 4)));
static pnb_status fail_at(struct reader *r, const struct place *place, const char *why, ...)
{
    char where[256] = "", reason[640];
    va_list arguments;
    va_start(arguments, why);
    vsnprintf(reason, sizeof(reason), why, arguments);
    va_end(arguments);
    if (place_print(place, where, sizeof(where)) == 0)
        return status_fail(r->context, PNB_ERROR_SCENE, r->source->file, "%s", reason);
    return status_fail(r->context, PNB_ERROR_SCENE, r->source->file, "%s: %s", where, reason);
}

/* An error of a call that knows neither file nor place: puts both in front. */
static pnb_status fail_inside(struct reader *r, const struct place *place, pnb_status status)
{
    char reason[640], where[256] = "";
    if (status == PNB_ERROR_MEMORY || status == PNB_ERROR_CANCELLED)
        return status;
    snprintf(reason, sizeof(reason), "%s", pnb_context_error(r->context));
    if (place_print(place, where, sizeof(where)) == 0)
        return status_fail(r->context, status, r->source->file, "%s", reason);
    return status_fail(r->context, status, r->source->file, "%s: %s", where, reason);
}

static const char *type_name(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "an array";
    case JSON_STRING: return "a text";
    case JSON_INTEGER:
    case JSON_REAL: return "a number";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: return "null";
    }
    return "something else";
}

static bool key_known(const char *known, const char *key)
{
    size_t length = strlen(key);
    for (const char *word = known + 1; *word; word = strchr(word, ' ') + 1)
        if (strncmp(word, key, length) == 0 && word[length] == ' ' && !strchr(key, ' '))
            return true;
    return false;
}

/* known: key names separated by blanks, with a blank at both ends. */
static pnb_status check_object(struct reader *r, const struct place *place, const json_t *value,
                               const char *known)
{
    if (!json_is_object(value))
        return fail_at(r, place, "must be an object, is %s", type_name(value));
    const char *key;
    json_t *member;
    json_object_foreach((json_t *)value, key, member)
    {
        struct place here = {place, key, 0};
        if (!*key)
            return fail_at(r, place, "a key without a name");
        if (!key_known(known, key))
            return fail_at(r, &here, "unknown key (known here:%.*s)", (int)strlen(known) - 1,
                           known);
    }
    return PNB_OK;
}

static pnb_status missing(struct reader *r, const struct place *place, const char *key)
{
    return fail_at(r, place, "\"%s\" is missing", key);
}

static pnb_status read_number(struct reader *r, const struct place *place, const json_t *value,
                              double *out)
{
    if (!json_is_number(value))
        return fail_at(r, place, "must be a number, is %s", type_name(value));
    *out = json_number_value(value);
    if (!isfinite(*out) || fabs(*out) > SCENE_NUMBER_LIMIT)
        return fail_at(r, place, "beyond 1e18");
    return PNB_OK;
}

static pnb_status read_vector(struct reader *r, const struct place *place, const json_t *value,
                              double out[3])
{
    if (!json_is_array(value))
        return fail_at(r, place, "must be three numbers, is %s", type_name(value));
    if (json_array_size(value) != 3)
        return fail_at(r, place, "must be three numbers, has %zu", json_array_size(value));
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < 3 && status == PNB_OK; i++)
        status = read_number(r, &(struct place){place, NULL, i}, json_array_get(value, i), &out[i]);
    return status;
}

enum need { OPTIONAL, REQUIRED };

/* Members of an object. An optional one that is absent leaves *out as it is. */
static pnb_status get_number(struct reader *r, const struct place *place, const json_t *object,
                             const char *key, enum need need, double *out)
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        return need == REQUIRED ? missing(r, place, key) : PNB_OK;
    return read_number(r, &(struct place){place, key, 0}, value, out);
}

static pnb_status get_vector(struct reader *r, const struct place *place, const json_t *object,
                             const char *key, enum need need, double out[3])
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        return need == REQUIRED ? missing(r, place, key) : PNB_OK;
    return read_vector(r, &(struct place){place, key, 0}, value, out);
}

static pnb_status get_color(struct reader *r, const struct place *place, const json_t *object,
                            const char *key, double out[3])
{
    pnb_status status = get_vector(r, place, object, key, OPTIONAL, out);
    if (status == PNB_OK && !(out[0] >= 0 && out[1] >= 0 && out[2] >= 0))
        return fail_at(r, &(struct place){place, key, 0}, "a colour below zero");
    return status;
}

static pnb_status get_bool(struct reader *r, const struct place *place, const json_t *object,
                           const char *key, bool *out)
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        return PNB_OK;
    if (!json_is_boolean(value))
        return fail_at(r, &(struct place){place, key, 0}, "must be true or false, is %s",
                       type_name(value));
    *out = json_is_true(value);
    return PNB_OK;
}

static pnb_status get_text(struct reader *r, const struct place *place, const json_t *object,
                           const char *key, enum need need, const char **out)
{
    const json_t *value = json_object_get(object, key);
    if (!value)
        return need == REQUIRED ? missing(r, place, key) : PNB_OK;
    if (!json_is_string(value))
        return fail_at(r, &(struct place){place, key, 0}, "must be a text, is %s",
                       type_name(value));
    if (json_string_length(value) == 0)
        return fail_at(r, &(struct place){place, key, 0}, "is empty");
    *out = json_string_value(value);
    return PNB_OK;
}

#define TRY(call)                                                                                  \
    do {                                                                                           \
        pnb_status try_status = (call);                                                            \
        if (try_status != PNB_OK)                                                                  \
            return try_status;                                                                     \
    } while (0)

static pnb_status read_camera(struct reader *r, const struct place *place, const json_t *value)
{
    pnb_camera camera = {.up = {0, 1, 0}, .vertical_fov_degrees = 45};
    TRY(check_object(r, place, value, " eye target up vertical_fov_degrees "));
    TRY(get_vector(r, place, value, "eye", REQUIRED, camera.eye));
    TRY(get_vector(r, place, value, "target", REQUIRED, camera.target));
    TRY(get_vector(r, place, value, "up", OPTIONAL, camera.up));
    TRY(get_number(r, place, value, "vertical_fov_degrees", OPTIONAL,
                   &camera.vertical_fov_degrees));
    pnb_status status = pnb_scene_set_camera(r->scene, &camera);
    if (status == PNB_OK)
        return PNB_OK;
    /* That message begins with "camera:" itself. */
    char reason[640];
    snprintf(reason, sizeof(reason), "%s", pnb_context_error(r->context));
    return status_fail(r->context, status, r->source->file, "%s", reason);
}

/* A polygon's vertices; *out_vertices is the caller's to free. */
static pnb_status read_polygon(struct reader *r, const struct place *place, const json_t *value,
                               pnb_light *light, double **out_vertices)
{
    const json_t *array = json_object_get(value, "vertices");
    struct place list = {place, "vertices", 0};
    if (!array)
        return missing(r, place, "vertices");
    if (!json_is_array(array))
        return fail_at(r, &list, "must be an array of points, is %s", type_name(array));
    size_t count = json_array_size(array);
    if (count < 3)
        return fail_at(r, &list, "a polygon needs three vertices, has %zu", count);
    double *vertices = memory_alloc(r->context, count, 3 * sizeof(double));
    if (!vertices)
        return status_no_memory(r->context, count * 3 * sizeof(double));
    *out_vertices = vertices;
    for (size_t i = 0; i < count; i++)
        TRY(read_vector(r, &(struct place){&list, NULL, i}, json_array_get(array, i),
                        vertices + 3 * i));
    light->shape.polygon.vertices = vertices;
    light->shape.polygon.vertex_count = count;
    return PNB_OK;
}

static pnb_status read_light_shape(struct reader *r, const struct place *place, const json_t *value,
                                   pnb_light *light, double **out_vertices)
{
    const char *type = NULL;
    if (!json_is_object(value))
        return fail_at(r, place, "must be an object, is %s", type_name(value));
    TRY(get_text(r, place, value, "type", REQUIRED, &type));
    TRY(get_text(r, place, value, "name", OPTIONAL, &light->name));
    TRY(get_color(r, place, value, "color", light->color));
    if (strcmp(type, "rectangle") == 0) {
        light->type = PNB_LIGHT_RECTANGLE;
        TRY(check_object(r, place, value, " type name color center half_u half_v "));
        TRY(get_vector(r, place, value, "center", REQUIRED, light->shape.rectangle.center));
        TRY(get_vector(r, place, value, "half_u", REQUIRED, light->shape.rectangle.half_u));
        return get_vector(r, place, value, "half_v", REQUIRED, light->shape.rectangle.half_v);
    }
    if (strcmp(type, "disk") == 0) {
        light->type = PNB_LIGHT_DISK;
        TRY(check_object(r, place, value, " type name color center normal radius "));
        TRY(get_vector(r, place, value, "center", REQUIRED, light->shape.disk.center));
        TRY(get_vector(r, place, value, "normal", REQUIRED, light->shape.disk.normal));
        return get_number(r, place, value, "radius", REQUIRED, &light->shape.disk.radius);
    }
    if (strcmp(type, "polygon") == 0) {
        light->type = PNB_LIGHT_POLYGON;
        TRY(check_object(r, place, value, " type name color vertices "));
        return read_polygon(r, place, value, light, out_vertices);
    }
    if (strcmp(type, "line") == 0) {
        light->type = PNB_LIGHT_LINE;
        TRY(check_object(r, place, value, " type name color from to "));
        TRY(get_vector(r, place, value, "from", REQUIRED, light->shape.line.from));
        return get_vector(r, place, value, "to", REQUIRED, light->shape.line.to);
    }
    if (strcmp(type, "point") == 0) {
        light->type = PNB_LIGHT_POINT;
        TRY(check_object(r, place, value, " type name color position "));
        return get_vector(r, place, value, "position", REQUIRED, light->shape.point.position);
    }
    if (strcmp(type, "sun") == 0) {
        light->type = PNB_LIGHT_SUN;
        light->shape.sun.angular_diameter_degrees = 0.53;
        TRY(check_object(r, place, value, " type name color direction angular_diameter_degrees "));
        TRY(get_vector(r, place, value, "direction", REQUIRED, light->shape.sun.direction));
        return get_number(r, place, value, "angular_diameter_degrees", OPTIONAL,
                          &light->shape.sun.angular_diameter_degrees);
    }
    return fail_at(r, &(struct place){place, "type", 0},
                   "unknown light \"%.40s\" (known: rectangle, disk, polygon, line, point, sun)",
                   type);
}

static pnb_status read_light(struct reader *r, const struct place *place, const json_t *value,
                             size_t *out_index)
{
    pnb_light light = {.color = {1, 1, 1}};
    double *vertices = NULL;
    pnb_status status = read_light_shape(r, place, value, &light, &vertices);
    if (status == PNB_OK) {
        status = pnb_scene_add_light(r->scene, &light, out_index);
        if (status != PNB_OK)
            status = fail_inside(r, place, status);
    }
    memory_free(r->context, vertices);
    return status;
}

/* world = translate rotate_z rotate_y rotate_x scale. */
static void placement(const double scale[3], const double degrees[3], const double translate[3],
                      double m[12])
{
    double s[3], c[3];
    for (int i = 0; i < 3; i++) {
        /* Quarter turns come out exact. */
        double turn = remainder(degrees[i], 360), quarter = turn / 90;
        if (quarter == rint(quarter)) {
            static const double sine[4] = {0, 1, 0, -1};
            int k = ((int)quarter + 4) & 3;
            s[i] = sine[k];
            c[i] = sine[(k + 1) & 3];
        } else {
            s[i] = sin(turn * M_PI / 180);
            c[i] = cos(turn * M_PI / 180);
        }
    }
    const double linear[9] = {c[2] * c[1],
                              c[2] * s[1] * s[0] - s[2] * c[0],
                              c[2] * s[1] * c[0] + s[2] * s[0],
                              s[2] * c[1],
                              s[2] * s[1] * s[0] + c[2] * c[0],
                              s[2] * s[1] * c[0] - c[2] * s[0],
                              -s[1],
                              c[1] * s[0],
                              c[1] * c[0]};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            m[4 * row + column] = linear[3 * row + column] * scale[column];
        m[4 * row + 3] = translate[row];
    }
}

/* Imports a mesh file once. */
static pnb_status find_mesh(struct reader *r, const struct place *place, const char *path,
                            size_t *out_mesh)
{
    for (size_t i = 0; i < r->mesh_count; i++)
        if (strcmp(r->meshes[i].path, path) == 0) {
            *out_mesh = r->meshes[i].mesh;
            return PNB_OK;
        }
    if (!memory_reserve(r->context, (void **)&r->meshes, &r->mesh_capacity, r->mesh_count, 1,
                        sizeof(*r->meshes)))
        return status_no_memory(r->context, sizeof(*r->meshes));
    const char *folder = path[0] == '/' ? NULL : r->source->folder;
    size_t size = (folder ? strlen(folder) : 0) + strlen(path) + 2;
    char *full = memory_alloc(r->context, size, 1);
    if (!full)
        return status_no_memory(r->context, size);
    if (folder && *folder)
        snprintf(full, size, "%s/%s", folder, path);
    else
        snprintf(full, size, "%s", path);
    pnb_status (*import)(pnb_scene *, const char *, size_t *) =
        r->source->import_mesh ? r->source->import_mesh : scene_import_mesh;
    pnb_status status = import(r->scene, full, out_mesh);
    memory_free(r->context, full);
    if (status != PNB_OK)
        return fail_inside(r, place, status);
    r->meshes[r->mesh_count++] = (struct known_mesh){path, *out_mesh};
    return PNB_OK;
}

/* scale: a number or three. */
static pnb_status get_scale(struct reader *r, const struct place *place, const json_t *value,
                            double out[3])
{
    const json_t *scale = json_object_get(value, "scale");
    struct place here = {place, "scale", 0};
    if (json_is_array(scale)) {
        TRY(read_vector(r, &here, scale, out));
    } else if (scale) {
        if (!json_is_number(scale))
            return fail_at(r, &here, "must be a number or three, is %s", type_name(scale));
        TRY(read_number(r, &here, scale, &out[0]));
        out[1] = out[2] = out[0];
    }
    if (out[0] == 0 || out[1] == 0 || out[2] == 0)
        return fail_at(r, &here, "must not be zero");
    return PNB_OK;
}

static pnb_status read_mesh_object(struct reader *r, const struct place *place, const json_t *value,
                                   pnb_object *object, size_t *out_index)
{
    const char *path = NULL;
    double scale[3] = {1, 1, 1}, degrees[3] = {0}, translate[3] = {0};
    TRY(check_object(r, place, value,
                     " name mesh scale rotate_degrees translate color casts receives "));
    TRY(get_text(r, place, value, "mesh", REQUIRED, &path));
    TRY(get_scale(r, place, value, scale));
    TRY(get_vector(r, place, value, "rotate_degrees", OPTIONAL, degrees));
    TRY(get_vector(r, place, value, "translate", OPTIONAL, translate));
    placement(scale, degrees, translate, object->world_from_mesh);
    TRY(find_mesh(r, &(struct place){place, "mesh", 0}, path, &object->mesh));
    if (!object->name)
        object->name = r->scene->meshes[object->mesh].name;
    pnb_status status = pnb_scene_add_object(r->scene, object, out_index);
    return status == PNB_OK ? PNB_OK : fail_inside(r, place, status);
}

static pnb_status read_plane_object(struct reader *r, const struct place *place,
                                    const json_t *value, const pnb_object *object,
                                    size_t *out_index)
{
    double point[3] = {0}, normal[3] = {0, 1, 0}, half_size = 0;
    struct place here = {place, "plane", 0};
    const json_t *plane = json_object_get(value, "plane");
    TRY(check_object(r, place, value, " name plane color casts receives "));
    TRY(check_object(r, &here, plane, " point normal half_size "));
    TRY(get_vector(r, &here, plane, "point", OPTIONAL, point));
    TRY(get_vector(r, &here, plane, "normal", OPTIONAL, normal));
    TRY(get_number(r, &here, plane, "half_size", REQUIRED, &half_size));
    if (!(half_size > 0))
        return fail_at(r, &(struct place){&here, "half_size", 0}, "must be above zero");
    if (normal[0] == 0 && normal[1] == 0 && normal[2] == 0)
        return fail_at(r, &(struct place){&here, "normal", 0}, "must not be zero");
    pnb_status status =
        scene_add_plane(r->scene, object->name ? object->name : "plane", v3_load(point),
                        v3_load(normal), half_size, object->color, out_index);
    if (status != PNB_OK)
        return fail_inside(r, place, status);
    r->scene->objects[*out_index].info.casts = object->casts;
    r->scene->objects[*out_index].info.receives = object->receives;
    return PNB_OK;
}

static pnb_status read_object(struct reader *r, const struct place *place, const json_t *value)
{
    pnb_object object = {.color = {0.8, 0.8, 0.8}, .casts = true, .receives = true};
    size_t index;
    if (!json_is_object(value))
        return fail_at(r, place, "must be an object, is %s", type_name(value));
    TRY(get_text(r, place, value, "name", OPTIONAL, &object.name));
    TRY(get_color(r, place, value, "color", object.color));
    TRY(get_bool(r, place, value, "casts", &object.casts));
    TRY(get_bool(r, place, value, "receives", &object.receives));
    bool plane = json_object_get(value, "plane"), mesh = json_object_get(value, "mesh");
    if (plane && mesh)
        return fail_at(r, place, "has a mesh and a plane; make two objects of it");
    if (plane)
        return read_plane_object(r, place, value, &object, &index);
    return read_mesh_object(r, place, value, &object, &index);
}

/* Bounds of what is not a plane, or of everything if there is nothing else. */
static void subject_bounds(const pnb_scene *scene, vec3 *out_low, vec3 *out_high)
{
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3(-INFINITY, -INFINITY, -INFINITY);
    for (size_t i = 0; i < scene->object_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        vec3 a, b;
        if (object->plane)
            continue;
        mesh_bounds(&scene->meshes[object->mesh], &a, &b);
        for (int corner = 0; corner < 8 && a.x <= b.x; corner++) {
            vec3 p = m34_point(
                object->world_from_mesh,
                v3(corner & 1 ? b.x : a.x, corner & 2 ? b.y : a.y, corner & 4 ? b.z : a.z));
            low = v3_min(low, p);
            high = v3_max(high, p);
        }
    }
    if (!(low.x <= high.x)) {
        double all_low[3], all_high[3];
        if (pnb_scene_bounds(scene, all_low, all_high)) {
            low = v3_load(all_low);
            high = v3_load(all_high);
        } else {
            low = v3(-1, 0, -1);
            high = v3(1, 1, 1);
        }
    }
    *out_low = low;
    *out_high = high;
}

static pnb_status supply_camera(struct reader *r, const struct place *top)
{
    vec3 low, high;
    pnb_camera camera;
    subject_bounds(r->scene, &low, &high);
    /* Half as much again on every side, for the shadow. */
    vec3 margin = v3_scale(v3_sub(high, low), 0.25);
    scene_frame_camera(v3_sub(low, margin), v3_add(high, margin), v3(0.3, 0.55, 1), &camera);
    scene_note(r->scene, "camera: none in the file; one that frames the objects was supplied");
    pnb_status status = pnb_scene_set_camera(r->scene, &camera);
    return status == PNB_OK ? PNB_OK : fail_inside(r, top, status);
}

static pnb_status supply_light(struct reader *r, const struct place *top)
{
    vec3 low, high, u, v;
    subject_bounds(r->scene, &low, &high);
    vec3 center = v3_scale(v3_add(low, high), 0.5);
    double radius = fmax(0.5 * v3_length(v3_sub(high, low)), 1e-6);
    vec3 towards = v3_normalize(v3(-0.5, 1, 0.4));
    v3_frame(v3_scale(towards, -1), &u, &v);
    pnb_light light = {.type = PNB_LIGHT_RECTANGLE, .name = "supplied", .color = {1, 1, 1}};
    v3_store(light.shape.rectangle.center, v3_mad(center, towards, 4 * radius));
    v3_store(light.shape.rectangle.half_u, v3_scale(u, 0.5 * radius));
    v3_store(light.shape.rectangle.half_v, v3_scale(v, 0.5 * radius));
    scene_note(r->scene,
               "lights: none in the file; a rectangle above and to the side was supplied");
    pnb_status status = pnb_scene_add_light(r->scene, &light, NULL);
    return status == PNB_OK ? PNB_OK : fail_inside(r, top, status);
}

static pnb_status read_scene(struct reader *r, const json_t *root)
{
    struct place top = {NULL, NULL, 0};
    const json_t *value;
    TRY(check_object(r, &top, root, " camera ambient background exposure lights objects "));

    double ambient[3], background[3], exposure = 0;
    pnb_scene_ambient(r->scene, ambient);
    pnb_scene_background(r->scene, background);
    TRY(get_color(r, &top, root, "ambient", ambient));
    TRY(get_color(r, &top, root, "background", background));
    pnb_scene_set_ambient(r->scene, ambient);
    pnb_scene_set_background(r->scene, background);
    TRY(get_number(r, &top, root, "exposure", OPTIONAL, &exposure));
    if (exposure < 0)
        return fail_at(r, &(struct place){&top, "exposure", 0}, "below zero");
    pnb_scene_set_exposure(r->scene, exposure);

    struct place camera = {&top, "camera", 0}, lights = {&top, "lights", 0},
                 objects = {&top, "objects", 0};
    if ((value = json_object_get(root, "camera")))
        TRY(read_camera(r, &camera, value));

    if (!(value = json_object_get(root, "objects")))
        return missing(r, &top, "objects");
    if (!json_is_array(value))
        return fail_at(r, &objects, "must be an array, is %s", type_name(value));
    if (json_array_size(value) == 0)
        return fail_at(r, &objects, "is empty: there is nothing to see");
    for (size_t i = 0; i < json_array_size(value); i++)
        TRY(read_object(r, &(struct place){&objects, NULL, i}, json_array_get(value, i)));

    if ((value = json_object_get(root, "lights"))) {
        if (!json_is_array(value))
            return fail_at(r, &lights, "must be an array, is %s", type_name(value));
        for (size_t i = 0; i < json_array_size(value); i++)
            TRY(read_light(r, &(struct place){&lights, NULL, i}, json_array_get(value, i), NULL));
    } else {
        TRY(supply_light(r, &top));
    }
    if (!json_object_get(root, "camera"))
        TRY(supply_camera(r, &top));
    return PNB_OK;
}

/* Text to tree; an error names line and column. */
static pnb_status load_text(pnb_context *context, const char *file, const char *text, size_t length,
                            json_t **out_root)
{
    json_error_t error;
    *out_root = NULL;
    if (length > SCENE_FILE_LIMIT)
        return status_fail(context, PNB_ERROR_FORMAT, file, "larger than %zu MB",
                           SCENE_FILE_LIMIT >> 20);
    /* A byte order mark is none of JSON's business, but editors write it. */
    if (length >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0) {
        text += 3;
        length -= 3;
    }
    size_t blank = 0;
    while (blank < length && strchr(" \t\r\n", text[blank]) && text[blank])
        blank++;
    if (blank == length)
        return status_fail(context, PNB_ERROR_FORMAT, file, "is empty");
    if (memchr(text, 0, length))
        return status_fail(context, PNB_ERROR_FORMAT, file, "is binary, not a JSON text");
    *out_root = json_loadb(text, length, JSON_REJECT_DUPLICATES | JSON_DECODE_INT_AS_REAL, &error);
    if (!*out_root)
        return status_fail(context, PNB_ERROR_FORMAT, file, "line %d, column %d: %s",
                           error.line > 0 ? error.line : 1, error.column > 0 ? error.column : 0,
                           error.text);
    return PNB_OK;
}

pnb_status scene_file_parse(pnb_context *context, const char *text, size_t length,
                            const struct scene_file_source *source, pnb_scene **out_scene)
{
    struct reader reader = {.context = context, .source = source};
    json_t *root;
    *out_scene = NULL;
    TRY(load_text(context, source->file, text, length, &root));
    pnb_status status = pnb_scene_create(context, &reader.scene);
    if (status == PNB_OK)
        status = read_scene(&reader, root);
    memory_free(context, reader.meshes);
    json_decref(root);
    if (status == PNB_OK)
        *out_scene = reader.scene;
    else
        pnb_scene_destroy(reader.scene);
    return status;
}

pnb_status pnb_scene_parse(pnb_context *context, const char *text, size_t length,
                           const char *folder, pnb_scene **out_scene)
{
    struct scene_file_source source = {.file = "scene", .folder = folder};
    return scene_file_parse(context, text, length, &source, out_scene);
}

pnb_status pnb_scene_add_light_json(pnb_scene *scene, const char *text, size_t *out_index)
{
    struct scene_file_source source = {.file = "light"};
    struct reader reader = {.context = scene->context, .scene = scene, .source = &source};
    struct place top = {NULL, NULL, 0};
    json_t *root;
    if (!text)
        return status_missing(scene->context, "light");
    TRY(load_text(scene->context, source.file, text, strlen(text), &root));
    pnb_status status = read_light(&reader, &top, root, out_index);
    json_decref(root);
    return status;
}
