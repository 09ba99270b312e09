/* bench/peer_clipper.cpp: Clipper 6 (libpolyclipping) as a peer of the sweep, behind C functions.
 */
#include "peer_clipper.h"

#include <polyclipping/clipper.hpp>

#include <vector>

using namespace ClipperLib;

struct peer_outlines {
    std::vector<Paths> outlines;
    std::vector<Paths> levels; /* levels[i]: covered at least i + 1 times */
};

extern "C" struct peer_outlines *peer_create(void)
{
    return new peer_outlines;
}

extern "C" void peer_destroy(struct peer_outlines *peer)
{
    delete peer;
}

extern "C" void peer_clear(struct peer_outlines *peer)
{
    peer->outlines.clear();
    peer->levels.clear();
}

/* One sample's directed loops to its hard outline. */
extern "C" void peer_add_outline(struct peer_outlines *peer, const int *xy, const unsigned *starts,
                                 size_t loop_count)
{
    Paths loops(loop_count);
    for (size_t i = 0; i < loop_count; i++) {
        loops[i].reserve(starts[i + 1] - starts[i]);
        for (unsigned k = starts[i]; k < starts[i + 1]; k++)
            loops[i].push_back(IntPoint(xy[2 * k], xy[2 * k + 1]));
    }
    Clipper clipper;
    clipper.AddPaths(loops, ptSubject, true);
    peer->outlines.emplace_back();
    clipper.Execute(ctUnion, peer->outlines.back(), pftNonZero, pftNonZero);
}

/* All levels of the outlines, one outline added after the other. */
extern "C" void peer_levels(struct peer_outlines *peer)
{
    for (size_t k = 0; k < peer->outlines.size(); k++) {
        peer->levels.emplace_back();
        for (size_t i = k + 1; i-- > 0;) {
            Paths more;
            if (i == 0) {
                more = peer->outlines[k];
            } else {
                Clipper both;
                both.AddPaths(peer->levels[i - 1], ptSubject, true);
                both.AddPaths(peer->outlines[k], ptClip, true);
                both.Execute(ctIntersection, more, pftNonZero, pftNonZero);
            }
            if (peer->levels[i].empty()) {
                peer->levels[i].swap(more);
                continue;
            }
            Clipper sum;
            sum.AddPaths(peer->levels[i], ptSubject, true);
            sum.AddPaths(more, ptClip, true);
            Paths result;
            sum.Execute(ctUnion, result, pftNonZero, pftNonZero);
            peer->levels[i].swap(result);
        }
    }
}

extern "C" double peer_level_area(const struct peer_outlines *peer, size_t level)
{
    double sum = 0;
    for (const Path &path : peer->levels[level - 1])
        sum += Area(path);
    return sum;
}
