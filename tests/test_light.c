/* Lights: checks, areas, samples, irradiance against brute force. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "light/light.h"
#include "light/polygon.h"

static const double l_shape[] = {-1, 4, -1, 1, 4, -1, 1, 4, 0, 0, 4, 0, 0, 4, 1, -1, 4, 1};

static pnb_light rectangle(void)
{
    return (pnb_light){.type = PNB_LIGHT_RECTANGLE,
                       .color = {1, 2, 3},
                       .shape.rectangle = {{0.5, 4, -0.25}, {0.5, 0, 0.1}, {0.2, 0, 1}}};
}
static pnb_light disk(void)
{
    return (pnb_light){.type = PNB_LIGHT_DISK,
                       .color = {1, 2, 3},
                       .shape.disk = {{0.5, 4, -0.25}, {0.2, -2, 0.5}, 0.8}};
}
static pnb_light polygon(void)
{
    /* Seen from below its vertices run counter-clockwise: emits down. */
    return (pnb_light){
        .type = PNB_LIGHT_POLYGON, .color = {1, 2, 3}, .shape.polygon = {l_shape, 6}};
}
static pnb_light line(void)
{
    return (pnb_light){
        .type = PNB_LIGHT_LINE, .color = {1, 2, 3}, .shape.line = {{-1, 3, 0.5}, {1.5, 4, 0}}};
}
static pnb_light sun(double degrees)
{
    return (pnb_light){
        .type = PNB_LIGHT_SUN, .color = {1, 2, 3}, .shape.sun = {{0.3, -1, 0.2}, degrees}};
}
static pnb_light point(void)
{
    return (pnb_light){.type = PNB_LIGHT_POINT, .color = {1, 2, 3}, .shape.point = {{0.3, 2, 0.1}}};
}

static pnb_context *context;

