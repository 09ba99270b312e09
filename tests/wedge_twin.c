/* wedge_twin.c: penumbra wedges by brute force. The formulas stand in src/method/wedge/README.md;
 * this is their plain form, and the shader's is held to it. */
#include "wedge_twin.h"

#include <string.h>

#define CELLS_MAX 4
/* Of the height over the receiver: what is nearer to its own level than this is cut off. */
#define NEAR    (1.0 / 8192)
#define NOTHING 1e-5

struct point {
    double x, y;
};

struct cell {
    double area, left, right, bottom, top; /* covered; the last four: lengths of the border */
    double x0, x1, y0, y1;                 /* of the edges inside */
    double mx, my;                         /* first moments */
};

struct sum {
    struct cell cells[CELLS_MAX][CELLS_MAX]; /* [row][column] */
    double area, middle;                     /* of the whole light, 0..1; layers over its middle */
};

static double sign_of(const double plane[4], vec3 p)
{
    double s = plane[0] * p.x + plane[1] * p.y + plane[2] * p.z + plane[3];
    return (s > 0) - (s < 0);
}

static double clamp(double x, double low, double high)
{
    return fmin(fmax(x, low), high);
}

/* The plane in light space, scaled by nothing: its value at a point stays the same. */
static void plane_to_light(const struct wedge_twin *twin, const float *world, double sign,
                           double *out)
{
    const struct wedge_light *l = twin->light;
    vec3 n = v3_loadf(world);
    out[0] = sign * v3_dot(n, l->half_u);
    out[1] = sign * v3_dot(n, l->half_v);
    out[2] = sign * v3_dot(n, l->normal);
    out[3] = sign * (v3_dot(n, l->center) + (double)world[3]);
    if (twin->center && (n.x != 0 || n.y != 0 || n.z != 0)) {
        out[3] = sign * (sign * out[3] > 0 ? -1 : 1);
        out[0] = out[1] = out[2] = 0;
    }
}

