/* scene/write_glb.c: the scene as one binary glTF 2.0 file.
 *
 *   header | JSON chunk: nodes, meshes, materials, camera, lights | BIN chunk: arrays, once per
 * mesh
 *
 *   object                node with the placement as matrix; one glTF mesh per mesh and colour, all
 *                         sharing the arrays. Sheared or flattened placements, which glTF nodes
 * must not have, are baked into arrays of their own camera                perspective, along the
 * node's -Z rectangle, disk       EXT_lights_area: centre at the node, emission along its -Z; size
 * is the height (along half_v) or diameter, rect.aspect width / height; intensity in nits is the
 * largest channel of the radiance, color the rest parallelogram,        planar faces, black with an
 * emissive material (KHR_materials_emissive_ polygon               strength), front on the lit side
 *   line                  a strip of such faces, 1/1000 of the length wide, turned towards the
 *                         camera's target, with the radiance that gives the same irradiance there;
 *                         the node's extras.penumbra_light keep what it stands for
 *   point, sun            KHR_lights_punctual point (candela) and directional (lux); the sun's
 *                         diameter stands in the light's extras.angular_diameter_degrees
 *   ambient, background,  extras of the scene; extras of the node: "casts": false, "receives":
 * false, exposure, flags       "plane": true
 *
 * A mesh with a normal of length zero ("take the flat one") is written without normals, since glTF
 * wants unit ones. Colours are clamped to [0,1], as glTF has it. */
#include <penumbra/image.h>
#include <stdio.h>
#include <string.h>

#include "light/light.h"
#include "scene/write.h"

/* Accessors of a mesh's arrays; NONE: not written (yet). */
#define NONE SIZE_MAX
struct arrays {
    size_t positions, normals, indices;
};

struct glb_mesh {
    size_t source, material; /* arrays, material */
};

struct writer {
    pnb_scene *scene;
    pnb_context *context;
    struct buffer bin, views, accessors, meshes, materials, nodes, area_lights, punctual_lights;
    size_t view_count, accessor_count, mesh_count, material_count, node_count;
    size_t area_light_count, punctual_light_count;
    bool emissive;
    struct arrays *arrays; /* per mesh of the scene, then baked ones and light faces */
    size_t array_count, array_capacity;
    struct glb_mesh *made; /* per glTF mesh */
    size_t made_capacity;
    double (*colors)[3]; /* per plain material */
    size_t *color_material;
    size_t color_count, color_capacity, color_material_capacity;
};

static void print_vector(struct buffer *out, vec3 v)
{
    const double values[3] = {v.x, v.y, v.z};
    for (int i = 0; i < 3; i++) {
        buffer_print(out, i ? "," : "[");
        buffer_number(out, values[i]);
    }
    buffer_print(out, "]");
}

/* A comma before every element but the first. */
static void next(struct buffer *out)
{
    if (out->size)
        buffer_print(out, ",");
}

static size_t add_accessor(struct writer *w, const void *bytes, size_t count, size_t element,
                           int component, const char *type, int target)
{
    next(&w->views);
    buffer_print(&w->views, "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d}",
                 w->bin.size, count * element, target);
    next(&w->accessors);
    buffer_print(&w->accessors,
                 "{\"bufferView\":%zu,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"",
                 w->view_count++, component, count, type);
    buffer_add(&w->bin, bytes, count * element); /* elements are multiples of four bytes */
    return w->accessor_count++;
}

static bool normals_usable(const struct mesh *mesh)
{
    if (!mesh->normals)
        return false;
    for (size_t i = 0; i < mesh->vertex_count; i++)
        if (!(fabs(v3_length(v3_loadf(mesh->normals + 3 * i)) - 1) < 1e-4))
            return false;
    return true;
}

