/* exact_twin.c: random scenes that are hard on purpose, and visibility by brute force. */
#include "exact_twin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "geom/tolerance.h"
#include "scene/scene.h"

double twin_uniform(struct twin_random *r)
{
    r->state = r->state * 6364136223846793005ull + 1442695040888963407ull;
    uint64_t x = r->state;
    x ^= x >> 33;
    x *= 0xff51afd7ed558ccdull;
    x ^= x >> 29;
    return (double)(x >> 11) * 0x1p-53;
}

int twin_below(struct twin_random *r, int count)
{
    return (int)(twin_uniform(r) * count);
}

static double within(struct twin_random *r, double low, double high)
{
    return low + (high - low) * twin_uniform(r);
}

static vec3 direction(struct twin_random *r)
{
    for (;;) {
        vec3 d = v3(within(r, -1, 1), within(r, -1, 1), within(r, -1, 1));
        double n = v3_length(d);
        if (n > 0.05 && n < 1)
            return v3_scale(d, 1 / n);
    }
}

/* ---- meshes ---- */

#define VERTICES_MAX  4096
#define TRIANGLES_MAX 4096

struct shape {
    float positions[3 * VERTICES_MAX];
    uint32_t indices[3 * TRIANGLES_MAX];
    size_t vertices, triangles;
};

static uint32_t add_vertex(struct shape *s, vec3 p)
{
    v3_storef(s->positions + 3 * s->vertices, p);
    return (uint32_t)s->vertices++;
}

static void add_triangle(struct shape *s, uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t *t = s->indices + 3 * s->triangles++;
    t[0] = a, t[1] = b, t[2] = c;
}

static void make_soup(struct twin_random *r, struct shape *s, int count, double size)
{
    for (int i = 0; i < count; i++) {
        vec3 c = v3_scale(direction(r), twin_uniform(r));
        uint32_t v[3];
        for (int k = 0; k < 3; k++)
            v[k] = add_vertex(s, v3_mad(c, direction(r), size * twin_uniform(r)));
        add_triangle(s, v[0], v[1], v[2]);
    }
}

static void make_slivers(struct twin_random *r, struct shape *s, int count)
{
    for (int i = 0; i < count; i++) {
        vec3 a = v3_scale(direction(r), twin_uniform(r)), d = direction(r);
        double thin = pow(10, -within(r, 1, 9));
        uint32_t v0 = add_vertex(s, a), v1 = add_vertex(s, v3_mad(a, d, within(r, 0.2, 2)));
        uint32_t v2 = add_vertex(s, v3_mad(v3_mad(a, d, within(r, 0, 1)), direction(r), thin));
        add_triangle(s, v0, v1, v2);
        if (i % 3 == 0)
            add_triangle(s, v0, v2, v0);
    }
}

static void make_duplicates(struct twin_random *r, struct shape *s, int count)
{
    make_soup(r, s, count, 0.7);
    size_t n = s->triangles;
    for (size_t t = 0; t < n; t++) {
        uint32_t *v = s->indices + 3 * t;
        for (int k = twin_below(r, 4); k > 0; k--)
            if (twin_below(r, 2))
                add_triangle(s, v[0], v[1], v[2]);
            else
                add_triangle(s, v[1], v[0], v[2]);
    }
}

static void make_stack(struct twin_random *r, struct shape *s, int count)
{
    vec3 n = direction(r), u, v;
    v3_frame(n, &u, &v);
    for (int i = 0; i < count; i++) {
        vec3 c = v3_scale(n, 1e-7 * i * twin_below(r, 3));
        c = v3_mad(v3_mad(c, u, within(r, -0.5, 0.5)), v, within(r, -0.5, 0.5));
        uint32_t q[4];
        for (int k = 0; k < 4; k++)
            q[k] = add_vertex(
                s, v3_mad(v3_mad(c, u, k == 1 || k == 2 ? 0.4 : -0.4), v, k >= 2 ? 0.4 : -0.4));
        add_triangle(s, q[0], q[1], q[2]);
        add_triangle(s, q[0], q[2], q[3]);
    }
}

