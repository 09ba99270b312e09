/* viewer/lights.c: lights as a hand moves, turns and sizes them.
 *
 * A rectangle's sides may be oblique; moving, turning and sizing keep that. Sizes never fall to
 * zero, so a light stays one that the library takes.
 */
#include "lights.h"

#include <glib.h>
#include <string.h>

void view_light_copy(struct view_light *to, const pnb_light *from)
{
    *to = (struct view_light){.light = *from};
    to->light.name = NULL;
    if (from->type == PNB_LIGHT_POLYGON) {
        to->vertices = g_memdup2(from->shape.polygon.vertices,
                                 from->shape.polygon.vertex_count * 3 * sizeof(double));
        to->light.shape.polygon.vertices = to->vertices;
    }
}

void view_light_finish(struct view_light *light)
{
    g_free(light->vertices);
    *light = (struct view_light){0};
}

bool view_light_equal(const pnb_light *a, const pnb_light *b)
{
    if (a->type != b->type || memcmp(a->color, b->color, sizeof(a->color)) != 0)
        return false;
    switch (a->type) {
    case PNB_LIGHT_RECTANGLE:
        return memcmp(&a->shape.rectangle, &b->shape.rectangle, sizeof(a->shape.rectangle)) == 0;
    case PNB_LIGHT_DISK: return memcmp(&a->shape.disk, &b->shape.disk, sizeof(a->shape.disk)) == 0;
    case PNB_LIGHT_POLYGON:
        return a->shape.polygon.vertex_count == b->shape.polygon.vertex_count &&
               memcmp(a->shape.polygon.vertices, b->shape.polygon.vertices,
                      a->shape.polygon.vertex_count * 3 * sizeof(double)) == 0;
    case PNB_LIGHT_LINE: return memcmp(&a->shape.line, &b->shape.line, sizeof(a->shape.line)) == 0;
    case PNB_LIGHT_POINT:
        return memcmp(&a->shape.point, &b->shape.point, sizeof(a->shape.point)) == 0;
    case PNB_LIGHT_SUN: return memcmp(&a->shape.sun, &b->shape.sun, sizeof(a->shape.sun)) == 0;
    }
    return false;
}

/* A unit vector perpendicular to n, level where it can be. */
static vec3 level_axis(vec3 n)
{
    vec3 u = v3_cross(v3(0, 1, 0), n);
    return v3_length(u) > 1e-4 ? v3_unit(u, v3(1, 0, 0)) : v3(1, 0, 0);
}

static void axes_from_normal(struct view_frame_axes *axes, vec3 n)
{
    axes->n = v3_unit(n, v3(0, -1, 0));
    axes->u = v3_unit(v3_mad(level_axis(axes->n), axes->n, -v3_dot(level_axis(axes->n), axes->n)),
                      v3(1, 0, 0));
    axes->v = v3_cross(axes->n, axes->u);
}

static void polygon_axes(const struct view_light *light, struct view_frame_axes *axes)
{
    size_t count = light->light.shape.polygon.vertex_count;
    vec3 first = v3_load(light->vertices), normal = v3(0, 0, 0), sum = v3(0, 0, 0);
    for (size_t i = 0; i < count; i++)
        sum = v3_add(sum, v3_load(light->vertices + 3 * i));
    for (size_t i = 1; i + 1 < count; i++)
        normal = v3_add(normal, v3_cross(v3_sub(v3_load(light->vertices + 3 * i), first),
                                         v3_sub(v3_load(light->vertices + 3 * (i + 1)), first)));
    axes->center = v3_scale(sum, 1.0 / (double)count);
    axes_from_normal(axes, normal);
    for (size_t i = 0; i < count; i++) {
        vec3 r = v3_sub(v3_load(light->vertices + 3 * i), axes->center);
        axes->half_u = fmax(axes->half_u, fabs(v3_dot(r, axes->u)));
        axes->half_v = fmax(axes->half_v, fabs(v3_dot(r, axes->v)));
    }
}

