/* The firmware's parts on the host's compiler: each test is a function, and its name says what must be so.
 *
 *     host_tests            runs all; prints the failed ones; exit code 1 where one failed
 *     host_tests frames     reads a body's type, sequence and payload as text, prints the frame: for golden vectors
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "application.h"
#include "board_constants.h"
#include "sense_channels.h"
#include "monitors.h"
#include "sense_ina.h"

/* ---- a board of variables --------------------------------------------------------------------------- */

mw_retained board_retained;
static uint8_t fake_cause;
static float output_v;
static bool line_full, button;
static uint8_t sent[131072];
static size_t sent_length;

uint8_t board_reset_cause(void) { return fake_cause; }
void board_set_drive(float drive_voltage_v) { output_v = drive_voltage_v; }
bool board_button(void) { return button; }
float board_knob(void) { return 0.5f; }

bool board_put(const uint8_t *bytes, uint8_t length)
{
    if (line_full || sent_length + length > sizeof sent)
        return false;
    memcpy(sent + sent_length, bytes, length);
    sent_length += length;
    return true;
}

static int failed, tests;
static void (*test[100])(void);

/* A test registers itself, so that none is written and forgotten. */
#define TEST(name)                                                                         \
    static void name(void);                                                                \
    __attribute__((constructor)) static void register_##name(void) { test[tests++] = name; } \
    static void name(void)

