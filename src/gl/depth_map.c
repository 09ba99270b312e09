/* gl/depth_map.c: depth maps from a point.
 *
 * One picture is fitted around all casters where their boxes lie within 70 degrees of the direction
 * to their middle; else six faces of a cube (five for an area light, whose back is dark), less
 * those that no caster's box meets. Floors (gl/frame.h) that have the light on the scene's side
 * shadow nothing and are left out, so that texels are spent on what casts. Casters that reach
 * around the point are clipped at the point itself where the device clamps depth, else at the near
 * plane.
 *
 * Texels hold 1 / distance along the face's axis, which is linear across a flat surface: so the
 * depth test can compare a texel with the receiver's own plane at that texel's middle and needs a
 * bias for curvature only (gl/depth_map.glsl). Cost: the casters once per face. Memory: 4 size^2
 * bytes a face, and 4 for depth.
 */
#include "gl/depth_map.h"

#include "geom/tolerance.h"

#define FIT_COSINE 0.342 /* 70 degrees */

pnb_status gl_depth_map_create(struct gl_device *device, int size, struct gl_depth_map **out_map)
{
    pnb_context *context = gl_device_context(device);
    *out_map = NULL;
    struct gl_depth_map *map = memory_calloc(context, 1, sizeof(*map));
    if (!map)
        return status_no_memory(context, sizeof(*map));
    map->device = device;
    map->size = size;
    static const char *const attributes[] = {"position"};
    struct gl_program_desc program = {.vertex = "gl/depth_map.vert",
                                      .fragment = "gl/depth_map.frag",
                                      .attributes = attributes,
                                      .attribute_count = 1};
    pnb_status status = gl_program_create(device, &program, &map->program);
    struct gl_texture_desc depth = {
        .format = GL_FORMAT_DEPTH32F, .width = size, .height = size, .layers = 1};
    if (status == PNB_OK)
        status = gl_texture_create(device, &depth, &map->depth);
    if (status != PNB_OK) {
        gl_depth_map_destroy(map);
        return status;
    }
    *out_map = map;
    return PNB_OK;
}

static void destroy_faces(struct gl_depth_map *map)
{
    for (int i = 0; i < GL_DEPTH_MAP_FACES; i++) {
        gl_target_destroy(map->targets[i]);
        map->targets[i] = NULL;
    }
    gl_texture_destroy(map->texture);
    map->texture = NULL;
    map->capacity = 0;
}

void gl_depth_map_destroy(struct gl_depth_map *map)
{
    if (!map)
        return;
    destroy_faces(map);
    gl_texture_destroy(map->depth);
    gl_program_destroy(map->program);
    memory_free(gl_device_context(map->device), map);
}

static pnb_status reserve_faces(struct gl_depth_map *map, int count)
{
    if (count <= map->capacity)
        return PNB_OK;
    destroy_faces(map);
    struct gl_texture_desc desc = {.kind = GL_TEXTURE_LAYERS,
                                   .format = GL_FORMAT_R32F,
                                   .width = map->size,
                                   .height = map->size,
                                   .layers = count};
    pnb_status status = gl_texture_create(map->device, &desc, &map->texture);
    for (int i = 0; i < count && status == PNB_OK; i++) {
        struct gl_target_desc target = {.colors = {{map->texture, i}}, .depth = {map->depth, 0}};
        status = gl_target_create(map->device, &target, &map->targets[i]);
    }
    if (status == PNB_OK)
        map->capacity = count;
    else
        destroy_faces(map);
    return status;
}

static vec3 box_corner(const struct gl_occluder *o, int i)
{
    return v3(i & 1 ? o->high.x : o->low.x, i & 2 ? o->high.y : o->low.y,
              i & 4 ? o->high.z : o->low.z);
}

static bool casts(const struct gl_occluder *o, vec3 center)
{
    return !(o->floor && v3_dot(o->floor_normal, center) - o->floor_offset > 0);
}

