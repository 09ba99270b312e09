/* cli/report_html.c: a comparison as one HTML file: style, script and pictures inside, nothing
 * fetched. Every text that is not ours is escaped. The sheet of images works without the script;
 * the wipe shows the same images again, by reference. */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "page_css.h"
#include "page_js.h"

void report_html_text(FILE *page, const char *text)
{
    for (; *text; text++)
        switch (*text) {
        case '&': fputs("&amp;", page); break;
        case '<': fputs("&lt;", page); break;
        case '>': fputs("&gt;", page); break;
        case '"': fputs("&quot;", page); break;
        case '\'': fputs("&#39;", page); break;
        default: fputc(*text, page);
        }
}

static void put_base64(FILE *page, const uint8_t *bytes, size_t size)
{
    static const char code[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t group = (uint32_t)bytes[i] << 16;
        if (i + 1 < size)
            group |= (uint32_t)bytes[i + 1] << 8;
        if (i + 2 < size)
            group |= bytes[i + 2];
        char text[4] = {code[group >> 18], code[group >> 12 & 63],
                        i + 1 < size ? code[group >> 6 & 63] : '=',
                        i + 2 < size ? code[group & 63] : '='};
        fwrite(text, 1, 4, page);
    }
}

/* 1,234,567 */
void report_html_count(FILE *page, size_t count)
{
    char digits[32];
    int length = snprintf(digits, sizeof(digits), "%zu", count);
    for (int i = 0; i < length; i++) {
        if (i > 0 && (length - i) % 3 == 0)
            fputc(',', page);
        fputc(digits[i], page);
    }
}

void report_html_duration(FILE *page, double ms)
{
    if (ms < 1000)
        fprintf(page, "%.3g ms", ms);
    else if (ms < 60e3)
        fprintf(page, "%.3g s", ms / 1e3);
    else
        fprintf(page, "%.0f min %02.0f s", floor(ms / 60e3), fmod(ms / 1e3, 60));
}

void report_html_png(FILE *page, const struct compare_png *png)
{
    fprintf(page, "data:image/png;base64,");
    put_base64(page, png->bytes, png->size);
}

void report_html_entry(FILE *page, const pnb_method_info *method, const char *label)
{
    fprintf(page, "<i class=\"dot\" style=\"background:var(--c%d)\"></i>", report_color(method));
    report_html_text(page, label);
}

/* What OpenGL ran on, if anything did. */
static void put_renderer(FILE *page, const struct compare_run *run)
{
    for (size_t s = 0; s < run->scene_count; s++)
        for (size_t i = 0; i < run->scenes[s].entry_count; i++) {
            const struct compare_entry *entry = &run->scenes[s].entries[i];
            if (!entry->method || entry->method->processor != PNB_PROCESSOR_OPENGL)
                continue;
            fprintf(page, "OpenGL on ");
            report_html_text(page, entry->device);
            fprintf(page, ", ");
            return;
        }
}

void report_html_begin(FILE *page, const struct compare_run *run)
{
    fprintf(page,
            "<!DOCTYPE html>\n<html lang=\"en\" class=\"no-script\">\n<head>\n"
            "<meta charset=\"utf-8\">\n"
            "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
            "<meta name=\"generator\" content=\"penumbra %s\">\n"
            "<link rel=\"icon\" href=\"data:,\">\n<title>Soft shadows compared: ",
            pnb_version());
    report_html_text(page, run->scenes[0].path);
    if (run->scene_count > 1)
        fprintf(page, " and %zu more", run->scene_count - 1);
    fprintf(page, "</title>\n<style>\n%s</style>\n</head>\n<body>\n", page_css);
    fprintf(page, "<header>\n<h1>Soft shadows, compared with the truth</h1>\n<p class=\"lead\">");
    fprintf(page, "%zu scene%s at %d \xc3\x97 %d, ", run->scene_count,
            run->scene_count == 1 ? "" : "s", run->options->width, run->options->height);
    report_html_text(page, run->processor);
    fprintf(page, ", %d thread%s, ", run->threads, run->threads == 1 ? "" : "s");
    put_renderer(page, run);
    fprintf(page, "%s</p>\n", run->date);
    fprintf(page, "<nav>");
    if (run->scene_count > 1)
        fprintf(page, "<a href=\"#summary\"><b>Which method?</b></a> ");
    if (run->motion_count)
        fprintf(page, "<a href=\"#motion\"><b>Motion</b></a> ");
    if (run->curves)
        fprintf(page, "<a href=\"#cost\"><b>Cost</b></a> ");
    if (run->papers)
        fprintf(page, "<a href=\"#papers\"><b>The papers remade</b></a> ");
    for (size_t i = 0; i < run->scene_count && run->scene_count > 1; i++) {
        fprintf(page, "<a href=\"#scene-%zu\">", i);
        report_html_text(page, report_scene_name(&run->scenes[i]));
        fprintf(page, "</a> ");
    }
    fprintf(page, "<a href=\"#reading\"><b>How to read this</b></a></nav>\n</header>\n");
}