static void make_sphere(struct twin_random *r, struct shape *s, int n, bool open)
{
    vec3 center = v3_scale(direction(r), 0.5);
    double radius = within(r, 0.2, 0.8);
    uint32_t first = (uint32_t)s->vertices;
    for (int j = 0; j <= n; j++)
        for (int i = 0; i < 2 * n; i++) {
            double theta = M_PI * j / n, phi = M_PI * i / n;
            add_vertex(s,
                       v3_mad(center, v3(sin(theta) * cos(phi), cos(theta), sin(theta) * sin(phi)),
                              radius));
        }
    for (int j = 0; j < n; j++)
        for (int i = 0; i < 2 * n; i++) {
            uint32_t a = first + (uint32_t)(j * 2 * n + i), d = a + (uint32_t)(2 * n);
            uint32_t b = first + (uint32_t)(j * 2 * n + (i + 1) % (2 * n)),
                     e = b + (uint32_t)(2 * n);
            if (open && twin_below(r, 4) == 0)
                continue;
            bool flip = open && twin_below(r, 5) == 0;
            if (j > 0)
                add_triangle(s, a, flip ? d : b, flip ? b : d);
            if (j < n - 1)
                add_triangle(s, b, flip ? d : e, flip ? e : d);
        }
}

static void make_box(struct twin_random *r, struct shape *s)
{
    static const int faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    vec3 half = v3(within(r, 0.05, 1), within(r, 0.05, 1), within(r, 0.05, 1));
    vec3 c = v3_scale(direction(r), 0.5 * twin_below(r, 2));
    uint32_t first = (uint32_t)s->vertices;
    for (int i = 0; i < 8; i++)
        add_vertex(s, v3_add(c, v3(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y,
                                   i & 4 ? half.z : -half.z)));
    for (int f = 0; f < 6; f++) {
        const int *q = faces[f];
        add_triangle(s, first + (uint32_t)q[0], first + (uint32_t)q[1], first + (uint32_t)q[2]);
        add_triangle(s, first + (uint32_t)q[0], first + (uint32_t)q[2], first + (uint32_t)q[3]);
    }
}

/* Three and more triangles on an edge. */
static void make_fan(struct twin_random *r, struct shape *s, int count)
{
    vec3 d = direction(r);
    uint32_t a = add_vertex(s, v3_scale(d, -0.8)), b = add_vertex(s, v3_scale(d, 0.8));
    for (int i = 0; i < count; i++) {
        uint32_t c = add_vertex(s, direction(r));
        if (twin_below(r, 2))
            add_triangle(s, a, b, c);
        else
            add_triangle(s, b, a, c);
    }
}

static const char *const kinds[] = {"soup",   "big soup",    "slivers", "duplicates", "stack",
                                    "sphere", "open sphere", "box",     "fan",        "boxes"};

static int make_shape(struct twin_random *r, struct shape *s)
{
    int kind = twin_below(r, 10);
    s->vertices = s->triangles = 0;
    switch (kind) {
    case 0: make_soup(r, s, 1 + twin_below(r, 200), 0.3); break;
    case 1: make_soup(r, s, 1 + twin_below(r, 20), 2); break;
    case 2: make_slivers(r, s, 1 + twin_below(r, 60)); break;
    case 3: make_duplicates(r, s, 1 + twin_below(r, 60)); break;
    case 4: make_stack(r, s, 1 + twin_below(r, 30)); break;
    case 5: make_sphere(r, s, 3 + twin_below(r, 14), false); break;
    case 6: make_sphere(r, s, 3 + twin_below(r, 14), true); break;
    case 7: make_box(r, s); break;
    case 8: make_fan(r, s, 1 + twin_below(r, 20)); break;
    default:
        for (int i = twin_below(r, 20); i >= 0; i--)
            make_box(r, s);
    }
    return kind;
}

/* ---- lights and receivers ---- */

static void make_light(struct twin_random *r, struct twin_case *c, double scale, vec3 at)
{
    memset(&c->light, 0, sizeof(c->light));
    c->light.color[0] = c->light.color[1] = c->light.color[2] = 1;
    double size = scale * pow(10, within(r, -1.5, 0.3));
    vec3 u = direction(r), v, n;
    v3_frame(u, &v, &n);
    if (twin_below(r, 3) == 0)
        v = v3_normalize(v3_mad(v, u, within(r, -1, 1)));
    double aspect = pow(10, within(r, -1, 0));
    switch (twin_below(r, 6)) {
    case 0:
    default:
        c->light.type = PNB_LIGHT_RECTANGLE;
        v3_store(c->light.shape.rectangle.center, at);
        v3_store(c->light.shape.rectangle.half_u, v3_scale(u, size));
        v3_store(c->light.shape.rectangle.half_v, v3_scale(v, size * aspect));
        break;
    case 1:
        c->light.type = PNB_LIGHT_DISK;
        v3_store(c->light.shape.disk.center, at);
        v3_store(c->light.shape.disk.normal, n);
        c->light.shape.disk.radius = size;
        break;
    case 2: {
        /* A star of 3 to 9 corners: simple, mostly not convex. */
        v3_frame(n, &u, &v);
        int corners = 3 + twin_below(r, 7);
        for (int i = 0; i < corners; i++) {
            double phi = 2 * M_PI * i / corners, radius = size * within(r, 0.4, 1);
            v3_store(c->polygon + 3 * i,
                     v3_mad(v3_mad(at, u, radius * cos(phi)), v, radius * sin(phi)));
        }
        c->light.type = PNB_LIGHT_POLYGON;
        c->light.shape.polygon.vertices = c->polygon;
        c->light.shape.polygon.vertex_count = (size_t)corners;
        break;
    }
    case 3:
        c->light.type = PNB_LIGHT_LINE;
        v3_store(c->light.shape.line.from, v3_mad(at, u, size));
        v3_store(c->light.shape.line.to, v3_mad(at, u, -size));
        break;
    case 4:
        c->light.type = PNB_LIGHT_POINT;
        v3_store(c->light.shape.point.position, at);
        break;
    case 5:
        c->light.type = PNB_LIGHT_SUN;
        v3_store(c->light.shape.sun.direction, u);
        c->light.shape.sun.angular_diameter_degrees = pow(10, within(r, -1, 1.5));
        break;
    }
}

