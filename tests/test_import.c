/* Meshes and scenes from files, through the importer's process: what comes in, and what goes wrong.
 */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <locale.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scene/import.h"

static pnb_context *context;
static char folder[64];

static int open_context(void **state)
{
    snprintf(folder, sizeof(folder), "/tmp/pnb-import-XXXXXX");
    return pnb_context_create(NULL, &context) == PNB_OK && mkdtemp(folder) ? 0 : -1;
}

static int close_context(void **state)
{
    DIR *entries = opendir(folder);
    for (struct dirent *entry; entries && (entry = readdir(entries));)
        unlinkat(dirfd(entries), entry->d_name, entry->d_type == DT_DIR ? AT_REMOVEDIR : 0);
    if (entries)
        closedir(entries);
    rmdir(folder);
    pnb_context_destroy(context);
    return 0;
}

static const char *place(const char *name)
{
    static char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

static const char *write_bytes(const char *name, const void *bytes, size_t size)
{
    const char *path = place(name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
    return path;
}

static const char *write_text(const char *name, const char *text)
{
    return write_bytes(name, text, strlen(text));
}

static pnb_scene *import(const char *path)
{
    pnb_scene *scene;
    pnb_status status = scene_import(context, path, &scene);
    if (status != PNB_OK)
        print_error("%s\n", pnb_context_error(context));
    assert_int_equal(status, PNB_OK);
    return scene;
}

/* The import fails, and its error names the file and holds the given words. */
static void import_fails(const char *path, const char *words)
{
    pnb_scene *scene;
    if (scene_import(context, path, &scene) == PNB_OK)
        fail_msg("%s was read", path);
    assert_null(scene);
    if (!strstr(pnb_context_error(context), words) || !strstr(pnb_context_error(context), path))
        fail_msg("'%s' holds no '%s'", pnb_context_error(context), words);
}

static bool has_note(const pnb_scene *scene, const char *words)
{
    for (size_t i = 0; i < pnb_scene_note_count(scene); i++)
        if (strstr(pnb_scene_note(scene, i), words))
            return true;
    return false;
}

static int open_descriptors(void)
{
    int count = 0;
    DIR *entries = opendir("/proc/self/fd");
    while (readdir(entries))
        count++;
    closedir(entries);
    return count;
}

static void vectors_near(const double *a, double x, double y, double z)
{
    if (!(fabs(a[0] - x) < 1e-6 && fabs(a[1] - y) < 1e-6 && fabs(a[2] - z) < 1e-6))
        fail_msg("(%g, %g, %g) is not (%g, %g, %g)", a[0], a[1], a[2], x, y, z);
}

/* --- the real meshes --- */

static void real_meshes_have_their_counts(void **state)
{
    /* Distinct positions that triangles use: the bunny's file has 1,113 unused vertices, suzanne's
     * and the teapot's repeat some. */
    static const struct {
        const char *name;
        size_t vertices, triangles, open, non_manifold;
    } meshes[] = {
        {"spot", 2930, 5856, 0, 0},        {"cow", 2903, 5804, 0, 0},
        {"fandisk", 6475, 12946, 0, 0},    {"rocker-arm", 10044, 20088, 0, 0},
        {"nefertiti", 49971, 99938, 0, 0}, {"stanford-bunny", 34834, 69451, 223, 0},
        {"teapot", 3241, 6320, 160, 0},    {"suzanne", 505, 968, SIZE_MAX, SIZE_MAX},
    };
    const char *models = getenv("PNB_MODELS"), *source = getenv("PNB_SOURCE_DIR");
    char path[4096];
    for (size_t i = 0; i < sizeof(meshes) / sizeof(meshes[0]); i++) {
        if (models)
            snprintf(path, sizeof(path), "%s/%s.obj", models, meshes[i].name);
        else
            snprintf(path, sizeof(path), "%s/../shared/models/%s.obj", source ? source : ".",
                     meshes[i].name);
        if (access(path, R_OK) != 0)
            skip();
        pnb_scene *scene = import(path);
        pnb_mesh_info info;
        assert_int_equal(pnb_scene_mesh_info(scene, 0, &info), PNB_OK);
        assert_int_equal(info.welded_vertex_count, meshes[i].vertices);
        assert_int_equal(info.triangle_count, meshes[i].triangles);
        if (meshes[i].open != SIZE_MAX) {
            assert_int_equal(info.open_edge_count, meshes[i].open);
            assert_int_equal(info.non_manifold_edge_count, meshes[i].non_manifold);
        }
        assert_string_equal(pnb_scene_name(scene), meshes[i].name);
        /* Bare meshes: ground, light, camera were supplied. */
        assert_int_equal(pnb_scene_object_count(scene), 2);
        assert_int_equal(pnb_scene_light_count(scene), 1);
        assert_true(has_note(scene, "ground") && has_note(scene, "light") &&
                    has_note(scene, "camera"));
        pnb_scene_destroy(scene);

        assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
        size_t mesh;
        assert_int_equal(scene_import_mesh(scene, path, &mesh), PNB_OK);
        assert_int_equal(pnb_scene_mesh_info(scene, mesh, &info), PNB_OK);
        assert_int_equal(info.welded_vertex_count, meshes[i].vertices);
        pnb_scene_destroy(scene);
    }
}

/* --- glTF written by hand --- */

/* A GLB of this JSON and of a binary chunk: a unit quad in the xy plane facing +Z (positions at 0,
 * indices at 48). */
static const char *write_glb(const char *name, const char *json)
{
    static const float positions[12] = {-0.5f, -0.5f, 0, 0.5f,  -0.5f, 0,
                                        0.5f,  0.5f,  0, -0.5f, 0.5f,  0};
    static const uint16_t indices[6] = {0, 1, 2, 0, 2, 3};
    unsigned char *bytes = calloc(1, strlen(json) + 200);
    size_t length = strlen(json), padded = (length + 3) / 4 * 4;
    uint32_t total = (uint32_t)(12 + 8 + padded + 8 + 60);
    uint32_t head[5] = {0x46546c67, 2, total, (uint32_t)padded, 0x4e4f534a};
    uint32_t second[2] = {60, 0x004e4942};
    memcpy(bytes, head, 20);
    memset(bytes + 20, ' ', padded);
    memcpy(bytes + 20, json, length);
    memcpy(bytes + 20 + padded, second, 8);
    memcpy(bytes + 28 + padded, positions, 48);
    memcpy(bytes + 76 + padded, indices, 12);
    const char *path = write_bytes(name, bytes, total);
    free(bytes);
    return path;
}

#define BUFFERS                                                                                    \
    "\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":60}],"                           \
    "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":48},"                          \
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":12}],"                                         \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\","       \
    "\"min\":[-0.5,-0.5,0],\"max\":[0.5,0.5,0]},"                                                  \
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"}],"
#define QUAD(material)                                                                             \
    "{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"material\":" #material "}]" \
    "}"

