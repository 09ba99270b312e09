/* cli/compare_motion.h: methods while the light or an occluder moves, and their part of the page.
 */
#ifndef CLI_COMPARE_MOTION_H
#define CLI_COMPARE_MOTION_H

#include "compare.h"

#define COMPARE_JUMP_SCALE 0.1 /* the end of the colours of the maps of jumps */

struct compare_motion_entry {
    char label[128];
    const pnb_method_info *method;
    double milliseconds; /* median of the frames */
    /* Over the steps and pixels of the penumbra: root mean squares of the method's own change, of
     * the truth's at the same places, and of their difference; of that the 99.9th percentile and
     * the largest. */
    double change, truth_change, flicker, popping, largest;
    size_t pixels;
    double *steps;            /* flicker of each, frames - 1 */
    struct compare_png slice; /* one row over time */
    struct compare_png jumps; /* the largest per pixel; malloc()ed */
};

struct compare_motion {
    const char *path, *title; /* of the scene; borrowed */
    char what[120];           /* "the light moves 0.3 m in 15 steps" */
    int frames, width, height, truth_samples;
    double share; /* of the whole path */
    struct compare_png truth_slice;
    struct compare_motion_entry *entries;
    size_t entry_count;
};

/* The caller sets frames (2 at least), width, height and share; the entries are those of the scene,
 * done before, that have pictures; of the reference fewer samples. CLI_GO_ON or an exit status;
 * finish in either case. */
int compare_motion_run(struct cli_session *session, const struct compare_scene *scene,
                       bool occluder, struct compare_motion *motion);
void compare_motion_finish(pnb_context *context, struct compare_motion *motion);
double compare_motion_units(const struct compare_motion *motion, size_t entries);

json_t *report_json_motion(const struct compare_motion *motion); /* a new reference */
void report_html_motion_begin(FILE *page, const struct compare_motion *motion);
void report_html_motion(FILE *page, const struct compare_motion *motion, size_t index);

#endif
