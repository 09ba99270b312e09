/* viewer/graph.c: the times of the last frames, by stage, as stacked bars. */
#include <stdlib.h>

#include "panels.h"

enum { BARS = 96, STAGES = 6 };

static const char *const stage_names[STAGES] = {"update", "surface", "visibility",
                                                "second", "shade",   "draw"};
static const unsigned stage_rgb[STAGES] = {0x9a9996, 0x62a0ea, 0xf5c211,
                                           0xe66100, 0x57e389, 0xc061cb};

struct graph {
    double times[BARS][STAGES];
    int count, next;
    GtkWidget *area;
};

static double total_of(const double *times)
{
    double sum = 0;
    for (int k = 0; k < STAGES; k++)
        sum += times[k];
    return sum;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* A round number of milliseconds above nine of ten bars: one slow frame does not flatten the rest;
 * it is cut off at the top. */
static double scale_of(const struct graph *graph)
{
    static const double rounds[] = {10, 20, 50, 100, 200, 500, 1000, 2000, 5000, 10000, 60000};
    double totals[BARS], most = 0;
    for (int i = 0; i < graph->count; i++)
        totals[i] = total_of(graph->times[i]);
    qsort(totals, (size_t)graph->count, sizeof(double), by_value);
    if (graph->count > 0)
        most = totals[(graph->count - 1) * 9 / 10];
    for (gsize i = 0; i < G_N_ELEMENTS(rounds); i++)
        if (most <= rounds[i])
            return rounds[i];
    return most;
}

static void draw(GtkDrawingArea *area, cairo_t *cr, int width, int height, gpointer data)
{
    const struct graph *graph = data;
    GdkRGBA ink;
    double scale = scale_of(graph), bar = (double)width / BARS;
    gtk_style_context_get_color(gtk_widget_get_style_context(GTK_WIDGET(area)), &ink);
    for (int i = 0; i < graph->count; i++) {
        int at = (graph->next - graph->count + i + 2 * BARS) % BARS;
        double y = height, x = (BARS - graph->count + i) * bar;
        for (int k = 0; k < STAGES; k++) {
            double h = graph->times[at][k] / scale * height;
            cairo_set_source_rgb(cr, (stage_rgb[k] >> 16) / 255.0,
                                 (stage_rgb[k] >> 8 & 255) / 255.0, (stage_rgb[k] & 255) / 255.0);
            cairo_rectangle(cr, x, y - h, MAX(bar - 0.5, 0.5), h);
            cairo_fill(cr);
            y -= h;
        }
    }
    /* A line at 20 frames a second. */
    cairo_set_source_rgba(cr, ink.red, ink.green, ink.blue, 0.5);
    cairo_set_line_width(cr, 1);
    if (scale >= 50) {
        double y = floor(height * (1 - 50 / scale)) + 0.5;
        const double dashes[] = {3, 3};
        cairo_set_dash(cr, dashes, 2, 0);
        cairo_move_to(cr, 0, y);
        cairo_line_to(cr, width, y);
        cairo_stroke(cr);
    }
    char text[32];
    g_snprintf(text, sizeof(text), "%g ms", scale);
    PangoLayout *layout = gtk_widget_create_pango_layout(GTK_WIDGET(area), text);
    cairo_set_source_rgba(cr, ink.red, ink.green, ink.blue, 0.8);
    cairo_move_to(cr, 4, 2);
    pango_cairo_show_layout(cr, layout);
    g_object_unref(layout);
}

static GtkWidget *legend(void)
{
    GString *text = g_string_new(NULL);
    for (int k = 0; k < STAGES; k++)
        g_string_append_printf(text, "%s<span foreground='#%06x'>■</span>\u00a0%s", k ? "  " : "",
                               stage_rgb[k], stage_names[k]);
    GtkWidget *label = gtk_label_new(NULL);
    gtk_label_set_markup(GTK_LABEL(label), text->str);
    gtk_label_set_wrap(GTK_LABEL(label), TRUE);
    gtk_label_set_xalign(GTK_LABEL(label), 0);
    gtk_label_set_max_width_chars(GTK_LABEL(label), 34);
    gtk_widget_add_css_class(label, "legend");
    g_string_free(text, TRUE);
    return label;
}

GtkWidget *view_graph_new(void)
{
    struct graph *graph = g_new0(struct graph, 1);
    GtkWidget *box = gtk_box_new(GTK_ORIENTATION_VERTICAL, 4);
    GtkWidget *title = gtk_label_new("Time of a frame");
    gtk_label_set_xalign(GTK_LABEL(title), 0);
    gtk_widget_add_css_class(title, "heading");
    graph->area = gtk_drawing_area_new();
    gtk_drawing_area_set_content_height(GTK_DRAWING_AREA(graph->area), 84);
    gtk_drawing_area_set_draw_func(GTK_DRAWING_AREA(graph->area), draw, graph, NULL);
    gtk_widget_add_css_class(graph->area, "graph");
    gtk_widget_set_tooltip_text(graph->area,
                                "Milliseconds of the last frames; dashed: 20 frames a second");
    gtk_widget_add_css_class(box, "graph-box");
    gtk_box_append(GTK_BOX(box), title);
    gtk_box_append(GTK_BOX(box), graph->area);
    gtk_box_append(GTK_BOX(box), legend());
    g_object_set_data_full(G_OBJECT(box), "graph", graph, g_free);
    return box;
}

void view_graph_add(GtkWidget *box, const struct view_frame *frame, double draw_ms)
{
    struct graph *graph = g_object_get_data(G_OBJECT(box), "graph");
    const struct view_times *t = &frame->times;
    const double times[STAGES] = {t->update,        t->primary,
                                  t->visibility[0], frame->compare ? t->visibility[1] : 0,
                                  t->shade,         draw_ms};
    for (int k = 0; k < STAGES; k++)
        graph->times[graph->next][k] = times[k];
    graph->next = (graph->next + 1) % BARS;
    graph->count = MIN(graph->count + 1, BARS);
}

void view_graph_redraw(GtkWidget *box)
{
    struct graph *graph = g_object_get_data(G_OBJECT(box), "graph");
    gtk_widget_queue_draw(graph->area);
}
