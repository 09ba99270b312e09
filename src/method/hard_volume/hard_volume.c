/* method/hard_volume/hard_volume.c: shadow volumes from the light's middle (Crow 1977), counted
 * behind the receivers (z-fail: Bilodeau and Songy 1999, Carmack 2000), exact at infinity (Everitt
 * and Kilgard 2002: far plane at infinity, clamped depth).
 *
 * The volume of a set of triangles is closed: near caps, sides extruded to infinity, far caps at
 * infinity. A receiver counts what it is in front of: + where a ray from the eye would leave a
 * volume behind it, - where it would enter one. Above zero it lies in shadow.
 *
 *   closed objects   caps are the faces turned away from the light, so that lit surfaces never meet
 *                    a cap and need no bias; sides where such a face meets one towards the light
 *   other objects    every triangle, turned towards the light, has a volume of its own; where two
 *                    of them share an edge their sides cancel, or count double at a fold. Caps
 *                    coincide with lit surfaces: pushed back by the polygon offset.
 *
 * So meshes may be open, non-manifold or inconsistently oriented, and the light may stand inside
 * them. Floors (gl/frame.h) with the light on the scene's side shadow nothing and are left out.
 * Counts are floats blended by addition: a stencil would wrap beyond 255 layers and cannot count
 * double sides in one draw.
 *
 * Cost: facing of each triangle and edge on the CPU, O(triangles + edges), all cores for the faces;
 * volumes drawn once: fill rate. Memory: 12 bytes a cap's triangle, 96 a side, 4 a pixel.
 */
#include <stddef.h>
#include <string.h>

#include "method/opengl.h"

struct corner {
    float position[3];
    float code; /* weight 1 or 2; + 8 at infinity */
};

struct volumes {
    struct gl_program *program, *decide;
    struct gl_texture *count;
    struct gl_target *target;
    unsigned generation; /* of the frame whose depth target was made for */
    struct gl_buffer *closed_caps, *open_caps, *sides;
    signed char *facing; /* per triangle: 1 towards the light, -1 away, 0 degenerate or edge-on */
    uint32_t *caps[2];   /* closed, open: corners */
    size_t cap_counts[2];
    size_t triangle_capacity;
    struct corner *corners;
    size_t corner_count, corner_capacity;
};

struct facing_job {
    const struct gl_occluders *occluders;
    signed char *facing;
    vec3 light;
    double w;
};

static void facing_body(void *user, size_t begin, size_t end, int worker)
{
    const struct facing_job *job = user;
    for (size_t t = begin; t < end; t++) {
        const float *p = job->occluders->planes + 4 * t;
        double side = v3_dot(v3_loadf(p), job->light) + p[3] * job->w;
        bool none = p[0] == 0 && p[1] == 0 && p[2] == 0;
        job->facing[t] = none || side == 0 ? 0 : side > 0 ? 1 : -1;
    }
}

static pnb_status reserve(pnb_solver *solver, struct volumes *v, size_t triangles)
{
    if (triangles <= v->triangle_capacity)
        return PNB_OK;
    pnb_context *context = solver->context;
    memory_free(context, v->facing);
    memory_free(context, v->caps[0]);
    memory_free(context, v->caps[1]);
    v->facing = memory_alloc(context, triangles, sizeof(*v->facing));
    v->caps[0] = memory_alloc(context, triangles, 3 * sizeof(uint32_t));
    v->caps[1] = memory_alloc(context, triangles, 3 * sizeof(uint32_t));
    v->triangle_capacity = v->facing && v->caps[0] && v->caps[1] ? triangles : 0;
    return v->triangle_capacity ? PNB_OK : status_no_memory(context, triangles * 25);
}

/* Corners in order (forward) or turned around. */
static void add_cap(struct volumes *v, int kind, const uint32_t *triangle, bool forward)
{
    uint32_t *to = v->caps[kind] + 3 * v->cap_counts[kind]++;
    to[0] = triangle[0];
    to[1] = triangle[forward ? 1 : 2];
    to[2] = triangle[forward ? 2 : 1];
}

/* The side of a volume whose near cap runs from b to a: counter-clockwise a, b, b far, a far. */
static bool add_side(pnb_solver *solver, struct volumes *v, const struct gl_occluders *o,
                     uint32_t a, uint32_t b, float weight)
{
    if (!memory_reserve(solver->context, (void **)&v->corners, &v->corner_capacity, v->corner_count,
                        6, sizeof(*v->corners)))
        return false;
    static const struct {
        bool second, far;
    } order[6] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    for (int i = 0; i < 6; i++) {
        struct corner *corner = &v->corners[v->corner_count++];
        memcpy(corner->position, o->positions + 3 * (size_t)(order[i].second ? b : a),
               sizeof(corner->position));
        corner->code = weight + (order[i].far ? 8 : 0);
    }
    return true;
}

