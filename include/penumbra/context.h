/* context.h: what every call shares: memory, log, threads, progress, and the text of the last
 * error. */
#ifndef PENUMBRA_CONTEXT_H
#define PENUMBRA_CONTEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(PNB_STATIC)
#define PNB_API
#else
#define PNB_API __attribute__((visibility("default")))
#endif

typedef enum pnb_status {
    PNB_OK = 0,
    PNB_ERROR_ARGUMENT, /* the caller broke a documented rule */
    PNB_ERROR_MEMORY,   /* out of memory */
    PNB_ERROR_FILE,     /* a file cannot be opened, read or written */
    PNB_ERROR_FORMAT,   /* a file's content is broken or of an unknown kind */
    PNB_ERROR_SCENE,    /* a scene that means nothing: degenerate camera, light of no area, ... */
    PNB_ERROR_UNSUPPORTED, /* a method asked for a light or receiver that it cannot do */
    PNB_ERROR_DEVICE,      /* a library or device refused */
    PNB_ERROR_CANCELLED    /* the progress callback asked to stop */
} pnb_status;

typedef enum pnb_log_level { PNB_LOG_INFO = 0, PNB_LOG_WARNING } pnb_log_level;

typedef struct pnb_context pnb_context;

typedef struct pnb_context_desc {
    /* Worker threads for parallel work; 0: one per processor that the process may use. */
    int threads;

    /* Memory: realloc-like. old NULL allocates, size 0 frees and returns NULL; may be called from
     * any thread. NULL: the C library's. Embree, the JSON and picture libraries use their own. */
    void *(*reallocate)(void *user, void *old, size_t size);

    /* One line of text without a line end; from the calling thread only. NULL: silence. */
    void (*log)(void *user, pnb_log_level level, const char *text);

    /* Long work reports its stage and the finished share in [0,1], from the calling thread, at most
     * some twenty times a second. Returning false cancels: the call ends soon with
     * PNB_ERROR_CANCELLED and leaves nothing half-done. NULL: never called. */
    bool (*progress)(void *user, const char *stage, double fraction);

    void *user; /* handed to the three above */
} pnb_context_desc;

/* A context is used by one thread at a time; several contexts are independent of one another.
 * desc may be NULL. Everything made with a context is destroyed before it. */
PNB_API pnb_status pnb_context_create(const pnb_context_desc *desc, pnb_context **out_context);
PNB_API void pnb_context_destroy(pnb_context *context);

/* "WHAT: WHY" of the last call that failed, one line; "" if none did. Valid until the next call. */
PNB_API const char *pnb_context_error(const pnb_context *context);
PNB_API int pnb_context_threads(const pnb_context *context);

/* "ok", "argument", "memory", ... */
PNB_API const char *pnb_status_name(pnb_status status);
PNB_API const char *pnb_version(void); /* "1.2.3" */

#ifdef __cplusplus
}
#endif
#endif
