/* The sweep: exact cases by hand, soups against ray casting and the validator, areas against GEOS.
 * PNB_FUZZ_SOUPS sets how many soups (default 3000). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <geos_c.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/planar.h>

#include "planar/planar.h"

static uint64_t random_state = 88172645463325252u;

static uint32_t random_bits(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 7;
    random_state ^= random_state << 17;
    return (uint32_t)(random_state >> 32);
}

static int32_t random_in(int32_t lo, int32_t hi)
{
    return lo + (int32_t)(random_bits() % (uint32_t)(hi - lo + 1));
}

struct fixture {
    pnb_context *context;
    struct planar_workspace *workspace;
    struct planar_input input;
};

static void begin(struct fixture *f)
{
    memset(f, 0, sizeof(*f));
    assert_int_equal(pnb_context_create(NULL, &f->context), PNB_OK);
    assert_int_equal(planar_workspace_create(f->context, &f->workspace), PNB_OK);
}

static void end(struct fixture *f)
{
    planar_input_finish(f->context, &f->input);
    planar_workspace_destroy(f->workspace);
    pnb_context_destroy(f->context);
}

static void add_loop(struct fixture *f, const struct planar_point *p, size_t n, int weight)
{
    struct planar_input *in = &f->input;
    assert_int_equal(planar_input_reserve(f->context, in, n, n), PNB_OK);
    for (size_t i = 0; i < n; i++) {
        in->segments[in->segment_count++] = (struct planar_segment){
            (uint32_t)(in->point_count + i), (uint32_t)(in->point_count + (i + 1) % n), weight};
    }
    for (size_t i = 0; i < n; i++)
        in->points[in->point_count + i] = p[i];
    in->point_count += n;
}

/* Clockwise: inside on the right. */
static void add_box(struct fixture *f, int32_t x0, int32_t y0, int32_t x1, int32_t y1)
{
    struct planar_point p[4] = {{x0, y0}, {x0, y1}, {x1, y1}, {x1, y0}};
    add_loop(f, p, 4, 1);
}

static const struct planar_options fill_all = {
    .triangulate = true, .trapezoids = true, .min_level = 1, .max_level = INT32_MAX};

static struct planar_result sweep(struct fixture *f, const struct planar_options *options)
{
    struct planar_result r;
    pnb_status status = planar_sweep(f->workspace, f->input.points, f->input.point_count,
                                     f->input.segments, f->input.segment_count, options, &r);
    if (status)
        fail_msg("%s", pnb_context_error(f->context));
    const char *wrong = planar_validate(&r, options);
    if (wrong) {
        FILE *file = fopen("planar-wrong.svg", "w");
        char *svg = planar_draw_svg(f->context, &r);
        if (file && svg)
            fputs(svg, file);
        if (file)
            fclose(file);
        memory_free(f->context, svg);
        fail_msg("%s", wrong);
    }
    return r;
}

/* The slow, obvious twin: winding number by a ray to the right. */
static int winding_by_ray(const struct planar_input *in, double x, double y)
{
    int winding = 0;
    for (size_t i = 0; i < in->segment_count; i++) {
        struct planar_point a = in->points[in->segments[i].a], b = in->points[in->segments[i].b];
        if ((a.y > y) == (b.y > y))
            continue;
        double at = a.x + (y - a.y) / ((double)b.y - a.y) * ((double)b.x - a.x);
        if (at > x) /* upwards: the right side is to the right: leaving x for it loses */
            winding += b.y > a.y ? -in->segments[i].weight : in->segments[i].weight;
    }
    return winding;
}

static double distance_to(const struct planar_input *in, double x, double y)
{
    double best = 1e30;
    for (size_t i = 0; i < in->segment_count; i++) {
        struct planar_point a = in->points[in->segments[i].a], b = in->points[in->segments[i].b];
        double dx = (double)b.x - a.x, dy = (double)b.y - a.y, n = dx * dx + dy * dy;
        double t = n > 0 ? ((x - a.x) * dx + (y - a.y) * dy) / n : 0;
        t = t < 0 ? 0 : t > 1 ? 1 : t;
        best = fmin(best, hypot(a.x + t * dx - x, a.y + t * dy - y));
    }
    return best;
}

