/* gl/frame.c: the receivers of a frame as a G-buffer.
 *
 * Two sources: arrays of pixels (pnb_receivers), which are uploaded with their rows turned, and an
 * engine's depth texture, from which a pass makes positions and, where there are none, normals.
 * Either way a second pass writes the window depth of the positions through clip_from_world, whose
 * far plane lies at infinity:  depth = 1 - near / distance along the view axis.  So volumes that
 * methods draw meet the depth of the very points that visibility is asked for.
 *
 * The alpha of a normal is the lift of its receiver, metres: that of the scene, and for a depth
 * texture twice what one step of 24-bit depth means there, if that is more.
 */
#include <string.h>

#include "gl/frame.h"

struct rows_job {
    const pnb_receivers *receivers;
    float *positions, *normals; /* x 4 */
    float lift;
};

/* Rows from the bottom: OpenGL's order. */
static void rows_body(void *user, size_t begin, size_t end, int worker)
{
    const struct rows_job *job = user;
    size_t width = (size_t)job->receivers->width, height = (size_t)job->receivers->height;
    for (size_t y = begin; y < end; y++) {
        const float *p = job->receivers->positions + 3 * y * width;
        const float *n = job->receivers->normals + 3 * y * width;
        float *position = job->positions + 4 * (height - 1 - y) * width;
        float *normal = job->normals + 4 * (height - 1 - y) * width;
        for (size_t x = 0; x < width; x++, p += 3, n += 3, position += 4, normal += 4) {
            bool none = !isfinite(p[0] + p[1] + p[2] + n[0] + n[1] + n[2]);
            for (int c = 0; c < 3; c++) {
                position[c] = none ? 0 : p[c];
                normal[c] = none ? 0 : n[c];
            }
            position[3] = none ? 0 : 1;
            normal[3] = job->lift;
        }
    }
}

/* Rows x, y and w of the camera's projection, then z for a far plane at infinity. */
static void project_camera(struct gl_frame *frame, const pnb_camera *camera)
{
    vec3 eye = v3_load(camera->eye);
    vec3 forward = v3_normalize(v3_sub(v3_load(camera->target), eye));
    vec3 right = v3_normalize(v3_cross(forward, v3_load(camera->up)));
    vec3 up = v3_cross(right, forward);
    double tangent = tan(camera->vertical_fov_degrees * M_PI / 360);
    double aspect = (double)frame->width / frame->height;
    const vec3 rows[4] = {v3_scale(right, 1 / (tangent * aspect)), v3_scale(up, 1 / tangent),
                          forward, forward};
    for (int r = 0; r < 4; r++) {
        double *m = frame->clip_from_world;
        m[r] = rows[r].x, m[4 + r] = rows[r].y, m[8 + r] = rows[r].z;
        m[12 + r] = -v3_dot(rows[r], eye);
    }
    frame->eye = eye;
}

static void set_near(struct gl_frame *frame, double near_w)
{
    double *m = frame->clip_from_world;
    for (int c = 0; c < 4; c++)
        m[4 * c + 2] = m[4 * c + 3];
    m[14] -= 2 * near_w;
    double w = v3_length(v3(m[3], m[7], m[11]));
    frame->near_m = near_w / w;
}

static vec3 to_clip_xyw(const struct gl_frame *frame, vec3 p)
{
    const double *m = frame->clip_from_world;
    return v3(m[0] * p.x + m[4] * p.y + m[8] * p.z + m[12],
              m[1] * p.x + m[5] * p.y + m[9] * p.z + m[13],
              m[3] * p.x + m[7] * p.y + m[11] * p.z + m[15]);
}

/* The near plane at half of the nearest point's depth. Looks whether points lie where the camera
 * sees them: a stray one means that image and camera do not belong together. */
