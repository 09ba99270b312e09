/* viewer/pacing.c: how many pixels a frame may have while something moves. */
#include "pacing.h"

#include <math.h>

#define BUDGET_MS   42.0 /* a frame of the worker: some 22 to 24 a second reach the screen */
#define LATE_MS     150.0
#define UP_AFTER    3
#define HOLD_FRAMES 60

void view_pacing_reset(struct view_pacing *pacing)
{
    /* Nothing is known: begin with few pixels, so that even a method of seconds answers. */
    *pacing = (struct view_pacing){.level = 12, .lowest = VIEW_PACING_LEVELS - 1};
}

static int side(int pixels, int level)
{
    int scaled = (int)lround(pixels * pow(2, -0.25 * level));
    return scaled < 8 ? (pixels < 8 ? pixels : 8) : scaled;
}

void view_pacing_size(int level, int width, int height, int *out_width, int *out_height)
{
    *out_width = side(width, level);
    *out_height = side(height, level);
}

static int clamp_level(int level)
{
    return level < 0 ? 0 : level >= VIEW_PACING_LEVELS ? VIEW_PACING_LEVELS - 1 : level;
}

/* Fewer pixels may even cost more (exact on spheres-9x9 is quickest at a quarter of each side): of
 * the levels seen, the one with most pixels that is within a quarter of the quickest, if that has
 * at least four times the pixels of this one. One slow frame proves nothing: each level stands by
 * the best of its last ones. */
static int as_good(const struct view_pacing *pacing, int level)
{
    double quickest = pacing->ms_at[level];
    if (pacing->seen[level] < 3)
        return level;
    for (int k = 0; k < level; k++)
        if (pacing->seen[k] > 0 && pacing->ms_at[k] < quickest)
            quickest = pacing->ms_at[k];
    for (int k = 0; k + 4 <= level; k++)
        if (pacing->seen[k] > 0 && pacing->ms_at[k] < 1.25 * quickest)
            return k;
    return level;
}

static void remember(struct view_pacing *pacing, int level, double ms)
{
    double aged = pacing->ms_at[level] * 1.1;
    pacing->ms_at[level] = pacing->seen[level] > 0 && aged < ms ? aged : ms;
    pacing->seen[level]++;
}

/* As deep as the budget asks, but not below an eighth of each side while that takes less than
 * LATE_MS: a few frames fewer are better than a picture that shows nothing. */
static int wanted_level(int level, double ms)
{
    int wanted = clamp_level(level + (int)ceil(2 * log2(fmax(ms, 0.01) / BUDGET_MS)));
    int late = clamp_level(level + (int)ceil(2 * log2(fmax(ms, 0.01) / LATE_MS)));
    int eighth = 12 > late ? 12 : late;
    return wanted < eighth ? wanted : eighth;
}

void view_pacing_learn(struct view_pacing *pacing, int level, double ms)
{
    double over = 2 * log2(fmax(ms, 0.01) / BUDGET_MS);
    int wanted = wanted_level(level, ms);
    remember(pacing, level, ms);
    if (pacing->hold > 0 && --pacing->hold == 0)
        pacing->lowest = VIEW_PACING_LEVELS - 1;
    if (!pacing->known) {
        pacing->level = wanted;
    } else if (over > 0.15) {
        int good = as_good(pacing, level);
        if (good < level) {
            pacing->lowest = wanted = good;
            pacing->hold = HOLD_FRAMES;
        }
        pacing->level = wanted < pacing->lowest ? wanted : pacing->lowest;
        pacing->quick = 0;
    } else if (over < -1.15 && level > 0) {
        if (++pacing->quick >= UP_AFTER) {
            pacing->level = level - 1;
            pacing->quick = 0;
        }
    } else {
        pacing->quick = 0;
    }
    pacing->known = true;
}

double view_pacing_predict(int level, double ms)
{
    return ms * pow(2, 0.5 * level);
}
