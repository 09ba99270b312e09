/* What holds for every method: parameters are checked, missing data is an error, memory that runs
 * out is an error and leaks nothing, nothing to do is done, threads change no byte. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

enum { WIDTH = 48, HEIGHT = 36 };

static const char scene_text[] =
    "{\"camera\": {\"eye\": [0.5, 3, 6], \"target\": [0, 0.5, 0]}, \"lights\": ["
    "{\"type\": \"rectangle\", \"center\": [0, 4, 0], \"half_u\": [0.5, 0, 0], \"half_v\": [0, 0, "
    "0.5]},"
    "{\"type\": \"disk\", \"center\": [1, 4, 0], \"normal\": [0, -1, 0], \"radius\": 0.5},"
    "{\"type\": \"polygon\", \"vertices\": [[0, 4, 0], [1, 4, 0], [1, 4, 0.3], [0.3, 4, 0.3], "
    "[0.3, 4, 1], [0, 4, 1]]},"
    "{\"type\": \"line\", \"from\": [-1, 4, 0], \"to\": [1, 4, 0]},"
    "{\"type\": \"point\", \"position\": [0, 4, 0]},"
    "{\"type\": \"sun\", \"direction\": [0.3, -1, 0.2], \"angular_diameter_degrees\": 2}],"
    "\"objects\": [{\"name\": \"ground\", \"plane\": {\"half_size\": 10}},"
    "{\"name\": \"board\", \"plane\": {\"point\": [0, 1.5, 0], \"half_size\": 0.5}},"
    "{\"name\": \"tilted\", \"plane\": {\"point\": [1, 1, 0], \"normal\": [1, 1, 0.2], "
    "\"half_size\": 0.6}}]}";

static void fill_scene(pnb_context *context, pnb_scene **scene, pnb_surface **surface)
{
    if (pnb_scene_parse(context, scene_text, strlen(scene_text), NULL, scene) != PNB_OK ||
        pnb_surface_create(context, *scene, NULL, WIDTH, HEIGHT, surface) != PNB_OK)
        fail_msg("%s", pnb_context_error(context));
}

/* ---- memory ---- */

struct purse {
    atomic_long left, live;
};

static void *spend(void *user, void *old, size_t size)
{
    struct purse *purse = user;
    if (size == 0) {
        purse->live -= old != NULL;
        free(old);
        return NULL;
    }
    if (purse->left-- <= 0)
        return NULL;
    void *grown = realloc(old, size);
    purse->live += grown && !old;
    return grown;
}

static bool has_param(const pnb_method_info *method, const char *key)
{
    for (size_t i = 0; i < method->param_count; i++)
        if (strcmp(method->params[i].key, key) == 0)
            return true;
    return false;
}

/* One pass of everything that a solver does, with so many allocations. */
static pnb_status run_poor(struct purse *purse, const char *method, pnb_light_type type, long limit,
                           char *said, size_t size)
{
    pnb_context *context;
    pnb_scene *scene;
    pnb_surface *whole, *surface = NULL;
    pnb_solver *solver = NULL;
    purse->left = 1L << 40;
    pnb_context_desc context_desc = {.threads = 2, .reallocate = spend, .user = purse};
    assert_int_equal(pnb_context_create(&context_desc, &context), PNB_OK);
    fill_scene(context, &scene, &whole);
    pnb_surface_destroy(whole);

    static float visibility[WIDTH * HEIGHT], rgb[3 * WIDTH * HEIGHT];
    const pnb_method_info *info = pnb_method_find(method);
    /* Small maps: as many allocations, less work. */
    const pnb_solver_param small = {"size", "64"};
    pnb_solver_desc desc = {.method = method, .samples = info->samples ? 5 : 0};
    if (has_param(info, small.key))
        desc.params = &small, desc.param_count = 1;
    purse->left = limit;
    pnb_status status = pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface);
    assert_true((status == PNB_OK) == (surface != NULL));
    if (status == PNB_OK) {
        status = pnb_solver_create(context, scene, &desc, &solver);
        assert_true((status == PNB_OK) == (solver != NULL));
    }
    pnb_light light;
    pnb_scene_light(scene, type, &light);
    if (status == PNB_OK) {
        pnb_receivers receivers;
        pnb_surface_receivers(surface, &receivers);
        status = pnb_solver_visibility(solver, &light, &receivers, visibility);
        if (status == PNB_OK) { /* as points, too */
            receivers.width = receivers.height = 0;
            status = pnb_solver_visibility(solver, &light, &receivers, visibility);
        }
    }
    if (status == PNB_OK)
        status = pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS);
    if (status == PNB_OK)
        status = pnb_solver_update(solver, PNB_UPDATE_VERTICES);
    if (status == PNB_OK)
        status = pnb_surface_shade(surface, NULL, rgb);
    strncpy(said, pnb_context_error(context), size - 1);
    pnb_solver_destroy(solver);
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return status;
}

