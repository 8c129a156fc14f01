/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Cycles of one whole tick on an ATmega328P, counted by its own timer 1 at an eighth of the clock, printed on its serial
 * line. simavr is exact in cycles, so a board says the same. */
#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdlib.h>

#include "../bench.h"

#define TICKS 200
#define CYCLES_A_COUNT 8

static void put(char character)
{
    while (!(UCSR0A & 1 << UDRE0)) {
    }
    UDR0 = (uint8_t)character;
}

static void put_text(const char *text)
{
    while (*text)
        put(*text++);
}

static void put_number(const char *name, uint32_t number)
{
    char digits[12];
    put_text(name);
    ultoa(number, digits, 10);
    put_text(digits);
}

__attribute__((noinline)) static uint16_t measured(mw_controller *controller, volatile const mw_real *inputs)
{
    const uint16_t before = TCNT1;
    mw_tick(controller, inputs[0], inputs[1], inputs[2], inputs[3]);
    return (uint16_t)(TCNT1 - before);
}

int main(void)
{
    static mw_controller controller;
    bench_state bench;
    uint32_t sum = 0, most = 0;
    uint16_t tick;
    UBRR0 = 0;
    UCSR0B = 1 << TXEN0;
    TCCR1B = 1 << CS11;
    bench_start(&bench);
    mw_start(&controller);
    for (tick = 0; tick < TICKS; tick++) {
        const bench_inputs next = bench_next(&bench, mw_protect_allowed(&controller.protection));
        const mw_real inputs[4] = {next.wire_v, next.shunt_v, next.target, TICK_S};
        const uint16_t counts = measured(&controller, inputs);
        sum += counts;
        most = counts > most ? counts : most;
        if (controller.protection.state == MW_STATE_TRIPPED)
            mw_start(&controller);
    }
    put_number("{\"ticks\": ", TICKS);
    put_number(", \"cycles_mean\": ", sum * CYCLES_A_COUNT / TICKS);
    put_number(", \"cycles_most\": ", most * CYCLES_A_COUNT);
    put_number(", \"state_bytes\": ", sizeof controller);
    put_text("}\n");
    cli();
    sleep_enable();
    for (;;)
        sleep_cpu(); /* with interrupts off: the emulator ends */
}
