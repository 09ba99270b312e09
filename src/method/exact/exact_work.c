/* method/exact/exact_work.c: the memory that one thread works in. */
#include <string.h>

#include "method/exact/exact.h"

/* Which of an edge's uses cancel: by the two states and whether both run the same way. 0: nothing
 * is left, 1: its weight is known, 2: it depends on the receiver. */
static uint8_t edge_class(int s0, int s1, int same_way)
{
    if (s0 == OPEN || s1 == OPEN)
        return 2;
    if ((same_way ? s0 + s1 == FRONT + BACK : s0 == s1) || (s0 == DROPPED && s1 == DROPPED))
        return 0;
    return 1;
}

bool exact_work_init(pnb_context *context, const struct exact_scene *scene, struct exact_work *work)
{
    memset(work, 0, sizeof(*work));
    work->context = context;
    work->into = &work->edges;
    for (int i = 0; i < 32; i++)
        work->edge_class[i] = edge_class(i & 3, i >> 2 & 3, !(i >> 4));
    size_t slots = (scene->slots_max + CLUSTER_SIZE - 1) / CLUSTER_SIZE * CLUSTER_SIZE;
    work->state = memory_calloc(context, slots + 1, 1); /* and one that stands for none */
    work->cluster_state = memory_calloc(context, scene->clusters_max, 1);
    work->kept = memory_alloc(context, scene->clusters_max, sizeof(*work->kept));
    work->centers = memory_calloc(context, scene->clusters_max, sizeof(*work->centers));
    work->vertex_weight = memory_calloc(context, scene->vertices_max, sizeof(*work->vertex_weight));
    work->candidates = memory_alloc(context, scene->instance_capacity, sizeof(*work->candidates));
    work->nearby = memory_alloc(context, scene->instance_capacity, 2 * sizeof(*work->nearby));
    work->found = work->nearby + scene->instance_capacity;
    return work->nearby && work->state && work->cluster_state && work->kept && work->centers &&
           work->vertex_weight && work->candidates;
}

bool exact_work_prepare(struct exact_work *work, const struct exact_grid *grid)
{
    memory_free(work->context, work->cells);
    memory_free(work->context, work->left);
    work->cells = memory_calloc(work->context, exact_cover_size(grid), sizeof(*work->cells));
    work->left = memory_calloc(work->context, EXACT_ROWS_MAX, sizeof(*work->left));
    memory_free(work->context, work->bits);
    size_t rows = (size_t)(grid->rows * grid->words);
    size_t size =
        rows * (EXACT_TILE + 18 * EXACT_LANES) + (size_t)(2 * grid->rows + 1) * EXACT_LANES;
    work->bits = memory_calloc(work->context, size + 16, sizeof(int32_t));
    work->hidden = (int32_t *)(((uintptr_t)work->bits + 63) & ~(uintptr_t)63);
    work->near = work->hidden + rows * EXACT_TILE;
    work->far = work->near + rows * 4 * EXACT_LANES;
    work->spare = work->far + rows * 12 * EXACT_LANES;
    work->turns = work->spare + (size_t)grid->rows * EXACT_LANES;
    work->steps = work->turns + 2 * rows * EXACT_LANES;
    memset(&work->stats, 0, sizeof(work->stats));
    work->no_memory = false;
    return work->cells && work->left && work->bits;
}

void exact_work_finish(struct exact_work *work)
{
    if (!work->context)
        return;
    memory_free(work->context, work->state);
    memory_free(work->context, work->cluster_state);
    memory_free(work->context, work->kept);
    memory_free(work->context, work->centers);
    memory_free(work->context, work->vertex_weight);
    memory_free(work->context, work->ends);
    memory_free(work->context, work->edges.steps);
    memory_free(work->context, work->list[0]);
    memory_free(work->context, work->list[1]);
    memory_free(work->context, work->edges.fixed);
    memory_free(work->context, work->edges.open);
    memory_free(work->context, work->solid_edges.fixed);
    memory_free(work->context, work->solid_edges.open);
    memory_free(work->context, work->solids);
    memory_free(work->context, work->loose);
    memory_free(work->context, work->loose_frame);
    memory_free(work->context, work->near_frame);
    memory_free(work->context, work->cells);
    memory_free(work->context, work->left);
    memory_free(work->context, work->candidates);
    memory_free(work->context, work->nearby);
    memory_free(work->context, work->bits);
    memory_free(work->context, work->picks_memory);
}
