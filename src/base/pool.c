/* base/pool.c: parallel loops.
 *
 * One loop at a time. The calling thread is worker 0 and takes pieces like the others; workers
 * sleep between loops. Pieces are handed out by an atomic counter, so a loop of n pieces costs n
 * additions.
 */
#include "base/pool.h"

#include <pthread.h>
#include <stdatomic.h>

#define REPORT_EVERY_MS 50.0

struct worker {
    struct pool *pool;
    pthread_t thread;
    int number;
};

struct pool {
    pthread_mutex_t mutex;
    pthread_cond_t wake, idle;
    struct worker *workers; /* threads - 1 */
    int worker_count;
    unsigned long generation; /* counts loops; workers wait for it to change */
    int busy;
    bool quit;
    /* The loop. */
    parallel_body *body;
    void *user;
    size_t count, grain;
    atomic_size_t next;
    atomic_bool cancelled;
};

static bool take(struct pool *pool, int worker)
{
    if (atomic_load_explicit(&pool->cancelled, memory_order_relaxed))
        return false;
    size_t begin = atomic_fetch_add_explicit(&pool->next, pool->grain, memory_order_relaxed);
    if (begin >= pool->count)
        return false;
    size_t end = pool->count - begin < pool->grain ? pool->count : begin + pool->grain;
    pool->body(pool->user, begin, end, worker);
    return true;
}

static void *work(void *user)
{
    struct worker *worker = user;
    struct pool *pool = worker->pool;
    unsigned long seen = 0;
    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        while (!pool->quit && pool->generation == seen)
            pthread_cond_wait(&pool->wake, &pool->mutex);
        if (pool->quit)
            break;
        seen = pool->generation;
        pthread_mutex_unlock(&pool->mutex);
        while (take(pool, worker->number))
            ;
        pthread_mutex_lock(&pool->mutex);
        if (--pool->busy == 0)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

/* NULL where threads cannot be had: the caller then works alone. */
static struct pool *pool_get(pnb_context *context)
{
    if (context->pool || context->threads < 2)
        return context->pool;
    struct pool *pool = memory_calloc(context, 1, sizeof(*pool));
    if (!pool)
        return NULL;
    pool->workers = memory_calloc(context, (size_t)context->threads - 1, sizeof(*pool->workers));
    if (!pool->workers) {
        memory_free(context, pool);
        return NULL;
    }
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->wake, NULL);
    pthread_cond_init(&pool->idle, NULL);
    for (int i = 0; i < context->threads - 1; i++) {
        struct worker *worker = &pool->workers[pool->worker_count];
        worker->pool = pool;
        worker->number = i + 1;
        if (pthread_create(&worker->thread, NULL, work, worker) != 0)
            break;
        pool->worker_count++;
    }
    context->pool = pool;
    return pool;
}

void pool_destroy(pnb_context *context)
{
    struct pool *pool = context->pool;
    if (!pool)
        return;
    pthread_mutex_lock(&pool->mutex);
    pool->quit = true;
    pthread_cond_broadcast(&pool->wake);
    pthread_mutex_unlock(&pool->mutex);
    for (int i = 0; i < pool->worker_count; i++)
        pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->wake);
    pthread_mutex_destroy(&pool->mutex);
    memory_free(context, pool->workers);
    memory_free(context, pool);
    context->pool = NULL;
}

static pnb_status run(pnb_context *context, const char *stage, double first, double last,
                      size_t count, size_t grain, parallel_body *body, void *user)
{
    bool (*progress)(void *, const char *, double) = stage ? context->desc.progress : NULL;
    if (grain == 0)
        grain = 1;
    struct pool alone;
    struct pool *pool = count > grain ? pool_get(context) : NULL;
    bool shared = pool && pool->worker_count > 0;
    if (!shared)
        pool = &alone;

    pool->body = body;
    pool->user = user;
    pool->count = count;
    pool->grain = grain;
    atomic_store(&pool->next, 0);
    atomic_store(&pool->cancelled, false);
    if (shared) {
        pthread_mutex_lock(&pool->mutex);
        pool->generation++;
        pool->busy = pool->worker_count;
        pthread_cond_broadcast(&pool->wake);
        pthread_mutex_unlock(&pool->mutex);
    }

    double reported = clock_ms();
    while (take(pool, 0)) {
        if (!progress)
            continue;
        double now = clock_ms();
        if (now - reported < REPORT_EVERY_MS)
            continue;
        reported = now;
        size_t done = atomic_load(&pool->next);
        double share = done < count ? (double)done / (double)count : 1.0;
        if (!progress(context->desc.user, stage, first + (last - first) * share))
            atomic_store(&pool->cancelled, true);
    }

    if (shared) {
        pthread_mutex_lock(&pool->mutex);
        while (pool->busy > 0)
            pthread_cond_wait(&pool->idle, &pool->mutex);
        pthread_mutex_unlock(&pool->mutex);
    }
    if (atomic_load(&pool->cancelled))
        return status_fail(context, PNB_ERROR_CANCELLED, stage, "cancelled");
    if (progress && !progress(context->desc.user, stage, last))
        return status_fail(context, PNB_ERROR_CANCELLED, stage, "cancelled");
    return PNB_OK;
}

void parallel_for(pnb_context *context, size_t count, size_t grain, parallel_body *body, void *user)
{
    run(context, NULL, 0, 0, count, grain, body, user);
}

pnb_status parallel_for_progress(pnb_context *context, const char *stage, double first, double last,
                                 size_t count, size_t grain, parallel_body *body, void *user)
{
    return run(context, stage, first, last, count, grain, body, user);
}
