/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Resistance from two voltages, and the quantity that the model assigns to it. */
#include "mw_branches.h"

mw_real mw_resistance(mw_real wire_voltage_v, mw_real shunt_voltage_v)
{
    const mw_real size_v = shunt_voltage_v < 0 ? -shunt_voltage_v : shunt_voltage_v;
    mw_real resistance_ohm;
    /* Written so that a NaN counts as "no current". */
    if (!(size_v >= MW_LEAST_SHUNT_VOLTAGE_V))
        return 0;
    resistance_ohm = MW_SERIES_RESISTANCE(wire_voltage_v, shunt_voltage_v);
    return resistance_ohm > 0 && resistance_ohm <= MW_LARGEST ? resistance_ohm : 0;
}

mw_estimation mw_estimate(mw_real resistance_ohm)
{
    const mw_real normalised = (resistance_ohm - MW_RESISTANCE_MIN_OHM) * MW_SHARE_PER_OHM;
    mw_estimation result;
    mw_branches at;
    result.valid = normalised >= MW_VALID_FROM && normalised <= MW_VALID_TO;
    if (!(normalised >= -MW_LARGEST && normalised <= MW_LARGEST)) {
        result.value = MW_QUANTITY_MAX;
        return result;
    }
    at = mw_branches_at(mw_within(normalised, MW_NORMALISED_MIN, MW_NORMALISED_MAX));
    result.value = (at.heating + at.cooling) / 2;
    return result;
}

#if defined(MW_INVERSE_MODEL) && !defined(MW_FILTER)
mw_real mw_deviation(mw_real resistance_ohm)
{
    const mw_real normalised = (resistance_ohm - MW_RESISTANCE_MIN_OHM) * MW_SHARE_PER_OHM;
    const mw_real inside = mw_within(normalised, MW_NORMALISED_MIN, MW_NORMALISED_MAX);
    const mw_branches at = mw_branches_at(inside);
    const mw_real half_gap = (at.heating - at.cooling) / 2, value = (at.heating + at.cooling) / 2;
    const mw_real beyond = normalised < inside ? inside - normalised : normalised - inside;
    const mw_real spread = at.slope / 2 * (beyond + MW_NOISE_OHM * MW_SHARE_PER_OHM);
    const mw_real variance =
        half_gap * half_gap + MW_RESIDUAL_VARIANCE + spread * spread + MW_SCALE_VARIANCE * value * value;
    const mw_real std = mw_root(variance);
    return std < MW_QUANTITY_SPAN ? std : MW_QUANTITY_SPAN;
}
#endif
