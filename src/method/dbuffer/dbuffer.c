/* method/dbuffer/dbuffer.c: soft shadows with correct boundaries: umbra and penumbra volumes in a
 * buffer of distances from the light's centre (Jakobsen, Christensen, Larsen, Petersen 2004), on
 * OpenGL.
 *
 *   faces, edges -> silhouettes from the disk -> volumes (volumes.c)
 *   D-buffer, a face at a time, seen from the light's centre c (map.c):
 *     occluder   |c x_o|                       occluder.frag
 *     umbra      |c x_uv|, |c x_s|, angle      volume.frag: volumes, then silhouette faces
 *     penumbra   |c x_pv|, |c x_s|, angle      volume.frag
 *     with layers=2: the next occluder, and the next umbra and penumbra volume behind the first
 *   pixels -> t, V(t) or V(t1, t2, alpha)      evaluate.frag
 *
 * Light: a disk; rectangles and polygons become a disk of the same area about their middle; a point
 * (or a disk without extent) is the plain depth map that hard-map is.
 *
 * Differences from the paper, each explained where it is done: the signs and factors of its
 * equations 1 to 3; umbra and penumbra have a distance to the silhouette each, so that no stencil
 * is needed to keep one from overwriting the other; the nearest volume wins, not the farthest
 * (volume.frag); distances are found per fragment; fans close both volumes; look-ups are blended
 * between texels (evaluate.frag).
 *
 * Cost: CPU O(triangles + edges); for each face of the D-buffer the casters once (twice), the
 * volumes once (twice); 3 (6) look-ups a pixel, four times that with filter=linear. Memory: per
 * face and texel 4 + 16 + 16 bytes (twice that with layers=2), and 4 for depth.
 */
#include <string.h>

#include "geom/tolerance.h"
#include "gl/depth_map.h"
#include "method/dbuffer/room.h"

#define SIZE_MIN   16
#define POINT_SIZE 1024 /* of a point light's map: what hard-map takes by itself */

/* Of the objects that shadow something. */
static void warn_of_open_meshes(pnb_solver *solver, const struct gl_occluders *o,
                                const struct silhouette_disk *disk)
{
    size_t open = 0, non_manifold = 0;
    bool any = false;
    for (size_t i = 0; i < o->object_count; i++)
        if (!o->objects[i].closed && dbuffer_casts(&o->objects[i], disk)) {
            any = true;
            open += o->objects[i].open_count;
            non_manifold += o->objects[i].non_manifold_count;
        }
    if (any && open + non_manifold > 0)
        solver_warn(solver,
                    "occluders are not closed (%zu open, %zu non-manifold edges): their borders "
                    "are taken for outlines",
                    open, non_manifold);
}

static pnb_status dbuffer_create(pnb_solver *solver, struct opengl_state *state)
{
    struct dbuffer *b = state->room = memory_calloc(solver->context, 1, sizeof(*b));
    if (!b)
        return status_no_memory(solver->context, sizeof(*b));
    b->device = state->device;
    b->size = solver_param_integer(solver, "size");
    if (b->size > 0 && b->size < SIZE_MIN)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "size", "%d is not 0 and below %d",
                           b->size, SIZE_MIN);
    b->layers = solver_param_integer(solver, "layers");
    b->bias = solver_param_number(solver, "bias");
    dbuffer_volumes_init(solver->context, &b->volumes);
    pnb_status status = dbuffer_programs_create(solver, b);
    for (int i = 0; i < 4 && status == PNB_OK; i++)
        status =
            gl_buffer_create(b->device, NULL, 4096, true, i < 2 ? &b->quads[i] : &b->fans[i - 2]);
    if (status == PNB_OK)
        status = gl_buffer_create(b->device, NULL, 4096, true, &b->faces);
    return status;
}

