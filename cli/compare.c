/* cli/compare.c: 'penumbra compare': several methods, and files of other programs, against the
 * truth; a page for people and a report for programs.
 *
 *   per scene: compare_scene_run() -> section of the page, object of the report
 *   at the end: both files, under temporary names, then renamed together
 */
#define _GNU_SOURCE
#include "compare.h"

#include "commands.h"
#include "compare_curves.h"
#include "compare_motion.h"

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
    "SCENE builtin:all stands for every built-in scene. --motion moves the light (or an occluder) "
    "of\n"
    "each scene along a short path, at half the size, and measures flicker and popping. --curves\n"
    "and --papers do not depend on SCENE. 'penumbra bench all -o DIR' is all of it at once.\n\n"
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

#define MOTION_FRAMES     16
#define MOTION_FRAMES_MAX 1000
/* Above so many triangles less of the path, in as long steps. */
#define MOTION_TRIANGLES    5000
#define MOTION_FRAMES_DENSE 8

static const char *truth_samples_text, *motion_text, *motion_path_text, *motion_frames_text,
    *curves_text, *papers_text, *series_text;

static const struct cli_extra extras[] = {
    {"truth-samples", "N", "light samples of the truth (default 4096)", &truth_samples_text},
    {"series", NULL, "also: methods at several numbers of samples, in tables and plots alone",
     &series_text},
    {"motion", NULL, "also: how much more each method jumps between frames than the truth",
     &motion_text},
    {"motion-path", "light|occluder", "what moves (default light)", &motion_path_text},
    {"motion-frames", "N", "frames of the motion (default 16; 8 above 5000 triangles)",
     &motion_frames_text},
    {"curves", NULL, "also: time and error over triangles, light size, pixels", &curves_text},
    {"papers", NULL, "also: the papers' tables and figures, made again", &papers_text},
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
        run->triangles[i] = scene.triangle_count;
        compare_scene_finish(session->context, &scene);
        if (result != CLI_GO_ON)
            return result;
    }
    return entries > 0 ? CLI_GO_ON
                       : cli_error("compare", "no method is left: none can do any of the scenes");
}

/* What the extras ask for beside the scenes. */
struct wishes {
    int truth_samples;
    bool motion, occluder, curves, papers;
    int motion_frames; /* 0: as the scene is */
};

static struct compare_motion plan_motion(const struct cli_options *options,
                                         const struct wishes *wishes, size_t triangles)
{
    int width = options->width / 2, height = options->height / 2;
    int frames = triangles > MOTION_TRIANGLES ? MOTION_FRAMES_DENSE : MOTION_FRAMES;
    return (struct compare_motion){
        .frames = wishes->motion_frames ? wishes->motion_frames : frames,
        .share = wishes->motion_frames ? 1 : (frames - 1) / (double)(MOTION_FRAMES - 1),
        .width = width > 0 ? width : 1,
        .height = height > 0 ? height : 1};
}

/* Of many scenes the motion of a few says as much. */
static bool moves(const struct compare_run *run, const struct compare_scene *scene)
{
    static const char *const shown[] = {"two-boxes", "knot",      "fence",        "spheres-9x9",
                                        "leaves",    "jack-tube", "light-size-3", "outdoor"};
    bool wanted = run->path_count <= 10;
    for (size_t i = 0; i < sizeof(shown) / sizeof(shown[0]); i++)
        wanted |= strcmp(report_scene_name(scene), shown[i]) == 0;
    return wanted;
}

static double plan_units(const struct compare_run *run, const struct wishes *wishes)
{
    const struct cli_options *options = run->options;
    double units = 0;
    for (size_t i = 0; i < run->path_count; i++) {
        struct compare_motion motion = plan_motion(options, wishes, run->triangles[i]);
        units += compare_scene_units(options, wishes->truth_samples, run->triangles[i]);
        if (wishes->motion && moves(run, &(struct compare_scene){.path = run->paths[i]}))
            units += compare_motion_units(&motion, pnb_method_count());
    }
    if (wishes->curves)
        units += compare_curves_units();
    if (wishes->papers)
        units += compare_papers_units();
    return units;
}

static int run_motion(struct cli_session *session, struct compare_run *run,
                      const struct wishes *wishes, const struct compare_scene *scene, FILE *page,
                      json_t *json)
{
    struct compare_motion *motion = &run->motion[run->motion_count];
    *motion = plan_motion(run->options, wishes, scene->triangle_count);
    int result = compare_motion_run(session, scene, wishes->occluder, motion);
    if (result == CLI_GO_ON) {
        if (run->motion_count == 0)
            report_html_motion_begin(page, motion);
        report_html_motion(page, motion, run->motion_count++);
        json_object_set_new(json, "motion", report_json_motion(motion));
    }
    compare_motion_finish(session->context, motion);
    return result;
}

