/* viewer/gpu.c: one frame by OpenGL in the window's context.
 *
 *   scene.vert, scene.frag    depth, geometric and shading normals, objects      "surface"
 *   box.frag                  the box of what is seen, which is read back        "surface"
 *   the library's door        depth and normals in, visibility out, each light   "visibility"
 *   light.frag                irradiance x visibility, added up over the lights  "shade"
 *   picture.frag              a side in sRGB: picture, visibility or error
 *   show.frag                 the sides on the canvas, either part of the divider
 *
 * Rows run from the bottom. The depth is reversed with an endless far plane where the context has
 * glClipControl(), so that positions from it are as good as floats are at any distance; else the
 * near plane lies as far out as the objects' boxes allow. Visibility below 0 stands for none.
 *
 * Memory: 60 bytes a pixel for one side, 68 for two, and the library's own.
 */
#include "gpu_inside.h"

#include <gio/gio.h>
#include <penumbra/opengl.h>
#include <string.h>

#include "camera.h"
#include "shade.h"

enum { MAP_SIZE = 512 }; /* colours of errors, and one for none */
enum { WARM_MS = 1000 }; /* may a solver's first frame take */
enum { BOX_SIDE = 16 };  /* pixels that one fragment of box.frag looks at, across */

/* LIGHT: one per type, made when it is needed. */
enum program { SCENE, BOX, PICTURE, SHOW, LIGHT, PROGRAMS = LIGHT + PNB_LIGHT_TYPE_COUNT };

enum {
    DEPTH,
    SURFACE,
    SHADING,
    SCRATCH,
    TRUTH,
    SUMS,
    VISIBILITY = SUMS + VIEW_SIDES,
    PICTURES = VISIBILITY + VIEW_SIDES,
    SIZED_TEXTURES = PICTURES + VIEW_SIDES
};

struct view_gpu {
    bool es, reversed;
    char device[128];
    GLuint programs[PROGRAMS];
    GLuint textures[SIZED_TEXTURES], colors, corners, box[2];
    GLuint framebuffer, empty_array;
    int width, height;
    struct gpu_scene scene;
    float low[3], high[3]; /* of what is seen; all zero: nothing */

    /* What the textures show. */
    uint64_t scene_id, content;
    double exposure;
    bool drawn[VIEW_SIDES];
    char messages[VIEW_SIDES][256];
    int samples[VIEW_SIDES];
};

/* ---- programs ---- */

static GLuint compile(struct view_gpu *gpu, GLenum type, const char *name, int kind, char *why,
                      size_t size)
{
    char path[64];
    g_snprintf(path, sizeof(path), "/penumbra/shaders/%s", name);
    GBytes *file = g_resources_lookup_data(path, G_RESOURCE_LOOKUP_FLAGS_NONE, NULL);
    if (!file)
        return 0;
    char define[32];
    g_snprintf(define, sizeof(define), "#define KIND %d\n", kind);
    const char *texts[3] = {gpu->es ? "#version 320 es\nprecision highp float;\n"
                                      "precision highp int;\nprecision highp sampler2D;\n"
                                    : "#version 330 core\n",
                            define, g_bytes_get_data(file, NULL)};
    GLint lengths[3] = {-1, -1, (GLint)g_bytes_get_size(file)}, good = 0;
    GLuint shader = glCreateShader(type);
    glShaderSource(shader, 3, texts, lengths);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    g_bytes_unref(file);
    if (good)
        return shader;
    char log[200] = "";
    glGetShaderInfoLog(shader, sizeof(log), NULL, log);
    g_snprintf(why, size, "%s: %s", name, g_strdelimit(log, "\n", ' '));
    glDeleteShader(shader);
    return 0;
}

