/* The writers: what is written is valid, and reads back as the same scene; a full disk leaves
 * nothing behind. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <jansson.h>
#include <locale.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/buffer.h"
#include "scene/scene.h"
#include "scene/write.h"

static pnb_context *context;
static char folder[] = "/tmp/penumbra-write-XXXXXX";

static int setup(void **state)
{
    return pnb_context_create(NULL, &context) != PNB_OK || !mkdtemp(folder);
}

/* Removes the folder's files; returns how many there were. */
static int clear_folder(void)
{
    int count = 0;
    DIR *open_folder = opendir(folder);
    for (struct dirent *entry; (entry = readdir(open_folder));) {
        char path[600];
        snprintf(path, sizeof(path), "%s/%s", folder, entry->d_name);
        if (strcmp(entry->d_name, ".") != 0 && strcmp(entry->d_name, "..") != 0) {
            unlink(path);
            count++;
        }
    }
    closedir(open_folder);
    return count;
}

static int teardown(void **state)
{
    clear_folder();
    rmdir(folder);
    pnb_context_destroy(context);
    return 0;
}

#define CHECK(call)                                                                                \
    do {                                                                                           \
        if ((call) != PNB_OK)                                                                      \
            fail_msg("%s: %s", #call, pnb_context_error(context));                                 \
    } while (0)

static bool near3(const double *a, const double *b, double slack)
{
    for (int i = 0; i < 3; i++)
        if (!(fabs(a[i] - b[i]) <= slack))
            return false;
    return true;
}

static void same_light(const pnb_light *a, const pnb_light *b, double slack)
{
    assert_int_equal(a->type, b->type);
    assert_true(near3(a->color, b->color, slack * (1 + fabs(a->color[0]))));
    switch (a->type) {
    case PNB_LIGHT_RECTANGLE:
        assert_true(near3(a->shape.rectangle.center, b->shape.rectangle.center, slack));
        assert_true(near3(a->shape.rectangle.half_u, b->shape.rectangle.half_u, slack));
        assert_true(near3(a->shape.rectangle.half_v, b->shape.rectangle.half_v, slack));
        break;
    case PNB_LIGHT_DISK: {
        double na[3], nb[3];
        v3_store(na, v3_normalize(v3_load(a->shape.disk.normal)));
        v3_store(nb, v3_normalize(v3_load(b->shape.disk.normal)));
        assert_true(near3(a->shape.disk.center, b->shape.disk.center, slack));
        assert_true(near3(na, nb, slack));
        assert_true(fabs(a->shape.disk.radius - b->shape.disk.radius) <= slack);
        break;
    }
    case PNB_LIGHT_POLYGON: {
        /* The same corners in the same order, from any of them on. */
        size_t n = a->shape.polygon.vertex_count, shift;
        assert_int_equal(n, b->shape.polygon.vertex_count);
        for (shift = 0; shift < n; shift++) {
            size_t i = 0;
            while (i < n && near3(a->shape.polygon.vertices + 3 * i,
                                  b->shape.polygon.vertices + 3 * ((i + shift) % n), slack))
                i++;
            if (i == n)
                break;
        }
        assert_true(shift < n);
        break;
    }
    case PNB_LIGHT_LINE:
        assert_true(near3(a->shape.line.from, b->shape.line.from, slack));
        assert_true(near3(a->shape.line.to, b->shape.line.to, slack));
        break;
    case PNB_LIGHT_POINT:
        assert_true(near3(a->shape.point.position, b->shape.point.position, slack));
        break;
    case PNB_LIGHT_SUN: {
        double na[3], nb[3];
        v3_store(na, v3_normalize(v3_load(a->shape.sun.direction)));
        v3_store(nb, v3_normalize(v3_load(b->shape.sun.direction)));
        assert_true(near3(na, nb, slack));
        assert_true(fabs(a->shape.sun.angular_diameter_degrees -
                         b->shape.sun.angular_diameter_degrees) <= slack);
        break;
    }
    }
}

static void same_bounds(const pnb_scene *a, const pnb_scene *b, double slack)
{
    double low_a[3], high_a[3], low_b[3], high_b[3];
    assert_true(pnb_scene_bounds(a, low_a, high_a) && pnb_scene_bounds(b, low_b, high_b));
    assert_true(near3(low_a, low_b, slack) && near3(high_a, high_b, slack));
}

static void scene_files_come_back_the_same(void **state)
{
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_scene *scene, *back;
        char path[128];
        pnb_builtin(i, &info);
        CHECK(scene_builtin(context, info.name, &scene));
        if (pnb_scene_triangle_count(scene) > 100000) {
            pnb_scene_destroy(scene);
            continue;
        }
        snprintf(path, sizeof(path), "%s/%s.json", folder, info.name);
        CHECK(pnb_scene_write_json(scene, path));
        CHECK(pnb_scene_load(context, path, &back));
        assert_int_equal(pnb_scene_note_count(back), 0);
        assert_int_equal(pnb_scene_object_count(back), pnb_scene_object_count(scene));
        assert_int_equal(pnb_scene_mesh_count(back), pnb_scene_mesh_count(scene));
        assert_int_equal(pnb_scene_triangle_count(back), pnb_scene_triangle_count(scene));
        assert_int_equal(pnb_scene_light_count(back), pnb_scene_light_count(scene));
        for (size_t k = 0; k < pnb_scene_light_count(scene); k++) {
            pnb_light a, b;
            pnb_scene_light(scene, k, &a);
            pnb_scene_light(back, k, &b);
            same_light(&a, &b, 0);
        }
        for (size_t k = 0; k < pnb_scene_object_count(scene); k++) {
            pnb_object a, b;
            pnb_scene_object(scene, k, &a);
            pnb_scene_object(back, k, &b);
            assert_string_equal(a.name, b.name);
            assert_true(near3(a.color, b.color, 0));
            assert_true(a.plane == b.plane && a.casts == b.casts && a.receives == b.receives);
            for (int m = 0; m < 12; m++)
                assert_true(fabs(a.world_from_mesh[m] - b.world_from_mesh[m]) < 1e-12);
            /* Vertices bit for bit, whatever their order became. */
            pnb_mesh_info c, d;
            CHECK(pnb_scene_mesh_info(scene, a.mesh, &c));
            CHECK(pnb_scene_mesh_info(back, b.mesh, &d));
            assert_true(near3(c.bounds_min, d.bounds_min, 0));
            assert_true(near3(c.bounds_max, d.bounds_max, 0));
            assert_int_equal(c.welded_vertex_count, d.welded_vertex_count);
            assert_int_equal(c.edge_count, d.edge_count);
            assert_int_equal(c.closed, d.closed);
        }
        pnb_camera a, b;
        pnb_scene_camera(scene, &a);
        pnb_scene_camera(back, &b);
        assert_memory_equal(&a, &b, sizeof(a));
        pnb_scene_destroy(back);
        pnb_scene_destroy(scene);
    }
    clear_folder();
}

