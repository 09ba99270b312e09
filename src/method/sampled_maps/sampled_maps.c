/* method/sampled_maps/sampled_maps.c: the baselines of shadow mapping: sampled-maps, the mean of N
 * point lights, and hard-map, one point in the light's middle.
 *
 * Input: any light but the sun; receivers. Output: the share of N samples whose depth map sees the
 * receiver: N + 1 levels.
 *
 * A line light's samples are the middles of N equal pieces (placement=ends: from end to end, as in
 * the paper's comparison); an area light's are N points of an Owen-scrambled Sobol sequence. Maps
 * are those of map/: a line's samples share one set of rows; an area light's have a set each, in
 * rows around a line of their own, along the light's plane. Depth test, bias and resolution are
 * those of line-map.
 *
 * Cost: O(N (triangles x rows + size^2)) to build, O(N) a receiver. Memory: 4 size^2 bytes a map,
 * all of a line's at once, one of an area light's.
 */
#include <string.h>

#include "light/light.h"
#include "map/map.h"
#include "method/method.h"
#include "method/sampled_maps/opengl.h"

struct sampled_maps {
    struct map_geometry *geometry;
    int size;
    double bias;
    bool ends;
};

struct sum_job {
    const struct map_set *set;
    const struct light_shape *shape;
    const pnb_receivers *receivers;
    float *visibility;
    float share, bias;
    bool first, last; /* of the sets */
};

static pnb_status sampled_create(pnb_solver *solver)
{
    if (opengl_wanted(solver))
        return opengl_create(solver);
    struct sampled_maps *m = solver->state = memory_calloc(solver->context, 1, sizeof(*m));
    if (!m)
        return status_no_memory(solver->context, sizeof(*m));
    m->size = solver_param_integer(solver, "size");
    m->bias = solver_param_number(solver, "bias");
    m->ends = strcmp(solver_param(solver, "placement"), "ends") == 0;
    return map_geometry_create(solver->scene, &m->geometry);
}

static void sampled_destroy(pnb_solver *solver)
{
    struct sampled_maps *m = solver->state;
    if (solver->opengl)
        opengl_destroy(solver);
    if (m)
        map_geometry_destroy(m->geometry);
    memory_free(solver->context, m);
}

static pnb_status sampled_update(pnb_solver *solver, pnb_update update)
{
    struct sampled_maps *m = solver->state;
    if (solver->opengl)
        return opengl_update(solver, update);
    return map_geometry_update(solver->scene, &m->geometry);
}

static void sum_body(void *user, size_t begin, size_t end, int worker)
{
    const struct sum_job *job = user;
    const struct map_set *set = job->set;
    for (size_t i = begin; i < end; i++) {
        const float *p = job->receivers->positions + 3 * i, *n = job->receivers->normals + 3 * i;
        struct map_point point;
        if (!isfinite(p[0] + p[1] + p[2] + n[0] + n[1] + n[2])) {
            job->visibility[i] = NAN;
            continue;
        }
        size_t seen = 0;
        if (light_shape_lit_side(job->shape, v3_loadf(p))) {
            map_locate(set, p, n, &point);
            for (size_t k = 0; k < set->count; k++) {
                const struct map *map = &set->maps[k];
                double t = set->length > 0 ? map->at / set->length : 0;
                double height =
                    point.height_low + ((double)point.height_high - point.height_low) * t;
                float bias = job->bias * map_texel(set, map);
                seen += height > 0 && map_seen(set, map, &point, bias) &&
                        !(point.below_floor && map_beneath_floor(set, &point, map->at));
            }
        }
        /* Counts first, the division last: sums of counts are exact. */
        float sum = (job->first ? 0 : job->visibility[i]) + (float)seen;
        job->visibility[i] = job->last ? sum * job->share : sum;
    }
}

/* The maps of samples at the given places along a line, and their part in the sum. */
static pnb_status do_set(pnb_solver *solver, vec3 origin, vec3 axis, double length,
                         const struct map_sample *samples, size_t count, struct sum_job *job)
{
    struct sampled_maps *m = solver->state;
    struct map_set *set;
    struct map_set_desc desc = {m->geometry, origin, axis, length, m->size, m->size};
    pnb_status status = map_set_create(&desc, &set);
    if (status != PNB_OK)
        return status;
    status = map_set_add(set, samples, count);
    if (status == PNB_OK) {
        job->set = set;
        parallel_for(solver->context, job->receivers->count, 2048, sum_body, job);
    }
    map_set_destroy(set);
    return status;
}

