/* method/dbuffer/volumes.c: silhouettes seen from a disk, and the volumes that they bound.
 *
 * Jakobsen et al., section 2.1. A plane through an edge that leaves the occluder on one side and
 * touches the rim bounds the umbra when the disk lies on the occluder's side (an outer tangent),
 * and the penumbra when it lies on the other (an inner tangent). For an edge between two faces of a
 * closed mesh such planes exist where
 *
 *   umbra:    one face is none-frontfacing and the other is not
 *   penumbra: one face is all-frontfacing and the other is not
 *
 * Where this differs from the paper:
 *   - Concave edges of closed meshes are left out: their own solid stands between them and every
 *     point of the light that could see them as an outline.
 *   - Edges of open meshes have no inside. There, each of the two tangent planes counts if all
 *     faces at the edge lie on one side of it (an open border always does with its one face).
 *   - Fans close both volumes: at corners that are convex, seen from the light, the penumbra quads
 *     part and the umbra quads cross; at reflex corners it is the other way round.
 *   - A fan's triangles touch the cone over the rim's arc from outside; the cone's own distance is
 *     found per fragment, so the arc's subdivision changes no value.
 *
 * Degenerate input: faces without area count as none-frontfacing; edges whose line meets the disk
 * (the light touches the occluder) are counted and skipped; edges that cross the light's plane are
 * cut just before it. Cost: a plane test per face, two look-ups per edge, the rest for silhouettes.
 */
#include "method/dbuffer/volumes.h"

#include <string.h>

/* Edges are cut at this share of the light's radius before its plane. */
#define PLANE_GAP 1e-3
/* Third corners within this share of their distance to a plane count as in it. */
#define FLAT 1e-6
/* An arc's triangle spans at most this angle; it sticks out of the rim by 1 / cos(half). */
#define ARC_STEP (M_PI / 6)
/* Faces between an umbra edge and the outline seen from the centre, at most. */
#define WALK_STEPS 24
/* The way there crosses edges that run within 70 degrees of the umbra edge. */
#define ALONG_COSINE 0.35
/* An outline belongs to an edge whose extrusion point lies within 60 degrees of where it looks. */
#define OUTLINE_COSINE 0.5
/* Concave edges in a row that join two silhouette edges, at most. */
#define BRIDGES_MAX 3
/* and how far they may lead, seen from the light's centre, in its radii. */
#define BRIDGE_MOST 0.15
/* Quads that part by more than this have no common corner to speak of. */
#define CORNER_MAX (0.9 * M_PI)

/* A silhouette edge as its two vertices see it: lists per vertex. */
struct dbuffer_link {
    uint32_t vertex[2]; /* from, to; the solid on the left */
    vec3 ends[2];       /* light space */
    double p[2];
    uint32_t next_out; /* of those that begin in vertex[0] */
    bool taken;        /* a corner ends in vertex[0] already */
    bool bridge;       /* a concave edge: no silhouette, but joins two of them */
    bool cut[2];       /* by the light's plane */
    size_t object;
    size_t piece;
};

void dbuffer_volumes_init(pnb_context *context, struct dbuffer_volumes *volumes)
{
    memset(volumes, 0, sizeof(*volumes));
    volumes->context = context;
}

void dbuffer_volumes_finish(struct dbuffer_volumes *volumes)
{
    pnb_context *context = volumes->context;
    for (int i = 0; i < 2; i++) {
        memory_free(context, volumes->quads[i].pieces);
        memory_free(context, volumes->fans[i].pieces);
    }
    memory_free(context, volumes->lines);
    memory_free(context, volumes->faces);
    memory_free(context, volumes->facing);
    memory_free(context, volumes->links);
    memory_free(context, volumes->heads);
    memory_free(context, volumes->across);
    memset(volumes, 0, sizeof(*volumes));
}

static vec3 vertex(const struct gl_occluders *o, const struct silhouette_disk *disk, uint32_t v)
{
    return silhouette_disk_from_world(disk, v3_loadf(o->positions + 3 * (size_t)v));
}

