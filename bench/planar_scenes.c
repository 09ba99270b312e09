/* bench/planar_scenes.c: the meshes of 'penumbra bench planar'. */
#include "planar_scenes.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mesh/shape.h"
#include "scene/scene.h"

void bench_die(pnb_context *context)
{
    fprintf(stderr, "penumbra: error: %s\n", pnb_context_error(context));
    exit(1);
}

static void point_of(enum bench_shape shape, double u, double v, double *p)
{
    double a = 2 * M_PI * u, b = 2 * M_PI * v;
    if (shape == BENCH_SPHERE || shape == BENCH_BLOB) {
        double t = M_PI * v;
        double r = 1;
        if (shape == BENCH_BLOB)
            r += 0.12 * sin(5 * a) * sin(4 * t) + 0.08 * sin(11 * a + 1) * sin(9 * t) +
                 0.05 * sin(17 * t + 2 * a);
        p[0] = r * sin(t) * cos(a);
        p[1] = r * cos(t);
        p[2] = r * sin(t) * sin(a);
    } else if (shape == BENCH_TORUS) {
        p[0] = (1 + 0.4 * cos(b)) * cos(a);
        p[1] = 0.4 * sin(b);
        p[2] = (1 + 0.4 * cos(b)) * sin(a);
    } else { /* a (3, 7) torus knot's tube */
        double c[3], d[3], e[3], n[3], m[3], h = 1e-4;
        for (int k = 0; k < 2; k++) {
            double s = 2 * M_PI * (u + k * h), r = 1 + 0.45 * cos(7 * s);
            double *q = k ? d : c;
            q[0] = r * cos(3 * s);
            q[1] = 0.45 * sin(7 * s);
            q[2] = r * sin(3 * s);
        }
        double length = 0;
        for (int k = 0; k < 3; k++) {
            e[k] = d[k] - c[k];
            length += e[k] * e[k];
        }
        length = sqrt(length);
        for (int k = 0; k < 3; k++)
            e[k] /= length;
        double out[3] = {c[0], 0.2, c[2]};
        double along = out[0] * e[0] + out[1] * e[1] + out[2] * e[2], size = 0;
        for (int k = 0; k < 3; k++) {
            n[k] = out[k] - along * e[k];
            size += n[k] * n[k];
        }
        size = sqrt(size);
        for (int k = 0; k < 3; k++)
            n[k] /= size;
        m[0] = e[1] * n[2] - e[2] * n[1];
        m[1] = e[2] * n[0] - e[0] * n[2];
        m[2] = e[0] * n[1] - e[1] * n[0];
        for (int k = 0; k < 3; k++)
            p[k] = c[k] + 0.12 * (cos(b) * n[k] + sin(b) * m[k]);
    }
}

static pnb_scene *ground(pnb_context *context)
{
    const double grey[3] = {0.8, 0.8, 0.8};
    pnb_scene *scene;
    size_t index;
    if (pnb_scene_create(context, &scene) ||
        scene_add_plane(scene, "ground", v3(0, 0, 0), v3(0, 1, 0), 10, grey, &index))
        bench_die(context);
    return scene;
}

static void add_object(pnb_context *context, pnb_scene *scene, const pnb_mesh_desc *mesh)
{
    pnb_object object = {.name = "occluder",
                         .world_from_mesh = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                         .color = {1, 1, 1},
                         .casts = true,
                         .receives = true};
    size_t index;
    if (pnb_scene_add_mesh(scene, mesh, &object.mesh) ||
        pnb_scene_add_object(scene, &object, &index))
        bench_die(context);
}

/* A box that hangs askew, or two slabs that cross, one above the other. */
static void add_boxes(pnb_context *context, pnb_scene *scene, bool slabs)
{
    struct shape shape;
    shape_init(context, &shape);
    if (slabs) {
        shape_beam(&shape, v3(0, 1.6, 0), v3(1.3, 0, 0.3), v3(0, 0.06, 0), v3(-0.08, 0, 0.35));
        shape_beam(&shape, v3(0.2, 2.3, 0.1), v3(0.3, 0, -1.2), v3(0, 0.06, 0), v3(0.4, 0, 0.1));
    } else {
        shape_beam(&shape, v3(0, 2, 0), v3(0.6, 0.1, 0.2), v3(-0.1, 0.6, 0), v3(-0.2, 0, 0.6));
    }
    pnb_mesh_desc mesh = shape_desc(&shape, "boxes");
    add_object(context, scene, &mesh);
    shape_finish(&shape);
}

pnb_scene *bench_scene(pnb_context *context, enum bench_shape shape, int rows, int columns)
{
    pnb_scene *scene;
    scene = ground(context);
    if (shape == BENCH_BOX || shape == BENCH_SLABS) {
        add_boxes(context, scene, shape == BENCH_SLABS);
        return scene;
    }
    bool poles = shape == BENCH_SPHERE || shape == BENCH_BLOB;
    int count_v = poles ? columns + 1 : columns;
    float *p = malloc(sizeof(float) * 3 * (size_t)rows * (size_t)count_v);
    uint32_t *t = malloc(sizeof(uint32_t) * 6 * (size_t)rows * (size_t)columns);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < count_v; j++) {
            double q[3];
            point_of(shape, (double)i / rows, (double)j / columns, q);
            /* The poles are one point each. */
            if (poles && (j == 0 || j == columns))
                point_of(shape, 0, (double)j / columns, q);
            if (poles && j == 0)
                q[0] = q[2] = 0;
            if (poles && j == columns)
                q[0] = q[2] = 0;
            float *out = p + 3 * ((size_t)i * count_v + j);
            out[0] = (float)q[0];
            out[1] = (float)(q[1] + 2);
            out[2] = (float)q[2];
        }
    size_t n = 0;
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            uint32_t a = (uint32_t)(i * count_v + j), b = (uint32_t)((i + 1) % rows * count_v + j);
            uint32_t c = (uint32_t)((i + 1) % rows * count_v + (j + 1) % count_v);
            uint32_t d = (uint32_t)(i * count_v + (j + 1) % count_v);
            uint32_t quad[6] = {a, b, c, a, c, d};
            for (int k = 0; k < 6; k += 3) {
                /* At a pole one of the two has no area: its points a and b, or c and d, are one. */
                if (poles && (j == 0 ? k == 0 : j == columns - 1 && k == 3))
                    continue;
                memcpy(t + 3 * n++, quad + k, 3 * sizeof(*t));
            }
        }
    pnb_mesh_desc mesh = {.positions = p,
                          .vertex_count = (size_t)rows * (size_t)count_v,
                          .indices = t,
                          .triangle_count = n};
    add_object(context, scene, &mesh);
    free(p);
    free(t);
    return scene;
}
