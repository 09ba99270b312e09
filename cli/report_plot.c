/* cli/report_plot.c: the drawings of the page, as inline SVG coloured by its style sheet. */
#include "compare.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

struct placed {
    double x, y;
    const struct report_point *point;
    const char *text; /* its label, or of a series' further members the setting alone */
    double rank;      /* for the front: time */
    bool front;
};

struct plot_axis {
    double low, high; /* log10, or the values themselves */
    double from, to;  /* of the drawing */
    bool linear;
};

static double place(const struct plot_axis *axis, double value)
{
    double at = axis->linear ? value : log10(value);
    return axis->from + (at - axis->low) / (axis->high - axis->low) * (axis->to - axis->from);
}

/* Wide enough for all values, with room, and at least about a decade. */
static struct plot_axis make_axis(double least, double most, double from, double to)
{
    double low = log10(least) - 0.15, high = log10(most) + 0.25;
    if (high - low < 1) {
        double middle = 0.5 * (low + high);
        low = middle - 0.5, high = middle + 0.5;
    }
    return (struct plot_axis){low, high, from, to, false};
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

/* Whole numbers up to most. */
static void draw_numbers(FILE *page, double most, const struct plot_axis *axis)
{
    int step = most > 40 ? 10 : most > 20 ? 5 : 2;
    for (int value = 0; value <= most; value += step)
        fprintf(page,
                "<line class=\"grid minor\" x1=\"%.1f\" x2=\"%.1f\" y1=\"%d\" y2=\"%d\"/>\n"
                "<text x=\"%.1f\" y=\"%d\" text-anchor=\"middle\">%d</text>\n",
                place(axis, value), place(axis, value), PLOT_TOP, PLOT_BOTTOM, place(axis, value),
                PLOT_BOTTOM + 18, value);
}

static bool overlap(const struct box *a, const struct box *b)
{
    return a->x0 < b->x1 && b->x0 < a->x1 && a->y0 < b->y1 && b->y0 < a->y1;
}

/* The first place around the point where the label meets no other label and no point; false if
 * there is none. */
static bool place_label(const struct placed *point, const struct box *taken, size_t count,
                        struct box *out)
{
    double width = 6.2 * (double)strlen(point->text) + 4;
    for (int ring = 0; ring < 5; ring++)
        for (int side = 0; side < 4; side++) {
            double dy = ring * LABEL_HEIGHT * 0.7;
            double x =
                side < 2 ? (side == 0 ? point->x + 9 : point->x - 9 - width) : point->x - width / 2;
            double y = side < 2    ? point->y - LABEL_HEIGHT / 2.0 + (ring % 2 ? dy : -dy)
                       : side == 2 ? point->y - LABEL_HEIGHT - 8 - dy
                                   : point->y + 8 + dy;
            struct box box = {x, y, x + width, y + LABEL_HEIGHT};
            if (box.x0 < PLOT_LEFT || box.x1 > PLOT_RIGHT || box.y0 < PLOT_TOP ||
                box.y1 > PLOT_BOTTOM)
                continue;
            bool hit = false;
            for (size_t i = 0; i < count && !hit; i++)
                hit = overlap(&box, &taken[i]);
            if (!hit) {
                *out = box;
                return true;
            }
        }
    return false;
}

static int by_group_and_order(const void *a, const void *b)
{
    const struct report_point *p = ((const struct placed *)a)->point,
                              *q = ((const struct placed *)b)->point;
    int groups = strcmp(p->group, q->group);
    return groups ? groups : (p->order > q->order) - (p->order < q->order);
}

static int by_time(const void *a, const void *b)
{
    const struct placed *p = *(struct placed *const *)a, *q = *(struct placed *const *)b;
    return (p->rank > q->rank) - (p->rank < q->rank);
}

/* Marks the points that no other point beats in both, and draws them as steps: what is above and to
 * the right of the line is beaten. */
static void draw_front(FILE *page, struct placed *placed, size_t count)
{
    struct placed **order = malloc((count + 1) * sizeof(*order));
    double best = INFINITY;
    bool drawn = false;
    for (size_t i = 0; order && i < count; i++)
        order[i] = &placed[i];
    if (order)
        qsort(order, count, sizeof(*order), by_time);
    for (size_t i = 0; order && i < count; i++) {
        if (order[i]->point->error >= best)
            continue;
        best = order[i]->point->error;
        order[i]->front = true;
        if (!drawn)
            fprintf(page, "<path class=\"front\" d=\"M%.1f %dV%.1f", order[i]->x, PLOT_TOP,
                    order[i]->y);
        else
            fprintf(page, "H%.1fV%.1f", order[i]->x, order[i]->y);
        drawn = true;
    }
    if (drawn)
        fprintf(page, "H%d\"/>\n", PLOT_RIGHT);
    free(order);
}

static void draw_frame(FILE *page, const char *x_title, const char *y_title, const char *what)
{
    fprintf(page, "<svg class=\"plot\" viewBox=\"0 0 %d %d\" role=\"img\" aria-label=\"%s\">\n",
            PLOT_WIDTH, PLOT_HEIGHT, what);
    fprintf(page,
            "<path class=\"axis\" fill=\"none\" d=\"M%d %dV%dH%d\"/>\n"
            "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%s</text>\n"
            "<text transform=\"translate(12 %d) rotate(-90)\" text-anchor=\"end\">%s</text>\n",
            PLOT_LEFT, PLOT_TOP, PLOT_BOTTOM, PLOT_RIGHT, PLOT_RIGHT, PLOT_BOTTOM + 38, x_title,
            PLOT_TOP, y_title);
}

static void draw_label(FILE *page, const struct placed *at, const struct box *box)
{
    bool left = box->x1 <= at->x, beside = left || box->x0 >= at->x;
    fprintf(page, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\" text-anchor=\"%s\">",
            at->front ? "name" : "name beaten",
            left     ? box->x1
            : beside ? box->x0
                     : 0.5 * (box->x0 + box->x1),
            box->y1 - 3,
            left     ? "end"
            : beside ? "start"
                     : "middle");
    report_html_text(page, at->text);
    fprintf(page, "</text>\n");
}

void report_plot_points(FILE *page, const struct report_point *points, size_t count,
                        const char *x_title, const char *y_title)
{
    struct placed *placed = calloc(count + 1, sizeof(*placed));
    struct box *taken = calloc(2 * count + 1, sizeof(*taken));
    size_t shown = 0, boxes = 0;
    double times[2] = {INFINITY, 0}, errors[2] = {INFINITY, 0};
    for (size_t i = 0; placed && i < count; i++) {
        if (!isfinite(points[i].time) || !(points[i].time > 0) || !(points[i].error > 0))
            continue;
        placed[shown++] = (struct placed){.point = &points[i], .rank = points[i].time};
        times[0] = fmin(times[0], points[i].time), times[1] = fmax(times[1], points[i].time);
        errors[0] = fmin(errors[0], points[i].error), errors[1] = fmax(errors[1], points[i].error);
    }
    if (!placed || !taken || shown == 0) {
        fprintf(page, "<p class=\"soft\">No entry has a time and an error.</p>\n");
        free(placed);
        free(taken);
        return;
    }
    qsort(placed, shown, sizeof(*placed), by_group_and_order);
    struct plot_axis x = make_axis(times[0], times[1], PLOT_LEFT, PLOT_RIGHT);
    struct plot_axis y = make_axis(errors[0], errors[1], PLOT_BOTTOM, PLOT_TOP);
    draw_frame(page, x_title, y_title, "error against time, both logarithmic");
    draw_ticks(page, &x, true);
    draw_ticks(page, &y, false);

    /* One method at several settings is a line. */
    for (size_t i = 0; i < shown; i++) {
        struct placed *at = &placed[i];
        at->x = place(&x, at->point->time), at->y = place(&y, at->point->error);
        at->text = at->point->label;
        taken[boxes++] = (struct box){at->x - 6, at->y - 6, at->x + 6, at->y + 6};
        if (i == 0 || strcmp(at->point->group, placed[i - 1].point->group) != 0)
            continue;
        fprintf(page, "<path class=\"series\" stroke=\"var(--c%d)\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n",
                at->point->color, placed[i - 1].x, placed[i - 1].y, at->x, at->y);
        /* Of a line the first point says the method. */
        size_t name = strlen(at->point->name);
        if (strncmp(at->text, at->point->name, name) == 0 && at->text[name] == ':')
            at->text += name;
    }
    draw_front(page, placed, shown);
    for (size_t i = 0; i < shown; i++) {
        const struct placed *at = &placed[i];
        fprintf(page,
                "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%d\" %s fill=\"var(--c%d)\" "
                "stroke=\"var(--c%d)\"><title>",
                at->x, at->y, at->front ? 6 : 4, at->point->partial ? "class=\"partial\"" : "",
                at->point->color, at->point->color);
        report_html_text(page, at->point->label);
        fprintf(page, ": %.3g at %.3g%s</title></circle>\n", at->point->error, at->point->time,
                at->point->partial ? ", planes only" : "");
    }
    /* The best ones get their labels first. */
    for (int turn = 0; turn < 3; turn++)
        for (size_t i = 0; i < shown; i++) {
            struct placed *at = &placed[i];
            int mine = at->front ? 0 : at->text == at->point->label ? 1 : 2;
            struct box box;
            if (mine != turn || !place_label(at, taken, boxes, &box))
                continue;
            taken[boxes++] = box;
            draw_label(page, at, &box);
        }
    fprintf(page, "</svg>\n");
    free(placed);
    free(taken);
}

void report_plot_time(FILE *page, const struct compare_scene *scene)
{
    struct report_point *points = calloc(scene->entry_count + 1, sizeof(*points));
    size_t count = 0;
    for (size_t i = 0; points && i < scene->entry_count; i++) {
        const struct compare_entry *entry = &scene->entries[i];
        if (entry->errors.pixels == 0)
            continue;
        points[count++] = report_point(entry, entry->milliseconds, fmax(entry->errors.rmse, 1e-5));
    }
    report_plot_points(page, points, count, "visibility of one frame, ms", "RMSE in the penumbra");
    free(points);
}

struct report_point report_point(const struct compare_entry *entry, double time, double error)
{
    /* Entries with parameters of their own are no members of the line of samples. */
    return (struct report_point){.label = entry->label,
                                 .name = entry->name,
                                 .group = strchr(entry->label, '=') ? entry->label : entry->name,
                                 .order = entry->samples,
                                 .color = report_color(entry->method),
                                 .partial =
                                     entry->method && entry->method->receivers != PNB_RECEIVERS_ANY,
                                 .time = time,
                                 .error = error};
}

int report_color(const pnb_method_info *method)
{
    for (size_t i = 0; method && i < pnb_method_count(); i++)
        if (strcmp(pnb_method(i)->name, method->name) == 0)
            return (int)(i % (REPORT_COLORS - 1));
    return REPORT_COLORS - 1;
}

/* ---- curves ---- */

static void plot_curves(FILE *page, const struct report_curve *curves, size_t count,
                        const char *x_title, const char *y_title, bool linear)
{
    double xs[2] = {INFINITY, 0}, ys[2] = {INFINITY, 0};
    size_t most = 0;
    for (size_t c = 0; c < count; c++)
        for (size_t i = 0; i < curves[c].count; i++) {
            double u = curves[c].x[i], v = curves[c].y[i];
            if (!(u > 0) || !(v > 0) || !isfinite(u * v))
                continue;
            xs[0] = fmin(xs[0], u), xs[1] = fmax(xs[1], u);
            ys[0] = fmin(ys[0], v), ys[1] = fmax(ys[1], v);
            most++;
        }
    struct box *taken = calloc(2 * most + count + 1, sizeof(*taken));
    if (!most || !taken) {
        fprintf(page, "<p class=\"soft\">Nothing was measured.</p>\n");
        free(taken);
        return;
    }
    struct plot_axis x = make_axis(xs[0], xs[1], PLOT_LEFT, PLOT_RIGHT);
    struct plot_axis y = make_axis(ys[0], ys[1], PLOT_BOTTOM, PLOT_TOP);
    if (linear)
        x = (struct plot_axis){0, xs[1], PLOT_LEFT, PLOT_RIGHT, true};
    x.high += 0.22 * (x.high - x.low); /* room for the names at the right ends */
    draw_frame(page, x_title, y_title, "curves on logarithmic axes");
    if (linear)
        draw_numbers(page, xs[1], &x);
    else
        draw_ticks(page, &x, true);
    draw_ticks(page, &y, false);
    size_t boxes = 0;
    for (size_t c = 0; c < count; c++) {
        struct report_point point = {.label = curves[c].label, .color = curves[c].color};
        struct placed last = {.point = &point, .text = curves[c].label, .front = true};
        bool open = false;
        fprintf(page, "<path class=\"curve\" stroke=\"var(--c%d)\" d=\"", curves[c].color);
        for (size_t i = 0; i < curves[c].count; i++) {
            double u = curves[c].x[i], v = curves[c].y[i];
            if (!(u > 0) || !(v > 0) || !isfinite(u * v))
                continue;
            last.x = place(&x, u), last.y = place(&y, v);
            fprintf(page, "%c%.1f %.1f", open ? 'L' : 'M', last.x, last.y);
            taken[boxes++] = (struct box){last.x - 3, last.y - 3, last.x + 3, last.y + 3};
            open = true;
        }
        fprintf(page, "\"/>\n");
        for (size_t i = 0; i < curves[c].count; i++) {
            double u = curves[c].x[i], v = curves[c].y[i];
            if (!(u > 0) || !(v > 0) || !isfinite(u * v))
                continue;
            fprintf(page, "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"3.5\" fill=\"var(--c%d)\"><title>",
                    place(&x, u), place(&y, v), curves[c].color);
            report_html_text(page, curves[c].label);
            fprintf(page, ": %.4g at %.4g</title></circle>\n", v, u);
        }
        struct box box;
        if (open && place_label(&last, taken, boxes, &box)) {
            taken[boxes++] = box;
            draw_label(page, &last, &box);
        }
    }
    fprintf(page, "</svg>\n");
    free(taken);
}

void report_plot_curves(FILE *page, const struct report_curve *curves, size_t count,
                        const char *x_title, const char *y_title)
{
    plot_curves(page, curves, count, x_title, y_title, false);
}

void report_plot_steps(FILE *page, const struct report_curve *curves, size_t count,
                       const char *x_title, const char *y_title)
{
    plot_curves(page, curves, count, x_title, y_title, true);
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
