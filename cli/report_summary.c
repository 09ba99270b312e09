/* cli/report_summary.c: the top of a page of several scenes: which method for which scene, the
 * figures of all methods on all scenes, and error against time over all scenes.
 *
 * Over all scenes an entry counts by the geometric means of its RMSE and of its time, each divided
 * by those of one entry that every scene has (the yardstick), so that methods which can do only
 * some scenes, easy or hard ones, are not flattered or wronged by that. */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const struct compare_entry *report_find_entry(const struct compare_scene *scene, const char *label)
{
    for (size_t i = 0; i < scene->entry_count; i++)
        if (strcmp(scene->entries[i].label, label) == 0)
            return &scene->entries[i];
    return NULL;
}

bool report_measured(const struct compare_entry *entry)
{
    return entry->errors.pixels > 0 && isfinite(entry->milliseconds) && entry->milliseconds > 0;
}

/* Every label of the run once, in order of appearance. */
static const struct compare_entry **list_entries(const struct compare_run *run, size_t *count)
{
    size_t most = 0;
    *count = 0;
    for (size_t s = 0; s < run->scene_count; s++)
        most += run->scenes[s].entry_count;
    const struct compare_entry **list = calloc(most + 1, sizeof(*list));
    for (size_t s = 0; list && s < run->scene_count; s++)
        for (size_t i = 0; i < run->scenes[s].entry_count; i++) {
            const struct compare_entry *entry = &run->scenes[s].entries[i];
            bool known = false;
            for (size_t k = 0; k < *count && !known; k++)
                known = strcmp(list[k]->label, entry->label) == 0;
            if (!known)
                list[(*count)++] = entry;
        }
    return list;
}

/* ---- which method ---- */

static void put_cheapest(FILE *page, const struct compare_scene *scene, double limit)
{
    const struct compare_entry *best = NULL;
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        if (!report_measured(entry) || entry->errors.rmse > limit)
            continue;
        /* A method that draws half of the picture is no answer for the whole. */
        if (2 * entry->errors.pixels < scene->facing_pixels)
            continue;
        if (!best || entry->milliseconds < best->milliseconds)
            best = entry;
    }
    if (!best) {
        fprintf(page, "<td class=\"text none\">none</td>");
        return;
    }
    fprintf(page, "<td class=\"text\">");
    report_html_entry(page, best->method, best->label);
    if (best->errors.pixels < scene->facing_pixels)
        fprintf(page, "*");
    fprintf(page, "<small>");
    report_html_duration(page, best->milliseconds);
    fprintf(page, "</small></td>");
}

static void put_advice(FILE *page, const struct compare_run *run)
{
    static const double limits[] = {0.1, 0.05, 0.02, 0.005};
    fprintf(page,
            "<h3>The quickest method that is good enough</h3>\n<p class=\"soft\">By the RMSE in "
            "the penumbra that is allowed: 0.1 passes at a glance, 0.02 side by side, 0.005 is "
            "ray tracing with some 300 samples. * does only some of the surfaces "
            "(planes).</p>\n<div class=\"scroll\"><table class=\"advice\">\n<thead><tr>"
            "<th></th><th>scene</th><th>light</th><th>triangles</th>");
    for (size_t k = 0; k < sizeof(limits) / sizeof(limits[0]); k++)
        fprintf(page, "<th class=\"text\">RMSE &le; %g</th>", limits[k]);
    fprintf(page, "</tr></thead>\n<tbody>\n");
    for (size_t s = 0; s < run->scene_count; s++) {
        const struct compare_scene *scene = &run->scenes[s];
        fprintf(page,
                "<tr><td class=\"thumb\"><a href=\"#scene-%zu\"><img data-thumb=\"scene-%zu\" "
                "alt=\"\" width=\"64\" height=\"48\"></a></td><td class=\"text\"><a "
                "href=\"#scene-%zu\">",
                s, s, s);
        report_html_text(page, report_scene_name(scene));
        fprintf(page, "</a></td><td class=\"text\">%s</td><td>", scene->light_type);
        report_html_count(page, scene->triangle_count);
        fprintf(page, "</td>");
        for (size_t k = 0; k < sizeof(limits) / sizeof(limits[0]); k++)
            put_cheapest(page, scene, limits[k]);
        fprintf(page, "</tr>\n");
    }
    fprintf(page, "</tbody>\n</table></div>\n");
}

/* ---- all figures ---- */

/* The figures that the script can show in the cells, as data-NAME. */
static const struct {
    const char *name, *title;
} figures[] = {
    {"rmse", "RMSE"},
    {"ms", "milliseconds"},
    {"mean", "bias (mean error)"},
    {"p99", "99 % of the errors below"},
    {"leak", "umbra leak, %"},
    {"dark", "lit darkening, %"},
};

static void put_cell(FILE *page, const struct compare_entry *entry)
{
    if (!entry || !report_measured(entry)) {
        fprintf(page, "<td>\xe2\x80\x93</td>");
        return;
    }
    const pnb_errors *e = &entry->errors;
    /* Shades by decades of the RMSE: none at 0.001, full at 0.3. */
    double shade = fmin(fmax((log10(fmax(e->rmse, REPORT_ERROR_FLOOR)) + 3) / 2.5, 0), 1);
    fprintf(page,
            "<td data-rmse=\"%.4f\" data-ms=\"%.4g\" data-mean=\"%+.4f\" data-p99=\"%.4f\" "
            "data-leak=\"%.2f\" data-dark=\"%.2f\" style=\"--shade:%.0f%%\">%.4f</td>",
            e->rmse, entry->milliseconds, e->mean_error, e->p99_error, 100 * e->umbra_leak,
            100 * e->lit_darkening, 45 * shade, e->rmse);
}

