/* MPS2 board with a Cortex-M4F, as QEMU emulates it. UART0 is the host's line.
 *
 * UART1 replaces converter and output stage. From the bench: 0xa5, node code, shunt code, number, check: a finished
 * conversion; 0x5a: the next one takes up to a second, and no time passes until then; 0xb7 and a byte: the button is down
 * (1) or up. To the bench: 0x3c (0x3d: the board
 * has just started), output code, number of the conversion that it answers, check. Codes are 16 bit, low byte first; the
 * check is the exclusive or of all bytes before it.
 */
#include "board.h"

#include "board_constants.h"
#include "messages.h"
#include "registers.h"
#include "sense_channels.h"

#define RING 1024u
#include "ring.h"

#define CONVERSION 0xa5u
#define CONVERTING 0x5au
#define BUTTON 0xb7u
#define OUTPUT 0x3cu
#define OUTPUT_AT_START 0x3du
#define CONVERSION_BYTES 7u
#define OUTPUT_BYTES 5u

#define NOTE_ALIVE 0x616c6976u
#define NOTE_WATCHDOG 0x77646f67u

/* If nothing comes from the converter for longer than this, a tick is missing. */
#define LATE (2u * MW_TICK_PERIOD_US * (CLOCK_HZ / 1000000u))
#define LATE_WHILE_CONVERTING CLOCK_HZ
#define TICK_COUNTS (MW_TICK_PERIOD_US * (CLOCK_HZ / 1000000u))
/* After 0.2 s the interrupt, which switches off; as long again, and the reset. */
#define WATCHDOG_COUNTS (CLOCK_HZ / 5u)

mw_retained board_retained __attribute__((section(".noinit")));
static uint32_t note __attribute__((section(".noinit")));

static ring from_host, from_bench, to_host;
static uint8_t cause;
static uint8_t answered; /* number of the conversion that the next output answers */
static bool first = true;
static uint32_t heard;   /* when a byte of the converter last came, in counts of the time base */
static uint32_t patience = LATE;
static uint8_t packet[CONVERSION_BYTES], packet_length;
static bool button_follows, button_down;

static const mw_channels channels = {MW_CONVERTER_FULL_CODE, MW_NODE_RANGE_V, MW_SHUNT_RANGE_V};

static void receive(uart_registers *uart, ring *into)
{
    uart->interrupts = 2u; /* before the byte is taken: the next one may follow at once */
    while (uart->state & UART_RECEIVE_FULL) {
        keep(into, (uint8_t)uart->data);
    }
}

static void transmit_waiting(void)
{
    uint8_t byte;
    while (!(HOST_UART->state & UART_TRANSMIT_FULL) && take(&to_host, &byte)) {
        HOST_UART->data = byte;
    }
}

void host_receive_handler(void)
{
    receive(HOST_UART, &from_host);
}

void host_transmit_handler(void)
{
    HOST_UART->interrupts = 1u;
    transmit_waiting();
}

void bench_receive_handler(void)
{
    receive(BENCH_UART, &from_bench);
}

/* Sends an output code to the bench. The bench always reads; on a real board this is one register. */
static void put_output(uint8_t kind, uint16_t code)
{
    const uint8_t bytes[OUTPUT_BYTES - 1u] = {kind, (uint8_t)code, (uint8_t)(code >> 8), answered};
    uint8_t check = 0;
    for (uint8_t i = 0; i < sizeof bytes; i++) {
        while (BENCH_UART->state & UART_TRANSMIT_FULL) {
        }
        BENCH_UART->data = bytes[i];
        check ^= bytes[i];
    }
    while (BENCH_UART->state & UART_TRANSMIT_FULL) {
    }
    BENCH_UART->data = check;
}

/* Runs first after a reset, before memory is set up: nothing here may use it. */
void board_output_off_at_reset(void)
{
    BENCH_UART->divider = 16u;
    BENCH_UART->control = 1u; /* the transmitter alone: a byte that came before its interrupt is on would stay */
    put_output(OUTPUT_AT_START, 0u);
}

/* The watchdog's first call: the loop hangs. Output off at once; the second call resets. */
void watchdog_handler(void)
{
    put_output(OUTPUT, 0u);
    note = NOTE_WATCHDOG;
    for (;;) {
    }
}

/* A fault of the processor: the output goes off, and the watchdog resets. */
void fault_handler(void)
{
    put_output(OUTPUT, 0u);
    for (;;) {
    }
}

void systick_handler(void)
{
    /* It only ends the wait for an interrupt. */
}

