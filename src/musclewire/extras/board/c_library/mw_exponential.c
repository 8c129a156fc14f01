/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* e^x for -4 <= x <= 0. libm's differ from one another in the last digit, so this one is made of the four
 * operations alone: x = r - k ln 2 with k = 0..6, a Taylor polynomial of r, |r| <= 0.35, and a power of two. */
#include "musclewire.h"

#if defined(MW_DOUBLE)
#define TERMS 14
#else
#define TERMS 8
#endif

mw_real mw_exponential(mw_real x)
{
    MW_TABLE mw_real inverse_factorials[14] = {
        MW_R(1.0),
        MW_R(1.0),
        MW_R(0.5),
        MW_R(0.16666666666666666),
        MW_R(0.041666666666666664),
        MW_R(0.0083333333333333332),
        MW_R(0.0013888888888888889),
        MW_R(0.00019841269841269841),
        MW_R(2.4801587301587302e-05),
        MW_R(2.7557319223985893e-06),
        MW_R(2.7557319223985888e-07),
        MW_R(2.505210838544172e-08),
        MW_R(2.08767569878681e-09),
        MW_R(1.6059043836821613e-10),
    };
    /* ln 2 in two parts: the first has so few digits that a small multiple of it is exact */
    const mw_real ln2_upper = MW_R(0.693145751953125), ln2_lower = MW_R(1.4286068203094173e-06);
    uint8_t index, halvings;
    mw_real rest, sum;
    if (!(x > -4))
        x = -4;
    if (x > 0)
        x = 0;
    halvings = (uint8_t)(x * MW_R(-1.4426950408889634) + MW_R(0.5));
    rest = (x + (mw_real)halvings * ln2_upper) + (mw_real)halvings * ln2_lower;
    sum = inverse_factorials[TERMS - 1];
    for (index = TERMS - 1; index > 0; index--)
        sum = sum * rest + inverse_factorials[index - 1];
    return sum / (mw_real)((uint8_t)1 << halvings);
}