static double area_of_level(const struct planar_result *r, int level)
{
    double sum = 0;
    for (size_t i = 0; i < r->edge_count; i++) {
        const struct planar_edge *e = &r->edges[i];
        int way = (e->below >= level) - (e->above >= level);
        struct planar_point a = r->points[e->left], b = r->points[e->right];
        sum -= way * 0.5 * ((double)a.x * b.y - (double)a.y * b.x);
    }
    return sum;
}

static double area_of_trapezoids(const struct planar_result *r)
{
    double sum = 0;
    for (size_t i = 0; i < r->trapezoid_count; i++) {
        const struct planar_trapezoid *t = &r->trapezoids[i];
        double y[2][2];
        for (int k = 0; k < 2; k++) {
            const struct planar_edge *e = &r->edges[k ? t->upper : t->lower];
            struct planar_point a = r->points[e->left], b = r->points[e->right];
            double slope = ((double)b.y - a.y) / ((double)b.x - a.x);
            y[k][0] = a.y + slope * ((double)t->x0 - a.x);
            y[k][1] = a.y + slope * ((double)t->x1 - a.x);
        }
        sum += 0.5 * ((double)t->x1 - t->x0) * (y[1][0] - y[0][0] + y[1][1] - y[0][1]);
    }
    return sum;
}

static void two_boxes_that_overlap(void **state)
{
    struct fixture f;
    begin(&f);
    add_box(&f, 0, 0, 10, 10);
    add_box(&f, 5, 5, 15, 15);
    struct planar_result r = sweep(&f, &fill_all);
    assert_int_equal(r.point_count, 10);
    assert_int_equal(r.edge_count, 12);
    assert_int_equal(r.crossing_count, 2);
    assert_true(area_of_level(&r, 1) == 175);
    assert_true(area_of_level(&r, 2) == 25);
    assert_true(area_of_level(&r, 3) == 0);
    assert_true(fabs(area_of_trapezoids(&r) - 175) < 1e-9);
    struct planar_chains rings;
    assert_int_equal(planar_rings(f.workspace, &r, 1, &rings), PNB_OK);
    assert_int_equal(rings.chain_count, 1);
    assert_int_equal(rings.starts[1], 8);
    planar_chains_finish(f.context, &rings);
    end(&f);
}

static void coincident_edges_add_up(void **state)
{
    struct fixture f;
    begin(&f);
    for (int i = 0; i < 5; i++)
        add_box(&f, 0, 0, 100, 100);
    add_box(&f, 0, 0, 100, 50); /* shares three sides, one of them a part */
    add_box(&f, 100, 0, 200, 100);
    struct planar_result r = sweep(&f, &fill_all);
    assert_true(area_of_level(&r, 1) == 20000);
    assert_true(area_of_level(&r, 5) == 10000);
    assert_true(area_of_level(&r, 6) == 5000);
    assert_true(fabs(area_of_trapezoids(&r) - 20000) < 1e-9);
    end(&f);
}

static void holes_are_kept_and_touching_rings_part(void **state)
{
    struct fixture f;
    begin(&f);
    add_box(&f, 0, 0, 100, 100);
    struct planar_point hole[4] = {{10, 10}, {20, 10}, {20, 20}, {10, 20}};
    add_loop(&f, hole, 4, 1); /* the other way round: takes one away */
    add_box(&f, 100, 100, 120, 120);
    struct planar_result r = sweep(&f, &fill_all);
    assert_true(area_of_level(&r, 1) == 10000 - 100 + 400);
    struct planar_chains rings;
    assert_int_equal(planar_rings(f.workspace, &r, 1, &rings), PNB_OK);
    assert_int_equal(rings.chain_count, 3);
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(rings.starts[i + 1] - rings.starts[i], 4);
    planar_chains_finish(f.context, &rings);
    end(&f);
}

/* The paper's Figure 4 on two boxes: both crossings part, the notches fill up by what the tips
 * lose.
 */