const char *report_scene_name(const struct compare_scene *scene)
{
    return strncmp(scene->path, "builtin:", 8) == 0 ? scene->path + 8 : scene->path;
}

/* ---- the sheet ---- */

/* entry: "truth" or its number. */
static void put_image(FILE *page, const struct compare_scene *scene, const char *entry,
                      const char *kind, const char *label, const char *caption,
                      const struct compare_png *png)
{
    if (!png->bytes)
        return;
    fprintf(page,
            "<figure><img data-entry=\"%s\" data-kind=\"%s\" width=\"%d\" height=\"%d\" alt=\"",
            entry, kind, scene->width, scene->height);
    report_html_text(page, label);
    fprintf(page, ", %s\" src=\"data:image/png;base64,", caption);
    put_base64(page, png->bytes, png->size);
    fprintf(page, "\"><figcaption>%s</figcaption></figure>\n", caption);
}

/* The colours of the error maps in steps of equal error, as "r g b" of sRGB. */
static void put_ramp_color(FILE *page, double t, const char *separator)
{
    double rgb[3];
    pnb_colormap_diverging(t, rgb);
    for (int k = 0; k < 3; k++) {
        fprintf(page, "%s%.0f", k ? separator : "", compare_srgb(rgb[k]) * 255);
    }
}

static void put_ramp(FILE *page, const struct compare_scene *scene)
{
    static const double scales[] = {0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1};
    fprintf(page, "<div class=\"legend\"><div class=\"ramp\"><i style=\"background:"
                  "linear-gradient(90deg");
    for (int i = 0; i <= 32; i++) {
        fprintf(page, ",rgb(");
        put_ramp_color(page, i / 32.0, " ");
        fprintf(page, ")");
    }
    fprintf(
        page,
        ")\"></i><span><span>\xe2\x88\x92<b>%g</b> too dark</span><span>0</span><span>too light "
        "+<b>%g</b></span></span></div>",
        scene->error_scale, scene->error_scale);
    fprintf(page, "<label class=\"scripted\">colours end at <select class=\"scale\">");
    for (size_t i = 0; i < sizeof(scales) / sizeof(scales[0]); i++)
        fprintf(page, "<option value=\"%g\"%s>%g</option>", scales[i],
                scales[i] == scene->error_scale ? " selected" : "", scales[i]);
    fprintf(page, "</select></label><div><i class=\"swatch\" style=\"background:#444\"></i>not "
                  "compared: no surface, turned away from the light, or not done by the "
                  "method</div></div>\n");
}

static void put_sheet(FILE *page, const struct compare_scene *scene)
{
    fprintf(page, "<h3>Pictures, visibility and errors</h3>\n");
    put_ramp(page, scene);
    fprintf(page, "<div class=\"row\"><h4>truth<span>%d samples per pixel</span></h4>\n",
            scene->truth_samples);
    put_image(page, scene, "truth", "picture", "truth", "picture", &scene->truth_picture);
    put_image(page, scene, "truth", "visibility", "truth", "visibility", &scene->truth_visibility);
    fprintf(page, "</div>\n");
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        char number[24];
        if (entry->figures_only)
            continue;
        snprintf(number, sizeof(number), "%zu", i);
        fprintf(page, "<div class=\"row\"><h4>");
        report_html_text(page, entry->label);
        fprintf(page, "<span>RMSE %.5f", entry->errors.rmse);
        if (isfinite(entry->milliseconds)) {
            fprintf(page, ", ");
            report_html_duration(page, entry->milliseconds);
        }
        fprintf(page, "</span></h4>\n");
        put_image(page, scene, number, "picture", entry->label, "picture", &entry->picture);
        put_image(page, scene, number, "visibility", entry->label, "visibility",
                  &entry->visibility);
        put_image(page, scene, number, "error", entry->label,
                  entry->picture_only ? "error of the luminance" : "error of the visibility",
                  &entry->error_map);
        fprintf(page, "<figure>");
        report_plot_histogram(page, scene, entry);
        fprintf(page, "<figcaption>pixels by error, logarithmic; exact ones left out"
                      "</figcaption></figure>\n</div>\n");
    }
}