bool twin_case_init(pnb_context *context, uint64_t seed, struct twin_case *c)
{
    struct twin_random random = {seed * 0x9e3779b97f4a7c15ull + 1}, *r = &random;
    memset(c, 0, sizeof(*c));
    for (int i = 0; i < 8; i++)
        twin_uniform(r);
    if (pnb_scene_create(context, &c->scene) != PNB_OK)
        return false;
    struct shape *shape = malloc(sizeof(*shape));
    double scale = twin_below(r, 3) ? 1 : pow(10, within(r, -4, 4));
    vec3 offset = twin_below(r, 3) ? v3(0, 0, 0) : v3_scale(direction(r), scale * within(r, 0, 30));
    int used = snprintf(c->text, sizeof(c->text), "scale %g:", scale);
    vec3 touch = offset;
    bool fine = shape != NULL;
    for (int m = 1 + twin_below(r, 3); m > 0 && fine; m--) {
        int kind = make_shape(r, shape);
        if (used < (int)sizeof(c->text))
            used += snprintf(c->text + used, sizeof(c->text) - (size_t)used, " %s", kinds[kind]);
        pnb_mesh_desc desc = {"mesh",          shape->positions, NULL,
                              shape->vertices, shape->indices,   shape->triangles};
        size_t mesh;
        fine = pnb_scene_add_mesh(c->scene, &desc, &mesh) == PNB_OK;
        for (int i = 1 + twin_below(r, 3); i > 0 && fine; i--) {
            vec3 x = direction(r), y, z;
            v3_frame(x, &y, &z);
            vec3 t = v3_mad(offset, direction(r), scale * within(r, 0, 1.5));
            double s[3] = {scale, scale, scale};
            if (twin_below(r, 4) == 0)
                s[0] *= within(r, 0.2, 2), s[1] *= twin_below(r, 2) ? -1 : 0.3;
            if (twin_below(r, 12) == 0)
                s[2] = 0; /* flattened */
            pnb_object object = {.name = "object", .mesh = mesh, .casts = true, .receives = true};
            const double placement[12] = {x.x * s[0], y.x * s[1], z.x * s[2], t.x,
                                          x.y * s[0], y.y * s[1], z.y * s[2], t.y,
                                          x.z * s[0], y.z * s[1], z.z * s[2], t.z};
            memcpy(object.world_from_mesh, placement, sizeof(placement));
            size_t index;
            fine = pnb_scene_add_object(c->scene, &object, &index) == PNB_OK;
            size_t v = (size_t)twin_below(r, (int)shape->vertices);
            touch = m34_point(placement, v3_loadf(shape->positions + 3 * v));
        }
    }
    free(shape);

    /* Away from the objects, among them, or touching one. */
    int where = twin_below(r, 4);
    vec3 at = v3_mad(offset, direction(r), scale * within(r, 2, 5));
    if (where == 0)
        at = v3_mad(offset, direction(r), scale * twin_uniform(r));
    else if (where == 1)
        at = touch;
    make_light(r, c, scale, at);

    /* Receivers: a patch of neighbours on a plane, points on triangles, points anywhere. */
    vec3 up = direction(r), u, v;
    v3_frame(up, &u, &v);
    vec3 middle = v3_mad(offset, direction(r), scale * within(r, 0, 3));
    double size = scale * pow(10, within(r, -2.5, 0.5));
    bool image = twin_below(r, 2) == 0;
    for (int i = 0; i < TWIN_RECEIVERS; i++) {
        vec3 p, n = up;
        if (image || i < TWIN_RECEIVERS / 2) {
            p = v3_mad(v3_mad(middle, u, size * twin_uniform(r)), v, size * twin_uniform(r));
        } else if (i % 2 && fine) {
            pnb_object object;
            pnb_mesh_desc mesh;
            pnb_scene_object(c->scene, (size_t)twin_below(r, (int)pnb_scene_object_count(c->scene)),
                             &object);
            pnb_scene_mesh(c->scene, object.mesh, &mesh);
            const uint32_t *t = mesh.indices + 3 * (size_t)twin_below(r, (int)mesh.triangle_count);
            vec3 q[3];
            for (int k = 0; k < 3; k++)
                q[k] = m34_point(object.world_from_mesh, v3_loadf(mesh.positions + 3 * t[k]));
            double a = twin_uniform(r), b = twin_uniform(r) * (1 - a);
            p = v3_mad(v3_mad(q[0], v3_sub(q[1], q[0]), a), v3_sub(q[2], q[0]), b);
            n = v3_normalize(v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0])));
            if (twin_below(r, 2))
                n = v3_scale(n, -1);
            if (!(v3_length(n) > 0.5))
                n = up;
        } else {
            p = v3_mad(offset, direction(r), scale * within(r, 0, 4));
            n = direction(r);
        }
        v3_storef(c->positions + 3 * i, p);
        v3_storef(c->normals + 3 * i, n);
    }
    c->receivers =
        (pnb_receivers){.count = TWIN_RECEIVERS, .positions = c->positions, .normals = c->normals};
    if (image)
        c->receivers.width = TWIN_RECEIVERS / 8, c->receivers.height = 8;
    if (!fine)
        twin_case_finish(c);
    return fine;
}