static void dbuffer_destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct dbuffer *b = state->room;
    if (!b)
        return;
    dbuffer_textures_destroy(b);
    for (int layer = 0; layer < 2; layer++) {
        for (int kind = 0; kind < KINDS; kind++) {
            gl_program_destroy(b->draw[kind][layer]);
            gl_program_destroy(b->draw_fan[kind][layer]);
        }
        gl_program_destroy(b->draw_face[layer]);
        gl_buffer_destroy(b->quads[layer]);
        gl_buffer_destroy(b->fans[layer]);
    }
    gl_program_destroy(b->evaluate);
    gl_program_destroy(b->point);
    gl_buffer_destroy(b->faces);
    gl_texture_destroy(b->lines);
    gl_depth_map_destroy(b->point_map);
    dbuffer_volumes_finish(&b->volumes);
    memory_free(solver->context, b->face_vertices);
    memory_free(solver->context, b);
}

/* The disk that stands for the light. */
static pnb_status find_disk(pnb_solver *solver, const struct light_shape *shape,
                            struct silhouette_disk *disk)
{
    vec3 center = shape->origin;
    double radius = sqrt(shape->area / M_PI);
    switch (shape->light.type) {
    case PNB_LIGHT_DISK: radius = shape->light.shape.disk.radius; break;
    case PNB_LIGHT_POINT: silhouette_disk_init(disk, center, v3(0, 1, 0), 0); return PNB_OK;
    case PNB_LIGHT_RECTANGLE:
        center = v3_mad(v3_mad(center, shape->axis_u, 0.5), shape->axis_v, 0.5);
        break;
    default: {
        /* The middle of the polygon's area. */
        const double *vertices = shape->light.shape.polygon.vertices;
        double sum = 0;
        center = v3(0, 0, 0);
        for (size_t i = 0; i < shape->triangle_count; i++) {
            const uint32_t *t = shape->triangles + 3 * i;
            vec3 a = v3_load(vertices + 3 * t[0]), b = v3_load(vertices + 3 * t[1]),
                 c = v3_load(vertices + 3 * t[2]);
            double area = v3_length(v3_cross(v3_sub(b, a), v3_sub(c, a)));
            center = v3_mad(center, v3_add(v3_add(a, b), c), area / 3);
            sum += area;
        }
        center = v3_scale(center, 1 / sum);
    }
    }
    silhouette_disk_init(disk, center, shape->normal, radius);
    if (shape->light.type != PNB_LIGHT_DISK)
        solver_warn(solver, "the light is taken for a disk of the same area, radius %.4g m",
                    radius);
    return PNB_OK;
}

static pnb_status draw_point(pnb_solver *solver, struct opengl_state *state, vec3 at, vec3 normal,
                             const struct gl_frame *frame, struct gl_target *target)
{
    struct dbuffer *b = state->room;
    pnb_status status = PNB_OK;
    if (!b->point_map)
        status = gl_depth_map_create(b->device, b->size ? b->size : POINT_SIZE, &b->point_map);
    if (status == PNB_OK)
        status = gl_depth_map_draw(b->point_map, state->occluders, at, normal);
    if (status != PNB_OK)
        return status;
    struct gl_draw draw = {.program = b->point, .target = target};
    gl_depth_map_uniforms(b->point_map, draw.uniforms);
    struct gl_uniform *u = draw.uniforms + GL_DEPTH_MAP_UNIFORMS;
    *u++ = gl_sampler("frame_position", frame->position);
    *u++ = gl_sampler("frame_normal", frame->normal);
    *u++ = gl_float("bias", b->bias);
    gl_draw_cover(b->device, &draw);
    return PNB_OK;
}

