/* cli/compare.c: 'penumbra compare': several methods, and files of other programs, against the
 * truth; a page for people and a report for programs.
 *
 *   per scene: compare_scene_run() -> section of the page, object of the report
 *   at the end: both files, under temporary names, then renamed together
 */
#define _GNU_SOURCE
#include "compare.h"

#include "commands.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#define TRUTH_SAMPLES     4096
#define TRUTH_SAMPLES_MAX (1L << 18) /* what the reference takes */

static const char help_text[] =
    "Writes DIR/index.html (pictures, error maps, table, plot; one file, no network) and\n"
    "DIR/report.json. The truth is ray-traced with --truth-samples samples per pixel. Without\n"
    "--methods: every method that can do the light, reference at 16, 64, 256 and 1024 samples.\n"
    "Each method takes those of the -p parameters that it knows, and -n where NAME:SAMPLES says\n"
    "nothing else. A method asked for by name that cannot do the scene is an error, found at "
    "once;\n"
    "of several scenes it is left out of those that it cannot do.\n\n"
    "--image FILE: one channel is a visibility (in EXR: the channel visibility); three channels\n"
    "are a picture, judged by its luminance against the true picture (PNG is taken as sRGB). The\n"
    "size must be that of -s, the camera that of the scene; pixels that are NaN do not count.\n\n"
    "examples\n"
    "  penumbra compare builtin:fence -o report\n"
    "  penumbra compare cow.obj builtin:knot --methods pcss,wedge-blend -s 640x480 -o report\n"
    "  penumbra compare cow.obj --methods reference:16,reference:64 --truth-samples 16384 -o r\n"
    "  penumbra compare scene.json --image cycles.exr --image other-visibility.pfm -o report\n";

static const char *truth_samples_text;

static const struct cli_extra extras[] = {
    {"truth-samples", "N", "light samples of the truth (default 4096)", &truth_samples_text},
};

static const struct cli_command command = {
    .name = "compare",
    .operands = "SCENE...",
    .summary = "Methods against the truth: pictures, error maps, figures, times",
    .options = CLI_METHOD | CLI_METHODS | CLI_OUTPUT | CLI_SIZE | CLI_LIGHT | CLI_LIGHT_INDEX |
               CLI_SAMPLES | CLI_PARAM | CLI_IMAGE | CLI_THREADS | CLI_JSON | CLI_QUIET,
    .extras = extras,
    .extra_count = sizeof(extras) / sizeof(extras[0]),
    .least_operands = 1,
    .most_operands = 1000,
    .output_help = "the folder of the page and the report; made if missing",
    .text = help_text,
};

static int no_memory(void)
{
    return cli_error("memory", "none left");
}

/* ---- input and output ---- */

static int read_images(struct cli_session *session, pnb_image *images)
{
    const struct cli_options *options = session->options;
    for (size_t i = 0; i < options->image_count; i++) {
        const char *path = options->images[i];
        if (pnb_image_read(session->context, path, &images[i]) != PNB_OK)
            return cli_session_fail(session);
        if (images[i].width != options->width || images[i].height != options->height)
            return cli_error(path, "has %dx%d pixels, the comparison %dx%d; -s %dx%d would fit",
                             images[i].width, images[i].height, options->width, options->height,
                             images[i].width, images[i].height);
    }
    return CLI_GO_ON;
}

/* Before the work: can the folder be made, or be written into? */
static int check_folder(const char *folder)
{
    struct stat info;
    if (stat(folder, &info) == 0) {
        if (!S_ISDIR(info.st_mode))
            return cli_error(folder, "is a file, not a folder");
        return access(folder, W_OK | X_OK) == 0 ? CLI_GO_ON
                                                : cli_error(folder, "%s", strerror(errno));
    }
    char path[4096];
    if (snprintf(path, sizeof(path), "%s", folder) >= (int)sizeof(path))
        return cli_error(folder, "the path is too long");
    for (size_t n = strlen(path); n > 1 && path[n - 1] == '/'; n--)
        path[n - 1] = 0;
    return cli_check_writable(path);
}

