/* method/planar/locate.c: which triangle of a shadow holds a point.
 *
 * A uniform grid over the triangles, about two cells each. A triangle is listed in the cells that
 * its slice of each row touches, so slivers cost their length. Build O(triangles + cells touched),
 * a look-up a handful of tests; neighbouring look-ups mostly end at the triangle found last.
 */
#include "method/planar/room.h"

#define GRID_MAX 1024

static int clamp_cell(double c, int count)
{
    return c < 0 ? 0 : c >= count ? count - 1 : (int)c;
}

struct visit {
    struct shadow_locator *l;
    bool fill;
};

static void slice(const struct shadow_locator *l, const double p[3][2], double y0, double y1,
                  int *first, int *last)
{
    double lo = INFINITY, hi = -INFINITY;
    for (int k = 0; k < 3; k++) {
        const double *a = p[k], *b = p[(k + 1) % 3];
        if (a[1] >= y0 && a[1] <= y1) {
            lo = fmin(lo, a[0]);
            hi = fmax(hi, a[0]);
        }
        for (int s = 0; s < 2; s++) {
            double y = s ? y1 : y0;
            if ((a[1] < y) != (b[1] < y)) {
                double x = a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
                lo = fmin(lo, x);
                hi = fmax(hi, x);
            }
        }
    }
    *first = 1;
    *last = 0;
    if (lo <= hi) {
        *first = clamp_cell((lo - l->x0) * l->per_x - 1e-6, l->columns);
        *last = clamp_cell((hi - l->x0) * l->per_x + 1e-6, l->columns);
    }
}

/* Counts (items NULL) or lists the triangle in every cell that it touches. */
static void visit(struct shadow_locator *l, uint32_t triangle, uint32_t *counts)
{
    const struct shadow_triangle *t = &l->part->triangles[triangle];
    double p[3][2], lo = INFINITY, hi = -INFINITY;
    for (int k = 0; k < 3; k++) {
        p[k][0] = l->part->points[2 * (size_t)t->v[k]];
        p[k][1] = l->part->points[2 * (size_t)t->v[k] + 1];
        lo = fmin(lo, p[k][1]);
        hi = fmax(hi, p[k][1]);
    }
    int r0 = clamp_cell((lo - l->y0) * l->per_y - 1e-6, l->rows);
    int r1 = clamp_cell((hi - l->y0) * l->per_y + 1e-6, l->rows);
    double pad = 1e-6 / l->per_y;
    for (int row = r0; row <= r1; row++) {
        int first, last;
        slice(l, (const double(*)[2])p, l->y0 + row / l->per_y - pad,
              l->y0 + (row + 1) / l->per_y + pad, &first, &last);
        for (int c = first; c <= last; c++) {
            size_t cell = (size_t)row * l->columns + c;
            if (l->items)
                l->items[l->starts[cell] + counts[cell]] = triangle;
            counts[cell]++;
        }
    }
}

pnb_status shadow_locator_init(pnb_context *context, const struct shadow_part *part,
                               struct shadow_locator *l)
{
    *l = (struct shadow_locator){.part = part};
    if (part->triangle_count == 0)
        return PNB_OK;
    double lo[2] = {INFINITY, INFINITY}, hi[2] = {-INFINITY, -INFINITY};
    for (size_t i = 0; i < part->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 2; axis++) {
                double p = part->points[2 * (size_t)part->triangles[i].v[k] + axis];
                lo[axis] = fmin(lo[axis], p);
                hi[axis] = fmax(hi[axis], p);
            }
    double width = fmax(hi[0] - lo[0], 1e-300), height = fmax(hi[1] - lo[1], 1e-300);
    double per = sqrt(2.0 * (double)part->triangle_count / (width * height));
    l->columns = (int)fmax(1, fmin(GRID_MAX, width * per));
    l->rows = (int)fmax(1, fmin(GRID_MAX, height * per));
    l->x0 = lo[0];
    l->y0 = lo[1];
    l->per_x = l->columns / width;
    l->per_y = l->rows / height;
    size_t cells = (size_t)l->columns * l->rows;
    uint32_t *counts = memory_calloc(context, cells, sizeof(*counts));
    l->starts = memory_alloc(context, cells + 1, sizeof(*l->starts));
    if (counts && l->starts) {
        for (uint32_t i = 0; i < part->triangle_count; i++)
            visit(l, i, counts);
        l->starts[0] = 0;
        for (size_t i = 0; i < cells; i++) {
            l->starts[i + 1] = l->starts[i] + counts[i];
            counts[i] = 0;
        }
        l->items = memory_alloc(context, l->starts[cells], sizeof(*l->items));
        for (uint32_t i = 0; i < part->triangle_count && l->items; i++)
            visit(l, i, counts);
    }
    bool ok = counts && l->starts && l->items;
    memory_free(context, counts);
    if (!ok) {
        shadow_locator_finish(context, l);
        return status_no_memory(context, cells * 8);
    }
    return PNB_OK;
}

void shadow_locator_finish(pnb_context *context, struct shadow_locator *l)
{
    memory_free(context, l->starts);
    memory_free(context, l->items);
    *l = (struct shadow_locator){0};
}

static bool holds(const struct shadow_part *part, uint32_t triangle, double x, double y,
                  double *value)
{
    const struct shadow_triangle *t = &part->triangles[triangle];
    const double *a = part->points + 2 * (size_t)t->v[0], *b = part->points + 2 * (size_t)t->v[1],
                 *c = part->points + 2 * (size_t)t->v[2];
    double wa = (b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x);
    double wb = (c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x);
    double wc = (a[0] - x) * (b[1] - y) - (a[1] - y) * (b[0] - x);
    double sum = wa + wb + wc, slack = -1e-9 * sum;
    if (wa < slack || wb < slack || wc < slack)
        return false;
    *value = (wa * t->value[0] + wb * t->value[1] + wc * t->value[2]) / sum;
    return true;
}

double shadow_at(const struct shadow_locator *l, double x, double y, uint32_t *io_hint)
{
    double value;
    if (!l->items)
        return 0;
    if (*io_hint != PLANAR_NONE && holds(l->part, *io_hint, x, y, &value))
        return value;
    double cx = (x - l->x0) * l->per_x, cy = (y - l->y0) * l->per_y;
    if (!(cx >= 0 && cy >= 0 && cx <= l->columns && cy <= l->rows))
        return 0;
    size_t cell = (size_t)clamp_cell(cy, l->rows) * l->columns + clamp_cell(cx, l->columns);
    for (uint32_t i = l->starts[cell]; i < l->starts[cell + 1]; i++) {
        if (holds(l->part, l->items[i], x, y, &value)) {
            *io_hint = l->items[i];
            return value;
        }
    }
    return 0;
}
