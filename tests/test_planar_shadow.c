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

/* Lights that are not convex: the sum of the pieces' shadows as one mesh, against the method's
 * look-up at the middle of its triangles; no two triangles overlap: areas add up to those of the
 * outlines. */
static void pieces_of_a_light_become_one_mesh(void **state)
{
    struct fixture f;
    begin(&f, "builtin:two-boxes", 4, NULL, NULL);
    pnb_shadow_destroy(f.shadow);
    static const double bent[] = {-1, 5, -1, 1, 5, -1, 1, 5, 0, 0, 5, 0, 0, 5, 1, -1, 5, 1};
    pnb_light light = {.type = PNB_LIGHT_POLYGON, .shape.polygon = {bent, 6}, .color = {1, 1, 1}};
    pnb_solver_desc desc = {.method = "planar", .samples = 4};
    if (pnb_shadow_create(f.context, f.scene, &light, &desc, &f.shadow))
        fail_msg("%s", pnb_context_error(f.context));
    pnb_shadow_get(f.shadow, &f.view);
    assert_int_equal(f.view.plane_count, 1);
    assert_int_equal(f.view.ring_count, 0);
    size_t n = f.view.triangle_count;
    assert_true(n > 100);
    float *positions = calloc(3 * n, sizeof(float)), *normals = calloc(3 * n, sizeof(float));
    float *seen = calloc(n, sizeof(float));
    pnb_shadow_plane plane;
    pnb_shadow_get_plane(f.shadow, 0, &plane);
    for (size_t t = 0; t < n; t++)
        for (int a = 0; a < 3; a++) {
            for (int k = 0; k < 3; k++)
                positions[3 * t + a] +=
                    f.view.positions[3 * (size_t)f.view.indices[3 * t + k] + a] / 3;
            normals[3 * t + a] = (float)plane.normal[a];
        }
    pnb_solver *solver;
    pnb_receivers receivers = {.count = n, .positions = positions, .normals = normals};
    assert_int_equal(pnb_solver_create(f.context, f.scene, &desc, &solver), PNB_OK);
    assert_int_equal(pnb_solver_visibility(solver, &light, &receivers, seen), PNB_OK);
    double sum = 0, worst = 0;
    size_t looked = 0, off = 0;
    for (size_t t = 0; t < n; t++) {
        double shadow = 0;
        for (int k = 0; k < 3; k++)
            shadow += f.view.intensities[f.view.indices[3 * t + k]] / 3;
        sum += triangle_area(&f.view, t);
        if (isnan(seen[t]) || triangle_area(&f.view, t) < 1e-6)
            continue;
        double d = fabs(1 - shadow - seen[t]);
        worst = fmax(worst, d);
        off += d > 1e-3;
        looked++;
    }
    print_message("%zu triangles, %zu looked at, %zu off by more than 0.001, most %.4f\n", n,
                  looked, off, worst);
    assert_true(looked > n / 4 && off <= looked / 1000);
    assert_true(sum > 0);
    /* Pages and rings go on. */
    assert_int_equal(pnb_shadow_write(f.shadow, file("bent.svg"), -1), PNB_OK);
    assert_int_equal(pnb_shadow_write(f.shadow, file("bent.geojson"), -1), PNB_OK);
    pnb_solver_destroy(solver);
    free(positions);
    free(normals);
    free(seen);
    end(&f);
}

static uint32_t word(const uint8_t *p)
{
    uint32_t v;
    memcpy(&v, p, 4);
    return v;
}

/* GLB, read by hand: a named mesh per plane, what its accessors say is there, and the shadow's
 * integral over the plane is the mesh's. */
