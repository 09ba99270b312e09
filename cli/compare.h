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
    char label[128];               /* "wedge", "reference:64", "cycles.exr": each once */
    const char *name;              /* the method's, or the file's path */
    const pnb_method_info *method; /* NULL: a file */
    int samples;                   /* in use; 0: the method does not sample */
    pnb_solver_param *params;      /* its own and those of -p that the method has; texts borrowed */
    size_t param_count;
    bool figures_only;               /* one of a series: no pictures on the page */
    const struct cli_choice *choice; /* NULL: none was given */
    bool picture_only;               /* a file with colours: judged by its picture */
    double prepare_ms, milliseconds; /* NaN for files, as the next */
    double processor_ms;             /* of a frame, all threads */
    pnb_errors errors;
    float *error; /* per pixel, V - truth; NaN where nothing is counted; gone once it is drawn */
    struct compare_png picture;
    struct compare_png visibility; /* our own memory, as the next; none if picture_only */
    /* The pixels are codes, 0 where nothing is counted, else
     * 128 + 127 sign(e) sqrt(|e|), coloured by a palette: another palette, another scale. */
    struct compare_png error_map;
    char device[256];
    char **warnings;
    size_t warning_count;
    char counters[512]; /* "lit 1203, umbra 88" */
};

struct compare_scene {
    const char *path;
    const char *title;                 /* of a built-in scene, else NULL */
    pnb_scene *given;                  /* measured instead of the file; path is then only a name */
    const struct cli_options *options; /* instead of the session's */
    bool one_of_several;               /* methods that cannot do it are left out */
    size_t planned_triangles;          /* by which the bar's plan was made; 0: unknown then */
    int width, height;
    size_t light_index, light_count, triangle_count;
    const char *light_type;
    bool open;                                        /* a mesh that casts is not closed */
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
    char **paths;      /* of the scenes */
    size_t *triangles; /* of each, for the bar; 0: not known yet */
    size_t path_count;
    struct compare_scene *scenes; /* done so far; without their pictures */
    size_t scene_count;
    struct compare_motion *motion; /* room for one per scene */
    size_t motion_count;           /* done; their pictures are gone */
    struct compare_curves *curves; /* or NULL */
    struct compare_papers *papers; /* or NULL */
};

/* Loads scene->path and fills the rest. images: one per file of --image, of the right size.
 * CLI_GO_ON or an exit status; finish in either case. */
int compare_scene_run(struct cli_session *session, const pnb_image *images, int truth_samples,
                      struct compare_scene *scene);
/* Loads it and finds out which methods can do it, no more: for all scenes before the first one's
 * long work. As above; entries holds those that can. */
int compare_scene_check(struct cli_session *session, struct compare_scene *scene);
void compare_scene_finish(pnb_context *context, struct compare_scene *scene);
/* Frees the pictures and errors per pixel; figures stay. */
void compare_scene_drop_pictures(pnb_context *context, struct compare_scene *scene);

/* What compare_scene_run() takes, in units of cli_session_plan(). triangles: planned_triangles. */
double compare_scene_units(const struct cli_options *options, int truth_samples, size_t triangles);
/* The entry's method on the scene, with its samples and parameters. */
pnb_status compare_entry_solver(pnb_context *context, pnb_scene *scene,
                                const struct compare_entry *entry, pnb_solver **out_solver);

/* An 8-bit grey PNG with 256 colours instead of its greys; out: malloc()ed. */
bool compare_png_palette(const uint8_t *grey, size_t size, const uint8_t (*colors)[3],
                         struct compare_png *out);
/* The colours of error codes when the ends of the map are -scale and scale. */
void compare_error_colors(double scale, uint8_t (*colors)[3]);
double compare_srgb(double linear); /* [0,1] both */

/* report.json; a new reference. */
json_t *report_json_scene(const struct compare_run *run, const struct compare_scene *scene);
json_t *report_json(const struct compare_run *run, json_t *scenes);

/* The page: head, a section per scene, foot. The head is written last: it holds the summary. */
void report_html_begin(FILE *page, const struct compare_run *run);
void report_html_scene(FILE *page, const struct compare_run *run, const struct compare_scene *scene,
                       size_t index);
void report_html_end(FILE *page, const struct compare_run *run);
void report_html_text(FILE *page, const char *text);              /* escaped */
const char *report_scene_name(const struct compare_scene *scene); /* its path without "builtin:" */
void report_html_count(FILE *page, size_t count);                 /* 1,234,567 */
void report_html_duration(FILE *page, double ms);
void report_html_entry(FILE *page, const pnb_method_info *method, const char *label); /* with dot */
void report_html_png(FILE *page, const struct compare_png *png); /* as a data: address */
/* Which method for which scene, the figures of all, error against time over all scenes. */
void report_html_summary(FILE *page, const struct compare_run *run);
/* Which method for which kind of scene. entries: every label of the run once. */
void report_html_kinds(FILE *page, const struct compare_run *run,
                       const struct compare_entry *const *entries, size_t count);
/* NULL: the scene has no such entry. */
const struct compare_entry *report_find_entry(const struct compare_scene *scene, const char *label);
bool report_measured(const struct compare_entry *entry); /* has an error and a time */
/* Below this two methods do not differ, since the truth has an error of its own. */
#define REPORT_ERROR_FLOOR 1e-4

/* ---- drawings: inline SVG on logarithmic axes ---- */

#define REPORT_COLORS 15 /* --c0 ... of the style sheet; the last one for files */

struct report_point {
    const char *label, *name; /* the label begins with the name */
    const char *group;        /* points of one group are joined, by order */
    double order;
    int color;
    bool partial; /* drawn hollow: the method does only some of the surfaces */
    double time, error;
};

struct report_curve {
    const char *label;
    int color;
    const double *x, *y; /* NaN: no point */
    size_t count;
};

/* With the front of those that no other one beats in both time and error. */
void report_plot_points(FILE *page, const struct report_point *points, size_t count,
                        const char *x_title, const char *y_title);
void report_plot_curves(FILE *page, const struct report_curve *curves, size_t count,
                        const char *x_title, const char *y_title);
/* The same over whole numbers, linear in x. */
void report_plot_steps(FILE *page, const struct report_curve *curves, size_t count,
                       const char *x_title, const char *y_title);
/* RMSE against milliseconds. */
void report_plot_time(FILE *page, const struct compare_scene *scene);
struct report_point report_point(const struct compare_entry *entry, double time, double error);
/* Which of the style sheet's colours stands for the method (NULL: a file). */
int report_color(const pnb_method_info *method);
/* How many pixels have which error. */
void report_plot_histogram(FILE *page, const struct compare_scene *scene,
                           const struct compare_entry *entry);

#endif