static void start_watchdog(void)
{
    WATCHDOG->lock = WATCHDOG_UNLOCK;
    WATCHDOG->load = WATCHDOG_COUNTS;
    WATCHDOG->control = WATCHDOG_ENABLE;
    WATCHDOG->lock = 0u;
}

void board_start(void)
{
    /* Memory kept its content, and the watchdog was not the cause: the reset pin, or a short dip of the supply. */
    cause = note == NOTE_WATCHDOG ? MW_RESET_WATCHDOG : note == NOTE_ALIVE ? MW_RESET_EXTERNAL : MW_RESET_POWER_ON;
    note = NOTE_ALIVE;
    FPGA_PRESCALE = 0u;
    SYSTICK_RELOAD = TICK_COUNTS - 1u;
    SYSTICK_VALUE = 0u;
    SYSTICK_CONTROL = 7u;
    HOST_UART->divider = 25u; /* 1 Mbaud */
    HOST_UART->control = UART_ENABLE | UART_INTERRUPTS;
    BENCH_UART->control = UART_ENABLE | 8u;
    receive(HOST_UART, &from_host);
    receive(BENCH_UART, &from_bench);
    INTERRUPT_ENABLE = 7u;
    heard = FPGA_COUNTER;
    start_watchdog();
}

uint8_t board_reset_cause(void)
{
    return cause;
}

void board_set_drive(float drive_voltage_v)
{
    float code = drive_voltage_v * ((float)MW_OUTPUT_FULL_CODE / MW_OUTPUT_RANGE_V) + 0.5f;
    /* Written so that NaN becomes 0. */
    code = code > 0.0f ? code : 0.0f;
    put_output(OUTPUT, code < (float)MW_OUTPUT_FULL_CODE ? (uint16_t)code : MW_OUTPUT_FULL_CODE);
}

/* Takes one byte of the converter; returns true if `packet` holds a complete conversion or one is announced. */
static bool converter_spoke(uint8_t byte, mw_board_tick *tick)
{
    if (button_follows) {
        button_follows = false;
        button_down = byte == 1u;
        return false;
    }
    if (packet_length == 0u && byte != CONVERSION) {
        button_follows = byte == BUTTON;
        *tick = MW_TICK_PENDING;
        return byte == CONVERTING;
    }
    packet[packet_length++] = byte;
    if (packet_length < CONVERSION_BYTES) {
        return false;
    }
    packet_length = 0;
    uint8_t check = 0;
    for (uint8_t i = 0; i < CONVERSION_BYTES; i++) {
        check ^= packet[i];
    }
    *tick = MW_TICK_READING;
    return check == 0u;
}

static uint16_t code_at(uint8_t place)
{
    return (uint16_t)(packet[place] | (uint16_t)(packet[place + 1u] << 8));
}

static bool next_tick(mw_board_tick *tick, mw_board_reading *reading)
{
    uint8_t byte;
    while (take(&from_bench, &byte)) {
        if (converter_spoke(byte, tick)) {
            heard = FPGA_COUNTER;
            patience = *tick == MW_TICK_READING ? LATE : LATE_WHILE_CONVERTING;
            if (*tick == MW_TICK_READING) {
                *reading = mw_sense_channels(&channels, code_at(1), code_at(3));
                /* The first after a start has no number before it. */
                reading->ticks = (uint8_t)(first ? 1u : (uint8_t)(packet[5] - answered));
                first = false;
                answered = packet[5];
            }
            return true;
        }
    }
    if (FPGA_COUNTER - heard > patience) {
        heard += TICK_COUNTS;
        *tick = MW_TICK_MISSING;
        return true;
    }
    *tick = MW_TICK_PENDING;
    return patience == LATE_WHILE_CONVERTING;
}

bool board_wait(mw_board_tick *tick, mw_board_reading *reading)
{
    __asm volatile("cpsid i");
    transmit_waiting(); /* its interrupt must not come in between */
    __asm volatile("cpsie i");
    if (next_tick(tick, reading)) {
        return true;
    }
    __asm volatile("cpsid i");
    if (is_empty(&from_bench) && is_empty(&from_host)) {
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
    __asm volatile("cpsid i");
    for (uint8_t i = 0; i < length; i++) {
        keep(&to_host, bytes[i]);
    }
    transmit_waiting();
    __asm volatile("cpsie i");
    return true;
}

void board_watchdog_feed(void)
{
    WATCHDOG->lock = WATCHDOG_UNLOCK;
    WATCHDOG->clear = 1u;
    WATCHDOG->lock = 0u;
}

bool board_button(void)
{
    return button_down;
}

float board_knob(void)
{
    return 0.0f;
}
