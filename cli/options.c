/* cli/options.c: reads and explains command lines.
 *
 * Long options take their value as the next argument or after '='; letters as the next argument or
 * attached (-s640x480); letters without a value may be joined (-qh). "--" ends the options. Names
 * are never abbreviated. Of an option that may be given once, the last one counts.
 */
#define _GNU_SOURCE
#include "options.h"

#include <errno.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define SIZE_MAX_PX    65536
#define PIXELS_MAX     (1L << 28)
#define SAMPLES_MAX    (1L << 20)
#define THREADS_MAX    256
#define HELP_COLUMN    28
#define NEAR_NAMES_MAX 128

struct shared_option {
    unsigned bit; /* 0: every command has it */
    char letter;  /* 0: none */
    const char *name, *value_name, *help;
};

static const struct shared_option shared_options[] = {
    {CLI_METHOD, 'm', "method", "NAME", "the shadow method; 'penumbra methods' lists them"},
    {CLI_METHODS, 0, "methods", "A,B|all",
     "several methods, separated by commas; A:64 with 64 light samples,\n"
     "                            A:64:KEY=VALUE with parameters of its own"},
    {CLI_OUTPUT, 'o', "output", "PATH", NULL},
    {CLI_SIZE, 's', "size", "WxH", "pixels of the picture (default 800x600)"},
    {CLI_LIGHT, 0, "light", "'SPEC'",
     "a light as in a scene file, in JSON; repeatable; replaces the scene's lights"},
    {CLI_LIGHT_INDEX, 0, "light-index", "N", "which light, from 0 (default 0)"},
    {CLI_SAMPLES, 'n', "samples", "N", "light samples of methods that sample"},
    {CLI_PARAM, 'p', "param", "KEY=VALUE",
     "a method's own parameter; repeatable; 'penumbra methods NAME' lists them"},
    {CLI_VISIBILITY, 0, "visibility", "FILE",
     "also write the visibility of light --light-index; repeatable; .pfm, .exr, .png"},
    {CLI_IMAGE, 0, "image", "FILE", "another program's result; repeatable; .png, .exr, .pfm"},
    {CLI_THREADS, 0, "threads", "N", "threads that work (default: one per processor)"},
    {CLI_JSON, 0, "json", NULL, "results on standard output as JSON"},
    {CLI_QUIET, 'q', "quiet", NULL, "no warnings, no progress bar"},
    {0, 'h', "help", NULL, "this text"},
    {0, 0, "version", NULL, "the version"},
};
#define SHARED_COUNT (sizeof(shared_options) / sizeof(shared_options[0]))

/* One line whatever the texts hold. */
static void print_error_line(const char *text)
{
    char line[1200];
    size_t used = 0;
    for (; *text && used + 1 < sizeof(line); text++)
        line[used++] = (unsigned char)*text < 0x20 || *text == 0x7f ? '?' : *text;
    line[used] = 0;
    fprintf(stderr, "penumbra: error: %s\n", line);
}

int cli_usage_error(const char *command, const char *what, const char *why, ...)
{
    char reason[700], text[1100];
    va_list arguments;
    va_start(arguments, why);
    vsnprintf(reason, sizeof(reason), why, arguments);
    va_end(arguments);
    snprintf(text, sizeof(text), "%.250s: %s (see 'penumbra%s%.40s --help')", what, reason,
             command ? " " : "", command ? command : "");
    print_error_line(text);
    return CLI_EXIT_USAGE;
}

int cli_error(const char *what, const char *why, ...)
{
    char reason[500], text[1100];
    va_list arguments;
    va_start(arguments, why);
    vsnprintf(reason, sizeof(reason), why, arguments);
    va_end(arguments);
    snprintf(text, sizeof(text), "%.590s: %s", what, reason);
    print_error_line(text);
    return CLI_EXIT_FAILED;
}

bool cli_read_integer(const char *command, const char *option, const char *text, long minimum,
                      long maximum, long *out_value)
{
    char *end;
    errno = 0;
    long value = strtol(text, &end, 10);
    bool digits =
        (text[0] >= '0' && text[0] <= '9') || (text[0] == '-' && text[1] >= '0' && text[1] <= '9');
    if (!digits || *end) {
        cli_usage_error(command, option, "'%.100s' is not a whole number", text);
        return false;
    }
    if (errno == ERANGE || value < minimum || value > maximum) {
        cli_usage_error(command, option, "%.100s is not between %ld and %ld", text, minimum,
                        maximum);
        return false;
    }
    *out_value = value;
    return true;
}

