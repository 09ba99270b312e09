/* cli/report_plot.c: the drawings of the page, as inline SVG coloured by its style sheet. */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define COLOR_COUNT 8

/* ---- error against time ---- */

enum {
    PLOT_WIDTH = 560,
    PLOT_HEIGHT = 420,
    PLOT_LEFT = 58,
    PLOT_RIGHT = 548,
    PLOT_TOP = 12,
    PLOT_BOTTOM = 372,
    LABEL_HEIGHT = 15
};

struct box {
    double x0, y0, x1, y1;
};

struct plot_point {
    double time, error, x, y;
    int color;
    const struct compare_entry *entry;
};

struct plot_axis {
    double low, high; /* log10 */
    double from, to;  /* of the drawing */
};

static double place(const struct plot_axis *axis, double value)
{
    return axis->from +
           (log10(value) - axis->low) / (axis->high - axis->low) * (axis->to - axis->from);
}

/* Wide enough for all values, with room, and at least about a decade. */
static struct plot_axis make_axis(double least, double most, double from, double to)
{
    double low = log10(least) - 0.15, high = log10(most) + 0.25;
    if (high - low < 1) {
        double middle = 0.5 * (low + high);
        low = middle - 0.5, high = middle + 0.5;
    }
    return (struct plot_axis){low, high, from, to};
}

/* 0.001, 0.5, 20, 3000: as people write them. */
static void format_tick(double value, char *text, size_t size)
{
    if (value >= 1e6 || value < 1e-5)
        snprintf(text, size, "%.0e", value);
    else
        snprintf(text, size, "%.*f", value < 0.99 ? (int)ceil(-log10(value) - 1e-9) : 0, value);
}

static void draw_ticks(FILE *page, const struct plot_axis *axis, bool horizontal)
{
    bool close = axis->high - axis->low < 2.2; /* decades alone would be too few labels */
    for (int decade = (int)floor(axis->low); decade <= (int)ceil(axis->high); decade++)
        for (int digit = 1; digit <= 9; digit++) {
            double value = digit * pow(10, decade);
            if (log10(value) < axis->low - 1e-9 || log10(value) > axis->high + 1e-9)
                continue;
            bool labelled = digit == 1 || (close && (digit == 2 || digit == 5));
            double at = place(axis, value);
            const char *style = labelled ? "grid" : "grid minor";
            char text[32];
            format_tick(value, text, sizeof(text));
            if (horizontal)
                fprintf(page, "<line class=\"%s\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>\n",
                        style, at, at, PLOT_TOP, PLOT_BOTTOM);
            else
                fprintf(page, "<line class=\"%s\" x1=\"%d\" x2=\"%d\" y1=\"%.1f\" y2=\"%.1f\"/>\n",
                        style, PLOT_LEFT, PLOT_RIGHT, at, at);
            if (labelled && horizontal)
                fprintf(page, "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%s</text>\n", at,
                        PLOT_BOTTOM + 18, text);
            else if (labelled)
                fprintf(page, "<text x=\"%d\" y=\"%.1f\" text-anchor=\"end\">%s</text>\n",
                        PLOT_LEFT - 8, at + 4, text);
        }
}