static int setup(void **state)
{
    return pnb_context_create(&(pnb_context_desc){.threads = 2}, &context);
}
static int teardown(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

static void expect_refused(pnb_light light, const char *text)
{
    assert_int_equal(pnb_light_check(context, &light), PNB_ERROR_SCENE);
    if (!strstr(pnb_context_error(context), text))
        fail_msg("'%s' does not say '%s'", pnb_context_error(context), text);
}

static void bad_lights_are_refused(void **state)
{
    pnb_light good[] = {rectangle(), disk(), polygon(), line(), point(), sun(0.53)};
    for (size_t i = 0; i < sizeof(good) / sizeof(*good); i++) {
        assert_int_equal(pnb_light_check(context, &good[i]), PNB_OK);
        pnb_light bad = good[i];
        bad.color[1] = NAN;
        expect_refused(bad, "colour");
        bad = good[i];
        if (bad.type != PNB_LIGHT_POLYGON) {
            memcpy(&bad.shape, &(double){INFINITY}, sizeof(double));
            expect_refused(bad, "not finite");
        }
    }
    pnb_light bad = rectangle();
    memcpy(bad.shape.rectangle.half_v, bad.shape.rectangle.half_u, 3 * sizeof(double));
    expect_refused(bad, "no area");
    bad = rectangle();
    memset(bad.shape.rectangle.half_u, 0, 3 * sizeof(double));
    expect_refused(bad, "no area");
    bad = disk();
    bad.shape.disk.radius = 0;
    expect_refused(bad, "above zero");
    bad.shape.disk.radius = -1;
    expect_refused(bad, "above zero");
    bad = disk();
    memset(bad.shape.disk.normal, 0, 3 * sizeof(double));
    expect_refused(bad, "normal is zero");
    bad = line();
    memcpy(bad.shape.line.to, bad.shape.line.from, 3 * sizeof(double));
    expect_refused(bad, "no length");
    expect_refused(sun(0), "between 0 and 180");
    expect_refused(sun(180), "between 0 and 180");

    static const double two[] = {0, 0, 0, 1, 0, 0};
    static const double flat[] = {0, 0, 0, 1, 0, 0, 2, 0, 0};
    static const double bent[] = {0, 0, 0, 1, 0, 0, 1, 1, 0.1, 0, 1, 0};
    static const double bow[] = {0, 0, 0, 2, 0, 0, 0, 1, 0, 3, 1.5, 0};
    static const double touch[] = {0, 0, 0, 4, 0, 0, 4, 4, 0, 2, 0, 0, 0, 4, 0};
    static const double spike[] = {0, 0, 0, 4, 0, 0, 4, 4, 0, 4, -2, 0, 3, 5, 0};
    static const double twice[] = {0, 0, 0, 0, 0, 0, 4, 0, 0, 4, 4, 0};
    static const double nan[] = {0, 0, 0, 4, 0, 0, 4, NAN, 0};
    const struct {
        const double *vertices;
        size_t count;
        const char *text;
    } cases[] = {{two, 2, "three"},        {flat, 3, "no area"},     {bent, 4, "not planar"},
                 {bow, 4, "not simple"},   {touch, 5, "not simple"}, {spike, 5, "not simple"},
                 {twice, 4, "same point"}, {nan, 3, "not finite"}};
    for (size_t i = 0; i < sizeof(cases) / sizeof(*cases); i++) {
        bad = (pnb_light){.type = PNB_LIGHT_POLYGON,
                          .shape.polygon = {cases[i].vertices, cases[i].count}};
        expect_refused(bad, cases[i].text);
    }
}

/* Stars, combs and outlines with straight corners: the triangles' area is the polygon's. */
static void triangulation_keeps_the_area(void **state)
{
    srand(1);
    for (int round = 0; round < 500; round++) {
        size_t count = 3 + (size_t)(rand() % 40);
        double points[200];
        uint32_t links[200], triangles[300];
        if (round % 2) {
            for (size_t i = 0; i < count; i++) {
                double r = 0.2 + rand() / (double)RAND_MAX,
                       a = 2 * M_PI * (double)i / (double)count;
                points[2 * i] = r * cos(a);
                points[2 * i + 1] = r * sin(a);
            }
        } else {
            /* A comb on integers: teeth up, straight corners along the bottom. */
            count = 0;
            int teeth = 1 + rand() % 10;
            for (int i = 0; i <= teeth * 2; i++, count++)
                points[2 * count] = i, points[2 * count + 1] = 0;
            for (int i = teeth * 2; i >= 0; i--, count++)
                points[2 * count] = i, points[2 * count + 1] = i % 2 ? 1 : 3;
        }
        size_t first, second, n;
        assert_true(polygon_simple(points, count, &first, &second));
        n = polygon_triangulate(points, count, links, links + 100, triangles);
        assert_true(n <= count - 2);
        double area = 0;
        for (size_t i = 0; i < n; i++) {
            double corner[6];
            for (int k = 0; k < 3; k++)
                memcpy(corner + 2 * k, points + 2 * triangles[3 * i + (size_t)k], 16);
            double part = polygon_area(corner, 3);
            assert_true(part > 0);
            area += part;
        }
        assert_true(fabs(area - polygon_area(points, count)) < 1e-12 * area);
    }
}

static void areas_and_normals(void **state)
{
    struct light_shape s;
    pnb_light l = rectangle();
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    assert_true(fabs(s.area - 4 * (0.5 * 1 - 0.1 * 0.2)) < 1e-12);
    assert_true(fabs(s.normal.y + 1) < 1e-12); /* z x x is up, x x z down */
    light_shape_finish(context, &s);
    l = polygon();
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    assert_true(fabs(s.area - 3) < 1e-12);
    assert_true(fabs(s.normal.y + 1) < 1e-12);
    assert_int_equal(s.triangle_count, 4);
    light_shape_finish(context, &s);
    l = disk();
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    assert_true(fabs(s.area - M_PI * 0.64) < 1e-12);
    light_shape_finish(context, &s);
    l = line();
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    assert_true(fabs(s.area - sqrt(2.5 * 2.5 + 1 + 0.25)) < 1e-12);
    l = sun(10);
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    assert_true(fabs(s.area - 2 * M_PI * (1 - cos(5 * M_PI / 180))) < 1e-12);
}

/* Every dyadic box of 2^k points of the sequence holds one of them, for any aligned run and seed;
 * and the points are uniform over the seeds. */
static void owen_sobol_is_a_net(void **state)
{
    static uint8_t hit[4096];
    for (uint32_t seed = 0; seed < 20; seed++)
        for (int k = 0; k <= 12; k++)
            for (int a = 0; a <= k; a++) {
                uint32_t n = 1u << k, first = (seed % 3) * n;
                memset(hit, 0, n);
                for (uint32_t i = 0; i < n; i++) {
                    float u, v;
                    light_sobol_owen(first + i, seed * 7919u, &u, &v);
                    assert_true(u >= 0 && u < 1 && v >= 0 && v < 1);
                    uint32_t x = (uint32_t)(u * (float)(1u << a)),
                             y = (uint32_t)(v * (float)(1u << (k - a)));
                    assert_int_equal(hit[y << a | x]++, 0);
                }
            }
    /* Each single point over the seeds: 16x16 cells, chi-square with 255 degrees of freedom (mean
     * 255, deviation 22.6), and no correlation between neighbours in the sequence. */
    for (uint32_t index = 0; index < 40; index += 3) {
        int count[256] = {0};
        double chi = 0, both = 0;
        const int seeds = 20000;
        for (int seed = 0; seed < seeds; seed++) {
            float u, v, u2, v2;
            light_sobol_owen(index, (uint32_t)seed, &u, &v);
            light_sobol_owen(index, (uint32_t)seed + 1, &u2, &v2);
            count[(int)(u * 16) * 16 + (int)(v * 16)]++;
            both += (u - 0.5) * (u2 - 0.5) + (v - 0.5) * (v2 - 0.5);
        }
        for (int i = 0; i < 256; i++)
            chi += (count[i] - seeds / 256.0) * (count[i] - seeds / 256.0) / (seeds / 256.0);
        assert_true(chi > 140 && chi < 380);
        assert_true(fabs(both / seeds) < 6 * (1.0 / 12) * sqrt(2.0 / seeds));
    }
}

/* Sample moments against those of the shape, from a midpoint grid. */
static void samples_cover_by_area(void **state)
{
    pnb_light lights[] = {rectangle(), disk(), polygon(), line()};
    for (int k = 0; k < 4; k++) {
        struct light_shape s;
        assert_int_equal(light_shape_init(context, &lights[k], &s), PNB_OK);
        vec3 sum = v3(0, 0, 0);
        double second = 0;
        const int n = 1200;
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                struct light_point p = light_shape_sample(&s, (i + 0.5) / n, (j + 0.5) / n);
                assert_true(p.w == 1);
                sum = v3_add(sum, p.p);
                if (k != 3)
                    assert_true(fabs(v3_dot(v3_sub(p.p, s.origin), s.normal)) < 1e-12);
                vec3 d = v3_sub(p.p, k == 2 ? v3(0, 4, 0) : s.origin);
                second += v3_dot(d, d);
            }
        sum = v3_scale(sum, 1.0 / n / n);
        second /= (double)n * n;
        if (k == 0)
            assert_true(v3_length(v3_sub(sum, v3(0.5, 4, -0.25))) < 1e-6);
        if (k == 1) {
            assert_true(v3_length(v3_sub(sum, v3(0.5, 4, -0.25))) < 1e-6);
            assert_true(fabs(second - 0.32) < 1e-5); /* R^2 / 2 */
        }
        if (k == 2) {
            /* Three unit squares around (-.5,-.5), (.5,-.5), (-.5,.5). */
            assert_true(v3_length(v3_sub(sum, v3(-0.5 / 3, 4, -0.5 / 3))) < 1e-3);
            assert_true(fabs(second - 2.0 / 3) < 1e-3);
        }
        if (k == 3)
            assert_true(v3_length(v3_sub(sum, v3(0.25, 3.5, 0.25))) < 1e-6);
        light_shape_finish(context, &s);
    }
    /* Chi-square of Owen-Sobol samples on the L over 4x4 cells per unit square. */
    struct light_shape s;
    assert_int_equal(light_shape_init(context, &lights[2], &s), PNB_OK);
    int count[8][8] = {{0}};
    const int n = 48 * 1000;
    for (int i = 0; i < n; i++) {
        float u, v;
        light_sobol_owen((uint32_t)i, 5, &u, &v);
        vec3 p = light_shape_sample(&s, u, v).p;
        int x = (int)((p.x + 1) * 4), z = (int)((p.z + 1) * 4);
        assert_true(x >= 0 && x < 8 && z >= 0 && z < 8);
        assert_true(x < 4 || z < 4 || p.x < 1e-6 || p.z < 1e-6);
        count[x][z]++;
    }
    for (int x = 0; x < 8; x++)
        for (int z = 0; z < 8; z++)
            if (x < 4 || z < 4)
                assert_true(abs(count[x][z] - 1000) < 100);
    light_shape_finish(context, &s);
    /* The sun's directions are unit and within its radius. */
    pnb_light l = sun(30);
    assert_int_equal(light_shape_init(context, &l, &s), PNB_OK);
    for (int i = 0; i < 1000; i++) {
        float u, v;
        light_sobol_owen((uint32_t)i, 1, &u, &v);
        struct light_point p = light_shape_sample(&s, u, v);
        assert_true(p.w == 0 && fabs(v3_length(p.p) - 1) < 1e-12);
        assert_true(v3_dot(p.p, s.normal) > cos(15.0001 * M_PI / 180));
    }
}