/* Floor (turned by -90 degrees about x, scaled by 10), two instances of it, a camera, every light.
 */
static const char full_scene[] =
    "{" BUFFERS "\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2,3,4,5,6,7]}],"
    "\"extensionsUsed\":[\"EXT_lights_area\",\"KHR_lights_punctual\"],"
    "\"extensions\":{\"EXT_lights_area\":{\"lights\":["
    "{\"name\":\"panel\",\"type\":\"rect\",\"size\":0.5,\"rect\":{\"aspect\":2},"
    "\"color\":[1,0.5,0.25],\"intensity\":8},"
    "{\"type\":\"disk\",\"size\":2,\"intensity\":3}]},"
    "\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"intensity\":5},"
    "{\"type\":\"directional\",\"intensity\":2,\"name\":\"sky\"},"
    "{\"type\":\"spot\",\"intensity\":7,\"spot\":{}}]}},"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
    "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.2,0.4,0.6,1]}}],"
    "\"meshes\":[" QUAD(
        0) "],"
           "\"nodes\":["
           "{\"name\":\"floor\",\"mesh\":0,\"rotation\":[-0.70710678118,0,0,0.70710678118],"
           "\"scale\":[10,10,10]},"
           "{\"name\":\"card\",\"translation\":[0,3,0],\"scale\":[2,2,2],\"children\":[8]},"
           "{\"name\":\"eye\",\"camera\":0,\"translation\":[0,1,9]},"
           /* turned by -90 degrees about x: emits along -Y; largest scale 3 */
           "{\"name\":\"lamp\",\"translation\":[1,4,2],\"rotation\":[-0.70710678118,0,0,0."
           "70710678118],"
           "\"scale\":[1,-3,2],\"extensions\":{\"EXT_lights_area\":{\"light\":0}}},"
           /* turned by 90 degrees about y: emits along -X */
           "{\"translation\":[-5,4,0],\"rotation\":[0,0.70710678118,0,0.70710678118],"
           "\"scale\":[0.5,0.5,0.5],\"extensions\":{\"EXT_lights_area\":{\"light\":1}}},"
           "{\"translation\":[0,6,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
           "{\"rotation\":[-0.70710678118,0,0,0.70710678118],"
           "\"extensions\":{\"KHR_lights_punctual\":{\"light\":1}}},"
           "{\"translation\":[0,7,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":2}}},"
           "{\"name\":\"inner\",\"mesh\":0,\"translation\":[0,0,1]}]}";

