/* method/exact/exact_cover.c: occluders one by one on the light's grid, in double precision, and
 * the answer read off the grid. The slow and obvious part: no assumption about the occluder.
 *
 * With e(s, r) the vector from eye to light point, a triangle q0 q1 q2 (relative to the eye) is met
 * by the ray along e where the three products e.(q_i x q_j) have the sign that makes e run through
 * the triangle from its front, and 0 < t < reach with t = q0.N / e.N. All four are linear in (s,
 * r), so that a row's samples behind the triangle are one interval, and nothing is ever divided by
 * a height: corners behind the eye or beyond the light need no clipping.
 */
#include <string.h>

#include "method/exact/exact.h"

size_t exact_cover_size(const struct exact_grid *grid)
{
    return (size_t)(grid->bins + 2) * (size_t)grid->stride;
}

void exact_cover_clear(const struct exact_cover *cover)
{
    const struct exact_grid *grid = cover->grid;
    size_t size = (size_t)grid->stride << grid->fold, all = exact_cover_size(grid);
    for (uint32_t bits = *cover->touched; bits; bits &= bits - 1) {
        size_t first = (size_t)__builtin_ctz(bits) * size;
        size_t count = first + size < all ? size : all - first;
        memset(cover->cells + first, 0, count * sizeof(*cover->cells));
    }
    *cover->touched = 0;
    memset(cover->left, 0, EXACT_ROWS_MAX * sizeof(*cover->left));
}

/* A crossing at x cells, seen from the left; column k as in struct exact_cover. */
static void add_crossing(const struct exact_cover *cover, int row, int k, double x, int change)
{
    const struct exact_grid *grid = cover->grid;
    int32_t *cell = &cover->cells[k * grid->stride + row];
    *cover->touched |= 1u << (k >> grid->fold);
    x = x > 0 ? x : 0;
    x = x < grid->bins ? x : grid->bins;
    *cell = exact_cell_add(*cell, change, (int)((x - k + 2) * 256) - 256);
}

/* One more occluder between low and high, in bins of the parallelogram, both included. */
static bool add_interval(const struct exact_cover *cover, int row, double low, double high)
{
    const struct exact_grid *grid = cover->grid;
    double place = grid->place[row];
    low = low * grid->scale[row] + grid->base[row];
    high = high * grid->scale[row] + grid->base[row];
    if (!(low <= high) || high < 0 || low > grid->bins)
        return false;
    /* The first sample at or behind low, and the first one behind high. */
    double bins = grid->bins, a = low - place, b = high - place;
    a = a > 0 ? a : 0;
    b = b > -1 ? b : -1;
    a = a < bins ? a : bins;
    b = b < bins - 1 ? b : bins - 1;
    int first = (int)a, end = (int)(b + 1);
    first += first < a;
    first = low <= 0 ? 0 : first + 1;
    end += 1;
    add_crossing(cover, row, first, low, 1);
    add_crossing(cover, row, end, high, -1);
    return true;
}

static struct exact_linear linear_along(const struct exact_grid *grid,
                                        const struct exact_view *view, vec3 n, double constant)
{
    double u = v3_dot(n, view->u), v = v3_dot(n, view->v);
    struct exact_linear f;
    f.step_x = u * grid->per_bin;
    f.step_j = v * grid->per_row;
    f.base = v3_dot(n, view->center) - 0.5 * u + v * grid->first_row + constant;
    return f;
}

/* Rows begin to end and a span of bins on each, narrowed by one linear inequality after another. */
struct region {
    int begin, end;
    double low[EXACT_ROWS_MAX], high[EXACT_ROWS_MAX];
};

/* Does f >= 0 hold anywhere on the grid, or everywhere (nothing to cut)? */
static bool somewhere(const struct exact_linear *f, const struct exact_grid *grid, bool *everywhere)
{
    double across = f->step_x * grid->bins, along = f->step_j * (grid->rows - 1);
    double least = f->base + (across < 0 ? across : 0) + (along < 0 ? along : 0);
    double most = f->base + (across > 0 ? across : 0) + (along > 0 ? along : 0);
    *everywhere = least >= 0;
    return most >= 0;
}

static void cut(const struct exact_linear *f, struct region *region)
{
    if (f->step_x == 0) {
        for (int row = region->begin; row < region->end; row++)
            if (f->base + row * f->step_j < 0)
                region->high[row] = -INFINITY;
        return;
    }
    double inverse = -1 / f->step_x;
    if (f->step_x > 0)
        for (int row = region->begin; row < region->end; row++) {
            double x = (f->base + row * f->step_j) * inverse;
            region->low[row] = x > region->low[row] ? x : region->low[row];
        }
    else
        for (int row = region->begin; row < region->end; row++) {
            double x = (f->base + row * f->step_j) * inverse;
            region->high[row] = x < region->high[row] ? x : region->high[row];
        }
}

