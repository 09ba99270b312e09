/* silhouette/point.c: silhouettes seen from points, projected onto a plane (Boehl and Stuerzlinger,
 * section 3.1).
 *
 * A triangle in front of the light sample casts its shadow counter-clockwise, one behind it
 * clockwise. Of closed meshes the front ones alone are taken: the sum of their boundaries is the
 * silhouette, the edges whose two triangles differ. So that the code below is one for all meshes,
 * take "the sum of the boundaries of triangles, each with a sign" as the definition; the winding
 * number around a point of the plane is then the number of layers between it and the light:
 *
 *   closed mesh, all of it between plane and sample    front +1, back 0
 *   open or non-manifold mesh, or one that is clipped  front +1, back -1 (both block)
 *
 * In the second case edges are cut at the plane and a little below the sample, and each triangle
 * that is cut adds the line of its cut, so every sum of boundaries closes, whatever the mesh.
 *
 * All samples in one pass over the faces: a bit per sample and face. Most faces are in front of all
 * samples or of none, which the distance of the samples' centre tells; only the others are tested
 * one by one. Then one pass over the edges: the bits in which their two faces differ. O(triangles +
 * silhouette edges of all samples). A face that is seen exactly edge-on counts as behind; either
 * way the boundaries close.
 */
#include "silhouette/point.h"

#include <string.h>

#include "geom/tolerance.h"

/* Vertices nearer to the plane than this share of the mesh's size lie on it. */
#define ON_PLANE 1e-7

vec3 silhouette_to_plane(const struct silhouette_plane *plane, vec3 p)
{
    vec3 d = v3_sub(p, plane->origin);
    return v3(v3_dot(d, plane->u), v3_dot(d, plane->v), v3_dot(d, plane->n));
}

vec3 silhouette_from_plane(const struct silhouette_plane *plane, vec3 p)
{
    return v3_mad(v3_mad(v3_mad(plane->origin, plane->u, p.x), plane->v, p.y), plane->n, p.z);
}

void silhouette_occluder_finish(pnb_context *context, struct silhouette_occluder *o)
{
    memory_free(context, o->x);
    memory_free(context, o->y);
    memory_free(context, o->h);
    memory_free(context, o->face);
    memory_free(context, o->pairs);
    memory_free(context, o->odd);
    memory_free(context, o->front);
    memory_free(context, o->slot);
    memory_free(context, o->stamps);
    *o = (struct silhouette_occluder){0};
}

void silhouette_outline_finish(pnb_context *context, struct silhouette_outline *outline)
{
    memory_free(context, outline->points);
    memory_free(context, outline->segments);
    *outline = (struct silhouette_outline){0};
}

static vec3 vertex(const struct silhouette_occluder *o, uint32_t i)
{
    return v3(o->x[i], o->y[i], o->h[i]);
}

pnb_status silhouette_occluder_init(pnb_context *context, struct mesh *mesh,
                                    const double world_from_mesh[12],
                                    const struct silhouette_plane *plane,
                                    struct silhouette_occluder *o)
{
    *o = (struct silhouette_occluder){.mesh = mesh};
    pnb_status status = mesh_get_edges(context, mesh, &o->edges);
    if (status)
        return status;
    const struct mesh_edges *edges = o->edges;
    size_t n = o->vertex_count = edges->welded_count, triangles = mesh->triangle_count;
    o->x = memory_alloc(context, n, sizeof(*o->x));
    o->y = memory_alloc(context, n, sizeof(*o->y));
    o->h = memory_alloc(context, n, sizeof(*o->h));
    o->face = memory_alloc(context, 4 * triangles, sizeof(*o->face));
    o->pairs = memory_alloc(context, edges->edge_count, sizeof(*o->pairs));
    o->odd = memory_alloc(context, edges->edge_count, sizeof(*o->odd));
    o->front = memory_alloc(context, triangles, sizeof(*o->front));
    o->slot = memory_alloc(context, n, sizeof(*o->slot));
    o->stamps = memory_calloc(context, n, sizeof(*o->stamps));
    if (!o->x || !o->y || !o->h || !o->face || !o->pairs || !o->odd || !o->front || !o->slot ||
        !o->stamps) {
        silhouette_occluder_finish(context, o);
        return status_no_memory(context, n * 32 + triangles * 40);
    }
    vec3 lo = v3(INFINITY, INFINITY, INFINITY), hi = v3_scale(lo, -1);
    for (size_t i = 0; i < n; i++) {
        vec3 p = v3_loadf(mesh->positions + 3 * (size_t)edges->welded_vertex[i]);
        p = silhouette_to_plane(plane, m34_point(world_from_mesh, p));
        o->x[i] = p.x;
        o->y[i] = p.y;
        o->h[i] = p.z;
        lo = v3_min(lo, p);
        hi = v3_max(hi, p);
    }
    /* What stands on the plane shall stand on it: heights are floats' and a placement's rounding.
     */
    double level = ON_PLANE * v3_length(v3_sub(hi, lo));
    for (size_t i = 0; i < n; i++)
        if (fabs(o->h[i]) < level)
            o->h[i] = 0;
    if (fabs(lo.z) < level)
        lo.z = 0;
    o->lowest = lo.z;
    o->highest = hi.z;
    vec3 middle = n > 0 ? v3_scale(v3_add(lo, hi), 0.5) : v3(0, 0, 0);
    v3_storef(o->middle, middle);
    middle = v3_loadf(o->middle);
    for (size_t i = 0; i < triangles; i++) {
        const uint32_t *t = mesh->indices + 3 * i;
        vec3 a = vertex(o, edges->welded[t[0]]), b = vertex(o, edges->welded[t[1]]),
             c = vertex(o, edges->welded[t[2]]);
        vec3 normal = v3_normalize(v3_cross(v3_sub(b, a), v3_sub(c, a)));
        v3_storef(o->face + 4 * i, normal);
        o->face[4 * i + 3] = (float)v3_dot(normal, v3_sub(a, middle));
    }
    for (size_t i = 0; i < edges->edge_count; i++) {
        const struct mesh_edge *e = &edges->edges[i];
        const uint32_t *use = edges->uses + e->first_use;
        if (e->use_count == 2 && ((use[0] ^ use[1]) & 1)) {
            bool first_with = !(use[0] & 1);
            o->pairs[o->pair_count++] = (struct silhouette_pair){{e->vertex[0], e->vertex[1]},
                                                                 use[first_with ? 0 : 1] >> 1,
                                                                 use[first_with ? 1 : 0] >> 1};
        } else {
            o->odd[o->odd_count++] = (uint32_t)i;
        }
    }
    return PNB_OK;
}

