/* method/planar/delaunay.c: a Delaunay triangulation that grows point by point.
 *
 * Triangles as index arrays with their neighbours' half-edges; a new point splits its triangle (or
 * the two beside its side), then diagonals are exchanged until every circle is empty (Lawson).
 * Sides can be fixed: they are split, never exchanged. Coordinates are on the grid of planar/;
 * in-circle and orientation are exact, so the walk to a point ends and the mesh stays a tiling. A
 * point on a vertex is not added. Insertion costs the walk from where the search starts, and some
 * six exchanges.
 */
#include "method/planar/refine.h"

static bool room(struct delaunay *m)
{
    m->no_memory = m->no_memory ||
                   !memory_reserve(m->context, (void **)&m->points, &m->point_capacity,
                                   m->point_count, 1, sizeof(*m->points)) ||
                   !memory_reserve(m->context, (void **)&m->values, &m->value_capacity,
                                   m->point_count, 1, sizeof(*m->values)) ||
                   !memory_reserve(m->context, (void **)&m->jump, &m->jump_capacity, m->point_count,
                                   1, sizeof(*m->jump)) ||
                   !memory_reserve(m->context, (void **)&m->corners, &m->corner_capacity,
                                   m->triangle_count, 2, sizeof(*m->corners)) ||
                   !memory_reserve(m->context, (void **)&m->triangles, &m->triangle_capacity,
                                   m->triangle_count, 2, sizeof(*m->triangles));
    return !m->no_memory;
}

struct side {
    uint32_t near;
    bool fixed;
};

static struct side side_of(const struct delaunay *m, uint32_t t, uint32_t k)
{
    return (struct side){m->triangles[t].near[k], m->corners[t].fixed >> k & 1};
}

static void fix(struct delaunay *m, uint32_t half)
{
    uint32_t other = m->triangles[half / 3].near[half % 3];
    m->corners[half / 3].fixed |= (uint8_t)(1 << half % 3);
    if (other != PLANAR_NONE)
        m->corners[other / 3].fixed |= (uint8_t)(1 << other % 3);
}

static void link2(struct delaunay *m, uint32_t half, struct side other)
{
    m->triangles[half / 3].near[half % 3] = other.near;
    if (other.near != PLANAR_NONE)
        m->triangles[other.near / 3].near[other.near % 3] = half;
    if (other.fixed)
        fix(m, half);
}

static struct side free_side(uint32_t half)
{
    return (struct side){half, false};
}

static void push(struct delaunay *m, uint32_t half)
{
    if (!memory_reserve(m->context, (void **)&m->stack, &m->stack_capacity, m->stack_count, 1,
                        sizeof(*m->stack))) {
        m->no_memory = true;
        return;
    }
    m->stack[m->stack_count++] = half;
}

static void set(struct delaunay *m, uint32_t t, uint32_t a, uint32_t b, uint32_t c)
{
    m->triangles[t] =
        (struct planar_triangle){{a, b, c}, {PLANAR_NONE, PLANAR_NONE, PLANAR_NONE}, 0};
    m->corners[t] = (struct delaunay_corners){{m->values[a], m->values[b], m->values[c]}, 0, false};
}

/* Lawson: sides opposite to the new point. */
static void legalize(struct delaunay *m)
{
    while (m->stack_count > 0 && !m->no_memory) {
        uint32_t half = m->stack[--m->stack_count], i = half / 3, k = half % 3;
        struct planar_triangle *t = m->triangles;
        uint32_t other = t[i].near[k];
        if (other == PLANAR_NONE || (m->corners[i].fixed >> k & 1))
            continue;
        uint32_t j = other / 3, l = other % 3;
        uint32_t a = t[i].v[k], b = t[i].v[(k + 1) % 3], c = t[i].v[(k + 2) % 3],
                 d = t[j].v[(l + 2) % 3];
        if (!planar_in_circle(m->points[a], m->points[b], m->points[c], m->points[d]) ||
            planar_orient(m->points[a], m->points[d], m->points[c]) <= 0 ||
            planar_orient(m->points[d], m->points[b], m->points[c]) <= 0)
            continue;
        struct side bc = side_of(m, i, (k + 1) % 3), ca = side_of(m, i, (k + 2) % 3);
        struct side ad = side_of(m, j, (l + 1) % 3), db = side_of(m, j, (l + 2) % 3);
        set(m, i, a, d, c);
        set(m, j, d, b, c);
        link2(m, 3 * i, ad);
        link2(m, 3 * i + 1, free_side(3 * j + 2));
        link2(m, 3 * i + 2, ca);
        link2(m, 3 * j, db);
        link2(m, 3 * j + 1, bc);
        push(m, 3 * i);
        push(m, 3 * j);
    }
}

