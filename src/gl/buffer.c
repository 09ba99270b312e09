/* gl/buffer.c: buffers of vertices, indices and captures. */
#include <string.h>

#include "gl/inside.h"

pnb_status gl_buffer_create(struct gl_device *device, const void *data, size_t size, bool stream,
                            struct gl_buffer **out_buffer)
{
    *out_buffer = NULL;
    struct gl_buffer *buffer = memory_calloc(device->context, 1, sizeof(*buffer));
    if (!buffer)
        return status_no_memory(device->context, sizeof(*buffer));
    buffer->device = device;
    buffer->usage = stream ? GL_STREAM_DRAW : GL_STATIC_DRAW;
    glGenBuffers(1, &buffer->name);
    pnb_status status = gl_buffer_write(buffer, data, size);
    if (status != PNB_OK) {
        gl_buffer_destroy(buffer);
        return status;
    }
    *out_buffer = buffer;
    return PNB_OK;
}

void gl_buffer_destroy(struct gl_buffer *buffer)
{
    if (!buffer)
        return;
    if (buffer->device->begun > 0)
        glDeleteBuffers(1, &buffer->name);
    memory_free(buffer->device->context, buffer);
}

/* The target does not matter for what a buffer is; this one touches no vertex array. */
pnb_status gl_buffer_write(struct gl_buffer *buffer, const void *data, size_t size)
{
    struct gl_device *device = buffer->device;
    pnb_status status = gl_check(device, "before a buffer");
    glBindBuffer(GL_ARRAY_BUFFER, buffer->name);
    if (size > buffer->capacity || buffer->capacity == 0 || buffer->usage == GL_STREAM_DRAW) {
        /* New storage: what is still being drawn keeps the old. */
        if (size > buffer->capacity || buffer->capacity == 0)
            buffer->capacity = size > 16 ? size : 16;
        bool whole = data && size == buffer->capacity;
        glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)buffer->capacity, whole ? data : NULL,
                     buffer->usage);
        if (data && !whole && size > 0)
            glBufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)size, data);
    } else if (data && size > 0) {
        glBufferSubData(GL_ARRAY_BUFFER, 0, (GLsizeiptr)size, data);
    }
    buffer->size = size;
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    if (status == PNB_OK && gl_check(device, "buffer") != PNB_OK) {
        buffer->size = buffer->capacity = 0;
        status = status_fail(device->context, PNB_ERROR_DEVICE, "buffer",
                             "%.1f MiB: the device has no room for it", (double)size / (1 << 20));
    }
    return status;
}

pnb_status gl_buffer_read(struct gl_buffer *buffer, size_t offset, void *data, size_t size)
{
    struct gl_device *device = buffer->device;
    if (size == 0)
        return PNB_OK;
    glBindBuffer(GL_ARRAY_BUFFER, buffer->name);
    const void *from =
        glMapBufferRange(GL_ARRAY_BUFFER, (GLintptr)offset, (GLsizeiptr)size, GL_MAP_READ_BIT);
    if (from) {
        memcpy(data, from, size);
        glUnmapBuffer(GL_ARRAY_BUFFER);
    }
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    pnb_status status = gl_check(device, "reading a buffer");
    if (status == PNB_OK && !from)
        status = status_fail(device->context, PNB_ERROR_DEVICE, "buffer", "cannot be read back");
    return status;
}

size_t gl_buffer_size(const struct gl_buffer *buffer)
{
    return buffer->size;
}