static void gltf_scene_arrives_whole(void **state)
{
    pnb_scene *scene = import(write_glb("full.glb", full_scene));
    pnb_object object;
    pnb_light light;
    pnb_camera camera;
    assert_int_equal(pnb_scene_mesh_count(scene), 1); /* shared */
    assert_int_equal(pnb_scene_object_count(scene), 2);
    pnb_scene_object(scene, 0, &object);
    assert_string_equal(object.name, "floor");
    vectors_near(object.color, 0.2, 0.4, 0.6);
    double corner[3];
    v3_store(corner, m34_point(object.world_from_mesh, v3(0.5, 0.5, 0)));
    vectors_near(corner, 5, 0, -5);
    pnb_scene_object(scene, 1, &object);
    v3_store(corner, m34_point(object.world_from_mesh, v3(0.5, 0.5, 0)));
    vectors_near(corner, 1, 4, 2);

    pnb_scene_camera(scene, &camera);
    vectors_near(camera.eye, 0, 1, 9);
    assert_true(fabs(camera.target[0]) < 1e-9 && fabs(camera.target[1] - 1) < 1e-9 &&
                camera.target[2] < 8);
    vectors_near(camera.up, 0, 1, 0);
    assert_true(fabs(camera.vertical_fov_degrees - 0.8 * 180 / M_PI) < 1e-6);

    assert_int_equal(pnb_scene_light_count(scene), 5);
    pnb_scene_light(scene, 0, &light);
    assert_int_equal(light.type, PNB_LIGHT_RECTANGLE);
    assert_string_equal(light.name, "panel");
    vectors_near(light.color, 8, 4, 2);
    vectors_near(light.shape.rectangle.center, 1, 4, 2);
    vec3 u = v3_load(light.shape.rectangle.half_u), v = v3_load(light.shape.rectangle.half_v);
    assert_true(fabs(v3_length(u) - 0.5 * 0.5 * 3 * 2) < 1e-6); /* width = height x aspect */
    assert_true(fabs(v3_length(v) - 0.5 * 0.5 * 3) < 1e-6);
    double normal[3];
    v3_store(normal, v3_normalize(v3_cross(u, v)));
    vectors_near(normal, 0, -1, 0);
    pnb_scene_light(scene, 1, &light);
    assert_int_equal(light.type, PNB_LIGHT_DISK);
    vectors_near(light.color, 3, 3, 3);
    vectors_near(light.shape.disk.normal, -1, 0, 0);
    assert_true(fabs(light.shape.disk.radius - 0.5) < 1e-6);
    pnb_scene_light(scene, 2, &light);
    assert_int_equal(light.type, PNB_LIGHT_POINT);
    vectors_near(light.color, 5, 5, 5);
    vectors_near(light.shape.point.position, 0, 6, 0);
    pnb_scene_light(scene, 3, &light);
    assert_int_equal(light.type, PNB_LIGHT_SUN);
    vectors_near(light.shape.sun.direction, 0, -1, 0);
    pnb_scene_light(scene, 4, &light);
    assert_int_equal(light.type, PNB_LIGHT_POINT);
    vectors_near(light.color, 7, 7, 7);
    assert_true(has_note(scene, "spot") && has_note(scene, "directional"));
    assert_false(has_note(scene, "supplied"));
    pnb_scene_destroy(scene);
}

static void merged_mesh_has_every_instance(void **state)
{
    pnb_scene *scene;
    size_t mesh;
    pnb_mesh_info info;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    assert_int_equal(scene_import_mesh(scene, write_glb("full.glb", full_scene), &mesh), PNB_OK);
    assert_int_equal(pnb_scene_mesh_info(scene, mesh, &info), PNB_OK);
    assert_int_equal(info.triangle_count, 4);
    vectors_near(info.bounds_min, -5, 0, -5);
    vectors_near(info.bounds_max, 5, 4, 5);
    pnb_scene_destroy(scene);
}

/* An emissive quad 4 above the floor, facing down: a rectangle of 2 x 1. */
static void emissive_quad_is_a_light(void **state)
{
    static const char json[] =
        "{" BUFFERS "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
        "\"materials\":[{},{\"emissiveFactor\":[1,0.5,0],\"extensions\":"
        "{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":6}}}],"
        "\"meshes\":[" QUAD(0) "," QUAD(
            1) "],"
               "\"nodes\":[{\"mesh\":0,\"rotation\":[-0.70710678118,0,0,0.70710678118],"
               "\"scale\":[10,10,10]},"
               "{\"name\":\"glow\",\"mesh\":1,\"translation\":[0,4,0],"
               "\"rotation\":[0.70710678118,0,0,0.70710678118],\"scale\":[%s]}]}";
    static const char *const scales[2] = {"2,1,1", "-2,1,1"}; /* the second one mirrors */
    for (int i = 0; i < 2; i++) {
        char text[4096];
        snprintf(text, sizeof(text), json, scales[i]);
        pnb_scene *scene = import(write_glb("glow.glb", text));
        pnb_light light;
        pnb_object object;
        assert_int_equal(pnb_scene_light_count(scene), 1);
        pnb_scene_light(scene, 0, &light);
        assert_int_equal(light.type, PNB_LIGHT_RECTANGLE);
        assert_string_equal(light.name, "glow");
        vectors_near(light.color, 6, 3, 0);
        vectors_near(light.shape.rectangle.center, 0, 4, 0);
        vec3 u = v3_load(light.shape.rectangle.half_u), v = v3_load(light.shape.rectangle.half_v);
        assert_true(fabs(v3_length(u) * v3_length(v) - 0.5) < 1e-5);
        double normal[3];
        v3_store(normal, v3_normalize(v3_cross(u, v)));
        vectors_near(normal, 0, -1, 0);
        pnb_scene_object(scene, 0, &object);
        assert_true(object.casts && object.receives);
        pnb_scene_object(scene, 1, &object);
        assert_false(object.casts);
        /* A floor is there already; a camera is not. */
        assert_int_equal(pnb_scene_object_count(scene), 2);
        assert_true(has_note(scene, "supplied: a camera"));
        pnb_scene_destroy(scene);
    }
}

