/* bench/exact_errors.c: 'penumbra bench exact --errors': errors under lights of all shapes, the
 * scene's own among them, as RMSE and 99th percentile in thousandths. Under a point light, which is
 * all or nothing, only pixels that differ from the traced ones count. */
#include "exact_rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct light_desc lights[] = {
    {"own", SHAPE_OWN, 0, 0},
    {"rectangle 12", SHAPE_SQUARE, 12, 0},
    {"rectangle 40, turned", SHAPE_SQUARE, 40, M_PI / 6},
    {"disk 12", SHAPE_DISK, 12, 0},
    {"L-shape 12", SHAPE_L, 12, 0},
    {"line 12, turned", SHAPE_LINE, 12, M_PI / 6},
    {"sun 6", SHAPE_SUN, 6, 0},
    {"point", SHAPE_POINT, 0, 0},
};
#define LIGHTS (sizeof(lights) / sizeof(*lights))

struct sums {
    double exact, reference, worst_rmse, worst_p99;
    size_t rows, apart;
};

static void take(const struct row *row, struct sums *sums)
{
    sums->apart += row->apart;
    if (row->exact_rmse > 0 && row->reference_rmse > 0) {
        sums->exact += log(row->exact_rmse);
        sums->reference += log(row->reference_rmse);
        sums->rows++;
    }
    sums->worst_rmse = fmax(sums->worst_rmse, row->exact_rmse);
    sums->worst_p99 = fmax(sums->worst_p99, row->exact_p99);
}

static double mean(double logs, size_t count)
{
    return count > 0 ? 1e3 * exp(logs / (double)count) : 0;
}

static void print_scene(pnb_context *context, const struct options *o, const char *path,
                        struct sums sums[LIGHTS])
{
    struct row row;
    size_t apart = 0;
    for (size_t l = 0; l < LIGHTS; l++) {
        bench_exact_row(context, o, path, &lights[l], &row);
        take(&row, &sums[l]);
        apart += row.apart;
        if (l == 0)
            printf("| %s | %zu |", row.scene, row.triangles);
        if (lights[l].shape == SHAPE_POINT)
            printf(" %zu |", apart);
        else if (row.penumbra == 0)
            printf(" - |");
        else
            printf(" %.2f, %.1f |", 1e3 * row.exact_rmse, 1e3 * row.exact_p99);
        fflush(stdout);
    }
    printf("\n");
}

int bench_exact_errors(pnb_context *context, const struct options *o, char **files, int file_count)
{
    struct sums sums[LIGHTS] = {0};
    printf("RMSE and 99th percentile x 1e-3, %dx%d, %d samples, truth %d samples on %d penumbra "
           "pixels; the last column: pixels off by more than 0.1 from as many rays\n\n"
           "| scene | triangles |",
           o->width, o->height, o->samples, o->truth_samples, o->truth_pixels);
    for (size_t l = 0; l + 1 < LIGHTS; l++)
        printf(" %s |", lights[l].label);
    printf(" off |\n| --- | --- |");
    for (size_t l = 0; l < LIGHTS; l++)
        printf(" --- |");
    printf("\n");
    for (size_t i = 0; i < pnb_builtin_count(); i++) {
        char path[80];
        pnb_builtin_info info;
        pnb_builtin(i, &info);
        snprintf(path, sizeof(path), "builtin:%s", info.name);
        print_scene(context, o, path, sums);
    }
    for (int i = 0; i < file_count; i++)
        print_scene(context, o, files[i], sums);
    printf("\n| light | RMSE, mean | reference's | worst RMSE | worst p99 | off |\n"
           "| --- | --- | --- | --- | --- | --- |\n");
    for (size_t l = 0; l < LIGHTS; l++)
        printf("| %s | %.2f | %.2f | %.2f | %.1f | %zu |\n", lights[l].label,
               mean(sums[l].exact, sums[l].rows), mean(sums[l].reference, sums[l].rows),
               1e3 * sums[l].worst_rmse, 1e3 * sums[l].worst_p99, sums[l].apart);
    return 0;
}
