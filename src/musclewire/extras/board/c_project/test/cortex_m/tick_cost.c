/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Instructions of one whole tick on an emulated Cortex-M: QEMU with -icount shift=0 lets one instruction take 1 ns, and
 * SysTick counts at 25 MHz, so one count is 40 instructions. Instructions are not cycles. */
#include <stdio.h>

#include "../bench.h"

#define TICKS 2000
#define INSTRUCTIONS_A_COUNT 40

#define SYSTICK_CONTROL (*(volatile uint32_t *)0xE000E010)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xE000E014)
#define SYSTICK_NOW (*(volatile uint32_t *)0xE000E018)

/* Not inlined, and the inputs come from memory, as in a program of one's own. */
__attribute__((noinline)) static uint32_t measured(mw_controller *controller, volatile const mw_real *inputs)
{
    const uint32_t before = SYSTICK_NOW;
    mw_tick(controller, inputs[0], inputs[1], inputs[2], inputs[3]);
    return (before - SYSTICK_NOW) & 0xffffff;
}

int main(void)
{
    static mw_controller controller;
    bench_state bench;
    uint32_t sum = 0, most = 0, tick;
    bench_start(&bench);
    mw_start(&controller);
    SYSTICK_RELOAD = 0xffffff;
    SYSTICK_NOW = 0;
    SYSTICK_CONTROL = 5;
    for (tick = 0; tick < TICKS; tick++) {
        const bench_inputs next = bench_next(&bench, mw_protect_allowed(&controller.protection));
        const mw_real inputs[4] = {next.wire_v, next.shunt_v, next.target, TICK_S};
        const uint32_t counts = measured(&controller, inputs);
        sum += counts;
        most = counts > most ? counts : most;
        if (controller.protection.state == MW_STATE_TRIPPED)
            mw_start(&controller);
    }
    printf("{\"ticks\": %d, \"instructions_mean\": %lu, \"instructions_most\": %lu, \"state_bytes\": %lu}\n", TICKS,
           (unsigned long)(sum * (uint64_t)INSTRUCTIONS_A_COUNT / TICKS),
           (unsigned long)(most * INSTRUCTIONS_A_COUNT), (unsigned long)sizeof controller);
    return 0;
}
