/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* musclewire: position a shape-memory-alloy wire by its own electrical resistance, without a sensor.
 *
 * One tick: two voltages -> resistance (Eq. 1) -> estimate (Eqs. 3 to 5) -> fuzzy-tuned PID (Eq. 6), or the inverse of
 * the wire's model -> limits -> protection -> drive voltage. Equations are those of Lan and Fan 2010. SI units throughout, unit last in the
 * name. No allocation, no global that is written, no library function: not even libm. All state is in the
 * caller's structures, one for each wire. Numbers of the model, controller, limits and protection are in
 * mw_constants.h, which `musclewire export c` wrote; these files are the same for every model.
 */
#ifndef MUSCLEWIRE_H
#define MUSCLEWIRE_H

#include "mw_real.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- sensing: mw_sensing.c ---------------------------------------------------------------------------- */

/* Resistance of the wire [ohm] from its voltage and the shunt's [V], Eq. 1. 0 means "no current, so no
 * resistance": a current below the minimum, a voltage that is not finite, or swapped leads. */
mw_real mw_resistance(mw_real wire_voltage_v, mw_real shunt_voltage_v);

typedef struct {
    mw_real value; /* the model's quantity, SI: strain as a fraction, displacement in m, force in N */
    uint8_t valid; /* 0 if the resistance is outside the model's range */
} mw_estimation;

/* Quantity at a resistance, Eqs. 3 to 5. Outside the valid range it is that of the nearer end; a resistance that
 * is not finite reads as fully contracted, so that a loop which ignores `valid` cools. */
mw_estimation mw_estimate(mw_real resistance_ohm);

/* ---- an estimate that remembers: mw_filter.c, if exported with --estimator filter ------------------------ */

/* What it remembers of a wire; cleared to zero before its first sample. */
#if defined(MW_FILTER)
typedef struct {
    mw_real value, std;                     /* the quantity, and its standard deviation */
    mw_real steady_w, place, shift_w, loss; /* power that would hold it, place, other air, factor of the heat loss */
    mw_real covariance[10];                 /* of these four: the lower triangle, row by row */
    mw_real unrest; /* by how much readings surprise of late: mean square, in what the covariance expects */
    mw_real before, before_last, noise_v2, learnt_s, waited_s;
    uint8_t followed;
#if defined(MW_INVERSE_MODEL)
    mw_real part;       /* 0 on the cooling branch, 1 on the heating branch */
    mw_real measured_w; /* electrical power over the sample */
    uint8_t cold;       /* before B, where the quantity does not count */
#endif
} mw_follower;

/* Quantity after one more reading, dt_s after the one before; 0 ohm for none. A resistance that the model's wire never
 * has leaves the value as it is and is not valid; nor is a wire that is colder than B, or a reading outside the model's
 * range. */
mw_estimation mw_follow(mw_follower *follower, mw_real resistance_ohm, mw_real wire_voltage_v, mw_real shunt_voltage_v,
                        mw_real dt_s);
#elif defined(MW_INVERSE_MODEL)
/* Standard deviation of the quantity that mw_estimate returns, for a resistance above 0. */
mw_real mw_deviation(mw_real resistance_ohm);
#endif

/* ---- functions without libm: mw_exponential.c, mw_root.c ---------------------------------------------- */

/* e^x for -4 <= x <= 0 by arithmetic alone, so that every target gives the same bits (libm's differ). */
mw_real mw_exponential(mw_real x);

/* The square root, rounded to nearest; of what is not a positive normal number 0. */
mw_real mw_root(mw_real x);

#if defined(MW_INVERSE_MODEL)
/* ---- the inverse of the wire's model: mw_inverse_model.c, if exported with --controller inverse-model -------- */

/* What it remembers; mw_inverse_model_start before the first step. */
typedef struct {
    mw_real drive_voltage_v; /* the drive [V] that is applied, */
    mw_real power_w;         /* and the power [W] that it should give */
    mw_real given_part;      /* what part of that power the wire is given */
    mw_real holding_w;       /* the power [W] that holds the wire */
    mw_real target;          /* the last target, */
    mw_real moved;           /* and by how much it was another than the one before */
    mw_real balance_w;       /* for an estimate without a state the steady power [W], */
    mw_real loss;            /* how much heat today's air takes, in that of still air, */
    mw_real value;           /* and the last value */
    uint8_t started;         /* 1 once there has been an estimate */
} mw_inverse_model;

/* What is known of the wire at a sample with current. */
typedef struct {
    mw_real value, std; /* the quantity, and its standard deviation */
    uint8_t cold;       /* 1 before B, where the quantity does not count */
    uint8_t wire_known; /* 0 for an estimate that knows the quantity alone: what follows is not read */
    mw_real balance_w;  /* power that would hold the wire's present temperature in the air of the characterization */
    mw_real part;       /* 0 on the cooling branch, 1 on the heating branch */
    mw_real shift_w;    /* power by which today's air shifts both branches */
    mw_real loss;       /* loss to the air over that of the characterization */
    mw_real measured_w; /* electrical power over the sample */
} mw_sensed;