#define MUST(condition)                                                                    \
    do {                                                                                   \
        if (!(condition)) {                                                                \
            printf("FAILED %s, line %d: %s\n", __func__, __LINE__, #condition);            \
            failed = 1;                                                                    \
            return;                                                                        \
        }                                                                                  \
    } while (0)

static mw_application app;

static void fresh(uint8_t cause)
{
    memset(&board_retained, 0, sizeof board_retained);
    fake_cause = cause;
    sent_length = 0;
    line_full = button = false;
    output_v = -1.0f;
    mw_application_start(&app);
}

static void say(uint8_t type, const void *payload, uint8_t length)
{
    mw_message message = {.version = MW_PROTOCOL_VERSION, .type = type, .sequence = 7, .payload_length = length};
    uint8_t frame[MW_FRAME_MAX];
    memcpy(message.payload, payload, length);
    const uint8_t bytes = mw_frame_encode(&message, frame);
    for (uint8_t i = 0; i < bytes; i++)
        mw_application_byte(&app, frame[i]);
}

static void drive(float value)
{
    uint8_t payload[4];
    mw_put_f32(payload, value);
    say(MW_DRIVE, payload, 4);
}

/* Switch a board on, arm it and drive. */
static void fresh_driven(float value)
{
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    drive(value);
}

/* A wire in the middle of its window at whatever is out, with a little noise, for some ticks. */
static void live(int ticks)
{
    static unsigned noise = 1;
    const float ohm = 0.5f * ((float)MW_RESISTANCE_LOW_OHM + (float)MW_RESISTANCE_HIGH_OHM);
    for (int i = 0; i < ticks; i++) {
        noise = noise * 1664525u + 1013904223u;
        const float shunt = output_v / (ohm + (float)MW_SHUNT_RESISTANCE_OHM) * (float)MW_SHUNT_RESISTANCE_OHM;
        const float wobble = 1e-5f * (float)(noise >> 24);
        const mw_board_reading reading = {output_v - shunt + wobble, shunt + 0.01f * wobble, 1u};
        mw_application_tick(&app, MW_TICK_READING, &reading);
    }
}

static void silent(int ticks)
{
    const mw_board_reading none = {0.0f, 0.0f, 1u};
    for (int i = 0; i < ticks; i++)
        mw_application_tick(&app, MW_TICK_MISSING, &none);
}

/* The last frame of a type that was sent. */
static bool last_sent(uint8_t type, mw_message *found)
{
    mw_decoder decoder;
    mw_message message;
    bool any = false;
    mw_decoder_start(&decoder);
    for (size_t i = 0; i < sent_length; i++)
        if (mw_decoder_push(&decoder, sent[i], &message) == MW_FRAME_GOOD && message.type == type) {
            *found = message;
            any = true;
        }
    return any;
}

static uint8_t acknowledged(void)
{
    mw_message message;
    return last_sent(MW_ACK, &message) ? message.payload[3] : 255u;
}

static int ticks_of(float time_s) { return (int)(time_s / MW_TICK_S + 0.5f); }

/* ---- framing -------------------------------------------------------------------------------------- */

TEST(every_length_of_payload_comes_back)
{
    for (unsigned length = 0; length <= MW_PAYLOAD_MAX; length++) {
        mw_message in = {.version = MW_PROTOCOL_VERSION, .type = 3, .sequence = (uint16_t)(length * 257u), .payload_length = (uint8_t)length};
        mw_message out;
        mw_decoder decoder;
        uint8_t frame[MW_FRAME_MAX];
        for (unsigned i = 0; i < length; i++)
            in.payload[i] = (uint8_t)(i % 3u ? i : 0u);
        const uint8_t bytes = mw_frame_encode(&in, frame);
        MUST(bytes <= MW_FRAME_MAX && memchr(frame, 0, bytes) == frame + bytes - 1);
        mw_decoder_start(&decoder);
        mw_frame_result result = MW_FRAME_NONE;
        for (uint8_t i = 0; i < bytes; i++)
            result = mw_decoder_push(&decoder, frame[i], &out);
        MUST(result == MW_FRAME_GOOD && out.type == 3 && out.sequence == in.sequence);
        MUST(out.payload_length == length && memcmp(out.payload, in.payload, length) == 0);
    }
}

TEST(a_single_wrong_bit_drops_the_frame)
{
    mw_message in = {.version = MW_PROTOCOL_VERSION, .type = MW_KEEP, .sequence = 258}, out;
    uint8_t frame[MW_FRAME_MAX];
    const uint8_t bytes = mw_frame_encode(&in, frame);
    for (unsigned bit = 0; bit < 8u * (bytes - 1u); bit++) {
        mw_decoder decoder;
        mw_decoder_start(&decoder);
        frame[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        for (uint8_t i = 0; i < bytes; i++)
            MUST(mw_decoder_push(&decoder, frame[i], &out) != MW_FRAME_GOOD);
        frame[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
}

TEST(another_version_is_dropped)
{
    mw_message in = {.version = MW_PROTOCOL_VERSION + 1, .type = MW_KEEP}, out;
    uint8_t frame[MW_FRAME_MAX];
    mw_decoder decoder;
    const uint8_t bytes = mw_frame_encode(&in, frame);
    mw_decoder_start(&decoder);
    for (uint8_t i = 0; i + 1 < bytes; i++)
        MUST(mw_decoder_push(&decoder, frame[i], &out) == MW_FRAME_NONE);
    MUST(mw_decoder_push(&decoder, 0, &out) == MW_FRAME_BAD);
}

TEST(noise_without_zeros_counts_once_a_frames_length_and_ends_with_a_zero)
{
    mw_message out;
    mw_decoder decoder;
    int bad = 0;
    mw_decoder_start(&decoder);
    for (int i = 0; i < 980; i++)
        bad += mw_decoder_push(&decoder, 0x55, &out) == MW_FRAME_BAD;
    MUST(bad == 10);
    MUST(mw_decoder_push(&decoder, 0, &out) == MW_FRAME_NONE);
    MUST(mw_decoder_push(&decoder, 0, &out) == MW_FRAME_NONE);
}

/* ---- application ---------------------------------------------------------------------------------- */

TEST(at_the_start_the_output_is_off_and_the_board_says_who_it_is)
{
    mw_message identity;
    fresh(MW_RESET_POWER_ON);
    MUST(output_v == 0.0f);
    MUST(last_sent(MW_IDENTITY, &identity) && identity.payload_length == MW_IDENTITY_BYTES);
    MUST(identity.payload[3] == MW_RESET_POWER_ON && identity.payload[30] == MW_EVENT_NONE);
    MUST(mw_get_u32(identity.payload + 26) == MW_MODEL_CHECKSUM);
    MUST(mw_get_f32(identity.payload + 16) == (float)MW_MAXIMUM_VOLTAGE_V);
}

/* A stack without what a test before has left there: what is not written then is not right by chance. */
__attribute__((noinline)) static void forget_the_stack(void)
{
    volatile uint8_t bytes[4096];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = 0xa5u;
}

TEST(all_that_a_board_says_of_itself_is_where_the_protocol_has_it)
{
    mw_message identity;
    const uint8_t *at = identity.payload;
    fresh(MW_RESET_BROWN_OUT);
    forget_the_stack();
    sent_length = 0;
    say(MW_HELLO, "", 0);
    MUST(last_sent(MW_IDENTITY, &identity));
    MUST(at[MW_AT_IDENTITY_PROTOCOL_VERSION] == MW_PROTOCOL_VERSION);
    MUST(at[MW_AT_IDENTITY_FIRMWARE_MAJOR] == MW_FIRMWARE_MAJOR && at[MW_AT_IDENTITY_FIRMWARE_MINOR] == MW_FIRMWARE_MINOR);
    MUST(at[MW_AT_IDENTITY_RESET_CAUSE] == MW_RESET_BROWN_OUT);
    MUST(mw_get_u32(at + MW_AT_IDENTITY_TICK_PERIOD_US) == MW_TICK_PERIOD_US);
    MUST(mw_get_u32(at + MW_AT_IDENTITY_CONTROL_PERIOD_US) == MW_TICK_PERIOD_US * (uint32_t)MW_CONTROL_TICKS);
    MUST(mw_get_f32(at + MW_AT_IDENTITY_SENSE_VOLTAGE_V) == (float)MW_SENSE_VOLTAGE_V);
    MUST(mw_get_f32(at + MW_AT_IDENTITY_SHUNT_RESISTANCE_OHM) == (float)MW_SHUNT_RESISTANCE_OHM);
    MUST(mw_get_u16(at + MW_AT_IDENTITY_EXPIRY_MS) == MW_EXPIRY_MS);
    MUST(strcmp((const char *)at + MW_AT_IDENTITY_BOARD, MW_BOARD_NAME) == 0);
    MUST(strcmp((const char *)at + MW_AT_IDENTITY_QUANTITY, MW_QUANTITY) == 0);
    MUST(strcmp((const char *)at + MW_AT_IDENTITY_WIRE, MW_WIRE_NAME) == 0);
}

TEST(a_drive_before_arming_is_refused)
{
    fresh(MW_RESET_POWER_ON);
    drive(1.0f);
    MUST(acknowledged() == MW_REFUSED && output_v == 0.0f);
}

TEST(arming_puts_out_the_sense_voltage_and_a_drive_takes_effect_at_once)
{
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    MUST(acknowledged() == MW_DONE && output_v == (float)MW_SENSE_VOLTAGE_V);
    MUST(mw_loop_state(&app.loop) == MW_STATE_ARMED);
    drive(1.5f);
    MUST(acknowledged() == MW_DONE && output_v == 1.5f);
    say(MW_OFF, "", 0);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_STOPPED);
}

TEST(a_drive_that_is_no_number_or_out_of_range_trips)
{
    const float wrong[] = {NAN, INFINITY, -INFINITY, -0.1f, (float)MW_MAXIMUM_VOLTAGE_V * 1.001f};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        fresh_driven(1.0f);
        drive(wrong[i]);
        MUST(acknowledged() == MW_BAD_PAYLOAD && output_v == 0.0f);
        MUST(mw_loop_event(&app.loop) == MW_EVENT_COMMAND_REFUSED);
        drive(1.0f);
        MUST(acknowledged() == MW_REFUSED && output_v == 0.0f);
        say(MW_ARM, "", 0);
        drive(1.0f);
        MUST(output_v == 1.0f);
    }
}

TEST(wrong_types_and_lengths_are_said_and_change_nothing)
{
    fresh_driven(1.0f);
    say(0x42, "", 0);
    MUST(acknowledged() == MW_UNKNOWN && output_v == 1.0f);
    say(MW_DRIVE, "abc", 3);
    MUST(acknowledged() == MW_BAD_PAYLOAD && output_v == 1.0f);
    say(MW_OFF, "x", 1);
    MUST(acknowledged() == MW_BAD_PAYLOAD && output_v == 1.0f);
}

TEST(silence_of_the_host_is_held_then_sensed_then_off)
{
    fresh_driven(2.0f);
    live(ticks_of(0.09f));
    MUST(output_v == 2.0f && mw_loop_state(&app.loop) == MW_STATE_HOLD);
    live(ticks_of(0.02f));
    MUST(output_v == (float)MW_SENSE_VOLTAGE_V && mw_loop_state(&app.loop) == MW_STATE_DEGRADED);
    live(ticks_of(0.15f));
    MUST(output_v == 0.0f && mw_loop_state(&app.loop) == MW_STATE_TRIPPED);
    MUST(mw_loop_event(&app.loop) == MW_EVENT_COMMAND_MISSING);
}

TEST(a_keep_renews_and_a_late_drive_ends_the_silence)
{
    fresh_driven(2.0f);
    for (int i = 0; i < 20; i++) {
        live(ticks_of(0.05f));
        say(MW_KEEP, "", 0);
    }
    MUST(output_v == 2.0f && mw_loop_state(&app.loop) == MW_STATE_RUN);
    live(ticks_of(0.15f));
    MUST(output_v == (float)MW_SENSE_VOLTAGE_V);
    drive(1.0f);
    MUST(output_v == 1.0f && mw_loop_state(&app.loop) == MW_STATE_RUN);
}

TEST(asking_who_it_is_or_a_refused_command_does_not_renew)
{
    fresh_driven(2.0f);
    for (int i = 0; i < 10; i++) {
        live(ticks_of(0.03f));
        say(MW_HELLO, "", 0);
        say(MW_DRIVE, "abc", 3);
        say(0x42, "", 0);
    }
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_COMMAND_MISSING);
}

TEST(a_silent_converter_is_off_after_a_quarter_of_a_second)
{
    fresh_driven(2.0f);
    for (int i = 0; i < 9; i++) {
        silent(ticks_of(0.03f));
        drive(2.0f);
    }
    MUST(output_v == 0.0f && mw_loop_state(&app.loop) == MW_STATE_TRIPPED);
    MUST(mw_loop_event(&app.loop) == MW_EVENT_SAMPLE_LATE);
}

TEST(ticks_without_a_reading_do_not_stretch_the_silence_of_the_host)
{
    uint8_t missed = 0;
    int passed = 0;
    fresh_driven(2.0f);
    while (output_v > 0.0f && passed < ticks_of(1.0f)) { /* three of four conversions fail */
        mw_board_reading reading = {0.9f * output_v, 0.05f * output_v, 1u};
        const mw_board_tick tick = ++passed % 4 == 0 ? MW_TICK_READING : MW_TICK_MISSING;
        reading.ticks = mw_ticks_passed(&missed, tick);
        mw_application_tick(&app, tick, &reading);
    }
    MUST(passed >= ticks_of(0.25f) && passed <= ticks_of(0.26f));
    MUST(mw_loop_event(&app.loop) == MW_EVENT_COMMAND_MISSING);
    MUST(app.tick >= (uint32_t)passed - 4u); /* nor does the board's clock lose them */
}

TEST(ticks_that_were_missing_are_the_next_readings)
{
    uint8_t missed = 0;
    MUST(mw_ticks_passed(&missed, MW_TICK_READING) == 1u);
    MUST(mw_ticks_passed(&missed, MW_TICK_MISSING) == 1u && mw_ticks_passed(&missed, MW_TICK_MISSING) == 1u);
    MUST(mw_ticks_passed(&missed, MW_TICK_READING) == 3u && mw_ticks_passed(&missed, MW_TICK_READING) == 1u);
    for (int i = 0; i < 1000; i++)
        MUST(mw_ticks_passed(&missed, MW_TICK_MISSING) == 1u);
    MUST(mw_ticks_passed(&missed, MW_TICK_READING) == 255u); /* no wrap to a reading without time */
}

TEST(arming_again_does_not_make_a_hot_wire_cold)
{
    const mw_real *above_k = &app.loop.core.protection.above_ambient_k;
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    for (int i = 0; i < 40; i++) {
        drive((float)MW_MAXIMUM_VOLTAGE_V);
        live(ticks_of(0.05f));
    }
    const mw_real hot_k = *above_k;
    MUST(hot_k > 50);
    say(MW_ARM, "", 0);
    MUST(*above_k == hot_k && output_v == (float)MW_SENSE_VOLTAGE_V);
    mw_loop_trip(&app.loop, MW_EVENT_OVER_TEMPERATURE);
    say(MW_ARM, "", 0);
    MUST(*above_k == hot_k);
    say(MW_OFF, "", 0);
    live(ticks_of(5.0f)); /* what is off cools */
    MUST(*above_k < 1 && *above_k >= 0);
}

TEST(the_loop_on_the_board_begins_with_readings_of_its_own_time)
{
    uint8_t payload[4];
    fresh_driven(1.0f);
    live(ticks_of(0.05f));
    MUST(app.loop.core.samples > 0);
    mw_put_f32(payload, (float)MW_QUANTITY_MIN);
    say(MW_TARGET, payload, 4);
    MUST(app.loop.core.samples == 0 && app.loop.core.wire_sum_v == 0 && mw_loop_armed(&app.loop));
    live(ticks_of(0.03f));
    for (int i = 0; i < ticks_of(0.015f); i++) { /* for a moment nothing at all is read */
        const mw_board_reading none = {0.0f, 0.0f, 1u};
        mw_application_tick(&app, MW_TICK_READING, &none);
    }
    MUST(mw_loop_state(&app.loop) == MW_STATE_HOLD && app.loop.core.samples == 0);
}

TEST(sixteen_bad_frames_within_a_fifth_of_a_second_are_a_storm)
{
    const uint8_t garbage[] = {5, 5, 5, 0};
    fresh_driven(1.0f);
    for (int frame = 0; frame < 40; frame++) { /* 71 in a second are none */
        live(14);
        drive(1.0f);
        for (size_t i = 0; i < sizeof garbage; i++)
            mw_application_byte(&app, garbage[i]);
    }
    MUST(output_v == 1.0f);
    live(ticks_of(0.05f));
    drive(1.0f);
    for (int frame = 0; frame < 15; frame++)
        for (size_t i = 0; i < sizeof garbage; i++)
            mw_application_byte(&app, garbage[i]);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_LINK_CORRUPTED);
}