/* ---- the table ---- */

struct column {
    const char *title, *hint;
    const char *format;
    double factor;
    bool ranked; /* the smallest size is the best */
};

enum { COLUMN_COUNT = 9 };

static const struct column columns[COLUMN_COUNT] = {
    {"visibility, ms", "one frame, nothing cached but what is made once per mesh", "%.2f", 1, true},
    {"prepare, ms", "once per mesh", "%.2f", 1, false},
    {"RMSE", "root mean square error in the penumbra", "%.5f", 1, true},
    {"mean", "signed: below 0 too dark, above too light", "%+.5f", 1, true},
    {"99 %", "99 of 100 penumbra pixels are off by less", "%.5f", 1, true},
    {"largest", "over all compared pixels", "%.5f", 1, true},
    {"umbra leak", "share of the umbra that gets light", "%.2f&#8201;%%", 100, true},
    {"lit darkening", "share of the lit surface that is shadowed", "%.2f&#8201;%%", 100, true},
    {"pixels", "compared", "%.0f", 1, false},
};

static double cell(const struct compare_entry *entry, int column)
{
    const pnb_errors *e = &entry->errors;
    const double values[COLUMN_COUNT] = {
        entry->milliseconds, entry->prepare_ms, e->rmse,          e->mean_error,     e->p99_error,
        e->max_error,        e->umbra_leak,     e->lit_darkening, (double)e->pixels,
    };
    bool measured = e->pixels > 0 || column < 2 || column == COLUMN_COUNT - 1;
    return measured ? values[column] : NAN;
}

static void put_table(FILE *page, const struct compare_scene *scene)
{
    fprintf(page, "<h3>Figures</h3>\n<div class=\"scroll\"><table class=\"figures\">\n<thead><tr>"
                  "<th scope=\"col\"><button type=\"button\">method</button></th>");
    double best[COLUMN_COUNT];
    for (int c = 0; c < COLUMN_COUNT; c++) {
        fprintf(page, "<th scope=\"col\" title=\"%s\"><button type=\"button\">%s</button></th>",
                columns[c].hint, columns[c].title);
        /* Where all are equal there is no best. */
        double worst = 0;
        best[c] = INFINITY;
        for (size_t i = 0; i < scene->entry_count; i++) {
            double size = fabs(cell(&scene->entries[i], c));
            if (isfinite(size)) {
                best[c] = fmin(best[c], size);
                worst = fmax(worst, size);
            }
        }
        if (!columns[c].ranked || worst <= best[c])
            best[c] = -1;
    }
    fprintf(page, "</tr></thead>\n<tbody>\n");
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        fprintf(page, "<tr><td>");
        report_html_entry(page, entry->method, entry->label);
        fprintf(page, "</td>");
        for (int c = 0; c < COLUMN_COUNT; c++) {
            double value = cell(entry, c);
            bool mark = fabs(value) <= best[c];
            if (!isfinite(value)) {
                fprintf(page, "<td data-value=\"NaN\">\xe2\x80\x93</td>");
                continue;
            }
            fprintf(page, "<td data-value=\"%.9g\"%s>", value, mark ? " class=\"best\"" : "");
            if (c == COLUMN_COUNT - 1)
                report_html_count(page, (size_t)value);
            else if (columns[c].format)
                fprintf(page, columns[c].format, value * columns[c].factor);
            fprintf(page, "</td>");
        }
        fprintf(page, "</tr>\n");
    }
    fprintf(page, "</tbody>\n</table></div>\n");
    bool any = false;
    for (size_t i = 0; i < scene->entry_count; i++)
        for (size_t w = 0; w < scene->entries[i].warning_count; w++) {
            fprintf(page, any ? "<li>" : "<ul class=\"warnings\"><li>");
            any = true;
            report_html_text(page, scene->entries[i].label);
            fprintf(page, ": ");
            report_html_text(page, scene->entries[i].warnings[w]);
            fprintf(page, "</li>");
        }
    if (any)
        fprintf(page, "</ul>\n");
}

