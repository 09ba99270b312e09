/* method/line_map/line_map.c: soft shadow maps for linear lights (Heidrich, Brabec, Seidel 2000) on
 * the CPU.
 *
 * Input: a line light, or a polygon or rectangle taken by its edges; receivers. Output: per
 * receiver the share of the light that it sees, from k >= 2 depth maps and their visibility
 * channels.
 *
 *   map/         k depth maps in rows through the light's line, so that warping stays in a row
 *   skins.c      discontinuities, skins warped into the neighbouring map: the channels
 *   light.c      the look-up: both samples see p: all of the segment; one: its channel; none: umbra
 *   auto.c       samples=auto
 *
 * Differs from the paper: rows instead of a perspective image (any direction, lights inside the
 * scene, and skins need no polygon rasteriser); the rational transition of its equation 1 instead
 * of the linear one (transition=linear brings that back); overlapping skins keep the least share
 * (overlap=nearest: the depth buffer). Maps are built anew for each frame. The channels hold what
 * is seen from one sample; the sums of the paper's figure 7 are formed at the look-up.
 *
 * Area lights by their edges, as in the paper's figure 8: the mean over the edges, by length.
 * Crude: the inside of the light is not looked at.
 *
 * Cost: O(triangles x rows + k size^2) to build, O(k) a receiver. Memory: 4 size^2 bytes a map and
 * 4 size^2 a segment. Limits: parts of the light that no sample sees are dark; what is thin enough
 * to hide the middle of a segment but neither end is not seen. Receivers that are not surfaces of
 * the scene get the channel of the surface behind them.
 */
#include "method/line_map/line_map.h"

#include <string.h>

#include "method/opengl.h"

#define AUTO_MOST  129 /* samples=auto stops here */
#define FIXED_MOST 1025

pnb_status line_map_read_params(pnb_solver *solver, struct line_map *m)
{
    m->automatic = strcmp(solver_param(solver, "samples"), "auto") == 0;
    m->linear = strcmp(solver_param(solver, "transition"), "linear") == 0;
    m->nearest = strcmp(solver_param(solver, "overlap"), "nearest") == 0;
    m->own_edges = strcmp(solver_param(solver, "edges"), "both") == 0;
    m->spans = strcmp(solver_param(solver, "between"), "spans") == 0;
    m->target = solver_param_number(solver, "target");
    m->threshold = solver_param_number(solver, "threshold");
    m->bias = solver_param_number(solver, "bias");
    m->size = solver_param_integer(solver, "size");
    m->rows = m->columns = m->size;
    if (solver->samples < 2)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "samples",
                           "line-map needs 2 or more: the ends of the light");
    if (solver->samples > FIXED_MOST)
        return status_fail(solver->context, PNB_ERROR_ARGUMENT, "samples",
                           "line-map takes %d at most, each has its map", FIXED_MOST);
    return PNB_OK;
}

static pnb_status line_map_create(pnb_solver *solver)
{
    if (opengl_wanted(solver))
        return opengl_create(solver);
    struct line_map *m = solver->state = memory_calloc(solver->context, 1, sizeof(*m));
    if (!m)
        return status_no_memory(solver->context, sizeof(*m));
    pnb_status status = line_map_read_params(solver, m);
    return status == PNB_OK ? map_geometry_create(solver->scene, &m->geometry) : status;
}

static void line_map_destroy(pnb_solver *solver)
{
    if (solver->opengl) {
        opengl_destroy(solver);
        return;
    }
    struct line_map *m = solver->state;
    if (m)
        map_geometry_destroy(m->geometry);
    memory_free(solver->context, m);
}

static pnb_status line_map_update(pnb_solver *solver, pnb_update update)
{
    if (solver->opengl)
        return opengl_update(solver, update);
    struct line_map *m = solver->state;
    return map_geometry_update(solver->scene, &m->geometry);
}

struct look_up_job {
    const struct line_map_light *light;
    const struct light_shape *shape;
    const pnb_receivers *receivers;
    float *visibility;
    double weight; /* of this edge in the sum */
    bool first;
};

