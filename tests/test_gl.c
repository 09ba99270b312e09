/* The OpenGL folder: devices of each kind, resources there and back, shaders that do not compile,
 * what does not fit, two devices at once, threads; and the engine's door: the same visibility as
 * through the CPU's door, and every state of the caller's context as it was. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <epoxy/gl.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/opengl.h>
#include <penumbra/penumbra.h>

#include "gl/device.h"
#include "gl/frame.h"

static int create_context(void **state)
{
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return -1;
    *state = context;
    return 0;
}

static int destroy_context(void **state)
{
    pnb_context_destroy(*state);
    return 0;
}

static struct gl_device *open_device(pnb_context *context, enum gl_device_api api)
{
    struct gl_device *device;
    if (gl_device_create_as(context, api, &device) == PNB_OK)
        return device;
    print_message("%s\n", pnb_context_error(context));
    skip();
    return NULL;
}

#define must(context, call)                                                                        \
    do {                                                                                           \
        if ((call) != PNB_OK)                                                                      \
            fail_msg("%s", pnb_context_error(context));                                            \
    } while (0)

/* ---- Device ---- */

static void draw_half(pnb_context *context, struct gl_device *device)
{
    struct gl_texture *texture, *source;
    struct gl_target *target;
    struct gl_program *program;
    float texels[16] = {0}, read[16];
    for (int i = 0; i < 16; i++)
        texels[i] = i % 3 == 0 ? 1 : 0;
    must(context, gl_device_begin(device));
    struct gl_texture_desc desc = {.format = GL_FORMAT_R32F, .width = 4, .height = 4};
    must(context, gl_texture_create(device, &desc, &texture));
    desc.texels = texels;
    must(context, gl_texture_create(device, &desc, &source));
    struct gl_target_desc target_desc = {.colors = {{texture, 0}}};
    must(context, gl_target_create(device, &target_desc, &target));
    struct gl_program_desc program_desc = {.vertex = "gl/cover.vert", .fragment = "gl/copy.frag"};
    must(context, gl_program_create(device, &program_desc, &program));
    struct gl_clear clear = {.color = {true}, .color_value = {{7}}};
    gl_target_clear(target, &clear);
    struct gl_draw draw = {.program = program,
                           .target = target,
                           .scissor = {0, 0, 4, 2},
                           .uniforms = {gl_sampler("source", source)}};
    gl_draw_cover(device, &draw);
    must(context, gl_texture_read(texture, 0, read));
    for (int i = 0; i < 16; i++) {
        float expected = i >= 8 ? 7 : texels[i];
        assert_float_equal(read[i], expected, 0);
    }
    gl_program_destroy(program);
    gl_target_destroy(target);
    gl_texture_destroy(texture);
    gl_texture_destroy(source);
    must(context, gl_device_end(device));
}

static void test_device(void **state)
{
    for (int api = GL_DEVICE_API_BEST; api <= GL_DEVICE_API_ES; api++) {
        struct gl_device *device = open_device(*state, (enum gl_device_api)api);
        const struct gl_device_info *info = gl_device_get_info(device);
        print_message("%s%s\n", info->renderer, info->software ? ", software" : "");
        assert_true(info->es == (api == GL_DEVICE_API_ES));
        assert_true(info->version >= (info->es ? 32 : 33) && info->max_texture_size >= 4096);
        draw_half(*state, device);
        gl_device_destroy(device);
    }
}

/* Each begin gives the earlier context back, also of another device. */
static void test_two_devices(void **state)
{
    struct gl_device *a = open_device(*state, GL_DEVICE_API_BEST);
    struct gl_device *b = open_device(*state, GL_DEVICE_API_BEST);
    must(*state, gl_device_begin(a));
    const GLubyte *renderer = glGetString(GL_RENDERER);
    assert_non_null(renderer);
    draw_half(*state, b);
    assert_non_null(glGetString(GL_RENDERER));
    draw_half(*state, a); /* nested */
    must(*state, gl_device_end(a));
    draw_half(*state, a);
    gl_device_destroy(a);
    draw_half(*state, b);
    gl_device_destroy(b);
}

static void *draw_elsewhere(void *user)
{
    void **pair = user;
    draw_half(pair[0], pair[1]);
    return NULL;
}

static void test_threads(void **state)
{
    struct gl_device *device = open_device(*state, GL_DEVICE_API_BEST);
    void *pair[2] = {*state, device};
    for (int i = 0; i < 3; i++) {
        pthread_t thread;
        assert_int_equal(pthread_create(&thread, NULL, draw_elsewhere, pair), 0);
        pthread_join(thread, NULL);
        draw_half(*state, device);
    }
    gl_device_destroy(device);
}

static void test_no_device(void **state)
{
    const char *build = getenv("PNB_BUILD_DIR");
    if (!build)
        skip();
    char command[1024], line[512] = "";
    snprintf(command, sizeof(command),
             "env __EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent '%s/penumbra' render builtin:prism "
             "-m hard-volume -s 16x12 -o /dev/null.png 2>&1",
             build);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    assert_non_null(fgets(line, sizeof(line), pipe));
    char more[64];
    assert_null(fgets(more, sizeof(more), pipe));
    int status = pclose(pipe);
    assert_int_equal(status >> 8, 1);
    if (strncmp(line, "penumbra: error: OpenGL: no device: ", 36) != 0)
        fail_msg("%s", line);
}

/* ---- Resources ---- */