static void crossings_part_into_lines_of_one_density(void **state)
{
    for (int way = 0; way < 2; way++) {
        double share = way ? 1 : 0.5;
        struct fixture f;
        begin(&f);
        add_box(&f, 0, 0, 1000, 1000);
        add_box(&f, 500, 500, 1500, 1500);
        struct planar_result r = sweep(&f, NULL);
        struct planar_input parted = {0}, given = f.input;
        size_t count;
        assert_int_equal(planar_reconnect(f.workspace, &r, share, &parted, &count), PNB_OK);
        assert_int_equal(count, 2);
        f.input = parted;
        r = sweep(&f, &fill_all);
        assert_int_equal(r.crossing_count, 0);
        double triangle = 0.5 * (share * 500) * (share * 500);
        assert_true(area_of_level(&r, 1) == 1750000 + 2 * triangle);
        assert_true(area_of_level(&r, 2) == 250000 - 2 * triangle);
        assert_true(area_of_level(&r, 3) == 0);
        assert_int_equal(planar_reconnect(f.workspace, &r, share, &given, &count), PNB_OK);
        assert_int_equal(count, 0);
        planar_input_finish(f.context, &given);
        end(&f);
    }
}

static void nothing_is_fine(void **state)
{
    struct fixture f;
    begin(&f);
    struct planar_result r = sweep(&f, &fill_all);
    assert_int_equal(r.edge_count, 0);
    struct planar_point line[2] = {{0, 0}, {10, 10}};
    add_loop(&f, line, 2, 1); /* there and back */
    struct planar_point dot[3] = {{5, 0}, {5, 0}, {5, 0}};
    add_loop(&f, dot, 3, 1);
    r = sweep(&f, &fill_all);
    assert_int_equal(r.edge_count, 0);
    end(&f);
}

static void bad_input_is_refused(void **state)
{
    struct fixture f;
    begin(&f);
    struct planar_result r;
    struct planar_point p[3] = {{0, 0}, {10, 0}, {PLANAR_LIMIT + 1, 3}};
    struct planar_segment open = {0, 1, 1}, far = {0, 7, 1};
    assert_int_equal(planar_sweep(f.workspace, p, 2, &open, 1, NULL, &r), PNB_ERROR_ARGUMENT);
    assert_non_null(strstr(pnb_context_error(f.context), "do not close"));
    assert_int_equal(planar_sweep(f.workspace, p, 2, &far, 1, NULL, &r), PNB_ERROR_ARGUMENT);
    assert_int_equal(planar_sweep(f.workspace, p, 3, &open, 1, NULL, &r), PNB_ERROR_ARGUMENT);
    end(&f);
}

/* Strips cover the same faces as the sweep's triangles; those at corners lie in nothing. */
static void strips_tile(struct fixture *f, struct planar_workspace *spare, size_t *filled)
{
    static const struct planar_options usual = {
        .triangulate = true, .min_level = 1, .max_level = INT32_MAX};
    struct planar_result r = sweep(f, NULL);
    uint8_t *corners = malloc(r.point_count + 1);
    float *values = malloc((r.point_count + 1) * sizeof(*values));
    for (size_t i = 0; i < r.point_count; i++) {
        corners[i] = random_bits() % 2;
        values[i] = (float)(random_bits() % 3);
    }
    struct planar_strips how = {.even_from = 1 + (int32_t)(random_bits() % 5), .values = values};
    if (planar_strips(f->workspace, spare, &how, &r)) {
        const char *wrong = planar_validate(&r, &usual);
        if (wrong)
            fail_msg("strips: %s", wrong);
        *filled += r.triangle_count;
    }
    r = sweep(f, NULL);
    how.corners = corners;
    if (planar_strips(f->workspace, spare, &how, &r))
        for (size_t i = 0; i < r.triangle_count; i++) {
            const struct planar_triangle *t = &r.triangles[i];
            double x = 0, y = 0;
            for (int k = 0; k < 3; k++) {
                x += r.points[t->v[k]].x / 3.0;
                y += r.points[t->v[k]].y / 3.0;
            }
            if (t->level == 0 && distance_to(&f->input, x, y) >= 4)
                assert_int_equal(winding_by_ray(&f->input, x, y), 0);
        }
    free(corners);
    free(values);
}