static void look_up_body(void *user, size_t begin, size_t end, int worker)
{
    const struct look_up_job *job = user;
    for (size_t i = begin; i < end; i++) {
        const float *p = job->receivers->positions + 3 * i, *n = job->receivers->normals + 3 * i;
        if (!isfinite(p[0] + p[1] + p[2] + n[0] + n[1] + n[2])) {
            job->visibility[i] = NAN;
            continue;
        }
        double seen = 0;
        if (job->shape->light.type == PNB_LIGHT_LINE ||
            light_shape_lit_side(job->shape, v3_loadf(p)))
            seen = line_map_look_up(job->light, p, n, NULL);
        if (job->weight == 1)
            job->visibility[i] = (float)seen;
        else if (job->first)
            job->visibility[i] = (float)(job->weight * seen);
        else
            job->visibility[i] = fminf(job->visibility[i] + (float)(job->weight * seen), 1);
    }
}

/* One linear light: maps, channels, and its part in the visibility of all receivers. */
static pnb_status do_edge(pnb_solver *solver, vec3 from, vec3 to, struct look_up_job *job)
{
    struct line_map *m = solver->state;
    struct line_map_light *light;
    size_t samples = m->automatic && solver->samples < LINE_MAP_AUTO_START
                         ? LINE_MAP_AUTO_START
                         : (size_t)solver->samples;
    pnb_status status = line_map_light_create(m, from, to, samples, &light);
    if (status != PNB_OK)
        return status;
    if (m->automatic) {
        double estimate;
        status = line_map_refine(light, job->receivers, AUTO_MOST, &estimate);
        m->estimate = fmax(m->estimate, estimate);
        if (status == PNB_OK && estimate > m->target)
            solver_warn(solver,
                        "samples=auto stopped at %zu samples with an estimated error of %.3g",
                        light->set->count, estimate);
    }
    if (status == PNB_OK) {
        double started = clock_ms();
        job->light = light;
        status = parallel_for_progress(solver->context, "visibility", 0, 1, job->receivers->count,
                                       2048, look_up_body, job);
        m->look_up_ms += clock_ms() - started;
        m->maps += (double)light->set->count;
    }
    line_map_light_destroy(light);
    return status;
}

size_t line_map_edge_count(const pnb_light *light)
{
    if (light->type == PNB_LIGHT_LINE)
        return 1;
    return light->type == PNB_LIGHT_POLYGON ? light->shape.polygon.vertex_count : 4;
}

static vec3 corner(const pnb_light *light, const struct light_shape *shape, size_t k)
{
    if (light->type == PNB_LIGHT_POLYGON)
        return v3_load(light->shape.polygon.vertices + 3 * (k % light->shape.polygon.vertex_count));
    vec3 p = shape->origin;
    if (k % 4 == 1 || k % 4 == 2)
        p = v3_add(p, shape->axis_u);
    if (k % 4 == 2 || k % 4 == 3)
        p = v3_add(p, shape->axis_v);
    return p;
}

double line_map_edge(const pnb_light *light, const struct light_shape *shape, size_t k,
                     vec3 *out_from, vec3 *out_to)
{
    if (light->type == PNB_LIGHT_LINE) {
        *out_from = shape->origin;
        *out_to = v3_add(shape->origin, shape->axis_u);
        return 1;
    }
    double around = 0;
    for (size_t i = 0; i < line_map_edge_count(light); i++)
        around += v3_length(v3_sub(corner(light, shape, i + 1), corner(light, shape, i)));
    *out_from = corner(light, shape, k);
    *out_to = corner(light, shape, k + 1);
    return v3_length(v3_sub(*out_to, *out_from)) / around;
}

void line_map_reset_counters(struct line_map *m)
{
    m->map_ms = m->skin_ms = m->look_up_ms = 0;
    m->maps = m->skins = m->texels = m->estimate = 0;
}

