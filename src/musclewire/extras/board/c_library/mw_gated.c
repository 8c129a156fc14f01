/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Direction-gated branches: the quantity moves towards the branch of the direction in which power drives the wire. The
 * arithmetic is that of musclewire.sensing._gated_estimator, operation by operation. */
#include "mw_branches.h"

#if defined(MW_GATED)

static mw_branches branches_at(mw_real normalised)
{
    return mw_branches_at(mw_within(normalised, MW_NORMALISED_MIN, MW_NORMALISED_MAX));
}

static mw_real gain(mw_real dt_s, mw_real time_constant_s)
{
    return dt_s / (dt_s + time_constant_s);
}

/* The first sample: the mean of both branches, heating; near R_max a wire counts as cold. */
static void begin(mw_follower *gates, mw_real read, mw_real power_w)
{
    const mw_branches at = branches_at(read);
    gates->value = (at.heating + at.cooling) / 2;
    gates->resistance = gates->lagging = gates->before = gates->before_last = read;
    gates->variance = MW_FIRST_VARIANCE;
    gates->noise_v2 = 0;
    gates->learnt_s = -1;
    gates->mean_power_w = gates->extreme_power_w = power_w;
    gates->power_variance_w2 = 0;
    gates->heating = 1;
    gates->sensing = read < MW_AMBIGUOUS_ABOVE;
    gates->followed = 1;
}

static void filter(mw_follower *gates, mw_real read, mw_real noise, mw_real ratio, mw_real dt_s)
{
    const mw_real away = read - gates->resistance;
    mw_real variance = gates->variance, surprise = away * away - noise - variance, weight;
    if (surprise < 0)
        surprise = 0;
    variance += dt_s * (MW_STILL_PER_S + MW_DRIVEN_PER_S * ratio * ratio + MW_SURPRISE_PER_S * surprise);
    weight = variance / (variance + noise);
    gates->resistance += weight * away;
    gates->variance = variance - weight * variance;
    weight = gain(dt_s, MW_LAGGING_S);
    gates->lagging += (gates->resistance - gates->lagging) * (weight < MW_MAX_LAGGING ? weight : MW_MAX_LAGGING);
}

static void learn_noise(mw_follower *gates, mw_real read, mw_real per_volt, mw_real dt_s)
{
    const mw_real bend_v = ((read - gates->before) - (gates->before - gates->before_last)) / per_volt;
    const mw_real longest_s = MW_NOISE_SAMPLES * dt_s > MW_NOISE_S ? MW_NOISE_SAMPLES * dt_s : MW_NOISE_S;
    mw_real noise_v2 = bend_v * bend_v / 6;
    gates->before_last = gates->before;
    gates->before = read;
    if (gates->learnt_s < 0) {
        gates->learnt_s = 0;
        return;
    }
    gates->learnt_s += dt_s;
    if (gates->learnt_s > longest_s)
        gates->learnt_s = longest_s;
    if (!(noise_v2 <= MW_MAX_NOISE_V2))
        noise_v2 = MW_MAX_NOISE_V2;
    gates->noise_v2 += (noise_v2 - gates->noise_v2) * (dt_s / gates->learnt_s);
}

/* Moves the quantity towards its branch and keeps it within both. */
static void move(mw_follower *gates, mw_real moved, mw_real support, mw_real dt_s)
{
    const mw_branches at = branches_at(gates->resistance);
    const mw_real branch = gates->heating ? at.heating : at.cooling;
    const mw_real ahead = gates->heating ? branch - gates->value : gates->value - branch;
    const mw_real low = at.heating < at.cooling ? at.heating : at.cooling, high = at.heating < at.cooling ? at.cooling : at.heating;
    mw_real value = gates->value;
    if (ahead < 0)
        value += (branch - value) * gain(dt_s, at.heating < at.cooling ? MW_CROSSED_RETURN_S : MW_RETURN_S);
    else if (gates->heating ? moved < 0 : moved > 0)
        value = branch;
    else if (support > MW_SUPPORTING_FRACTION)
        value += (branch - value) * gain(dt_s, MW_APPROACH_S);
    else if (at.heating >= at.cooling)
        value += ((at.heating + at.cooling) / 2 - value) * gain(dt_s, MW_MIDDLE_S);
    gates->value = mw_within(value, low - MW_BEYOND, high + MW_BEYOND);
}

/* Whether the mean power has left its extreme of this direction for good, however slowly. */
static uint8_t has_come_back(mw_follower *gates, mw_real away_w, mw_real dt_s)
{
    mw_real back_w;
    gates->power_variance_w2 += (away_w * away_w - gates->power_variance_w2) * gain(dt_s, MW_NOISE_S);
    if (gates->heating ? gates->mean_power_w > gates->extreme_power_w : gates->mean_power_w < gates->extreme_power_w)
        gates->extreme_power_w = gates->mean_power_w;
    back_w = gates->mean_power_w - gates->extreme_power_w;
    if (back_w < 0)
        back_w = -back_w;
    return back_w > MW_SLOW_TURNING_FRACTION * gates->extreme_power_w &&
           back_w * back_w > MW_SLOW_TURNING_DEVIATIONS * gates->power_variance_w2;
}

