/* gl/draw.c: one function that draws. Every state that a draw can choose is set by every draw, so
 * that none depends on the one before it. */
#include "gl/inside.h"

static const GLenum primitives[] = {GL_TRIANGLES,          GL_TRIANGLE_STRIP, GL_LINES,
                                    GL_LINE_STRIP,         GL_POINTS,         GL_LINES_ADJACENCY,
                                    GL_TRIANGLES_ADJACENCY};
static const GLenum compares[] = {GL_ALWAYS, GL_NEVER,  GL_LESS,    GL_LEQUAL,
                                  GL_EQUAL,  GL_GEQUAL, GL_GREATER, GL_NOTEQUAL};
static const GLenum actions[] = {GL_KEEP,      GL_ZERO, GL_REPLACE, GL_INCR_WRAP,
                                 GL_DECR_WRAP, GL_INCR, GL_DECR,    GL_INVERT};

static void enable(GLenum what, bool on)
{
    if (on)
        glEnable(what);
    else
        glDisable(what);
}

static void set_uniform(struct gl_program *program, const struct gl_uniform *uniform, int *unit)
{
    GLint at = gl_program_location(program, uniform->name);
    if (at < 0)
        return;
    const float *values = uniform->data ? uniform->data : uniform->value;
    GLsizei count = uniform->count > 0 ? uniform->count : 1;
    switch (uniform->type) {
    case GL_UNIFORM_NONE: break;
    case GL_UNIFORM_INT:
        glUniform1iv(at, count, uniform->data ? uniform->data : uniform->integer);
        break;
    case GL_UNIFORM_IVEC2:
        glUniform2iv(at, count, uniform->data ? uniform->data : uniform->integer);
        break;
    case GL_UNIFORM_FLOAT: glUniform1fv(at, count, values); break;
    case GL_UNIFORM_VEC2: glUniform2fv(at, count, values); break;
    case GL_UNIFORM_VEC3: glUniform3fv(at, count, values); break;
    case GL_UNIFORM_VEC4: glUniform4fv(at, count, values); break;
    case GL_UNIFORM_MAT4: glUniformMatrix4fv(at, count, GL_FALSE, values); break;
    case GL_UNIFORM_TEXTURE:
        if (uniform->texture && *unit < GL_UNITS) {
            gl_texture_bind(uniform->texture, *unit);
            glUniform1i(at, (*unit)++);
        }
        break;
    }
}

static void set_attributes(const struct gl_draw *draw)
{
    for (GLuint i = 0; i < GL_ATTRIBUTES_MAX; i++) {
        const struct gl_attribute *a = &draw->attributes[i];
        if (a->components == 0 || !a->buffer) {
            glDisableVertexAttribArray(i);
            continue;
        }
        glBindBuffer(GL_ARRAY_BUFFER, a->buffer->name);
        const void *offset = (const char *)NULL + a->offset;
        if (a->integer)
            glVertexAttribIPointer(i, a->components, GL_UNSIGNED_INT, (GLsizei)a->stride, offset);
        else
            glVertexAttribPointer(i, a->components, GL_FLOAT, GL_FALSE, (GLsizei)a->stride, offset);
        glVertexAttribDivisor(i, a->divisor);
        glEnableVertexAttribArray(i);
    }
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, draw->indices ? draw->indices->name : 0);
}

static void set_target(struct gl_device *device, const struct gl_draw *draw)
{
    const struct gl_target *target = draw->target;
    glBindFramebuffer(GL_FRAMEBUFFER, target ? target->name : device->discard_target);
    if (draw->viewport[2] > 0)
        glViewport(draw->viewport[0], draw->viewport[1], draw->viewport[2], draw->viewport[3]);
    else
        glViewport(0, 0, target ? target->width : 1, target ? target->height : 1);
    enable(GL_SCISSOR_TEST, draw->scissor[2] > 0);
    if (draw->scissor[2] > 0)
        glScissor(draw->scissor[0], draw->scissor[1], draw->scissor[2], draw->scissor[3]);
}

static void set_depth(struct gl_device *device, const struct gl_draw *draw)
{
    /* Writes happen only where the test is on. */
    enable(GL_DEPTH_TEST, draw->depth_test || draw->depth_write);
    glDepthFunc(draw->depth_test ? compares[draw->depth_compare] : GL_ALWAYS);
    glDepthMask(draw->depth_write);
    if (device->info.depth_clamp)
        enable(GL_DEPTH_CLAMP, draw->depth_clamp);
    if (device->info.depth_bounds) {
        enable(GL_DEPTH_BOUNDS_TEST_EXT, draw->depth_bounds);
        if (draw->depth_bounds)
            glDepthBoundsEXT(draw->depth_low, draw->depth_high);
    }
    bool offset = draw->offset_factor != 0 || draw->offset_units != 0;
    enable(GL_POLYGON_OFFSET_FILL, offset);
    if (offset)
        glPolygonOffset(draw->offset_factor, draw->offset_units);
}

