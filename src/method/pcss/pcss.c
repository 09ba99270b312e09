/* method/pcss/pcss.c: percentage-closer soft shadows (Fernando 2005) on OpenGL.
 *
 * One depth map from the light's middle c. For a receiver at d = p - c:
 *
 *   blocker search   taps towards points l of the light, where they cross the depth of the nearest
 *                    caster; those whose texel is nearer than the receiver are blockers
 *   penumbra         their mean depth z_b
 *   filter           taps towards points l of the light, where they cross z_b; V = share that
 * passes
 *
 * A tap towards l at depth z crosses p + s (l - d), s = (d.z - z) / (d.z - l.z): in the paper's
 * parallel case that is the light's outline scaled by (z_receiver - z) / z, its w_penumbra and its
 * search region in one. The search is done `rounds` times, from the second on with z the mean depth
 * that the one before it found (the paper: once). Differs from the paper where that is to its
 * advantage: taps lie on the light's own shape (the paper: a square), low-discrepancy, in
 * `patterns` sets that change from pixel to pixel (1: one for all), and the depth test uses the
 * receiver's own plane, so that the wide filter needs no large bias.
 *
 * The defaults are the best of some thirty settings over the built-in scenes with an area light
 * (160x120, against exact; mean RMSE 0.057; one round 0.075, bias 1 texel 0.058, search x 0.7 0.061
 * with two rounds): more taps or texels change it by 0.001 to 0.004.
 *
 * Known failures, which are the method's: one depth per direction from one point of the light, so
 * what hides behind the nearest layer does not count, and the umbra of overlapping casters leaks;
 * blockers that no tap meets are missed. Cost: casters once per face of the map, and for each pixel
 * (rounds x blocker_taps + taps) fetches. Memory: 8 size^2 bytes, 28 with a cube (gl/depth_map.h).
 */
#include "gl/depth_map.h"
#include "method/opengl.h"

struct pcss {
    struct gl_depth_map *map;
    struct gl_program *programs[2]; /* for a map of one face, of several */
    struct gl_texture *taps; /* RGBA32F: taps wide, patterns high: points of the light minus c */
    float *points;           /* the same in memory */
    int tap_count, pattern_count;
};

static pnb_status pcss_create(pnb_solver *solver, struct opengl_state *state)
{
    struct pcss *pcss = state->room = memory_calloc(solver->context, 1, sizeof(*pcss));
    if (!pcss)
        return status_no_memory(solver->context, sizeof(*pcss));
    int filter = solver_param_integer(solver, "taps");
    int blocker = solver_param_integer(solver, "blocker_taps");
    pcss->tap_count = filter > blocker ? filter : blocker;
    pcss->pattern_count = solver_param_integer(solver, "patterns");
    size_t count = (size_t)pcss->tap_count * (size_t)pcss->pattern_count;
    pcss->points = memory_alloc(solver->context, count, 4 * sizeof(float));
    if (!pcss->points)
        return status_no_memory(solver->context, count * 4 * sizeof(float));
    struct gl_texture_desc taps = {
        .format = GL_FORMAT_RGBA32F, .width = pcss->tap_count, .height = pcss->pattern_count};
    pnb_status status = gl_texture_create(state->device, &taps, &pcss->taps);
    struct gl_program_desc desc = {.vertex = "gl/cover.vert", .fragment = "method/pcss/pcss.frag"};
    for (int i = 0; i < 2 && status == PNB_OK; i++) {
        desc.defines = i == 0 ? "#define MAP_ONE_FACE 1\n" : NULL;
        status = gl_program_create(state->device, &desc, &pcss->programs[i]);
    }
    if (status == PNB_OK)
        status =
            gl_depth_map_create(state->device, solver_param_integer(solver, "size"), &pcss->map);
    return status;
}

static void pcss_destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct pcss *pcss = state->room;
    if (!pcss)
        return;
    gl_depth_map_destroy(pcss->map);
    gl_program_destroy(pcss->programs[0]);
    gl_program_destroy(pcss->programs[1]);
    gl_texture_destroy(pcss->taps);
    memory_free(solver->context, pcss->points);
    memory_free(solver->context, pcss);
}

