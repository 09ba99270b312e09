/* method/planar/plane.c: receiver planes and what may shadow them. */
#include <string.h>

#include "method/planar/room.h"

/* The domain is the receiver's box and this share of it more on every side; what is cast beyond
 * lies on its border. */
#define DOMAIN_MARGIN 0.25
/* An object is flat when its points leave a plane by no more than this share of its size. */
#define FLAT 1e-5
/* A face of an object that is not flat must be this share of its surface to receive. */
#define FACE_SHARE 0.1
/* A slab is no thicker than this share of its size. */
#define SLAB 0.1

struct flat_object {
    vec3 center, normal; /* unit */
    vec3 along;          /* an edge of its largest triangle: axis u */
    double area, size;
    bool flat;
    bool slab; /* or thin, at least: such objects are taken without being named */
};

static void triangle_points(const pnb_object *info, const struct mesh *mesh, size_t triangle,
                            vec3 *out)
{
    for (int k = 0; k < 3; k++)
        out[k] = m34_point(
            info->world_from_mesh,
            v3_loadf(mesh->positions + 3 * (size_t)mesh->indices[3 * triangle + (size_t)k]));
}

static bool in_plane(const struct flat_object *f, const vec3 *p)
{
    for (int k = 0; k < 3; k++)
        if (fabs(v3_dot(v3_sub(p[k], f->center), f->normal)) > FLAT * f->size)
            return false;
    return true;
}

/* The plane that an object receives on: all of it, or, of a slab, the largest face that looks
 * towards the light with nothing of the object above it. */
static struct flat_object examine(const pnb_scene *scene, size_t object, vec3 towards)
{
    const pnb_object *info = &scene->objects[object].info;
    const struct mesh *mesh = &scene->meshes[info->mesh];
    double turned = m34_det(info->world_from_mesh) < 0 ? -1 : 1;
    struct flat_object f = {0};
    vec3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_scale(lo, -1), p[3];
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        triangle_points(info, mesh, i, p);
        for (int k = 0; k < 3; k++) {
            lo = v3_min(lo, p[k]);
            hi = v3_max(hi, p[k]);
        }
    }
    f.size = mesh->triangle_count > 0 ? v3_length(v3_sub(hi, lo)) : 0;
    /* First the largest triangle of all, then the largest that looks at the light. */
    for (int pass = 0; pass < 2 && !f.flat; pass++) {
        double largest = 0;
        for (size_t i = 0; i < mesh->triangle_count; i++) {
            triangle_points(info, mesh, i, p);
            vec3 n = v3_scale(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])), turned);
            double area = 0.5 * v3_length(n);
            if (area <= largest || (pass == 1 && v3_dot(n, v3_sub(towards, p[0])) <= 0))
                continue;
            largest = area;
            f.normal = v3_normalize(n);
            /* Of a rectangle's triangle the longest edge is the diagonal; a leg suits better. */
            vec3 a = v3_sub(p[1], p[0]), b = v3_sub(p[2], p[1]), c = v3_sub(p[0], p[2]);
            f.along = fabs(v3_dot(a, b)) < fabs(v3_dot(b, c)) ? a : b;
            f.center = p[0];
        }
        if (largest == 0)
            return f;
        double above = 0, below = 0, whole = 0;
        f.area = 0;
        lo = v3(INFINITY, INFINITY, INFINITY);
        hi = v3_scale(lo, -1);
        for (size_t i = 0; i < mesh->triangle_count; i++) {
            triangle_points(info, mesh, i, p);
            for (int k = 0; k < 3; k++) {
                double h = v3_dot(v3_sub(p[k], f.center), f.normal);
                above = fmax(above, h);
                below = fmax(below, -h);
            }
            double area = 0.5 * v3_length(v3_cross(v3_sub(p[1], p[0]), v3_sub(p[2], p[0])));
            whole += area;
            if (!in_plane(&f, p))
                continue;
            f.area += area;
            for (int k = 0; k < 3; k++) {
                lo = v3_min(lo, p[k]);
                hi = v3_max(hi, p[k]);
            }
        }
        f.flat = above <= FLAT * f.size &&
                 (pass == 1 ? f.area >= FACE_SHARE * whole : below <= FLAT * f.size);
        f.slab = below <= SLAB * f.size;
    }
    vec3 middle = v3_scale(v3_add(lo, hi), 0.5);
    f.center = v3_mad(middle, f.normal, v3_dot(v3_sub(f.center, middle), f.normal));
    return f;
}

bool shadow_next_receiver(const pnb_scene *scene, vec3 towards, size_t *io_object)
{
    for (size_t i = *io_object; i < scene->object_count; i++) {
        const pnb_object *info = &scene->objects[i].info;
        struct flat_object f = {0};
        if (info->receives && !info->plane)
            f = examine(scene, i, towards);
        if (info->receives && (info->plane || (f.flat && f.slab))) {
            *io_object = i;
            return true;
        }
    }
    return false;
}

