/* method/planar/write_page.c: the shadow for pages: SVG and PDF, the plane seen from the light's
 * side.
 *
 * SVG has no triangles with three colours, but a linear function over a triangle is a linear
 * gradient: along the direction in which the intensity rises, from the corner with the least to the
 * place with the most. Greys are opaque (1 - intensity) and multiplied over what lies below, so
 * that triangles may overlap by the width of a hairline drawn around each: that closes the seams
 * which anti-aliasing leaves between neighbours. Darker triangles come last, so that hairlines
 * never eat into them; those of needles are as thin as they are, or they would show as lines.
 *
 * PDF: one mesh pattern of degenerate Coons patches, by cairo; viewers shade it without seams.
 */
#include <cairo-pdf.h>
#include <cairo.h>
#include <stdlib.h>
#include <string.h>

#include "method/planar/shadow.h"

#define PAGE           1000.0 /* the longer side */
#define HAIRLINE       1.2
#define HAIRLINE_LEAST 0.05

struct page {
    double x0, y1, scale, width, height;
};

/* The receiver's box, v upwards. */
static struct page make_page(const struct pnb_shadow *s)
{
    const struct shadow_sheet *sheet = &s->sheets[0];
    double w = sheet->hi[0] - sheet->lo[0], h = sheet->hi[1] - sheet->lo[1];
    double scale = PAGE / fmax(w, h);
    return (struct page){sheet->lo[0], sheet->hi[1], scale, w * scale, h * scale};
}

static void corner(const struct pnb_shadow *s, const struct page *page, size_t triangle, int k,
                   double *out)
{
    uint32_t v = s->indices[3 * triangle + (size_t)k];
    out[0] = (s->coordinates[2 * (size_t)v] - page->x0) * page->scale;
    out[1] = (page->y1 - s->coordinates[2 * (size_t)v + 1]) * page->scale;
    out[2] = fmin(1, fmax(0, s->intensities[v]));
}

/* The least height of a triangle. */
static double height_of(double p[3][3])
{
    double longest = 0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, hypot(p[(k + 1) % 3][0] - p[k][0], p[(k + 1) % 3][1] - p[k][1]));
    double area =
        fabs((p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]));
    return longest > 0 ? area / longest : 0;
}

struct ordered {
    float darkness;
    uint32_t triangle;
};

static int by_darkness(const void *a, const void *b)
{
    const struct ordered *p = a, *q = b;
    if (p->darkness != q->darkness)
        return p->darkness < q->darkness ? -1 : 1;
    return p->triangle < q->triangle ? -1 : p->triangle > q->triangle;
}

