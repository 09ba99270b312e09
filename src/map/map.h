/* map/map.h: depth maps of sample points on a line, row by row in planes through that line.
 *
 * All maps of a set share one frame: the line runs along the axis, a point is (a, y, z) with a
 * measured along the line from its origin, r = |(y, z)| its distance from the line and phi its
 * angle around it. Row v of every map is the half-plane at one angle phi that the line bounds.
 * Within a row, the sample at place s on the line sees a point in the direction u = (a - s) / r,
 * and q = 1 / r plays the depth: both are linear along a flat surface.
 *
 *        line  s_i --------- s_j          r = 0
 *                  .        /
 *                    .     /              u_j = u_i + (s_i - s_j) q
 *      row               .p               (a point moves along its row from map to map)
 *
 * So the 3-D problem falls apart into one 2-D problem per row, as in Heidrich, Brabec and Seidel's
 * section 3.1, whatever the direction of the light; and as rows turn around the line and |u| may be
 * infinite, one map covers everything around a light that stands inside the scene.
 */
#ifndef MAP_MAP_H
#define MAP_MAP_H

#include "base/base.h"
#include "geom/vec.h"
#include "scene/scene.h"

/* What does not depend on the light: the scene's triangles in world space. Made once per mesh or
 * placement. */
struct map_geometry {
    pnb_context *context;
    float *positions;  /* vertex_count x 3, world */
    uint32_t *indices; /* triangle_count x 3: casters, then floors, then what casts no shadow */
    size_t vertex_count, triangle_count, caster_count, passive_first;
    /* Flat casters with all other objects on one side: they shadow nothing that lies there, so that
     * maps for a light on that side need not cover them. */
    struct map_floor *floors;
    size_t floor_count;
    vec3 low, high; /* bounds */
    double lift;    /* of receivers, metres */
};

#define MAP_FLOORS_MOST 16

struct map_floor {
    vec3 normal; /* towards the scene */
    double offset;
    size_t first_triangle, triangle_count;
};

pnb_status map_geometry_create(pnb_scene *scene, struct map_geometry **out_geometry);
void map_geometry_destroy(struct map_geometry *geometry);
/* Made anew after the scene changed; on failure the old one stays. */
pnb_status map_geometry_update(pnb_scene *scene, struct map_geometry **geometry);

/* One sample's map. Texels without a surface have q = 0. */
struct map {
    double at; /* place on the line */
    /* Column of direction u: (w(u) - low) * scale, w = map_spread(u); texel c's middle is c + 0.5.
     * Directions outside the columns meet no caster. */
    float low, scale;
    float *u;       /* columns: u of the texels' middles */
    float *q;       /* rows x columns: the nearest caster */
    float *passive; /* the same for objects that cast no shadow, or NULL if there are none */
};

/* Angles around the line at which something casts, and their rows. */
#define MAP_ARCS    32
#define MAP_SECTORS 4096
#define MAP_NO_ARC  255
struct map_arc {
    double low, range, step; /* low in [0, turn) */
    int first_row, row_count;
};

struct map_set {
    const struct map_geometry *geometry;
    pnb_context *context;
    int rows, columns;
    vec3 origin, axis, y, z; /* world */
    double length;           /* of the line */
    struct map_arc *arcs;    /* MAP_ARCS at most, by angle */
    int arc_count;
    uint8_t *sector_arc; /* MAP_SECTORS: which arc, MAP_NO_ARC: none */
    double phi_step;     /* the widest row */
    bool round;          /* rows go all the way around */
    bool wide;           /* directions are spread unevenly: map_spread() */
    bool empty;          /* nothing casts: everything is seen */
    float *row_cos, *row_sin;
    int32_t *row_above, *row_below; /* the rows beside a row; itself where there is none */
    double near_r;                  /* nothing nearer to the line counts */
    double far_q;                   /* 1 / r of the scene's farthest corner */
    struct map *maps;
    size_t count, capacity;
    bool *floor_open; /* floor_count: all of the line lies on the scene's side */
    /* For look-ups: axis, y, z as rows; open floors as normal (a, y, z) and offset. */
    float frame[9], start[3];
    float (*floors)[4];
    int open_floor_count;
    /* Scan conversion. */
    float *points;                 /* vertex_count x 3: (a, y, z) */
    int32_t *first_row, *last_row; /* triangle_count */
    uint32_t *band_start, *band_triangles;
    size_t bands;
};

