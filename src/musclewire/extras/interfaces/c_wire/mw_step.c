/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Steps of one wire in its driving circuit: musclewire.wire._step, musclewire.wire._wires and .stepping. */
#include "mw_wire.h"

/* A connector whose load is balanced by friction to within this stays where it is. */
#define HELD_N 1e-9
/* Heat below this is rounding. */
#define NO_HEAT_J 1e-12
/* Chosen steps: the next one aims at this fraction of the tolerance and changes by these factors at most. */
#define SAFETY 0.9
#define MAX_SHRINK 0.2
#define MAX_GROWTH 3.0
/* Steps this short are taken whatever their error: only a jump of a load or a drive asks for shorter ones. */
#define MIN_STEP_S 1e-5
/* A fixed step must divide the duration; this much of a step may be left over by rounding. */
#define RAGGED 1e-6

/* The wire in its circuit and in the air at one moment. */
typedef struct {
    double current_a, power_w, loss_w;
} instant;

/* A step that was tried: what it owes the next by the trapezoidal rule is also the estimate of its error. */
typedef struct {
    mw_equilibrium found;
    instant within, ended;
    double heat_j, owed_j, error_k;
} attempt;

static double magnitude(double value)
{
    return value < 0.0 ? -value : value;
}

static double larger(double one, double other)
{
    return other > one ? other : one;
}

static double smaller(double one, double other)
{
    return other < one ? other : one;
}

/* The square root of a number of about 1, within rounding, by the four operations. */
static double square_root(double value)
{
    double scale = 1.0, root;
    int round;
    while (value > 4.0) {
        value *= 0.25;
        scale *= 2.0;
    }
    while (value < 1.0) {
        value *= 4.0;
        scale *= 0.5;
    }
    root = 0.5 * (1.0 + value);
    for (round = 0; round < 6; round++)
        root = 0.5 * (root + value / root);
    return root * scale;
}

mw_shakedown mw_shakedown_of(const mw_step_constants *k, double cycles)
{
    mw_shakedown of = {1.0, 0.0, 1.0};
    double remaining;
    if (k->shakedown_cycles == 0.0)
        return of;
    remaining = mw_decay(cycles / k->shakedown_cycles);
    of.barrier_factor = 1.0 + k->shakedown_barrier * remaining;
    of.residual_strain = k->shakedown_strain * (1.0 - remaining);
    of.resistivity_factor = 1.0 + k->shakedown_resistivity * remaining;
    return of;
}

/* The source drives wire, shunt and leads in series. */
static instant instant_of(const mw_step_constants *k, double drive_voltage_v, double resistance_ohm,
                          double temperature_k)
{
    instant at;
    at.current_a = drive_voltage_v / (resistance_ohm + k->series_resistance_ohm);
    at.power_w = at.current_a * at.current_a * resistance_ohm;
    at.loss_w = mw_heat_loss_w(k, temperature_k);
    return at;
}

/* Try a step; the wire does not move yet. Power and loss in the middle of the step give its heat; the middle is
 * predicted with the slopes of the last step, and with the capacity without latent heat after a change from heating to
 * cooling or back. */
static attempt attempt_of(mw_wire_state *state, const mw_step_constants *k, double drive_voltage_v, const mw_push *push,
                          const instant *started, double step_s)
{
    const double half_heat_j = 0.5 * step_s * (started->power_w - started->loss_w);
    const int turned = half_heat_j * state->last_heat_j < 0.0;
    const double temperature_slope = turned ? k->per_capacity_k_per_j : state->temperature_slope_k_per_j;
    const double stress_slope = turned ? 0.0 : state->stress_slope_pa_per_j;
    const double resistance_slope = turned ? 0.0 : state->resistance_slope_ohm_per_j;
    const mw_shakedown shakedown = mw_shakedown_of(k, state->cycles);
    double both_w;
    attempt tried;
    tried.within = instant_of(k, drive_voltage_v, state->resistance_ohm + resistance_slope * half_heat_j,
                              state->temperature_k + temperature_slope * half_heat_j);
    tried.heat_j = (tried.within.power_w - tried.within.loss_w) * step_s + state->carried_heat_j;
    tried.found = mw_solve(state, k, &shakedown, state->enthalpy_j + tried.heat_j,
                           state->temperature_k + temperature_slope * tried.heat_j,
                           larger(state->stress_pa + stress_slope * tried.heat_j, 0.0), push);
    tried.ended = instant_of(k, drive_voltage_v, tried.found.wire.resistance_ohm, tried.found.wire.temperature_k);
    both_w = 0.5 * (started->power_w - started->loss_w + tried.ended.power_w - tried.ended.loss_w);
    tried.owed_j = (both_w - (tried.within.power_w - tried.within.loss_w)) * step_s;
    tried.error_k = magnitude(tried.owed_j) * larger(tried.found.temperature_slope_k_per_j, temperature_slope);
    return tried;
}

