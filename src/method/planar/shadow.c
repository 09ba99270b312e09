/* method/planar/shadow.c: the shadow as geometry for the outside (include/penumbra/shadow.h).
 *
 * Corners of one point that have one value become one vertex; where the shadow jumps there are
 * several. Rings are traced from the arrangement's edges when a writer asks for them.
 */
#include "method/planar/shadow.h"

#include <string.h>

/* What has been visited of a plane. */
struct collector {
    struct pnb_shadow *shadow;
    const struct shadow_plane *plane;
    struct shadow_part *parts;
    size_t part_count, part_capacity;
    struct shadow_part merged;
};

/* The vertices of one part. */
static pnb_status add_vertices(struct pnb_shadow *s, const struct shadow_plane *plane,
                               const struct shadow_part *part)
{
    pnb_context *context = s->context;
    size_t corners = 3 * part->triangle_count;
    /* The vertices made of each point so far, as lists. */
    uint32_t *first = memory_alloc(context, part->point_count, sizeof(*first));
    uint32_t *next = memory_alloc(context, corners, sizeof(*next));
    bool ok = first && next &&
              memory_reserve(context, (void **)&s->positions, &s->position_capacity,
                             3 * s->view.vertex_count, 3 * corners, sizeof(float)) &&
              memory_reserve(context, (void **)&s->coordinates, &s->coordinate_capacity,
                             2 * s->view.vertex_count, 2 * corners, sizeof(float)) &&
              memory_reserve(context, (void **)&s->intensities, &s->intensity_capacity,
                             s->view.vertex_count, corners, sizeof(float)) &&
              memory_reserve(context, (void **)&s->indices, &s->index_capacity,
                             3 * s->view.triangle_count, corners, sizeof(uint32_t));
    for (size_t i = 0; i < part->point_count && ok; i++)
        first[i] = PLANAR_NONE;
    size_t base = s->view.vertex_count, count = base;
    for (size_t i = 0; i < part->triangle_count && ok; i++) {
        const struct shadow_triangle *t = &part->triangles[i];
        for (int k = 0; k < 3; k++) {
            uint32_t v = first[t->v[k]];
            while (v != PLANAR_NONE && s->intensities[base + v] != t->value[k])
                v = next[v];
            if (v == PLANAR_NONE) {
                v = (uint32_t)(count - base);
                next[v] = first[t->v[k]];
                first[t->v[k]] = v;
                double x = part->points[2 * (size_t)t->v[k]];
                double y = part->points[2 * (size_t)t->v[k] + 1];
                v3_storef(s->positions + 3 * count,
                          silhouette_from_plane(&plane->frame, v3(x, y, 0)));
                s->coordinates[2 * count] = (float)x;
                s->coordinates[2 * count + 1] = (float)y;
                s->intensities[count++] = t->value[k];
            }
            s->indices[3 * s->view.triangle_count + (size_t)k] = (uint32_t)(base + v);
        }
        s->view.triangle_count++;
    }
    s->view.vertex_count = count;
    memory_free(context, first);
    memory_free(context, next);
    return ok ? PNB_OK : status_no_memory(context, corners * 40);
}

