/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Holds the library against the golden vectors, what Python computed from the same inputs.
 *
 * golden_test golden_vectors.csv     0: agrees, 1: does not, 2: no vectors to read
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "musclewire.h"

#define INPUTS 6
#define OUTPUTS 9
#define COLUMNS (INPUTS + OUTPUTS)

#if defined(MW_DOUBLE)
#define ALLOWED 1e-6 /* of the value; near zero, of a thousandth of full scale */
#elif defined(MW_FILTER)
#define ALLOWED 2e-2 /* of full scale: where faults contradict its model, the filter enlarges rounding */
#else
#define ALLOWED 2e-4 /* of full scale */
#endif

#if defined(MW_INVERSE_MODEL)
#define RECORDED "steady_power_w", "pending_heat_j", "power_limited"
#define RECORDED_SCALES MW_MAXIMUM_STEADY_POWER_W, MW_MAXIMUM_STEADY_POWER_W * MW_THERMAL_TIME_CONSTANT_S, 1
#else
#define RECORDED "kp", "ki", "kd"
#define RECORDED_SCALES MW_KP_MAXIMUM, MW_KI_MAXIMUM, MW_KD_MAXIMUM
#endif

static const char *const names[OUTPUTS] = {
    "resistance_ohm", "estimate", "valid", RECORDED, "drive_voltage_v", "state", "event",
};
static const double full_scale[OUTPUTS] = {
    MW_RESISTANCE_MAX_OHM, MW_QUANTITY_MAX, 1, RECORDED_SCALES, MW_MAXIMUM_VOLTAGE_V, 1, 1,
};

static double size_of(double value)
{
    return value < 0 ? -value : value;
}

static int numbers_of(char *line, double *values)
{
    int column;
    for (column = 0; column < COLUMNS; column++) {
        char *end;
        values[column] = strtod(line, &end);
        if (end == line)
            return 0;
        line = *end == ',' ? end + 1 : end;
    }
    return 1;
}

static void tick(mw_controller *controller, const double *inputs, double *outputs)
{
    mw_output output;
    if (inputs[0] != 0)
        mw_start(controller);
    output = mw_sample(controller, (mw_real)inputs[1], (mw_real)inputs[2], (mw_real)inputs[4]);
    if (inputs[5] > 0)
        output = mw_control(controller, (mw_real)inputs[3], (mw_real)inputs[5]);
    outputs[0] = output.resistance_ohm;
    outputs[1] = output.estimate;
    outputs[2] = output.valid;
#if defined(MW_INVERSE_MODEL)
    outputs[3] = controller->answer.holding_w;
    outputs[4] = controller->answer.due_j;
    outputs[5] = controller->answer.limited;
#else
    outputs[3] = controller->kp;
    outputs[4] = controller->ki;
    outputs[5] = controller->kd;
#endif
    outputs[6] = output.drive_voltage_v;
    outputs[7] = output.state;
    outputs[8] = output.event;
}

static double difference(double ours, double python, double scale)
{
#if defined(MW_DOUBLE)
    const double floor = 1e-3 * size_of(scale);
    scale = size_of(python) > floor ? python : floor;
#else
    (void)python;
#endif
    return scale == 0 ? size_of(ours - python) : size_of((ours - python) / scale);
}

int main(int count, char **arguments)
{
    static char line[1024];
    static mw_controller controller;
    double values[COLUMNS], outputs[OUTPUTS], most[OUTPUTS] = {0};
    int rows = 0, wrong = 0, column;
    FILE *file = count > 1 ? fopen(arguments[1], "r") : NULL;
    if (file == NULL || fgets(line, sizeof line, file) == NULL) {
        fprintf(stderr, "golden_test: give the file golden_vectors.csv\n");
        return 2;
    }
    mw_start(&controller);
    while (fgets(line, sizeof line, file) != NULL && numbers_of(line, values)) {
        rows++;
        tick(&controller, values, outputs);
        for (column = 0; column < OUTPUTS; column++) {
            const double off = difference(outputs[column], values[INPUTS + column], full_scale[column]);
            if (!(off <= most[column]))
                most[column] = off;
            if (!(off <= ALLOWED) && wrong++ < 10)
                printf("row %d: %s is %.9g, Python says %.9g\n", rows, names[column], outputs[column],
                       values[INPUTS + column]);
        }
    }
    fclose(file);
    for (column = 0; column < OUTPUTS; column++)
        printf("%-16s off by at most %.2e\n", names[column], most[column]);
    printf("%d rows, %d numbers off by more than %.0e\n", rows, wrong, ALLOWED);
    return rows == 0 ? 2 : wrong != 0;
}