static void facing_agrees_with_samples(void **state)
{
    pnb_light lights[] = {rectangle(), disk(), polygon(), line(), point(), sun(20)};
    srand(3);
    for (int k = 0; k < 6; k++) {
        struct light_shape s;
        assert_int_equal(light_shape_init(context, &lights[k], &s), PNB_OK);
        int seen[3] = {0};
        for (int round = 0; round < 2000; round++) {
            vec3 p = v3(rand() % 1000 / 125. - 4, rand() % 1000 / 160., rand() % 1000 / 125. - 4);
            vec3 n = v3_normalize(
                v3(rand() % 1000 - 499.5, rand() % 1000 - 499.5, rand() % 1000 - 499.5));
            int above = 0, below = 0;
            for (int i = 0; i < 40; i++)
                for (int j = 0; j < 40; j++) {
                    struct light_point l = light_shape_sample(&s, i / 39., j / 39.);
                    double h = v3_dot(v3_sub(l.p, v3_scale(p, l.w)), n);
                    h > 1e-9 ? above++ : (below += h < -1e-9);
                }
            bool side = k > 2 || v3_dot(v3_sub(p, s.origin), s.normal) > 0;
            enum light_facing facing = light_shape_facing(&s, p, n);
            seen[facing]++;
            if (!side)
                assert_int_equal(facing, LIGHT_FACING_NONE);
            else if (facing == LIGHT_FACING_ALL)
                assert_true(below == 0);
            else if (facing == LIGHT_FACING_NONE)
                assert_true(above == 0);
            else if (k == 0 || k == 3)
                assert_true(above > 0 && below > 0);
            assert_true(light_shape_faces(&s, p, n) == (facing == LIGHT_FACING_ALL));
        }
        assert_true(seen[LIGHT_FACING_ALL] > 50 && seen[LIGHT_FACING_NONE] > 50);
        light_shape_finish(context, &s);
    }
}

