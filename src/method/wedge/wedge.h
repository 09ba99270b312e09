/* method/wedge/wedge.h: inside the room of penumbra wedges: parts and their items. */
#ifndef WEDGE_WEDGE_H
#define WEDGE_WEDGE_H

#include "gl/frame.h"
#include "light/light.h"

/* Items stand in groups of this many: one word of a mask. */
#define WEDGE_GROUP 32

/* What a group's items belong to. Parts follow one another within a group and from group to group;
 * items of no kind (padding) only stand behind the last one. */
enum wedge_group_kind { WEDGE_GROUP_EDGES = 0, WEDGE_GROUP_FACES, WEDGE_GROUP_MIXED };
struct wedge_group {
    uint32_t part;   /* of the first item */
    uint32_t starts; /* a bit for each item with which the next part begins */
    uint32_t faces;  /* a bit for each item that is a face */
    uint32_t kind;   /* enum wedge_group_kind */
};

/* A connected part of an occluder: what casts one silhouette (which may be several loops). */
struct wedge_part {
    size_t first_item, first_face_item; /* into wedge_parts.items: edges, then faces */
    size_t item_count;                  /* from first_item, with padding */
    size_t first_face, face_count;      /* into wedge_parts.faces */
    size_t first_edge, edge_count;      /* into wedge_parts.edges */
    bool closed;                        /* every edge has two faces of opposite direction */
    bool cut; /* reaches through the light's plane: its faces stand among its edge items too */
    vec3 low, high; /* world */
};

/* An edge, or a face that may be cut, as the device is given it. Vertices stand in the order of
 * their numbers, so that every item cuts a shared edge at the same floats. Unused slots are zero.
 */
enum wedge_item_kind {
    WEDGE_ITEM_NONE = 0,
    WEDGE_ITEM_EDGE,
    WEDGE_ITEM_CUT, /* a face, for the line in which the light's plane cuts it */
    WEDGE_ITEM_FACE /* for the line at a receiver's own level */
};
struct wedge_item {
    float a[3], kind;
    float b[3], sign; /* edge: 1 if the first face runs from a to b, else -1; face: 1 if a, b, c run
                         counter-clockwise, else -1 */
    float c[3], k;    /* k: what a face counts for: 0.5 in closed parts, 1 in others */
    float first[4], second[4]; /* planes of the faces; second is zero where there is none */
};

struct wedge_parts {
    pnb_context *context;
    const struct gl_occluders *occluders;
    struct wedge_part *parts;
    size_t part_count;
    uint32_t *faces, *edges;  /* numbers in the occluders, part by part, near ones together */
    struct wedge_item *items; /* group_count x WEDGE_GROUP */
    struct wedge_group *groups;
    size_t group_count;
    bool packed;       /* items and groups are those of the parts as they are cut now */
    size_t open_count; /* edges of parts that are not closed, planes of the scene left out */
};

/* Connected parts by shared vertices, and their items; nothing is cut by the light's plane yet.
 * O(n log n) once per mesh. */
pnb_status wedge_parts_create(pnb_scene *scene, const struct gl_occluders *occluders,
                              struct wedge_parts **out_parts);
void wedge_parts_destroy(struct wedge_parts *parts);

#define WEDGE_CORNERS_MAX 24

/* A convex light. Light space: x and y in half_u and half_v from its middle, z metres along its
 * normal; the light lies within [-1,1]^2. */
struct wedge_light {
    vec3 center, half_u, half_v, normal;
    vec3 x_axis, y_axis; /* x = x_axis . (p - center) */
    double gap;          /* occluders nearer to the light's plane than this do not count, metres */
    bool rectangle;      /* fills [-1,1]^2 */
    int corner_count;    /* light space, counter-clockwise */
    double corners[WEDGE_CORNERS_MAX][2];
    double share; /* of the area of the whole, of which this is a piece */
};
/* The convex pieces of a light. lights: the caller's to free with memory_free(). */
pnb_status wedge_lights_create(pnb_context *context, const struct light_shape *shape,
                               const struct gl_occluders *occluders,
                               struct wedge_light **out_lights, size_t *out_count);
vec3 wedge_light_from_world(const struct wedge_light *light, vec3 p);

/* Marks the parts that reach through the light's plane, and packs the items anew where that changed
 * (out_changed). */
pnb_status wedge_parts_cut(struct wedge_parts *parts, const struct wedge_light *light,
                           bool *out_changed);

#endif
