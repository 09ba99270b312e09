/* cli/session.c: the context of a command, its progress bar, signals, and what it prints.
 *
 * The progress bar is drawn on standard error only if that is a terminal that can move its cursor,
 * after a third of a second, ten times a second, and is wiped out before anything else is printed.
 */
#define _GNU_SOURCE
#include "session.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

/* A quick visibility is run again while this much time has not passed, at most so often. */
#define REPEAT_MS  400.0
#define REPEAT_MAX 9

#define BAR_AFTER_MS 300.0
#define BAR_EVERY_MS 100.0
#define BAR_CELLS    24

static volatile sig_atomic_t stop_signal;

static void on_signal(int number)
{
    stop_signal = number;
}

bool cli_session_stopped(void)
{
    return stop_signal != 0;
}

double cli_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* ---- progress ---- */

void cli_session_clear_bar(struct cli_session *session)
{
    if (session->bar.drawn) {
        fputs("\r\033[K", stderr);
        fflush(stderr);
    }
    session->bar.drawn = false;
}

static void format_seconds(double seconds, char *text, size_t size)
{
    long s = (long)(seconds + 0.5);
    if (s < 60)
        snprintf(text, size, "%lds", s);
    else if (s < 3600)
        snprintf(text, size, "%ldm%02lds", s / 60, s % 60);
    else
        snprintf(text, size, "%ldh%02ldm", s / 3600, s / 60 % 60);
}

static void draw_bar(struct cli_session *session, double fraction, double now)
{
    struct cli_bar *bar = &session->bar;
    char left[32] = "", cells[BAR_CELLS + 1];
    int full = (int)(fraction * BAR_CELLS);
    for (int i = 0; i < BAR_CELLS; i++)
        cells[i] = i < full ? '#' : '.';
    cells[BAR_CELLS] = 0;
    if (fraction > 0.01)
        format_seconds((now - bar->started_ms) * 1e-3 * (1 - fraction) / fraction, left,
                       sizeof(left));
    fprintf(stderr, "\r%.24s [%s] %3d%%%s%s\033[K", bar->stage, cells, (int)(fraction * 100),
            *left ? "  left " : "", left);
    fflush(stderr);
    bar->drawn = true;
    bar->drawn_ms = now;
}

static bool on_progress(void *user, const char *stage, double fraction)
{
    struct cli_session *session = user;
    struct cli_bar *bar = &session->bar;
    if (stop_signal)
        return false;
    if (!bar->enabled)
        return true;
    double now = cli_clock_ms();
    fraction = fraction < 0 ? 0 : fraction > 1 ? 1 : fraction;
    if (bar->total > 0) {
        fraction = fmin((bar->done + bar->step * fraction) / bar->total, 1);
    } else if (strncmp(bar->stage, stage, sizeof(bar->stage) - 1) != 0) {
        snprintf(bar->stage, sizeof(bar->stage), "%s", stage);
        bar->started_ms = now;
    }
    if (now - bar->started_ms >= BAR_AFTER_MS && now - bar->drawn_ms >= BAR_EVERY_MS)
        draw_bar(session, fraction, now);
    return true;
}

void cli_session_plan(struct cli_session *session, double units)
{
    session->bar.total = units;
    session->bar.done = session->bar.step = 0;
    session->bar.started_ms = cli_clock_ms();
}

void cli_session_step(struct cli_session *session, const char *what, double units)
{
    struct cli_bar *bar = &session->bar;
    bar->done += bar->step;
    bar->step = units;
    snprintf(bar->stage, sizeof(bar->stage), "%s", what);
    on_progress(session, what, 0);
}

/* ---- log ---- */

void cli_session_warn(struct cli_session *session, const char *text)
{
    for (size_t i = 0; i < session->warning_count; i++)
        if (strcmp(session->warnings[i], text) == 0)
            return;
    char **grown = realloc(session->warnings, (session->warning_count + 1) * sizeof(*grown));
    if (grown) {
        session->warnings = grown;
        grown[session->warning_count] = strdup(text);
        if (grown[session->warning_count])
            session->warning_count++;
    }
    if (!session->options->quiet) {
        cli_session_clear_bar(session);
        fprintf(stderr, "penumbra: warning: %s\n", text);
    }
}

static void on_log(void *user, pnb_log_level level, const char *text)
{
    if (level == PNB_LOG_WARNING)
        cli_session_warn(user, text);
}

/* ---- the session ---- */