/* Cuts a polygon (room for two corners more) by the half-plane left of a to b. */
static int clip(struct point *polygon, int count, struct point a, struct point b)
{
    struct point out[16];
    int kept = 0;
    for (int i = 0; i < count; i++) {
        struct point p = polygon[i], q = polygon[(i + 1) % count];
        double sp = (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
        double sq = (b.x - a.x) * (q.y - a.y) - (b.y - a.y) * (q.x - a.x);
        if (sp >= 0)
            out[kept++] = p;
        if ((sp >= 0) != (sq >= 0)) {
            double t = sp / (sp - sq);
            out[kept++] = (struct point){p.x + (q.x - p.x) * t, p.y + (q.y - p.y) * t};
        }
    }
    memcpy(polygon, out, (size_t)kept * sizeof(*out));
    return kept;
}

/* What lies left of the edge, cut to a row's column, with its moments. */
static void add_cut(struct cell *cell, double w, struct point a, struct point b,
                    const struct wedge_row *row, int c)
{
    struct point left[2] = {{row->left[0][c], row->low}, {row->left[1][c], row->high}};
    struct point right[2] = {{row->right[0][c], row->low}, {row->right[1][c], row->high}};
    if (fmax(a.y, b.y) <= row->low || fmin(a.y, b.y) >= row->high ||
        fmax(a.x, b.x) <= fmin(left[0].x, left[1].x))
        return;
    double far = fmin(fmin(a.x, b.x), -2) - 1;
    bool up = b.y > a.y;
    struct point low = up ? a : b, high = up ? b : a;
    struct point polygon[16] = {low, high, {far, high.y}, {far, low.y}};
    int count = clip(polygon, 4, left[0], right[0]);
    count = clip(polygon, count, right[1], left[1]);
    if (right[0].x > left[0].x || right[1].x > left[1].x) {
        count = clip(polygon, count, right[0], right[1]);
        count = clip(polygon, count, left[1], left[0]);
    } else {
        return;
    }
    for (int i = 1; i + 1 < count; i++) {
        struct point o = polygon[0], p = polygon[i], q = polygon[i + 1];
        double area = 0.5 * ((p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x));
        area *= up ? w : -w;
        cell->area += area;
        cell->mx += area * (o.x + p.x + q.x) / 3;
        cell->my += area * (o.y + p.y + q.y) / 3;
    }
}

/* The same in units of the cell's bounds. */
static struct cell within_bounds(const struct cell *cell, const struct wedge_cell *bounds)
{
    double width = bounds->x1 - bounds->x0, height = bounds->y1 - bounds->y0;
    struct cell out = {0};
    if (width > 0 && height > 0) {
        out.area = cell->area / (width * height);
        out.mx = (cell->mx - bounds->x0 * cell->area) / (width * width * height);
        out.my = (cell->my - bounds->y0 * cell->area) / (width * height * height);
    }
    return out;
}

/* Adds one directed edge of the outline on the light. */
static void add(const struct wedge_twin *twin, struct sum *sum, double w, struct point a,
                struct point b)
{
    if (w == 0)
        return;
    if ((a.y <= 0) != (b.y <= 0)) {
        double x = a.x + (b.x - a.x) * (0 - a.y) / (b.y - a.y);
        sum->middle += x > 0 ? (b.y > a.y ? w : -w) : 0;
    }
    for (int r = 0; twin->cells && r < twin->cells->row_count; r++)
        for (int c = 0; c < twin->cells->columns; c++) {
            const struct wedge_row *row = &twin->cells->rows[r];
            if (a.y != b.y)
                add_cut(&sum->cells[row->bin][c], w, a, b, row, c);
        }
    if (twin->cells)
        return;
    double width = 2.0 / twin->columns, height = 2.0 / twin->rows;
    for (int j = 0; j <= twin->rows; j++) {
        double level = -1 + height * j;
        if ((a.y <= level) == (b.y <= level))
            continue;
        double x = a.x + (b.x - a.x) * (level - a.y) / (b.y - a.y);
        for (int i = 0; i < twin->columns; i++) {
            double u = clamp((x + 1) / width - i, 0, 1) * (b.y > a.y ? w : -w);
            if (j < twin->rows)
                sum->cells[j][i].bottom += u;
            if (j > 0)
                sum->cells[j - 1][i].top += u;
        }
    }
    for (int j = 0; j < twin->rows; j++) {
        double low = -1 + height * j;
        double ya = clamp(a.y, low, low + height), yb = clamp(b.y, low, low + height);
        if (ya == yb)
            continue;
        double xa = a.x + (b.x - a.x) * (ya - a.y) / (b.y - a.y);
        double xb = a.x + (b.x - a.x) * (yb - a.y) / (b.y - a.y);
        double va = (ya - low) / height, vb = (yb - low) / height, dv = vb - va;
        for (int i = 0; i < twin->columns; i++) {
            struct cell *cell = &sum->cells[j][i];
            double ua = (xa + 1) / width - i, ub = (xb + 1) / width - i;
            double ca = clamp(ua, 0, 1), cb = clamp(ub, 0, 1), du = ub - ua;
            bool steep = fabs(du) > 1e-9;
            /* Shares of the edge right of the cell's left border, and of its right one. */
            double left = steep ? (fmax(ub, 0) - fmax(ua, 0)) / du : ua > 0;
            double right = steep ? (fmax(ub, 1) - fmax(ua, 1)) / du : ua > 1;
            double inside = left - right;
            double mean = 0.5 * (ca + cb);
            cell->area += w * dv * (inside * mean + right);
            cell->left += w * dv * left;
            cell->right += w * dv * right;
            /* Ends of the piece inside. */
            double sa = steep ? (ca - ua) / du : 0, sb = steep ? (cb - ua) / du : 1;
            double pa = va + sa * dv, pb = va + sb * dv;
            cell->mx += w * dv * (inside * (ca * ca + ca * cb + cb * cb) / 6 + right / 2);
            /* Integral of v times clamp(u): inside, u and v are both linear. */
            double vm = 0.5 * (pa + pb), right_end = ub > ua ? vb : va;
            double right_start = right_end - (ub > ua ? 1 : -1) * right * dv;
            cell->my += w * (dv * inside * (vm * mean + (pb - pa) * (cb - ca) / 12) +
                             dv * right * 0.5 * (right_end + right_start));
            if (inside > 0) {
                cell->x0 = fmin(cell->x0, fmin(ca, cb));
                cell->x1 = fmax(cell->x1, fmax(ca, cb));
                cell->y0 = fmin(cell->y0, fmin(pa, pb));
                cell->y1 = fmax(cell->y1, fmax(pa, pb));
            }
        }
    }
}

static struct point project(vec3 a, vec3 p)
{
    double k = a.z / (p.z - a.z);
    return (struct point){a.x + (a.x - p.x) * k, a.y + (a.y - p.y) * k};
}

/* Where the segment crosses height z; z itself exactly. */
static vec3 cross_at(vec3 a, vec3 b, double z)
{
    double t = (z - a.z) / (b.z - a.z);
    return v3(a.x + (b.x - a.x) * t, a.y + (b.y - a.y) * t, z);
}

/* The line in which height z cuts a face, from where its outline leaves the kept side to where it
 * comes back. */
static bool cut_face(const vec3 v[3], double sign, double z, bool keep_below, vec3 out[2])
{
    bool kept[3];
    for (int i = 0; i < 3; i++)
        kept[i] = keep_below ? v[i].z < z : v[i].z > z;
    if (kept[0] == kept[1] && kept[1] == kept[2])
        return false;
    for (int i = 0; i < 3; i++) {
        int k = (i + 1) % 3;
        if (kept[i] == kept[k])
            continue;
        vec3 c = i < k ? cross_at(v[i], v[k], z) : cross_at(v[k], v[i], z);
        out[(kept[i] ? 0 : 1) ^ (sign < 0)] = c;
    }
    return true;
}

static void add_edge_item(const struct wedge_twin *twin, const struct wedge_item *item, vec3 p,
                          struct sum *sum)
{
    vec3 a = wedge_light_from_world(twin->light, v3_loadf(item->a));
    vec3 b = wedge_light_from_world(twin->light, v3_loadf(item->b));
    double gap = twin->light->gap, level = p.z * (1 - NEAR);
    double first[4], second[4] = {0};
    if (item->kind == WEDGE_ITEM_NONE)
        return;
    if (item->kind == WEDGE_ITEM_EDGE) {
        plane_to_light(twin, item->first, item->sign, first);
        plane_to_light(twin, item->second, item->sign, second);
        if (a.z <= gap && b.z <= gap)
            return;
        if (a.z <= gap)
            a = cross_at(a, b, gap);
        else if (b.z <= gap)
            b = cross_at(a, b, gap);
    } else {
        vec3 v[3] = {a, b, wedge_light_from_world(twin->light, v3_loadf(item->c))}, ends[2];
        if (!cut_face(v, item->sign, gap, false, ends))
            return;
        a = ends[0];
        b = ends[1];
        plane_to_light(twin, item->first, 1, first);
        second[3] = item->k < 1 ? -1 : 0;
    }
    double w = (double)item->k * (sign_of(first, p) - sign_of(second, p));
    if (a.z >= level && b.z >= level)
        return;
    if (a.z >= level)
        a = cross_at(a, b, level);
    else if (b.z >= level)
        b = cross_at(a, b, level);
    add(twin, sum, w, project(a, p), project(b, p));
}

static void add_face_item(const struct wedge_twin *twin, const struct wedge_item *item, vec3 p,
                          struct sum *sum)
{
    if (item->kind == WEDGE_ITEM_NONE)
        return;
    vec3 v[3] = {wedge_light_from_world(twin->light, v3_loadf(item->a)),
                 wedge_light_from_world(twin->light, v3_loadf(item->b)),
                 wedge_light_from_world(twin->light, v3_loadf(item->c))};
    vec3 ends[2];
    double level = p.z * (1 - NEAR), first[4];
    if (level <= twin->light->gap || !cut_face(v, item->sign, level, true, ends))
        return;
    plane_to_light(twin, item->first, 1, first);
    double w = (double)item->k * (sign_of(first, p) - (item->k < 1 ? 1 : 0));
    add(twin, sum, w, project(ends[0], p), project(ends[1], p));
}

/* What is known about the hidden share of one cell. */
struct hidden {
    double area, x0, x1, y0, y1;
};

static struct hidden cell_hidden(const struct wedge_twin *twin, const struct cell *cell,
                                 double fill)
{
    struct hidden h = {clamp(cell->area, 0, fill), cell->x0, cell->x1, cell->y0, cell->y1};
    if (twin->gravity) {
        double gx = clamp(cell->mx / fmax(cell->area, 1e-6), 0, 1);
        double gy = clamp(cell->my / fmax(cell->area, 1e-6), 0, 1);
        double hx = fmin(gx, 1 - gx), hy = fmin(gy, 1 - gy);
        double grow = sqrt(fmax(1, h.area / fmax(4 * hx * hy, 1e-12)));
        hx = hx * grow;
        hy = hy * grow;
        return (struct hidden){h.area, fmax(gx - hx, 0), fmin(gx + hx, 1), fmax(gy - hy, 0),
                               fmin(gy + hy, 1)};
    }
    if (cell->left > NOTHING)
        h.x0 = 0;
    if (cell->right > NOTHING)
        h.x1 = 1;
    if (cell->bottom > NOTHING)
        h.y0 = 0;
    if (cell->top > NOTHING)
        h.y1 = 1;
    /* A border that is covered is covered up to the edge that ends it; without an edge, wholly. */
    if (h.x1 <= h.x0)
        h.x0 = 0, h.x1 = 1;
    if (h.y1 <= h.y0)
        h.y0 = 0, h.y1 = 1;
    return h;
}

/* Section 3.2 of the paper. */
static struct hidden blend(struct hidden f, struct hidden s, double fill)
{
    if (s.area <= NOTHING)
        return f;
    if (f.area <= NOTHING)
        return s;
    double bf = (f.x1 - f.x0) * (f.y1 - f.y0), bs = (s.x1 - s.x0) * (s.y1 - s.y0);
    double beta =
        fmax(fmin(f.x1, s.x1) - fmax(f.x0, s.x0), 0) * fmax(fmin(f.y1, s.y1) - fmax(f.y0, s.y0), 0);
    double df = fmin(f.area / fmax(bf, NOTHING), 1), ds = fmin(s.area / fmax(bs, NOTHING), 1);
    struct hidden both = {0, fmin(f.x0, s.x0), fmax(f.x1, s.x1), fmin(f.y0, s.y0),
                          fmax(f.y1, s.y1)};
    both.area = f.area + s.area - fmin(df * ds * beta, fmin(f.area, s.area));
    both.area = fmin(fmin(both.area, (both.x1 - both.x0) * (both.y1 - both.y0)), fill);
    return both;
}

struct wedge_twin_answer wedge_twin_at(const struct wedge_twin *twin, vec3 p_world)
{
    vec3 p = wedge_light_from_world(twin->light, p_world);
    struct wedge_twin_answer answer = {1, 1, 1};
    struct hidden whole[CELLS_MAX][CELLS_MAX];
    double share[CELLS_MAX][CELLS_MAX]; /* of the light */
    memset(whole, 0, sizeof(whole));
    memset(share, 0, sizeof(share));
    int hard = 0, count = twin->rows * twin->columns;
    double soft = 0;
    for (size_t i = 0; i < twin->parts->part_count; i++) {
        const struct wedge_part *part = &twin->parts->parts[i];
        struct sum sum;
        memset(&sum, 0, sizeof(sum));
        for (int r = 0; r < twin->rows; r++)
            for (int c = 0; c < twin->columns; c++) {
                sum.cells[r][c].x0 = sum.cells[r][c].y0 = 1;
                sum.cells[r][c].x1 = sum.cells[r][c].y1 = 0;
            }
        const struct wedge_item *items = twin->parts->items;
        for (size_t k = part->first_item; k < part->first_item + part->item_count; k++)
            if (k < part->first_face_item)
                add_edge_item(twin, &items[k], p, &sum);
            else
                add_face_item(twin, &items[k], p, &sum);
        double all = 0;
        for (int r = 0; r < twin->rows; r++)
            for (int c = 0; c < twin->columns; c++) {
                struct cell cell = sum.cells[r][c];
                double bounds = 1, fill = 1;
                if (twin->cells) {
                    const struct wedge_cell *b = &twin->cells->cells[r][c];
                    bounds = (b->x1 - b->x0) * (b->y1 - b->y0);
                    fill = bounds > 0 ? b->area / bounds : 0;
                    cell = within_bounds(&cell, b);
                }
                share[r][c] = twin->cells ? bounds / twin->cells->area : 1.0 / count;
                all += cell.area * share[r][c];
                whole[r][c] = blend(whole[r][c], cell_hidden(twin, &cell, fill), fill);
            }
        all = clamp(all, 0, 1);
        bool middle = sum.middle > 0.5;
        hard = hard || middle;
        soft += all - middle;
        answer.probabilistic *= 1 - all;
    }
    answer.wedge = clamp(1 - (hard + soft), 0, 1);
    double hidden = 0;
    for (int r = 0; r < twin->rows; r++)
        for (int c = 0; c < twin->columns; c++)
            hidden += whole[r][c].area * share[r][c];
    answer.blend = clamp(1 - hidden, 0, 1);
    return answer;
}
