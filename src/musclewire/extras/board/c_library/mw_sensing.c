/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Resistance from two voltages, and the quantity that the model assigns to it. */
#include "musclewire.h"

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
    MW_TABLE mw_real heating_powers[MW_COEFFICIENTS] = MW_HEATING_FALLING;
    MW_TABLE mw_real cooling_powers[MW_COEFFICIENTS] = MW_COOLING_FALLING;
    const mw_real normalised = (resistance_ohm - MW_RESISTANCE_MIN_OHM) * MW_SHARE_PER_OHM;
    mw_estimation result;
    mw_real inside = normalised, heating, cooling;
    uint8_t index;
    result.valid = normalised >= MW_VALID_FROM && normalised <= MW_VALID_TO;
    if (!(normalised >= -MW_LARGEST && normalised <= MW_LARGEST)) {
        result.value = MW_QUANTITY_MAX;
        return result;
    }
    if (normalised < MW_NORMALISED_MIN)
        inside = MW_NORMALISED_MIN;
    else if (normalised > MW_NORMALISED_MAX)
        inside = MW_NORMALISED_MAX;
    heating = heating_powers[0];
    cooling = cooling_powers[0];
    for (index = 1; index < MW_COEFFICIENTS; index++) {
        heating = heating * inside + heating_powers[index];
        cooling = cooling * inside + cooling_powers[index];
    }
    result.value = (heating + cooling) / 2;
    return result;
}