/* A bit per sample: is the face in front of it? */
static void classify(struct silhouette_occluder *o, const vec3 *samples, size_t count)
{
    float at[SILHOUETTE_SAMPLES_MAX][3];
    vec3 lo = samples[0], hi = samples[0], middle = v3_loadf(o->middle);
    for (size_t k = 0; k < count; k++) {
        v3_storef(at[k], v3_sub(samples[k], middle));
        lo = v3_min(lo, samples[k]);
        hi = v3_max(hi, samples[k]);
    }
    vec3 center = v3_sub(v3_scale(v3_add(lo, hi), 0.5), middle);
    /* Half the box of the samples, with room for rounding. */
    float c[3], r[3];
    v3_storef(c, center);
    v3_storef(r, v3_scale(v3_sub(hi, lo), 0.5));
    float slack = 1e-5f * (float)(v3_max_abs(center) + v3_length(v3_sub(hi, lo)));
    uint64_t all = count == 64 ? ~(uint64_t)0 : ((uint64_t)1 << count) - 1;
    for (size_t i = 0; i < o->mesh->triangle_count; i++) {
        const float *f = o->face + 4 * i;
        float s = f[0] * c[0] + f[1] * c[1] + f[2] * c[2] - f[3];
        float reach = fabsf(f[0]) * r[0] + fabsf(f[1]) * r[1] + fabsf(f[2]) * r[2] + slack;
        if (fabsf(s) > reach) {
            o->front[i] = s > 0 ? all : 0;
            continue;
        }
        uint64_t bits = 0;
        for (size_t k = 0; k < count; k++)
            bits |= (uint64_t)(f[0] * at[k][0] + f[1] * at[k][1] + f[2] * at[k][2] > f[3]) << k;
        o->front[i] = bits;
    }
}

static bool reserve(pnb_context *context, struct silhouette_outline *out, size_t points,
                    size_t segments)
{
    return memory_reserve(context, (void **)&out->points, &out->point_capacity, out->point_count,
                          points, 2 * sizeof(*out->points)) &&
           memory_reserve(context, (void **)&out->segments, &out->segment_capacity,
                          out->segment_count, segments, sizeof(*out->segments));
}

/* Where the line from the sample l through p meets the plane. */
static void project(vec3 p, vec3 l, double *out)
{
    if (isinf(l.z) || p.z == 0) { /* on the plane: the same for every sample, to the last bit */
        out[0] = p.x;
        out[1] = p.y;
        return;
    }
    double s = 1 / (l.z - p.z);
    out[0] = (p.x * l.z - l.x * p.z) * s;
    out[1] = (p.y * l.z - l.y * p.z) * s;
}

