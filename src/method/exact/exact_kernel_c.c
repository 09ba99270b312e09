/* method/exact/exact_kernel_c.c: the inner loops for any processor. */
#define WIDTH       4
#define KERNEL      exact_kernel_c
#define KERNEL_NAME "c"
#include "method/exact/exact_kernel.inc"