/* A plane whose parts are all there. */
static pnb_status add_plane(struct pnb_shadow *s, const struct shadow_plane *plane,
                            const struct shadow_part *part)
{
    struct shadow_sheet *sheet = &s->sheets[s->view.plane_count];
    s->planes[s->view.plane_count] = (uint32_t)plane->object;
    s->first_triangles[s->view.plane_count++] = (uint32_t)s->view.triangle_count;
    sheet->frame = plane->frame;
    memcpy(sheet->lo, plane->lo, sizeof(sheet->lo));
    memcpy(sheet->hi, plane->hi, sizeof(sheet->hi));
    s->view.ring_count = part->rings;
    pnb_status status = add_vertices(s, plane, part);
    s->first_triangles[s->view.plane_count] = (uint32_t)s->view.triangle_count;
    if (status || part->edge_count == 0)
        return status;
    /* What the rings are traced from. */
    sheet->edges = memory_alloc(s->context, part->edge_count, sizeof(*sheet->edges));
    sheet->points = memory_alloc(s->context, part->point_count, sizeof(*sheet->points));
    if (!sheet->edges || !sheet->points)
        return status_no_memory(s->context, part->edge_count * sizeof(*sheet->edges));
    memcpy(sheet->edges, part->edges, part->edge_count * sizeof(*sheet->edges));
    sheet->edge_count = part->edge_count;
    for (size_t i = 0; i < part->point_count; i++)
        sheet->points[i] = (struct planar_point){
            (int32_t)floor((part->points[2 * i] - part->origin[0]) * part->scale + 0.5),
            (int32_t)floor((part->points[2 * i + 1] - part->origin[1]) * part->scale + 0.5)};
    sheet->point_count = part->point_count;
    memcpy(sheet->origin, part->origin, sizeof(sheet->origin));
    sheet->scale = part->scale;
    return PNB_OK;
}

static pnb_status finish_plane(struct collector *c)
{
    struct planar_state *state = c->shadow->solver->state;
    pnb_status status = PNB_OK;
    if (c->part_count == 1)
        status = add_plane(c->shadow, c->plane, &c->parts[0]);
    if (c->part_count > 1)
        status = shadow_merge(&state->builder, c->parts, c->part_count, &c->merged);
    if (c->part_count > 1 && !status)
        status = add_plane(c->shadow, c->plane, &c->merged);
    for (size_t i = 0; i < c->part_count; i++)
        shadow_part_finish(c->shadow->context, &c->parts[i]);
    c->part_count = 0;
    return status;
}

/* Takes the part's arrays: the next one makes its own. */
static pnb_status collect(void *user, const struct shadow_plane *plane, struct shadow_part *part,
                          bool first)
{
    struct collector *c = user;
    pnb_status status = first ? finish_plane(c) : PNB_OK;
    if (status)
        return status;
    if (!memory_reserve(c->shadow->context, (void **)&c->parts, &c->part_capacity, c->part_count, 1,
                        sizeof(*c->parts)))
        return status_no_memory(c->shadow->context, sizeof(*c->parts));
    c->plane = plane;
    c->parts[c->part_count++] = *part;
    *part = (struct shadow_part){0};
    return PNB_OK;
}

pnb_status pnb_shadow_create(pnb_context *context, pnb_scene *scene, const pnb_light *light,
                             const pnb_solver_desc *desc, pnb_shadow **out_shadow)
{
    pnb_solver_desc planar = desc ? *desc : (pnb_solver_desc){0};
    planar.method = "planar";
    *out_shadow = NULL;
    pnb_status status = pnb_light_check(context, light);
    if (status)
        return status;
    struct pnb_shadow *s = memory_calloc(context, 1, sizeof(*s));
    if (!s)
        return status_no_memory(context, sizeof(*s));
    s->context = context;
    s->lift = 1e-4;
    s->sheets = memory_calloc(context, scene->object_count + 1, sizeof(*s->sheets));
    s->planes = memory_calloc(context, scene->object_count + 1, sizeof(*s->planes));
    s->first_triangles = memory_calloc(context, scene->object_count + 2, sizeof(*s->planes));
    if (!s->sheets || !s->planes || !s->first_triangles)
        status = status_no_memory(context, scene->object_count * sizeof(*s->sheets));
    if (!status)
        status = pnb_solver_create(context, scene, &planar, &s->solver);
    if (!status) {
        double started = clock_ms();
        struct collector collector = {.shadow = s};
        status = shadow_visit(s->solver, light, collect, &collector);
        if (!status)
            status = finish_plane(&collector);
        for (size_t i = 0; i < collector.part_count; i++)
            shadow_part_finish(context, &collector.parts[i]);
        memory_free(context, collector.parts);
        shadow_part_finish(context, &collector.merged);
        s->solver->report.visibility_ms = clock_ms() - started;
    }
    if (status) {
        pnb_shadow_destroy(s);
        return status;
    }
    for (size_t i = 0; i < s->view.plane_count; i++)
        for (int axis = 0; axis < 2; axis++)
            s->lift = fmax(s->lift, 1e-4 * (s->sheets[i].hi[axis] - s->sheets[i].lo[axis]));
    s->view.positions = s->positions;
    s->view.coordinates = s->coordinates;
    s->view.intensities = s->intensities;
    s->view.indices = s->indices;
    s->view.planes = s->planes;
    s->view.first_triangles = s->first_triangles;
    *out_shadow = s;
    return PNB_OK;
}