static void test_textures(void **state)
{
    static const struct {
        enum gl_format format;
        int components;
        bool bytes, integer;
    } formats[] = {{GL_FORMAT_R8, 1, true, false},       {GL_FORMAT_RGBA8, 4, true, false},
                   {GL_FORMAT_R16F, 1, false, false},    {GL_FORMAT_RGBA16F, 4, false, false},
                   {GL_FORMAT_R32F, 1, false, false},    {GL_FORMAT_RG32F, 2, false, false},
                   {GL_FORMAT_RGBA32F, 4, false, false}, {GL_FORMAT_R32UI, 1, false, true},
                   {GL_FORMAT_RGBA32UI, 4, false, true}};
    for (int api = GL_DEVICE_API_BEST; api <= GL_DEVICE_API_ES; api += 2) {
        struct gl_device *device = open_device(*state, (enum gl_device_api)api);
        must(*state, gl_device_begin(device));
        for (size_t f = 0; f < sizeof(formats) / sizeof(*formats); f++)
            for (int kind = GL_TEXTURE_PLANE; kind <= GL_TEXTURE_FACES; kind++) {
                struct gl_texture_desc desc = {.kind = (enum gl_texture_kind)kind,
                                               .format = formats[f].format,
                                               .width = 5,
                                               .height = 5,
                                               .layers = 3};
                int layers = kind == GL_TEXTURE_PLANE ? 1 : kind == GL_TEXTURE_LAYERS ? 3 : 6;
                struct gl_texture *texture;
                must(*state, gl_texture_create(device, &desc, &texture));
                unsigned char sent[6][400], got[400];
                int count = 25 * formats[f].components;
                for (int l = 0; l < layers; l++) {
                    for (int i = 0; i < count; i++) {
                        float number = 0.5f * (float)(i + l);
                        uint32_t integer = (uint32_t)(i * 1000003 + l);
                        if (formats[f].bytes)
                            sent[l][i] = (unsigned char)(i * 7 + l);
                        else if (formats[f].integer)
                            memcpy(&sent[l][4 * i], &integer, 4);
                        else
                            memcpy(&sent[l][4 * i], &number, 4);
                    }
                    gl_texture_upload(texture, l, sent[l]);
                }
                for (int l = 0; l < layers; l++) {
                    must(*state, gl_texture_read(texture, l, got));
                    assert_memory_equal(got, sent[l], (size_t)count * (formats[f].bytes ? 1 : 4));
                }
                gl_texture_destroy(texture);
            }
        must(*state, gl_device_end(device));
        gl_device_destroy(device);
    }
}

static void test_no_room(void **state)
{
    struct gl_device *device = open_device(*state, GL_DEVICE_API_BEST);
    int largest = gl_device_get_info(device)->max_texture_size;
    must(*state, gl_device_begin(device));
    struct gl_texture_desc desc = {
        .format = GL_FORMAT_R8, .width = largest + 1, .height = 1, .layers = 2048};
    struct gl_texture *texture;
    assert_int_equal(gl_texture_create(device, &desc, &texture), PNB_ERROR_DEVICE);
    assert_null(texture);
    char expected[64];
    snprintf(expected, sizeof(expected), "texture: %dx1; this device has", largest + 1);
    assert_non_null(strstr(pnb_context_error(*state), expected));
    if (gl_device_get_info(device)->software) {
        desc = (struct gl_texture_desc){.kind = GL_TEXTURE_LAYERS,
                                        .format = GL_FORMAT_RGBA32F,
                                        .width = largest,
                                        .height = largest,
                                        .layers = 2048};
        assert_int_equal(gl_texture_create(device, &desc, &texture), PNB_ERROR_DEVICE);
        assert_non_null(strstr(pnb_context_error(*state), "the device has no room for it"));
    }
    must(*state, gl_device_end(device)); /* reported once */
    draw_half(*state, device);
    gl_device_destroy(device);
}

static void test_buffers(void **state)
{
    struct gl_device *device = open_device(*state, GL_DEVICE_API_BEST);
    must(*state, gl_device_begin(device));
    for (int stream = 0; stream < 2; stream++) {
        struct gl_buffer *buffer;
        int numbers[1000], back[1000];
        for (int i = 0; i < 1000; i++)
            numbers[i] = i * i;
        must(*state, gl_buffer_create(device, numbers, 40, stream, &buffer));
        must(*state, gl_buffer_write(buffer, numbers, sizeof(numbers)));
        must(*state, gl_buffer_write(buffer, numbers + 500, 80));
        assert_int_equal(gl_buffer_size(buffer), 80);
        must(*state, gl_buffer_read(buffer, 8, back, 72));
        assert_memory_equal(back, numbers + 502, 72);
        must(*state, gl_buffer_write(buffer, NULL, 0));
        gl_buffer_destroy(buffer);
    }
    must(*state, gl_device_end(device));
    gl_device_destroy(device);
}

/* The vertex shader of the depth maps, captured without rasterisation. */
static void test_capture(void **state)
{
    for (int api = GL_DEVICE_API_BEST; api <= GL_DEVICE_API_ES; api++) {
        struct gl_device *device = open_device(*state, (enum gl_device_api)api);
        must(*state, gl_device_begin(device));
        static const char *const captures[] = {"gl_Position"}, *const names[] = {"position"};
        struct gl_program_desc desc = {.vertex = "gl/depth_map.vert",
                                       .captures = captures,
                                       .capture_count = 1,
                                       .attributes = names,
                                       .attribute_count = 1};
        struct gl_program *program;
        struct gl_buffer *in, *out;
        must(*state, gl_program_create(device, &desc, &program));
        static const float points[9] = {1, 2, 3, 4, 5, 6, 7, 8, 9};
        static const double twice[16] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1};
        static const double one[3] = {1, 1, 1};
        float got[12];
        must(*state, gl_buffer_create(device, points, sizeof(points), false, &in));
        must(*state, gl_buffer_create(device, NULL, sizeof(got), true, &out));
        struct gl_draw draw = {
            .program = program,
            .count = 3,
            .attributes = {{in, 3}},
            .uniforms = {gl_vec3("center", one), gl_mat4("clip_from_relative", twice)},
            .capture = out,
            .capture_primitive = GL_PRIMITIVE_TRIANGLES,
            .discard = true};
        assert_int_equal(gl_draw_captured(device, &draw), 1);
        must(*state, gl_buffer_read(out, 0, got, sizeof(got)));
        for (int i = 0; i < 12; i++) {
            float expected = i % 4 == 3 ? 1 : 2 * (points[i / 4 * 3 + i % 4] - 1);
            assert_float_equal(got[i], expected, 0);
        }
        gl_buffer_destroy(in);
        gl_buffer_destroy(out);
        gl_program_destroy(program);
        must(*state, gl_device_end(device));
        gl_device_destroy(device);
    }
}