int cli_session_init(struct cli_session *session, const struct cli_options *options)
{
    *session = (struct cli_session){.options = options};
    const char *terminal = getenv("TERM");
    session->bar.enabled =
        !options->quiet && isatty(STDERR_FILENO) && terminal && strcmp(terminal, "dumb") != 0;

    /* The first signal asks politely, the second one kills. */
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);

    pnb_context_desc desc = {
        .threads = options->threads, .log = on_log, .progress = on_progress, .user = session};
    if (pnb_context_create(&desc, &session->context) != PNB_OK)
        return cli_error("memory", "none left");
    return CLI_GO_ON;
}

void cli_session_finish(struct cli_session *session)
{
    cli_session_clear_bar(session);
    pnb_context_destroy(session->context);
    for (size_t i = 0; i < session->warning_count; i++)
        free(session->warnings[i]);
    free(session->warnings);
    *session = (struct cli_session){0};
}

int cli_session_fail(struct cli_session *session)
{
    cli_session_clear_bar(session);
    fprintf(stderr, "penumbra: error: %s\n", pnb_context_error(session->context));
    return CLI_EXIT_FAILED;
}

/* ---- scenes ---- */

int cli_lights_check(struct cli_session *session)
{
    const struct cli_options *options = session->options;
    pnb_scene *scene = NULL;
    if (!options->light_count)
        return CLI_GO_ON;
    if (pnb_scene_create(session->context, &scene) != PNB_OK)
        return cli_session_fail(session);
    int result = CLI_GO_ON;
    for (size_t i = 0; i < options->light_count && result == CLI_GO_ON; i++)
        if (pnb_scene_add_light_json(scene, options->lights[i], NULL) != PNB_OK)
            result = cli_usage_error(options->command->name, "--light", "%s",
                                     pnb_context_error(session->context));
    if (result == CLI_GO_ON && options->light_index >= options->light_count)
        result = cli_usage_error(options->command->name, "--light-index",
                                 "%zu: only %zu lights are given, counted from 0",
                                 options->light_index, options->light_count);
    pnb_scene_destroy(scene);
    return result;
}

int cli_scene_load(struct cli_session *session, const char *path, pnb_scene **out_scene)
{
    const struct cli_options *options = session->options;
    int result = cli_lights_check(session);
    if (result != CLI_GO_ON)
        return result;
    pnb_scene *scene = NULL;
    if (pnb_scene_load(session->context, path, &scene) != PNB_OK)
        return cli_session_fail(session);
    if (options->light_count)
        pnb_scene_clear_lights(scene);
    for (size_t i = 0; i < options->light_count; i++)
        if (pnb_scene_add_light_json(scene, options->lights[i], NULL) != PNB_OK) {
            pnb_scene_destroy(scene);
            return cli_session_fail(session);
        }
    size_t count = pnb_scene_light_count(scene);
    if (options->light_index > 0 && options->light_index >= count) {
        pnb_scene_destroy(scene);
        return cli_usage_error(options->command->name, "--light-index",
                               "%zu: the scene has %zu light%s, counted from 0",
                               options->light_index, count, count == 1 ? "" : "s");
    }
    *out_scene = scene;
    return CLI_GO_ON;
}

/* ---- files ---- */

static void folder_of(const char *path, char *folder, size_t size)
{
    const char *slash = strrchr(path, '/');
    if (!slash)
        snprintf(folder, size, ".");
    else
        snprintf(folder, size, "%.*s", slash == path ? 1 : (int)(slash - path), path);
}

int cli_check_writable(const char *path)
{
    char folder[4096];
    struct stat info;
    if (strlen(path) >= sizeof(folder))
        return cli_error(path, "the path is too long");
    if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
        return cli_error(path, "is a folder");
    folder_of(path, folder, sizeof(folder));
    if (stat(folder, &info) != 0)
        return cli_error(path, "folder '%.300s': %s", folder, strerror(errno));
    if (!S_ISDIR(info.st_mode))
        return cli_error(path, "'%.300s' is no folder", folder);
    if (access(folder, W_OK | X_OK) != 0)
        return cli_error(path, "folder '%.300s': %s", folder, strerror(errno));
    return CLI_GO_ON;
}

int cli_make_folder(const char *path)
{
    struct stat info;
    if (mkdir(path, 0777) != 0 && errno != EEXIST)
        return cli_error(path, "cannot make the folder: %s", strerror(errno));
    if (stat(path, &info) != 0)
        return cli_error(path, "%s", strerror(errno));
    if (!S_ISDIR(info.st_mode))
        return cli_error(path, "is a file, not a folder");
    if (access(path, W_OK | X_OK) != 0)
        return cli_error(path, "%s", strerror(errno));
    return CLI_GO_ON;
}