static bool link_program(struct view_gpu *gpu, enum program which, const char *vertex,
                         const char *fragment, char *why, size_t size)
{
    int kind = which >= LIGHT ? (int)which - LIGHT : 0;
    GLuint shaders[2] = {compile(gpu, GL_VERTEX_SHADER, vertex, kind, why, size), 0};
    if (shaders[0])
        shaders[1] = compile(gpu, GL_FRAGMENT_SHADER, fragment, kind, why, size);
    GLint good = 0;
    GLuint program = gpu->programs[which] = glCreateProgram();
    for (int i = 0; i < 2 && shaders[1]; i++)
        glAttachShader(program, shaders[i]);
    if (shaders[1]) {
        glLinkProgram(program);
        glGetProgramiv(program, GL_LINK_STATUS, &good);
        if (!good)
            g_snprintf(why, size, "%s and %s do not fit", vertex, fragment);
    }
    for (int i = 0; i < 2; i++)
        if (shaders[i])
            glDeleteShader(shaders[i]);
    return good;
}

static GLint at(const struct view_gpu *gpu, enum program which, const char *name)
{
    return glGetUniformLocation(gpu->programs[which], name);
}

static void set_vec3(struct view_gpu *gpu, enum program which, const char *name, vec3 v)
{
    glUniform3f(at(gpu, which, name), (float)v.x, (float)v.y, (float)v.z);
}

static void set_map(struct view_gpu *gpu, enum program which, const char *name, int unit,
                    GLuint texture)
{
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(GL_TEXTURE_2D, texture);
    glUniform1i(at(gpu, which, name), unit);
}

/* ---- textures ---- */

static void make_texture(GLuint texture, GLenum internal, GLenum format, GLenum type, int width,
                         int height, bool smooth, const void *texels)
{
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, (GLint)internal, width, height, 0, format, type, texels);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, smooth ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, smooth ? GL_LINEAR : GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static int box_size(int pixels)
{
    return (pixels + BOX_SIDE - 1) / BOX_SIDE;
}

static bool resize(struct view_gpu *gpu, int width, int height)
{
    if (gpu->width == width && gpu->height == height)
        return true;
    gpu->content = 0;
    gpu->width = gpu->height = 0;
    while (glGetError() != GL_NO_ERROR)
        ;
    for (int i = 0; i < SIZED_TEXTURES; i++) {
        GLenum internal = GL_R32F, format = GL_RED, type = GL_FLOAT;
        if (i == DEPTH) {
            internal = GL_DEPTH_COMPONENT32F;
            format = GL_DEPTH_COMPONENT;
        } else if (i == SURFACE || i == SHADING || (i >= SUMS && i < SUMS + VIEW_SIDES)) {
            internal = i == SURFACE ? GL_RGBA32F : GL_RGBA16F;
            format = GL_RGBA;
        } else if (i >= PICTURES) {
            internal = GL_RGBA8;
            format = GL_RGBA;
            type = GL_UNSIGNED_BYTE;
        }
        make_texture(gpu->textures[i], internal, format, type, width, height,
                     type == GL_UNSIGNED_BYTE, NULL);
    }
    for (int i = 0; i < 2; i++)
        make_texture(gpu->box[i], GL_RGBA32F, GL_RGBA, GL_FLOAT, box_size(width), box_size(height),
                     false, NULL);
    if (glGetError() != GL_NO_ERROR)
        return false;
    gpu->width = width;
    gpu->height = height;
    return true;
}

static void make_colors(struct view_gpu *gpu)
{
    uint8_t texels[MAP_SIZE + 1][4];
    for (int i = 0; i <= MAP_SIZE; i++) {
        double rgb[3] = {0.03, 0.03, 0.03};
        if (i < MAP_SIZE)
            pnb_colormap_diverging((double)i / (MAP_SIZE - 1), rgb);
        for (int c = 0; c < 3; c++) {
            double e = rgb[c] <= 0.0031308 ? 12.92 * rgb[c] : 1.055 * pow(rgb[c], 1 / 2.4) - 0.055;
            texels[i][c] = (uint8_t)lround(255 * CLAMP(e, 0, 1));
        }
        texels[i][3] = 255;
    }
    make_texture(gpu->colors, GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, MAP_SIZE + 1, 1, false, texels);
}

/* ---- life ---- */

