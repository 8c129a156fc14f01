/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Both branches of the resistance curve, for the files that estimate; in a header, so that the slope is computed only
 * where it is used. */
#ifndef MW_BRANCHES_H
#define MW_BRANCHES_H

#include "musclewire.h"

typedef struct {
    mw_real heating, cooling, slope; /* g_h, g_c, and the slope of their sum */
} mw_branches;

/* A number kept between two others; what is not a number is the lower one. */
static inline mw_real mw_within(mw_real number, mw_real low, mw_real high)
{
    return number > low ? (number < high ? number : high) : low;
}

/* Eq. 4 at a normalised resistance within the valid range, by Horner's rule. */
static inline mw_branches mw_branches_at(mw_real inside)
{
    MW_TABLE mw_real heating_powers[MW_COEFFICIENTS] = MW_HEATING_FALLING;
    MW_TABLE mw_real cooling_powers[MW_COEFFICIENTS] = MW_COOLING_FALLING;
    mw_branches at = {heating_powers[0], cooling_powers[0], 0};
    uint8_t index;
    for (index = 1; index < MW_COEFFICIENTS; index++) {
        at.slope = at.slope * inside + at.heating + at.cooling;
        at.heating = at.heating * inside + heating_powers[index];
        at.cooling = at.cooling * inside + cooling_powers[index];
    }
    return at;
}

#endif