static void soups_agree_with_ray_casting(void **state)
{
    const char *wanted = getenv("PNB_FUZZ_SOUPS");
    long soups = wanted ? atol(wanted) : 3000, snapped = 0, checked = 0;
    size_t filled = 0;
    struct fixture f;
    struct planar_workspace *spare;
    begin(&f);
    assert_int_equal(planar_workspace_create(f.context, &spare), PNB_OK);
    static const int32_t ranges[] = {3, 6, 12, 40, 1000, 100000, PLANAR_LIMIT - 2};
    for (long soup = 0; soup < soups; soup++) {
        f.input.point_count = f.input.segment_count = 0;
        if (soup % 2 == 0) { /* memory that has to grow on the way */
            planar_workspace_destroy(f.workspace);
            assert_int_equal(planar_workspace_create(f.context, &f.workspace), PNB_OK);
        }
        int32_t range = ranges[random_bits() % 7];
        size_t loops = 1 + random_bits() % 6;
        if (soup % 100 == 0)
            loops = 60;
        for (size_t k = 0; k < loops; k++) {
            struct planar_point p[40];
            size_t n = 2 + random_bits() % (loops < 3 ? 30 : 10);
            if (random_bits() % 4 == 0) { /* thin things in nearly one direction */
                for (size_t i = 0; i < n; i++) {
                    int32_t x = random_in(-range, range);
                    p[i] = (struct planar_point){x, x / 3 + random_in(-1, 1)};
                }
            } else {
                for (size_t i = 0; i < n; i++)
                    p[i] =
                        (struct planar_point){random_in(-range, range), random_in(-range, range)};
            }
            add_loop(&f, p, n, random_in(-2, 2));
        }
        struct planar_options options = {.triangulate = true,
                                         .trapezoids = true,
                                         .min_level = -100,
                                         .max_level = 100,
                                         .base = 0};
        bool frame = random_bits() % 2;
        if (frame) {
            add_box(&f, -range - 2, -range - 2, range + 2, range + 2);
            options.base = -50;
            for (size_t k = f.input.segment_count - 4; k < f.input.segment_count; k++)
                f.input.segments[k].weight = 50;
        }
        struct planar_result r = sweep(&f, &options);
        snapped += r.snapped;
        for (int k = 0; k < 3; k++) {
            const enum planar_rule rules[] = {PLANAR_RULE_NEAREST, PLANAR_RULE_DELAUNAY,
                                              PLANAR_RULE_SWEEP};
            for (size_t i = 0; i < 40 && i < r.triangle_count; i++) {
                const struct planar_triangle *t =
                    &r.triangles[r.triangle_count < 40 ? i : random_bits() % r.triangle_count];
                double x = 0, y = 0;
                for (int c = 0; c < 3; c++) {
                    x += r.points[t->v[c]].x / 3.0;
                    y += r.points[t->v[c]].y / 3.0;
                }
                /* Rounding bends an edge by up to 1.5 units per crossing; bends in a row add up. */
                if (distance_to(&f.input, x, y) < 4)
                    continue;
                assert_int_equal(t->level, winding_by_ray(&f.input, x, y) + options.base);
                checked++;
            }
            planar_improve(f.workspace, &r, &(struct planar_improve){.rule = rules[k]});
            assert_null(planar_validate(&r, &options));
        }
        /* Every ring's chains close and enclose what the level's area says. */
        int32_t level = options.base + 1 + (int32_t)(random_bits() % 3);
        struct planar_chains rings;
        assert_int_equal(planar_rings(f.workspace, &r, level, &rings), PNB_OK);
        double area = 0;
        for (size_t k = 0; k < rings.chain_count; k++)
            for (uint32_t i = rings.starts[k]; i < rings.starts[k + 1]; i++) {
                uint32_t next = i + 1 < rings.starts[k + 1] ? i + 1 : rings.starts[k];
                struct planar_point a = r.points[rings.points[i]], b = r.points[rings.points[next]];
                area -= 0.5 * ((double)a.x * b.y - (double)a.y * b.x);
            }
        assert_true(fabs(area - area_of_level(&r, level)) <= 1e-9 * (double)range * range + 1e-9);
        planar_chains_finish(f.context, &rings);
        if (!frame)
            strips_tile(&f, spare, &filled);
        /* Without trapezoids usual points take shorter ways; and an outline alone. */
        options.trapezoids = false;
        r = sweep(&f, &options);
        double whole = area_of_level(&r, 1);
        bool careful = r.snapped;
        options = (struct planar_options){.base = options.base, .threshold = 1};
        r = sweep(&f, &options);
        if (r.snapped == careful)
            assert_true(fabs(area_of_level(&r, 1) - whole) <= 1e-9 * (double)range * range + 1e-9);
    }
    planar_workspace_destroy(spare);
    print_message("%ld soups, %ld points checked, %ld soups took the careful way, %zu triangles of "
                  "strips\n",
                  soups, checked, snapped, filled);
    end(&f);
}