/* One sample, nothing to clip, closed: edges whose faces differ in bit k. */
static bool emit_pairs(pnb_context *context, struct silhouette_occluder *o, vec3 l,
                       const uint32_t *list, size_t count, struct silhouette_outline *out)
{
    if (!reserve(context, out, 2 * count, count))
        return false;
    if (++o->stamp == 0) {
        memset(o->stamps, 0, o->vertex_count * sizeof(*o->stamps));
        o->stamp = 1;
    }
    for (size_t i = 0; i < count; i++) {
        const struct silhouette_pair *pair = &o->pairs[list[i] >> 1];
        uint32_t ends[2];
        for (int k = 0; k < 2; k++) {
            uint32_t v = pair->vertex[k];
            if (o->stamps[v] != o->stamp) {
                o->stamps[v] = o->stamp;
                o->slot[v] = (uint32_t)out->point_count;
                project(vertex(o, v), l, out->points + 2 * out->point_count++);
            }
            ends[k] = o->slot[v];
        }
        /* The face in front runs counter-clockwise; its shadow is to lie on the right. */
        bool with_front = list[i] & 1;
        out->segments[out->segment_count++] =
            (struct silhouette_segment){ends[with_front ? 1 : 0], ends[with_front ? 0 : 1], 1};
    }
    return true;
}

static bool add_segment(pnb_context *context, struct silhouette_outline *out, vec3 l, vec3 a,
                        vec3 b, int32_t weight)
{
    if (!reserve(context, out, 2, 1))
        return false;
    size_t n = out->point_count;
    project(a, l, out->points + 2 * n);
    project(b, l, out->points + 2 * n + 2);
    out->point_count += 2;
    out->segments[out->segment_count++] =
        (struct silhouette_segment){(uint32_t)n, (uint32_t)n + 1, weight};
    return true;
}

/* The point of the edge between welded vertices i and j at a height between theirs: the same
 * whichever way round they are named. */
static vec3 at_height(const struct silhouette_occluder *o, uint32_t i, uint32_t j, double height)
{
    if (i > j) {
        uint32_t t = i;
        i = j;
        j = t;
    }
    vec3 a = vertex(o, i), b = vertex(o, j);
    if (a.z == height)
        return a;
    if (b.z == height)
        return b;
    vec3 p = v3_mad(a, v3_sub(b, a), (height - a.z) / (b.z - a.z));
    p.z = height;
    return p;
}

/* The part of an edge between the heights 0 and top. */
static bool add_clipped(pnb_context *context, const struct silhouette_occluder *o,
                        struct silhouette_outline *out, vec3 l, double top, uint32_t i, uint32_t j,
                        int32_t weight)
{
    vec3 a = vertex(o, i), b = vertex(o, j);
    if ((a.z < 0 && b.z < 0) || (a.z > top && b.z > top))
        return true;
    if (a.z < 0 || b.z < 0) {
        vec3 p = at_height(o, i, j, 0);
        if (a.z < 0)
            a = p;
        else
            b = p;
    }
    if (a.z > top || b.z > top) {
        vec3 p = at_height(o, i, j, top);
        if (a.z > top)
            a = p;
        else
            b = p;
    }
    return add_segment(context, out, l, a, b, weight);
}

/* The line along which a triangle is cut at a height; what is kept lies above (way = 1) or below.
 */
static bool add_cut(pnb_context *context, const struct silhouette_occluder *o,
                    struct silhouette_outline *out, vec3 l, const uint32_t *v, double height,
                    int way, int32_t weight)
{
    vec3 leaves = {0}, enters = {0};
    int found = 0;
    for (int k = 0; k < 3; k++) {
        uint32_t i = v[k], j = v[(k + 1) % 3];
        bool in_i = way > 0 ? o->h[i] >= height : o->h[i] <= height;
        bool in_j = way > 0 ? o->h[j] >= height : o->h[j] <= height;
        if (in_i == in_j)
            continue;
        found++;
        if (in_i)
            leaves = at_height(o, i, j, height);
        else
            enters = at_height(o, i, j, height);
    }
    return found < 2 || add_segment(context, out, l, leaves, enters, weight);
}

/* One sample, any mesh, any position: the sum of the boundaries of all triangles, front ones with
 * +1, others with -1, between the plane and top. */