/* One picture around all casters; false where they lie too far apart as seen from the center. */
static bool fit(struct gl_depth_map *map, const struct gl_occluders *occluders)
{
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_scale(low, -1);
    for (size_t i = 0; i < occluders->object_count; i++)
        if (casts(&occluders->objects[i], map->center)) {
            low = v3_min(low, occluders->objects[i].low);
            high = v3_max(high, occluders->objects[i].high);
        }
    vec3 z = v3_normalize(v3_sub(v3_scale(v3_add(low, high), 0.5), map->center));
    if (!(v3_dot(z, z) > 0.5))
        return false;
    vec3 x, y;
    v3_frame(z, &x, &y);
    double least[2] = {INFINITY, INFINITY}, most[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < occluders->object_count; i++)
        for (int k = 0; k < 8 && casts(&occluders->objects[i], map->center); k++) {
            vec3 d = v3_sub(box_corner(&occluders->objects[i], k), map->center);
            double along = v3_dot(d, z);
            if (!(along > FIT_COSINE * v3_length(d)))
                return false;
            const double at[2] = {v3_dot(d, x) / along, v3_dot(d, y) / along};
            for (int c = 0; c < 2; c++) {
                least[c] = fmin(least[c], at[c]);
                most[c] = fmax(most[c], at[c]);
            }
        }
    map->face_count = 1;
    map->axes[0][0] = x, map->axes[0][1] = y, map->axes[0][2] = z;
    for (int c = 0; c < 2; c++) {
        /* A texel's room on each side, and never nothing: a caster may be seen edge-on. */
        double reach = 0.5 * (most[c] - least[c]) * map->size / fmax(map->size - 2, 1);
        map->reach[c] = fmax(reach, 1e-6);
        map->shift[c] = 0.5 * (most[c] + least[c]);
    }
    return true;
}

/* Whether any caster's box may meet the pyramid of a cube's face. */
static bool face_needed(const struct gl_depth_map *map, const struct gl_occluders *occluders,
                        const vec3 axes[3])
{
    for (size_t i = 0; i < occluders->object_count; i++) {
        if (!casts(&occluders->objects[i], map->center))
            continue;
        int outside = 31; /* sides of the pyramid, and its tip's plane, that all corners leave */
        for (int k = 0; k < 8; k++) {
            vec3 d = v3_sub(box_corner(&occluders->objects[i], k), map->center);
            double x = v3_dot(d, axes[0]), y = v3_dot(d, axes[1]), z = v3_dot(d, axes[2]);
            outside &= (x > z) | (-x > z) << 1 | (y > z) << 2 | (-y > z) << 3 | (z < 0) << 4;
        }
        if (outside == 0)
            return true;
    }
    return false;
}

static void cube(struct gl_depth_map *map, const struct gl_occluders *occluders, vec3 normal)
{
    bool one_sided = v3_dot(normal, normal) > 0.5;
    vec3 n = one_sided ? normal : v3(0, 1, 0), u, v;
    v3_frame(n, &u, &v);
    const vec3 faces[GL_DEPTH_MAP_FACES] = {
        n, u, v, v3_scale(u, -1), v3_scale(v, -1), v3_scale(n, -1)};
    map->face_count = 0;
    for (int i = 0; i < (one_sided ? 5 : 6); i++) {
        vec3 axes[3] = {[2] = faces[i]};
        v3_frame(faces[i], &axes[0], &axes[1]);
        if (!face_needed(map, occluders, axes))
            continue;
        for (int k = 0; k < 3; k++)
            map->axes[map->face_count][k] = axes[k];
        map->face_count++;
    }
    map->shift[0] = map->shift[1] = 0;
    map->reach[0] = map->reach[1] = 1;
}

/* The least distance along any face's axis that is worth a near plane. */
static double find_near(struct gl_depth_map *map, const struct gl_occluders *occluders,
                        double extent)
{
    double nearest = INFINITY;
    for (size_t i = 0; i < occluders->object_count; i++) {
        const struct gl_occluder *o = &occluders->objects[i];
        if (!casts(o, map->center))
            continue;
        vec3 inside = v3_max(o->low, v3_min(o->high, map->center));
        nearest = fmin(nearest, v3_length(v3_sub(inside, map->center)));
    }
    map->nearest = isfinite(nearest) ? fmax(nearest, extent / 16384) : extent;
    /* Off the axis a point is nearer along it, by up to the fitted picture's corner. */
    double far_corner =
        hypot(fabs(map->shift[0]) + map->reach[0], fabs(map->shift[1]) + map->reach[1]);
    return fmax(0.9 * nearest / hypot(1, far_corner), extent / 16384);
}

