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
    float *uv;      /* blocks x 16 sets x {u, v} x samples */
    float *targets; /* blocks x 16 sets x {x, y, z} x samples: the places on the light */
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
    vec3 middle;        /* of the light */
    double packet_area; /* of the light's part that a packet aims at; the sun: solid angle */
    float tfar;
    bool sun;
    struct reference_count *rays;
};

struct reference_receiver {
    float origin[3], normal[3]; /* lifted */
    float height;
    uint32_t seen;
    bool whole;    /* faces the whole light */
    bool coherent; /* its packets are thin bundles */
    size_t index;
    const float *targets; /* its sample set */
};

#define REFERENCE_TILE 16
struct reference_tile {
    int count;
    struct reference_receiver receivers[REFERENCE_TILE];
};

#endif
