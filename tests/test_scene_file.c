/* The scene file: what it says is what the scene holds; what it must not say is one clear line. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scene/scene_file.h"

static pnb_context *context;
static int imports;

static int setup(void **state)
{
    return pnb_context_create(NULL, &context) != PNB_OK;
}

static int teardown(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

static char imported_path[256];

static pnb_status tetrahedron(pnb_scene *scene, const char *path, size_t *out_mesh)
{
    static const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint32_t indices[] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};
    imports++;
    snprintf(imported_path, sizeof(imported_path), "%s", path);
    if (strstr(path, "missing"))
        return status_fail(scene->context, PNB_ERROR_FILE, path, "No such file or directory");
    return pnb_scene_add_mesh(scene, &(pnb_mesh_desc){"tetra", positions, NULL, 4, indices, 4},
                              out_mesh);
}

static pnb_status parse(const char *text, pnb_scene **out_scene)
{
    struct scene_file_source source = {"s.json", "folder", tetrahedron};
    return scene_file_parse(context, text, strlen(text), &source, out_scene);
}

static void everything_is_read(void **state)
{
    static const char text[] =
        "{\"camera\": {\"eye\": [1, 2, 6], \"target\": [0, 0.5, 0], \"up\": [0, 1, 0.5],"
        "  \"vertical_fov_degrees\": 30},"
        " \"ambient\": [0.1, 0.2, 0.3], \"background\": [0.4, 0.5, 0.6], \"exposure\": 0.25,"
        " \"lights\": ["
        "  {\"type\": \"rectangle\", \"name\": \"lamp\", \"center\": [0, 4, 0],"
        "   \"half_u\": [0.5, 0, 0], \"half_v\": [0, 0, 0.5], \"color\": [1, 2, 3]},"
        "  {\"type\": \"disk\", \"center\": [0, 4, 0], \"normal\": [0, -1, 0], \"radius\": 0.5},"
        "  {\"type\": \"polygon\", \"vertices\": [[0, 4, 0], [1, 4, 0], [0, 4, 1]]},"
        "  {\"type\": \"line\", \"from\": [-1, 4, 0], \"to\": [1, 4, 0]},"
        "  {\"type\": \"point\", \"position\": [0, 4, 7]},"
        "  {\"type\": \"sun\", \"direction\": [0.3, -1, 0.2]}],"
        " \"objects\": ["
        "  {\"name\": \"ground\", \"plane\": {\"point\": [0, -1, 0], \"half_size\": 10}},"
        "  {\"mesh\": \"a.obj\", \"scale\": 2, \"rotate_degrees\": [90, 90, 0],"
        "   \"translate\": [0, 1, 0], \"color\": [0.7, 0.5, 0.4], \"casts\": false},"
        "  {\"mesh\": \"a.obj\", \"scale\": [1, 2, -3], \"receives\": false},"
        "  {\"mesh\": \"/b.obj\"}]}";
    pnb_scene *scene;
    imports = 0;
    assert_int_equal(parse(text, &scene), PNB_OK);
    assert_int_equal(imports, 2);
    assert_string_equal(imported_path, "/b.obj");
    assert_int_equal(pnb_scene_note_count(scene), 0);
    assert_int_equal(pnb_scene_light_count(scene), 6);
    assert_int_equal(pnb_scene_object_count(scene), 4);
    assert_int_equal(pnb_scene_mesh_count(scene), 3);

    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    assert_true(camera.eye[0] == 1 && camera.target[1] == 0.5 && camera.up[2] == 0.5 &&
                camera.vertical_fov_degrees == 30);
    double color[3];
    pnb_scene_ambient(scene, color);
    assert_true(color[0] == 0.1 && color[2] == 0.3);
    pnb_scene_background(scene, color);
    assert_true(color[0] == 0.4 && color[2] == 0.6);
    assert_true(pnb_scene_exposure(scene) == 0.25);

    static const pnb_light_type types[] = {PNB_LIGHT_RECTANGLE, PNB_LIGHT_DISK,  PNB_LIGHT_POLYGON,
                                           PNB_LIGHT_LINE,      PNB_LIGHT_POINT, PNB_LIGHT_SUN};
    pnb_light light;
    for (size_t i = 0; i < 6; i++) {
        pnb_scene_light(scene, i, &light);
        assert_int_equal(light.type, types[i]);
    }
    assert_true(light.shape.sun.angular_diameter_degrees == 0.53 && light.color[0] == 1);
    pnb_scene_light(scene, 0, &light);
    assert_string_equal(light.name, "lamp");
    assert_true(light.color[2] == 3 && light.shape.rectangle.half_v[2] == 0.5);
    pnb_scene_light(scene, 2, &light);
    assert_int_equal(light.shape.polygon.vertex_count, 3);
    assert_true(light.shape.polygon.vertices[8] == 1);

    pnb_object object;
    pnb_scene_object(scene, 0, &object);
    assert_string_equal(object.name, "ground");
    assert_true(object.plane && object.color[0] == 0.8);
    /* About x first: y goes to z, then about y: z goes to x. Then the scale of 2 and the shift. */
    pnb_scene_object(scene, 1, &object);
    assert_string_equal(object.name, "tetra");
    assert_true(!object.casts && object.receives && !object.plane);
    vec3 p = m34_point(object.world_from_mesh, v3(0, 1, 0));
    assert_true(p.x == 2 && p.y == 1 && p.z == 0);
    pnb_scene_object(scene, 2, &object);
    assert_true(object.casts && !object.receives);
    p = m34_point(object.world_from_mesh, v3(1, 1, 1));
    assert_true(p.x == 1 && p.y == 2 && p.z == -3);
    pnb_scene_destroy(scene);
}