struct view_gpu *view_gpu_create(bool es, char *why, size_t size)
{
    struct view_gpu *gpu = g_new0(struct view_gpu, 1);
    int version = epoxy_gl_version();
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    gpu->es = es;
    gpu->reversed = !es && (version >= 45 || epoxy_has_gl_extension("GL_ARB_clip_control"));
    g_strlcpy(gpu->device, renderer ? renderer : "", sizeof(gpu->device));
    g_strlcpy(why, "its shaders are missing", size);
    if (version < (es ? 32 : 33)) {
        g_snprintf(why, size, "it has OpenGL %s%d.%d only", es ? "ES " : "", version / 10,
                   version % 10);
        g_free(gpu);
        return NULL;
    }
    glGenTextures(SIZED_TEXTURES, gpu->textures);
    glGenTextures(1, &gpu->colors);
    glGenTextures(1, &gpu->corners);
    glGenTextures(2, gpu->box);
    glGenFramebuffers(1, &gpu->framebuffer);
    glGenVertexArrays(1, &gpu->empty_array);
    if (link_program(gpu, SCENE, "scene.vert", "scene.frag", why, size) &&
        link_program(gpu, BOX, "cover.vert", "box.frag", why, size) &&
        link_program(gpu, PICTURE, "cover.vert", "picture.frag", why, size) &&
        link_program(gpu, SHOW, "cover.vert", "show.frag", why, size)) {
        make_colors(gpu);
        return gpu;
    }
    view_gpu_destroy(gpu);
    return NULL;
}

void view_gpu_destroy(struct view_gpu *gpu)
{
    if (!gpu)
        return;
    gpu_scene_close(&gpu->scene);
    for (int i = 0; i < PROGRAMS; i++)
        if (gpu->programs[i])
            glDeleteProgram(gpu->programs[i]);
    glDeleteTextures(SIZED_TEXTURES, gpu->textures);
    glDeleteTextures(1, &gpu->colors);
    glDeleteTextures(1, &gpu->corners);
    glDeleteTextures(2, gpu->box);
    glDeleteFramebuffers(1, &gpu->framebuffer);
    glDeleteVertexArrays(1, &gpu->empty_array);
    g_free(gpu);
}

/* ---- the surface ---- */

/* Where the picture is drawn to; textures of attachments beyond the first may be 0. */
static void attach(struct view_gpu *gpu, GLuint depth, GLuint first, GLuint second)
{
    const GLenum both[2] = {GL_COLOR_ATTACHMENT0, second ? GL_COLOR_ATTACHMENT1 : GL_NONE};
    glBindFramebuffer(GL_FRAMEBUFFER, gpu->framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth, 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, first, 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT1, GL_TEXTURE_2D, second, 0);
    glDrawBuffers(2, both);
    glViewport(0, 0, gpu->width, gpu->height);
}

struct view {
    struct view_lens lens;
    double near_m;
    double rows[4][3], z_add; /* clip = rows . (p - eye), and what clip z adds */
};

static struct view view_of(const struct view_gpu *gpu, const struct view_state *state)
{
    struct view view = {.lens = view_lens_make(&state->camera, gpu->width, gpu->height)};
    const struct view_lens *lens = &view.lens;
    double corner = 1 / sqrt(1 + lens->half_x * lens->half_x + lens->half_y * lens->half_y);
    view.near_m = gpu_scene_near(&gpu->scene, state, corner);
    v3_store(view.rows[0], v3_scale(lens->right, 1 / lens->half_x));
    v3_store(view.rows[1], v3_scale(lens->up, 1 / lens->half_y));
    v3_store(view.rows[2], gpu->reversed ? v3(0, 0, 0) : lens->forward);
    v3_store(view.rows[3], lens->forward);
    view.z_add = gpu->reversed ? view.near_m : -2 * view.near_m;
    return view;
}

/* Column-major; relative to the eye, or to the world. */
static void clip_matrix(const struct view *view, bool relative, float out[16])
{
    for (int row = 0; row < 4; row++) {
        double moved = row == 2 ? view->z_add : 0;
        if (!relative)
            moved -= v3_dot(v3_load(view->rows[row]), view->lens.eye);
        for (int c = 0; c < 3; c++)
            out[4 * c + row] = (float)view->rows[row][c];
        out[12 + row] = (float)moved;
    }
}

