/* method/wedge/light.c: a light as convex pieces, each with a space of its own.
 *
 * A rectangle (parallelogram) is one piece and fills [-1,1]^2. A disk is a regular polygon of
 * DISK_SIDES corners and its area: no direction is off by more than 1.3 % of the radius. A polygon
 * is cut into triangles, which are joined again as long as they stay convex: a convex one of up to
 * WEDGE_CORNERS_MAX corners is one piece, an L two. Each piece is a light of its own, and the
 * visibility is the mean by area. O(n^3) for a polygon of n corners, and a frame for each piece.
 */
#include "method/wedge/wedge.h"

#include <string.h>

#include "geom/tolerance.h"

#define DISK_SIDES    16
#define TRIANGLES_MAX 256

struct outline {
    int count;
    uint32_t corners[WEDGE_CORNERS_MAX];
};

/* The reciprocal basis: the sides of a parallelogram may be oblique. */
static void finish_axes(struct wedge_light *light)
{
    vec3 x = v3_cross(light->half_v, light->normal), y = v3_cross(light->normal, light->half_u);
    light->x_axis = v3_scale(x, 1 / v3_dot(x, light->half_u));
    light->y_axis = v3_scale(y, 1 / v3_dot(y, light->half_v));
}

static void set_rectangle(const struct light_shape *shape, struct wedge_light *light)
{
    static const double corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    light->half_u = v3_scale(shape->axis_u, 0.5);
    light->half_v = v3_scale(shape->axis_v, 0.5);
    light->center = v3_add(shape->origin, v3_add(light->half_u, light->half_v));
    light->rectangle = true;
    light->corner_count = 4;
    memcpy(light->corners, corners, sizeof(corners));
}

static void set_disk(const struct light_shape *shape, struct wedge_light *light)
{
    double grow = sqrt(2 * M_PI / (DISK_SIDES * sin(2 * M_PI / DISK_SIDES)));
    light->half_u = v3_scale(shape->axis_u, grow);
    light->half_v = v3_scale(shape->axis_v, grow);
    light->center = shape->origin;
    light->corner_count = DISK_SIDES;
    for (int i = 0; i < DISK_SIDES; i++) {
        light->corners[i][0] = cos(2 * M_PI * i / DISK_SIDES);
        light->corners[i][1] = sin(2 * M_PI * i / DISK_SIDES);
    }
}

/* In the plane's coordinates along axis_u and axis_v from the origin. */
static void flat(const struct light_shape *shape, uint32_t vertex, double out[2])
{
    vec3 p = v3_load(shape->light.shape.polygon.vertices + 3 * (size_t)vertex);
    vec3 d = v3_sub(p, shape->origin);
    out[0] = v3_dot(d, shape->axis_u);
    out[1] = v3_dot(d, shape->axis_v);
}

static double turn(const struct light_shape *shape, uint32_t a, uint32_t b, uint32_t c)
{
    double p[2], q[2], r[2];
    flat(shape, a, p);
    flat(shape, b, q);
    flat(shape, c, r);
    return (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
}

/* Joins two outlines along an edge that they share if the whole stays convex. */
static bool join(const struct light_shape *shape, struct outline *a, const struct outline *b)
{
    int count = a->count + b->count - 2;
    if (count > WEDGE_CORNERS_MAX)
        return false;
    for (int i = 0; i < a->count; i++)
        for (int k = 0; k < b->count; k++) {
            struct outline both = {.count = count};
            if (a->corners[i] != b->corners[(k + 1) % b->count] ||
                a->corners[(i + 1) % a->count] != b->corners[k])
                continue;
            /* From behind the shared edge all around a, then what b has beyond it. */
            int at = 0;
            for (int s = 1; s <= a->count; s++)
                both.corners[at++] = a->corners[(i + s) % a->count];
            for (int s = 2; s < b->count; s++)
                both.corners[at++] = b->corners[(k + s) % b->count];
            for (int s = 0; s < count; s++)
                if (turn(shape, both.corners[s], both.corners[(s + 1) % count],
                         both.corners[(s + 2) % count]) < 0)
                    return false;
            *a = both;
            return true;
        }
    return false;
}

static size_t find_pieces(const struct light_shape *shape, struct outline *pieces)
{
    size_t count = shape->triangle_count;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = shape->triangles + 3 * i;
        pieces[i] = (struct outline){3, {t[0], t[1], t[2]}};
    }
    for (size_t i = 0; i < count; i++)
        for (size_t k = i + 1; k < count; k++)
            if (join(shape, &pieces[i], &pieces[k])) {
                pieces[k] = pieces[--count];
                k = i; /* from the start again: others may fit now */
            }
    return count;
}

