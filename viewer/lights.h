/* viewer/lights.h: lights as a hand moves, turns and sizes them. */
#ifndef VIEWER_LIGHTS_H
#define VIEWER_LIGHTS_H

#include <penumbra/light.h>

#include "vec.h"

/* A light that owns its vertices. */
struct view_light {
    pnb_light light; /* shape.polygon.vertices is vertices; name is NULL */
    double *vertices;
};

/* Every shape seen the same way: a place, two axes in the light's surface and the side that it
 * shines to, u x v = n, all of unit length; half extents along u and v in metres, 0 where the shape
 * has none. A line runs along u. A sun has no place: it is drawn towards the scene's middle. */
struct view_frame_axes {
    vec3 center, u, v, n;
    double half_u, half_v;
};

void view_light_copy(struct view_light *to, const pnb_light *from);
void view_light_finish(struct view_light *light);
/* Of the same shape and colour, to the bit. */
bool view_light_equal(const pnb_light *a, const pnb_light *b);

/* middle and distance: where a sun is drawn, distance against its direction from middle. */
struct view_frame_axes view_light_axes(const struct view_light *light, vec3 middle,
                                       double distance);

void view_light_move(struct view_light *light, vec3 by, vec3 middle, double distance);
/* About the light's own place. */
void view_light_turn(struct view_light *light, vec3 axis, double radians);
/* Turns the frame (u, v, n) of axes into the new one, u and n of unit length and perpendicular. */
void view_light_aim(struct view_light *light, const struct view_frame_axes *axes, vec3 u, vec3 n);
/* New half extents; lengths below the smallest are raised to it. A disk takes half_u (and half_v
 * where only that differs), a sun's half_u is the tangent of half its angular diameter. */
void view_light_resize(struct view_light *light, const struct view_frame_axes *axes, double half_u,
                       double half_v, double smallest);
/* The same place and look as another shape, as bright on what lies far below it. */
void view_light_reshape(struct view_light *light, pnb_light_type type,
                        const struct view_frame_axes *axes, double smallest);

/* Azimuth, elevation of the side that it shines to, and the turn of u about it; degrees. Elevation
 * -90 shines down. And back. */
void view_axes_angles(const struct view_frame_axes *axes, double *azimuth, double *elevation,
                      double *twist);
void view_axes_from_angles(double azimuth, double elevation, double twist, vec3 *out_u,
                           vec3 *out_n);

/* The outline in the world for drawing: at most VIEW_OUTLINE_MAX points, returns how many; closed
 * unless it is a line. 1 for a point or sun. */
#define VIEW_OUTLINE_MAX 128
int view_light_outline(const struct view_light *light, vec3 middle, double distance, vec3 *out);

#endif
