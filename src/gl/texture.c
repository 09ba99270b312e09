/* gl/texture.c: textures and targets. */
#include <string.h>

#include "gl/inside.h"

static const struct gl_format_info formats[] = {
    [GL_FORMAT_R8] = {GL_R8, GL_RED, GL_UNSIGNED_BYTE, 1, 1, 1},
    [GL_FORMAT_RGBA8] = {GL_RGBA8, GL_RGBA, GL_UNSIGNED_BYTE, 4, 4, 1},
    [GL_FORMAT_R16F] = {GL_R16F, GL_RED, GL_FLOAT, 2, 1, 4},
    [GL_FORMAT_RGBA16F] = {GL_RGBA16F, GL_RGBA, GL_FLOAT, 8, 4, 4},
    [GL_FORMAT_R32F] = {GL_R32F, GL_RED, GL_FLOAT, 4, 1, 4},
    [GL_FORMAT_RG32F] = {GL_RG32F, GL_RG, GL_FLOAT, 8, 2, 4},
    [GL_FORMAT_RGBA32F] = {GL_RGBA32F, GL_RGBA, GL_FLOAT, 16, 4, 4},
    [GL_FORMAT_R32UI] = {GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, 4, 1, 4, .integer = true},
    [GL_FORMAT_RGBA32UI] = {GL_RGBA32UI, GL_RGBA_INTEGER, GL_UNSIGNED_INT, 16, 4, 4,
                            .integer = true},
    [GL_FORMAT_DEPTH24_STENCIL8] = {GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, 4,
                                    1, 4, .depth = true, .stencil = true},
    [GL_FORMAT_DEPTH32F_STENCIL8] = {GL_DEPTH32F_STENCIL8, GL_DEPTH_STENCIL,
                                     GL_FLOAT_32_UNSIGNED_INT_24_8_REV, 8, 1, 4, .depth = true,
                                     .stencil = true},
    [GL_FORMAT_DEPTH32F] = {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT, GL_FLOAT, 4, 1, 4,
                            .depth = true},
};

const struct gl_format_info *gl_format_info(enum gl_format format)
{
    return &formats[format];
}

void gl_texture_bind(struct gl_texture *texture, int unit)
{
    struct gl_device *device = texture->device;
    gl_state_save_unit(device, unit);
    glActiveTexture(GL_TEXTURE0 + (GLenum)unit);
    glBindTexture(texture->target, texture->name);
    glBindSampler((GLuint)unit, texture->adopted ? device->sampler : 0);
}

void gl_texture_attach(GLenum target, GLenum point, const struct gl_attachment *attachment)
{
    const struct gl_texture *texture = attachment->texture;
    if (!texture)
        glFramebufferTexture2D(target, point, GL_TEXTURE_2D, 0, 0);
    else if (texture->kind == GL_TEXTURE_LAYERS)
        glFramebufferTextureLayer(target, point, texture->name, 0, attachment->layer);
    else if (texture->kind == GL_TEXTURE_FACES)
        glFramebufferTexture2D(target, point,
                               GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)attachment->layer,
                               texture->name, 0);
    else
        glFramebufferTexture2D(target, point, GL_TEXTURE_2D, texture->name, 0);
}