static void turns_compose_in_order(void **state)
{
    pnb_scene *scene;
    assert_int_equal(
        parse("{\"objects\":[{\"mesh\":\"a\",\"rotate_degrees\":[30,40,-50]}]}", &scene), PNB_OK);
    pnb_object object;
    pnb_scene_object(scene, 0, &object);
    /* One turn after another, by hand. */
    vec3 p = v3(0.3, -0.7, 1.1), q = m34_point(object.world_from_mesh, p);
    double a = 30 * M_PI / 180, b = 40 * M_PI / 180, c = -50 * M_PI / 180;
    p = v3(p.x, cos(a) * p.y - sin(a) * p.z, sin(a) * p.y + cos(a) * p.z);
    p = v3(cos(b) * p.x + sin(b) * p.z, p.y, -sin(b) * p.x + cos(b) * p.z);
    p = v3(cos(c) * p.x - sin(c) * p.y, sin(c) * p.x + cos(c) * p.y, p.z);
    assert_true(v3_length(v3_sub(p, q)) < 1e-14);
    pnb_scene_destroy(scene);
}

static void what_is_missing_is_supplied(void **state)
{
    pnb_scene *scene;
    assert_int_equal(parse("\xef\xbb\xbf{\"objects\":[{\"plane\":{\"half_size\":50}},"
                           "{\"mesh\":\"a\",\"translate\":[10,0,0]}]}",
                           &scene),
                     PNB_OK);
    assert_int_equal(pnb_scene_light_count(scene), 1);
    assert_int_equal(pnb_scene_note_count(scene), 2);
    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    assert_true(fabs(camera.target[0] - 10.5) < 1e-6);
    assert_true(fabs(camera.eye[0] - 10.5) < 5);
    pnb_scene_destroy(scene);
    /* An empty list of lights is meant. */
    assert_int_equal(parse("{\"objects\":[{\"plane\":{\"half_size\":5}}],\"lights\":[]}", &scene),
                     PNB_OK);
    assert_int_equal(pnb_scene_light_count(scene), 0);
    assert_true(pnb_scene_exposure(scene) == 1);
    pnb_scene_destroy(scene);
}

#define PLANE       "{\"objects\":[{\"plane\":{\"half_size\":1}}],"
#define LIGHT(text) PLANE "\"lights\":[{\"type\":\"point\",\"position\":[0,1,0]}," text "]}"