/* The corner of a triangle that is neither a nor b. */
static uint32_t third_corner(const struct gl_occluders *o, uint32_t triangle, uint32_t a,
                             uint32_t b)
{
    const uint32_t *t = o->indices + 3 * (size_t)triangle;
    for (int i = 0; i < 2; i++)
        if (t[i] != a && t[i] != b)
            return t[i];
    return t[2];
}

static struct dbuffer_piece *add_piece(pnb_context *context, struct dbuffer_pieces *to, vec3 v1,
                                       vec3 v2, const double p1[2], const double p2[2])
{
    if (!memory_reserve(context, (void **)&to->pieces, &to->capacity, to->count, 1,
                        sizeof(*to->pieces)))
        return NULL;
    struct dbuffer_piece *piece = &to->pieces[to->count++];
    memset(piece, 0, sizeof(*piece));
    v3_storef(piece->v1, v1);
    v3_storef(piece->v2, v2);
    for (int i = 0; i < 2; i++) {
        piece->p1[i] = (float)p1[i];
        piece->p2[i] = (float)p2[i];
    }
    piece->line = piece->outline_line = DBUFFER_NONE;
    return piece;
}

static bool add_line(struct dbuffer_volumes *s, vec3 v1, vec3 v2, float *out_index)
{
    if (!memory_reserve(s->context, (void **)&s->lines, &s->line_capacity, s->line_count, 1,
                        sizeof(*s->lines)))
        return false;
    *out_index = (float)s->line_count;
    struct dbuffer_line *line = &s->lines[s->line_count++];
    v3_storef(line->v1, v1);
    v3_storef(line->v2, v2);
    line->before = line->after = DBUFFER_NONE;
    return true;
}

/* det[a - p, b - p, x - p]: negative where x lies left of ab, seen from p. */
static double side(const double p[2], vec3 a, vec3 b, vec3 x)
{
    vec3 at = v3(p[0], p[1], 0);
    return v3_dot(v3_cross(v3_sub(a, at), v3_sub(b, at)), v3_sub(x, at));
}

/* How far the light's centre lies over a face's plane, in what the disk reaches over it: in (-1, 1)
 * for silhouette faces. */
static double height_over(const struct gl_occluders *o, const struct silhouette_disk *disk,
                          uint32_t triangle)
{
    const float *plane = o->planes + 4 * (size_t)triangle;
    vec3 n = v3_loadf(plane);
    double along = v3_dot(n, disk->normal), reach = sqrt(fmax(1 - along * along, 1e-12));
    return (v3_dot(n, disk->center) + plane[3]) / (reach * disk->radius);
}

/* From a face that the centre lies behind, up the slope from face to face, to the edge where the
 * centre comes to see them; NULL where the way is lost. */
static const struct gl_edge *find_outline(const struct dbuffer_volumes *s,
                                          const struct gl_occluders *o,
                                          const struct silhouette_disk *disk, uint32_t triangle,
                                          vec3 along)
{
    uint32_t came = MESH_NONE;
    for (int step = 0; step < WALK_STEPS; step++) {
        uint32_t best_edge = MESH_NONE, best = MESH_NONE;
        double best_height = -1;
        /* Across edges that run along the first one, or else across any. */
        for (int i = 0; i < 6 && (i != 3 || best_edge == MESH_NONE); i++) {
            uint32_t e = s->across[3 * (size_t)triangle + i % 3];
            if (e == MESH_NONE || e == came)
                continue;
            const struct gl_edge *edge = &o->edges[e];
            vec3 runs = v3_sub(v3_loadf(o->positions + 3 * (size_t)edge->b),
                               v3_loadf(o->positions + 3 * (size_t)edge->a));
            if (i < 3 && fabs(v3_dot(runs, along)) < ALONG_COSINE * v3_length(runs))
                continue;
            uint32_t other = edge->first == triangle ? edge->second : edge->first;
            double height = other == MESH_NONE ? -HUGE_VAL : height_over(o, disk, other);
            if (height > best_height) {
                best_height = height;
                best = other;
                best_edge = e;
            }
        }
        if (best_edge == MESH_NONE)
            return NULL;
        if (best_height > 0)
            return &o->edges[best_edge];
        triangle = best;
        came = best_edge;
    }
    return NULL;
}