static void test_shader_errors(void **state)
{
    struct gl_device *device = open_device(*state, GL_DEVICE_API_BEST);
    must(*state, gl_device_begin(device));
    struct gl_program *program;
    /* Breaks a line of an included file. */
    struct gl_program_desc desc = {.vertex = "gl/cover.vert",
                                   .fragment = "method/sampled_maps/seen.frag",
                                   .defines = "#define map_texel +\n"};
    assert_int_equal(gl_program_create(device, &desc, &program), PNB_ERROR_DEVICE);
    assert_null(program);
    const char *said = pnb_context_error(*state);
    print_message("%s\n", said);
    int line = 0;
    assert_int_equal(sscanf(said, "shader: gl/depth_map.glsl:%d: ", &line), 1);
    FILE *file = NULL;
    if (getenv("PNB_SOURCE_DIR")) {
        char path[512], text[256] = "";
        snprintf(path, sizeof(path), "%s/src/gl/depth_map.glsl", getenv("PNB_SOURCE_DIR"));
        file = fopen(path, "r");
        for (int i = 0; file && i < line; i++)
            if (!fgets(text, sizeof(text), file))
                break;
        assert_non_null(strstr(text, "map_texel"));
    }
    if (file)
        fclose(file);
    desc = (struct gl_program_desc){.vertex = "gl/cover.vert", .fragment = "gl/none.frag"};
    assert_int_equal(gl_program_create(device, &desc, &program), PNB_ERROR_DEVICE);
    assert_non_null(strstr(pnb_context_error(*state), "no shader file 'gl/none.frag'"));
    must(*state, gl_device_end(device));
    gl_device_destroy(device);
}

/* ---- Occluders ---- */

static void load(pnb_context *context, const char *text, pnb_scene **scene)
{
    must(context, pnb_scene_parse(context, text, strlen(text), NULL, scene));
}

static void test_occluders(void **state)
{
    static const char *const names[] = {"spheres-3x3x3", "leaves", "light-in-solid", "room"};
    for (size_t n = 0; n < sizeof(names) / sizeof(*names); n++) {
        char path[64];
        snprintf(path, sizeof(path), "builtin:%s", names[n]);
        pnb_scene *scene;
        must(*state, pnb_scene_load(*state, path, &scene));
        struct gl_occluders *o;
        must(*state, gl_occluders_create(scene, true, &o));
        size_t uses = 0;
        for (size_t e = 0; e < o->edge_count; e++) {
            const struct gl_edge *edge = &o->edges[e];
            for (int k = 0; k < 2; k++) {
                uint32_t t = k == 0 ? edge->first : edge->second;
                if (t == MESH_NONE)
                    continue;
                uses++;
                const uint32_t *corner = o->indices + 3 * (size_t)t;
                uint32_t a = edge->a, b = edge->b;
                if (k == 1 && !edge->same_way)
                    a = edge->b, b = edge->a;
                assert_true((corner[0] == a && corner[1] == b) ||
                            (corner[1] == a && corner[2] == b) ||
                            (corner[2] == a && corner[0] == b));
            }
        }
        assert_int_equal(uses, 3 * o->triangle_count);
        for (size_t i = 0; i < o->object_count; i++)
            for (size_t e = 0; e < o->objects[i].edge_count && o->objects[i].closed; e++) {
                const struct gl_edge *edge = &o->edges[o->objects[i].first_edge + e];
                assert_true(edge->second != MESH_NONE && !edge->same_way);
            }
        gl_occluders_destroy(o);
        pnb_scene_destroy(scene);
    }
    /* A floor, a caster, and a mirrored one: outward planes all the same. */
    pnb_scene *scene;
    load(*state,
         "{\"lights\": [], \"objects\": [{\"name\": \"floor\", \"plane\": {\"half_size\": 4}},"
         "{\"name\": \"board\", \"plane\": {\"point\": [0, 1, 0], \"half_size\": 1}}]}",
         &scene);
    static const double mirrored[12] = {-1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1, 0};
    must(*state, pnb_scene_set_placement(scene, 1, mirrored));
    struct gl_occluders *o;
    must(*state, gl_occluders_create(scene, true, &o));
    assert_true(o->objects[0].floor && o->objects[0].floor_normal.y > 0.99);
    assert_true(o->objects[1].floor && o->objects[1].floor_normal.y < -0.99);
    for (size_t t = 0; t < o->triangle_count; t++)
        assert_float_equal(o->planes[4 * t + 1], 1, 1e-6);
    gl_occluders_destroy(o);
    pnb_scene_destroy(scene);
}

/* ---- The engine's door ---- */

enum { WIDTH = 160, HEIGHT = 120 };

/* What a caller may have set, by name of the query. */
struct snapshot {
    GLint integers[128];
    GLint units[20][4];
    GLfloat floats[32][4];
    GLint indexed[512];
};

