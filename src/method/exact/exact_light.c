/* method/exact/exact_light.c: the light as a grid of samples over a parallelogram.
 *
 * The rows are sheared against the light's sides, v = (1 + T) r + T (s - 1), and the samples' place
 * in their cells turns from row to row, so that no direction of an occluder's edge but one meets
 * the samples in step.
 *
 *      +--_____ v = 1        A row's part inside the light is cut into cells of equal length with
 *      | o   o -|o____+      one sample each; its weight is its length. Disks and polygons differ
 *      |   o   o|  o  |      from the parallelogram by their rows alone. Where a row meets a
 *      +--_____o|   o |      polygon in several pieces, the cells in between weigh nothing.
 *              +------+
 */
#include <stdlib.h>
#include <string.h>

#include "method/exact/exact.h"

struct pattern {
    int samples, rows, bins;
    double shear, turn, shift;
};

static const struct pattern patterns[] = {
    {256, 32, 16, 0.10456, 0.79334, 0.7822},
    {1024, 48, 32, 0.14030, 0.41824, 0.9499},
    {4096, 96, 64, 0.14030, 0.41824, 0.9499},
};

static const struct pattern line_pattern = {256, 1, 256, 0, 0, 0.5};
static const struct pattern point_pattern = {1, 1, 1, 0, 0, 0.5};

/* The pieces [low, high] of a row, in s, that lie in the light; at most max of them. */
struct shape {
    pnb_light_type type;
    double shear;
    /* Polygon: vertices in (s - 1/2, v - 1/2) of the unsheared parallelogram. */
    const double *vertices;
    size_t vertex_count;
};

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static size_t row_pieces(const struct shape *shape, double r, double *cuts)
{
    if (shape->type == PNB_LIGHT_LINE || shape->type == PNB_LIGHT_POINT) {
        cuts[0] = 0, cuts[1] = 1;
        return 2;
    }
    /* v - 1/2 = base + T (s - 1/2) */
    double t = shape->shear, base = (1 + t) * (r - 0.5);
    if (shape->type == PNB_LIGHT_RECTANGLE) {
        double low = 0, high = 1;
        if (t > 0) {
            low = fmax(low, (-0.5 - base) / t + 0.5);
            high = fmin(high, (0.5 - base) / t + 0.5);
        }
        cuts[0] = low, cuts[1] = high;
        return low < high ? 2 : 0;
    }
    if (shape->type == PNB_LIGHT_DISK || shape->type == PNB_LIGHT_SUN) {
        /* x^2 + (base + t x)^2 = 1/4 */
        double a = 1 + t * t, b = base * t, c = base * base - 0.25;
        double root = b * b - a * c;
        if (!(root > 0))
            return 0;
        root = sqrt(root);
        cuts[0] = (-b - root) / a + 0.5, cuts[1] = (-b + root) / a + 0.5;
        return 2;
    }
    size_t count = 0;
    for (size_t i = 0; i < shape->vertex_count; i++) {
        const double *p = shape->vertices + 2 * i;
        const double *q = shape->vertices + 2 * ((i + 1) % shape->vertex_count);
        double hp = p[1] - base - t * p[0], hq = q[1] - base - t * q[0];
        if ((hp > 0) != (hq > 0))
            cuts[count++] = p[0] + (q[0] - p[0]) * hp / (hp - hq) + 0.5;
    }
    qsort(cuts, count, sizeof(*cuts), compare_doubles);
    return count & ~(size_t)1;
}

/* Length of [a, b] inside the pieces. */
static double inside(const double *cuts, size_t count, double a, double b)
{
    double sum = 0;
    for (size_t c = 0; c + 1 < count; c += 2)
        sum += fmax(0, fmin(b, cuts[c + 1]) - fmax(a, cuts[c]));
    return sum;
}

static void weigh_row(struct exact_grid *grid, int row, const double *cuts, size_t count, bool area)
{
    double low = count ? cuts[0] : 0, high = count ? cuts[count - 1] : 1;
    double length = high - low;
    bool empty = count == 0 || !(length * 256 * grid->bins >= 1);
    if (empty)
        low = 0, length = 1;
    grid->scale[row] = (float)(1 / length);
    grid->base[row] = (float)(-low * grid->bins / length);
    grid->length[row] = empty ? 0 : (int32_t)lrint(length * 256 * grid->bins);
    for (int i = 0; i < grid->bins && !empty; i++) {
        double left = low + length * i / grid->bins, right = low + length * (i + 1) / grid->bins;
        double at = low + length * (i + (double)grid->place[row]) / grid->bins;
        double share = count == 2 ? 1 : inside(cuts, count, left, right) / (right - left);
        if (!area && count > 2) {
            share = 0;
            for (size_t c = 0; c + 1 < count; c += 2)
                share += at >= cuts[c] && at < cuts[c + 1];
        }
        grid->weight[i * grid->stride + row] = (int32_t)lrint(256 * fmin(fmax(share, 0), 1));
    }
    for (int i = 0; i <= grid->bins; i++) {
        int before = i > 0 ? grid->weight[(i - 1) * grid->stride + row] : 256;
        int after = i < grid->bins ? grid->weight[i * grid->stride + row] : 256;
        grid->inner[i * grid->stride + row] = before == 256 && after == 256 ? -1 : 0;
    }
}