static void set_parameters(const struct gl_texture_desc *desc, const struct gl_texture *texture)
{
    GLenum target = texture->target;
    GLint filter = desc->linear ? GL_LINEAR : GL_NEAREST;
    GLint wrap = desc->has_border ? GL_CLAMP_TO_BORDER : GL_CLAMP_TO_EDGE;
    glTexParameteri(target, GL_TEXTURE_BASE_LEVEL, 0);
    glTexParameteri(target, GL_TEXTURE_MAX_LEVEL, 0);
    glTexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(target, GL_TEXTURE_WRAP_S, wrap);
    glTexParameteri(target, GL_TEXTURE_WRAP_T, wrap);
    if (desc->has_border)
        glTexParameterfv(target, GL_TEXTURE_BORDER_COLOR, desc->border);
    if (desc->compare) {
        glTexParameteri(target, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        glTexParameteri(target, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
    }
}

static void pixel_store(void)
{
    /* Rows are tight; state.c has noted the caller's. */
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
}

pnb_status gl_texture_create(struct gl_device *device, const struct gl_texture_desc *desc,
                             struct gl_texture **out_texture)
{
    *out_texture = NULL;
    const struct gl_format_info *info = gl_format_info(desc->format);
    int largest = device->info.max_texture_size;
    if (desc->width < 1 || desc->height < 1 || desc->width > largest || desc->height > largest)
        return status_fail(device->context, PNB_ERROR_DEVICE, "texture",
                           "%dx%d; this device has 1x1 to %dx%d", desc->width, desc->height,
                           largest, largest);
    struct gl_texture *texture = memory_calloc(device->context, 1, sizeof(*texture));
    if (!texture)
        return status_no_memory(device->context, sizeof(*texture));
    *texture = (struct gl_texture){.device = device,
                                   .format = desc->format,
                                   .kind = desc->kind,
                                   .width = desc->width,
                                   .height = desc->height};
    texture->layers = desc->kind == GL_TEXTURE_FACES    ? 6
                      : desc->kind == GL_TEXTURE_LAYERS ? desc->layers
                                                        : 1;
    texture->target = desc->kind == GL_TEXTURE_FACES    ? GL_TEXTURE_CUBE_MAP
                      : desc->kind == GL_TEXTURE_LAYERS ? GL_TEXTURE_2D_ARRAY
                                                        : GL_TEXTURE_2D;
    pnb_status status = gl_check(device, "before a texture");
    glGenTextures(1, &texture->name);
    gl_texture_bind(texture, 0);
    set_parameters(desc, texture);
    pixel_store();
    GLint internal = (GLint)info->internal;
    if (desc->kind == GL_TEXTURE_FACES)
        for (GLenum face = 0; face < 6; face++)
            glTexImage2D(GL_TEXTURE_CUBE_MAP_POSITIVE_X + face, 0, internal, desc->width,
                         desc->height, 0, info->format, info->type, NULL);
    else if (desc->kind == GL_TEXTURE_LAYERS)
        glTexImage3D(texture->target, 0, internal, desc->width, desc->height, desc->layers, 0,
                     info->format, info->type, NULL);
    else
        glTexImage2D(texture->target, 0, internal, desc->width, desc->height, 0, info->format,
                     info->type, desc->texels);
    if (status == PNB_OK && gl_check(device, "texture") != PNB_OK)
        status = status_fail(device->context, PNB_ERROR_DEVICE, "texture",
                             "%dx%dx%d, %.0f MiB: the device has no room for it", desc->width,
                             desc->height, texture->layers,
                             (double)gl_texture_bytes(texture) / (1 << 20));
    if (status != PNB_OK) {
        gl_texture_destroy(texture);
        return status;
    }
    *out_texture = texture;
    return PNB_OK;
}

pnb_status gl_texture_adopt(struct gl_device *device, unsigned name, enum gl_format format,
                            int width, int height, struct gl_texture **out_texture)
{
    struct gl_texture *texture = *out_texture = memory_calloc(device->context, 1, sizeof(*texture));
    if (!texture)
        return status_no_memory(device->context, sizeof(*texture));
    *texture = (struct gl_texture){.device = device,
                                   .name = name,
                                   .target = GL_TEXTURE_2D,
                                   .format = format,
                                   .width = width,
                                   .height = height,
                                   .layers = 1,
                                   .adopted = true};
    return PNB_OK;
}

pnb_status gl_texture_look(struct gl_device *device, unsigned name, bool depth, const char *what,
                           int *out_width, int *out_height)
{
    *out_width = *out_height = 0;
    if (name == 0 || !glIsTexture(name))
        return status_fail(device->context, PNB_ERROR_ARGUMENT, what,
                           "%u is no texture of this context", name);
    gl_state_save_unit(device, 0);
    glActiveTexture(GL_TEXTURE0);
    glBindTexture(GL_TEXTURE_2D, name);
    GLint bits = 0;
    if (glGetError() == GL_NO_ERROR) {
        glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, out_width);
        glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, out_height);
        glGetTexLevelParameteriv(GL_TEXTURE_2D, 0,
                                 depth ? GL_TEXTURE_DEPTH_SIZE : GL_TEXTURE_RED_SIZE, &bits);
    }
    if (*out_width < 1 || *out_height < 1)
        return status_fail(device->context, PNB_ERROR_ARGUMENT, what,
                           "no two-dimensional texture, or without storage");
    if (bits == 0)
        return status_fail(device->context, PNB_ERROR_ARGUMENT, what, "has no %s",
                           depth ? "depth" : "colour");
    return PNB_OK;
}

