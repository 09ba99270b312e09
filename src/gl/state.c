/* gl/state.c: the state of a caller's context, noted before we draw and given back after.
 *
 * Noted is everything that the files of this folder change; state.c and they are to be read
 * together. Not touched at all: uniform, storage and image buffers, program pipelines, queries
 * (but a caller's own query for written primitives must not be active), hints.
 */
#include "gl/inside.h"

#define DRAW_BUFFERS 8
#define VIEWPORTS    16

static const GLenum switches[] = {
    GL_CULL_FACE,
    GL_DEPTH_TEST,
    GL_STENCIL_TEST,
    GL_POLYGON_OFFSET_FILL,
    GL_RASTERIZER_DISCARD,
    GL_DITHER,
    GL_SAMPLE_ALPHA_TO_COVERAGE,
    GL_SAMPLE_COVERAGE,
    GL_PRIMITIVE_RESTART_FIXED_INDEX,
    /* OpenGL ES has none of those that follow. */
    GL_DEPTH_CLAMP,
    GL_COLOR_LOGIC_OP,
    GL_FRAMEBUFFER_SRGB,
    GL_PRIMITIVE_RESTART,
    GL_POLYGON_SMOOTH,
    GL_LINE_SMOOTH,
    GL_SAMPLE_ALPHA_TO_ONE,
    GL_SAMPLE_MASK,
    GL_MULTISAMPLE,
    GL_PROGRAM_POINT_SIZE,
    GL_CLIP_DISTANCE0,
    GL_CLIP_DISTANCE1,
    GL_CLIP_DISTANCE2,
    GL_CLIP_DISTANCE3,
    GL_CLIP_DISTANCE4,
    GL_CLIP_DISTANCE5,
    GL_CLIP_DISTANCE6,
    GL_CLIP_DISTANCE7,
};
#define SWITCHES    ((int)(sizeof(switches) / sizeof(*switches)))
#define ES_SWITCHES 9

static const GLenum pixel_stores[] = {
    GL_UNPACK_ALIGNMENT,
    GL_UNPACK_ROW_LENGTH,
    GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS,
    GL_UNPACK_IMAGE_HEIGHT,
    GL_UNPACK_SKIP_IMAGES,
    GL_PACK_ALIGNMENT,
    GL_PACK_ROW_LENGTH,
    GL_PACK_SKIP_ROWS,
    GL_PACK_SKIP_PIXELS,
    /* Not in OpenGL ES. */
    GL_UNPACK_SWAP_BYTES,
    GL_UNPACK_LSB_FIRST,
    GL_PACK_SWAP_BYTES,
    GL_PACK_LSB_FIRST,
    GL_PACK_IMAGE_HEIGHT,
    GL_PACK_SKIP_IMAGES,
};
#define PIXEL_STORES    ((int)(sizeof(pixel_stores) / sizeof(*pixel_stores)))
#define ES_PIXEL_STORES 10

struct stencil {
    GLint func, reference, read, write, fail, depth_fail, pass;
};

struct gl_state {
    GLboolean switches[SWITCHES];
    GLint pixel_stores[PIXEL_STORES];
    GLint program, vertex_array, array_buffer, draw_framebuffer, read_framebuffer, renderbuffer;
    GLint pack_buffer, unpack_buffer, active_texture;
    GLint feedback, feedback_buffer, feedback_buffer_0;
    GLint64 feedback_start, feedback_size;
    GLfloat viewports[VIEWPORTS][4], depth_range[VIEWPORTS][2];
    GLint scissors[VIEWPORTS][4];
    GLboolean scissor_on[VIEWPORTS];
    int viewport_count, draw_buffer_count;
    GLboolean depth_mask, color_masks[DRAW_BUFFERS][4], blend_on[DRAW_BUFFERS];
    GLint depth_func, blends[DRAW_BUFFERS][6];
    GLint cull_mode, front_face, polygon_mode[2], clip_origin, clip_depth;
    GLfloat offset_factor, offset_units, offset_clamp, depth_bounds[2];
    GLboolean depth_bounds_on;
    struct stencil stencil[2];
    struct {
        bool saved;
        GLint plane, layers, faces, sampler;
    } units[GL_UNITS];
};