/* OBJ with a material file: an L of three quads, a box and a fan that is not flat. */
static void emissive_shapes(void **state)
{
    write_text("e.mtl", "newmtl dark\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 1 1 1\nKe 2 2 2\n");
    const char *path = write_text("l.obj", "mtllib e.mtl\n"
                                           "v 0 2 0\nv 1 2 0\nv 2 2 0\nv 0 2 1\nv 1 2 1\nv 2 2 1\n"
                                           "v 0 2 2\nv 1 2 2\n"
                                           "v -1 0 -1\nv 3 0 -1\nv 0 0 3\n"
                                           "o lamp\nusemtl glow\nf 1 2 5 4\nf 2 3 6 5\nf 4 5 8 7\n"
                                           "o floor\nusemtl dark\nf 9 11 10\n");
    pnb_scene *scene = import(path);
    pnb_light light;
    assert_int_equal(pnb_scene_light_count(scene), 1);
    pnb_scene_light(scene, 0, &light);
    assert_int_equal(light.type, PNB_LIGHT_POLYGON);
    assert_int_equal(light.shape.polygon.vertex_count, 6);
    double area = 0; /* twice, looking down: the faces run clockwise seen from above */
    for (size_t i = 0; i < 6; i++) {
        const double *a = light.shape.polygon.vertices + 3 * i;
        const double *b = light.shape.polygon.vertices + 3 * ((i + 1) % 6);
        area += a[2] * b[0] - a[0] * b[2];
    }
    assert_true(fabs(area + 6) < 1e-6);
    pnb_scene_destroy(scene);

    /* A box: six lights. A cone of 24 sides: none, and a note. */
    path = write_text("box.obj", "mtllib e.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
                                 "v 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nusemtl glow\n"
                                 "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 4 8 7 3\nf 1 5 8 4\n"
                                 "f 2 3 7 6\n");
    scene = import(path);
    assert_int_equal(pnb_scene_light_count(scene), 6);
    pnb_scene_destroy(scene);

    char text[4096] = "mtllib e.mtl\nv 0 1 0\n";
    for (int i = 0; i < 24; i++)
        sprintf(text + strlen(text), "v %.6f 0 %.6f\n", cos(i * M_PI / 12), sin(i * M_PI / 12));
    strcat(text, "usemtl glow\n");
    for (int i = 0; i < 24; i++)
        sprintf(text + strlen(text), "f 1 %d %d\n", 2 + (i + 1) % 24, 2 + i);
    scene = import(write_text("cone.obj", text));
    assert_int_equal(pnb_scene_light_count(scene), 1); /* the supplied one */
    assert_true(has_note(scene, "not flat"));
    pnb_scene_destroy(scene);
}

/* Double-sided emissive panels over a floor shine towards it, whichever way they face; a frame (a
 * square with a square hole) is eight triangles, each a light. */