pnb_status shadow_find_receiver(pnb_context *context, const pnb_scene *scene, const char *name,
                                vec3 towards, size_t *out_object)
{
    if (name && *name) {
        for (size_t i = 0; i < scene->object_count; i++) {
            const char *other = scene->objects[i].info.name;
            if (other && strcmp(other, name) == 0) {
                *out_object = i;
                return PNB_OK;
            }
        }
        return status_fail(context, PNB_ERROR_ARGUMENT, name,
                           "the scene has no object of that name");
    }
    double best = 0;
    for (int pass = 0; pass < 2 && best == 0; pass++) {
        /* Planes; if there is none, any object that is flat, or has a face that will do. */
        for (size_t i = 0; i < scene->object_count; i++) {
            const pnb_object *info = &scene->objects[i].info;
            if (!info->receives || (pass == 0 && !info->plane))
                continue;
            struct flat_object f = examine(scene, i, towards);
            if (f.flat && f.slab && f.area > best) {
                best = f.area;
                *out_object = i;
            }
        }
    }
    if (best == 0) {
        char able[256];
        method_list_any_receivers(able, sizeof(able));
        return status_fail(context, PNB_ERROR_UNSUPPORTED, "planar",
                           "the scene has no plane that receives shadows; these methods do other "
                           "receivers: %s",
                           able);
    }
    return PNB_OK;
}

void shadow_plane_finish(pnb_context *context, struct shadow_plane *plane)
{
    for (size_t i = 0; i < plane->occluder_count; i++)
        silhouette_occluder_finish(context, &plane->occluders[i]);
    memory_free(context, plane->occluders);
    shadow_forget_kept(context, plane);
    *plane = (struct shadow_plane){0};
}

pnb_status shadow_plane_init(pnb_context *context, pnb_scene *scene, struct mesh *meshes,
                             size_t object, vec3 towards, struct shadow_plane *plane)
{
    *plane = (struct shadow_plane){.object = object};
    meshes = meshes ? meshes : scene->meshes;
    struct flat_object f = examine(scene, object, towards);
    const pnb_object *receiver = &scene->objects[object].info;
    if (!f.flat) {
        char able[256];
        method_list_any_receivers(able, sizeof(able));
        return status_fail(
            context, PNB_ERROR_UNSUPPORTED, receiver->name ? receiver->name : "object",
            "is not flat, which planar needs; these methods do other receivers: %s", able);
    }
    struct silhouette_plane *frame = &plane->frame;
    frame->origin = f.center;
    frame->n = v3_dot(v3_sub(towards, f.center), f.normal) < 0 ? v3_scale(f.normal, -1) : f.normal;
    frame->u = v3_normalize(v3_mad(f.along, frame->n, -v3_dot(f.along, frame->n)));
    frame->v = v3_cross(frame->n, frame->u);
    /* The receiver's box. */
    const struct mesh *mesh = &scene->meshes[receiver->mesh];
    plane->lo[0] = plane->lo[1] = INFINITY;
    plane->hi[0] = plane->hi[1] = -INFINITY;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        vec3 corner[3];
        triangle_points(receiver, mesh, i, corner);
        for (int k = 0; k < 3 && in_plane(&f, corner); k++) {
            vec3 p = silhouette_to_plane(frame, corner[k]);
            plane->lo[0] = fmin(plane->lo[0], p.x);
            plane->lo[1] = fmin(plane->lo[1], p.y);
            plane->hi[0] = fmax(plane->hi[0], p.x);
            plane->hi[1] = fmax(plane->hi[1], p.y);
        }
    }
    double half = 0.5 * fmax(plane->hi[0] - plane->lo[0], plane->hi[1] - plane->lo[1]);
    plane->center[0] = 0.5 * (plane->lo[0] + plane->hi[0]);
    plane->center[1] = 0.5 * (plane->lo[1] + plane->hi[1]);
    plane->scale = (PLANAR_LIMIT - 8) / (half * (1 + 2 * DOMAIN_MARGIN));

    plane->occluders = memory_calloc(context, scene->object_count, sizeof(*plane->occluders));
    if (!plane->occluders)
        return status_no_memory(context, scene->object_count * sizeof(*plane->occluders));
    double lift = scene_receiver_lift(scene);
    pnb_status status = PNB_OK;
    for (size_t i = 0; i < scene->object_count && !status; i++) {
        const pnb_object *info = &scene->objects[i].info;
        if (i == object || !info->casts || meshes[info->mesh].triangle_count == 0)
            continue;
        struct silhouette_occluder *o = &plane->occluders[plane->occluder_count];
        status =
            silhouette_occluder_init(context, &meshes[info->mesh], info->world_from_mesh, frame, o);
        if (status)
            break;
        if (!(o->highest > lift)) { /* in the plane or below it */
            silhouette_occluder_finish(context, o);
            continue;
        }
        plane->occluder_count++;
        plane->open_edges += o->edges->open_count;
        plane->non_manifold_edges += o->edges->non_manifold_count;
        plane->open_meshes += !info->plane && o->odd_count > 0;
    }
    if (status)
        shadow_plane_finish(context, plane);
    return status;
}