static void draw_object(struct view_gpu *gpu, size_t index, const pnb_object *object, vec3 eye)
{
    const double *m = object->world_from_mesh;
    const double e[3] = {eye.x, eye.y, eye.z};
    float place[16] = {0}, normals[9];
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            place[4 * c + r] = (float)m[4 * r + c];
            normals[3 * c + r] =
                (float)(m[4 * r1 + c1] * m[4 * r2 + c2] - m[4 * r1 + c2] * m[4 * r2 + c1]);
        }
        place[12 + r] = (float)(m[4 * r + 3] - e[r]);
    }
    place[15] = 1;
    float most = 0;
    for (int i = 0; i < 9; i++)
        most = fmaxf(most, fabsf(normals[i]));
    for (int i = 0; i < 9 && most > 0; i++)
        normals[i] /= most;
    const struct gpu_mesh *mesh = &gpu->scene.meshes[object->mesh];
    glUniformMatrix4fv(at(gpu, SCENE, "relative_from_mesh"), 1, GL_FALSE, place);
    glUniformMatrix3fv(at(gpu, SCENE, "normal_from_mesh"), 1, GL_FALSE, normals);
    glUniform1f(at(gpu, SCENE, "object"), (float)(index + 1));
    glBindVertexArray(mesh->array);
    glDrawArrays(GL_TRIANGLES, 0, mesh->count);
}

static void draw_surface(struct view_gpu *gpu, const struct view *view,
                         const struct view_state *state)
{
    static const float none[4] = {0, 0, 0, 0};
    const float far_depth = gpu->reversed ? 0 : 1;
    float clip[16];
    clip_matrix(view, true, clip);
    attach(gpu, gpu->textures[DEPTH], gpu->textures[SURFACE], gpu->textures[SHADING]);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(gpu->reversed ? GL_GREATER : GL_LESS);
    if (gpu->reversed)
        glClipControl(GL_LOWER_LEFT, GL_ZERO_TO_ONE);
    glClearBufferfv(GL_DEPTH, 0, &far_depth);
    glClearBufferfv(GL_COLOR, 0, none);
    glClearBufferfv(GL_COLOR, 1, none);
    glUseProgram(gpu->programs[SCENE]);
    glUniformMatrix4fv(at(gpu, SCENE, "clip_from_relative"), 1, GL_FALSE, clip);
    for (size_t i = 0; i < state->object_count; i++) {
        pnb_object object;
        pnb_scene_object(gpu->scene.scene->twin->scene, i, &object);
        if (gpu->scene.meshes[object.mesh].count > 0)
            draw_object(gpu, i, &object, view->lens.eye);
    }
    if (gpu->reversed)
        glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glDisable(GL_DEPTH_TEST);
}

/* ---- lights ---- */

static void draw_cover(struct view_gpu *gpu)
{
    glBindVertexArray(gpu->empty_array);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void set_view(struct view_gpu *gpu, enum program program, const struct view *view)
{
    const struct view_lens *lens = &view->lens;
    set_vec3(gpu, program, "view_forward", lens->forward);
    set_vec3(gpu, program, "view_right", v3_scale(lens->right, lens->half_x));
    set_vec3(gpu, program, "view_up", v3_scale(lens->up, lens->half_y));
    glUniform1f(at(gpu, program, "view_near"), (float)view->near_m);
    glUniform1i(at(gpu, program, "view_reversed"), gpu->reversed);
}

/* A method whose maps follow what is seen gets the same ones as from a file's pixels by it. */
static void find_box(struct view_gpu *gpu, const struct view *view)
{
    int width = box_size(gpu->width), height = box_size(gpu->height);
    size_t count = (size_t)width * (size_t)height;
    float *texels = g_new(float, 8 * count);
    attach(gpu, 0, gpu->box[0], gpu->box[1]);
    glViewport(0, 0, width, height);
    glUseProgram(gpu->programs[BOX]);
    set_map(gpu, BOX, "depth_map", 0, gpu->textures[DEPTH]);
    set_map(gpu, BOX, "surface_map", 1, gpu->textures[SURFACE]);
    set_view(gpu, BOX, view);
    glUniform1i(at(gpu, BOX, "side"), BOX_SIDE);
    draw_cover(gpu);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    for (int i = 0; i < 2; i++) {
        glReadBuffer(i ? GL_COLOR_ATTACHMENT1 : GL_COLOR_ATTACHMENT0);
        glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels + 4 * count * (size_t)i);
    }
    const double eye[3] = {view->lens.eye.x, view->lens.eye.y, view->lens.eye.z};
    for (int c = 0; c < 3; c++) {
        float low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++)
            if (texels[4 * i + 3] > 0) {
                low = fminf(low, texels[4 * i + (size_t)c]);
                high = fmaxf(high, texels[4 * (count + i) + (size_t)c]);
            }
        gpu->low[c] = low <= high ? (float)(low + eye[c]) : 0;
        gpu->high[c] = low <= high ? (float)(high + eye[c]) : 0;
    }
    g_free(texels);
}

