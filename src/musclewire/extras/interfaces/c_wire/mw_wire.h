/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The simulated wire on its load, in the order of operations of musclewire's Python (musclewire.wire):
 * the same bits, if the compiler keeps IEEE 754 arithmetic (-ffp-contract=off).
 *
 * SI units throughout, unit last in the name. No allocation, no global that is written, no libm. The numbers of one wire
 * and its load are in mw_wire_numbers.h, which the export writes; the other files are the same for every wire.
 */
#ifndef MW_WIRE_H
#define MW_WIRE_H

#include <float.h>

#if defined(__FAST_MATH__)
#error "musclewire: -ffast-math changes results and may drop the checks for NaN; compile these files without it"
#endif
/* 16 widens _Float16 alone (ISO/IEC TS 18661-3), on processors with AVX512-FP16; float and double are as with 0. */
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && FLT_EVAL_METHOD != 16
#error "musclewire: this target computes in wider numbers than it stores (FLT_EVAL_METHOD is neither 0 nor 16); on 32 bit x86 use -msse2 -mfpmath=sse"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#else
#pragma STDC FP_CONTRACT OFF
#endif

#include "mw_wire_numbers.h" /* mw_wire_constants, mw_step_constants, mw_wire_state, tables */

/* ---- fronts: mw_fronts.c ---------------------------------------------------------------------------------------- */

/* Offsets, in units of the spread, at which the six changes of phase are due, with slopes over stress and temperature. */
typedef struct {
    double a_to_m, a_to_r, r_to_m, m_to_a, r_to_a, m_to_r;
    double a_to_m_per_pa, a_to_r_per_pa, r_to_m_per_pa, m_to_a_per_pa, m_to_r_per_pa;
    double m_per_k, r_per_k, p_per_k;
} mw_thresholds;

/* Both fronts after a temperature and a stress, with their slopes; 0 while one stands still. */
typedef struct {
    double austenite, martensite;
    double austenite_per_k, austenite_per_pa, martensite_per_k, martensite_per_pa;
} mw_fronts;

/* Where the six changes of phase are due; barrier_factor is that of shakedown, barrier_k that of a class of grains. */
mw_thresholds mw_thresholds_at(const mw_step_constants *k, double temperature_k, double stress_pa,
                               double barrier_factor, double barrier_k);

/* The fronts that thresholds leave behind: cooling moves them down, heating up. */
mw_fronts mw_moved_fronts(const mw_thresholds *at, double front_austenite, double front_martensite);

/* Fraction of a class's grains below an offset, and its density. */
double mw_cumulative_at(const mw_step_constants *k, int row, double offset, double *density);

/* ---- both balances: mw_balance.c -------------------------------------------------------------------------------- */

/* Effects of the shakedown that a wire has behind it. */
typedef struct {
    double barrier_factor, residual_strain, resistivity_factor;
} mw_shakedown;

/* Volume fractions with their slopes over temperature and stress. */
typedef struct {
    double martensite, r_phase;
    double martensite_per_k, martensite_per_pa, r_phase_per_k, r_phase_per_pa;
} mw_phases;

/* A force on the connector that adds to the load's, linear around a contraction. */
typedef struct {
    double force_n, per_contraction_n, contraction;
} mw_push;

/* Force of the load at a contraction, friction included, and the friction alone with its limit. */
typedef struct {
    double force_n, per_contraction_n, friction_n, friction_per_contraction_n, limit_n;
} mw_load_point;

/* The three parts of strain, and what pure martensite would have with its slope over stress. */
typedef struct {
    double transformation, elastic, thermal, oriented, oriented_per_pa;
} mw_strain;

/* What is missing from both balances, and the Newton step that would meet them. */
typedef struct {
    double heat_j, excess_pa, rise_k, rise_pa;
    double contraction, contraction_per_k, contraction_per_pa;
    double heat_per_k, heat_per_pa, excess_per_k, excess_per_pa, per_determinant;
} mw_balance;