static bool overlap(const struct box *a, const struct box *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

/* The first place around the point where the label meets no other label and no point. */
static struct box place_label(const struct plot_point *point, const struct box *taken, size_t count)
{
    double width = 6.6 * (double)strlen(point->entry->label) + 4;
    struct box best = {0};
    size_t fewest = (size_t)-1;
    for (int ring = 0; ring < 4; ring++)
        for (int side = 0; side < 4; side++) {
            double dy = ring * LABEL_HEIGHT;
            double x =
                side < 2 ? (side == 0 ? point->x + 9 : point->x - 9 - width) : point->x - width / 2;
            double y = side < 2    ? point->y - LABEL_HEIGHT / 2.0 + (ring % 2 ? dy : -dy)
                       : side == 2 ? point->y - LABEL_HEIGHT - 8 - dy
                                   : point->y + 8 + dy;
            struct box box = {x, y, x + width, y + LABEL_HEIGHT};
            if (box.x0 < PLOT_LEFT || box.x1 > PLOT_RIGHT || box.y0 < PLOT_TOP ||
                box.y1 > PLOT_BOTTOM)
                continue;
            size_t hits = 0;
            for (size_t i = 0; i < count; i++)
                hits += overlap(&box, &taken[i]);
            if (hits < fewest) {
                fewest = hits;
                best = box;
            }
            if (hits == 0)
                return best;
        }
    if (fewest == (size_t)-1)
        best = (struct box){point->x + 9, point->y - 7, point->x + 9 + width, point->y + 8};
    return best;
}

/* Colours go to methods, in order of appearance. */
int report_color(const struct compare_scene *scene, const struct compare_entry *entry)
{
    int color = 0;
    for (size_t i = 0; i < scene->entry_count; i++) {
        const struct compare_entry *other = &scene->entries[i];
        if (strcmp(other->name, entry->name) == 0)
            break;
        bool first = true;
        for (size_t k = 0; k < i; k++)
            first &= strcmp(scene->entries[k].name, other->name) != 0;
        color += first;
    }
    return color % COLOR_COUNT;
}

static int by_method_and_samples(const void *a, const void *b)
{
    const struct plot_point *p = a, *q = b;
    int names = strcmp(p->entry->name, q->entry->name);
    return names
               ? names
               : (p->entry->samples > q->entry->samples) - (p->entry->samples < q->entry->samples);
}

void report_plot_time(FILE *page, const struct compare_scene *scene)
{
    struct plot_point *points = calloc(scene->entry_count + 1, sizeof(*points));
    struct box *taken = calloc(2 * scene->entry_count + 1, sizeof(*taken));
    size_t count = 0, boxes = 0;
    double times[2] = {INFINITY, 0}, errors[2] = {INFINITY, 0};
    for (size_t i = 0; points && i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        double time = entry->milliseconds, error = entry->errors.rmse;
        if (!isfinite(time) || !(time > 0) || entry->errors.pixels == 0)
            continue;
        error = fmax(error, 1e-5);
        points[count++] = (struct plot_point){
            .time = time, .error = error, .color = report_color(scene, entry), .entry = entry};
        times[0] = fmin(times[0], time), times[1] = fmax(times[1], time);
        errors[0] = fmin(errors[0], error), errors[1] = fmax(errors[1], error);
    }
    if (!points || !taken || count == 0) {
        fprintf(page, "<p class=\"soft\">No entry has a time.</p>\n");
        free(points);
        free(taken);
        return;
    }
    qsort(points, count, sizeof(*points), by_method_and_samples);
    struct plot_axis x = make_axis(times[0], times[1], PLOT_LEFT, PLOT_RIGHT);
    struct plot_axis y = make_axis(errors[0], errors[1], PLOT_BOTTOM, PLOT_TOP);
    fprintf(page,
            "<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"RMSE against "
            "milliseconds, both logarithmic\">\n",
            PLOT_WIDTH, PLOT_HEIGHT);
    draw_ticks(page, &x, true);
    draw_ticks(page, &y, false);
    fprintf(page,
            "<path class=\"axis\" fill=\"none\" d=\"M%d %dV%dH%d\"/>\n"
            "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">visibility of one frame, ms</text>\n"
            "<text transform=\"translate(12 %d) rotate(-90)\" text-anchor=\"end\">RMSE in the "
            "penumbra</text>\n",
            PLOT_LEFT, PLOT_TOP, PLOT_BOTTOM, PLOT_RIGHT, PLOT_RIGHT, PLOT_BOTTOM + 38, PLOT_TOP);

    /* One method at several settings is a line. */
    for (size_t i = 0; i < count; i++) {
        points[i].x = place(&x, points[i].time);
        points[i].y = place(&y, points[i].error);
        taken[boxes++] =
            (struct box){points[i].x - 6, points[i].y - 6, points[i].x + 6, points[i].y + 6};
        if (i > 0 && strcmp(points[i].entry->name, points[i - 1].entry->name) == 0)
            fprintf(page,
                    "<path class=\"series\" stroke=\"var(--c%d)\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n",
                    points[i].color, points[i - 1].x, points[i - 1].y, points[i].x, points[i].y);
    }
    for (size_t i = 0; i < count; i++) {
        const struct plot_point *point = &points[i];
        fprintf(page, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"5\" fill=\"var(--c%d)\"><title>",
                point->x, point->y, point->color);
        report_html_text(page, point->entry->label);
        fprintf(page, ": RMSE %.5f in %.2f ms</title></circle>\n", point->entry->errors.rmse,
                point->time);
        struct box box = place_label(point, taken, boxes);
        taken[boxes++] = box;
        bool left = box.x1 <= point->x, beside = left || box.x0 >= point->x;
        fprintf(page, "<text class=\"name\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">",
                left     ? box.x1
                : beside ? box.x0
                         : 0.5 * (box.x0 + box.x1),
                box.y1 - 3,
                left     ? "end"
                : beside ? "start"
                         : "middle");
        report_html_text(page, point->entry->label);
        fprintf(page, "</text>\n");
    }
    fprintf(page, "</svg>\n");
    free(points);
    free(taken);
}

/* ---- histogram ---- */

enum { BIN_COUNT = 61, BIN_WIDTH = 5, BINS_HEIGHT = 190 };

void report_plot_histogram(FILE *page, const struct compare_scene *scene,
                           const struct compare_entry *entry)
{
    size_t bins[BIN_COUNT] = {0}, most = 1;
    size_t pixels = (size_t)scene->width * (size_t)scene->height;
    for (size_t i = 0; i < pixels; i++) {
        double error = entry->error[i];
        if (isnan(error) || error == 0)
            continue;
        double at = floor((error / scene->error_scale + 1) * 0.5 * BIN_COUNT);
        size_t bin = at < 0 ? 0 : at >= BIN_COUNT ? BIN_COUNT - 1 : (size_t)at;
        if (++bins[bin] > most)
            most = bins[bin];
    }
    int width = BIN_COUNT * BIN_WIDTH;
    fprintf(page,
            "<svg class=\"histogram\" viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"number of "
            "pixels by error\">\n<path d=\"M0 %d",
            width, BINS_HEIGHT + 18, BINS_HEIGHT);
    for (int i = 0; i < BIN_COUNT; i++) {
        double height = BINS_HEIGHT * log1p((double)bins[i]) / log1p((double)most);
        fprintf(page, "V%.1fh%d", BINS_HEIGHT - height, BIN_WIDTH);
    }
    fprintf(page,
            "V%dZ\"/>\n<line x1=\"%.1f\" x2=\"%.1f\" y1=\"0\" y2=\"%d\"/>\n"
            "<line x1=\"0\" x2=\"%d\" y1=\"%d\" y2=\"%d\"/>\n"
            "<text x=\"0\" y=\"%d\">\xe2\x88\x92%g</text><text x=\"%d\" y=\"%d\" "
            "text-anchor=\"middle\">0</text><text x=\"%d\" y=\"%d\" "
            "text-anchor=\"end\">+%g</text>\n</svg>\n",
            BINS_HEIGHT, width / 2.0, width / 2.0, BINS_HEIGHT, width, BINS_HEIGHT, BINS_HEIGHT,
            BINS_HEIGHT + 15, scene->error_scale, width / 2, BINS_HEIGHT + 15, width,
            BINS_HEIGHT + 15, scene->error_scale);
}
