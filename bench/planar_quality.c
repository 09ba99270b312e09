/* bench/planar_quality.c: 'penumbra bench planar --quality': what the parameters of the ring mode
 * do to error, triangles and time.
 *
 * Four occluders under a square light of 1.4 m, 7 m above the ground: a box, a bumpy blob, a torus
 * knot's tube, two slabs. Error: RMSE of visibility over those of 256 x 256 points around the
 * shadow where the truth (reference, 1,024 rays) lies strictly between 0 and 1 or a method is off
 * by more than 1/255. Triangles and milliseconds (silhouettes to values, least of three) are means
 * over the four.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "planar_scenes.h"

enum { SIDE = 256, POINTS = SIDE * SIDE, SCENES = 4 };

struct subject {
    pnb_context *context;
    pnb_scene *scene;
    float *truth;
};

static float positions[3 * POINTS], normals[3 * POINTS], seen[POINTS];

static pnb_light square_light(void)
{
    return (pnb_light){.type = PNB_LIGHT_RECTANGLE,
                       .shape.rectangle = {{0.8, 7, 0.3}, {0.7, 0, 0}, {0, 0, 0.7}},
                       .color = {1, 1, 1}};
}

static const pnb_receivers receivers = {
    .count = POINTS, .positions = positions, .normals = normals};

static void prepare(struct subject *s, enum bench_shape shape)
{
    int rows = shape == BENCH_KNOT ? 500 : 100, columns = shape == BENCH_KNOT ? 10 : 50;
    pnb_solver *reference;
    pnb_light light = square_light();
    if (pnb_context_create(NULL, &s->context))
        exit(1);
    s->scene = bench_scene(s->context, shape, rows, columns);
    s->truth = malloc(POINTS * sizeof(*s->truth));
    if (pnb_solver_create(s->context, s->scene,
                          &(pnb_solver_desc){.method = "reference", .samples = 1024}, &reference) ||
        pnb_solver_visibility(reference, &light, &receivers, s->truth))
        bench_die(s->context);
    pnb_solver_destroy(reference);
}

static double counter(const pnb_solver_report *report, const char *name)
{
    for (size_t i = 0; i < report->counter_count; i++)
        if (strcmp(report->counters[i].name, name) == 0)
            return report->counters[i].value;
    return 0;
}

static void row(struct subject *subjects, const char *title, int samples, const char *text)
{
    /* "key=value key=value" */
    char copy[256];
    pnb_solver_param params[8];
    size_t count = 0;
    snprintf(copy, sizeof(copy), "%s", text);
    for (char *word = strtok(copy, " "); word; word = strtok(NULL, " ")) {
        char *equals = strchr(word, '=');
        *equals = 0;
        params[count++] = (pnb_solver_param){word, equals + 1};
    }
    pnb_solver_desc desc = {
        .method = "planar", .samples = samples, .params = params, .param_count = count};
    pnb_light light = square_light();
    double triangles = 0, ms = 0;
    printf("%-10s %3d %-28s", title, samples, text);
    for (int i = 0; i < SCENES; i++) {
        struct subject *s = &subjects[i];
        pnb_solver *solver;
        if (pnb_solver_create(s->context, s->scene, &desc, &solver))
            bench_die(s->context);
        double best = INFINITY;
        pnb_solver_report report;
        for (int round = 0; round < 3; round++) {
            if (pnb_solver_visibility(solver, &light, &receivers, seen))
                bench_die(s->context);
            pnb_solver_get_report(solver, &report);
            best = fmin(best, counter(&report, "silhouettes_ms") + counter(&report, "outlines_ms") +
                                  counter(&report, "rings_ms") + counter(&report, "fill_ms") +
                                  counter(&report, "values_ms"));
        }
        triangles += counter(&report, "triangles") / SCENES;
        ms += best / SCENES;
        double sum = 0;
        size_t n = 0;
        for (int k = 0; k < POINTS; k++) {
            double d = seen[k] - s->truth[k];
            if (isnan(d) || (!(s->truth[k] > 0 && s->truth[k] < 1) && fabs(d) <= 1 / 255.0))
                continue;
            sum += d * d;
            n++;
        }
        printf(" %6.4f", sqrt(sum / (double)(n ? n : 1)));
        pnb_solver_destroy(solver);
    }
    printf(" %9.0f %8.2f\n", triangles, ms);
    fflush(stdout);
}

void bench_planar_quality(void)
{
    static const enum bench_shape shapes[SCENES] = {BENCH_BOX, BENCH_BLOB, BENCH_KNOT, BENCH_SLABS};
    static const int counts[] = {3, 8, 16, 32, 64};
    static struct subject subjects[SCENES];
    for (int i = 0; i < POINTS; i++) {
        positions[3 * i] = (float)(2.6 * (2 * (i % SIDE + 0.5) / SIDE - 1) - 0.3);
        positions[3 * i + 2] = (float)(2.6 * (2 * (i / SIDE + 0.5) / SIDE - 1) - 0.1);
        normals[3 * i + 1] = 1;
    }
    for (int i = 0; i < SCENES; i++)
        prepare(&subjects[i], shapes[i]);
    printf("%-10s %3s %-28s %6s %6s %6s %6s %9s %8s\n", "", "K", "parameters", "box", "blob",
           "knot", "slabs", "triangles", "ms");
    for (int i = 0; i < 5; i++)
        row(subjects, "samples", counts[i], "");
    for (int i = 0; i < 4; i++)
        row(subjects, "samples", counts[i], "placement=border");
    static const struct {
        const char *title, *params;
    } choices[] = {
        {"fill", "fill=nearest"},
        {"fill", "fill=delaunay"},
        {"fill", "fill=sweep"},
        {"leaks", "mend=even"},
        {"leaks", "mend=triangles"},
        {"leaks", "mend=no"},
        {"crossings", "reconnect=0.25"},
        {"crossings", "reconnect=0.5"},
        {"crossings", "reconnect=1"},
        {"crossings", "reconnect=1 fill=delaunay"},
        {"join", "join=0.001"},
        {"join", "join=0.003"},
        {"join", "join=0.01"},
        {"join", "join=0.03"},
        {"join", "join=0.1"},
        {"coarser", "simplify=0.001"},
        {"coarser", "simplify=0.003"},
        {"coarser", "simplify=0.01"},
        {"coarser", "simplify=0.03"},
        {"coarser", "simplify=0.1"},
        {"coarser", "simplify=0.01 reconnect=1"},
        {"values", "intensity=exact"},
        {"values", "intensity=exact reconnect=0.5"},
    };
    for (size_t i = 0; i < sizeof(choices) / sizeof(choices[0]); i++)
        for (int k = 8; k <= 16; k += 8)
            row(subjects, choices[i].title, k, choices[i].params);
    for (int i = 0; i < SCENES; i++) {
        free(subjects[i].truth);
        pnb_scene_destroy(subjects[i].scene);
        pnb_context_destroy(subjects[i].context);
    }
}
