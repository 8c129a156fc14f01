/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The FMI 2.0 functions that save a state, restore it, and turn it into bytes and back. */
#include <stdlib.h>
#include <string.h>

#include "mw_instance.h"

static fmi2Status no_memory(mw_instance *of)
{
    mw_say(&of->message, "caller", "no memory for a state of %lu bytes", (unsigned long)mw_snapshot_bytes());
    return mw_fail(of);
}

MW_EXPORTED fmi2Status MW_FMI(fmi2GetFMUstate)(fmi2Component component, fmi2FMUstate *state)
{
    mw_instance *of = component;
    if (!*state)
        *state = malloc(mw_snapshot_bytes());
    if (!*state)
        return no_memory(of);
    memcpy(*state, of->now, mw_snapshot_bytes());
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SetFMUstate)(fmi2Component component, fmi2FMUstate state)
{
    mw_instance *of = component;
    memcpy(of->now, state, mw_snapshot_bytes());
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2FreeFMUstate)(fmi2Component component, fmi2FMUstate *state)
{
    (void)component;
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SerializedFMUstateSize)(fmi2Component component, fmi2FMUstate state, size_t *bytes)
{
    (void)component, (void)state;
    *bytes = mw_snapshot_bytes();
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2SerializeFMUstate)(fmi2Component component, fmi2FMUstate state, fmi2Byte bytes[],
                                                     size_t count)
{
    mw_instance *of = component;
    if (count < mw_snapshot_bytes()) {
        mw_say(&of->message, "caller", "a state has %lu bytes, and there is room for %lu",
               (unsigned long)mw_snapshot_bytes(), (unsigned long)count);
        return mw_fail(of);
    }
    memcpy(bytes, state, mw_snapshot_bytes());
    return fmi2OK;
}

MW_EXPORTED fmi2Status MW_FMI(fmi2DeSerializeFMUstate)(fmi2Component component, const fmi2Byte bytes[], size_t count,
                                                       fmi2FMUstate *state)
{
    mw_instance *of = component;
    if (count != mw_snapshot_bytes() || memcmp(bytes, MW_GUID, sizeof MW_GUID) != 0) {
        mw_say(&of->message, "caller", "these bytes are not a state of this FMU");
        return mw_fail(of);
    }
    if (!*state)
        *state = malloc(count);
    if (!*state)
        return no_memory(of);
    memcpy(*state, bytes, count);
    return fmi2OK;
}

/* There are none: providesDirectionalDerivative is false. */
MW_EXPORTED fmi2Status MW_FMI(fmi2GetDirectionalDerivative)(fmi2Component component,
                                                            const fmi2ValueReference unknown[], size_t unknowns,
                                                            const fmi2ValueReference known[], size_t knowns,
                                                            const fmi2Real by_known[], fmi2Real of_unknown[])
{
    (void)unknown, (void)unknowns, (void)known, (void)knowns, (void)by_known, (void)of_unknown;
    return mw_wrong_call(component, "fmi2GetDirectionalDerivative", "by nobody: there are none");
}