struct map_set_desc {
    const struct map_geometry *geometry;
    vec3 origin, axis; /* axis: unit */
    double length;     /* samples lie at places in [0, length] */
    int rows, columns;
    bool laid_out; /* maps are drawn elsewhere: map_set_lay_out() instead of map_set_add() */
};

/* Frame, rows and bins; no maps yet. Cost: O(vertices + triangles). */
pnb_status map_set_create(const struct map_set_desc *desc, struct map_set **out_set);
void map_set_destroy(struct map_set *set);

/* A sample to make a map for, and the places of the samples whose skins will be warped into it
 * (equal to at where there are none): the columns cover what those can shadow, too. */
struct map_sample {
    double at, neighbour_low, neighbour_high;
};

/* Appends maps, all cores; O(triangles x rows they cross x maps + texels). Indices run on from
 * set->count. */
pnb_status map_set_add(struct map_set *set, const struct map_sample *samples, size_t count);
/* Appends maps without depth: q and passive are NULL. O(triangles) a map. */
pnb_status map_set_lay_out(struct map_set *set, const struct map_sample *samples, size_t count);

static inline float map_spread(const struct map_set *set, float u)
{
    if (!set->wide || (u <= 1 && u >= -1))
        return u;
    return u > 0 ? 2 - 1 / u : -2 - 1 / u;
}

/* A texel's width as an angle, rows and columns alike: at distance r it is r times as wide, and a
 * depth is as uncertain as this share of itself. */
static inline float map_texel(const struct map_set *set, const struct map *map)
{
    return fmaxf((float)set->phi_step, 1 / map->scale);
}

/* A receiver in the set's frame. */
struct map_point {
    float a, r, q;
    int row; /* -1: outside the rows, or nothing casts */
    /* Its tangent plane na a + nd r = d within the row's half-plane, at the row's middle. */
    float na, nd, d;
    /* Heights of the line's two ends above the (unlifted) tangent plane. */
    float height_low, height_high;
    float y, z;       /* lifted, like a, r, q */
    bool below_floor; /* on the far side of a floor that the maps do not cover */
};

void map_locate(const struct map_set *set, const float position[3], const float normal[3],
                struct map_point *out_point);

/* Whether a floor that the maps do not cover stands between. Only ever true beneath it. */
bool map_beneath_floor(const struct map_set *set, const struct map_point *point, double at);

/* The texel's column of a point, -1: outside. */
static inline int map_column(const struct map_set *set, const struct map *map, float u)
{
    float x = (map_spread(set, u) - map->low) * map->scale;
    return x >= 0 && x < (float)set->columns ? (int)x : -1;
}

/* The depth test. The receiver's own tangent plane tells its depth at the texel's middle, so that a
 * flat receiver needs no more bias than rounding; curved ones get bias texels. */
static inline bool map_seen(const struct map_set *set, const struct map *map,
                            const struct map_point *p, float bias)
{
    if (p->row < 0)
        return true;
    float at = (float)map->at, u = (p->a - at) * p->q;
    int column = map_column(set, map, u);
    if (column < 0)
        return true;
    float q = map->q[(size_t)p->row * (size_t)set->columns + (size_t)column];
    if (q <= 0)
        return true;
    /* Plane na (s + u r) + nd r = d: q = (na u + nd) / (d - na s). */
    float under = p->d - p->na * at, own = p->q;
    float plane = (p->na * map->u[column] + p->nd) / under;
    if (plane > 0.5f * own && plane < 2 * own)
        own = plane;
    else if (plane >= 2 * own)
        own = 2 * own;
    else if (plane > 0)
        own = 0.5f * own;
    /* A texel's width at distance r is r x its angle: in terms of q, a relative error. */
    return q <= own * (1 + bias);
}

#endif
