/* planar/snap.c: hot-pixel rounding (Hobby 1999; Guibas and Marimont 1998), the careful way.
 *
 * Every end point and every rounded crossing makes the unit square around it hot. Each segment is
 * replaced by the chain through the centres of all hot squares that it touches, in the order in
 * which it touches them. The chains meet in centres only: a crossing of two chains would need a
 * point of one inside a hot square that it does not visit. So this cannot fail where rounding one
 * crossing at a time (sweep.c) can; it costs some times more and is called only then.
 *
 * Coordinates within 2^29; squares have half-integer corners, so tests run in doubled coordinates:
 * differences fit 32 bits, products and their sum 65: __int128.
 */
#include "planar/inside.h"

#include <math.h>
#include <stdlib.h>

struct span { /* a segment's box */
    int32_t x0, x1, y0, y1;
    uint32_t segment;
};

struct on_chain {
    int64_t along;
    uint32_t point;
};

static int compare_spans(const void *a, const void *b)
{
    const struct span *p = a, *q = b;
    return p->x0 != q->x0 ? (p->x0 < q->x0 ? -1 : 1) : (p->segment < q->segment ? -1 : 1);
}

static int compare_points(const void *a, const void *b)
{
    const struct planar_point *p = a, *q = b;
    return planar_before(*p, *q) ? -1 : planar_before(*q, *p);
}

static int compare_along(const void *a, const void *b)
{
    const struct on_chain *p = a, *q = b;
    return p->along < q->along ? -1 : p->along > q->along;
}

/* Does the segment l-r meet the unit square around c, its left and lower side included, the others
 * not? l.x <= r.x, and c lies in the segment's box. */
static bool touches(struct planar_point l, struct planar_point r, struct planar_point c)
{
    int64_t dx = (int64_t)r.x - l.x, dy = (int64_t)r.y - l.y;
    /* Distances of the corners to the line: that of the centre +- (dx + |dy|) / 2 at the two
     * corners that lie furthest to both sides; doubled. Rising: upper left and lower right, neither
     * of which belongs to the square. Falling: upper right, which does not, and lower left, which
     * does. */
    __int128 d = 2 * ((__int128)dx * (c.y - l.y) - (__int128)dy * (c.x - l.x));
    __int128 reach = (__int128)dx + llabs(dy);
    return d > -reach && (dy < 0 && dx > 0 ? d <= reach : d < reach);
}

static pnb_status add_point(pnb_context *context, struct planar_input *set, struct planar_point p)
{
    pnb_status status = planar_input_reserve(context, set, 1, 0);
    if (!status)
        set->points[set->point_count++] = p;
    return status;
}

