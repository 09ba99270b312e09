/* light/light.c: what follows from a light's description: checks, frame, area, samples.
 *
 * Samples map the unit square to the light by equal areas and without tearing where the shape
 * allows, so that well distributed (u, v) stay well distributed: rectangle affine, disk by
 * concentric squares, a triangle by folding the square along its diagonal, a polygon triangle by
 * triangle along u, a line by u alone.
 */
#include "light/light.h"

#include <string.h>

#include "geom/tolerance.h"
#include "light/polygon.h"

const char *pnb_light_type_name(pnb_light_type type)
{
    static const char *const names[PNB_LIGHT_TYPE_COUNT] = {"rectangle", "disk",  "polygon",
                                                            "line",      "point", "sun"};
    return (unsigned)type < PNB_LIGHT_TYPE_COUNT ? names[type] : "unknown";
}

static bool finite3(const double *p)
{
    return isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]);
}

static pnb_status fail(pnb_context *context, const pnb_light *light, const char *why)
{
    return status_fail(context, PNB_ERROR_SCENE,
                       light->name && *light->name ? light->name : pnb_light_type_name(light->type),
                       "%s", why);
}

/* Newell's normal: twice the area, robust for any outline. */
static vec3 polygon_normal(const double *vertices, size_t count)
{
    vec3 sum = v3(0, 0, 0), base = v3_load(vertices);
    for (size_t i = 1; i + 1 < count; i++)
        sum = v3_add(sum, v3_cross(v3_sub(v3_load(vertices + 3 * i), base),
                                   v3_sub(v3_load(vertices + 3 * i + 3), base)));
    return sum;
}

static void flatten(const double *vertices, size_t count, vec3 u, vec3 v, double *points)
{
    vec3 base = v3_load(vertices);
    for (size_t i = 0; i < count; i++) {
        vec3 d = v3_sub(v3_load(vertices + 3 * i), base);
        points[2 * i] = v3_dot(d, u);
        points[2 * i + 1] = v3_dot(d, v);
    }
}

static pnb_status check_polygon(pnb_context *context, const pnb_light *light)
{
    size_t count = light->shape.polygon.vertex_count;
    const double *vertices = light->shape.polygon.vertices;
    if (count < 3 || !vertices)
        return fail(context, light, "a polygon needs three vertices or more");
    if (count > 65536)
        return fail(context, light, "a polygon of more than 65536 vertices");
    for (size_t i = 0; i < count; i++)
        if (!finite3(vertices + 3 * i))
            return status_fail(context, PNB_ERROR_SCENE, light->name ? light->name : "polygon",
                               "vertex %zu is not finite", i);
    vec3 low = v3_load(vertices), high = low;
    for (size_t i = 1; i < count; i++) {
        low = v3_min(low, v3_load(vertices + 3 * i));
        high = v3_max(high, v3_load(vertices + 3 * i));
    }
    double size = v3_length(v3_sub(high, low));
    if (!isfinite(size * size))
        return fail(context, light, "its size is beyond what numbers hold");
    vec3 normal = polygon_normal(vertices, count);
    if (!(v3_length(normal) > TOLERANCE_DEGENERATE * size * size))
        return fail(context, light, "the polygon has no area");
    normal = v3_normalize(normal);
    for (size_t i = 0; i < count; i++) {
        vec3 d = v3_sub(v3_load(vertices + 3 * i), v3_load(vertices));
        if (fabs(v3_dot(d, normal)) > TOLERANCE_LIGHT_PLANARITY * size)
            return status_fail(context, PNB_ERROR_SCENE, light->name ? light->name : "polygon",
                               "not planar: vertex %zu lies %.3g of its size off the plane", i,
                               fabs(v3_dot(d, normal)) / size);
    }
    double *points = memory_alloc(context, count * 2, sizeof(*points));
    if (!points)
        return status_no_memory(context, count * 2 * sizeof(*points));
    vec3 u, v;
    v3_frame(normal, &u, &v);
    flatten(vertices, count, u, v, points);
    pnb_status status = PNB_OK;
    size_t first = 0, second = 0;
    for (size_t i = 0; i < count && status == PNB_OK; i++) {
        const double *a = points + 2 * i, *b = points + 2 * ((i + 1) % count);
        if (a[0] == b[0] && a[1] == b[1])
            status = status_fail(context, PNB_ERROR_SCENE, light->name ? light->name : "polygon",
                                 "vertices %zu and %zu are the same point", i, (i + 1) % count);
    }
    if (status == PNB_OK && !polygon_simple(points, count, &first, &second))
        status = status_fail(context, PNB_ERROR_SCENE, light->name ? light->name : "polygon",
                             "not simple: the edges from vertices %zu and %zu meet", first, second);
    memory_free(context, points);
    return status;
}