static pnb_status do_line(pnb_solver *solver, const struct light_shape *shape, size_t count,
                          struct sum_job *job)
{
    struct sampled_maps *m = solver->state;
    struct map_sample *samples = memory_alloc(solver->context, count, sizeof(*samples));
    if (!samples)
        return status_no_memory(solver->context, count * sizeof(*samples));
    double length = v3_length(shape->axis_u);
    for (size_t i = 0; i < count; i++) {
        double at = ((double)i + 0.5) / (double)count * length;
        if (m->ends && count > 1)
            at = (double)i / (double)(count - 1) * length;
        samples[i] = (struct map_sample){at, at, at};
    }
    pnb_status status =
        do_set(solver, shape->origin, v3_normalize(shape->axis_u), length, samples, count, job);
    memory_free(solver->context, samples);
    return status;
}

static pnb_status sampled_visibility(pnb_solver *solver, const pnb_light *light,
                                     const pnb_receivers *receivers, float *visibility)
{
    struct sampled_maps *m = solver->state;
    if (solver->opengl)
        return opengl_visibility(solver, light, receivers, visibility);
    struct light_shape shape;
    pnb_status status = light_shape_init(solver->context, light, &shape);
    if (status != PNB_OK)
        return status;
    size_t count =
        solver->samples > 0 && light->type != PNB_LIGHT_POINT ? (size_t)solver->samples : 1;
    struct sum_job job = {.shape = &shape,
                          .receivers = receivers,
                          .visibility = visibility,
                          .share = 1 / (float)count,
                          .bias = (float)m->bias,
                          .first = true,
                          .last = true};
    if (light->type == PNB_LIGHT_LINE) {
        status = do_line(solver, &shape, count, &job);
    } else {
        vec3 axis = v3(1, 0, 0);
        if (light->type != PNB_LIGHT_POINT)
            axis = v3_normalize(shape.axis_u);
        const struct map_sample here = {0, 0, 0};
        for (size_t i = 0; i < count && status == PNB_OK; i++) {
            float u = 0.5f, v = 0.5f;
            if (count > 1)
                light_sobol_owen((uint32_t)i, 1, &u, &v);
            job.first = i == 0;
            job.last = i + 1 == count;
            status = do_set(solver, light_shape_sample(&shape, u, v).p, axis, 0, &here, 1, &job);
        }
    }
    solver_count(solver, "maps", (double)count);
    light_shape_finish(solver->context, &shape);
    return status;
}

#define LIGHTS                                                                                     \
    (PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |                          \
     PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) | PNB_LIGHT_BIT(PNB_LIGHT_LINE) |                            \
     PNB_LIGHT_BIT(PNB_LIGHT_POINT))

static const pnb_param_info params[] = {
    {"size", PNB_PARAM_INTEGER, "1024", 2, 16384, NULL, "a map has size x size texels"},
    {"bias", PNB_PARAM_NUMBER, "1", 0, 1000, NULL, "of the depth test, in texels"},
    {"path", PNB_PARAM_CHOICE, "cpu", 0, 0, "cpu|opengl",
     "where: on the CPU, or on OpenGL (pixels of an image only)"},
    {"placement", PNB_PARAM_CHOICE, "cells", 0, 0, "cells|ends",
     "samples of a line: middles of equal pieces, or from end to end"},
};

const struct method method_sampled_maps = {
    .info =
        {
            .name = "sampled-maps",
            .title = "averaged shadow maps",
            .paper = "",
            .summary = "The brute force of shadow mapping: N depth maps from points of the light, "
                       "averaged.",
            .lights = LIGHTS,
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_CPU,
            .opengl_path = true,
            .samples = true,
            .default_samples = 16,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = sampled_create,
    .destroy = sampled_destroy,
    .update = sampled_update,
    .visibility = sampled_visibility,
    .opengl = &sampled_maps_opengl,
};

const struct method method_hard_map = {
    .info =
        {
            .name = "hard-map",
            .title = "shadow map",
            .paper = "Williams: Casting Curved Shadows on Curved Surfaces (1978)",
            .summary = "One depth map from the middle of the light: what soft shadows reduce to "
                       "for a point.",
            .lights = LIGHTS,
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_CPU,
            .opengl_path = true,
            .params = params,
            .param_count = 3,
        },
    .create = sampled_create,
    .destroy = sampled_destroy,
    .update = sampled_update,
    .visibility = sampled_visibility,
    .opengl = &sampled_maps_opengl,
};
