/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The FMI 2.0 co-simulation functions: instances, the order of calls, and steps. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mw_instance.h"

void mw_say(mw_message *message, const char *owner, const char *format, ...)
{
    va_list values;
    char *at;
    va_start(values, format);
    message->owner = owner;
    vsnprintf(message->text, sizeof message->text, format, values);
    va_end(values);
    /* A tool's logger takes the message for a format, as printf does. */
    for (at = message->text; *at; at++)
        if (*at == '%')
            *at = '?';
}

size_t mw_snapshot_bytes(void)
{
    return sizeof(mw_snapshot) + mw_model_bytes();
}

/* The model's bytes begin where the snapshot ends; its size is a multiple of a double's. */
mw_model *mw_model_of(mw_snapshot *state)
{
    return (mw_model *)(state + 1);
}

fmi2Status mw_tell(mw_instance *of, fmi2Status status)
{
    if (of->functions.logger)
        of->functions.logger(of->functions.componentEnvironment, of->name, status, of->message.owner,
                             of->message.text);
    return status;
}

fmi2Status mw_fail(mw_instance *of)
{
    of->now->phase = MW_IN_ERROR;
    return mw_tell(of, fmi2Error);
}

fmi2Status mw_wrong_call(mw_instance *of, const char *call, const char *when)
{
    mw_say(&of->message, "caller", "%s can only be called %s", call, when);
    return mw_fail(of);
}

fmi2Status mw_status_of(mw_instance *of, mw_outcome outcome)
{
    switch (outcome) {
    case MW_DONE: return fmi2OK;
    case MW_WARNED: return mw_tell(of, fmi2Warning);
    case MW_RETRY: return mw_tell(of, fmi2Discard);
    default: return mw_fail(of);
    }
}

static void restart(mw_instance *of)
{
    memset(of->now, 0, mw_snapshot_bytes());
    of->now->phase = MW_INSTANTIATED;
    mw_take_start_values(&of->now->values);
}

fmi2Status mw_start_model(mw_instance *of)
{
    mw_outcome outcome;
    if (of->now->started)
        return fmi2OK;
    outcome = mw_model_start(mw_model_of(of->now), &of->now->values, &of->message);
    of->now->started = outcome == MW_DONE || outcome == MW_WARNED;
    return mw_status_of(of, outcome == MW_RETRY ? MW_FAILED : outcome);
}

/* ---- instances ---------------------------------------------------------------------------------------------------- */

MW_EXPORTED const char *MW_FMI(fmi2GetTypesPlatform)(void)
{
    return "default";
}

MW_EXPORTED const char *MW_FMI(fmi2GetVersion)(void)
{
    return "2.0";
}

static void release(mw_instance *of)
{
    if (!of)
        return;
    free(of->now);
    free(of->before);
    free(of->name);
    free(of);
}

static mw_instance *made(fmi2String name, const fmi2CallbackFunctions *functions)
{
    mw_instance *of = calloc(1, sizeof *of);
    const size_t length = name ? strlen(name) : 0;
    if (!of)
        return NULL;
    if (functions)
        of->functions = *functions;
    of->name = calloc(length + 1, 1);
    of->now = calloc(1, mw_snapshot_bytes());
    of->before = calloc(1, mw_snapshot_bytes());
    if (!of->name || !of->now || !of->before) {
        release(of);
        return NULL;
    }
    if (length)
        memcpy(of->name, name, length);
    return of;
}

MW_EXPORTED fmi2Component MW_FMI(fmi2Instantiate)(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                                  const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                                  fmi2Boolean logging)
{
    mw_instance *of = made(name, functions);
    (void)resources, (void)visible, (void)logging;
    if (!of)
        return NULL;
    if (type != fmi2CoSimulation) {
        mw_say(&of->message, "caller", "this FMU is for co-simulation: it has no model exchange");
    } else if (!guid || strcmp(guid, MW_GUID) != 0) {
        mw_say(&of->message, "caller", "the GUID %s is not %s, that of this binary: modelDescription.xml and binary "
               "are of two different exports", guid ? guid : "(none)", MW_GUID);
    } else {
        restart(of);
        return of;
    }
    mw_tell(of, fmi2Error);
    release(of);
    return NULL;
}