static const GLenum integer_names[] = {GL_CURRENT_PROGRAM,
                                       GL_VERTEX_ARRAY_BINDING,
                                       GL_ARRAY_BUFFER_BINDING,
                                       GL_ELEMENT_ARRAY_BUFFER_BINDING,
                                       GL_DRAW_FRAMEBUFFER_BINDING,
                                       GL_READ_FRAMEBUFFER_BINDING,
                                       GL_RENDERBUFFER_BINDING,
                                       GL_PIXEL_PACK_BUFFER_BINDING,
                                       GL_PIXEL_UNPACK_BUFFER_BINDING,
                                       GL_ACTIVE_TEXTURE,
                                       GL_DEPTH_FUNC,
                                       GL_DEPTH_WRITEMASK,
                                       GL_CULL_FACE_MODE,
                                       GL_FRONT_FACE,
                                       GL_CULL_FACE,
                                       GL_DEPTH_TEST,
                                       GL_STENCIL_TEST,
                                       GL_POLYGON_OFFSET_FILL,
                                       GL_RASTERIZER_DISCARD,
                                       GL_DITHER,
                                       GL_SAMPLE_ALPHA_TO_COVERAGE,
                                       GL_SAMPLE_COVERAGE,
                                       GL_PRIMITIVE_RESTART,
                                       GL_PRIMITIVE_RESTART_FIXED_INDEX,
                                       GL_DEPTH_CLAMP,
                                       GL_COLOR_LOGIC_OP,
                                       GL_FRAMEBUFFER_SRGB,
                                       GL_POLYGON_SMOOTH,
                                       GL_LINE_SMOOTH,
                                       GL_SAMPLE_ALPHA_TO_ONE,
                                       GL_SAMPLE_MASK,
                                       GL_MULTISAMPLE,
                                       GL_PROGRAM_POINT_SIZE,
                                       GL_CLIP_DISTANCE0,
                                       GL_CLIP_DISTANCE3,
                                       GL_UNPACK_ALIGNMENT,
                                       GL_UNPACK_ROW_LENGTH,
                                       GL_UNPACK_SKIP_ROWS,
                                       GL_UNPACK_SKIP_PIXELS,
                                       GL_PACK_ALIGNMENT,
                                       GL_PACK_ROW_LENGTH,
                                       GL_PACK_SKIP_ROWS,
                                       GL_PACK_SKIP_PIXELS,
                                       GL_STENCIL_FUNC,
                                       GL_STENCIL_REF,
                                       GL_STENCIL_VALUE_MASK,
                                       GL_STENCIL_WRITEMASK,
                                       GL_STENCIL_FAIL,
                                       GL_STENCIL_PASS_DEPTH_FAIL,
                                       GL_STENCIL_PASS_DEPTH_PASS,
                                       GL_STENCIL_BACK_FUNC,
                                       GL_STENCIL_BACK_REF,
                                       GL_STENCIL_BACK_VALUE_MASK,
                                       GL_STENCIL_BACK_WRITEMASK,
                                       GL_STENCIL_BACK_FAIL,
                                       GL_STENCIL_BACK_PASS_DEPTH_FAIL,
                                       GL_STENCIL_BACK_PASS_DEPTH_PASS,
                                       GL_TRANSFORM_FEEDBACK_BUFFER_BINDING,
                                       GL_TRANSFORM_FEEDBACK_BINDING,
                                       GL_UNIFORM_BUFFER_BINDING,
                                       GL_LOGIC_OP_MODE,
                                       GL_PROVOKING_VERTEX,
                                       GL_CLIP_ORIGIN,
                                       GL_CLIP_DEPTH_MODE,
                                       GL_PRIMITIVE_RESTART_INDEX,
                                       GL_STENCIL_CLEAR_VALUE,
                                       GL_UNPACK_SWAP_BYTES,
                                       GL_PACK_SWAP_BYTES,
                                       GL_PROGRAM_PIPELINE_BINDING};
static const GLenum float_names[] = {
    GL_POLYGON_OFFSET_FACTOR, GL_POLYGON_OFFSET_UNITS, GL_BLEND_COLOR, GL_COLOR_CLEAR_VALUE,
    GL_DEPTH_CLEAR_VALUE,     GL_LINE_WIDTH,           GL_POINT_SIZE,  GL_SAMPLE_COVERAGE_VALUE};

static void take(struct snapshot *s)
{
    memset(s, 0, sizeof(*s));
    for (size_t i = 0; i < sizeof(integer_names) / sizeof(*integer_names); i++)
        glGetIntegerv(integer_names[i], &s->integers[i]);
    GLint mode[2];
    glGetIntegerv(GL_POLYGON_MODE, mode);
    s->integers[127] = mode[0];
    for (size_t i = 0; i < sizeof(float_names) / sizeof(*float_names); i++)
        glGetFloatv(float_names[i], s->floats[i]);
    GLint active;
    glGetIntegerv(GL_ACTIVE_TEXTURE, &active);
    for (GLuint i = 0; i < 20; i++) {
        glActiveTexture(GL_TEXTURE0 + i);
        glGetIntegerv(GL_TEXTURE_BINDING_2D, &s->units[i][0]);
        glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &s->units[i][1]);
        glGetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &s->units[i][2]);
        glGetIntegerv(GL_SAMPLER_BINDING, &s->units[i][3]);
    }
    glActiveTexture((GLenum)active);
    GLint *at = s->indexed;
    for (GLuint i = 0; i < 8; i++) {
        GLboolean mask[4];
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, mask);
        for (int k = 0; k < 4; k++)
            *at++ = mask[k];
        *at++ = glIsEnabledi(GL_BLEND, i);
        static const GLenum blends[] = {GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA,
                                        GL_BLEND_SRC_RGB,      GL_BLEND_DST_RGB,
                                        GL_BLEND_SRC_ALPHA,    GL_BLEND_DST_ALPHA};
        for (int k = 0; k < 6; k++)
            glGetIntegeri_v(blends[k], i, at++);
    }
    for (GLuint i = 0; i < 16; i++) {
        glGetIntegeri_v(GL_VIEWPORT, i, at);
        glGetIntegeri_v(GL_SCISSOR_BOX, i, at + 4);
        at[8] = glIsEnabledi(GL_SCISSOR_TEST, i);
        GLfloat range[2];
        glGetFloati_v(GL_DEPTH_RANGE, i, range);
        at[9] = (GLint)(range[0] * 1e6f);
        at[10] = (GLint)(range[1] * 1e6f);
        at += 11;
    }
}