typedef struct {
    mw_real drive_voltage_v;
    mw_real holding_w; /* power that holds the wire */
    mw_real due_j;     /* heat that it has still to be given or, if negative, to let go */
    uint8_t limited;   /* 1 where the highest permitted temperature holds power back */
} mw_inverse_model_answer;

/* Take over from the present drive. */
void mw_inverse_model_start(mw_inverse_model *own, mw_real drive_voltage_v);

/* Advance by dt_s (above 0). Inputs that are not finite leave drive and state as they are. */
mw_inverse_model_answer mw_inverse_model_step(mw_inverse_model *own, mw_real target, const mw_sensed *sensed, mw_real dt_s);

/* A tick without a measurement: the drive stays. */
mw_inverse_model_answer mw_inverse_model_hold(const mw_inverse_model *own);

#else
/* ---- fuzzy inference: mw_fuzzy.c ---------------------------------------------------------------------- */

typedef struct {
    mw_real kp, ki, kd; /* K_p', K_I', K_D' of Eq. 6, each in [0, 1] */
} mw_ratios;

/* The three gain ratios for an error and its change, each clipped to [-1, 1]. */
mw_ratios mw_infer(mw_real error_ratio, mw_real change_ratio);

/* ---- fuzzy PID: mw_pid.c ------------------------------------------------------------------------------ */

typedef struct {
    mw_real drive_voltage_v, error, measured, measured_rate, error_rate;
    uint8_t rates_known; /* 0 after a hold: the last measurement is too old to make a rate with */
} mw_pid;

typedef struct {
    mw_real drive_voltage_v, kp, ki, kd;
} mw_pid_step;

/* Take over from the present drive without a jump. */
void mw_fuzzy_pid_start(mw_pid *pid, mw_real drive_voltage_v, mw_real measured, mw_real target);

/* Advance by dt_s (above 0): velocity form, Eq. 6, drive kept between sense voltage and maximum. Inputs that
 * are not finite, or whose rates overflow, leave the drive as it is and clear the rates, as mw_fuzzy_pid_hold. */
mw_pid_step mw_fuzzy_pid_step(mw_pid *pid, mw_real target, mw_real measured, mw_real dt_s);

/* A tick without a measurement: the drive stays, the rates are cleared. */
void mw_fuzzy_pid_hold(mw_pid *pid);
#endif

#ifdef __cplusplus
}
#endif

#include "mw_protect.h"

#ifdef __cplusplus
extern "C" {
#endif

/* ---- the whole tick: mw_controller.c ------------------------------------------------------------------ */

/* Samples that make one reading of the protection. */
typedef struct {
    mw_real drive_sum_v, wire_sum_v, shunt_sum_v, time_s;
    mw_real ordered_v; /* the highest drive among them */
    uint16_t samples;
} mw_block;

typedef struct mw_controller {
#if defined(MW_INVERSE_MODEL)
    mw_inverse_model inverse_model;
    mw_inverse_model_answer answer;  /* of the last step, 0 where there was none */
#else
    mw_pid pid;
#endif
    mw_protection protection;
    mw_block block;
    mw_real wire_sum_v, shunt_sum_v; /* of the samples since the last mw_control */
    uint16_t samples;
    uint8_t started;                 /* the controller has seen a first measurement */
    mw_real resistance_ohm;          /* of the last mw_control, 0 without current */
    mw_estimation estimation;
#if defined(MW_FILTER)
    mw_follower follower;
#endif
#if !defined(MW_INVERSE_MODEL)
    mw_real kp, ki, kd;              /* gains of the last step, 0 where there was none */
#endif
} mw_controller;

typedef struct {
    mw_real drive_voltage_v; /* what to put out now */
    mw_real resistance_ohm;  /* 0 without current */
    mw_real estimate;
    uint8_t valid;           /* the estimate's */
    uint8_t state;           /* MW_STATE_... */
    uint8_t event;           /* MW_EVENT_..., 0 for none */
} mw_output;

/* Start cold: the drive is the sense voltage, nothing is known of the wire, the protection is armed. */
void mw_start(mw_controller *controller);

/* The same after a run: a trip is cleared, the wire's estimated temperature is kept. */
void mw_start_again(mw_controller *controller);

/* One converter tick of tick_s: add to the mean and run the protection. A trip shows in the output. A tick_s that is not
 * a number above 0 trips, because the protection's times depend on it. */
mw_output mw_sample(mw_controller *controller, mw_real wire_voltage_v, mw_real shunt_voltage_v, mw_real tick_s);

/* One control tick of dt_s, with the mean of the samples since the last one: estimate, controller, limits. The first one
 * after mw_start or mw_drive takes over from the present drive. A target that is not a number trips, as does a drive
 * outside 0 to the maximum. */
mw_output mw_control(mw_controller *controller, mw_real target, mw_real dt_s);

/* Open loop instead of mw_control: a drive voltage of the caller's, under the same protection. */
mw_output mw_drive(mw_controller *controller, mw_real drive_voltage_v);

/* Both at once, for loops in which every sample is a control tick. */
mw_output mw_tick(mw_controller *controller, mw_real wire_voltage_v, mw_real shunt_voltage_v, mw_real target,
                  mw_real dt_s);

#ifdef __cplusplus
}
#endif

#endif