static void memory_runs_out(void **state)
{
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *method = pnb_method(m);
        for (int type = 0; type < PNB_LIGHT_TYPE_COUNT; type++) {
            if (method->processor != PNB_PROCESSOR_CPU || !(method->lights & PNB_LIGHT_BIT(type)))
                continue;
            long limit = 0;
            for (pnb_status status = PNB_ERROR_MEMORY; status != PNB_OK; limit += 1 + limit / 32) {
                struct purse purse = {0};
                char said[1024] = "";
                assert_true(limit < 1000000);
                status =
                    run_poor(&purse, method->name, (pnb_light_type)type, limit, said, sizeof(said));
                if (status != PNB_OK && (status != PNB_ERROR_MEMORY || !*said))
                    fail_msg("%s, %s, %ld allocations: %s: %s", method->name,
                             pnb_light_type_name((pnb_light_type)type), limit,
                             pnb_status_name(status), said);
                if (purse.live != 0)
                    fail_msg("%s, %s, %ld allocations: %ld blocks leaked", method->name,
                             pnb_light_type_name((pnb_light_type)type), limit, (long)purse.live);
            }
            assert_true(limit > 10); /* it does take its memory from the context */
        }
    }
}

/* ---- threads ---- */

static void threads_change_nothing(void **state)
{
    static float visibility[2][WIDTH * HEIGHT], rgb[2][3 * WIDTH * HEIGHT];
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *method = pnb_method(m);
        for (int type = 0; type < PNB_LIGHT_TYPE_COUNT; type++) {
            if (method->processor != PNB_PROCESSOR_CPU || !(method->lights & PNB_LIGHT_BIT(type)))
                continue;
            for (int run = 0; run < 2; run++) {
                pnb_context *context;
                pnb_scene *scene;
                pnb_surface *surface;
                pnb_solver *solver;
                pnb_receivers receivers;
                pnb_light light;
                pnb_context_create(&(pnb_context_desc){.threads = run ? 7 : 1}, &context);
                fill_scene(context, &scene, &surface);
                pnb_scene_light(scene, (size_t)type, &light);
                pnb_surface_receivers(surface, &receivers);
                pnb_solver_desc desc = {.method = method->name};
                assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
                assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, visibility[run]),
                                 PNB_OK);
                const float *lights[PNB_LIGHT_TYPE_COUNT] = {0};
                lights[type] = visibility[run];
                assert_int_equal(pnb_surface_shade(surface, lights, rgb[run]), PNB_OK);
                pnb_solver_destroy(solver);
                pnb_surface_destroy(surface);
                pnb_scene_destroy(scene);
                pnb_context_destroy(context);
            }
            assert_memory_equal(visibility[0], visibility[1], sizeof(visibility[0]));
            assert_memory_equal(rgb[0], rgb[1], sizeof(rgb[0]));
        }
    }
}

/* ---- the calls themselves ---- */

static pnb_context *context;
static pnb_scene *scene;
static pnb_surface *surface;

static int set_up(void **state)
{
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    fill_scene(context, &scene, &surface);
    return 0;
}

static int tear_down(void **state)
{
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return 0;
}

static void records_are_whole(void **state)
{
    assert_non_null(pnb_method_find(pnb_default_method()));
    assert_null(pnb_method(pnb_method_count()));
    assert_null(pnb_method_find(NULL));
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *info = pnb_method(m);
        assert_ptr_equal(pnb_method_find(info->name), info);
        assert_true(*info->name && *info->title && info->paper && *info->summary && info->lights);
        assert_true(info->samples == (info->default_samples > 0));
        for (size_t i = 0; i < info->param_count; i++) {
            const pnb_param_info *p = &info->params[i];
            assert_true(*p->key && p->default_value && *p->summary);
            /* The default is a legal value. */
            pnb_solver_param param = {p->key, p->default_value};
            pnb_solver_desc desc = {.method = info->name, .params = &param, .param_count = 1};
            pnb_solver *solver;
            pnb_status status = pnb_solver_create(context, scene, &desc, &solver);
            if (status != PNB_OK && status != PNB_ERROR_DEVICE)
                fail_msg("%s", pnb_context_error(context));
            pnb_solver_destroy(solver);
        }
    }
}

/* The first of the scene's lights that the method can do; they are in the order of the types. */
static void light_for(const pnb_method_info *method, pnb_light *light)
{
    size_t type = 0;
    while (!(method->lights & PNB_LIGHT_BIT(type)))
        type++;
    pnb_scene_light(scene, type, light);
}