static void errors_name_the_place(void **state)
{
    static const struct {
        const char *text, *error;
    } cases[] = {
        {"", "s.json: is empty"},
        {" \n\t", "s.json: is empty"},
        {"[1]", "s.json: must be an object, is an array"},
        {"{}", "s.json: \"objects\" is missing"},
        {"{\"objects\":[]}", "s.json: objects: is empty"},
        {"{\"objects\":[\n{\"plane\":\n}]}", "s.json: line 3, column 1: unexpected token near '}'"},
        {"{\"objects\":[{\"mesh\":\"k\xfchl\"}]}", "s.json: line 1, column 22: unable to decode"},
        {"{\"objects\":[],\"objects\":[]}", "s.json: line 1, column 23: duplicate object key"},
        {PLANE "\"exposure\":NaN}", "s.json: line 1, column 53: invalid token near 'NaN'"},
        {PLANE "\"exposure\":1e999}", "s.json: line 1, column 55: real number overflow"},
        {PLANE "\"exposure\":1e19}", "s.json: exposure: beyond 1e18"},
        {PLANE "\"exposure\":-1}", "s.json: exposure: below zero"},
        {PLANE "\"exposure\":\"1\"}", "s.json: exposure: must be a number, is a text"},
        {PLANE "\"ambient\":[1,1]}", "s.json: ambient: must be three numbers, has 2"},
        {PLANE "\"ambient\":[1,null,1]}", "s.json: ambient[1]: must be a number, is null"},
        {PLANE "\"ambient\":[1,-1,1]}", "s.json: ambient: a colour below zero"},
        {PLANE "\"light\":[]}", "s.json: light: unknown key (known here: camera "},
        {PLANE "\"lights\":{}}", "s.json: lights: must be an array, is an object"},
        {LIGHT("{\"type\":\"disk\",\"center\":[0,4,0],\"normal\":[0,1,0],\"radiuss\":1}"),
         "s.json: lights[1].radiuss: unknown key"},
        {LIGHT("{\"type\":\"disk\",\"center\":[0,4,0],\"normal\":[0,1,0]}"),
         "s.json: lights[1]: \"radius\" is missing"},
        {LIGHT("{\"type\":\"dis\"}"), "s.json: lights[1].type: unknown light \"dis\" (known: "},
        {LIGHT("7"), "s.json: lights[1]: must be an object, is a number"},
        {LIGHT("{\"type\":\"polygon\",\"vertices\":[[0,1,2],[1,2,\"3\"],[0,0,0]]}"),
         "s.json: lights[1].vertices[1][2]: must be a number, is a text"},
        {LIGHT("{\"type\":\"polygon\",\"vertices\":[[0,1,2]]}"),
         "s.json: lights[1].vertices: a polygon needs three vertices, has 1"},
        {PLANE "\"camera\":{\"eye\":[1,1,1],\"target\":[1,1,1]}}",
         "s.json: camera: eye and target are the same point"},
        {PLANE "\"camera\":{\"eye\":[1,3,1],\"target\":[1,1,1]}}",
         "s.json: camera: up is zero or along the view"},
        {PLANE "\"camera\":{\"eye\":[1,3,1],\"target\":[1,1,2],\"vertical_fov_degrees\":180}}",
         "s.json: camera: vertical_fov_degrees must lie between 0 and 180"},
        {PLANE "\"camera\":{\"target\":[1,1,1]}}", "s.json: camera: \"eye\" is missing"},
        {"{\"objects\":[{\"name\":\"x\"}]}", "s.json: objects[0]: \"mesh\" is missing"},
        {"{\"objects\":[{\"mesh\":\"\"}]}", "s.json: objects[0].mesh: is empty"},
        {"{\"objects\":[{\"mesh\":\"missing.obj\"}]}",
         "s.json: objects[0].mesh: folder/missing.obj: No such file"},
        {"{\"objects\":[{\"mesh\":\"a\",\"plane\":{\"half_size\":1}}]}",
         "s.json: objects[0]: has a mesh and a plane"},
        {"{\"objects\":[{\"mesh\":\"a\",\"scale\":0}]}",
         "s.json: objects[0].scale: must not be zero"},
        {"{\"objects\":[{\"mesh\":\"a\",\"scale\":true}]}",
         "s.json: objects[0].scale: must be a number or three, is true or false"},
        {"{\"objects\":[{\"mesh\":\"a\",\"scale\":1e18,\"translate\":[1e18,0,0]}]}",
         "s.json: objects[0]: tetra: coordinates beyond 1e18"},
        {"{\"objects\":[{\"mesh\":\"a\",\"casts\":1}]}",
         "s.json: objects[0].casts: must be true or false, is a number"},
        {"{\"objects\":[{\"plane\":{\"half_size\":0}}]}",
         "s.json: objects[0].plane.half_size: must be above zero"},
        {"{\"objects\":[{\"plane\":{\"half_size\":1,\"normal\":[0,0,0]}}]}",
         "s.json: objects[0].plane.normal: must not be zero"},
        {"{\"objects\":[{\"plane\":{\"half_size\":1},\"scale\":2}]}",
         "s.json: objects[0].scale: unknown key"},
        {"{\"objects\":[{\"plane\":[]}]}", "s.json: objects[0].plane: must be an object"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        pnb_scene *scene;
        assert_int_not_equal(parse(cases[i].text, &scene), PNB_OK);
        assert_null(scene);
        if (strncmp(pnb_context_error(context), cases[i].error, strlen(cases[i].error)) != 0)
            fail_msg("%s\n  gave   %s\n  wanted %s", cases[i].text, pnb_context_error(context),
                     cases[i].error);
    }
}

static void deep_nesting_is_refused(void **state)
{
    enum { DEPTH = 100000 };
    char *text = malloc(DEPTH + 1);
    memset(text, '[', DEPTH);
    text[DEPTH] = 0;
    pnb_scene *scene;
    assert_int_equal(parse(text, &scene), PNB_ERROR_FORMAT);
    assert_non_null(strstr(pnb_context_error(context), "maximum parsing depth"));
    free(text);
}

static void lights_from_the_command_line(void **state)
{
    pnb_scene *scene;
    size_t index = 99;
    assert_int_equal(pnb_scene_create(context, &scene), PNB_OK);
    assert_int_equal(
        pnb_scene_add_light_json(
            scene, "{\"type\":\"point\",\"position\":[1,2,3],\"color\":[2,2,2]}", &index),
        PNB_OK);
    assert_int_equal(index, 0);
    assert_int_not_equal(pnb_scene_add_light_json(scene, "{\"type\":\"point\",\"pos\":1}", NULL),
                         PNB_OK);
    assert_string_equal(pnb_context_error(context),
                        "light: pos: unknown key (known here: type name color position)");
    assert_int_not_equal(pnb_scene_add_light_json(scene, "{", NULL), PNB_OK);
    assert_non_null(strstr(pnb_context_error(context), "light: line 1"));
    assert_int_equal(pnb_scene_light_count(scene), 1);
    pnb_scene_destroy(scene);
}

static void files_that_are_none(void **state)
{
    char folder[] = "/tmp/penumbra-test-XXXXXX", path[128], text[300];
    pnb_scene *scene;
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/x.json", folder);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FILE);
    snprintf(text, sizeof(text), "%s: No such file or directory", path);
    assert_string_equal(pnb_context_error(context), text);
    assert_int_equal(mkdir(path, 0700), 0);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FILE);
    assert_non_null(strstr(pnb_context_error(context), "x.json: is a folder"));
    rmdir(path);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FILE);
    assert_non_null(strstr(pnb_context_error(context), "not a regular file"));
    unlink(path);

    FILE *file = fopen(path, "w");
    fclose(file);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FORMAT);
    assert_non_null(strstr(pnb_context_error(context), "x.json: is empty"));
    file = fopen(path, "w");
    fwrite("\x89PNG\0\0\0", 1, 7, file);
    fclose(file);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FORMAT);
    assert_non_null(strstr(pnb_context_error(context), "x.json: is binary"));
    assert_int_equal(truncate(path, (off_t)SCENE_FILE_LIMIT + 1), 0);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_ERROR_FORMAT);
    assert_non_null(strstr(pnb_context_error(context), "larger than 64 MB"));
    file = fopen(path, "w");
    fputs("{\"objects\":[{\"plane\":{\"half_size\":1}}]}", file);
    fclose(file);
    assert_int_equal(pnb_scene_load(context, path, &scene), PNB_OK);
    assert_string_equal(pnb_scene_name(scene), "x");
    pnb_scene_destroy(scene);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(everything_is_read),
        cmocka_unit_test(turns_compose_in_order),
        cmocka_unit_test(what_is_missing_is_supplied),
        cmocka_unit_test(errors_name_the_place),
        cmocka_unit_test(deep_nesting_is_refused),
        cmocka_unit_test(lights_from_the_command_line),
        cmocka_unit_test(files_that_are_none),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