/* Let the connector of a slack wire follow as far as the load overcomes the friction. */
static void let_connector_slide(mw_wire_state *state, const mw_step_constants *k, const mw_push *push)
{
    const double connector = state->connector_contraction, friction_n = state->friction_n;
    double low = state->contraction, high = connector;
    const mw_load_point at_wire = mw_load_at(k, low, connector, friction_n, push);
    int round;
    if (at_wire.limit_n <= 0.0 || at_wire.force_n >= 0.0) {
        state->connector_contraction = low;
        state->friction_n = at_wire.friction_n;
        return;
    }
    if (mw_load_at(k, high, connector, friction_n, push).force_n <= HELD_N)
        return;
    for (round = 0; round < 100; round++) {
        const double middle = 0.5 * (low + high);
        if (mw_load_at(k, middle, connector, friction_n, push).force_n < 0.0)
            low = middle;
        else
            high = middle;
        if ((middle == low || middle == high) && high - low <= 1e-15)
            break;
    }
    state->friction_n = mw_load_at(k, high, connector, friction_n, push).friction_n;
    state->connector_contraction = high;
}

/* Move a wire to a solution: its state, its fronts, and the slopes for the next step. */
static void accept(mw_wire_state *state, const mw_step_constants *k, const mw_equilibrium *found, double heat_j,
                   const mw_push *push)
{
    const mw_settled *after = &found->wire;
    int row;
    for (row = 0; row < MW_CLASSES; row++) {
        const double *trial = state->front_trial + 6 * row;
        state->front_austenite[row] = trial[0] + trial[2] * after->rise_k + trial[3] * after->rise_pa;
        state->front_martensite[row] = trial[1] + trial[4] * after->rise_k + trial[5] * after->rise_pa;
    }
    state->enthalpy_j += heat_j;
    state->cycles += 0.5 * magnitude(after->martensite - state->martensite_fraction);
    if (magnitude(heat_j) > NO_HEAT_J)
        state->resistance_slope_ohm_per_j = (after->resistance_ohm - state->resistance_ohm) / heat_j;
    state->last_heat_j = heat_j;
    state->temperature_slope_k_per_j = found->temperature_slope_k_per_j;
    state->stress_slope_pa_per_j = found->stress_slope_pa_per_j;
    state->contraction_slope_per_j = found->contraction_slope_per_j;
    state->temperature_k = after->temperature_k;
    state->martensite_fraction = after->martensite;
    state->r_phase_fraction = after->r_phase;
    state->resistance_ohm = after->resistance_ohm;
    state->stress_pa = after->stress_pa;
    state->contraction = after->contraction;
    state->evaluations += found->evaluations;
    if (!found->solved)
        state->unsolved_steps += 1.0;
    if (after->stress_pa > 0.0 || after->contraction >= state->connector_contraction) {
        state->connector_contraction = after->contraction;
        state->friction_n = after->friction_n;
    } else {
        let_connector_slide(state, k, push);
    }
}

/* The largest error of a step over its tolerance: of temperature, resistance and strain, also as means over it. */
static double error_ratio(const mw_wire_state *state, const attempt *tried, const instant *started, double step_s,
                          const mw_stepping *stepping)
{
    const mw_equilibrium *found = &tried->found;
    const double at_start_w = started->power_w - started->loss_w;
    const double at_end_w = tried->ended.power_w - tried->ended.loss_w;
    const int turned = at_start_w * state->last_heat_j < 0.0;
    const double resistance_slope =
        tried->heat_j != 0.0 ? (found->wire.resistance_ohm - state->resistance_ohm) / tried->heat_j : 0.0;
    const double bend_ohm =
        magnitude((turned ? 0.0 : state->resistance_slope_ohm_per_j) * at_start_w - resistance_slope * at_end_w);
    const double bend = magnitude((turned ? 0.0 : state->contraction_slope_per_j) * at_start_w
                                  - found->contraction_slope_per_j * at_end_w);
    const double mean = step_s / 12.0;
    const double resistance_ohm = larger(magnitude(tried->owed_j * resistance_slope), bend_ohm * mean);
    const double strain = larger(magnitude(tried->owed_j * found->contraction_slope_per_j), bend * mean);
    return larger(tried->error_k / stepping->temperature_k,
                  larger(resistance_ohm / (stepping->resistance * state->resistance_ohm), strain / stepping->strain));
}

