/* STM32F411 on its internal oscillator, by registers.
 *
 * SysTick at 8 kHz converts both channels; eight of them make a tick of 1 ms. It waits for the converter longer than a
 * byte takes on the line, so the line's interrupt may interrupt it, and is never masked for long. Timer 3 makes the PWM.
 * The independent watchdog runs on an oscillator of its own: it resets although the processor's clock may have stopped.
 */
#include "board.h"

#include "board_constants.h"
#include "messages.h"
#include "registers.h"
#include "sense_channels.h"

#define RING 512u
#include "ring.h"

#define READINGS 8u
#define NODE_CHANNEL 4u
#define SHUNT_CHANNEL 5u
/* A conversion takes 40 cycles of 8 MHz; this many rounds of waiting take far longer. */
#define CONVERSION_ROUNDS 200u
#define NOTE_ALIVE 0x616c6976u

mw_retained board_retained __attribute__((section(".noinit")));
static uint32_t note __attribute__((section(".noinit")));

static ring from_host, to_host;
static volatile uint32_t node_sum, shunt_sum;
static volatile uint16_t readings, slices;
static uint8_t cause, missed;

static const mw_channels channels = {MW_CONVERTER_FULL_CODE, MW_NODE_RANGE_V, MW_SHUNT_RANGE_V};

/* The gate's own pull-down holds it while the pin is an input; from here on the pin does. Before memory is set up. */
void board_output_off_at_reset(void)
{
    RCC_AHB1_ENABLE |= 1u;
    (void)RCC_AHB1_ENABLE; /* the clock comes two cycles later (ST ES0287): a read waits for it */
    PINS_SET = 1u << (16 + 6);
    PINS_MODE = (PINS_MODE & ~(3u << 12)) | 1u << 12; /* PA6 an output, low */
}

void fault_handler(void)
{
    board_output_off_at_reset();
    for (;;) { /* the watchdog resets */
    }
}

/* Returns the code of one channel, or one above full scale if the converter does not answer. */
static uint32_t converted(uint32_t channel)
{
    CONVERTER_CHANNEL = channel;
    CONVERTER_STATUS = 0u;
    CONVERTER_CONTROL = CONVERTER_ON | CONVERTER_START;
    for (uint32_t round = 0; round < CONVERSION_ROUNDS; round++) {
        if (CONVERTER_STATUS & CONVERTER_DONE) {
            return CONVERTER_DATA & 0xfffu;
        }
    }
    return UINT32_MAX;
}

void systick_handler(void)
{
    const uint32_t node = converted(NODE_CHANNEL), shunt = converted(SHUNT_CHANNEL);
    slices++;
    if (node != UINT32_MAX && shunt != UINT32_MAX) {
        node_sum += node;
        shunt_sum += shunt;
        readings++;
    }
}

static void send_waiting(void)
{
    uint8_t byte;
    while ((LINE_STATUS & LINE_MAY_SEND) && take(&to_host, &byte)) {
        LINE_DATA = byte;
    }
    if (is_empty(&to_host)) {
        LINE_CONTROL &= ~LINE_SENDING;
    }
}

void line_handler(void)
{
    const uint32_t status = LINE_STATUS;
    if (status & (LINE_RECEIVED | LINE_OVERRUN)) {
        const uint8_t byte = (uint8_t)LINE_DATA; /* clears both flags: an overrun that is not cleared would interrupt endlessly */
        if (status & LINE_RECEIVED) {
            keep(&from_host, byte);
        }
    }
    if (LINE_CONTROL & LINE_SENDING) {
        send_waiting();
    }
}

static uint8_t cause_of_reset(void)
{
    const uint32_t flags = RCC_RESET_FLAGS;
    RCC_RESET_FLAGS = flags | FLAGS_CLEAR;
    if (flags & FLAG_WATCHDOG) {
        return MW_RESET_WATCHDOG;
    }
    if (flags & FLAG_POWER_ON) {
        return MW_RESET_POWER_ON;
    }
    if (flags & FLAG_BROWN_OUT) {
        return MW_RESET_BROWN_OUT;
    }
    return note == NOTE_ALIVE ? MW_RESET_EXTERNAL : MW_RESET_POWER_ON;
}

static void start_watchdog(void)
{
    WATCHDOG_KEY = 0xccccu; /* starts it, and the oscillator it runs on */
    WATCHDOG_KEY = 0x5555u;
    WATCHDOG_PRESCALER = 3u; /* 32 kHz / 32: milliseconds */
    WATCHDOG_RELOAD = 200u;
    WATCHDOG_KEY = 0xaaaau;
}

