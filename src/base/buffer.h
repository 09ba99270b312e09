/* base/buffer.h: a growing run of bytes that a file is put together in. After the first failure to
 * grow every call does nothing and failed is set: check once, at the end. */
#ifndef BASE_BUFFER_H
#define BASE_BUFFER_H

#include "base/base.h"

struct buffer {
    pnb_context *context;
    char *bytes;
    size_t size, capacity;
    bool failed;
};

void buffer_init(pnb_context *context, struct buffer *buffer);
void buffer_finish(struct buffer *buffer);
void buffer_add(struct buffer *buffer, const void *bytes, size_t size);
void buffer_print(struct buffer *buffer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* A finite number with as few digits as bring the same double back; 1.0 prints as 1. Always with a
 * decimal point, whatever the locale. */
void buffer_number(struct buffer *buffer, double value);
/* Nine digits, which bring the same float back; faster. */
void buffer_float(struct buffer *buffer, float value);
/* A JSON string with its quotes; bytes that are not UTF-8 become '?'. NULL prints "". */
void buffer_json_string(struct buffer *buffer, const char *text);

#endif
