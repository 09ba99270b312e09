/* stress_exact.c: the method `exact` against its twin on many random scenes.
 *
 *   stress-exact [COUNT [FIRST [SAMPLES [LIGHT [AREA]]]]]
 *
 * LIGHT: of the lights' types that one alone, or any. AREA: exact-area; areas differ from the
 * twin's samples, so that with auto and on only receivers off by more than 5 % of the light count.
 * Fails when more than 0.1 % of the receivers differ by more than two samples in 1,024, or 0.01 %
 * by more than 5 % of the light: a point light that touches an occluder is all or nothing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "exact_twin.h"

int main(int argc, char **argv)
{
    long count = argc > 1 ? atol(argv[1]) : 10000, first = argc > 2 ? atol(argv[2]) : 0;
    int samples = argc > 3 ? atoi(argv[3]) : 256;
    const char *type = argc > 4 && strcmp(argv[4], "any") ? argv[4] : NULL;
    const char *area = argc > 5 ? argv[5] : "off";
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    size_t points = 0, partly = 0, off = 0, bad = 0;
    double edges = 0, loose = 0;
    double worst = 0;
    long worst_seed = 0;
    for (long seed = first; seed < first + count; seed++) {
        struct twin_case c;
        if (!twin_case_init(context, (uint64_t)seed, &c))
            return 1;
        if ((type && strcmp(pnb_light_type_name(c.light.type), type) != 0) ||
            pnb_light_check(context, &c.light) != PNB_OK) {
            twin_case_finish(&c);
            continue;
        }
        pnb_solver_param params[] = {{"exact-area", area}};
        pnb_solver_desc desc = {"exact", samples, params, 1};
        pnb_solver *solver;
        float visibility[TWIN_RECEIVERS];
        double truth[TWIN_RECEIVERS];
        if (pnb_solver_create(context, c.scene, &desc, &solver) != PNB_OK ||
            pnb_solver_visibility(solver, &c.light, &c.receivers, visibility) != PNB_OK) {
            fprintf(stderr, "seed %ld: %s\n", seed, pnb_context_error(context));
            return 1;
        }
        pnb_solver_report report;
        pnb_solver_get_report(solver, &report);
        for (size_t i = 0; i < report.counter_count; i++) {
            edges +=
                strcmp(report.counters[i].name, "edges_per_tile") ? 0 : report.counters[i].value;
            loose +=
                strcmp(report.counters[i].name, "loose_per_tile") ? 0 : report.counters[i].value;
        }
        pnb_solver_destroy(solver);
        twin_visibility(context, &c, samples, truth);
        for (size_t i = 0; i < c.receivers.count; i++) {
            double error = fabs(visibility[i] - truth[i]);
            points++;
            partly += truth[i] > 0 && truth[i] < 1;
            off += error > 2.01 / 1024 + 1e-6 && error > 1.01 / samples;
            if (!(error < 0.05)) {
                if (bad++ < 40)
                    printf("seed %ld receiver %zu: %g, truth %g (%s, %s)\n", seed, i, visibility[i],
                           truth[i], pnb_light_type_name(c.light.type), c.text);
            }
            if (!(error <= worst)) {
                worst = error;
                worst_seed = seed;
            }
        }
        twin_case_finish(&c);
    }
    printf("%.1f edges and %.1f loose triangles a tile; ", edges / (double)count,
           loose / (double)count);
    printf("%ld scenes, %zu receivers, %zu in penumbra: %.4f %% off by more than two samples in "
           "1,024, %zu by more "
           "than 0.05, worst %g (seed %ld)\n",
           count, points, partly, 100.0 * (double)off / (double)points, bad, worst, worst_seed);
    pnb_context_destroy(context);
    return (double)bad > 0.0001 * (double)points ||
           (strcmp(area, "off") == 0 && (double)off > 0.001 * (double)points);
}