static void same(const struct snapshot *a, const struct snapshot *b)
{
    for (size_t i = 0; i < 128; i++)
        if (a->integers[i] != b->integers[i])
            fail_msg("state %#x was %d and is %d", i < 127 ? integer_names[i] : GL_POLYGON_MODE,
                     a->integers[i], b->integers[i]);
    assert_memory_equal(a->units, b->units, sizeof(a->units));
    assert_memory_equal(a->floats, b->floats, sizeof(a->floats));
    assert_memory_equal(a->indexed, b->indexed, sizeof(a->indexed));
}

/* Everything that draws would trip over. */
static void set_odd_state(GLuint names[16])
{
    glGenTextures(3, names);
    glGenBuffers(3, names + 3);
    glGenVertexArrays(1, names + 6);
    glGenFramebuffers(1, names + 7);
    glGenSamplers(1, names + 8);
    glGenRenderbuffers(1, names + 9);
    glGenTransformFeedbacks(1, names + 10);
    glBindVertexArray(names[6]);
    glBindBuffer(GL_ARRAY_BUFFER, names[3]);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, names[4]);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, names[5]);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, names[5]);
    glBindRenderbuffer(GL_RENDERBUFFER, names[9]);
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, names[10]);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, names[3]);
    for (GLuint i = 0; i < 5; i++) {
        glActiveTexture(GL_TEXTURE0 + i);
        glBindTexture(GL_TEXTURE_2D, names[0]);
        glBindTexture(GL_TEXTURE_2D_ARRAY, names[1]);
        glBindTexture(GL_TEXTURE_CUBE_MAP, names[2]);
        glBindSampler(i, names[8]);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, names[7]);
    static const GLenum on[] = {GL_CULL_FACE,
                                GL_DEPTH_TEST,
                                GL_STENCIL_TEST,
                                GL_POLYGON_OFFSET_FILL,
                                GL_RASTERIZER_DISCARD,
                                GL_SAMPLE_ALPHA_TO_COVERAGE,
                                GL_SAMPLE_COVERAGE,
                                GL_PRIMITIVE_RESTART,
                                GL_DEPTH_CLAMP,
                                GL_COLOR_LOGIC_OP,
                                GL_FRAMEBUFFER_SRGB,
                                GL_SAMPLE_MASK,
                                GL_PROGRAM_POINT_SIZE,
                                GL_CLIP_DISTANCE0,
                                GL_CLIP_DISTANCE3,
                                GL_SCISSOR_TEST,
                                GL_BLEND};
    for (size_t i = 0; i < sizeof(on) / sizeof(*on); i++)
        glEnable(on[i]);
    glLogicOp(GL_INVERT);
    glPrimitiveRestartIndex(2);
    glPolygonMode(GL_FRONT_AND_BACK, GL_LINE);
    glPolygonOffset(3, 4);
    glCullFace(GL_FRONT_AND_BACK);
    glFrontFace(GL_CW);
    glDepthFunc(GL_NEVER);
    glDepthMask(GL_FALSE);
    glDepthRangef(0.25f, 0.5f);
    glClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
    glStencilFuncSeparate(GL_FRONT, GL_NEVER, 3, 5);
    glStencilFuncSeparate(GL_BACK, GL_LESS, 1, 7);
    glStencilOpSeparate(GL_BACK, GL_INVERT, GL_ZERO, GL_INCR);
    glStencilMaskSeparate(GL_BACK, 6);
    glColorMaski(0, GL_FALSE, GL_TRUE, GL_FALSE, GL_TRUE);
    glDisablei(GL_BLEND, 2);
    glBlendFuncSeparatei(1, GL_DST_COLOR, GL_ONE_MINUS_DST_ALPHA, GL_ZERO, GL_ONE);
    glBlendEquationi(3, GL_MAX);
    glViewportIndexedf(1, 3, 4, 5, 6);
    glViewportIndexedf(0, 1, 2, 3, 4);
    glScissorIndexed(2, 7, 8, 9, 10);
    glScissorIndexed(0, 1, 1, 1, 1);
    glClearColor(1, 2, 3, 4);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 1000);
    glPixelStorei(GL_UNPACK_SKIP_ROWS, 3);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 2);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 8);
    glPixelStorei(GL_UNPACK_SWAP_BYTES, 1);
}

static void set_plain_state(const GLuint names[16])
{
    static const GLenum off[] = {GL_CULL_FACE,
                                 GL_STENCIL_TEST,
                                 GL_POLYGON_OFFSET_FILL,
                                 GL_RASTERIZER_DISCARD,
                                 GL_SAMPLE_ALPHA_TO_COVERAGE,
                                 GL_SAMPLE_COVERAGE,
                                 GL_PRIMITIVE_RESTART,
                                 GL_DEPTH_CLAMP,
                                 GL_COLOR_LOGIC_OP,
                                 GL_FRAMEBUFFER_SRGB,
                                 GL_SAMPLE_MASK,
                                 GL_CLIP_DISTANCE0,
                                 GL_CLIP_DISTANCE3,
                                 GL_SCISSOR_TEST,
                                 GL_BLEND};
    for (size_t i = 0; i < sizeof(off) / sizeof(*off); i++)
        glDisable(off[i]);
    glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    glFrontFace(GL_CCW);
    glDepthMask(GL_TRUE);
    glDepthRangef(0, 1);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    glColorMask(1, 1, 1, 1);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
    glPixelStorei(GL_UNPACK_SKIP_ROWS, 0);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
    glPixelStorei(GL_UNPACK_SWAP_BYTES, 0);
    for (GLuint i = 0; i < 5; i++)
        glBindSampler(i, 0);
    glActiveTexture(GL_TEXTURE0);
    glDeleteTextures(3, names);
    glDeleteBuffers(3, names + 3);
    glDeleteVertexArrays(1, names + 6);
    glDeleteFramebuffers(1, names + 7);
    glDeleteSamplers(1, names + 8);
    glDeleteRenderbuffers(1, names + 9);
    glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
    glDeleteTransformFeedbacks(1, names + 10);
}

