/* geom/vec.h: vectors of three doubles, and 3x4 placements. Values in, values out. */
#ifndef GEOM_VEC_H
#define GEOM_VEC_H

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
    return (vec3){p[0], p[1], p[2]};
}
static inline vec3 v3_loadf(const float *p)
{
    return (vec3){p[0], p[1], p[2]};
}
static inline void v3_store(double *p, vec3 a)
{
    p[0] = a.x, p[1] = a.y, p[2] = a.z;
}
static inline void v3_storef(float *p, vec3 a)
{
    p[0] = (float)a.x, p[1] = (float)a.y, p[2] = (float)a.z;
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
static inline vec3 v3_mad(vec3 a, vec3 b, double s) /* a + b s */
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
/* The zero vector stays zero. */
static inline vec3 v3_normalize(vec3 a)
{
    double n = v3_length(a);
    return n > 0 ? v3_scale(a, 1 / n) : a;
}
static inline vec3 v3_min(vec3 a, vec3 b)
{
    return v3(fmin(a.x, b.x), fmin(a.y, b.y), fmin(a.z, b.z));
}
static inline vec3 v3_max(vec3 a, vec3 b)
{
    return v3(fmax(a.x, b.x), fmax(a.y, b.y), fmax(a.z, b.z));
}
static inline bool v3_finite(vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}
static inline double v3_max_abs(vec3 a)
{
    return fmax(fabs(a.x), fmax(fabs(a.y), fabs(a.z)));
}

/* Two unit vectors that make a right-handed frame with the unit vector n: u x v = n. */
static inline void v3_frame(vec3 n, vec3 *u, vec3 *v)
{
    vec3 a = fabs(n.x) < 0.6 ? v3(1, 0, 0) : v3(0, 1, 0);
    *u = v3_normalize(v3_cross(a, n));
    *v = v3_cross(n, *u);
}

/* Row-major 3x4: world = M p + t. */
static inline vec3 m34_point(const double *m, vec3 p)
{
    return v3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3],
              m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
              m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}
static inline vec3 m34_vector(const double *m, vec3 p)
{
    return v3(m[0] * p.x + m[1] * p.y + m[2] * p.z, m[4] * p.x + m[5] * p.y + m[6] * p.z,
              m[8] * p.x + m[9] * p.y + m[10] * p.z);
}
static inline double m34_det(const double *m)
{
    return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
           m[2] * (m[4] * m[9] - m[5] * m[8]);
}
/* Normals: times the cofactor matrix of the linear part (its sign makes mirrored normals right).
 * Not normalised. */
static inline vec3 m34_normal(const double *m, vec3 n)
{
    double s = m34_det(m) < 0 ? -1 : 1;
    return v3_scale(v3((m[5] * m[10] - m[6] * m[9]) * n.x + (m[6] * m[8] - m[4] * m[10]) * n.y +
                           (m[4] * m[9] - m[5] * m[8]) * n.z,
                       (m[2] * m[9] - m[1] * m[10]) * n.x + (m[0] * m[10] - m[2] * m[8]) * n.y +
                           (m[1] * m[8] - m[0] * m[9]) * n.z,
                       (m[1] * m[6] - m[2] * m[5]) * n.x + (m[2] * m[4] - m[0] * m[6]) * n.y +
                           (m[0] * m[5] - m[1] * m[4]) * n.z),
                    s);
}

#endif
