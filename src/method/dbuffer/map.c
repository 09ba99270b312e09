/* method/dbuffer/map.c: fits the D-buffer around what can lie in a penumbra.
 *
 * A point v of an occluder darkens x = v + k (v - p), k >= 0, for points p of the disk. p has no
 * height, so the farthest x that matters, at the scene's far end, has k = far / height(v) - 1. All
 * x of an occluder lie in the hull of its vertices and of those x, for p on an octagon around the
 * disk. The face is turned about its axis for the smallest rectangle around the vertices. An
 * occluder that comes down to the light's plane can darken any direction: then the faces of a cube,
 * the size of all that the centre can see. O(vertices). */
#include "method/dbuffer/map.h"

/* One face spans at most this angle to each side of its axis. */
#define FIT_COSINE 0.342 /* 70 degrees */
/* Boxes that come nearer to the light's plane than this share of the scene's depth are too near. */
#define NEAR_SHARE 0.02
/* Of a face's side, where nobody says: the more where the light's radius, seen from the middle of
 * the occluders, would span fewer texels than this. */
#define SIZE_LEAST   512
#define SIZE_MOST    1024
#define RADIUS_SPANS 32
/* Ways to turn a face that are tried. */
#define TURNS 8

bool dbuffer_casts(const struct gl_occluder *object, const struct silhouette_disk *disk)
{
    if (!object->floor)
        return true;
    double side = v3_dot(object->floor_normal, disk->center) - object->floor_offset;
    double along = v3_dot(object->floor_normal, disk->normal);
    return !(side - disk->radius * sqrt(fmax(0, 1 - along * along)) > 0);
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

/* The vertices of an object's triangles: they stand together (gl/occluders.c). */
static void vertex_range(const struct gl_occluders *o, size_t object, size_t *first, size_t *end)
{
    const struct gl_occluder *of = &o->objects[object];
    *first = SIZE_MAX;
    *end = 0;
    for (size_t i = of->first_index; i < of->first_index + of->index_count; i++) {
        *first = o->indices[i] < *first ? o->indices[i] : *first;
        *end = o->indices[i] >= *end ? o->indices[i] + (size_t)1 : *end;
    }
}

static vec3 vertex(const struct gl_occluders *o, const struct silhouette_disk *disk, size_t i)
{
    return silhouette_disk_from_world(disk, v3_loadf(o->positions + 3 * i));
}

/* Around the vertices alone. */
static bool around_vertices(const struct gl_occluders *o, const struct silhouette_disk *disk,
                            const vec3 axes[3], struct bounds *bounds)
{
    *bounds = (struct bounds){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0, first, end; i < o->object_count; i++)
        if (dbuffer_casts(&o->objects[i], disk)) {
            vertex_range(o, i, &first, &end);
            for (size_t k = first; k < end; k++)
                if (!include(bounds, axes, vertex(o, disk, k)))
                    return false;
        }
    return true;
}

static void turn(vec3 axes[3], double angle)
{
    vec3 x = axes[0], y = axes[1];
    axes[0] = v3_mad(v3_scale(x, cos(angle)), y, sin(angle));
    axes[1] = v3_mad(v3_scale(y, cos(angle)), x, -sin(angle));
}

static bool fit(const struct gl_occluders *o, const struct silhouette_disk *disk, double far_z,
                int size, struct dbuffer_map *map)
{
    vec3 low = v3(INFINITY, INFINITY, INFINITY), high = v3_scale(low, -1);
    for (size_t i = 0, first, end; i < o->object_count; i++)
        if (dbuffer_casts(&o->objects[i], disk)) {
            vertex_range(o, i, &first, &end);
            for (size_t k = first; k < end; k++) {
                vec3 v = vertex(o, disk, k);
                low = v3_min(low, v);
                high = v3_max(high, v);
            }
        }
    if (!(low.z > NEAR_SHARE * fmax(far_z, high.z)))
        return false;
    vec3 *axes = map->axes[0];
    axes[2] = v3_normalize(v3_scale(v3_add(low, high), 0.5));
    v3_frame(axes[2], &axes[0], &axes[1]);
    struct bounds bounds;
    double best = INFINITY;
    int turns = 0;
    for (int i = 0; i < TURNS; i++, turn(axes, M_PI / 2 / TURNS)) {
        if (!around_vertices(o, disk, axes, &bounds))
            return false;
        double area = (bounds.most[0] - bounds.least[0]) * (bounds.most[1] - bounds.least[1]);
        if (area < 0.999 * best) {
            best = area;
            turns = i;
        }
    }
    v3_frame(axes[2], &axes[0], &axes[1]);
    turn(axes, turns * M_PI / 2 / TURNS);
    bounds = (struct bounds){{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0, first, end; i < o->object_count; i++) {
        if (!dbuffer_casts(&o->objects[i], disk))
            continue;
        vertex_range(o, i, &first, &end);
        for (size_t k = first; k < end; k++) {
            vec3 v = vertex(o, disk, k);
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
    }
    map->face_count = 1;
    double widest = 0.5 * fmax(bounds.most[0] - bounds.least[0], bounds.most[1] - bounds.least[1]);
    double away = 0.5 * v3_length(v3_add(low, high));
    if (size == 0)
        size =
            disk->radius / away * SIZE_LEAST < RADIUS_SPANS * 2 * widest ? SIZE_MOST : SIZE_LEAST;
    map->size = size;
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
    map->size = size ? size : SIZE_LEAST;
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