/* The scene's depth as an engine would draw it: its own program, its own projection. */
struct engine {
    GLuint depth, visibility, framebuffer;
    pnb_gl_view view;
};

static const char engine_vertex[] = "#version 330 core\nin vec3 position; uniform mat4 m;\n"
                                    "void main() { gl_Position = m * vec4(position, 1.0); }\n";
static const char engine_fragment[] = "#version 330 core\nvoid main() {}\n";

static void multiply(const double a[16], const double b[16], float out[16])
{
    for (int c = 0; c < 4; c++)
        for (int r = 0; r < 4; r++) {
            double sum = 0;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + r] * b[4 * c + k];
            out[4 * c + r] = (float)sum;
        }
}

enum { MODE_PLAIN, MODE_ZERO_TO_ONE, MODE_REVERSED, MODES };

static void project(const pnb_camera *camera, int mode, float clip_from_world[16])
{
    vec3 eye = v3_load(camera->eye);
    vec3 f = v3_normalize(v3_sub(v3_load(camera->target), eye));
    vec3 r = v3_normalize(v3_cross(f, v3_load(camera->up))), u = v3_cross(r, f);
    double view[16] = {r.x,
                       u.x,
                       -f.x,
                       0,
                       r.y,
                       u.y,
                       -f.y,
                       0,
                       r.z,
                       u.z,
                       -f.z,
                       0,
                       -v3_dot(r, eye),
                       -v3_dot(u, eye),
                       v3_dot(f, eye),
                       1};
    double near_m = 0.5, far_m = 100, t = tan(camera->vertical_fov_degrees * M_PI / 360);
    double projection[16] = {
        1 / (t * WIDTH / HEIGHT), 0, 0, 0, 0, 1 / t, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0};
    if (mode == MODE_REVERSED) {
        projection[14] = near_m; /* far at infinity */
    } else if (mode == MODE_ZERO_TO_ONE) {
        projection[10] = -far_m / (far_m - near_m);
        projection[14] = -far_m * near_m / (far_m - near_m);
    } else {
        projection[10] = -(far_m + near_m) / (far_m - near_m);
        projection[14] = -2 * far_m * near_m / (far_m - near_m);
    }
    multiply(projection, view, clip_from_world);
}

static void engine_draw(pnb_scene *scene, int mode, struct engine *engine)
{
    pnb_camera camera;
    pnb_scene_camera(scene, &camera);
    memset(engine, 0, sizeof(*engine));
    project(&camera, mode, engine->view.clip_from_world);
    engine->view.clip_zero_to_one = mode != MODE_PLAIN;
    engine->view.depth_reversed = mode == MODE_REVERSED;

    GLuint program = glCreateProgram(), array, buffers[2];
    const char *sources[2] = {engine_vertex, engine_fragment};
    for (int i = 0; i < 2; i++) {
        GLuint shader = glCreateShader(i ? GL_FRAGMENT_SHADER : GL_VERTEX_SHADER);
        glShaderSource(shader, 1, &sources[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glBindAttribLocation(program, 0, "position");
    glLinkProgram(program);
    glGenTextures(1, &engine->depth);
    glBindTexture(GL_TEXTURE_2D, engine->depth);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, WIDTH, HEIGHT, 0, GL_DEPTH_COMPONENT,
                 GL_FLOAT, NULL);
    /* As engines leave them: comparing, no mipmaps, filtered. */
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    glGenTextures(1, &engine->visibility);
    glBindTexture(GL_TEXTURE_2D, engine->visibility);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, WIDTH, HEIGHT, 0, GL_RED, GL_FLOAT, NULL);
    glBindTexture(GL_TEXTURE_2D, 0);
    glGenFramebuffers(1, &engine->framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, engine->framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, engine->depth, 0);
    glDrawBuffer(GL_NONE);
    glReadBuffer(GL_NONE);
    assert_int_equal(glCheckFramebufferStatus(GL_FRAMEBUFFER), GL_FRAMEBUFFER_COMPLETE);
    glClipControl(GL_LOWER_LEFT, mode == MODE_PLAIN ? GL_NEGATIVE_ONE_TO_ONE : GL_ZERO_TO_ONE);
    glViewport(0, 0, WIDTH, HEIGHT);
    glEnable(GL_DEPTH_TEST);
    glDepthMask(GL_TRUE);
    glDepthFunc(mode == MODE_REVERSED ? GL_GREATER : GL_LESS);
    glClearDepth(mode == MODE_REVERSED ? 0 : 1);
    glClear(GL_DEPTH_BUFFER_BIT);
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glEnableVertexAttribArray(0);
    glUseProgram(program);
    for (size_t i = 0; i < pnb_scene_object_count(scene); i++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(scene, i, &object);
        pnb_scene_mesh(scene, object.mesh, &mesh);
        const double *w = object.world_from_mesh;
        double world[16], clip[16];
        for (int c = 0; c < 4; c++)
            for (int r = 0; r < 4; r++)
                world[4 * c + r] = r < 3 ? w[4 * r + c] : c == 3;
        float matrix[16];
        for (int k = 0; k < 16; k++)
            clip[k] = engine->view.clip_from_world[k];
        multiply(clip, world, matrix);
        glUniformMatrix4fv(glGetUniformLocation(program, "m"), 1, GL_FALSE, matrix);
        glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(mesh.vertex_count * 12), mesh.positions,
                     GL_STREAM_DRAW);
        glBufferData(GL_ELEMENT_ARRAY_BUFFER, (GLsizeiptr)(mesh.triangle_count * 12), mesh.indices,
                     GL_STREAM_DRAW);
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
        glDrawElements(GL_TRIANGLES, (GLsizei)(mesh.triangle_count * 3), GL_UNSIGNED_INT, NULL);
    }
    glUseProgram(0);
    glBindVertexArray(0);
    glDeleteProgram(program);
    glDeleteVertexArrays(1, &array);
    glDeleteBuffers(2, buffers);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    engine->view.depth_texture = engine->depth;
    assert_int_equal(glGetError(), GL_NO_ERROR);
}

