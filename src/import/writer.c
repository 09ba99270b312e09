/* import/writer.c: the stream, see scene/import_stream.h. Small fields are gathered in a buffer,
 * large arrays go straight to the pipe. The importer is one thread that writes one stream and ends,
 * so the stream is the file's. */
#define _GNU_SOURCE
#include "import/import.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static struct {
    int fd;
    size_t used;
    unsigned char buffer[65536];
} stream;

static void write_all(const void *bytes, size_t size)
{
    const unsigned char *p = bytes;
    while (size > 0) {
        ssize_t n = write(stream.fd, p, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            import_fail(IMPORT_BAD_CALL, "cannot write: %s", strerror(errno));
        p += n;
        size -= (size_t)n;
    }
}

static void flush(void)
{
    write_all(stream.buffer, stream.used);
    stream.used = 0;
}

void writer_bytes(const void *bytes, size_t size)
{
    if (size > sizeof(stream.buffer) - stream.used)
        flush();
    if (size > sizeof(stream.buffer)) {
        write_all(bytes, size);
        return;
    }
    if (size > 0)
        memcpy(stream.buffer + stream.used, bytes, size);
    stream.used += size;
}

void writer_u32(uint32_t value)
{
    writer_bytes(&value, sizeof(value));
}

void writer_numbers(const double *values, size_t count)
{
    writer_bytes(values, count * sizeof(*values));
}

void writer_open(int fd)
{
    stream.fd = fd;
    writer_bytes(IMPORT_MAGIC, 8);
    writer_u32(IMPORT_VERSION);
    writer_u32(0);
}

void writer_close(void)
{
    writer_record(IMPORT_END, 0);
    flush();
}

void writer_record(enum import_record kind, size_t size)
{
    uint64_t wide = size;
    writer_u32((uint32_t)kind);
    writer_u32(0);
    writer_bytes(&wide, sizeof(wide));
}

static size_t text_length(const char *text)
{
    return strnlen(text, IMPORT_TEXT_MAX);
}

size_t writer_text_size(const char *text)
{
    return 4 + (text_length(text) + 3) / 4 * 4;
}

void writer_text(const char *text)
{
    size_t length = text_length(text);
    writer_u32((uint32_t)length);
    writer_bytes(text, length);
    writer_bytes("\0\0\0", (4 - length % 4) % 4);
}

void writer_note(const char *format, ...)
{
    char text[IMPORT_TEXT_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    writer_record(IMPORT_NOTE, writer_text_size(text));
    writer_text(text);
}

void writer_camera(const char *name, const double numbers[IMPORT_CAMERA_NUMBERS])
{
    writer_record(IMPORT_CAMERA, writer_text_size(name) + IMPORT_CAMERA_NUMBERS * sizeof(double));
    writer_text(name);
    writer_numbers(numbers, IMPORT_CAMERA_NUMBERS);
}

void writer_light(const char *name, unsigned type, const double numbers[IMPORT_LIGHT_NUMBERS])
{
    writer_record(IMPORT_LIGHT, writer_text_size(name) + 8 + IMPORT_LIGHT_NUMBERS * sizeof(double));
    writer_text(name);
    writer_u32(type);
    writer_u32(0);
    writer_numbers(numbers, IMPORT_LIGHT_NUMBERS);
}