static unsigned char *read_all(const char *path, size_t *out_size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    *out_size = (size_t)ftell(file);
    rewind(file);
    unsigned char *bytes = malloc(*out_size);
    assert_int_equal(fread(bytes, 1, *out_size, file), *out_size);
    fclose(file);
    return bytes;
}

static size_t u32(const unsigned char *p)
{
    return p[0] | (size_t)p[1] << 8 | (size_t)p[2] << 16 | (size_t)p[3] << 24;
}

static size_t member(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    assert_true(json_is_integer(value));
    return (size_t)json_integer_value(value);
}

/* Header, chunks, and every reference of the document. */
static void validate_glb(const char *path)
{
    size_t size;
    unsigned char *bytes = read_all(path, &size);
    assert_memory_equal(bytes, "glTF", 4);
    assert_int_equal(u32(bytes + 4), 2);
    assert_int_equal(u32(bytes + 8), size);
    size_t json_size = u32(bytes + 12);
    assert_memory_equal(bytes + 16, "JSON", 4);
    assert_true(json_size % 4 == 0 && 20 + json_size + 8 <= size);
    const unsigned char *chunk = bytes + 20 + json_size;
    assert_memory_equal(chunk + 4, "BIN\0", 4);
    size_t bin_size = u32(chunk);
    assert_int_equal(20 + json_size + 8 + bin_size, size);

    json_error_t error;
    json_t *root = json_loadb((char *)bytes + 20, json_size, JSON_REJECT_DUPLICATES, &error);
    if (!root)
        fail_msg("%s: %s", path, error.text);
    json_t *nodes = json_object_get(root, "nodes"), *meshes = json_object_get(root, "meshes");
    json_t *accessors = json_object_get(root, "accessors");
    json_t *views = json_object_get(root, "bufferViews");
    json_t *materials = json_object_get(root, "materials"), *item, *inner;
    size_t index;
    assert_int_equal(member(json_array_get(json_object_get(root, "buffers"), 0), "byteLength"),
                     bin_size);
    json_array_foreach(views, index, item)
    {
        assert_true(member(item, "byteOffset") + member(item, "byteLength") <= bin_size);
        assert_int_equal(member(item, "byteOffset") % 4, 0);
    }
    json_array_foreach(accessors, index, item)
    {
        json_t *view = json_array_get(views, member(item, "bufferView"));
        assert_non_null(view);
        bool scalar = strcmp(json_string_value(json_object_get(item, "type")), "SCALAR") == 0;
        assert_int_equal(member(item, "count") * (scalar ? 4 : 12), member(view, "byteLength"));
    }
    json_array_foreach(meshes, index, item)
    {
        json_t *primitive = json_array_get(json_object_get(item, "primitives"), 0);
        json_t *attributes = json_object_get(primitive, "attributes");
        json_t *positions = json_array_get(accessors, member(attributes, "POSITION"));
        assert_int_equal(json_array_size(json_object_get(positions, "min")), 3);
        assert_int_equal(json_array_size(json_object_get(positions, "max")), 3);
        json_t *indices = json_array_get(accessors, member(primitive, "indices"));
        assert_non_null(json_array_get(materials, member(primitive, "material")));
        /* Indices in range. */
        json_t *view = json_array_get(views, member(indices, "bufferView"));
        const unsigned char *data = chunk + 8 + member(view, "byteOffset");
        for (size_t i = 0; i < member(indices, "count"); i++)
            assert_true(u32(data + 4 * i) < member(positions, "count"));
    }
    json_array_foreach(nodes, index, item)
    {
        if (json_object_get(item, "mesh"))
            assert_non_null(json_array_get(meshes, member(item, "mesh")));
        const char *name;
        json_t *used = json_object_get(root, "extensionsUsed");
        json_object_foreach(json_object_get(item, "extensions"), name, inner)
        {
            json_t *lights = json_object_get(
                json_object_get(json_object_get(root, "extensions"), name), "lights");
            assert_non_null(json_array_get(lights, member(inner, "light")));
            size_t k;
            json_t *word;
            bool listed = false;
            json_array_foreach(used, k, word) listed =
                listed || strcmp(json_string_value(word), name) == 0;
            assert_true(listed);
        }
    }
    assert_int_equal(json_array_size(json_object_get(
                         json_array_get(json_object_get(root, "scenes"), 0), "nodes")),
                     json_array_size(nodes));
    json_decref(root);
    free(bytes);
}

