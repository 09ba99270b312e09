/* method/planar/write_geojson.c: the rings as polygons with holes, metres along the plane's axes.
 *
 * Features "outer" (ring 1), "umbra" (ring K) and "ring" 1..K, each a MultiPolygon: outer
 * boundaries counter-clockwise, holes clockwise, each hole with the smallest boundary that holds
 * it. Of a refined mesh, which has no rings, the lines of intensity 1/16 .. 15/16, 1/256 ("outer")
 * and 255/256 ("umbra") through its triangles take their place. RFC 7946 wants longitude and
 * latitude; a plane has none, so "coordinates" are metres, as in GeoJSON of 2008 without a
 * reference system.
 */
#include <stdlib.h>
#include <string.h>

#include "method/planar/shadow.h"

struct chain {
    size_t first, count; /* into points */
    double area;         /* counter-clockwise above 0 */
    double box[4];
    size_t parent;
};

struct outline2 {
    double *points; /* x, y */
    size_t point_count, point_capacity;
    struct chain *chains;
    size_t chain_count, chain_capacity;
};

static bool add_chain(pnb_context *context, struct outline2 *o, size_t count)
{
    if (!memory_reserve(context, (void **)&o->chains, &o->chain_capacity, o->chain_count, 1,
                        sizeof(*o->chains)))
        return false;
    struct chain c = {
        o->point_count - count, count, 0, {INFINITY, INFINITY, -INFINITY, -INFINITY}, 0};
    const double *p = o->points + 2 * c.first;
    for (size_t i = 0; i < count; i++) {
        size_t j = i + 1 < count ? i + 1 : 0;
        c.area += 0.5 * (p[2 * i] * p[2 * j + 1] - p[2 * i + 1] * p[2 * j]);
        for (int axis = 0; axis < 2; axis++) {
            c.box[axis] = fmin(c.box[axis], p[2 * i + axis]);
            c.box[2 + axis] = fmax(c.box[2 + axis], p[2 * i + axis]);
        }
    }
    if (c.area != 0)
        o->chains[o->chain_count++] = c;
    return true;
}

/* Ring `level` of a sheet, turned so that the inside is on the left. */
static pnb_status ring(const struct pnb_shadow *s, struct planar_workspace *w, int level,
                       struct outline2 *o)
{
    const struct shadow_sheet *sheet = &s->sheets[0];
    struct planar_result r = {.points = sheet->points,
                              .point_count = sheet->point_count,
                              .edges = sheet->edges,
                              .edge_count = sheet->edge_count};
    struct planar_chains chains;
    pnb_status status = planar_rings(w, &r, level, &chains);
    if (status)
        return status;
    size_t total = chains.starts[chains.chain_count];
    bool ok = memory_reserve(s->context, (void **)&o->points, &o->point_capacity, 0, total,
                             2 * sizeof(*o->points));
    for (size_t c = 0; c < chains.chain_count && ok; c++) {
        for (uint32_t i = chains.starts[c + 1]; i-- > chains.starts[c];) {
            struct planar_point p = sheet->points[chains.points[i]];
            o->points[2 * o->point_count] = sheet->origin[0] + p.x / sheet->scale;
            o->points[2 * o->point_count++ + 1] = sheet->origin[1] + p.y / sheet->scale;
        }
        ok = add_chain(s->context, o, chains.starts[c + 1] - chains.starts[c]);
    }
    planar_chains_finish(s->context, &chains);
    return ok ? PNB_OK : status_no_memory(s->context, 0);
}

/* A place where a line of equal intensity crosses a side of the mesh; sides are named by their two
 * vertices, so both triangles of a side name the same place. */
struct step {
    uint64_t from, to;
    double at[2]; /* of from */
    size_t next;
};

static int by_from(const void *a, const void *b)
{
    const struct step *p = a, *q = b;
    return p->from < q->from ? -1 : p->from > q->from;
}

static uint64_t cross(const struct pnb_shadow *s, uint32_t a, uint32_t b, double level, double *at)
{
    if (a > b) {
        uint32_t t = a;
        a = b;
        b = t;
    }
    double fa = s->intensities[a], fb = s->intensities[b], t = (level - fa) / (fb - fa);
    for (int k = 0; k < 2; k++)
        at[k] = s->coordinates[2 * (size_t)a + k] +
                t * ((double)s->coordinates[2 * (size_t)b + k] - s->coordinates[2 * (size_t)a + k]);
    return (uint64_t)a << 32 | b;
}

/* The line where the intensity passes `level`, darker on the left. Lines that leave the mesh close
 * along its border, where intensity is below the level on the other side. */
