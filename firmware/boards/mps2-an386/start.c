/* Vectors and the way from reset to main(). */
#include <stdint.h>
#include <string.h>

#include "registers.h"

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;

int main(void);
void board_output_off_at_reset(void);
void watchdog_handler(void);
void fault_handler(void);
void systick_handler(void);
void host_receive_handler(void);
void host_transmit_handler(void);
void bench_receive_handler(void);
void reset_handler(void);

__attribute__((section(".vectors"), used)) static void *const vectors[16 + 3] = {
    (void *)&stack_top, (void *)reset_handler, (void *)watchdog_handler, /* the watchdog is the board's NMI */
    (void *)fault_handler, (void *)fault_handler, (void *)fault_handler, (void *)fault_handler,
    0, 0, 0, 0, (void *)fault_handler, (void *)fault_handler, 0, (void *)fault_handler, (void *)systick_handler,
    (void *)host_receive_handler, (void *)host_transmit_handler, (void *)bench_receive_handler,
};

void reset_handler(void)
{
    board_output_off_at_reset();
    COPROCESSOR_ACCESS |= 0xfu << 20; /* the floating point unit, before anything computes */
    __asm volatile("dsb\n isb");
    memcpy(&data_start, &data_load, (size_t)((uint8_t *)&data_end - (uint8_t *)&data_start));
    memset(&bss_start, 0, (size_t)((uint8_t *)&bss_end - (uint8_t *)&bss_start));
    (void)main();
    fault_handler();
}