static void glb_comes_back_the_same(void **state)
{
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        pnb_builtin_info info;
        pnb_scene *scene, *back;
        char path[128];
        pnb_builtin(i, &info);
        CHECK(scene_builtin(context, info.name, &scene));
        snprintf(path, sizeof(path), "%s/%s.glb", folder, info.name);
        if (pnb_scene_triangle_count(scene) > 100000) {
            pnb_scene_destroy(scene);
            continue;
        }
        CHECK(pnb_scene_write_glb(scene, path));
        validate_glb(path);
        CHECK(pnb_scene_load(context, path, &back));
        size_t faces = 0;
        for (size_t k = 0; k < pnb_scene_light_count(scene); k++) {
            pnb_light a, b;
            pnb_scene_light(scene, k, &a);
            assert_true(k < pnb_scene_light_count(back));
            pnb_scene_light(back, k, &b);
            if (a.type == PNB_LIGHT_POLYGON)
                faces += a.shape.polygon.vertex_count - 2;
            if (a.type == PNB_LIGHT_LINE) {
                /* A strip stands for it: same middle, same length. */
                faces += 2;
                assert_int_equal(b.type, PNB_LIGHT_RECTANGLE);
                vec3 middle =
                    v3_scale(v3_add(v3_load(a.shape.line.from), v3_load(a.shape.line.to)), 0.5);
                assert_true(v3_length(v3_sub(middle, v3_load(b.shape.rectangle.center))) < 1e-5);
                double u = v3_length(v3_load(b.shape.rectangle.half_u));
                double v = v3_length(v3_load(b.shape.rectangle.half_v)),
                       length =
                           v3_length(v3_sub(v3_load(a.shape.line.to), v3_load(a.shape.line.from)));
                assert_true(fabs(fmax(u, v) - length / 2) < 1e-5);
                assert_true(fabs(fmin(u, v) - length / 2000) < 1e-6);
                continue;
            }
            same_light(&a, &b, 1e-6);
        }
        assert_int_equal(pnb_scene_light_count(back), pnb_scene_light_count(scene));
        assert_int_equal(pnb_scene_triangle_count(back), pnb_scene_triangle_count(scene) + faces);
        if (faces == 0)
            same_bounds(scene, back, 1e-5);
        pnb_camera a, b;
        double towards_a[3], towards_b[3];
        pnb_scene_camera(scene, &a);
        pnb_scene_camera(back, &b);
        v3_store(towards_a, v3_normalize(v3_sub(v3_load(a.target), v3_load(a.eye))));
        v3_store(towards_b, v3_normalize(v3_sub(v3_load(b.target), v3_load(b.eye))));
        assert_true(near3(a.eye, b.eye, 1e-6) && near3(towards_a, towards_b, 1e-6));
        assert_true(fabs(a.vertical_fov_degrees - b.vertical_fov_degrees) < 1e-4);
        pnb_scene_destroy(back);
        pnb_scene_destroy(scene);
    }
    clear_folder();
}

