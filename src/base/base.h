/* base/base.h: status, log, memory, parallel loops, clock. Knows no geometry. */
#ifndef BASE_BASE_H
#define BASE_BASE_H

#include <penumbra/context.h>

struct pool;

struct pnb_context {
    pnb_context_desc desc;
    int threads;
    struct pool *pool; /* started by the first parallel loop */
    char error[1024];
};

/* The only place where an error is born: "WHAT: WHY" as one line (control characters are replaced)
 * into the context; returns status. what may be NULL: only the reason. */
pnb_status status_fail(pnb_context *context, pnb_status status, const char *what, const char *why,
                       ...) __attribute__((format(printf, 4, 5)));
pnb_status status_no_memory(pnb_context *context, size_t size);
/* The caller gave NULL for what. */
pnb_status status_missing(pnb_context *context, const char *what);

void log_info(pnb_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));
void log_warning(pnb_context *context, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Memory by the context's allocator; NULL when there is none left (or the product overflows). Sizes
 * of 0 give a valid pointer. */
void *memory_alloc(pnb_context *context, size_t count, size_t size);  /* uninitialised */
void *memory_calloc(pnb_context *context, size_t count, size_t size); /* zeros */
void *memory_realloc(pnb_context *context, void *old, size_t count, size_t size);
void memory_free(pnb_context *context, void *block);
char *memory_strdup(pnb_context *context, const char *text); /* NULL in, NULL out */

/* A growing array: doubles capacity so that *count + extra fit. False: no memory (array unchanged).
 */
bool memory_reserve(pnb_context *context, void **array, size_t *capacity, size_t count,
                    size_t extra, size_t size);

/* Calls body(user, begin, end, worker) for pieces that cover [0, count), each of at most grain
 * items, on the context's threads; worker is in [0, pnb_context_threads()). Which worker does a
 * piece is open: results must not depend on it. Not reentrant from within body. */
typedef void parallel_body(void *user, size_t begin, size_t end, int worker);
void parallel_for(pnb_context *context, size_t count, size_t grain, parallel_body *body,
                  void *user);

/* The same with progress: the calling thread reports stage and share now and then;
 * PNB_ERROR_CANCELLED when the callback asked to stop (pieces not begun are then left out). first,
 * last: the share of the stage that this loop makes up, usually 0 and 1. */
pnb_status parallel_for_progress(pnb_context *context, const char *stage, double first, double last,
                                 size_t count, size_t grain, parallel_body *body, void *user);

double clock_ms(void); /* monotonic */

#endif