static pnb_status grid_init(pnb_context *context, const struct pattern *pattern,
                            const struct shape *shape, bool area, struct exact_grid *grid)
{
    *grid = (struct exact_grid){.rows = pattern->rows, .bins = pattern->bins};
    grid->stride = grid->rows == 1 ? 1 : (grid->rows + 15) / 16 * 16;
    grid->row_shift = (float)pattern->shift;
    grid->per_bin = 1.0 / grid->bins;
    grid->per_row = 1.0 / grid->rows;
    grid->first_row = grid->row_shift * grid->per_row - 0.5;
    while ((grid->bins + 1) >> grid->fold > 31)
        grid->fold++;
    size_t size = exact_cover_size(grid);
    grid->weight = memory_calloc(context, size, sizeof(*grid->weight));
    grid->inner = memory_calloc(context, size, sizeof(*grid->inner));
    double *cuts = memory_alloc(context, shape->vertex_count + 2, sizeof(*cuts));
    grid->before = memory_calloc(context, size, sizeof(*grid->before));
    if (!grid->weight || !grid->inner || !grid->before || !cuts) {
        memory_free(context, cuts);
        return status_no_memory(context, size * 2 * sizeof(*grid->weight));
    }
    for (int j = 0; j < grid->rows; j++) {
        double turn = (j + 0.5) * pattern->turn;
        /* Away from the cell's ends, by which rounding could push it out. */
        double place = grid->rows == 1 ? 0.5 : turn - floor(turn);
        grid->place[j] = (float)fmin(fmax(place, 1.0 / 64), 63.0 / 64);
        double r = (j + pattern->shift) / grid->rows;
        weigh_row(grid, j, cuts, row_pieces(shape, r, cuts), area);
    }
    memory_free(context, cuts);
    for (int i = 0; i < grid->bins * grid->stride; i++)
        grid->before[i + grid->stride] = grid->before[i] + grid->weight[i];
    grid->words = (grid->bins + 31) / 32;
    for (int i = 0; i < grid->bins && i < EXACT_MASK_BINS; i++)
        for (int j = 0; j < grid->rows; j++)
            if (grid->weight[i * grid->stride + j] > 0 && grid->length[j] > 0)
                grid->need[j * grid->words + i / 32] |= 1u << (i % 32);
    for (int i = 0; i < grid->bins; i++)
        for (int j = 0; j < grid->rows; j++)
            grid->total += (double)grid->weight[i * grid->stride + j] * grid->length[j];
    return PNB_OK;
}

/* The rectangle around a planar polygon with one side along its longest edge; vertices in it. */
static void polygon_frame(const pnb_light *light, struct exact_light *out, double *vertices)
{
    const double *p = light->shape.polygon.vertices;
    size_t count = light->shape.polygon.vertex_count;
    vec3 n = v3(0, 0, 0), origin = v3_load(p), along = v3(0, 0, 0);
    for (size_t i = 0; i < count; i++) {
        vec3 a = v3_sub(v3_load(p + 3 * i), origin);
        vec3 b = v3_sub(v3_load(p + 3 * ((i + 1) % count)), origin);
        n = v3_add(n, v3_cross(a, b));
        if (v3_length(v3_sub(b, a)) > v3_length(along))
            along = v3_sub(b, a);
    }
    n = v3_normalize(n);
    vec3 u = v3_normalize(v3_mad(along, n, -v3_dot(along, n))), v = v3_cross(n, u);
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < count; i++) {
        vec3 q = v3_sub(v3_load(p + 3 * i), origin);
        double x[2] = {v3_dot(q, u), v3_dot(q, v)};
        for (int k = 0; k < 2; k++) {
            low[k] = fmin(low[k], x[k]);
            high[k] = fmax(high[k], x[k]);
            vertices[2 * i + (size_t)k] = x[k];
        }
    }
    double size[2] = {high[0] - low[0], high[1] - low[1]};
    for (size_t i = 0; i < 2 * count; i++)
        vertices[i] = (vertices[i] - low[i % 2]) / size[i % 2] - 0.5;
    out->normal = n;
    out->u = v3_scale(u, size[0]);
    out->v = v3_scale(v, size[1]);
    out->center = v3_mad(v3_mad(origin, u, 0.5 * (low[0] + high[0])), v, 0.5 * (low[1] + high[1]));
}