/* A point at which both balances have been evaluated. */
typedef struct {
    mw_phases phases;
    mw_strain strain;
    mw_load_point load;
    mw_balance balance;
} mw_trial;

/* A wire in both balances; rise_k and rise_pa are the last correction, for the fronts. */
typedef struct {
    double temperature_k, stress_pa, contraction, friction_n, martensite, r_phase, resistance_ohm, rise_k, rise_pa;
} mw_settled;

/* exp(-exponent) for exponents of 0 to 32, and that of 32 beyond; within 3e-14 of the exact value. */
double mw_decay(double exponent);

mw_strain mw_strain_at(const mw_step_constants *k, double temperature_k, double stress_pa, double martensite,
                       double r_phase);
double mw_contraction_of(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_strain *strain);
double mw_resistance_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_strain *strain,
                        double temperature_k, double martensite, double r_phase);

/* Residuals of both balances at point's phases, strain and load, and the Newton step from there. */
mw_balance mw_balance_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_trial *point,
                         double temperature_k, double stress_pa, double enthalpy_j);

/* The wire after the last Newton step, applied linearly; temperature follows from enthalpy. */
mw_settled mw_settled_at(const mw_step_constants *k, const mw_shakedown *shakedown, const mw_trial *point, double rise_k,
                         double rise_pa, double stress_pa, double enthalpy_j);

/* Heat lost to the air at a wall temperature [W]. */
double mw_heat_loss_w(const mw_step_constants *k, double temperature_k);

/* ---- temperature and stress from enthalpy and load: mw_solve.c ---------------------------------------------------- */

/* A solution of both balances with the slopes that the next guess needs. */
typedef struct {
    mw_settled wire;
    double temperature_slope_k_per_j, stress_slope_pa_per_j, contraction_slope_per_j;
    int evaluations, solved;
} mw_equilibrium;

/* Pretension, spring, table, push, and friction after the motion from the connector's contraction to this one. */
mw_load_point mw_load_at(const mw_step_constants *k, double contraction, double connector_before,
                         double friction_before_n, const mw_push *push);

/* Volume fractions at a temperature and a stress, from the fronts before; those after go to state->front_trial. */
mw_phases mw_phases_at(mw_wire_state *state, const mw_step_constants *k, const mw_shakedown *shakedown,
                       double temperature_k, double stress_pa);

/* Solve both balances at an enthalpy from a guess; only state->front_trial changes. */
mw_equilibrium mw_solve(mw_wire_state *state, const mw_step_constants *k, const mw_shakedown *shakedown,
                        double enthalpy_j, double temperature_k, double stress_pa, const mw_push *push);

/* ---- steps in time: mw_step.c -------------------------------------------------------------------------------------- */

/* How a duration is divided: step_s above 0 is a fixed step; otherwise steps follow from the tolerances of temperature,
 * of resistance as a fraction of it, and of strain. */
typedef struct {
    double step_s, temperature_k, resistance, strain;
} mw_stepping;

/* Means over a duration: what averaging instruments measure. */
typedef struct {
    double wire_voltage_v, shunt_voltage_v, displacement_m, force_n;
} mw_means;

mw_shakedown mw_shakedown_of(const mw_step_constants *k, double cycles);

/* Advance a wire in place at one drive voltage. Returns the number of fixed steps, 0 for chosen ones, or -1 if the fixed
 * step does not divide the duration; then nothing has changed. */
int mw_advance(mw_wire_state *state, const mw_step_constants *k, double drive_voltage_v, const mw_push *push,
               double duration_s, const mw_stepping *stepping, mw_means *means);

/* ---- at rest: mw_rest.c -------------------------------------------------------------------------------------------- */

/* What a step reads, from the constants. */
void mw_derive(const mw_wire_constants *of, mw_step_constants *to);

/* Cool the wire from hot to the air's temperature under its pretension: sets cold_strain and austenite_length_m of the
 * constants, derives from them, and puts the state at rest. */
void mw_at_rest(mw_wire_constants *constants, mw_step_constants *k, mw_wire_state *state);

#endif