TEST(samples_are_means_and_come_every_so_many_ticks)
{
    uint8_t every[2];
    mw_message sample;
    mw_put_u16(every, 10);
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    say(MW_STREAM, every, 2);
    drive(1.0f);
    for (int i = 0; i < 9; i++) {
        const mw_board_reading reading = {0.9f, 0.05f, 1u};
        mw_application_tick(&app, MW_TICK_READING, &reading);
    }
    MUST(!last_sent(MW_SAMPLE, &sample));
    const mw_board_reading other = {1.9f, 0.15f, 1u};
    mw_application_tick(&app, MW_TICK_READING, &other);
    MUST(last_sent(MW_SAMPLE, &sample) && sample.payload_length == MW_SAMPLE_BYTES);
    MUST(mw_get_u32(sample.payload) == 10u && mw_get_u16(sample.payload + 6) == 7u);
    MUST(fabsf(mw_get_f32(sample.payload + 12) - 1.0f) < 1e-6f);
    MUST(fabsf(mw_get_f32(sample.payload + 16) - 0.06f) < 1e-6f);
}

TEST(a_target_closes_the_loop_on_the_board)
{
    uint8_t payload[4];
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    mw_put_f32(payload, 0.5f * ((float)MW_QUANTITY_MIN + (float)MW_QUANTITY_MAX));
    for (int i = 0; i < 40; i++) {
        say(MW_TARGET, payload, 4);
        live(ticks_of(0.05f));
    }
    MUST(acknowledged() == MW_DONE && mw_loop_state(&app.loop) == MW_STATE_RUN);
    MUST(output_v >= (float)MW_SENSE_VOLTAGE_V && output_v <= (float)MW_MAXIMUM_VOLTAGE_V);
    mw_put_f32(payload, (float)MW_QUANTITY_MAX * 1.1f);
    say(MW_TARGET, payload, 4);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_COMMAND_REFUSED);
}

/* ---- corrections ---------------------------------------------------------------------------------- */

#define SPAN ((float)(MW_QUANTITY_MAX - MW_QUANTITY_MIN))

static void correct(float scale, float zero)
{
    uint8_t payload[MW_CORRECT_BYTES];
    mw_put_f32(payload + MW_AT_CORRECT_SCALE, scale);
    mw_put_f32(payload + MW_AT_CORRECT_ZERO, zero);
    say(MW_CORRECT, payload, sizeof payload);
}

static void follow_target(float target)
{
    uint8_t payload[4];
    mw_put_f32(payload, target);
    say(MW_TARGET, payload, 4);
}

static bool is_corrected(float scale, float zero) { return app.loop.scale == scale && app.loop.zero == zero; }

/* One control tick of a wire of so many ohm, without noise. */
static void one_control_tick(float ohm)
{
    const float shunt = output_v / (ohm + (float)MW_SHUNT_RESISTANCE_OHM) * (float)MW_SHUNT_RESISTANCE_OHM;
    const mw_board_reading reading = {output_v - shunt, shunt, 1u};
    for (int i = 0; i < (int)MW_CONTROL_TICKS; i++)
        mw_application_tick(&app, MW_TICK_READING, &reading);
}