/* Mirrored, sheared and flattened placements, an oblique light, names that no file may have. */
static pnb_scene *awkward_scene(void)
{
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    static const double placements[4][12] = {
        {-2, 0, 0, 5, 0, 1, 0, 0, 0, 0, 3, 0.1},
        {1, 0.5, 0, 0, 0, 1, 0, 1, 0, 0, 1, 0},
        {1, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 7},
        {0, 0, 1.5, 0, 1.5, 0, 0, -2, 0, 1.5, 0, 0},
    };
    pnb_scene *scene;
    size_t mesh;
    CHECK(pnb_scene_create(context, &scene));
    CHECK(scene_add_plane(scene, "wall", v3(1, 2, 3), v3(1, 2, -0.5), 4, (double[]){1, 0, 0.5},
                          NULL));
    CHECK(pnb_scene_add_mesh(
        scene, &(pnb_mesh_desc){"a/b\xff \"c\"", positions, NULL, 4, indices, 4}, &mesh));
    for (int i = 0; i < 4; i++) {
        pnb_object object = {.name = i ? "again" : "../\n\"x\\",
                             .mesh = mesh,
                             .casts = i != 2,
                             .receives = i != 1,
                             .color = {0.1 * i, 0.2, 0.3}};
        memcpy(object.world_from_mesh, placements[i], sizeof(placements[i]));
        CHECK(pnb_scene_add_object(scene, &object, NULL));
    }
    pnb_light oblique = {.type = PNB_LIGHT_RECTANGLE, .color = {3, 2, 7}, .name = "\"oblique\""};
    v3_store(oblique.shape.rectangle.center, v3(0, 5, 0));
    v3_store(oblique.shape.rectangle.half_u, v3(1, 0, 0.2));
    v3_store(oblique.shape.rectangle.half_v, v3(0.7, 0, 1));
    CHECK(pnb_scene_add_light(scene, &oblique, NULL));
    pnb_light point = {.type = PNB_LIGHT_POINT, .color = {10, 20, 5}};
    v3_store(point.shape.point.position, v3(1, 6, 2));
    CHECK(pnb_scene_add_light(scene, &point, NULL));
    pnb_light sun = {.type = PNB_LIGHT_SUN, .color = {1, 2, 0}};
    v3_store(sun.shape.sun.direction, v3(0, -3, 1));
    sun.shape.sun.angular_diameter_degrees = 7.5;
    CHECK(pnb_scene_add_light(scene, &sun, NULL));
    return scene;
}

