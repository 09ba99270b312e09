/* cli/compare.h: what a comparison finds out about one scene; the page and the report are made from
 * it. */
#ifndef CLI_COMPARE_H
#define CLI_COMPARE_H

#include <stdint.h>
#include <stdio.h>

#include "session.h"

/* A file's bytes, made by the library: pnb_bytes_free(). */
struct compare_png {
    uint8_t *bytes;
    size_t size;
};

/* One method at one setting, or one file of another program. */
struct compare_entry {
    char label[128];                 /* "wedge", "reference:64", "cycles.exr": each once */
    const char *name;                /* the method's, or the file's path */
    const pnb_method_info *method;   /* NULL: a file */
    int samples;                     /* in use; 0: the method does not sample */
    bool picture_only;               /* a file with colours: judged by its picture */
    double prepare_ms, milliseconds; /* NaN for files */
    pnb_errors errors;
    float *error; /* per pixel, V - truth; NaN where nothing is counted */
    struct compare_png picture, visibility, error_map; /* visibility: none if picture_only */
    /* The error itself, for other scales: grey code 0 where nothing is counted, else
     * 128 + 127 sign(e) sqrt(|e|). */
    struct compare_png error_codes;
    char device[256];
    char **warnings;
    size_t warning_count;
    char counters[512]; /* "lit 1203, umbra 88" */
};

struct compare_scene {
    const char *path;
    int width, height;
    size_t light_index, light_count, triangle_count;
    const char *light_type;
    size_t surface_pixels;                            /* where the camera sees something */
    size_t facing_pixels;                             /* of these: what faces the whole light */
    size_t penumbra_pixels, umbra_pixels, lit_pixels; /* of these, by the truth */
    int truth_samples;
    double truth_ms, primary_ms;
    struct compare_png truth_picture, truth_visibility;
    double error_scale; /* at the ends of the error maps' colours */
    struct compare_entry *entries;
    size_t entry_count;
    char **notes; /* methods left out, and why */
    size_t note_count;
};

/* What is the same for all scenes of a run. */
struct compare_run {
    const char *command; /* that makes this comparison again */
    const char *date;    /* UTC */
    char processor[256];
    int threads;
    const struct cli_options *options;
};

/* Loads scene->path and fills the rest. images: one per file of --image, of the right size.
 * CLI_GO_ON or an exit status; finish in either case. */
int compare_scene_run(struct cli_session *session, const pnb_image *images, int truth_samples,
                      struct compare_scene *scene);
/* Loads it and finds out which methods can do it, no more: for all scenes before the first one's
 * long work. As above; entries holds those that can. */
int compare_scene_check(struct cli_session *session, struct compare_scene *scene);
void compare_scene_finish(pnb_context *context, struct compare_scene *scene);

/* report.json; a new reference. */
json_t *report_json_scene(const struct compare_run *run, const struct compare_scene *scene);
json_t *report_json(const struct compare_run *run, json_t *scenes);

/* The page: head, a section per scene, foot. */
void report_html_begin(FILE *page, const struct compare_run *run, size_t scene_count);
void report_html_scene(FILE *page, const struct compare_run *run, const struct compare_scene *scene,
                       size_t index);
void report_html_end(FILE *page, const struct compare_run *run);
void report_html_text(FILE *page, const char *text); /* escaped */

/* Inline SVG: RMSE against milliseconds, both logarithmic. */
void report_plot_time(FILE *page, const struct compare_scene *scene);
/* Which of the style sheet's colours --c0 ... --c7 stands for the entry's method. */
int report_color(const struct compare_scene *scene, const struct compare_entry *entry);
/* Inline SVG: how many pixels have which error. */
void report_plot_histogram(FILE *page, const struct compare_scene *scene,
                           const struct compare_entry *entry);

#endif
