/* cli/compare_papers.c: tables and figures of the papers made again on this machine. Rows of
 * methods that this program lacks stay empty and say so; nothing here needs a method to exist.
 */
#define _GNU_SOURCE
#include "compare_curves.h"

#include <math.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

enum { FIGURE_WIDTH = 320, FIGURE_HEIGHT = 240, FIGURE_TRUTH = 1024 };

/* Pictures by scene and entries, in the order of the papers. */
static const struct {
    const char *paper, *title, *scene, *entries, *note;
} figure_rows[] = {
    {"planar", "Area shadows of two boxes", "two-boxes",
     "planar:3,planar:8,planar:16,planar:tolerance=0.0156",
     "The paper's 3 samples, more, and the mesh refined to a tolerance. The ground alone."},
    {"planar", "Contact: a pole that stands on the ground", "pole", "planar:3,planar:8,planar:16",
     "The shadow begins hard at the foot."},
    {"line-map", "Figure 8: a part of the ground sees the light but no sample", "overlap",
     "line-map:2:between=dark,line-map:3:between=dark,line-map:2,sampled-maps:2,sampled-maps:3",
     "As in the paper (between=dark) the middle is dark with two samples, with a jump at its "
     "border; a third one mends it, and so does what lies between the samples told by the "
     "occluders."},
    {"line-map", "Figure 9: one blocker", "blocker",
     "line-map:2,line-map:2:path=opengl,reference:10,reference:200",
     "The paper sets two samples beside 10 and 200 ray-traced ones."},
    {"line-map", "Figure 10: jack-in-the-box under a tube", "jack-tube",
     "line-map:2:between=dark,line-map:2,line-map:3,line-map:samples=auto,sampled-maps:3,reference:"
     "200",
     "The point of the clown's shadow sees no sample of two."},
    {"line-map", "Figure 10: a light by its edges", "triangle-light", "line-map:3,sampled-maps:3",
     "Crude, as the paper says."},
    {"dbuffer", "Figure 8(a): far from the ground", "distance-1",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact", ""},
    {"dbuffer", "Figure 8(a): near the ground", "distance-4",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact", ""},
    {"dbuffer", "Figure 8(b): a small light", "light-size-1",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact", ""},
    {"dbuffer", "Figure 8(b): a large light", "light-size-4",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact", ""},
    {"dbuffer", "Figure 8(c): a concave occluder of 5,760 triangles", "complex",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact",
     "The paper sets it beside 1,024 ray-traced samples: the truth here."},
    {"dbuffer", "Figure 7: a prism under a very large light", "prism",
     "dbuffer:layers=1:v=paper,dbuffer,hard-map,exact",
     "One silhouette from the light's middle gives the wrong outline."},
    {"wedge-blend", "Figure 1: 81 spheres", "spheres-9x9",
     "wedge,wedge-probabilistic,wedge-blend,hard-volume,exact",
     "Overlapping penumbrae: added (wedge) they come out too dark."},
    {"wedge-blend", "Figure 2: 27 spheres in a cube", "spheres-3x3x3",
     "wedge,wedge-probabilistic,wedge-blend,hard-volume,exact", ""},
};

/* Table 1 of Jakobsen, Christensen, Larsen, Petersen (2004): frames a second. */
static const struct {
    const char *scene, *title;
    double paper[3];
} table_rows[] = {
    {"distance-1", "Figure 8(a), 224 triangles", {212, 120, 61}},
    {"light-size-3", "Figure 8(b), 960 triangles", {107, 75, 45}},
    {"complex", "Figure 8(c), 5,760 triangles", {14.2, 13, 12.1}},
    {"complex-1440", "simplified, 1,440 triangles", {28.4, 21.3, 16.9}},
};
static const int table_sizes[] = {300, 600, 1000};
static const char *const table_methods[] = {"dbuffer", "hard-map", "hard-volume",
                                            "pcss",    "exact",    "reference:16"};

static int no_memory(void)
{
    return cli_error("memory", "none left");
}

static struct cli_options make_options(const struct cli_session *session, int width, int height)
{
    return (struct cli_options){.command = session->options->command,
                                .threads = session->options->threads,
                                .all_methods = true,
                                .width = width,
                                .height = height,
                                .size_given = true};
}

/* ---- figures ---- */

static bool add_missing(struct compare_figure *figure, const char *name, size_t length)
{
    char **grown = realloc(figure->missing, (figure->missing_count + 1) * sizeof(*figure->missing));
    if (!grown)
        return false;
    figure->missing = grown;
    grown[figure->missing_count] = strndup(name, length);
    return grown[figure->missing_count++] != NULL;
}

/* Those of the list whose method this program has. */
static bool choose(struct cli_options *options, const char *list, struct compare_figure *figure)
{
    for (const char *entry = list; *entry; entry += *entry == ',') {
        size_t length = strcspn(entry, ",");
        char text[160];
        snprintf(text, sizeof(text), "%.*s", (int)length, entry);
        if (cli_knows_entry(entry, length) ? !cli_add_methods(options, text)
                                           : !add_missing(figure, entry, length))
            return false;
        entry += length;
    }
    return true;
}

static int run_figure(struct cli_session *session, size_t row, struct compare_figure *figure)
{
    struct cli_options options = make_options(session, FIGURE_WIDTH, FIGURE_HEIGHT);
    char path[100];
    snprintf(path, sizeof(path), "builtin:%s", figure_rows[row].scene);
    *figure = (struct compare_figure){.paper = figure_rows[row].paper,
                                      .title = figure_rows[row].title,
                                      .note = figure_rows[row].note};
    figure->scene = (struct compare_scene){.path = strdup(path), .options = &options};
    int result = figure->scene.path && choose(&options, figure_rows[row].entries, figure)
                     ? CLI_GO_ON
                     : no_memory();
    if (result == CLI_GO_ON && options.choice_count)
        result = compare_scene_run(session, NULL, FIGURE_TRUTH, &figure->scene);
    figure->scene.options = NULL;
    /* Its parameters' texts go with the options. */
    for (size_t i = 0; i < figure->scene.entry_count; i++)
        figure->scene.entries[i].param_count = 0;
    cli_options_finish(&options);
    return result;
}

/* ---- the table of frame rates ---- */

static char *print(const char *format, ...)
{
    char text[200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    return strdup(text);
}

static int run_cell(struct cli_session *session, struct cli_options *options,
                    struct compare_rates *rates, size_t row, size_t column)
{
    char path[100];
    snprintf(path, sizeof(path), "builtin:%s", table_rows[row].scene);
    options->width = options->height = table_sizes[column];
    struct compare_scene scene = {.path = path, .options = options};
    int result = compare_scene_run(session, NULL, 1, &scene);
    for (size_t i = 0; i < scene.entry_count && result == CLI_GO_ON; i++)
        for (size_t k = 0; k < rates->track_count; k++)
            if (strcmp(rates->tracks[k].label, scene.entries[i].label) == 0)
                rates->tracks[k].ms[row * rates->column_count + column] =
                    scene.entries[i].milliseconds;
    compare_scene_finish(session->context, &scene);
    return result;
}

static int run_table(struct cli_session *session, struct compare_rates *rates)
{
    const size_t rows = COUNT(table_rows), columns = COUNT(table_sizes);
    struct cli_options options = make_options(session, 0, 0);
    bool good = true;
    for (size_t i = 0; i < COUNT(table_methods) && good; i++)
        if (cli_knows_entry(table_methods[i], strlen(table_methods[i])))
            good = cli_add_methods(&options, table_methods[i]);
    *rates = (struct compare_rates){
        .title = "Table 1: frames a second",
        .note =
            "The paper's machine was of 2004; its numbers are whole frames, ours the visibility "
            "alone, without the primary surface and shading.",
        .paper_name = "dbuffer",
        .rows = calloc(rows, sizeof(*rates->rows)),
        .columns = calloc(columns, sizeof(*rates->columns)),
        .paper = calloc(rows * columns, sizeof(*rates->paper)),
        .tracks = calloc(options.choice_count + 1, sizeof(*rates->tracks)),
        .row_count = rows,
        .column_count = columns};
    good = good && rates->rows && rates->columns && rates->paper && rates->tracks;
    for (size_t k = 0; k < columns && good; k++)
        good =
            (rates->columns[k] = print("%d \xc3\x97 %d", table_sizes[k], table_sizes[k])) != NULL;
    for (size_t i = 0; i < rows && good; i++) {
        good = (rates->rows[i] = print("%s", table_rows[i].title)) != NULL;
        for (size_t k = 0; k < columns && good; k++)
            rates->paper[i * columns + k] = table_rows[i].paper[k];
    }
    for (size_t i = 0; i < options.choice_count && good; i++) {
        struct compare_track *track = &rates->tracks[rates->track_count++];
        options.choices[i].figures_only = true;
        snprintf(track->label, sizeof(track->label), "%s", options.choices[i].label);
        track->method = pnb_method_find(options.choices[i].method);
        good = (track->ms = calloc(rows * columns, sizeof(double))) != NULL;
        for (size_t k = 0; k < rows * columns && good; k++)
            track->ms[k] = NAN;
    }
    int result = good ? CLI_GO_ON : no_memory();
    for (size_t i = 0; i < rows && result == CLI_GO_ON; i++)
        for (size_t k = 0; k < columns && result == CLI_GO_ON; k++)
            result = run_cell(session, &options, rates, i, k);
    cli_options_finish(&options);
    return result;
}

/* ---- outlines ---- */

/* Triangles thin; lines of equal intensity, the rings, in colours from the outside in. */
static char *draw_shadow(const pnb_shadow_view *view)
{
    char *text = NULL;
    size_t size;
    double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
    FILE *file = open_memstream(&text, &size);
    if (!file)
        return NULL;
    /* What shows is the penumbra: behind the light's plane the ground is dark without end. */
    for (size_t t = 0; t < 3 * view->triangle_count; t++) {
        uint32_t v = view->indices[t], next = view->indices[t % 3 == 2 ? t - 2 : t + 1],
                 last = view->indices[t % 3 == 0 ? t + 2 : t - 1];
        bool flat = view->intensities[v] == view->intensities[next] &&
                    view->intensities[v] == view->intensities[last];
        for (int a = 0; a < 2 && !flat; a++) {
            low[a] = fmin(low[a], view->coordinates[2 * v + (size_t)a]);
            high[a] = fmax(high[a], view->coordinates[2 * v + (size_t)a]);
        }
    }
    for (int a = 0; a < 2; a++) {
        double margin = 0.08 * (high[a] - low[a]);
        low[a] -= margin, high[a] += margin;
    }
    double scale = 1000 / fmax(high[0] - low[0], 1e-9);
    fprintf(file,
            "<svg class=\"outlines\" viewBox=\"-10 -10 1020 %.0f\" role=\"img\" "
            "aria-label=\"triangles and rings of the shadow\">\n",
            (high[1] - low[1]) * scale + 20);
    for (int pass = -1; pass < view->ring_count; pass++) {
        double level = view->ring_count > 1 ? pass / (double)(view->ring_count - 1) : 0;
        if (pass < 0)
            fprintf(file, "<path class=\"mesh\" d=\"");
        else
            fprintf(file, "<path class=\"ring\" stroke=\"var(--c%d)\" d=\"", pass % 7);
        for (size_t t = 0; t < 3 * view->triangle_count; t++) {
            uint32_t a = view->indices[t], b = view->indices[t % 3 == 2 ? t - 2 : t + 1];
            /* A ring has a triangle that slopes on one side of it at least. */
            double beyond = view->intensities[view->indices[t % 3 == 0 ? t + 2 : t - 1]] - level;
            bool ring = fabs(view->intensities[a] - level) < 1e-4 &&
                        fabs(view->intensities[b] - level) < 1e-4 && fabs(beyond) > 1e-4;
            if (pass < 0 ? a > b : !ring)
                continue;
            fprintf(file, "M%.0f %.0fL%.0f %.0f", (view->coordinates[2 * a] - low[0]) * scale,
                    (high[1] - view->coordinates[2 * a + 1]) * scale,
                    (view->coordinates[2 * b] - low[0]) * scale,
                    (high[1] - view->coordinates[2 * b + 1]) * scale);
        }
        fprintf(file, "\"/>\n");
    }
    fprintf(file, "</svg>\n");
    fclose(file);
    return text;
}

static int run_outlines(struct cli_session *session, struct compare_papers *papers)
{
    static const int rings[] = {3, 8, 16};
    pnb_scene *scene = NULL;
    if (!pnb_method_find("planar"))
        return CLI_GO_ON;
    if (pnb_scene_load(session->context, "builtin:knot", &scene) != PNB_OK)
        return cli_session_fail(session);
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    int result = CLI_GO_ON;
    for (size_t k = 0; k < COUNT(rings) && result == CLI_GO_ON; k++) {
        struct compare_outlines *outlines = &papers->outlines[papers->outline_count++];
        double times[9];
        for (int i = 0; i < 9 && result == CLI_GO_ON; i++) {
            pnb_solver_desc desc = {.samples = rings[k]};
            pnb_shadow *shadow = NULL;
            pnb_solver_report report;
            pnb_shadow_view view;
            if (pnb_shadow_create(session->context, scene, &light, &desc, &shadow) != PNB_OK) {
                result = cli_session_fail(session);
                break;
            }
            pnb_shadow_get_report(shadow, &report);
            pnb_shadow_get(shadow, &view);
            times[i] = report.visibility_ms;
            if (i == 0) {
                outlines->rings = view.ring_count;
                outlines->vertices = view.vertex_count;
                outlines->triangles = view.triangle_count;
                outlines->drawing = k == 0 ? draw_shadow(&view) : NULL;
            }
            pnb_shadow_destroy(shadow);
        }
        if (result == CLI_GO_ON)
            outlines->milliseconds = cli_median(times, 9);
    }
    pnb_scene_destroy(scene);
    return result;
}

/* ---- all of it ---- */

double compare_papers_units(void)
{
    struct cli_options figure = {.width = FIGURE_WIDTH, .height = FIGURE_HEIGHT};
    return (double)COUNT(figure_rows) * compare_scene_units(&figure, FIGURE_TRUTH, 0) +
           (double)(COUNT(table_rows) * COUNT(table_sizes) * COUNT(table_methods)) * 200;
}

int compare_papers_run(struct cli_session *session, struct compare_papers *papers)
{
    papers->figures = calloc(COUNT(figure_rows), sizeof(*papers->figures));
    int result = papers->figures ? run_outlines(session, papers) : no_memory();
    for (size_t i = 0; i < COUNT(figure_rows) && result == CLI_GO_ON; i++)
        result = run_figure(session, i, &papers->figures[papers->figure_count++]);
    return result == CLI_GO_ON ? run_table(session, &papers->dbuffer) : result;
}

static void free_texts(char **texts, size_t count)
{
    for (size_t i = 0; texts && i < count; i++)
        free(texts[i]);
    free(texts);
}

void compare_papers_finish(pnb_context *context, struct compare_papers *papers)
{
    for (size_t i = 0; i < papers->figure_count; i++) {
        struct compare_figure *figure = &papers->figures[i];
        free((char *)figure->scene.path);
        compare_scene_finish(context, &figure->scene);
        free_texts(figure->missing, figure->missing_count);
    }
    free(papers->figures);
    for (size_t i = 0; i < papers->outline_count; i++)
        free(papers->outlines[i].drawing);
    struct compare_rates *rates = &papers->dbuffer;
    free_texts(rates->rows, rates->row_count);
    free_texts(rates->columns, rates->column_count);
    free(rates->paper);
    for (size_t i = 0; i < rates->track_count; i++)
        free(rates->tracks[i].ms);
    free(rates->tracks);
}

json_t *report_json_papers(const struct compare_run *run, const struct compare_papers *papers)
{
    json_t *object = json_object(), *figures = json_array(), *rows = json_array(),
           *outlines = json_array();
    for (size_t i = 0; i < papers->figure_count; i++) {
        json_t *figure = report_json_scene(run, &papers->figures[i].scene);
        json_object_set_new(figure, "paper", json_string(papers->figures[i].paper));
        json_object_set_new(figure, "title", json_string(papers->figures[i].title));
        json_array_append_new(figures, figure);
    }
    const struct compare_rates *rates = &papers->dbuffer;
    for (size_t r = 0; r < rates->row_count; r++)
        for (size_t c = 0; c < rates->column_count; c++)
            for (size_t k = 0; k < rates->track_count; k++) {
                json_t *row = json_object();
                size_t at = r * rates->column_count + c;
                json_object_set_new(row, "scene", json_string(rates->rows[r]));
                json_object_set_new(row, "size", json_string(rates->columns[c]));
                json_object_set_new(row, "label", json_string(rates->tracks[k].label));
                json_object_set_new(row, "milliseconds", cli_json_number(rates->tracks[k].ms[at]));
                if (strcmp(rates->tracks[k].label, rates->paper_name) == 0)
                    json_object_set_new(row, "paper_frames_per_second",
                                        cli_json_number(rates->paper[at]));
                json_array_append_new(rows, row);
            }
    for (size_t i = 0; i < papers->outline_count; i++) {
        json_t *row = json_object();
        json_object_set_new(row, "samples", json_integer(papers->outlines[i].rings));
        json_object_set_new(row, "milliseconds", cli_json_number(papers->outlines[i].milliseconds));
        json_object_set_new(row, "triangles",
                            json_integer((json_int_t)papers->outlines[i].triangles));
        json_array_append_new(outlines, row);
    }
    json_object_set_new(object, "figures", figures);
    json_object_set_new(object, "dbuffer_table_1", rows);
    json_object_set_new(object, "planar_knot", outlines);
    return object;
}

/* ---- the page ---- */

static const struct {
    const char *method, *title, *claims;
} paper_heads[] = {
    {"planar", "Boehl, Stuerzlinger: Real-Time Computation of Area Shadows (2006)",
     "The paper: about 10 frames a second for 5,000 vertices and 3 samples on a processor of 1 "
     "GHz; "
     "no errors."},
    {"line-map", "Heidrich, Brabec, Seidel: Soft Shadow Maps for Linear Lights (2000)",
     "The paper: 20 frames a second to walk through with fixed maps; 2 s to rebuild them in the "
     "worst "
     "case; about the cost of ray tracing with a handful of samples; no errors."},
    {"dbuffer",
     "Jakobsen, Christensen, Larsen, Petersen: Boundary Correct Real-Time Soft Shadows "
     "(2004)",
     "The paper: Table 1, below; no errors."},
    {"wedge-blend",
     "Forest, Barthe, Paulin: Realistic Soft Shadows by Penumbra-Wedges Blending (2006)",
     "The paper, on two GeForce 7800 GTX at 800 x 600: half the speed of penumbra wedges at 762 "
     "triangles, 21 % slower on average, limited by the processor from 17,482 triangles on; no "
     "errors, and figure 12 without numbers in its text."},
};

static void put_figure(FILE *page, const struct compare_figure *figure)
{
    const struct compare_scene *scene = &figure->scene;
    fprintf(page, "<h4>");
    report_html_text(page, figure->title);
    fprintf(page, " <span>%s</span></h4>\n", report_scene_name(scene));
    if (*figure->note || figure->missing_count) {
        fprintf(page, "<p class=\"soft\">");
        report_html_text(page, figure->note);
        for (size_t i = 0; i < figure->missing_count; i++) {
            fprintf(page, i ? ", " : " Not in this build: ");
            report_html_text(page, figure->missing[i]);
        }
        fprintf(page, figure->missing_count ? ".</p>\n" : "</p>\n");
    }
    if (!scene->truth_picture.bytes)
        return;
    fprintf(page, "<div class=\"films\">\n<figure><img alt=\"truth\" src=\"");
    report_html_png(page, &scene->truth_picture);
    fprintf(page, "\"><figcaption>truth, %d samples</figcaption></figure>\n", scene->truth_samples);
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        fprintf(page, "<figure><img alt=\"");
        report_html_text(page, entry->label);
        fprintf(page, "\" src=\"");
        report_html_png(page, &entry->picture);
        fprintf(page, "\"><img alt=\"its error\" src=\"");
        report_html_png(page, &entry->error_map);
        fprintf(page, "\"><figcaption>");
        report_html_entry(page, entry->method, entry->label);
        fprintf(page, "<br>RMSE %.4f, ", entry->errors.rmse);
        report_html_duration(page, entry->milliseconds);
        fprintf(page, "</figcaption></figure>\n");
    }
    fprintf(page, "</div>\n");
    for (size_t i = 0; i < scene->note_count; i++) {
        fprintf(page, "<p class=\"soft\">");
        report_html_text(page, scene->notes[i]);
        fprintf(page, "</p>\n");
    }
}

static void put_outlines(FILE *page, const struct compare_papers *papers)
{
    if (!papers->outline_count)
        return;
    fprintf(page,
            "<h4>Frame rate <span>the torus knot of 5,000 vertices; the whole soft shadow as "
            "triangles</span></h4>\n<div class=\"pair\"><div><table><thead><tr><th>samples</th>"
            "<th>triangles of the shadow</th><th>ms</th><th>frames a second</th><th>the "
            "paper's</th></tr></thead><tbody>\n");
    for (size_t i = 0; i < papers->outline_count; i++) {
        const struct compare_outlines *outlines = &papers->outlines[i];
        fprintf(page, "<tr><td>%d</td><td>", outlines->rings);
        report_html_count(page, outlines->triangles);
        fprintf(page, "</td><td>%.2f</td><td>%.0f</td><td>%s</td></tr>\n", outlines->milliseconds,
                1e3 / outlines->milliseconds, outlines->rings == 3 ? "about 10" : "\xe2\x80\x93");
    }
    fprintf(page,
            "</tbody></table></div>\n<div>%s<p class=\"soft\">Figures 8 and 9: the rings of three "
            "samples, from the outside in, and the triangles between them.</p></div></div>\n",
            papers->outlines[0].drawing ? papers->outlines[0].drawing : "");
}

static void put_rates(FILE *page, const struct compare_rates *rates)
{
    fprintf(page,
            "<h4>%s</h4>\n<p class=\"soft\">%s</p>\n<div class=\"scroll\"><table><thead><tr><th>"
            "</th><th>size</th><th>the paper</th>",
            rates->title, rates->note);
    bool there = false;
    for (size_t k = 0; k < rates->track_count; k++) {
        there |= strcmp(rates->tracks[k].label, rates->paper_name) == 0;
        fprintf(page, "<th>");
        report_html_entry(page, rates->tracks[k].method, rates->tracks[k].label);
        fprintf(page, "</th>");
    }
    fprintf(page, "</tr></thead><tbody>\n");
    for (size_t r = 0; r < rates->row_count; r++)
        for (size_t c = 0; c < rates->column_count; c++) {
            size_t at = r * rates->column_count + c;
            fprintf(page, "<tr><td>%s</td><td>%s</td><td>%g</td>", c ? "" : rates->rows[r],
                    rates->columns[c], rates->paper[at]);
            for (size_t k = 0; k < rates->track_count; k++) {
                double rate = 1e3 / rates->tracks[k].ms[at];
                if (isfinite(rate))
                    fprintf(page, rate < 10 ? "<td>%.1f</td>" : "<td>%.0f</td>", rate);
                else
                    fprintf(page, "<td>\xe2\x80\x93</td>");
            }
            fprintf(page, "</tr>\n");
        }
    fprintf(page, "</tbody></table></div>\n");
    if (!there)
        fprintf(page, "<p class=\"soft\">Not in this build: %s.</p>\n", rates->paper_name);
}

/* Frames a second over polygons, of the curve over triangles. */
static void put_figure_12(FILE *page, const struct compare_curves *curves)
{
    const struct compare_curve *curve = &curves->curves[0];
    static const char *const names[] = {
        "wedge", "wedge-probabilistic", "wedge-blend", "hard-volume", "exact", "reference:64"};
    struct report_curve lines[COUNT(names)];
    double *rates = calloc(COUNT(names) * curve->count, sizeof(*rates));
    size_t shown = 0;
    for (size_t i = 0; rates && i < COUNT(names); i++)
        for (size_t k = 0; k < curve->track_count; k++) {
            if (strcmp(curve->tracks[k].label, names[i]) != 0)
                continue;
            double *rate = rates + shown * curve->count;
            for (size_t x = 0; x < curve->count; x++)
                rate[x] = 1e3 / curve->tracks[k].ms[x];
            lines[shown++] = (struct report_curve){.label = names[i],
                                                   .color = report_color(curve->tracks[k].method),
                                                   .x = curve->x,
                                                   .y = rate,
                                                   .count = curve->count};
        }
    fprintf(page,
            "<h4>Figure 12: frame rate over polygons <span>%s</span></h4>\n<div "
            "class=\"pair\"><div>",
            curve->note);
    report_plot_curves(page, lines, shown, "triangles", "frames a second");
    fprintf(page, "</div></div>\n");
    free(rates);
}

void report_html_papers(FILE *page, const struct compare_run *run,
                        const struct compare_papers *papers, const struct compare_curves *curves)
{
    fprintf(page,
            "<section id=\"papers\">\n<h2>The papers remade</h2>\n<p>Figures and tables of the "
            "papers, with their own numbers beside ours. Machine: ");
    report_html_text(page, run->processor);
    fprintf(page,
            ", %d thread%s. Pictures %d &times; %d; below each its error, at the scale of its "
            "row.</p>\n",
            run->threads, run->threads == 1 ? "" : "s", FIGURE_WIDTH, FIGURE_HEIGHT);
    for (size_t p = 0; p < COUNT(paper_heads); p++) {
        bool there = pnb_method_find(paper_heads[p].method) != NULL;
        fprintf(page, "<h3>%s</h3>\n<p class=\"soft\">%s%s</p>\n", paper_heads[p].title,
                paper_heads[p].claims, there ? "" : " <b>The method is not in this build.</b>");
        if (p == 0)
            put_outlines(page, papers);
        if (strcmp(paper_heads[p].method, "dbuffer") == 0)
            put_rates(page, &papers->dbuffer);
        if (strcmp(paper_heads[p].method, "wedge-blend") == 0 && curves)
            put_figure_12(page, curves);
        for (size_t i = 0; i < papers->figure_count; i++)
            if (strcmp(papers->figures[i].paper, paper_heads[p].method) == 0)
                put_figure(page, &papers->figures[i]);
    }
    fprintf(page, "</section>\n");
}