/* ---- the wipe ---- */

static void put_select(FILE *page, const struct compare_scene *scene, const char *label,
                       size_t chosen, const char *style)
{
    fprintf(page, "<select aria-label=\"%s\" class=\"%s\">", label, style);
    fprintf(page, "<option value=\"truth\"%s>truth</option>", chosen == 0 ? " selected" : "");
    for (size_t i = 0; i < scene->entry_count; i++) {
        if (scene->entries[i].figures_only)
            continue;
        fprintf(page, "<option value=\"%zu\"%s>", i, chosen == i + 1 ? " selected" : "");
        report_html_text(page, scene->entries[i].label);
        fprintf(page, "</option>");
    }
    fprintf(page, "</select>");
}

static void put_wipe(FILE *page, const struct compare_scene *scene)
{
    fprintf(page, "<div class=\"wipe\">\n<div class=\"bar\">");
    size_t first = 0; /* the first with pictures */
    while (first < scene->entry_count && scene->entries[first].figures_only)
        first++;
    put_select(page, scene, "left image", first < scene->entry_count ? first + 1 : 0, "left");
    fprintf(page, "<span class=\"kinds\" role=\"group\" aria-label=\"what is shown\">"
                  "<button type=\"button\" data-kind=\"picture\">Picture</button>"
                  "<button type=\"button\" data-kind=\"visibility\">Visibility</button>"
                  "<button type=\"button\" data-kind=\"error\">Error</button></span>");
    put_select(page, scene, "right image", 0, "right");
    fprintf(page,
            "</div>\n<div class=\"stage\"><img class=\"under\" alt=\"right image\" width=\"%d\" "
            "height=\"%d\"><img class=\"over\" alt=\"left image\" width=\"%d\" height=\"%d\">"
            "<div class=\"seam\"></div><input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" "
            "value=\"50\" aria-label=\"where the left image ends\"></div>\n</div>\n",
            scene->width, scene->height, scene->width, scene->height);
}

static void put_share(FILE *page, size_t part, size_t whole, const char *what)
{
    fprintf(page, "%.1f&#8201;%% %s", whole ? 100.0 * (double)part / (double)whole : 0.0, what);
}

void report_html_scene(FILE *page, const struct compare_run *run, const struct compare_scene *scene,
                       size_t index)
{
    fprintf(page, "<section class=\"scene\" id=\"scene-%zu\">\n<h2>", index);
    report_html_text(page, report_scene_name(scene));
    fprintf(page, "</h2>\n");
    if (scene->title) {
        fprintf(page, "<p class=\"title\">");
        report_html_text(page, scene->title);
        fprintf(page, "</p>\n");
    }
    fprintf(page, "<p class=\"soft\">");
    report_html_count(page, scene->triangle_count);
    fprintf(page, " triangles. Light %zu of %zu: %s. Truth: ", scene->light_index,
            scene->light_count, scene->light_type);
    report_html_count(page, (size_t)scene->truth_samples);
    fprintf(page, " samples per pixel in ");
    report_html_duration(page, scene->truth_ms);
    fprintf(page, ". ");
    report_html_count(page, scene->facing_pixels);
    fprintf(page, " pixels face the whole light: ");
    put_share(page, scene->penumbra_pixels, scene->facing_pixels, "penumbra, ");
    put_share(page, scene->umbra_pixels, scene->facing_pixels, "umbra, ");
    put_share(page, scene->lit_pixels, scene->facing_pixels, "lit.</p>\n");
    if (scene->note_count) {
        fprintf(page, "<ul class=\"notes\">");
        for (size_t i = 0; i < scene->note_count; i++) {
            fprintf(page, "<li>");
            report_html_text(page, scene->notes[i]);
            fprintf(page, "</li>");
        }
        fprintf(page, "</ul>\n");
    }
    fprintf(page, "<div class=\"top\">\n");
    put_wipe(page, scene);
    fprintf(page, "<div>\n<p class=\"panel-title\">Error against time<span>the line: what no other "
                  "one beats in both; hollow: planes only</span></p>\n");
    report_plot_time(page, scene);
    fprintf(page, "</div>\n</div>\n");
    put_table(page, scene);
    put_sheet(page, scene);

    fprintf(page, "<h3>Settings</h3>\n<dl>\n");
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        if (entry->figures_only)
            continue;
        fprintf(page, "<dt>");
        report_html_text(page, entry->label);
        fprintf(page, "</dt><dd>");
        if (!entry->method) {
            fprintf(page, "file ");
            report_html_text(page, entry->name);
        } else {
            report_html_text(page, entry->method->title);
            if (entry->method->paper && *entry->method->paper) {
                fprintf(page, " (");
                report_html_text(page, entry->method->paper);
                fprintf(page, ")");
            }
            if (entry->samples)
                fprintf(page, "; %d samples", entry->samples);
            for (size_t p = 0; p < entry->param_count; p++) {
                fprintf(page, "; ");
                report_html_text(page, entry->params[p].key);
                fprintf(page, " = ");
                report_html_text(page, entry->params[p].value);
            }
            fprintf(page, "; ");
            report_html_text(page, entry->device);
            if (*entry->counters) {
                fprintf(page, "; ");
                report_html_text(page, entry->counters);
            }
        }
        fprintf(page, "</dd>\n");
    }
    fprintf(page, "</dl>\n</section>\n");
}