/* The ends of an outline edge with the solid on the left. */
static void outline_ends(const struct gl_occluders *o, const struct silhouette_disk *disk,
                         const struct gl_edge *edge, vec3 ends[2])
{
    bool first_seen = height_over(o, disk, edge->first) > 0;
    ends[first_seen ? 0 : 1] = vertex(o, disk, edge->a);
    ends[first_seen ? 1 : 0] = vertex(o, disk, edge->b);
}

/* How far off the segment ab, seen from c, stands g: squared, in slopes. */
static double off_segment(vec3 a, vec3 b, vec3 g)
{
    double ax = a.x / a.z - g.x / g.z, ay = a.y / a.z - g.y / g.z;
    double ex = b.x / b.z - a.x / a.z, ey = b.y / b.z - a.y / a.z, size = ex * ex + ey * ey;
    double k = size > 0 ? fmin(1, fmax(0, -(ax * ex + ay * ey) / size)) : 0;
    ax += k * ex, ay += k * ey;
    return ax * ax + ay * ay;
}

/* The edges where the centre comes to see the faces, among those around a face that it lies behind:
 * the nearest one to the face's middle, seen from there. NULL: none near. */
static const struct gl_edge *nearest_outline(const struct dbuffer_volumes *s,
                                             const struct gl_occluders *o,
                                             const struct silhouette_disk *disk, uint32_t triangle)
{
    uint32_t known[WALK_STEPS] = {triangle};
    size_t count = 1;
    const uint32_t *t = o->indices + 3 * (size_t)triangle;
    vec3 g = v3_add(v3_add(vertex(o, disk, t[0]), vertex(o, disk, t[1])), vertex(o, disk, t[2]));
    vec3 n = v3_loadf(o->planes + 4 * (size_t)triangle);
    vec3 looks = v3(v3_dot(n, disk->u), v3_dot(n, disk->v), 0);
    const struct gl_edge *best = NULL;
    double least = INFINITY;
    if (g.z <= 0)
        return NULL;
    for (size_t at = 0; at < count; at++)
        for (int i = 0; i < 3; i++) {
            uint32_t e = s->across[3 * (size_t)known[at] + (size_t)i];
            if (e == MESH_NONE)
                continue;
            const struct gl_edge *edge = &o->edges[e];
            uint32_t other = edge->first == known[at] ? edge->second : edge->first;
            if (other == MESH_NONE)
                continue;
            if (height_over(o, disk, other) > 0) {
                vec3 ends[2];
                outline_ends(o, disk, edge, ends);
                vec3 out = v3_cross(ends[0], ends[1]);
                double along = out.x * looks.x + out.y * looks.y;
                bool ahead = ends[0].z > 0 && ends[1].z > 0 &&
                             along > OUTLINE_COSINE * hypot(out.x, out.y) * hypot(looks.x, looks.y);
                double off = ahead ? off_segment(ends[0], ends[1], g) : INFINITY;
                if (off < least) {
                    least = off;
                    best = edge;
                }
                continue;
            }
            bool seen = count == WALK_STEPS;
            for (size_t k = 0; k < count && !seen; k++)
                seen = known[k] == other;
            if (!seen)
                known[count++] = other;
        }
    return best;
}

/* The outline before an umbra edge of a closed mesh: the edge itself if the centre sees one of its
 * faces. */
static const struct gl_edge *outline_of_edge(const struct dbuffer_volumes *s,
                                             const struct gl_occluders *o,
                                             const struct silhouette_disk *disk,
                                             const struct gl_edge *edge)
{
    double first = height_over(o, disk, edge->first), second = height_over(o, disk, edge->second);
    if (first > 0 || second > 0)
        return (first > 0) != (second > 0) ? edge : NULL;
    return find_outline(s, o, disk, first > second ? edge->first : edge->second,
                        v3_normalize(v3_sub(v3_loadf(o->positions + 3 * (size_t)edge->b),
                                            v3_loadf(o->positions + 3 * (size_t)edge->a))));
}

