/* method/planar/shadow.h: the inside of a pnb_shadow, for its writers. */
#ifndef METHOD_PLANAR_SHADOW_H
#define METHOD_PLANAR_SHADOW_H

#include <penumbra/image.h>
#include <penumbra/shadow.h>

#include "base/buffer.h"
#include "method/planar/room.h"

/* What belongs to one receiver plane. edges, points: the rings, none after refinement. */
struct shadow_sheet {
    struct silhouette_plane frame;
    double lo[2], hi[2];
    struct planar_edge *edges;
    size_t edge_count;
    struct planar_point *points;
    size_t point_count;
    double origin[2], scale; /* plane space = origin + points / scale */
};

struct pnb_shadow {
    pnb_context *context;
    pnb_solver *solver;
    pnb_shadow_view view;
    struct shadow_sheet *sheets;
    uint32_t *planes, *first_triangles, *indices;
    float *positions, *coordinates, *intensities;
    size_t position_capacity, coordinate_capacity, intensity_capacity, index_capacity;
    double lift; /* the default, metres */
};

/* Each adds a whole file to the buffer. */
pnb_status shadow_write_obj(const struct pnb_shadow *s, double lift, struct buffer *file);
pnb_status shadow_write_ply(const struct pnb_shadow *s, double lift, struct buffer *file);
pnb_status shadow_write_glb(const struct pnb_shadow *s, double lift, struct buffer *file);
pnb_status shadow_write_svg(const struct pnb_shadow *s, double lift, struct buffer *file);
pnb_status shadow_write_pdf(const struct pnb_shadow *s, double lift, struct buffer *file);
pnb_status shadow_write_geojson(const struct pnb_shadow *s, double lift, struct buffer *file);

#endif
