/* Arduino Uno or Nano: ATmega328P at 16 MHz. Registers as in Microchip's data sheet DS40002061.
 *
 * Timer 2 is the time base of 1 ms; in each it starts one conversion of A0 and one of A1. Ten of both make a tick.
 */
#include "board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "board_constants.h"
#include "messages.h"
#include "sense_channels.h"

#define NOTE_ALIVE 0x616cu
#define NOTE_WATCHDOG 0x7764u
#define READINGS 10u
#define NODE_CHANNEL 0u
#define SHUNT_CHANNEL 1u
#define KNOB_CHANNEL 2u
#define SUPPLY_IS_REFERENCE (1u << REFS0)
/* 16 MHz / (8 * (7 + 1)): exactly 250 kBd */
#define BAUD_DIVIDER 7u

mw_retained board_retained __attribute__((section(".noinit")));
static uint16_t note __attribute__((section(".noinit")));
static uint8_t flags_at_reset __attribute__((section(".noinit")));

/* Powers of two, so that an index wraps by a mask. */
#define FROM_HOST 128u
#define TO_HOST 128u
static volatile uint8_t from_host_in, from_host_out, to_host_in, to_host_out;
static volatile uint8_t from_host[FROM_HOST], to_host[TO_HOST];

static volatile uint16_t node_sum, shunt_sum, node_code;
static volatile uint8_t readings, milliseconds, knob_code;
static uint8_t cause, missed;

static const mw_channels channels = {MW_CONVERTER_FULL_CODE, MW_NODE_RANGE_V, MW_SHUNT_RANGE_V};

/* The gate's own pull-down holds it while the pin is an input; from here on the pin does. Before memory is set up. */
void board_output_off_at_reset(void) __attribute__((naked, used, section(".init3")));
void board_output_off_at_reset(void)
{
    TCCR1A = 0;
    PORTB &= (uint8_t)~(1u << PORTB1);
    DDRB |= (uint8_t)(1u << DDB1);
    flags_at_reset = MCUSR;
    MCUSR = 0;
    wdt_disable(); /* it stays on after its own reset, with its shortest time */
}

static uint8_t cause_of_reset(void)
{
    /* A boot loader may have cleared the flags; the note shows a watchdog's reset all the same. */
    if ((flags_at_reset & (1u << WDRF)) || note == NOTE_WATCHDOG) {
        return MW_RESET_WATCHDOG;
    }
    if (flags_at_reset & (1u << PORF)) {
        return MW_RESET_POWER_ON;
    }
    if (flags_at_reset & (1u << BORF)) {
        return MW_RESET_BROWN_OUT;
    }
    return note == NOTE_ALIVE ? MW_RESET_EXTERNAL : MW_RESET_POWER_ON;
}

static void start_watchdog(void)
{
    /* 0.12 s to the interrupt, which switches off, as long again to the reset. Two writes within four cycles. */
    wdt_reset();
    WDTCSR = (uint8_t)((1u << WDCE) | (1u << WDE));
    WDTCSR = (uint8_t)((1u << WDIE) | (1u << WDE) | (1u << WDP1) | (1u << WDP0));
}

void board_start(void)
{
    cause = cause_of_reset();
    note = NOTE_ALIVE;
    PORTD |= (uint8_t)(1u << PORTD2); /* the button's pull-up */
    ICR1 = MW_OUTPUT_FULL_CODE;
    TCCR1B = (uint8_t)((1u << WGM13) | (1u << WGM12) | (1u << CS10)); /* fast PWM up to ICR1, with WGM11 below */
    TCCR2A = (uint8_t)(1u << WGM21);
    OCR2A = 249; /* 16 MHz / 64 / 250 = 1 kHz */
    TIMSK2 = (uint8_t)(1u << OCIE2A);
    TCCR2B = (uint8_t)(1u << CS22);
    ADMUX = (uint8_t)(SUPPLY_IS_REFERENCE | NODE_CHANNEL);
    ADCSRA = (uint8_t)((1u << ADEN) | (1u << ADIE) | (1u << ADPS2) | (1u << ADPS1) | (1u << ADPS0)); /* 125 kHz */
    UCSR0A = (uint8_t)(1u << U2X0);
    UBRR0 = BAUD_DIVIDER;
    UCSR0B = (uint8_t)((1u << RXEN0) | (1u << TXEN0) | (1u << RXCIE0));
    start_watchdog();
    SMCR = 0; /* idle: all clocks run on */
    sei();
}

uint8_t board_reset_cause(void)
{
    return cause;
}

ISR(WDT_vect)
{
    TCCR1A = 0;
    PORTB &= (uint8_t)~(1u << PORTB1);
    note = NOTE_WATCHDOG;
    for (;;) {
    }
}

ISR(TIMER2_COMPA_vect)
{
    milliseconds++;
    if (!(ADCSRA & (1u << ADSC))) { /* a conversion that still runs is late, and counts as missing */
        ADMUX = (uint8_t)(SUPPLY_IS_REFERENCE | NODE_CHANNEL);
        ADCSRA |= (uint8_t)(1u << ADSC);
    }
}