uint32_t delaunay_find(const struct delaunay *m, struct planar_point p, uint32_t from,
                       int *out_side)
{
    uint32_t t = from;
    for (size_t steps = 0; steps < 4 * m->triangle_count + 16; steps++) {
        int on = 3, leave = 3;
        for (int i = 0; i < 3; i++) {
            int k = (i + (int)(steps % 3)) % 3; /* no fixed order, or a walk could go in circles */
            const struct planar_triangle *x = &m->triangles[t];
            int64_t s = planar_orient(m->points[x->v[k]], m->points[x->v[(k + 1) % 3]], p);
            if (s < 0) {
                leave = k;
                break;
            }
            if (s == 0)
                on = k;
        }
        if (leave == 3) {
            *out_side = on;
            return t;
        }
        uint32_t next = m->triangles[t].near[leave];
        if (next == PLANAR_NONE)
            return PLANAR_NONE;
        t = next / 3;
    }
    return PLANAR_NONE;
}

void delaunay_insert(struct delaunay *m, struct planar_point p, float value, uint32_t t, int side)
{
    if (!room(m))
        return;
    uint32_t n = (uint32_t)m->point_count;
    const struct planar_triangle old = m->triangles[t];
    for (int k = 0; k < 3; k++)
        if (planar_same(m->points[old.v[k]], p))
            return;
    m->points[n] = p;
    m->values[n] = value;
    m->jump[n] = 0;
    m->point_count++;
    uint32_t u = (uint32_t)m->triangle_count;
    if (side == 3) {
        uint32_t a = old.v[0], b = old.v[1], c = old.v[2];
        struct side ab = side_of(m, t, 0), bc = side_of(m, t, 1), ca = side_of(m, t, 2);
        m->triangle_count += 2;
        set(m, t, a, b, n);
        set(m, u, b, c, n);
        set(m, u + 1, c, a, n);
        link2(m, 3 * t, ab);
        link2(m, 3 * u, bc);
        link2(m, 3 * (u + 1), ca);
        link2(m, 3 * t + 1, free_side(3 * u + 2));
        link2(m, 3 * u + 1, free_side(3 * (u + 1) + 2));
        link2(m, 3 * (u + 1) + 1, free_side(3 * t + 2));
        push(m, 3 * t);
        push(m, 3 * u);
        push(m, 3 * (u + 1));
    } else {
        /* On the side a-b; the triangle beyond, if any, is a d b. */
        uint32_t k = (uint32_t)side;
        uint32_t a = old.v[k], b = old.v[(k + 1) % 3], c = old.v[(k + 2) % 3];
        struct side ab = side_of(m, t, k), bc = side_of(m, t, (k + 1) % 3),
                    ca = side_of(m, t, (k + 2) % 3);
        m->jump[n] = ab.fixed;
        if (ab.near == PLANAR_NONE) {
            m->triangle_count += 1;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * t + 2, free_side(3 * u + 1));
            push(m, 3 * t);
            push(m, 3 * u);
        } else {
            uint32_t s = ab.near / 3, l = ab.near % 3;
            uint32_t d = m->triangles[s].v[(l + 2) % 3];
            struct side ad = side_of(m, s, (l + 1) % 3), db = side_of(m, s, (l + 2) % 3);
            m->triangle_count += 2;
            set(m, t, c, a, n);
            set(m, u, b, c, n);
            set(m, s, a, d, n);
            set(m, u + 1, d, b, n);
            link2(m, 3 * t, ca);
            link2(m, 3 * u, bc);
            link2(m, 3 * s, ad);
            link2(m, 3 * (u + 1), db);
            /* a-n and n-b are what a-b was. */
            link2(m, 3 * t + 1, (struct side){3 * s + 2, ab.fixed});
            link2(m, 3 * s + 1, free_side(3 * (u + 1) + 2));
            link2(m, 3 * (u + 1) + 1, (struct side){3 * u + 2, ab.fixed});
            link2(m, 3 * u + 1, free_side(3 * t + 2));
            push(m, 3 * t);
            push(m, 3 * u);
            push(m, 3 * s);
            push(m, 3 * (u + 1));
        }
    }
    legalize(m);
}

