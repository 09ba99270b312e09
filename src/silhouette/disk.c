/* silhouette/disk.c: facing by the nearest and farthest rim point, tangent planes through an edge.
 * Constant time each. */
#include "silhouette/disk.h"

void silhouette_disk_init(struct silhouette_disk *disk, vec3 center, vec3 normal, double radius)
{
    disk->center = center;
    disk->normal = v3_normalize(normal);
    disk->radius = radius;
    v3_frame(disk->normal, &disk->u, &disk->v);
}

vec3 silhouette_disk_from_world(const struct silhouette_disk *disk, vec3 p_world)
{
    vec3 d = v3_sub(p_world, disk->center);
    return v3(v3_dot(d, disk->u), v3_dot(d, disk->v), v3_dot(d, disk->normal));
}

vec3 silhouette_disk_to_world(const struct silhouette_disk *disk, vec3 p_light)
{
    return v3_mad(v3_mad(v3_mad(disk->center, disk->u, p_light.x), disk->v, p_light.y),
                  disk->normal, p_light.z);
}

enum silhouette_facing silhouette_disk_facing(const struct silhouette_disk *disk,
                                              const float plane[4])
{
    vec3 n = v3_loadf(plane);
    double height = v3_dot(n, disk->center) + plane[3];
    vec3 along = v3_mad(n, disk->normal, -v3_dot(n, disk->normal));
    double reach = disk->radius * v3_length(along);
    if (height + reach <= 0)
        return SILHOUETTE_NONE_FRONTFACING;
    return height - reach > 0 ? SILHOUETTE_ALL_FRONTFACING : SILHOUETTE_FACE;
}

bool silhouette_disk_tangents(double radius, vec3 a, vec3 b, double out_points[2][2])
{
    double w = b.z - a.z, nx = a.x * b.z - b.x * a.z, ny = a.y * b.z - b.y * a.z;
    double nn = nx * nx + ny * ny, inside = nn - radius * radius * w * w;
    if (!(inside > 0) || !isfinite(nn))
        return false;
    double k = radius * radius * w / nn, l = radius * sqrt(inside) / nn;
    /* det[a - p, b - p, c - p] = -p.(a x b) = s N.N with p = k N + s N_perp, N_perp = (-ny, nx):
     * negative on the left. */
    for (int i = 0; i < 2; i++) {
        double s = i == 0 ? -l : l;
        out_points[i][0] = k * nx - s * ny;
        out_points[i][1] = k * ny + s * nx;
    }
    return true;
}