static void awkward_scenes_are_written(void **state)
{
    pnb_scene *scene = awkward_scene(), *back;
    char path[128];
    snprintf(path, sizeof(path), "%s/awkward.json", folder);
    CHECK(pnb_scene_write_json(scene, path));
    CHECK(pnb_scene_load(context, path, &back));
    assert_int_equal(pnb_scene_object_count(back), 5);
    assert_int_equal(pnb_scene_triangle_count(back), pnb_scene_triangle_count(scene));
    same_bounds(scene, back, 2e-5);
    pnb_object a, b;
    pnb_light light_a, light_b;
    for (size_t i = 0; i < 5; i++) {
        pnb_scene_object(scene, i, &a);
        pnb_scene_object(back, i, &b);
        assert_true(a.casts == b.casts && a.receives == b.receives && a.plane == b.plane);
    }
    for (size_t i = 0; i < 3; i++) {
        pnb_scene_light(scene, i, &light_a);
        pnb_scene_light(back, i, &light_b);
        same_light(&light_a, &light_b, 0);
    }
    /* The mirrored tetrahedron and the turned one are instances of one file. */
    pnb_scene_object(back, 1, &a);
    pnb_scene_object(back, 4, &b);
    assert_int_equal(a.mesh, b.mesh);
    pnb_scene_destroy(back);

    snprintf(path, sizeof(path), "%s/awkward.glb", folder);
    CHECK(pnb_scene_write_glb(scene, path));
    validate_glb(path);
    CHECK(pnb_scene_load(context, path, &back));
    assert_int_equal(pnb_scene_light_count(back), 3);
    /* Those of the document come first, emissive faces last. */
    for (size_t i = 0; i < 3; i++) {
        pnb_scene_light(scene, (i + 1) % 3, &light_a);
        pnb_scene_light(back, i, &light_b);
        if (light_a.type != PNB_LIGHT_RECTANGLE) {
            same_light(&light_a, &light_b, 1e-6);
            continue;
        }
        assert_true(near3(light_a.color, light_b.color, 1e-5));
        /* A parallelogram comes back as a polygon: the same corners, lit on the same side. */
        static const int side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
        double corners[12];
        vec3 center = v3_load(light_a.shape.rectangle.center);
        vec3 u = v3_load(light_a.shape.rectangle.half_u);
        vec3 v = v3_load(light_a.shape.rectangle.half_v);
        for (int c = 0; c < 4; c++)
            v3_store(corners + 3 * c, v3_mad(v3_mad(center, u, side[c][0]), v, side[c][1]));
        light_a.type = PNB_LIGHT_POLYGON;
        light_a.shape.polygon.vertices = corners;
        light_a.shape.polygon.vertex_count = 4;
        same_light(&light_a, &light_b, 1e-5);
    }
    pnb_scene_destroy(back);
    pnb_scene_destroy(scene);
    clear_folder();
}

static void a_full_disk_leaves_nothing(void **state)
{
    pnb_scene *scene;
    char path[128];
    CHECK(scene_builtin(context, "jack-in-the-box", &scene));
    /* A limit on file size acts like a full disk at the larger meshes. */
    struct rlimit old, small = {20000, 20000};
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &old), 0);
    small.rlim_max = old.rlim_max;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    snprintf(path, sizeof(path), "%s/jack.json", folder);
    pnb_status json = pnb_scene_write_json(scene, path);
    char error[200];
    snprintf(error, sizeof(error), "%.190s", pnb_context_error(context));
    snprintf(path, sizeof(path), "%s/jack.glb", folder);
    pnb_status glb = pnb_scene_write_glb(scene, path);
    setrlimit(RLIMIT_FSIZE, &old);
    assert_int_equal(json, PNB_ERROR_FILE);
    assert_int_equal(glb, PNB_ERROR_FILE);
    assert_non_null(strstr(error, "jack-"));
    assert_non_null(strstr(pnb_context_error(context), "jack.glb: "));
    assert_int_equal(clear_folder(), 0);
    assert_int_equal(pnb_scene_write_json(scene, "/nowhere/at/all.json"), PNB_ERROR_FILE);
    assert_int_equal(pnb_scene_write_glb(scene, "/nowhere/at/all.glb"), PNB_ERROR_FILE);
    pnb_scene_destroy(scene);
}