static void emissive_sides_and_holes(void **state)
{
    static const char json[] =
        "{" BUFFERS "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
        "\"materials\":[{},{\"emissiveFactor\":[1,1,1],\"doubleSided\":%s}],"
        "\"meshes\":[" QUAD(0) "," QUAD(
            1) "],"
               "\"nodes\":[{\"mesh\":0,\"rotation\":[-0.70710678118,0,0,0.70710678118],"
               "\"scale\":[10,10,10]},"
               "{\"mesh\":1,\"translation\":[0,4,0],\"rotation\":[%s,0,0,0.70710678118]}]}";
    static const struct {
        const char *double_sided, *turn;
        double y; /* of the direction of emission */
    } cases[] = {{"true", "0.70710678118", -1},
                 {"true", "-0.70710678118", -1},
                 {"false", "0.70710678118", -1},
                 {"false", "-0.70710678118", 1}};
    for (size_t i = 0; i < 4; i++) {
        char text[4096];
        snprintf(text, sizeof(text), json, cases[i].double_sided, cases[i].turn);
        pnb_scene *scene = import(write_glb("sides.glb", text));
        pnb_light light;
        double normal[3];
        assert_int_equal(pnb_scene_light_count(scene), 1);
        pnb_scene_light(scene, 0, &light);
        assert_int_equal(light.type, PNB_LIGHT_RECTANGLE);
        v3_store(normal, v3_normalize(v3_cross(v3_load(light.shape.rectangle.half_u),
                                               v3_load(light.shape.rectangle.half_v))));
        vectors_near(normal, 0, cases[i].y, 0);
        pnb_scene_destroy(scene);
    }

    write_text("e.mtl", "newmtl glow\nKd 1 1 1\nKe 2 2 2\n");
    pnb_scene *scene =
        import(write_text("frame.obj", "mtllib e.mtl\nv 0 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\n"
                                       "v 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\nusemtl glow\n"
                                       "f 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"));
    assert_int_equal(pnb_scene_light_count(scene), 8);
    pnb_scene_destroy(scene);
}

/* What glTF lacks and this project's writer adds. */
static void extras_are_read(void **state)
{
    static const char json[] =
        "{" BUFFERS "\"scene\":0,\"scenes\":[{\"nodes\":[0,1%s],\"extras\":"
        "{\"ambient\":[0.1,0.2,0.3],\"background\":[0.4,0.5,0.6]}}],\"materials\":[{}],"
        "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"directional\","
        "\"extras\":{\"angular_diameter_degrees\":2}}]}},\"meshes\":[" QUAD(
            0) "],"
               "\"nodes\":[{\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}},"
               "{\"children\":[2,3]},"
               "{\"mesh\":0,\"extras\":{\"plane\":true}},"
               "{\"mesh\":0,\"extras\":{\"casts\":false,\"receives\":false}},"
               "{\"mesh\":0,\"translation\":[0,0,1]}]}";
    for (int i = 0; i < 2; i++) {
        char text[4096];
        double color[3];
        pnb_object object;
        pnb_light light;
        snprintf(text, sizeof(text), json, i ? ",4" : "");
        pnb_scene *scene = import(write_glb("extras.glb", text));
        pnb_scene_ambient(scene, color);
        vectors_near(color, 0.1, 0.2, 0.3);
        pnb_scene_background(scene, color);
        vectors_near(color, 0.4, 0.5, 0.6);
        pnb_scene_light(scene, 0, &light);
        assert_true(light.shape.sun.angular_diameter_degrees == 2);
        pnb_scene_object(scene, 0, &object);
        assert_true(object.plane && object.casts && object.receives);
        pnb_scene_object(scene, 1, &object);
        assert_true(!object.plane && !object.casts && !object.receives);
        pnb_scene_object(scene, 2, &object); /* the supplied ground, or the node 4 */
        assert_true(object.plane == (i == 0) && object.casts && object.receives);
        pnb_scene_destroy(scene);
    }
}