ISR(ADC_vect)
{
    const uint16_t code = ADC;
    const uint8_t channel = ADMUX & 7u;
    if (channel == KNOB_CHANNEL) {
        knob_code = (uint8_t)(code >> 2);
        return;
    }
    if (channel == NODE_CHANNEL) {
        node_code = code;
    } else {
        /* Both at once: a tick that is fetched late, between the two, would otherwise have one reading more of the node,
         * and the next one less: two jumps of a tenth, by which the protection trips. */
        node_sum = (uint16_t)(node_sum + node_code);
        shunt_sum = (uint16_t)(shunt_sum + code);
        readings++;
    }
    ADMUX = (uint8_t)(SUPPLY_IS_REFERENCE | (channel + 1u)); /* node, shunt, knob, and then until the next millisecond */
    ADCSRA |= (uint8_t)(1u << ADSC);
}

ISR(USART_RX_vect)
{
    const uint8_t byte = UDR0;
    const uint8_t next = (uint8_t)((from_host_in + 1u) & (FROM_HOST - 1u));
    if (next != from_host_out) { /* a full ring drops bytes: the frame's checksum then fails */
        from_host[from_host_in] = byte;
        from_host_in = next;
    }
}

ISR(USART_UDRE_vect)
{
    if (to_host_in == to_host_out) {
        UCSR0B &= (uint8_t)~(1u << UDRIE0);
        return;
    }
    UDR0 = to_host[to_host_out];
    to_host_out = (uint8_t)((to_host_out + 1u) & (TO_HOST - 1u));
}

void board_set_drive(float drive_voltage_v)
{
    float code = drive_voltage_v * ((float)MW_OUTPUT_FULL_CODE / MW_OUTPUT_RANGE_V) + 0.5f;
    code = code > 0.0f ? code : 0.0f; /* NaN becomes 0 */
    const uint16_t whole = code < (float)MW_OUTPUT_FULL_CODE ? (uint16_t)code : MW_OUTPUT_FULL_CODE;
    /* At a compare value of 0 fast PWM still gives a spike of one cycle: for 0 V the timer is disconnected from the pin. */
    const uint8_t mode = whole > 0u ? (uint8_t)((1u << COM1A1) | (1u << WGM11)) : (uint8_t)(1u << WGM11);
    const uint8_t interrupts = SREG;
    cli();
    OCR1A = whole;
    TCCR1A = mode;
    SREG = interrupts;
}

/* Takes over the sums of a tick, once ten milliseconds have passed. */
static bool next_tick(mw_board_tick *tick, mw_board_reading *reading)
{
    cli();
    const uint8_t passed = milliseconds;
    if (passed < READINGS) {
        sei();
        return false;
    }
    const uint16_t node = node_sum, shunt = shunt_sum;
    const uint8_t count = readings;
    milliseconds = (uint8_t)(passed - READINGS);
    node_sum = shunt_sum = 0;
    readings = 0;
    sei();
    /* The beat of two clocks makes one reading more or less; the sums are scaled to ten. */
    *tick = count + 2u >= READINGS ? MW_TICK_READING : MW_TICK_MISSING;
    const uint8_t ticks = mw_ticks_passed(&missed, *tick);
    if (*tick == MW_TICK_READING) {
        const uint32_t scale = count;
        *reading = mw_sense_channels(&channels, (uint32_t)node * READINGS / scale, (uint32_t)shunt * READINGS / scale);
        reading->ticks = ticks;
    }
    return true;
}

bool board_wait(mw_board_tick *tick, mw_board_reading *reading)
{
    if (next_tick(tick, reading)) {
        return true;
    }
    cli();
    if (from_host_in == from_host_out && milliseconds < READINGS) {
        SMCR = (uint8_t)(1u << SE);
        sei(); /* takes effect after the next instruction: no interrupt comes in between */
        sleep_cpu();
        SMCR = 0;
    }
    sei();
    return next_tick(tick, reading);
}

bool board_get(uint8_t *byte)
{
    if (from_host_in == from_host_out) {
        return false;
    }
    *byte = from_host[from_host_out];
    from_host_out = (uint8_t)((from_host_out + 1u) & (FROM_HOST - 1u));
    return true;
}

bool board_put(const uint8_t *bytes, uint8_t length)
{
    const uint8_t used = (uint8_t)((uint8_t)(to_host_in - to_host_out) & (TO_HOST - 1u));
    if ((uint16_t)used + length >= TO_HOST) {
        return false;
    }
    for (uint8_t i = 0; i < length; i++) {
        to_host[to_host_in] = bytes[i];
        to_host_in = (uint8_t)((to_host_in + 1u) & (TO_HOST - 1u));
    }
    UCSR0B |= (uint8_t)(1u << UDRIE0);
    return true;
}

void board_watchdog_feed(void)
{
    wdt_reset();
}

bool board_button(void)
{
    return !(PIND & (1u << PIND2));
}

float board_knob(void)
{
    return (float)knob_code / 255.0f;
}