void gl_texture_destroy(struct gl_texture *texture)
{
    if (!texture)
        return;
    if (!texture->adopted && texture->device->begun > 0)
        glDeleteTextures(1, &texture->name);
    memory_free(texture->device->context, texture);
}

void gl_texture_upload(struct gl_texture *texture, int layer, const void *texels)
{
    const struct gl_format_info *info = gl_format_info(texture->format);
    gl_texture_bind(texture, 0);
    pixel_store();
    if (texture->kind == GL_TEXTURE_LAYERS)
        glTexSubImage3D(texture->target, 0, 0, 0, layer, texture->width, texture->height, 1,
                        info->format, info->type, texels);
    else
        glTexSubImage2D(texture->kind == GL_TEXTURE_FACES
                            ? GL_TEXTURE_CUBE_MAP_POSITIVE_X + (GLenum)layer
                            : GL_TEXTURE_2D,
                        0, 0, 0, texture->width, texture->height, info->format, info->type, texels);
}

/* OpenGL ES reads floats as four channels only. */
static pnb_status read_wide(struct gl_texture *texture, const struct gl_format_info *info,
                            void *texels)
{
    struct gl_device *device = texture->device;
    size_t count = (size_t)texture->width * (size_t)texture->height;
    size_t size = (size_t)info->component_bytes;
    unsigned char *wide = memory_alloc(device->context, count, 4 * size), *out = texels;
    if (!wide)
        return status_no_memory(device->context, count * 4 * size);
    glReadPixels(0, 0, texture->width, texture->height, info->integer ? GL_RGBA_INTEGER : GL_RGBA,
                 info->type, wide);
    for (size_t i = 0; i < count; i++)
        memcpy(out + i * size * (size_t)info->components, wide + i * 4 * size,
               size * (size_t)info->components);
    memory_free(device->context, wide);
    return PNB_OK;
}

pnb_status gl_texture_read(struct gl_texture *texture, int layer, void *texels)
{
    struct gl_device *device = texture->device;
    const struct gl_format_info *info = gl_format_info(texture->format);
    GLenum point = !info->depth    ? GL_COLOR_ATTACHMENT0
                   : info->stencil ? GL_DEPTH_STENCIL_ATTACHMENT
                                   : GL_DEPTH_ATTACHMENT;
    if (info->depth && device->info.es)
        return status_fail(device->context, PNB_ERROR_DEVICE, "texture",
                           "OpenGL ES reads no depth back");
    glBindFramebuffer(GL_FRAMEBUFFER, device->framebuffer);
    struct gl_attachment attachment = {texture, layer}, none = {NULL, 0};
    gl_texture_attach(GL_FRAMEBUFFER, point, &attachment);
    glReadBuffer(info->depth ? GL_NONE : GL_COLOR_ATTACHMENT0);
    pixel_store();
    pnb_status status = PNB_OK;
    if (device->info.es && info->components != 4)
        status = read_wide(texture, info, texels);
    else
        glReadPixels(0, 0, texture->width, texture->height,
                     info->depth ? GL_DEPTH_COMPONENT : info->format,
                     info->depth ? GL_FLOAT : info->type, texels);
    gl_texture_attach(GL_FRAMEBUFFER, point, &none);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    return status == PNB_OK ? gl_check(device, "reading a texture") : status;
}

int gl_texture_width(const struct gl_texture *texture)
{
    return texture->width;
}

int gl_texture_height(const struct gl_texture *texture)
{
    return texture->height;
}

size_t gl_texture_bytes(const struct gl_texture *texture)
{
    return (size_t)texture->width * (size_t)texture->height * (size_t)texture->layers *
           (size_t)gl_format_info(texture->format)->texel_bytes;
}

/* ---- Targets ---- */

static const char *incomplete(GLenum what)
{
    switch (what) {
    case GL_FRAMEBUFFER_UNDEFINED: return "undefined";
    case GL_FRAMEBUFFER_INCOMPLETE_ATTACHMENT: return "an attachment cannot be drawn to";
    case GL_FRAMEBUFFER_INCOMPLETE_MISSING_ATTACHMENT: return "no attachment";
    case GL_FRAMEBUFFER_UNSUPPORTED: return "this combination of formats is not supported";
    case GL_FRAMEBUFFER_INCOMPLETE_MULTISAMPLE: return "unequal numbers of samples";
    default: return "incomplete";
    }
}

