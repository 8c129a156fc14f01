/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The inverse of the wire's model: the power that holds the wire, and the heat that its error takes. The arithmetic is
 * that of musclewire.controllers._inverse_model, operation by operation; what each function does is said there. */
#include "mw_branches.h"

#if defined(MW_INVERSE_MODEL)

/* What is known of the wire at each level of the quantity. */
enum { HEATING_W, COOLING_W, RESISTANCE, HEATING_SLOPE, COOLING_SLOPE, COLUMNS };
MW_TABLE mw_real levels[MW_LEVELS][COLUMNS] = MW_LEVEL_TABLE;

static mw_real level_value(uint8_t column, mw_real value)
{
    const mw_real place = mw_within((value - MW_LOWEST) / MW_SPACING, 0, MW_LEVELS - 1);
    const uint16_t left = (uint16_t)mw_within(place, 0, MW_LEVELS - 2);
    const mw_real at_left = levels[left][column];
    return at_left + (place - (mw_real)left) * (levels[left + 1][column] - at_left);
}

static uint8_t is_finite(mw_real number)
{
    return number >= -MW_LARGEST && number <= MW_LARGEST;
}

static mw_real least(mw_real one, mw_real other)
{
    return other < one ? other : one;
}

static mw_real most(mw_real one, mw_real other)
{
    return other > one ? other : one;
}

static mw_real size_of(mw_real number)
{
    return number < 0 ? -number : number;
}

static mw_real power_w(mw_real drive_voltage_v, mw_real value)
{
    const mw_real resistance_ohm = level_value(RESISTANCE, value);
    const mw_real current_a = drive_voltage_v / (resistance_ohm + MW_SHUNT_RESISTANCE_OHM);
    return current_a * current_a * resistance_ohm;
}

static mw_real heat_per_value(uint8_t slope, mw_real value)
{
    return MW_THERMAL_TIME_CONSTANT_S * level_value(slope, value) + MW_HEAT_PER_UNIT;
}

static mw_real counted(mw_real error, mw_real deviation)
{
    const mw_real squared = error * error;
    return squared > 0 ? squared / (squared + deviation * deviation) : 0;
}

void mw_inverse_model_start(mw_inverse_model *own, mw_real drive_voltage_v)
{
    const mw_inverse_model fresh = {.drive_voltage_v = drive_voltage_v};
    *own = fresh;
    own->drive_voltage_v = mw_within(drive_voltage_v, MW_SENSE_VOLTAGE_V, MW_MAXIMUM_VOLTAGE_V);
}

mw_inverse_model_answer mw_inverse_model_hold(const mw_inverse_model *own)
{
    const mw_inverse_model_answer answer = {own->drive_voltage_v, own->holding_w, 0, 0};
    return answer;
}

static void take_over(mw_inverse_model *own, mw_real target, mw_real value)
{
    own->started = 1;
    own->given_part = own->loss = 1;
    own->power_w = power_w(own->drive_voltage_v, value);
    own->holding_w = own->balance_w = own->power_w;
    own->target = target;
    own->value = value;
}

static mw_real target_rate(mw_inverse_model *own, mw_real target, mw_real dt_s)
{
    const mw_real moved = target - own->target, before = own->moved;
    mw_real common;
    own->target = target;
    own->moved = moved;
    if (moved * before <= 0)
        return 0;
    common = least(size_of(moved), size_of(before));
    return (moved < 0 ? -common : common) / dt_s;
}

static void notice_given_part(mw_inverse_model *own, mw_real measured_w, mw_real dt_s)
{
    const mw_real asked_w = own->power_w, ceiling_w = MW_MAXIMUM_STEADY_POWER_W;
    const mw_real lacking_w = measured_w - own->given_part * asked_w;
    const mw_real learnt = lacking_w * asked_w / (asked_w * asked_w + ceiling_w * ceiling_w);
    own->given_part += learnt * least(dt_s / MW_INTEGRAL_TIME_S, 1);
    own->given_part = most(own->given_part, MW_MIN_PART);
}

/* The wire at a sample: the steady power, where between the branches it is, and the power that holds it. */
typedef struct {
    mw_real balance_w, part, holding_w;
} wire_now;

static wire_now state_of_value(mw_inverse_model *own, mw_real value, uint8_t cold, mw_real dt_s)
{
    const mw_real tau_s = MW_THERMAL_TIME_CONSTANT_S, lag_s = tau_s + dt_s * own->loss;
    const mw_real taken_j = cold ? 0 : MW_HEAT_PER_UNIT * (value - own->value);
    const mw_real free_w = (tau_s * own->balance_w + dt_s * own->power_w - taken_j) / lag_s;
    /* A cold wire is at most as warm as on the way to B. */
    const mw_real cooling_w = cold ? 0 : level_value(COOLING_W, value), heating_w = level_value(HEATING_W, value);
    const mw_real held_w = mw_within(free_w, cooling_w, heating_w);
    wire_now now = {held_w, 1, 0};
    if (held_w != free_w) {
        const mw_real lacking = (free_w - held_w) * lag_s / (dt_s * held_w);
        own->loss = most(own->loss + lacking * least(dt_s / MW_INTEGRAL_TIME_S, 1), 0);
    }
    if (!cold)
        now.part = heating_w > cooling_w ? (held_w - cooling_w) / (heating_w - cooling_w) : MW_R(0.5);
    own->balance_w = held_w;
    now.holding_w = own->loss * own->balance_w;
    return now;
}