/* Caps are the faces turned away, reversed: they point at the light, out of the volume. */
static bool add_closed(pnb_solver *solver, struct volumes *v, const struct gl_occluders *o,
                       const struct gl_occluder *object)
{
    size_t first = object->first_index / 3, count = object->index_count / 3;
    for (size_t t = first; t < first + count; t++)
        if (v->facing[t] < 0)
            add_cap(v, 0, o->indices + 3 * t, false);
    for (size_t i = object->first_edge; i < object->first_edge + object->edge_count; i++) {
        const struct gl_edge *edge = &o->edges[i];
        bool first_away = v->facing[edge->first] < 0, second_away = v->facing[edge->second] < 0;
        if (first_away == second_away)
            continue;
        /* The face turned away runs a to b if it is the first; its cap runs back. */
        uint32_t a = first_away ? edge->a : edge->b, b = first_away ? edge->b : edge->a;
        if (!add_side(solver, v, o, a, b, 1))
            return false;
    }
    return true;
}

static bool add_open(pnb_solver *solver, struct volumes *v, const struct gl_occluders *o,
                     const struct gl_occluder *object)
{
    size_t first = object->first_index / 3, count = object->index_count / 3;
    for (size_t t = first; t < first + count; t++)
        if (v->facing[t] != 0)
            add_cap(v, 1, o->indices + 3 * t, v->facing[t] > 0);
    for (size_t i = object->first_edge; i < object->first_edge + object->edge_count; i++) {
        const struct gl_edge *edge = &o->edges[i];
        /* Caps that run a to b less those that run b to a. */
        int runs = v->facing[edge->first];
        if (edge->second != MESH_NONE)
            runs += edge->same_way ? v->facing[edge->second] : -v->facing[edge->second];
        if (runs == 0)
            continue;
        uint32_t a = runs > 0 ? edge->b : edge->a, b = runs > 0 ? edge->a : edge->b;
        if (!add_side(solver, v, o, a, b, (float)(runs > 0 ? runs : -runs)))
            return false;
    }
    return true;
}

static pnb_status build(pnb_solver *solver, struct volumes *v, const struct gl_occluders *o,
                        vec3 light, double w)
{
    pnb_status status = reserve(solver, v, o->triangle_count);
    if (status != PNB_OK)
        return status;
    struct facing_job job = {o, v->facing, light, w};
    parallel_for(solver->context, o->triangle_count, 16384, facing_body, &job);
    v->cap_counts[0] = v->cap_counts[1] = v->corner_count = 0;
    for (size_t i = 0; i < o->object_count; i++) {
        const struct gl_occluder *object = &o->objects[i];
        if (object->floor && v3_dot(object->floor_normal, light) - object->floor_offset * w > 0)
            continue;
        if (!(object->closed ? add_closed(solver, v, o, object) : add_open(solver, v, o, object)))
            return status_no_memory(solver->context, v->corner_count * sizeof(*v->corners));
    }
    return PNB_OK;
}

static pnb_status volume_create(pnb_solver *solver, struct opengl_state *state)
{
    struct volumes *v = state->room = memory_calloc(solver->context, 1, sizeof(*v));
    if (!v)
        return status_no_memory(solver->context, sizeof(*v));
    static const char *const attributes[] = {"position", "code"};
    struct gl_program_desc desc = {.vertex = "method/hard_volume/volume.vert",
                                   .fragment = "method/hard_volume/volume.frag",
                                   .attributes = attributes,
                                   .attribute_count = 2};
    pnb_status status = gl_program_create(state->device, &desc, &v->program);
    struct gl_program_desc decide = {.vertex = "gl/cover.vert",
                                     .fragment = "method/hard_volume/decide.frag"};
    if (status == PNB_OK)
        status = gl_program_create(state->device, &decide, &v->decide);
    struct gl_buffer **const buffers[] = {&v->closed_caps, &v->open_caps, &v->sides};
    for (int i = 0; i < 3 && status == PNB_OK; i++)
        status = gl_buffer_create(state->device, NULL, 0, true, buffers[i]);
    return status;
}

static void volume_destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct volumes *v = state->room;
    if (!v)
        return;
    gl_program_destroy(v->program);
    gl_program_destroy(v->decide);
    gl_target_destroy(v->target);
    gl_texture_destroy(v->count);
    gl_buffer_destroy(v->closed_caps);
    gl_buffer_destroy(v->open_caps);
    gl_buffer_destroy(v->sides);
    memory_free(solver->context, v->facing);
    memory_free(solver->context, v->caps[0]);
    memory_free(solver->context, v->caps[1]);
    memory_free(solver->context, v->corners);
    memory_free(solver->context, v);
}

static pnb_status resize(struct volumes *v, struct gl_device *device, const struct gl_frame *frame)
{
    if (v->target && v->generation == frame->generation)
        return PNB_OK;
    gl_target_destroy(v->target);
    gl_texture_destroy(v->count);
    v->target = NULL;
    v->count = NULL;
    v->generation = frame->generation;
    struct gl_texture_desc desc = {
        .format = GL_FORMAT_R32F, .width = frame->width, .height = frame->height};
    pnb_status status = gl_texture_create(device, &desc, &v->count);
    struct gl_target_desc target = {.colors = {{v->count, 0}}, .depth = {frame->depth, 0}};
    return status == PNB_OK ? gl_target_create(device, &target, &v->target) : status;
}

