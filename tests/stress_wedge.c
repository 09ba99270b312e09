/* stress_wedge.c: many random scenes for the wedges: stress-wedge COUNT [FIRST]. */
#include <stdio.h>
#include <stdlib.h>

#include "wedge_random.h"

int main(int argc, char **argv)
{
    unsigned long count = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000;
    unsigned long first = argc > 2 ? strtoul(argv[2], NULL, 10) : 0, bad = 0;
    double sums[3] = {0};
    pnb_context *context;
    if (pnb_context_create(NULL, &context) != PNB_OK)
        return 1;
    for (unsigned long seed = first; seed < first + count; seed++) {
        struct wedge_random_result result;
        pnb_status status = wedge_random_run(context, seed, &result);
        if (status == PNB_ERROR_DEVICE) {
            printf("SKIP: %s\n", pnb_context_error(context));
            return 77;
        }
        for (int m = 0; m < 3; m++)
            sums[m] += result.rmse[m];
        if (status != PNB_OK || result.what) {
            printf("seed %lu: %s (rmse %.4f %.4f %.4f, %zu gross of %zu, streak %d)\n", seed,
                   result.what ? result.what : pnb_context_error(context), result.rmse[0],
                   result.rmse[1], result.rmse[2], result.gross, result.pixels, result.streak);
            bad++;
        }
    }
    printf("%lu scenes, %lu bad; mean rmse: wedge %.4f, wedge-probabilistic %.4f, wedge-blend "
           "%.4f\n",
           count, bad, sums[0] / (double)count, sums[1] / (double)count, sums[2] / (double)count);
    pnb_context_destroy(context);
    return bad > 0;
}
