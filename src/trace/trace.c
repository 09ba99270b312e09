/* trace/trace.c: Embree 3.
 *
 * One device and one scene per hierarchy. Each object is one triangle geometry of its own with
 * world-space float vertices, computed in double and rounded once; its geometry number is the
 * object's index, so a hit names the object without a search. Embree builds one tree over all of
 * them. Robust mode: no ray slips between two triangles that share an edge.
 *
 * One that moves (trace_share()) has a tree per object and one over those: what moves is written
 * anew and its tree's boxes are fitted again, O(vertices that moved). The triangles and the test
 * are the same, so a ray meets the same distance; where two triangles lie there it may name the
 * other one.
 *
 * Memory: 12 bytes a vertex and 12 a triangle, and the tree, some 100 bytes a triangle while it is
 * built. Triangles of no area are legal and never hit.
 */
#include "trace/trace.h"

#include <embree3/rtcore.h>
#include <stdio.h>
#include <string.h>

_Static_assert(sizeof(struct trace_rays) == sizeof(struct RTCRay16), "layout of Embree's rays");
_Static_assert(offsetof(struct trace_rays, tfar) == offsetof(struct RTCRay16, tfar) &&
                   offsetof(struct trace_rays, dir_x) == offsetof(struct RTCRay16, dir_x) &&
                   offsetof(struct trace_rays, flags) == offsetof(struct RTCRay16, flags),
               "layout of Embree's rays");
_Static_assert(TRACE_NONE == RTC_INVALID_GEOMETRY_ID, "no hit");

struct trace_mesh {
    const float *positions; /* Embree's buffers */
    const uint32_t *indices;
};

struct trace {
    pnb_context *context;
    RTCDevice device;
    RTCScene scene;
    struct trace_mesh *meshes; /* one per object; NULL buffers: left out */
    size_t mesh_count;
    pnb_scene *of; /* what it was built from, and the versions of that */
    unsigned long geometry_version, placement_version;
    int keepers;              /* of a shared one */
    double (*placements)[12]; /* one that moves: where each object is; else NULL */
};

static pnb_status embree_fail(pnb_context *context, RTCDevice device)
{
    enum RTCError error = rtcGetDeviceError(device);
    switch (error) {
    case RTC_ERROR_NONE: return PNB_OK;
    case RTC_ERROR_OUT_OF_MEMORY:
        return status_fail(context, PNB_ERROR_MEMORY, "Embree", "out of memory");
    case RTC_ERROR_UNSUPPORTED_CPU:
        return status_fail(context, PNB_ERROR_DEVICE, "Embree", "this processor is not supported");
    default:
        return status_fail(context, PNB_ERROR_DEVICE, "Embree", "error %d while building",
                           (int)error);
    }
}

/* After a call that gave nothing: an error even where Embree does not know one. */
static pnb_status embree_refusal(pnb_context *context, RTCDevice device)
{
    pnb_status status = embree_fail(context, device);
    if (status == PNB_OK)
        status = status_fail(context, PNB_ERROR_DEVICE, "Embree", "refused without a reason");
    return status;
}

static void write_positions(const struct mesh *mesh, const double world_from_mesh[12],
                            float *positions)
{
    for (size_t i = 0; i < mesh->vertex_count; i++)
        v3_storef(positions + 3 * i, m34_point(world_from_mesh, v3_loadf(mesh->positions + 3 * i)));
}

