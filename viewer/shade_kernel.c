/* viewer/shade_kernel.c: irradiance of a light at 16 points, in single precision.
 *
 * The formulas are those of pnb_light_irradiance(): Lambert's sum over the edges of a polygon, the
 * closed forms of disk and line. Lanes whose horizon cuts the light leave the vector loop: polygons
 * are then clipped, a disk becomes a polygon of 24 corners and equal area. An edge's angle over its
 * sine comes from a rational approximation (largest error 4e-4 of the value).
 *
 * Compiled once per instruction set: VIEW_KERNEL is the function's name. The loops over lanes are
 * written for the compiler to vectorise.
 */
#include "shade.h"

#include <math.h>

#define LANES        VIEW_LANES
#define FAST_MAX     8 /* vertices of polygons in the vector loop */
#define DISK_CORNERS 24
#define PI           3.14159265f

/* angle / sine of two unit vectors with this cosine. */
static inline float angle_over_sine(float c)
{
    float y = fabsf(c);
    float v = (5.36834f + (3.119699f + 0.0912357f * y) * y) / (3.417594f + (4.1616724f + y) * y);
    float rest = 1 - c * c;
    float flip = PI / sqrtf(rest > 1e-7f ? rest : 1e-7f) - v;
    return c > 0 ? v : flip;
}

struct point3 {
    float x, y, z;
};

static struct point3 mix(struct point3 a, struct point3 b, float t)
{
    return (struct point3){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z)};
}

static float edge_term(struct point3 a, struct point3 b, struct point3 n)
{
    float cx = a.y * b.z - a.z * b.y, cy = a.z * b.x - a.x * b.z, cz = a.x * b.y - a.y * b.x;
    float sine = sqrtf(cx * cx + cy * cy + cz * cz);
    float cosine = a.x * b.x + a.y * b.y + a.z * b.z;
    if (!(sine > 0))
        return 0;
    return atan2f(sine, cosine) / sine * (n.x * cx + n.y * cy + n.z * cz);
}

/* One point p, clipped at its horizon. */
static float clipped_polygon(const float *vertices, int count, struct point3 p, struct point3 n)
{
    struct point3 first = {0}, last = {0};
    bool any = false;
    float sum = 0;
    for (int i = 0; i < count; i++) {
        const float *va = vertices + 3 * i, *vb = vertices + 3 * (i + 1 < count ? i + 1 : 0);
        struct point3 a = {va[0] - p.x, va[1] - p.y, va[2] - p.z};
        struct point3 b = {vb[0] - p.x, vb[1] - p.y, vb[2] - p.z};
        float ha = a.x * n.x + a.y * n.y + a.z * n.z, hb = b.x * n.x + b.y * n.y + b.z * n.z;
        if (ha <= 0 && hb <= 0)
            continue;
        struct point3 from = ha <= 0 ? mix(a, b, ha / (ha - hb)) : a;
        struct point3 to = hb <= 0 ? mix(a, b, ha / (ha - hb)) : b;
        if (!any)
            first = from;
        else if (ha <= 0)
            sum += edge_term(last, from, n);
        sum += edge_term(from, to, n);
        last = to;
        any = true;
    }
    if (any)
        sum += edge_term(last, first, n);
    return fmaxf(0, -0.5f * sum);
}

static struct point3 lane_of(const float values[3][LANES], int lane)
{
    return (struct point3){values[0][lane], values[1][lane], values[2][lane]};
}

static void mask_lit_side(const struct view_emitter *e, const struct view_points *at, float *out)
{
    for (int i = 0; i < LANES; i++) {
        float side = (at->p[0][i] - e->center[0]) * e->normal[0] +
                     (at->p[1][i] - e->center[1]) * e->normal[1] +
                     (at->p[2][i] - e->center[2]) * e->normal[2];
        out[i] = side > 0 && out[i] > 0 ? out[i] : 0;
    }
}