/* Both files or neither: each whole under a name of its own first. */
static int write_both(struct cli_session *session, const char *folder, const char *page,
                      size_t page_size, const char *report, size_t report_size)
{
    const struct {
        const char *name, *bytes;
        size_t size;
    } files[2] = {{"report.json", report, report_size}, {"index.html", page, page_size}};
    char temporary[2][4200], target[2][4200];
    int written = 0, result = CLI_GO_ON;
    for (int i = 0; i < 2; i++) {
        snprintf(target[i], sizeof(target[i]), "%s/%s", folder, files[i].name);
        snprintf(temporary[i], sizeof(temporary[i]), "%s/.%s.%ld.new", folder, files[i].name,
                 (long)getpid());
        struct stat info;
        if (result == CLI_GO_ON && stat(target[i], &info) == 0 && S_ISDIR(info.st_mode))
            result = cli_error(target[i], "is a folder");
    }
    for (int i = 0; i < 2 && result == CLI_GO_ON; i++) {
        if (pnb_file_write(session->context, temporary[i], files[i].bytes, files[i].size) != PNB_OK)
            result = cli_session_fail(session);
        else
            written++;
    }
    for (int i = 0; i < 2 && result == CLI_GO_ON; i++)
        if (rename(temporary[i], target[i]) != 0)
            result = cli_error(target[i], "%s", strerror(errno));
    for (int i = 0; i < written && result != CLI_GO_ON; i++)
        unlink(temporary[i]);
    return result;
}

static int write_results(struct cli_session *session, const char *page, size_t page_size,
                         const char *report)
{
    const char *folder = session->options->output;
    bool made = access(folder, F_OK) != 0;
    int result = cli_make_folder(folder);
    if (result != CLI_GO_ON)
        return result;
    result = write_both(session, folder, page, page_size, report, strlen(report));
    if (result != CLI_GO_ON && made)
        rmdir(folder);
    return result;
}

static void print_table(const struct compare_scene *scene)
{
    printf("%s  %dx%d  light %zu (%s)  truth %d samples, %.0f ms\n", scene->path, scene->width,
           scene->height, scene->light_index, scene->light_type, scene->truth_samples,
           scene->truth_ms);
    printf("  %-24s %10s %9s %9s %9s %9s %9s\n", "method", "ms", "rmse", "mean", "p99", "leak",
           "darkening");
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        const pnb_errors *e = &entry->errors;
        char time[32] = "-";
        if (isfinite(entry->milliseconds))
            snprintf(time, sizeof(time), "%.2f", entry->milliseconds);
        printf("  %-24s %10s %9.5f %+9.5f %9.5f %8.3f%% %8.3f%%\n", entry->label, time, e->rmse,
               e->mean_error, e->p99_error, 100 * e->umbra_leak, 100 * e->lit_darkening);
    }
}