static void draw_pixels(struct dbuffer_pass *pass, const struct gl_frame *frame,
                        struct gl_target *target)
{
    struct dbuffer *b = pass->b;
    struct gl_draw draw = {.program = b->evaluate, .target = target};
    struct gl_uniform *u = draw.uniforms;
    *u++ = gl_sampler("frame_position", frame->position);
    *u++ = gl_sampler("frame_normal", frame->normal);
    *u++ = gl_vec3("center", &pass->disk->center.x);
    *u++ = gl_vec3("axis_u", &pass->disk->u.x);
    *u++ = gl_vec3("axis_v", &pass->disk->v.x);
    *u++ = gl_vec3("axis_n", &pass->disk->normal.x);
    *u++ = gl_float("radius", pass->disk->radius);
    *u++ = gl_sampler("lines", b->lines);
    *u++ = gl_float("bias", b->bias);
    *u++ = gl_int("map_face_count", b->map.face_count);
    *u++ = gl_floats("map_axes", GL_UNIFORM_VEC3, pass->axes, 3 * b->map.face_count);
    *u++ = gl_vec4("map_fit", b->map.shift[0], b->map.shift[1], b->map.reach[0], b->map.reach[1]);
    *u++ = gl_float("map_size", b->map.size);
    *u++ = gl_sampler("occluder_texture", b->textures[OCCLUDER][0]);
    *u++ = gl_sampler("umbra_texture", b->textures[UMBRA][0]);
    *u++ = gl_sampler("penumbra_texture", b->textures[PENUMBRA][0]);
    if (b->layers == 2) {
        *u++ = gl_sampler("behind_texture", b->textures[OCCLUDER][1]);
        *u++ = gl_sampler("umbra2_texture", b->textures[UMBRA][1]);
        *u++ = gl_sampler("penumbra2_texture", b->textures[PENUMBRA][1]);
    }
    gl_draw_cover(b->device, &draw);
}

/* Of the receivers over the light's plane; 0: unknown. */
static double farthest_height(const struct silhouette_disk *disk, const struct gl_frame *frame)
{
    double far_z = 0;
    for (int i = 0; i < 8 && frame->bounded; i++) {
        vec3 corner = v3(i & 1 ? frame->high.x : frame->low.x, i & 2 ? frame->high.y : frame->low.y,
                         i & 4 ? frame->high.z : frame->low.z);
        double z = silhouette_disk_from_world(disk, corner).z;
        far_z = isfinite(z) ? fmax(far_z, 1.001 * z) : far_z;
    }
    return far_z;
}

static pnb_status draw_disk(pnb_solver *solver, struct opengl_state *state,
                            const struct silhouette_disk *disk, const struct gl_frame *frame,
                            struct gl_target *target)
{
    struct dbuffer *b = state->room;
    const struct gl_occluders *o = state->occluders;
    struct dbuffer_pass pass = {.b = b, .occluders = o, .disk = disk};
    warn_of_open_meshes(solver, o, disk);
    double started = clock_ms();
    pnb_status status = dbuffer_volumes_build(&b->volumes, o, disk);
    double built = clock_ms();
    pass.far_z = farthest_height(disk, frame);
    dbuffer_map_fit(o, disk, pass.far_z, b->size, &b->map);
    if (status == PNB_OK)
        status = dbuffer_volumes_upload(solver, b);
    if (status == PNB_OK)
        status = dbuffer_textures_reserve(b);
    if (status != PNB_OK)
        return status;
    double extent = v3_length(v3_sub(o->scene_high, o->scene_low)), farthest = 0;
    for (int i = 0; i < 8; i++) {
        vec3 p =
            v3(i & 1 ? o->scene_high.x : o->scene_low.x, i & 2 ? o->scene_high.y : o->scene_low.y,
               i & 4 ? o->scene_high.z : o->scene_low.z);
        farthest = fmax(farthest, v3_length(v3_sub(p, disk->center)));
    }
    pass.per_far = 1 / (8 * farthest);
    pass.gap = TOLERANCE_LIGHT_GAP * extent;
    for (int i = 0; i < b->map.face_count; i++)
        for (int k = 0; k < 3; k++)
            v3_storef(pass.axes + 9 * i + 3 * k, b->map.axes[i][k]);
    dbuffer_draw_faces(&pass);
    if (b->map.face_count > 0) {
        draw_pixels(&pass, frame, target);
    } else {
        struct gl_clear lit = {.color = {true}, .color_value = {{1, 1, 1, 1}}};
        gl_target_clear(target, &lit);
    }
    const struct dbuffer_volumes *v = &b->volumes;
    solver_count(solver, "umbra_edges", (double)v->edges[0]);
    solver_count(solver, "penumbra_edges", (double)v->edges[1]);
    solver_count(solver, "skipped_edges", (double)v->skipped_edges);
    solver_count(solver, "concave_edges", (double)v->concave_edges);
    solver_count(solver, "umbra_pieces", (double)(v->quads[0].count + v->fans[0].count));
    solver_count(solver, "penumbra_pieces", (double)(v->quads[1].count + v->fans[1].count));
    solver_count(solver, "silhouette_faces", (double)v->face_count);
    solver_count(solver, "buffer_faces", b->map.face_count);
    solver_count(solver, "buffer_size", b->map.size);
    solver_count(solver, "texel", 2 * fmax(b->map.reach[0], b->map.reach[1]) / b->map.size);
    solver_count(solver, "volumes_ms", built - started);
    if (v->skipped_edges > 0)
        solver_warn(solver, "the lines of some silhouette edges meet the light: they are left out");
    return PNB_OK;
}

