/* trace/surface.c: the visible surface of each pixel, and its shading.
 *
 * One primary ray per pixel centre, in packets of 4x4 pixels. Embree's hit says which triangle; the
 * point is then computed in double as the pixel's ray against that triangle's plane (by the hit's
 * barycentrics where the ray is nearly in the plane), so that it lies on the plane to float
 * rounding at any distance from the eye.
 *
 * pnb_surface_update() keeps the hierarchy, one for all surfaces of the scene that were updated.
 * Where objects have moved it becomes one that moves (trace.h) and follows them, until an update
 * finds nothing moved since the surface's last; where vertices have changed it is built anew.
 * pnb_surface_create() uses it if it is there and does not move, and keeps none.
 *
 * Memory: 44 bytes a pixel. Objects without triangles are skipped; a triangle of no area is never
 * hit.
 */
#include <penumbra/surface.h>

#include <string.h>

#include "trace/trace.h"

#define TILE 4

struct pnb_surface {
    pnb_context *context;
    pnb_scene *scene;
    pnb_camera camera;
    int width, height;
    size_t capacity; /* pixels that the arrays hold */
    float *positions, *normals, *shading_normals, *depth;
    uint32_t *objects;
    double primary_ms;
    struct trace *trace;      /* kept by updates; NULL: none yet */
    unsigned long placements; /* the scene's version when it was made or updated */
};

struct primary {
    struct pnb_surface *surface;
    const struct trace *trace;
    vec3 eye, forward, right,
        down; /* direction of (x, y) in [-1,1]^2: forward + x right + y down */
    int tiles_x;
};

static vec3 shading_normal(const pnb_scene *scene, uint32_t object, uint32_t triangle, double u,
                           double v, vec3 geometric)
{
    const pnb_object *info = &scene->objects[object].info;
    const struct mesh *mesh = &scene->meshes[info->mesh];
    if (!mesh->normals)
        return geometric;
    vec3 sum = v3(0, 0, 0);
    const double weight[3] = {1 - u - v, u, v};
    for (int k = 0; k < 3; k++) {
        vec3 n = v3_loadf(mesh->normals + 3 * (size_t)mesh->indices[3 * triangle + k]);
        n = v3_normalize(m34_normal(info->world_from_mesh, n));
        if (!(v3_dot(n, n) > 0.5) || !v3_finite(n))
            return geometric;
        sum = v3_mad(sum, n, weight[k]);
    }
    sum = v3_normalize(sum);
    double side = v3_dot(sum, geometric);
    if (side == 0 || !v3_finite(sum))
        return geometric;
    return side < 0 ? v3_scale(sum, -1) : sum;
}

static void store_none(struct pnb_surface *s, size_t pixel)
{
    for (int c = 0; c < 3; c++)
        s->positions[3 * pixel + c] = s->normals[3 * pixel + c] =
            s->shading_normals[3 * pixel + c] = NAN;
    s->depth[pixel] = NAN;
    s->objects[pixel] = PNB_NO_OBJECT;
}

static void store_hit(const struct primary *job, size_t pixel, vec3 direction,
                      const struct trace_hits *hits, int lane)
{
    struct pnb_surface *s = job->surface;
    vec3 corner[3];
    uint32_t object = hits->object[lane], triangle = hits->triangle[lane];
    double u = hits->u[lane], v = hits->v[lane];
    trace_triangle(job->trace, object, triangle, corner);
    vec3 e1 = v3_sub(corner[1], corner[0]), e2 = v3_sub(corner[2], corner[0]);
    vec3 p = v3_mad(v3_mad(corner[0], e1, u), e2, v);
    vec3 n = v3_normalize(v3_cross(e1, e2));
    double slope = v3_dot(n, direction);
    if (!(v3_dot(n, n) > 0.5)) {
        n = v3_scale(direction, -1);
    } else if (fabs(slope) > 1e-4) {
        double t = v3_dot(v3_sub(corner[0], job->eye), n) / slope;
        if (t > 0)
            p = v3_mad(job->eye, direction, t);
    }
    if (slope > 0)
        n = v3_scale(n, -1);
    v3_storef(s->positions + 3 * pixel, p);
    v3_storef(s->normals + 3 * pixel, n);
    v3_storef(s->shading_normals + 3 * pixel, shading_normal(s->scene, object, triangle, u, v, n));
    s->depth[pixel] = (float)v3_dot(v3_sub(p, job->eye), job->forward);
    s->objects[pixel] = object;
}

