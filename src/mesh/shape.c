/* mesh/shape.c: meshes made by rule; see shape.h for what each is. Vertices along seams are shared,
 * so the shapes are closed by construction and not by rounding. */
#include "mesh/shape.h"

#include <string.h>

void shape_init(pnb_context *context, struct shape *shape)
{
    *shape = (struct shape){.context = context};
}

void shape_finish(struct shape *shape)
{
    memory_free(shape->context, shape->positions);
    memory_free(shape->context, shape->normals);
    memory_free(shape->context, shape->indices);
    shape_init(shape->context, shape);
}

pnb_mesh_desc shape_desc(const struct shape *shape, const char *name)
{
    return (pnb_mesh_desc){name,
                           shape->positions,
                           shape->smooth ? shape->normals : NULL,
                           shape->vertex_count,
                           shape->indices,
                           shape->triangle_count};
}

uint32_t shape_vertex(struct shape *shape, vec3 position, vec3 normal)
{
    if (shape->failed ||
        !memory_reserve(shape->context, (void **)&shape->positions, &shape->vertex_capacity,
                        shape->vertex_count, 1, 3 * sizeof(float)) ||
        !memory_reserve(shape->context, (void **)&shape->normals, &shape->normal_capacity,
                        shape->vertex_count, 1, 3 * sizeof(float))) {
        shape->failed = true;
        return 0;
    }
    v3_storef(shape->positions + 3 * shape->vertex_count, position);
    v3_storef(shape->normals + 3 * shape->vertex_count, v3_normalize(normal));
    shape->smooth = shape->smooth || v3_max_abs(normal) > 0;
    return (uint32_t)shape->vertex_count++;
}

void shape_triangle(struct shape *shape, uint32_t a, uint32_t b, uint32_t c)
{
    if (shape->failed ||
        !memory_reserve(shape->context, (void **)&shape->indices, &shape->index_capacity,
                        shape->triangle_count, 1, 3 * sizeof(uint32_t))) {
        shape->failed = true;
        return;
    }
    uint32_t *index = shape->indices + 3 * shape->triangle_count++;
    index[0] = a;
    index[1] = b;
    index[2] = c;
}

static const vec3 flat = {0, 0, 0};

void shape_hexahedron(struct shape *shape, const vec3 corners[8])
{
    static const int side[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    uint32_t first = (uint32_t)shape->vertex_count;
    for (int i = 0; i < 8; i++)
        shape_vertex(shape, corners[i], flat);
    for (int i = 0; i < 6; i++) {
        uint32_t a = first + (uint32_t)side[i][0], b = first + (uint32_t)side[i][1];
        uint32_t c = first + (uint32_t)side[i][2], d = first + (uint32_t)side[i][3];
        shape_triangle(shape, a, b, c);
        shape_triangle(shape, a, c, d);
    }
}

void shape_box(struct shape *shape, vec3 low, vec3 high)
{
    vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = v3(i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z);
    shape_hexahedron(shape, corners);
}

void shape_beam(struct shape *shape, vec3 center, vec3 u, vec3 v, vec3 w)
{
    vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] =
            v3_mad(v3_mad(v3_mad(center, u, i & 1 ? 1 : -1), v, i & 2 ? 1 : -1), w, i & 4 ? 1 : -1);
    shape_hexahedron(shape, corners);
}

void shape_loft(struct shape *shape, const vec3 *points, size_t rings, size_t count, bool closed)
{
    uint32_t first = (uint32_t)shape->vertex_count, n = (uint32_t)count;
    for (size_t i = 0; i < rings * count; i++)
        shape_vertex(shape, points[i], flat);
    for (size_t k = 0; k < (closed ? rings : rings - 1); k++) {
        uint32_t a = first + (uint32_t)(k * count), b = first + (uint32_t)((k + 1) % rings * count);
        for (uint32_t i = 0; i < n; i++) {
            uint32_t j = (i + 1) % n;
            shape_triangle(shape, a + i, a + j, b + j);
            shape_triangle(shape, a + i, b + j, b + i);
        }
    }
    uint32_t last = first + (uint32_t)((rings - 1) * count);
    for (uint32_t i = 2; i < n && !closed; i++) {
        shape_triangle(shape, first, first + i, first + i - 1);
        shape_triangle(shape, last, last + i - 1, last + i);
    }
}