void twin_case_finish(struct twin_case *c)
{
    pnb_scene_destroy(c->scene);
    c->scene = NULL;
}

/* Does the open segment (or ray) from the origin along e meet the triangle? */
static bool blocks(const vec3 q[3], vec3 e, bool endless)
{
    vec3 n = v3_cross(v3_sub(q[1], q[0]), v3_sub(q[2], q[0]));
    double along = v3_dot(n, e), height = v3_dot(n, q[0]);
    if (along == 0 || height == 0)
        return false;
    double t = height / along;
    if (!(t > 0) || (!endless && !(t < 1 - TOLERANCE_LIGHT_GAP)))
        return false;
    double side = along > 0 ? 1 : -1;
    for (int i = 0; i < 3; i++)
        if (side * v3_dot(e, v3_cross(q[i], q[(i + 1) % 3])) < 0)
            return false;
    return true;
}

void twin_visibility(pnb_context *context, const struct twin_case *c, int samples, double *out)
{
    struct exact_light light;
    if (exact_light_init(context, &c->light, samples, false, &light) != PNB_OK)
        abort();
    const struct exact_grid *grid = &light.grid;
    double lift = scene_receiver_lift(c->scene);
    for (size_t i = 0; i < c->receivers.count; i++) {
        vec3 p = v3_loadf(c->positions + 3 * i), n = v3_loadf(c->normals + 3 * i);
        vec3 eye = v3_mad(p, n, lift);
        double seen = 0, total = 0;
        bool lit = !light.one_sided || v3_dot(light.normal, v3_sub(p, light.center)) > 0;
        for (int j = 0; j < grid->rows; j++)
            for (int k = 0; k < grid->bins; k++) {
                double weight = (double)grid->weight[k * grid->stride + j] * grid->length[j];
                if (weight == 0)
                    continue;
                total += weight;
                double s =
                    (k + (double)grid->place[j] - grid->base[j]) / grid->scale[j] / grid->bins;
                double row = (j + grid->row_shift) / grid->rows;
                vec3 l = v3_mad(v3_mad(light.center, light.u, s - 0.5), light.v, row - 0.5);
                vec3 e = light.sun ? l : v3_sub(l, eye);
                bool visible = lit && v3_dot(n, e) + (light.sun ? 0 : lift) > 0;
                for (size_t o = 0; o < pnb_scene_object_count(c->scene) && visible; o++) {
                    pnb_object object;
                    pnb_mesh_desc mesh;
                    pnb_scene_object(c->scene, o, &object);
                    pnb_scene_mesh(c->scene, object.mesh, &mesh);
                    for (size_t t = 0; t < mesh.triangle_count && visible; t++) {
                        vec3 q[3];
                        for (int v = 0; v < 3; v++)
                            q[v] = v3_sub(m34_point(object.world_from_mesh,
                                                    v3_loadf(mesh.positions +
                                                             3 * mesh.indices[3 * t + (size_t)v])),
                                          eye);
                        visible = !blocks(q, e, light.sun);
                    }
                }
                seen += visible ? weight : 0;
            }
        out[i] = seen / total;
    }
    exact_light_finish(context, &light);
}