/* The outline before an umbra edge: the edge itself where no other is found. */
static bool add_outline(struct dbuffer_volumes *s, const struct gl_occluders *o,
                        const struct silhouette_disk *disk, const struct gl_edge *edge,
                        const vec3 ends[2], const double p[2], struct dbuffer_piece *piece)
{
    const struct gl_edge *outline = outline_of_edge(s, o, disk, edge);
    vec3 at[2] = {ends[0], ends[1]};
    double points[2][2];
    if (outline) {
        /* One that looks another way belongs to another side of the solid. */
        outline_ends(o, disk, outline, at);
        vec3 out = v3_cross(at[0], at[1]);
        bool known = out.x * p[0] + out.y * p[1] > OUTLINE_COSINE * disk->radius * v3_length(out);
        if (!known)
            at[0] = ends[0], at[1] = ends[1];
        else if (outline != edge && silhouette_disk_tangents(disk->radius, at[0], at[1], points)) {
            for (int i = 0; i < 2; i++)
                piece->outline_p[i] = (float)points[0][i];
            if (!add_line(s, at[0], at[1], &piece->outline_line))
                return false;
        }
    }
    v3_storef(piece->outline1, at[0]);
    v3_storef(piece->outline2, at[1]);
    return true;
}

/* The quad of a directed silhouette edge, and its ends for the fans. */
static bool add_edge(struct dbuffer_volumes *s, const struct gl_occluders *o,
                     const struct silhouette_disk *disk, bool penumbra, size_t object,
                     const struct gl_edge *edge, const uint32_t index[2], const vec3 ends[2],
                     const double p[2])
{
    double least = PLANE_GAP * disk->radius;
    struct dbuffer_link link = {.vertex = {index[0], index[1]},
                                .ends = {ends[0], ends[1]},
                                .p = {p[0], p[1]},
                                .object = object};
    if (ends[0].z < least && ends[1].z < least)
        return true;
    for (int i = 0; i < 2; i++) {
        vec3 in = ends[i], out = ends[1 - i];
        if (in.z >= least)
            continue;
        link.ends[i] = v3_mad(in, v3_sub(out, in), (least - in.z) / (out.z - in.z));
        link.cut[i] = true;
    }
    s->edges[penumbra]++;
    link.piece = s->quads[penumbra].count;
    struct dbuffer_piece *piece =
        add_piece(s->context, &s->quads[penumbra], link.ends[0], link.ends[1], p, p);
    if (!piece ||
        !memory_reserve(s->context, (void **)&s->links, &s->link_capacity, s->link_count, 1,
                        sizeof(*s->links)) ||
        !add_line(s, link.ends[0], link.ends[1], &piece->line))
        return false;
    if (!penumbra && o->objects[object].closed &&
        !add_outline(s, o, disk, edge, link.ends, p, piece))
        return false;
    s->links[s->link_count++] = link;
    return true;
}

static bool add_tangents(struct dbuffer_volumes *s, const struct gl_occluders *o,
                         const struct silhouette_disk *disk, const struct gl_edge *edge, bool plain,
                         size_t object, bool penumbra)
{
    vec3 ends[2] = {vertex(o, disk, edge->a), vertex(o, disk, edge->b)};
    uint32_t index[2] = {edge->a, edge->b};
    double points[2][2];
    if (ends[0].z <= 0 && ends[1].z <= 0)
        return true;
    if (!silhouette_disk_tangents(disk->radius, ends[0], ends[1], points)) {
        s->skipped_edges++;
        return true;
    }
    if (plain) {
        /* The face that is seen runs counter-clockwise: the solid is on the left. */
        bool first_seen = penumbra ? s->facing[edge->first] == SILHOUETTE_ALL_FRONTFACING
                                   : s->facing[edge->first] != SILHOUETTE_NONE_FRONTFACING;
        if (!first_seen) {
            vec3 end = ends[0];
            ends[0] = ends[1], ends[1] = end;
            index[0] = edge->b, index[1] = edge->a;
        }
        /* The other way round, the tangents change places. */
        const double *p = points[(penumbra ? 1 : 0) ^ (first_seen ? 0 : 1)];
        return add_edge(s, o, disk, penumbra, object, edge, index, ends, p);
    }
    /* No inside: each tangent plane that leaves all faces on one side. */
    uint32_t corners[2] = {third_corner(o, edge->first, edge->a, edge->b), MESH_NONE};
    if (edge->second != MESH_NONE)
        corners[1] = third_corner(o, edge->second, edge->a, edge->b);
    for (int k = 0; k < 2; k++) {
        double sides[2] = {side(points[k], ends[0], ends[1], vertex(o, disk, corners[0])), 0};
        sides[1] = corners[1] == MESH_NONE
                       ? sides[0]
                       : side(points[k], ends[0], ends[1], vertex(o, disk, corners[1]));
        if (sides[0] * sides[1] <= 0)
            continue;
        bool swap = sides[0] > 0, is_umbra = (k == 0) != swap;
        const uint32_t directed[2] = {index[swap], index[!swap]};
        const vec3 directed_ends[2] = {ends[swap], ends[!swap]};
        if (is_umbra == penumbra)
            continue;
        if (!add_edge(s, o, disk, penumbra, object, edge, directed, directed_ends, points[k]))
            return false;
    }
    return true;
}