static void primary_tile(const struct primary *job, size_t tile)
{
    struct pnb_surface *s = job->surface;
    int x0 = TILE * (int)(tile % (size_t)job->tiles_x);
    int y0 = TILE * (int)(tile / (size_t)job->tiles_x);
    struct trace_rays rays;
    struct trace_hits hits;
    int32_t valid[TRACE_WIDTH] __attribute__((aligned(64)));
    vec3 direction[TRACE_WIDTH];
    trace_rays_init(&rays);
    for (int lane = 0; lane < TRACE_WIDTH; lane++) {
        int x = x0 + lane % TILE, y = y0 + lane / TILE;
        valid[lane] = x < s->width && y < s->height ? -1 : 0;
        direction[lane] =
            v3_normalize(v3_mad(v3_mad(job->forward, job->right, 2 * (x + 0.5) / s->width - 1),
                                job->down, 2 * (y + 0.5) / s->height - 1));
        rays.org_x[lane] = (float)job->eye.x;
        rays.org_y[lane] = (float)job->eye.y;
        rays.org_z[lane] = (float)job->eye.z;
        rays.dir_x[lane] = (float)direction[lane].x;
        rays.dir_y[lane] = (float)direction[lane].y;
        rays.dir_z[lane] = (float)direction[lane].z;
    }
    trace_closest(job->trace, valid, &rays, &hits);
    for (int lane = 0; lane < TRACE_WIDTH; lane++) {
        if (!valid[lane])
            continue;
        size_t pixel = (size_t)(y0 + lane / TILE) * (size_t)s->width + (size_t)(x0 + lane % TILE);
        if (hits.object[lane] == TRACE_NONE)
            store_none(s, pixel);
        else
            store_hit(job, pixel, direction[lane], &hits, lane);
    }
}

static void primary_body(void *user, size_t begin, size_t end, int worker)
{
    for (size_t tile = begin; tile < end; tile++)
        primary_tile(user, tile);
}

static pnb_status prepare(struct pnb_surface *s, struct primary *job)
{
    const pnb_camera *camera = &s->camera;
    *job = (struct primary){.surface = s, .eye = v3_load(camera->eye)};
    job->forward = v3_normalize(v3_sub(v3_load(camera->target), job->eye));
    vec3 right = v3_normalize(v3_cross(job->forward, v3_normalize(v3_load(camera->up))));
    double half_y = tan(0.5 * camera->vertical_fov_degrees * M_PI / 180);
    job->down = v3_scale(v3_cross(job->forward, right), half_y);
    job->right = v3_scale(right, half_y * s->width / s->height);
    job->tiles_x = (s->width + TILE - 1) / TILE;
    if (!v3_finite(job->forward) || !(v3_length(right) > 0.5) || !v3_finite(right) ||
        !(camera->vertical_fov_degrees > 0 && camera->vertical_fov_degrees < 180))
        return status_fail(s->context, PNB_ERROR_SCENE, "camera",
                           "eye, target and up span no view");
    return PNB_OK;
}

static pnb_status find_surface(struct primary *job, const struct trace *trace)
{
    struct pnb_surface *s = job->surface;
    double started = clock_ms();
    size_t tiles = (size_t)job->tiles_x * (size_t)((s->height + TILE - 1) / TILE);
    job->trace = trace;
    pnb_status status =
        parallel_for_progress(s->context, "surface", 0, 1, tiles, 64, primary_body, job);
    s->primary_ms = clock_ms() - started;
    return status;
}

static pnb_status check_size(pnb_context *context, int width, int height)
{
    if (width < 1 || height < 1 || width > 65536 || height > 65536)
        return status_fail(context, PNB_ERROR_ARGUMENT, "size",
                           "%dx%d pixels; each side must lie between 1 and 65536", width, height);
    return PNB_OK;
}