void pnb_shadow_destroy(pnb_shadow *s)
{
    if (!s)
        return;
    for (size_t i = 0; i < s->view.plane_count; i++) {
        memory_free(s->context, s->sheets[i].edges);
        memory_free(s->context, s->sheets[i].points);
    }
    void *blocks[] = {s->sheets,      s->planes,      s->first_triangles, s->positions,
                      s->coordinates, s->intensities, s->indices};
    for (size_t i = 0; i < sizeof(blocks) / sizeof(blocks[0]); i++)
        memory_free(s->context, blocks[i]);
    pnb_solver_destroy(s->solver);
    memory_free(s->context, s);
}

void pnb_shadow_get(const pnb_shadow *shadow, pnb_shadow_view *out_view)
{
    *out_view = shadow->view;
}

void pnb_shadow_get_plane(const pnb_shadow *shadow, size_t plane, pnb_shadow_plane *out)
{
    const struct shadow_sheet *sheet = &shadow->sheets[plane];
    v3_store(out->origin, sheet->frame.origin);
    v3_store(out->axis_u, sheet->frame.u);
    v3_store(out->axis_v, sheet->frame.v);
    v3_store(out->normal, sheet->frame.n);
    out->half_u = fmax(-sheet->lo[0], sheet->hi[0]);
    out->half_v = fmax(-sheet->lo[1], sheet->hi[1]);
}

void pnb_shadow_get_report(const pnb_shadow *shadow, pnb_solver_report *out_report)
{
    pnb_solver_get_report(shadow->solver, out_report);
}

static bool ends_in(const char *path, const char *ending)
{
    size_t n = strlen(path), m = strlen(ending);
    if (n < m)
        return false;
    for (size_t i = 0; i < m; i++) {
        char c = path[n - m + i];
        if ((c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c) != ending[i])
            return false;
    }
    return true;
}

pnb_status pnb_shadow_write(pnb_shadow *s, const char *path, double lift)
{
    if (!path)
        return status_missing(s->context, "path");
    static const struct {
        const char *ending;
        pnb_status (*write)(const struct pnb_shadow *, double lift, struct buffer *);
        bool flat;
    } writers[] = {
        {".obj", shadow_write_obj, false}, {".ply", shadow_write_ply, false},
        {".glb", shadow_write_glb, false}, {".svg", shadow_write_svg, true},
        {".pdf", shadow_write_pdf, true},  {".geojson", shadow_write_geojson, true},
    };
    for (size_t i = 0; i < sizeof(writers) / sizeof(writers[0]); i++) {
        if (!ends_in(path, writers[i].ending))
            continue;
        if (writers[i].flat && s->view.plane_count > 1)
            return status_fail(s->context, PNB_ERROR_UNSUPPORTED, path,
                               "such a file holds one plane, not %zu: choose one by receiver=NAME",
                               s->view.plane_count);
        struct buffer file;
        buffer_init(s->context, &file);
        pnb_status status = writers[i].write(s, lift >= 0 ? lift : s->lift, &file);
        if (!status && file.failed)
            status = status_no_memory(s->context, file.size);
        if (!status)
            status = pnb_file_write(s->context, path, file.bytes, file.size);
        buffer_finish(&file);
        return status;
    }
    return status_fail(s->context, PNB_ERROR_ARGUMENT, path,
                       "ends in none of .obj .ply .glb .svg .pdf .geojson");
}
