/* method/line_map/auto.c: where to add samples, which the paper leaves open.
 *
 * A segment is undersampled where parts of it are seen that neither of its ends sees, or hidden
 * though both see the receiver. That is measured, not guessed: every segment gets a sample in its
 * middle, and the visibility of some PROBES of the receivers before is held against that after. The
 * root mean square difference over the penumbra estimates the error before; the result is the one
 * after, which is better. While the estimate exceeds the target, the segments that caused it are
 * split again; those whose share of it is small stay as they are.
 *
 * Ends at the sample limit with the estimate it has reached.
 */
#include <string.h>

#include "method/line_map/line_map.h"

#define PROBES 32768

struct probe_job {
    const struct line_map_light *light;
    const pnb_receivers *receivers;
    size_t stride;
    float *visibility; /* probes */
    float *shares;     /* probes x segments */
    size_t segments;
};

static void probe_body(void *user, size_t begin, size_t end, int worker)
{
    struct probe_job *job = user;
    for (size_t i = begin; i < end; i++) {
        /* One of each run of `stride`, by a hash, so that probes fall into no pattern. */
        uint32_t hash = (uint32_t)i * 0x9e3779b9u;
        hash ^= hash >> 15;
        size_t k = i * job->stride + hash % job->stride;
        const float *p = job->receivers->positions + 3 * k, *n = job->receivers->normals + 3 * k;
        bool none = !isfinite(p[0] + p[1] + p[2] + n[0] + n[1] + n[2]);
        if (none)
            memset(job->shares + i * job->segments, 0, job->segments * sizeof(float));
        job->visibility[i] =
            none ? NAN : (float)line_map_look_up(job->light, p, n, job->shares + i * job->segments);
    }
}

static pnb_status probe(struct probe_job *job, size_t probes)
{
    pnb_context *context = job->light->context;
    job->segments = job->light->segment_count;
    job->visibility = memory_alloc(context, probes, sizeof(float));
    job->shares = memory_alloc(context, probes * job->segments, sizeof(float));
    if (!job->visibility || !job->shares)
        return status_no_memory(context, probes * (job->segments + 1) * sizeof(float));
    parallel_for(context, probes, 1024, probe_body, job);
    return PNB_OK;
}

static void probe_finish(struct probe_job *job)
{
    memory_free(job->light->context, job->visibility);
    memory_free(job->light->context, job->shares);
}

/* Root mean square difference over the penumbra, and each old segment's mean square part in it.
 * parents: of the new segments, in order. */
static double difference(const struct probe_job *before, const struct probe_job *after,
                         const size_t *parents, size_t probes, double *parts)
{
    const struct line_map_light *light = after->light;
    const struct map_set *set = light->set;
    double sum = 0;
    size_t count = 0;
    for (size_t s = 0; s < before->segments; s++)
        parts[s] = 0;
    for (size_t i = 0; i < probes; i++) {
        double d = (double)after->visibility[i] - before->visibility[i];
        if (!isfinite(d))
            continue;
        bool penumbra = after->visibility[i] > 0 && after->visibility[i] < 1;
        if (!penumbra && !(fabs(d) > 1.0 / 255))
            continue;
        count++;
        sum += d * d;
        double change = 0;
        for (size_t s = 0; s < after->segments; s++) {
            const struct line_map_segment *segment = &light->segments[s];
            double length = set->maps[segment->right].at - set->maps[segment->left].at;
            double now = after->shares[i * after->segments + s];
            change += (now - before->shares[i * before->segments + parents[s]]) * length;
            if (s + 1 == after->segments || parents[s + 1] != parents[s]) {
                parts[parents[s]] += change * change / (set->length * set->length);
                change = 0;
            }
        }
    }
    for (size_t s = 0; s < before->segments; s++)
        parts[s] /= count ? (double)count : 1;
    return count ? sqrt(sum / (double)count) : 0;
}

pnb_status line_map_refine(struct line_map_light *light, const pnb_receivers *receivers,
                           size_t most_samples, double *out_estimate)
{
    pnb_context *context = light->context;
    size_t stride = receivers->count / PROBES + 1, probes = receivers->count / stride;
    struct probe_job before = {light, receivers, stride, NULL, NULL, 0};
    const double target = light->method->target;
    *out_estimate = 0;
    if (light->segment_count == 0 || probes == 0)
        return PNB_OK;
    pnb_status status = probe(&before, probes);
    for (bool again = true; again && status == PNB_OK;) {
        size_t old = light->segment_count, open = 0;
        for (size_t s = 0; s < old; s++)
            open += !light->segments[s].settled;
        if (open == 0 || light->set->count + open > most_samples)
            break;
        size_t *parents = memory_alloc(context, old + open, sizeof(*parents));
        double *parts = memory_alloc(context, old, sizeof(*parts));
        struct probe_job after = {light, receivers, stride, NULL, NULL, 0};
        if (!parents || !parts)
            status = status_no_memory(context, (old + open) * sizeof(*parents));
        for (size_t s = 0, k = 0; s < old && status == PNB_OK; s++) {
            parents[k++] = s;
            if (!light->segments[s].settled)
                parents[k++] = s;
        }
        if (status == PNB_OK)
            status = line_map_light_split(light);
        if (status == PNB_OK)
            status = probe(&after, probes);
        if (status == PNB_OK) {
            *out_estimate = difference(&before, &after, parents, probes, parts);
            again = *out_estimate > target;
            double small = 0.25 * target * target / (double)old;
            for (size_t s = 0; s < light->segment_count; s++)
                light->segments[s].settled =
                    light->segments[s].settled || parts[parents[s]] < small;
        }
        memory_free(context, parents);
        memory_free(context, parts);
        probe_finish(&before);
        before = after;
    }
    probe_finish(&before);
    return status;
}
