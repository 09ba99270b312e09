/* method/dbuffer/map.c: fits the D-buffer around what can lie in a penumbra.
 *
 * A point v of an occluder darkens x = v + k (v - p), k >= 0, for points p of the disk. p has no
 * height, so the farthest x that matters, at the scene's far end, has k = far / height(v) - 1. All
 * x of a box of occluders lie in the hull of its corners and of those x, for p on an octagon around
 * the disk. A box that comes down to the light's plane can darken any direction: then the faces of
 * a cube, the size of all that the centre can see. */
#include "method/dbuffer/map.h"

/* One face spans at most this angle to each side of its axis. */
#define FIT_COSINE 0.342 /* 70 degrees */
/* Boxes that come nearer to the light's plane than this share of the scene's depth are too near. */
#define NEAR_SHARE 0.02

bool dbuffer_casts(const struct gl_occluder *object, const struct silhouette_disk *disk)
{
    if (!object->floor)
        return true;
    double side = v3_dot(object->floor_normal, disk->center) - object->floor_offset;
    double along = v3_dot(object->floor_normal, disk->normal);
    return !(side - disk->radius * sqrt(fmax(0, 1 - along * along)) > 0);
}

static vec3 corner(vec3 low, vec3 high, int i)
{
    return v3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
}

struct bounds {
    double least[2], most[2];
};

/* False where the point is too far off the face's axis. */
static bool include(struct bounds *bounds, const vec3 axes[3], vec3 x)
{
    double along = v3_dot(x, axes[2]);
    if (!(along > FIT_COSINE * v3_length(x)))
        return false;
    for (int c = 0; c < 2; c++) {
        double slope = v3_dot(x, axes[c]) / along;
        bounds->least[c] = fmin(bounds->least[c], slope);
        bounds->most[c] = fmax(bounds->most[c], slope);
    }
    return true;
}

static bool fit(const struct gl_occluders *o, const struct silhouette_disk *disk, double far_z,
                int size, struct dbuffer_map *map)
{
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_scale(low, -1);
    for (size_t i = 0; i < o->object_count; i++)
        for (int k = 0; k < 8 && dbuffer_casts(&o->objects[i], disk); k++) {
            vec3 v =
                silhouette_disk_from_world(disk, corner(o->objects[i].low, o->objects[i].high, k));
            low = v3_min(low, v);
            high = v3_max(high, v);
        }
    if (!(low.z > NEAR_SHARE * fmax(far_z, high.z)))
        return false;
    vec3 *axes = map->axes[0];
    axes[2] = v3_normalize(v3_scale(v3_add(low, high), 0.5));
    v3_frame(axes[2], &axes[0], &axes[1]);
    struct bounds bounds = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0; i < o->object_count; i++)
        for (int k = 0; k < 8 && dbuffer_casts(&o->objects[i], disk); k++) {
            vec3 v =
                silhouette_disk_from_world(disk, corner(o->objects[i].low, o->objects[i].high, k));
            /* far_z unknown: directions at infinity. */
            double reach = far_z > 0 ? fmax(0, far_z / v.z - 1) : 1e6;
            double out = disk->radius / cos(M_PI / 8);
            if (!include(&bounds, axes, v))
                return false;
            for (int j = 0; j < 8; j++) {
                double angle = (j + 0.5) * M_PI / 4;
                vec3 p = v3(out * cos(angle), out * sin(angle), 0);
                if (!include(&bounds, axes, v3_mad(v, v3_sub(v, p), reach)))
                    return false;
            }
        }
    map->face_count = 1;
    for (int c = 0; c < 2; c++) {
        /* A texel's room on each side, and never nothing: an occluder may be seen edge-on. */
        double reach = 0.5 * (bounds.most[c] - bounds.least[c]);
        map->reach[c] = fmax(reach * size / fmax(size - 2, 1), 1e-6);
        map->shift[c] = 0.5 * (bounds.most[c] + bounds.least[c]);
    }
    return true;
}

void dbuffer_map_fit(const struct gl_occluders *o, const struct silhouette_disk *disk, double far_z,
                     int size, struct dbuffer_map *map)
{
    bool any = false;
    for (size_t i = 0; i < o->object_count; i++)
        any = any || dbuffer_casts(&o->objects[i], disk);
    map->face_count = 0;
    if (!any || fit(o, disk, far_z, size, map))
        return;
    static const vec3 faces[DBUFFER_FACES] = {
        {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    map->face_count = DBUFFER_FACES;
    for (int i = 0; i < DBUFFER_FACES; i++) {
        map->axes[i][2] = faces[i];
        v3_frame(faces[i], &map->axes[i][0], &map->axes[i][1]);
    }
    map->shift[0] = map->shift[1] = 0;
    map->reach[0] = map->reach[1] = 1;
}

void dbuffer_map_matrix(const struct dbuffer_map *map, int face, const struct silhouette_disk *disk,
                        bool from_world, double m[16])
{
    const vec3 *axes = map->axes[face];
    vec3 rows[4];
    for (int c = 0; c < 2; c++)
        rows[c] = v3_scale(v3_mad(axes[c], axes[2], -map->shift[c]), 1 / map->reach[c]);
    rows[2] = v3(0, 0, 0);
    rows[3] = axes[2];
    for (int r = 0; r < 4; r++) {
        vec3 row = rows[r];
        if (from_world)
            row = v3_mad(v3_mad(v3_scale(disk->u, row.x), disk->v, row.y), disk->normal, row.z);
        m[r] = row.x;
        m[4 + r] = row.y;
        m[8 + r] = row.z;
        m[12 + r] = 0;
    }
}