TEST(a_correction_is_told_back_and_out_of_range_changes_nothing)
{
    const float wrong[][2] = {{NAN, 0.0f},     {1.0f, NAN},      {INFINITY, 0.0f},      {1.0f, -INFINITY},
                              {1.061f, 0.0f}, {0.939f, 0.0f}, {1.0f, 1.01f * SPAN}, {1.0f, -1.01f * SPAN}};
    mw_message told;
    fresh_driven(1.0f);
    correct(1.05f, -0.5f * SPAN);
    MUST(acknowledged() == MW_DONE && is_corrected(1.05f, -0.5f * SPAN) && output_v == 1.0f);
    MUST(last_sent(MW_CORRECTION, &told) && told.payload_length == MW_CORRECTION_BYTES);
    MUST(mw_get_f32(told.payload + MW_AT_CORRECTION_SCALE) == 1.05f);
    MUST(mw_get_f32(told.payload + MW_AT_CORRECTION_ZERO) == -0.5f * SPAN);
    sent_length = 0;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        correct(wrong[i][0], wrong[i][1]);
        MUST(acknowledged() == MW_BAD_PAYLOAD && !last_sent(MW_CORRECTION, &told));
        MUST(is_corrected(1.05f, -0.5f * SPAN) && output_v == 1.0f);
    }
    say(MW_CORRECT, "abcd", 4);
    MUST(acknowledged() == MW_BAD_PAYLOAD && is_corrected(1.05f, -0.5f * SPAN));
}

TEST(arming_and_a_reset_forget_a_correction_and_a_correction_renews_nothing)
{
    fresh_driven(1.0f);
    live(ticks_of(0.05f));
    correct(1.01f, 0.1f * SPAN);
    live(ticks_of(0.06f));
    MUST(output_v == (float)MW_SENSE_VOLTAGE_V && is_corrected(1.01f, 0.1f * SPAN));
    say(MW_ARM, "", 0);
    MUST(is_corrected(1.0f, 0.0f));
    correct(1.01f, 0.1f * SPAN);
    mw_application_start(&app);
    MUST(is_corrected(1.0f, 0.0f));
}

TEST(a_corrected_loop_sees_the_scaled_resistance_and_the_power_that_was_read)
{
    const float ohm = 0.5f * (float)(MW_OWN_LOW_OHM + MW_OWN_HIGH_OHM);
    const float middle = 0.5f * (float)(MW_QUANTITY_MIN + MW_QUANTITY_MAX);
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    for (int i = 0; i < 3; i++) {
        follow_target(middle);
        one_control_tick(ohm);
    }
    correct(0.98f, 0.05f * SPAN);
    MUST(app.loop.core.started && !app.loop.core.follower.followed);
    follow_target(middle);
    const float read_v = output_v / (ohm + (float)MW_SHUNT_RESISTANCE_OHM) * ohm;
    one_control_tick(ohm);
    MUST(fabsf((float)app.loop.core.resistance_ohm / ohm - 0.98f) < 1e-5f);
    MUST(fabsf((float)app.loop.core.follower.measured_w / (read_v * read_v / ohm) - 1.0f) < 1e-5f);
    MUST(fabsf((float)app.loop.core.inverse_model.target - middle - 0.05f * SPAN) < 1e-6f * SPAN);
    MUST(fabsf(mw_loop_resistance(&app.loop) / ohm - 1.0f) < 1e-5f); /* the protection has read the wire as it is */
}

TEST(an_estimate_before_the_first_target_is_by_the_corrected_model_too)
{
    uint8_t every[2];
    mw_message sample;
    fresh_driven(1.0f);
    mw_put_u16(every, MW_CONTROL_TICKS);
    say(MW_STREAM, every, 2);
    correct(0.98f, 0.0f);
    one_control_tick(0.5f * (float)(MW_RESISTANCE_LOW_OHM + MW_RESISTANCE_HIGH_OHM));
    MUST(last_sent(MW_SAMPLE, &sample));
    const float ohm = mw_get_f32(sample.payload + MW_AT_SAMPLE_RESISTANCE_OHM);
    MUST(mw_get_f32(sample.payload + MW_AT_SAMPLE_ESTIMATE) == (float)mw_estimate((mw_real)0.98f * (mw_real)ohm).value);
}

TEST(a_zero_never_takes_a_target_beyond_the_models_highest)
{
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    correct(1.0f, 0.5f * SPAN);
    follow_target((float)MW_TARGET_HIGHEST);
    live(ticks_of(0.06f));
    MUST(acknowledged() == MW_DONE && app.loop.core.inverse_model.target == MW_TARGET_HIGHEST);
    correct(1.0f, -0.5f * SPAN); /* so much further up today's highest target is */
    follow_target((float)MW_TARGET_HIGHEST + 0.4f * SPAN);
    MUST(acknowledged() == MW_DONE && output_v >= (float)MW_SENSE_VOLTAGE_V);
    follow_target((float)MW_TARGET_HIGHEST + 0.6f * SPAN);
    MUST(acknowledged() == MW_BAD_PAYLOAD && output_v == 0.0f);
    MUST(mw_loop_event(&app.loop) == MW_EVENT_COMMAND_REFUSED);
}

TEST(a_line_that_nobody_reads_changes_nothing)
{
    fresh(MW_RESET_POWER_ON);
    line_full = true;
    say(MW_ARM, "", 0);
    drive(2.0f);
    MUST(output_v == 2.0f);
    live(ticks_of(0.3f));
    MUST(output_v == 0.0f);
}

TEST(a_reset_in_a_run_is_told_as_what_it_was)
{
    fresh_driven(2.0f);
    fake_cause = MW_RESET_WATCHDOG;
    mw_application_start(&app);
    MUST(output_v == 0.0f && app.event_at_reset == MW_EVENT_WATCHDOG);
    say(MW_ARM, "", 0);
    drive(2.0f);
    fake_cause = MW_RESET_EXTERNAL;
    mw_application_start(&app);
    MUST(output_v == 0.0f && app.event_at_reset == MW_EVENT_POWER_LOST);
    board_retained.check ^= 1u; /* the dip of the supply took the memory, too */
    mw_application_start(&app);
    MUST(app.event_at_reset == MW_EVENT_NONE);
}

TEST(memory_of_a_clean_end_is_no_lost_power)
{
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    say(MW_OFF, "", 0);
    fake_cause = MW_RESET_EXTERNAL;
    mw_application_start(&app);
    MUST(app.event_at_reset == MW_EVENT_STOPPED);
}

/* ---- what keeps a wire safe behind something else that does ------------------------------------------ */

/* Some ticks of a healthy wire whose node, wire and shunt together, moves by so many volts from tick to tick. */
static void node_moves(int ticks, float volts)
{
    const float ohm = 0.5f * ((float)MW_RESISTANCE_LOW_OHM + (float)MW_RESISTANCE_HIGH_OHM);
    for (int i = 0; i < ticks; i++) {
        const float noise = 1e-5f * (float)(i % 7);
        const float shunt = output_v / (ohm + (float)MW_SHUNT_RESISTANCE_OHM) * (float)MW_SHUNT_RESISTANCE_OHM + noise;
        const mw_board_reading reading = {output_v - shunt + (i % 2 ? volts : 0.0f), shunt, 1u};
        if (i % ticks_of(0.05f) == 0)
            say(MW_KEEP, "", 0);
        mw_application_tick(&app, MW_TICK_READING, &reading);
    }
}

TEST(a_node_that_stands_still_while_the_shunt_moves_is_frozen_after_three_tenths_of_a_second)
{
    fresh_driven(1.0f);
    node_moves(ticks_of(0.29f), 0.0f);
    MUST(output_v == 1.0f);
    node_moves(ticks_of(0.02f), 0.0f);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_CHANNEL_FROZEN);
}

TEST(a_node_that_moves_by_one_step_of_its_converter_is_not_frozen)
{
    fresh_driven(1.0f);
    node_moves(ticks_of(1.0f), MW_NODE_RANGE_V / (float)MW_CONVERTER_FULL_CODE);
    MUST(output_v == 1.0f && mw_loop_event(&app.loop) == MW_EVENT_NONE);
}

