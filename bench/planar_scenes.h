/* bench/planar_scenes.h: meshes over a ground plane, for the planar suite. */
#ifndef BENCH_PLANAR_SCENES_H
#define BENCH_PLANAR_SCENES_H

#include <penumbra/penumbra.h>

enum bench_shape {
    BENCH_SPHERE,
    BENCH_TORUS,
    BENCH_KNOT, /* a (3, 7) torus knot's tube */
    BENCH_BLOB, /* a bumpy sphere */
    BENCH_BOX,
    BENCH_SLABS /* the last two have no rows and columns */
};

void bench_die(pnb_context *context);
/* The ground, and a mesh of rows x columns two metres above it. */
pnb_scene *bench_scene(pnb_context *context, enum bench_shape shape, int rows, int columns);
/* Quality of what the parameters choose between, against ray tracing. */
void bench_planar_quality(void);

#endif
