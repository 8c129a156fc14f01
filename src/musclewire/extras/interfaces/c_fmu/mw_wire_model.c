/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The wire on its load as a model: mw_wire.h, one duration each communication step. */
#include "mw_model.h"
#include "mw_finger.h"
#include "mw_wire.h"
#include "mw_wire_parameters.h"

/* Stresses at which the spreads must be positive: none, and about the strength of a wire; and the least spread. */
#define STRENGTH_PA 1e9
#define MIN_SPREAD_K 1e-3

struct mw_model {
    mw_wire_constants constants;
    mw_step_constants step;
    mw_wire_state state;
};

size_t mw_model_bytes(void)
{
    return sizeof(mw_model);
}

static int finite(double value)
{
    return value >= -DBL_MAX && value <= DBL_MAX;
}

static mw_push push_of(const mw_values *values)
{
    const mw_push push = {values->real[MW_REAL_EXTERNAL_FORCE_N], 0.0, 0.0};
    return push;
}

static void show_circuit(const mw_model *model, mw_values *values)
{
    const double resistance_ohm = model->state.resistance_ohm;
    const double current_a =
        values->real[MW_REAL_DRIVE_VOLTAGE_V] / (resistance_ohm + model->step.series_resistance_ohm);
    values->real[MW_REAL_RESISTANCE_OHM] = resistance_ohm;
    values->real[MW_REAL_WIRE_VOLTAGE_V] = current_a * resistance_ohm;
    values->real[MW_REAL_SHUNT_VOLTAGE_V] = current_a * model->step.shunt_resistance_ohm;
}

/* Show the endpoint of a finger, if there is one. Its curve must cover where the tendon is. */
static mw_outcome show_endpoint(mw_values *values, double time_s, mw_message *message)
{
#if MW_FINGER
    const mw_endpoint now = mw_endpoint_at(values->real[MW_REAL_DISPLACEMENT_M]);
    const mw_endpoint mean = mw_endpoint_at(values->real[MW_REAL_MEAN_DISPLACEMENT_M]);
    values->real[MW_REAL_ENDPOINT_DISPLACEMENT_M] = now.displacement_m;
    values->real[MW_REAL_ENDPOINT_FORCE_N] = now.force_n;
    values->real[MW_REAL_MEAN_ENDPOINT_DISPLACEMENT_M] = mean.displacement_m;
    values->real[MW_REAL_MEAN_ENDPOINT_FORCE_N] = mean.force_n;
    if (now.beyond_m > 0.0 || mean.beyond_m > 0.0) {
        mw_say(message, "caller", "at %.9g s the tendon has travelled %.3f mm more than the finger's file covers: drive "
               "less, or export a rig with a longer curve", time_s,
               1e3 * (now.beyond_m > mean.beyond_m ? now.beyond_m : mean.beyond_m));
        return MW_FAILED;
    }
#else
    (void)values, (void)time_s, (void)message;
#endif
    return MW_DONE;
}

static void show(const mw_model *model, const mw_means *means, mw_values *values)
{
    const mw_wire_state *state = &model->state;
    const double leg_length_m = model->step.leg_length_m;
    show_circuit(model, values);
    values->real[MW_REAL_DISPLACEMENT_M] = state->connector_contraction * leg_length_m;
    values->real[MW_REAL_FORCE_N] = state->stress_pa * model->step.section_m2;
    values->real[MW_REAL_TEMPERATURE_K] = state->temperature_k;
    values->real[MW_REAL_STRESS_PA] = state->stress_pa;
    values->real[MW_REAL_CONTRACTION] = state->contraction;
    values->real[MW_REAL_MARTENSITE_FRACTION] = state->martensite_fraction;
    values->real[MW_REAL_R_PHASE_FRACTION] = state->r_phase_fraction;
    values->real[MW_REAL_FRICTION_FORCE_N] = state->friction_n;
    values->real[MW_REAL_SLACK_M] = (state->connector_contraction - state->contraction) * leg_length_m;
    values->real[MW_REAL_HEAT_IN_J] = state->heat_in_j;
    values->real[MW_REAL_HEAT_OUT_J] = state->heat_out_j;
    values->real[MW_REAL_CYCLES] = state->cycles;
    values->real[MW_REAL_STEP_ERROR_K] = state->step_error_k;
    values->real[MW_REAL_MEAN_WIRE_VOLTAGE_V] = means ? means->wire_voltage_v : values->real[MW_REAL_WIRE_VOLTAGE_V];
    values->real[MW_REAL_MEAN_SHUNT_VOLTAGE_V] = means ? means->shunt_voltage_v : values->real[MW_REAL_SHUNT_VOLTAGE_V];
    values->real[MW_REAL_MEAN_DISPLACEMENT_M] = means ? means->displacement_m : values->real[MW_REAL_DISPLACEMENT_M];
    values->real[MW_REAL_MEAN_FORCE_N] = means ? means->force_n : values->real[MW_REAL_FORCE_N];
}

