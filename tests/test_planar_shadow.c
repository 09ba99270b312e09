#define _DEFAULT_SOURCE /* mkdtemp */
/* The shadow as geometry: what the triangles add up to, and the files: read back by the importer,
 * and rasterised by other programs (rsvg-convert, pdftoppm; skipped where they are absent). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <penumbra/penumbra.h>

static char folder[] = "/tmp/penumbra-shadow-XXXXXX";

static char *file(const char *name)
{
    static char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return path;
}

struct fixture {
    pnb_context *context;
    pnb_scene *scene;
    pnb_shadow *shadow;
    pnb_shadow_view view;
};

static void begin(struct fixture *f, const char *scene, int samples, const char *key,
                  const char *value)
{
    assert_int_equal(pnb_context_create(NULL, &f->context), PNB_OK);
    if (pnb_scene_load(f->context, scene, &f->scene))
        fail_msg("%s", pnb_context_error(f->context));
    pnb_light light;
    pnb_scene_light(f->scene, 0, &light);
    pnb_solver_param param = {key, value};
    pnb_solver_desc desc = {.samples = samples, .params = &param, .param_count = key ? 1 : 0};
    if (pnb_shadow_create(f->context, f->scene, &light, &desc, &f->shadow))
        fail_msg("%s", pnb_context_error(f->context));
    pnb_shadow_get(f->shadow, &f->view);
}

static void end(struct fixture *f)
{
    pnb_shadow_destroy(f->shadow);
    pnb_scene_destroy(f->scene);
    pnb_context_destroy(f->context);
}

static double triangle_area(const pnb_shadow_view *v, size_t t)
{
    const uint32_t *i = v->indices + 3 * t;
    const float *a = v->coordinates + 2 * (size_t)i[0], *b = v->coordinates + 2 * (size_t)i[1],
                *c = v->coordinates + 2 * (size_t)i[2];
    return 0.5 * (((double)b[0] - a[0]) * ((double)c[1] - a[1]) -
                  ((double)b[1] - a[1]) * ((double)c[0] - a[0]));
}

/* Area of a GeoJSON feature's polygons. */
static double feature_area(json_t *feature)
{
    double area = 0;
    json_t *polygons = json_object_get(json_object_get(feature, "geometry"), "coordinates");
    size_t i, j;
    json_t *polygon, *ring;
    json_array_foreach(polygons, i, polygon) json_array_foreach(polygon, j, ring)
    {
        double sum = 0;
        for (size_t k = 0; k + 1 < json_array_size(ring); k++) {
            json_t *p = json_array_get(ring, k), *q = json_array_get(ring, k + 1);
            sum +=
                0.5 *
                (json_number_value(json_array_get(p, 0)) * json_number_value(json_array_get(q, 1)) -
                 json_number_value(json_array_get(p, 1)) * json_number_value(json_array_get(q, 0)));
        }
        assert_true(j == 0 ? sum > 0 : sum < 0);
        area += sum;
    }
    return area;
}

static void rings_and_triangles_cover_the_same(void **state)
{
    struct fixture f;
    begin(&f, "builtin:knot", 8, "mend", "no");
    double area = 0, umbra = 0;
    for (size_t t = 0; t < f.view.triangle_count; t++) {
        area += triangle_area(&f.view, t);
        const uint32_t *i = f.view.indices + 3 * t;
        for (int k = 0; k < 3; k++)
            assert_in_range((int)(f.view.intensities[i[k]] * 1000), 0, 1000);
    }
    assert_int_equal(pnb_shadow_write(f.shadow, file("knot.geojson"), -1), PNB_OK);
    json_t *root = json_load_file(file("knot.geojson"), 0, NULL);
    assert_non_null(root);
    json_t *features = json_object_get(root, "features");
    assert_int_equal(json_array_size(features), 2 + 8);
    double outer = feature_area(json_array_get(features, 0)), last = 1e30;
    for (size_t i = 2; i < 10; i++) {
        double ring = feature_area(json_array_get(features, i));
        assert_true(ring <= last);
        last = ring;
    }
    umbra = feature_area(json_array_get(features, 1));
    assert_true(fabs(umbra - last) < 1e-9);
    print_message("area of triangles %.9g, of ring 1 %.9g\n", area, outer);
    assert_true(fabs(area / outer - 1) < 1e-5); /* coordinates of triangles are floats */
    json_decref(root);
    end(&f);
}

static void meshes_come_back(void **state)
{
    static const char *const names[] = {"boxes.obj", "boxes.ply", "boxes.glb"};
    struct fixture f;
    begin(&f, "builtin:two-boxes", 5, NULL, NULL);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(pnb_shadow_write(f.shadow, file(names[i]), -1), PNB_OK);
        pnb_scene *back;
        if (pnb_scene_load(f.context, file(names[i]), &back))
            fail_msg("%s: %s", names[i], pnb_context_error(f.context));
        size_t triangles = 0;
        for (size_t m = 0; m < pnb_scene_mesh_count(back); m++) {
            pnb_mesh_desc mesh;
            pnb_scene_mesh(back, m, &mesh);
            triangles = mesh.triangle_count > triangles ? mesh.triangle_count : triangles;
        }
        assert_int_equal(triangles, f.view.triangle_count);
        pnb_scene_destroy(back);
    }
    end(&f);
}