/* The arc from one extrusion point to the next as triangles around it. */
static bool add_fan(struct dbuffer_volumes *s, bool penumbra, double radius,
                    const struct dbuffer_link *in, const struct dbuffer_link *out, double turn)
{
    int count = (int)ceil(fabs(turn) / ARC_STEP);
    double step = turn / count, start = atan2(in->p[1], in->p[0]);
    double outside = radius / cos(step / 2), last[2] = {in->p[0], in->p[1]};
    struct dbuffer_piece *quads = s->quads[penumbra].pieces;
    for (int i = 0; i <= count; i++) {
        double angle = start + (i == count ? turn : (i + 0.5) * step);
        double r = i == count ? radius : outside, p[2] = {r * cos(angle), r * sin(angle)};
        struct dbuffer_piece *piece =
            add_piece(s->context, &s->fans[penumbra], in->ends[1], in->ends[1], last, p);
        if (!piece)
            return false;
        piece->line = fabs(turn) < CORNER_MAX ? quads[in->piece].line : DBUFFER_NONE;
        memcpy(piece->outline1, quads[in->piece].outline1, sizeof(piece->outline1));
        memcpy(piece->outline2, quads[in->piece].outline2, sizeof(piece->outline2));
        last[0] = p[0], last[1] = p[1];
    }
    return true;
}

/* The solid lies on the left, so the outline turns to the right (turn < 0) where it is convex. */
static void join_lines(struct dbuffer_volumes *s, bool penumbra, const struct dbuffer_link *in,
                       const struct dbuffer_link *out, double turn)
{
    const struct dbuffer_piece *quads = s->quads[penumbra].pieces;
    float before = quads[in->piece].line, after = quads[out->piece].line;
    float mark = turn > 0 ? DBUFFER_REFLEX : 0;
    if (fabs(turn) < CORNER_MAX) {
        s->lines[(size_t)before].after = after + mark;
        s->lines[(size_t)after].before = before + mark;
    }
}

/* A concave edge between silhouette edges, in their direction. */
static bool add_bridge(struct dbuffer_volumes *s, const struct gl_edge *edge, bool penumbra,
                       size_t object)
{
    bool first_seen = penumbra ? s->facing[edge->first] == SILHOUETTE_ALL_FRONTFACING
                               : s->facing[edge->first] != SILHOUETTE_NONE_FRONTFACING;
    if (!memory_reserve(s->context, (void **)&s->links, &s->link_capacity, s->link_count, 1,
                        sizeof(*s->links)))
        return false;
    s->links[s->link_count++] = (struct dbuffer_link){
        .vertex = {first_seen ? edge->a : edge->b, first_seen ? edge->b : edge->a},
        .object = object,
        .bridge = true};
    return true;
}

/* Of several edges that leave a vertex, the one that turns least. */
static struct dbuffer_link *find_next(const struct dbuffer_volumes *s,
                                      const struct dbuffer_link *in, uint32_t from,
                                      double *out_turn)
{
    struct dbuffer_link *best = NULL;
    for (uint32_t k = s->heads[from]; k != MESH_NONE; k = s->links[k].next_out) {
        struct dbuffer_link *out = &s->links[k];
        if (out->bridge || out->taken || out->cut[0] || out->object != in->object)
            continue;
        double turn = atan2(in->p[0] * out->p[1] - in->p[1] * out->p[0],
                            in->p[0] * out->p[0] + in->p[1] * out->p[1]);
        if (!best || fabs(turn) < fabs(*out_turn)) {
            best = out;
            *out_turn = turn;
        }
    }
    return best;
}

