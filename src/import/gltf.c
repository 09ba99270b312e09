/* import/gltf.c: cameras and lights of a glTF 2.0 scene, read from its JSON.
 *
 * Assimp knows nothing of EXT_lights_area, and keeps one node per punctual light where files may
 * have several. So the nodes are walked here: from the default scene's roots (the first scene, or
 * every node that is no child, where none is named), each node once, so that cycles end.
 *
 *   EXT_lights_area       nodes[i].extensions.EXT_lights_area.light, an index into the root list
 *                         {type: rect|disk, size, rect: {aspect}, color, intensity}: centre at the
 *                         node, emission along its -Z, height = size x the largest absolute world
 *                         scale, width = height x aspect, a disk's diameter the same as the height
 *   KHR_lights_punctual   point; spot, as a point; directional, as a sun of 0.53 degrees, or of
 *                         the light's extras.angular_diameter_degrees
 *   cameras               perspective: along the node's -Z, up its +Y
 *
 * Files that this project wrote say more in extras: ambient light and background, a sun's diameter,
 * objects that cast or receive no shadow or are planes.
 *
 * Values of the wrong kind count as absent. What cannot be used gets a note. */
#include "import/import.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include <penumbra/light.h>

#define NODE_DEPTH_MAX 500

struct walk {
    json_t *gltf, *nodes;
    unsigned char *visited;
};