static pnb_status choose_near(struct gl_frame *frame, const pnb_receivers *receivers)
{
    double nearest = INFINITY;
    size_t width = (size_t)frame->width;
    frame->bounded = true;
    frame->low = v3(INFINITY, INFINITY, INFINITY);
    frame->high = v3_scale(frame->low, -1);
    for (size_t i = 0; i < receivers->count; i++) {
        vec3 p = v3_loadf(receivers->positions + 3 * i);
        if (!v3_finite(p))
            continue;
        frame->low = v3_min(frame->low, p);
        frame->high = v3_max(frame->high, p);
        vec3 clip = to_clip_xyw(frame, p);
        if (clip.z > 0 && clip.z < nearest)
            nearest = clip.z;
        if (i % 97 != 0 || !(clip.z > 0))
            continue;
        double x = (0.5 * clip.x / clip.z + 0.5) * frame->width - 0.5;
        double y = (0.5 - 0.5 * clip.y / clip.z) * frame->height - 0.5;
        double off = fmax(fabs(x - (double)(i % width)), fabs(y - (double)(i / width)));
        double rounding = 1e-6 * v3_max_abs(p) / clip.z * fmax(frame->width, frame->height);
        if (off > 2 + 10 * rounding)
            return status_fail(gl_device_context(frame->device), PNB_ERROR_ARGUMENT, "receivers",
                               "pixel (%zu, %zu) is not where the camera sees it", i % width,
                               i / width);
    }
    set_near(frame, isfinite(nearest) ? 0.5 * nearest : 1);
    return PNB_OK;
}