static void upload_corners(struct view_gpu *gpu, const struct view_emitter *e, vec3 eye)
{
    int count = MAX(e->count, 1);
    float *texels = g_new0(float, 4 * (gsize)count);
    for (int i = 0; i < e->count; i++) {
        texels[4 * i] = (float)(e->vertices[3 * i] - eye.x);
        texels[4 * i + 1] = (float)(e->vertices[3 * i + 1] - eye.y);
        texels[4 * i + 2] = (float)(e->vertices[3 * i + 2] - eye.z);
    }
    glActiveTexture(GL_TEXTURE0);
    make_texture(gpu->corners, GL_RGBA32F, GL_RGBA, GL_FLOAT, count, 1, false, texels);
    g_free(texels);
}

/* Adds a light with the visibility in `texture` to the sum. */
static void add_light(struct view_gpu *gpu, const struct view *view, int side,
                      const pnb_light *light, double exposure, GLuint texture)
{
    struct view_emitter e;
    const struct view_lens *lens = &view->lens;
    enum program program = LIGHT + light->type;
    char why[256] = "";
    if (!gpu->programs[program] &&
        !link_program(gpu, program, "cover.vert", "light.frag", why, sizeof(why)))
        g_warning("%s", why);
    view_emitter_init(&e, light);
    upload_corners(gpu, &e, lens->eye);
    attach(gpu, 0, gpu->textures[SUMS + side], 0);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    glUseProgram(gpu->programs[program]);
    set_map(gpu, program, "depth_map", 0, gpu->textures[DEPTH]);
    set_map(gpu, program, "surface_map", 1, gpu->textures[SURFACE]);
    set_map(gpu, program, "shading_map", 2, gpu->textures[SHADING]);
    set_map(gpu, program, "visibility_map", 3, texture);
    set_map(gpu, program, "material_map", 4, gpu->scene.materials);
    set_map(gpu, program, "corner_map", 5, gpu->corners);
    set_view(gpu, program, view);
    glUniform1i(at(gpu, program, "count"), e.count);
    vec3 middle = v3(e.center[0], e.center[1], e.center[2]);
    set_vec3(gpu, program, "middle", v3_sub(middle, lens->eye));
    set_vec3(gpu, program, "normal", v3(e.normal[0], e.normal[1], e.normal[2]));
    glUniform1f(at(gpu, program, "radius"), e.radius);
    glUniform1f(at(gpu, program, "sun_scale"), e.sum_scale);
    set_vec3(gpu, program, "amount", v3_scale(v3(e.color[0], e.color[1], e.color[2]), exposure));
    draw_cover(gpu);
    glDisable(GL_BLEND);
    view_emitter_finish(&e);
}

static void clear_map(struct view_gpu *gpu, GLuint texture, float value)
{
    const float values[4] = {value, value, value, value};
    attach(gpu, 0, texture, 0);
    glClearBufferfv(GL_COLOR, 0, values);
}

static double milliseconds_since(int64_t *started)
{
    glFinish();
    int64_t now = g_get_monotonic_time();
    double ms = (double)(now - *started) * 1e-3;
    *started = now;
    return ms;
}

/* The visibility and the sum of all lights. shadows: ask the method; else every light is seen whole
 * and the visibility is none. */
