/* viewer/options.h: the command line of penumbra-view, which 'penumbra view' has checked already.
 */
#ifndef VIEWER_OPTIONS_H
#define VIEWER_OPTIONS_H

#include <penumbra/penumbra.h>
#include <stdbool.h>

enum { VIEW_METHODS_MAX = 2 };

struct view_options {
    const char *scene; /* NULL: the first built-in one */
    struct view_choice {
        const char *method; /* NULL: the default */
        int samples;
        const char **params; /* KEY=VALUE */
        int param_count;
    } choices[VIEW_METHODS_MAX];
    int method_count;    /* given by -m */
    const char **lights; /* JSON; ends with NULL */
    int light_count;
    int width, height; /* of the canvas */
    bool size_given;
    int threads;
    const char *script; /* a name or a file */
    int frames;
    bool json, quiet, full_size;
};

/* False: said why, exit_status is set (0 for --help and --version). */
bool view_options_read(struct view_options *options, int argc, char **argv, int *exit_status);
void view_options_finish(struct view_options *options);
/* "penumbra: error: WHAT: WHY", one line. */
void view_complain(const char *what, const char *why);

#endif
