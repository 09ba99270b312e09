/* Faults of a device, put where OpenGL answers (gl/inside.h): a context that is lost, headless and
 * the caller's, and no memory at any point of a frame. A clear error each time, no picture, and
 * everything after it defined. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include <penumbra/opengl.h>
#include <penumbra/penumbra.h>

#include "gl/device.h"
#include "gl/inside.h"
#include "method/opengl.h"

enum { W = 64, H = 48, N = W * H };

static pnb_context *context;
static pnb_scene *scene;
static pnb_surface *surface;
static pnb_receivers receivers;
static pnb_light light;
static bool device; /* OpenGL can be had */

static int setup(void **state)
{
    struct gl_device *probe;
    if (pnb_context_create(&(pnb_context_desc){.threads = 2}, &context) != PNB_OK ||
        pnb_scene_load(context, "builtin:disk", &scene) != PNB_OK ||
        pnb_surface_create(context, scene, NULL, W, H, &surface) != PNB_OK)
        return 1;
    pnb_surface_receivers(surface, &receivers);
    pnb_scene_light(scene, 0, &light);
    device = gl_device_create(context, &probe) == PNB_OK;
    if (device)
        gl_device_destroy(probe);
    return 0;
}

static int teardown(void **state)
{
    pnb_surface_destroy(surface);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return 0;
}

static void must(pnb_status status)
{
    if (status != PNB_OK)
        fail_msg("%s", pnb_context_error(context));
}

static void must_fail(pnb_status status, const char *text)
{
    assert_int_equal(status, PNB_ERROR_DEVICE);
    if (!strstr(pnb_context_error(context), text))
        fail_msg("'%s' says nothing of '%s'", pnb_context_error(context), text);
}

/* A solver on OpenGL of the m-th method; false: it cannot do the light, or OpenGL. */
static bool make(size_t m, bool adopts, pnb_solver **out_solver)
{
    const pnb_method_info *info = pnb_method(m);
    pnb_solver_param path = {"path", "opengl"};
    pnb_solver_desc desc = {info->name, strcmp(info->name, "sampled-maps") == 0 ? 2 : 0, &path,
                            info->opengl_path ? 1 : 0};
    if (!(info->processor == PNB_PROCESSOR_OPENGL || info->opengl_path) ||
        !(info->lights & PNB_LIGHT_BIT(light.type)))
        return false;
    must(adopts ? pnb_gl_solver_create(context, scene, &desc, out_solver)
                : pnb_solver_create(context, scene, &desc, out_solver));
    return true;
}

/* solver->opengl begins with what all methods share. */
static struct gl_device *device_of(pnb_solver *solver)
{
    return ((struct opengl_state *)solver->opengl)->device;
}

/* ---- The faults ---- */

static GLenum reset_by_us(void)
{
    return GL_GUILTY_CONTEXT_RESET;
}

static GLenum always_lost(void)
{
    return GL_CONTEXT_LOST;
}

static int calls, fails_at;

static GLenum no_memory_once(void)
{
    return calls++ == fails_at ? GL_OUT_OF_MEMORY : GL_NO_ERROR;
}

/* ---- Tests ---- */

static void robust_where_offered(void **state)
{
    if (!device)
        skip();
    for (int api = GL_DEVICE_API_BEST; api <= GL_DEVICE_API_ES; api++) {
        struct gl_device *made;
        if (gl_device_create_as(context, (enum gl_device_api)api, &made) != PNB_OK)
            continue;
        must(gl_device_begin(made));
        GLint strategy = 0;
        bool offered = epoxy_egl_version(made->display) >= 15 ||
                       epoxy_has_egl_extension(made->display, "EGL_EXT_create_context_robustness");
        if (made->ask_reset)
            glGetIntegerv(GL_RESET_NOTIFICATION_STRATEGY, &strategy);
        if (made->info.software && offered) {
            assert_non_null(made->ask_reset);
            assert_int_equal(strategy, GL_LOSE_CONTEXT_ON_RESET);
        }
        must(gl_device_end(made));
        gl_device_destroy(made);
    }
}

