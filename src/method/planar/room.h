/* method/planar/room.h: what the files of this room share. */
#ifndef METHOD_PLANAR_ROOM_H
#define METHOD_PLANAR_ROOM_H

#include "light/light.h"
#include "method/method.h"
#include "planar/planar.h"
#include "silhouette/point.h"

#define SHADOW_SAMPLES_MAX  1024
#define SHADOW_SAMPLES_MANY 128   /* above: slow, a warning */
#define SHADOW_FINE         0.008 /* tolerances below: 4,096 light samples instead of 1,024 */

enum shadow_placement { SHADOW_OPTIMISED = 0, SHADOW_BORDER, SHADOW_RANDOM };
/* What becomes of leaks, see build.c. */
enum shadow_mend { SHADOW_MEND_EVEN = 0, SHADOW_MEND_TRIANGLES, SHADOW_MEND_NOT };
enum shadow_intensity { SHADOW_RING = 0, SHADOW_EXACT };

/* The method's parameters, read once. */
struct shadow_settings {
    int samples;
    enum shadow_placement placement;
    enum shadow_intensity intensity;
    enum planar_rule fill;
    enum shadow_mend mend;
    double join;      /* metres; 0: the grid's own unit */
    double reconnect; /* share of the edges at a crossing of rings that gives way; 0: none */
    double tolerance; /* 0: rings */
    bool keep;        /* go on from the last frame's mesh */
    bool rings_only;  /* no triangles: for measurements */
    double simplify;  /* metres that coarser occluders may be off, see mesh/simplify.h; 0: none */
};

/* A receiver plane with the occluders above it. */
struct shadow_plane {
    size_t object;
    struct silhouette_plane frame; /* the light is on the side that n points to */
    double lo[2], hi[2];           /* of the receiver, plane space */
    double center[2], scale;       /* grid = (p - center) x scale */
    struct silhouette_occluder *occluders;
    size_t occluder_count;
    size_t open_edges, non_manifold_edges, open_meshes; /* of the occluders */
    struct tiling *kept; /* the mesh of the last frame, where meshes are kept; refine.c's */
};

/* Triangles of the shadow: a value per corner, 0 lit to 1 umbra; linear in between. Corners of one
 * point differ only where the shadow itself jumps (an occluder that touches the plane). */
struct shadow_triangle {
    uint32_t v[3];
    float value[3];
    int32_t level; /* how many outlines cover it; -1: made by refinement */
};

/* The shadow of one light (or one convex piece of it) on one plane. Points in plane space. */
struct shadow_part {
    double *points; /* x, y */
    size_t point_count, point_capacity;
    struct shadow_triangle *triangles;
    size_t triangle_count, triangle_capacity;
    struct planar_edge *edges; /* of the rings; none after refinement */
    size_t edge_count, edge_capacity;
    int rings;
    double weight;           /* share of the light's area */
    double origin[2], scale; /* points = origin + integers / scale */
};

struct shadow_times {
    double silhouettes_ms, outlines_ms, rings_ms, fill_ms, values_ms;
    size_t silhouette_edges, outline_edges, ring_edges, crossings, exchanges, careful, evaluations;
    bool unfinished; /* refinement ended at its limit of triangles */
};

struct shadow_builder {
    pnb_context *context;
    pnb_scene *scene;
    struct planar_workspace *workspace, *spare;
    struct silhouette_outline outlines[SILHOUETTE_SAMPLES_MAX];
    struct planar_input outline, levels, parted;
    struct planar_chains chains;
    int32_t *ring_lo, *ring_hi;
    uint8_t *leak, *jump;
    float *value;
    uint32_t *slot;
    size_t scratch;    /* points that the six arrays above have room for */
    pnb_solver *truth; /* of intensity=exact and of tolerance; made when first needed */
    const char *truth_method;
    int truth_samples; /* on the light; 0: 1,024 */
    struct shadow_times times;
};
pnb_status shadow_builder_init(pnb_context *context, pnb_scene *scene,
                               struct shadow_builder *builder);
void shadow_builder_finish(struct shadow_builder *builder);
/* The scene has changed: what the truth keeps of it is stale. */
pnb_status shadow_builder_update(struct shadow_builder *builder, pnb_update update);

/* object: flat, or with a flat face that looks towards the light and has nothing of it above, else
 * PNB_ERROR_UNSUPPORTED. meshes: what the occluders are taken from, as many as the scene's, or
 * NULL: the scene's. towards: a world point (the light's middle) on the side that is to be lit.
 */
pnb_status shadow_plane_init(pnb_context *context, pnb_scene *scene, struct mesh *meshes,
                             size_t object, vec3 towards, struct shadow_plane *plane);
