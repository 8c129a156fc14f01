/* The firmware's parser and application on a host, fed from standard input, judged at every change of the output.
 *
 * Bytes come from a fuzzer. Between them ticks pass with readings of a healthy wire, or of none, or of nonsense. What
 * must hold whatever comes: the output is a finite voltage from 0 to the maximum; it is 0 V when off or tripped and the
 * sense voltage when sensing; state and event are of the table; and 0.25 s after the last valid command it is 0 V.
 * The board's own frames are decoded again and must be whole.
 *
 *     firmware_under_fire SEED < bytes
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "application.h"
#include "board_constants.h"

#define TICK_CHANCE 12u /* a tick for so many bytes: a line of 115200 baud and ticks of 1 ms */
#define SILENCE_CHANCE 20000u
#define SILENCE_TICKS 400u
#define EXPIRED_TICKS 252u /* 0.25 s, and a tick at either end */

mw_retained board_retained;

static mw_application application;
static mw_decoder listener;
static float output_v, highest_v;
static unsigned long frames_in, frames_out, ticks, runs, trips, silences, refusals;
static unsigned ticks_since_command, missed;
static uint8_t last_state, last_event;
static uint32_t chance_state;

static uint32_t chance(uint32_t below)
{
    chance_state ^= chance_state << 13;
    chance_state ^= chance_state >> 17;
    chance_state ^= chance_state << 5;
    return chance_state % below;
}

static void fail(const char *what)
{
    fprintf(stderr, "unsafe: %s (state %u, event %u, output %g V, tick %lu)\n", what,
            (unsigned)mw_loop_state(&application.loop), (unsigned)mw_loop_event(&application.loop), (double)output_v, ticks);
    exit(3);
}

void board_start(void)
{
}

uint8_t board_reset_cause(void)
{
    return MW_RESET_POWER_ON;
}

void board_set_drive(float drive_voltage_v)
{
    output_v = drive_voltage_v;
    if (!isfinite(drive_voltage_v) || drive_voltage_v < 0.0f || drive_voltage_v > (float)MW_MAXIMUM_VOLTAGE_V) {
        fail("the output left its range");
    }
    if (drive_voltage_v > highest_v) {
        highest_v = drive_voltage_v;
    }
}

bool board_wait(mw_board_tick *tick, mw_board_reading *reading)
{
    (void)tick;
    (void)reading;
    return false;
}

bool board_get(uint8_t *byte)
{
    (void)byte;
    return false;
}

bool board_put(const uint8_t *bytes, uint8_t length)
{
    mw_message message;
    for (uint8_t i = 0; i < length; i++) {
        const mw_frame_result result = mw_decoder_push(&listener, bytes[i], &message);
        if (result == MW_FRAME_BAD || (result == MW_FRAME_GOOD && i + 1u != length)) {
            fail("the board sent a broken frame");
        }
        if (result != MW_FRAME_GOOD) {
            continue;
        }
        frames_out++;
        if (message.type == MW_ACK) {
            frames_in++;
            if (message.payload[3] != MW_DONE) {
                refusals++;
            } else if (message.payload[2] >= MW_ARM && message.payload[2] <= MW_KEEP) {
                ticks_since_command = 0;
            }
        }
    }
    return true;
}

void board_watchdog_feed(void)
{
}

bool board_button(void)
{
    return false;
}

float board_knob(void)
{
    return 0.0f;
}

static void judge(void)
{
    const uint8_t state = mw_loop_state(&application.loop), event = mw_loop_event(&application.loop);
    if (state >= MW_STATES || event >= MW_EVENTS) {
        fail("a state or event that is not in the table");
    }
    if ((state == MW_STATE_OFF || state == MW_STATE_TRIPPED) && output_v != 0.0f) {
        fail("voltage while off");
    }
    if ((state == MW_STATE_ARMED || state == MW_STATE_DEGRADED) && output_v != (float)MW_SENSE_VOLTAGE_V) {
        fail("another voltage than the sense voltage while sensing");
    }
    if (!mw_state_drives(last_state) && state != last_state && state != MW_STATE_ARMED) {
        fail("off or tripped was left by something else than arming");
    }
    if (state == MW_STATE_TRIPPED && last_state == MW_STATE_TRIPPED && event != last_event) {
        fail("the first cause of a trip has not stayed");
    }
    if (ticks_since_command > EXPIRED_TICKS && output_v != 0.0f) {
        fail("the heater has not expired");
    }
    runs += state == MW_STATE_RUN && last_state != MW_STATE_RUN;
    trips += state == MW_STATE_TRIPPED && last_state != MW_STATE_TRIPPED;
    last_state = state;
    last_event = event;
}

static float nonsense(void)
{
    static const float odd[] = {NAN, INFINITY, -INFINITY, 0.0f, -1.0f, 1e38f, 1e-38f, 5.5f, 0.33f, -0.0f};
    return odd[chance(sizeof odd / sizeof *odd)];
}

static mw_board_reading reading_now(void)
{
    mw_board_reading reading;
    reading.ticks = (uint8_t)(1u + missed); /* the converter counts on while its conversions are not fetched */
    const float wire_ohm = 14.0f + 1e-3f * (float)chance(100);
    const float current_a = output_v / (wire_ohm + (float)MW_SHUNT_RESISTANCE_OHM);
    reading.wire_voltage_v = current_a * wire_ohm + 1e-5f * (float)chance(16);
    reading.shunt_voltage_v = current_a * (float)MW_SHUNT_RESISTANCE_OHM + 1e-6f * (float)chance(16);
    /* Most of the time the wire is healthy, so that a run gets somewhere before something is wrong. */
    if (chance(400) == 0u) {
        reading.wire_voltage_v = nonsense();
    }
    if (chance(400) == 0u) {
        reading.shunt_voltage_v = nonsense();
    }
    return reading;
}

static void tick(void)
{
    const uint32_t kind = chance(100);
    const mw_board_reading reading = reading_now();
    ticks++;
    if (kind == 0u) {
        mw_application_tick(&application, MW_TICK_PENDING, &reading);
        return; /* no time has passed */
    }
    ticks_since_command++;
    missed = kind == 1u ? missed + 1u : 0u;
    mw_application_tick(&application, kind == 1u ? MW_TICK_MISSING : MW_TICK_READING, &reading);
    judge();
}

int main(int argc, char **argv)
{
    int byte;
    unsigned long bytes = 0;
    chance_state = (argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 1u) * 2654435761u + 1u;
    mw_decoder_start(&listener);
    mw_application_start(&application);
    judge();
    while ((byte = getchar()) != EOF) {
        bytes++;
        mw_application_byte(&application, (uint8_t)byte);
        judge();
        if (chance(TICK_CHANCE) == 0u) {
            tick();
        }
        if (chance(SILENCE_CHANCE) == 0u) {
            silences++;
            for (unsigned i = 0; i < SILENCE_TICKS; i++) {
                tick();
            }
        }
    }
    printf("{\"bytes\": %lu, \"accepted\": %lu, \"rejected\": %lu, \"refused_commands\": %lu, \"runs\": %lu, "
           "\"trips\": %lu, \"silences\": %lu, \"ticks\": %lu, \"frames_sent\": %lu, \"highest_v\": %.6f}\n",
           bytes, frames_in, (unsigned long)application.bad_frames, refusals, runs, trips, silences, ticks, frames_out,
           (double)highest_v);
    return 0;
}