pnb_status pnb_light_check(pnb_context *context, const pnb_light *light)
{
    if (!light)
        return status_missing(context, "light");
    if ((unsigned)light->type >= PNB_LIGHT_TYPE_COUNT)
        return status_fail(context, PNB_ERROR_ARGUMENT, "light", "type %d does not exist",
                           (int)light->type);
    if (!finite3(light->color))
        return fail(context, light, "its colour is not finite");
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(light->shape.rectangle.half_u), v = v3_load(light->shape.rectangle.half_v);
        if (!finite3(light->shape.rectangle.center) || !v3_finite(u) || !v3_finite(v))
            return fail(context, light, "center, half_u or half_v is not finite");
        double area = v3_length(v3_cross(u, v));
        if (!isfinite(area))
            return fail(context, light, "its size is beyond what numbers hold");
        if (!(area > TOLERANCE_DEGENERATE * v3_length(u) * v3_length(v)) || !(area > 0))
            return fail(context, light, "the rectangle has no area");
        return PNB_OK;
    }
    case PNB_LIGHT_DISK: {
        double radius = light->shape.disk.radius,
               length = v3_length(v3_load(light->shape.disk.normal));
        if (!finite3(light->shape.disk.center) || !finite3(light->shape.disk.normal) ||
            !isfinite(radius * radius) || !isfinite(length))
            return fail(context, light, "center, normal or radius is not finite");
        if (!(length > 0))
            return fail(context, light, "the disk's normal is zero");
        if (!(radius > 0) || !(radius * radius > 0))
            return fail(context, light, "the disk's radius must be above zero");
        return PNB_OK;
    }
    case PNB_LIGHT_POLYGON: return check_polygon(context, light);
    case PNB_LIGHT_LINE: {
        double length =
            v3_length(v3_sub(v3_load(light->shape.line.to), v3_load(light->shape.line.from)));
        if (!finite3(light->shape.line.from) || !finite3(light->shape.line.to) || !isfinite(length))
            return fail(context, light, "from or to is not finite");
        if (!(length > 0))
            return fail(context, light, "the line has no length");
        return PNB_OK;
    }
    case PNB_LIGHT_POINT:
        if (!finite3(light->shape.point.position))
            return fail(context, light, "position is not finite");
        return PNB_OK;
    case PNB_LIGHT_SUN: {
        double length = v3_length(v3_load(light->shape.sun.direction)),
               diameter = light->shape.sun.angular_diameter_degrees;
        if (!finite3(light->shape.sun.direction) || !isfinite(length) || !isfinite(diameter))
            return fail(context, light, "direction or angular_diameter_degrees is not finite");
        if (!(length > 0))
            return fail(context, light, "the sun's direction is zero");
        if (!(diameter > 0 && diameter < 180))
            return fail(context, light, "angular_diameter_degrees must lie between 0 and 180");
        return PNB_OK;
    }
    }
    return PNB_OK;
}

static pnb_status init_polygon(pnb_context *context, struct light_shape *shape)
{
    size_t count = shape->light.shape.polygon.vertex_count;
    const double *vertices = shape->light.shape.polygon.vertices;
    vec3 normal = polygon_normal(vertices, count);
    shape->normal = v3_normalize(normal);
    shape->origin = v3_load(vertices);
    v3_frame(shape->normal, &shape->axis_u, &shape->axis_v);

    double *points = memory_alloc(context, count * 2, sizeof(*points));
    uint32_t *links = memory_alloc(context, count * 2, sizeof(*links));
    shape->triangles = memory_alloc(context, count * 3, sizeof(*shape->triangles));
    shape->share = memory_alloc(context, count, sizeof(*shape->share));
    if (!points || !links || !shape->triangles || !shape->share) {
        memory_free(context, points);
        memory_free(context, links);
        light_shape_finish(context, shape);
        return status_no_memory(context, count * 48);
    }
    flatten(vertices, count, shape->axis_u, shape->axis_v, points);
    shape->triangle_count =
        polygon_triangulate(points, count, links, links + count, shape->triangles);
    memory_free(context, points);
    memory_free(context, links);

    shape->area = 0;
    for (size_t i = 0; i < shape->triangle_count; i++) {
        const uint32_t *t = shape->triangles + 3 * i;
        vec3 a = v3_load(vertices + 3 * t[0]);
        shape->area += 0.5 * v3_length(v3_cross(v3_sub(v3_load(vertices + 3 * t[1]), a),
                                                v3_sub(v3_load(vertices + 3 * t[2]), a)));
        shape->share[i] = shape->area;
    }
    for (size_t i = 0; i < shape->triangle_count; i++)
        shape->share[i] /= shape->area;
    return PNB_OK;
}