static void numbers_keep_every_bit(void **state)
{
    static const double values[] = {0.1, 1, -3, 1e18, 1.0 / 3, 4e-324, 0.30000000000000004, 2e-7};
    /* A locale with a decimal comma, where the machine has one. */
    setlocale(LC_NUMERIC, "de_DE.UTF-8");
    struct buffer buffer;
    for (size_t i = 0; i < sizeof(values) / sizeof(values[0]); i++) {
        buffer_init(context, &buffer);
        buffer_number(&buffer, values[i]);
        buffer_add(&buffer, "", 1);
        assert_null(strchr(buffer.bytes, ','));
        setlocale(LC_NUMERIC, "C");
        assert_true(strtod(buffer.bytes, NULL) == values[i]);
        setlocale(LC_NUMERIC, "de_DE.UTF-8");
        buffer_finish(&buffer);
    }
    setlocale(LC_NUMERIC, "C");
    buffer_init(context, &buffer);
    buffer_number(&buffer, 0.8);
    buffer_json_string(&buffer, "a\"b\\\n\xff\xc3\xa9");
    buffer_add(&buffer, "", 1);
    assert_string_equal(buffer.bytes, "0.8\"a\\\"b\\\\\\u000a?\xc3\xa9\"");
    buffer_finish(&buffer);
}

static long allocations_left;

static void *failing_reallocate(void *user, void *old, size_t size)
{
    if (size == 0) {
        free(old);
        return NULL;
    }
    return allocations_left-- > 0 ? realloc(old, size) : NULL;
}

/* Every single allocation fails once: an error each time, nothing lost, nothing left behind. */
static void no_memory_is_an_error(void **state)
{
    static const char *const names[] = {"overlap", "room", "outdoor", "three-lights"};
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        bool done = false;
        for (long limit = 0; !done; limit += 1 + limit / 40) {
            pnb_context *poor;
            pnb_scene *scene = NULL, *back = NULL;
            char json[128], glb[128];
            snprintf(json, sizeof(json), "%s/poor.json", folder);
            snprintf(glb, sizeof(glb), "%s/poor.glb", folder);
            allocations_left = 1;
            pnb_context_desc desc = {.reallocate = failing_reallocate};
            assert_int_equal(pnb_context_create(&desc, &poor), PNB_OK);
            allocations_left = limit;
            pnb_status status = scene_builtin(poor, names[i], &scene);
            assert_true((status == PNB_OK) == (scene != NULL));
            pnb_mesh_info info;
            if (status == PNB_OK)
                status = pnb_scene_mesh_info(scene, 1, &info);
            if (status == PNB_OK)
                status = pnb_scene_write_glb(scene, glb);
            if (status == PNB_OK)
                status = pnb_scene_write_json(scene, json);
            if (status == PNB_OK && i == 0) {
                /* The import is another's; a scene of a plane reads the same way. */
                static const char text[] =
                    "{\"objects\":[{\"plane\":{\"half_size\":1},\"name\":\"p\"}],\"lights\":[{"
                    "\"type\":\"polygon\",\"vertices\":[[0,4,0],[1,4,0],[0,4,1]]}]}";
                status = pnb_scene_parse(poor, text, strlen(text), NULL, &back);
            }
            if (status == PNB_ERROR_MEMORY)
                assert_true(*pnb_context_error(poor) != 0);
            else if (status != PNB_OK)
                fail_msg("%s with %ld allocations: %s", names[i], limit, pnb_context_error(poor));
            done = status == PNB_OK;
            pnb_scene_destroy(back);
            pnb_scene_destroy(scene);
            pnb_context_destroy(poor);
        }
    }
    clear_folder();
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_keep_every_bit),
        cmocka_unit_test(scene_files_come_back_the_same),
        cmocka_unit_test(glb_comes_back_the_same),
        cmocka_unit_test(awkward_scenes_are_written),
        cmocka_unit_test(a_full_disk_leaves_nothing),
        cmocka_unit_test(no_memory_is_an_error),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