/* x along the longest edge, the middle in the centre of gravity. */
static void set_piece(const struct light_shape *shape, const struct outline *outline,
                      struct wedge_light *light)
{
    double points[WEDGE_CORNERS_MAX][2], area = 0, middle[2] = {0, 0}, x[2] = {1, 0}, longest = 0;
    int count = light->corner_count = outline->count;
    for (int i = 0; i < count; i++)
        flat(shape, outline->corners[i], points[i]);
    for (int i = 0; i < count; i++) {
        const double *o = points[0], *a = points[i], *b = points[(i + 1) % count];
        double w = 0.5 * ((a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]));
        double length = hypot(b[0] - a[0], b[1] - a[1]);
        area += w;
        for (int k = 0; k < 2; k++) {
            middle[k] += w * (o[k] + a[k] + b[k]) / 3;
            if (length > longest)
                x[k] = (b[k] - a[k]) / length;
        }
        longest = fmax(longest, length);
    }
    double half[2] = {0, 0};
    for (int i = 0; i < count; i++) {
        double d[2] = {points[i][0] - middle[0] / area, points[i][1] - middle[1] / area};
        light->corners[i][0] = d[0] * x[0] + d[1] * x[1];
        light->corners[i][1] = d[1] * x[0] - d[0] * x[1];
        for (int k = 0; k < 2; k++)
            half[k] = fmax(half[k], fabs(light->corners[i][k]));
    }
    for (int i = 0; i < count; i++)
        for (int k = 0; k < 2; k++)
            light->corners[i][k] /= half[k];
    vec3 u = shape->axis_u, v = shape->axis_v;
    light->half_u = v3_scale(v3_mad(v3_scale(u, x[0]), v, x[1]), half[0]);
    light->half_v = v3_scale(v3_mad(v3_scale(v, x[0]), u, -x[1]), half[1]);
    light->center = v3_mad(v3_mad(shape->origin, u, middle[0] / area), v, middle[1] / area);
    light->share = area / shape->area;
}

pnb_status wedge_lights_create(pnb_context *context, const struct light_shape *shape,
                               const struct gl_occluders *o, struct wedge_light **out_lights,
                               size_t *out_count)
{
    bool polygon = shape->light.type == PNB_LIGHT_POLYGON;
    size_t count = polygon ? shape->triangle_count : 1;
    *out_lights = NULL;
    *out_count = 0;
    if (count > TRIANGLES_MAX)
        return status_fail(context, PNB_ERROR_UNSUPPORTED, "wedge",
                           "a polygon light of more than 258 corners");
    struct outline *pieces = memory_alloc(context, count, sizeof(*pieces));
    if (pieces && polygon)
        count = find_pieces(shape, pieces);
    struct wedge_light *lights = memory_calloc(context, count, sizeof(*lights));
    if (!pieces || !lights) {
        memory_free(context, pieces);
        memory_free(context, lights);
        return status_no_memory(context, count * sizeof(*lights));
    }
    for (size_t i = 0; i < count; i++) {
        struct wedge_light *light = &lights[i];
        light->normal = shape->normal;
        light->share = 1;
        if (polygon)
            set_piece(shape, &pieces[i], light);
        else if (shape->light.type == PNB_LIGHT_DISK)
            set_disk(shape, light);
        else
            set_rectangle(shape, light);
        finish_axes(light);
        vec3 middle = v3_scale(v3_add(o->scene_low, o->scene_high), 0.5);
        double reach = v3_length(v3_sub(lights[0].center, middle)) +
                       0.5 * v3_length(v3_sub(o->scene_high, o->scene_low));
        light->gap = isfinite(reach) ? TOLERANCE_LIGHT_GAP * reach : TOLERANCE_LIGHT_GAP;
    }
    memory_free(context, pieces);
    *out_lights = lights;
    *out_count = count;
    return PNB_OK;
}

vec3 wedge_light_from_world(const struct wedge_light *light, vec3 p)
{
    vec3 d = v3_sub(p, light->center);
    return v3(v3_dot(light->x_axis, d), v3_dot(light->y_axis, d), v3_dot(light->normal, d));
}
