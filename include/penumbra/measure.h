/* measure.h: visibility against truth. */
#ifndef PENUMBRA_MEASURE_H
#define PENUMBRA_MEASURE_H

#include <penumbra/surface.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Errors are V minus truth. Counted are the points whose surface faces the whole light and whose
 * visibility is a number in both. "Penumbra" below: truth strictly between 0 and 1, or |error| >
 * 1/255. */
typedef struct pnb_errors {
    size_t pixels; /* counted points */
    size_t penumbra_pixels;
    double rmse;          /* over the penumbra */
    double mean_error;    /* signed, over the penumbra */
    double p99_error;     /* 99th percentile of |error| over the penumbra */
    double max_error;     /* largest |error| of all counted points */
    double umbra_leak;    /* share of truth = 0 points with V > 1/255 */
    double lit_darkening; /* share of truth = 1 points with V < 254/255 */
} pnb_errors;

/* mask: count bytes, 0 leaves a point out; NULL: all. */
PNB_API pnb_status pnb_measure(pnb_context *context, const float *visibility, const float *truth,
                               const uint8_t *mask, size_t count, pnb_errors *out_errors);

/* Which receivers face the whole light: every point of it above their tangent plane, and they on
 * its lit side. mask: receivers->count bytes, 0 or 1. */
PNB_API void pnb_measure_facing(const pnb_light *light, const pnb_receivers *receivers,
                                uint8_t *mask);

#ifdef __cplusplus
}
#endif
#endif