/* All pairs whose boxes overlap, by x; crossings are rounded into set. */
static pnb_status find_crossings(pnb_context *context, const struct planar_input *in,
                                 struct planar_input *set)
{
    size_t n = in->segment_count;
    struct span *spans = memory_alloc(context, n, sizeof(*spans));
    uint32_t *active = memory_alloc(context, n, sizeof(*active));
    pnb_status status = PNB_OK;
    if (!spans || !active)
        status = status_no_memory(context, n * sizeof(*spans));
    for (size_t i = 0; i < n && !status; i++) {
        struct planar_point a = in->points[in->segments[i].a], b = in->points[in->segments[i].b];
        spans[i] = (struct span){a.x < b.x ? a.x : b.x, a.x < b.x ? b.x : a.x,
                                 a.y < b.y ? a.y : b.y, a.y < b.y ? b.y : a.y, (uint32_t)i};
    }
    if (!status)
        qsort(spans, n, sizeof(*spans), compare_spans);
    size_t active_count = 0;
    for (size_t i = 0; i < n && !status; i++) {
        size_t kept = 0;
        struct planar_point a = in->points[in->segments[spans[i].segment].a];
        struct planar_point b = in->points[in->segments[spans[i].segment].b];
        for (size_t j = 0; j < active_count && !status; j++) {
            const struct span *o = &spans[active[j]];
            if (o->x1 < spans[i].x0)
                continue;
            active[kept++] = active[j];
            if (o->y1 < spans[i].y0 || o->y0 > spans[i].y1)
                continue;
            struct planar_point c = in->points[in->segments[o->segment].a];
            struct planar_point d = in->points[in->segments[o->segment].b];
            int64_t sc = planar_orient(a, b, c), sd = planar_orient(a, b, d);
            if ((sc > 0 && sd > 0) || (sc < 0 && sd < 0) || sc == sd)
                continue;
            int64_t sa = planar_orient(c, d, a), sb = planar_orient(c, d, b);
            if ((sa > 0 && sb > 0) || (sa < 0 && sb < 0))
                continue;
            double t = (double)sc / ((double)sc - (double)sd);
            struct planar_point p = {c.x + (int32_t)floor(t * (d.x - c.x) + 0.5),
                                     c.y + (int32_t)floor(t * (d.y - c.y) + 0.5)};
            status = add_point(context, set, p);
        }
        /* Some of the rest may not have been looked at when an error came. */
        active_count = kept;
        active[active_count++] = (uint32_t)i;
    }
    memory_free(context, spans);
    memory_free(context, active);
    return status;
}

/* Hot squares in a grid of columns, sorted by y within each. */
struct columns {
    int32_t x0;
    double per_unit;
    uint32_t count;
    uint32_t *starts, *points;
};

static uint32_t column_of(const struct columns *c, int32_t x)
{
    double i = ((double)x - c->x0) * c->per_unit;
    return i <= 0 ? 0 : i >= c->count - 1 ? c->count - 1 : (uint32_t)i;
}

static pnb_status make_columns(pnb_context *context, const struct planar_point *points,
                               size_t count, struct columns *c)
{
    c->x0 = points[0].x;
    double width = (double)points[count - 1].x - points[0].x + 1;
    c->count = (uint32_t)(sqrt((double)count) + 1);
    c->per_unit = c->count / width;
    c->starts = memory_calloc(context, c->count + 1, sizeof(*c->starts));
    c->points = memory_alloc(context, count, sizeof(*c->points));
    if (!c->starts || !c->points)
        return status_no_memory(context, count * sizeof(*c->points));
    /* Points are sorted by x, so columns are runs; within a column they get sorted by y. */
    for (size_t i = 0; i < count; i++) {
        c->points[i] = (uint32_t)i;
        c->starts[column_of(c, points[i].x) + 1]++;
    }
    for (uint32_t i = 0; i < c->count; i++)
        c->starts[i + 1] += c->starts[i];
    for (uint32_t k = 0; k < c->count; k++) {
        /* Heap sort by y: columns are short, and no qsort() with context is at hand in C11. */
        uint32_t *run = c->points + c->starts[k];
        size_t n = c->starts[k + 1] - c->starts[k];
        for (size_t start = n / 2, end = n; end > 1;) {
            if (start > 0) {
                start--;
            } else {
                end--;
                uint32_t t = run[0];
                run[0] = run[end];
                run[end] = t;
            }
            for (size_t root = start, child; (child = 2 * root + 1) < end; root = child) {
                if (child + 1 < end && points[run[child + 1]].y > points[run[child]].y)
                    child++;
                if (points[run[root]].y >= points[run[child]].y)
                    break;
                uint32_t t = run[root];
                run[root] = run[child];
                run[child] = t;
            }
        }
    }
    return PNB_OK;
}

static size_t first_at_or_above(const struct columns *c, const struct planar_point *points,
                                uint32_t column, double y)
{
    size_t a = c->starts[column], b = c->starts[column + 1];
    while (a < b) {
        size_t m = (a + b) / 2;
        if (points[c->points[m]].y < y)
            a = m + 1;
        else
            b = m;
    }
    return a;
}

