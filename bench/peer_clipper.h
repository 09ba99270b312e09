/* bench/peer_clipper.h: Clipper 6 behind C functions. */
#ifndef BENCH_PEER_CLIPPER_H
#define BENCH_PEER_CLIPPER_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

struct peer_outlines;
struct peer_outlines *peer_create(void);
void peer_destroy(struct peer_outlines *peer);
void peer_clear(struct peer_outlines *peer);
void peer_add_outline(struct peer_outlines *peer, const int *xy, const unsigned *starts,
                      size_t loop_count);
void peer_levels(struct peer_outlines *peer);
double peer_level_area(const struct peer_outlines *peer, size_t level);

#ifdef __cplusplus
}
#endif
#endif
