/* viewer/camera.h: the pinhole camera under a hand: orbit, pan, zoom, and pixels to rays and back.
 */
#ifndef VIEWER_CAMERA_H
#define VIEWER_CAMERA_H

#include <penumbra/scene.h>

#include "vec.h"

/* The camera's axes for a picture of a size. Pixels are counted from the top left corner. */
struct view_lens {
    vec3 eye, forward, right, up;
    double half_y, half_x; /* tangents of half the field of view */
    double width, height;
};

struct view_lens view_lens_make(const pnb_camera *camera, double width, double height);
/* False behind the eye. */
bool view_lens_project(const struct view_lens *lens, vec3 p, double *x, double *y);
vec3 view_lens_ray(const struct view_lens *lens, double x, double y); /* of unit length */
/* Metres that one pixel spans at p's depth. */
double view_lens_pixel_size(const struct view_lens *lens, vec3 p);
/* Where the pixel's ray meets the plane through p; false where it does not, or far beyond
 * `farthest` from the eye. */
bool view_lens_on_plane(const struct view_lens *lens, double x, double y, vec3 p, vec3 normal,
                        double farthest, vec3 *out);
/* The point of the axis through p that is nearest to the pixel's ray. */
bool view_lens_on_axis(const struct view_lens *lens, double x, double y, vec3 p, vec3 axis,
                       double farthest, vec3 *out);

/* About the target: degrees to the right and up; stays off the poles. */
void view_camera_orbit(pnb_camera *camera, double right_degrees, double up_degrees);
/* By pixels of a picture of that height, at the target's depth. */
void view_camera_pan(pnb_camera *camera, double dx, double dy, double height);
/* Factor below 1 goes nearer; scale: the scene's size, which bounds the distance. */
void view_camera_zoom(pnb_camera *camera, double factor, double scale);
/* Keeps the direction, and frames the ball. */
void view_camera_frame(pnb_camera *camera, vec3 middle, double radius, double aspect);

#endif
