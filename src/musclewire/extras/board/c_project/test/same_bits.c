/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Prints one number that stands for every bit of many ticks: the same on every target, or the target computes otherwise.
 *
 * same_bits [SAMPLES]    prints samples, trips, and FNV-1a (64 bits) over all outputs and what the controller records.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "bench.h"

#ifndef SAMPLES
#define SAMPLES 1000000
#endif

static uint64_t hash = 14695981039346656037u;

static void add(mw_real value)
{
    uint8_t bytes[sizeof value];
    size_t index;
    memcpy(bytes, &value, sizeof value);
    for (index = 0; index < sizeof value; index++)
        hash = (hash ^ bytes[index]) * 1099511628211u;
}

typedef struct {
    uint32_t kind, lasts;
} fault_state;

/* Now and then a reading is lost or a fault lasts for a while. */
static void spoil(bench_inputs *inputs, fault_state *fault, bench_state *bench, mw_real last_wire_v)
{
    if (fault->lasts == 0) {
        if (drawn(bench) % 97 == 0) {
            fault->kind = drawn(bench) % 8;
            fault->lasts = drawn(bench) % 8;
        }
        return;
    }
    fault->lasts--;
    switch (fault->kind) {
    case 0: inputs->shunt_v = 0; break;
    case 1: inputs->wire_v = inputs->shunt_v = 0; break;
    case 2: inputs->wire_v *= 3; break;
    case 3: inputs->wire_v = -inputs->wire_v; break;
    case 4: inputs->shunt_v *= 4; break;
    case 5: inputs->target *= 2; break;
    case 6: inputs->wire_v *= MW_R(1.15); break;
    default: inputs->wire_v = last_wire_v; break;
    }
}

static void add_tick(const mw_controller *controller, mw_output output)
{
    add(output.drive_voltage_v);
    add(output.resistance_ohm);
    add(output.estimate);
#if defined(MW_INVERSE_MODEL)
    add(controller->answer.holding_w);
    add(controller->answer.due_j);
    add(controller->answer.limited);
#else
    add(controller->kp);
    add(controller->ki);
    add(controller->kd);
#endif
    add(controller->protection.above_ambient_k);
    add((mw_real)output.state);
    add((mw_real)output.event);
}

int main(int count, char **arguments)
{
    const long samples = count > 1 ? atol(arguments[1]) : SAMPLES;
    bench_state bench;
    fault_state fault = {0, 0};
    mw_controller controller;
    long sample, trips = 0;
    bench_start(&bench);
    mw_start(&controller);
    for (sample = 0; sample < samples; sample++) {
        bench_inputs inputs = bench_next(&bench, mw_protect_allowed(&controller.protection));
        mw_output output;
        spoil(&inputs, &fault, &bench, controller.protection.wire_voltage_v);
        output = mw_tick(&controller, inputs.wire_v, inputs.shunt_v, inputs.target, TICK_S);
        add_tick(&controller, output);
        if (output.state == MW_STATE_TRIPPED) {
            trips++;
            mw_start(&controller);
        }
    }
    printf("%ld samples, %ld trips, %lu byte numbers, hash %08lx%08lx\n", samples, trips,
           (unsigned long)sizeof(mw_real), (unsigned long)(hash >> 32), (unsigned long)(hash & 0xffffffffu));
    return 0;
}
