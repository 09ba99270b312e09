/* cli/view.c: 'penumbra view': starts the window, a program of its own (penumbra-view), so that the
 * command line needs no GTK. The line is checked here; the program takes it as it stands. */
#define _GNU_SOURCE
#include "commands.h"
#include "session.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define PROGRAM "penumbra-view"

static const char help_text[] =
    "Drag the light by its handle, turn the picture with the mouse, press F1 for the keys. "
    "Without\n"
    "SCENE a built-in one is shown; files can be opened or dropped.\n\n"
    "--methods A,B puts two methods side by side with a divider. --script drives the window for\n"
    "measurements and tests: first, drag, drag-object, orbit and repaint measure, a FILE of\n"
    "commands does what it says (docs/view.md); the exit status is 1 if it could not.\n\n"
    "examples\n"
    "  penumbra view builtin:two-boxes\n"
    "  penumbra view cow.obj --methods exact,reference\n"
    "  penumbra view builtin:spheres-9x9 --script drag --frames 300 -s 800x600 --json\n";

static bool try_folder(const char *folder, const char *below, char *path, size_t size)
{
    snprintf(path, size, "%s/%s" PROGRAM, folder, below);
    return access(path, X_OK) == 0;
}

/* PNB_VIEWER; beside this program as in a build folder, or where it is installed. */
static bool find_viewer(char *path, size_t size)
{
    const char *given = getenv("PNB_VIEWER");
    char folder[4000];
    if (given && *given) {
        snprintf(path, size, "%s", given);
        return access(path, X_OK) == 0;
    }
    ssize_t length = readlink("/proc/self/exe", folder, sizeof(folder) - 1);
    if (length > 0) {
        folder[length] = 0;
        char *slash = strrchr(folder, '/');
        if (slash)
            *slash = 0;
        if (try_folder(folder, "viewer/", path, size) ||
            try_folder(folder, "../libexec/penumbra/", path, size))
            return true;
    }
    return try_folder(PNB_LIBEXECDIR, "", path, size);
}

static int check_line(const struct cli_options *options)
{
    if (options->choice_count > 2)
        return cli_usage_error("view", "--methods", "the window shows two methods at most");
    if (options->size_given && (options->width < 64 || options->height < 64 ||
                                options->width > 8192 || options->height > 8192))
        return cli_usage_error("view", "--size",
                               "each side of the window's picture must lie "
                               "between 64 and 8192");
    return CLI_GO_ON;
}

/* The viewer's command line. Texts made for it are its own. */
struct line {
    char **argv, **made;
    size_t count, made_count;
};

static bool line_init(struct line *line, const struct cli_options *options)
{
    size_t most = 64 + 2 * (options->param_count + options->light_count);
    for (size_t i = 0; i < options->choice_count; i++)
        most += 4 + 2 * options->choices[i].param_count;
    *line =
        (struct line){.argv = calloc(most, sizeof(char *)), .made = calloc(most, sizeof(char *))};
    if (line->argv && line->made)
        return true;
    free(line->argv);
    free(line->made);
    return false;
}

static void line_finish(struct line *line)
{
    for (size_t i = 0; i < line->made_count; i++)
        free(line->made[i]);
    free(line->argv);
    free(line->made);
}

static void add(struct line *line, const char *text)
{
    line->argv[line->count++] = (char *)text;
}

static void add_made(struct line *line, const char *option, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static void add_made(struct line *line, const char *option, const char *format, ...)
{
    va_list arguments;
    char *text;
    va_start(arguments, format);
    if (vasprintf(&text, format, arguments) >= 0) {
        line->made[line->made_count++] = text;
        add(line, option);
        add(line, text);
    }
    va_end(arguments);
}

static void add_settings(struct line *line, int samples, const pnb_solver_param *params,
                         size_t count)
{
    if (samples)
        add_made(line, "-n", "%d", samples);
    for (size_t i = 0; i < count; i++)
        add_made(line, "-p", "%s=%s", params[i].key, params[i].value);
}

/* -n and -p belong to the -m before them; those of the whole line to the first method. */
static void add_methods(struct line *line, const struct cli_options *options)
{
    for (size_t i = 0; i < options->choice_count; i++) {
        const struct cli_choice *choice = &options->choices[i];
        add(line, "-m");
        add(line, choice->method);
        if (i == 0)
            add_settings(line, options->samples, options->params, options->param_count);
        add_settings(line, choice->samples, choice->params, choice->param_count);
    }
    if (options->choice_count == 0)
        add_settings(line, options->samples, options->params, options->param_count);
}

static int start(const struct cli_options *options, const char *script, const char *frames,
                 bool full_size)
{
    char path[4200], size[64], threads[32];
    if (!find_viewer(path, sizeof(path)))
        return cli_error(PROGRAM, "not found: this penumbra was built without its window (GTK 4, "
                                  "Debian: libgtk-4-dev)");
    struct line line;
    if (!line_init(&line, options))
        return cli_error("memory", "none left");
    add(&line, PROGRAM);
    if (options->operand_count)
        add(&line, options->operands[0]);
    add_methods(&line, options);
    for (size_t i = 0; i < options->light_count; i++) {
        add(&line, "--light");
        add(&line, options->lights[i]);
    }
    if (options->size_given) {
        snprintf(size, sizeof(size), "%dx%d", options->width, options->height);
        add(&line, "-s");
        add(&line, size);
    }
    if (options->threads) {
        snprintf(threads, sizeof(threads), "%d", options->threads);
        add(&line, "--threads");
        add(&line, threads);
    }
    if (script) {
        add(&line, "--script");
        add(&line, script);
    }
    if (frames) {
        add(&line, "--frames");
        add(&line, frames);
    }
    if (full_size)
        add(&line, "--full-size");
    if (options->json)
        add(&line, "--json");
    if (options->quiet)
        add(&line, "-q");
    fflush(stdout);
    execv(path, line.argv);
    int result = cli_error(path, "%s", strerror(errno));
    line_finish(&line);
    return result;
}

int command_view(int argc, char **argv)
{
    const char *script = NULL, *frames = NULL, *full_size = NULL;
    const struct cli_extra extras[] = {
        {"script", "NAME|FILE",
         "drive the window: first, drag, drag-object, orbit, repaint or a file", &script},
        {"frames", "N", "frames of a measured drag (default 300)", &frames},
        {"full-size", NULL, "keep all pixels while something moves", &full_size}};
    const struct cli_command command = {
        .name = "view",
        .operands = "[SCENE]",
        .summary = "A window: drag lights and objects, methods beside the truth",
        .options = CLI_METHOD | CLI_METHODS | CLI_SIZE | CLI_LIGHT | CLI_SAMPLES | CLI_PARAM |
                   CLI_THREADS | CLI_JSON | CLI_QUIET,
        .extras = extras,
        .extra_count = 3,
        .most_operands = 1,
        .text = help_text,
    };
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON)
        return result;
    long number;
    if (frames && !cli_read_integer("view", "--frames", frames, 1, 100000000, &number))
        result = CLI_EXIT_USAGE;
    if (result == CLI_GO_ON)
        result = check_line(&options);
    if (result == CLI_GO_ON && options.light_count) {
        struct cli_session session;
        result = cli_session_init(&session, &options);
        if (result == CLI_GO_ON) {
            result = cli_lights_check(&session);
            cli_session_finish(&session);
        }
    }
    if (result == CLI_GO_ON)
        result = start(&options, script, frames, full_size != NULL);
    cli_options_finish(&options);
    return result;
}