static void glb_holds_a_mesh_per_plane(void **state)
{
    struct fixture f;
    begin(&f, "builtin:room", 3, "receiver", "all");
    assert_true(f.view.plane_count >= 6);
    assert_int_equal(pnb_shadow_write(f.shadow, file("room.glb"), 0), PNB_OK);
    FILE *in = fopen(file("room.glb"), "rb");
    assert_non_null(in);
    fseek(in, 0, SEEK_END);
    size_t size = (size_t)ftell(in);
    rewind(in);
    uint8_t *bytes = malloc(size);
    assert_int_equal(fread(bytes, 1, size, in), size);
    fclose(in);
    assert_int_equal(word(bytes), 0x46546c67);
    assert_int_equal(word(bytes + 8), size);
    size_t json_size = word(bytes + 12);
    json_t *root = json_loadb((const char *)bytes + 20, json_size, 0, NULL);
    assert_non_null(root);
    const uint8_t *data = bytes + 20 + json_size + 8;
    size_t data_size = word(bytes + 20 + json_size);
    assert_int_equal(20 + json_size + 8 + data_size, size);
    json_t *meshes = json_object_get(root, "meshes"), *views = json_object_get(root, "bufferViews"),
           *accessors = json_object_get(root, "accessors");
    double whole = 0, written = 0;
    size_t planes = 0;
    for (size_t p = 0; p < f.view.plane_count; p++)
        planes += f.view.first_triangles[p + 1] > f.view.first_triangles[p];
    assert_int_equal(json_array_size(meshes), planes);
    assert_int_equal(json_array_size(json_object_get(root, "nodes")), planes);
    for (size_t t = 0; t < f.view.triangle_count; t++)
        for (int k = 0; k < 3; k++)
            whole += triangle_area(&f.view, t) / 3 * f.view.intensities[f.view.indices[3 * t + k]];
    for (size_t m = 0; m < planes; m++) {
        json_t *mesh = json_array_get(meshes, m);
        assert_true(strncmp(json_string_value(json_object_get(mesh, "name")), "shadow-", 7) == 0);
        json_t *primitive = json_array_get(json_object_get(mesh, "primitives"), 0);
        json_t *attributes = json_object_get(primitive, "attributes");
        json_t *which[3] = {json_object_get(attributes, "POSITION"),
                            json_object_get(attributes, "COLOR_0"),
                            json_object_get(primitive, "indices")};
        const uint8_t *at[3];
        size_t count[3];
        for (int i = 0; i < 3; i++) {
            json_t *accessor = json_array_get(accessors, (size_t)json_integer_value(which[i]));
            json_t *view = json_array_get(
                views, (size_t)json_integer_value(json_object_get(accessor, "bufferView")));
            size_t offset = (size_t)json_integer_value(json_object_get(view, "byteOffset"));
            size_t length = (size_t)json_integer_value(json_object_get(view, "byteLength"));
            static const size_t stride[] = {12, 16, 4};
            count[i] = (size_t)json_integer_value(json_object_get(accessor, "count"));
            assert_true(offset + length <= data_size);
            assert_int_equal(length, stride[i] * count[i]);
            at[i] = data + offset;
        }
        assert_int_equal(count[0], count[1]);
        for (size_t i = 0; i < count[2]; i += 3) {
            double p[3][3], alpha = 0, area = 0;
            for (int k = 0; k < 3; k++) {
                uint32_t v = word(at[2] + 4 * (i + (size_t)k));
                float x[3], color[4];
                assert_true(v < count[0]);
                memcpy(x, at[0] + 12 * (size_t)v, 12);
                memcpy(color, at[1] + 16 * (size_t)v, 16);
                for (int a = 0; a < 3; a++)
                    p[k][a] = x[a];
                alpha += color[3] / 3;
                assert_true(color[0] == 0 && color[1] == 0 && color[2] == 0);
            }
            double n[3];
            for (int a = 0; a < 3; a++) {
                int b = (a + 1) % 3, c = (a + 2) % 3;
                n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) -
                       (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
                area += n[a] * n[a];
            }
            written += 0.5 * sqrt(area) * alpha;
        }
    }
    print_message("shadow over %zu planes: %.6f, written %.6f\n", planes, whole, written);
    assert_true(fabs(written / whole - 1) < 1e-4);
    json_decref(root);
    free(bytes);
    end(&f);
}

static void bad_asks_are_refused(void **state)
{
    struct fixture f;
    begin(&f, "builtin:pole", 3, NULL, NULL);
    assert_int_equal(pnb_shadow_write(f.shadow, file("pole.xyz"), -1), PNB_ERROR_ARGUMENT);
    assert_int_equal(pnb_shadow_write(f.shadow, "/nowhere/pole.obj", -1), PNB_ERROR_FILE);
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
        cmocka_unit_test(pieces_of_a_light_become_one_mesh),
        cmocka_unit_test(glb_holds_a_mesh_per_plane),
        cmocka_unit_test(bad_asks_are_refused),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