/* The slow twin: a midpoint grid over the shape's samples, for smooth integrands refined by
 * halving. */
static double brute(const struct light_shape *s, vec3 p, vec3 n, int grid)
{
    double sum = 0;
    for (int i = 0; i < grid; i++)
        for (int j = 0; j < (s->light.type == PNB_LIGHT_LINE ? 1 : grid); j++) {
            struct light_point l = light_shape_sample(s, (i + 0.5) / grid, (j + 0.5) / grid);
            vec3 r = v3_sub(l.p, v3_scale(p, l.w));
            double d2 = v3_dot(r, r), cosine = v3_dot(r, n) / sqrt(d2), emit = 1;
            if (s->light.type <= PNB_LIGHT_POLYGON)
                emit = -v3_dot(r, s->normal) / sqrt(d2);
            if (l.w == 0) {
                /* Uniform in the tangent disk: solid angle goes with the cube of the cosine. */
                double c = v3_dot(l.p, s->normal);
                emit = c * c * c;
                d2 = 1;
                cosine = v3_dot(l.p, n);
            }
            if (cosine > 0 && emit > 0)
                sum += cosine * emit / d2;
        }
    double cells = s->light.type == PNB_LIGHT_LINE ? grid : (double)grid * grid, area = s->area;
    if (s->light.type == PNB_LIGHT_SUN) {
        double radius = v3_length(s->axis_u);
        /* Radiance such that the axis receives 1. */
        area = M_PI * radius * radius * (1 + radius * radius) / (M_PI * radius * radius);
        /* (the tangent disk's area times radiance (1 + R^2) / (pi R^2)) */
    }
    return sum / cells * area;
}

