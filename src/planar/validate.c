/* planar/validate.c: is the result of a sweep what it claims to be? Slow, for tests and fuzzing. */
#include "planar/inside.h"

#include <stdlib.h>

struct box {
    const struct planar_edge *e;
    int32_t x0, x1, y0, y1;
};

static int compare_boxes(const void *a, const void *b)
{
    int32_t p = ((const struct box *)a)->x0, q = ((const struct box *)b)->x0;
    return p < q ? -1 : p > q;
}

/* Do two edges meet anywhere but in a common end point? */
static bool meet_wrongly(const struct planar_point *p, const struct planar_edge *e,
                         const struct planar_edge *f)
{
    struct planar_point a = p[e->left], b = p[e->right], c = p[f->left], d = p[f->right];
    int64_t sc = planar_orient(a, b, c), sd = planar_orient(a, b, d);
    int64_t sa = planar_orient(c, d, a), sb = planar_orient(c, d, b);
    if ((sc > 0 && sd > 0) || (sc < 0 && sd < 0) || (sa > 0 && sb > 0) || (sa < 0 && sb < 0))
        return false;
    if (sc == 0 && sd == 0) /* on one line: do the open intervals overlap? */
        return planar_before(planar_before(a, c) ? c : a, planar_before(b, d) ? b : d);
    bool shared = planar_same(a, c) || planar_same(a, d) || planar_same(b, c) || planar_same(b, d);
    return !shared;
}

const char *planar_validate(const struct planar_result *r, const struct planar_options *options)
{
    static const struct planar_options none;
    options = options ? options : &none;
    const struct planar_point *p = r->points;
    for (size_t i = 0; i < r->edge_count; i++) {
        const struct planar_edge *e = &r->edges[i];
        if (e->left >= r->point_count || e->right >= r->point_count)
            return "an edge names a point that is not there";
        if (!planar_before(p[e->left], p[e->right]))
            return "an edge runs backwards";
        if (e->below == e->above)
            return "an edge separates nothing";
    }
    for (size_t i = 0; i + 1 < r->input_point_count; i++)
        if (!planar_before(p[i], p[i + 1]))
            return "the points of the input are not in order";

    struct box *boxes = malloc((r->edge_count + 1) * sizeof(*boxes));
    size_t *active = malloc((r->edge_count + 1) * sizeof(*active)), active_count = 0;
    const char *wrong = boxes && active ? NULL : "no memory is left to look";
    for (size_t i = 0; i < r->edge_count && !wrong; i++) {
        struct planar_point a = p[r->edges[i].left], b = p[r->edges[i].right];
        boxes[i] =
            (struct box){&r->edges[i], a.x, b.x, a.y < b.y ? a.y : b.y, a.y < b.y ? b.y : a.y};
    }
    if (!wrong)
        qsort(boxes, r->edge_count, sizeof(*boxes), compare_boxes);
    for (size_t i = 0; i < r->edge_count && !wrong; i++) {
        size_t kept = 0;
        for (size_t j = 0; j < active_count; j++) {
            struct box *o = &boxes[active[j]];
            if (o->x1 < boxes[i].x0)
                continue;
            active[kept++] = active[j];
            if (o->y1 >= boxes[i].y0 && o->y0 <= boxes[i].y1 && meet_wrongly(p, o->e, boxes[i].e))
                wrong = "two edges meet outside their ends";
        }
        active_count = kept;
        active[active_count++] = i;
    }
    free(boxes);
    free(active);
    if (wrong || !options->triangulate)
        return wrong;

    bool usual = options->min_level == 0 && options->max_level == 0 && options->base == 0;
    int32_t lo = usual ? 1 : options->min_level, hi = usual ? INT32_MAX : options->max_level;
    if (lo <= options->base)
        lo = options->base + 1;
    __int128 triangles = 0, faces = 0;
    for (size_t i = 0; i < r->triangle_count; i++) {
        const struct planar_triangle *t = &r->triangles[i];
        if (t->v[0] >= r->point_count || t->v[1] >= r->point_count || t->v[2] >= r->point_count)
            return "a triangle names a point that is not there";
        int64_t area = planar_orient(p[t->v[0]], p[t->v[1]], p[t->v[2]]);
        if (area <= 0)
            return "a triangle is not counter-clockwise";
        if (t->level < lo || t->level > hi)
            return "a triangle of a level that was not asked for";
        triangles += area;
        for (int k = 0; k < 3; k++) {
            uint32_t n = t->near[k];
            if (n == PLANAR_NONE)
                continue;
            if (n >= 3 * r->triangle_count)
                return "a neighbour that is not there";
            const struct planar_triangle *o = &r->triangles[n / 3];
            if (o->near[n % 3] != 3 * i + (uint32_t)k || o->v[n % 3] != t->v[(k + 1) % 3] ||
                o->v[(n % 3 + 1) % 3] != t->v[k] || o->level != t->level)
                return "neighbours that disagree";
        }
    }
    for (size_t i = 0; i < r->edge_count; i++) {
        const struct planar_edge *e = &r->edges[i];
        int way = (e->below >= lo && e->below <= hi) - (e->above >= lo && e->above <= hi);
        struct planar_point a = p[e->left], b = p[e->right];
        faces -= way * ((__int128)a.x * b.y - (__int128)a.y * b.x);
    }
    return triangles == faces ? NULL : "the triangles do not cover the faces";
}
