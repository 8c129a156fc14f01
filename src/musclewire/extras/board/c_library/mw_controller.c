/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The whole tick: means of the samples, estimate, controller, and the protection below them. */
#include "musclewire.h"

void mw_start(mw_controller *controller)
{
    const mw_controller cold = {.estimation = {MW_QUANTITY_MIN, 0}};
    *controller = cold;
#if defined(MW_FILTER)
    controller->follower.value = MW_QUANTITY_MIN;
#endif
    mw_protect_arm(&controller->protection);
}

void mw_start_again(mw_controller *controller)
{
    const mw_protection before = controller->protection;
    mw_start(controller);
    controller->protection = before;
    mw_protect_arm_again(&controller->protection);
}

static mw_output output_of(const mw_controller *controller)
{
    mw_output output;
    output.drive_voltage_v = mw_protect_allowed(&controller->protection);
    output.resistance_ohm = controller->resistance_ohm;
    output.estimate = controller->estimation.value;
    output.valid = controller->estimation.valid;
    output.state = controller->protection.state;
    output.event = controller->protection.event;
    return output;
}

static void forget_samples(mw_controller *controller)
{
    controller->wire_sum_v = controller->shunt_sum_v = 0;
    controller->samples = 0;
}

mw_output mw_sample(mw_controller *controller, mw_real wire_voltage_v, mw_real shunt_voltage_v, mw_real tick_s)
{
    const mw_real drive_voltage_v = mw_protect_allowed(&controller->protection);
    mw_block *block = &controller->block;
    /* Without a time step no block would ever be full, and nothing would be judged. Written so that a NaN trips. */
    if (!(tick_s > 0 && tick_s <= MW_LARGEST)) {
        mw_protect_trip(&controller->protection, MW_EVENT_CLOCK_BACKWARDS);
        return output_of(controller);
    }
    if (controller->samples == UINT16_MAX)
        forget_samples(controller); /* no control tick has used them in all this time */
    controller->wire_sum_v += wire_voltage_v;
    controller->shunt_sum_v += shunt_voltage_v;
    controller->samples++;
    block->drive_sum_v += drive_voltage_v;
    if (drive_voltage_v > block->ordered_v)
        block->ordered_v = drive_voltage_v;
    block->wire_sum_v += wire_voltage_v;
    block->shunt_sum_v += shunt_voltage_v;
    block->time_s += tick_s;
    block->samples++;
    if (mw_microseconds(block->time_s) >= MW_READING_PERIOD_US) {
        const mw_block empty = {0, 0, 0, 0, 0, 0};
        const mw_real samples = (mw_real)block->samples;
        mw_protect_reading(&controller->protection, block->drive_sum_v / samples, block->wire_sum_v / samples,
                           block->shunt_sum_v / samples, block->ordered_v, block->time_s);
        *block = empty;
    }
    return output_of(controller);
}

/* Resistance and estimate from the mean of the samples since the last control tick. */
static void sense(mw_controller *controller, mw_real dt_s)
{
    const mw_real samples = (mw_real)controller->samples;
    mw_real wire_voltage_v = 0, shunt_voltage_v = 0;
    if (controller->samples > 0) {
        wire_voltage_v = controller->wire_sum_v / samples;
        shunt_voltage_v = controller->shunt_sum_v / samples;
    }
    forget_samples(controller);
    controller->resistance_ohm = mw_resistance(wire_voltage_v, shunt_voltage_v);
#if defined(MW_FILTER)
    controller->estimation =
        mw_follow(&controller->follower, controller->resistance_ohm, wire_voltage_v, shunt_voltage_v, dt_s);
#else
    (void)dt_s;
    if (controller->resistance_ohm > 0)
        controller->estimation = mw_estimate(controller->resistance_ohm);
    else
        controller->estimation.valid = 0;
#endif
}

#if defined(MW_INVERSE_MODEL)
/* What is known of the wire; of an estimate that knows the quantity alone only that. */
static mw_sensed sensed_of(const mw_controller *controller)
{
    mw_sensed sensed = {.value = controller->estimation.value};
#if defined(MW_FILTER)
    const mw_follower *follower = &controller->follower;
    sensed.std = follower->std;
    sensed.cold = follower->cold;
#else
    sensed.std = mw_deviation(controller->resistance_ohm);
#endif
#if defined(MW_FILTER)
    sensed.wire_known = 1;
    sensed.balance_w = follower->steady_w;
    sensed.part = follower->part;
    sensed.shift_w = follower->shift_w;
    sensed.loss = follower->loss;
    sensed.measured_w = follower->measured_w;
#endif
    return sensed;
}

static mw_real controlled(mw_controller *controller, mw_real target, mw_real dt_s)
{
    const mw_sensed sensed = sensed_of(controller);
    if (!controller->started) {
        mw_inverse_model_start(&controller->inverse_model, mw_protect_allowed(&controller->protection));
        controller->started = 1;
    }
    controller->answer = mw_inverse_model_step(&controller->inverse_model, target, &sensed, dt_s);
    return controller->answer.drive_voltage_v;
}

static mw_real without_current(mw_controller *controller)
{
    const mw_inverse_model_answer none = {mw_protect_allowed(&controller->protection), 0, 0, 0};
    controller->answer = controller->started ? mw_inverse_model_hold(&controller->inverse_model) : none;
    return controller->answer.drive_voltage_v;
}
#else
/* The drive that the controller commands for an estimate. */
static mw_real controlled(mw_controller *controller, mw_real target, mw_real dt_s)
{
    mw_pid_step step;
    if (!controller->started) {
        mw_fuzzy_pid_start(&controller->pid, mw_protect_allowed(&controller->protection),
                           controller->estimation.value, target);
        controller->started = 1;
    }
    step = mw_fuzzy_pid_step(&controller->pid, target, controller->estimation.value, dt_s);
    controller->kp = step.kp;
    controller->ki = step.ki;
    controller->kd = step.kd;
    return step.drive_voltage_v;
}

/* A tick without a resistance, because no current flows: the drive stays as it is. */
static mw_real without_current(mw_controller *controller)
{
    controller->kp = controller->ki = controller->kd = 0;
    if (!controller->started)
        return mw_protect_allowed(&controller->protection);
    mw_fuzzy_pid_hold(&controller->pid);
    return controller->pid.drive_voltage_v;
}
#endif

mw_output mw_control(mw_controller *controller, mw_real target, mw_real dt_s)
{
    mw_real drive_voltage_v = -1; /* refused: what a target that is not a number leads to */
    sense(controller, dt_s);
    if (target >= -MW_LARGEST && target <= MW_LARGEST)
        drive_voltage_v =
            controller->resistance_ohm > 0 ? controlled(controller, target, dt_s) : without_current(controller);
    mw_protect_command(&controller->protection, drive_voltage_v);
    return output_of(controller);
}

mw_output mw_drive(mw_controller *controller, mw_real drive_voltage_v)
{
    controller->started = 0;
#if defined(MW_FILTER)
    controller->follower.followed = 0; /* what it remembers is from before */
#endif
    forget_samples(controller);
    mw_protect_command(&controller->protection, drive_voltage_v);
    return output_of(controller);
}

mw_output mw_tick(mw_controller *controller, mw_real wire_voltage_v, mw_real shunt_voltage_v, mw_real target,
                  mw_real dt_s)
{
    mw_sample(controller, wire_voltage_v, shunt_voltage_v, dt_s);
    return mw_control(controller, target, dt_s);
}