void line_map_report(pnb_solver *solver, const struct line_map *m, const pnb_light *light)
{
    if (light->type != PNB_LIGHT_LINE)
        solver_warn(solver, "an area light is taken by its edges, which is crude");
    solver_count(solver, "maps", m->maps);
    solver_count(solver, "skins", m->skins);
    if (!solver->opengl)
        solver_count(solver, "skin texels", m->texels);
    solver_count(solver, "map ms", m->map_ms);
    solver_count(solver, "skin ms", m->skin_ms);
    solver_count(solver, "look-up ms", m->look_up_ms);
    if (m->automatic)
        solver_count(solver, "estimated error", m->estimate);
}

static pnb_status line_map_visibility(pnb_solver *solver, const pnb_light *light,
                                      const pnb_receivers *receivers, float *visibility)
{
    if (solver->opengl)
        return opengl_visibility(solver, light, receivers, visibility);
    struct line_map *m = solver->state;
    struct light_shape shape;
    pnb_status status = light_shape_init(solver->context, light, &shape);
    if (status != PNB_OK)
        return status;
    line_map_reset_counters(m);
    struct look_up_job job = {.shape = &shape, .receivers = receivers, .visibility = visibility};
    for (size_t k = 0; k < line_map_edge_count(light) && status == PNB_OK; k++) {
        vec3 from, to;
        job.weight = line_map_edge(light, &shape, k, &from, &to);
        job.first = k == 0;
        status = do_edge(solver, from, to, &job);
    }
    line_map_report(solver, m, light);
    light_shape_finish(solver->context, &shape);
    return status;
}

static const pnb_param_info params[] = {
    {"path", PNB_PARAM_CHOICE, "cpu", 0, 0, "cpu|opengl", "the same algorithm on either"},
    {"samples", PNB_PARAM_CHOICE, "given", 0, 0, "given|auto",
     "auto: as many samples, and where, as the target error asks for"},
    {"target", PNB_PARAM_NUMBER, "0.02", 0.0001, 1, NULL,
     "samples=auto: root mean square error in the penumbra"},
    {"size", PNB_PARAM_INTEGER, "1024", 2, 16384, NULL, "a map has size x size texels"},
    {"transition", PNB_PARAM_CHOICE, "rational", 0, 0, "rational|linear",
     "across a penumbra: the paper's equation 1, or its linear approximation"},
    {"overlap", PNB_PARAM_CHOICE, "least", 0, 0, "least|nearest",
     "of overlapping penumbrae keep the least visibility, or the paper's nearest skin"},
    {"edges", PNB_PARAM_CHOICE, "both", 0, 0, "both|other",
     "of a map's penumbrae: as both samples see them, or the paper's, as the other sample does"},
    {"between", PNB_PARAM_CHOICE, "spans", 0, 0, "spans|dark",
     "between samples that see little: what the occluders in all maps leave, or the paper's"},
    {"threshold", PNB_PARAM_NUMBER, "0", 0, 1e9, NULL,
     "metres of depth that make a discontinuity; 0: two texels"},
    {"bias", PNB_PARAM_NUMBER, "1", 0, 1000, NULL, "of the depth test, in texels"},
};

const struct method method_line_map = {
    .info =
        {
            .name = "line-map",
            .title = "soft shadow maps for linear lights",
            .paper = "Heidrich, Brabec, Seidel: Soft Shadow Maps for Linear Lights (2000)",
            .summary = "Two or more depth maps along a linear light; the penumbrae between them "
                       "come from their depth discontinuities. Area lights by their edges, "
                       "crudely.",
            .lights = PNB_LIGHT_BIT(PNB_LIGHT_LINE) | PNB_LIGHT_BIT(PNB_LIGHT_POLYGON) |
                      PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE),
            .receivers = PNB_RECEIVERS_ANY,
            .processor = PNB_PROCESSOR_CPU,
            .samples = true,
            .default_samples = 3,
            .params = params,
            .param_count = sizeof(params) / sizeof(*params),
        },
    .create = line_map_create,
    .destroy = line_map_destroy,
    .update = line_map_update,
    .visibility = line_map_visibility,
    .opengl = &line_map_opengl,
};
