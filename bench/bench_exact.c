/* bench/bench_exact.c: 'penumbra bench exact': time and error of `exact` against ray tracing.
 *
 * Per scene and light: one frame of `exact` (best of a few) and of `reference` at as many samples,
 * through the same public calls, and the errors of both against 65,536 rays on a random choice of
 * penumbra pixels that face the whole light. Frame times leave out what is made once per mesh.
 * At equal error: the reference's time is scaled to the number of samples that would bring it to
 * exact's error, by the slope that it has between 1,024 and 4,096 samples.
 *
 * Lights are horizontal squares over the scene that are seen under 12 (M) or 40 (L) degrees from
 * the casters' middle; r: turned by 30 degrees. Then a disk and an L-shaped polygon. --errors: the
 * errors alone, under all shapes of lights, on all built-in scenes and on files.
 */
#include "exact_rows.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double counter(const struct row *row, const char *name)
{
    for (size_t i = 0; i < row->counter_count; i++)
        if (strcmp(row->names[i], name) == 0)
            return row->values[i];
    return 0;
}

static void print_row(const struct options *o, const struct row *row, bool first)
{
    if (o->json) {
        printf(
            "%s\n  {\"scene\": \"%s\", \"light\": \"%s\", \"triangles\": %zu, \"exact_ms\": %.3f, "
            "\"reference_ms\": %.1f, \"prepare_ms\": %.1f, \"exact_rmse\": %.6f, "
            "\"exact_p99\": %.6f, \"reference_rmse\": %.6f, \"speed\": %.2f, "
            "\"speed_at_equal_error\": %.2f, \"lit\": %.0f, \"umbra\": %.0f, \"sampled\": %.0f, "
            "\"closed_form\": %.0f, \"edges_per_tile\": %.1f, \"loose_per_tile\": %.1f, "
            "\"bytes_per_triangle\": %.1f}",
            first ? "" : ",", row->scene, row->light, row->triangles, row->exact_ms,
            row->reference_ms, row->prepare_ms, row->exact_rmse, row->exact_p99,
            row->reference_rmse, row->speed, row->equal_speed, counter(row, "lit"),
            counter(row, "umbra"), counter(row, "sampled"), counter(row, "closed_form"),
            counter(row, "edges_per_tile"), counter(row, "loose_per_tile"),
            counter(row, "bytes_per_triangle"));
    } else {
        printf("| %s | %s | %zu | %.1f | %.0f | %.1f | %.1f | %.2f | %.2f | %.1f | %.0f |\n",
               row->scene, row->light, row->triangles, row->exact_ms, row->reference_ms, row->speed,
               row->equal_speed, 1e3 * row->exact_rmse, 1e3 * row->reference_rmse,
               1e3 * row->exact_p99, counter(row, "edges_per_tile"));
    }
    fflush(stdout);
}

static void print_head(const struct options *o)
{
    if (o->json)
        return;
    printf("\n| scene | light | triangles | exact ms | reference ms | times | at equal error | "
           "RMSE x 1e-3 | reference's | p99 x 1e-3 | edges a tile |\n"
           "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n");
}

static bool listed(const char *list, const char *word)
{
    size_t length = strlen(word);
    for (const char *c = list; c; c = strchr(c, ',') ? strchr(c, ',') + 1 : NULL)
        if (strncmp(c, word, length) == 0 && (c[length] == 0 || c[length] == ','))
            return true;
    return !list;
}

static int usage(void)
{
    printf("usage: penumbra bench exact [--json] [--size WxH] [--samples N] [--runs N]\n"
           "         [--truth N] [--pixels N] [--scene NAME]\n"
           "         [--lights LABEL,...] [--no-curves]\n"
           "       penumbra bench exact --errors [--size WxH] [--samples N] [--truth N]\n"
           "         [--pixels N] [FILE...]\n\n"
           "Time and error of the method exact against ray tracing, scene by scene. --errors: the\n"
           "errors under lights of all shapes, of all built-in scenes and the FILEs.\n");
    return 0;
}

