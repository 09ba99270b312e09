/* cli/main.c: the front door: finds the command and hands over the rest of the line. */
#define _GNU_SOURCE
#include "commands.h"
#include "session.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct entry {
    const char *name, *operands, *summary;
    int (*run)(int argc, char **argv);
};

static const struct entry entries[] = {
    {"render", "SCENE", "one picture, shaded, with shadows", command_render},
    {"compare", "SCENE... -o DIR", "methods against the truth: a page and a report",
     command_compare},
    {"shadow", "SCENE", "the shadow on a plane as geometry: SVG, PDF, GLB, ...", command_shadow},
    {"bench", "[SUITE]", "measurements", command_bench},
    {"view", "[SCENE]", "a window: drag the light and watch", command_view},
    {"info", "SCENE", "what is in a scene, and what each method can do with it", command_info},
    {"methods", "[NAME]", "the shadow methods and their parameters", command_methods},
    {"scenes", "", "the built-in scenes", command_scenes},
};
#define ENTRY_COUNT (sizeof(entries) / sizeof(entries[0]))

static void print_help(void)
{
    printf("usage: penumbra COMMAND [ARGUMENT]...\n\n"
           "Soft shadows from area lights, and a ruler to judge them with.\n\ncommands\n");
    for (size_t i = 0; i < ENTRY_COUNT; i++) {
        int width = printf("  %s %s", entries[i].name, entries[i].operands);
        printf("%*s%s\n", 28 - width, "", entries[i].summary);
    }
    printf("\nEach command answers --help and --version.\n\n"
           "SCENE is a scene file (.json), a mesh or scene (.glb .gltf .obj .ply .stl ...), or\n"
           "builtin:NAME. What a bare mesh lacks (ground, light, camera) is supplied.\n\n"
           "examples\n"
           "  penumbra render builtin:prism -o prism.png\n"
           "  penumbra render cow.obj -m reference -n 256 --visibility cow.pfm --json\n"
           "  penumbra compare builtin:fence --methods all -o report\n"
           "  penumbra info scene.glb\n"
           "  penumbra scenes --write scenes\n\n"
           "exit status: 0 done, 1 the work failed, 2 the command line is wrong\n");
}

static const struct entry *find_entry(const char *name)
{
    for (size_t i = 0; i < ENTRY_COUNT; i++)
        if (strcmp(entries[i].name, name) == 0)
            return &entries[i];
    return NULL;
}

static int unknown_command(const char *name)
{
    const char *names[ENTRY_COUNT];
    for (size_t i = 0; i < ENTRY_COUNT; i++)
        names[i] = entries[i].name;
    const char *nearest = cli_nearest(name, names, ENTRY_COUNT);
    return cli_usage_error(NULL, "command line", "there is no %s '%.100s'%s%s%s",
                           name[0] == '-' ? "option" : "command", name,
                           nearest ? "; did you mean '" : "", nearest ? nearest : "",
                           nearest ? "'?" : "");
}

/* A closed standard stream would let the next file take its number, and be overwritten by what is
 * printed: open it the wrong way round, so that using it fails as it should. */
static void hold_standard_streams(void)
{
    for (int number = 0; number <= 2; number++)
        if (fcntl(number, F_GETFD) == -1)
            (void)!open("/dev/null", number == 0 ? O_WRONLY : O_RDONLY);
}

int main(int argc, char **argv)
{
    hold_standard_streams();
    /* A closed pipe or a file over its limit is an error of that write, not the end. */
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);

    if (argc < 2)
        return cli_usage_error(NULL, "command line", "a command is missing");
    const char *name = argv[1];
    bool help = strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0;
    if (help || strcmp(name, "--version") == 0) {
        if (argc > 2)
            return cli_usage_error(NULL, "command line", "'%.200s' is one argument too many",
                                   argv[2]);
        if (help)
            print_help();
        else
            printf("penumbra %s\n", pnb_version());
        return cli_flush();
    }
    const struct entry *entry = find_entry(name);
    if (!entry)
        return unknown_command(name);
    int result = entry->run(argc - 1, argv + 1);
    int flushed = ferror(stdout) ? CLI_EXIT_DONE : cli_flush();
    return result != CLI_EXIT_DONE ? result : flushed;
}
