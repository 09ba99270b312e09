/* wedge_random.h: random scenes for the methods `wedge`, judged against `exact`. */
#ifndef WEDGE_RANDOM_H
#define WEDGE_RANDOM_H

#include <penumbra/penumbra.h>

struct wedge_random_result {
    const char *what; /* NULL, or what is wrong */
    double rmse[3];   /* wedge, wedge-probabilistic, wedge-blend, over all receivers */
    int streak;       /* longest run of grossly wrong pixels in a row or column, of wedge-blend */
    size_t gross, pixels; /* of wedge-blend: wrong by more than 0.5 */
};

/* Boxes, spheres and open or tangled meshes over a ground, some through the light's plane or around
 * the light. */
pnb_status wedge_random_run(pnb_context *context, uint64_t seed,
                            struct wedge_random_result *result);

#endif