static void irradiance_agrees_with_brute_force(void **state)
{
    pnb_light lights[] = {rectangle(), disk(), polygon(), line(), sun(0.53), sun(60), sun(150)};
    srand(4);
    for (size_t k = 0; k < sizeof(lights) / sizeof(*lights); k++) {
        struct light_shape s;
        assert_int_equal(light_shape_init(context, &lights[k], &s), PNB_OK);
        int cut = 0, lit = 0;
        for (int round = 0; round < 60; round++) {
            float p[3], n[3], e[3];
            vec3 q = v3(rand() % 1000 / 125. - 4, rand() % 1000 / 400., rand() % 1000 / 125. - 4);
            vec3 m = v3_normalize(
                v3(rand() % 1000 - 499.5, rand() % 1000 - 199.5, rand() % 1000 - 499.5));
            v3_storef(p, q);
            v3_storef(n, m);
            assert_int_equal(pnb_light_irradiance(context, &lights[k], p, n, 1, e), PNB_OK);
            q = v3_loadf(p);
            m = v3_loadf(n);
            double slow = brute(&s, q, m, lights[k].type == PNB_LIGHT_LINE ? 200000 : 500);
            enum light_facing facing = light_shape_facing(&s, q, m);
            cut += facing == LIGHT_FACING_SOME;
            lit += slow > 0;
            /* The grid's own error: second order inside, first order along a cut. */
            double full = s.light.type == PNB_LIGHT_SUN ? 1 : 0.2;
            double smooth = s.light.type == PNB_LIGHT_POLYGON ? 3e-3 : 1e-4;
            double bound = facing == LIGHT_FACING_ALL ? smooth * slow + 1e-7 : 3e-4 * full;
            if (fabs(e[0] - slow) > bound)
                fail_msg("light %zu round %d facing %d: %.9g against %.9g", k, round, (int)facing,
                         e[0], slow);
            assert_true(fabsf(e[1] - 2 * e[0]) <= 1e-6f * e[1]);
            assert_true(fabsf(e[2] - 3 * e[0]) <= 1e-6f * e[2]);
        }
        assert_true(lit > 10);
        if (k != 4)
            assert_true(cut > 2);
        light_shape_finish(context, &s);
    }
}

/* An L is a rectangle and a square, wherever the horizon cuts it. */
static void non_convex_polygon_is_the_sum_of_its_parts(void **state)
{
    pnb_light whole = polygon();
    pnb_light a = {.type = PNB_LIGHT_RECTANGLE,
                   .color = {1, 2, 3},
                   .shape.rectangle = {{0, 4, -0.5}, {1, 0, 0}, {0, 0, 0.5}}};
    pnb_light b = {.type = PNB_LIGHT_RECTANGLE,
                   .color = {1, 2, 3},
                   .shape.rectangle = {{-0.5, 4, 0.5}, {0.5, 0, 0}, {0, 0, 0.5}}};
    srand(6);
    enum { COUNT = 20000 };
    static float p[COUNT * 3], n[COUNT * 3], e[COUNT * 3], ea[COUNT * 3], eb[COUNT * 3];
    for (int i = 0; i < COUNT; i++) {
        v3_storef(p + 3 * i,
                  v3(rand() % 1000 / 125. - 4, rand() % 1000 / 240., rand() % 1000 / 125. - 4));
        v3_storef(n + 3 * i, v3_normalize(v3(rand() % 1000 - 499.5, rand() % 1000 - 499.5,
                                             rand() % 1000 - 499.5)));
    }
    assert_int_equal(pnb_light_irradiance(context, &whole, p, n, COUNT, e), PNB_OK);
    assert_int_equal(pnb_light_irradiance(context, &a, p, n, COUNT, ea), PNB_OK);
    assert_int_equal(pnb_light_irradiance(context, &b, p, n, COUNT, eb), PNB_OK);
    for (int i = 0; i < 3 * COUNT; i++)
        assert_true(fabs((double)e[i] - ea[i] - eb[i]) <= 1e-6 * e[i] + 1e-12);
}