static void samples_in_use_are_reported(void **state)
{
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *info = pnb_method(m);
        if (info->processor != PNB_PROCESSOR_CPU || !info->samples)
            continue;
        for (int wanted = 2; wanted <= 20; wanted += 18) {
            pnb_solver *solver;
            pnb_solver_report report;
            pnb_light light;
            pnb_solver_desc desc = {.method = info->name, .samples = wanted};
            assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
            light_for(info, &light);
            assert_int_equal(pnb_solver_visibility(solver, &light, &(pnb_receivers){0}, NULL),
                             PNB_OK);
            pnb_solver_get_report(solver, &report);
            assert_true(report.samples >= wanted);
            assert_true(report.visibility_ms >= 0 && report.prepare_ms >= 0);
            pnb_solver_destroy(solver);
        }
    }
}

#define REFUSED(call)                                                                              \
    do {                                                                                           \
        assert_int_equal((call), PNB_ERROR_ARGUMENT);                                              \
        assert_true(*pnb_context_error(context) != 0);                                             \
        assert_null(strchr(pnb_context_error(context), '\n'));                                     \
    } while (0)

static void numbers_may_be_fractions(void **state)
{
    double number;
    assert_true(pnb_param_number("0.25", &number) && number == 0.25);
    assert_true(pnb_param_number("1/4", &number) && number == 0.25);
    assert_true(pnb_param_number("-3/-2", &number) && number == 1.5);
    static const char *const none[] = {"", "/", "1/", "/2", "1/0", "1/2/3", "1/2x", "x", "inf"};
    for (size_t i = 0; i < sizeof(none) / sizeof(none[0]); i++)
        assert_false(pnb_param_number(none[i], &number));
}

static void bad_descriptors_are_refused(void **state)
{
    static const pnb_solver_param unknown = {"such", "1"}, keyless = {NULL, "1"},
                                  word = {"seed", "x"}, fraction = {"seed", "1.5"},
                                  low = {"seed", "-1"}, infinite = {"seed", "inf"},
                                  empty = {"seed", ""}, none = {"seed", NULL};
    const pnb_solver_desc bad[] = {
        {.method = ""},
        {.method = "no such method"},
        {.method = "reference", .samples = -1},
        {.method = "reference", .samples = 1 << 30},
        {.method = "reference", .param_count = 1},
        {.method = "reference", .params = &unknown, .param_count = 1},
        {.method = "reference", .params = &keyless, .param_count = 1},
        {.method = "reference", .params = &word, .param_count = 1},
        {.method = "reference", .params = &fraction, .param_count = 1},
        {.method = "reference", .params = &low, .param_count = 1},
        {.method = "reference", .params = &infinite, .param_count = 1},
        {.method = "reference", .params = &empty, .param_count = 1},
        {.method = "reference", .params = &none, .param_count = 1},
    };
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++) {
        pnb_solver *solver = (pnb_solver *)&bad;
        REFUSED(pnb_solver_create(context, scene, &bad[i], &solver));
        assert_null(solver);
    }
    pnb_solver *solver;
    REFUSED(pnb_solver_create(context, NULL, NULL, &solver));
}

static void bad_frames_are_refused(void **state)
{
    float three[15] = {0}, visibility[5];
    pnb_light light, strange = {.type = (pnb_light_type)99};
    for (size_t m = 0; m < pnb_method_count(); m++) {
        if (pnb_method(m)->processor != PNB_PROCESSOR_CPU)
            continue;
        pnb_solver *solver;
        pnb_solver_desc desc = {.method = pnb_method(m)->name};
        light_for(pnb_method(m), &light);
        pnb_receivers some = {.count = 5, .positions = three, .normals = three}, bad;
        assert_int_equal(pnb_solver_create(context, scene, &desc, &solver), PNB_OK);
        REFUSED(pnb_solver_visibility(solver, NULL, &some, visibility));
        REFUSED(pnb_solver_visibility(solver, &strange, &some, visibility));
        REFUSED(pnb_solver_visibility(solver, &light, NULL, visibility));
        REFUSED(pnb_solver_visibility(solver, &light, &some, NULL));
        bad = some, bad.positions = NULL;
        REFUSED(pnb_solver_visibility(solver, &light, &bad, visibility));
        bad = some, bad.normals = NULL;
        REFUSED(pnb_solver_visibility(solver, &light, &bad, visibility));
        bad = some, bad.width = 2, bad.height = 2;
        REFUSED(pnb_solver_visibility(solver, &light, &bad, visibility));
        bad = some, bad.width = -1;
        REFUSED(pnb_solver_visibility(solver, &light, &bad, visibility));
        /* Normals of no length are no receivers' either, but no crash. */
        assert_int_equal(pnb_solver_visibility(solver, &light, &some, visibility), PNB_OK);
        /* Nothing to do. */
        assert_int_equal(pnb_solver_visibility(solver, &light, &(pnb_receivers){0}, NULL), PNB_OK);
        pnb_solver_destroy(solver);
    }
}

