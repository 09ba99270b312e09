/* examples/planar_figures.c: a hard shadow from nothing but projected triangles, and the figures 6
 * to 9 of Boehl and Stuerzlinger's paper remade.
 *
 *     example-planar_figures [FOLDER]
 *
 * Every triangle that faces the light goes into the sweep as three directed edges, projected onto
 * the ground; edges between two such triangles cancel by themselves. With FOLDER four SVG pictures
 * are written: 6 the projected silhouette, 7 its regions by winding number, 8 the outlines of three
 * light samples merged, 9 the shadow with penumbrae.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

struct flat {
    double *points;
    uint32_t *edges;
    size_t count; /* of edges; points are two per edge */
};

/* Triangles of the scene's meshes that face the point l, on the plane y = 0. */
static struct flat project(pnb_scene *scene, const double *l)
{
    struct flat flat = {0};
    size_t triangles = pnb_scene_triangle_count(scene);
    flat.points = malloc(triangles * 6 * 2 * sizeof(double));
    flat.edges = malloc(triangles * 6 * sizeof(uint32_t));
    for (size_t o = 0; o < pnb_scene_object_count(scene); o++) {
        pnb_object object;
        pnb_mesh_desc mesh;
        pnb_scene_object(scene, o, &object);
        pnb_scene_mesh(scene, object.mesh, &mesh);
        if (object.plane || !object.casts)
            continue;
        for (size_t t = 0; t < mesh.triangle_count; t++) {
            double p[3][3], q[3][2];
            for (int k = 0; k < 3; k++) {
                const float *v = mesh.positions + 3 * mesh.indices[3 * t + k];
                const double *m = object.world_from_mesh;
                for (int a = 0; a < 3; a++)
                    p[k][a] =
                        m[4 * a] * v[0] + m[4 * a + 1] * v[1] + m[4 * a + 2] * v[2] + m[4 * a + 3];
                double s = l[1] / (l[1] - p[k][1]);
                q[k][0] = l[0] + s * (p[k][0] - l[0]);
                q[k][1] = l[2] + s * (p[k][2] - l[2]);
            }
            /* The projections of triangles that face the light all turn the same way. */
            double n[3], u[3], v[3], facing = 0;
            for (int a = 0; a < 3; a++) {
                u[a] = p[1][a] - p[0][a];
                v[a] = p[2][a] - p[0][a];
            }
            for (int a = 0; a < 3; a++) {
                n[a] = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
                facing += n[a] * (l[a] - p[0][a]);
            }
            if (facing <= 0)
                continue;
            for (int k = 0; k < 3; k++) {
                size_t e = flat.count++;
                memcpy(flat.points + 4 * e, q[k], sizeof(q[k]));
                memcpy(flat.points + 4 * e + 2, q[(k + 1) % 3], sizeof(q[k]));
                flat.edges[2 * e] = (uint32_t)(2 * e);
                flat.edges[2 * e + 1] = (uint32_t)(2 * e + 1);
            }
        }
    }
    return flat;
}

static FILE *open_svg(const char *folder, const char *name, const double *box)
{
    char path[1024];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    if (file)
        fprintf(file,
                "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"600\" height=\"%.0f\" "
                "viewBox=\"%.4f %.4f %.4f %.4f\">\n",
                600 * (box[3] - box[1]) / (box[2] - box[0]), box[0], box[1], box[2] - box[0],
                box[3] - box[1]);
    return file;
}

static void bounds(const pnb_planar_view *view, double *box)
{
    box[0] = box[1] = INFINITY;
    box[2] = box[3] = -INFINITY;
    for (size_t i = 0; i < view->point_count; i++)
        for (int a = 0; a < 2; a++) {
            box[a] = fmin(box[a], view->points[2 * i + a]);
            box[2 + a] = fmax(box[2 + a], view->points[2 * i + a]);
        }
    for (int a = 0; a < 2; a++) {
        double more = 0.25 * (box[2 + a] - box[a]);
        box[a] -= more;
        box[2 + a] += more;
    }
}

static void draw_edges(FILE *file, const pnb_planar_view *view, const double *box,
                       const char *color)
{
    fprintf(file, "<path fill=\"none\" stroke=\"%s\" stroke-width=\"%.5f\" d=\"", color,
            (box[2] - box[0]) / 900);
    for (size_t i = 0; i < view->edge_count; i++) {
        const double *a = view->points + 2 * view->edges[i].left,
                     *b = view->points + 2 * view->edges[i].right;
        fprintf(file, "M%.4f %.4fL%.4f %.4f", a[0], a[1], b[0], b[1]);
    }
    fprintf(file, "\"/>\n");
}

static void draw_regions(FILE *file, const pnb_planar_view *view)
{
    static const char *const colors[] = {"#fee8c8", "#fdbb84", "#e34a33",
                                         "#b30000", "#7f0000", "#400000"};
    for (int level = 1; level <= 6; level++) {
        fprintf(file, "<path fill=\"%s\" d=\"", colors[level - 1]);
        for (size_t t = 0; t < view->triangle_count; t++) {
            int at = view->triangle_levels[t] > 6 ? 6 : view->triangle_levels[t];
            if (at != level)
                continue;
            for (int k = 0; k < 3; k++) {
                const double *p = view->points + 2 * view->triangles[3 * t + k];
                fprintf(file, "%c%.4f %.4f", k ? 'L' : 'M', p[0], p[1]);
            }
            fprintf(file, "Z");
        }
        fprintf(file, "\"/>\n");
    }
}

