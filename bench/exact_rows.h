/* bench/exact_rows.h: one scene under one light, measured with `exact` and with `reference`. */
#ifndef BENCH_EXACT_ROWS_H
#define BENCH_EXACT_ROWS_H

#include <penumbra/penumbra.h>

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif

struct options {
    int width, height, samples, truth_samples, truth_pixels, runs;
    bool json, curves;
    const char *scene;  /* only this one */
    const char *lights; /* only these labels, separated by commas */
};

struct row {
    char scene[64], light[16];
    size_t triangles, penumbra; /* penumbra: pixels that were compared with the truth */
    size_t apart;               /* pixels at which the two differ by more than 0.1 */
    bool closed;
    double exact_ms, reference_ms, prepare_ms, exact_rmse, reference_rmse, exact_p99;
    double speed, equal_speed;
    double values[PNB_COUNTER_MAX];
    char names[PNB_COUNTER_MAX][32];
    size_t counter_count;
};

/* A light over the scene, seen under so many degrees from the casters' middle. */
enum light_shape {
    SHAPE_OWN,
    SHAPE_SQUARE,
    SHAPE_DISK,
    SHAPE_L,
    SHAPE_LINE,
    SHAPE_SUN,
    SHAPE_POINT
};

struct light_desc {
    const char *label;
    enum light_shape shape;
    double degrees, turn; /* turn: about the vertical, of squares and lines */
};

/* Prints the context's error and ends the program. */
void bench_die(pnb_context *context);
/* path: a scene's, or builtin:NAME. Fills row; errors are those at o->truth_pixels penumbra pixels
 * against o->truth_samples rays. */
void bench_exact_row(pnb_context *context, const struct options *o, const char *path,
                     const struct light_desc *desc, struct row *row);
/* Errors under lights of all shapes, of all built-in scenes and the files given, as a table. */
int bench_exact_errors(pnb_context *context, const struct options *o, char **files, int file_count);

#endif