TEST(a_node_stands_still_by_the_time_that_its_readings_cover_and_only_while_it_is_driven)
{
    const float shunt = 0.05f;
    mw_board_reading reading = {1.0f - shunt, shunt, 10u};
    fresh(MW_RESET_POWER_ON);
    for (int i = 0; i < 100; i++)
        mw_application_tick(&app, MW_TICK_READING, &reading);
    say(MW_ARM, "", 0);
    drive(1.0f);
    MUST(app.node_still_s == 0.0f);
    for (int i = 0; i < 20; i++) {
        reading.shunt_voltage_v = shunt + 1e-5f * (float)(i % 7);
        reading.wire_voltage_v = 1.0f - reading.shunt_voltage_v;
        mw_application_tick(&app, MW_TICK_READING, &reading);
        say(MW_KEEP, "", 0);
    }
    MUST(fabsf(app.node_still_s - 0.2f) < 0.011f && output_v == 1.0f);
}

static void garbage(int frames)
{
    const uint8_t bytes[] = {5, 5, 5, 0};
    for (int frame = 0; frame < frames; frame++)
        for (size_t i = 0; i < sizeof bytes; i++)
            mw_application_byte(&app, bytes[i]);
}

TEST(the_first_frames_after_a_start_may_be_a_storm_from_the_sixteenth_on)
{
    fresh_driven(1.0f);
    garbage(15);
    MUST(output_v == 1.0f);
    garbage(1);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_LINK_CORRUPTED);
    fresh_driven(1.0f);
    live(ticks_of(1.0f)); /* tripped by silence, and armed again: the ticks are no longer near 0 */
    say(MW_ARM, "", 0);
    drive(1.0f);
    garbage(15);
    MUST(output_v == 1.0f);
    garbage(1);
    MUST(output_v == 0.0f);
}

TEST(sixteen_bad_frames_that_just_fit_into_a_fifth_of_a_second_are_a_storm)
{
    fresh_driven(1.0f);
    for (int frame = 0; frame < 15; frame++) {
        garbage(1);
        live(13);
        drive(1.0f);
    }
    MUST(output_v == 1.0f);
    garbage(1);
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_LINK_CORRUPTED);
}

TEST(a_number_that_is_no_state_counts_as_tripped)
{
    mw_protection *protection = &app.loop.core.protection;
    for (unsigned state = MW_STATES; state < 256u; state++) {
        fresh_driven(2.0f);
        protection->state = (uint8_t)state; /* memory that has been overwritten */
        MUST(!mw_state_drives((uint8_t)state) && mw_loop_output(&app.loop) == 0.0f);
        drive(1.0f);
        MUST(output_v == 0.0f && acknowledged() == MW_REFUSED);
        mw_protect_command(protection, MW_R(1.0));
        MUST(mw_loop_output(&app.loop) == 0.0f);
        say(MW_ARM, "", 0);
        MUST(output_v == (float)MW_SENSE_VOLTAGE_V);
    }
}

TEST(what_is_off_or_has_tripped_holds_no_drive_that_could_come_out)
{
    const mw_protection *protection = &app.loop.core.protection;
    fresh_driven(2.0f);
    MUST(protection->drive_voltage_v == MW_R(2.0));
    mw_loop_trip(&app.loop, MW_EVENT_OVER_CURRENT);
    MUST(protection->drive_voltage_v == 0);
    fresh_driven(2.0f);
    say(MW_OFF, "", 0);
    MUST(protection->drive_voltage_v == 0);
}

TEST(a_warmth_that_cannot_be_is_that_of_a_cold_wire_when_it_is_armed)
{
    const mw_real wrong[] = {NAN, -INFINITY, MW_R(-100.0), MW_R(-0.5), MW_R(-1e-3)};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        fresh(MW_RESET_POWER_ON);
        app.loop.core.protection.above_ambient_k = wrong[i];
        say(MW_ARM, "", 0);
        MUST(app.loop.core.protection.above_ambient_k == 0);
    }
}

TEST(the_loop_on_the_board_starts_anew_from_the_drive_that_is_out_after_a_silence)
{
    uint8_t payload[4];
    fresh(MW_RESET_POWER_ON);
    say(MW_ARM, "", 0);
    mw_put_f32(payload, 0.5f * ((float)MW_QUANTITY_MIN + (float)MW_QUANTITY_MAX));
    for (int i = 0; i < 4; i++) {
        say(MW_TARGET, payload, 4);
        live(ticks_of(0.05f));
    }
    MUST(app.loop.core.started);
    live(ticks_of(0.15f));
    MUST(output_v == (float)MW_SENSE_VOLTAGE_V && mw_loop_state(&app.loop) == MW_STATE_DEGRADED);
    say(MW_KEEP, "", 0);
    MUST(!app.loop.core.started && app.loop.core.samples == 0);
}

/* How warm one reading makes a cold wire, and its closed form for a constant power: P / G (1 - exp(-G t / C)). */
static double warmed_k(mw_real drive_v, mw_real wire_v, mw_real shunt_v, mw_real dt_s)
{
    mw_protection protection;
    mw_protect_arm(&protection);
    mw_protect_command(&protection, drive_v);
    mw_protect_reading(&protection, drive_v, wire_v, shunt_v, drive_v, dt_s);
    return (double)protection.above_ambient_k;
}

static bool is_warmed(double above_k, double power_w, double dt_s)
{
    const double loss = (double)MW_HEAT_LOSS_W_PER_K, capacity = (double)MW_HEAT_CAPACITY_J_PER_K;
    const double exact_k = -power_w / loss * expm1(-loss / capacity * dt_s);
    return fabs(above_k - exact_k) < 1e-4 * exact_k;
}

TEST(the_wire_of_a_missing_reading_is_heated_by_what_was_ordered)
{
    const mw_real missing[][2] = {{NAN, MW_R(0.1)}, {MW_R(1.9), INFINITY}, {0, 0}, {2, 0}};
    const double ordered_w = (double)MW_LARGEST_W_PER_V2 * 2.0 * 2.0;
    for (size_t i = 0; i < sizeof missing / sizeof missing[0]; i++)
        MUST(is_warmed(warmed_k(2, missing[i][0], missing[i][1], MW_R(0.01)), ordered_w, 0.01));
}

TEST(the_larger_of_read_and_ordered_power_heats_on_a_reversed_channel_too)
{
    const double ordered_w = (double)MW_LARGEST_W_PER_V2 * 2.0 * 2.0, read_w = 1.9 * 0.3 / (double)MW_SHUNT_RESISTANCE_OHM;
    MUST(read_w > ordered_w);
    MUST(is_warmed(warmed_k(2, MW_R(1.9), MW_R(0.3), MW_R(0.01)), read_w, 0.01));
    MUST(is_warmed(warmed_k(2, MW_R(-1.9), MW_R(0.3), MW_R(0.01)), read_w, 0.01));
    MUST(is_warmed(warmed_k(2, MW_R(1.9), MW_R(-0.3), MW_R(0.01)), read_w, 0.01));
    MUST(is_warmed(warmed_k(2, MW_R(0.5), MW_R(0.03), MW_R(0.01)), ordered_w, 0.01));
}