/* The scene's front door, and a scene file that refers to a mesh. */
static void loading_by_path(void **state)
{
    pnb_scene *scene;
    pnb_object object;
    const char *text = "{\"objects\": [{\"name\": \"m\", \"mesh\": \"tri.obj\", \"scale\": 2}],"
                       " \"lights\": [{\"type\": \"point\", \"position\": [0, 4, 0]}]}";
    assert_int_equal(pnb_scene_load(context,
                                    write_text("tri.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
                                    &scene),
                     PNB_OK);
    assert_string_equal(pnb_scene_name(scene), "tri");
    pnb_scene_destroy(scene);
    assert_int_equal(pnb_scene_load(context, write_text("s.json", text), &scene), PNB_OK);
    assert_int_equal(pnb_scene_triangle_count(scene), 1);
    pnb_scene_object(scene, 0, &object);
    assert_true(object.world_from_mesh[0] == 2);
    pnb_scene_destroy(scene);
}

/* --- what else meshes can be --- */

static void normals_materials_lines(void **state)
{
    write_text("m.mtl", "newmtl red\nKd 0.9 0.1 0.2\n");
    pnb_scene *scene = import(write_text(
        "n.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 5\nvn 0 0 1\nvt 0 0\nvt 1 1\n"
                 "usemtl red\nf 1/1/1 2/2/1 3/1/1\nf 1/2/1 3/2/1 2/1/1\nl 1 4\n"));
    pnb_mesh_desc mesh;
    pnb_object object;
    pnb_scene_mesh(scene, 0, &mesh);
    assert_int_equal(mesh.triangle_count, 2);
    assert_int_equal(mesh.vertex_count, 3); /* texture seams do not split */
    assert_non_null(mesh.normals);
    assert_true(mesh.normals[2] == 1);
    pnb_scene_object(scene, 0, &object);
    vectors_near(object.color, (float)0.9, (float)0.1, (float)0.2);
    pnb_scene_destroy(scene);

    scene = import(write_text("p.ply", "ply\nformat ascii 1.0\nelement vertex 4\n"
                                       "property float x\nproperty float y\nproperty float z\n"
                                       "element face 1\nproperty list uchar int vertex_indices\n"
                                       "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"));
    pnb_scene_mesh(scene, 0, &mesh);
    assert_int_equal(mesh.triangle_count, 2);
    pnb_scene_destroy(scene);

    scene = import(write_text("t.stl", "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n"
                                       "vertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
                                       "facet normal 0 0 -1\nouter loop\nvertex 0 0 0\n"
                                       "vertex 0 1 0\nvertex 1 0 0\nendloop\nendfacet\n"
                                       "endsolid t\n"));
    pnb_scene_mesh(scene, 0, &mesh);
    assert_int_equal(mesh.triangle_count, 2);
    assert_int_equal(mesh.vertex_count, 3);
    pnb_scene_destroy(scene);

    scene = import(write_text("o.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    assert_int_equal(pnb_scene_triangle_count(scene), 3);
    pnb_scene_destroy(scene);
}

static void languages_do_not_matter(void **state)
{
    char *old = strdup(getenv("LC_ALL") ? getenv("LC_ALL") : "");
    setenv("LC_ALL", "de_DE.UTF-8", 1);
    pnb_scene *scene = import(write_text("c.obj", "v 0.5 0 0\nv 1.5 0 0\nv 0 1.25 0\nf 1 2 3\n"));
    pnb_mesh_desc mesh;
    pnb_scene_mesh(scene, 0, &mesh);
    assert_true(mesh.positions[0] == 0.5f && mesh.positions[7] == 1.25f);
    pnb_scene_destroy(scene);
    setenv("LC_ALL", old, 1);
    if (!*old)
        unsetenv("LC_ALL");
    free(old);
}

/* --- what goes wrong --- */

static void broken_files_are_named(void **state)
{
    int descriptors = open_descriptors();
    import_fails(place("missing.obj"), "No such file");
    import_fails(write_text("empty.obj", ""), "empty");
    mkdir(place("folder.obj"), 0700);
    import_fails(place("folder.obj"), "folder");
    mkfifo(place("fifo.obj"), 0600);
    import_fails(place("fifo.obj"), "not a regular file");
    import_fails(write_text("what.xyz", "hello"), "unknown kind");
    import_fails(write_text("noending", "hello"), "unknown kind");
    import_fails(write_text("text.glb", "this is no mesh at all, just a line of text\n"), "");
    import_fails(write_text("text.obj", "this is no mesh at all, just a line of text\n"), "");
    import_fails(write_text("text.ply", "this is no mesh at all, just a line of text\n"), "");
    import_fails(write_text("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"), "");
    import_fails(write_text("off.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n"), "");
    import_fails(write_text("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n"), "");
    import_fails(write_text("huge.obj", "v 0 0 0\nv 1e30 0 0\nv 0 1e30 0\nf 1 2 3\n"), "1e18");
    import_fails(write_text("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\np 1 2 3\n"), "");
    import_fails(write_text("counts.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\n"
                                          "property float x\nproperty float y\n"
                                          "property float z\nelement face 4000000000\n"
                                          "property list uchar int vertex_indices\n"
                                          "end_header\n0 0 0\n"),
                 "");
    char *accessor = strdup(full_scene), *count = strstr(accessor, "\"count\":6");
    count[8] = '9';
    import_fails(write_glb("accessor.glb", accessor), "");
    free(accessor);
    assert_int_equal(open_descriptors(), descriptors);
    assert_true(waitpid(-1, NULL, WNOHANG) < 0 && errno == ECHILD);
}

static void flat_triangles_are_kept(void **state)
{
    pnb_scene *scene =
        import(write_text("zero.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n"));
    assert_int_equal(pnb_scene_triangle_count(scene), 4);
    pnb_scene_destroy(scene);
}

static void either_scene_or_error(const char *path)
{
    pnb_scene *scene;
    pnb_status status =
        scene_import_within(context, path, &(struct scene_import_limits){.seconds = 20}, &scene);
    if (status == PNB_OK)
        assert_true(pnb_scene_triangle_count(scene) > 0);
    else
        assert_true(strstr(pnb_context_error(context), path) != NULL);
    pnb_scene_destroy(scene);
}

static void truncated_and_random_files(void **state)
{
    unsigned char whole[8192];
    FILE *file = fopen(write_glb("whole.glb", full_scene), "rb");
    size_t size = fread(whole, 1, sizeof(whole), file);
    fclose(file);
    for (size_t length = 1; length < size; length += 131)
        either_scene_or_error(write_bytes("cut.glb", whole, length));
    static const char ascii[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//1\nf -1 -2 -3";
    for (size_t length = 1; length < sizeof(ascii); length += 3)
        either_scene_or_error(write_bytes("cut.obj", ascii, length));
    static const char *const names[] = {"r.obj", "r.glb", "r.gltf", "r.ply", "r.stl", "r.off",
                                        "r.dae", "r.fbx", "r.3ds",  "r.lwo", "r.ac",  "r.x"};
    uint32_t random = 1;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        for (size_t k = 0; k < 600; k++) {
            random = random * 1664525u + 1013904223u;
            whole[k] = (unsigned char)(random >> 24);
        }
        either_scene_or_error(write_bytes(names[i], whole, 600));
    }
    assert_true(waitpid(-1, NULL, WNOHANG) < 0 && errno == ECHILD);
}

/* --- importers that misbehave --- */

static void with_importer(const char *script, const struct scene_import_limits *limits,
                          const char *words)
{
    char path[256];
    snprintf(path, sizeof(path), "%s", write_text("importer.sh", script));
    chmod(path, 0700);
    setenv("PNB_IMPORTER", path, 1);
    const char *mesh = write_text("fine.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    pnb_scene *scene;
    int descriptors = open_descriptors();
    double begin = clock_ms();
    assert_int_not_equal(scene_import_within(context, mesh, limits, &scene), PNB_OK);
    assert_true(clock_ms() - begin < 10000);
    if (!strstr(pnb_context_error(context), words) || !strstr(pnb_context_error(context), mesh))
        fail_msg("'%s' holds no '%s'", pnb_context_error(context), words);
    assert_int_equal(open_descriptors(), descriptors);
    assert_true(waitpid(-1, NULL, WNOHANG) < 0 && errno == ECHILD);
    unsetenv("PNB_IMPORTER");
}

static void importers_misbehave(void **state)
{
    struct scene_import_limits quick = {.seconds = 0.5}, small = {.answer_bytes = 8 << 20};
    with_importer("#!/bin/sh\nexit 1\n", NULL, "failed (exit status 1)");
    with_importer("#!/bin/sh\necho >&2\necho broken header >&2\nexit 1\n", NULL, "broken header");
    with_importer("#!/bin/sh\nexit 3\n", NULL, "memory");
    with_importer("#!/bin/sh\nkill -SEGV $$\n", NULL, "crashed (signal 11)");
    with_importer("#!/bin/sh\nsleep 100\n", &quick, "took more than 0.5 s");
    with_importer("#!/bin/sh\nexec >&- 2>&-\nsleep 100\n", &quick, "took more than 0.5 s");
    with_importer("#!/bin/sh\ncat /dev/zero\n", &quick, "answer is none");
    with_importer("#!/bin/sh\nprintf 'PNBSTRM\\0'; cat /dev/zero\n", &small, "more than 8 MiB");
    with_importer("#!/bin/sh\ncat /dev/zero >&2\n", &quick, "took more than 0.5 s");
    with_importer("#!/bin/sh\nprintf 'PNBSTRM\\0'\n", NULL, "version");
    with_importer("#!/bin/sh\nprintf 'PNBSTRM\\0\\1\\0\\0\\0\\0\\0\\0\\0'\n", NULL, "broken");
    with_importer("#!/bin/sh\nexit 0\n", NULL, "answer is none");
    with_importer("no program", NULL, "cannot be started");

    setenv("PNB_IMPORTER", "/bin/false", 1);
    import_fails(write_text("fine.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "exit status 1");
    setenv("PNB_IMPORTER", "/does/not/exist", 1);
    import_fails(write_text("fine.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), "No such file");
    unsetenv("PNB_IMPORTER");
}

/* Every cut of a good answer is an error; every changed byte an error or a scene. */
static void answers_are_not_trusted(void **state)
{
    unsigned char *bytes, *copy;
    size_t size;
    struct scene_import_data data;
    assert_int_equal(
        scene_import_run(context, write_glb("full.glb", full_scene), NULL, &bytes, &size), PNB_OK);
    copy = malloc(size);
    for (size_t length = 0; length < size; length++) {
        memcpy(copy, bytes, size);
        assert_int_equal(scene_import_decode(context, "cut", copy, length, &data),
                         PNB_ERROR_FORMAT);
        for (int change = 0; change < 3; change++) {
            static const unsigned char masks[3] = {1, 0x80, 0xff};
            pnb_scene *scene = NULL;
            memcpy(copy, bytes, size);
            copy[length] ^= masks[change];
            if (scene_import_decode(context, "changed", copy, size, &data) == PNB_OK) {
                pnb_status status = scene_import_assemble(context, "changed", &data, &scene);
                assert_true((status == PNB_OK) == (scene != NULL));
                scene_import_data_finish(context, &data);
            }
            pnb_scene_destroy(scene);
        }
    }
    assert_int_equal(scene_import_decode(context, "whole", bytes, size, &data), PNB_OK);
    assert_int_equal(data.object_count, 2);
    scene_import_data_finish(context, &data);
    memory_free(context, bytes);
    free(copy);
}

struct miser {
    size_t left, live;
};

/* Gives so many blocks and no more. */
static void *miserly(void *user, void *old, size_t size)
{
    struct miser *miser = user;
    if (size == 0) {
        free(old);
        miser->live--;
        return NULL;
    }
    if (miser->left == 0)
        return NULL;
    miser->left--;
    miser->live += old == NULL;
    return realloc(old, size);
}

/* Whichever allocation fails, the import fails with it, and everything is given back. */
static void memory_may_run_out(void **state)
{
    unsigned char *bytes;
    size_t size;
    char text[4096] = "mtllib e.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl glow\n"
                      "f 1 2 3 4\n";
    write_text("e.mtl", "newmtl glow\nKd 1 1 1\nKe 2 2 2\n");
    assert_int_equal(scene_import_run(context, write_text("glow.obj", text), NULL, &bytes, &size),
                     PNB_OK);
    bool done = false;
    for (size_t blocks = 1; !done; blocks++) {
        struct miser miser = {blocks, 0};
        pnb_context *poor;
        pnb_scene *scene = NULL;
        struct scene_import_data data;
        assert_int_equal(
            pnb_context_create(
                &(pnb_context_desc){.threads = 1, .reallocate = miserly, .user = &miser}, &poor),
            PNB_OK);
        pnb_status status = scene_import_decode(poor, "poor", bytes, size, &data);
        if (status == PNB_OK) {
            status = scene_import_assemble(poor, "poor", &data, &scene);
            scene_import_data_finish(poor, &data);
        }
        assert_true(status == PNB_OK || status == PNB_ERROR_MEMORY);
        /* Notes may be lost; nothing else is. */
        done = status == PNB_OK && miser.left > 0;
        pnb_scene_destroy(scene);
        pnb_context_destroy(poor);
        assert_int_equal(miser.live, 0);
        assert_true(blocks < 1000);
    }
    memory_free(context, bytes);
}

static bool stop(void *user, const char *stage, double fraction)
{
    return false;
}

static void import_can_be_cancelled(void **state)
{
    char path[256];
    pnb_context *impatient;
    pnb_scene *scene;
    assert_int_equal(pnb_context_create(&(pnb_context_desc){.progress = stop}, &impatient), PNB_OK);
    snprintf(path, sizeof(path), "%s", write_text("importer.sh", "#!/bin/sh\nsleep 100\n"));
    chmod(path, 0700);
    setenv("PNB_IMPORTER", path, 1);
    assert_int_equal(scene_import(impatient, write_text("fine.obj", "v 0 0 0\n"), &scene),
                     PNB_ERROR_CANCELLED);
    unsetenv("PNB_IMPORTER");
    pnb_context_destroy(impatient);
}

static void memory_is_limited(void **state)
{
#if defined(__SANITIZE_ADDRESS__)
    skip();
#endif
    char *text = malloc(8 << 20);
    size_t used = 0;
    while (used < (7 << 20))
        used += (size_t)sprintf(text + used, "v %zu 0 0\n", used);
    used += (size_t)sprintf(text + used, "f 1 2 3\n");
    const char *path = write_bytes("large.obj", text, used);
    free(text);
    pnb_scene *scene;
    struct scene_import_limits limits = {.memory_bytes = 48 << 20};
    assert_int_equal(scene_import_within(context, path, &limits, &scene), PNB_ERROR_MEMORY);
    assert_non_null(strstr(pnb_context_error(context), "48 MiB"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(real_meshes_have_their_counts),
        cmocka_unit_test(gltf_scene_arrives_whole),
        cmocka_unit_test(merged_mesh_has_every_instance),
        cmocka_unit_test(emissive_quad_is_a_light),
        cmocka_unit_test(emissive_shapes),
        cmocka_unit_test(emissive_sides_and_holes),
        cmocka_unit_test(extras_are_read),
        cmocka_unit_test(loading_by_path),
        cmocka_unit_test(normals_materials_lines),
        cmocka_unit_test(languages_do_not_matter),
        cmocka_unit_test(broken_files_are_named),
        cmocka_unit_test(flat_triangles_are_kept),
        cmocka_unit_test(truncated_and_random_files),
        cmocka_unit_test(importers_misbehave),
        cmocka_unit_test(answers_are_not_trusted),
        cmocka_unit_test(memory_may_run_out),
        cmocka_unit_test(import_can_be_cancelled),
        cmocka_unit_test(memory_is_limited),
    };
    return cmocka_run_group_tests(tests, open_context, close_context);
}