static const char explanation[] =
    "<h3 id=\"reading\">How to read this</h3>\n<dl class=\"explain\">\n"
    "<dt>Visibility</dt><dd>The share of the light&#8217;s area that a point sees: 1 lit, 0 umbra, "
    "between them penumbra.</dd>\n"
    "<dt>Error</dt><dd>Visibility minus truth. Only pixels count whose surface faces the whole "
    "light, since elsewhere the light&#8217;s horizon and not a shadow decides.</dd>\n"
    "<dt>RMSE, mean, 99&#8201;%</dt><dd>Over the penumbra: where the truth lies strictly between 0 "
    "and 1, or the error exceeds 1/255. Empty floor, which every method gets right, does not "
    "dilute them.</dd>\n"
    "<dt>Umbra leak</dt><dd>Share of the pixels in true umbra that get more than 1/255 of the "
    "light.</dd>\n"
    "<dt>Lit darkening</dt><dd>Share of the fully lit pixels that lose more than 1/255 of "
    "it.</dd>\n"
    "<dt>Time</dt><dd>The visibility of one frame with a moving light; what is made once per mesh "
    "is <i>prepare</i>, and finding the visible surface is the same work for every method and not "
    "counted. Quick methods are timed several times; the median counts.</dd>\n"
    "<dt>Pictures</dt><dd>Ambient light plus irradiance times visibility. They differ by the "
    "compared light alone: other lights have their true visibility in all of them.</dd>\n"
    "<dt>Names</dt><dd><code>method:64</code> is the method with 64 light samples, "
    "<code>method:key=value</code> with a parameter of its own; without either, its "
    "defaults.</dd>\n"
    "<dt>Files of other programs</dt><dd>One channel is taken as visibility. A picture is judged "
    "by its linear luminance minus that of the true picture; umbra, lit and penumbra are then "
    "those of the truth.</dd>\n</dl>\n";

void report_html_end(FILE *page, const struct compare_run *run)
{
    fprintf(page, "<footer>\n%s<h3>This comparison</h3>\n<dl>\n<dt>Command</dt><dd><code>",
            explanation);
    report_html_text(page, run->command);
    fprintf(page, "</code></dd>\n<dt>Machine</dt><dd>");
    report_html_text(page, run->processor);
    fprintf(page,
            ", %d thread%s</dd>\n<dt>Program</dt><dd>penumbra %s</dd>\n<dt>Date</dt><dd>%s</dd>\n"
            "</dl>\n</footer>\n<dialog><img alt=\"\"></dialog>\n",
            run->threads, run->threads == 1 ? "" : "s", pnb_version(), run->date);
    fprintf(page, "<script type=\"application/json\" id=\"ramp\">[");
    for (int i = 0; i <= 256; i++) {
        fprintf(page, "%s[", i ? "," : "");
        put_ramp_color(page, i / 256.0, ",");
        fprintf(page, "]");
    }
    fprintf(page, "]</script>\n<script>\n%s</script>\n</body>\n</html>\n", page_js);
}