/* Each scene writes its section, and its motion another. */
static int run_scenes(struct cli_session *session, struct compare_run *run, const pnb_image *images,
                      const struct wishes *wishes, FILE *body, FILE *motion, json_t *scenes)
{
    const struct cli_options *options = session->options;
    int result = CLI_GO_ON;
    for (size_t i = 0; i < run->path_count && result == CLI_GO_ON; i++) {
        struct compare_scene *scene = &run->scenes[run->scene_count++];
        *scene = (struct compare_scene){.path = run->paths[i],
                                        .planned_triangles = run->triangles[i],
                                        .one_of_several = run->path_count > 1};
        result = compare_scene_run(session, images, wishes->truth_samples, scene);
        if (result != CLI_GO_ON)
            break;
        report_html_scene(body, run, scene, i);
        compare_scene_drop_pictures(session->context, scene);
        json_t *json = report_json_scene(run, scene);
        json_array_append_new(scenes, json);
        if (wishes->motion && moves(run, scene))
            result = run_motion(session, run, wishes, scene, motion, json);
        cli_session_clear_bar(session);
        if (result == CLI_GO_ON && !options->json && !options->quiet)
            print_table(scene);
    }
    if (run->motion_count)
        fprintf(motion, "</section>\n");
    return result;
}

static int run_extras(struct cli_session *session, const struct wishes *wishes,
                      struct compare_curves *curves, struct compare_papers *papers)
{
    int result = CLI_GO_ON;
    if (wishes->curves)
        result = compare_curves_run(session, curves);
    if (result == CLI_GO_ON && wishes->papers)
        result = compare_papers_run(session, papers);
    return result;
}

/* A part of the page in memory. */
struct part {
    FILE *file;
    char *text;
    size_t size;
};

static int write_page(struct cli_session *session, struct part *parts, size_t count,
                      const char *report)
{
    size_t size = 0;
    for (size_t i = 0; i < count; i++)
        size += parts[i].size;
    char *page = malloc(size + 1), *at = page;
    for (size_t i = 0; page && i < count; i++) {
        memcpy(at, parts[i].text, parts[i].size);
        at += parts[i].size;
    }
    int result = page ? write_results(session, page, size, report) : no_memory();
    free(page);
    return result;
}