/* Levenshtein distance of short words; long ones count as far. */
static size_t word_distance(const char *a, const char *b)
{
    size_t row[64], length_a = strlen(a), length_b = strlen(b);
    if (length_a >= 64 || length_b >= 64)
        return 64;
    for (size_t j = 0; j <= length_b; j++)
        row[j] = j;
    for (size_t i = 1; i <= length_a; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= length_b; j++) {
            size_t change = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            if (row[j] + 1 < change)
                change = row[j] + 1;
            if (row[j - 1] + 1 < change)
                change = row[j - 1] + 1;
            row[j] = change;
        }
    }
    return row[length_b];
}

const char *cli_nearest(const char *text, const char *const *names, size_t count)
{
    const char *best = NULL;
    size_t least = strlen(text) < 4 ? 2 : 3; /* distances below this are near */
    for (size_t i = 0; i < count; i++) {
        size_t distance = word_distance(text, names[i]);
        if (distance < least) {
            least = distance;
            best = names[i];
        }
    }
    return best;
}

bool cli_has_ending(const char *path, const char *endings)
{
    size_t length = strlen(path);
    while (*endings) {
        size_t size = strcspn(endings, " ");
        if (length > size && strncasecmp(path + length - size, endings, size) == 0)
            return true;
        endings += size;
        endings += strspn(endings, " ");
    }
    return false;
}

/* ---- help ---- */

static void print_help_entry(char letter, const char *name, const char *value_name,
                             const char *help)
{
    int width = letter ? printf("  -%c, --%s", letter, name) : printf("      --%s", name);
    if (value_name)
        width += printf(" %s", value_name);
    if (width >= HELP_COLUMN) {
        printf("\n");
        width = 0;
    }
    printf("%*s%s\n", HELP_COLUMN - width, "", help);
}

static void print_help(const struct cli_command *command)
{
    printf("usage: penumbra %s%s%s [OPTION]...\n\n%s.\n\noptions\n", command->name,
           *command->operands ? " " : "", command->operands, command->summary);
    for (size_t i = 0; i < command->extra_count; i++)
        print_help_entry(0, command->extras[i].name, command->extras[i].value_name,
                         command->extras[i].help);
    for (size_t i = 0; i < SHARED_COUNT; i++) {
        const struct shared_option *option = &shared_options[i];
        if (!option->bit || (command->options & option->bit))
            print_help_entry(option->letter, option->name, option->value_name,
                             option->help ? option->help : command->output_help);
    }
    if (command->text)
        printf("\n%s", command->text);
}

/* ---- reading ---- */

static bool read_size(struct cli_options *options, const char *text)
{
    const char *command = options->command->name;
    long size[2] = {0, 0};
    const char *at = text;
    bool good = true;
    for (int i = 0; i < 2 && good; i++) {
        char *end = NULL;
        good = *at >= '0' && *at <= '9';
        errno = 0;
        if (good)
            size[i] = strtol(at, &end, 10);
        good = good && (i == 0 ? *end == 'x' || *end == 'X' : *end == 0);
        if (good)
            at = end + 1;
    }
    if (!good) {
        cli_usage_error(command, "--size", "'%.100s' is not WxH, as in 800x600", text);
        return false;
    }
    if (size[0] < 1 || size[1] < 1 || size[0] > SIZE_MAX_PX || size[1] > SIZE_MAX_PX ||
        size[0] * size[1] > PIXELS_MAX) {
        cli_usage_error(command, "--size",
                        "%.60s is out of range: each side 1 to %d, at most %ld pixels", text,
                        SIZE_MAX_PX, PIXELS_MAX);
        return false;
    }
    options->width = (int)size[0];
    options->height = (int)size[1];
    options->size_given = true;
    return true;
}

static bool word_in(const char *word, const char *choices)
{
    size_t length = strlen(word);
    while (choices) {
        size_t size = strcspn(choices, "|");
        if (size == length && memcmp(word, choices, size) == 0)
            return true;
        choices = choices[size] ? choices + size + 1 : NULL;
    }
    return false;
}

