/* light.h: the shapes of lights.
 *
 * A light's colour is radiometric: radiance for area lights, radiant intensity per metre for lines,
 * radiant intensity for points, irradiance at normal incidence for the sun; each per channel of
 * linear RGB with sRGB primaries.
 */
#ifndef PENUMBRA_LIGHT_H
#define PENUMBRA_LIGHT_H

#include <penumbra/context.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Area lights emit on one side, lines and points all round; a sun is a disk infinitely far away. */
typedef enum pnb_light_type {
    PNB_LIGHT_RECTANGLE = 0,
    PNB_LIGHT_DISK,
    PNB_LIGHT_POLYGON,
    PNB_LIGHT_LINE,
    PNB_LIGHT_POINT,
    PNB_LIGHT_SUN
} pnb_light_type;
#define PNB_LIGHT_TYPE_COUNT 6

/* Bit of a light type in the masks that say what a method can do. */
#define PNB_LIGHT_BIT(type) (1u << (type))

typedef struct pnb_light {
    pnb_light_type type;
    const char *name; /* may be NULL */
    double color[3];
    union {
        /* Emits along half_u x half_v. half_u and half_v may be oblique: a parallelogram. */
        struct {
            double center[3], half_u[3], half_v[3];
        } rectangle;
        /* Emits along normal (any length but zero). */
        struct {
            double center[3], normal[3], radius;
        } disk;
        /* Planar, simple, convex or not; emits along the side from which its vertices run
         * counter-clockwise. vertex_count x 3 doubles; a scene copies them. */
        struct {
            const double *vertices;
            size_t vertex_count;
        } polygon;
        struct {
            double from[3], to[3];
        } line;
        struct {
            double position[3];
        } point;
        /* direction: the way the light travels (any length but zero). Infinitely far. */
        struct {
            double direction[3], angular_diameter_degrees;
        } sun;
    } shape;
} pnb_light;

PNB_API const char *pnb_light_type_name(pnb_light_type type); /* "rectangle", ... */

/* Finite numbers, an area (length, diameter) above zero, a polygon planar to 1e-4 of its size and
 * simple; else PNB_ERROR_SCENE with the reason. */
PNB_API pnb_status pnb_light_check(pnb_context *context, const pnb_light *light);

/* Unshadowed irradiance that the light sends to points with the given normals, noise-free.
 * Rectangle, polygon: Lambert's formula, clipped at the horizon. Disk, sun, line: closed form, or
 * quadrature converged to 1e-6 relative. positions, normals: count x 3 floats, world, normals of
 * unit length. irradiance: count x 3 floats (linear RGB), overwritten; 0 where the position is NaN.
 */
PNB_API pnb_status pnb_light_irradiance(pnb_context *context, const pnb_light *light,
                                        const float *positions, const float *normals, size_t count,
                                        float *irradiance);

#ifdef __cplusplus
}
#endif
#endif
