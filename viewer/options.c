/* viewer/options.c: the command line of penumbra-view. Mistakes end in one line and status 2. */
#include "options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char help_text[] =
    "usage: penumbra-view [SCENE] [OPTION]...\n\n"
    "The window of 'penumbra view'; that command explains the options:\n"
    "  -m NAME [-n N] [-p KEY=VALUE]..., twice for two methods, --light SPEC, -s WxH, --threads "
    "N,\n"
    "  --script NAME|FILE, --frames N, --full-size, --json, -q\n";

void view_complain(const char *what, const char *why)
{
    char line[1200];
    snprintf(line, sizeof(line), "%.500s: %.600s", what, why);
    for (char *c = line; *c; c++)
        if ((unsigned char)*c < 0x20)
            *c = '?';
    fprintf(stderr, "penumbra: error: %s\n", line);
}

static bool add_method(struct view_options *options, const char *name)
{
    if (!pnb_method_find(name)) {
        view_complain(name, "there is no such method; 'penumbra methods' lists them");
        return false;
    }
    if (options->method_count == VIEW_METHODS_MAX) {
        view_complain("-m", "the window shows two methods at most");
        return false;
    }
    options->choices[options->method_count++].method = pnb_method_find(name)->name;
    return true;
}

static bool read_number(const char *option, const char *text, long least, long most, int *out)
{
    char *end;
    long value = strtol(text, &end, 10);
    if (!*text || *end || value < least || value > most) {
        view_complain(option, "is not a whole number in range");
        return false;
    }
    *out = (int)value;
    return true;
}

static bool take(struct view_options *options, const char *option, char *value)
{
    if (strcmp(option, "-m") == 0 || strcmp(option, "--method") == 0)
        return add_method(options, value);
    struct view_choice *choice =
        &options->choices[options->method_count > 0 ? options->method_count - 1 : 0];
    if (strcmp(option, "-n") == 0 || strcmp(option, "--samples") == 0)
        return read_number(option, value, 1, 1 << 20, &choice->samples);
    if (strcmp(option, "-p") == 0 || strcmp(option, "--param") == 0) {
        if (!strchr(value, '=')) {
            view_complain(option, "wants KEY=VALUE");
            return false;
        }
        choice->params[choice->param_count++] = value;
        return true;
    }
    if (strcmp(option, "--light") == 0) {
        options->lights[options->light_count++] = value;
        return true;
    }
    if (strcmp(option, "-s") == 0 || strcmp(option, "--size") == 0) {
        options->size_given = true;
        char tail;
        if (sscanf(value, "%dx%d%c", &options->width, &options->height, &tail) == 2 &&
            options->width >= 64 && options->height >= 64 && options->width <= 8192 &&
            options->height <= 8192)
            return true;
        view_complain(option, "wants WxH, each between 64 and 8192");
        return false;
    }
    if (strcmp(option, "--threads") == 0)
        return read_number(option, value, 1, 256, &options->threads);
    if (strcmp(option, "--frames") == 0)
        return read_number(option, value, 1, 100000000, &options->frames);
    if (strcmp(option, "--script") == 0) {
        options->script = value;
        return true;
    }
    view_complain(option, "there is no such option (see penumbra view --help)");
    return false;
}

static bool take_flag(struct view_options *options, const char *option)
{
    if (strcmp(option, "--json") == 0)
        options->json = true;
    else if (strcmp(option, "--full-size") == 0)
        options->full_size = true;
    else if (strcmp(option, "-q") == 0 || strcmp(option, "--quiet") == 0)
        options->quiet = true;
    else
        return false;
    return true;
}

bool view_options_read(struct view_options *options, int argc, char **argv, int *exit_status)
{
    *options = (struct view_options){.width = 800, .height = 600, .frames = 300};
    bool good = true;
    for (int i = 0; i < VIEW_METHODS_MAX; i++) {
        options->choices[i].params = calloc((size_t)argc + 1, sizeof(char *));
        good = good && options->choices[i].params;
    }
    options->lights = calloc((size_t)argc + 1, sizeof(*options->lights));
    *exit_status = 2;
    if (!good || !options->lights)
        return false;
    for (int i = 1; i < argc; i++) {
        char *text = argv[i];
        if (strcmp(text, "--help") == 0 || strcmp(text, "--version") == 0) {
            printf("%s%s", text[2] == 'h' ? help_text : "penumbra ",
                   text[2] == 'h' ? "" : pnb_version());
            printf("%s", text[2] == 'h' ? "" : "\n");
            *exit_status = 0;
            return false;
        }
        if (text[0] != '-' || !text[1]) {
            if (options->scene) {
                view_complain(text, "is one argument too many");
                return false;
            }
            options->scene = text;
            continue;
        }
        if (take_flag(options, text))
            continue;
        char option[32] = "", *equals = text[1] == '-' ? strchr(text, '=') : NULL;
        snprintf(option, sizeof(option), "%.*s",
                 equals ? (int)(equals - text) : (int)sizeof(option) - 1, text);
        char *value = equals ? equals + 1 : i + 1 < argc ? argv[++i] : NULL;
        if (!value) {
            view_complain(option, "a value is missing");
            return false;
        }
        if (!take(options, option, value))
            return false;
    }
    return true;
}

void view_options_finish(struct view_options *options)
{
    for (int i = 0; i < VIEW_METHODS_MAX; i++)
        free(options->choices[i].params);
    free(options->lights);
}
