/* light/irradiance.c: the irradiance that an unshadowed light sends to a point, without noise.
 *
 * With r from the point to the light, n the point's normal, N the light's:
 *   area lights   E = L * integral of (n.r)+ (-N.r)+ / |r|^4 dA          L radiance
 *   line          E = I * integral of (n.r)+ / |r|^3 ds                  I intensity per metre, the
 *                 same in all directions: a line of small glowing beads, not a tube
 *   point         E = I (n.r)+ / |r|^3                                   I intensity
 *   sun           E = C where n is its axis; a cone of constant radiance
 *
 * Rectangle and polygon: Lambert's formula, E = L/2 sum over edges of (angle) n.(unit normal of the
 * edge's plane), after clipping at the horizon. Clipping a non-convex outline against one plane
 * leaves edges that run to and fro along the horizon; their terms cancel, so nothing special is
 * needed. Line: closed form. Disk: closed form where the horizon does not cut it, else strips
 * parallel to the cut, closed along the strip and by adaptive Gauss-Legendre across. The sun is a
 * disk at distance one.
 *
 * Accuracy: 1e-6 relative; the light seen edge-on at grazing angles below 1e-6 rad loses digits of
 * a value near zero. A point on the light itself gets 0 or the limit from its lit side, never NaN.
 */
#include "light/light.h"

#include <string.h>

#define STACK_VERTICES 64

/* One edge's angle times n.normal, from unnormalised ends. */
static double lambert_edge(vec3 a, vec3 b, vec3 n)
{
    vec3 c = v3_cross(a, b);
    double sine = v3_length(c), cosine = v3_dot(a, b);
    if (!(sine > 0))
        return 0;
    return atan2(sine, cosine) / sine * v3_dot(n, c);
}

/* vertices are relative to the point; counter-clockwise seen from the lit side. */
static double polygon_sum(const vec3 *vertices, size_t count, vec3 n)
{
    double sum = 0;
    vec3 first = v3(0, 0, 0), last = first;
    bool any = false;
    for (size_t i = 0; i < count; i++) {
        vec3 a = vertices[i], b = vertices[(i + 1) % count];
        double ha = v3_dot(a, n), hb = v3_dot(b, n);
        vec3 from = a, to = b;
        if (ha <= 0 && hb <= 0)
            continue;
        if (ha <= 0)
            from = v3_mad(a, v3_sub(b, a), ha / (ha - hb));
        else if (hb <= 0)
            to = v3_mad(a, v3_sub(b, a), ha / (ha - hb));
        if (!any)
            first = from;
        else if (ha <= 0)
            sum += lambert_edge(last, from, n); /* along the horizon */
        sum += lambert_edge(from, to, n);
        last = to;
        any = true;
    }
    if (any)
        sum += lambert_edge(last, first, n);
    return fmax(0, -0.5 * sum);
}

/* Integral over [x0, x1] of dx / (g + x^2)^2. */
static double strip_integral(double x0, double x1, double g)
{
    double root = sqrt(g);
    if (x1 < 0) {
        double swap = -x0;
        x0 = -x1;
        x1 = swap;
    }
    /* Both ends far on one side, where the closed form cancels: series of the tail in g / x^2. */
    if (x0 > 8 * root) {
        double a = 1 / (x0 * x0), b = 1 / (x1 * x1), pa = a / x0, pb = b / x1, sum = 0;
        for (int k = 0; k < 9; k++) {
            sum += (k & 1 ? -1 : 1) * (k + 1) * (pa - pb) / (3 + 2 * k);
            pa *= a * g;
            pb *= b * g;
        }
        return sum;
    }
    double q0 = x0 / root, q1 = x1 / root;
    return (q1 / (1 + q1 * q1) - q0 / (1 + q0 * q0) + atan(q1) - atan(q0)) / (2 * g * root);
}

struct cut_disk {
    double radius, height; /* of the disk's plane over the point, > 0 */
    double along, across;  /* the disk's middle: along the highest direction, across it */
    double n_up, n_along;  /* n = n_up * N + n_along * highest direction */
};

static double cut_disk_strip(const struct cut_disk *d, double psi)
{
    double s = sin(psi), w = d->along - d->radius * cos(psi), half = d->radius * s;
    double g = d->height * d->height + w * w;
    double cosine = d->n_up * d->height + d->n_along * w;
    if (!(cosine > 0))
        return 0;
    double inner = strip_integral(d->across - half, d->across + half, g);
    return d->height * cosine * inner * half; /* dw = R sin(psi) dpsi */
}

static const double gauss_x[8] = {0.0950125098376374, 0.2816035507792589, 0.4580167776572274,
                                  0.6178762444026438, 0.7554044083550030, 0.8656312023878318,
                                  0.9445750230732326, 0.9894009349916499};
