/* method/exact/exact_kernel_avx512.c: the inner loops, sixteen wide. */
#include <immintrin.h>

#include "method/exact/exact.h"

#define WIDTH          16
#define KERNEL         exact_kernel_avx512
#define KERNEL_NAME    "avx512"
#define lanes_of(mask) ((unsigned)_mm512_movepi32_mask((__m512i)(mask)))
#define clamp(x, high)                                                                             \
    ((vf)_mm512_min_ps(_mm512_max_ps((__m512)(x), _mm512_setzero_ps()), _mm512_set1_ps(high)))

/* exact_cover_resolve() for 32 rows at once, with masks instead of selections. */
#define HAVE_RESOLVE
static double kernel_resolve(const struct exact_cover *cover)
{
    const struct exact_grid *grid = cover->grid;
    const __m512i zero = _mm512_setzero_si512();
    const __m512i unit = _mm512_set1_epi16((short)cover->unit);
    const __m512i low = _mm512_set1_epi16(-256), high = _mm512_set1_epi16(256);
    /* How far rest is shifted for a change of 0 to 31. */
    int16_t shifts[32];
    for (int n = 0; n < 32; n++)
        shifts[n] = (int16_t)(n == 0 ? cover->unit - 1 : n == 1 ? 0 : n == 2 ? 1 : n <= 4 ? 2 : 3);
    const __m512i table = _mm512_loadu_si512(shifts), last = _mm512_set1_epi16(31);
    double total = 0;
    for (int row = 0; row < grid->rows; row += 32) {
        __m512i count = _mm512_loadu_si512(cover->cover + row), sum = zero;
        __mmask32 seen = _mm512_cmple_epi16_mask(count, zero);
        for (int k = 1; k <= grid->bins + 1; k++) {
            int at = k * grid->stride + row, cell = at - grid->stride;
            __m512i change = _mm512_loadu_si512(cover->cover + at);
            __m512i next = _mm512_add_epi16(count, change);
            __mmask32 seen_next = _mm512_cmple_epi16_mask(next, zero);
            if (k <= grid->bins)
                sum = _mm512_mask_add_epi16(sum, seen_next, sum,
                                            _mm512_loadu_si512(grid->weight + cell));
            if (cover->rest) {
                __m512i rest = _mm512_loadu_si512(cover->rest + at);
                __mmask32 none = _mm512_testn_epi16_mask(change, change);
                __mmask32 gap = _mm512_mask_cmpeq_epi16_mask(
                    _mm512_mask_cmpgt_epi16_mask(none, rest, zero), count, unit);
                __mmask32 moved = (seen & (none | ~seen_next)) | (seen_next & ~none) | gap;
                moved = _mm512_mask_test_epi16_mask(moved, rest,
                                                    _mm512_loadu_si512(grid->inner + cell));
                __m512i n = _mm512_min_epu16(_mm512_abs_epi16(change), last);
                __m512i move = _mm512_srav_epi16(rest, _mm512_permutexvar_epi16(n, table));
                move = _mm512_min_epi16(_mm512_max_epi16(move, low), high);
                sum = _mm512_mask_add_epi16(sum, moved, sum, move);
            }
            count = next;
            seen = seen_next;
        }
        int16_t sums[32];
        _mm512_storeu_si512(sums, sum);
        for (int i = 0; i < 32 && row + i < grid->rows; i++)
            total += (double)((long)sums[i] * grid->length[row + i]);
    }
    double v = total / grid->total;
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

#include "method/exact/exact_kernel.inc"