int main(int argc, char **argv)
{
    struct options o = {800, 600, 1024, 65536, 1000, 3, false, true, NULL, NULL};
    const bool errors = argc > 1 && strcmp(argv[1], "--errors") == 0;
    int file_count = 0;
    if (errors)
        o.width = 160, o.height = 120, o.truth_samples = 16384, o.runs = 1;
    for (int i = errors ? 2 : 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : "";
        if (strcmp(argv[i], "--help") == 0)
            return usage();
        if (strcmp(argv[i], "--json") == 0)
            o.json = true;
        else if (strcmp(argv[i], "--no-curves") == 0)
            o.curves = false;
        else if (strcmp(argv[i], "--size") == 0 &&
                 sscanf(value, "%dx%d", &o.width, &o.height) == 2 && o.width > 0 && o.height > 0)
            i++;
        else if (strcmp(argv[i], "--samples") == 0 && (o.samples = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--runs") == 0 && (o.runs = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--truth") == 0 && (o.truth_samples = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--pixels") == 0 && (o.truth_pixels = atoi(value)) > 0)
            i++;
        else if (strcmp(argv[i], "--lights") == 0 && *value)
            o.lights = argv[++i];
        else if (strcmp(argv[i], "--scene") == 0 && *value)
            o.scene = argv[++i];
        else if (errors && argv[i][0] != '-')
            argv[file_count++] = argv[i]; /* the front of argv has been read */
        else {
            fprintf(stderr, "penumbra: error: %s: unknown option, see --help\n", argv[i]);
            return 2;
        }
    }
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    if (errors) {
        int status = bench_exact_errors(context, &o, argv, file_count);
        pnb_context_destroy(context);
        return status;
    }
    if (o.json)
        printf("{\"suite\": \"exact\", \"threads\": %d, \"samples\": %d, \"rows\": [",
               pnb_context_threads(context), o.samples);
    else
        printf("%d threads, %dx%d, %d samples, truth %d samples on %d penumbra pixels\n",
               pnb_context_threads(context), o.width, o.height, o.samples, o.truth_samples,
               o.truth_pixels);

    static const char *const scenes[] = {"prism",         "fence",         "spheres-9x9",
                                         "spheres-3x3x3", "spheres-9x9x9", "knot-96k",
                                         "knot-768k",     "leaves-20k"};
    static const struct light_desc lights[] = {
        {"M", SHAPE_SQUARE, 12, 0},          {"L", SHAPE_SQUARE, 40, 0},
        {"M r", SHAPE_SQUARE, 12, M_PI / 6}, {"L r", SHAPE_SQUARE, 40, M_PI / 6},
        {"disk 12", SHAPE_DISK, 12, 0},      {"L-shape 12", SHAPE_L, 12, 0}};
    double log_sum = 0, least = INFINITY, error_sum = 0, reference_sum = 0, leaves = INFINITY;
    double worst_rmse = 0, worst_p99 = 0;
    int closed = 0, rows = 0, printed = 0;
    struct row row;
    print_head(&o);
    for (size_t s = 0; s < sizeof(scenes) / sizeof(*scenes); s++)
        for (size_t l = 0; l < sizeof(lights) / sizeof(*lights); l++) {
            if ((o.scene && strcmp(o.scene, scenes[s]) != 0) || !listed(o.lights, lights[l].label))
                continue;
            char path[64];
            snprintf(path, sizeof(path), "builtin:%s", scenes[s]);
            bench_exact_row(context, &o, path, &lights[l], &row);
            print_row(&o, &row, printed++ == 0);
            worst_rmse = fmax(worst_rmse, row.exact_rmse);
            worst_p99 = fmax(worst_p99, row.exact_p99);
            if (row.exact_rmse > 0 && row.reference_rmse > 0) {
                error_sum += log(row.exact_rmse);
                reference_sum += log(row.reference_rmse);
                rows++;
            }
            if (row.closed) {
                log_sum += log(row.speed);
                least = fmin(least, row.speed);
                closed++;
            } else if (lights[l].degrees == 12) {
                leaves = fmin(leaves, row.speed);
            }
        }
    if (!o.json && printed > 0)
        printf(
            "\nclosed meshes: %.1f times in the geometric mean, least %.1f; leaves at 12 degrees "
            "%.1f; RMSE %.2f against %.2f x 1e-3 in the geometric mean, worst %.2f, p99 %.1f\n",
            exp(log_sum / fmax(closed, 1)), least, leaves, 1e3 * exp(error_sum / fmax(rows, 1)),
            1e3 * exp(reference_sum / fmax(rows, 1)), 1e3 * worst_rmse, 1e3 * worst_p99);

    if (o.curves && !o.scene) {
        static const char *const knots[] = {"builtin:knot", "builtin:knot-96k",
                                            "builtin:knot-768k"};
        static const double sizes[] = {3, 6, 12, 24, 40};
        if (!o.json)
            printf("\nOver the number of triangles, and over the light's size:\n");
        print_head(&o);
        for (size_t i = 0; i < 3; i++) {
            bench_exact_row(context, &o, knots[i], &(struct light_desc){"12", SHAPE_SQUARE, 12, 0},
                            &row);
            print_row(&o, &row, printed++ == 0);
        }
        for (size_t i = 0; i < 5; i++) {
            char label[16];
            snprintf(label, sizeof(label), "%g", sizes[i]);
            const struct light_desc light = {label, SHAPE_SQUARE, sizes[i], 0};
            bench_exact_row(context, &o, knots[1], &light, &row);
            print_row(&o, &row, printed++ == 0);
        }
    }
    if (o.json)
        printf(
            "\n],\n\"geometric_mean_closed\": %.2f, \"least_closed\": %.2f, \"least_leaves_12\": "
            "%.2f, \"worst_rmse\": %.6f, \"worst_p99\": %.6f}\n",
            exp(log_sum / fmax(closed, 1)), least, isfinite(leaves) ? leaves : 0, worst_rmse,
            worst_p99);
    pnb_context_destroy(context);
    return 0;
}
