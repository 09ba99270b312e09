/* map/raster.h: what the two halves of the map folder share. */
#ifndef MAP_RASTER_H
#define MAP_RASTER_H

#include "map/map.h"

#define MAP_BAND 16 /* rows that one worker fills at a time */

/* The directions that a sample's map must cover: the casters', and where its neighbours' skins end
 * up. low > high: none. */
void map_directions(const struct map_set *set, const struct map_sample *sample, double *out_low,
                    double *out_high);

#endif