static void write_arrays(struct writer *w, const struct mesh *mesh, struct arrays *arrays)
{
    const int float_component = 5126, index_component = 5125, vertex_target = 34962,
              index_target = 34963;
    vec3 low = v3_loadf(mesh->positions), high = low;
    for (size_t i = 1; i < mesh->vertex_count; i++) {
        low = v3_min(low, v3_loadf(mesh->positions + 3 * i));
        high = v3_max(high, v3_loadf(mesh->positions + 3 * i));
    }
    arrays->positions = add_accessor(w, mesh->positions, mesh->vertex_count, 12, float_component,
                                     "VEC3", vertex_target);
    buffer_print(&w->accessors, ",\"min\":");
    print_vector(&w->accessors, low);
    buffer_print(&w->accessors, ",\"max\":");
    print_vector(&w->accessors, high);
    buffer_print(&w->accessors, "}");
    arrays->normals = NONE;
    if (normals_usable(mesh)) {
        arrays->normals = add_accessor(w, mesh->normals, mesh->vertex_count, 12, float_component,
                                       "VEC3", vertex_target);
        buffer_print(&w->accessors, "}");
    }
    arrays->indices = add_accessor(w, mesh->indices, mesh->triangle_count * 3, 4, index_component,
                                   "SCALAR", index_target);
    buffer_print(&w->accessors, "}");
}

/* Arrays that no mesh of the scene has; returns their number, NONE without memory. */
static size_t add_arrays(struct writer *w, const struct mesh *mesh)
{
    if (!memory_reserve(w->context, (void **)&w->arrays, &w->array_capacity, w->array_count, 1,
                        sizeof(*w->arrays))) {
        w->bin.failed = true;
        return NONE;
    }
    write_arrays(w, mesh, &w->arrays[w->array_count]);
    return w->array_count++;
}