/* A horizon-cut disk must join the uncut closed form, and agree with a fine polygon by Lambert's
 * formula, Richardson-extrapolated, wherever it is cut. */
static void cut_disks_to_six_digits(void **state)
{
    enum { SIDES = 4096 };
    static double fine[SIDES * 3], coarse[SIDES / 2 * 3];
    srand(5);
    for (int round = 0; round < 300; round++) {
        pnb_light d = disk();
        d.shape.disk.radius = 0.01 + rand() % 100 / 40.;
        vec3 p = v3(rand() % 1000 / 125. - 4, 3.9 - rand() % 1000 / 300., rand() % 1000 / 125. - 4);
        vec3 n =
            v3_normalize(v3(rand() % 1000 - 499.5, rand() % 1000 - 499.5, rand() % 1000 - 499.5));
        if (round % 3 == 0) /* close under the disk */
            p = v3_mad(v3_load(d.shape.disk.center), v3(0.1, -1, 0.2), 0.02 + 0.001 * round);
        struct light_shape s;
        assert_int_equal(light_shape_init(context, &d, &s), PNB_OK);
        /* Equal-area radius makes the polygon's error fourth order after extrapolation. */
        for (int i = 0; i < SIDES; i++) {
            double a = 2 * M_PI * i / SIDES;
            vec3 q = v3_mad(v3_mad(s.origin, s.axis_u, cos(a)), s.axis_v, sin(a));
            v3_store(fine + 3 * i, q);
            if (i % 2 == 0)
                v3_store(coarse + 3 * (i / 2), q);
        }
        pnb_light many = {
            .type = PNB_LIGHT_POLYGON, .color = {1, 2, 3}, .shape.polygon = {fine, SIDES}};
        pnb_light fewer = {
            .type = PNB_LIGHT_POLYGON, .color = {1, 2, 3}, .shape.polygon = {coarse, SIDES / 2}};
        float pf[3], nf[3], e[3], a[3], b[3];
        v3_storef(pf, p);
        v3_storef(nf, n);
        /* The polygon's simplicity check is quadratic: only now and then. */
        if (round % 15)
            continue;
        assert_int_equal(pnb_light_irradiance(context, &d, pf, nf, 1, e), PNB_OK);
        assert_int_equal(pnb_light_irradiance(context, &many, pf, nf, 1, a), PNB_OK);
        assert_int_equal(pnb_light_irradiance(context, &fewer, pf, nf, 1, b), PNB_OK);
        double truth = a[2] + (a[2] - b[2]) / 3.0;
        if (fabs(e[2] - truth) > 2e-6 * truth + 1e-9)
            fail_msg("round %d: %.9g against %.9g", round, e[2], truth);
    }
}

static float one_irradiance(pnb_light light, vec3 p, vec3 n)
{
    float pf[3], nf[3], e[3];
    v3_storef(pf, p);
    v3_storef(nf, n);
    assert_int_equal(pnb_light_irradiance(context, &light, pf, nf, 1, e), PNB_OK);
    assert_true(e[0] >= 0 && isfinite(e[0]));
    return e[0];
}

