/* method/wedge/cells.c: a convex light cut into cells.
 *
 *   y ^      ____            Rows lie between neighbouring heights at which anything happens: a
 *     |    /| /\ |\          corner, a border between bins, a line between columns that leaves the
 *     |---/-|/--\|-\---      light. So within a row every line is straight and none cross.
 *     |   \ |\  /| /         Quarters have the column border x = 0, octants also x = -|y| and |y|,
 *     |    \|_\/_|/          the grid x = -1/2, 0, 1/2; each is kept within the light.
 *
 * At most WEDGE_CORNERS_MAX corners + 2 crossings for each of 5 lines + 3 borders of bins, which is
 * less than WEDGE_ROWS_MAX rows. O(rows x corners).
 */
#include "method/wedge/cells.h"

#include <stdlib.h>
#include <string.h>

/* Heights nearer than this are one; of the light's half side. */
#define SAME 1e-9

struct line {
    double x, slope; /* crosses y at x + slope |y| */
};

struct cut {
    int columns, bins, line_count;
    struct line lines[WEDGE_COLUMNS_MAX - 1]; /* from left to right */
    double borders[WEDGE_BINS_MAX - 1];
};

static struct cut cut_for(int parts)
{
    switch (parts) {
    case 4: return (struct cut){2, 2, 1, {{0, 0}}, {0}};
    case 8: return (struct cut){4, 2, 3, {{0, -1}, {0, 0}, {0, 1}}, {0}};
    case 16: return (struct cut){4, 4, 3, {{-0.5, 0}, {0, 0}, {0.5, 0}}, {-0.5, 0, 0.5}};
    default: return (struct cut){.columns = 1, .bins = 1};
    }
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Heights at which an edge of the light crosses a line, on either side of y = 0. */
static int crossings(const double *a, const double *b, struct line line, double *out)
{
    int count = 0;
    for (int side = -1; side <= 1; side += 2) {
        double fa = a[0] - line.x - line.slope * side * a[1];
        double fb = b[0] - line.x - line.slope * side * b[1];
        if ((fa < 0) == (fb < 0))
            continue;
        double y = a[1] + (b[1] - a[1]) * fa / (fa - fb);
        if (y * side >= 0)
            out[count++] = y;
    }
    return count;
}

/* Sorted heights, each once; returns their number. */
static int find_heights(const struct wedge_light *light, const struct cut *cut, double *heights)
{
    int count = 0, kept = 0;
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < light->corner_count; i++) {
        const double *a = light->corners[i], *b = light->corners[(i + 1) % light->corner_count];
        heights[count++] = a[1];
        low = fmin(low, a[1]);
        high = fmax(high, a[1]);
        for (int k = 0; k < cut->line_count; k++)
            count += crossings(a, b, cut->lines[k], heights + count);
    }
    for (int i = 0; i + 1 < cut->bins; i++)
        if (cut->borders[i] > low && cut->borders[i] < high)
            heights[count++] = cut->borders[i];
    qsort(heights, (size_t)count, sizeof(*heights), by_value);
    for (int i = 0; i < count; i++)
        if (kept == 0 || heights[i] > heights[kept - 1] + SAME)
            heights[kept++] = heights[i];
    return kept;
}

/* The light's borders at both ends of a row; the middle of the row meets two edges. */
static void find_borders(const struct wedge_light *light, const struct wedge_row *row,
                         double left[2], double right[2])
{
    double middle = 0.5 * (row->low + row->high), least = INFINITY, most = -INFINITY;
    for (int i = 0; i < light->corner_count; i++) {
        const double *a = light->corners[i], *b = light->corners[(i + 1) % light->corner_count];
        if ((a[1] < middle) == (b[1] < middle))
            continue;
        double slope = (b[0] - a[0]) / (b[1] - a[1]);
        double x = a[0] + (middle - a[1]) * slope;
        double ends[2] = {a[0] + (row->low - a[1]) * slope, a[0] + (row->high - a[1]) * slope};
        if (x < least) {
            least = x;
            memcpy(left, ends, sizeof(ends));
        }
        if (x > most) {
            most = x;
            memcpy(right, ends, sizeof(ends));
        }
    }
}

static void add_to_cell(struct wedge_cell *cell, const struct wedge_row *row, int column)
{
    const double *low = row->left[0], *high = row->left[1];
    double bottom = row->right[0][column] - low[column], top = row->right[1][column] - high[column];
    double area = 0.5 * (bottom + top) * (row->high - row->low);
    if (!(area > 0))
        return;
    double x0 = fmin(low[column], high[column]);
    double x1 = fmax(row->right[0][column], row->right[1][column]);
    bool first = cell->area == 0;
    cell->x0 = first ? x0 : fmin(cell->x0, x0);
    cell->x1 = first ? x1 : fmax(cell->x1, x1);
    cell->y0 = first ? row->low : cell->y0;
    cell->y1 = row->high;
    cell->area += area;
}

void wedge_cells_init(const struct wedge_light *light, int parts, struct wedge_cells *cells)
{
    struct cut cut = cut_for(parts);
    double heights[WEDGE_CORNERS_MAX * (1 + 2 * (WEDGE_COLUMNS_MAX - 1)) + WEDGE_BINS_MAX];
    int count = find_heights(light, &cut, heights);
    memset(cells, 0, sizeof(*cells));
    cells->columns = cut.columns;
    cells->bins = cut.bins;
    for (int i = 0; i + 1 < count && i < WEDGE_ROWS_MAX; i++) {
        struct wedge_row *row = &cells->rows[cells->row_count++];
        double left[2] = {0}, right[2] = {0};
        *row = (struct wedge_row){.low = heights[i], .high = heights[i + 1]};
        find_borders(light, row, left, right);
        for (int k = 0; k + 1 < cut.bins; k++)
            row->bin += 0.5 * (row->low + row->high) > cut.borders[k];
        for (int end = 0; end < 2; end++) {
            double y = end ? row->high : row->low;
            double at = left[end];
            for (int c = 0; c < cut.columns; c++) {
                const struct line *line = &cut.lines[c];
                double x = c < cut.line_count ? line->x + line->slope * fabs(y) : right[end];
                row->left[end][c] = at;
                at = row->right[end][c] = fmax(fmin(x, right[end]), at);
            }
        }
        for (int c = 0; c < cut.columns; c++)
            add_to_cell(&cells->cells[row->bin][c], row, c);
    }
    for (int j = 0; j < cells->bins; j++)
        for (int c = 0; c < cells->columns; c++)
            cells->area += cells->cells[j][c].area;
}