static bool at_least(const struct gl_device *device, int desktop, int es)
{
    return device->info.version >= (device->info.es ? es : desktop);
}

static bool has_switch(const struct gl_device *device, int i)
{
    if (switches[i] == GL_PRIMITIVE_RESTART_FIXED_INDEX)
        return at_least(device, 43, 30);
    if (switches[i] == GL_SAMPLE_MASK)
        return at_least(device, 32, 31);
    if (switches[i] == GL_DEPTH_CLAMP)
        return device->info.depth_clamp;
    return i < ES_SWITCHES || !device->info.es;
}

static bool has_pixel_store(const struct gl_device *device, int i)
{
    return i < ES_PIXEL_STORES || !device->info.es;
}

static void set_switch(GLenum what, bool on)
{
    if (on)
        glEnable(what);
    else
        glDisable(what);
}

void gl_state_baseline(const struct gl_device *device)
{
    for (int i = 0; i < SWITCHES; i++)
        if (has_switch(device, i))
            glDisable(switches[i]);
    for (int i = 0; i < PIXEL_STORES; i++)
        if (has_pixel_store(device, i))
            glPixelStorei(pixel_stores[i], pixel_stores[i] == GL_UNPACK_ALIGNMENT ||
                                                   pixel_stores[i] == GL_PACK_ALIGNMENT
                                               ? 1
                                               : 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
    glFrontFace(GL_CCW);
    glDepthRangef(0, 1);
    if (!device->info.es)
        glPolygonMode(GL_FRONT_AND_BACK, GL_FILL);
    if (!device->info.es && device->info.version >= 45)
        glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    if (!device->info.es && device->info.version >= 46)
        glPolygonOffsetClamp(0, 0, 0);
    if (device->info.depth_bounds)
        glDisable(GL_DEPTH_BOUNDS_TEST_EXT);
}

static void save_views(struct gl_device *device, struct gl_state *s)
{
    s->viewport_count = !device->info.es && device->info.version >= 41 ? VIEWPORTS : 1;
    if (s->viewport_count == 1) {
        glGetFloatv(GL_VIEWPORT, s->viewports[0]);
        glGetIntegerv(GL_SCISSOR_BOX, s->scissors[0]);
        glGetFloatv(GL_DEPTH_RANGE, s->depth_range[0]);
        s->scissor_on[0] = glIsEnabled(GL_SCISSOR_TEST);
        return;
    }
    for (GLuint i = 0; i < VIEWPORTS; i++) {
        glGetFloati_v(GL_VIEWPORT, i, s->viewports[i]);
        glGetIntegeri_v(GL_SCISSOR_BOX, i, s->scissors[i]);
        glGetFloati_v(GL_DEPTH_RANGE, i, s->depth_range[i]);
        s->scissor_on[i] = glIsEnabledi(GL_SCISSOR_TEST, i);
    }
}

static void restore_views(const struct gl_state *s)
{
    if (s->viewport_count == 1) {
        glViewport((GLint)s->viewports[0][0], (GLint)s->viewports[0][1],
                   (GLsizei)s->viewports[0][2], (GLsizei)s->viewports[0][3]);
        glScissor(s->scissors[0][0], s->scissors[0][1], s->scissors[0][2], s->scissors[0][3]);
        glDepthRangef(s->depth_range[0][0], s->depth_range[0][1]);
        set_switch(GL_SCISSOR_TEST, s->scissor_on[0]);
        return;
    }
    for (GLuint i = 0; i < VIEWPORTS; i++) {
        glViewportIndexedfv(i, s->viewports[i]);
        glScissorIndexedv(i, s->scissors[i]);
        glDepthRangeIndexed(i, (GLdouble)s->depth_range[i][0], (GLdouble)s->depth_range[i][1]);
        if (s->scissor_on[i])
            glEnablei(GL_SCISSOR_TEST, i);
        else
            glDisablei(GL_SCISSOR_TEST, i);
    }
}

static const GLenum blend_names[6] = {GL_BLEND_EQUATION_RGB, GL_BLEND_EQUATION_ALPHA,
                                      GL_BLEND_SRC_RGB,      GL_BLEND_DST_RGB,
                                      GL_BLEND_SRC_ALPHA,    GL_BLEND_DST_ALPHA};

static void save_colors(struct gl_device *device, struct gl_state *s)
{
    GLint most = 1;
    glGetIntegerv(GL_MAX_DRAW_BUFFERS, &most);
    s->draw_buffer_count = most < DRAW_BUFFERS ? most : DRAW_BUFFERS;
    for (GLuint i = 0; i < (GLuint)s->draw_buffer_count; i++) {
        glGetBooleani_v(GL_COLOR_WRITEMASK, i, s->color_masks[i]);
        s->blend_on[i] = glIsEnabledi(GL_BLEND, i);
        for (int k = 0; k < 6; k++)
            if (at_least(device, 40, 32))
                glGetIntegeri_v(blend_names[k], i, &s->blends[i][k]);
            else if (i == 0)
                glGetIntegerv(blend_names[k], &s->blends[0][k]);
    }
}

static void restore_colors(struct gl_device *device, const struct gl_state *s)
{
    for (GLuint i = 0; i < (GLuint)s->draw_buffer_count; i++) {
        const GLboolean *mask = s->color_masks[i];
        const GLint *b = s->blends[i];
        glColorMaski(i, mask[0], mask[1], mask[2], mask[3]);
        if (s->blend_on[i])
            glEnablei(GL_BLEND, i);
        else
            glDisablei(GL_BLEND, i);
        if (at_least(device, 40, 32)) {
            glBlendEquationSeparatei(i, (GLenum)b[0], (GLenum)b[1]);
            glBlendFuncSeparatei(i, (GLenum)b[2], (GLenum)b[3], (GLenum)b[4], (GLenum)b[5]);
        } else if (i == 0) {
            glBlendEquationSeparate((GLenum)b[0], (GLenum)b[1]);
            glBlendFuncSeparate((GLenum)b[2], (GLenum)b[3], (GLenum)b[4], (GLenum)b[5]);
        }
    }
}

static const GLenum stencil_names[2][7] = {
    {GL_STENCIL_FUNC, GL_STENCIL_REF, GL_STENCIL_VALUE_MASK, GL_STENCIL_WRITEMASK, GL_STENCIL_FAIL,
     GL_STENCIL_PASS_DEPTH_FAIL, GL_STENCIL_PASS_DEPTH_PASS},
    {GL_STENCIL_BACK_FUNC, GL_STENCIL_BACK_REF, GL_STENCIL_BACK_VALUE_MASK,
     GL_STENCIL_BACK_WRITEMASK, GL_STENCIL_BACK_FAIL, GL_STENCIL_BACK_PASS_DEPTH_FAIL,
     GL_STENCIL_BACK_PASS_DEPTH_PASS}};

static void save_stencil(struct gl_state *s)
{
    for (int f = 0; f < 2; f++) {
        struct stencil *stencil = &s->stencil[f];
        GLint *values[7] = {&stencil->func, &stencil->reference,  &stencil->read, &stencil->write,
                            &stencil->fail, &stencil->depth_fail, &stencil->pass};
        for (int k = 0; k < 7; k++)
            glGetIntegerv(stencil_names[f][k], values[k]);
    }
}

static void restore_stencil(const struct gl_state *s)
{
    static const GLenum faces[2] = {GL_FRONT, GL_BACK};
    for (int f = 0; f < 2; f++) {
        const struct stencil *stencil = &s->stencil[f];
        glStencilFuncSeparate(faces[f], (GLenum)stencil->func, stencil->reference,
                              (GLuint)stencil->read);
        glStencilOpSeparate(faces[f], (GLenum)stencil->fail, (GLenum)stencil->depth_fail,
                            (GLenum)stencil->pass);
        glStencilMaskSeparate(faces[f], (GLuint)stencil->write);
    }
}

static void save_feedback(struct gl_device *device, struct gl_state *s)
{
    glGetIntegerv(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING, &s->feedback_buffer);
    if (device->feedback) {
        /* Draws use an object of ours. */
        glGetIntegerv(GL_TRANSFORM_FEEDBACK_BINDING, &s->feedback);
        return;
    }
    glGetIntegeri_v(GL_TRANSFORM_FEEDBACK_BUFFER_BINDING, 0, &s->feedback_buffer_0);
    glGetInteger64i_v(GL_TRANSFORM_FEEDBACK_BUFFER_START, 0, &s->feedback_start);
    glGetInteger64i_v(GL_TRANSFORM_FEEDBACK_BUFFER_SIZE, 0, &s->feedback_size);
}

static void restore_feedback(struct gl_device *device, const struct gl_state *s)
{
    if (device->feedback) {
        glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, (GLuint)s->feedback);
    } else if (s->feedback_size > 0) {
        glBindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, (GLuint)s->feedback_buffer_0,
                          (GLintptr)s->feedback_start, (GLsizeiptr)s->feedback_size);
    } else {
        glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, (GLuint)s->feedback_buffer_0);
    }
    glBindBuffer(GL_TRANSFORM_FEEDBACK_BUFFER, (GLuint)s->feedback_buffer);
}