static pnb_status solve_lights(struct view_gpu *gpu, const struct view *view, int side,
                               struct view_frame *frame, bool shadows)
{
    const struct view_state *state = &frame->state;
    pnb_solver *solver = gpu->scene.solvers[side].solver;
    pnb_gl_view input = {.depth_texture = gpu->textures[DEPTH],
                         .normal_texture = gpu->textures[SURFACE],
                         .clip_zero_to_one = gpu->reversed,
                         .depth_reversed = gpu->reversed};
    clip_matrix(view, false, input.clip_from_world);
    memcpy(input.low, gpu->low, sizeof(input.low));
    memcpy(input.high, gpu->high, sizeof(input.high));
    clear_map(gpu, gpu->textures[SUMS + side], 0);
    clear_map(gpu, gpu->textures[VISIBILITY + side], -1);
    int64_t started = g_get_monotonic_time();
    for (size_t k = 0; k < state->light_count; k++) {
        bool shown = k == state->light;
        GLuint texture = gpu->textures[shown ? VISIBILITY + side : SCRATCH];
        const pnb_light *light = &state->lights[k].light;
        pnb_status status = PNB_OK;
        if (shadows)
            status = pnb_gl_solver_visibility(solver, light, &input, texture);
        else
            clear_map(gpu, texture, -1);
        frame->times.visibility[side] += milliseconds_since(&started);
        if (status != PNB_OK)
            return status;
        add_light(gpu, view, side, light, frame->exposure, texture);
        frame->times.shade += milliseconds_since(&started);
    }
    return PNB_OK;
}

/* ---- sides ---- */

/* PNB_OK even where the method cannot do a light: then the side has a message and no shadow. */
static pnb_status solve_side(struct view_gpu *gpu, const struct view *view, int side,
                             struct view_frame *frame)
{
    pnb_context *context = gpu->scene.scene->twin->context;
    int64_t started = g_get_monotonic_time();
    gpu->messages[side][0] = 0;
    gpu->samples[side] = 0;
    pnb_status status = gpu_scene_solver(&gpu->scene, side, &frame->state.methods[side]);
    frame->times.update += milliseconds_since(&started);
    const struct gpu_solver *solver = &gpu->scene.solvers[side];
    if (status == PNB_OK) {
        status = solve_lights(gpu, view, side, frame, true);
        if (status != PNB_OK)
            g_strlcpy(gpu->messages[side], pnb_context_error(context), sizeof(gpu->messages[side]));
    } else {
        g_strlcpy(gpu->messages[side], solver->error, sizeof(gpu->messages[side]));
    }
    if (status == PNB_OK) {
        pnb_solver_report report;
        pnb_solver_get_report(solver->solver, &report);
        gpu->samples[side] = report.samples;
        if (report.warning_count > 0 && !frame->warning[0])
            g_strlcpy(frame->warning, report.warnings[0], sizeof(frame->warning));
        return PNB_OK;
    }
    if (status == PNB_ERROR_CANCELLED || status == PNB_ERROR_DEVICE)
        return status;
    frame->times.visibility[side] = 0;
    return solve_lights(gpu, view, side, frame, false);
}

static void upload_truth(struct view_gpu *gpu, const struct view_frame *frame)
{
    size_t pixels = (size_t)frame->width * (size_t)frame->height;
    float *texels = g_new(float, pixels);
    for (size_t i = 0; i < pixels; i++)
        texels[i] = isnan(frame->truth[i]) ? -1 : frame->truth[i];
    glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, gpu->textures[TRUTH]);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, frame->width, frame->height, GL_RED, GL_FLOAT, texels);
    g_free(texels);
}

static void draw_picture(struct view_gpu *gpu, int side, const struct view_frame *frame)
{
    const pnb_scene *scene = gpu->scene.scene->twin->scene;
    double ambient[3], background[3];
    bool truth = frame->show == VIEW_SHOW_ERROR && frame->truth_samples > 0;
    int show = truth ? 2 : frame->show == VIEW_SHOW_PICTURE ? 0 : 1;
    pnb_scene_ambient(scene, ambient);
    pnb_scene_background(scene, background);
    attach(gpu, 0, gpu->textures[PICTURES + side], 0);
    glUseProgram(gpu->programs[PICTURE]);
    set_map(gpu, PICTURE, "surface_map", 0, gpu->textures[SURFACE]);
    set_map(gpu, PICTURE, "light_map", 1, gpu->textures[SUMS + side]);
    set_map(gpu, PICTURE, "visibility_map", 2, gpu->textures[VISIBILITY + side]);
    set_map(gpu, PICTURE, "truth_map", 3, gpu->textures[TRUTH]);
    set_map(gpu, PICTURE, "material_map", 4, gpu->scene.materials);
    set_map(gpu, PICTURE, "color_map", 5, gpu->colors);
    glUniform1i(at(gpu, PICTURE, "show"), show);
    glUniform1f(at(gpu, PICTURE, "error_factor"), (float)(0.5 / frame->error_scale));
    set_vec3(gpu, PICTURE, "ambient", v3_load(ambient));
    set_vec3(gpu, PICTURE, "background", v3_load(background));
    glUniform1f(at(gpu, PICTURE, "emission_factor"), (float)(frame->exposure * G_PI));
    draw_cover(gpu);
}