pnb_status gl_target_create(struct gl_device *device, const struct gl_target_desc *desc,
                            struct gl_target **out_target)
{
    *out_target = NULL;
    struct gl_target *target = memory_calloc(device->context, 1, sizeof(*target));
    if (!target)
        return status_no_memory(device->context, sizeof(*target));
    target->device = device;
    target->desc = *desc;
    glGenFramebuffers(1, &target->name);
    glBindFramebuffer(GL_FRAMEBUFFER, target->name);
    GLenum buffers[GL_COLORS_MAX];
    for (int i = 0; i < GL_COLORS_MAX; i++) {
        const struct gl_attachment *color = &desc->colors[i];
        buffers[i] = GL_NONE;
        if (!color->texture)
            continue;
        gl_texture_attach(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0 + (GLenum)i, color);
        buffers[i] = GL_COLOR_ATTACHMENT0 + (GLenum)i;
        target->color_count = i + 1;
        target->width = color->texture->width;
        target->height = color->texture->height;
    }
    if (desc->depth.texture) {
        const struct gl_format_info *info = gl_format_info(desc->depth.texture->format);
        gl_texture_attach(GL_FRAMEBUFFER,
                          info->stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT,
                          &desc->depth);
        if (target->color_count == 0) {
            target->width = desc->depth.texture->width;
            target->height = desc->depth.texture->height;
        }
    }
    if (target->color_count == 0)
        buffers[0] = GL_NONE;
    glDrawBuffers(target->color_count > 0 ? target->color_count : 1, buffers);
    glReadBuffer(target->color_count > 0 ? buffers[0] : GL_NONE);
    GLenum what = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    if (what != GL_FRAMEBUFFER_COMPLETE) {
        gl_target_destroy(target);
        return status_fail(device->context, PNB_ERROR_DEVICE, "target", "%s", incomplete(what));
    }
    *out_target = target;
    return PNB_OK;
}

void gl_target_destroy(struct gl_target *target)
{
    if (!target)
        return;
    if (target->device->begun > 0)
        glDeleteFramebuffers(1, &target->name);
    memory_free(target->device->context, target);
}

void gl_target_clear(struct gl_target *target, const struct gl_clear *clear)
{
    glBindFramebuffer(GL_FRAMEBUFFER, target->name);
    glDisable(GL_SCISSOR_TEST);
    glDisable(GL_RASTERIZER_DISCARD);
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    glDepthMask(GL_TRUE);
    glStencilMask(~0u);
    for (int i = 0; i < GL_COLORS_MAX; i++) {
        const struct gl_texture *texture = target->desc.colors[i].texture;
        const float *value = clear->color_value[i];
        if (!clear->color[i] || !texture)
            continue;
        if (gl_format_info(texture->format)->integer) {
            GLuint integers[4];
            for (int k = 0; k < 4; k++)
                integers[k] = (GLuint)value[k];
            glClearBufferuiv(GL_COLOR, i, integers);
        } else {
            glClearBufferfv(GL_COLOR, i, value);
        }
    }
    const struct gl_texture *depth = target->desc.depth.texture;
    bool stencil = clear->stencil && depth && gl_format_info(depth->format)->stencil;
    if (clear->depth && depth && stencil)
        glClearBufferfi(GL_DEPTH_STENCIL, 0, clear->depth_value, clear->stencil_value);
    else if (clear->depth && depth)
        glClearBufferfv(GL_DEPTH, 0, &clear->depth_value);
    else if (stencil)
        glClearBufferiv(GL_STENCIL, 0, &clear->stencil_value);
}

void gl_target_copy_depth(struct gl_target *from, struct gl_target *to)
{
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from->name);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to->name);
    glDisable(GL_SCISSOR_TEST);
    glDepthMask(GL_TRUE);
    glStencilMask(~0u);
    const struct gl_texture *depth = from->desc.depth.texture;
    GLbitfield bits = GL_DEPTH_BUFFER_BIT;
    if (gl_format_info(depth->format)->stencil)
        bits |= GL_STENCIL_BUFFER_BIT;
    glBlitFramebuffer(0, 0, from->width, from->height, 0, 0, to->width, to->height, bits,
                      GL_NEAREST);
}
