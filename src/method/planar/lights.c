/* method/planar/lights.c: light samples of the ring rule.
 *
 * The paper (section 3.3.1) asks for samples that are random-like, prefer the border and never lie
 * in a line. Placement "border" is that. It makes penumbrae too wide and flat, since equal steps of
 * intensity belong to crowded samples; placement "optimised" chooses those samples for which the
 * ring rule's profile fits the light's area best (sample_tables.h), at no cost when it runs.
 *
 * A light that is not convex becomes clusters, one per triangle of it: between samples of one
 * cluster all is light, as the paper demands.
 */
#include <string.h>

#include "method/planar/room.h"
#include "method/planar/sample_tables.h"

enum { PARALLELOGRAM, DISK, TRIANGLE, POLYGON, LINE, POINT };

static bool convex(const double *p, size_t n, vec3 normal)
{
    for (size_t i = 0; i < n; i++) {
        vec3 a = v3_load(p + 3 * i), b = v3_load(p + 3 * ((i + 1) % n)),
             c = v3_load(p + 3 * ((i + 2) % n));
        vec3 d = v3_sub(b, a), e = v3_sub(c, b);
        if (v3_dot(v3_cross(d, e), normal) < -1e-9 * v3_length(d) * v3_length(e))
            return false;
    }
    return true;
}

static struct shadow_cluster triangle(vec3 a, vec3 b, vec3 c, double weight)
{
    return (struct shadow_cluster){
        .shape = TRIANGLE, .origin = a, .u = v3_sub(b, a), .v = v3_sub(c, a), .weight = weight};
}

pnb_status shadow_clusters(pnb_context *context, const struct light_shape *shape,
                           struct shadow_cluster **out_clusters, size_t *out_count)
{
    const pnb_light *light = &shape->light;
    size_t count = light->type == PNB_LIGHT_POLYGON ? shape->triangle_count : 1;
    struct shadow_cluster *c = memory_calloc(context, count, sizeof(*c));
    *out_clusters = c;
    *out_count = 1;
    if (!c)
        return status_no_memory(context, count * sizeof(*c));
    c[0].weight = 1;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        c[0].shape = PARALLELOGRAM;
        c[0].origin = v3_load(light->shape.rectangle.center);
        c[0].u = v3_load(light->shape.rectangle.half_u);
        c[0].v = v3_load(light->shape.rectangle.half_v);
        break;
    case PNB_LIGHT_DISK:
    case PNB_LIGHT_SUN:
        c[0].shape = DISK;
        c[0].directions = light->type == PNB_LIGHT_SUN;
        c[0].origin = c[0].directions ? shape->normal : shape->origin;
        c[0].u = shape->axis_u;
        c[0].v = shape->axis_v;
        if (c[0].directions && v3_length(c[0].u) == 0)
            c[0].shape = POINT;
        break;
    case PNB_LIGHT_POLYGON: {
        const double *p = light->shape.polygon.vertices;
        size_t n = light->shape.polygon.vertex_count;
        if (n > 3 && convex(p, n, shape->normal)) {
            vec3 a = v3_load(p), b = v3_load(p + 3), d = v3_load(p + 9), e = v3_load(p + 6);
            vec3 gap = v3_sub(v3_sub(v3_add(b, d), a), e);
            if (n == 4 && v3_length(gap) < 1e-6 * v3_length(v3_sub(e, a))) {
                c[0].shape = PARALLELOGRAM;
                c[0].origin = v3_scale(v3_add(a, e), 0.5);
                c[0].u = v3_scale(v3_sub(b, a), 0.5);
                c[0].v = v3_scale(v3_sub(d, a), 0.5);
            } else {
                c[0].shape = POLYGON;
                c[0].corners = p;
                c[0].corner_count = n;
                c[0].u = v3_normalize(shape->axis_u);
                c[0].v = v3_normalize(shape->axis_v);
                for (size_t i = 0; i < n; i++)
                    c[0].origin = v3_mad(c[0].origin, v3_load(p + 3 * i), 1.0 / (double)n);
            }
            break;
        }
        *out_count = shape->triangle_count;
        for (size_t i = 0; i < shape->triangle_count; i++) {
            const uint32_t *t = shape->triangles + 3 * i;
            c[i] = triangle(v3_load(p + 3 * (size_t)t[0]), v3_load(p + 3 * (size_t)t[1]),
                            v3_load(p + 3 * (size_t)t[2]),
                            shape->share[i] - (i > 0 ? shape->share[i - 1] : 0));
        }
        break;
    }
    case PNB_LIGHT_LINE:
        c[0].shape = LINE;
        c[0].origin = v3_load(light->shape.line.from);
        c[0].u = v3_sub(v3_load(light->shape.line.to), c[0].origin);
        break;
    case PNB_LIGHT_POINT:
        c[0].shape = POINT;
        c[0].origin = v3_load(light->shape.point.position);
        break;
    }
    return PNB_OK;
}

int shadow_sample_count(const struct shadow_cluster *cluster, int wanted)
{
    return cluster->shape == POINT ? 1 : wanted;
}

static vec3 at(const struct shadow_cluster *c, double x, double y)
{
    return v3_mad(v3_mad(c->origin, c->u, x), c->v, y);
}

