/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The square root, digit by digit in whole numbers and rounded to nearest, as IEEE 754 asks of sqrt: the same bits as
 * every processor that has one, without libm. */
#include "musclewire.h"

#if defined(MW_DOUBLE)
typedef uint64_t bits;
#define DIGITS DBL_MANT_DIG
#define BIAS (DBL_MAX_EXP - 1)
#define SMALLEST DBL_MIN
#else
typedef uint32_t bits;
#define DIGITS FLT_MANT_DIG
#define BIAS (FLT_MAX_EXP - 1)
#define SMALLEST FLT_MIN
#endif

mw_real mw_root(mw_real x)
{
    union {
        mw_real number;
        bits bits;
    } as;
    const bits hidden = (bits)1 << (DIGITS - 1);
    bits left, digit, taken = 0, root = 0;
    int16_t exponent;
    if (!(x >= SMALLEST))
        return 0;
    if (x > MW_LARGEST)
        return x;
    as.number = x;
    exponent = (int16_t)((int16_t)(as.bits >> (DIGITS - 1)) - BIAS);
    left = ((as.bits & (hidden - 1)) | hidden) << 1;
    if (exponent & 1) /* an even power of two is left, whose root is the half of it */
        left <<= 1;
    exponent = (int16_t)((exponent - (exponent & 1)) / 2);
    for (digit = hidden << 1; digit != 0; digit >>= 1) {
        if (taken + digit <= left) {
            taken += digit << 1;
            left -= taken - digit;
            root += digit;
        }
        left <<= 1;
    }
    root += root & 1; /* one digit more than there is room for; no root lies half-way */
    as.bits = (root >> 1) + ((bits)(exponent + BIAS - 1) << (DIGITS - 1));
    return as.number;
}