pnb_status light_shape_init(pnb_context *context, const pnb_light *light, struct light_shape *shape)
{
    memset(shape, 0, sizeof(*shape));
    shape->light = *light;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(light->shape.rectangle.half_u), v = v3_load(light->shape.rectangle.half_v);
        vec3 cross = v3_cross(u, v);
        shape->normal = v3_normalize(cross);
        shape->area = 4 * v3_length(cross);
        shape->origin = v3_sub(v3_sub(v3_load(light->shape.rectangle.center), u), v);
        shape->axis_u = v3_scale(u, 2);
        shape->axis_v = v3_scale(v, 2);
        break;
    }
    case PNB_LIGHT_DISK: {
        double radius = light->shape.disk.radius;
        shape->normal = v3_normalize(v3_load(light->shape.disk.normal));
        shape->area = M_PI * radius * radius;
        shape->origin = v3_load(light->shape.disk.center);
        v3_frame(shape->normal, &shape->axis_u, &shape->axis_v);
        shape->axis_u = v3_scale(shape->axis_u, radius);
        shape->axis_v = v3_scale(shape->axis_v, radius);
        break;
    }
    case PNB_LIGHT_POLYGON: return init_polygon(context, shape);
    case PNB_LIGHT_LINE:
        shape->origin = v3_load(light->shape.line.from);
        shape->axis_u = v3_sub(v3_load(light->shape.line.to), shape->origin);
        shape->area = v3_length(shape->axis_u);
        break;
    case PNB_LIGHT_POINT:
        shape->origin = v3_load(light->shape.point.position);
        shape->area = 1;
        break;
    case PNB_LIGHT_SUN: {
        double half_rad = 0.5 * light->shape.sun.angular_diameter_degrees * (M_PI / 180);
        shape->normal = v3_normalize(v3_scale(v3_load(light->shape.sun.direction), -1));
        v3_frame(shape->normal, &shape->axis_u, &shape->axis_v);
        shape->axis_u = v3_scale(shape->axis_u, tan(half_rad));
        shape->axis_v = v3_scale(shape->axis_v, tan(half_rad));
        shape->area = 4 * M_PI * sin(0.5 * half_rad) * sin(0.5 * half_rad);
        break;
    }
    }
    return PNB_OK;
}

void light_shape_finish(pnb_context *context, struct light_shape *shape)
{
    memory_free(context, shape->triangles);
    memory_free(context, shape->share);
    shape->triangles = NULL;
    shape->share = NULL;
}

/* Shirley and Chiu, A low distortion map between disk and square (1997): squares around the middle
 * become circles. */
static void square_to_disk(double u, double v, double *out_a, double *out_b)
{
    double x = 2 * u - 1, y = 2 * v - 1, r, phi;
    if (x == 0 && y == 0) {
        *out_a = *out_b = 0;
        return;
    }
    if (fabs(x) > fabs(y)) {
        r = x;
        phi = (M_PI / 4) * (y / x);
    } else {
        r = y;
        phi = (M_PI / 2) - (M_PI / 4) * (x / y);
    }
    *out_a = r * cos(phi);
    *out_b = r * sin(phi);
}