pnb_status planar_snap(pnb_context *context, const struct planar_input *in,
                       struct planar_input *out)
{
    struct columns columns = {0};
    struct on_chain *chain = NULL;
    size_t chain_capacity = 0;
    *out = (struct planar_input){0};
    pnb_status status = planar_input_reserve(context, out, in->point_count, in->segment_count);
    for (size_t i = 0; i < in->segment_count && !status; i++) {
        status = add_point(context, out, in->points[in->segments[i].a]);
        if (!status)
            status = add_point(context, out, in->points[in->segments[i].b]);
    }
    if (!status)
        status = find_crossings(context, in, out);
    if (status || out->point_count == 0)
        goto end;
    qsort(out->points, out->point_count, sizeof(*out->points), compare_points);
    size_t distinct = 0;
    for (size_t i = 0; i < out->point_count; i++)
        if (distinct == 0 || !planar_same(out->points[distinct - 1], out->points[i]))
            out->points[distinct++] = out->points[i];
    out->point_count = distinct;
    status = make_columns(context, out->points, distinct, &columns);

    for (size_t i = 0; i < in->segment_count && !status; i++) {
        struct planar_point a = in->points[in->segments[i].a], b = in->points[in->segments[i].b];
        if (planar_same(a, b))
            continue;
        struct planar_point l = a.x < b.x ? a : b, r = a.x < b.x ? b : a;
        double slope = r.x > l.x ? ((double)r.y - l.y) / ((double)r.x - l.x) : 0;
        double y_min = a.y < b.y ? a.y : b.y, y_max = a.y < b.y ? b.y : a.y;
        size_t count = 0;
        uint32_t first = column_of(&columns, l.x - 1), last = column_of(&columns, r.x + 1);
        for (uint32_t k = first; k <= last && !status; k++) {
            /* The segment's y range over this column, some units wider. */
            double x0 = columns.x0 + k / columns.per_unit, x1 = x0 + 1 / columns.per_unit;
            double y0 = l.y + slope * (fmax(x0, l.x) - l.x),
                   y1 = l.y + slope * (fmin(x1, r.x) - l.x);
            double low = fmin(y0, y1) - fabs(slope) - 3, high = fmax(y0, y1) + fabs(slope) + 3;
            if (r.x == l.x) {
                low = y_min - 1;
                high = y_max + 1;
            }
            low = fmax(low, y_min - 1);
            high = fmin(high, y_max + 1);
            for (size_t j = first_at_or_above(&columns, out->points, k, low);
                 j < columns.starts[k + 1]; j++) {
                struct planar_point p = out->points[columns.points[j]];
                if (p.y > high)
                    break;
                if (p.x < l.x || p.x > r.x || p.y < y_min || p.y > y_max || !touches(l, r, p))
                    continue;
                if (!memory_reserve(context, (void **)&chain, &chain_capacity, count, 1,
                                    sizeof(*chain))) {
                    status = status_no_memory(context, sizeof(*chain));
                    break;
                }
                /* Squares that one segment meets go up, or down, in both coordinates. */
                int64_t along =
                    (b.x >= a.x ? p.x : -(int64_t)p.x) + (b.y >= a.y ? p.y : -(int64_t)p.y);
                chain[count++] = (struct on_chain){along, columns.points[j]};
            }
        }
        if (status)
            break;
        if (count > 0)
            qsort(chain, count, sizeof(*chain), compare_along);
        status = planar_input_reserve(context, out, 0, count);
        for (size_t j = 0; j + 1 < count && !status; j++)
            out->segments[out->segment_count++] =
                (struct planar_segment){chain[j].point, chain[j + 1].point, in->segments[i].weight};
    }
end:
    memory_free(context, chain);
    memory_free(context, columns.starts);
    memory_free(context, columns.points);
    if (status)
        planar_input_finish(context, out);
    return status;
}