void shape_rod(struct shape *shape, vec3 from, vec3 to, double radius_from, double radius_to,
               size_t count)
{
    vec3 axis = v3_normalize(v3_sub(to, from)), u, v;
    double length = v3_length(v3_sub(to, from)), slope = (radius_from - radius_to) / length;
    v3_frame(axis, &u, &v);
    /* Two rings for the smooth side, two more at the same places for the flat caps. */
    uint32_t ring[4], n = (uint32_t)count;
    for (int k = 0; k < 4; k++) {
        bool top = k & 1, cap = k & 2;
        double radius = top ? radius_to : radius_from;
        ring[k] = (uint32_t)shape->vertex_count;
        for (uint32_t i = 0; i < n && !(cap && radius == 0); i++) {
            double angle = 2 * M_PI * i / n;
            vec3 out = v3_mad(v3_scale(u, cos(angle)), v, sin(angle));
            shape_vertex(shape, v3_mad(top ? to : from, out, radius),
                         cap ? v3_scale(axis, top ? 1 : -1) : v3_mad(out, axis, slope));
        }
    }
    for (uint32_t i = 0; i < n; i++) {
        uint32_t j = (i + 1) % n;
        if (radius_from > 0)
            shape_triangle(shape, ring[0] + i, ring[0] + j, ring[1] + j);
        if (radius_to > 0)
            shape_triangle(shape, ring[0] + i, ring[1] + j, ring[1] + i);
    }
    for (uint32_t i = 2; i < n; i++) {
        if (radius_from > 0)
            shape_triangle(shape, ring[2], ring[2] + i, ring[2] + i - 1);
        if (radius_to > 0)
            shape_triangle(shape, ring[3], ring[3] + i - 1, ring[3] + i);
    }
}

/* Fills the band between two rings that run counter-clockwise seen from above: goes round both at
 * once and always joins the vertex that comes next. */
static void join_rings(struct shape *shape, uint32_t below, uint32_t below_count, uint32_t above,
                       uint32_t above_count)
{
    uint32_t i = 0, j = 0;
    while (i < below_count || j < above_count) {
        uint32_t a = below + i % below_count, b = above + j % above_count;
        /* (i + 1) / below_count <= (j + 1) / above_count */
        bool advance_below =
            i < below_count && (j == above_count ||
                                (uint64_t)(i + 1) * above_count <= (uint64_t)(j + 1) * below_count);
        if (advance_below) {
            i++;
            shape_triangle(shape, a, below + i % below_count, b);
        } else {
            j++;
            shape_triangle(shape, a, above + j % above_count, b);
        }
    }
}

void shape_sphere_762(struct shape *shape, vec3 center, double radius)
{
    /* V vertices on a sphere make 2 V - 4 triangles. 17 rings, 10 degrees apart, of
     * round(33.33 sin) vertices hold 381; with the poles 383. */
    static const uint32_t count[17] = {6,  11, 17, 21, 26, 29, 31, 33, 33,
                                       33, 31, 29, 26, 21, 17, 11, 6};
    uint32_t top = shape_vertex(shape, v3_mad(center, v3(0, 1, 0), radius), v3(0, 1, 0));
    uint32_t ring[17];
    for (int k = 0; k < 17; k++) {
        double polar = M_PI * (k + 1) / 18;
        ring[k] = (uint32_t)shape->vertex_count;
        for (uint32_t i = 0; i < count[k]; i++) {
            double angle = 2 * M_PI * i / count[k];
            vec3 n = v3(sin(polar) * cos(angle), cos(polar), -sin(polar) * sin(angle));
            shape_vertex(shape, v3_mad(center, n, radius), n);
        }
    }
    uint32_t bottom = shape_vertex(shape, v3_mad(center, v3(0, -1, 0), radius), v3(0, -1, 0));
    for (uint32_t i = 0; i < 6; i++) {
        shape_triangle(shape, top, ring[0] + i, ring[0] + (i + 1) % 6);
        shape_triangle(shape, bottom, ring[16] + (i + 1) % 6, ring[16] + i);
    }
    for (int k = 0; k < 16; k++)
        join_rings(shape, ring[k + 1], count[k + 1], ring[k], count[k]);
}