static vec3 sample_polygon(const struct light_shape *shape, double u, double v)
{
    /* First triangle whose cumulated share lies above u, then u stretched over it. */
    size_t low = 0, high = shape->triangle_count - 1;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (shape->share[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    double first = low > 0 ? shape->share[low - 1] : 0, width = shape->share[low] - first;
    double s = width > 0 ? fmin(fmax((u - first) / width, 0), 1) : 0.5, t = v;
    /* Heitz, A low-distortion map between triangle and square (2019): the fold. */
    if (t > s) {
        s *= 0.5;
        t -= s;
    } else {
        t *= 0.5;
        s -= t;
    }
    const double *vertices = shape->light.shape.polygon.vertices;
    const uint32_t *k = shape->triangles + 3 * low;
    vec3 a = v3_load(vertices + 3 * k[0]);
    vec3 p = v3_mad(a, v3_sub(v3_load(vertices + 3 * k[1]), a), s);
    return v3_mad(p, v3_sub(v3_load(vertices + 3 * k[2]), a), t);
}

struct light_point light_shape_sample(const struct light_shape *shape, double u, double v)
{
    double a, b;
    switch (shape->light.type) {
    case PNB_LIGHT_RECTANGLE:
        return (struct light_point){
            v3_mad(v3_mad(shape->origin, shape->axis_u, u), shape->axis_v, v), 1};
    case PNB_LIGHT_DISK:
        square_to_disk(u, v, &a, &b);
        return (struct light_point){
            v3_mad(v3_mad(shape->origin, shape->axis_u, a), shape->axis_v, b), 1};
    case PNB_LIGHT_POLYGON: return (struct light_point){sample_polygon(shape, u, v), 1};
    case PNB_LIGHT_LINE: return (struct light_point){v3_mad(shape->origin, shape->axis_u, u), 1};
    case PNB_LIGHT_POINT: return (struct light_point){shape->origin, 1};
    case PNB_LIGHT_SUN:
        square_to_disk(u, v, &a, &b);
        return (struct light_point){
            v3_normalize(v3_mad(v3_mad(shape->normal, shape->axis_u, a), shape->axis_v, b)), 0};
    }
    return (struct light_point){shape->origin, 1};
}

enum light_facing light_shape_facing(const struct light_shape *shape, vec3 p, vec3 n)
{
    double low = INFINITY, high = -INFINITY; /* heights of the light over the plane */
    switch (shape->light.type) {
    case PNB_LIGHT_RECTANGLE: {
        double h = v3_dot(v3_sub(shape->origin, p), n), u = v3_dot(shape->axis_u, n),
               v = v3_dot(shape->axis_v, n);
        low = h + (u < 0 ? u : 0) + (v < 0 ? v : 0);
        high = h + (u > 0 ? u : 0) + (v > 0 ? v : 0);
        break;
    }
    case PNB_LIGHT_DISK:
    case PNB_LIGHT_SUN: {
        bool sun = shape->light.type == PNB_LIGHT_SUN;
        double h = v3_dot(sun ? shape->normal : v3_sub(shape->origin, p), n);
        double reach = hypot(v3_dot(shape->axis_u, n), v3_dot(shape->axis_v, n));
        low = h - reach;
        high = h + reach;
        break;
    }
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < shape->light.shape.polygon.vertex_count; i++) {
            double h = v3_dot(v3_sub(v3_load(shape->light.shape.polygon.vertices + 3 * i), p), n);
            low = fmin(low, h);
            high = fmax(high, h);
        }
        break;
    case PNB_LIGHT_LINE: {
        double h = v3_dot(v3_sub(shape->origin, p), n), u = v3_dot(shape->axis_u, n);
        low = h + fmin(u, 0);
        high = h + fmax(u, 0);
        break;
    }
    case PNB_LIGHT_POINT: low = high = v3_dot(v3_sub(shape->origin, p), n); break;
    }
    if (!(high > 0) || !light_shape_lit_side(shape, p))
        return LIGHT_FACING_NONE;
    return low > 0 ? LIGHT_FACING_ALL : LIGHT_FACING_SOME;
}

bool light_shape_lit_side(const struct light_shape *shape, vec3 p)
{
    switch (shape->light.type) {
    case PNB_LIGHT_RECTANGLE:
    case PNB_LIGHT_DISK:
    case PNB_LIGHT_POLYGON: return v3_dot(v3_sub(p, shape->origin), shape->normal) > 0;
    default: return true;
    }
}

bool light_shape_faces(const struct light_shape *shape, vec3 p, vec3 n)
{
    return light_shape_facing(shape, p, n) == LIGHT_FACING_ALL;
}