pnb_status shadow_write_svg(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    struct page page = make_page(s);
    size_t n = s->view.triangle_count;
    struct ordered *order = memory_alloc(s->context, n, sizeof(*order));
    if (!order)
        return status_no_memory(s->context, n * sizeof(*order));
    for (size_t i = 0; i < n; i++) {
        order[i] = (struct ordered){0, (uint32_t)i};
        for (int k = 0; k < 3; k++)
            order[i].darkness += s->intensities[s->indices[3 * i + (size_t)k]];
    }
    qsort(order, n, sizeof(*order), by_darkness);
    buffer_print(file,
                 "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.6g\" height=\"%.6g\" "
                 "viewBox=\"0 0 %.6g %.6g\">\n<title>soft shadow: grey is visibility</title>\n"
                 "<defs>\n",
                 page.width, page.height, page.width, page.height);
    /* Gradients of the triangles that are not even. */
    for (size_t i = 0; i < n; i++) {
        double p[3][3];
        int low = 0, high = 0;
        for (int k = 0; k < 3; k++) {
            corner(s, &page, order[i].triangle, k, p[k]);
            low = p[k][2] < p[low][2] ? k : low;
            high = p[k][2] > p[high][2] ? k : high;
        }
        double rise = p[high][2] - p[low][2];
        double ux = p[1][0] - p[0][0], uy = p[1][1] - p[0][1], uf = p[1][2] - p[0][2];
        double vx = p[2][0] - p[0][0], vy = p[2][1] - p[0][1], vf = p[2][2] - p[0][2];
        double det = ux * vy - uy * vx;
        double gx = (uf * vy - vf * uy) / det, gy = (vf * ux - uf * vx) / det,
               gg = gx * gx + gy * gy;
        if (!(rise > 1e-4) || !(gg > 0) || !isfinite(gg))
            continue;
        double a = 100 * (1 - p[low][2]), b = 100 * (1 - p[high][2]);
        buffer_print(
            file,
            "<linearGradient id=\"g%zu\" gradientUnits=\"userSpaceOnUse\" x1=\"%.5f\" "
            "y1=\"%.5f\" x2=\"%.5f\" y2=\"%.5f\"><stop stop-color=\"rgb(%.3f%%,%.3f%%,%.3f%%)\"/>"
            "<stop offset=\"1\" stop-color=\"rgb(%.3f%%,%.3f%%,%.3f%%)\"/></linearGradient>\n",
            i, p[low][0], p[low][1], p[low][0] + gx * rise / gg, p[low][1] + gy * rise / gg, a, a,
            a, b, b, b);
        order[i].darkness = -1; /* has a gradient */
    }
    buffer_print(file,
                 "</defs>\n<g stroke-width=\"%.3g\" stroke-linejoin=\"round\" "
                 "style=\"mix-blend-mode:multiply\">\n",
                 HAIRLINE);
    for (size_t i = 0; i < n; i++) {
        double p[3][3];
        for (int k = 0; k < 3; k++)
            corner(s, &page, order[i].triangle, k, p[k]);
        double grey = 100 * (1 - (p[0][2] + p[1][2] + p[2][2]) / 3);
        buffer_print(file, "<path d=\"M%.4f %.4fL%.4f %.4fL%.4f %.4fZ\" ", p[0][0], p[0][1],
                     p[1][0], p[1][1], p[2][0], p[2][1]);
        double width = fmax(HAIRLINE_LEAST, height_of(p));
        if (width < HAIRLINE)
            buffer_print(file, "stroke-width=\"%.3g\" ", width);
        if (order[i].darkness < 0)
            buffer_print(file, "fill=\"url(#g%zu)\" stroke=\"url(#g%zu)\"/>\n", i, i);
        else
            buffer_print(
                file, "fill=\"rgb(%.3f%%,%.3f%%,%.3f%%)\" stroke=\"rgb(%.3f%%,%.3f%%,%.3f%%)\"/>\n",
                grey, grey, grey, grey, grey, grey);
    }
    buffer_print(file, "</g>\n</svg>\n");
    memory_free(s->context, order);
    return PNB_OK;
}

static cairo_status_t add_bytes(void *closure, const unsigned char *bytes, unsigned int size)
{
    struct buffer *file = closure;
    buffer_add(file, bytes, size);
    return file->failed ? CAIRO_STATUS_NO_MEMORY : CAIRO_STATUS_SUCCESS;
}

pnb_status shadow_write_pdf(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    struct page page = make_page(s);
    cairo_surface_t *surface =
        cairo_pdf_surface_create_for_stream(add_bytes, file, page.width, page.height);
    cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_TITLE, "soft shadow");
    cairo_t *cr = cairo_create(surface);
    cairo_pattern_t *mesh = cairo_pattern_create_mesh();
    for (size_t i = 0; i < s->view.triangle_count; i++) {
        cairo_mesh_pattern_begin_patch(mesh);
        for (int k = 0; k < 3; k++) {
            double p[3];
            corner(s, &page, i, k, p);
            if (k == 0)
                cairo_mesh_pattern_move_to(mesh, p[0], p[1]);
            else
                cairo_mesh_pattern_line_to(mesh, p[0], p[1]);
            cairo_mesh_pattern_set_corner_color_rgb(mesh, (unsigned)k, 1 - p[2], 1 - p[2],
                                                    1 - p[2]);
        }
        cairo_mesh_pattern_end_patch(mesh);
    }
    cairo_set_source(cr, mesh);
    cairo_set_operator(cr, CAIRO_OPERATOR_OVER);
    cairo_paint(cr);
    cairo_status_t status = cairo_status(cr);
    cairo_pattern_destroy(mesh);
    cairo_destroy(cr);
    cairo_surface_finish(surface);
    if (!status)
        status = cairo_surface_status(surface);
    cairo_surface_destroy(surface);
    return status ? status_fail(s->context, PNB_ERROR_DEVICE, "PDF", "%s",
                                cairo_status_to_string(status))
                  : PNB_OK;
}
