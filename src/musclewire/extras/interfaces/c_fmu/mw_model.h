/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* What stands between the FMI functions (mw_fmi2.c) and a model (mw_wire_model.c or mw_controller_model.c).
 *
 * The FMI functions own instances, the order of calls, and the values of variables. A model owns what is computed. It has
 * no global that is written and no pointer in its state, so that a copy of the bytes is what a step that fails goes back to.
 */
#ifndef MW_MODEL_H
#define MW_MODEL_H

#include <stddef.h>

typedef enum { MW_INPUT, MW_OUTPUT, MW_FIXED, MW_TUNABLE, MW_CONSTANT } mw_role;

typedef struct {
    const char *name;
    mw_role role;
    double start, minimum, maximum;
} mw_variable;

#include "mw_variables.h" /* written by the export: MW_REAL_..., MW_INTEGER_..., MW_BOOLEAN_... and their tables */

typedef struct {
    double real[MW_REALS + 1]; /* one more than there are, because C has no empty arrays */
    int integer[MW_INTEGERS + 1];
    int boolean[MW_BOOLEANS + 1];
} mw_values;

/* MW_RETRY: nothing is wrong with the caller's values, and a shorter step may succeed. */
typedef enum { MW_DONE, MW_WARNED, MW_RETRY, MW_FAILED } mw_outcome;

/* Whose fault it is ("caller", "numerics", or "protection" for what the protection did), and one line that says it. */
typedef struct {
    const char *owner;
    char text[320];
} mw_message;

typedef struct mw_model mw_model;

/* Bytes of a model's state. */
size_t mw_model_bytes(void);

/* Put the model at rest with the present parameters and inputs, and write the first outputs. */
mw_outcome mw_model_start(mw_model *model, mw_values *values, mw_message *message);

/* Advance by duration_s with the inputs held, and write the outputs; time_s is for messages. Unless it is done, the caller restores
 * what was before. */
mw_outcome mw_model_step(mw_model *model, mw_values *values, double time_s, double duration_s, mw_message *message);

/* Write a message; the format is printf's. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
void mw_say(mw_message *message, const char *owner, const char *format, ...);

#endif