/* A diffuse material of that colour, made once. */
static size_t plain_material(struct writer *w, const double color[3])
{
    for (size_t i = 0; i < w->color_count; i++)
        if (memcmp(w->colors[i], color, sizeof(w->colors[i])) == 0)
            return w->color_material[i];
    if (!memory_reserve(w->context, (void **)&w->colors, &w->color_capacity, w->color_count, 1,
                        sizeof(*w->colors)) ||
        !memory_reserve(w->context, (void **)&w->color_material, &w->color_material_capacity,
                        w->color_count, 1, sizeof(*w->color_material))) {
        w->bin.failed = true;
        return 0;
    }
    memcpy(w->colors[w->color_count], color, sizeof(w->colors[0]));
    w->color_material[w->color_count++] = w->material_count;
    next(&w->materials);
    buffer_print(&w->materials, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[");
    for (int c = 0; c < 3; c++) {
        buffer_number(&w->materials, fmin(fmax(color[c], 0), 1));
        buffer_print(&w->materials, ",");
    }
    buffer_print(&w->materials,
                 "1],\"metallicFactor\":0,\"roughnessFactor\":1},\"doubleSided\":true}");
    return w->material_count++;
}

/* Largest channel of a colour, and the colour divided by it. */
static double split_color(const double color[3], vec3 *out_color)
{
    double largest = fmax(color[0], fmax(color[1], color[2]));
    if (!(largest > 0)) {
        *out_color = v3(0, 0, 0);
        return 1;
    }
    *out_color = v3(color[0] / largest, color[1] / largest, color[2] / largest);
    return largest;
}

static size_t emissive_material(struct writer *w, const double radiance[3])
{
    vec3 color;
    double strength = split_color(radiance, &color);
    next(&w->materials);
    buffer_print(&w->materials, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[");
    const double channels[3] = {color.x, color.y, color.z};
    for (int c = 0; c < 3; c++) {
        buffer_number(&w->materials, channels[c]);
        buffer_print(&w->materials, ",");
    }
    buffer_print(&w->materials,
                 "1],\"metallicFactor\":0,\"roughnessFactor\":1},\"emissiveFactor\":");
    print_vector(&w->materials, color);
    buffer_print(&w->materials,
                 ",\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":");
    buffer_number(&w->materials, strength);
    buffer_print(&w->materials, "}}}");
    w->emissive = true;
    return w->material_count++;
}

static size_t add_mesh(struct writer *w, const char *name, size_t source, size_t material)
{
    for (size_t i = 0; i < w->mesh_count; i++)
        if (w->made[i].source == source && w->made[i].material == material)
            return i;
    if (!memory_reserve(w->context, (void **)&w->made, &w->made_capacity, w->mesh_count, 1,
                        sizeof(*w->made))) {
        w->bin.failed = true;
        return 0;
    }
    w->made[w->mesh_count] = (struct glb_mesh){source, material};
    const struct arrays *arrays = &w->arrays[source];
    next(&w->meshes);
    buffer_print(&w->meshes, "{\"name\":");
    buffer_json_string(&w->meshes, name);
    buffer_print(&w->meshes, ",\"primitives\":[{\"attributes\":{\"POSITION\":%zu",
                 arrays->positions);
    if (arrays->normals != NONE)
        buffer_print(&w->meshes, ",\"NORMAL\":%zu", arrays->normals);
    buffer_print(&w->meshes, "},\"indices\":%zu,\"material\":%zu}]}", arrays->indices, material);
    return w->mesh_count++;
}

static void begin_node(struct writer *w, const char *name)
{
    next(&w->nodes);
    buffer_print(&w->nodes, "{\"name\":");
    buffer_json_string(&w->nodes, name);
    w->node_count++;
}

/* Column-major 4x4. */
static void print_matrix(struct buffer *out, vec3 x, vec3 y, vec3 z, vec3 origin)
{
    const vec3 columns[4] = {x, y, z, origin};
    buffer_print(out, ",\"matrix\":[");
    for (int c = 0; c < 4; c++) {
        const double v[3] = {columns[c].x, columns[c].y, columns[c].z};
        for (int i = 0; i < 3; i++) {
            buffer_number(out, v[i]);
            buffer_print(out, ",");
        }
        buffer_print(out, c < 3 ? "0," : "1]");
    }
}

static pnb_status write_object(struct writer *w, const pnb_object *object)
{
    const struct mesh *mesh = &w->scene->meshes[object->mesh];
    const double *m = object->world_from_mesh;
    struct write_placement placement;
    size_t source = object->mesh;
    if (mesh->triangle_count == 0)
        return PNB_OK;
    bool plain = write_decompose(m, &placement);
    if (plain) {
        if (w->arrays[source].positions == NONE)
            write_arrays(w, mesh, &w->arrays[source]);
    } else {
        struct mesh baked;
        pnb_status status = write_bake(w->context, mesh, m, &baked);
        if (status != PNB_OK)
            return status;
        source = add_arrays(w, &baked);
        mesh_finish(w->context, &baked);
    }
    if (w->bin.failed)
        return PNB_OK; /* told at the end */
    size_t number = add_mesh(w, mesh->name, source, plain_material(w, object->color));
    begin_node(w, object->name);
    buffer_print(&w->nodes, ",\"mesh\":%zu", number);
    if (plain)
        print_matrix(&w->nodes, v3(m[0], m[4], m[8]), v3(m[1], m[5], m[9]), v3(m[2], m[6], m[10]),
                     v3(m[3], m[7], m[11]));
    if (!object->casts || !object->receives || object->plane)
        buffer_print(&w->nodes, ",\"extras\":{%s%s%s%s%s}", object->plane ? "\"plane\":true" : "",
                     object->plane && !(object->casts && object->receives) ? "," : "",
                     object->casts ? "" : "\"casts\":false",
                     object->casts || object->receives ? "" : ",",
                     object->receives ? "" : "\"receives\":false");
    buffer_print(&w->nodes, "}");
    return PNB_OK;
}

static void write_camera_node(struct writer *w)
{
    const pnb_camera *camera = &w->scene->camera;
    vec3 eye = v3_load(camera->eye);
    vec3 z = v3_normalize(v3_sub(eye, v3_load(camera->target)));
    vec3 x = v3_normalize(v3_cross(v3_load(camera->up), z));
    begin_node(w, "camera");
    buffer_print(&w->nodes, ",\"camera\":0");
    print_matrix(&w->nodes, x, v3_cross(z, x), z, eye);
    buffer_print(&w->nodes, "}");
}

static const char *light_name(const pnb_light *light)
{
    return light->name && *light->name ? light->name : pnb_light_type_name(light->type);
}

/* A node whose -Z is the given direction and whose X is x, which is at right angles to it. */
static void light_node(struct writer *w, const pnb_light *light, const char *extension,
                       size_t number, vec3 center, vec3 x, vec3 direction)
{
    vec3 z = v3_scale(direction, -1);
    begin_node(w, light_name(light));
    print_matrix(&w->nodes, x, v3_cross(z, x), z, center);
    buffer_print(&w->nodes, ",\"extensions\":{\"%s\":{\"light\":%zu}}}", extension, number);
}

static void begin_light(struct buffer *out, const pnb_light *light, const char *type)
{
    vec3 color;
    double intensity = split_color(light->color, &color);
    next(out);
    buffer_print(out, "{\"name\":");
    buffer_json_string(out, light_name(light));
    buffer_print(out, ",\"type\":\"%s\",\"color\":", type);
    print_vector(out, color);
    buffer_print(out, ",\"intensity\":");
    buffer_number(out, intensity);
}

static void write_rectangle(struct writer *w, const pnb_light *light)
{
    vec3 u = v3_load(light->shape.rectangle.half_u), v = v3_load(light->shape.rectangle.half_v);
    double width = v3_length(u), height = v3_length(v);
    begin_light(&w->area_lights, light, "rect");
    buffer_print(&w->area_lights, ",\"size\":");
    buffer_number(&w->area_lights, 2 * height);
    buffer_print(&w->area_lights, ",\"rect\":{\"aspect\":");
    buffer_number(&w->area_lights, width / height);
    buffer_print(&w->area_lights, "}}");
    light_node(w, light, "EXT_lights_area", w->area_light_count++,
               v3_load(light->shape.rectangle.center), v3_normalize(u),
               v3_normalize(v3_cross(u, v)));
}

static void write_disk(struct writer *w, const pnb_light *light)
{
    vec3 n = v3_normalize(v3_load(light->shape.disk.normal)), x, y;
    v3_frame(n, &x, &y);
    begin_light(&w->area_lights, light, "disk");
    buffer_print(&w->area_lights, ",\"size\":");
    buffer_number(&w->area_lights, 2 * light->shape.disk.radius);
    buffer_print(&w->area_lights, "}");
    light_node(w, light, "EXT_lights_area", w->area_light_count++,
               v3_load(light->shape.disk.center), x, n);
}

static void write_punctual(struct writer *w, const pnb_light *light)
{
    bool sun = light->type == PNB_LIGHT_SUN;
    vec3 direction = sun ? v3_normalize(v3_load(light->shape.sun.direction)) : v3(0, -1, 0);
    vec3 x, y, at = sun ? v3(0, 0, 0) : v3_load(light->shape.point.position);
    v3_frame(direction, &x, &y);
    begin_light(&w->punctual_lights, light, sun ? "directional" : "point");
    if (sun) {
        buffer_print(&w->punctual_lights, ",\"extras\":{\"angular_diameter_degrees\":");
        buffer_number(&w->punctual_lights, light->shape.sun.angular_diameter_degrees);
        buffer_print(&w->punctual_lights, "}");
    }
    buffer_print(&w->punctual_lights, "}");
    light_node(w, light, "KHR_lights_punctual", w->punctual_light_count++, at, x, direction);
}

/* Emissive faces around `origin`, so that floats keep the shape of a small light far away.
 * vertices: world, count x 3; triangles with their front on the lit side. line: what the faces
 * stand for, or NULL. */
static pnb_status write_faces(struct writer *w, const pnb_light *light, const double *vertices,
                              size_t count, const uint32_t *triangles, size_t triangle_count,
                              const double radiance[3], const pnb_light *line)
{
    vec3 origin = v3_load(vertices);
    float *positions = memory_alloc(w->context, count, 3 * sizeof(float));
    if (!positions)
        return status_no_memory(w->context, count * 12);
    for (size_t i = 0; i < count; i++)
        v3_storef(positions + 3 * i, v3_sub(v3_load(vertices + 3 * i), origin));
    struct mesh mesh;
    pnb_mesh_desc desc = {light_name(light), positions, NULL, count, triangles, triangle_count};
    pnb_status status = mesh_init(w->context, &mesh, &desc);
    memory_free(w->context, positions);
    if (status != PNB_OK)
        return status;
    size_t source = add_arrays(w, &mesh);
    mesh_finish(w->context, &mesh);
    if (source == NONE)
        return PNB_OK; /* told at the end */
    size_t number = add_mesh(w, light_name(light), source, emissive_material(w, radiance));
    begin_node(w, light_name(light));
    buffer_print(&w->nodes, ",\"mesh\":%zu,\"translation\":", number);
    print_vector(&w->nodes, origin);
    if (line) {
        buffer_print(&w->nodes, ",\"extras\":{\"penumbra_light\":{\"type\":\"line\",\"from\":");
        print_vector(&w->nodes, v3_load(line->shape.line.from));
        buffer_print(&w->nodes, ",\"to\":");
        print_vector(&w->nodes, v3_load(line->shape.line.to));
        buffer_print(&w->nodes, ",\"color\":");
        print_vector(&w->nodes, v3_load(line->color));
        buffer_print(&w->nodes, "}}");
    }
    buffer_print(&w->nodes, "}");
    return PNB_OK;
}

static const uint32_t quad_triangles[6] = {0, 1, 2, 0, 2, 3};

static pnb_status write_parallelogram(struct writer *w, const pnb_light *light)
{
    static const int side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    vec3 center = v3_load(light->shape.rectangle.center);
    vec3 u = v3_load(light->shape.rectangle.half_u), v = v3_load(light->shape.rectangle.half_v);
    double vertices[12];
    for (int i = 0; i < 4; i++)
        v3_store(vertices + 3 * i, v3_mad(v3_mad(center, u, side[i][0]), v, side[i][1]));
    return write_faces(w, light, vertices, 4, quad_triangles, 2, light->color, NULL);
}

static pnb_status write_polygon(struct writer *w, const pnb_light *light)
{
    struct light_shape shape;
    pnb_status status = light_shape_init(w->context, light, &shape);
    if (status != PNB_OK)
        return status;
    status = write_faces(w, light, light->shape.polygon.vertices, light->shape.polygon.vertex_count,
                         shape.triangles, shape.triangle_count, light->color, NULL);
    light_shape_finish(w->context, &shape);
    return status;
}

static pnb_status write_line(struct writer *w, const pnb_light *light)
{
    vec3 from = v3_load(light->shape.line.from), to = v3_load(light->shape.line.to);
    vec3 along = v3_sub(to, from), middle = v3_scale(v3_add(from, to), 0.5);
    double length = v3_length(along), width = 1e-3 * length;
    vec3 axis = v3_scale(along, 1 / length);
    vec3 towards = v3_sub(v3_load(w->scene->camera.target), middle), across, other;
    towards = v3_mad(towards, axis, -v3_dot(towards, axis));
    if (v3_length(towards) > 1e-9 * length)
        across = v3_normalize(v3_cross(v3_normalize(towards), axis));
    else
        v3_frame(axis, &across, &other);
    /* Counter-clockwise seen from where it shines to: axis x across points there. */
    vec3 half = v3_scale(across, 0.5 * width);
    if (v3_dot(v3_cross(axis, across), towards) < 0)
        half = v3_scale(half, -1);
    double vertices[12], radiance[3];
    v3_store(vertices, v3_sub(from, half));
    v3_store(vertices + 3, v3_sub(to, half));
    v3_store(vertices + 6, v3_add(to, half));
    v3_store(vertices + 9, v3_add(from, half));
    /* Intensity per metre is radiance x width. */
    for (int c = 0; c < 3; c++)
        radiance[c] = light->color[c] / width;
    return write_faces(w, light, vertices, 4, quad_triangles, 2, radiance, light);
}

static pnb_status write_light(struct writer *w, const pnb_light *light)
{
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(light->shape.rectangle.half_u), v = v3_load(light->shape.rectangle.half_v);
        if (fabs(v3_dot(u, v)) > 1e-6 * v3_length(u) * v3_length(v))
            return write_parallelogram(w, light);
        write_rectangle(w, light);
        return PNB_OK;
    }
    case PNB_LIGHT_DISK: write_disk(w, light); return PNB_OK;
    case PNB_LIGHT_POLYGON: return write_polygon(w, light);
    case PNB_LIGHT_LINE: return write_line(w, light);
    case PNB_LIGHT_POINT:
    case PNB_LIGHT_SUN: write_punctual(w, light); return PNB_OK;
    }
    return PNB_OK;
}

static void print_document(struct writer *w, struct buffer *out)
{
    const pnb_scene *scene = w->scene;
    const char *separator = "";
    buffer_print(out, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"penumbra %s\"}",
                 pnb_version());
    if (w->area_light_count || w->punctual_light_count || w->emissive) {
        buffer_print(out, ",\"extensionsUsed\":[");
        if (w->area_light_count) {
            buffer_print(out, "\"EXT_lights_area\"");
            separator = ",";
        }
        if (w->punctual_light_count) {
            buffer_print(out, "%s\"KHR_lights_punctual\"", separator);
            separator = ",";
        }
        if (w->emissive)
            buffer_print(out, "%s\"KHR_materials_emissive_strength\"", separator);
        buffer_print(out, "]");
    }
    if (w->area_light_count || w->punctual_light_count) {
        buffer_print(out, ",\"extensions\":{");
        if (w->area_light_count)
            buffer_print(out, "\"EXT_lights_area\":{\"lights\":[%.*s]}", (int)w->area_lights.size,
                         w->area_lights.bytes);
        if (w->punctual_light_count)
            buffer_print(out, "%s\"KHR_lights_punctual\":{\"lights\":[%.*s]}",
                         w->area_light_count ? "," : "", (int)w->punctual_lights.size,
                         w->punctual_lights.bytes);
        buffer_print(out, "}");
    }
    buffer_print(out, ",\"scene\":0,\"scenes\":[{\"name\":");
    buffer_json_string(out, scene->name);
    buffer_print(out, ",\"nodes\":[");
    for (size_t i = 0; i < w->node_count; i++)
        buffer_print(out, "%s%zu", i ? "," : "", i);
    buffer_print(out, "],\"extras\":{\"ambient\":");
    print_vector(out, v3_load(scene->ambient));
    buffer_print(out, ",\"background\":");
    print_vector(out, v3_load(scene->background));
    if (scene->exposure > 0) {
        buffer_print(out, ",\"exposure\":");
        buffer_number(out, scene->exposure);
    }
    buffer_print(out, "}}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":");
    buffer_number(out, scene->camera.vertical_fov_degrees * M_PI / 180);
    vec3 view = v3_sub(v3_load(scene->camera.target), v3_load(scene->camera.eye));
    buffer_print(out, ",\"znear\":");
    buffer_number(out, 0.01 * v3_length(view));
    buffer_print(out, "}}]");

    const struct {
        const char *key;
        const struct buffer *list;
    } lists[] = {{"nodes", &w->nodes},
                 {"meshes", &w->meshes},
                 {"materials", &w->materials},
                 {"accessors", &w->accessors},
                 {"bufferViews", &w->views}};
    for (size_t i = 0; i < sizeof(lists) / sizeof(lists[0]); i++) {
        if (lists[i].list->size == 0)
            continue; /* glTF forbids empty arrays */
        buffer_print(out, ",\"%s\":[", lists[i].key);
        buffer_add(out, lists[i].list->bytes, lists[i].list->size);
        buffer_print(out, "]");
    }
    if (w->bin.size > 0)
        buffer_print(out, ",\"buffers\":[{\"byteLength\":%zu}]", w->bin.size);
    buffer_print(out, "}");
    while (out->size % 4 != 0 && !out->failed)
        buffer_add(out, " ", 1);
}

static void add_u32(struct buffer *out, size_t value)
{
    const unsigned char bytes[4] = {(unsigned char)value, (unsigned char)(value >> 8),
                                    (unsigned char)(value >> 16), (unsigned char)(value >> 24)};
    buffer_add(out, bytes, 4);
}

static pnb_status write_file(struct writer *w, const char *path)
{
    struct buffer document, file;
    pnb_status status = PNB_OK;
    buffer_init(w->context, &document);
    buffer_init(w->context, &file);
    print_document(w, &document);
    size_t bin = w->bin.size ? 8 + w->bin.size : 0, total = 12 + 8 + document.size + bin;
    if (total > 0xffffffffu)
        status =
            status_fail(w->context, PNB_ERROR_FILE, path, "larger than 4 GiB, the limit of GLB");
    if (status == PNB_OK) {
        buffer_add(&file, "glTF", 4);
        add_u32(&file, 2);
        add_u32(&file, total);
        add_u32(&file, document.size);
        buffer_add(&file, "JSON", 4);
        buffer_add(&file, document.bytes, document.size);
        if (bin) {
            add_u32(&file, w->bin.size);
            buffer_add(&file, "BIN\0", 4);
            buffer_add(&file, w->bin.bytes, w->bin.size);
        }
        if (file.failed || document.failed || w->bin.failed || w->views.failed ||
            w->accessors.failed || w->meshes.failed || w->materials.failed || w->nodes.failed ||
            w->area_lights.failed || w->punctual_lights.failed)
            status = status_no_memory(w->context, total);
    }
    if (status == PNB_OK)
        status = pnb_file_write(w->context, path, file.bytes, file.size);
    buffer_finish(&document);
    buffer_finish(&file);
    return status;
}

pnb_status pnb_scene_write_glb(pnb_scene *scene, const char *path)
{
    pnb_context *context = scene->context;
    struct writer w = {.scene = scene, .context = context};
    struct buffer *buffers[] = {&w.bin,       &w.views, &w.accessors,   &w.meshes,
                                &w.materials, &w.nodes, &w.area_lights, &w.punctual_lights};
    for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++)
        buffer_init(context, buffers[i]);
    pnb_status status = PNB_OK;
    if (memory_reserve(context, (void **)&w.arrays, &w.array_capacity, 0, scene->mesh_count + 1,
                       sizeof(*w.arrays))) {
        w.array_count = scene->mesh_count;
        for (size_t i = 0; i < w.array_count; i++)
            w.arrays[i] = (struct arrays){NONE, NONE, NONE};
    } else {
        status = status_no_memory(context, scene->mesh_count * sizeof(*w.arrays));
    }
    for (size_t i = 0; i < scene->object_count && status == PNB_OK; i++)
        status = write_object(&w, &scene->objects[i].info);
    for (size_t i = 0; i < scene->light_count && status == PNB_OK; i++)
        status = write_light(&w, &scene->lights[i]);
    if (status == PNB_OK) {
        write_camera_node(&w);
        status = write_file(&w, path);
    }
    for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++)
        buffer_finish(buffers[i]);
    memory_free(context, w.arrays);
    memory_free(context, w.made);
    memory_free(context, w.colors);
    memory_free(context, w.color_material);
    return status;
}
