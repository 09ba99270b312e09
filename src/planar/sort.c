/* planar/sort.c: points in the order of the sweep.
 *
 * Radix sort by the highest bits of x (16 for few points, 22 for many), then runs that share them
 * by x and y. O(n), and O(n log n) where all points share them.
 */
#include "planar/inside.h"

#include <string.h>

static void radix_pass(const struct sort_item *in, struct sort_item *out, size_t count, int shift,
                       int bits, uint32_t *histogram)
{
    uint32_t mask = (1u << bits) - 1;
    memset(histogram, 0, ((size_t)mask + 1) * sizeof(*histogram));
    for (size_t i = 0; i < count; i++)
        histogram[in[i].x >> shift & mask]++;
    uint32_t sum = 0;
    for (uint32_t d = 0; d <= mask; d++) {
        uint32_t n = histogram[d];
        histogram[d] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++)
        out[histogram[in[i].x >> shift & mask]++] = in[i];
}

/* A run of nearly equal x: insertion for the usual short ones, heap sort for long ones. */
static bool later(const struct planar_point *p, struct sort_item a, struct sort_item b)
{
    return a.x > b.x || (a.x == b.x && p[a.index].y > p[b.index].y);
}

static void sift(const struct planar_point *p, struct sort_item *run, size_t root, size_t count)
{
    for (;;) {
        size_t child = 2 * root + 1;
        if (child >= count)
            return;
        if (child + 1 < count && later(p, run[child + 1], run[child]))
            child++;
        if (!later(p, run[child], run[root]))
            return;
        struct sort_item t = run[root];
        run[root] = run[child];
        run[child] = t;
        root = child;
    }
}

static void sort_run(const struct planar_point *p, struct sort_item *run, size_t count)
{
    if (count < 24) {
        for (size_t i = 1; i < count; i++) {
            struct sort_item t = run[i];
            size_t j = i;
            for (; j > 0 && later(p, run[j - 1], t); j--)
                run[j] = run[j - 1];
            run[j] = t;
        }
        return;
    }
    for (size_t i = count / 2; i-- > 0;)
        sift(p, run, i, count);
    for (size_t n = count; n-- > 1;) {
        struct sort_item t = run[0];
        run[0] = run[n];
        run[n] = t;
        sift(p, run, 0, n);
    }
}

bool sort_points(struct planar_workspace *w, const struct planar_point *points, size_t count)
{
    uint32_t histogram[2048];
    w->sorted_count = w->spare_count = w->rank_count = w->points_count = 0;
    if (!ROOM(w, sorted, count) || !ROOM(w, spare, count) || !ROOM(w, rank, count) ||
        !ROOM(w, points, count))
        return false;
    if (count == 0)
        return true;
    int32_t smallest = points[0].x, largest = points[0].x;
    for (size_t i = 1; i < count; i++) {
        smallest = points[i].x < smallest ? points[i].x : smallest;
        largest = points[i].x > largest ? points[i].x : largest;
    }
    struct sort_item *from = w->sorted, *to = w->spare;
    for (size_t i = 0; i < count; i++)
        from[i] = (struct sort_item){(uint32_t)(points[i].x - smallest), (uint32_t)i};
    /* Two passes over the highest digits; runs that share them are sorted one by one. */
    uint32_t range = (uint32_t)(largest - smallest);
    int bits = count < 1500 ? 8 : 11, top = 0;
    while (top < 32 && range >> top)
        top++;
    int low = top > 2 * bits ? top - 2 * bits : 0;
    for (int shift = low; shift < top; shift += bits) {
        int width = shift + bits > 32 ? 32 - shift : bits;
        radix_pass(from, to, count, shift, width, histogram);
        struct sort_item *t = from;
        from = to;
        to = t;
    }
    /* Order within runs, then give equal points one rank. */
    for (size_t i = 0; i < count;) {
        size_t j = i + 1;
        while (j < count && from[j].x >> low == from[i].x >> low)
            j++;
        if (j - i > 1)
            sort_run(points, from + i, j - i);
        for (; i < j; i++) {
            struct planar_point p = points[from[i].index];
            if (w->points_count == 0 || !planar_same(w->points[w->points_count - 1], p))
                w->points[w->points_count++] = p;
            w->rank[from[i].index] = (uint32_t)(w->points_count - 1);
        }
    }
    w->rank_count = count;
    return true;
}