/* From the unit disk along rays through the middle to the polygon. */
static vec3 in_polygon(const struct shadow_cluster *c, double x, double y)
{
    vec3 d = v3_add(v3_scale(c->u, x), v3_scale(c->v, y));
    double r = v3_length(d), reach = INFINITY;
    if (r == 0)
        return c->origin;
    vec3 n = v3_cross(c->u, c->v);
    for (size_t i = 0; i < c->corner_count; i++) {
        vec3 a = v3_sub(v3_load(c->corners + 3 * i), c->origin);
        vec3 b = v3_sub(v3_load(c->corners + 3 * ((i + 1) % c->corner_count)), c->origin);
        vec3 out = v3_cross(v3_sub(b, a), n);
        double down = v3_dot(d, out), height = v3_dot(a, out);
        if (height < 0) {
            down = -down;
            height = -height;
        }
        if (down > 0)
            reach = fmin(reach, height / down);
    }
    return v3_mad(c->origin, d, isfinite(reach) ? reach * r : 0);
}

static vec3 place(const struct shadow_cluster *c, double x, double y)
{
    return c->shape == POLYGON ? in_polygon(c, x, y) : at(c, x, y);
}

/* A point of the shape's border: t in [0, 1) runs round it once. */
static void border(int shape, double t, double *x, double *y)
{
    if (shape == PARALLELOGRAM) {
        double s = 8 * t, along = fmod(s, 2) - 1;
        int sidenumber = (int)(s / 2);
        *x = sidenumber == 0 ? along : sidenumber == 1 ? 1 : sidenumber == 2 ? -along : -1;
        *y = sidenumber == 0 ? -1 : sidenumber == 1 ? along : sidenumber == 2 ? 1 : -along;
    } else if (shape == TRIANGLE) {
        double s = 3 * t, along = fmod(s, 1);
        int sidenumber = (int)s;
        *x = sidenumber == 0 ? along : sidenumber == 1 ? 1 - along : 0;
        *y = sidenumber == 0 ? 0 : sidenumber == 1 ? along : 1 - along;
    } else {
        *x = cos(2 * M_PI * t);
        *y = sin(2 * M_PI * t);
    }
}

static void spread(int shape, int i, double *x, double *y)
{
    float u, v;
    light_sobol_owen((uint32_t)i, 0x51f15e5du, &u, &v);
    if (shape == PARALLELOGRAM) {
        *x = 2 * u - 1;
        *y = 2 * v - 1;
    } else if (shape == TRIANGLE) {
        double r = sqrt(u);
        *x = r * (1 - v);
        *y = r * v;
    } else {
        double r = sqrt(u);
        *x = r * cos(2 * M_PI * v);
        *y = r * sin(2 * M_PI * v);
    }
}

void shadow_samples(const struct shadow_cluster *c, enum shadow_placement placement, int count,
                    vec3 around, double far, vec3 *out)
{
    const struct sample_table *table = NULL;
    int shape = c->shape == POLYGON ? DISK : c->shape;
    for (size_t i = 0; i < sizeof(sample_tables) / sizeof(sample_tables[0]); i++)
        if (placement == SHADOW_OPTIMISED && sample_tables[i].shape == shape &&
            sample_tables[i].count == count)
            table = &sample_tables[i];
    /* The paper's: most of them on the border, at uneven steps; the rest inside. */
    int on_border = count <= 4 ? count : (int)(0.7 * count + 0.5);
    for (int i = 0; i < count; i++) {
        double x = 0, y = 0;
        if (c->shape == LINE) {
            x = count > 1 ? (double)i / (count - 1) : 0.5; /* equal steps are exact here */
        } else if (c->shape == POINT) {
            x = 0;
        } else if (table) {
            x = table->points[2 * i];
            y = table->points[2 * i + 1];
        } else if (count == 1) {
            x = y = shape == TRIANGLE ? 1 / 3.0 : 0;
        } else if (placement == SHADOW_BORDER && i < on_border) {
            double jitter = fmod(i * 0.6180339887498949, 1) - 0.5;
            border(shape, fmod((i + 0.3 * jitter) / on_border + 0.071, 1), &x, &y);
        } else {
            spread(shape, i, &x, &y);
        }
        out[i] = c->directions ? v3_mad(around, v3_normalize(place(c, x, y)), far) : place(c, x, y);
    }
}

int shadow_corners(const struct shadow_cluster *c, vec3 around, double far, int most, vec3 *out)
{
    int count = 0;
    if (c->shape == POLYGON) {
        int step = (int)((c->corner_count + (size_t)most - 1) / (size_t)most);
        for (size_t i = 0; i < c->corner_count; i += (size_t)step)
            out[count++] = v3_load(c->corners + 3 * i);
        return count;
    }
    count = c->shape == PARALLELOGRAM ? 4
            : c->shape == TRIANGLE    ? 3
            : c->shape == LINE        ? 2
            : c->shape == POINT       ? 1
                                      : 8;
    count = count < most ? count : most;
    for (int i = 0; i < count; i++) {
        double x = 0, y = 0;
        if (c->shape == LINE)
            x = i;
        else if (c->shape == PARALLELOGRAM || c->shape == TRIANGLE)
            border(c->shape, (double)i / count, &x, &y);
        else if (c->shape == DISK)
            border(c->shape, (i + 0.5) / count, &x, &y);
        out[i] = c->directions ? v3_mad(around, v3_normalize(place(c, x, y)), far) : place(c, x, y);
    }
    return count;
}

vec3 shadow_light_middle(const struct light_shape *shape, vec3 around, double far)
{
    if (shape->light.type == PNB_LIGHT_SUN)
        return v3_mad(around, shape->normal, far);
    return light_shape_sample(shape, 0.5, 0.5).p;
}
