/* viewer/frame.c: frames and their pool. At most POOL_MAX frames lie idle. */
#include "frame.h"

#include <stdlib.h>

enum { POOL_MAX = 4 };

struct view_frame_pool {
    int references; /* the owner's, and one per frame */
    GMutex mutex;
    struct view_frame *idle[POOL_MAX];
    int idle_count;
};

struct view_frame_pool *view_frame_pool_create(void)
{
    struct view_frame_pool *pool = g_new0(struct view_frame_pool, 1);
    pool->references = 1;
    g_mutex_init(&pool->mutex);
    return pool;
}

static void free_frame(struct view_frame *frame)
{
    for (int side = 0; side < VIEW_SIDES; side++) {
        free(frame->bgra[side]);
        free(frame->visibility[side]);
    }
    free(frame->truth);
    free(frame->objects);
    g_free(frame);
}

void view_frame_pool_unref(struct view_frame_pool *pool)
{
    if (!pool || !g_atomic_int_dec_and_test(&pool->references))
        return;
    for (int i = 0; i < pool->idle_count; i++)
        free_frame(pool->idle[i]);
    g_mutex_clear(&pool->mutex);
    g_free(pool);
}

static struct view_frame *new_frame(size_t capacity)
{
    struct view_frame *frame = g_new0(struct view_frame, 1);
    bool good = true;
    for (int side = 0; side < VIEW_SIDES; side++) {
        frame->bgra[side] = malloc(capacity * 4);
        frame->visibility[side] = malloc(capacity * sizeof(float));
        good = good && frame->bgra[side] && frame->visibility[side];
    }
    frame->truth = malloc(capacity * sizeof(float));
    frame->objects = malloc(capacity * sizeof(uint32_t));
    frame->capacity = capacity;
    if (good && frame->truth && frame->objects)
        return frame;
    free_frame(frame);
    return NULL;
}

struct view_frame *view_frame_acquire(struct view_frame_pool *pool, int width, int height,
                                      size_t capacity)
{
    size_t pixels = MAX((size_t)width * (size_t)height, capacity);
    struct view_frame *frame = NULL;
    g_mutex_lock(&pool->mutex);
    while (pool->idle_count > 0 && !frame) {
        frame = pool->idle[--pool->idle_count];
        /* Neither too small nor kept from a much larger canvas. */
        if (frame->capacity < pixels || frame->capacity > 4 * pixels) {
            free_frame(frame);
            frame = NULL;
        }
    }
    g_mutex_unlock(&pool->mutex);
    if (!frame)
        frame = new_frame(pixels);
    if (!frame)
        return NULL;
    struct view_frame fresh = {.references = 1,
                               .pool = pool,
                               .capacity = frame->capacity,
                               .width = width,
                               .height = height,
                               .truth = frame->truth,
                               .objects = frame->objects};
    for (int side = 0; side < VIEW_SIDES; side++) {
        fresh.bgra[side] = frame->bgra[side];
        fresh.visibility[side] = frame->visibility[side];
    }
    *frame = fresh;
    g_atomic_int_inc(&pool->references);
    return frame;
}

struct view_frame *view_frame_ref(struct view_frame *frame)
{
    g_atomic_int_inc(&frame->references);
    return frame;
}

void view_frame_unref(struct view_frame *frame)
{
    if (!frame || !g_atomic_int_dec_and_test(&frame->references))
        return;
    struct view_frame_pool *pool = frame->pool;
    view_state_finish(&frame->state);
    g_mutex_lock(&pool->mutex);
    bool keep = pool->idle_count < POOL_MAX;
    if (keep)
        pool->idle[pool->idle_count++] = frame;
    g_mutex_unlock(&pool->mutex);
    if (!keep)
        free_frame(frame);
    view_frame_pool_unref(pool);
}
