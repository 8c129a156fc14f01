/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* Vector table and reset of an Arm MPS2 board as QEMU emulates it: the floating point unit on, then newlib's _start. */
#include <stdint.h>

extern uint32_t __stack;
void _start(void);
void reset(void);
void stuck(void);

__attribute__((section(".vectors"), used)) static const uintptr_t vectors[16] = {
    (uintptr_t)&__stack, (uintptr_t)reset, (uintptr_t)stuck, (uintptr_t)stuck,
    (uintptr_t)stuck,    (uintptr_t)stuck, (uintptr_t)stuck,
};

void reset(void)
{
#if defined(__VFP_FP__) && !defined(__SOFTFP__)
    *(volatile uint32_t *)0xE000ED88 |= 0xFu << 20; /* CPACR: coprocessors 10 and 11 */
    __asm volatile("dsb\n isb");
#endif
    _start();
}

/* A fault ends the emulation with an exit code instead of hanging: SYS_EXIT, ADP_Stopped_RunTimeErrorUnknown. */
void stuck(void)
{
    __asm volatile("movs r0, #0x18\n ldr r1, =0x20023\n bkpt 0xab");
    for (;;) {
    }
}