static uint32_t cross_bridge(const struct dbuffer_volumes *s, const struct dbuffer_link *in,
                             uint32_t from)
{
    for (uint32_t k = s->heads[from]; k != MESH_NONE; k = s->links[k].next_out)
        if (s->links[k].bridge && s->links[k].object == in->object)
            return s->links[k].vertex[1];
    return MESH_NONE;
}

/* Joins neighbouring edges; fans where their quads part. */
static bool add_fans(struct dbuffer_volumes *s, const struct gl_occluders *o, bool penumbra,
                     double radius)
{
    if (!memory_reserve(s->context, (void **)&s->heads, &s->head_capacity, 0, o->vertex_count,
                        sizeof(*s->heads)))
        return false;
    memset(s->heads, 0xff, o->vertex_count * sizeof(*s->heads));
    for (size_t i = 0; i < s->link_count; i++) {
        uint32_t *head = &s->heads[s->links[i].vertex[0]];
        s->links[i].next_out = *head;
        *head = (uint32_t)i;
    }
    for (size_t i = 0; i < s->link_count; i++) {
        const struct dbuffer_link *in = &s->links[i];
        if (in->bridge || in->cut[1])
            continue;
        double turn = 0;
        uint32_t vertex = in->vertex[1];
        struct dbuffer_link *out = find_next(s, in, vertex, &turn);
        for (int k = 0; k < BRIDGES_MAX && !out && vertex != MESH_NONE; k++) {
            vertex = cross_bridge(s, in, vertex);
            out = vertex != MESH_NONE ? find_next(s, in, vertex, &turn) : NULL;
        }
        if (!out)
            continue;
        if (vertex != in->vertex[1]) {
            vec3 a = in->ends[1], b = out->ends[0];
            if (hypot(b.x - a.x * b.z / a.z, b.y - a.y * b.z / a.z) > BRIDGE_MOST * radius)
                continue;
        }
        out->taken = true;
        /* The solid is on the left, so an outline seen from the light along +z turns clockwise
         * in (x, y) around what is convex. */
        if (fabs(turn) > M_PI - 1e-6)
            turn = penumbra ? -M_PI : M_PI;
        bool parted = (turn < 0) == penumbra;
        /* Small open pieces, as leaves, hide one another: what passes one on two sides is too much.
         */
        if (parted || o->objects[in->object].closed)
            join_lines(s, penumbra, in, out, turn);
        if (fabs(turn) <= 1e-9 || !parted)
            continue;
        struct dbuffer_link far_end = *in;
        far_end.ends[1] = out->ends[0];
        if (!add_fan(s, penumbra, radius, in, out, turn) ||
            (vertex != in->vertex[1] && !add_fan(s, penumbra, radius, &far_end, out, turn)))
            return false;
    }
    return true;
}