void shape_tube(struct shape *shape, const struct shape_tube *tube)
{
    size_t along = tube->along, around = tube->around;
    double steps = (double)(tube->open ? along - 1 : along);
    const double delta = 1e-5;
    uint32_t first = (uint32_t)shape->vertex_count;
    vec3 *frame_u = memory_alloc(shape->context, along + 1, sizeof(vec3));
    vec3 *tangent = memory_alloc(shape->context, along + 1, sizeof(vec3));
    if (!frame_u || !tangent) {
        memory_free(shape->context, frame_u);
        memory_free(shape->context, tangent);
        shape->failed = true;
        return;
    }

    /* Carry a frame along the curve without turning it about the tangent. */
    for (size_t i = 0; i <= along; i++) {
        double t = (double)i / steps;
        tangent[i] = v3_normalize(
            v3_sub(tube->curve(tube->user, t + delta), tube->curve(tube->user, t - delta)));
        vec3 u, v;
        if (i == 0)
            v3_frame(tangent[0], &u, &v);
        else
            u = v3_mad(frame_u[i - 1], tangent[i], -v3_dot(frame_u[i - 1], tangent[i]));
        frame_u[i] = v3_normalize(u);
    }
    /* A closed curve brings it back turned by some angle: spread that over the whole length. */
    double twist = 0;
    if (!tube->open) {
        vec3 v = v3_cross(tangent[0], frame_u[0]);
        twist = atan2(v3_dot(frame_u[along], v), v3_dot(frame_u[along], frame_u[0]));
    }

    for (size_t i = 0; i < along; i++) {
        double t = (double)i / steps;
        vec3 center = tube->curve(tube->user, t), u = frame_u[i], v = v3_cross(tangent[i], u);
        for (size_t j = 0; j < around; j++) {
            double angle = 2 * M_PI * (double)j / (double)around, turned = angle - twist * t;
            double radius = tube->section(tube->user, t, angle);
            vec3 out = v3_mad(v3_scale(u, cos(turned)), v, sin(turned));
            shape_vertex(shape, v3_mad(center, out, radius), out);
        }
    }
    size_t bands = tube->open ? along - 1 : along;
    for (size_t i = 0; i < bands; i++)
        for (size_t j = 0; j < around; j++) {
            size_t i1 = (i + 1) % along, j1 = (j + 1) % around;
            uint32_t a = first + (uint32_t)(i * around + j),
                     b = first + (uint32_t)(i * around + j1);
            uint32_t c = first + (uint32_t)(i1 * around + j1);
            uint32_t d = first + (uint32_t)(i1 * around + j);
            shape_triangle(shape, a, b, c);
            shape_triangle(shape, a, c, d);
        }
    for (size_t j = 2; j < around && tube->open; j++) {
        uint32_t last = first + (uint32_t)((along - 1) * around);
        shape_triangle(shape, first, first + (uint32_t)j, first + (uint32_t)j - 1);
        shape_triangle(shape, last, last + (uint32_t)j - 1, last + (uint32_t)j);
    }

    /* Normals from the surface itself: the section need not be round. */
    size_t vertices = shape->failed ? 0 : along;
    for (size_t i = 0; i < vertices; i++)
        for (size_t j = 0; j < around; j++) {
            size_t before = i > 0 ? i - 1 : tube->open ? 0 : along - 1;
            size_t after = i + 1 < along ? i + 1 : tube->open ? i : 0;
            const float *p = shape->positions + 3 * (size_t)first;
            vec3 di = v3_sub(v3_loadf(p + 3 * (after * around + j)),
                             v3_loadf(p + 3 * (before * around + j)));
            vec3 dj = v3_sub(v3_loadf(p + 3 * (i * around + (j + 1) % around)),
                             v3_loadf(p + 3 * (i * around + (j + around - 1) % around)));
            v3_storef(shape->normals + 3 * (first + i * around + j),
                      v3_normalize(v3_cross(dj, di)));
        }
    memory_free(shape->context, frame_u);
    memory_free(shape->context, tangent);
}

static vec3 circle(const void *user, double t)
{
    double major = ((const double *)user)[0];
    return v3(major * cos(2 * M_PI * t), 0, -major * sin(2 * M_PI * t));
}

static double round_section(const void *user, double t, double angle)
{
    return ((const double *)user)[1];
}

void shape_torus(struct shape *shape, double major, double minor, size_t along, size_t around)
{
    double radii[2] = {major, minor};
    shape_tube(shape, &(struct shape_tube){circle, round_section, radii, along, around, false});
}

void shape_quad(struct shape *shape, vec3 center, vec3 half_u, vec3 half_v)
{
    uint32_t first = (uint32_t)shape->vertex_count;
    static const int side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; i++)
        shape_vertex(shape, v3_mad(v3_mad(center, half_u, side[i][0]), half_v, side[i][1]), flat);
    shape_triangle(shape, first, first + 1, first + 2);
    shape_triangle(shape, first, first + 2, first + 3);
}

void shape_transform(struct shape *shape, size_t first_vertex, const double m[12])
{
    for (size_t i = first_vertex; i < shape->vertex_count; i++) {
        v3_storef(shape->positions + 3 * i, m34_point(m, v3_loadf(shape->positions + 3 * i)));
        v3_storef(shape->normals + 3 * i,
                  v3_normalize(m34_normal(m, v3_loadf(shape->normals + 3 * i))));
    }
}

double shape_volume(const float *positions, const uint32_t *indices, size_t triangle_count)
{
    double sum = 0;
    for (size_t i = 0; i < triangle_count; i++) {
        vec3 a = v3_loadf(positions + 3 * (size_t)indices[3 * i]);
        vec3 b = v3_loadf(positions + 3 * (size_t)indices[3 * i + 1]);
        vec3 c = v3_loadf(positions + 3 * (size_t)indices[3 * i + 2]);
        sum += v3_dot(a, v3_cross(b, c));
    }
    return sum / 6;
}
