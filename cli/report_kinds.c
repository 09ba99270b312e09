/* cli/report_kinds.c: the top of the summary: which method for which kind of scene.
 *
 * A kind is the light's type, the number of triangles by rough steps, and whether all meshes are
 * closed. Within a kind an entry counts by the scenes that it can do: time and RMSE are geometric
 * means over them. Good enough is who stays below the limit in the most scenes of the kind, and of
 * several the quickest; so one scene that nobody can do does not empty the cell, and says so. */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define GOOD_ENOUGH 0.05 /* RMSE: passes beside the truth unless one looks closely */
#define LEAST_ERROR INFINITY

static const size_t steps[] = {5000, 50000, SIZE_MAX};

struct kind {
    const char *light_type;
    size_t step; /* of the triangles */
    bool open;
    size_t *scenes, count;
};

/* Who is asked for. */
enum crowd { ALL, ON_OPENGL, ON_PLANES };

struct winner {
    const struct compare_entry *entry; /* NULL: none */
    double time, error;                /* geometric means */
    size_t good, done;                 /* scenes below the limit, and with figures */
};

static size_t step_of(size_t triangles)
{
    size_t step = 0;
    while (triangles > steps[step])
        step++;
    return step;
}

static bool belongs(const struct kind *kind, const struct compare_scene *scene)
{
    return strcmp(kind->light_type, scene->light_type) == 0 &&
           kind->step == step_of(scene->triangle_count) && kind->open == scene->open;
}

/* By first appearance of the light, then from few triangles to many; NULL: no memory. */
static struct kind *list_kinds(const struct compare_run *run, size_t *count)
{
    struct kind *kinds = calloc(run->scene_count + 1, sizeof(*kinds));
    size_t *indices = calloc(run->scene_count + 1, sizeof(*indices)); /* of all, kind by kind */
    *count = 0;
    for (size_t s = 0; kinds && indices && s < run->scene_count; s++) {
        const char *light = run->scenes[s].light_type;
        bool known = false;
        for (size_t k = 0; k < *count; k++)
            known |= strcmp(kinds[k].light_type, light) == 0;
        for (size_t key = 0; key < 2 * sizeof(steps) / sizeof(steps[0]) && !known; key++) {
            struct kind kind = {light, key / 2, key % 2, indices, 0};
            for (size_t i = 0; i < run->scene_count; i++)
                if (belongs(&kind, &run->scenes[i]))
                    indices[kind.count++] = i;
            if (kind.count)
                kinds[(*count)++] = kind;
            indices += kind.count;
        }
    }
    if (*count == 0)
        free(indices);
    return kinds;
}

static void free_kinds(struct kind *kinds, size_t count)
{
    if (count)
        free(kinds[0].scenes);
    free(kinds);
}

static bool asked(enum crowd crowd, const struct compare_entry *entry)
{
    if (!entry->method)
        return false;
    bool partial = entry->method->receivers != PNB_RECEIVERS_ANY;
    return partial == (crowd == ON_PLANES) &&
           (crowd != ON_OPENGL || entry->method->processor == PNB_PROCESSOR_OPENGL);
}

static struct winner weigh(const struct compare_run *run, const struct kind *kind,
                           const char *label, double limit)
{
    struct winner sum = {NULL, 0, 0, 0, 0};
    for (size_t i = 0; i < kind->count; i++) {
        const struct compare_entry *entry = report_find_entry(&run->scenes[kind->scenes[i]], label);
        if (!entry || !report_measured(entry))
            continue;
        sum.entry = entry;
        sum.time += log(entry->milliseconds);
        sum.error += log(fmax(entry->errors.rmse, REPORT_ERROR_FLOOR));
        sum.good += entry->errors.rmse <= limit;
        sum.done++;
    }
    sum.time = exp(sum.time / (double)(sum.done ? sum.done : 1));
    sum.error = exp(sum.error / (double)(sum.done ? sum.done : 1));
    return sum;
}