TEST(a_wire_that_gets_too_hot_while_its_readings_are_missing_is_off_for_that)
{
    mw_protection protection;
    mw_protect_arm(&protection);
    mw_protect_command(&protection, 2);
    protection.above_ambient_k = MW_MAXIMUM_ABOVE_AMBIENT_K + 10;
    mw_protect_reading(&protection, 2, NAN, NAN, 2, MW_R(0.01));
    MUST(protection.state == MW_STATE_TRIPPED && protection.event == MW_EVENT_OVER_TEMPERATURE);
}

#ifdef MW_STANDALONE
static void press(void)
{
    button = true;
    live(ticks_of(0.04f));
    button = false;
    live(ticks_of(0.04f));
}

TEST(alone_a_button_starts_and_stops_the_staircase)
{
    fresh(MW_RESET_POWER_ON);
    live(ticks_of(0.05f));
    MUST(output_v == 0.0f);
    press();
    MUST(fabsf(app.loop.target - 0.015f) < 1e-6f);
    live(ticks_of(2.0f)); /* no host, no expiry */
    MUST(mw_loop_state(&app.loop) == MW_STATE_RUN && output_v >= (float)MW_SENSE_VOLTAGE_V);
    press();
    MUST(output_v == 0.0f && mw_loop_state(&app.loop) == MW_STATE_OFF);
}

TEST(alone_a_bouncing_contact_is_one_press)
{
    fresh(MW_RESET_POWER_ON);
    live(ticks_of(0.05f));
    for (int i = 0; i < 7; i++) {
        button = !button;
        live(ticks_of(0.003f));
    }
    live(ticks_of(0.1f));
    MUST(mw_loop_state(&app.loop) == MW_STATE_RUN);
}

TEST(alone_nothing_starts_after_a_watchdog_reset)
{
    fresh(MW_RESET_WATCHDOG);
    live(ticks_of(0.05f));
    press();
    live(100);
    MUST(output_v == 0.0f);
}

TEST(a_host_takes_over_and_its_silence_counts_again)
{
    fresh(MW_RESET_POWER_ON);
    live(ticks_of(0.05f));
    press();
    drive(1.0f);
    MUST(output_v == 1.0f);
    live(ticks_of(0.3f));
    MUST(output_v == 0.0f && mw_loop_event(&app.loop) == MW_EVENT_COMMAND_MISSING);
}

TEST(alone_a_contact_counts_once_it_has_been_closed_for_thirty_milliseconds)
{
    fresh(MW_RESET_POWER_ON);
    live(ticks_of(0.03f)); /* it counts as held down until it has been open for as long */
    button = true;
    live(ticks_of(0.03f) - 1);
    MUST(output_v == 0.0f);
    live(1);
    MUST(output_v >= (float)MW_SENSE_VOLTAGE_V);
    button = false; /* at once: it is open, and closed again, after as long */
    live(ticks_of(0.03f));
    button = true;
    live(ticks_of(0.03f) - 1);
    MUST(output_v >= (float)MW_SENSE_VOLTAGE_V);
    live(1);
    MUST(output_v == 0.0f);
}

TEST(alone_a_button_that_is_held_down_at_the_start_starts_nothing_until_it_is_pressed_again)
{
    fresh(MW_RESET_POWER_ON);
    button = true;
    live(ticks_of(1.0f));
    MUST(output_v == 0.0f);
    button = false;
    live(ticks_of(1.0f));
    MUST(output_v == 0.0f);
    press();
    MUST(mw_loop_state(&app.loop) == MW_STATE_RUN);
}

TEST(alone_only_a_clean_start_lets_the_button_heat)
{
    const uint8_t causes[] = {MW_RESET_POWER_ON, MW_RESET_EXTERNAL, MW_RESET_WATCHDOG, MW_RESET_BROWN_OUT, 200u};
    for (size_t i = 0; i < sizeof causes; i++) {
        fresh(causes[i]);
        live(ticks_of(0.05f));
        press();
        MUST((output_v > 0.0f) == (causes[i] == MW_RESET_POWER_ON || causes[i] == MW_RESET_EXTERNAL));
    }
}

TEST(alone_a_reading_of_many_ticks_is_no_silence_of_a_host)
{
    fresh(MW_RESET_POWER_ON);
    live(ticks_of(0.05f));
    press();
    const float ohm = 0.5f * ((float)MW_RESISTANCE_LOW_OHM + (float)MW_RESISTANCE_HIGH_OHM);
    const float current = output_v / (ohm + (float)MW_SHUNT_RESISTANCE_OHM);
    const mw_board_reading late = {current * ohm, current * (float)MW_SHUNT_RESISTANCE_OHM, 255u};
    mw_application_tick(&app, MW_TICK_READING, &late);
    MUST(mw_loop_state(&app.loop) == MW_STATE_RUN && mw_loop_event(&app.loop) == MW_EVENT_NONE);
}

TEST(alone_the_papers_staircase_goes_up_and_down_in_steps_of_six_seconds_and_begins_again)
{
    const float levels[] = {1.5f, 1.8f, 2.1f, 2.4f, 2.7f, 3.0f, 2.7f, 2.4f, 2.1f, 1.8f, 1.5f, 1.5f};
    mw_standalone standalone;
    mw_control_loop loop;
    mw_loop_start(&loop);
    mw_loop_arm(&loop);
    mw_standalone_start(&standalone, MW_RESET_POWER_ON);
    button = false;
    standalone.running = true;
    for (int i = 0; i < ticks_of(69.0f); i++) {
        const float seconds = (float)i * MW_TICK_S, in_step_s = fmodf(seconds, 6.0f);
        mw_standalone_tick(&standalone, &loop);
        if (in_step_s > 0.01f && in_step_s < 5.99f) /* but where rounding may fall on either side */
            MUST(fabsf(100.0f * loop.target - levels[(int)(seconds / 6.0f)]) < 1e-4f);
    }
}
#endif

/* ---- sense front ends ----------------------------------------------------------------------------- */

TEST(channels_turn_codes_into_volts)
{
    const mw_channels channels = {65535u, 5.5f, 0.33f};
    const mw_board_reading reading = mw_sense_channels(&channels, 32768u, 16384u);
    MUST(fabsf(reading.shunt_voltage_v - 0.33f * 16384.0f / 65535.0f) < 1e-6f);
    MUST(fabsf(reading.wire_voltage_v + reading.shunt_voltage_v - 5.5f * 32768.0f / 65535.0f) < 1e-6f);
}

TEST(a_saturated_channel_reads_as_the_end_of_its_range)
{
    const mw_channels channels = {65535u, 5.5f, 0.33f};
    MUST(mw_sense_channels(&channels, 65535u, 30000u).wire_voltage_v == 5.5f);
    MUST(mw_sense_channels(&channels, 30000u, 65535u).shunt_voltage_v == 0.33f);
}

/* Monitor chips of registers, by their data sheets and not by the table: what they wake up with, widths, steps, how the
 * ready flag is cleared, the time of a pair of conversions. */
typedef struct {
    uint8_t number, maker_at, kind_at, configuration_at, flags_at, clear_at, shunt_at, bus_at, bytes, shunt_shift, bus_shift;
    uint16_t maker, kind, wakes_with, settings, ready, overflow;
    int32_t shunt_end; /* [steps] */
    double shunt_step_v, bus_step_v;
    int pair_us;
} chip_sheet;