/* Random star-shaped polygons; levels from GEOS by adding one polygon after the other. */
static GEOSGeometry *geos_polygon(GEOSContextHandle_t g, const struct planar_point *p, size_t n)
{
    GEOSCoordSequence *s = GEOSCoordSeq_create_r(g, (unsigned)n + 1, 2);
    for (size_t i = 0; i <= n; i++)
        GEOSCoordSeq_setXY_r(g, s, (unsigned)i, p[i % n].x, p[i % n].y);
    return GEOSGeom_createPolygon_r(g, GEOSGeom_createLinearRing_r(g, s), NULL, 0);
}

static void areas_of_levels_equal_those_of_geos(void **state)
{
    GEOSContextHandle_t g = GEOS_init_r();
    struct fixture f;
    begin(&f);
    double worst = 0;
    for (int round = 0; round < 30; round++) {
        enum { count = 5, corners = 60 };
        f.input.point_count = f.input.segment_count = 0;
        GEOSGeometry *level[count + 1] = {0}; /* level[i]: covered at least i times */
        for (int k = 0; k < count; k++) {
            struct planar_point p[corners];
            double cx = random_in(-1000000, 1000000) * 100.0,
                   cy = random_in(-1000000, 1000000) * 100.0;
            for (int i = 0; i < corners; i++) {
                double angle = -2 * 3.14159265358979 * i / corners; /* clockwise */
                double radius = 1e8 * (1 + 0.5 * random_in(0, 1000) / 1000.0);
                p[i] = (struct planar_point){(int32_t)(cx + radius * cos(angle)),
                                             (int32_t)(cy + radius * sin(angle))};
            }
            add_loop(&f, p, corners, 1);
            GEOSGeometry *polygon = geos_polygon(g, p, corners);
            for (int i = k + 1; i >= 1; i--) {
                GEOSGeometry *more = i == 1 ? GEOSGeom_clone_r(g, polygon)
                                            : GEOSIntersection_r(g, level[i - 1], polygon);
                if (level[i]) {
                    GEOSGeometry *sum = GEOSUnion_r(g, level[i], more);
                    GEOSGeom_destroy_r(g, level[i]);
                    GEOSGeom_destroy_r(g, more);
                    more = sum;
                }
                level[i] = more;
            }
            GEOSGeom_destroy_r(g, polygon);
        }
        struct planar_result r = sweep(&f, &fill_all);
        for (int i = 1; i <= count; i++) {
            double area = 0;
            GEOSArea_r(g, level[i], &area);
            GEOSGeom_destroy_r(g, level[i]);
            double error = fabs(area_of_level(&r, i) - area) / (area + 1e10);
            worst = fmax(worst, error);
        }
        assert_true(fabs(area_of_trapezoids(&r) / area_of_level(&r, 1) - 1) < 1e-9);
    }
    print_message("levels against GEOS: worst relative difference %.2g\n", worst);
    assert_true(worst < 1e-6);
    end(&f);
    GEOS_finish_r(g);
}