void board_start(void)
{
    cause = cause_of_reset();
    note = NOTE_ALIVE;
    RCC_APB1_ENABLE |= (1u << 17) | (1u << 1);
    RCC_APB2_ENABLE |= 1u << 8;
    PINS_MODE |= (2u << 4) | (2u << 6) | (3u << 8) | (3u << 10); /* PA2, PA3 the line; PA4, PA5 analogue */
    PINS_FUNCTION |= (7u << 8) | (7u << 12) | (2u << 24);
    PINS_PULL |= 1u; /* the key at PA0 */
    TIMER_TOP = MW_OUTPUT_FULL_CODE - 1u;
    TIMER_COMPARE = 0u;
    TIMER_MODE = (6u << 4) | (1u << 3); /* PWM mode 1: at a compare value of 0 the pin stays low */
    TIMER_CHANNELS = 1u;
    TIMER_UPDATE = 1u;
    TIMER_CONTROL = 1u;
    PINS_MODE = (PINS_MODE & ~(3u << 12)) | 2u << 12; /* from here on PA6 is the timer's */
    CONVERTER_SAMPLING = (2u << 12) | (2u << 15); /* 28 cycles for channels 4 and 5 */
    CONVERTER_CONTROL = CONVERTER_ON;
    LINE_DIVIDER = CLOCK_HZ / 1000000u;
    LINE_CONTROL = LINE_ON;
    SYSTEM_PRIORITIES_12_TO_15 = 0xf0000000u; /* SysTick's the lowest, the line's stays the highest */
    INTERRUPTS_32_TO_63 = 1u << (38 - 32);
    SYSTICK_RELOAD = CLOCK_HZ / 1000u / READINGS - 1u;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 7u;
    start_watchdog();
}

uint8_t board_reset_cause(void)
{
    return cause;
}

void board_set_drive(float drive_voltage_v)
{
    float code = drive_voltage_v * ((float)MW_OUTPUT_FULL_CODE / MW_OUTPUT_RANGE_V) + 0.5f;
    code = code > 0.0f ? code : 0.0f; /* NaN becomes 0 */
    TIMER_COMPARE = code < (float)MW_OUTPUT_FULL_CODE ? (uint32_t)code : MW_OUTPUT_FULL_CODE;
}

/* Takes over the sums of a tick, once a millisecond has passed. */
static bool next_tick(mw_board_tick *tick, mw_board_reading *reading)
{
    __asm volatile("cpsid i");
    if (slices < READINGS) {
        __asm volatile("cpsie i");
        return false;
    }
    const uint32_t node = node_sum, shunt = shunt_sum, count = readings;
    slices = (uint16_t)(slices - READINGS);
    node_sum = shunt_sum = 0u;
    readings = 0u;
    __asm volatile("cpsie i");
    *tick = 2u * count >= READINGS ? MW_TICK_READING : MW_TICK_MISSING;
    const uint8_t ticks = mw_ticks_passed(&missed, *tick);
    if (*tick == MW_TICK_READING) {
        *reading = mw_sense_channels(&channels, node * READINGS / count, shunt * READINGS / count);
        reading->ticks = ticks;
    }
    return true;
}

bool board_wait(mw_board_tick *tick, mw_board_reading *reading)
{
    if (next_tick(tick, reading)) {
        return true;
    }
    __asm volatile("cpsid i");
    if (is_empty(&from_host) && slices < READINGS) {
        __asm volatile("wfi"); /* wakes on an interrupt that is pending, although it is not served yet */
    }
    __asm volatile("cpsie i");
    return next_tick(tick, reading);
}

bool board_get(uint8_t *byte)
{
    return take(&from_host, byte);
}

bool board_put(const uint8_t *bytes, uint8_t length)
{
    if (waiting(&to_host) + length >= RING) {
        return false;
    }
    for (uint8_t i = 0; i < length; i++) {
        keep(&to_host, bytes[i]);
    }
    __asm volatile("cpsid i"); /* only from here on: copying a frame takes longer than bytes take to come */
    LINE_CONTROL |= LINE_SENDING;
    send_waiting();
    __asm volatile("cpsie i");
    return true;
}

void board_watchdog_feed(void)
{
    WATCHDOG_KEY = 0xaaaau;
}

bool board_button(void)
{
    return !(PINS_IN & 1u);
}

float board_knob(void)
{
    return 0.0f;
}