/* The page as a raster of greys over white, 500 pixels wide, against look-up in the triangles. */
static void check_page(struct fixture *f, const char *command, const char *png, double ceiling)
{
    pnb_image image;
    if (system(command) != 0 || pnb_image_read(f->context, png, &image) != PNB_OK) {
        print_message("cannot rasterise: %s\n", command);
        skip();
    }
    pnb_shadow_plane plane;
    pnb_shadow_get_plane(f->shadow, 0, &plane);
    size_t n = (size_t)image.width * image.height;
    float *shadow = calloc(n, sizeof(*shadow));
    for (size_t t = 0; t < f->view.triangle_count; t++) {
        double p[3][3], lo[2] = {1e30, 1e30}, hi[2] = {-1e30, -1e30};
        for (int k = 0; k < 3; k++) {
            uint32_t v = f->view.indices[3 * t + k];
            p[k][0] = (f->view.coordinates[2 * v] / plane.half_u + 1) * 0.5 * image.width;
            p[k][1] = (1 - f->view.coordinates[2 * v + 1] / plane.half_v) * 0.5 * image.height;
            p[k][2] = f->view.intensities[v];
            for (int a = 0; a < 2; a++) {
                lo[a] = fmin(lo[a], p[k][a]);
                hi[a] = fmax(hi[a], p[k][a]);
            }
        }
        for (int y = (int)fmax(0, lo[1]); y < image.height && y <= hi[1]; y++)
            for (int x = (int)fmax(0, lo[0]); x < image.width && x <= hi[0]; x++) {
                double w[3], sum = 0, value = 0;
                for (int k = 0; k < 3; k++) {
                    double *a = p[(k + 1) % 3], *b = p[(k + 2) % 3];
                    w[k] =
                        (a[0] - x - 0.5) * (b[1] - y - 0.5) - (a[1] - y - 0.5) * (b[0] - x - 0.5);
                    sum += w[k];
                    value += w[k] * p[k][2];
                }
                if (w[0] / sum >= 0 && w[1] / sum >= 0 && w[2] / sum >= 0)
                    shadow[(size_t)y * image.width + x] = (float)(value / sum);
            }
    }
    /* Pixels on a sharp edge are blurred by it; all others must agree. */
    double error = 0;
    size_t off = 0;
    for (size_t i = 0; i < n; i++) {
        double grey = image.data[i * image.channels]; /* linear: back to the file's grey */
        grey = grey <= 0.0031308 ? 12.92 * grey : 1.055 * pow(grey, 1 / 2.4) - 0.055;
        error += pow(grey - (1 - shadow[i]), 2);
        off += fabs(grey - (1 - shadow[i])) > 0.02;
    }
    error = sqrt(error / n);
    print_message("%s: RMSE against the mesh %.4f, %.2f%% of the pixels off by more than 0.02\n",
                  png, error, 100.0 * off / n);
    assert_true(error < ceiling);
    assert_true(off < n / 200);
    free(shadow);
    pnb_image_finish(f->context, &image);
}

static void svg_draws_the_mesh(void **state)
{
    struct fixture f;
    char command[1024];
    begin(&f, "builtin:two-boxes", 8, NULL, NULL);
    assert_int_equal(pnb_shadow_write(f.shadow, file("boxes.svg"), -1), PNB_OK);
    snprintf(command, sizeof(command),
             "rsvg-convert -b white -w 1000 %s/boxes.svg -o %s/svg.png 2>/dev/null", folder,
             folder);
    check_page(&f, command, file("svg.png"), 0.03);
    end(&f);
}

static void pdf_draws_the_mesh(void **state)
{
    struct fixture f;
    char command[1024];
    begin(&f, "builtin:two-boxes", 8, NULL, NULL);
    assert_int_equal(pnb_shadow_write(f.shadow, file("boxes.pdf"), -1), PNB_OK);
    snprintf(command, sizeof(command),
             "pdftoppm -r 72 -png -singlefile %s/boxes.pdf %s/pdf 2>/dev/null", folder, folder);
    check_page(&f, command, file("pdf.png"), 0.03);
    end(&f);
}

static void bad_asks_are_refused(void **state)
{
    struct fixture f;
    begin(&f, "builtin:pole", 3, NULL, NULL);
    assert_int_equal(pnb_shadow_write(f.shadow, file("pole.xyz"), -1), PNB_ERROR_ARGUMENT);
    assert_int_equal(pnb_shadow_write(f.shadow, "/nowhere/pole.obj", -1), PNB_ERROR_FILE);
    static const double bent[] = {-1, 5, -1, 1, 5, -1, 1, 5, 0, 0, 5, 0, 0, 5, 1, -1, 5, 1};
    pnb_light light = {.type = PNB_LIGHT_POLYGON, .shape.polygon = {bent, 6}, .color = {1, 1, 1}};
    pnb_shadow *shadow;
    assert_int_equal(pnb_shadow_create(f.context, f.scene, &light, NULL, &shadow),
                     PNB_ERROR_UNSUPPORTED);
    assert_null(shadow);
    end(&f);
}

static int setup(void **state)
{
    return mkdtemp(folder) ? 0 : -1;
}

static int teardown(void **state)
{
    char command[300];
    snprintf(command, sizeof(command), "rm -r %s", folder);
    return system(command);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rings_and_triangles_cover_the_same),
        cmocka_unit_test(meshes_come_back),
        cmocka_unit_test(svg_draws_the_mesh),
        cmocka_unit_test(pdf_draws_the_mesh),
        cmocka_unit_test(bad_asks_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