static void irradiance_at_the_edges_of_its_range(void **state)
{
    pnb_light r = {.type = PNB_LIGHT_RECTANGLE,
                   .color = {1, 1, 1},
                   .shape.rectangle = {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}};
    vec3 up = v3(0, 1, 0), down = v3(0, -1, 0);
    /* An infinite plane sends pi; close under a large one nearly that. */
    assert_true(fabs(one_irradiance(r, v3(0, 0.9999, 0), up) - M_PI) < 1e-3);
    assert_true(one_irradiance(r, v3(0, 0, 0), down) == 0); /* turned away */
    assert_true(one_irradiance(r, v3(0, 2, 0), down) == 0); /* behind */
    assert_true(one_irradiance(r, v3(0, 1, 0), up) == 0);   /* on the light */
    assert_true(one_irradiance(r, v3(1, 1, 0), up) == 0);   /* on its edge */
    assert_true(one_irradiance(r, v3(5, 1, 0), up) == 0);   /* in its plane */
    /* Just below the plane, far to the side: small, and right to first order in the height. */
    double h = 1.0 / 1024, far = one_irradiance(r, v3(100, 1 - h, 0), v3(-1, 0, 0));
    assert_true(fabs(far - 4 * h / 1e6) < 1e-3 * 4 * h / 1e6);

    pnb_light d = {
        .type = PNB_LIGHT_DISK, .color = {1, 1, 1}, .shape.disk = {{0, 1, 0}, {0, -1, 0}, 2}};
    /* On the axis: pi R^2 / (R^2 + h^2); a wall below the rim sees half of the disk. */
    assert_true(fabs(one_irradiance(d, v3(0, 0, 0), up) - M_PI * 4 / 5) < 1e-6);
    assert_true(one_irradiance(d, v3(0, 1, 0), up) == 0);
    assert_true(one_irradiance(d, v3(2, 1, 0), up) == 0);
    assert_true(one_irradiance(d, v3(9, 1, 0), up) == 0);
    assert_true(one_irradiance(d, v3(0, 0, 0), down) == 0);
    double wall = one_irradiance(d, v3(0, 0, 0), v3(1, 0, 0));
    /* On the axis, n across it: atan(R/h) - (R/h) / (1 + (R/h)^2) */
    assert_true(fabs(wall - (atan(2.0) - 2.0 / 5)) < 1e-6);
    /* A tiny far disk is a point of intensity pi R^2 cos. */
    d.shape.disk.radius = 1e-5;
    double tiny = one_irradiance(d, v3(3, -3, 0), v3(0, 1, 0));
    assert_true(fabs(tiny / (M_PI * 1e-10 * 16 / 625) - 1) < 1e-6);

    pnb_light l = line();
    assert_true(one_irradiance(l, v3(-1, 3, 0.5), up) >= 0);
    assert_true(one_irradiance(l, v3(0.25, 3.5, 0.25), up) >= 0);
    /* Middle of a long line at distance h: 2 I / h. */
    l.shape.line.from[0] = -1e6;
    l.shape.line.from[1] = l.shape.line.to[1] = 2;
    l.shape.line.from[2] = l.shape.line.to[2] = 0;
    l.shape.line.to[0] = 1e6;
    assert_true(fabs(one_irradiance(l, v3(0, 0, 0), up) - 1) < 1e-6);
    /* On the line's prolongation only the along part is left: 1/a - 1/b. */
    l.shape.line.from[0] = 1;
    l.shape.line.to[0] = 4;
    assert_true(fabs(one_irradiance(l, v3(0, 2, 0), v3(1, 0, 0)) - 0.75) < 1e-6);

    pnb_light q = point();
    assert_true(fabs(one_irradiance(q, v3(0.3, 0, 0.1), up) - 0.25) < 1e-6);
    assert_true(one_irradiance(q, v3(0.3, 2, 0.1), up) == 0);

    float nothing[6] = {NAN, 0, 0, 0, 0, 0}, n[6] = {0, 1, 0, 0, 1, 0}, e[6] = {9, 9, 9, 9, 9, 9};
    assert_int_equal(pnb_light_irradiance(context, &q, nothing, n, 2, e), PNB_OK);
    assert_true(e[0] == 0 && e[1] == 0 && e[2] == 0 && e[3] > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_lights_are_refused),
        cmocka_unit_test(triangulation_keeps_the_area),
        cmocka_unit_test(areas_and_normals),
        cmocka_unit_test(owen_sobol_is_a_net),
        cmocka_unit_test(samples_cover_by_area),
        cmocka_unit_test(facing_agrees_with_samples),
        cmocka_unit_test(irradiance_agrees_with_brute_force),
        cmocka_unit_test(non_convex_polygon_is_the_sum_of_its_parts),
        cmocka_unit_test(cut_disks_to_six_digits),
        cmocka_unit_test(irradiance_at_the_edges_of_its_range),
    };
    return cmocka_run_group_tests(tests, setup, teardown);
}