/* What a hard shadow covers, by the chains of its outline; and by its triangles. */
static double chain_area(pnb_planar *planar, const pnb_planar_view *view, int level)
{
    const uint32_t *points, *starts;
    size_t count;
    double sum = 0;
    if (pnb_planar_chains(planar, level, &points, &starts, &count) != PNB_OK)
        return NAN;
    for (size_t c = 0; c < count; c++)
        for (uint32_t i = starts[c]; i < starts[c + 1]; i++) {
            const double *a = view->points + 2 * points[i];
            const double *b = view->points + 2 * points[i + 1 < starts[c + 1] ? i + 1 : starts[c]];
            sum -= 0.5 * (a[0] * b[1] - a[1] * b[0]);
        }
    return fabs(sum);
}

int main(int argc, char **argv)
{
    const char *folder = argc > 1 ? argv[1] : NULL;
    pnb_context *context = NULL;
    pnb_scene *scene = NULL;
    pnb_planar *planar = NULL;
    pnb_shadow *shadow = NULL;
    const double samples[3][3] = {{0.4, 5, 0.9}, {0.9, 5, 0.1}, {0.1, 5, 0.2}};
    int result = 1;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    if (pnb_scene_load(context, "builtin:knot", &scene) || pnb_planar_create(context, &planar))
        goto end;

    /* Figures 6 and 7: one sample. In x, z seen from above the front triangles turn clockwise. */
    struct flat one = project(scene, samples[0]);
    pnb_planar_desc desc = {.points = one.points,
                            .point_count = 2 * one.count,
                            .edges = one.edges,
                            .edge_count = one.count,
                            .fill = PNB_PLANAR_FILL_SWEEP};
    if (pnb_planar_sweep(planar, &desc))
        goto end;
    pnb_planar_view view;
    pnb_planar_get(planar, &view);
    double by_triangles = 0, by_chains = chain_area(planar, &view, 1), box[4];
    for (size_t t = 0; t < view.triangle_count; t++) {
        const double *a = view.points + 2 * view.triangles[3 * t],
                     *b = view.points + 2 * view.triangles[3 * t + 1],
                     *c = view.points + 2 * view.triangles[3 * t + 2];
        by_triangles += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
    }
    bounds(&view, box);
    printf("%zu projected edges: %zu in the arrangement, area %.9g by triangles, %.9g by chains\n",
           one.count, view.edge_count, by_triangles, by_chains);
    result = fabs(by_triangles / by_chains - 1) < 1e-9 ? 0 : 1;
    FILE *file;
    if (folder && (file = open_svg(folder, "planar-figure-6.svg", box))) {
        draw_edges(file, &view, box, "#000");
        fprintf(file, "</svg>\n");
        fclose(file);
    }
    if (folder && (file = open_svg(folder, "planar-figure-7.svg", box))) {
        draw_regions(file, &view);
        fprintf(file, "</svg>\n");
        fclose(file);
    }

    /* Figure 8: the outlines of three samples, swept together. */
    size_t points = 0, edges = 0;
    double *all = NULL;
    uint32_t *links = NULL;
    for (int k = 0; k < 3 && result == 0; k++) {
        struct flat flat = project(scene, samples[k]);
        desc = (pnb_planar_desc){.points = flat.points,
                                 .point_count = 2 * flat.count,
                                 .edges = flat.edges,
                                 .edge_count = flat.count};
        if (pnb_planar_sweep(planar, &desc))
            result = 1;
        pnb_planar_get(planar, &view);
        all = realloc(all, (points + view.point_count) * 2 * sizeof(*all));
        links = realloc(links, (edges + view.edge_count) * 2 * sizeof(*links));
        memcpy(all + 2 * points, view.points, view.point_count * 2 * sizeof(*all));
        for (size_t i = 0; i < view.edge_count; i++) {
            int in_below = view.edges[i].below > 0, in_above = view.edges[i].above > 0;
            if (in_below == in_above)
                continue;
            /* The inside on the right: below an edge that runs to the right. */
            links[2 * edges] =
                (uint32_t)points + (in_below ? view.edges[i].left : view.edges[i].right);
            links[2 * edges + 1] =
                (uint32_t)points + (in_below ? view.edges[i].right : view.edges[i].left);
            edges++;
        }
        points += view.point_count;
        free(flat.points);
        free(flat.edges);
    }
    desc = (pnb_planar_desc){.points = all,
                             .point_count = points,
                             .edges = links,
                             .edge_count = edges,
                             .fill = PNB_PLANAR_FILL_SWEEP};
    if (result == 0 && pnb_planar_sweep(planar, &desc) == PNB_OK) {
        pnb_planar_get(planar, &view);
        double last = INFINITY;
        for (int level = 1; level <= 3; level++) {
            double area = chain_area(planar, &view, level);
            printf("covered by at least %d outlines: %.6g\n", level, area);
            if (area > last)
                result = 1;
            last = area;
        }
        if (folder && (file = open_svg(folder, "planar-figure-8.svg", box))) {
            draw_regions(file, &view);
            draw_edges(file, &view, box, "#000");
            fprintf(file, "</svg>\n");
            fclose(file);
        }
    }

    /* Figure 9: the whole method. */
    pnb_light light;
    pnb_scene_light(scene, 0, &light);
    pnb_solver_desc how = {.samples = 3};
    char path[1024];
    snprintf(path, sizeof(path), "%s/planar-figure-9.svg", folder ? folder : "");
    if (pnb_shadow_create(context, scene, &light, &how, &shadow) ||
        (folder && pnb_shadow_write(shadow, path, 0)))
        result = 1;
    free(one.points);
    free(one.edges);
    free(all);
    free(links);
end:
    if (result)
        fprintf(stderr, "%s\n", pnb_context_error(context));
    pnb_shadow_destroy(shadow);
    pnb_planar_destroy(planar);
    pnb_scene_destroy(scene);
    pnb_context_destroy(context);
    return result;
}
