/* method/wedge/tables.h: what the device holds: items, groups, parts, tiles, and who matters to
 * whom. */
#ifndef WEDGE_TABLES_H
#define WEDGE_TABLES_H

#include "method/wedge/wedge.h"

/* One table that a pass draws: its textures, drawn together. */
struct wedge_table {
    struct gl_texture *textures[4];
    int count;
    struct gl_target *target;
};

struct wedge_programs {
    struct gl_program *setup, *groups, *tiles, *coarse, *part_mask, *hits, *prefix, *list, *mask,
        *wedge;
};

/* How a fragment finds silhouettes, each in fewer turns of a loop than the one before: an edge a
 * turn, four a turn, those from the light's middle. */
enum wedge_search { WEDGE_SEARCH_QUICK = 0, WEDGE_SEARCH_FOUR, WEDGE_SEARCH_CENTER };

struct wedge_room {
    struct gl_device *device;
    struct wedge_parts *parts;
    struct wedge_programs programs;
    bool uploaded;                 /* what follows from the parts is there, all of it */
    struct gl_texture *in[5];      /* items as given: a, b, c, first, second of struct wedge_item */
    struct gl_texture *group_info; /* struct wedge_group of each group */
    struct gl_texture *part_box[2]; /* low, high; light space */
    float *box_texels[2];
    struct wedge_table items, group_box; /* light space */
    struct wedge_table tile_box, coarse_box;
    struct wedge_table part_mask, hits, prefix, list; /* of the coarse tiles */
    struct wedge_table mask;                          /* of the tiles */
    int tile_wanted, tile_size, tile_columns, tile_rows;
    int coarse, coarse_columns, coarse_rows; /* a coarse tile is coarse x coarse tiles */
    int words;                               /* of 32 groups */
    int list_width, list_rows;               /* a coarse tile's list, folded */
    int mask_width;                          /* places of a list that have a mask */
    int width, height;                       /* of the frame that the tiles are for */
    int line_rows;   /* that the programs are made for: rows of cells between lines; 0: a grid */
    double setup_ms; /* on the CPU, of the last frame */
    enum wedge_search search; /* that the programs are made for */
};

/* The parts' items, and what depends on their number. */
pnb_status wedge_tables_upload(struct wedge_room *room);
/* Boxes of the parts in light space. */
void wedge_tables_place(struct wedge_room *room, const struct wedge_light *light);
/* Tiles and their lists for a frame; nothing to do when its size is the last one's. */
pnb_status wedge_tables_resize(struct wedge_room *room, int width, int height);
void wedge_tables_finish(struct wedge_room *room);
/* Of lists and masks, and of all that follows from the meshes. */
void wedge_tables_bytes(const struct wedge_room *room, size_t *out_lists, size_t *out_items);

#endif
