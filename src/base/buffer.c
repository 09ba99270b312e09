/* base/buffer.c: see buffer.h. */
#include "base/buffer.h"

#include <locale.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void buffer_init(pnb_context *context, struct buffer *buffer)
{
    *buffer = (struct buffer){.context = context};
}

void buffer_finish(struct buffer *buffer)
{
    memory_free(buffer->context, buffer->bytes);
    *buffer = (struct buffer){.context = buffer->context};
}

static bool reserve(struct buffer *buffer, size_t extra)
{
    if (!buffer->failed && !memory_reserve(buffer->context, (void **)&buffer->bytes,
                                           &buffer->capacity, buffer->size, extra, 1))
        buffer->failed = true;
    return !buffer->failed;
}

void buffer_add(struct buffer *buffer, const void *bytes, size_t size)
{
    if (size == 0 || !reserve(buffer, size))
        return;
    memcpy(buffer->bytes + buffer->size, bytes, size);
    buffer->size += size;
}

void buffer_print(struct buffer *buffer, const char *format, ...)
{
    va_list arguments;
    size_t room = 128;
    for (;;) {
        if (!reserve(buffer, room))
            return;
        va_start(arguments, format);
        int length = vsnprintf(buffer->bytes + buffer->size, room, format, arguments);
        va_end(arguments);
        if (length < 0) {
            buffer->failed = true;
            return;
        }
        if ((size_t)length < room) {
            buffer->size += (size_t)length;
            return;
        }
        room = (size_t)length + 1;
    }
}

/* The caller's locale may print a comma, or more, where files have a point. */
static void add_number(struct buffer *buffer, const char *text)
{
    const char *point = localeconv()->decimal_point, *found = strstr(text, point);
    if (!found || strcmp(point, ".") == 0) {
        buffer_add(buffer, text, strlen(text));
        return;
    }
    buffer_add(buffer, text, (size_t)(found - text));
    buffer_add(buffer, ".", 1);
    buffer_add(buffer, found + strlen(point), strlen(found + strlen(point)));
}

void buffer_number(struct buffer *buffer, double value)
{
    char text[40];
    for (int digits = 6; digits <= 17; digits++) {
        snprintf(text, sizeof(text), "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    add_number(buffer, text);
}

void buffer_float(struct buffer *buffer, float value)
{
    char text[40];
    snprintf(text, sizeof(text), "%.9g", (double)value);
    add_number(buffer, text);
}

/* Length of the UTF-8 sequence at text, 0 if it is none (overlong, surrogate, cut short). */
static size_t utf8_length(const unsigned char *text)
{
    static const unsigned least[5] = {0, 0, 0x80, 0x800, 0x10000};
    size_t length = text[0] < 0x80             ? 1
                    : (text[0] & 0xe0) == 0xc0 ? 2
                    : (text[0] & 0xf0) == 0xe0 ? 3
                    : (text[0] & 0xf8) == 0xf0 ? 4
                                               : 0;
    if (length < 2)
        return length;
    unsigned code = text[0] & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if ((text[i] & 0xc0) != 0x80)
            return 0;
        code = code << 6 | (text[i] & 0x3fu);
    }
    bool valid = code >= least[length] && code <= 0x10ffff && (code < 0xd800 || code > 0xdfff);
    return valid ? length : 0;
}

void buffer_json_string(struct buffer *buffer, const char *text)
{
    buffer_add(buffer, "\"", 1);
    for (const unsigned char *c = (const unsigned char *)(text ? text : ""); *c;) {
        size_t length = utf8_length(c);
        if (length == 0)
            buffer_add(buffer, "?", 1);
        else if (*c == '"' || *c == '\\')
            buffer_print(buffer, "\\%c", *c);
        else if (*c < 0x20 || *c == 0x7f)
            buffer_print(buffer, "\\u%04x", *c);
        else
            buffer_add(buffer, c, length);
        c += length ? length : 1;
    }
    buffer_add(buffer, "\"", 1);
}