static int check_param_value(const char *command, const pnb_param_info *info, const char *value)
{
    char what[80];
    snprintf(what, sizeof(what), "--param %.60s", info->key);
    if (info->type == PNB_PARAM_TEXT)
        return CLI_GO_ON;
    if (info->type == PNB_PARAM_CHOICE) {
        if (word_in(value, info->choices))
            return CLI_GO_ON;
        return cli_usage_error(command, what, "'%.60s' is none of %.200s", value, info->choices);
    }
    double number;
    bool whole = info->type == PNB_PARAM_INTEGER;
    if (!pnb_param_number(value, &number) || (whole && number != floor(number)))
        return cli_usage_error(command, what, "'%.60s' is not a %s", value,
                               whole ? "whole number" : "number");
    if (number < info->minimum || number > info->maximum)
        return cli_usage_error(command, what, "%.60s is not between %g and %g", value,
                               info->minimum, info->maximum);
    return CLI_GO_ON;
}

static const pnb_param_info *find_param(const pnb_method_info *method, const char *key)
{
    for (size_t i = 0; method && i < method->param_count; i++)
        if (strcmp(method->params[i].key, key) == 0)
            return &method->params[i];
    return NULL;
}

static const pnb_method_info *find_method(const char *command, const char *option, const char *name)
{
    const pnb_method_info *info = pnb_method_find(name);
    if (info)
        return info;
    const char *names[NEAR_NAMES_MAX];
    size_t count = 0;
    for (size_t i = 0; i < pnb_method_count() && count < NEAR_NAMES_MAX; i++)
        names[count++] = pnb_method(i)->name;
    const char *nearest = cli_nearest(name, names, count);
    cli_usage_error(command, option,
                    "there is no method '%.60s'; %s%s%s'penumbra methods' lists them", name,
                    nearest ? "did you mean '" : "", nearest ? nearest : "", nearest ? "'? " : "");
    return NULL;
}

static void finish_choice(struct cli_choice *choice)
{
    for (size_t i = 0; i < choice->param_count; i++) {
        free((char *)choice->params[i].key);
        free((char *)choice->params[i].value);
    }
    free(choice->params);
}

static bool say_no_memory(void)
{
    cli_error("memory", "none left");
    return false;
}

/* One word after a colon: "64", "n=64", "placement=border". */
static bool add_setting(struct cli_choice *choice, const char *command, const pnb_method_info *info,
                        const char *word, size_t length)
{
    char text[256];
    snprintf(text, sizeof(text), "%.*s", (int)length, word);
    char *equals = strchr(text, '=');
    const char *number = !equals ? text : strncmp(text, "n=", 2) == 0 ? text + 2 : NULL;
    if (number) {
        long samples;
        if (!cli_read_integer(command, "--methods", number, 1, SAMPLES_MAX, &samples))
            return false;
        if (!info->samples) {
            cli_usage_error(command, "--methods", "%s takes no number of samples", info->name);
            return false;
        }
        choice->samples = (int)samples;
        return true;
    }
    *equals = 0;
    const pnb_param_info *param = find_param(info, text);
    if (!param) {
        cli_usage_error(command, "--methods",
                        "%s has no parameter '%.60s'; 'penumbra methods %s' lists them", info->name,
                        text, info->name);
        return false;
    }
    if (check_param_value(command, param, equals + 1) != CLI_GO_ON)
        return false;
    pnb_solver_param *grown =
        realloc(choice->params, (choice->param_count + 1) * sizeof(*choice->params));
    if (!grown)
        return say_no_memory();
    choice->params = grown;
    grown[choice->param_count] = (pnb_solver_param){strdup(text), strdup(equals + 1)};
    if (!grown[choice->param_count].key || !grown[choice->param_count].value)
        return say_no_memory();
    choice->param_count++;
    return true;
}