void shadow_plane_finish(pnb_context *context, struct shadow_plane *plane);
/* coarse.c: coarser meshes of the scene's occluders; none: the scene's are to be taken. */
struct shadow_coarse {
    struct mesh *meshes;
    size_t mesh_count, triangles_before, triangles_after;
    unsigned long version; /* of the scene's geometry that they were made from */
};
/* Makes them if the settings ask for it and they are not there. */
pnb_status shadow_coarse_update(pnb_context *context, pnb_scene *scene,
                                const struct shadow_settings *settings,
                                struct shadow_coarse *coarse);
void shadow_coarse_finish(pnb_context *context, struct shadow_coarse *coarse);

/* The object named by receiver=, or the largest plane ("" or NULL). */
pnb_status shadow_find_receiver(pnb_context *context, const pnb_scene *scene, const char *name,
                                vec3 towards, size_t *out_object);
/* The receivers of "all": planes, and slabs with a face that looks towards the light. The first
 * from *io_object on; false: none. */
bool shadow_next_receiver(const pnb_scene *scene, vec3 towards, size_t *io_object);

/* lights.c: convex pieces of a light, and their samples in plane space. */
struct shadow_cluster {
    int shape;         /* 0 parallelogram, 1 disk, 2 triangle, 3 convex polygon, 4 line, 5 point */
    vec3 origin, u, v; /* world; shape's plane coordinates as in sample_tables.h */
    const double *corners; /* of a polygon: 3 doubles each */
    size_t corner_count;
    bool directions; /* the sun: origin, u, v are directions */
    double weight;
};
/* The caller frees *out_clusters by memory_free(). */
pnb_status shadow_clusters(pnb_context *context, const struct light_shape *shape,
                           struct shadow_cluster **out_clusters, size_t *out_count);
/* count samples of a cluster, world; the sun's lie `far` away from `around`. */
void shadow_samples(const struct shadow_cluster *cluster, enum shadow_placement placement,
                    int count, vec3 around, double far, vec3 *out_samples);
int shadow_sample_count(const struct shadow_cluster *cluster, int wanted); /* 1 for points */
/* The corners of a cluster, world; of a round one some points of its rim. At most `most`. */
int shadow_corners(const struct shadow_cluster *cluster, vec3 around, double far, int most,
                   vec3 *out_corners);
vec3 shadow_light_middle(const struct light_shape *shape, vec3 around, double far);

/* build.c: rings and their fill. */
pnb_status shadow_build(struct shadow_builder *builder, struct shadow_plane *plane,
                        const struct light_shape *shape, const struct shadow_cluster *cluster,
                        const struct shadow_settings *settings, struct shadow_part *part);
/* The hard outlines of the shadows of single points (plane space), into builder->levels. */
pnb_status shadow_outlines(struct shadow_builder *builder, struct shadow_plane *plane,
                           const struct light_shape *shape, const vec3 *samples, size_t count);
void shadow_part_finish(pnb_context *context, struct shadow_part *part);
/* Visibility of the light at points of the plane (x, y in plane space), by the best method there
 * is.
 */
pnb_status shadow_truth(struct shadow_builder *builder, const struct shadow_plane *plane,
                        const pnb_light *light, const double *points, size_t count,
                        float *visibility);

/* refine.c: a mesh within settings->tolerance of the truth. */
pnb_status shadow_refine(struct shadow_builder *builder, struct shadow_plane *plane,
                         const pnb_light *light, const struct shadow_settings *settings,
                         struct shadow_part *part);

void shadow_forget_kept(pnb_context *context, struct shadow_plane *plane);

/* locate.c: which triangle holds a point. */
struct shadow_locator {
    const struct shadow_part *part;
    double x0, y0, per_x, per_y;
    int columns, rows;
    uint32_t *starts, *items;
};
pnb_status shadow_locator_init(pnb_context *context, const struct shadow_part *part,
                               struct shadow_locator *locator);
void shadow_locator_finish(pnb_context *context, struct shadow_locator *locator);
/* The shadow at a point, 0 where there is no triangle. hint: the triangle found last, or
 * PLANAR_NONE. */
double shadow_at(const struct shadow_locator *locator, double x, double y, uint32_t *io_hint);

/* merge.c: the sum of the parts, each times its weight, as one mesh without rings. The parts share
 * a grid. */
pnb_status shadow_merge(struct shadow_builder *builder, const struct shadow_part *parts,
                        size_t count, struct shadow_part *out);

/* The solver's state. */
struct planar_state {
    struct shadow_builder builder;
    struct shadow_settings settings;
    struct shadow_plane *planes;
    size_t plane_count;
    struct shadow_part part; /* of the last visit */
    struct shadow_coarse coarse;
};

/* Makes the shadow on every plane, part by part; visit is called with each (first: the first part
 * of a plane; lights that are not convex have several, whose weights add up to 1). */
typedef pnb_status shadow_visitor(void *user, const struct shadow_plane *plane,
                                  struct shadow_part *part, bool first);
pnb_status shadow_visit(pnb_solver *solver, const pnb_light *light, shadow_visitor *visit,
                        void *user);
void shadow_settings_read(const pnb_solver *solver, struct shadow_settings *settings);

#endif
