/* base/context.c: the context, its errors, log and memory. */
#define _GNU_SOURCE
#include "base/base.h"

#include <sched.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/pool.h"

static void *libc_reallocate(void *user, void *old, size_t size)
{
    (void)user;
    if (size == 0) {
        free(old);
        return NULL;
    }
    return realloc(old, size);
}

static int processors(void)
{
    cpu_set_t set;
    if (sched_getaffinity(0, sizeof(set), &set) == 0) {
        int n = CPU_COUNT(&set);
        if (n > 0)
            return n;
    }
    return 1;
}

pnb_status pnb_context_create(const pnb_context_desc *desc, pnb_context **out_context)
{
    pnb_context_desc d = {0};
    *out_context = NULL;
    if (desc)
        d = *desc;
    if (!d.reallocate)
        d.reallocate = libc_reallocate;
    pnb_context *context = d.reallocate(d.user, NULL, sizeof(*context));
    if (!context)
        return PNB_ERROR_MEMORY;
    memset(context, 0, sizeof(*context));
    context->desc = d;
    context->threads = d.threads > 0 ? d.threads : processors();
    if (context->threads > 256)
        context->threads = 256;
    *out_context = context;
    return PNB_OK;
}

void pnb_context_destroy(pnb_context *context)
{
    if (!context)
        return;
    pool_destroy(context);
    context->desc.reallocate(context->desc.user, context, 0);
}

const char *pnb_context_error(const pnb_context *context)
{
    return context->error;
}

int pnb_context_threads(const pnb_context *context)
{
    return context->threads;
}

const char *pnb_status_name(pnb_status status)
{
    switch (status) {
    case PNB_OK: return "ok";
    case PNB_ERROR_ARGUMENT: return "argument";
    case PNB_ERROR_MEMORY: return "memory";
    case PNB_ERROR_FILE: return "file";
    case PNB_ERROR_FORMAT: return "format";
    case PNB_ERROR_SCENE: return "scene";
    case PNB_ERROR_UNSUPPORTED: return "unsupported";
    case PNB_ERROR_DEVICE: return "device";
    case PNB_ERROR_CANCELLED: return "cancelled";
    }
    return "unknown";
}

const char *pnb_version(void)
{
    return PNB_VERSION;
}

pnb_status status_fail(pnb_context *context, pnb_status status, const char *what, const char *why,
                       ...)
{
    char text[sizeof(context->error)];
    size_t used = 0;
    if (what)
        used = (size_t)snprintf(text, sizeof(text), "%.600s: ", what);
    va_list arguments;
    va_start(arguments, why);
    vsnprintf(text + used, sizeof(text) - used, why, arguments);
    va_end(arguments);
    for (char *c = text; *c; c++)
        if ((unsigned char)*c < 0x20 || *c == 0x7f)
            *c = '?';
    memcpy(context->error, text, sizeof(text));
    return status;
}

pnb_status status_no_memory(pnb_context *context, size_t size)
{
    return status_fail(context, PNB_ERROR_MEMORY, "memory", "no %zu bytes left", size);
}

pnb_status status_missing(pnb_context *context, const char *what)
{
    return status_fail(context, PNB_ERROR_ARGUMENT, what, "is missing: the pointer is NULL");
}

static void log_line(pnb_context *context, pnb_log_level level, const char *format,
                     va_list arguments)
{
    char text[1024];
    if (!context->desc.log)
        return;
    vsnprintf(text, sizeof(text), format, arguments);
    context->desc.log(context->desc.user, level, text);
}

void log_info(pnb_context *context, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    log_line(context, PNB_LOG_INFO, format, arguments);
    va_end(arguments);
}

void log_warning(pnb_context *context, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    log_line(context, PNB_LOG_WARNING, format, arguments);
    va_end(arguments);
}

void *memory_realloc(pnb_context *context, void *old, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes))
        return NULL;
    return context->desc.reallocate(context->desc.user, old, bytes ? bytes : 1);
}

void *memory_alloc(pnb_context *context, size_t count, size_t size)
{
    return memory_realloc(context, NULL, count, size);
}

void *memory_calloc(pnb_context *context, size_t count, size_t size)
{
    void *block = memory_alloc(context, count, size);
    if (block)
        memset(block, 0, count * size);
    return block;
}

void memory_free(pnb_context *context, void *block)
{
    if (block)
        context->desc.reallocate(context->desc.user, block, 0);
}

char *memory_strdup(pnb_context *context, const char *text)
{
    if (!text)
        return NULL;
    size_t size = strlen(text) + 1;
    char *copy = memory_alloc(context, size, 1);
    if (copy)
        memcpy(copy, text, size);
    return copy;
}

bool memory_reserve(pnb_context *context, void **array, size_t *capacity, size_t count,
                    size_t extra, size_t size)
{
    size_t wanted;
    if (__builtin_add_overflow(count, extra, &wanted))
        return false;
    if (wanted <= *capacity)
        return true;
    size_t grown = *capacity + *capacity / 2 + 16;
    if (grown < wanted)
        grown = wanted;
    void *block = memory_realloc(context, *array, grown, size);
    if (!block)
        return false;
    *array = block;
    *capacity = grown;
    return true;
}

double clock_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e3 + (double)t.tv_nsec * 1e-6;
}