struct view_frame_axes view_light_axes(const struct view_light *light, vec3 middle, double distance)
{
    struct view_frame_axes axes = {.u = {1, 0, 0}, .v = {0, 0, 1}, .n = {0, -1, 0}};
    switch (light->light.type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(light->light.shape.rectangle.half_u);
        vec3 v = v3_load(light->light.shape.rectangle.half_v);
        axes.center = v3_load(light->light.shape.rectangle.center);
        axes.half_u = v3_length(u);
        axes.half_v = v3_length(v);
        axes.n = v3_unit(v3_cross(u, v), v3(0, -1, 0));
        axes.u = v3_unit(u, v3(1, 0, 0));
        axes.v = v3_cross(axes.n, axes.u);
        break;
    }
    case PNB_LIGHT_DISK:
        axes.center = v3_load(light->light.shape.disk.center);
        axes_from_normal(&axes, v3_load(light->light.shape.disk.normal));
        axes.half_u = axes.half_v = light->light.shape.disk.radius;
        break;
    case PNB_LIGHT_POLYGON: polygon_axes(light, &axes); break;
    case PNB_LIGHT_LINE: {
        vec3 from = v3_load(light->light.shape.line.from), to = v3_load(light->light.shape.line.to);
        axes.center = v3_scale(v3_add(from, to), 0.5);
        axes.u = v3_unit(v3_sub(to, from), v3(1, 0, 0));
        axes.half_u = 0.5 * v3_length(v3_sub(to, from));
        vec3 down = v3_mad(v3(0, -1, 0), axes.u, axes.u.y);
        axes.n = v3_unit(down, v3(0, 0, 1));
        axes.v = v3_cross(axes.n, axes.u);
        break;
    }
    case PNB_LIGHT_POINT: axes.center = v3_load(light->light.shape.point.position); break;
    case PNB_LIGHT_SUN:
        axes_from_normal(&axes, v3_load(light->light.shape.sun.direction));
        axes.center = v3_mad(middle, axes.n, -distance);
        axes.half_u =
            tan(0.5 * light->light.shape.sun.angular_diameter_degrees * M_PI / 180) * distance;
        axes.half_v = axes.half_u;
        break;
    }
    return axes;
}

static void add3(double *p, vec3 by)
{
    v3_store(p, v3_add(v3_load(p), by));
}

void view_light_move(struct view_light *light, vec3 by, vec3 middle, double distance)
{
    pnb_light *l = &light->light;
    if (!v3_finite(by))
        return;
    switch (l->type) {
    case PNB_LIGHT_RECTANGLE: add3(l->shape.rectangle.center, by); break;
    case PNB_LIGHT_DISK: add3(l->shape.disk.center, by); break;
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < l->shape.polygon.vertex_count; i++)
            add3(light->vertices + 3 * i, by);
        break;
    case PNB_LIGHT_LINE:
        add3(l->shape.line.from, by);
        add3(l->shape.line.to, by);
        break;
    case PNB_LIGHT_POINT: add3(l->shape.point.position, by); break;
    case PNB_LIGHT_SUN: {
        vec3 old = v3_unit(v3_load(l->shape.sun.direction), v3(0, -1, 0));
        vec3 place = v3_add(v3_mad(middle, old, -distance), by);
        v3_store(l->shape.sun.direction, v3_unit(v3_sub(middle, place), old));
        break;
    }
    }
}

/* The columns of from become those of to. */
static vec3 change_basis(vec3 a, const vec3 from[3], const vec3 to[3])
{
    vec3 out = v3(0, 0, 0);
    for (int k = 0; k < 3; k++)
        out = v3_mad(out, to[k], v3_dot(a, from[k]));
    return out;
}

static void turn_basis(struct view_light *light, const vec3 from[3], const vec3 to[3])
{
    pnb_light *l = &light->light;
    switch (l->type) {
    case PNB_LIGHT_RECTANGLE:
        v3_store(l->shape.rectangle.half_u,
                 change_basis(v3_load(l->shape.rectangle.half_u), from, to));
        v3_store(l->shape.rectangle.half_v,
                 change_basis(v3_load(l->shape.rectangle.half_v), from, to));
        break;
    case PNB_LIGHT_DISK:
        v3_store(l->shape.disk.normal, change_basis(v3_load(l->shape.disk.normal), from, to));
        break;
    case PNB_LIGHT_POLYGON: {
        struct view_frame_axes axes = view_light_axes(light, v3(0, 0, 0), 0);
        for (size_t i = 0; i < l->shape.polygon.vertex_count; i++) {
            double *p = light->vertices + 3 * i;
            v3_store(p,
                     v3_add(axes.center, change_basis(v3_sub(v3_load(p), axes.center), from, to)));
        }
        break;
    }
    case PNB_LIGHT_LINE: {
        struct view_frame_axes axes = view_light_axes(light, v3(0, 0, 0), 0);
        vec3 half = change_basis(v3_scale(axes.u, axes.half_u), from, to);
        v3_store(l->shape.line.from, v3_sub(axes.center, half));
        v3_store(l->shape.line.to, v3_add(axes.center, half));
        break;
    }
    case PNB_LIGHT_POINT: break;
    case PNB_LIGHT_SUN:
        v3_store(l->shape.sun.direction, change_basis(v3_load(l->shape.sun.direction), from, to));
        break;
    }
}