static void draw_volumes(const pnb_solver *solver, struct volumes *v, struct gl_device *device,
                         const struct gl_occluders *o, const struct gl_frame *frame, vec3 light,
                         double w)
{
    struct gl_draw draw = {.program = v->program,
                           .target = v->target,
                           .uniforms = {gl_mat4("clip_from_world", frame->clip_from_world),
                                        gl_vec4("light", light.x, light.y, light.z, w)},
                           .depth_test = true,
                           .depth_compare = GL_COMPARE_GREATER,
                           .depth_clamp = true,
                           .blend = GL_BLEND_ADD};
    struct gl_uniform *cap = &draw.uniforms[2];
    *cap = gl_float("cap", 0);
    draw.attributes[0] = (struct gl_attribute){v->sides, 3, .stride = sizeof(struct corner)};
    draw.attributes[1] = (struct gl_attribute){v->sides, 1, .stride = sizeof(struct corner),
                                               .offset = offsetof(struct corner, code)};
    draw.count = v->corner_count;
    gl_draw(device, &draw);

    draw.attributes[0] = (struct gl_attribute){o->position_buffer, 3};
    draw.attributes[1] = (struct gl_attribute){0};
    for (int kind = 0; kind < 2; kind++) {
        draw.indices = kind == 0 ? v->closed_caps : v->open_caps;
        draw.count = 3 * v->cap_counts[kind];
        *cap = gl_float("cap", 1);
        draw.offset_factor = kind == 1 ? (float)solver_param_number(solver, "bias") : 0;
        draw.offset_units = 2 * draw.offset_factor;
        gl_draw(device, &draw);
        /* The far caps are the near ones at infinity, turned around. A sun's meet in a point. */
        *cap = gl_float("cap", -1);
        draw.offset_factor = draw.offset_units = 0;
        if (w != 0)
            gl_draw(device, &draw);
    }
}

static pnb_status volume_draw(pnb_solver *solver, struct opengl_state *state,
                              const struct light_shape *shape, const pnb_light *light,
                              const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct volumes *v = state->room;
    struct gl_device *device = state->device;
    struct light_point middle = light_shape_sample(shape, 0.5, 0.5);
    if (light->type == PNB_LIGHT_SUN)
        middle = (struct light_point){shape->normal, 0};
    double started = clock_ms();
    pnb_status status = build(solver, v, state->occluders, middle.p, middle.w);
    solver_count(solver, "cpu_ms", clock_ms() - started);
    if (status == PNB_OK)
        status = resize(v, device, frame);
    if (status == PNB_OK)
        status =
            gl_buffer_write(v->closed_caps, v->caps[0], v->cap_counts[0] * 3 * sizeof(uint32_t));
    if (status == PNB_OK)
        status = gl_buffer_write(v->open_caps, v->caps[1], v->cap_counts[1] * 3 * sizeof(uint32_t));
    if (status == PNB_OK)
        status = gl_buffer_write(v->sides, v->corners, v->corner_count * sizeof(*v->corners));
    struct gl_target *target = NULL;
    struct gl_target_desc desc = {.colors = {{visibility, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(device, &desc, &target);
    if (status != PNB_OK)
        return status;
    struct gl_clear clear = {.color = {true}};
    gl_target_clear(v->target, &clear);
    draw_volumes(solver, v, device, state->occluders, frame, middle.p, middle.w);
    struct gl_draw decide = {
        .program = v->decide,
        .target = target,
        .uniforms = {gl_sampler("count", v->count),
                     gl_vec4("light", middle.p.x, middle.p.y, middle.p.z, middle.w),
                     gl_sampler("frame_position", frame->position),
                     gl_sampler("frame_normal", frame->normal)}};
    gl_draw_cover(device, &decide);
    gl_target_destroy(target);
    solver_count(solver, "sides", (double)(v->corner_count / 6));
    solver_count(solver, "caps", (double)(v->cap_counts[0] + v->cap_counts[1]));
    return PNB_OK;
}

static const struct opengl_method volume_opengl = {
    .create = volume_create, .destroy = volume_destroy, .draw = volume_draw, .edges = true};

static const pnb_param_info params[] = {
    {"bias", PNB_PARAM_NUMBER, "1", 0, 100, NULL,
     "of open objects' caps: polygon offset, factor and half the units"},
};

const struct method method_hard_volume = {
    .info =
        {
            .name = "hard-volume",
            .title = "shadow volumes",
            .paper = "Crow: Shadow Algorithms for Computer Graphics (1977); Everitt and Kilgard: "
                     "Practical and Robust Stenciled Shadow Volumes (2002)",
            .summary = "Volumes from the middle of the light, counted behind the receivers: hard "
                       "shadows, exact to the pixel.",
            .lights = (1u << PNB_LIGHT_TYPE_COUNT) - 1,
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_OPENGL,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = opengl_create,
    .destroy = opengl_destroy,
    .update = opengl_update,
    .visibility = opengl_visibility,
    .opengl = &volume_opengl,
};
