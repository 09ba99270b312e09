/* planar/workspace.c: the memory that sweeps reuse, and growing inputs. */
#include "planar/inside.h"

bool workspace_grow(struct planar_workspace *w, void **array, size_t *capacity, size_t count,
                    size_t more, size_t size)
{
    if (w->no_memory || !memory_reserve(w->context, array, capacity, count, more, size)) {
        w->no_memory = true;
        return false;
    }
    return true;
}

pnb_status planar_workspace_create(pnb_context *context, struct planar_workspace **out_workspace)
{
    struct planar_workspace *w = memory_calloc(context, 1, sizeof(*w));
    *out_workspace = w;
    if (!w)
        return status_no_memory(context, sizeof(*w));
    w->context = context;
    return PNB_OK;
}

void planar_workspace_destroy(struct planar_workspace *w)
{
    if (!w)
        return;
    void *blocks[] = {w->points,         w->work,     w->edges,  w->triangles,    w->trapezoids,
                      w->status,         w->heap,     w->nodes,  w->diagonals,    w->rank,
                      w->first,          w->incoming, w->sorted, w->spare,        w->stack,
                      w->queued,         w->slots,    w->next,   w->leaving,      w->leaving_next,
                      w->walk,           w->loops,    w->holes,  w->given_points, w->given_ids,
                      w->given_segments, w->values};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(w->context, blocks[i]);
    memory_free(w->context, w);
}

void planar_input_finish(pnb_context *context, struct planar_input *input)
{
    memory_free(context, input->points);
    memory_free(context, input->segments);
    *input = (struct planar_input){0};
}

pnb_status planar_input_reserve(pnb_context *context, struct planar_input *input,
                                size_t more_points, size_t more_segments)
{
    if (!memory_reserve(context, (void **)&input->points, &input->point_capacity,
                        input->point_count, more_points, sizeof(*input->points)) ||
        !memory_reserve(context, (void **)&input->segments, &input->segment_capacity,
                        input->segment_count, more_segments, sizeof(*input->segments)))
        return status_no_memory(context, (more_points + more_segments) * 12);
    return PNB_OK;
}