void view_light_turn(struct view_light *light, vec3 axis, double radians)
{
    const vec3 from[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vec3 to[3];
    if (!isfinite(radians))
        return;
    for (int k = 0; k < 3; k++)
        to[k] = v3_turn(from[k], axis, radians);
    turn_basis(light, from, to);
}

void view_light_aim(struct view_light *light, const struct view_frame_axes *axes, vec3 u, vec3 n)
{
    const vec3 from[3] = {axes->u, axes->v, axes->n};
    const vec3 to[3] = {u, v3_cross(n, u), n};
    if (v3_finite(u) && v3_finite(n))
        turn_basis(light, from, to);
}

static double at_least(double value, double smallest)
{
    return value > smallest ? value : smallest; /* NaN too */
}

void view_light_resize(struct view_light *light, const struct view_frame_axes *axes, double half_u,
                       double half_v, double smallest)
{
    pnb_light *l = &light->light;
    half_u = at_least(half_u, smallest);
    half_v = at_least(half_v, smallest);
    switch (l->type) {
    case PNB_LIGHT_RECTANGLE: {
        double *u = l->shape.rectangle.half_u, *v = l->shape.rectangle.half_v;
        v3_store(u, v3_scale(v3_load(u), half_u / v3_length(v3_load(u))));
        v3_store(v, v3_scale(v3_load(v), half_v / v3_length(v3_load(v))));
        break;
    }
    case PNB_LIGHT_DISK:
        l->shape.disk.radius =
            fabs(half_u - axes->half_u) >= fabs(half_v - axes->half_v) ? half_u : half_v;
        break;
    case PNB_LIGHT_POLYGON: {
        double su = half_u / at_least(axes->half_u, smallest);
        double sv = half_v / at_least(axes->half_v, smallest);
        for (size_t i = 0; i < l->shape.polygon.vertex_count; i++) {
            vec3 r = v3_sub(v3_load(light->vertices + 3 * i), axes->center);
            vec3 p = v3_mad(axes->center, axes->u, su * v3_dot(r, axes->u));
            p = v3_mad(p, axes->v, sv * v3_dot(r, axes->v));
            v3_store(light->vertices + 3 * i, p);
        }
        break;
    }
    case PNB_LIGHT_LINE:
        v3_store(l->shape.line.from, v3_mad(axes->center, axes->u, -half_u));
        v3_store(l->shape.line.to, v3_mad(axes->center, axes->u, half_u));
        break;
    case PNB_LIGHT_POINT: break;
    case PNB_LIGHT_SUN: {
        double degrees = 360 / M_PI * atan(half_u);
        l->shape.sun.angular_diameter_degrees = fmin(fmax(degrees, 0.01), 90);
        break;
    }
    }
}

/* What the light sends along its axis to a far point, over its squared distance. */
static double strength(const pnb_light *l, const struct view_frame_axes *axes)
{
    switch (l->type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(l->shape.rectangle.half_u), v = v3_load(l->shape.rectangle.half_v);
        return 4 * v3_length(v3_cross(u, v));
    }
    case PNB_LIGHT_DISK: return M_PI * axes->half_u * axes->half_u;
    case PNB_LIGHT_POLYGON: {
        vec3 area = v3(0, 0, 0);
        const double *p = l->shape.polygon.vertices;
        for (size_t i = 1; i + 1 < l->shape.polygon.vertex_count; i++)
            area = v3_add(area, v3_cross(v3_sub(v3_load(p + 3 * i), v3_load(p)),
                                         v3_sub(v3_load(p + 3 * i + 3), v3_load(p))));
        return 0.5 * v3_length(area);
    }
    case PNB_LIGHT_LINE: return 2 * axes->half_u;
    case PNB_LIGHT_POINT: return 1;
    case PNB_LIGHT_SUN: return 0;
    }
    return 0;
}