static bool add_faces(struct dbuffer_volumes *s, const struct gl_occluders *o,
                      const struct silhouette_disk *disk)
{
    if (!memory_reserve(s->context, (void **)&s->across, &s->across_capacity, 0,
                        3 * o->triangle_count, sizeof(*s->across)))
        return false;
    memset(s->across, 0xff, 3 * o->triangle_count * sizeof(*s->across));
    for (size_t e = 0; e < o->edge_count; e++)
        for (int k = 0; k < 2; k++) {
            uint32_t t = k ? o->edges[e].second : o->edges[e].first;
            for (int i = 0; i < 3 && t != MESH_NONE; i++)
                if (s->across[3 * (size_t)t + i] == MESH_NONE) {
                    s->across[3 * (size_t)t + i] = (uint32_t)e;
                    break;
                }
        }
    for (size_t k = 0; k < o->object_count; k++) {
        const struct gl_occluder *object = &o->objects[k];
        if (!object->closed)
            continue;
        for (size_t t = object->first_index / 3;
             t < (object->first_index + object->index_count) / 3; t++) {
            if (s->facing[t] != SILHOUETTE_FACE || height_over(o, disk, (uint32_t)t) > 0)
                continue;
            const struct gl_edge *edge = nearest_outline(s, o, disk, (uint32_t)t);
            vec3 ends[2];
            double points[2][2] = {{0}};
            if (edge) {
                outline_ends(o, disk, edge, ends);
                if (!silhouette_disk_tangents(disk->radius, ends[0], ends[1], points))
                    edge = NULL;
            }
            if (!edge) {
                vec3 n = v3_loadf(o->planes + 4 * t);
                ends[0] = ends[1] =
                    v3(v3_dot(n, disk->u), v3_dot(n, disk->v), v3_dot(n, disk->normal));
            }
            if (!memory_reserve(s->context, (void **)&s->faces, &s->face_capacity, s->face_count, 1,
                                sizeof(*s->faces)))
                return false;
            struct dbuffer_face *face = &s->faces[s->face_count++];
            face->line = DBUFFER_NONE;
            if (edge && !add_line(s, ends[0], ends[1], &face->line))
                return false;
            for (int i = 0; i < 3; i++)
                v3_storef(face->corners[i], vertex(o, disk, o->indices[3 * t + (size_t)i]));
            v3_storef(face->v1, ends[0]);
            v3_storef(face->v2, ends[1]);
            for (int i = 0; i < 2; i++)
                face->p[i] = (float)points[0][i];
        }
    }
    return true;
}

static bool is_concave(const struct gl_occluders *o, const struct gl_edge *edge)
{
    const float *plane = o->planes + 4 * (size_t)edge->first;
    vec3 a = v3_loadf(o->positions + 3 * (size_t)edge->a);
    uint32_t other = third_corner(o, edge->second, edge->a, edge->b);
    vec3 to = v3_sub(v3_loadf(o->positions + 3 * (size_t)other), a);
    return v3_dot(v3_loadf(plane), to) > FLAT * v3_length(to);
}

pnb_status dbuffer_volumes_build(struct dbuffer_volumes *s, const struct gl_occluders *o,
                                 const struct silhouette_disk *disk)
{
    for (int i = 0; i < 2; i++)
        s->quads[i].count = s->fans[i].count = s->edges[i] = 0;
    s->line_count = s->face_count = s->skipped_edges = s->concave_edges = 0;
    if (!memory_reserve(s->context, (void **)&s->facing, &s->facing_capacity, 0, o->triangle_count,
                        1))
        return status_no_memory(s->context, o->triangle_count);

    /* Classify the faces. */
    for (size_t t = 0; t < o->triangle_count; t++) {
        s->facing[t] = (uint8_t)silhouette_disk_facing(disk, o->planes + 4 * t);
    }
    if (!add_faces(s, o, disk))
        return status_no_memory(s->context, 0);

    /* Each volume in its turn: quads, then fans between them. */
    for (int penumbra = 0; penumbra < 2; penumbra++) {
        uint8_t mark = penumbra ? SILHOUETTE_ALL_FRONTFACING : SILHOUETTE_NONE_FRONTFACING;
        s->link_count = 0;
        for (size_t k = 0; k < o->object_count; k++) {
            const struct gl_occluder *object = &o->objects[k];
            for (size_t i = 0; i < object->edge_count; i++) {
                const struct gl_edge *edge = &o->edges[object->first_edge + i];
                bool plain = object->closed;
                if (object->closed) {
                    plain = (s->facing[edge->first] == mark) != (s->facing[edge->second] == mark);
                    if (!plain && (s->facing[edge->first] != SILHOUETTE_FACE ||
                                   s->facing[edge->second] != SILHOUETTE_FACE))
                        continue;
                    if (is_concave(o, edge)) {
                        s->concave_edges++;
                        if (plain && !add_bridge(s, edge, penumbra, k))
                            return status_no_memory(s->context, 0);
                        continue;
                    }
                }
                if (!add_tangents(s, o, disk, edge, plain, k, penumbra))
                    return status_no_memory(s->context, 0);
            }
        }
        if (!add_fans(s, o, penumbra, disk->radius))
            return status_no_memory(s->context, 0);
    }
    return PNB_OK;
}