/* An entry of --methods, length bytes long. */
static bool add_method(struct cli_options *options, const char *option, const char *entry,
                       size_t length)
{
    const char *command = options->command->name, *end = entry + length;
    size_t size = strcspn(entry, ":,");
    char name[128];
    snprintf(name, sizeof(name), "%.*s", (int)(size < length ? size : length), entry);
    const pnb_method_info *info = find_method(command, option, name);
    if (!info)
        return false;
    struct cli_choice choice = {.method = info->name}, *grown = NULL;
    for (const char *at = entry + size; at < end;) {
        at++;
        size = strcspn(at, ":,");
        if (!add_setting(&choice, command, info, at, size)) {
            finish_choice(&choice);
            return false;
        }
        at += size;
    }
    int used = snprintf(choice.label, sizeof(choice.label), "%s", info->name);
    if (choice.samples)
        used += snprintf(choice.label + used, sizeof(choice.label) - (size_t)used, ":%d",
                         choice.samples);
    for (size_t i = 0; i < choice.param_count && (size_t)used < sizeof(choice.label); i++)
        used += snprintf(choice.label + used, sizeof(choice.label) - (size_t)used, ":%s=%s",
                         choice.params[i].key, choice.params[i].value);
    if ((size_t)used >= sizeof(choice.label)) {
        finish_choice(&choice);
        cli_usage_error(command, option, "'%.60s...' is too long", entry);
        return false;
    }
    for (size_t i = 0; i < options->choice_count; i++)
        if (strcmp(options->choices[i].label, choice.label) == 0) {
            finish_choice(&choice);
            return true;
        }
    grown = realloc(options->choices, (options->choice_count + 1) * sizeof(*grown));
    if (!grown) {
        finish_choice(&choice);
        return say_no_memory();
    }
    options->choices = grown;
    grown[options->choice_count++] = choice;
    return true;
}

bool cli_knows_entry(const char *entry, size_t length)
{
    const pnb_method_info *info = NULL;
    bool known = true;
    for (size_t at = 0; at < length && known; at++) {
        size_t size = strcspn(entry + at, ":=,");
        char word[128];
        if (at + size > length)
            size = length - at;
        snprintf(word, sizeof(word), "%.*s", (int)size, entry + at);
        if (at == 0) {
            info = pnb_method_find(word);
            known = info != NULL;
        } else if (entry[at + size] == '=' && strcmp(word, "n") != 0) {
            known = find_param(info, word) != NULL;
            size += strcspn(entry + at + size, ":,");
        }
        at += size;
    }
    return known && info;
}

bool cli_add_methods(struct cli_options *options, const char *list)
{
    for (const char *entry = list;; entry++) {
        size_t length = strcspn(entry, ",");
        if (length == 3 && strncmp(entry, "all", 3) == 0) {
            options->all_methods = true;
            for (size_t i = 0; i < pnb_method_count(); i++)
                if (!add_method(options, "--methods", pnb_method(i)->name,
                                strlen(pnb_method(i)->name)))
                    return false;
        } else if (!add_method(options, "--methods", entry, length)) {
            return false;
        }
        entry += length;
        if (!*entry)
            return true;
    }
}

static bool add_param(struct cli_options *options, char *text)
{
    char *equals = strchr(text, '=');
    if (!equals || equals == text) {
        cli_usage_error(options->command->name, "--param", "'%.100s' is not KEY=VALUE", text);
        return false;
    }
    *equals = 0;
    options->params[options->param_count++] = (pnb_solver_param){text, equals + 1};
    return true;
}