pnb_status gl_state_save(struct gl_device *device)
{
    if (!device->state)
        device->state = memory_alloc(device->context, 1, sizeof(*device->state));
    struct gl_state *s = device->state;
    if (!s)
        return status_no_memory(device->context, sizeof(*s));
    GLboolean active = GL_FALSE, paused = GL_FALSE;
    if (device->feedback) {
        glGetBooleanv(GL_TRANSFORM_FEEDBACK_ACTIVE, &active);
        glGetBooleanv(GL_TRANSFORM_FEEDBACK_PAUSED, &paused);
    }
    if (active && !paused)
        return status_fail(device->context, PNB_ERROR_DEVICE, "OpenGL",
                           "a transform feedback is active: pause or end it first");
    for (int i = 0; i < SWITCHES; i++)
        s->switches[i] = has_switch(device, i) && glIsEnabled(switches[i]);
    for (int i = 0; i < PIXEL_STORES; i++)
        if (has_pixel_store(device, i))
            glGetIntegerv(pixel_stores[i], &s->pixel_stores[i]);
    const struct {
        GLenum what;
        GLint *value;
    } integers[] = {
        {GL_CURRENT_PROGRAM, &s->program},
        {GL_VERTEX_ARRAY_BINDING, &s->vertex_array},
        {GL_ARRAY_BUFFER_BINDING, &s->array_buffer},
        {GL_DRAW_FRAMEBUFFER_BINDING, &s->draw_framebuffer},
        {GL_READ_FRAMEBUFFER_BINDING, &s->read_framebuffer},
        {GL_RENDERBUFFER_BINDING, &s->renderbuffer},
        {GL_PIXEL_PACK_BUFFER_BINDING, &s->pack_buffer},
        {GL_PIXEL_UNPACK_BUFFER_BINDING, &s->unpack_buffer},
        {GL_ACTIVE_TEXTURE, &s->active_texture},
        {GL_DEPTH_FUNC, &s->depth_func},
        {GL_CULL_FACE_MODE, &s->cull_mode},
        {GL_FRONT_FACE, &s->front_face},
    };
    for (size_t i = 0; i < sizeof(integers) / sizeof(*integers); i++)
        glGetIntegerv(integers[i].what, integers[i].value);
    glGetBooleanv(GL_DEPTH_WRITEMASK, &s->depth_mask);
    glGetFloatv(GL_POLYGON_OFFSET_FACTOR, &s->offset_factor);
    glGetFloatv(GL_POLYGON_OFFSET_UNITS, &s->offset_units);
    if (!device->info.es)
        glGetIntegerv(GL_POLYGON_MODE, s->polygon_mode);
    if (!device->info.es && device->info.version >= 45) {
        glGetIntegerv(GL_CLIP_ORIGIN, &s->clip_origin);
        glGetIntegerv(GL_CLIP_DEPTH_MODE, &s->clip_depth);
    }
    if (!device->info.es && device->info.version >= 46)
        glGetFloatv(GL_POLYGON_OFFSET_CLAMP, &s->offset_clamp);
    if (device->info.depth_bounds) {
        s->depth_bounds_on = glIsEnabled(GL_DEPTH_BOUNDS_TEST_EXT);
        glGetFloatv(GL_DEPTH_BOUNDS_EXT, s->depth_bounds);
    }
    save_views(device, s);
    save_colors(device, s);
    save_stencil(s);
    save_feedback(device, s);
    for (int i = 0; i < GL_UNITS; i++)
        s->units[i].saved = false;
    gl_state_baseline(device);
    return PNB_OK;
}