static const double gauss_w[8] = {0.1894506104550685, 0.1826034150449236, 0.1691565193950025,
                                  0.1495959888165767, 0.1246289712555339, 0.0951585116824928,
                                  0.0622535239386479, 0.0271524594117541};

static double cut_disk_gauss(const struct cut_disk *d, double a, double b)
{
    double middle = 0.5 * (a + b), half = 0.5 * (b - a), sum = 0;
    for (int i = 0; i < 8; i++)
        sum += gauss_w[i] * (cut_disk_strip(d, middle - half * gauss_x[i]) +
                             cut_disk_strip(d, middle + half * gauss_x[i]));
    return sum * half;
}

static double cut_disk_adapt(const struct cut_disk *d, double a, double b, double whole,
                             double scale, int depth)
{
    double middle = 0.5 * (a + b);
    double left = cut_disk_gauss(d, a, middle), right = cut_disk_gauss(d, middle, b);
    scale = fmax(scale, left + right);
    if (depth == 0 || fabs(left + right - whole) <= 1e-8 * scale)
        return left + right;
    return cut_disk_adapt(d, a, middle, left, scale, depth - 1) +
           cut_disk_adapt(d, middle, b, right, scale, depth - 1);
}

/* Form factor times pi of a disk: middle c from the point, unit normal towards the point's far side
 * (away from the point: N = -lit normal), h = c.N > 0. */
static double disk_sum(vec3 c, vec3 normal, double radius, vec3 n)
{
    double h = v3_dot(c, normal), n_up = v3_dot(n, normal);
    if (!(h > 0))
        return 0;
    vec3 n_flat = v3_mad(n, normal, -n_up);
    double slope = v3_length(n_flat), middle = v3_dot(c, n);
    if (middle <= -radius * slope)
        return 0;
    if (middle >= radius * slope) {
        /* E = pi R^2 / (s (A + s)) [n.N (m + s) + 2 h n.c_flat] with A = |c|^2 + R^2,
         * m = h^2 + R^2 - |c_flat|^2, s^2 = m^2 + 4 |c_flat|^2 h^2: the contour integral round the
         * rim, arranged so that nothing cancels. */
        vec3 flat = v3_mad(c, normal, -h);
        double t2 = v3_dot(flat, flat), m = h * h + radius * radius - t2;
        double s = sqrt(m * m + 4 * t2 * h * h), sum_a = h * h + t2 + radius * radius + s;
        double lifted = m >= 0 ? m + s : 4 * t2 * h * h / (s - m);
        if (!(s > 0))
            return 0;
        return fmax(0, M_PI * radius * radius / (s * sum_a) *
                           (n_up * lifted + 2 * h * v3_dot(n, flat)));
    }
    vec3 up = v3_scale(n_flat, 1 / slope), side = v3_cross(normal, up);
    struct cut_disk d = {radius, h, v3_dot(c, up), v3_dot(c, side), n_up, slope};
    /* Strips w = along - R cos(psi) lie above the horizon where psi is beyond the cut. */
    double cut = acos(fmin(fmax(middle / (radius * slope), -1), 1));
    /* The peak below the point, if it lies over the disk, splits the range. */
    double peak = d.along > -radius && d.along < radius ? acos(d.along / radius) : -1;
    if (peak > cut + 1e-9 && peak < M_PI - 1e-9)
        return cut_disk_adapt(&d, cut, peak, cut_disk_gauss(&d, cut, peak), 0, 24) +
               cut_disk_adapt(&d, peak, M_PI, cut_disk_gauss(&d, peak, M_PI), 0, 24);
    return cut_disk_adapt(&d, cut, M_PI, cut_disk_gauss(&d, cut, M_PI), 0, 24);
}

static double line_sum(vec3 from, vec3 to, vec3 n)
{
    double ha = v3_dot(from, n), hb = v3_dot(to, n);
    if (ha <= 0 && hb <= 0)
        return 0;
    vec3 along = v3_sub(to, from);
    if (ha < 0)
        from = v3_mad(from, along, ha / (ha - hb));
    else if (hb < 0)
        to = v3_mad(from, along, ha / (ha - hb));
    vec3 u = v3_normalize(along);
    double t0 = v3_dot(from, u), t1 = v3_dot(to, u);
    vec3 foot = v3_mad(from, u, -t0);
    double d = v3_dot(foot, foot), q0 = sqrt(d + t0 * t0), q1 = sqrt(d + t1 * t1);
    if (!(q0 > 0) || !(q1 > 0))
        return 0;
    /* integral of dt / (d + t^2)^(3/2) = (t1/q1 - t0/q0) / d */
    double a = t1 / q1, b = t0 / q0, width = t1 - t0, across;
    if (t0 * t1 > 0)
        across = width * (t0 + t1) / (q0 * q0 * q1 * q1 * (a + b));
    else if (d > 0)
        across = (a - b) / d;
    else
        across = 0;
    /* integral of t dt / (d + t^2)^(3/2) = 1/q0 - 1/q1 */
    double forth = width * (t0 + t1) / (q0 * q1 * (q0 + q1));
    double sum = v3_dot(n, foot) * across + v3_dot(n, u) * forth;
    return isfinite(sum) ? fmax(0, sum) : 0;
}