/* How much of an error counts, and the heat that is due for it. */
static mw_real due_at(const wire_now *now, mw_real error, mw_real value, mw_real std, mw_real *trust)
{
    const uint8_t rises = error > 0;
    const mw_real left = rises ? 1 - now->part : -now->part, turn = counted(error, MW_TURN * std);
    const mw_real gap_w = level_value(HEATING_W, value) - level_value(COOLING_W, value);
    const mw_real gap_j = turn * MW_THERMAL_TIME_CONSTANT_S * left * gap_w;
    *trust = counted(error, MW_NEAR * std) * (1 - size_of(left) * (1 - turn));
    return gap_j + *trust * heat_per_value(rises ? HEATING_SLOPE : COOLING_SLOPE, value) * error;
}

static mw_real due_from_cold_j(const wire_now *now, mw_real target)
{
    const mw_real warming_w = level_value(HEATING_W, target) - now->balance_w;
    return MW_THERMAL_TIME_CONSTANT_S * warming_w + MW_HEAT_PER_UNIT * target;
}

static void set_drive(mw_inverse_model *own, mw_real value, mw_real given_w, mw_real lowest_w, mw_real highest_w)
{
    if (given_w == lowest_w) {
        own->drive_voltage_v = MW_SENSE_VOLTAGE_V;
    } else if (given_w == highest_w) {
        own->drive_voltage_v = MW_MAXIMUM_VOLTAGE_V;
    } else if (given_w != own->power_w) {
        const mw_real resistance_ohm = level_value(RESISTANCE, value);
        const mw_real drive_v = mw_root(given_w / resistance_ohm) * (resistance_ohm + MW_SHUNT_RESISTANCE_OHM);
        own->drive_voltage_v = mw_within(drive_v, MW_SENSE_VOLTAGE_V, MW_MAXIMUM_VOLTAGE_V);
    }
    own->power_w = given_w;
}

mw_inverse_model_answer mw_inverse_model_step(mw_inverse_model *own, mw_real target, const mw_sensed *sensed, mw_real dt_s)
{
    mw_inverse_model_answer answer = mw_inverse_model_hold(own);
    const uint8_t cold = sensed->cold;
    const mw_real value = cold ? least(sensed->value, MW_LOWEST) : sensed->value;
    wire_now now = {sensed->balance_w, sensed->part, sensed->loss * (sensed->balance_w - sensed->shift_w)};
    mw_real trust = 1, due_j, rate, ahead_w, wanted_w, warmest_w, lowest_w, highest_w, asked_w;
    if (!(is_finite(target - sensed->value) && dt_s > 0 && dt_s <= MW_LARGEST))
        return answer;
    if (!own->started)
        take_over(own, target, value);
    if (sensed->wire_known && sensed->measured_w > 0) /* a reading of another wire measures no power */
        notice_given_part(own, sensed->measured_w, dt_s);
    if (!(sensed->wire_known && is_finite(now.holding_w + now.part)))
        now = state_of_value(own, value, cold, dt_s);
    due_j = cold ? due_from_cold_j(&now, target) : due_at(&now, target - value, value, sensed->std, &trust);
    own->holding_w += trust * (now.holding_w - own->holding_w);
    rate = target_rate(own, target, dt_s);
    ahead_w = rate * heat_per_value(rate > 0 ? HEATING_SLOPE : COOLING_SLOPE, target);
    wanted_w = own->holding_w + due_j / most(MW_RESPONSE_S, dt_s) + ahead_w;
    /* With this power, of which the wire is given its part, the heat balance is at the limit after this sample. */
    warmest_w = now.holding_w + (MW_MAXIMUM_STEADY_POWER_W - now.balance_w) * MW_THERMAL_TIME_CONSTANT_S / dt_s;
    lowest_w = power_w(MW_SENSE_VOLTAGE_V, value);
    highest_w = power_w(MW_MAXIMUM_VOLTAGE_V, value);
    asked_w = mw_within(least(wanted_w, warmest_w) / own->given_part, lowest_w, highest_w);
    set_drive(own, value, asked_w, lowest_w, highest_w);
    own->value = value;
    answer.drive_voltage_v = own->drive_voltage_v;
    answer.holding_w = own->holding_w;
    answer.due_j = due_j;
    answer.limited = wanted_w > warmest_w && warmest_w < highest_w;
    return answer;
}

#else
typedef int mw_no_inverse_model; /* the library was exported with the fuzzy PID */
#endif