MW_EXPORTED void MW_FMI(fmi2FreeInstance)(fmi2Component component)
{
    release(component);
}

/* All messages are warnings or worse and are always sent, so there is nothing to switch. */
MW_EXPORTED fmi2Status MW_FMI(fmi2SetDebugLogging)(fmi2Component component, fmi2Boolean on, size_t count,
                                                   const fmi2String categories[])
{
    (void)component, (void)on, (void)count, (void)categories;
    return fmi2OK;
}

/* ---- the order of calls ------------------------------------------------------------------------------------------- */

MW_EXPORTED fmi2Status MW_FMI(fmi2SetupExperiment)(fmi2Component component, fmi2Boolean tolerance_defined,
                                                   fmi2Real tolerance, fmi2Real start_s, fmi2Boolean stop_defined,
                                                   fmi2Real stop_s)
{
    mw_instance *of = component;
    (void)tolerance_defined, (void)tolerance, (void)stop_defined, (void)stop_s;
    if (of->now->phase != MW_INSTANTIATED)
        return mw_wrong_call(of, "fmi2SetupExperiment", "before initialization");
    of->now->time_s = start_s;
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2EnterInitializationMode)(fmi2Component component)
{
    mw_instance *of = component;
    if (of->now->phase != MW_INSTANTIATED)
        return mw_wrong_call(of, "fmi2EnterInitializationMode", "once, after instantiation or fmi2Reset");
    of->now->phase = MW_INITIALIZING;
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2ExitInitializationMode)(fmi2Component component)
{
    mw_instance *of = component;
    fmi2Status status;
    if (of->now->phase != MW_INITIALIZING)
        return mw_wrong_call(of, "fmi2ExitInitializationMode", "in initialization mode");
    status = mw_start_model(of);
    if (status <= fmi2Warning)
        of->now->phase = MW_STEPPING;
    return status;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2Terminate)(fmi2Component component)
{
    mw_instance *of = component;
    if (of->now->phase != MW_STEPPING)
        return mw_wrong_call(of, "fmi2Terminate", "after initialization");
    of->now->phase = MW_TERMINATED;
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2Reset)(fmi2Component component)
{
    restart(component);
    return fmi2OK;
}

/* ---- steps -------------------------------------------------------------------------------------------------------- */

/* Communication points are sums of step sizes, each master adding in its own way: so near is the same point. */
static int same_time(double asked_s, double known_s, double step_s)
{
    const double difference = asked_s > known_s ? asked_s - known_s : known_s - asked_s;
    const double size = known_s > 0 ? known_s : -known_s;
    return difference <= 1e-6 * step_s + 1e-9 * size;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2DoStep)(fmi2Component component, fmi2Real time_s, fmi2Real step_s,
                                          fmi2Boolean no_state_before)
{
    mw_instance *of = component;
    mw_outcome outcome;
    (void)no_state_before;
    if (of->now->phase != MW_STEPPING)
        return mw_wrong_call(of, "fmi2DoStep", "between fmi2ExitInitializationMode and fmi2Terminate, and not after an error");
    if (!(step_s > 0.0 && step_s < 1e9)) {
        mw_say(&of->message, "caller", "the communication step at %.9g s is %g s: give a positive one", time_s, step_s);
        return mw_fail(of);
    }
    if (!same_time(time_s, of->now->time_s, step_s)) {
        mw_say(&of->message, "caller", "the communication point is %.9g s, and the last step ended at %.9g s: do not "
               "leave a step out, and repeat none", time_s, of->now->time_s);
        return mw_fail(of);
    }
    memcpy(of->before, of->now, mw_snapshot_bytes());
    outcome = mw_model_step(mw_model_of(of->now), &of->now->values, time_s, step_s, &of->message);
    if (outcome == MW_DONE || outcome == MW_WARNED)
        of->now->time_s = time_s + step_s;
    else
        memcpy(of->now, of->before, mw_snapshot_bytes());
    return mw_status_of(of, outcome);
}