static struct winner choose(const struct compare_run *run, const struct kind *kind,
                            const struct compare_entry *const *entries, size_t count,
                            enum crowd crowd, double limit)
{
    struct winner best = {NULL, INFINITY, INFINITY, 0, 0};
    for (size_t i = 0; i < count; i++) {
        if (!asked(crowd, entries[i]))
            continue;
        struct winner one = weigh(run, kind, entries[i]->label, limit);
        bool better = limit < LEAST_ERROR ? one.time < best.time : one.error < best.error;
        if (one.good > best.good || (one.good && one.good == best.good && better))
            best = one;
    }
    return best;
}

static void put_winner(FILE *page, const struct kind *kind, const struct winner *winner)
{
    if (!winner->entry) {
        fprintf(page, "<td class=\"text none\">none</td>");
        return;
    }
    fprintf(page, "<td class=\"text\">");
    report_html_entry(page, winner->entry->method, winner->entry->label);
    fprintf(page, "<br><small>%.4f, ", winner->error);
    report_html_duration(page, winner->time);
    if (winner->good < kind->count)
        fprintf(page, "; %zu of %zu", winner->good, kind->count);
    fprintf(page, "</small></td>");
}

static void put_kind(FILE *page, const struct compare_run *run, const struct kind *kind)
{
    fprintf(page, "<td class=\"text\"><b>%s</b>, ", kind->light_type);
    if (kind->step == 0)
        fprintf(page, "up to 5,000 triangles");
    else
        fprintf(page, kind->step == 1 ? "5,000 to 50,000" : "more than 50,000");
    fprintf(page, "%s<br><small class=\"wrap\">", kind->open ? ", open meshes" : "");
    for (size_t i = 0; i < kind->count; i++) {
        fprintf(page, "%s<a href=\"#scene-%zu\">", i ? ", " : "", kind->scenes[i]);
        report_html_text(page, report_scene_name(&run->scenes[kind->scenes[i]]));
        fprintf(page, "</a>");
    }
    fprintf(page, "</small></td>");
}

void report_html_kinds(FILE *page, const struct compare_run *run,
                       const struct compare_entry *const *entries, size_t count)
{
    static const struct {
        const char *title;
        enum crowd crowd;
        double limit;
    } columns[] = {
        {"least error", ALL, LEAST_ERROR},
        {"quickest that is good", ALL, GOOD_ENOUGH},
        {"OpenGL: least error", ON_OPENGL, LEAST_ERROR},
        {"OpenGL: quickest that is good", ON_OPENGL, GOOD_ENOUGH},
        {"planes only: quickest that is good", ON_PLANES, GOOD_ENOUGH},
    };
    size_t kind_count;
    struct kind *kinds = list_kinds(run, &kind_count);
    if (!kinds)
        return;
    fprintf(page,
            "<h3>For a scene like yours</h3>\n<p class=\"soft\">Find the light and the size of "
            "your scene. In a cell: the method, its RMSE in the penumbra, the time of a frame at "
            "%d &times; %d (geometric means over the scenes named). Good is an RMSE of at most %g: "
            "it passes beside the truth unless one looks closely; <i>7 of 9</i>: in so many of the "
            "scenes. Times are this machine&#8217;s: llvmpipe is OpenGL in software, and on a "
            "graphics card its methods cost another, lesser time; choose among them by their "
            "errors.</p>\n<div class=\"scroll\"><table class=\"advice by-kind\">\n<thead><tr><th "
            "class=\"text\">light, triangles</th>",
            run->scenes[0].width, run->scenes[0].height, GOOD_ENOUGH);
    for (size_t c = 0; c < sizeof(columns) / sizeof(columns[0]); c++)
        fprintf(page, "<th class=\"text\">%s</th>", columns[c].title);
    fprintf(page, "</tr></thead>\n<tbody>\n");
    for (size_t k = 0; k < kind_count; k++) {
        fprintf(page, "<tr>");
        put_kind(page, run, &kinds[k]);
        for (size_t c = 0; c < sizeof(columns) / sizeof(columns[0]); c++) {
            struct winner winner =
                choose(run, &kinds[k], entries, count, columns[c].crowd, columns[c].limit);
            put_winner(page, &kinds[k], &winner);
        }
        fprintf(page, "</tr>\n");
    }
    fprintf(page, "</tbody>\n</table></div>\n");
    free_kinds(kinds, kind_count);
}