struct irradiance {
    const struct light_shape *shape;
    const float *positions, *normals;
    float *out;
    vec3 *scratch; /* polygon vertices relative to the point, one row per worker; NULL: few */
    size_t vertex_count;
};

static double irradiance_at(const struct irradiance *job, vec3 p, vec3 n, vec3 *vertices)
{
    const struct light_shape *shape = job->shape;
    const pnb_light *light = &shape->light;
    if (!light_shape_lit_side(shape, p))
        return 0;
    switch (light->type) {
    case PNB_LIGHT_RECTANGLE:
        vertices[0] = v3_sub(shape->origin, p);
        vertices[1] = v3_add(vertices[0], shape->axis_u);
        vertices[2] = v3_add(vertices[1], shape->axis_v);
        vertices[3] = v3_add(vertices[0], shape->axis_v);
        return polygon_sum(vertices, 4, n);
    case PNB_LIGHT_POLYGON:
        for (size_t i = 0; i < job->vertex_count; i++)
            vertices[i] = v3_sub(v3_load(light->shape.polygon.vertices + 3 * i), p);
        return polygon_sum(vertices, job->vertex_count, n);
    case PNB_LIGHT_DISK:
        return disk_sum(v3_sub(shape->origin, p), v3_scale(shape->normal, -1),
                        light->shape.disk.radius, n);
    case PNB_LIGHT_SUN: {
        double radius = v3_length(shape->axis_u);
        /* A disk at distance 1 sends pi R^2 / (1 + R^2) along its axis. */
        return disk_sum(shape->normal, shape->normal, radius, n) * (1 + radius * radius) /
               (M_PI * radius * radius);
    }
    case PNB_LIGHT_LINE:
        return line_sum(v3_sub(v3_load(light->shape.line.from), p),
                        v3_sub(v3_load(light->shape.line.to), p), n);
    case PNB_LIGHT_POINT: {
        vec3 r = v3_sub(shape->origin, p);
        double d2 = v3_dot(r, r), cosine = v3_dot(r, n);
        return d2 > 0 && cosine > 0 ? cosine / (d2 * sqrt(d2)) : 0;
    }
    }
    return 0;
}

static void irradiance_body(void *user, size_t begin, size_t end, int worker)
{
    const struct irradiance *job = user;
    vec3 stack[STACK_VERTICES];
    vec3 *vertices = job->scratch ? job->scratch + (size_t)worker * job->vertex_count : stack;
    for (size_t i = begin; i < end; i++) {
        vec3 p = v3_loadf(job->positions + 3 * i), n = v3_loadf(job->normals + 3 * i);
        double e = 0;
        if (v3_finite(p) && v3_finite(n))
            e = irradiance_at(job, p, n, vertices);
        for (int c = 0; c < 3; c++)
            job->out[3 * i + c] = (float)(e * job->shape->light.color[c]);
    }
}

pnb_status pnb_light_irradiance(pnb_context *context, const pnb_light *light,
                                const float *positions, const float *normals, size_t count,
                                float *irradiance)
{
    struct light_shape shape;
    pnb_status status = pnb_light_check(context, light);
    if (status == PNB_OK && count > 0 && (!positions || !normals || !irradiance))
        status = status_missing(context, "positions, normals or irradiance");
    if (status == PNB_OK)
        status = light_shape_init(context, light, &shape);
    if (status != PNB_OK)
        return status;
    struct irradiance job = {&shape, positions, normals, irradiance, NULL, 0};
    if (light->type == PNB_LIGHT_POLYGON) {
        job.vertex_count = light->shape.polygon.vertex_count;
        if (job.vertex_count > STACK_VERTICES) {
            size_t rows = (size_t)pnb_context_threads(context);
            job.scratch = memory_alloc(context, rows * job.vertex_count, sizeof(vec3));
            if (!job.scratch) {
                light_shape_finish(context, &shape);
                return status_no_memory(context, rows * job.vertex_count * sizeof(vec3));
            }
        }
    }
    parallel_for(context, count, 2048, irradiance_body, &job);
    memory_free(context, job.scratch);
    light_shape_finish(context, &shape);
    return PNB_OK;
}