/* Takes one option with its value. CLI_GO_ON, or the exit status. */
static int take_shared(struct cli_options *options, const struct shared_option *option, char *value)
{
    const struct cli_command *command = options->command;
    long number = 0;
    bool good = true;
    switch (option->bit) {
    case 0:
        if (option->letter == 'h')
            print_help(command);
        else
            printf("penumbra %s\n", pnb_version());
        return CLI_EXIT_DONE;
    case CLI_METHOD:
        /* A name alone: settings are -n and -p. */
        good = find_method(command->name, "--method", value) != NULL;
        if (good) {
            options->method = pnb_method_find(value)->name;
            good = add_method(options, "--method", value, strlen(value));
        }
        break;
    case CLI_METHODS: good = cli_add_methods(options, value); break;
    case CLI_SIZE: good = read_size(options, value); break;
    case CLI_LIGHT: options->lights[options->light_count++] = value; break;
    case CLI_LIGHT_INDEX:
        good = cli_read_integer(command->name, "--light-index", value, 0, 1000000, &number);
        options->light_index = (size_t)number;
        break;
    case CLI_SAMPLES:
        good = cli_read_integer(command->name, "--samples", value, 1, SAMPLES_MAX, &number);
        options->samples = (int)number;
        break;
    case CLI_PARAM: good = add_param(options, value); break;
    case CLI_VISIBILITY:
        good = cli_has_ending(value, ".pfm .exr .png");
        if (!good)
            cli_usage_error(command->name, "--visibility",
                            "'%.200s' ends in none of .pfm .exr .png", value);
        options->visibilities[options->visibility_count++] = value;
        break;
    case CLI_IMAGE: options->images[options->image_count++] = value; break;
    case CLI_THREADS:
        good = cli_read_integer(command->name, "--threads", value, 1, THREADS_MAX, &number);
        options->threads = (int)number;
        break;
    case CLI_JSON: options->json = true; break;
    case CLI_QUIET: options->quiet = true; break;
    case CLI_OUTPUT:
        good = *value;
        if (!good)
            cli_usage_error(command->name, "--output", "the path is empty");
        options->output = value;
        break;
    }
    return good ? CLI_GO_ON : CLI_EXIT_USAGE;
}

static bool offers(const struct cli_command *command, const struct shared_option *option)
{
    return !option->bit || (command->options & option->bit);
}

static int unknown_option(const struct cli_command *command, const char *name)
{
    const char *names[NEAR_NAMES_MAX];
    size_t count = 0;
    for (size_t i = 0; i < SHARED_COUNT; i++)
        if (offers(command, &shared_options[i]))
            names[count++] = shared_options[i].name;
        else if (strcmp(name, shared_options[i].name) == 0)
            return cli_usage_error(command->name, "command line", "%s does not take --%s",
                                   command->name, name);
    for (size_t i = 0; i < command->extra_count && count < NEAR_NAMES_MAX; i++)
        names[count++] = command->extras[i].name;
    const char *nearest = cli_nearest(name, names, count);
    return cli_usage_error(command->name, "command line", "unknown option --%.100s%s%s%s", name,
                           nearest ? "; did you mean --" : "", nearest ? nearest : "",
                           nearest ? "?" : "");
}

/* argv[*at] begins with "--". Moves *at to the last argument that it used. */
static int read_long(struct cli_options *options, int argc, char **argv, int *at)
{
    const struct cli_command *command = options->command;
    char name[64], shown[68];
    char *text = argv[*at] + 2, *equals = strchr(text, '=');
    size_t length = equals ? (size_t)(equals - text) : strlen(text);
    if (length >= sizeof(name))
        return unknown_option(command, text);
    memcpy(name, text, length);
    name[length] = 0;
    snprintf(shown, sizeof(shown), "--%s", name);

    const struct shared_option *option = NULL;
    const struct cli_extra *extra = NULL;
    for (size_t i = 0; i < SHARED_COUNT && !option; i++)
        if (offers(command, &shared_options[i]) && strcmp(name, shared_options[i].name) == 0)
            option = &shared_options[i];
    for (size_t i = 0; i < command->extra_count && !option && !extra; i++)
        if (strcmp(name, command->extras[i].name) == 0)
            extra = &command->extras[i];
    if (!option && !extra)
        return unknown_option(command, name);

    const char *value_name = option ? option->value_name : extra->value_name;
    char *value = equals ? equals + 1 : NULL;
    if (!value_name && value)
        return cli_usage_error(command->name, shown, "takes no value");
    if (value_name && !value) {
        if (*at + 1 >= argc)
            return cli_usage_error(command->name, shown, "needs a value: %s", value_name);
        value = argv[++*at];
    }
    if (option)
        return take_shared(options, option, value);
    *extra->value = value ? value : "";
    return CLI_GO_ON;
}

/* argv[*at] is a '-' with letters after it. */
static int read_letters(struct cli_options *options, int argc, char **argv, int *at)
{
    const struct cli_command *command = options->command;
    for (char *letter = argv[*at] + 1; *letter; letter++) {
        char shown[3] = {'-', *letter, 0};
        const struct shared_option *option = NULL;
        for (size_t i = 0; i < SHARED_COUNT && !option; i++)
            if (offers(command, &shared_options[i]) && shared_options[i].letter == *letter)
                option = &shared_options[i];
        if (!option)
            return cli_usage_error(command->name, "command line", "unknown option %s in '%.60s'",
                                   shown, argv[*at]);
        char *value = NULL;
        if (option->value_name) {
            if (letter[1])
                value = letter + 1;
            else if (*at + 1 < argc)
                value = argv[++*at];
            else
                return cli_usage_error(command->name, shown, "needs a value: %s",
                                       option->value_name);
        }
        int result = take_shared(options, option, value);
        if (result != CLI_GO_ON || value)
            return result;
    }
    return CLI_GO_ON;
}

