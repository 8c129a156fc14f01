/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* What the files of the FMI functions share: an instance, its phase, and how an error ends a call. */
#ifndef MW_INSTANCE_H
#define MW_INSTANCE_H

#include "mw_fmi2.h"
#include "mw_model.h"

typedef enum { MW_INSTANTIATED, MW_INITIALIZING, MW_STEPPING, MW_TERMINATED, MW_IN_ERROR } mw_phase;

/* All that a step may change; the model's bytes follow it. */
typedef struct {
    mw_phase phase;
    int started; /* whether the model has been put at rest with the present parameters */
    double time_s;
    mw_values values;
} mw_snapshot;

typedef struct {
    fmi2CallbackFunctions functions;
    char *name;
    mw_snapshot *now, *before; /* each with the model's bytes; `before` is what a step that fails goes back to */
    mw_message message;
} mw_instance;

/* Bytes of a snapshot with the model's, which follow it. */
size_t mw_snapshot_bytes(void);
mw_model *mw_model_of(mw_snapshot *state);

/* Send the instance's message to the tool's log, and return the status. */
fmi2Status mw_tell(mw_instance *of, fmi2Status status);

/* The same for an error: until fmi2Reset nothing can be set or stepped. */
fmi2Status mw_fail(mw_instance *of);

/* An error of the tool: a function that was called at the wrong time. */
fmi2Status mw_wrong_call(mw_instance *of, const char *call, const char *when);

/* The status of what a model did. */
fmi2Status mw_status_of(mw_instance *of, mw_outcome outcome);

/* Put the model at rest, unless that has been done since a value was last set. */
fmi2Status mw_start_model(mw_instance *of);

/* Give all variables their start values. */
void mw_take_start_values(mw_values *values);

#endif
