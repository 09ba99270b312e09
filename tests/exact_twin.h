/* exact_twin.h: random scenes for the method `exact`, and its slow and obvious twin. */
#ifndef EXACT_TWIN_H
#define EXACT_TWIN_H

#include <penumbra/penumbra.h>

#include "method/exact/exact.h"

struct twin_random {
    uint64_t state;
};
double twin_uniform(struct twin_random *random); /* [0, 1) */
int twin_below(struct twin_random *random, int count);

#define TWIN_RECEIVERS 96

/* A scene that seed makes, with one light, and receivers on and about its surfaces. */
struct twin_case {
    pnb_scene *scene;
    pnb_light light;
    double polygon[64];
    float positions[3 * TWIN_RECEIVERS], normals[3 * TWIN_RECEIVERS];
    pnb_receivers receivers;
    char text[128];
};
bool twin_case_init(pnb_context *context, uint64_t seed, struct twin_case *out);
void twin_case_finish(struct twin_case *c);

/* Visibility of each receiver: every sample of the light against every triangle, in double
 * precision. */
void twin_visibility(pnb_context *context, const struct twin_case *c, int samples, double *out);

#endif