static void careful_way_agrees(void **state)
{
    struct fixture f;
    begin(&f);
    for (int round = 0; round < 300; round++) {
        f.input.point_count = f.input.segment_count = 0;
        int32_t range = round % 2 ? 30 : 1 << 28;
        for (int k = 0; k < 3; k++) {
            struct planar_point p[12];
            for (int i = 0; i < 12; i++)
                p[i] = (struct planar_point){random_in(-range, range), random_in(-range, range)};
            add_loop(&f, p, 12, 1);
        }
        struct planar_input given = f.input, snapped;
        assert_int_equal(planar_snap(f.context, &given, &snapped), PNB_OK);
        f.input = snapped;
        struct planar_result r = sweep(&f, &fill_all);
        assert_int_equal(r.crossing_count, 0);
        assert_false(r.snapped);
        planar_input_finish(f.context, &snapped);
        f.input = given;
    }
    end(&f);
}

/* Through the public door: a square with a square hole and a diamond on top, in doubles. */
static void the_public_door(void **state)
{
    pnb_context *context;
    pnb_planar *planar;
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    assert_int_equal(pnb_planar_create(context, &planar), PNB_OK);
    const double points[] = {0,    0,    0,    1,    1,    1,    1,    0,    /* clockwise */
                             0.25, 0.25, 0.75, 0.25, 0.75, 0.75, 0.25, 0.75, /* the hole */
                             0.5,  1.5,  1,    1,    0.5,  0.5,  0,    1};
    uint32_t edges[24];
    for (uint32_t i = 0; i < 12; i++) {
        edges[2 * i] = i;
        edges[2 * i + 1] = i % 4 == 3 ? i - 3 : i + 1;
    }
    pnb_planar_desc desc = {.points = points, .point_count = 12, .edges = edges, .edge_count = 12};
    const double areas[] = {1 - 0.25 + 0.25 + 1.0 / 16, 0.25 - 1.0 / 16};
    for (int fill = PNB_PLANAR_FILL_NONE; fill <= PNB_PLANAR_FILL_TRAPEZOIDS; fill++) {
        desc.fill = (pnb_planar_fill)fill;
        if (pnb_planar_sweep(planar, &desc))
            fail_msg("%s", pnb_context_error(context));
        pnb_planar_view view;
        pnb_planar_get(planar, &view);
        double area = 0;
        for (size_t i = 0; i < view.triangle_count; i++) {
            const double *a = view.points + 2 * view.triangles[3 * i],
                         *b = view.points + 2 * view.triangles[3 * i + 1],
                         *c = view.points + 2 * view.triangles[3 * i + 2];
            area += 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        }
        for (size_t i = 0; i < view.trapezoid_count; i++) {
            const pnb_planar_trapezoid *t = &view.trapezoids[i];
            area += 0.5 * (t->x[1] - t->x[0]) * (t->y1[0] - t->y0[0] + t->y1[1] - t->y0[1]);
        }
        assert_true(fabs(area - (fill ? areas[0] : 0)) < 1e-8);
        for (int level = 1; level <= 2; level++) {
            const uint32_t *at, *starts;
            size_t count;
            assert_int_equal(pnb_planar_chains(planar, level, &at, &starts, &count), PNB_OK);
            double sum = 0;
            for (size_t k = 0; k < count; k++)
                for (uint32_t i = starts[k]; i < starts[k + 1]; i++) {
                    const double *a = view.points + 2 * at[i];
                    const double *b =
                        view.points + 2 * at[i + 1 < starts[k + 1] ? i + 1 : starts[k]];
                    sum -= 0.5 * (a[0] * b[1] - a[1] * b[0]);
                }
            assert_true(fabs(sum - areas[level - 1]) < 1e-8);
        }
    }
    desc.edge_count = 11;
    assert_int_equal(pnb_planar_sweep(planar, &desc), PNB_ERROR_ARGUMENT);
    pnb_planar_destroy(planar);
    pnb_context_destroy(context);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_boxes_that_overlap),
        cmocka_unit_test(coincident_edges_add_up),
        cmocka_unit_test(holes_are_kept_and_touching_rings_part),
        cmocka_unit_test(crossings_part_into_lines_of_one_density),
        cmocka_unit_test(nothing_is_fine),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(the_public_door),
        cmocka_unit_test(careful_way_agrees),
        cmocka_unit_test(soups_agree_with_ray_casting),
        cmocka_unit_test(areas_of_levels_equal_those_of_geos),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