static const chip_sheet sheets[] = {
    {MW_INA219, 0xf0, 0xf0, 0, 2, 3, 1, 2, 2, 0, 3, 0, 0, 0x399f, 0x199f, 2, 1, 32000, 10e-6, 4e-3, 1064},
    {MW_INA226, 0xfe, 0xff, 0, 6, 6, 1, 2, 2, 0, 0, 0x5449, 0x2260, 0x4127, 0x4097, 8, 4, 32767, 2.5e-6, 1.25e-3, 664},
    {MW_INA228, 0x3e, 0x3f, 1, 11, 11, 4, 5, 3, 4, 4, 0x5449, 0x2281, 0xfb68, 0xb6e8, 2, 0x200, 524287, 312.5e-9,
     195.3125e-6, 560},
    {MW_INA260, 0xfe, 0xff, 0, 6, 6, 1, 2, 2, 0, 0, 0x5449, 0x2270, 0x6127, 0x6097, 8, 4, 32767, 2e-3 * 1.25e-3, 1.25e-3,
     664},
};
#define SHEETS (sizeof sheets / sizeof sheets[0])

typedef struct {
    const chip_sheet *sheet;
    uint16_t settings;
    double shunt_v, bus_v;
    int now_us, taken_us; /* since when the next pair is converted */
    bool overflowed;
    int calls_left; /* the cable falls out after them; -1: never */
    int writes;
} chip_model;

static bool is_there(chip_model *chip, uint8_t address)
{
    if (address != 0x45u || chip->calls_left == 0)
        return false;
    chip->calls_left -= chip->calls_left > 0;
    return true;
}

static bool model_write(void *bus, uint8_t address, uint8_t chip_register, uint16_t value)
{
    chip_model *chip = bus;
    if (!is_there(chip, address))
        return false;
    chip->writes++;
    if (chip_register == chip->sheet->configuration_at) {
        chip->settings = value;
        chip->taken_us = chip->now_us;
    }
    return true;
}

/* An odd end is that of two's complement, which reaches one step further below zero. */
static uint32_t steps_of(double value, int32_t end)
{
    return (uint32_t)(int32_t)lrint(fmin(fmax(value, -end - (end & 1)), end));
}

static bool model_read(void *bus, uint8_t address, uint8_t chip_register, uint8_t bytes, uint32_t *value)
{
    chip_model *chip = bus;
    const chip_sheet *sheet = chip->sheet;
    const uint32_t kept = bytes == 3u ? 0xffffffu : 0xffffu;
    if (!is_there(chip, address))
        return false;
    const bool ready = chip->now_us - chip->taken_us >= sheet->pair_us;
    *value = 0u;
    if (chip_register == sheet->maker_at)
        *value = sheet->maker;
    if (chip_register == sheet->kind_at)
        *value = sheet->kind;
    if (chip_register == sheet->configuration_at)
        *value = chip->settings;
    if (chip_register == sheet->shunt_at && bytes == sheet->bytes)
        *value = (steps_of(chip->shunt_v / sheet->shunt_step_v, sheet->shunt_end) << sheet->shunt_shift) & kept;
    if (chip_register == sheet->bus_at && bytes == sheet->bytes)
        *value = (steps_of(chip->bus_v / sheet->bus_step_v, 1000000) << sheet->bus_shift) & kept;
    if (chip_register == sheet->flags_at)
        *value |= (ready ? sheet->ready : 0u) | (chip->overflowed ? sheet->overflow : 0u);
    if (chip_register == sheet->clear_at && ready)
        chip->taken_us = chip->now_us;
    return true;
}

static chip_model woken(const chip_sheet *sheet)
{
    return (chip_model){.sheet = sheet, .settings = sheet->wakes_with, .shunt_v = 0.05, .bus_v = 3.0, .calls_left = -1};
}

TEST(each_monitor_chip_is_found_and_gives_each_pair_once_and_in_volts)
{
    for (size_t i = 0; i < SHEETS; i++) {
        const chip_sheet *sheet = &sheets[i];
        chip_model model = woken(sheet);
        mw_ina chip = {model_write, model_read, &model, 0x45u, NULL};
        mw_board_reading reading;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_LOST);
        MUST(mw_ina_start(&chip) && chip.kind == mw_ina_kind_of(sheet->number) && model.settings == sheet->settings);
        MUST(mw_ina_start(&chip)); /* the processor alone was reset */
        model.now_us += sheet->pair_us - 1;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_NOT_YET);
        model.now_us += 1;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_READY);
        MUST(fabs(reading.shunt_voltage_v - 0.05) <= 0.5 * sheet->shunt_step_v + 1e-7);
        MUST(fabs(reading.wire_voltage_v - 2.95) <= 0.5 * (sheet->bus_step_v + sheet->shunt_step_v) + 1e-6);
        MUST(mw_ina_read(&chip, &reading) == MW_INA_NOT_YET);
        model.now_us += sheet->pair_us;
        model.shunt_v = -0.0025;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_READY && fabsf(reading.shunt_voltage_v + 0.0025f) < 1e-7f);
        for (int sign = -1; sign <= 1; sign += 2) {
            model.now_us += sheet->pair_us;
            model.shunt_v = sign * 1.0;
            MUST(mw_ina_read(&chip, &reading) == MW_INA_OVERFLOW && sign * reading.shunt_voltage_v > 0.08f);
        }
        model.now_us += sheet->pair_us;
        model.shunt_v = 0.05;
        model.overflowed = true;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_OVERFLOW);
    }
}

TEST(a_monitor_chip_that_is_gone_foreign_or_forgetful_is_not_believed)
{
    for (size_t i = 0; i < SHEETS; i++) {
        mw_board_reading reading;
        for (size_t j = 0; j < SHEETS; j++) {
            chip_model other = woken(&sheets[j]);
            mw_ina chip = {model_write, model_read, &other, 0x45u, mw_ina_kind_of(sheets[i].number)};
            MUST(mw_ina_start(&chip) == (i == j) && (i == j || other.writes == 0));
        }
        chip_model model = woken(&sheets[i]);
        mw_ina chip = {model_write, model_read, &model, 0x45u, NULL};
        MUST(mw_ina_start(&chip));
        model.settings = sheets[i].wakes_with; /* its supply dipped */
        model.now_us += sheets[i].pair_us;
        MUST(mw_ina_read(&chip, &reading) == MW_INA_LOST);
        MUST(mw_ina_start(&chip));
        for (int calls = 0; calls < 4; calls++) {
            model.calls_left = -1;
            model.now_us += sheets[i].pair_us;
            model.calls_left = calls;
            MUST(mw_ina_read(&chip, &reading) == MW_INA_LOST);
        }
        chip_model foreign = woken(&sheets[i]);
        foreign.settings = 0x1234u;
        chip_sheet sheet = sheets[i];
        sheet.maker = 0x1234u;
        foreign.sheet = &sheet;
        chip = (mw_ina){model_write, model_read, &foreign, 0x45u, NULL};
        MUST(!mw_ina_start(&chip) && foreign.writes == 0);
    }
}

/* ---- lines of text ---------------------------------------------------------------------------------- */

/* Types a line and lets what is said to it be sent. */
static void type_line(const char *line)
{
    sent_length = 0;
    for (; *line; line++)
        mw_application_byte(&app, (uint8_t)*line);
    mw_application_byte(&app, '\n');
    live(60);
}

static bool was_said(const char *text)
{
    sent[sent_length] = 0;
    return strstr((const char *)sent, text) != NULL;
}

static bool is_out(float volts) { return fabsf(output_v - volts) < 1e-4f; }

#define SECONDS(s) ((int)((s) / MW_TICK_S))