static void set_stencil_face(GLenum face, const struct gl_draw *draw,
                             const struct gl_stencil_face *actions_of, unsigned read,
                             unsigned write)
{
    glStencilFuncSeparate(face, compares[draw->stencil_compare], draw->stencil_reference, read);
    glStencilOpSeparate(face, actions[actions_of->fail], actions[actions_of->depth_fail],
                        actions[actions_of->pass]);
    glStencilMaskSeparate(face, write);
}

static void set_stencil(const struct gl_draw *draw)
{
    enable(GL_STENCIL_TEST, draw->stencil);
    if (!draw->stencil)
        return;
    bool all = draw->stencil_read_mask == 0 && draw->stencil_write_mask == 0;
    unsigned read = all ? ~0u : draw->stencil_read_mask,
             write = all ? ~0u : draw->stencil_write_mask;
    set_stencil_face(GL_FRONT, draw, &draw->stencil_front, read, write);
    set_stencil_face(GL_BACK, draw, &draw->stencil_back, read, write);
}

static void set_color(const struct gl_draw *draw)
{
    static const struct {
        GLenum equation, source, target;
    } blends[] = {
        [GL_BLEND_OFF] = {GL_FUNC_ADD, GL_ONE, GL_ZERO},
        [GL_BLEND_ADD] = {GL_FUNC_ADD, GL_ONE, GL_ONE},
        [GL_BLEND_REVERSE_SUBTRACT] = {GL_FUNC_REVERSE_SUBTRACT, GL_ONE, GL_ONE},
        [GL_BLEND_MULTIPLY] = {GL_FUNC_ADD, GL_DST_COLOR, GL_ZERO},
        [GL_BLEND_MIN] = {GL_MIN, GL_ONE, GL_ONE},
        [GL_BLEND_MAX] = {GL_MAX, GL_ONE, GL_ONE},
        [GL_BLEND_OVER] = {GL_FUNC_ADD, GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA},
    };
    enable(GL_BLEND, draw->blend != GL_BLEND_OFF);
    glBlendEquation(blends[draw->blend].equation);
    glBlendFunc(blends[draw->blend].source, blends[draw->blend].target);
    const bool *c = draw->channels;
    bool all = !c[0] && !c[1] && !c[2] && !c[3], on = !draw->color_off;
    glColorMask(on && (all || c[0]), on && (all || c[1]), on && (all || c[2]), on && (all || c[3]));
}

static void begin_capture(struct gl_device *device, const struct gl_draw *draw)
{
    if (device->feedback)
        glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, device->feedback);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, draw->capture->name);
    glBeginTransformFeedback(primitives[draw->capture_primitive]);
}

static void end_capture(struct gl_device *device)
{
    glEndTransformFeedback();
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
    if (device->feedback)
        glBindTransformFeedback(GL_TRANSFORM_FEEDBACK, 0);
}

void gl_draw(struct gl_device *device, const struct gl_draw *draw)
{
    if (draw->count == 0)
        return;
    glUseProgram(draw->program->name);
    glBindVertexArray(device->vertex_array);
    set_attributes(draw);
    int unit = 0;
    for (int i = 0; i < GL_UNIFORMS_MAX && draw->uniforms[i].type != GL_UNIFORM_NONE; i++)
        set_uniform(draw->program, &draw->uniforms[i], &unit);
    set_target(device, draw);
    set_depth(device, draw);
    set_stencil(draw);
    set_color(draw);
    enable(GL_CULL_FACE, draw->cull != GL_CULL_NONE);
    glCullFace(draw->cull == GL_CULL_FRONT ? GL_FRONT : GL_BACK);
    enable(GL_RASTERIZER_DISCARD, draw->discard);

    if (draw->capture)
        begin_capture(device, draw);
    GLenum mode = primitives[draw->primitive];
    GLsizei count = (GLsizei)draw->count;
    const void *offset = (const char *)NULL + draw->first * sizeof(uint32_t);
    if (draw->indices && draw->instances > 0)
        glDrawElementsInstanced(mode, count, GL_UNSIGNED_INT, offset, (GLsizei)draw->instances);
    else if (draw->indices)
        glDrawElements(mode, count, GL_UNSIGNED_INT, offset);
    else if (draw->instances > 0)
        glDrawArraysInstanced(mode, (GLint)draw->first, count, (GLsizei)draw->instances);
    else
        glDrawArrays(mode, (GLint)draw->first, count);
    if (draw->capture)
        end_capture(device);
    if (draw->discard)
        glDisable(GL_RASTERIZER_DISCARD);
}

size_t gl_draw_captured(struct gl_device *device, const struct gl_draw *draw)
{
    GLuint count = 0;
    glBeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, device->query);
    gl_draw(device, draw);
    glEndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    glGetQueryObjectuiv(device->query, GL_QUERY_RESULT, &count);
    return count;
}

void gl_draw_cover(struct gl_device *device, const struct gl_draw *draw)
{
    struct gl_draw cover = *draw;
    cover.primitive = GL_PRIMITIVE_TRIANGLES;
    cover.first = 0;
    cover.count = 3;
    cover.indices = NULL;
    gl_draw(device, &cover);
}
