/* method/exact/exact_kernel.c: which inner loops this processor runs. */
#include <string.h>

#include "method/exact/exact.h"

#if defined(__x86_64__)
#define HAS_AVX2 __builtin_cpu_supports("avx2")
#define HAS_AVX512                                                                                 \
    (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&                    \
     __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
#endif

const struct exact_kernel *exact_kernel_choose(const char *name)
{
    bool any = !name || !*name;
#if defined(__x86_64__)
    if ((any || strcmp(name, "avx512") == 0) && HAS_AVX512)
        return &exact_kernel_avx512;
    if ((any || strcmp(name, "avx2") == 0) && HAS_AVX2)
        return &exact_kernel_avx2;
#endif
    if (any || strcmp(name, "c") == 0)
        return &exact_kernel_c;
    return NULL;
}