void delaunay_start(struct delaunay *m, struct planar_point lo, struct planar_point hi)
{
    struct planar_point corners[4] = {lo, {hi.x, lo.y}, hi, {lo.x, hi.y}};
    for (int i = 0; i < 4 && room(m); i++) {
        m->points[m->point_count] = corners[i];
        m->jump[m->point_count] = 0;
        m->values[m->point_count++] = 0;
    }
    if (!room(m))
        return;
    m->triangle_count = 2;
    set(m, 0, 0, 1, 2);
    set(m, 1, 0, 2, 3);
    link2(m, 2, free_side(3));
}

void delaunay_add_grid(struct delaunay *m, struct planar_point lo, struct planar_point hi,
                       int cells)
{
    double w = (double)hi.x - lo.x, h = (double)hi.y - lo.y;
    int nx = (int)fmax(2, w > h ? cells : cells * w / h + 0.5);
    int ny = (int)fmax(2, w > h ? cells * h / w + 0.5 : cells);
    for (int j = 0; j <= ny; j++)
        for (int i = 0; i <= nx; i++) {
            struct planar_point p = {lo.x + (int32_t)(w * i / nx), lo.y + (int32_t)(h * j / ny)};
            int side;
            uint32_t t = delaunay_find(m, p, (uint32_t)m->triangle_count - 1, &side);
            if (t != PLANAR_NONE)
                delaunay_insert(m, p, 0, t, side);
        }
}

uint32_t delaunay_add_point(struct delaunay *m, struct planar_point p)
{
    int side;
    uint32_t t = delaunay_find(m, p, (uint32_t)m->triangle_count - 1, &side);
    if (t == PLANAR_NONE)
        return PLANAR_NONE;
    for (int k = 0; k < 3; k++)
        if (planar_same(m->points[m->triangles[t].v[k]], p)) {
            m->jump[m->triangles[t].v[k]] = 1;
            return m->triangles[t].v[k];
        }
    size_t before = m->point_count;
    delaunay_insert(m, p, 1, t, side);
    if (m->point_count == before)
        return PLANAR_NONE;
    m->jump[before] = 1;
    return (uint32_t)before;
}

void delaunay_force_edge(struct delaunay *m, uint32_t a, uint32_t b, int depth)
{
    if (a == PLANAR_NONE || b == PLANAR_NONE || a == b || m->no_memory)
        return;
    for (uint32_t i = 0; i < 3 * m->triangle_count; i++) {
        const uint32_t *v = m->triangles[i / 3].v;
        if (v[i % 3] == a && v[(i % 3 + 1) % 3] == b) {
            fix(m, i);
            return;
        }
    }
    if (depth > 10)
        return;
    struct planar_point p = m->points[a], q = m->points[b];
    struct planar_point middle = {(int32_t)floor(0.5 * ((double)p.x + q.x)),
                                  (int32_t)floor(0.5 * ((double)p.y + q.y))};
    uint32_t c = delaunay_add_point(m, middle);
    delaunay_force_edge(m, a, c, depth + 1);
    delaunay_force_edge(m, c, b, depth + 1);
}
