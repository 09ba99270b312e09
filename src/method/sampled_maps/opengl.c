/* method/sampled_maps/opengl.c: sampled-maps and hard-map on OpenGL.
 *
 * One depth map after another, each from one sample of the light (the samples of the CPU path), and
 * after each a pass that adds its share to the visibility. Maps, depth test and bias are those of
 * gl/depth_map.h: one fitted picture, or the faces of a cube where the light stands amid casters.
 *
 * Cost: O(N (casters x faces + size^2 + pixels)). Memory: 8 size^2 bytes, 28 size^2 with a cube.
 */
#include "method/sampled_maps/opengl.h"

#include <string.h>

#include "gl/depth_map.h"

struct maps {
    struct gl_depth_map *map;
    struct gl_program *add[2]; /* for a map of one face, of several */
};

static pnb_status maps_create(pnb_solver *solver, struct opengl_state *state)
{
    struct maps *maps = state->room = memory_calloc(solver->context, 1, sizeof(*maps));
    if (!maps)
        return status_no_memory(solver->context, sizeof(*maps));
    struct gl_program_desc desc = {.vertex = "gl/cover.vert",
                                   .fragment = "method/sampled_maps/seen.frag"};
    pnb_status status = PNB_OK;
    for (int i = 0; i < 2 && status == PNB_OK; i++) {
        desc.defines = i == 0 ? "#define MAP_ONE_FACE 1\n" : NULL;
        status = gl_program_create(state->device, &desc, &maps->add[i]);
    }
    if (status == PNB_OK)
        status =
            gl_depth_map_create(state->device, solver_param_integer(solver, "size"), &maps->map);
    return status;
}

static void maps_destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct maps *maps = state->room;
    if (!maps)
        return;
    gl_depth_map_destroy(maps->map);
    gl_program_destroy(maps->add[0]);
    gl_program_destroy(maps->add[1]);
    memory_free(solver->context, maps);
}

/* The places of the CPU path's samples. */
static vec3 sample_at(const pnb_solver *solver, const struct light_shape *shape, int i, int count)
{
    float u = 0.5f, v = 0.5f;
    if (count > 1 && shape->light.type == PNB_LIGHT_LINE) {
        bool ends = strcmp(solver_param(solver, "placement"), "ends") == 0;
        double at = ends ? (double)i / (count - 1) : (i + 0.5) / count;
        return v3_mad(shape->origin, shape->axis_u, at);
    }
    if (count > 1)
        light_sobol_owen((uint32_t)i, 1, &u, &v);
    return light_shape_sample(shape, u, v).p;
}

static pnb_status maps_draw(pnb_solver *solver, struct opengl_state *state,
                            const struct light_shape *shape, const pnb_light *light,
                            const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct maps *maps = state->room;
    int count = solver->samples > 0 && light->type != PNB_LIGHT_POINT ? solver->samples : 1;
    bool area = light->type != PNB_LIGHT_LINE && light->type != PNB_LIGHT_POINT;
    struct gl_target *target;
    struct gl_target_desc desc = {.colors = {{visibility, 0}}};
    pnb_status status = gl_target_create(state->device, &desc, &target);
    if (status != PNB_OK)
        return status;
    struct gl_clear clear = {.color = {true}};
    gl_target_clear(target, &clear);
    double last_ms = 0;
    for (int i = 0; i < count && status == PNB_OK; i++) {
        vec3 at = sample_at(solver, shape, i, count);
        status =
            gl_depth_map_draw(maps->map, state->occluders, at, area ? shape->normal : v3(0, 0, 0));
        struct gl_draw draw = {.program = maps->add[maps->map->face_count > 1],
                               .target = target,
                               .blend = GL_BLEND_ADD};
        gl_depth_map_uniforms(maps->map, draw.uniforms);
        struct gl_uniform *rest = draw.uniforms + GL_DEPTH_MAP_UNIFORMS;
        *rest++ = gl_sampler("frame_position", frame->position);
        *rest++ = gl_sampler("frame_normal", frame->normal);
        *rest++ = gl_float("bias", solver_param_number(solver, "bias"));
        *rest++ = gl_float("share", 1.0 / count);
        if (status == PNB_OK)
            gl_draw_cover(state->device, &draw);
        if (status == PNB_OK)
            status = opengl_progress(solver, state, (i + 1.0) / count, &last_ms);
    }
    gl_target_destroy(target);
    solver->report.samples = count;
    solver_count(solver, "maps", count);
    solver_count(solver, "faces", maps->map->face_count);
    return status;
}

const struct opengl_method sampled_maps_opengl = {
    .create = maps_create, .destroy = maps_destroy, .draw = maps_draw};