/* Two fronts describe the phases only while the driving force of martensite spreads further over the grains than that of
 * the R-phase, at any stress. */
static mw_outcome check_spreads(const mw_wire_constants *of, mw_message *message)
{
    const double spread_r_k = of->r_phase_entropy_ratio * of->r_phase_spread_k;
    const double strong_k = of->martensite_spread_k + of->martensite_spread_per_pa * STRENGTH_PA;
    const double least_k = strong_k < of->martensite_spread_k ? strong_k : of->martensite_spread_k;
    if (spread_r_k >= MIN_SPREAD_K && least_k - spread_r_k >= MIN_SPREAD_K)
        return MW_DONE;
    mw_say(message, "caller", "martensite_spread_k is %g K up to %g MPa, and r_phase_entropy_ratio * r_phase_spread_k %g K: "
           "it must be at least %g K, and martensite's larger by as much", least_k, STRENGTH_PA / 1e6, spread_r_k,
           MIN_SPREAD_K);
    return MW_FAILED;
}

mw_outcome mw_model_start(mw_model *model, mw_values *values, mw_message *message)
{
    model->constants = mw_constants_of_the_wire;
#define TAKE(field, place) model->constants.field = values->real[place];
    MW_WIRE_PARAMETERS(TAKE)
#undef TAKE
    model->constants.ambient_temperature_k = values->real[MW_REAL_AMBIENT_TEMPERATURE_K];
    if (check_spreads(&model->constants, message) != MW_DONE)
        return MW_FAILED;
    mw_at_rest(&model->constants, &model->step, &model->state);
    if (!finite(model->state.resistance_ohm) || !finite(model->state.enthalpy_j)) {
        mw_say(message, "caller", "these parameters do not describe a wire: its resistance at rest is %g ohm",
               model->state.resistance_ohm);
        return MW_FAILED;
    }
    show(model, NULL, values);
    return show_endpoint(values, 0.0, message);
}

mw_outcome mw_model_step(mw_model *model, mw_values *values, double time_s, double duration_s, mw_message *message)
{
    const mw_stepping stepping = {values->real[MW_REAL_STEP_S], values->real[MW_REAL_TOLERANCE_K],
                                  values->real[MW_REAL_RESISTANCE_TOLERANCE], values->real[MW_REAL_STRAIN_TOLERANCE]};
    const mw_push push = push_of(values);
    const double unsolved = model->state.unsolved_steps;
    mw_means means;
    model->step.ambient_temperature_k = values->real[MW_REAL_AMBIENT_TEMPERATURE_K];
    model->step.surface_factor_m2 =
        model->constants.surface_m2 * (model->constants.convection_factor * values->real[MW_REAL_CONVECTION_RATIO]);
    if (mw_advance(&model->state, &model->step, values->real[MW_REAL_DRIVE_VOLTAGE_V], &push, duration_s, &stepping,
                   &means) < 0) {
        mw_say(message, "caller", "step_s of %g s does not divide the communication step of %g s at %.9g s: choose one "
               "that does, or step_s 0 for steps by tolerance", stepping.step_s, duration_s, time_s);
        return MW_FAILED;
    }
    if (model->state.unsolved_steps > unsolved || !(model->state.step_error_k <= MW_MAX_STEP_ERROR_K)
        || !finite(model->state.temperature_k)) {
        mw_say(message, "numerics", "between %.9g s and %.9g s %g balances are unsolved, and a step's error in temperature "
               "is %.3g K: set step_s to 0 for steps by tolerance or shorter, or take shorter communication steps", time_s,
               time_s + duration_s, model->state.unsolved_steps - unsolved, model->state.step_error_k);
        return MW_RETRY;
    }
    show(model, &means, values);
    return show_endpoint(values, time_s + duration_s, message);
}