static void fresh_text(void)
{
    fresh(MW_RESET_POWER_ON);
    type_line("plot");
    type_line("on");
}

TEST(a_typed_word_switches_to_text_and_a_zero_back_to_frames)
{
    fresh(MW_RESET_POWER_ON);
    type_line("on");
    MUST(sent_length == 0u && is_out(0.0f)); /* in frames only two words are text */
    type_line("Help");
    MUST(was_said("# target 2.0 [20]") && was_said("at the sense") == false && is_out(0.0f));
    type_line("plot");
    MUST(was_said("target_" MW_PLOT_UNIT ":nan estimate_") && was_said(" drive_v:0.000\r\n"));
    type_line("on");
    MUST(is_out((float)MW_SENSE_VOLTAGE_V) && was_said("# on"));
    mw_application_byte(&app, 0u);
    MUST(is_out(0.0f)); /* a host comes: it arms for itself */
    sent_length = 0;
    say(MW_HELLO, "", 0);
    mw_message identity;
    MUST(last_sent(MW_IDENTITY, &identity));
    sent_length = 0;
    live(SECONDS(1.0f));
    MUST(sent_length == 0u);
}

TEST(numbers_come_25_times_a_second)
{
    fresh_text();
    sent_length = 0;
    live(SECONDS(10.0f));
    int lines = 0;
    for (size_t i = 0; i < sent_length; i++)
        lines += sent[i] == '\n';
    MUST(lines >= 249 && lines <= 251);
    const float ohm = 0.5f * ((float)MW_RESISTANCE_LOW_OHM + (float)MW_RESISTANCE_HIGH_OHM);
    sent[sent_length] = 0;
    const char *at = strstr((const char *)sent, "resistance_ohm:");
    MUST(at && fabsf((float)atof(at + 15) - ohm) < 0.02f * ohm);
    at = strstr((const char *)sent, "drive_v:");
    MUST(at && fabsf((float)atof(at + 8) - (float)MW_SENSE_VOLTAGE_V) < 6e-4f);
    for (sent_length = 0; sent_length == 0u;)
        live(1);
    MUST(app.sums.count == 0u && app.sums.wire_voltage_v == 0.0f && app.sums.shunt_voltage_v == 0.0f);
}

TEST(a_command_ends_by_itself_at_the_sense_voltage_and_a_board_left_alone_goes_off)
{
    fresh_text();
    type_line("drive 1.5 20");
    MUST(is_out(1.5f));
    live(SECONDS(19.0f));
    MUST(is_out(1.5f)); /* nobody sends anything meanwhile */
    sent_length = 0;
    live(SECONDS(1.2f));
    MUST(is_out((float)MW_SENSE_VOLTAGE_V) && was_said("# time is over"));
    type_line("drive 1,25"); /* 30 s, and a comma */
    MUST(is_out(1.25f));
    live(SECONDS(29.0f));
    MUST(is_out(1.25f));
    live(SECONDS(1.2f));
    MUST(is_out((float)MW_SENSE_VOLTAGE_V));
    live(SECONDS(298.0f));
    MUST(is_out((float)MW_SENSE_VOLTAGE_V));
    sent_length = 0;
    live(SECONDS(3.0f));
    MUST(is_out(0.0f) && was_said("# no command for five minutes: off"));
}

TEST(a_sweep_goes_up_to_the_amplitude_and_back)
{
    fresh_text();
    type_line("sweep");
    float highest = 0.0f;
    for (int i = 0; i < SECONDS(89.0f); i++) {
        live(1);
        highest = output_v > highest ? output_v : highest;
    }
    MUST(fabsf(highest - MW_DRIVE_AMPLITUDE_V) < 0.02f);
    MUST(output_v < (float)MW_SENSE_VOLTAGE_V + 0.15f);
    live(SECONDS(1.5f));
    MUST(is_out((float)MW_SENSE_VOLTAGE_V));
}

TEST(what_cannot_be_is_refused_and_changes_nothing)
{
    static const char *const wrong[] = {"drive 99",    "drive -1", "drive 1 121", "drive 1 0", "drive",    "drive 1 2 3",
                                        "drive 1.5 x", "target 99", "target",     "targets 1", "drive1.5", "drive nan",
                                        "a line that is much too long to be a command of this board", "\x80\xff"};
    fresh(MW_RESET_POWER_ON);
    type_line("plot");
    type_line("drive 1");
    MUST(is_out(0.0f) && was_said("# refused: type on first"));
    type_line("sweep");
    MUST(is_out(0.0f) && was_said("# refused: type on first"));
    type_line("on");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        type_line(wrong[i]);
        MUST(is_out((float)MW_SENSE_VOLTAGE_V) && (was_said("# refused: target") || was_said("# what is that?")));
    }
    type_line("drive 1.5");
    type_line("stop");
    MUST(is_out(0.0f) && was_said("# off"));
}

TEST(text_is_below_the_protection)
{
    fresh_text();
    type_line("drive 1.5");
    sent_length = 0;
    silent(SECONDS(0.3f));
    MUST(is_out(0.0f) && was_said("# protection: sample_late") && was_said(", off"));
    type_line("drive 1.5");
    MUST(is_out(0.0f) && was_said("# refused: type on first"));
    type_line("on");
    MUST(is_out((float)MW_SENSE_VOLTAGE_V));
    type_line("drive 1.5");
    for (int i = 0; i < SECONDS(0.5f); i++) {
        const mw_board_reading open = {output_v, 0.0f, 1u};
        mw_application_tick(&app, MW_TICK_READING, &open);
    }
    MUST(is_out(0.0f));
}

TEST(a_typed_target_closes_the_loop)
{
    char line[MW_TEXT_LINE_BYTES];
    fresh_text();
    const float middle = 0.5f * (float)(MW_QUANTITY_MIN + MW_QUANTITY_MAX);
    snprintf(line, sizeof line, "target %.2f", (double)(middle * MW_PLOT_SCALE));
    type_line(line);
    MUST(app.loop.closed_loop && fabsf(app.loop.target - middle) < 0.01f / MW_PLOT_SCALE);
    snprintf(line, sizeof line, "target_" MW_PLOT_UNIT ":%.2f ", (double)(middle * MW_PLOT_SCALE));
    MUST(was_said(line));
}

/* Golden vectors: "type sequence payload-in-hex" a line in, the frame in hex out. */
static int print_frames(void)
{
    char line[1024], hex[512];
    unsigned type, sequence;
    while (fgets(line, sizeof line, stdin)) {
        mw_message message = {.version = MW_PROTOCOL_VERSION};
        uint8_t frame[MW_FRAME_MAX];
        if (sscanf(line, "%u %u %511s", &type, &sequence, hex) != 3)
            return 2;
        message.type = (uint8_t)type;
        message.sequence = (uint16_t)sequence;
        for (const char *at = hex; at[0] != '-' && at[0] && at[1]; at += 2) {
            const char pair[3] = {at[0], at[1], 0};
            message.payload[message.payload_length++] = (uint8_t)strtoul(pair, NULL, 16);
        }
        const uint8_t bytes = mw_frame_encode(&message, frame);
        for (uint8_t i = 0; i < bytes; i++)
            printf("%02x", frame[i]);
        printf("\n");
    }
    return 0;
}

int main(int count, char **arguments)
{
    if (count > 1 && strcmp(arguments[1], "frames") == 0)
        return print_frames();
    for (int i = 0; i < tests; i++)
        test[i]();
    return failed;
}