static void put_matrix(FILE *page, const struct compare_run *run,
                       const struct compare_entry *const *entries, size_t count)
{
    fprintf(page, "<h3>Every method on every scene</h3>\n<p><span class=\"scripted kinds matrix\" "
                  "role=\"group\" aria-label=\"figure\">");
    for (size_t k = 0; k < sizeof(figures) / sizeof(figures[0]); k++)
        fprintf(page, "<button type=\"button\" data-figure=\"%s\">%s</button>", figures[k].name,
                figures[k].title);
    fprintf(page, "</span></p>\n<div class=\"scroll\"><table class=\"matrix\">\n<thead><tr><th>"
                  "scene</th>");
    for (size_t i = 0; i < count; i++) {
        if (entries[i]->figures_only)
            continue;
        fprintf(page, "<th>");
        report_html_entry(page, entries[i]->method, entries[i]->label);
        fprintf(page, "</th>");
    }
    fprintf(page, "</tr></thead>\n<tbody>\n");
    for (size_t s = 0; s < run->scene_count; s++) {
        fprintf(page, "<tr><td><a href=\"#scene-%zu\">", s);
        report_html_text(page, report_scene_name(&run->scenes[s]));
        fprintf(page, "</a> <small>%s</small></td>", run->scenes[s].light_type);
        for (size_t i = 0; i < count; i++)
            if (!entries[i]->figures_only)
                put_cell(page, report_find_entry(&run->scenes[s], entries[i]->label));
        fprintf(page, "</tr>\n");
    }
    fprintf(page, "</tbody>\n</table></div>\n");
}

/* ---- over all scenes ---- */

/* In all scenes, and of all such entries the one nearest to 64 samples of the reference. */
static const char *find_yardstick(const struct compare_run *run,
                                  const struct compare_entry *const *entries, size_t count)
{
    const char *best = NULL;
    double nearest = INFINITY;
    for (size_t i = 0; i < count; i++) {
        bool everywhere = true;
        for (size_t s = 0; s < run->scene_count && everywhere; s++) {
            const struct compare_entry *entry =
                report_find_entry(&run->scenes[s], entries[i]->label);
            everywhere = entry && report_measured(entry) && entry->errors.rmse > 0;
        }
        double away = strcmp(entries[i]->name, "reference") == 0
                          ? fabs(log2(entries[i]->samples / 64.0))
                          : 1e3 + (double)i;
        if (everywhere && away < nearest) {
            nearest = away;
            best = entries[i]->label;
        }
    }
    return best;
}

static void put_overall(FILE *page, const struct compare_run *run,
                        const struct compare_entry *const *entries, size_t count)
{
    const char *yardstick = find_yardstick(run, entries, count);
    struct report_point *points = calloc(count + 1, sizeof(*points));
    size_t *shares = calloc(count + 1, sizeof(*shares));
    size_t shown = 0;
    for (size_t i = 0; points && shares && yardstick && i < count; i++) {
        double time = 0, error = 0;
        size_t scenes = 0;
        for (size_t s = 0; s < run->scene_count; s++) {
            const struct compare_entry *entry =
                report_find_entry(&run->scenes[s], entries[i]->label);
            const struct compare_entry *unit = report_find_entry(&run->scenes[s], yardstick);
            if (!entry || !report_measured(entry))
                continue;
            time += log(entry->milliseconds / unit->milliseconds);
            error += log(fmax(entry->errors.rmse, REPORT_ERROR_FLOOR) / unit->errors.rmse);
            scenes++;
        }
        if (!scenes)
            continue;
        shares[shown] = scenes;
        points[shown++] =
            report_point(entries[i], exp(time / (double)scenes), exp(error / (double)scenes));
    }
    if (shown) {
        fprintf(page, "<h3>Over all scenes</h3>\n<div class=\"top\"><div>");
        report_plot_points(page, points, shown, "time, times that of the yardstick",
                           "RMSE, times that of the yardstick");
        fprintf(page,
                "</div>\n<div><p class=\"soft\">Geometric means of time and RMSE, each divided by "
                "those of <b>");
        report_html_text(page, yardstick);
        fprintf(page,
                "</b> on the same scene: a method counts by the scenes that it can do. The line: "
                "what no other one beats in both. Hollow: planes only.</p>\n<div "
                "class=\"scroll\"><table "
                "class=\"figures\"><thead><tr><th><button type=\"button\">method</button></th>"
                "<th><button type=\"button\">time</button></th><th><button type=\"button\">RMSE"
                "</button></th><th><button type=\"button\">scenes</button></th></tr></thead>\n"
                "<tbody>\n");
        for (size_t i = 0; i < shown; i++) {
            fprintf(page, "<tr><td><i class=\"dot\" style=\"background:var(--c%d)\"></i>",
                    points[i].color);
            report_html_text(page, points[i].label);
            fprintf(page,
                    "</td><td data-value=\"%.6g\">%.3g</td><td data-value=\"%.6g\">%.3g</td>"
                    "<td data-value=\"%zu\">%zu</td></tr>\n",
                    points[i].time, points[i].time, points[i].error, points[i].error, shares[i],
                    shares[i]);
        }
        fprintf(page, "</tbody>\n</table></div></div></div>\n");
    }
    free(points);
    free(shares);
}

void report_html_summary(FILE *page, const struct compare_run *run)
{
    if (run->scene_count < 2)
        return;
    size_t count;
    const struct compare_entry **entries = list_entries(run, &count);
    if (!entries)
        return;
    fprintf(page, "<section id=\"summary\">\n<h2>Which method?</h2>\n");
    report_html_kinds(page, run, entries, count);
    put_overall(page, run, entries, count);
    put_advice(page, run);
    put_matrix(page, run, entries, count);
    fprintf(page, "</section>\n");
    free(entries);
}
