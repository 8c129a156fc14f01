/* Registers of the MPS2 board with FPGA image AN386 (Arm DAI 0386, Cortex-M System Design Kit DDI 0479). */
#ifndef MW_REGISTERS_H
#define MW_REGISTERS_H

#include <stdint.h>

typedef struct {
    volatile uint32_t data, state, control, interrupts, divider;
} uart_registers;

#define UART_TRANSMIT_FULL 1u
#define UART_RECEIVE_FULL 2u
#define UART_ENABLE 3u            /* transmitter and receiver */
#define UART_INTERRUPTS 12u       /* of both */

#define HOST_UART ((uart_registers *)0x40004000u)
#define BENCH_UART ((uart_registers *)0x40005000u)

typedef struct {
    volatile uint32_t load, value, control, clear, raw, masked;
    uint32_t unused[(0xc00 - 0x18) / 4];
    volatile uint32_t lock;
} watchdog_registers;

#define WATCHDOG ((watchdog_registers *)0x40008000u)
#define WATCHDOG_UNLOCK 0x1acce551u
#define WATCHDOG_ENABLE 3u        /* first the interrupt, the second time the reset */

/* A counter of the FPGA that runs at 25 MHz whatever the processor does: the independent time base. */
#define FPGA_COUNTER (*(volatile uint32_t *)0x40028018u)
#define FPGA_PRESCALE (*(volatile uint32_t *)0x4002801cu)
#define CLOCK_HZ 25000000u

#define SYSTICK_CONTROL (*(volatile uint32_t *)0xe000e010u)
#define SYSTICK_RELOAD (*(volatile uint32_t *)0xe000e014u)
#define SYSTICK_VALUE (*(volatile uint32_t *)0xe000e018u)
#define INTERRUPT_ENABLE (*(volatile uint32_t *)0xe000e100u)
#define COPROCESSOR_ACCESS (*(volatile uint32_t *)0xe000ed88u)

#endif