static void engine_finish(struct engine *engine)
{
    glDeleteFramebuffers(1, &engine->framebuffer);
    glDeleteTextures(1, &engine->depth);
    glDeleteTextures(1, &engine->visibility);
}

/* RMSE between the door's texture and the CPU door's picture, and the shares of pixels that are
 * wrong, and that differ at all. */
static double compare(const float *texture, const float *cpu, double *out_wrong, double *out_differ)
{
    double sum = 0, count = 0, wrong = 0, differ = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double a = texture[(HEIGHT - 1 - y) * WIDTH + x], b = cpu[y * WIDTH + x];
            if (isnan(b)) {
                b = 1;
            }
            sum += (a - b) * (a - b);
            wrong += fabs(a - b) > 0.25;
            differ += fabs(a - b) > 0.004;
            count++;
        }
    *out_wrong = wrong / count;
    *out_differ = differ / count;
    return sqrt(sum / count);
}

/* Around the receivers. */
static void box_of(const pnb_receivers *receivers, pnb_gl_view *view)
{
    for (int c = 0; c < 3; c++) {
        view->low[c] = INFINITY;
        view->high[c] = -INFINITY;
        for (size_t i = 0; i < receivers->count; i++) {
            float p = receivers->positions[3 * i + (size_t)c];
            view->low[c] = fminf(view->low[c], p);
            view->high[c] = fmaxf(view->high[c], p);
        }
    }
}

static void test_engine(void **state)
{
    pnb_context *context = *state;
    struct gl_device *device = open_device(context, GL_DEVICE_API_BEST);
    if (gl_device_get_info(device)->version < 45)
        skip();
    static const char *const scenes[] = {"two-boxes", "disk", "complex"};
    static float cpu[WIDTH * HEIGHT], got[WIDTH * HEIGHT];
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++) {
        char path[64];
        snprintf(path, sizeof(path), "builtin:%s", scenes[s]);
        pnb_scene *scene;
        pnb_surface *surface;
        pnb_receivers receivers;
        pnb_light light;
        must(context, pnb_scene_load(context, path, &scene));
        must(context, pnb_surface_create(context, scene, NULL, WIDTH, HEIGHT, &surface));
        pnb_surface_receivers(surface, &receivers);
        pnb_scene_light(scene, 0, &light);
        for (size_t m = 0; m < pnb_method_count(); m++) {
            const pnb_method_info *info = pnb_method(m);
            if (!(info->processor == PNB_PROCESSOR_OPENGL || info->opengl_path) ||
                !(info->lights & PNB_LIGHT_BIT(light.type)))
                continue;
            pnb_solver_param on_opengl = {"path", "opengl"};
            pnb_solver_desc desc = {.method = info->name,
                                    .params = &on_opengl,
                                    .param_count = info->opengl_path ? 1 : 0};
            pnb_solver *solver;
            must(context, pnb_solver_create(context, scene, &desc, &solver));
            must(context, pnb_solver_visibility(solver, &light, &receivers, cpu));
            pnb_solver_destroy(solver);

            must(context, gl_device_begin(device));
            for (int mode = MODE_PLAIN; mode < MODES; mode++) {
                struct engine engine;
                GLuint names[16];
                struct snapshot before, after;
                engine_draw(scene, mode, &engine);
                set_odd_state(names);
                assert_int_equal(glGetError(), GL_NO_ERROR);
                take(&before);
                must(context, pnb_gl_solver_create(context, scene, &desc, &solver));
                take(&after);
                same(&before, &after);
                must(context,
                     pnb_gl_solver_visibility(solver, &light, &engine.view, engine.visibility));
                take(&after);
                same(&before, &after);
                must(context,
                     pnb_gl_solver_visibility(solver, &light, &engine.view, engine.visibility));
                pnb_solver_destroy(solver);
                take(&after);
                same(&before, &after);
                assert_int_equal(glGetError(), GL_NO_ERROR);
                set_plain_state(names);
                glBindTexture(GL_TEXTURE_2D, engine.visibility);
                glPixelStorei(GL_PACK_ALIGNMENT, 1);
                glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_FLOAT, got);
                double wrong, differ, rmse = compare(got, cpu, &wrong, &differ);
                print_message("%s %s mode %d: rmse %.4f, wrong %.4f, differ %.4f\n", scenes[s],
                              info->name, mode, rmse, wrong, differ);
                assert_true(wrong < 0.02);

                /* With a box around what is seen: at least as near to the CPU door's. */
                if (mode == MODE_REVERSED) {
                    box_of(&receivers, &engine.view);
                    must(context, pnb_gl_solver_create(context, scene, &desc, &solver));
                    must(context,
                         pnb_gl_solver_visibility(solver, &light, &engine.view, engine.visibility));
                    pnb_solver_destroy(solver);
                    glBindTexture(GL_TEXTURE_2D, engine.visibility);
                    glGetTexImage(GL_TEXTURE_2D, 0, GL_RED, GL_FLOAT, got);
                    double boxed_wrong, boxed_differ;
                    compare(got, cpu, &boxed_wrong, &boxed_differ);
                    print_message("in a box: wrong %.4f, differ %.4f\n", boxed_wrong, boxed_differ);
                    assert_true(boxed_wrong <= wrong + 0.0005 && boxed_differ <= differ + 0.0005);
                }
                engine_finish(&engine);
            }
            must(context, gl_device_end(device));
        }
        pnb_surface_destroy(surface);
        pnb_scene_destroy(scene);
    }
    gl_device_destroy(device);
}