/* ---- parameters of -p ---- */

/* Each parameter must belong to one of the methods asked for, and its value fit there. */
static int check_params(const struct cli_options *options)
{
    const struct cli_command *command = options->command;
    bool several = (command->options & CLI_METHODS) != 0;
    bool all = several && options->choice_count == 0;
    size_t count = all ? pnb_method_count() : several ? options->choice_count : 1;
    for (size_t p = 0; p < options->param_count; p++) {
        const char *key = options->params[p].key;
        bool known = false;
        const char *only = NULL;
        for (size_t m = 0; m < count; m++) {
            const char *name = all               ? pnb_method(m)->name
                               : several         ? options->choices[m].method
                               : options->method ? options->method
                               : command->method ? command->method
                                                 : pnb_default_method();
            const pnb_method_info *method = pnb_method_find(name);
            if (!method)
                return CLI_GO_ON; /* the library will say it */
            only = method->name;
            const pnb_param_info *info = find_param(method, key);
            if (!info)
                continue;
            known = true;
            int result = check_param_value(command->name, info, options->params[p].value);
            if (result != CLI_GO_ON)
                return result;
        }
        if (!known && count == 1)
            return cli_usage_error(command->name, "--param",
                                   "%s has no parameter '%.60s'; 'penumbra methods %s' lists them",
                                   only, key, only);
        if (!known)
            return cli_usage_error(command->name, "--param",
                                   "none of the methods has a parameter '%.60s'", key);
    }
    return CLI_GO_ON;
}

static int read_arguments(struct cli_options *options, int argc, char **argv)
{
    const struct cli_command *command = options->command;
    bool only_operands = false;
    for (int at = 1; at < argc; at++) {
        char *text = argv[at];
        int result = CLI_GO_ON;
        if (only_operands || text[0] != '-' || text[1] == 0) {
            if (*text == 0)
                return cli_usage_error(command->name, "command line", "an argument is empty");
            options->operands[options->operand_count++] = text;
        } else if (strcmp(text, "--") == 0) {
            only_operands = true;
        } else if (text[1] == '-') {
            result = read_long(options, argc, argv, &at);
        } else {
            result = read_letters(options, argc, argv, &at);
        }
        if (result != CLI_GO_ON)
            return result;
    }
    if (options->operand_count < command->least_operands)
        return cli_usage_error(command->name, "command line", "missing %s", command->operands);
    if (options->operand_count > command->most_operands)
        return cli_usage_error(command->name, "command line", "'%.200s' is one argument too many",
                               options->operands[command->most_operands]);
    return check_params(options);
}

int cli_options_init(const struct cli_command *command, int argc, char **argv,
                     struct cli_options *options)
{
    *options = (struct cli_options){.command = command, .width = 800, .height = 600};
    size_t room = (size_t)argc + 1;
    options->operands = calloc(room, sizeof(*options->operands));
    options->lights = calloc(room, sizeof(*options->lights));
    options->params = calloc(room, sizeof(*options->params));
    options->visibilities = calloc(room, sizeof(*options->visibilities));
    options->images = calloc(room, sizeof(*options->images));
    int result;
    if (!options->operands || !options->lights || !options->params || !options->images ||
        !options->visibilities)
        result = cli_error("memory", "none left");
    else
        result = read_arguments(options, argc, argv);
    if (result != CLI_GO_ON)
        cli_options_finish(options);
    return result;
}

void cli_options_finish(struct cli_options *options)
{
    free(options->operands);
    free(options->lights);
    free(options->params);
    free(options->images);
    free(options->visibilities);
    for (size_t i = 0; i < options->choice_count; i++)
        finish_choice(&options->choices[i]);
    free(options->choices);
    *options = (struct cli_options){0};
}