MW_EXPORTED fmi2Status MW_FMI(fmi2CancelStep)(fmi2Component component)
{
    return mw_wrong_call(component, "fmi2CancelStep", "for a step that is pending, and these steps never are");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SetRealInputDerivatives)(fmi2Component component, const fmi2ValueReference references[],
                                                           size_t count, const fmi2Integer orders[],
                                                           const fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return count ? mw_wrong_call(component, "fmi2SetRealInputDerivatives", "by nobody: inputs are held over a step") : fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetRealOutputDerivatives)(fmi2Component component,
                                                            const fmi2ValueReference references[], size_t count,
                                                            const fmi2Integer orders[], fmi2Real values[])
{
    (void)references, (void)orders, (void)values;
    return count ? mw_wrong_call(component, "fmi2GetRealOutputDerivatives", "by nobody: there are none") : fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetStatus)(fmi2Component component, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)component, (void)kind, (void)value;
    return fmi2Discard;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetRealStatus)(fmi2Component component, const fmi2StatusKind kind, fmi2Real *value)
{
    mw_instance *of = component;
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = of->now->time_s;
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetIntegerStatus)(fmi2Component component, const fmi2StatusKind kind,
                                                    fmi2Integer *value)
{
    (void)component, (void)kind, (void)value;
    return fmi2Discard;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetBooleanStatus)(fmi2Component component, const fmi2StatusKind kind,
                                                    fmi2Boolean *value)
{
    (void)component;
    if (kind != fmi2Terminated)
        return fmi2Discard;
    *value = 0; /* a model never asks to end the simulation */
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetStringStatus)(fmi2Component component, const fmi2StatusKind kind, fmi2String *value)
{
    (void)component, (void)kind, (void)value;
    return fmi2Discard;
}

/* ---- what is not offered: modelDescription.xml says so, and tools ask for the names all the same --------------------- */

static fmi2Status not_offered(fmi2Component component, const char *call)
{
    return mw_wrong_call(component, call, "by nobody: this FMU does not offer it");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetFMUstate)(fmi2Component component, fmi2FMUstate *state)
{
    (void)state;
    return not_offered(component, "fmi2GetFMUstate");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SetFMUstate)(fmi2Component component, fmi2FMUstate state)
{
    (void)state;
    return not_offered(component, "fmi2SetFMUstate");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2FreeFMUstate)(fmi2Component component, fmi2FMUstate *state)
{
    (void)state;
    return not_offered(component, "fmi2FreeFMUstate");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SerializedFMUstateSize)(fmi2Component component, fmi2FMUstate state, size_t *bytes)
{
    (void)state, (void)bytes;
    return not_offered(component, "fmi2SerializedFMUstateSize");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SerializeFMUstate)(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                                     size_t count)
{
    (void)state, (void)bytes, (void)count;
    return not_offered(component, "fmi2SerializeFMUstate");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2DeSerializeFMUstate)(fmi2Component component, const fmi2Byte bytes[], size_t count,
                                                       fmi2FMUstate *state)
{
    (void)bytes, (void)count, (void)state;
    return not_offered(component, "fmi2DeSerializeFMUstate");
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetDirectionalDerivative)(fmi2Component component,
                                                            const fmi2ValueReference unknown[], size_t unknowns,
                                                            const fmi2ValueReference known[], size_t knowns,
                                                            const fmi2Real by_known[], fmi2Real of_unknown[])
{
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)by_known, (void)of_unknown;
    return not_offered(component, "fmi2GetDirectionalDerivative");
}