static void lost_context(void **state)
{
    static float before[N], after[N];
    if (!device)
        skip();
    for (size_t m = 0; m < pnb_method_count(); m++)
        for (int fault = 0; fault < 2; fault++) {
            pnb_solver *solver;
            if (!make(m, false, &solver))
                continue;
            must(pnb_solver_visibility(solver, &light, &receivers, before));
            memcpy(after, before, sizeof(after));
            if (fault == 0)
                device_of(solver)->ask_reset = reset_by_us;
            else
                device_of(solver)->ask_error = always_lost;
            must_fail(pnb_solver_visibility(solver, &light, &receivers, after),
                      fault == 0 ? "context is lost (the device was reset, for what was drawn"
                                 : "context is lost: nothing more can be drawn");
            /* For good, whatever OpenGL says later. */
            device_of(solver)->ask_reset = NULL;
            must_fail(pnb_solver_visibility(solver, &light, &receivers, after), "context is lost");
            must_fail(pnb_solver_update(solver, PNB_UPDATE_PLACEMENTS), "context is lost");
            pnb_solver_destroy(solver);
            /* A new one has a context of its own. */
            assert_true(make(m, false, &solver));
            must(pnb_solver_visibility(solver, &light, &receivers, after));
            assert_memory_equal(after, before, sizeof(after));
            pnb_solver_destroy(solver);
        }
}

/* The caller's context: told in the frame in which it was lost, and from then on. */
static void lost_context_of_the_caller(void **state)
{
    struct gl_device *owner;
    pnb_solver *solver;
    if (!device)
        skip();
    must(gl_device_create(context, &owner));
    must(gl_device_begin(owner));
    struct gl_texture *depth, *visibility;
    static float depths[N];
    for (size_t i = 0; i < N; i++)
        depths[i] = 0.93f;
    must(gl_texture_create(
        owner,
        &(struct gl_texture_desc){
            .format = GL_FORMAT_DEPTH32F, .width = W, .height = H, .texels = depths},
        &depth));
    must(gl_texture_create(
        owner, &(struct gl_texture_desc){.format = GL_FORMAT_R32F, .width = W, .height = H},
        &visibility));
    pnb_gl_view view = {.depth_texture = depth->name};
    /* From the origin along -z. */
    view.clip_from_world[0] = view.clip_from_world[5] = 1;
    view.clip_from_world[10] = view.clip_from_world[14] = -1.1f;
    view.clip_from_world[11] = -1;
    for (size_t m = 0; m < pnb_method_count(); m++) {
        if (!make(m, true, &solver))
            continue;
        must(pnb_gl_solver_visibility(solver, &light, &view, visibility->name));
        device_of(solver)->ask_reset = reset_by_us;
        must_fail(pnb_gl_solver_visibility(solver, &light, &view, visibility->name),
                  "context is lost (the device was reset");
        must_fail(pnb_gl_solver_visibility(solver, &light, &view, visibility->name),
                  "context is lost");
        pnb_solver_destroy(solver);
        assert_int_equal(glGetError(), GL_NO_ERROR);
    }
    gl_texture_destroy(depth);
    gl_texture_destroy(visibility);
    must(gl_device_end(owner));
    gl_device_destroy(owner);
}

/* Each time that OpenGL is asked, in turn, it has no memory; the frame after that is as ever. Of
 * another size, so that textures are made. */
static void no_memory_at_any_point(void **state)
{
    static float before[N], large[N], after[N], small[N / 4];
    pnb_surface *half;
    pnb_receivers half_receivers;
    if (!device)
        skip();
    must(pnb_surface_create(context, scene, NULL, W / 2, H / 2, &half));
    pnb_surface_receivers(half, &half_receivers);
    for (size_t m = 0; m < pnb_method_count(); m++) {
        pnb_solver *solver;
        if (!make(m, false, &solver))
            continue;
        must(pnb_solver_visibility(solver, &light, &receivers, before));
        bool reached = true;
        int failed = 0;
        for (fails_at = 1; reached && fails_at < 400; fails_at++) {
            must(pnb_solver_visibility(solver, &light, &half_receivers, small));
            calls = 0;
            device_of(solver)->ask_error = no_memory_once;
            pnb_status status = pnb_solver_visibility(solver, &light, &receivers, large);
            reached = calls > fails_at;
            if (reached && status == PNB_OK)
                fail_msg("%s: no word of the fault at %d", pnb_method(m)->name, fails_at);
            if (reached) {
                bool told = strstr(pnb_context_error(context), "out of device memory") ||
                            strstr(pnb_context_error(context), "the device has no room for it");
                if (status != PNB_ERROR_DEVICE || !told)
                    fail_msg("%s: %s", pnb_method(m)->name, pnb_context_error(context));
                failed++;
            }
            calls = fails_at + 1;
            must(pnb_solver_visibility(solver, &light, &receivers, after));
            assert_memory_equal(after, before, sizeof(after));
        }
        print_message("%s: %d places\n", pnb_method(m)->name, failed);
        assert_true(failed > 3 && !reached);
        pnb_solver_destroy(solver);
    }
    pnb_surface_destroy(half);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(robust_where_offered),
        cmocka_unit_test(lost_context),
        cmocka_unit_test(lost_context_of_the_caller),
        cmocka_unit_test(no_memory_at_any_point),
    };
    return cmocka_run_group_tests_name("faults", tests, setup, teardown);
}