static void polygon(const struct view_emitter *e, const struct view_points *at, float *out)
{
    float v[FAST_MAX][3][LANES], lowest[LANES], highest[LANES], sum[LANES] = {0};
    int count = e->count;
    for (int i = 0; i < LANES; i++) {
        lowest[i] = INFINITY;
        highest[i] = -INFINITY;
    }
    for (int k = 0; k < count && count <= FAST_MAX; k++) {
        const float *vertex = e->vertices + 3 * k;
        for (int i = 0; i < LANES; i++) {
            float x = vertex[0] - at->p[0][i], y = vertex[1] - at->p[1][i],
                  z = vertex[2] - at->p[2][i];
            float scale = 1 / sqrtf(x * x + y * y + z * z);
            float height = x * at->n[0][i] + y * at->n[1][i] + z * at->n[2][i];
            v[k][0][i] = x * scale;
            v[k][1][i] = y * scale;
            v[k][2][i] = z * scale;
            lowest[i] = height < lowest[i] ? height : lowest[i];
            highest[i] = height > highest[i] ? height : highest[i];
        }
    }
    for (int k = 0; k < count && count <= FAST_MAX; k++) {
        int next = k + 1 < count ? k + 1 : 0;
        for (int i = 0; i < LANES; i++) {
            float ax = v[k][0][i], ay = v[k][1][i], az = v[k][2][i];
            float bx = v[next][0][i], by = v[next][1][i], bz = v[next][2][i];
            float cosine = ax * bx + ay * by + az * bz;
            float across = (ay * bz - az * by) * at->n[0][i] + (az * bx - ax * bz) * at->n[1][i] +
                           (ax * by - ay * bx) * at->n[2][i];
            sum[i] += angle_over_sine(cosine) * across;
        }
    }
    for (int i = 0; i < LANES; i++)
        out[i] = -0.5f * sum[i];
    for (int i = 0; i < LANES; i++)
        if (count > FAST_MAX || !(lowest[i] > 0))
            out[i] = count > FAST_MAX || highest[i] > 0
                         ? clipped_polygon(e->vertices, count, lane_of(at->p, i), lane_of(at->n, i))
                         : 0;
    mask_lit_side(e, at, out);
}

static float slow_disk(const struct view_emitter *e, struct point3 c, struct point3 n, float nx,
                       float ny, float nz)
{
    /* Two axes of the disk's plane. */
    struct point3 u = fabsf(nx) < 0.6f ? (struct point3){0, nz, -ny} : (struct point3){-nz, 0, nx};
    float length = 1 / sqrtf(u.x * u.x + u.y * u.y + u.z * u.z);
    u = (struct point3){u.x * length, u.y * length, u.z * length};
    struct point3 v = {ny * u.z - nz * u.y, nz * u.x - nx * u.z, nx * u.y - ny * u.x};
    float radius = e->radius * sqrtf(2 * PI / DISK_CORNERS / sinf(2 * PI / DISK_CORNERS));
    float corners[3 * DISK_CORNERS];
    for (int k = 0; k < DISK_CORNERS; k++) {
        float a = 2 * PI * (float)k / DISK_CORNERS, cu = radius * cosf(a), cv = -radius * sinf(a);
        corners[3 * k] = c.x + cu * u.x + cv * v.x;
        corners[3 * k + 1] = c.y + cu * u.y + cv * v.y;
        corners[3 * k + 2] = c.z + cu * u.z + cv * v.z;
    }
    return clipped_polygon(corners, DISK_CORNERS, (struct point3){0, 0, 0}, n);
}