/* The taps: points of the light relative to its middle. */
static void place_taps(struct pcss *pcss, const struct light_shape *shape, vec3 center)
{
    for (int row = 0; row < pcss->pattern_count; row++)
        for (int i = 0; i < pcss->tap_count; i++) {
            float u, v;
            light_sobol_owen((uint32_t)i, (uint32_t)row + 1, &u, &v);
            vec3 l = v3_sub(light_shape_sample(shape, u, v).p, center);
            float *to = pcss->points + 4 * ((size_t)row * (size_t)pcss->tap_count + (size_t)i);
            v3_storef(to, l);
            to[3] = 0;
        }
    gl_texture_upload(pcss->taps, 0, pcss->points);
}

static pnb_status pcss_draw(pnb_solver *solver, struct opengl_state *state,
                            const struct light_shape *shape, const pnb_light *light,
                            const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct pcss *pcss = state->room;
    bool area = light->type != PNB_LIGHT_LINE && light->type != PNB_LIGHT_POINT;
    vec3 center = light_shape_sample(shape, 0.5, 0.5).p;
    pnb_status status =
        gl_depth_map_draw(pcss->map, state->occluders, center, area ? shape->normal : v3(0, 0, 0));
    struct gl_target *target = NULL;
    struct gl_target_desc desc = {.colors = {{visibility, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(state->device, &desc, &target);
    if (status != PNB_OK)
        return status;
    place_taps(pcss, shape, center);
    struct gl_draw draw = {.program = pcss->programs[pcss->map->face_count > 1], .target = target};
    gl_depth_map_uniforms(pcss->map, draw.uniforms);
    struct gl_uniform *rest = draw.uniforms + GL_DEPTH_MAP_UNIFORMS;
    *rest++ = gl_sampler("frame_position", frame->position);
    *rest++ = gl_sampler("frame_normal", frame->normal);
    *rest++ = gl_sampler("taps", pcss->taps);
    *rest++ = gl_int("filter_count", solver_param_integer(solver, "taps"));
    *rest++ = gl_int("blocker_count", solver_param_integer(solver, "blocker_taps"));
    *rest++ = gl_int("rounds", solver_param_integer(solver, "rounds"));
    *rest++ = gl_float("bias", solver_param_number(solver, "bias"));
    *rest++ = gl_float("search", solver_param_number(solver, "search"));
    *rest++ = gl_float("nearest", pcss->map->nearest);
    *rest++ = gl_float("near_share", solver_param_number(solver, "near"));
    gl_draw_cover(state->device, &draw);
    gl_target_destroy(target);
    solver_count(solver, "faces", pcss->map->face_count);
    return PNB_OK;
}

static const struct opengl_method pcss_opengl = {
    .create = pcss_create, .destroy = pcss_destroy, .draw = pcss_draw};

static const pnb_param_info params[] = {
    {"size", PNB_PARAM_INTEGER, "1024", 2, 16384, NULL, "the map has size x size texels"},
    {"taps", PNB_PARAM_INTEGER, "64", 1, 1024, NULL, "of the filter"},
    {"blocker_taps", PNB_PARAM_INTEGER, "32", 1, 1024, NULL, "of the search for blockers"},
    {"patterns", PNB_PARAM_INTEGER, "16", 1, 256, NULL,
     "sets of taps, changing from pixel to pixel (1: bands instead of noise)"},
    {"bias", PNB_PARAM_NUMBER, "2", 0, 1000, NULL, "of the depth test, in texels"},
    {"search", PNB_PARAM_NUMBER, "1", 0.01, 100, NULL,
     "radius of the search, in that of the light seen past the nearest caster"},
    {"rounds", PNB_PARAM_INTEGER, "3", 1, 8, NULL,
     "of the search; from the second on at the depth of the blockers found (1: the paper)"},
    {"near", PNB_PARAM_NUMBER, "0.1", 0, 1, NULL,
     "the nearest caster that the search allows for, share of the receiver's distance"},
};

const struct method method_pcss = {
    .info =
        {
            .name = "pcss",
            .title = "percentage-closer soft shadows",
            .paper = "Fernando: Percentage-Closer Soft Shadows (2005)",
            .summary = "One depth map from the middle of the light; a filter as wide as the mean "
                       "depth of the blockers says.",
            .lights = PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) | PNB_LIGHT_BIT(PNB_LIGHT_LINE) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POINT),
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_OPENGL,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = opengl_create,
    .destroy = opengl_destroy,
    .update = opengl_update,
    .visibility = opengl_visibility,
    .opengl = &pcss_opengl,
};
