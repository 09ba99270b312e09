/* cli/options.h: the command line: what a command takes, how it is read, and how it is explained.
 *
 * A command describes itself by one struct cli_command; reading and --help both come from it. Every
 * mistake of the command line ends in one line on standard error and exit status 2.
 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>

#include <penumbra/penumbra.h>

#define CLI_EXIT_DONE   0
#define CLI_EXIT_FAILED 1 /* the work failed */
#define CLI_EXIT_USAGE  2 /* the command line is wrong */
#define CLI_GO_ON       (-1)

/* The options that commands share; a command takes those in its mask. --help and --version are
 * always there. */
enum {
    CLI_METHOD = 1 << 0,      /* -m, --method NAME */
    CLI_METHODS = 1 << 1,     /* --methods a,b:SAMPLES:KEY=VALUE,all; -m adds one more */
    CLI_SIZE = 1 << 2,        /* -s, --size WxH */
    CLI_LIGHT = 1 << 3,       /* --light SPEC, repeatable */
    CLI_LIGHT_INDEX = 1 << 4, /* --light-index N */
    CLI_SAMPLES = 1 << 5,     /* -n, --samples N */
    CLI_PARAM = 1 << 6,       /* -p, --param KEY=VALUE, repeatable */
    CLI_VISIBILITY = 1 << 7,  /* --visibility FILE, repeatable */
    CLI_THREADS = 1 << 8,     /* --threads N */
    CLI_JSON = 1 << 9,        /* --json */
    CLI_QUIET = 1 << 10,      /* -q, --quiet */
    CLI_OUTPUT = 1 << 11,     /* -o, --output PATH */
    CLI_IMAGE = 1 << 12       /* --image FILE, repeatable */
};

/* An option of one command only: with value_name it takes a text, else it is a flag. values may be
 * NULL for a flag. */
struct cli_extra {
    const char *name;       /* without the dashes */
    const char *value_name; /* "FILE", or NULL: a flag */
    const char *help;
    const char **value; /* the last one given; "" for a flag; untouched if absent */
};

struct cli_command {
    const char *name;
    const char *operands; /* as help shows them: "SCENE", "SCENE...", "[NAME]" or "" */
    const char *summary;  /* a few words, for the list of commands */
    unsigned options;     /* the mask */
    const struct cli_extra *extras;
    size_t extra_count;
    size_t least_operands, most_operands;
    const char *output_help; /* what -o is here */
    const char *text;        /* what --help says after the options: details and examples */
    const char *method;      /* whose parameters -p are without -m; NULL: pnb_default_method() */
};

/* One entry of --methods: NAME[:SAMPLES][:KEY=VALUE]..., where n=SAMPLES is another way to say
 * SAMPLES. */
struct cli_choice {
    const char *method;
    int samples;              /* 0: none */
    pnb_solver_param *params; /* its own; they count before those of -p */
    size_t param_count;
    bool figures_only; /* shown in tables and plots, without pictures */
    /* Left out of scenes with more triangles (0: of none), or also of those with open meshes. */
    size_t most_triangles;
    bool closed_only;
    const char *why;
    char label[128]; /* "planar", "planar:8", "planar:8:placement=border" */
};

struct cli_options {
    const struct cli_command *command;
    const char **operands;
    size_t operand_count;
    const char *output;         /* NULL: not given */
    const char *method;         /* the last -m; NULL: not given */
    struct cli_choice *choices; /* --methods and -m, in order, each once; "all" is written out */
    size_t choice_count;        /* 0: not given */
    bool all_methods;           /* "all" is among --methods */
    int width, height;          /* 800 x 600 unless given */
    bool size_given;
    const char **lights; /* JSON texts */
    size_t light_count;
    size_t light_index;
    int samples; /* 0: the method's default */
    pnb_solver_param *params;
    size_t param_count;
    const char **visibilities; /* files */
    size_t visibility_count;
    const char **images; /* files */
    size_t image_count;
    int threads; /* 0: one per processor */
    bool json, quiet;
};

/* Reads argv[1..]; argv[0] is the command's name. CLI_GO_ON, or an exit status: --help and
 * --version were answered, or the line is wrong and that was said. Also checks method names and
 * parameters against the registry, so that no long work starts in vain. finish after CLI_GO_ON. */
int cli_options_init(const struct cli_command *command, int argc, char **argv,
                     struct cli_options *options);
void cli_options_finish(struct cli_options *options);

/* Does this program have the method of the entry, with those parameters? */
bool cli_knows_entry(const char *entry, size_t length);
/* Adds the entries of a list as --methods does, without cutting it; false: the mistake was said. */
bool cli_add_methods(struct cli_options *options, const char *list);

/* "penumbra: error: WHAT: WHY (see penumbra COMMAND --help)", one line; returns CLI_EXIT_USAGE.
 * command may be NULL. */
int cli_usage_error(const char *command, const char *what, const char *why, ...)
    __attribute__((format(printf, 3, 4)));
/* "penumbra: error: WHAT: WHY", one line; returns CLI_EXIT_FAILED. */
int cli_error(const char *what, const char *why, ...) __attribute__((format(printf, 2, 3)));

/* The whole text as a number in [minimum, maximum]; else the mistake is said and false returned. */
bool cli_read_integer(const char *command, const char *option, const char *text, long minimum,
                      long maximum, long *out_value);

/* The name in the list that is likeliest meant by text, or NULL if none is near. */
const char *cli_nearest(const char *text, const char *const *names, size_t count);

/* True if path ends in one of the endings, which are written as ".png .exr"; case does not count.
 */
bool cli_has_ending(const char *path, const char *endings);

#endif
