/* bench/dbuffer_boundary.h: how far the boundaries of dbuffer's umbrae and penumbrae lie from the
 * truth's, in texels of its buffer. */
#ifndef BENCH_DBUFFER_BOUNDARY_H
#define BENCH_DBUFFER_BOUNDARY_H

#include <penumbra/penumbra.h>

/* By [0: umbra, 1: outer]. */
struct boundary {
    size_t near[2]; /* pixels: the truth's boundary runs within 4 texels of them */
    size_t off[2];  /* of these: on the wrong side of it, and 1.5 texels around them all is */
    int size;       /* texels a side */
    double texel;   /* seen from the light's centre, radians */
};

/* Flat receivers that face the whole light, width x height pixels, D-buffer of size^2. mark: NULL,
 * or per pixel bits 0, 1: near; bits 2, 3: off. */
pnb_status boundary_measure(pnb_context *context, pnb_scene *scene, const pnb_light *light,
                            int width, int height, int size, struct boundary *out, uint8_t *mark,
                            float *visibility);

#endif
