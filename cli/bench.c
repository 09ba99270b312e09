/* cli/bench.c: 'penumbra bench': runs the suites, which are programs of their own.
 *
 * Suite NAME is the program penumbra-bench-NAME, looked for in the folder bench/ beside this
 * program (a build tree), in ../libexec/penumbra from it, and in the folder given at build time.
 * What stands after the suite's name is handed to it.
 */
#define _GNU_SOURCE
#include "commands.h"
#include "session.h"

#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define PREFIX     "penumbra-bench-"
#define SUITES_MAX 64

static const char help_text[] =
    "Without SUITE, or with 'all', every suite runs. What follows SUITE is handed to the suite;\n"
    "'penumbra bench SUITE --help' shows what it takes.\n\n"
    "'penumbra bench all -o DIR' measures every method on every built-in scene instead and writes\n"
    "one page: errors, times, motion, cost, the papers remade. It is short for\n"
    "  penumbra compare builtin:all --methods all --series --motion --curves --papers -s 400x300\n"
    "and takes the options of compare.\n\n"
    "examples\n"
    "  penumbra bench all -o page\n"
    "  penumbra bench\n"
    "  penumbra bench reference\n"
    "  penumbra bench reference --json\n";

struct suites {
    char folders[3][4096];
    size_t folder_count;
    char names[SUITES_MAX][64]; /* sorted */
    size_t count;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static void find_folders(struct suites *suites)
{
    char program[3800];
    ssize_t length = readlink("/proc/self/exe", program, sizeof(program) - 1);
    if (length > 0) {
        program[length] = 0;
        char *slash = strrchr(program, '/');
        if (slash)
            *slash = 0;
        snprintf(suites->folders[suites->folder_count++], sizeof(suites->folders[0]), "%s/bench",
                 program);
        snprintf(suites->folders[suites->folder_count++], sizeof(suites->folders[0]),
                 "%s/../libexec/penumbra", program);
    }
    snprintf(suites->folders[suites->folder_count++], sizeof(suites->folders[0]), "%s",
             PNB_LIBEXECDIR);
}

static bool find_program(const struct suites *suites, const char *name, char *path, size_t size)
{
    for (size_t i = 0; i < suites->folder_count; i++) {
        snprintf(path, size, "%s/" PREFIX "%s", suites->folders[i], name);
        if (access(path, X_OK) == 0)
            return true;
    }
    return false;
}

static void find_suites(struct suites *suites)
{
    find_folders(suites);
    for (size_t i = 0; i < suites->folder_count; i++) {
        DIR *folder = opendir(suites->folders[i]);
        struct dirent *entry;
        while (folder && (entry = readdir(folder))) {
            const char *name = entry->d_name + strlen(PREFIX);
            if (strncmp(entry->d_name, PREFIX, strlen(PREFIX)) != 0 || strchr(name, '.') ||
                strlen(name) >= sizeof(suites->names[0]) || suites->count == SUITES_MAX)
                continue;
            bool known = false;
            for (size_t k = 0; k < suites->count; k++)
                known = known || strcmp(suites->names[k], name) == 0;
            if (!known)
                strcpy(suites->names[suites->count++], name);
        }
        if (folder)
            closedir(folder);
    }
    qsort(suites->names, suites->count, sizeof(suites->names[0]), by_name);
}

/* Runs the program to its end; arguments[0] is filled in here. */
static int run_suite(const struct suites *suites, const char *name, char **arguments)
{
    char path[4200];
    if (!find_program(suites, name, path, sizeof(path)))
        return cli_error(name, "the suite's program " PREFIX "%s is not found", name);
    arguments[0] = path;
    fflush(stdout);
    pid_t child = fork();
    if (child < 0)
        return cli_error(name, "cannot start: %s", strerror(errno));
    if (child == 0) {
        signal(SIGPIPE, SIG_DFL);
        execv(path, arguments);
        _exit(127);
    }
    int status;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return cli_error(name, "%s", strerror(errno));
    if (WIFSIGNALED(status))
        return cli_error(name, "the suite ended by signal %d", WTERMSIG(status));
    if (WEXITSTATUS(status) == 127)
        return cli_error(name, "cannot run %s", path);
    return WEXITSTATUS(status);
}

/* Each suite prints one JSON object; together they are an array in an object. */
static int run_all(const struct suites *suites, char **arguments, bool as_json)
{
    int worst = CLI_EXIT_DONE;
    if (!suites->count)
        return cli_error("bench", "no suites are found");
    if (as_json)
        printf("{\"suites\": [\n");
    for (size_t i = 0; i < suites->count; i++) {
        if (as_json && i)
            printf(",\n");
        else if (!as_json)
            printf("%s%s\n", i ? "\n" : "", suites->names[i]);
        int result = run_suite(suites, suites->names[i], arguments);
        if (result != CLI_EXIT_DONE)
            worst = result;
        if (as_json && result != CLI_EXIT_DONE)
            break;
    }
    if (as_json)
        printf("]}\n");
    return worst != CLI_EXIT_DONE ? worst : cli_flush();
}

static void print_suites(const struct suites *suites)
{
    printf("\nsuites\n");
    for (size_t i = 0; i < suites->count; i++)
        printf("  %s\n", suites->names[i]);
    if (!suites->count)
        printf("  (none found)\n");
}

/* Everything on one page: a comparison with all that it can do. */
static int write_page(int argc, char **argv)
{
    static char *const words[] = {"compare",  "builtin:all", "--methods", "all", "--series",
                                  "--motion", "--curves",    "--papers",  "-s",  "400x300"};
    const int count = sizeof(words) / sizeof(words[0]);
    char **line = calloc((size_t)(count + argc), sizeof(*line));
    if (!line)
        return cli_error("memory", "none left");
    memcpy(line, words, sizeof(words));
    memcpy(line + count, argv + 2, (size_t)(argc - 2) * sizeof(*line));
    int result = command_compare(count + argc - 2, line);
    free(line);
    return result;
}

static bool names_output(int argc, char **argv)
{
    bool found = false;
    for (int i = 2; i < argc; i++)
        found |= strncmp(argv[i], "-o", 2) == 0 || strncmp(argv[i], "--output", 8) == 0;
    return found;
}

int command_bench(int argc, char **argv)
{
    static const struct cli_command command = {
        .name = "bench",
        .operands = "[SUITE [ARGUMENT]...]",
        .summary = "Measurements; suites are named after what they measure",
        .options = CLI_JSON,
        .most_operands = 1,
        .text = help_text,
    };
    if (argc > 2 && strcmp(argv[1], "all") == 0 && names_output(argc, argv))
        return write_page(argc, argv);
    struct suites suites = {0};
    find_suites(&suites);

    /* A suite's name first: the rest is the suite's. */
    if (argc > 1 && argv[1][0] != '-' && strcmp(argv[1], "all") != 0) {
        const char *name = argv[1];
        for (size_t i = 0; i < suites.count; i++)
            if (strcmp(suites.names[i], name) == 0)
                return run_suite(&suites, name, argv + 1);
        return cli_usage_error("bench", name, "there is no such suite");
    }
    struct cli_options options;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON) {
        if (result == CLI_EXIT_DONE)
            for (int i = 1; i < argc; i++)
                if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
                    print_suites(&suites);
                    break;
                }
        return result;
    }
    char json[] = "--json", *arguments[3] = {NULL, options.json ? json : NULL, NULL};
    if (options.operand_count && strcmp(options.operands[0], "all") != 0)
        result =
            cli_usage_error("bench", "command line", "the suite's name stands before its options");
    else
        result = run_all(&suites, arguments, options.json);
    cli_options_finish(&options);
    return result;
}