static bool cover_region(const struct exact_cover *cover, const struct exact_linear *f, int count,
                         unsigned trivial)
{
    const struct exact_grid *grid = cover->grid;
    struct region region = {.begin = 0, .end = grid->rows};
    for (int row = 0; row < grid->rows; row++) {
        region.low[row] = -INFINITY;
        region.high[row] = INFINITY;
    }
    for (int i = 0; i < count; i++)
        if (!(trivial >> i & 1))
            cut(&f[i], &region);
    bool any = false;
    for (int row = region.begin; row < region.end; row++)
        any |= add_interval(cover, row, region.low[row], region.high[row]);
    return any;
}

bool exact_triangle_linear(const struct exact_grid *grid, const struct exact_view *view,
                           const vec3 q[3], struct exact_linear f[4], unsigned *trivial)
{
    vec3 n = v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]));
    double height = -v3_dot(q[0], n); /* of the eye over the plane */
    if (!(height != 0) || !isfinite(height))
        return false;
    double side = height > 0 ? -1 : 1;
    *trivial = 0;
    for (int i = 3; i >= 0; i--) {
        if (i < 3)
            f[i] = linear_along(grid, view, v3_scale(v3_cross(q[i], q[(i + 1) % 3]), side), 0);
        else if (view->reach > 0)
            f[i] = linear_along(grid, view, v3_scale(n, side * view->reach), -fabs(height));
        else
            f[i] = linear_along(grid, view, v3_scale(n, side), 0);
        bool everywhere;
        if (!somewhere(&f[i], grid, &everywhere))
            return false;
        *trivial |= (unsigned)everywhere << i;
    }
    return true;
}

bool exact_below_linear(const struct exact_grid *grid, const struct exact_view *view, vec3 n,
                        double lift, struct exact_linear *f, unsigned *trivial)
{
    *f = linear_along(grid, view, v3_scale(n, -1), -lift);
    bool everywhere;
    bool any = somewhere(f, grid, &everywhere);
    *trivial = everywhere;
    return any;
}

bool exact_cover_triangle(const struct exact_cover *cover, const struct exact_view *view,
                          const vec3 q[3])
{
    struct exact_linear f[4];
    unsigned trivial;
    return exact_triangle_linear(cover->grid, view, q, f, &trivial) &&
           cover_region(cover, f, 4, trivial);
}

bool exact_cover_below(const struct exact_cover *cover, const struct exact_view *view, vec3 n,
                       double lift)
{
    struct exact_linear f;
    unsigned trivial;
    return exact_below_linear(cover->grid, view, n, lift, &f, &trivial) &&
           cover_region(cover, &f, 1, trivial);
}

/* How far the crossings between two samples move the visible length, in 1/256 cells. Where
 * occlusion begins or ends: by the place of the border, the mean if there are several. Where the
 * count is the same on both sides: something thinner than a bin between two visible samples, or a
 * gap between two samples that the same single occluder hides. */
static int crossing_move(const struct exact_cover *cover, int rest, int count, int change)
{
    int n = change < 0 ? -change : change;
    if (n == 0) {
        if (count > 0 && (count != cover->unit || rest <= 0))
            return 0;
        n = cover->unit;
    } else if (count > 0 && count + change > 0) {
        return 0;
    }
    int move = rest >> (n == 1 ? 0 : n <= 2 ? 1 : n <= 4 ? 2 : 3);
    return move < -256 ? -256 : move > 256 ? 256 : move;
}

double exact_cover_resolve(const struct exact_cover *cover)
{
    const struct exact_grid *grid = cover->grid;
    double sum = 0;
    int left = 0;
    for (int row = 0; row < grid->rows; row++) {
        left += cover->left[row];
        int count = left + exact_cell_change(cover->cells[row]);
        long seen = 0;
        for (int k = 1; k <= grid->bins + 1; k++) {
            int at = k * grid->stride + row, cell = at - grid->stride;
            int change = exact_cell_change(cover->cells[at]);
            if (cover->area && grid->inner[cell])
                seen += crossing_move(cover, exact_cell_rest(cover->cells[at]), count, change);
            count += change;
            if (count <= 0 && k <= grid->bins)
                seen += grid->weight[cell];
        }
        sum += (double)(seen * grid->length[row]);
    }
    return fmin(fmax(sum / grid->total, 0), 1);
}
