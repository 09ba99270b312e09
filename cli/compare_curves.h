/* cli/compare_curves.h: cost and error over one number: triangles, light size, pixels; and the
 * papers' tables and figures made again. Both are measured by compare_scene_run(), and become
 * sections of the page. */
#ifndef CLI_COMPARE_CURVES_H
#define CLI_COMPARE_CURVES_H

#include "compare.h"

/* One entry along a curve; NaN where it has no figure. */
struct compare_track {
    char label[128];
    const pnb_method_info *method;
    double *ms, *rmse;
};

struct compare_curve {
    const char *key, *title, *x_title;
    char note[200];
    double *x;
    size_t count;
    struct compare_track *tracks;
    size_t track_count;
    bool errors; /* rmse is meant */
};

#define COMPARE_CURVES 3

struct compare_curves {
    struct compare_curve curves[COMPARE_CURVES]; /* triangles, light size, pixels */
};

/* options: those of the session; every method at its defaults is measured, the reference at 64
 * samples. CLI_GO_ON or an exit status; finish in either case. */
int compare_curves_run(struct cli_session *session, struct compare_curves *curves);
void compare_curves_finish(struct compare_curves *curves);
double compare_curves_units(void);
json_t *report_json_curves(const struct compare_curves *curves);
void report_html_curves(FILE *page, const struct compare_curves *curves);

/* A table of the frame rates of scenes at sizes. */
struct compare_rates {
    const char *title, *note;
    char **rows;    /* "complex: 5,760 triangles" */
    char **columns; /* "300 x 300" */
    size_t row_count, column_count;
    const char *paper_name;       /* whose column the paper's own numbers are */
    double *paper;                /* rows x columns, NaN: not given; NULL: none */
    struct compare_track *tracks; /* ms: rows x columns */
    size_t track_count;
};

/* Pictures of one scene by several entries. */
struct compare_figure {
    const char *paper, *title, *note;
    struct compare_scene scene; /* with its pictures */
    char **missing;             /* entries that this program lacks, or that cannot do it */
    size_t missing_count;
};

/* The geometry of a planar shadow, as a drawing. */
struct compare_outlines {
    int rings;
    size_t vertices, triangles;
    double milliseconds;
    char *drawing; /* inline SVG, or NULL */
};

struct compare_papers {
    struct compare_rates dbuffer;
    struct compare_outlines outlines[3];
    size_t outline_count;
    struct compare_figure *figures;
    size_t figure_count;
};

int compare_papers_run(struct cli_session *session, struct compare_papers *papers);
void compare_papers_finish(pnb_context *context, struct compare_papers *papers);
double compare_papers_units(void);
json_t *report_json_papers(const struct compare_run *run, const struct compare_papers *papers);
void report_html_papers(FILE *page, const struct compare_run *run,
                        const struct compare_papers *papers, const struct compare_curves *curves);

#endif
