/* method/exact/exact_kernel_avx2.c: the inner loops, eight wide. */
#include <immintrin.h>
#define WIDTH          8
#define KERNEL         exact_kernel_avx2
#define KERNEL_NAME    "avx2"
#define lanes_of(mask) ((unsigned)_mm256_movemask_ps((__m256)(mask)))
#define clamp(x, high)                                                                             \
    ((vf)_mm256_min_ps(_mm256_max_ps((__m256)(x), _mm256_setzero_ps()), _mm256_set1_ps(high)))
#define round_up(x)                                                                                \
    ((vi)_mm256_cvtps_epi32(                                                                       \
        _mm256_round_ps((__m256)(x), _MM_FROUND_TO_POS_INF | _MM_FROUND_NO_EXC)))
#define gather_floats(from, at) ((vf)_mm256_i32gather_ps(from, (__m256i)(at), 4))
#define root_of(x)              ((vf)_mm256_sqrt_ps((__m256)(x)))
#define HAVE_MASK
#define shift_ones(by) ((vi)_mm256_sllv_epi32(_mm256_set1_epi32(-1), (__m256i)(by)))
#define any_bit(x)     (!_mm256_testz_si256((__m256i)(x), (__m256i)(x)))
#include "method/exact/exact_kernel.inc"
