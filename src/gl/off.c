/* gl/off.c: stands in for this folder where it was built without OpenGL: no device can be made, so
 * that nothing else is ever reached. */
#include "gl/device.h"

static const struct gl_device_info none;

pnb_status gl_device_create_as(pnb_context *context, enum gl_device_api api,
                               struct gl_device **out_device)
{
    *out_device = NULL;
    return status_fail(context, PNB_ERROR_DEVICE, "OpenGL", "built without OpenGL");
}
pnb_status gl_device_create(pnb_context *context, struct gl_device **out_device)
{
    return gl_device_create_as(context, GL_DEVICE_API_BEST, out_device);
}
pnb_status gl_device_adopt(pnb_context *context, struct gl_device **out_device)
{
    return gl_device_create(context, out_device);
}
void gl_device_destroy(struct gl_device *device) {}
const struct gl_device_info *gl_device_get_info(const struct gl_device *device)
{
    return &none;
}
pnb_context *gl_device_context(const struct gl_device *device)
{
    return NULL;
}
pnb_status gl_device_begin(struct gl_device *device)
{
    return PNB_ERROR_DEVICE;
}
pnb_status gl_device_end(struct gl_device *device)
{
    return PNB_ERROR_DEVICE;
}
void gl_device_finish(struct gl_device *device) {}
pnb_status gl_texture_create(struct gl_device *device, const struct gl_texture_desc *desc,
                             struct gl_texture **out_texture)
{
    *out_texture = NULL;
    return PNB_ERROR_DEVICE;
}
void gl_texture_destroy(struct gl_texture *texture) {}
void gl_texture_upload(struct gl_texture *texture, int layer, const void *texels) {}
pnb_status gl_texture_read(struct gl_texture *texture, int layer, void *texels)
{
    return PNB_ERROR_DEVICE;
}
int gl_texture_width(const struct gl_texture *texture)
{
    return 0;
}
int gl_texture_height(const struct gl_texture *texture)
{
    return 0;
}
size_t gl_texture_bytes(const struct gl_texture *texture)
{
    return 0;
}
pnb_status gl_texture_adopt(struct gl_device *device, unsigned name, enum gl_format format,
                            int width, int height, struct gl_texture **out_texture)
{
    *out_texture = NULL;
    return PNB_ERROR_DEVICE;
}
pnb_status gl_texture_look(struct gl_device *device, unsigned name, bool depth, const char *what,
                           int *out_width, int *out_height)
{
    return PNB_ERROR_DEVICE;
}
pnb_status gl_target_create(struct gl_device *device, const struct gl_target_desc *desc,
                            struct gl_target **out_target)
{
    *out_target = NULL;
    return PNB_ERROR_DEVICE;
}
void gl_target_destroy(struct gl_target *target) {}
void gl_target_clear(struct gl_target *target, const struct gl_clear *clear) {}
void gl_target_copy_depth(struct gl_target *from, struct gl_target *to) {}
pnb_status gl_buffer_create(struct gl_device *device, const void *data, size_t size, bool stream,
                            struct gl_buffer **out_buffer)
{
    *out_buffer = NULL;
    return PNB_ERROR_DEVICE;
}
void gl_buffer_destroy(struct gl_buffer *buffer) {}
pnb_status gl_buffer_write(struct gl_buffer *buffer, const void *data, size_t size)
{
    return PNB_ERROR_DEVICE;
}
pnb_status gl_buffer_read(struct gl_buffer *buffer, size_t offset, void *data, size_t size)
{
    return PNB_ERROR_DEVICE;
}
size_t gl_buffer_size(const struct gl_buffer *buffer)
{
    return 0;
}
pnb_status gl_program_create(struct gl_device *device, const struct gl_program_desc *desc,
                             struct gl_program **out_program)
{
    *out_program = NULL;
    return PNB_ERROR_DEVICE;
}
void gl_program_destroy(struct gl_program *program) {}
void gl_draw(struct gl_device *device, const struct gl_draw *draw) {}
size_t gl_draw_captured(struct gl_device *device, const struct gl_draw *draw)
{
    return 0;
}
void gl_draw_cover(struct gl_device *device, const struct gl_draw *draw) {}
