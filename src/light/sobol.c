/* light/sobol.c: Owen-scrambled Sobol points in two dimensions.
 *
 * The first two Sobol dimensions form a (0,2)-sequence in base 2: of the first 2^k points (and of
 * every aligned run of 2^k) exactly one lies in each of the 2^k cells of every dyadic grid 2^a x
 * 2^b, a + b = k. Owen's nested uniform scrambling (Randomly permuted (t,m,s)-nets, 1995) keeps
 * that and makes each point uniform and the sets of different seeds independent: going down a
 * coordinate's binary digits, each digit is flipped or not by a coin that belongs to the digits
 * above it. Here each of those coins is a hash of (seed, digits above), so that the scrambling is
 * the full tree and not a shorter permutation; 24 digits, which is what a float holds.
 *
 * Cost: 48 small hashes, some 40 ns. Sets that are used again should be kept.
 */
#include "light/light.h"

#define DIGITS 24

/* Two rounds of multiply and shift: every input bit reaches every output bit. */
static uint32_t mix(uint32_t x)
{
    x ^= x >> 16;
    x *= 0x21f0aaadu;
    x ^= x >> 15;
    x *= 0x735a2d97u;
    x ^= x >> 15;
    return x;
}

static uint32_t reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x & 0x0f0f0f0fu) << 4 | (x >> 4 & 0x0f0f0f0fu);
    x = (x & 0x33333333u) << 2 | (x >> 2 & 0x33333333u);
    return (x & 0x55555555u) << 1 | (x >> 1 & 0x55555555u);
}

/* Second dimension: Pascal's triangle modulo 2 as the generator matrix, column i the i-th power of
 * the shear x ^ x/2 applied to the top digit. */
static uint32_t sobol_second(uint32_t index)
{
    uint32_t column = 0x80000000u, x = 0;
    for (; index; index >>= 1) {
        if (index & 1)
            x ^= column;
        column ^= column >> 1;
    }
    return x;
}

/* The node of a prefix is numbered 1prefix in binary, which tells its length as well. */
static uint32_t scramble(uint32_t x, uint32_t seed)
{
    uint32_t flips = 0;
    for (int digit = 0; digit < DIGITS; digit++) {
        uint32_t node = (uint32_t)((0x100000000u | x) >> (32 - digit));
        flips |= (mix(node * 0x9e3779b9u ^ seed) >> 31) << (31 - digit);
    }
    return x ^ flips;
}

void light_sobol_owen(uint32_t index, uint32_t seed, float *out_u, float *out_v)
{
    uint32_t seed_u = mix(seed + 0x68bc21ebu), seed_v = mix(seed ^ 0x02e5be93u) + 0x5bd1e995u;
    *out_u = (float)(scramble(reverse(index), seed_u) >> 8) * (1.0f / 16777216.0f);
    *out_v = (float)(scramble(sobol_second(index), mix(seed_v)) >> 8) * (1.0f / 16777216.0f);
}
