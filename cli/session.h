/* cli/session.h: a command at work: the context with its progress bar and log, signals, scenes,
 * files and JSON output. */
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include <jansson.h>

#include "options.h"

struct cli_session {
    pnb_context *context;
    const struct cli_options *options;
    char **warnings; /* each once, in order */
    size_t warning_count;
    struct cli_bar {
        bool enabled, drawn;
        char stage[64];
        double started_ms, drawn_ms;
        double total, done, step; /* of a plan; total 0: none, each stage counts by itself */
    } bar;
    double repeat_ms; /* cli_solve(): how long quick frames are repeated; 0: the default */
};

/* CLI_GO_ON or an exit status. On SIGINT and SIGTERM the work is cancelled: the call under way ends
 * with PNB_ERROR_CANCELLED; a second signal ends the program at once. */
int cli_session_init(struct cli_session *session, const struct cli_options *options);
void cli_session_finish(struct cli_session *session);

/* Says what the context's last call failed of; returns CLI_EXIT_FAILED. */
int cli_session_fail(struct cli_session *session);
/* "penumbra: warning: TEXT" unless quiet, each text once; kept for JSON. */
void cli_session_warn(struct cli_session *session, const char *text);
/* Removes the progress bar from the screen. Whatever prints while work goes on calls it first. */
void cli_session_clear_bar(struct cli_session *session);
/* Long work of many parts: from here on the bar shows all of it, and the time left. units: of any
 * size, as long as they are about proportional to time. */
void cli_session_plan(struct cli_session *session, double units);
/* The part before is done, this one begins. */
void cli_session_step(struct cli_session *session, const char *what, double units);
/* True once a signal asked to stop. */
bool cli_session_stopped(void);
double cli_clock_ms(void);

/* The scene with the lights of --light in place of its own, if there are any; --light-index is
 * checked against it. CLI_GO_ON or an exit status. */
int cli_scene_load(struct cli_session *session, const char *path, pnb_scene **out_scene);
/* The --light texts alone: a mistake in them is one of the command line. Before loading a scene. */
int cli_lights_check(struct cli_session *session);

/* What can be known before long work: the folder of the file exists and lets write, and path is no
 * folder. CLI_GO_ON or an exit status. */
int cli_check_writable(const char *path);
/* The same for a folder that is made when missing. */
int cli_make_folder(const char *path);

/* pnb_solver_visibility(), then its report. steady: a quick one is run several times, and
 * report->visibility_ms is the median: the steady-state cost of a frame. processor_ms: the median
 * of what it took of the processor, all threads, other than on a graphics card; or NULL. */
pnb_status cli_solve(const struct cli_session *session, pnb_solver *solver, const pnb_light *light,
                     const pnb_receivers *receivers, bool steady, float *visibility,
                     pnb_solver_report *report, double *processor_ms);

double cli_median(double *values, size_t count); /* sorts them; count at least 1 */

/* What the solver ran on: the OpenGL renderer that it reported, or else the processor's name. text:
 * size bytes, the caller's. */
const char *cli_device(const pnb_solver_report *report, char *text, size_t size);

/* A JSON string of any bytes: what is not UTF-8 becomes '?'. */
json_t *cli_json_text(const char *text);
/* Finite numbers as they are, others as null. */
json_t *cli_json_number(double value);
/* The session's warnings as an array. */
json_t *cli_json_warnings(const struct cli_session *session);
/* Every parameter of the method (NULL: none) as it is in use. */
json_t *cli_json_parameters(const pnb_solver_param *params, size_t param_count,
                            const pnb_method_info *method);
json_t *cli_json_counters(const pnb_solver_report *report);
/* Prints to standard output and gives the reference away. CLI_EXIT_DONE or CLI_EXIT_FAILED. */
int cli_json_print(json_t *value);
/* Standard output as a whole came through? CLI_EXIT_DONE, or says why not: CLI_EXIT_FAILED. Every
 * command that prints ends with it. */
int cli_flush(void);

#endif