static pnb_status create_textures(struct gl_frame *frame)
{
    struct gl_texture_desc desc = {
        .format = GL_FORMAT_RGBA32F, .width = frame->width, .height = frame->height};
    pnb_status status = gl_texture_create(frame->device, &desc, &frame->position);
    if (status == PNB_OK)
        status = gl_texture_create(frame->device, &desc, &frame->normal);
    desc.format = GL_FORMAT_DEPTH24_STENCIL8;
    if (status == PNB_OK)
        status = gl_texture_create(frame->device, &desc, &frame->depth);
    struct gl_target_desc depth = {.depth = {frame->depth, 0}};
    if (status == PNB_OK)
        status = gl_target_create(frame->device, &depth, &frame->depth_target);
    struct gl_target_desc surface = {.colors = {{frame->position, 0}, {frame->normal, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(frame->device, &surface, &frame->surface_target);
    return status;
}

static void destroy_textures(struct gl_frame *frame)
{
    gl_target_destroy(frame->surface_target);
    gl_target_destroy(frame->depth_target);
    gl_texture_destroy(frame->position);
    gl_texture_destroy(frame->normal);
    gl_texture_destroy(frame->depth);
    frame->surface_target = frame->depth_target = NULL;
    frame->position = frame->normal = frame->depth = NULL;
}

/* Textures of the size, kept where it did not change. */
static pnb_status resize(struct gl_frame *frame, int width, int height)
{
    if (frame->depth_target && frame->width == width && frame->height == height)
        return PNB_OK;
    destroy_textures(frame);
    frame->width = width;
    frame->height = height;
    frame->generation++;
    pnb_status status = create_textures(frame);
    if (status != PNB_OK) {
        destroy_textures(frame);
        frame->width = frame->height = 0;
    }
    return status;
}

static void draw_depth(struct gl_frame *frame)
{
    const double *m = frame->clip_from_world;
    struct gl_clear clear = {.depth = true, .stencil = true, .depth_value = 1};
    gl_target_clear(frame->depth_target, &clear);
    struct gl_draw draw = {
        .program = frame->depth_program,
        .target = frame->depth_target,
        .depth_write = true,
        .uniforms = {gl_sampler("frame_position", frame->position),
                     gl_vec4("row_w", m[3], m[7], m[11], m[15]),
                     gl_float("near_w", frame->near_m * v3_length(v3(m[3], m[7], m[11])))}};
    gl_draw_cover(frame->device, &draw);
}

pnb_status gl_frame_create(struct gl_device *device, struct gl_frame **out_frame)
{
    pnb_context *context = gl_device_context(device);
    *out_frame = NULL;
    struct gl_frame *frame = memory_calloc(context, 1, sizeof(*frame));
    if (!frame)
        return status_no_memory(context, sizeof(*frame));
    frame->device = device;
    struct gl_program_desc desc = {.vertex = "gl/cover.vert", .fragment = "gl/frame_depth.frag"};
    pnb_status status = gl_program_create(device, &desc, &frame->depth_program);
    desc.fragment = "gl/frame_surface.frag";
    if (status == PNB_OK)
        status = gl_program_create(device, &desc, &frame->surface_program);
    if (status != PNB_OK) {
        gl_frame_destroy(frame);
        return status;
    }
    *out_frame = frame;
    return PNB_OK;
}

void gl_frame_destroy(struct gl_frame *frame)
{
    if (!frame)
        return;
    destroy_textures(frame);
    gl_program_destroy(frame->depth_program);
    gl_program_destroy(frame->surface_program);
    memory_free(gl_device_context(frame->device), frame);
}

pnb_status gl_frame_from_receivers(struct gl_device *device, const pnb_scene *scene,
                                   const pnb_receivers *receivers, struct gl_frame **out_frame)
{
    pnb_status status = gl_frame_create(device, out_frame);
    if (status == PNB_OK)
        status = gl_frame_update(*out_frame, scene, receivers);
    if (status != PNB_OK) {
        gl_frame_destroy(*out_frame);
        *out_frame = NULL;
    }
    return status;
}

pnb_status gl_frame_update(struct gl_frame *frame, const pnb_scene *scene,
                           const pnb_receivers *receivers)
{
    pnb_context *context = gl_device_context(frame->device);
    if (receivers->width < 1 || receivers->height < 1 || !receivers->camera)
        return status_fail(context, PNB_ERROR_UNSUPPORTED, "receivers",
                           "methods on OpenGL need the pixels of an image and its camera");
    pnb_status status = resize(frame, receivers->width, receivers->height);
    if (status != PNB_OK)
        return status;
    project_camera(frame, receivers->camera);
    status = choose_near(frame, receivers);
    if (status != PNB_OK)
        return status;
    frame->lift = scene_receiver_lift(scene);

    struct rows_job job = {.receivers = receivers, .lift = (float)frame->lift};
    job.positions = memory_alloc(context, receivers->count, 4 * sizeof(float));
    job.normals = memory_alloc(context, receivers->count, 4 * sizeof(float));
    if (job.positions && job.normals) {
        parallel_for(context, (size_t)frame->height, 16, rows_body, &job);
        gl_texture_upload(frame->position, 0, job.positions);
        gl_texture_upload(frame->normal, 0, job.normals);
        draw_depth(frame);
    } else {
        status = status_no_memory(context, receivers->count * 8 * sizeof(float));
    }
    memory_free(context, job.positions);
    memory_free(context, job.normals);
    return status;
}

/* ---- From a depth texture ---- */

/* Gauss-Jordan with pivots; false: singular. Column-major. */
static bool invert(const double m[16], double out[16])
{
    double a[4][8];
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 8; c++)
            a[r][c] = c < 4 ? m[4 * c + r] : (double)(c - 4 == r);
    for (int k = 0; k < 4; k++) {
        int pivot = k;
        for (int r = k + 1; r < 4; r++)
            if (fabs(a[r][k]) > fabs(a[pivot][k]))
                pivot = r;
        if (!(fabs(a[pivot][k]) > 0) || !isfinite(a[pivot][k]))
            return false;
        for (int c = 0; c < 8; c++) {
            double swap = a[k][c];
            a[k][c] = a[pivot][c];
            a[pivot][c] = swap;
        }
        for (int r = 0; r < 4; r++) {
            double factor = a[r][k] / a[k][k];
            for (int c = 0; c < 8 && r != k; c++)
                a[r][c] -= factor * a[k][c];
        }
    }
    for (int r = 0; r < 4; r++)
        for (int c = 0; c < 4; c++) {
            out[4 * c + r] = a[r][c + 4] / a[r][r];
            if (!isfinite(out[4 * c + r]))
                return false;
        }
    return true;
}

/* The eye: where clip x, y and w are all zero. */
static bool find_eye(const double *m, vec3 *out_eye)
{
    vec3 x = v3(m[0], m[4], m[8]), y = v3(m[1], m[5], m[9]), w = v3(m[3], m[7], m[11]);
    double det = v3_dot(x, v3_cross(y, w));
    if (!(fabs(det) > 1e-12 * v3_length(x) * v3_length(y) * v3_length(w)))
        return false;
    vec3 sum = v3_scale(v3_cross(y, w), -m[12]);
    sum = v3_mad(sum, v3_cross(w, x), -m[13]);
    sum = v3_mad(sum, v3_cross(x, y), -m[15]);
    *out_eye = v3_scale(sum, 1 / det);
    return v3_finite(*out_eye);
}

pnb_status gl_frame_from_depth(struct gl_frame *frame, const pnb_scene *scene,
                               const struct gl_frame_source *source)
{
    pnb_context *context = gl_device_context(frame->device);
    pnb_status status = resize(frame, source->width, source->height);
    if (status != PNB_OK)
        return status;
    double *m = frame->clip_from_world, relative[16], world_from_clip[16];
    memcpy(m, source->clip_from_world, sizeof(frame->clip_from_world));
    if (!find_eye(m, &frame->eye))
        return status_fail(context, PNB_ERROR_ARGUMENT, "clip_from_world",
                           "no perspective projection");
    /* Relative to the eye, so that floats are spent on what is seen. */
    memcpy(relative, m, sizeof(relative));
    const double *eye = &frame->eye.x;
    for (int r = 0; r < 4; r++)
        relative[12 + r] += m[r] * eye[0] + m[4 + r] * eye[1] + m[8 + r] * eye[2];
    if (!invert(relative, world_from_clip))
        return status_fail(context, PNB_ERROR_ARGUMENT, "clip_from_world", "singular");

    /* Along the axis z = a w + b: near where z = -w (or 0, or w). */
    vec3 axis = v3(m[3], m[7], m[11]);
    double per_w = v3_dot(v3(m[2], m[6], m[10]), axis) / v3_dot(axis, axis);
    double base = relative[14], near_z = source->zero_to_one ? 0 : -1;
    if (source->reversed)
        near_z = 1;
    double near_w = base / (near_z - per_w);
    if (!(near_w > 0) || !isfinite(near_w))
        return status_fail(context, PNB_ERROR_ARGUMENT, "clip_from_world",
                           "its near plane does not lie before the eye");
    set_near(frame, near_w);
    frame->bounded = source->bounded;
    frame->low = source->low;
    frame->high = source->high;
    frame->lift = scene_receiver_lift(scene);

    struct gl_draw draw = {
        .program = frame->surface_program,
        .target = frame->surface_target,
        .uniforms = {gl_sampler("engine_depth", source->depth),
                     gl_int("has_normals", source->normal != NULL),
                     gl_sampler("engine_normal", source->normal ? source->normal : source->depth),
                     gl_int("normals_biased", source->normals_biased),
                     (struct gl_uniform){"corner", GL_UNIFORM_IVEC2, .count = 1,
                                         .integer = {source->x, source->y}},
                     gl_vec2("size", frame->width, frame->height),
                     gl_int("zero_to_one", source->zero_to_one),
                     gl_float("background", source->reversed ? 0 : 1),
                     gl_mat4("relative_from_clip", world_from_clip), gl_vec3("eye", eye),
                     gl_float("lift", frame->lift),
                     /* d(distance)/d(depth) = distance^2 / near: one step of 24 bits, twice. */
                     gl_float("lift_per_square", 2.0 / 16777216 / frame->near_m)}};
    gl_draw_cover(frame->device, &draw);
    draw_depth(frame);
    return PNB_OK;
}
