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
    size_t tiles, tiles_x;
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

/* A frame's preparation: the samples' places on this light. The frame points to shape. */
pnb_status reference_frame_init(pnb_solver *solver, const pnb_light *light,
                                const pnb_receivers *receivers, float *visibility,
                                struct light_shape *shape, struct reference_frame *frame);
void reference_frame_finish(pnb_solver *solver, struct reference_frame *frame);
/* The receivers of a tile that face some of the light; the others' visibility is written. */
void reference_tile_begin(const struct reference_frame *frame, size_t tile,
                          struct reference_tile *t);
/* The packet of samples [sample, sample + 16) of a receiver. */
void reference_packet(const struct reference_frame *frame, const struct reference_receiver *at,
                      size_t sample, struct trace_rays *rays, int32_t *valid);

#endif
