/* cli/report_motion.c: what the motion of a scene showed, for the report and for the page. */
#include "compare_motion.h"

#include <stdlib.h>

json_t *report_json_motion(const struct compare_motion *motion)
{
    json_t *methods = json_array();
    for (size_t i = 0; i < motion->entry_count; i++) {
        const struct compare_motion_entry *entry = &motion->entries[i];
        json_t *object = json_object(), *steps = json_array();
        json_object_set_new(object, "name", json_string(entry->method->name));
        json_object_set_new(object, "label", cli_json_text(entry->label));
        json_object_set_new(object, "milliseconds", cli_json_number(entry->milliseconds));
        json_object_set_new(object, "change", cli_json_number(entry->change));
        json_object_set_new(object, "truth_change", cli_json_number(entry->truth_change));
        json_object_set_new(object, "flicker", cli_json_number(entry->flicker));
        json_object_set_new(object, "popping", cli_json_number(entry->popping));
        json_object_set_new(object, "largest_jump", cli_json_number(entry->largest));
        json_object_set_new(object, "pixels", json_integer((json_int_t)entry->pixels));
        for (int f = 0; f + 1 < motion->frames; f++)
            json_array_append_new(steps, cli_json_number(entry->steps[f]));
        json_object_set_new(object, "steps", steps);
        json_array_append_new(methods, object);
    }
    json_t *object = json_object();
    json_object_set_new(object, "what", json_string(motion->what));
    json_object_set_new(object, "frames", json_integer(motion->frames));
    json_object_set_new(object, "width", json_integer(motion->width));
    json_object_set_new(object, "height", json_integer(motion->height));
    json_object_set_new(object, "truth_samples", json_integer(motion->truth_samples));
    json_object_set_new(object, "methods", methods);
    return object;
}

static void put_film(FILE *page, const char *label, const pnb_method_info *method,
                     const struct compare_png *slice, const struct compare_png *jumps)
{
    fprintf(page, "<figure class=\"film\"><figcaption>");
    if (method)
        report_html_entry(page, method, label);
    else
        report_html_text(page, label);
    fprintf(page, "</figcaption><img class=\"slice\" alt=\"a row of pixels over time\" src=\"");
    report_html_png(page, slice);
    fprintf(page, "\">");
    if (jumps) {
        fprintf(page, "<img alt=\"largest jump per pixel\" src=\"");
        report_html_png(page, jumps);
        fprintf(page, "\">");
    }
    fprintf(page, "</figure>\n");
}

void report_html_motion(FILE *page, const struct compare_motion *motion, size_t index)
{
    fprintf(page, "<div class=\"motion\" id=\"motion-%zu\">\n<h3>", index);
    report_html_text(page, motion->title);
    fprintf(page,
            ": %s</h3>\n<div class=\"top\"><div class=\"scroll\"><table class=\"figures\">"
            "<thead><tr><th><button type=\"button\">method</button></th>",
            motion->what);
    static const char *const heads[][2] = {
        {"flicker", "root mean square of the jumps that the truth does not make"},
        {"popping", "99.9 % of the jumps are below"},
        {"largest", "the largest jump"},
        {"own change", "root mean square of the method's own change between frames"},
        {"truth's", "of the truth's, at the same pixels"},
        {"ms", "visibility of a frame"}};
    for (size_t k = 0; k < sizeof(heads) / sizeof(heads[0]); k++)
        fprintf(page, "<th title=\"%s\"><button type=\"button\">%s</button></th>", heads[k][1],
                heads[k][0]);
    fprintf(page, "</tr></thead><tbody>\n");
    struct report_curve *curves = calloc(motion->entry_count + 1, sizeof(*curves));
    double *xs = calloc((size_t)motion->frames, sizeof(*xs));
    for (int f = 0; xs && f < motion->frames; f++)
        xs[f] = f + 1;
    for (size_t i = 0; i < motion->entry_count; i++) {
        const struct compare_motion_entry *entry = &motion->entries[i];
        const double values[] = {entry->flicker, entry->popping,      entry->largest,
                                 entry->change,  entry->truth_change, entry->milliseconds};
        fprintf(page, "<tr><td>");
        report_html_entry(page, entry->method, entry->label);
        fprintf(page, "</td>");
        for (int k = 0; k < 6; k++)
            fprintf(page,
                    k == 5 ? "<td data-value=\"%.6g\">%.3g</td>"
                           : "<td data-value=\"%.6g\">%.4f</td>",
                    values[k], values[k]);
        fprintf(page, "</tr>\n");
        if (curves && xs)
            curves[i] = (struct report_curve){.label = entry->label,
                                              .color = report_color(entry->method),
                                              .x = xs,
                                              .y = entry->steps,
                                              .count = (size_t)motion->frames - 1};
    }
    fprintf(page, "</tbody></table></div>\n<div>");
    if (curves && xs)
        report_plot_steps(page, curves, motion->entry_count, "step", "flicker");
    fprintf(page, "</div></div>\n<div class=\"films\">");
    put_film(page, "truth", NULL, &motion->truth_slice, NULL);
    for (size_t i = 0; i < motion->entry_count; i++)
        put_film(page, motion->entries[i].label, motion->entries[i].method,
                 &motion->entries[i].slice, &motion->entries[i].jumps);
    fprintf(page, "</div>\n</div>\n");
    free(curves);
    free(xs);
}

void report_html_motion_begin(FILE *page, const struct compare_motion *motion)
{
    fprintf(
        page,
        "<section id=\"motion\">\n<h2>Motion</h2>\n<p>How much more the visibility jumps from one "
        "frame to the next than the truth does. <b>Flicker</b>: the root mean square over the "
        "penumbra of (V&#8242; &minus; V) &minus; (T&#8242; &minus; T); an error that stays in its "
        "place makes none. <b>Popping</b>: 99.9&#8201;%% of those jumps are below. %d &times; %d "
        "pixels, truth with %d samples. The narrow pictures are one row of pixels over time, "
        "frame below frame: steps in them are popping. Below each, the largest jump of every "
        "pixel, from 0 (dark) to %g (bright). The truth's own noise is in all figures: what exact "
        "shows is mostly that.</p>\n",
        motion->width, motion->height, motion->truth_samples, COMPARE_JUMP_SCALE);
}