static double polygon_fill(const double *vertices, size_t count)
{
    double area = 0;
    for (size_t i = 0; i < count; i++) {
        const double *p = vertices + 2 * i, *q = vertices + 2 * ((i + 1) % count);
        area += 0.5 * (p[0] * q[1] - p[1] * q[0]);
    }
    return fabs(area);
}

pnb_status exact_light_init(pnb_context *context, const pnb_light *light, int samples, bool area,
                            struct exact_light *out)
{
    memset(out, 0, sizeof(*out));
    out->type = light->type;
    size_t last = sizeof(patterns) / sizeof(*patterns) - 1, quality = 0;
    while (quality < last && patterns[quality].samples < samples)
        quality++;
    struct pattern pattern = patterns[quality];
    struct shape shape = {light->type, pattern.shear, NULL, 0};
    double *vertices = NULL;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        out->one_sided = true;
        out->center = v3_load(light->shape.rectangle.center);
        out->u = v3_scale(v3_load(light->shape.rectangle.half_u), 2);
        out->v = v3_scale(v3_load(light->shape.rectangle.half_v), 2);
        out->normal = v3_normalize(v3_cross(out->u, out->v));
        break;
    case PNB_LIGHT_DISK:
        out->one_sided = true;
        out->center = v3_load(light->shape.disk.center);
        out->normal = v3_normalize(v3_load(light->shape.disk.normal));
        v3_frame(out->normal, &out->u, &out->v);
        out->u = v3_scale(out->u, 2 * light->shape.disk.radius);
        out->v = v3_scale(out->v, 2 * light->shape.disk.radius);
        break;
    case PNB_LIGHT_POLYGON:
        out->one_sided = true;
        shape.vertex_count = light->shape.polygon.vertex_count;
        vertices = memory_alloc(context, shape.vertex_count * 2, sizeof(*vertices));
        if (!vertices)
            return status_no_memory(context, shape.vertex_count * 2 * sizeof(*vertices));
        polygon_frame(light, out, vertices);
        shape.vertices = vertices;
        /* A shape that fills little of its rectangle wants more rows. */
        if (polygon_fill(vertices, shape.vertex_count) < 0.6 && pattern.rows <= 48)
            pattern.rows *= 2;
        break;
    case PNB_LIGHT_LINE:
        out->u = v3_sub(v3_load(light->shape.line.to), v3_load(light->shape.line.from));
        out->center = v3_mad(v3_load(light->shape.line.from), out->u, 0.5);
        pattern = line_pattern;
        break;
    case PNB_LIGHT_POINT:
        out->center = v3_load(light->shape.point.position);
        pattern = point_pattern;
        break;
    case PNB_LIGHT_SUN: {
        double radius = tan(light->shape.sun.angular_diameter_degrees * M_PI / 360);
        out->sun = true;
        out->center = v3_scale(v3_normalize(v3_load(light->shape.sun.direction)), -1);
        out->normal = v3_scale(out->center, -1);
        v3_frame(out->center, &out->u, &out->v);
        out->u = v3_scale(out->u, 2 * radius);
        out->v = v3_scale(out->v, 2 * radius);
        break;
    }
    }
    out->samples = pattern.samples;
    if (pattern.rows > 1) {
        out->u = v3_mad(out->u, out->v, pattern.shear);
        out->v = v3_scale(out->v, 1 + pattern.shear);
    }
    pnb_status status = grid_init(context, &pattern, &shape, area, &out->grid);
    /* r = (y + shift) / rows, s = x / bins; v = (1 + T) r + T (s - 1). */
    out->closed = light->type == PNB_LIGHT_RECTANGLE;
    out->to_u = (float)(1.0 / pattern.bins);
    out->v_x = (float)(pattern.shear / pattern.bins);
    out->v_y = (float)((1 + pattern.shear) / pattern.rows);
    out->v_0 = (float)((1 + pattern.shear) * pattern.shift / pattern.rows - pattern.shear);
    memory_free(context, vertices);
    if (status == PNB_OK && !(out->grid.total > 0))
        status = status_fail(context, PNB_ERROR_SCENE, "light",
                             "its shape is thinner than the sample pattern");
    if (status != PNB_OK)
        exact_light_finish(context, out);
    return status;
}

void exact_light_finish(pnb_context *context, struct exact_light *light)
{
    memory_free(context, light->grid.weight);
    memory_free(context, light->grid.inner);
    memory_free(context, light->grid.before);
    light->grid.weight = light->grid.inner = light->grid.before = NULL;
}
