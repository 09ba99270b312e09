/* method/exact/exact_kernel_avx512.c: the inner loops, sixteen wide. */
#include <immintrin.h>
#define WIDTH       16
#define KERNEL      exact_kernel_avx512
#define KERNEL_NAME "avx512"
#define HAVE_ANY
#define any(mask) _mm512_test_epi32_mask((__m512i)(mask), (__m512i)(mask))
#define clamp(x, high)                                                                             \
    ((vf)_mm512_min_ps(_mm512_max_ps((__m512)(x), _mm512_setzero_ps()), _mm512_set1_ps(high)))
#include "method/exact/exact_kernel.inc"
