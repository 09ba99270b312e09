/* method/line_map/line_map.h: the room's own structures. */
#ifndef METHOD_LINE_MAP_LINE_MAP_H
#define METHOD_LINE_MAP_LINE_MAP_H

#include "light/light.h"
#include "map/map.h"
#include "method/method.h"

struct line_map {
    struct map_geometry *geometry;
    int size; /* a map has size x size texels */
    int rows, columns;
    bool automatic; /* samples=auto */
    bool linear;    /* transition=linear: the paper's Gouraud shading; else its equation 1 */
    bool nearest;   /* overlap=nearest: the paper's depth buffer; else the least share */
    bool own_edges; /* edges=both */
    bool spans;     /* between=spans */
    double target;
    double threshold; /* metres; 0: LINE_MAP_STEP texels */
    double bias;      /* texels */
    /* What the last call took, for the benchmark: counters of the report. */
    double map_ms, skin_ms, look_up_ms;
    double maps, skins, texels, estimate;
};

#define LINE_MAP_SLACK 1.5f /* texels by which skins overlap what they border on */
/* Of spans, in texels; both paths use them. */
#define LINE_MAP_LIFT                                                                              \
    1.0f /* above a receiver's plane: less, and curved casters shadow themselves */
#define LINE_MAP_BESIDE     4.0f /* nearer to the light than a receiver */
#define LINE_MAP_AUTO_START 3    /* samples that samples=auto begins with */

/* line_map.c, for both paths. */
pnb_status line_map_read_params(pnb_solver *solver, struct line_map *method);
/* The linear lights that a light is taken by: itself, or its edges. */
size_t line_map_edge_count(const pnb_light *light);
/* Edge k, and its share of the light by length. */
double line_map_edge(const pnb_light *light, const struct light_shape *shape, size_t k,
                     vec3 *out_from, vec3 *out_to);
void line_map_reset_counters(struct line_map *method);
void line_map_report(pnb_solver *solver, const struct line_map *method, const pnb_light *light);

/* opengl.c: the room of path=opengl */
extern const struct opengl_method line_map_opengl;

/* Visibility channels: the share of the segment that a point seen by one of its two samples sees,
 * if a skin lies before it. */
#define LINE_MAP_SHARE_ONE 65534
#define LINE_MAP_NO_SKIN   65535

/* The piece of the light between two samples that are next to one another. */
struct line_map_segment {
    size_t left, right;               /* maps of the set */
    uint16_t *from_left, *from_right; /* rows x columns: channel of the left map and of the right */
    bool settled;                     /* samples=auto: needs no further samples */
};

/* A discontinuity between columns c and c + 1 of a row. */
struct line_map_jump {
    float u, near_q, far_q;
    bool near_left; /* the occluder lies at smaller u */
    int column;
};

/* A straight piece of a surface in a row's half-plane, between two places (a, r). */
struct line_map_piece {
    float from[2], to[2];
};

/* What one map shows, row after row. */
struct line_map_view {
    struct line_map_jump *jumps;
    struct line_map_piece *pieces;      /* between=spans */
    uint32_t *jump_start, *piece_start; /* rows + 1 */
};

/* The hidden parts of the light, disjoint. */
#define LINE_MAP_INTERVALS 64
struct line_map_cover {
    size_t count;
    float from[LINE_MAP_INTERVALS], to[LINE_MAP_INTERVALS];
};

/* One linear light with its maps and channels. */
struct line_map_light {
    struct line_map *method;
    pnb_context *context;
    struct map_set *set;
    struct line_map_segment *segments; /* in order along the line */
    size_t segment_count, segment_capacity;
    struct line_map_view *views; /* of the set's maps */
    size_t view_count, view_capacity;
};

/* skins.c: fills the channels of the segments [begin, end) from the views. Adds to method->skins
 * and texels. */
pnb_status line_map_warp(struct line_map_light *light, size_t begin, size_t end);
/* The least step that is a discontinuity: fixed as a share of q, or metres of r. */
void line_map_least_step(const struct line_map *method, const struct map_set *set,
                         const struct map *map, double *out_fixed, double *out_metres);

/* The discontinuities of a row into jumps (columns at most); returns how many. Scratch: response of
 * columns, mark of columns + 16, zero beyond them. */
size_t line_map_find_jumps(const struct line_map_light *light, const struct map *map, int row,
                           float *response, uint8_t *mark, struct line_map_jump *jumps);

/* spans.c: the views of maps that have none yet. */
pnb_status line_map_scan(struct line_map_light *light);
void line_map_forget_views(struct line_map_light *light);
/* What the surfaces that any map sees hide of the light; p->row >= 0. */
void line_map_cover(const struct line_map_light *light, const struct map_point *p,
                    struct line_map_cover *out_cover);
/* How much of [low, high] of the light is not covered. */
double line_map_uncovered(const struct line_map_cover *cover, double low, double high);

/* light.c */
pnb_status line_map_light_create(struct line_map *method, vec3 from, vec3 to, size_t samples,
                                 struct line_map_light **out_light);
void line_map_light_destroy(struct line_map_light *light);
/* Puts a sample in the middle of each segment that is not settled. */
pnb_status line_map_light_split(struct line_map_light *light);
/* The share of the light that the receiver sees. shares: the same for each segment, or NULL. */
double line_map_look_up(const struct line_map_light *light, const float position[3],
                        const float normal[3], float *shares);
/* Plain shadow mapping with the same maps, for the benchmark: the share of samples that see the
 * receiver. */
double line_map_look_up_plain(const struct line_map_light *light, const float position[3],
                              const float normal[3]);

/* auto.c: adds samples until splitting once more changes the visibility of the receivers by less
 * than the target (root mean square over the penumbra). */
pnb_status line_map_refine(struct line_map_light *light, const pnb_receivers *receivers,
                           size_t most_samples, double *out_estimate);

#endif