/* Rows from the top, NaN where there is none. */
static void read_visibility(struct view_gpu *gpu, int side, struct view_frame *frame)
{
    size_t width = (size_t)frame->width, height = (size_t)frame->height, step = gpu->es ? 4 : 1;
    float *texels = g_new(float, width *height *step);
    attach(gpu, 0, gpu->textures[VISIBILITY + side], 0);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    glReadPixels(0, 0, frame->width, frame->height, gpu->es ? GL_RGBA : GL_RED, GL_FLOAT, texels);
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            size_t i = y * width + x;
            float v = texels[step * ((height - 1 - y) * width + x)];
            frame->visibility[side][i] =
                v < 0 || frame->objects[i] == PNB_NO_OBJECT ? (float)NAN : v;
        }
    g_free(texels);
}

static void plain_state(void)
{
    static const GLenum off[] = {GL_BLEND,        GL_SCISSOR_TEST, GL_DEPTH_TEST,
                                 GL_STENCIL_TEST, GL_CULL_FACE,    GL_DITHER};
    for (gsize i = 0; i < G_N_ELEMENTS(off); i++)
        glDisable(off[i]);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
}

static bool all_warm(const struct view_gpu *gpu, const struct view_frame *frame)
{
    bool warm = true;
    for (int side = 0; side < VIEW_SIDES; side++)
        warm = warm && (!frame->window[side] || gpu->scene.solvers[side].warm);
    return warm;
}

/* Both sides of a frame; PNB_OK, or why not. */
static pnb_status draw_sides(struct view_gpu *gpu, struct view_frame *frame)
{
    bool same = gpu->content == frame->content && gpu->scene_id == frame->scene_id;
    for (int side = 0; side < VIEW_SIDES; side++)
        same = same && (gpu->drawn[side] || !frame->window[side]);
    same = same && gpu->exposure == frame->exposure;
    int64_t started = g_get_monotonic_time();
    gpu->content = 0;
    struct view view = {0};
    if (!same) {
        gpu_scene_move(&gpu->scene, &frame->state);
        view = view_of(gpu, &frame->state);
        draw_surface(gpu, &view, &frame->state);
        find_box(gpu, &view);
        frame->times.primary += milliseconds_since(&started);
    }
    if (frame->show == VIEW_SHOW_ERROR && frame->truth_samples > 0)
        upload_truth(gpu, frame);
    for (int side = 0; side < VIEW_SIDES; side++) {
        if (!frame->window[side])
            continue;
        pnb_status status = same ? PNB_OK : solve_side(gpu, &view, side, frame);
        if (status != PNB_OK)
            return status;
        started = g_get_monotonic_time();
        draw_picture(gpu, side, frame);
        frame->times.shade += milliseconds_since(&started);
        if (frame->full && !frame->moving)
            read_visibility(gpu, side, frame);
        frame->samples[side] = gpu->samples[side];
        g_strlcpy(frame->message[side], gpu->messages[side], sizeof(frame->message[side]));
        g_strlcpy(frame->device, gpu->device, sizeof(frame->device));
    }
    for (int side = 0; side < VIEW_SIDES; side++)
        gpu->drawn[side] = frame->window[side];
    for (int side = 0; side < VIEW_SIDES; side++)
        gpu->scene.solvers[side].warm = gpu->scene.solvers[side].warm || frame->window[side];
    gpu->content = frame->content;
    gpu->exposure = frame->exposure;
    gpu->scene_id = frame->scene_id;
    return PNB_OK;
}