/* Every method's shaders compile for OpenGL ES too, and make the same picture there: receivers come
 * from a plain depth texture that holds one depth. */
static void test_es(void **state)
{
    pnb_context *context = *state;
    pnb_scene *scene;
    pnb_light light;
    must(context, pnb_scene_load(context, "builtin:disk", &scene));
    pnb_scene_light(scene, 0, &light);
    static float got[2][WIDTH * HEIGHT], depths[WIDTH * HEIGHT];
    for (size_t i = 0; i < WIDTH * HEIGHT; i++)
        depths[i] = 0.93f;
    for (size_t m = 0; m < pnb_method_count(); m++) {
        const pnb_method_info *info = pnb_method(m);
        if (!(info->processor == PNB_PROCESSOR_OPENGL || info->opengl_path) ||
            !(info->lights & PNB_LIGHT_BIT(light.type)))
            continue;
        for (int es = 0; es < 2; es++) {
            struct gl_device *device =
                open_device(context, es ? GL_DEVICE_API_ES : GL_DEVICE_API_BEST);
            must(context, gl_device_begin(device));
            pnb_camera camera;
            pnb_solver *solver;
            pnb_gl_view view = {0};
            pnb_scene_camera(scene, &camera);
            project(&camera, MODE_PLAIN, view.clip_from_world);
            GLuint textures[2];
            glGenTextures(2, textures);
            glBindTexture(GL_TEXTURE_2D, textures[0]);
            glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, WIDTH, HEIGHT, 0,
                         GL_DEPTH_COMPONENT, GL_FLOAT, depths);
            glBindTexture(GL_TEXTURE_2D, textures[1]);
            glTexImage2D(GL_TEXTURE_2D, 0, GL_R32F, WIDTH, HEIGHT, 0, GL_RED, GL_FLOAT, NULL);
            view.depth_texture = textures[0];
            must(context, pnb_gl_solver_create(context, scene,
                                               &(pnb_solver_desc){.method = info->name}, &solver));
            must(context, pnb_gl_solver_visibility(solver, &light, &view, textures[1]));
            pnb_solver_destroy(solver);
            struct gl_texture *texture;
            must(context,
                 gl_texture_adopt(device, textures[1], GL_FORMAT_R32F, WIDTH, HEIGHT, &texture));
            must(context, gl_texture_read(texture, 0, got[es]));
            gl_texture_destroy(texture);
            glDeleteTextures(2, textures);
            must(context, gl_device_end(device));
            gl_device_destroy(device);
        }
        size_t differing = 0;
        for (size_t i = 0; i < WIDTH * HEIGHT; i++)
            differing += fabsf(got[0][i] - got[1][i]) > 0.02f;
        print_message("%s: %zu pixels differ on ES\n", info->name, differing);
        assert_true(differing < WIDTH * HEIGHT / 200);
    }
    pnb_scene_destroy(scene);
}

/* What a caller can get wrong, each with a word about it. */
static void test_engine_errors(void **state)
{
    pnb_context *context = *state;
    struct gl_device *device = open_device(context, GL_DEVICE_API_BEST);
    pnb_scene *scene;
    pnb_solver *solver;
    pnb_light light;
    pnb_solver_desc desc = {.method = "hard-volume"};
    must(context, pnb_scene_load(context, "builtin:prism", &scene));
    pnb_scene_light(scene, 0, &light);
    assert_int_equal(pnb_gl_solver_create(context, scene, &desc, &solver), PNB_ERROR_DEVICE);
    assert_non_null(strstr(pnb_context_error(context), "no context is current"));

    must(context, gl_device_begin(device));
    pnb_solver_desc cpu = {.method = "exact"};
    assert_int_equal(pnb_gl_solver_create(context, scene, &cpu, &solver), PNB_ERROR_ARGUMENT);
    must(context, pnb_gl_solver_create(context, scene, &desc, &solver));
    struct engine engine;
    engine_draw(scene, MODE_PLAIN, &engine);
    pnb_gl_view view = engine.view;
    view.depth_texture = engine.visibility;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    assert_non_null(strstr(pnb_context_error(context), "depth_texture: has no depth"));
    view.depth_texture = 12345;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    view = engine.view;
    view.x = 1;
    view.width = WIDTH, view.height = HEIGHT;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    view.width = 16, view.height = 16;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    assert_non_null(strstr(pnb_context_error(context), "visibility_texture: 160x120 texels"));
    view = engine.view;
    memset(view.clip_from_world, 0, sizeof(view.clip_from_world));
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    view.clip_from_world[0] = view.clip_from_world[5] = view.clip_from_world[10] =
        view.clip_from_world[15] = 1; /* orthographic */
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    assert_non_null(strstr(pnb_context_error(context), "perspective"));
    view = engine.view;
    view.high[1] = -1;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    view.high[1] = NAN;
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &view, engine.visibility),
                     PNB_ERROR_ARGUMENT);
    assert_non_null(strstr(pnb_context_error(context), "low, high: no box"));
    must(context, pnb_gl_solver_visibility(solver, &light, &engine.view, engine.visibility));
    assert_int_equal(glGetError(), GL_NO_ERROR);
    must(context, gl_device_end(device));

    /* Another context, then none. */
    assert_int_equal(pnb_gl_solver_visibility(solver, &light, &engine.view, engine.visibility),
                     PNB_ERROR_DEVICE);
    pnb_solver_destroy(solver);
    pnb_scene_destroy(scene);
    gl_device_destroy(device);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_device, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_two_devices, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_threads, create_context, destroy_context),
        cmocka_unit_test(test_no_device),
        cmocka_unit_test_setup_teardown(test_textures, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_no_room, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_buffers, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_capture, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_shader_errors, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_occluders, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_engine, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_es, create_context, destroy_context),
        cmocka_unit_test_setup_teardown(test_engine_errors, create_context, destroy_context),
    };
    return cmocka_run_group_tests_name("gl", tests, NULL, NULL);
}
