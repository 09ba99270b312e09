/* method/exact/exact_kernel_avx512.c: the inner loops, sixteen wide. */
#include <immintrin.h>

#include "method/exact/exact.h"

#define WIDTH          16
#define KERNEL         exact_kernel_avx512
#define KERNEL_NAME    "avx512"
#define lanes_of(mask) ((unsigned)_mm512_movepi32_mask((__m512i)(mask)))
#define clamp(x, high)                                                                             \
    ((vf)_mm512_min_ps(_mm512_max_ps((__m512)(x), _mm512_setzero_ps()), _mm512_set1_ps(high)))

#define gather_floats(from, at) ((vf)_mm512_i32gather_ps((__m512i)(at), from, 4))

#define round_up(x)                                                                                \
    ((vi)_mm512_cvt_roundps_epi32((__m512)(x), _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC))

#define HAVE_LANE_SETS
typedef __mmask16 vm;
#define less(a, b)            _mm512_cmp_ps_mask((__m512)(a), (__m512)(b), _CMP_LT_OQ)
#define less_int(a, b)        _mm512_cmplt_epi32_mask((__m512i)(a), (__m512i)(b))
#define differ_int(a, b)      _mm512_cmpneq_epi32_mask((__m512i)(a), (__m512i)(b))
#define bits_of(m)            ((unsigned)(m))
#define where(m, x)           ((vi)_mm512_maskz_mov_epi32(m, (__m512i)(x)))
#define either(m, a, b)       ((vi)_mm512_mask_mov_epi32((__m512i)(b), m, (__m512i)(a)))
#define either_float(m, a, b) ((vf)_mm512_mask_mov_ps((__m512)(b), m, (__m512)(a)))
#define all_ones(m)           ((vi)_mm512_movm_epi32(m))
#define no_lanes              ((vm)0)
#define all_lanes             ((vm)0xffff)

/* exact_cover_resolve() for 16 rows at once, with masks instead of selections. */
#define HAVE_RESOLVE
static double kernel_resolve(const struct exact_cover *cover)
{
    const struct exact_grid *grid = cover->grid;
    const __m512i zero = _mm512_setzero_si512(), half = _mm512_set1_epi32(0x8000);
    const __m512i unit = _mm512_set1_epi32(cover->unit);
    const __m512i low = _mm512_set1_epi32(-256), high = _mm512_set1_epi32(256);
    /* How far rest is shifted for a change of 0 to 15. */
    const __m512i table =
        _mm512_setr_epi32(cover->unit - 1, 0, 1, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3, 3);
    const __m512i last_shift = _mm512_set1_epi32(15);
    double total = 0;
    int32_t base[EXACT_ROWS_MAX], left = 0;
    for (int row = 0; row < grid->stride; row++)
        base[row] = left += cover->left[row];
    for (int row = 0; row < grid->rows; row += 16) {
        __m512i count = _mm512_loadu_si512(cover->cells + row);
        count = _mm512_srai_epi32(_mm512_slli_epi32(count, 16), 16);
        count = _mm512_add_epi32(count, _mm512_loadu_si512(base + row));
        __m512i sum = zero, done = zero;
        __mmask16 seen = _mm512_cmple_epi32_mask(count, zero);
        for (uint32_t bits = *cover->touched; bits; bits &= bits - 1) {
            int first = __builtin_ctz(bits) << grid->fold;
            int last = first + (1 << grid->fold);
            last = last < grid->bins + 2 ? last : grid->bins + 2;
            for (int k = first > 0 ? first : 1; k < last; k++) {
                int at = k * grid->stride + row, cell = at - grid->stride;
                __m512i both = _mm512_loadu_si512(cover->cells + at);
                __m512i change = _mm512_srai_epi32(_mm512_slli_epi32(both, 16), 16);
                __m512i next = _mm512_add_epi32(count, change);
                __mmask16 seen_next = _mm512_cmple_epi32_mask(next, zero);
                __m512i here = _mm512_loadu_si512(grid->before + cell);
                sum = _mm512_mask_add_epi32(sum, seen, sum, _mm512_sub_epi32(here, done));
                done = here;
                if (cover->area) {
                    __m512i rest = _mm512_srai_epi32(_mm512_add_epi32(both, half), 16);
                    __mmask16 none = _mm512_testn_epi32_mask(change, change);
                    __mmask16 gap = _mm512_mask_cmpeq_epi32_mask(
                        _mm512_mask_cmpgt_epi32_mask(none, rest, zero), count, unit);
                    __mmask16 moved = (seen & (none | ~seen_next)) | (seen_next & ~none) | gap;
                    moved = _mm512_mask_test_epi32_mask(moved, rest,
                                                        _mm512_loadu_si512(grid->inner + cell));
                    __m512i n = _mm512_min_epu32(_mm512_abs_epi32(change), last_shift);
                    __m512i move = _mm512_srav_epi32(rest, _mm512_permutexvar_epi32(n, table));
                    move = _mm512_min_epi32(_mm512_max_epi32(move, low), high);
                    sum = _mm512_mask_add_epi32(sum, moved, sum, move);
                }
                count = next;
                seen = seen_next;
            }
        }
        __m512i whole = _mm512_loadu_si512(grid->before + grid->bins * grid->stride + row);
        sum = _mm512_mask_add_epi32(sum, seen, sum, _mm512_sub_epi32(whole, done));
        int32_t sums[16];
        _mm512_storeu_si512(sums, sum);
        for (int i = 0; i < 16 && row + i < grid->rows; i++)
            total += (double)((long)sums[i] * grid->length[row + i]);
    }
    double v = total / grid->total;
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

#define root_of(x) ((vf)_mm512_sqrt_ps((__m512)(x)))
#define HAVE_MASK
#define shift_ones(by) ((vi)_mm512_sllv_epi32(_mm512_set1_epi32(-1), (__m512i)(by)))
#define any_bit(x)     (_mm512_test_epi32_mask((__m512i)(x), (__m512i)(x)) != 0)

#define HAVE_REDUCE
#define least_of(x) _mm512_reduce_min_epi32((__m512i)(x))
#define most_of(x)  _mm512_reduce_max_epi32((__m512i)(x))
#define append_picks(to, lanes, x)                                                                 \
    _mm512_storeu_si512(to, _mm512_maskz_compress_epi32((__mmask16)(lanes), (__m512i)(x)))

#include "method/exact/exact_kernel.inc"