static uint32_t little_u32(const unsigned char *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

json_t *gltf_read(const char *path)
{
    const char *dot = strrchr(path, '.');
    if (!dot || (strcasecmp(dot, ".glb") != 0 && strcasecmp(dot, ".gltf") != 0))
        return NULL;
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    json_t *gltf = NULL;
    unsigned char head[20];
    size_t size = 0;
    if (fread(head, 1, 20, file) == 20 && memcmp(head, "glTF", 4) == 0) {
        if (memcmp(head + 16, "JSON", 4) == 0)
            size = little_u32(head + 12);
    } else if (fseek(file, 0, SEEK_END) == 0) {
        long end = ftell(file);
        rewind(file);
        size = end > 0 ? (size_t)end : 0;
    }
    /* A declared size may lie: take what is there, read in pieces. */
    size_t used = 0, capacity = 0;
    char *text = NULL;
    while (used < size) {
        size_t piece = size - used < (1u << 20) ? size - used : 1u << 20;
        if (used + piece > capacity) {
            capacity = (used + piece) * 2;
            text = realloc(text, capacity);
            if (!text)
                import_fail(IMPORT_NO_MEMORY, "out of memory");
        }
        size_t n = fread(text + used, 1, piece, file);
        if (n == 0)
            break;
        used += n;
    }
    if (used > 0)
        gltf = json_loadb(text, used, JSON_DISABLE_EOF_CHECK, NULL);
    free(text);
    fclose(file);
    if (json_is_object(gltf))
        return gltf;
    json_decref(gltf);
    return NULL;
}

static double number(json_t *object, const char *key, double otherwise)
{
    json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : otherwise;
}

static const char *text(json_t *object, const char *key)
{
    const char *value = json_string_value(json_object_get(object, key));
    return value ? value : "";
}

/* False, and out untouched, if there are not exactly count numbers. */
static bool numbers(json_t *object, const char *key, size_t count, double *out)
{
    json_t *array = json_object_get(object, key);
    if (json_array_size(array) != count)
        return false;
    for (size_t i = 0; i < count; i++)
        if (!json_is_number(json_array_get(array, i)))
            return false;
    for (size_t i = 0; i < count; i++)
        out[i] = json_number_value(json_array_get(array, i));
    return true;
}

/* The element of an array that an integer names; NULL if there is none. */
static json_t *element(json_t *array, json_t *index)
{
    json_int_t i = json_integer_value(index);
    return json_is_integer(index) && i >= 0 ? json_array_get(array, (size_t)i) : NULL;
}

static json_t *extension(json_t *object, const char *name)
{
    return json_object_get(json_object_get(object, "extensions"), name);
}

double gltf_emissive_strength(json_t *gltf, size_t material)
{
    json_t *object = json_array_get(json_object_get(gltf, "materials"), material);
    return number(extension(object, "KHR_materials_emissive_strength"), "emissiveStrength", 1);
}

/* Row-major 3x4 from the node's matrix or its translation, rotation and scale. */
static void local_matrix(json_t *node, double *out)
{
    double m[16];
    if (numbers(node, "matrix", 16, m)) {
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 4; column++)
                out[4 * row + column] = m[4 * column + row];
        return;
    }
    double t[3] = {0, 0, 0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    numbers(node, "translation", 3, t);
    numbers(node, "rotation", 4, q);
    numbers(node, "scale", 3, s);
    double x = q[0], y = q[1], z = q[2], w = q[3];
    const double r[9] = {1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
                         2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
                         2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            out[4 * row + column] = r[3 * row + column] * s[column];
        out[4 * row + 3] = t[row];
    }
}

/* The world direction of a node's axis times sign; false if it has none. */
static bool axis(const double *world, int column, double sign, double *out)
{
    double length = 0;
    for (int row = 0; row < 3; row++) {
        out[row] = sign * world[4 * row + column];
        length += out[row] * out[row];
    }
    length = sqrt(length);
    if (!(length > 0) || !isfinite(length))
        return false;
    for (int row = 0; row < 3; row++)
        out[row] /= length;
    return true;
}

static void position(const double *world, double *out)
{
    for (int row = 0; row < 3; row++)
        out[row] = world[4 * row + 3];
}

static double largest_scale(const double *world)
{
    double largest = 0;
    for (int column = 0; column < 3; column++)
        largest = fmax(largest,
                       sqrt(world[column] * world[column] + world[4 + column] * world[4 + column] +
                            world[8 + column] * world[8 + column]));
    return largest;
}

/* Colour x intensity. */
static void light_color(json_t *light, double *out)
{
    double intensity = number(light, "intensity", 1);
    out[0] = out[1] = out[2] = 1;
    numbers(light, "color", 3, out);
    for (int c = 0; c < 3; c++)
        out[c] *= intensity;
}

static void write_area_light(json_t *light, const char *name, const double *world)
{
    double out[IMPORT_LIGHT_NUMBERS] = {0}, *shape = out + 3, u[3], n[3];
    const char *type = text(light, "type");
    double height = number(light, "size", 1) * largest_scale(world);
    light_color(light, out);
    position(world, shape);
    if (!(height > 0) || !isfinite(height) || !axis(world, 2, -1, n)) {
        writer_note("light '%s' has no area and is left out", name);
        return;
    }
    if (strcmp(type, "disk") == 0) {
        memcpy(shape + 3, n, sizeof(n));
        shape[6] = 0.5 * height;
        writer_light(name, PNB_LIGHT_DISK, out);
        return;
    }
    if (strcmp(type, "rect") != 0) {
        writer_note("light '%s': area lights of type '%s' are not supported", name, type);
        return;
    }
    /* Width along the node's X, height along n x X: they emit along width x height, which is n. */
    double aspect = number(json_object_get(light, "rect"), "aspect", 1), along = 0;
    if (!axis(world, 0, 1, u) || !(aspect > 0) || !isfinite(aspect)) {
        writer_note("light '%s' has no area and is left out", name);
        return;
    }
    for (int c = 0; c < 3; c++)
        along += u[c] * n[c];
    double length = 0;
    for (int c = 0; c < 3; c++) {
        u[c] -= along * n[c]; /* a sheared node: the rectangle stays one */
        length += u[c] * u[c];
    }
    length = sqrt(length);
    if (!(length > 1e-9)) {
        writer_note("light '%s' has no area and is left out", name);
        return;
    }
    for (int c = 0; c < 3; c++)
        u[c] /= length;
    for (int c = 0; c < 3; c++) {
        shape[3 + c] = u[c] * 0.5 * height * aspect;
        shape[6 + c] =
            (n[(c + 1) % 3] * u[(c + 2) % 3] - n[(c + 2) % 3] * u[(c + 1) % 3]) * 0.5 * height;
    }
    writer_light(name, PNB_LIGHT_RECTANGLE, out);
}

static void write_punctual_light(json_t *light, const char *name, const double *world)
{
    double out[IMPORT_LIGHT_NUMBERS] = {0}, *shape = out + 3;
    const char *type = text(light, "type");
    light_color(light, out);
    if (strcmp(type, "directional") == 0) {
        if (!axis(world, 2, -1, shape)) {
            writer_note("light '%s' has no direction and is left out", name);
            return;
        }
        /* glTF knows no size of it; our own files say it on the side. */
        shape[3] = number(json_object_get(light, "extras"), "angular_diameter_degrees", 0);
        if (!(shape[3] > 0 && shape[3] < 180)) {
            shape[3] = 0.53;
            writer_note("light '%s': a directional light is taken as a sun of 0.53 degrees", name);
        }
        writer_light(name, PNB_LIGHT_SUN, out);
        return;
    }
    if (strcmp(type, "spot") == 0) {
        writer_note("light '%s': a spot light is taken as a point light", name);
    } else if (strcmp(type, "point") != 0) {
        writer_note("light '%s': punctual lights of type '%s' are not supported", name, type);
        return;
    }
    position(world, shape);
    writer_light(name, PNB_LIGHT_POINT, out);
}

static void write_camera(json_t *camera, const char *name, const double *world)
{
    double out[IMPORT_CAMERA_NUMBERS];
    double yfov = number(json_object_get(camera, "perspective"), "yfov", 0);
    if (strcmp(text(camera, "type"), "perspective") != 0) {
        writer_note("camera '%s' is not a perspective camera and is left out", name);
        return;
    }
    position(world, out);
    out[9] = yfov * 180 / 3.14159265358979323846;
    if (!axis(world, 2, -1, out + 3) || !axis(world, 1, 1, out + 6) ||
        !(out[9] > 0 && out[9] < 180)) {
        writer_note("camera '%s' means nothing and is left out", name);
        return;
    }
    writer_camera(name, out);
}

static void write_node(struct walk *walk, size_t index, const double *parent, int depth)
{
    json_t *node = json_array_get(walk->nodes, index);
    if (!node || walk->visited[index] || depth > NODE_DEPTH_MAX)
        return;
    walk->visited[index] = 1;
    double local[12], world[12];
    local_matrix(node, local);
    matrix_multiply(parent, local, world);

    json_t *reference = json_object_get(node, "camera");
    json_t *thing = element(json_object_get(walk->gltf, "cameras"), reference);
    const char *node_name = text(node, "name");
    if (thing)
        write_camera(thing, *node_name ? node_name : text(thing, "name"), world);
    else if (reference)
        writer_note("node %zu refers to a camera that does not exist", index);

    static const char *const kinds[2] = {"EXT_lights_area", "KHR_lights_punctual"};
    for (int kind = 0; kind < 2; kind++) {
        json_t *mention = extension(node, kinds[kind]);
        json_t *lights = json_object_get(extension(walk->gltf, kinds[kind]), "lights");
        thing = element(lights, json_object_get(mention, "light"));
        if (!thing) {
            if (mention)
                writer_note("node %zu: %s refers to a light that does not exist", index,
                            kinds[kind]);
            continue;
        }
        const char *name = text(thing, "name");
        if (!*name)
            name = node_name;
        if (kind == 0)
            write_area_light(thing, name, world);
        else
            write_punctual_light(thing, name, world);
    }

    json_t *children = json_object_get(node, "children");
    for (size_t i = 0; i < json_array_size(children); i++) {
        json_t *child = json_array_get(children, i);
        if (json_is_integer(child) && json_integer_value(child) >= 0)
            write_node(walk, (size_t)json_integer_value(child), world, depth + 1);
    }
}

/* The scene to show; NULL if the file has none. */
static json_t *shown_scene(json_t *gltf)
{
    json_t *scenes = json_object_get(gltf, "scenes");
    json_t *scene = element(scenes, json_object_get(gltf, "scene"));
    return scene ? scene : json_array_get(scenes, 0);
}

json_t *gltf_root(json_t *gltf)
{
    json_t *roots = json_object_get(shown_scene(gltf), "nodes");
    if (json_array_size(roots) != 1)
        return NULL;
    return element(json_object_get(gltf, "nodes"), json_array_get(roots, 0));
}

json_t *gltf_child(json_t *gltf, json_t *node, bool top, size_t index, size_t count)
{
    json_t *children = NULL;
    if (node)
        children = json_object_get(node, "children");
    else if (top)
        children = json_object_get(shown_scene(gltf), "nodes");
    if (json_array_size(children) != count)
        return NULL;
    return element(json_object_get(gltf, "nodes"), json_array_get(children, index));
}

uint32_t gltf_object_flags(json_t *node)
{
    json_t *extras = json_object_get(node, "extras");
    return (json_is_false(json_object_get(extras, "casts")) ? IMPORT_CASTS_NOT : 0) |
           (json_is_false(json_object_get(extras, "receives")) ? IMPORT_RECEIVES_NOT : 0) |
           (json_is_true(json_object_get(extras, "plane")) ? IMPORT_PLANE : 0);
}

void gltf_write_surroundings(json_t *gltf)
{
    double colors[IMPORT_SURROUNDINGS_NUMBERS];
    json_t *extras = json_object_get(shown_scene(gltf), "extras");
    if (!numbers(extras, "ambient", 3, colors) || !numbers(extras, "background", 3, colors + 3))
        return;
    writer_record(IMPORT_SURROUNDINGS, sizeof(colors));
    writer_numbers(colors, IMPORT_SURROUNDINGS_NUMBERS);
}

void gltf_write_cameras_and_lights(json_t *gltf)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    struct walk walk = {.gltf = gltf, .nodes = json_object_get(gltf, "nodes")};
    size_t count = json_array_size(walk.nodes);
    walk.visited = import_alloc(count, 1);
    json_t *roots = json_object_get(shown_scene(gltf), "nodes");
    if (roots) {
        for (size_t i = 0; i < json_array_size(roots); i++) {
            json_t *root = json_array_get(roots, i);
            if (json_is_integer(root) && json_integer_value(root) >= 0)
                write_node(&walk, (size_t)json_integer_value(root), identity, 0);
        }
    } else {
        unsigned char *is_child = import_alloc(count, 1);
        for (size_t i = 0; i < count; i++) {
            json_t *children = json_object_get(json_array_get(walk.nodes, i), "children");
            for (size_t k = 0; k < json_array_size(children); k++) {
                json_int_t child = json_integer_value(json_array_get(children, k));
                if (child >= 0 && (size_t)child < count)
                    is_child[child] = 1;
            }
        }
        for (size_t i = 0; i < count; i++)
            if (!is_child[i])
                write_node(&walk, i, identity, 0);
        import_free(is_child);
    }
    import_free(walk.visited);
}
