/* planar/svg.c: the state of a sweep as a drawing, for whoever looks for a bug. */
#include "planar/inside.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

struct text {
    pnb_context *context;
    char *bytes;
    size_t length, capacity;
    bool failed;
};

static void add(struct text *t, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(struct text *t, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    int n = vsnprintf(line, sizeof(line), format, arguments);
    va_end(arguments);
    if (t->failed || !memory_reserve(t->context, (void **)&t->bytes, &t->capacity, t->length,
                                     (size_t)n + 1, 1)) {
        t->failed = true;
        return;
    }
    memcpy(t->bytes + t->length, line, (size_t)n + 1);
    t->length += (size_t)n;
}

char *planar_draw_svg(pnb_context *context, const struct planar_result *r)
{
    static const char *colors[] = {"#888888", "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728",
                                   "#9467bd", "#8c564b", "#e377c2", "#bcbd22", "#17becf"};
    struct text t = {.context = context};
    double x0 = 0, y0 = 0, x1 = 1, y1 = 1;
    for (size_t i = 0; i < r->point_count; i++) {
        double x = r->points[i].x, y = -(double)r->points[i].y;
        x0 = i == 0 || x < x0 ? x : x0;
        x1 = i == 0 || x > x1 ? x : x1;
        y0 = i == 0 || y < y0 ? y : y0;
        y1 = i == 0 || y > y1 ? y : y1;
    }
    double scale = 1000 / (x1 - x0 > y1 - y0 ? x1 - x0 + 1 : y1 - y0 + 1);
    add(&t,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"-10 -10 %.3f %.3f\">\n"
        "<g fill=\"none\" stroke=\"#ccc\" stroke-width=\"0.3\">\n",
        (x1 - x0) * scale + 20, (y1 - y0) * scale + 20);
#define X(i) ((r->points[i].x - x0) * scale)
#define Y(i) ((-(double)r->points[i].y - y0) * scale)
    for (size_t i = 0; i < r->triangle_count; i++) {
        const uint32_t *v = r->triangles[i].v;
        add(&t, "<path d=\"M%.4f %.4fL%.4f %.4fL%.4f %.4fZ\"/>\n", X(v[0]), Y(v[0]), X(v[1]),
            Y(v[1]), X(v[2]), Y(v[2]));
    }
    add(&t, "</g>\n<g fill=\"none\" stroke-width=\"0.8\">\n");
    for (size_t i = 0; i < r->edge_count; i++) {
        const struct planar_edge *e = &r->edges[i];
        int32_t level = e->below > e->above ? e->below : e->above;
        add(&t, "<path stroke=\"%s\" d=\"M%.4f %.4fL%.4f %.4f\"><title>%d/%d</title></path>\n",
            colors[((level % 10) + 10) % 10], X(e->left), Y(e->left), X(e->right), Y(e->right),
            e->below, e->above);
    }
    add(&t, "</g>\n</svg>\n");
    if (t.failed) {
        memory_free(context, t.bytes);
        return NULL;
    }
    return t.bytes;
}