bool view_gpu_draw(struct view_gpu *gpu, struct view_scene *scene, struct view_frame *frame,
                   struct view_drawn *out)
{
    int64_t started = g_get_monotonic_time();
    GLint bound = 0;
    pnb_status status = PNB_OK;
    *out = (struct view_drawn){
        .scene_id = frame->scene_id, .serial = frame->serial, .level = frame->level};
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    plain_state();
    bool good = true;
    if (gpu->scene.scene != scene)
        good = gpu_scene_open(&gpu->scene, scene, out->why, sizeof(out->why));
    if (good && !resize(gpu, frame->width, frame->height)) {
        good = false;
        g_strlcpy(out->why, "no memory for pictures of this size", sizeof(out->why));
    }
    if (good) {
        /* A solver's first frame is drawn twice; only the second time counts. */
        struct view_times before = frame->times;
        scene->twin->stop_us = started + (WARM_MS + frame->state.patience_ms) * 1000;
        if (!all_warm(gpu, frame)) {
            status = draw_sides(gpu, frame);
            gpu->content = 0;
            double update = frame->times.update;
            frame->times = before;
            frame->times.update = update;
        }
        started = g_get_monotonic_time();
        scene->twin->stop_us = started + frame->state.patience_ms * 1000;
        before = frame->times;
        if (status == PNB_OK)
            status = draw_sides(gpu, frame);
        out->ms -= frame->times.update - before.update;
        scene->twin->stop_us = 0;
        if (status == PNB_ERROR_DEVICE)
            g_strlcpy(out->why, pnb_context_error(scene->twin->context), sizeof(out->why));
    }
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)bound);
    out->refused = !good || status == PNB_ERROR_DEVICE || status == PNB_ERROR_MEMORY;
    out->ms += (double)(g_get_monotonic_time() - started) * 1e-3;
    out->late = status == PNB_ERROR_CANCELLED;
    return good && status == PNB_OK;
}

/* ---- the canvas ---- */

void view_gpu_show(struct view_gpu *gpu, const struct view_frame *frame, double divider, int width,
                   int height)
{
    int cut = frame->compare ? (int)lround(divider * width) : width;
    const int from[VIEW_SIDES] = {0, cut}, to[VIEW_SIDES] = {cut, width};
    plain_state();
    glViewport(0, 0, width, height);
    glEnable(GL_SCISSOR_TEST);
    glUseProgram(gpu->programs[SHOW]);
    for (int side = 0; side < VIEW_SIDES; side++) {
        if (!frame->window[side] || !gpu->drawn[side] || from[side] >= to[side])
            continue;
        glScissor(from[side], 0, to[side] - from[side], height);
        set_map(gpu, SHOW, "picture", 0, gpu->textures[PICTURES + side]);
        draw_cover(gpu);
    }
    glDisable(GL_SCISSOR_TEST);
    glBindVertexArray(0);
    glUseProgram(0);
}

void view_gpu_read(struct view_gpu *gpu, struct view_frame *frame)
{
    size_t row = 4 * (size_t)frame->width;
    GLint bound = 0;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    uint8_t *texels = g_malloc(row * (size_t)frame->height);
    for (int side = 0; side < VIEW_SIDES; side++) {
        if (!frame->window[side] || !gpu->drawn[side])
            continue;
        attach(gpu, 0, gpu->textures[PICTURES + side], 0);
        glReadBuffer(GL_COLOR_ATTACHMENT0);
        glReadPixels(0, 0, frame->width, frame->height, GL_RGBA, GL_UNSIGNED_BYTE, texels);
        for (int y = 0; y < frame->height; y++)
            for (int x = 0; x < frame->width; x++) {
                const uint8_t *in = texels + row * (size_t)(frame->height - 1 - y) + 4 * (size_t)x;
                uint8_t *to = frame->bgra[side] + row * (size_t)y + 4 * (size_t)x;
                to[0] = in[2];
                to[1] = in[1];
                to[2] = in[0];
                to[3] = 255;
            }
    }
    g_free(texels);
    glBindFramebuffer(GL_FRAMEBUFFER, (GLuint)bound);
}
