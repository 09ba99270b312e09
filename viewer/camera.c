/* viewer/camera.c: orbit, pan, zoom; pixels to rays and back. */
#include "camera.h"

struct view_lens view_lens_make(const pnb_camera *camera, double width, double height)
{
    struct view_lens lens = {.eye = v3_load(camera->eye), .width = width, .height = height};
    lens.forward = v3_unit(v3_sub(v3_load(camera->target), lens.eye), v3(0, 0, -1));
    lens.right = v3_unit(v3_cross(lens.forward, v3_load(camera->up)), v3(1, 0, 0));
    lens.up = v3_cross(lens.right, lens.forward);
    lens.half_y = tan(0.5 * camera->vertical_fov_degrees * M_PI / 180);
    lens.half_x = lens.half_y * width / height;
    return lens;
}

bool view_lens_project(const struct view_lens *lens, vec3 p, double *x, double *y)
{
    vec3 r = v3_sub(p, lens->eye);
    double depth = v3_dot(r, lens->forward);
    if (!(depth > 1e-9 * (1 + v3_length(r))))
        return false;
    *x = 0.5 * lens->width * (1 + v3_dot(r, lens->right) / (depth * lens->half_x));
    *y = 0.5 * lens->height * (1 - v3_dot(r, lens->up) / (depth * lens->half_y));
    return true;
}

vec3 view_lens_ray(const struct view_lens *lens, double x, double y)
{
    vec3 d = v3_mad(lens->forward, lens->right, lens->half_x * (2 * x / lens->width - 1));
    return v3_unit(v3_mad(d, lens->up, lens->half_y * (1 - 2 * y / lens->height)), lens->forward);
}

double view_lens_pixel_size(const struct view_lens *lens, vec3 p)
{
    double depth = v3_dot(v3_sub(p, lens->eye), lens->forward);
    return fmax(depth, 0) * 2 * lens->half_y / lens->height;
}

bool view_lens_on_plane(const struct view_lens *lens, double x, double y, vec3 p, vec3 normal,
                        double farthest, vec3 *out)
{
    vec3 ray = view_lens_ray(lens, x, y);
    double slope = v3_dot(ray, normal);
    if (fabs(slope) < 0.02)
        return false;
    double t = v3_dot(v3_sub(p, lens->eye), normal) / slope;
    if (!(t > 0 && t < farthest))
        return false;
    *out = v3_mad(lens->eye, ray, t);
    return true;
}

bool view_lens_on_axis(const struct view_lens *lens, double x, double y, vec3 p, vec3 axis,
                       double farthest, vec3 *out)
{
    vec3 ray = view_lens_ray(lens, x, y);
    vec3 r = v3_sub(p, lens->eye);
    double b = v3_dot(ray, axis), d = 1 - b * b;
    if (d < 1e-3)
        return false;
    /* Nearest points of two lines: eye + s ray, p + t axis. */
    double t = (b * v3_dot(r, ray) - v3_dot(r, axis)) / d;
    if (!(fabs(t) < farthest))
        return false;
    *out = v3_mad(p, axis, t);
    return true;
}

void view_camera_orbit(pnb_camera *camera, double right_degrees, double up_degrees)
{
    vec3 target = v3_load(camera->target), up = v3_unit(v3_load(camera->up), v3(0, 1, 0));
    vec3 r = v3_sub(v3_load(camera->eye), target);
    double distance = v3_length(r);
    r = v3_turn(r, up, right_degrees * M_PI / 180);
    double height = asin(fmin(fmax(v3_dot(r, up) / distance, -1), 1));
    double wanted = height + up_degrees * M_PI / 180;
    wanted = fmin(fmax(wanted, -89 * M_PI / 180), 89 * M_PI / 180);
    vec3 side = v3_unit(v3_cross(r, up), v3(1, 0, 0));
    r = v3_turn(r, side, wanted - height);
    if (v3_finite(r) && v3_length(v3_cross(r, up)) > 1e-6 * distance)
        v3_store(camera->eye, v3_add(target, r));
}

void view_camera_pan(pnb_camera *camera, double dx, double dy, double height)
{
    struct view_lens lens = view_lens_make(camera, height, height);
    double metre = view_lens_pixel_size(&lens, v3_load(camera->target));
    vec3 by = v3_mad(v3_scale(lens.right, -dx * metre), lens.up, dy * metre);
    v3_store(camera->eye, v3_add(v3_load(camera->eye), by));
    v3_store(camera->target, v3_add(v3_load(camera->target), by));
}

void view_camera_zoom(pnb_camera *camera, double factor, double scale)
{
    vec3 target = v3_load(camera->target), r = v3_sub(v3_load(camera->eye), target);
    double distance = v3_length(r), wanted = distance * factor;
    wanted = fmin(fmax(wanted, 1e-3 * scale), 1e2 * scale);
    if (distance > 0 && isfinite(wanted))
        v3_store(camera->eye, v3_mad(target, r, wanted / distance));
}

void view_camera_frame(pnb_camera *camera, vec3 middle, double radius, double aspect)
{
    vec3 back = v3_unit(v3_sub(v3_load(camera->eye), v3_load(camera->target)), v3(0, 0.4, 1));
    double half = 0.5 * camera->vertical_fov_degrees * M_PI / 180;
    if (aspect < 1)
        half = atan(tan(half) * aspect);
    double distance = radius / sin(half);
    if (!isfinite(distance) || !(distance > 0))
        return;
    v3_store(camera->target, middle);
    v3_store(camera->eye, v3_mad(middle, back, distance));
}