static pnb_status add_object(struct trace *trace, const pnb_scene *scene, size_t index)
{
    const pnb_object *object = &scene->objects[index].info;
    const struct mesh *mesh = &scene->meshes[object->mesh];
    if (mesh->triangle_count == 0)
        return PNB_OK;
    RTCGeometry geometry = rtcNewGeometry(trace->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *positions = NULL;
    uint32_t *indices = NULL;
    if (geometry) {
        positions = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            3 * sizeof(float), mesh->vertex_count);
        indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                          3 * sizeof(uint32_t), mesh->triangle_count);
    }
    if (!positions || !indices) {
        if (geometry)
            rtcReleaseGeometry(geometry);
        return embree_refusal(trace->context, trace->device);
    }
    write_positions(mesh, object->world_from_mesh, positions);
    if (trace->placements) {
        memcpy(trace->placements[index], object->world_from_mesh, sizeof(*trace->placements));
        rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    }
    memcpy(indices, mesh->indices, mesh->triangle_count * 3 * sizeof(uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(trace->scene, geometry, (unsigned)index);
    rtcReleaseGeometry(geometry); /* the scene holds it */
    trace->meshes[index] = (struct trace_mesh){positions, indices};
    return PNB_OK;
}

static pnb_status create(pnb_scene *scene, bool casters_only, bool moves, struct trace **out_trace)
{
    pnb_context *context = scene->context;
    *out_trace = NULL;
    struct trace *trace = memory_calloc(context, 1, sizeof(*trace));
    if (!trace)
        return status_no_memory(context, sizeof(*trace));
    trace->context = context;
    trace->mesh_count = scene->object_count;
    trace->of = scene;
    trace->geometry_version = scene->geometry_version;
    trace->placement_version = scene->placement_version;
    trace->meshes = memory_calloc(context, scene->object_count, sizeof(*trace->meshes));
    if (moves)
        trace->placements = memory_calloc(context, scene->object_count, sizeof(*trace->placements));
    pnb_status status = PNB_OK;
    if (!trace->meshes || (moves && !trace->placements))
        status = status_no_memory(context, scene->object_count * sizeof(*trace->meshes));
    if (status == PNB_OK) {
        char config[64];
        snprintf(config, sizeof(config), "threads=%d", pnb_context_threads(context));
        trace->device = rtcNewDevice(config);
        if (!trace->device)
            status = embree_refusal(context, NULL);
    }
    if (status == PNB_OK) {
        trace->scene = rtcNewScene(trace->device);
        if (!trace->scene)
            status = embree_refusal(context, trace->device);
    }
    if (status == PNB_OK) {
        rtcSetSceneFlags(trace->scene, moves ? RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC
                                             : RTC_SCENE_FLAG_ROBUST);
        /* Embree has trees per object for "low" alone; their own quality says how they are made. */
        rtcSetSceneBuildQuality(trace->scene,
                                moves ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
        for (size_t i = 0; i < scene->object_count && status == PNB_OK; i++)
            if (!casters_only || scene->objects[i].info.casts)
                status = add_object(trace, scene, i);
    }
    if (status == PNB_OK) {
        rtcCommitScene(trace->scene);
        status = embree_fail(context, trace->device);
    }
    if (status != PNB_OK) {
        trace_destroy(trace);
        return status;
    }
    *out_trace = trace;
    return PNB_OK;
}

pnb_status trace_create(pnb_scene *scene, bool casters_only, struct trace **out_trace)
{
    return create(scene, casters_only, false, out_trace);
}

void trace_destroy(struct trace *trace)
{
    if (!trace)
        return;
    if (trace->scene)
        rtcReleaseScene(trace->scene);
    if (trace->device)
        rtcReleaseDevice(trace->device);
    memory_free(trace->context, trace->meshes);
    memory_free(trace->context, trace->placements);
    memory_free(trace->context, trace);
}

bool trace_current(const struct trace *trace)
{
    return trace->geometry_version == trace->of->geometry_version &&
           trace->placement_version == trace->of->placement_version;
}

bool trace_moves(const struct trace *trace)
{
    return trace->placements != NULL;
}

struct trace *trace_shared(pnb_scene *scene)
{
    struct trace *trace = scene->shared_trace;
    return trace && !trace->placements && trace_current(trace) ? trace : NULL;
}

/* Its objects to where the scene has them. */
static pnb_status move_objects(struct trace *trace)
{
    const pnb_scene *scene = trace->of;
    for (size_t i = 0; i < trace->mesh_count; i++) {
        const pnb_object *object = &scene->objects[i].info;
        if (!trace->meshes[i].positions ||
            memcmp(trace->placements[i], object->world_from_mesh, sizeof(*trace->placements)) == 0)
            continue;
        RTCGeometry geometry = rtcGetGeometry(trace->scene, (unsigned)i);
        write_positions(&scene->meshes[object->mesh], object->world_from_mesh,
                        (float *)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0));
        rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
        rtcCommitGeometry(geometry);
        memcpy(trace->placements[i], object->world_from_mesh, sizeof(*trace->placements));
    }
    rtcCommitScene(trace->scene);
    trace->placement_version = scene->placement_version;
    return embree_fail(trace->context, trace->device);
}

static bool fits(const struct trace *trace, bool moves)
{
    return trace && trace_moves(trace) == moves &&
           trace->geometry_version == trace->of->geometry_version &&
           (moves || trace_current(trace));
}

pnb_status trace_share(pnb_scene *scene, bool moves, struct trace *old, struct trace **out_trace)
{
    struct trace *trace = fits(old, moves) ? old : scene->shared_trace;
    pnb_status status = PNB_OK;
    *out_trace = NULL;
    if (!fits(trace, moves)) {
        status = create(scene, false, moves, &trace);
        if (status == PNB_OK)
            scene->shared_trace = trace; /* another one stays its keepers' */
    } else if (!trace_current(trace)) {
        status = move_objects(trace);
    }
    if (status != PNB_OK)
        return status;
    trace->keepers++;
    *out_trace = trace;
    return PNB_OK;
}

void trace_release(struct trace *trace)
{
    if (!trace || --trace->keepers > 0)
        return;
    if (trace->of->shared_trace == trace)
        trace->of->shared_trace = NULL;
    trace_destroy(trace);
}

void trace_rays_init(struct trace_rays *rays)
{
    memset(rays, 0, sizeof(*rays));
    for (int i = 0; i < TRACE_WIDTH; i++) {
        rays->tfar[i] = INFINITY;
        rays->mask[i] = 0xffffffffu;
    }
}

void trace_occluded(const struct trace *trace, const int32_t valid[TRACE_WIDTH], bool coherent,
                    struct trace_rays *rays)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    rtcOccluded16(valid, trace->scene, &context, (struct RTCRay16 *)rays);
}

void trace_closest(const struct trace *trace, const int32_t valid[TRACE_WIDTH],
                   struct trace_rays *rays, struct trace_hits *hits)
{
    struct RTCRayHit16 both;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    memcpy(&both.ray, rays, sizeof(both.ray));
    memset(&both.hit, 0, sizeof(both.hit));
    for (int i = 0; i < TRACE_WIDTH; i++)
        both.hit.geomID[i] = both.hit.primID[i] = both.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect16(valid, trace->scene, &context, &both);
    memcpy(rays->tfar, both.ray.tfar, sizeof(rays->tfar));
    memcpy(hits->object, both.hit.geomID, sizeof(hits->object));
    memcpy(hits->triangle, both.hit.primID, sizeof(hits->triangle));
    memcpy(hits->u, both.hit.u, sizeof(hits->u));
    memcpy(hits->v, both.hit.v, sizeof(hits->v));
}

void trace_triangle(const struct trace *trace, uint32_t object, uint32_t triangle,
                    vec3 out_corners[3])
{
    const struct trace_mesh *mesh = &trace->meshes[object];
    for (int k = 0; k < 3; k++)
        out_corners[k] = v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + k]);
}

void *trace_embree_scene(const struct trace *trace)
{
    return trace->scene;
}
