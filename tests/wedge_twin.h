/* wedge_twin.h: the slow and obvious twin of the methods `wedge`: every item of every part for each
 * receiver, in double precision, nothing rejected. */
#ifndef WEDGE_TWIN_H
#define WEDGE_TWIN_H

#include "method/wedge/cells.h"

struct wedge_twin {
    const struct wedge_parts *parts;
    const struct wedge_light *light;
    bool center;  /* silhouettes seen from the light's middle, else from the receiver */
    bool gravity; /* overlaps from centres of gravity, else from bounding rectangles */
    int columns, rows;
    /* Cells of no rectangle's grid: NULL, or these (then gravity, and columns and rows as there).
     */
    const struct wedge_cells *cells;
};

struct wedge_twin_answer {
    double wedge, probabilistic, blend;
};

struct wedge_twin_answer wedge_twin_at(const struct wedge_twin *twin, vec3 p_world);

#endif