/* ---- solving ---- */

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double cli_median(double *values, size_t count)
{
    qsort(values, count, sizeof(values[0]), by_value);
    return values[count / 2];
}

/* What the frame took of the processor, all threads: on OpenGL what the solver counted, without the
 * drawing that only warms up. */
static double processor_of(const pnb_solver_report *report, double spent_ms)
{
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, "processor_ms") == 0)
            return report->counters[i].value;
    return spent_ms;
}

static double processor_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

pnb_status cli_solve(const struct cli_session *session, pnb_solver *solver, const pnb_light *light,
                     const pnb_receivers *receivers, bool steady, float *visibility,
                     pnb_solver_report *report, double *processor_ms)
{
    double limit = session->repeat_ms > 0 ? session->repeat_ms : REPEAT_MS;
    double times[REPEAT_MAX], processor[REPEAT_MAX], total = 0;
    int count = 0;
    do {
        double begun = processor_clock_ms();
        pnb_status status = pnb_solver_visibility(solver, light, receivers, visibility);
        if (status != PNB_OK)
            return status;
        pnb_solver_get_report(solver, report);
        processor[count] = processor_of(report, processor_clock_ms() - begun);
        times[count++] = report->visibility_ms;
        total += report->visibility_ms;
    } while (steady && count < REPEAT_MAX && total < limit);
    report->visibility_ms = cli_median(times, (size_t)count);
    if (processor_ms)
        *processor_ms = cli_median(processor, (size_t)count);
    return PNB_OK;
}

/* ---- output ---- */

const char *cli_device(const pnb_solver_report *report, char *text, size_t size)
{
    if (report && report->device && *report->device)
        return report->device;
    snprintf(text, size, "CPU");
    FILE *file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file && fgets(line, sizeof(line), file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) != 0 || !colon)
            continue;
        line[strcspn(line, "\n")] = 0;
        snprintf(text, size, "%s", colon + 1 + strspn(colon + 1, " "));
        break;
    }
    if (file)
        fclose(file);
    return text;
}

json_t *cli_json_text(const char *text)
{
    json_t *value = json_string(text);
    if (value)
        return value;
    char *copy = strdup(text);
    for (char *c = copy; c && *c; c++)
        if ((unsigned char)*c >= 0x80)
            *c = '?';
    value = copy ? json_string(copy) : NULL;
    free(copy);
    return value ? value : json_string("");
}

json_t *cli_json_number(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *cli_json_warnings(const struct cli_session *session)
{
    json_t *array = json_array();
    for (size_t i = 0; i < session->warning_count; i++)
        json_array_append_new(array, cli_json_text(session->warnings[i]));
    return array;
}

json_t *cli_json_parameters(const pnb_solver_param *params, size_t param_count,
                            const pnb_method_info *method)
{
    json_t *object = json_object();
    for (size_t i = 0; method && i < method->param_count; i++) {
        const pnb_param_info *info = &method->params[i];
        const char *value = info->default_value;
        for (size_t p = 0; p < param_count; p++)
            if (strcmp(params[p].key, info->key) == 0)
                value = params[p].value;
        bool whole = info->type == PNB_PARAM_INTEGER;
        double number = 0;
        if (whole || info->type == PNB_PARAM_NUMBER)
            pnb_param_number(value, &number);
        json_object_set_new(object, info->key,
                            whole                            ? json_integer((json_int_t)number)
                            : info->type == PNB_PARAM_NUMBER ? cli_json_number(number)
                                                             : cli_json_text(value));
    }
    return object;
}

json_t *cli_json_counters(const pnb_solver_report *report)
{
    json_t *object = json_object();
    for (size_t i = 0; i < report->counter_count; i++) {
        double value = report->counters[i].value;
        bool whole = value == floor(value) && fabs(value) < 9e15;
        json_object_set_new(object, report->counters[i].name,
                            whole ? json_integer((json_int_t)value) : cli_json_number(value));
    }
    return object;
}

int cli_json_print(json_t *value)
{
    int bad = json_dumpf(value, stdout, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    json_decref(value);
    if (bad == 0)
        putchar('\n');
    return cli_flush();
}

int cli_flush(void)
{
    errno = 0;
    bool bad = fflush(stdout) != 0;
    if (bad || ferror(stdout))
        return cli_error("standard output", "%s", errno ? strerror(errno) : "cannot be written");
    return CLI_EXIT_DONE;
}
