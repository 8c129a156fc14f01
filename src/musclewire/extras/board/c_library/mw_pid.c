/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The fuzzy-tuned PID in velocity form. The law and its reasons are in musclewire's controllers/fuzzy_pid.py;
 * the order of operations is that of controllers/kernels.py. */
#include "musclewire.h"

#if !defined(MW_INVERSE_MODEL)

static uint8_t is_number(mw_real value)
{
    return value >= -MW_LARGEST && value <= MW_LARGEST;
}

/* In this order a drive that is not a number becomes the sense voltage, never the maximum. */
static mw_real limited(mw_real drive_voltage_v)
{
    if (!(drive_voltage_v > MW_SENSE_VOLTAGE_V))
        return MW_SENSE_VOLTAGE_V;
    return drive_voltage_v < MW_MAXIMUM_VOLTAGE_V ? drive_voltage_v : MW_MAXIMUM_VOLTAGE_V;
}

static mw_real gain(mw_real ratio, mw_real minimum, mw_real maximum)
{
    return (maximum - minimum) * ratio + minimum; /* Eq. 6 */
}

void mw_fuzzy_pid_start(mw_pid *pid, mw_real drive_voltage_v, mw_real measured, mw_real target)
{
    pid->drive_voltage_v = limited(drive_voltage_v);
    pid->error = target - measured;
    pid->measured = measured;
    pid->measured_rate = 0;
    pid->error_rate = 0;
    pid->rates_known = 1;
}

void mw_fuzzy_pid_hold(mw_pid *pid)
{
    pid->measured_rate = 0;
    pid->error_rate = 0;
    pid->rates_known = 0;
}

static mw_pid_step held(mw_pid *pid)
{
    mw_pid_step step = {0, 0, 0, 0};
    mw_fuzzy_pid_hold(pid);
    step.drive_voltage_v = pid->drive_voltage_v;
    return step;
}

mw_pid_step mw_fuzzy_pid_step(mw_pid *pid, mw_real target, mw_real measured, mw_real dt_s)
{
    const mw_real error = target - measured;
    mw_real measured_rate = 0, error_rate = 0, proportional, integral, derivative;
    mw_pid_step step;
    mw_ratios ratios;
    if (!is_number(error) || !(dt_s > 0 && dt_s <= MW_LARGEST))
        return held(pid);
    if (pid->rates_known) {
        /* backward Euler of a first-order lag: stable whatever the tick, no lag at all for a zero constant */
        const mw_real weight = dt_s / (MW_DERIVATIVE_FILTER_S + dt_s);
        measured_rate = pid->measured_rate + weight * ((measured - pid->measured) / dt_s - pid->measured_rate);
        error_rate = pid->error_rate + weight * ((error - pid->error) / dt_s - pid->error_rate);
        if (!is_number(measured_rate + error_rate))
            return held(pid);
    }
    ratios = mw_infer(error / MW_ERROR_UNIT / MW_ERROR_RANGE, error_rate / MW_ERROR_UNIT / MW_CHANGE_RANGE);
    step.kp = gain(ratios.kp, MW_KP_MINIMUM, MW_KP_MAXIMUM);
    step.ki = gain(ratios.ki, MW_KI_MINIMUM, MW_KI_MAXIMUM);
    step.kd = gain(ratios.kd, MW_KD_MINIMUM, MW_KD_MAXIMUM);
    proportional = step.kp * (error - pid->error);
    integral = step.ki * dt_s * error;
    derivative = step.kd * (measured_rate - pid->measured_rate);
    step.drive_voltage_v = limited(pid->drive_voltage_v
                                   + MW_INPUT_SCALE * (proportional + integral - derivative) / MW_ERROR_UNIT);
    pid->drive_voltage_v = step.drive_voltage_v;
    pid->error = error;
    pid->measured = measured;
    pid->measured_rate = measured_rate;
    pid->error_rate = error_rate;
    pid->rates_known = 1;
    return step;
}

#else
typedef int mw_no_pid; /* the library was exported with the inverse of the wire's model */
#endif
