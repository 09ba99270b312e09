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
    "  penumbra compare cow.obj --methods planar:8,planar:8:placement=border,exact -o r\n"
    "  penumbra compare builtin:all -s 400x300 -o report\n"
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
static int check_scenes(struct cli_session *session, const struct compare_run *run)
{
    size_t entries = 0;
    for (size_t i = 0; i < run->path_count; i++) {
        struct compare_scene scene = {.path = run->paths[i], .one_of_several = true};
        int result = compare_scene_check(session, &scene);
        entries += scene.entry_count;
        compare_scene_finish(session->context, &scene);
        if (result != CLI_GO_ON)
            return result;
    }
    return entries > 0 ? CLI_GO_ON
                       : cli_error("compare", "no method is left: none can do any of the scenes");
}

/* Everything that is measured, in the order of the page's parts; each writes its section. */
static int run_scenes(struct cli_session *session, struct compare_run *run, const pnb_image *images,
                      int truth_samples, FILE *body, json_t *scenes)
{
    const struct cli_options *options = session->options;
    int result = CLI_GO_ON;
    for (size_t i = 0; i < run->path_count && result == CLI_GO_ON; i++) {
        struct compare_scene *scene = &run->scenes[run->scene_count++];
        *scene =
            (struct compare_scene){.path = run->paths[i], .one_of_several = run->path_count > 1};
        result = compare_scene_run(session, images, truth_samples, scene);
        if (result != CLI_GO_ON)
            break;
        report_html_scene(body, run, scene, i);
        compare_scene_drop_pictures(session->context, scene);
        json_array_append_new(scenes, report_json_scene(run, scene));
        cli_session_clear_bar(session);
        if (!options->json && !options->quiet)
            print_table(scene);
    }
    return result;
}

static int run_all(struct cli_session *session, struct compare_run *run, const pnb_image *images,
                   int truth_samples)
{
    const struct cli_options *options = session->options;
    char *head_text = NULL, *body_text = NULL, *report_text = NULL;
    size_t head_size = 0, body_size = 0;
    FILE *head = open_memstream(&head_text, &head_size);
    FILE *body = open_memstream(&body_text, &body_size);
    json_t *scenes = json_array();
    run->scenes = calloc(run->path_count, sizeof(*run->scenes));
    int result = head && body && scenes && run->scenes ? CLI_GO_ON : no_memory();
    if (result == CLI_GO_ON)
        result = run_scenes(session, run, images, truth_samples, body, scenes);
    if (result == CLI_GO_ON) {
        report_html_begin(head, run);
        report_html_summary(head, run);
        report_html_end(body, run);
    }
    bool bad = head && (ferror(head) | fclose(head));
    bad |= body && (ferror(body) | fclose(body));
    if (bad && result == CLI_GO_ON)
        result = no_memory();
    json_t *report = report_json(run, scenes);
    if (result == CLI_GO_ON) {
        report_text = json_dumps(report, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        char *page = malloc(head_size + body_size);
        result = report_text && page ? CLI_GO_ON : no_memory();
        if (result == CLI_GO_ON) {
            memcpy(page, head_text, head_size);
            memcpy(page + head_size, body_text, body_size);
            result = write_results(session, page, head_size + body_size, report_text);
        }
        free(page);
    }
    if (result == CLI_GO_ON && options->json)
        result = cli_json_print(json_incref(report));
    else if (result == CLI_GO_ON && !options->quiet)
        printf("%s/index.html\n", options->output);
    json_decref(report);
    free(report_text);
    free(head_text);
    free(body_text);
    for (size_t i = 0; run->scenes && i < run->scene_count; i++)
        compare_scene_finish(session->context, &run->scenes[i]);
    free(run->scenes);
    return result == CLI_GO_ON ? CLI_EXIT_DONE : result;
}

/* "builtin:all" stands for every built-in scene. Paths are ours to free. */
static bool list_paths(const struct cli_options *options, struct compare_run *run)
{
    run->paths = calloc(options->operand_count * (pnb_builtin_count() + 1), sizeof(*run->paths));
    for (size_t i = 0; run->paths && i < options->operand_count; i++) {
        bool all = strcmp(options->operands[i], "builtin:all") == 0;
        for (size_t k = 0; k < (all ? pnb_builtin_count() : 1); k++) {
            pnb_builtin_info info;
            char path[300];
            pnb_builtin(k, &info);
            snprintf(path, sizeof(path), "builtin:%s", info.name);
            run->paths[run->path_count] = strdup(all ? path : options->operands[i]);
            if (!run->paths[run->path_count])
                return false;
            run->path_count++;
        }
    }
    return run->paths != NULL;
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
        if (result == CLI_GO_ON && !list_paths(&options, &run))
            result = no_memory();
        if (result == CLI_GO_ON && run.path_count > 1)
            result = check_scenes(&session, &run);
        if (result == CLI_GO_ON)
            result = run_all(&session, &run, images, (int)truth_samples);
        for (size_t i = 0; i < options.image_count; i++)
            pnb_image_finish(session.context, &images[i]);
        for (size_t i = 0; i < run.path_count; i++)
            free(run.paths[i]);
        free(run.paths);
        cli_session_finish(&session);
    }
    free(images);
    free(line);
    cli_options_finish(&options);
    return result;
}