static void free_arrays(struct pnb_surface *s)
{
    memory_free(s->context, s->positions);
    memory_free(s->context, s->normals);
    memory_free(s->context, s->shading_normals);
    memory_free(s->context, s->depth);
    memory_free(s->context, s->objects);
}

/* Arrays for so many pixels; where they are large enough, and not four times too large, they stay.
 * Without memory the surface is as it was. */
static pnb_status make_room(struct pnb_surface *s, size_t count)
{
    pnb_context *context = s->context;
    if (count <= s->capacity && s->capacity <= 4 * count)
        return PNB_OK;
    struct pnb_surface fresh = {.context = context};
    fresh.positions = memory_alloc(context, count * 3, sizeof(float));
    fresh.normals = memory_alloc(context, count * 3, sizeof(float));
    fresh.shading_normals = memory_alloc(context, count * 3, sizeof(float));
    fresh.depth = memory_alloc(context, count, sizeof(float));
    fresh.objects = memory_alloc(context, count, sizeof(uint32_t));
    if (!fresh.positions || !fresh.normals || !fresh.shading_normals || !fresh.depth ||
        !fresh.objects) {
        free_arrays(&fresh);
        return status_no_memory(context, count * 44);
    }
    free_arrays(s);
    s->positions = fresh.positions;
    s->normals = fresh.normals;
    s->shading_normals = fresh.shading_normals;
    s->depth = fresh.depth;
    s->objects = fresh.objects;
    s->capacity = count;
    return PNB_OK;
}

pnb_status pnb_surface_create(pnb_context *context, pnb_scene *scene, const pnb_camera *camera,
                              int width, int height, pnb_surface **out_surface)
{
    *out_surface = NULL;
    if (!scene)
        return status_missing(context, "scene");
    pnb_status status = check_size(context, width, height);
    if (status != PNB_OK)
        return status;
    struct pnb_surface *s = memory_calloc(context, 1, sizeof(*s));
    if (!s)
        return status_no_memory(context, sizeof(*s));
    s->context = context;
    s->scene = scene;
    s->placements = scene->placement_version;
    s->camera = camera ? *camera : scene->camera;
    s->width = width;
    s->height = height;
    struct primary job;
    struct trace *shared = trace_shared(scene), *own = NULL;
    status = make_room(s, (size_t)width * (size_t)height);
    if (status == PNB_OK)
        status = prepare(s, &job);
    if (status == PNB_OK && !shared)
        status = trace_create(scene, false, &own);
    if (status == PNB_OK)
        status = find_surface(&job, shared ? shared : own);
    trace_destroy(own);
    if (status != PNB_OK) {
        pnb_surface_destroy(s);
        return status;
    }
    *out_surface = s;
    return PNB_OK;
}

/* Shows nothing: no pixel has a surface. */
static void clear_surface(struct pnb_surface *s)
{
    size_t count = (size_t)s->width * (size_t)s->height;
    for (size_t i = 0; i < count; i++)
        store_none(s, i);
}

/* The hierarchy of the scene as it is now. */
static pnb_status follow_scene(struct pnb_surface *s)
{
    unsigned long now = s->scene->placement_version;
    struct trace *old = s->trace;
    bool moved = s->placements != now;
    s->placements = now;
    if (old && trace_current(old) && (moved || !trace_moves(old)))
        return PNB_OK;
    s->trace = NULL;
    pnb_status status = trace_share(s->scene, moved, old, &s->trace);
    trace_release(old);
    return status;
}

pnb_status pnb_surface_update(pnb_surface *s, const pnb_camera *camera, int width, int height)
{
    pnb_status status = check_size(s->context, width, height);
    if (status != PNB_OK)
        return status;
    /* What may fail for other reasons than memory comes first, with the surface as it was. */
    struct pnb_surface wanted = *s;
    struct primary job;
    wanted.camera = camera ? *camera : s->scene->camera;
    wanted.width = width;
    wanted.height = height;
    status = prepare(&wanted, &job);
    if (status != PNB_OK)
        return status;
    status = follow_scene(s);
    if (status == PNB_OK)
        status = make_room(s, (size_t)width * (size_t)height);
    if (status != PNB_OK)
        return status;
    s->camera = wanted.camera;
    s->width = width;
    s->height = height;
    job.surface = s;
    status = find_surface(&job, s->trace);
    if (status != PNB_OK)
        clear_surface(s);
    return status;
}

