/* viewer/pacing.h: how many pixels a frame may have while something moves.
 *
 * Level 0 is all of them; two levels halve their number. A frame that took too long goes down as
 * many levels as its time is over the budget in powers of the root of two; one with enough time to
 * spare may go up one, since that many more pixels take at most that much more time. Where fewer
 * pixels did not help, as with a method whose cost is in its maps, it goes back up and stays there
 * for a while.
 */
#ifndef VIEWER_PACING_H
#define VIEWER_PACING_H

#include <stdbool.h>

enum { VIEW_PACING_LEVELS = 22 };

struct view_pacing {
    int level;
    bool known; /* false: nothing measured since the methods or the scene changed */
    int quick;  /* frames in a row that would let it go up */
    double ms_at[VIEW_PACING_LEVELS]; /* the best of the last times */
    int seen[VIEW_PACING_LEVELS];     /* frames at each level */
    int lowest;                       /* deeper levels do not help */
    int hold;                         /* frames for which that is believed */
};

void view_pacing_reset(struct view_pacing *pacing);
/* The size at a level, at least 8 pixels each way. */
void view_pacing_size(int level, int width, int height, int *out_width, int *out_height);
/* A frame at `level` took so long. */
void view_pacing_learn(struct view_pacing *pacing, int level, double ms);
/* What a frame of all pixels would take at most, by one measured at that level. */
double view_pacing_predict(int level, double ms);

#endif