/* A word of a shell's command line, quoted where it must be. */
static void put_word(FILE *file, const char *word)
{
    if (*word && strspn(word, "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                              "_-./:=,+@%") == strlen(word)) {
        fputs(word, file);
        return;
    }
    fputc('\'', file);
    for (; *word; word++)
        if (*word == '\'')
            fputs("'\\''", file);
        else
            fputc(*word, file);
    fputc('\'', file);
}

static char *command_line(int argc, char **argv)
{
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    if (!file)
        return NULL;
    fputs("penumbra", file);
    for (int i = 0; i < argc; i++) {
        fputc(' ', file);
        put_word(file, argv[i]);
    }
    fclose(file);
    return text;
}

/* Before the work: can all scenes be read, and is there anything to compare in one of them? */
static int check_scenes(struct cli_session *session)
{
    const struct cli_options *options = session->options;
    size_t entries = 0;
    for (size_t i = 0; i < options->operand_count; i++) {
        struct compare_scene scene = {.path = options->operands[i]};
        int result = compare_scene_check(session, &scene);
        entries += scene.entry_count;
        compare_scene_finish(session->context, &scene);
        if (result != CLI_GO_ON)
            return result;
    }
    return entries > 0 ? CLI_GO_ON
                       : cli_error("compare", "no method is left: none can do any of the scenes");
}

static int run_all(struct cli_session *session, struct compare_run *run, const pnb_image *images,
                   int truth_samples)
{
    const struct cli_options *options = session->options;
    char *page_text = NULL, *report_text = NULL;
    size_t page_size = 0;
    FILE *page = open_memstream(&page_text, &page_size);
    json_t *scenes = json_array();
    int result = page && scenes ? CLI_GO_ON : no_memory();
    if (page)
        report_html_begin(page, run, options->operand_count);
    for (size_t i = 0; i < options->operand_count && result == CLI_GO_ON; i++) {
        struct compare_scene scene = {.path = options->operands[i]};
        result = compare_scene_run(session, images, truth_samples, &scene);
        if (result == CLI_GO_ON) {
            report_html_scene(page, run, &scene, i);
            json_array_append_new(scenes, report_json_scene(run, &scene));
            cli_session_clear_bar(session);
            if (!options->json && !options->quiet)
                print_table(&scene);
        }
        compare_scene_finish(session->context, &scene);
    }
    if (page) {
        report_html_end(page, run);
        if ((ferror(page) | fclose(page)) && result == CLI_GO_ON)
            result = no_memory();
    }
    json_t *report = report_json(run, scenes);
    if (result == CLI_GO_ON) {
        report_text = json_dumps(report, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        result =
            report_text ? write_results(session, page_text, page_size, report_text) : no_memory();
    }
    if (result == CLI_GO_ON && options->json)
        result = cli_json_print(json_incref(report));
    else if (result == CLI_GO_ON && !options->quiet)
        printf("%s/index.html\n", options->output);
    json_decref(report);
    free(report_text);
    free(page_text);
    return result == CLI_GO_ON ? CLI_EXIT_DONE : result;
}

static int check_line(const struct cli_options *options, long *truth_samples)
{
    if (!options->output)
        return cli_usage_error("compare", "command line", "missing -o DIR");
    if (options->image_count && options->operand_count > 1)
        return cli_usage_error("compare", "--image", "judges one scene; %zu are given",
                               options->operand_count);
    if (truth_samples_text && !cli_read_integer("compare", "--truth-samples", truth_samples_text, 1,
                                                TRUTH_SAMPLES_MAX, truth_samples))
        return CLI_EXIT_USAGE;
    return check_folder(options->output);
}

int command_compare(int argc, char **argv)
{
    /* Reading the options cuts some arguments into words. */
    char *line = command_line(argc, argv);
    struct cli_options options;
    truth_samples_text = NULL;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON) {
        free(line);
        return result;
    }
    struct cli_session session = {0};
    pnb_image *images = calloc(options.image_count + 1, sizeof(*images));
    long truth_samples = TRUTH_SAMPLES;
    result = images && line ? check_line(&options, &truth_samples) : no_memory();
    if (result == CLI_GO_ON)
        result = cli_session_init(&session, &options);
    if (result == CLI_GO_ON) {
        char date[64];
        time_t now = time(NULL);
        struct tm utc;
        strftime(date, sizeof(date), "%Y-%m-%d %H:%M UTC", gmtime_r(&now, &utc));
        struct compare_run run = {.command = line,
                                  .date = date,
                                  .threads = pnb_context_threads(session.context),
                                  .options = &options};
        char processor[256];
        snprintf(run.processor, sizeof(run.processor), "%s",
                 cli_device(NULL, processor, sizeof(processor)));
        if (truth_samples < 1024)
            cli_session_warn(&session, "the truth has fewer than 1024 samples: the figures "
                                       "contain its own noise");
        result = read_images(&session, images);
        if (result == CLI_GO_ON && options.operand_count > 1)
            result = check_scenes(&session);
        if (result == CLI_GO_ON)
            result = run_all(&session, &run, images, (int)truth_samples);
        for (size_t i = 0; i < options.image_count; i++)
            pnb_image_finish(session.context, &images[i]);
        cli_session_finish(&session);
    }
    free(images);
    free(line);
    cli_options_finish(&options);
    return result;
}