void pnb_surface_destroy(pnb_surface *surface)
{
    if (!surface)
        return;
    free_arrays(surface);
    trace_release(surface->trace);
    memory_free(surface->context, surface);
}

void pnb_surface_get(const pnb_surface *surface, pnb_surface_view *out_view)
{
    *out_view = (pnb_surface_view){
        .width = surface->width,
        .height = surface->height,
        .positions = surface->positions,
        .normals = surface->normals,
        .shading_normals = surface->shading_normals,
        .depth = surface->depth,
        .objects = surface->objects,
        .primary_ms = surface->primary_ms,
    };
}

void pnb_surface_receivers(const pnb_surface *surface, pnb_receivers *out_receivers)
{
    *out_receivers = (pnb_receivers){
        .count = (size_t)surface->width * (size_t)surface->height,
        .positions = surface->positions,
        .normals = surface->normals,
        .width = surface->width,
        .height = surface->height,
        .objects = surface->objects,
        .camera = &surface->camera,
    };
}

struct shade {
    const struct pnb_surface *surface;
    const float *irradiance, *visibility;
    float *rgb;
    double exposure;
};

static void add_light(void *user, size_t begin, size_t end, int worker)
{
    const struct shade *job = user;
    const struct pnb_surface *s = job->surface;
    for (size_t i = begin; i < end; i++) {
        if (s->objects[i] == PNB_NO_OBJECT)
            continue;
        double v = job->visibility ? job->visibility[i] : 1;
        if (isnan(v) || !s->scene->objects[s->objects[i]].info.receives)
            v = 1;
        for (int c = 0; c < 3; c++)
            job->rgb[3 * i + c] += (float)(job->exposure * v * job->irradiance[3 * i + c]);
    }
}

static void finish_colours(void *user, size_t begin, size_t end, int worker)
{
    const struct shade *job = user;
    const struct pnb_surface *s = job->surface;
    const pnb_scene *scene = s->scene;
    for (size_t i = begin; i < end; i++) {
        for (int c = 0; c < 3; c++) {
            float *value = &job->rgb[3 * i + c];
            if (s->objects[i] == PNB_NO_OBJECT)
                *value = (float)scene->background[c];
            else
                *value =
                    (float)(scene->objects[s->objects[i]].info.color[c] *
                                (scene->ambient[c] + *value) +
                            job->exposure * M_PI * scene->objects[s->objects[i]].info.emission[c]);
        }
    }
}

pnb_status pnb_surface_shade(const pnb_surface *surface, const float *const *visibility, float *rgb)
{
    pnb_context *context = surface->context;
    const pnb_scene *scene = surface->scene;
    size_t count = (size_t)surface->width * (size_t)surface->height;
    if (!rgb)
        return status_missing(context, "rgb");
    memset(rgb, 0, count * 3 * sizeof(float));
    struct shade job = {.surface = surface, .rgb = rgb};
    if (scene->light_count > 0) {
        float *irradiance = memory_alloc(context, count * 3, sizeof(float));
        if (!irradiance)
            return status_no_memory(context, count * 3 * sizeof(float));
        job.exposure = pnb_scene_exposure(scene);
        job.irradiance = irradiance;
        for (size_t k = 0; k < scene->light_count; k++) {
            pnb_status status = pnb_light_irradiance(context, &scene->lights[k], surface->positions,
                                                     surface->shading_normals, count, irradiance);
            if (status != PNB_OK) {
                memory_free(context, irradiance);
                return status;
            }
            job.visibility = visibility ? visibility[k] : NULL;
            parallel_for(context, count, 8192, add_light, &job);
        }
        memory_free(context, irradiance);
    }
    parallel_for(context, count, 8192, finish_colours, &job);
    return PNB_OK;
}
