/* viewer/vec.h: three doubles. */
#ifndef VIEWER_VEC_H
#define VIEWER_VEC_H

#include <math.h>
#include <stdbool.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

typedef struct vec3 {
    double x, y, z;
} vec3;

static inline vec3 v3(double x, double y, double z)
{
    return (vec3){x, y, z};
}

static inline vec3 v3_load(const double *p)
{
    return v3(p[0], p[1], p[2]);
}

static inline void v3_store(double *p, vec3 a)
{
    p[0] = a.x;
    p[1] = a.y;
    p[2] = a.z;
}

static inline vec3 v3_add(vec3 a, vec3 b)
{
    return v3(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline vec3 v3_sub(vec3 a, vec3 b)
{
    return v3(a.x - b.x, a.y - b.y, a.z - b.z);
}

static inline vec3 v3_scale(vec3 a, double s)
{
    return v3(a.x * s, a.y * s, a.z * s);
}

static inline vec3 v3_mad(vec3 a, vec3 b, double s)
{
    return v3(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline double v3_dot(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline vec3 v3_cross(vec3 a, vec3 b)
{
    return v3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline double v3_length(vec3 a)
{
    return sqrt(v3_dot(a, a));
}

/* fallback where a has no direction. */
static inline vec3 v3_unit(vec3 a, vec3 fallback)
{
    double length = v3_length(a);
    return length > 1e-300 && isfinite(length) ? v3_scale(a, 1 / length) : fallback;
}

static inline bool v3_finite(vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

/* Turned about a unit axis. */
static inline vec3 v3_turn(vec3 a, vec3 axis, double radians)
{
    double c = cos(radians), s = sin(radians);
    return v3_mad(v3_mad(v3_scale(a, c), v3_cross(axis, a), s), axis, v3_dot(axis, a) * (1 - c));
}

#endif