/* How many fixed steps a duration has; 0 for chosen ones, -1 if it is no whole number. */
static int fixed_steps(const mw_stepping *stepping, double duration_s)
{
    double ratio, whole, rest;
    if (stepping->step_s == 0.0)
        return 0;
    ratio = duration_s / stepping->step_s;
    if (!(ratio >= 1.0 - RAGGED && ratio < 1e9))
        return -1;
    whole = (double)(int)(ratio + 0.5);
    rest = magnitude(ratio - whole);
    return rest > RAGGED * larger(ratio, 1.0) ? -1 : (int)whole;
}

/* The smallest whole number that is not below a positive one. */
static double whole_above(double value)
{
    const double below = (double)(long)value;
    return below < value ? below + 1.0 : below;
}

int mw_advance(mw_wire_state *state, const mw_step_constants *k, double drive_voltage_v, const mw_push *push,
               double duration_s, const mw_stepping *stepping, mw_means *means)
{
    const int steps = fixed_steps(stepping, duration_s);
    const int fixed = steps > 0;
    instant started = instant_of(k, drive_voltage_v, state->resistance_ohm, state->temperature_k);
    double left_s = duration_s, step_s = fixed ? duration_s / steps : duration_s;
    double voltage_sum = 0.0, current_sum = 0.0, moved_sum = 0.0, stress_sum = 0.0;
    const double mean = 0.5 / duration_s;
    int steps_left = steps;
    if (steps < 0)
        return -1;
    if (!fixed && state->step_s > 0.0)
        step_s = smaller(state->step_s, duration_s);
    while (fixed ? steps_left > 0 : left_s > 0.0) {
        attempt tried;
        double resistance_ohm, connector, stress_pa;
        if (!fixed) /* equal steps over what is left, none longer than the tolerance asks for */
            step_s = left_s / whole_above(left_s / step_s * (1.0 - 1e-9));
        tried = attempt_of(state, k, drive_voltage_v, push, &started, step_s);
        if (!fixed) {
            const double ratio = error_ratio(state, &tried, &started, step_s, stepping);
            if (ratio > 1.0 && step_s > MIN_STEP_S) {
                step_s *= larger(SAFETY / square_root(ratio), MAX_SHRINK);
                continue;
            }
            state->step_s =
                step_s * smaller(larger(SAFETY / square_root(larger(ratio, 1e-6)), MAX_SHRINK), MAX_GROWTH);
        }
        resistance_ohm = state->resistance_ohm;
        connector = state->connector_contraction;
        stress_pa = state->stress_pa;
        accept(state, k, &tried.found, tried.heat_j, push);
        state->carried_heat_j = tried.owed_j;
        state->heat_in_j += 0.5 * (started.power_w + tried.ended.power_w) * step_s;
        state->heat_out_j += 0.5 * (started.loss_w + tried.ended.loss_w) * step_s;
        state->step_error_k = larger(state->step_error_k, tried.error_k);
        /* The trapezoidal rule for all four alike: otherwise strain would be late or early beside resistance. */
        voltage_sum += step_s * (started.current_a * resistance_ohm + tried.ended.current_a * state->resistance_ohm);
        current_sum += step_s * (started.current_a + tried.ended.current_a);
        moved_sum += step_s * (connector + state->connector_contraction);
        stress_sum += step_s * (stress_pa + state->stress_pa);
        started = tried.ended;
        left_s -= step_s;
        steps_left--;
        step_s = fixed ? step_s : state->step_s;
    }
    state->time_s += duration_s; /* adding up step by step would accumulate rounding errors */
    means->wire_voltage_v = mean * voltage_sum;
    means->shunt_voltage_v = mean * current_sum * k->shunt_resistance_ohm;
    means->displacement_m = mean * moved_sum * k->leg_length_m;
    means->force_n = mean * stress_sum * k->section_m2;
    return steps;
}
