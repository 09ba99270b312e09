/* method/reference/reference.h: the room's own structures, shared with its benchmark. */
#ifndef METHOD_REFERENCE_REFERENCE_H
#define METHOD_REFERENCE_REFERENCE_H

#include "light/light.h"
#include "method/method.h"
#include "trace/trace.h"

struct reference {
    struct trace *trace;
    uint32_t samples;
    size_t blocks;
    float *uv;      /* blocks x samples x {u, v} x 16 lanes */
    float *targets; /* blocks x samples x {x, y, z} x 16 lanes: the places on the light */
    bool filled, filled_line;
};

/* One per worker, on cache lines of their own. */
struct reference_count {
    uint64_t count;
    char padding[120];
};

struct reference_frame {
    struct reference *reference;
    const struct light_shape *shape;
    const pnb_receivers *receivers;
    float *visibility;
    size_t tiles_x;
    uint32_t samples;
    double lift;
    float tfar;
    bool sun;
    struct reference_count *rays;
};

struct reference_tile {
    float origin[3][TRACE_WIDTH]; /* lifted receivers */
    float plane[4][TRACE_WIDTH];  /* normal; what to add to its product with a direction */
    int32_t valid[TRACE_WIDTH];   /* -1: faces some of the light */
    uint32_t seen[TRACE_WIDTH];
    size_t index[TRACE_WIDTH]; /* of the receiver; SIZE_MAX: none */
    size_t block;
    bool all; /* every valid receiver faces the whole light */
};

#endif