static void locate(mw_follower *gates, mw_real moved, mw_real power_w, mw_real dt_s)
{
    const uint8_t before = gates->sensing;
    const mw_real least_w = power_w < MW_B_POWER_W ? power_w : MW_B_POWER_W;
    const mw_real below = MW_AMBIGUOUS_ABOVE - gates->resistance;
    const mw_real until_b = MW_NORMALISED_MAX - gates->resistance;
    if (until_b < 0 || until_b * until_b < 4 * gates->variance ||
        (gates->mean_power_w < MW_COLD_POWER_W && gates->resistance > MW_COLD_ABOVE))
        gates->sensing = 0;
    else if (below > 0 && below * below > 9 * gates->variance)
        gates->sensing = 1;
    else if (gates->heating && moved < 0 && moved * moved > 9 * gates->variance &&
             gates->learnt_s >= MW_NOISE_SAMPLES * dt_s)
        gates->sensing = 1;
    if (gates->sensing && !before && gates->mean_power_w < least_w)
        gates->mean_power_w = least_w;
}

/* Whether a reading can be one of the valid range, within three deviations of its noise. */
static uint8_t on_curve(mw_real read, mw_real noise)
{
    mw_real outside = MW_VALID_FROM - read;
    if (read - MW_VALID_TO > outside)
        outside = read - MW_VALID_TO;
    return !(outside > 0) || outside * outside <= 9 * noise;
}

#if defined(MW_INVERSE_MODEL)
/* The deviation, at a resistance and its variance, of which the gap between the branches is a part; and whether the wire
 * is before B. */
static void judge(mw_follower *gates, mw_real resistance, mw_real variance, mw_real gap_fraction, uint8_t is_on_curve)
{
    const mw_branches at = branches_at(resistance);
    const mw_real inside = mw_within(resistance, MW_NORMALISED_MIN, MW_NORMALISED_MAX);
    const mw_real gap = gap_fraction * (at.heating - at.cooling), slope = at.slope / 2, off = slope * (resistance - inside);
    const mw_real of_reading = slope * slope * variance, own = MW_SCALE_VARIANCE * gates->value * gates->value;
    const mw_real std = mw_root(gap * gap + of_reading + off * off + MW_MIN_VARIANCE + own);
    gates->std = std < MW_QUANTITY_SPAN ? std : MW_QUANTITY_SPAN;
    gates->cold = is_on_curve && !gates->sensing;
}
#endif

mw_estimation mw_follow(mw_follower *gates, mw_real resistance_ohm, mw_real wire_voltage_v, mw_real shunt_voltage_v,
                        mw_real dt_s)
{
    const mw_real read = (resistance_ohm - MW_RESISTANCE_MIN_OHM) * MW_SHARE_PER_OHM;
    const mw_real per_volt = resistance_ohm * MW_SHARE_PER_OHM / shunt_voltage_v;
    mw_real noise, power_w = wire_voltage_v * wire_voltage_v / resistance_ohm, ratio, support, moved;
    uint8_t slow_turn;
    mw_estimation result = {gates->value, 0};
#if defined(MW_INVERSE_MODEL)
    gates->std = MW_QUANTITY_SPAN;
    gates->cold = 0;
#endif
    /* A wire that this model never has: the estimate stays. Written so that a NaN counts as one. */
    if (!(resistance_ohm >= MW_OWN_LOW_OHM && resistance_ohm <= MW_OWN_HIGH_OHM && dt_s > 0 && dt_s <= MW_LARGEST))
        return result;
    if (!(power_w <= MW_MAX_POWER_W))
        power_w = MW_MAX_POWER_W;
    if (!gates->followed) {
        begin(gates, read, power_w);
        result.value = gates->value;
        result.valid = gates->sensing && read >= MW_VALID_FROM && read <= MW_VALID_TO;
#if defined(MW_INVERSE_MODEL)
        judge(gates, read, 0, MW_R(0.5), on_curve(read, 0));
#endif
        return result;
    }
    noise = gates->noise_v2 * per_volt * per_volt + MW_MIN_NOISE;
    gates->mean_power_w += (power_w - gates->mean_power_w) * gain(dt_s, MW_MEAN_POWER_S);
    ratio = power_w / gates->mean_power_w - 1;
    if (ratio > MW_MAX_RATIO)
        ratio = MW_MAX_RATIO;
    result.valid = on_curve(read, noise);
    filter(gates, read, noise, ratio, dt_s);
    learn_noise(gates, read, per_volt, dt_s);
    support = gates->heating ? ratio : -ratio;
    slow_turn = has_come_back(gates, power_w - gates->mean_power_w, dt_s);
    if (support < -MW_TURNING_FRACTION || slow_turn) { /* motion counts from the turn, and so do extremes of power */
        support = -support;
        gates->extreme_power_w = gates->mean_power_w;
        gates->heating = !gates->heating;
        gates->lagging = gates->resistance;
    }
    moved = gates->resistance - gates->lagging;
    if (!(moved * moved > MW_MOTION_DEVIATIONS * gates->variance + MW_MIN_MOTION_VARIANCE))
        moved = 0;
    locate(gates, moved, power_w, dt_s);
    move(gates, moved, support, dt_s);
    result.value = gates->value;
#if defined(MW_INVERSE_MODEL)
    judge(gates, gates->resistance, gates->variance, MW_GAP_FRACTION, result.valid);
#endif
    result.valid = result.valid && gates->sensing;
    return result;
}

#else
typedef int mw_no_gates; /* the library was exported with the polynomial */
#endif
