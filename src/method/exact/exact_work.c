/* method/exact/exact_work.c: the memory that one thread works in. */
#include <string.h>

#include "method/exact/exact.h"

bool exact_work_init(pnb_context *context, const struct exact_scene *scene, struct exact_work *work)
{
    memset(work, 0, sizeof(*work));
    work->context = context;
    size_t slots = (scene->slots_max + CLUSTER_SIZE - 1) / CLUSTER_SIZE * CLUSTER_SIZE;
    work->state = memory_calloc(context, slots, 1);
    work->cluster_state = memory_calloc(context, scene->clusters_max, 1);
    work->kept = memory_alloc(context, scene->clusters_max, sizeof(*work->kept));
    work->candidates = memory_alloc(context, scene->instance_count, sizeof(*work->candidates));
    return work->state && work->cluster_state && work->kept && work->candidates;
}

bool exact_work_prepare(struct exact_work *work, const struct exact_grid *grid)
{
    memory_free(work->context, work->cells);
    memory_free(work->context, work->left);
    work->cells = memory_calloc(work->context, exact_cover_size(grid), sizeof(*work->cells));
    work->left = memory_calloc(work->context, EXACT_ROWS_MAX, sizeof(*work->left));
    memory_free(work->context, work->hidden);
    work->hidden = memory_calloc(work->context, EXACT_TILE * EXACT_ROWS_MAX, sizeof(*work->hidden));
    memset(&work->stats, 0, sizeof(work->stats));
    work->no_memory = false;
    return work->cells && work->left && work->hidden;
}

void exact_work_finish(struct exact_work *work)
{
    if (!work->context)
        return;
    memory_free(work->context, work->state);
    memory_free(work->context, work->cluster_state);
    memory_free(work->context, work->kept);
    memory_free(work->context, work->edges.fixed);
    memory_free(work->context, work->edges.open);
    memory_free(work->context, work->loose);
    memory_free(work->context, work->loose_frame);
    memory_free(work->context, work->cells);
    memory_free(work->context, work->left);
    memory_free(work->context, work->candidates);
    memory_free(work->context, work->hidden);
    memory_free(work->context, work->hits.fields);
    memory_free(work->context, work->hits.list);
}