static void draw_face(struct gl_depth_map *map, const struct gl_occluders *occluders, int face,
                      double near_z, double gap)
{
    const vec3 *axes = map->axes[face];
    double m[16] = {0};
    vec3 rows[3];
    for (int c = 0; c < 2; c++)
        rows[c] = v3_scale(v3_mad(axes[c], axes[2], -map->shift[c]), 1 / map->reach[c]);
    rows[2] = axes[2];
    /* Relative to the center: the vertex shader subtracts it first. z = w - 2 near. */
    const int to[4] = {0, 1, 2, 2};
    for (int r = 0; r < 4; r++) {
        m[r] = rows[to[r]].x;
        m[4 + r] = rows[to[r]].y;
        m[8 + r] = rows[to[r]].z;
    }
    m[14] = -2 * near_z;
    struct gl_clear clear = {.color = {true}, .depth = true, .depth_value = 1};
    gl_target_clear(map->targets[face], &clear);
    struct gl_draw draw = {.program = map->program,
                           .target = map->targets[face],
                           .indices = occluders->index_buffer,
                           .attributes = {{occluders->position_buffer, 3}},
                           .uniforms = {gl_vec3("center", &map->center.x),
                                        gl_mat4("clip_from_relative", m),
                                        gl_float("largest", gap > 0 ? 1 / gap : 1e30)},
                           .depth_test = true,
                           .depth_write = true,
                           .depth_clamp = true,
                           .depth_compare = GL_COMPARE_LESS_EQUAL};
    /* Neighbours in one draw. */
    for (size_t i = 0; i < occluders->object_count; i++) {
        const struct gl_occluder *o = &occluders->objects[i];
        bool more = casts(o, map->center);
        if (more && draw.count == 0)
            draw.first = o->first_index;
        if (more)
            draw.count += o->index_count;
        if (draw.count > 0 && (!more || i + 1 == occluders->object_count)) {
            gl_draw(map->device, &draw);
            draw.count = 0;
        }
    }
}

pnb_status gl_depth_map_draw(struct gl_depth_map *map, const struct gl_occluders *occluders,
                             vec3 center, vec3 normal)
{
    map->center = center;
    map->face_count = 0;
    bool any = false;
    for (size_t i = 0; i < occluders->object_count; i++)
        any = any || casts(&occluders->objects[i], center);
    if (any && !fit(map, occluders))
        cube(map, occluders, normal);
    pnb_status status = reserve_faces(map, map->face_count > 1 ? GL_DEPTH_MAP_FACES : 1);
    if (status != PNB_OK)
        return status;
    double extent = v3_length(v3_sub(occluders->scene_high, occluders->scene_low));
    double near_z = find_near(map, occluders, extent), gap = TOLERANCE_LIGHT_GAP * extent;
    for (int i = 0; i < map->face_count; i++)
        draw_face(map, occluders, i, near_z, gap);
    for (int i = 0; i < map->face_count; i++)
        for (int k = 0; k < 3; k++)
            v3_storef(map->packed_axes + 9 * i + 3 * k, map->axes[i][k]);
    return PNB_OK;
}

void gl_depth_map_uniforms(const struct gl_depth_map *map, struct gl_uniform *uniforms)
{
    uniforms[0] = gl_sampler("map_texture", map->texture);
    uniforms[1] = gl_vec3("map_center", &map->center.x);
    uniforms[2] = gl_int("map_face_count", map->face_count);
    uniforms[3] = gl_floats("map_axes", GL_UNIFORM_VEC3, map->packed_axes, 3 * map->face_count);
    uniforms[4] = gl_vec4("map_fit", map->shift[0], map->shift[1], map->reach[0], map->reach[1]);
    uniforms[5] = gl_int("map_size", map->size);
}