void view_light_reshape(struct view_light *light, pnb_light_type type,
                        const struct view_frame_axes *axes, double smallest)
{
    double old = strength(&light->light, axes);
    bool from_sun = light->light.type == PNB_LIGHT_SUN;
    struct view_light made = {.light = {.type = type}};
    pnb_light *l = &made.light;
    double half_u = axes->half_u > smallest ? axes->half_u : 100 * smallest;
    double half_v = axes->half_v > smallest ? axes->half_v : half_u;
    memcpy(l->color, light->light.color, sizeof(l->color));
    switch (type) {
    case PNB_LIGHT_RECTANGLE:
        v3_store(l->shape.rectangle.center, axes->center);
        v3_store(l->shape.rectangle.half_u, v3_scale(axes->u, half_u));
        v3_store(l->shape.rectangle.half_v, v3_scale(axes->v, half_v));
        break;
    case PNB_LIGHT_DISK:
        v3_store(l->shape.disk.center, axes->center);
        v3_store(l->shape.disk.normal, axes->n);
        l->shape.disk.radius = half_u;
        break;
    case PNB_LIGHT_POLYGON: {
        /* An L: the simplest outline that is not convex. */
        static const double corners[6][2] = {{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}};
        made.vertices = g_new(double, 18);
        for (int i = 0; i < 6; i++)
            v3_store(made.vertices + 3 * i,
                     v3_mad(v3_mad(axes->center, axes->u, half_u * corners[i][0]), axes->v,
                            half_v * corners[i][1]));
        l->shape.polygon.vertices = made.vertices;
        l->shape.polygon.vertex_count = 6;
        break;
    }
    case PNB_LIGHT_LINE:
        v3_store(l->shape.line.from, v3_mad(axes->center, axes->u, -half_u));
        v3_store(l->shape.line.to, v3_mad(axes->center, axes->u, half_u));
        break;
    case PNB_LIGHT_POINT: v3_store(l->shape.point.position, axes->center); break;
    case PNB_LIGHT_SUN:
        v3_store(l->shape.sun.direction, axes->n);
        l->shape.sun.angular_diameter_degrees = 2;
        break;
    }
    struct view_frame_axes new_axes = view_light_axes(&made, v3(0, 0, 0), 0);
    double now = strength(l, &new_axes);
    if (!from_sun && type != PNB_LIGHT_SUN && old > 0 && now > 0)
        for (int c = 0; c < 3; c++)
            l->color[c] *= old / now;
    view_light_finish(light);
    *light = made;
}

void view_axes_angles(const struct view_frame_axes *axes, double *azimuth, double *elevation,
                      double *twist)
{
    vec3 n = axes->n, u0, n0;
    *elevation = asin(fmin(fmax(n.y, -1), 1)) * 180 / M_PI;
    *azimuth = fabs(n.x) + fabs(n.z) > 1e-9 ? atan2(n.x, n.z) * 180 / M_PI : 0;
    view_axes_from_angles(*azimuth, *elevation, 0, &u0, &n0);
    *twist = atan2(v3_dot(axes->u, v3_cross(n, u0)), v3_dot(axes->u, u0)) * 180 / M_PI;
}

void view_axes_from_angles(double azimuth, double elevation, double twist, vec3 *out_u, vec3 *out_n)
{
    double a = azimuth * M_PI / 180, e = elevation * M_PI / 180;
    vec3 n = v3(cos(e) * sin(a), sin(e), cos(e) * cos(a));
    *out_n = v3_unit(n, v3(0, -1, 0));
    /* level, and continuous through the poles */
    *out_u = v3_turn(v3(cos(a), 0, -sin(a)), *out_n, twist * M_PI / 180);
}

int view_light_outline(const struct view_light *light, vec3 middle, double distance, vec3 *out)
{
    const pnb_light *l = &light->light;
    struct view_frame_axes axes = view_light_axes(light, middle, distance);
    int count = 0;
    switch (l->type) {
    case PNB_LIGHT_RECTANGLE: {
        vec3 u = v3_load(l->shape.rectangle.half_u), v = v3_load(l->shape.rectangle.half_v);
        out[count++] = v3_sub(v3_sub(axes.center, u), v);
        out[count++] = v3_sub(v3_add(axes.center, u), v);
        out[count++] = v3_add(v3_add(axes.center, u), v);
        out[count++] = v3_add(v3_sub(axes.center, u), v);
        break;
    }
    case PNB_LIGHT_DISK:
    case PNB_LIGHT_SUN:
        for (; count < 48; count++) {
            double t = 2 * M_PI * count / 48;
            out[count] = v3_mad(v3_mad(axes.center, axes.u, axes.half_u * cos(t)), axes.v,
                                axes.half_v * sin(t));
        }
        break;
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < l->shape.polygon.vertex_count && count < VIEW_OUTLINE_MAX; i++)
            out[count++] = v3_load(light->vertices + 3 * i);
        break;
    case PNB_LIGHT_LINE:
        out[count++] = v3_load(l->shape.line.from);
        out[count++] = v3_load(l->shape.line.to);
        break;
    case PNB_LIGHT_POINT: out[count++] = axes.center; break;
    }
    return count;
}
