/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The FMI 2.0 functions that get and set variables by their references. */
#include "mw_instance.h"

static const mw_variable reals[MW_REALS + 1] = MW_REAL_TABLE;
static const mw_variable integers[MW_INTEGERS + 1] = MW_INTEGER_TABLE;
static const mw_variable booleans[MW_BOOLEANS + 1] = MW_BOOLEAN_TABLE;
static const size_t real_count = MW_REALS, integer_count = MW_INTEGERS, boolean_count = MW_BOOLEANS;

void mw_take_start_values(mw_values *values)
{
    size_t index;
    for (index = 0; index < real_count; index++)
        values->real[index] = reals[index].start;
    for (index = 0; index < integer_count; index++)
        values->integer[index] = (int)integers[index].start;
    for (index = 0; index < boolean_count; index++)
        values->boolean[index] = booleans[index].start != 0.0;
}

static fmi2Status unknown_reference(mw_instance *of, fmi2ValueReference reference, const char *type)
{
    mw_say(&of->message, "caller", "there is no %s variable with value reference %u", type, reference);
    return mw_fail(of);
}

/* Whether a value is within a variable's bounds; a NaN is not. What has no bounds is the model's to judge. */
static int within(const mw_variable *variable, double value)
{
    if (variable->minimum <= -DBL_MAX && variable->maximum >= DBL_MAX)
        return 1;
    return value >= variable->minimum && value <= variable->maximum;
}

/* Whether a variable may be set now, to this value. */
static fmi2Status check_set(mw_instance *of, const mw_variable *variable, double value)
{
    const mw_phase now = of->now->phase;
    if (now == MW_IN_ERROR || now == MW_TERMINATED)
        return mw_wrong_call(of, "fmi2Set...", "until an error or fmi2Terminate: call fmi2Reset");
    if (variable->role == MW_OUTPUT || variable->role == MW_CONSTANT) {
        mw_say(&of->message, "caller", "%s cannot be set: it is computed", variable->name);
        return mw_fail(of);
    }
    if (variable->role == MW_FIXED && now == MW_STEPPING) {
        mw_say(&of->message, "caller", "%s is fixed: set it before the end of initialization", variable->name);
        return mw_fail(of);
    }
    if (!within(variable, value)) {
        mw_say(&of->message, "caller", "%s is %g at %.9g s: give %g to %g", variable->name, value, of->now->time_s,
               variable->minimum, variable->maximum);
        return mw_fail(of);
    }
    if (now != MW_STEPPING)
        of->now->started = 0;
    return fmi2OK;
}

/* Outputs that are read before the first step are those of the model at rest. */
static fmi2Status ready_to_get(mw_instance *of)
{
    return of->now->phase == MW_INITIALIZING ? mw_start_model(of) : fmi2OK;
}

#define MW_GET_AND_SET(TYPE, LABEL, FIRST, COUNT, TABLE, MEMBER)                                                       \
    MW_EXPORTED fmi2Status MW_FMI(fmi2Get##TYPE)(fmi2Component component, const fmi2ValueReference references[],       \
                                                 size_t count, fmi2##TYPE values[])                                    \
    {                                                                                                                  \
        mw_instance *of = component;                                                                                      \
        fmi2Status status = ready_to_get(of);                                                                          \
        size_t index;                                                                                                  \
        for (index = 0; index < count && status <= fmi2Warning; index++) {                                             \
            const size_t place = (size_t)references[index] - (FIRST);                                                  \
            if (place >= (COUNT))                                                                                      \
                return unknown_reference(of, references[index], LABEL);                                                \
            values[index] = of->now->values.MEMBER[place];                                                             \
        }                                                                                                              \
        return status;                                                                                                 \
    }                                                                                                                  \
    MW_EXPORTED fmi2Status MW_FMI(fmi2Set##TYPE)(fmi2Component component, const fmi2ValueReference references[],       \
                                                 size_t count, const fmi2##TYPE values[])                              \
    {                                                                                                                  \
        mw_instance *of = component;                                                                                      \
        size_t index;                                                                                                  \
        for (index = 0; index < count; index++) {                                                                      \
            const size_t place = (size_t)references[index] - (FIRST);                                                  \
            if (place >= (COUNT))                                                                                      \
                return unknown_reference(of, references[index], LABEL);                                                \
            if (check_set(of, &TABLE[place], (double)values[index]) != fmi2OK)                                         \
                return fmi2Error;                                                                                      \
            of->now->values.MEMBER[place] = values[index];                                                             \
        }                                                                                                              \
        return fmi2OK;                                                                                                 \
    }

MW_GET_AND_SET(Real, "Real", MW_FIRST_REAL, real_count, reals, real)
MW_GET_AND_SET(Integer, "Integer", MW_FIRST_INTEGER, integer_count, integers, integer)
MW_GET_AND_SET(Boolean, "Boolean", MW_FIRST_BOOLEAN, boolean_count, booleans, boolean)

MW_EXPORTED fmi2Status MW_FMI(fmi2GetString)(fmi2Component component, const fmi2ValueReference references[],
                                             size_t count, fmi2String values[])
{
    (void)values;
    return count ? unknown_reference(component, references[0], "String") : fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SetString)(fmi2Component component, const fmi2ValueReference references[],
                                             size_t count, const fmi2String values[])
{
    (void)values;
    return count ? unknown_reference(component, references[0], "String") : fmi2OK;
}
