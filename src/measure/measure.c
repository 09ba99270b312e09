/* measure/measure.c: the error figures of a visibility against the truth.
 *
 * Error = V - truth. One pass over the points that count (mask set, both values numbers), then the
 * 99th percentile by selection: O(n) expected, count floats of scratch memory. The sums are in
 * double and in index order: same input, same figures. A set without a penumbra, without umbra or
 * without lit points has 0 for the figures about it.
 *
 *   penumbra  truth strictly in (0, 1), or |error| > 1/255: what a method gets wrong on the floor
 *             counts, what everybody gets right there does not dilute the figure */
#include <penumbra/measure.h>

#include <math.h>
#include <string.h>

#include "base/base.h"
#include "light/light.h"

#define ONE_STEP (1.0 / 255)

/* The k-th smallest (from 0) of count values; reorders them. Quickselect by Hoare's partition with
 * the median of three; values are not NaN. */
static float select_smallest(float *values, size_t count, size_t k)
{
    size_t low = 0, high = count - 1;
    while (low < high) {
        float a = values[low], b = values[low + (high - low) / 2], c = values[high];
        float pivot = fmaxf(fminf(a, b), fminf(fmaxf(a, b), c));
        size_t i = low, j = high;
        for (;;) {
            while (values[i] < pivot)
                i++;
            while (values[j] > pivot)
                j--;
            if (i >= j)
                break;
            float swap = values[i];
            values[i++] = values[j];
            values[j--] = swap;
        }
        /* [low, j] <= pivot <= [j + 1, high]; where both met on the pivot, j is its place. */
        if (k <= j)
            high = j;
        else
            low = j + 1;
    }
    return values[k];
}

pnb_status pnb_measure(pnb_context *context, const float *visibility, const float *truth,
                       const uint8_t *mask, size_t count, pnb_errors *out_errors)
{
    memset(out_errors, 0, sizeof(*out_errors));
    if (count > 0 && (!visibility || !truth))
        return status_missing(context, "visibility or truth");
    float *sizes = memory_alloc(context, count, sizeof(*sizes));
    if (!sizes)
        return status_no_memory(context, count * sizeof(*sizes));

    size_t pixels = 0, penumbra = 0, umbra = 0, leaks = 0, lit = 0, darkened = 0;
    double sum = 0, squares = 0, largest = 0;
    for (size_t i = 0; i < count; i++) {
        double v = visibility[i], t = truth[i];
        if ((mask && !mask[i]) || !isfinite(v) || !isfinite(t))
            continue;
        double error = v - t, size = fabs(error);
        pixels++;
        largest = fmax(largest, size);
        if ((t > 0 && t < 1) || size > ONE_STEP) {
            sizes[penumbra++] = (float)size;
            sum += error;
            squares += error * error;
        }
        if (t == 0) {
            umbra++;
            leaks += v > ONE_STEP;
        } else if (t == 1) {
            lit++;
            darkened += v < 1 - ONE_STEP;
        }
    }
    out_errors->pixels = pixels;
    out_errors->penumbra_pixels = penumbra;
    out_errors->max_error = largest;
    if (penumbra) {
        out_errors->rmse = sqrt(squares / (double)penumbra);
        out_errors->mean_error = sum / (double)penumbra;
        /* Nearest rank: the smallest size that 99 in 100 do not exceed. */
        size_t rank = (penumbra * 99 + 99) / 100;
        out_errors->p99_error = select_smallest(sizes, penumbra, rank - 1);
    }
    if (umbra)
        out_errors->umbra_leak = (double)leaks / (double)umbra;
    if (lit)
        out_errors->lit_darkening = (double)darkened / (double)lit;
    memory_free(context, sizes);
    return PNB_OK;
}

void pnb_measure_facing(const pnb_light *light, const pnb_receivers *receivers, uint8_t *mask)
{
    memset(mask, 0, receivers->count);
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return;
    struct light_shape shape;
    if (light_shape_init(context, light, &shape) == PNB_OK) {
        for (size_t i = 0; i < receivers->count; i++) {
            vec3 p = v3_loadf(receivers->positions + 3 * i);
            vec3 n = v3_loadf(receivers->normals + 3 * i);
            mask[i] = v3_finite(p) && v3_finite(n) && light_shape_faces(&shape, p, n);
        }
        light_shape_finish(context, &shape);
    }
    pnb_context_destroy(context);
}
