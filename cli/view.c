/* cli/view.c: 'penumbra view': starts the window, a program of its own (penumbra-view), so that the
 * command line needs no GTK. The line is checked here; the program takes it as it stands. */
#define _GNU_SOURCE
#include "commands.h"
#include "session.h"

#include <errno.h>
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
    "measurements and tests: first, drag, drag-object or orbit measure, a FILE of commands does\n"
    "what it says (docs/view.md); the exit status is 1 if it could not.\n\n"
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

/* "METHOD,METHOD": the window shows two at most, with the numbers of samples that they have. */
static int check_methods(const struct cli_options *options)
{
    if (options->method_count > 2)
        return cli_usage_error("view", "--methods", "the window shows two methods at most");
    for (size_t i = 0; i < options->method_count; i++)
        if (options->method_samples[i])
            return cli_usage_error("view", "--methods",
                                   "takes names alone here; -n gives the samples of the first");
    if (options->size_given && (options->width < 64 || options->height < 64 ||
                                options->width > 8192 || options->height > 8192))
        return cli_usage_error("view", "--size",
                               "each side of the window's picture must lie "
                               "between 64 and 8192");
    return CLI_GO_ON;
}

static int start(const struct cli_options *options, const char *script, const char *frames,
                 bool full_size)
{
    char path[4200], size[64], threads[32], samples[32];
    if (!find_viewer(path, sizeof(path)))
        return cli_error(PROGRAM, "not found: this penumbra was built without its window (GTK 4, "
                                  "Debian: libgtk-4-dev)");
    size_t most = 32 + 2 * (options->param_count + options->light_count + options->method_count);
    char **argv = calloc(most, sizeof(*argv));
    char **params = calloc(options->param_count + 1, sizeof(*params));
    if (!argv || !params) {
        free(argv);
        free(params);
        return cli_error("memory", "none left");
    }
    size_t count = 0;
    argv[count++] = (char *)PROGRAM;
    if (options->operand_count)
        argv[count++] = (char *)options->operands[0];
    for (size_t i = 0; i < options->method_count; i++) {
        argv[count++] = (char *)"-m";
        argv[count++] = (char *)options->methods[i];
    }
    for (size_t i = 0; i < options->param_count; i++) {
        if (asprintf(&params[i], "%s=%s", options->params[i].key, options->params[i].value) < 0)
            params[i] = NULL;
        if (!params[i])
            continue;
        argv[count++] = (char *)"-p";
        argv[count++] = params[i];
    }
    for (size_t i = 0; i < options->light_count; i++) {
        argv[count++] = (char *)"--light";
        argv[count++] = (char *)options->lights[i];
    }
    if (options->size_given) {
        snprintf(size, sizeof(size), "%dx%d", options->width, options->height);
        argv[count++] = (char *)"-s";
        argv[count++] = size;
    }
    if (options->threads) {
        snprintf(threads, sizeof(threads), "%d", options->threads);
        argv[count++] = (char *)"--threads";
        argv[count++] = threads;
    }
    if (options->samples) {
        snprintf(samples, sizeof(samples), "%d", options->samples);
        argv[count++] = (char *)"-n";
        argv[count++] = samples;
    }
    if (script) {
        argv[count++] = (char *)"--script";
        argv[count++] = (char *)script;
    }
    if (frames) {
        argv[count++] = (char *)"--frames";
        argv[count++] = (char *)frames;
    }
    if (full_size)
        argv[count++] = (char *)"--full-size";
    if (options->json)
        argv[count++] = (char *)"--json";
    if (options->quiet)
        argv[count++] = (char *)"-q";
    fflush(stdout);
    execv(path, argv);
    int result = cli_error(path, "%s", strerror(errno));
    for (size_t i = 0; i < options->param_count; i++)
        free(params[i]);
    free(params);
    free(argv);
    return result;
}

int command_view(int argc, char **argv)
{
    const char *script = NULL, *frames = NULL, *full_size = NULL;
    const struct cli_extra extras[] = {
        {"script", "NAME|FILE", "drive the window: first, drag, drag-object, orbit or a file",
         &script},
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
        result = check_methods(&options);
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
