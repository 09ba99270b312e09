/* silhouette/disk.h: which faces a disk sees, and the planes through an edge that touch its rim.
 *
 * Light space: origin in the disk's centre c, z along its normal n_c (the lit side), so the disk is
 * x^2 + y^2 <= r^2, z = 0, and z is the height of the paper's dot products with n_c. */
#ifndef SILHOUETTE_DISK_H
#define SILHOUETTE_DISK_H

#include "geom/vec.h"

struct silhouette_disk {
    vec3 center, u, v, normal; /* world; u x v = normal */
    double radius;
};
void silhouette_disk_init(struct silhouette_disk *disk, vec3 center, vec3 normal, double radius);
vec3 silhouette_disk_from_world(const struct silhouette_disk *disk, vec3 p_world);
vec3 silhouette_disk_to_world(const struct silhouette_disk *disk, vec3 p_light);

/* What a face sees of the disk: its plane is n.p + d = 0 in world space with |n| = 1, outside where
 * it is positive. The highest and lowest points over it are those of the rim,
 *
 *   p_near = c + r m, p_far = c - r m, m = normalised(n - (n.n_c) n_c)
 *
 * (Eq. 1, which is printed with the other sign and not normalised), at heights
 * n.c + d +- r |n - (n.n_c) n_c|. A face without area (n = 0) sees nothing. */
enum silhouette_facing {
    SILHOUETTE_NONE_FRONTFACING = 0, /* p_near is not above it */
    SILHOUETTE_FACE,                 /* neither: a silhouette face */
    SILHOUETTE_ALL_FRONTFACING       /* p_far is above it */
};
enum silhouette_facing silhouette_disk_facing(const struct silhouette_disk *disk,
                                              const float plane[4]);

/* The two rim points (x, y in light space) whose planes through the line ab are tangent to the
 * rim. Seen from [0] the disk's centre lies to the left of a to b, from [1] to the right, where
 * left of a line, seen from p, are the points x with det[a - p, b - p, x - p] < 0: a face that is
 * seen from the front has its third corner to the left of each of its edges.
 *
 * With heights a.z, b.z, N = a.xy b.z - b.xy a.z and w = b.z - a.z, the line meets the light's
 * plane in N / w, and the tangent points are (r^2 w N -+ r sqrt(N.N - r^2 w^2) N_perp) / N.N:
 * finite for an edge parallel to the light (w = 0), which so is no special case. False, and nothing
 * written, where the line meets the disk or its centre. */
bool silhouette_disk_tangents(double radius, vec3 a_light, vec3 b_light, double out_points[2][2]);

#endif
