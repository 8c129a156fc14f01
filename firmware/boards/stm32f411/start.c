/* Vectors and the way from reset to main(). */
#include <stdint.h>
#include <string.h>

#include "registers.h"

#define LINE_INTERRUPT 38

extern uint32_t stack_top, data_start, data_end, data_load, bss_start, bss_end;

int main(void);
void board_output_off_at_reset(void);
void fault_handler(void);
void systick_handler(void);
void line_handler(void);
void reset_handler(void);

__attribute__((section(".vectors"), used)) static void *const vectors[16 + LINE_INTERRUPT + 1] = {
    [0] = (void *)&stack_top,
    [1] = (void *)reset_handler,
    [2 ... 14] = (void *)fault_handler,
    [15] = (void *)systick_handler,
    [16 ... 16 + LINE_INTERRUPT - 1] = (void *)fault_handler,
    [16 + LINE_INTERRUPT] = (void *)line_handler,
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