static pnb_status dbuffer_draw(pnb_solver *solver, struct opengl_state *state,
                               const struct light_shape *shape, const pnb_light *light,
                               const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct silhouette_disk disk;
    struct gl_target *target;
    struct gl_target_desc desc = {.colors = {{visibility, 0}}};
    pnb_status status = find_disk(solver, shape, &disk);
    if (status == PNB_OK)
        status = gl_target_create(state->device, &desc, &target);
    if (status != PNB_OK)
        return status;
    const struct gl_occluders *o = state->occluders;
    double extent = v3_length(v3_sub(o->scene_high, o->scene_low));
    bool point = light->type == PNB_LIGHT_POINT;
    if (point || disk.radius < TOLERANCE_LIGHT_GAP * extent)
        status = draw_point(solver, state, disk.center, point ? v3(0, 0, 0) : disk.normal, frame,
                            target);
    else
        status = draw_disk(solver, state, &disk, frame, target);
    gl_target_destroy(target);
    return status;
}

static const pnb_param_info params[] = {
    {"size", PNB_PARAM_INTEGER, "0", 0, 8192, NULL,
     "a face of the D-buffer has size x size texels, from 16 on; 0: 512, or 1024 for small lights"},
    {"layers", PNB_PARAM_INTEGER, "2", 1, 2, NULL,
     "intersections with the light that a texel holds: 1 as in the paper, 2 as in its outlook"},
    {"v", PNB_PARAM_CHOICE, "disk", 0, 0, "paper|disk|sqrt",
     "V(t): 3t^2 - 2t^3, the disk's own, or sqrt(t) for small occluders"},
    {"filter", PNB_PARAM_CHOICE, "linear", 0, 0, "nearest|linear",
     "one texel for a pixel, or the four around it"},
    {"bias", PNB_PARAM_NUMBER, "1", 0, 1000, NULL,
     "texels of slack between a receiver and what hides it"},
};

static const struct opengl_method opengl = {
    .create = dbuffer_create, .destroy = dbuffer_destroy, .draw = dbuffer_draw, .edges = true};

const struct method method_dbuffer = {
    .info =
        {
            .name = "dbuffer",
            .title = "umbra and penumbra volumes in a distance buffer",
            .paper = "Jakobsen, Christensen, Larsen, Petersen: Boundary Correct Real-Time Soft "
                     "Shadows (2004)",
            .summary = "Umbra and penumbra volumes of a disk light, drawn from its centre into a "
                       "buffer of distances; a share of the light's diameter per pixel.",
            .lights = PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |
                      PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) | PNB_LIGHT_BIT(PNB_LIGHT_POINT),
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_OPENGL,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = opengl_create,
    .destroy = opengl_destroy,
    .update = opengl_update,
    .visibility = opengl_visibility,
    .opengl = &opengl,
};