static bool emit_general(pnb_context *context, const struct silhouette_occluder *o, size_t k,
                         vec3 l, struct silhouette_outline *out)
{
    double top = l.z * (1 - TOLERANCE_LIGHT_GAP);
    bool clipped = o->lowest < 0 || o->highest > top;
#define SIGN(t) ((o->front[t] >> k & 1) ? 1 : -1)
    /* The sum along an edge counts counter-clockwise, segments have the shadow on the right. */
    for (size_t i = 0; i < o->pair_count; i++) {
        const struct silhouette_pair *p = &o->pairs[i];
        int32_t sum = SIGN(p->with) - SIGN(p->against);
        if (sum != 0 && !add_clipped(context, o, out, l, top, p->vertex[0], p->vertex[1], -sum))
            return false;
    }
    for (size_t i = 0; i < o->odd_count; i++) {
        const struct mesh_edge *e = &o->edges->edges[o->odd[i]];
        int32_t sum = 0;
        for (uint32_t u = 0; u < e->use_count; u++) {
            uint32_t use = o->edges->uses[e->first_use + u];
            sum += (use & 1) ? -SIGN(use >> 1) : SIGN(use >> 1);
        }
        if (sum != 0 && !add_clipped(context, o, out, l, top, e->vertex[0], e->vertex[1], -sum))
            return false;
    }
    if (!clipped)
        return true;
    for (size_t i = 0; i < o->mesh->triangle_count; i++) {
        const uint32_t *t = o->mesh->indices + 3 * i;
        uint32_t v[3] = {o->edges->welded[t[0]], o->edges->welded[t[1]], o->edges->welded[t[2]]};
        if (!add_cut(context, o, out, l, v, 0, 1, -SIGN(i)) ||
            !add_cut(context, o, out, l, v, top, -1, -SIGN(i)))
            return false;
    }
#undef SIGN
    return true;
}

pnb_status silhouette_from_points(pnb_context *context, struct silhouette_occluder *o,
                                  const vec3 *samples, size_t count,
                                  struct silhouette_outline *outlines)
{
    if (count == 0 || o->mesh->triangle_count == 0 || o->highest < 0)
        return PNB_OK;
    classify(o, samples, count);
    uint64_t plain = 0, general = 0;
    for (size_t k = 0; k < count; k++) {
        if (samples[k].z <= 0)
            continue;
        bool simple = o->odd_count == 0 && o->lowest >= 0 &&
                      o->highest <= samples[k].z * (1 - TOLERANCE_LIGHT_GAP);
        *(simple ? &plain : &general) |= (uint64_t)1 << k;
    }
    bool ok = true;
    if (plain) {
        /* Lists of edges per sample: counted, then filled. */
        size_t starts[SILHOUETTE_SAMPLES_MAX + 1] = {0}, at[SILHOUETTE_SAMPLES_MAX];
        size_t total = 0, capacity = 0;
        uint64_t *differ = NULL;
        for (size_t i = 0; i < o->pair_count; i++) {
            const struct silhouette_pair *p = &o->pairs[i];
            uint64_t bits = (o->front[p->with] ^ o->front[p->against]) & plain;
            if (!bits)
                continue;
            if (!memory_reserve(context, (void **)&differ, &capacity, 2 * total, 2,
                                sizeof(*differ))) {
                ok = false;
                break;
            }
            differ[2 * total] = i;
            differ[2 * total + 1] = bits;
            total++;
            for (; bits; bits &= bits - 1)
                starts[__builtin_ctzll(bits) + 1]++;
        }
        for (size_t k = 0; k < SILHOUETTE_SAMPLES_MAX; k++) {
            at[k] = starts[k];
            starts[k + 1] += starts[k];
        }
        uint32_t *list = memory_alloc(context, starts[SILHOUETTE_SAMPLES_MAX], sizeof(*list));
        ok = ok && list;
        for (size_t i = 0; i < total && ok; i++) {
            uint64_t front = o->front[o->pairs[differ[2 * i]].with];
            for (uint64_t bits = differ[2 * i + 1]; bits; bits &= bits - 1) {
                int k = __builtin_ctzll(bits);
                list[at[k]++] = (uint32_t)(differ[2 * i] << 1 | (front >> k & 1));
            }
        }
        for (size_t k = 0; k < count && ok; k++)
            if (plain >> k & 1)
                ok = emit_pairs(context, o, samples[k], list + starts[k], starts[k + 1] - starts[k],
                                &outlines[k]);
        memory_free(context, differ);
        memory_free(context, list);
    }
    for (size_t k = 0; k < count && ok; k++)
        if (general >> k & 1)
            ok = emit_general(context, o, k, samples[k], &outlines[k]);
    return ok ? PNB_OK : status_no_memory(context, 0);
}

pnb_status silhouette_cross_section(pnb_context *context, const struct silhouette_occluder *o,
                                    double height, struct silhouette_outline *out)
{
    if (o->odd_count > 0 || !(o->lowest < height) || !(o->highest > height))
        return PNB_OK;
    /* From infinitely far above: the projection is x, y. */
    vec3 above = v3(0, 0, INFINITY);
    bool ok = true;
    for (size_t i = 0; i < o->mesh->triangle_count && ok; i++) {
        const uint32_t *t = o->mesh->indices + 3 * i;
        uint32_t v[3] = {o->edges->welded[t[0]], o->edges->welded[t[1]], o->edges->welded[t[2]]};
        ok = add_cut(context, o, out, above, v, height, 1, 1);
    }
    return ok ? PNB_OK : status_no_memory(context, 0);
}