static int run_all(struct cli_session *session, struct compare_run *run, const pnb_image *images,
                   const struct wishes *wishes)
{
    enum { HEAD, EXTRAS, MOTION, BODY, PARTS };
    const struct cli_options *options = session->options;
    struct part parts[PARTS] = {{0}};
    struct compare_curves curves = {0};
    struct compare_papers papers = {0};
    char *report_text = NULL;
    json_t *scenes = json_array();
    run->scenes = calloc(run->path_count, sizeof(*run->scenes));
    run->motion = calloc(run->path_count, sizeof(*run->motion));
    int result = scenes && run->scenes && run->motion ? CLI_GO_ON : no_memory();
    for (int i = 0; i < PARTS && result == CLI_GO_ON; i++) {
        parts[i].file = open_memstream(&parts[i].text, &parts[i].size);
        if (!parts[i].file)
            result = no_memory();
    }
    cli_session_plan(session, plan_units(run, wishes));
    if (run->path_count > 8 || wishes->curves || wishes->papers)
        session->repeat_ms = 40;
    if (result == CLI_GO_ON)
        result =
            run_scenes(session, run, images, wishes, parts[BODY].file, parts[MOTION].file, scenes);
    if (result == CLI_GO_ON)
        result = run_extras(session, wishes, &curves, &papers);
    run->curves = wishes->curves ? &curves : NULL;
    run->papers = wishes->papers ? &papers : NULL;
    if (result == CLI_GO_ON) {
        report_html_begin(parts[HEAD].file, run);
        report_html_summary(parts[HEAD].file, run);
        if (run->curves)
            report_html_curves(parts[EXTRAS].file, run->curves);
        if (run->papers)
            report_html_papers(parts[EXTRAS].file, run, run->papers, run->curves);
        report_html_end(parts[BODY].file, run);
    }
    for (int i = 0; i < PARTS; i++)
        if (parts[i].file && (ferror(parts[i].file) | fclose(parts[i].file)) && result == CLI_GO_ON)
            result = no_memory();
    cli_session_clear_bar(session);
    json_t *report = report_json(run, scenes);
    if (result == CLI_GO_ON) {
        report_text = json_dumps(report, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
        result = report_text ? write_page(session, parts, PARTS, report_text) : no_memory();
    }
    if (result == CLI_GO_ON && options->json)
        result = cli_json_print(json_incref(report));
    else if (result == CLI_GO_ON && !options->quiet)
        printf("%s/index.html\n", options->output);
    json_decref(report);
    free(report_text);
    for (int i = 0; i < PARTS; i++)
        free(parts[i].text);
    compare_curves_finish(&curves);
    compare_papers_finish(session->context, &papers);
    for (size_t i = 0; run->scenes && i < run->scene_count; i++)
        compare_scene_finish(session->context, &run->scenes[i]);
    free(run->scenes);
    free(run->motion);
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
    run->triangles = calloc(run->path_count + 1, sizeof(*run->triangles));
    return run->paths && run->triangles;
}

/* Of everything at once: what would take most of the time and says little. */
static const struct {
    const char *entry;
    size_t most_triangles;
    bool closed_only;
    const char *why;
} limits[] = {
    {"wedge", 100000, false, "more than 100,000 triangles take half a minute"},
    {"wedge-probabilistic", 100000, false, "more than 100,000 triangles take half a minute"},
    {"wedge-blend", 600000, false, "more than 600,000 triangles take a minute and more"},
    {"planar:64", 100000, true, "open meshes, and more than 100,000 triangles, take minutes"},
    {"planar:tolerance=0.0156", 100000, true,
     "open meshes, and more than 100,000 triangles, take minutes"},
};

/* Each method that samples at a quarter of its usual number, and settings that say more, where the
 * method is there: many samples only of what stays quick with them. */
static bool add_series(struct cli_options *options)
{
    static const char *const more[] = {"reference:16", "reference:64", "reference:256",
                                       "exact:4096",   "planar:64",    "planar:tolerance=0.0156"};
    bool good = options->choice_count > 0 || cli_add_methods(options, "all");
    size_t before = options->choice_count;
    for (size_t i = 0; i < sizeof(more) / sizeof(more[0]) && good; i++) {
        if (cli_knows_entry(more[i], strlen(more[i])))
            good = cli_add_methods(options, more[i]);
    }
    for (size_t i = 0; i < pnb_method_count() && good; i++) {
        const pnb_method_info *method = pnb_method(i);
        int few = method->default_samples / 4;
        char text[80];
        if (!method->samples || strcmp(method->name, "reference") == 0)
            continue;
        snprintf(text, sizeof(text), "%s:%d", method->name, few > 2 ? few : 2);
        good = cli_add_methods(options, text);
    }
    for (size_t i = before; i < options->choice_count; i++)
        options->choices[i].figures_only = true;
    for (size_t i = 0; i < options->choice_count && options->all_methods; i++)
        for (size_t k = 0; k < sizeof(limits) / sizeof(limits[0]); k++) {
            struct cli_choice *choice = &options->choices[i];
            if (strcmp(choice->label, limits[k].entry) != 0)
                continue;
            choice->most_triangles = limits[k].most_triangles;
            choice->closed_only = limits[k].closed_only;
            choice->why = limits[k].why;
        }
    return good;
}

static int check_line(const struct cli_options *options, struct wishes *wishes)
{
    long truth_samples = TRUTH_SAMPLES, frames = 0;
    if (!options->output)
        return cli_usage_error("compare", "command line", "missing -o DIR");
    if (options->image_count && options->operand_count > 1)
        return cli_usage_error("compare", "--image", "judges one scene; %zu are given",
                               options->operand_count);
    if (truth_samples_text && !cli_read_integer("compare", "--truth-samples", truth_samples_text, 1,
                                                TRUTH_SAMPLES_MAX, &truth_samples))
        return CLI_EXIT_USAGE;
    if (motion_frames_text && !cli_read_integer("compare", "--motion-frames", motion_frames_text, 2,
                                                MOTION_FRAMES_MAX, &frames))
        return CLI_EXIT_USAGE;
    bool occluder = motion_path_text && strcmp(motion_path_text, "occluder") == 0;
    if (motion_path_text && !occluder && strcmp(motion_path_text, "light") != 0)
        return cli_usage_error("compare", "--motion-path", "'%.60s' is neither light nor occluder",
                               motion_path_text);
    *wishes = (struct wishes){.truth_samples = (int)truth_samples,
                              .motion = motion_text || motion_path_text || motion_frames_text,
                              .occluder = occluder,
                              .curves = curves_text != NULL,
                              .papers = papers_text != NULL,
                              .motion_frames = (int)frames};
    return check_folder(options->output);
}

int command_compare(int argc, char **argv)
{
    /* Reading the options cuts some arguments into words. */
    char *line = command_line(argc, argv);
    struct cli_options options;
    truth_samples_text = motion_text = motion_path_text = motion_frames_text = curves_text =
        papers_text = series_text = NULL;
    int result = cli_options_init(&command, argc, argv, &options);
    if (result != CLI_GO_ON) {
        free(line);
        return result;
    }
    struct cli_session session = {0};
    pnb_image *images = calloc(options.image_count + 1, sizeof(*images));
    struct wishes wishes = {0};
    result = images && line ? check_line(&options, &wishes) : no_memory();
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
        if (wishes.truth_samples < 1024)
            cli_session_warn(&session, "the truth has fewer than 1024 samples: the figures "
                                       "contain its own noise");
        result = read_images(&session, images);
        if (result == CLI_GO_ON && series_text && !add_series(&options))
            result = CLI_EXIT_FAILED;
        if (result == CLI_GO_ON && !list_paths(&options, &run))
            result = no_memory();
        if (result == CLI_GO_ON && run.path_count > 1)
            result = check_scenes(&session, &run);
        if (result == CLI_GO_ON)
            result = run_all(&session, &run, images, &wishes);
        for (size_t i = 0; i < options.image_count; i++)
            pnb_image_finish(session.context, &images[i]);
        for (size_t i = 0; i < run.path_count; i++)
            free(run.paths[i]);
        free(run.paths);
        free(run.triangles);
        cli_session_finish(&session);
    }
    free(images);
    free(line);
    cli_options_finish(&options);
    return result;
}