static pnb_status contour(const struct pnb_shadow *s, double level, struct outline2 *o)
{
    struct step *steps = NULL;
    size_t count = 0, capacity = 0;
    bool ok = true;
    for (size_t t = 0; t < s->view.triangle_count && ok; t++) {
        const uint32_t *v = s->indices + 3 * t;
        bool in[3];
        for (int k = 0; k < 3; k++)
            in[k] = s->intensities[v[k]] >= level;
        struct step step = {0};
        int found = 0;
        for (int k = 0; k < 3; k++) {
            double at[2];
            if (in[k] == in[(k + 1) % 3])
                continue;
            uint64_t name = cross(s, v[k], v[(k + 1) % 3], level, at);
            found++;
            if (in[k]) { /* counter-clockwise out of the dark part: the line starts here */
                step.from = name;
                memcpy(step.at, at, sizeof(at));
            } else {
                step.to = name;
            }
        }
        if (found < 2)
            continue;
        ok = memory_reserve(s->context, (void **)&steps, &capacity, count, 1, sizeof(*steps));
        if (ok)
            steps[count++] = step;
    }
    if (ok && count > 0)
        qsort(steps, count, sizeof(*steps), by_from);
    for (size_t i = 0; i < count && ok; i++) {
        struct step key = {.from = steps[i].to};
        struct step *next = bsearch(&key, steps, count, sizeof(*steps), by_from);
        steps[i].next = next ? (size_t)(next - steps) : SIZE_MAX;
    }
    for (size_t i = 0; i < count && ok; i++) {
        size_t length = 0;
        for (size_t at = i; at != SIZE_MAX && steps[at].from != UINT64_MAX && ok;) {
            ok = memory_reserve(s->context, (void **)&o->points, &o->point_capacity, o->point_count,
                                1, 2 * sizeof(*o->points));
            if (!ok)
                break;
            memcpy(o->points + 2 * o->point_count++, steps[at].at, sizeof(steps[at].at));
            steps[at].from = UINT64_MAX;
            length++;
            at = steps[at].next;
        }
        if (length > 2)
            ok = ok && add_chain(s->context, o, length);
    }
    memory_free(s->context, steps);
    return ok ? PNB_OK : status_no_memory(s->context, 0);
}

static bool holds(const struct outline2 *o, const struct chain *c, const double *p)
{
    if (p[0] < c->box[0] || p[1] < c->box[1] || p[0] > c->box[2] || p[1] > c->box[3])
        return false;
    bool in = false;
    const double *q = o->points + 2 * c->first;
    for (size_t i = 0, j = c->count - 1; i < c->count; j = i++)
        if ((q[2 * i + 1] > p[1]) != (q[2 * j + 1] > p[1]) &&
            p[0] < q[2 * i] + (p[1] - q[2 * i + 1]) / (q[2 * j + 1] - q[2 * i + 1]) *
                                  (q[2 * j] - q[2 * i]))
            in = !in;
    return in;
}

static void write_chain(struct buffer *file, const struct outline2 *o, const struct chain *c)
{
    const double *p = o->points + 2 * c->first;
    buffer_print(file, "[");
    for (size_t i = 0; i <= c->count; i++)
        buffer_print(file, "%s[%.8g,%.8g]", i ? "," : "", p[2 * (i % c->count)],
                     p[2 * (i % c->count) + 1]);
    buffer_print(file, "]");
}

static void write_feature(struct buffer *file, struct outline2 *o, const char *name, int number,
                          double intensity, bool *io_first)
{
    /* A hole may touch its boundary: its middle points decide. */
    for (size_t i = 0; i < o->chain_count; i++) {
        struct chain *hole = &o->chains[i];
        hole->parent = SIZE_MAX;
        if (hole->area > 0)
            continue;
        const double *q = o->points + 2 * hole->first;
        double middle[2] = {0.5 * (q[0] + q[2]), 0.5 * (q[1] + q[3])};
        for (size_t j = 0; j < o->chain_count; j++)
            if (o->chains[j].area > -hole->area && holds(o, &o->chains[j], middle) &&
                (hole->parent == SIZE_MAX || o->chains[j].area < o->chains[hole->parent].area))
                hole->parent = j;
    }
    buffer_print(file, "%s{\"type\":\"Feature\",\"properties\":{\"name\":\"%s\",",
                 *io_first ? "" : ",\n", name);
    if (number > 0)
        buffer_print(file, "\"ring\":%d,", number);
    buffer_print(file,
                 "\"intensity\":%.9g},\"geometry\":{\"type\":\"MultiPolygon\",\"coordinates\":[",
                 intensity);
    *io_first = false;
    bool first = true;
    for (size_t i = 0; i < o->chain_count; i++) {
        if (o->chains[i].area <= 0)
            continue;
        buffer_print(file, "%s[", first ? "" : ",");
        first = false;
        write_chain(file, o, &o->chains[i]);
        for (size_t j = 0; j < o->chain_count; j++)
            if (o->chains[j].area < 0 && o->chains[j].parent == i) {
                buffer_print(file, ",");
                write_chain(file, o, &o->chains[j]);
            }
        buffer_print(file, "]");
    }
    buffer_print(file, "]}}");
}

pnb_status shadow_write_geojson(const struct pnb_shadow *s, double lift, struct buffer *file)
{
    struct planar_workspace *workspace;
    pnb_status status = planar_workspace_create(s->context, &workspace);
    if (status)
        return status;
    struct outline2 o = {0};
    bool first = true,
         rings = s->view.ring_count > 0 && s->view.plane_count > 0 && s->sheets[0].edges;
    int steps = rings ? s->view.ring_count : s->view.ring_count > 0 ? 0 : 15;
    buffer_print(file, "{\"type\":\"FeatureCollection\",\"features\":[\n");
    for (int i = -2; i < steps && !status; i++) {
        if (steps == 0)
            break;
        o.point_count = o.chain_count = 0;
        int number = i == -2 ? 1 : i == -1 ? steps : i + 1;
        double intensity = rings     ? (steps > 1 ? (number - 1.0) / (steps - 1) : 1)
                           : i == -2 ? 1 / 256.0
                           : i == -1 ? 255 / 256.0
                                     : number / 16.0;
        status = rings ? ring(s, workspace, number, &o) : contour(s, intensity, &o);
        if (!status)
            write_feature(file, &o,
                          i == -2   ? "outer"
                          : i == -1 ? "umbra"
                                    : "ring",
                          i >= 0 ? number : 0, intensity, &first);
    }
    buffer_print(file, "\n]}\n");
    memory_free(s->context, o.points);
    memory_free(s->context, o.chains);
    planar_workspace_destroy(workspace);
    return status;
}