static void bad_surfaces_are_refused(void **state)
{
    static const int sizes[][2] = {{0, 0}, {0, 5}, {5, 0}, {-1, 5}, {100000, 100000}};
    pnb_surface *none;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        REFUSED(pnb_surface_create(context, scene, NULL, sizes[i][0], sizes[i][1], &none));
        assert_null(none);
    }
    REFUSED(pnb_surface_create(context, NULL, NULL, 5, 5, &none));
    REFUSED(pnb_surface_shade(surface, NULL, NULL));
    const pnb_camera blind = {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}, 45},
                     along = {{0, 0, 0}, {0, 2, 0}, {0, 1, 0}, 45},
                     wide = {{0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 180},
                     lost = {{NAN, 0, 0}, {0, 0, 1}, {0, 1, 0}, 45};
    const pnb_camera *cameras[] = {&blind, &along, &wide, &lost};
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(pnb_surface_create(context, scene, cameras[i], 5, 5, &none),
                         PNB_ERROR_SCENE);
}

static void missing_data_is_refused(void **state)
{
    pnb_scene *loaded;
    pnb_shadow *shadow;
    pnb_errors errors;
    pnb_image image;
    pnb_light light;
    float one[3] = {0};
    const pnb_channel nameless = {NULL, one, 1}, empty = {"R", NULL, 1};
    pnb_scene_light(scene, 0, &light);
    REFUSED(pnb_scene_load(context, NULL, &loaded));
    REFUSED(pnb_scene_add_mesh(scene, NULL, NULL));
    REFUSED(pnb_scene_add_object(scene, NULL, NULL));
    REFUSED(pnb_scene_add_light(scene, NULL, NULL));
    REFUSED(pnb_scene_add_light_json(scene, NULL, NULL));
    REFUSED(pnb_scene_set_camera(scene, NULL));
    REFUSED(pnb_scene_set_light(scene, 0, NULL));
    REFUSED(pnb_scene_set_placement(scene, 0, NULL));
    REFUSED(pnb_scene_set_vertices(scene, 0, NULL, NULL));
    REFUSED(pnb_scene_write_json(scene, NULL));
    REFUSED(pnb_scene_write_glb(scene, NULL));
    REFUSED(pnb_shadow_create(context, scene, NULL, NULL, &shadow));
    REFUSED(pnb_light_check(context, NULL));
    REFUSED(pnb_light_irradiance(context, NULL, one, one, 1, one));
    REFUSED(pnb_light_irradiance(context, &light, NULL, one, 1, one));
    REFUSED(pnb_measure(context, NULL, one, NULL, 1, &errors));
    REFUSED(pnb_image_write(context, NULL, &(pnb_image){1, 1, 1, one}));
    REFUSED(pnb_image_write(context, "/tmp/none.png", &(pnb_image){1, 1, 2, one}));
    REFUSED(pnb_image_write(context, "/tmp/none.png", &(pnb_image){1, 1, 3, NULL}));
    REFUSED(pnb_image_write_exr(context, "/tmp/none.exr", 1, 1, NULL, 1));
    REFUSED(pnb_image_write_exr(context, "/tmp/none.exr", 1, 1, &nameless, 1));
    REFUSED(pnb_image_write_exr(context, "/tmp/none.exr", 1, 1, &empty, 1));
    REFUSED(pnb_image_error_map(context, NULL, 1, 1, 1, false, &image));
    REFUSED(pnb_image_read(context, NULL, &image));
    REFUSED(pnb_file_write(context, NULL, "", 0));
    assert_int_equal(pnb_shadow_create(context, scene, &light, NULL, &shadow), PNB_OK);
    REFUSED(pnb_shadow_write(shadow, NULL, 0));
    REFUSED(pnb_shadow_write(shadow, "/tmp/none.doc", 0));
    pnb_shadow_destroy(shadow);

    /* Beyond the last one: nothing. */
    pnb_object object;
    pnb_mesh_desc mesh;
    pnb_scene_light(scene, 99, &light);
    pnb_scene_object(scene, 99, &object);
    pnb_scene_mesh(scene, 99, &mesh);
    assert_true(!light.name && !object.name && !mesh.name && mesh.vertex_count == 0);
    assert_string_equal(pnb_scene_note(scene, 99), "");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(memory_runs_out),          cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(records_are_whole),        cmocka_unit_test(samples_in_use_are_reported),
        cmocka_unit_test(numbers_may_be_fractions), cmocka_unit_test(bad_descriptors_are_refused),
        cmocka_unit_test(bad_frames_are_refused),   cmocka_unit_test(bad_surfaces_are_refused),
        cmocka_unit_test(missing_data_is_refused),
    };
    return cmocka_run_group_tests_name("solver", tests, set_up, tear_down);
}
