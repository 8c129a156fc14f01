/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The controller as a model: the exported library (musclewire.h), one sample each communication step. */
#include "mw_model.h"
#include "musclewire.h"

/* A sum of communication steps that is so near to the control period is the period. */
#define TIME_ROUNDING_S 1e-9

static const char *const event_names[] = MW_PROTECTION_EVENT_NAMES;
static const char *const state_names[] = MW_PROTECTION_STATE_NAMES;

struct mw_model {
    mw_controller controller;
    double since_control_s;
};

size_t mw_model_bytes(void)
{
    return sizeof(mw_model);
}

static void show(const mw_controller *controller, mw_output output, mw_values *values)
{
    values->real[MW_REAL_DRIVE_VOLTAGE_V] = output.drive_voltage_v;
    values->real[MW_REAL_RESISTANCE_OHM] = output.resistance_ohm;
    values->real[MW_REAL_ESTIMATE] = output.estimate;
    values->boolean[MW_BOOLEAN_ESTIMATE_VALID] = output.valid;
#if defined(MW_INVERSE_MODEL)
    values->real[MW_REAL_STEADY_POWER_W] = controller->answer.holding_w;
    values->real[MW_REAL_PENDING_HEAT_J] = controller->answer.due_j;
    values->boolean[MW_BOOLEAN_POWER_LIMITED] = controller->answer.limited;
#else
    values->real[MW_REAL_KP] = controller->kp;
    values->real[MW_REAL_KI] = controller->ki;
    values->real[MW_REAL_KD] = controller->kd;
#endif
    values->real[MW_REAL_ABOVE_AMBIENT_K] = controller->protection.above_ambient_k;
    values->integer[MW_INTEGER_PROTECTION_STATE] = output.state;
    values->integer[MW_INTEGER_PROTECTION_EVENT] = output.event;
}

mw_outcome mw_model_start(mw_model *model, mw_values *values, mw_message *message)
{
    (void)message;
    mw_start(&model->controller);
    model->since_control_s = 0.0;
    /* A control tick without a sample leaves the drive at the sense voltage, and is not done. */
    show(&model->controller,
         (mw_output){mw_protect_allowed(&model->controller.protection), 0, model->controller.estimation.value, 0,
                     model->controller.protection.state, model->controller.protection.event},
         values);
    return MW_DONE;
}

mw_outcome mw_model_step(mw_model *model, mw_values *values, double time_s, double duration_s, mw_message *message)
{
    mw_controller *controller = &model->controller;
    const uint8_t event = controller->protection.event;
    mw_output output = mw_sample(controller, values->real[MW_REAL_WIRE_VOLTAGE_V], values->real[MW_REAL_SHUNT_VOLTAGE_V],
                                 duration_s);
    model->since_control_s += duration_s;
    if (model->since_control_s > values->real[MW_REAL_CONTROL_PERIOD_S] - TIME_ROUNDING_S) {
        output = mw_control(controller, values->real[MW_REAL_TARGET], model->since_control_s);
        model->since_control_s = 0.0;
    }
    show(controller, output, values);
    if (output.event == event || !output.event)
        return MW_DONE;
    mw_say(message, "protection", "at %.9g s %s: the state is now %s, the drive %g V", time_s + duration_s,
           event_names[output.event], state_names[output.state], (double)output.drive_voltage_v);
    return MW_WARNED;
}