void gl_state_save_unit(struct gl_device *device, int unit)
{
    struct gl_state *s = device->state;
    if (!device->adopted || !s || s->units[unit].saved)
        return;
    s->units[unit].saved = true;
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &s->units[unit].plane);
    glGetIntegerv(GL_TEXTURE_BINDING_2D_ARRAY, &s->units[unit].layers);
    glGetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &s->units[unit].faces);
    glGetIntegerv(GL_SAMPLER_BINDING, &s->units[unit].sampler);
}

void gl_state_restore(struct gl_device *device)
{
    const struct gl_state *s = device->state;
    for (int i = 0; i < GL_UNITS; i++) {
        if (!s->units[i].saved)
            continue;
        glActiveTexture(GL_TEXTURE0 + (GLenum)i);
        glBindTexture(GL_TEXTURE_2D, (GLuint)s->units[i].plane);
        glBindTexture(GL_TEXTURE_2D_ARRAY, (GLuint)s->units[i].layers);
        glBindTexture(GL_TEXTURE_CUBE_MAP, (GLuint)s->units[i].faces);
        glBindSampler((GLuint)i, (GLuint)s->units[i].sampler);
    }
    glActiveTexture((GLenum)s->active_texture);
    restore_feedback(device, s);
    restore_stencil(s);
    restore_colors(device, s);
    restore_views(s);
    if (device->info.depth_bounds) {
        set_switch(GL_DEPTH_BOUNDS_TEST_EXT, s->depth_bounds_on);
        glDepthBoundsEXT((GLclampd)s->depth_bounds[0], (GLclampd)s->depth_bounds[1]);
    }
    if (!device->info.es && device->info.version >= 45)
        glClipControl((GLenum)s->clip_origin, (GLenum)s->clip_depth);
    if (!device->info.es)
        glPolygonMode(GL_FRONT_AND_BACK, (GLenum)s->polygon_mode[0]);
    if (!device->info.es && device->info.version >= 46)
        glPolygonOffsetClamp(s->offset_factor, s->offset_units, s->offset_clamp);
    else
        glPolygonOffset(s->offset_factor, s->offset_units);
    glFrontFace((GLenum)s->front_face);
    glCullFace((GLenum)s->cull_mode);
    glDepthFunc((GLenum)s->depth_func);
    glDepthMask(s->depth_mask);
    for (int i = 0; i < SWITCHES; i++)
        if (has_switch(device, i))
            set_switch(switches[i], s->switches[i]);
    for (int i = 0; i < PIXEL_STORES; i++)
        if (has_pixel_store(device, i))
            glPixelStorei(pixel_stores[i], s->pixel_stores[i]);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, (GLuint)s->pack_buffer);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, (GLuint)s->unpack_buffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, (GLuint)s->draw_framebuffer);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, (GLuint)s->read_framebuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, (GLuint)s->renderbuffer);
    glBindVertexArray((GLuint)s->vertex_array);
    glBindBuffer(GL_ARRAY_BUFFER, (GLuint)s->array_buffer);
    glUseProgram((GLuint)s->program);
}

void gl_state_destroy(struct gl_device *device)
{
    memory_free(device->context, device->state);
    device->state = NULL;
}