/* Disk and sun. N: the unit normal away from the point; c: the middle seen from the point. */
static void disk(const struct view_emitter *e, const struct view_points *at, float *out)
{
    bool sun = e->type == PNB_LIGHT_SUN;
    float sign = sun ? 1 : -1, r2 = e->radius * e->radius;
    float nx = sign * e->normal[0], ny = sign * e->normal[1], nz = sign * e->normal[2];
    float middle[LANES], slope[LANES];
    for (int i = 0; i < LANES; i++) {
        float cx = sun ? nx : e->center[0] - at->p[0][i];
        float cy = sun ? ny : e->center[1] - at->p[1][i];
        float cz = sun ? nz : e->center[2] - at->p[2][i];
        float ax = at->n[0][i], ay = at->n[1][i], az = at->n[2][i];
        float h = cx * nx + cy * ny + cz * nz, up = ax * nx + ay * ny + az * nz;
        float fx = cx - h * nx, fy = cy - h * ny, fz = cz - h * nz;
        float t2 = fx * fx + fy * fy + fz * fz, m = h * h + r2 - t2;
        float s = sqrtf(m * m + 4 * t2 * h * h);
        float plain = m + s, turned = 4 * t2 * h * h / (s - m);
        float lifted = m >= 0 ? plain : turned;
        float flat = ax * fx + ay * fy + az * fz;
        float value = PI * r2 / (s * (h * h + t2 + r2 + s)) * (up * lifted + 2 * h * flat);
        middle[i] = ax * cx + ay * cy + az * cz;
        float level = 1 - up * up;
        slope[i] = e->radius * sqrtf(level > 0 ? level : 0);
        value = h > 0 ? value : 0;
        out[i] = value > 0 ? value : 0;
    }
    for (int i = 0; i < LANES; i++) {
        if (!(middle[i] < slope[i]))
            continue;
        struct point3 c = {sun ? nx : e->center[0] - at->p[0][i],
                           sun ? ny : e->center[1] - at->p[1][i],
                           sun ? nz : e->center[2] - at->p[2][i]};
        struct point3 n = lane_of(at->n, i);
        bool in_front = c.x * nx + c.y * ny + c.z * nz > 0;
        out[i] = in_front && middle[i] > -slope[i] ? slow_disk(e, c, n, nx, ny, nz) : 0;
    }
    for (int i = 0; i < LANES; i++)
        out[i] *= e->sum_scale;
}

static void line(const struct view_emitter *e, const struct view_points *at, float *out)
{
    const float *from = e->vertices, *to = e->vertices + 3;
    for (int i = 0; i < LANES; i++) {
        float nx = at->n[0][i], ny = at->n[1][i], nz = at->n[2][i];
        float ax = from[0] - at->p[0][i], ay = from[1] - at->p[1][i], az = from[2] - at->p[2][i];
        float bx = to[0] - at->p[0][i], by = to[1] - at->p[1][i], bz = to[2] - at->p[2][i];
        float lx = bx - ax, ly = by - ay, lz = bz - az;
        float ha = ax * nx + ay * ny + az * nz, hb = bx * nx + by * ny + bz * nz;
        /* The part above the horizon: parameters s0 to s1. */
        float cut = ha / (ha - hb), s0 = ha < 0 ? cut : 0, s1 = hb < 0 ? cut : 1;
        float length = sqrtf(lx * lx + ly * ly + lz * lz);
        float ux = lx / length, uy = ly / length, uz = lz / length;
        float t = ax * ux + ay * uy + az * uz;
        float fx = ax - t * ux, fy = ay - t * uy, fz = az - t * uz;
        float t0 = t + s0 * length, t1 = t + s1 * length;
        float d = fx * fx + fy * fy + fz * fz;
        float q0 = sqrtf(d + t0 * t0), q1 = sqrtf(d + t1 * t1);
        float a = t1 / q1, b = t0 / q0, width = t1 - t0;
        float apart = width * (t0 + t1) / (q0 * q0 * q1 * q1 * (a + b)), close = (a - b) / d;
        float across = t0 * t1 > 0 ? apart : close;
        float forth = width * (t0 + t1) / (q0 * q1 * (q0 + q1));
        float sum = (nx * fx + ny * fy + nz * fz) * across + (nx * ux + ny * uy + nz * uz) * forth;
        out[i] = (ha > 0 || hb > 0) && sum > 0 && sum < INFINITY ? sum : 0;
    }
}

static void point(const struct view_emitter *e, const struct view_points *at, float *out)
{
    for (int i = 0; i < LANES; i++) {
        float x = e->center[0] - at->p[0][i], y = e->center[1] - at->p[1][i],
              z = e->center[2] - at->p[2][i];
        float d2 = x * x + y * y + z * z;
        float value = (x * at->n[0][i] + y * at->n[1][i] + z * at->n[2][i]) / (d2 * sqrtf(d2));
        out[i] = value > 0 && d2 > 0 ? value : 0;
    }
}

void VIEW_KERNEL(const struct view_emitter *emitter, const struct view_points *points, float *out)
{
    switch (emitter->type) {
    case PNB_LIGHT_RECTANGLE:
    case PNB_LIGHT_POLYGON: polygon(emitter, points, out); break;
    case PNB_LIGHT_DISK:
    case PNB_LIGHT_SUN: disk(emitter, points, out); break;
    case PNB_LIGHT_LINE: line(emitter, points, out); break;
    case PNB_LIGHT_POINT: point(emitter, points, out); break;
    }
}
