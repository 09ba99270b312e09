/* light/polygon.h: simple polygons in the plane. points: count x 2. */
#ifndef LIGHT_POLYGON_H
#define LIGHT_POLYGON_H

#include "base/base.h"
#include "geom/vec.h"

double polygon_area(const double *points, size_t count); /* signed */

/* False: edges first and second (from corner i to i + 1) meet where they may not. */
bool polygon_simple(const double *points, size_t count, size_t *out_first, size_t *out_second);

/* Ear clipping of a simple counter-clockwise polygon. next, previous: count entries of scratch;
 * triangles: room for (count - 2) x 3. Returns the number of triangles, all of positive area. */
size_t polygon_triangulate(const double *points, size_t count, uint32_t *next, uint32_t *previous,
                           uint32_t *triangles);

#endif
