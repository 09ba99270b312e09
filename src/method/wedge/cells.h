/* method/wedge/cells.h: a light cut into the cells over which hidden areas are summed. */
#ifndef WEDGE_CELLS_H
#define WEDGE_CELLS_H

#include "method/wedge/wedge.h"

#define WEDGE_ROWS_MAX    40
#define WEDGE_COLUMNS_MAX 4
#define WEDGE_BINS_MAX    4

/* Between two heights, and within each column between two lines, given by where they cross these
 * heights. Columns may be empty. */
struct wedge_row {
    double low, high;
    int bin;
    double left[2][WEDGE_COLUMNS_MAX], right[2][WEDGE_COLUMNS_MAX]; /* [at low, at high] */
};

/* What a bin's rows have in one column. */
struct wedge_cell {
    double x0, x1, y0, y1; /* its bounds; all 0 where it is empty */
    double area;
};

struct wedge_cells {
    int columns, bins, row_count; /* rows from low to high, bins too */
    struct wedge_row rows[WEDGE_ROWS_MAX];
    struct wedge_cell cells[WEDGE_BINS_MAX][WEDGE_COLUMNS_MAX];
    double area; /* of all, light space */
};

/* parts: 1; 4: quarters; 8: the radial parts between the axes and the diagonals; 16: a grid. */
void wedge_cells_init(const struct wedge_light *light, int parts, struct wedge_cells *cells);

#endif
