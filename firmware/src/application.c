#include "application.h"

#include <math.h>
#include <string.h>

#include "board_constants.h"

#define RETAINED_MAGIC 0x6d757363u

static uint16_t retained_check(void)
{
    return (uint16_t)(RETAINED_MAGIC ^ (uint16_t)(board_retained.state * 257u) ^ (uint16_t)(board_retained.event << 4));
}

static void retain(uint8_t state, uint8_t event)
{
    board_retained.state = state;
    board_retained.event = event;
    board_retained.check = retained_check();
    board_retained.magic = RETAINED_MAGIC;
}

/* The event that describes what the reset interrupted; 0 after a clean end or a real power-on. */
static uint8_t event_at_reset(uint8_t cause)
{
    if (cause == MW_RESET_WATCHDOG) {
        return MW_EVENT_WATCHDOG;
    }
    if (board_retained.magic != RETAINED_MAGIC || board_retained.check != retained_check()) {
        return MW_EVENT_NONE; /* the memory lost its content with the power */
    }
    return mw_state_drives(board_retained.state) ? MW_EVENT_POWER_LOST : board_retained.event;
}

static void send(mw_application *application, mw_message *message)
{
    uint8_t frame[MW_FRAME_MAX];
    message->version = MW_PROTOCOL_VERSION;
    message->sequence = application->sequence++; /* counts dropped frames, too: the host sees the gap */
    (void)board_put(frame, mw_frame_encode(message, frame));
}

static void acknowledge(mw_application *application, const mw_message *command, uint8_t result)
{
    mw_message message;
    message.type = MW_ACK;
    message.payload_length = MW_ACK_BYTES;
    mw_put_u16(message.payload + MW_AT_ACK_SEQUENCE, command->sequence);
    message.payload[MW_AT_ACK_KIND] = command->type;
    message.payload[MW_AT_ACK_RESULT] = result;
    send(application, &message);
}

static void put_text(uint8_t *at, const char *text, uint8_t room)
{
    memset(at, 0, room);
    memcpy(at, text, strlen(text) < room ? strlen(text) : room);
}

static void send_identity(mw_application *application)
{
    mw_message message;
    uint8_t *at = message.payload;
    message.type = MW_IDENTITY;
    message.payload_length = MW_IDENTITY_BYTES;
    at[MW_AT_IDENTITY_PROTOCOL_VERSION] = MW_PROTOCOL_VERSION;
    at[MW_AT_IDENTITY_FIRMWARE_MAJOR] = MW_FIRMWARE_MAJOR;
    at[MW_AT_IDENTITY_FIRMWARE_MINOR] = MW_FIRMWARE_MINOR;
    at[MW_AT_IDENTITY_RESET_CAUSE] = application->reset_cause;
    mw_put_u32(at + MW_AT_IDENTITY_TICK_PERIOD_US, MW_TICK_PERIOD_US);
    mw_put_u32(at + MW_AT_IDENTITY_CONTROL_PERIOD_US, MW_TICK_PERIOD_US * (uint32_t)MW_CONTROL_TICKS);
    mw_put_f32(at + MW_AT_IDENTITY_SENSE_VOLTAGE_V, (float)MW_SENSE_VOLTAGE_V);
    mw_put_f32(at + MW_AT_IDENTITY_MAXIMUM_VOLTAGE_V, (float)MW_MAXIMUM_VOLTAGE_V);
    mw_put_f32(at + MW_AT_IDENTITY_SHUNT_RESISTANCE_OHM, (float)MW_SHUNT_RESISTANCE_OHM);
    mw_put_u16(at + MW_AT_IDENTITY_EXPIRY_MS, MW_EXPIRY_MS);
    mw_put_u32(at + MW_AT_IDENTITY_MODEL_CHECKSUM, MW_MODEL_CHECKSUM);
    at[MW_AT_IDENTITY_EVENT_AT_RESET] = application->event_at_reset;
    put_text(at + MW_AT_IDENTITY_BOARD, MW_BOARD_NAME, MW_IDENTITY_BOARD_BYTES);
    put_text(at + MW_AT_IDENTITY_QUANTITY, MW_QUANTITY, MW_IDENTITY_QUANTITY_BYTES);
    put_text(at + MW_AT_IDENTITY_WIRE, MW_WIRE_NAME, MW_IDENTITY_WIRE_BYTES);
    send(application, &message);
}

/* What the board's model makes of a resistance; of an estimate that remembers, the loop's own while it is closed. */
static float estimate_of(const mw_control_loop *loop, mw_real resistance_ohm)
{
#if defined(MW_FILTER)
    if (loop->closed_loop && loop->core.started)
        return (float)loop->core.estimation.value;
#endif
    return (float)mw_estimate((mw_real)loop->scale * resistance_ohm).value;
}

/* Sends the means over the ticks since the last sample, with resistance and estimate; NaN without a reading. */
static void send_sample(mw_application *application)
{
    const mw_control_loop *loop = &application->loop;
    mw_sums *sums = &application->sums;
    mw_message message;
    uint8_t *at = message.payload;
    const float count = sums->count > 0u ? (float)sums->count : NAN;
    const float wire_voltage_v = sums->wire_voltage_v / count;
    const float shunt_voltage_v = sums->shunt_voltage_v / count;
    const mw_real resistance_ohm = mw_resistance((mw_real)wire_voltage_v, (mw_real)shunt_voltage_v);
    message.type = MW_SAMPLE;
    message.payload_length = MW_SAMPLE_BYTES;
    mw_put_u32(at + MW_AT_SAMPLE_TICK, application->tick);
    at[MW_AT_SAMPLE_STATE] = mw_loop_state(loop);
    at[MW_AT_SAMPLE_EVENT] = mw_loop_event(loop);
    mw_put_u16(at + MW_AT_SAMPLE_COMMAND_SEQUENCE, application->command_sequence);
    mw_put_f32(at + MW_AT_SAMPLE_DRIVE_VOLTAGE_V, mw_loop_output(loop));
    mw_put_f32(at + MW_AT_SAMPLE_WIRE_VOLTAGE_V, wire_voltage_v);
    mw_put_f32(at + MW_AT_SAMPLE_SHUNT_VOLTAGE_V, shunt_voltage_v);
    mw_put_f32(at + MW_AT_SAMPLE_RESISTANCE_OHM, (float)resistance_ohm);
    mw_put_f32(at + MW_AT_SAMPLE_ESTIMATE, resistance_ohm > 0 ? estimate_of(loop, resistance_ohm) : NAN);
    mw_put_f32(at + MW_AT_SAMPLE_TARGET, loop->target);
    send(application, &message);
    memset(sums, 0, sizeof *sums);
}

/* Puts out the drive that is allowed now; a change of the state is sent to the host and kept in retained memory. */
static void settle(mw_application *application)
{
    const uint8_t state = mw_loop_state(&application->loop);
    const uint8_t event = mw_loop_event(&application->loop);
    board_set_drive(mw_loop_output(&application->loop));
    if (state == application->reported_state && event == application->reported_event) {
        return;
    }
    application->reported_state = state;
    application->reported_event = event;
    retain(state, event);
    if (application->plotter.on) {
        mw_plotter_changed(&application->plotter, state, event, mw_loop_resistance(&application->loop));
        return;
    }
    mw_message message;
    message.type = MW_EVENT;
    message.payload_length = MW_EVENT_BYTES;
    mw_put_u32(message.payload + MW_AT_EVENT_TICK, application->tick);
    message.payload[MW_AT_EVENT_STATE] = state;
    message.payload[MW_AT_EVENT_EVENT] = event;
    mw_put_f32(message.payload + MW_AT_EVENT_VALUE, mw_loop_resistance(&application->loop));
    send(application, &message);
}

static void bad_frame(mw_application *application)
{
    const uint32_t now = application->tick;
    uint32_t *oldest = &application->storm_ticks[application->bad_frames % MW_STORM_FRAMES];
    const bool enough = application->bad_frames >= MW_STORM_FRAMES - 1u;
    *oldest = now;
    application->bad_frames++;
    /* After the increment above, this slot holds the first of the last sixteen. */
    const uint32_t first = application->storm_ticks[application->bad_frames % MW_STORM_FRAMES];
    if (enough && (float)(now - first) * MW_TICK_S <= MW_STORM_S) {
        mw_loop_trip(&application->loop, MW_EVENT_LINK_CORRUPTED);
    }
}

static uint8_t armed_command(mw_application *application, const mw_message *command)
{
    mw_control_loop *loop = &application->loop;
    if (command->payload_length != MW_DRIVE_BYTES) {
        return MW_BAD_PAYLOAD;
    }
    if (!mw_loop_armed(loop)) {
        return MW_REFUSED;
    }
    /* One number, a drive or a target, in the same place. */
    const float value = mw_get_f32(command->payload + MW_AT_DRIVE_DRIVE_VOLTAGE_V);
    mw_standalone_stop(&application->standalone);
    const bool taken = command->type == MW_DRIVE ? mw_loop_drive(loop, value) : mw_loop_target(loop, value);
    if (!taken) {
        return MW_BAD_PAYLOAD;
    }
    loop->expires = true;
    application->command_sequence = command->sequence;
    return MW_DONE;
}

/* Takes a correction and tells what it has taken. */
static uint8_t correct(mw_application *application, const mw_message *command)
{
    mw_control_loop *loop = &application->loop;
    mw_message message;
    if (command->payload_length != MW_CORRECT_BYTES ||
        !mw_loop_correct(loop, mw_get_f32(command->payload + MW_AT_CORRECT_SCALE),
                         mw_get_f32(command->payload + MW_AT_CORRECT_ZERO))) {
        return MW_BAD_PAYLOAD;
    }
    message.type = MW_CORRECTION;
    message.payload_length = MW_CORRECTION_BYTES;
    mw_put_f32(message.payload + MW_AT_CORRECTION_SCALE, loop->scale);
    mw_put_f32(message.payload + MW_AT_CORRECTION_ZERO, loop->zero);
    send(application, &message);
    return MW_DONE;
}

#ifdef MW_FAULT_INJECTION
static uint8_t inject(mw_application *application, const mw_message *command)
{
    if (command->payload_length != MW_INJECT_BYTES) {
        return MW_BAD_PAYLOAD;
    }
    application->injected = command->payload[MW_AT_INJECT_WHAT];
    return MW_DONE;
}
#endif

static uint8_t plain_command(mw_application *application, const mw_message *command)
{
    mw_control_loop *loop = &application->loop;
    const uint8_t expected = command->type == MW_STREAM ? MW_STREAM_BYTES : 0u;
    if (command->type == MW_DRIVE || command->type == MW_TARGET) {
        return armed_command(application, command);
    }
    if (command->type == MW_CORRECT) {
        return correct(application, command);
    }
#ifdef MW_FAULT_INJECTION
    if (command->type == MW_INJECT) {
        return inject(application, command);
    }
#endif
    if (command->type < MW_HELLO || command->type > MW_KEEP) {
        return MW_UNKNOWN;
    }
    if (command->payload_length != expected) {
        return MW_BAD_PAYLOAD;
    }
    if (command->type == MW_ARM) {
        mw_standalone_stop(&application->standalone);
        mw_loop_arm(loop);
        application->command_sequence = command->sequence;
    } else if (command->type == MW_OFF) {
        mw_standalone_stop(&application->standalone);
        mw_loop_off(loop);
    } else if (command->type == MW_STREAM) {
        application->stream_every = mw_get_u16(command->payload + MW_AT_STREAM_EVERY);
        application->stream_left = application->stream_every;
        memset(&application->sums, 0, sizeof application->sums);
    } else if (command->type == MW_KEEP) {
        mw_loop_renew(loop);
    }
    return MW_DONE;
}

/* Whether a byte belonged to a line of text, which has then been obeyed. */
static bool is_text(mw_application *application, uint8_t byte)
{
    const bool before = application->plotter.on;
    const bool text = mw_plotter_byte(&application->plotter, &application->loop, byte);
    if (text && !before) {
        mw_decoder_start(&application->decoder);
        mw_standalone_stop(&application->standalone);
        memset(&application->sums, 0, sizeof application->sums);
    }
    if (text || before) {
        settle(application);
    }
    return text;
}

void mw_application_byte(mw_application *application, uint8_t byte)
{
    if (is_text(application, byte)) {
        return;
    }
    mw_message command;
    const mw_frame_result result = mw_decoder_push(&application->decoder, byte, &command);
    if (result == MW_FRAME_NONE) {
        return;
    }
    if (result == MW_FRAME_BAD) {
        bad_frame(application);
        settle(application);
        return;
    }
    const uint8_t done = plain_command(application, &command);
    settle(application); /* set the output before acknowledging it */
    acknowledge(application, &command, done);
    if (command.type == MW_HELLO && done == MW_DONE) {
        send_identity(application);
    }
}

#ifdef MW_FAULT_INJECTION
static bool injected_reading(mw_application *application, mw_board_tick tick, mw_board_reading *reading)
{
    if (application->injected == MW_INJECT_STUCK_LOOP) {
        for (;;) { /* the watchdog ends this */
        }
    }
    if (application->injected == MW_INJECT_FROZEN_CONVERTER) {
        const uint8_t ticks = reading->ticks; /* the values are frozen, time is not */
        *reading = application->kept;
        reading->ticks = ticks;
    } else if (application->injected == MW_INJECT_NAN) {
        reading->wire_voltage_v = NAN;
    } else if (tick == MW_TICK_READING) {
        application->kept = *reading;
    }
    return tick == MW_TICK_READING && application->injected != MW_INJECT_SILENT_CONVERTER;
}
#endif

/* The node is one channel, wire and shunt together: if it freezes, its difference to the shunt still changes, so that
 * the protection, which sees wire and shunt, would not notice. */
static void watch_node(mw_application *application, const mw_board_reading *reading)
{
    const float step_v = MW_NODE_RANGE_V / (float)MW_CONVERTER_FULL_CODE;
    const float node_v = reading->wire_voltage_v + reading->shunt_voltage_v;
    if (!(fabsf(node_v - application->node_v) < 0.25f * step_v) || !mw_loop_armed(&application->loop)) {
        application->node_v = node_v;
        application->node_still_s = 0.0f;
        return;
    }
    application->node_still_s += (float)reading->ticks * MW_TICK_S;
    if (MW_READINGS_NOISY && application->node_still_s >= MW_FROZEN_NODE_S) {
        mw_loop_trip(&application->loop, MW_EVENT_CHANNEL_FROZEN);
    }
}

static void count(mw_application *application, const mw_board_reading *reading)
{
    application->sums.wire_voltage_v += reading->wire_voltage_v;
    application->sums.shunt_voltage_v += reading->shunt_voltage_v;
    application->sums.count++;
}

static void stream(mw_application *application, uint8_t ticks)
{
    if (application->stream_every == 0u) {
        return;
    }
    if (application->stream_left > ticks) {
        application->stream_left = (uint16_t)(application->stream_left - ticks);
        return;
    }
    application->stream_left = application->stream_every;
    send_sample(application);
}

/* Text instead of samples: the means since the last line. */
static void plot(mw_application *application, uint8_t ticks)
{
    const mw_control_loop *loop = &application->loop;
    if (!mw_plotter_tick(&application->plotter, &application->loop, ticks)) {
        return;
    }
    const mw_sums *sums = &application->sums;
    const float count = sums->count > 0u ? (float)sums->count : NAN;
    const mw_real resistance_ohm =
        mw_resistance((mw_real)(sums->wire_voltage_v / count), (mw_real)(sums->shunt_voltage_v / count));
    const bool current = resistance_ohm > 0;
    const mw_plot shown = {
        .target = loop->closed_loop ? loop->target : NAN,
        .estimate = current ? estimate_of(loop, resistance_ohm) : NAN,
        .resistance_ohm = current ? (float)resistance_ohm : NAN,
        .drive_v = mw_loop_output(loop),
    };
    mw_plotter_numbers(&shown);
    memset(&application->sums, 0, sizeof application->sums);
}

void mw_application_tick(mw_application *application, mw_board_tick tick, const mw_board_reading *given)
{
    mw_board_reading reading = *given;
    bool there = tick == MW_TICK_READING;
    reading.ticks = reading.ticks > 0u ? reading.ticks : 1u; /* a reading without time would stop the expiry */
    if (tick == MW_TICK_PENDING) {
        return;
    }
#ifdef MW_FAULT_INJECTION
    there = injected_reading(application, tick, &reading);
#endif
    /* The converter defines the time: a tick that it did not finish is missing, and has not passed. */
    if (tick == MW_TICK_READING) {
        application->tick += reading.ticks;
    }
    if (there && mw_plotter_settles(&application->plotter)) {
        there = false;
    }
    if (there) {
        mw_loop_reading(&application->loop, &reading);
        watch_node(application, &reading);
        count(application, &reading);
    } else {
        mw_loop_missing(&application->loop);
    }
    if (application->plotter.on) {
        plot(application, reading.ticks);
        settle(application);
        return;
    }
    mw_standalone_tick(&application->standalone, &application->loop);
    settle(application);
    if (tick == MW_TICK_READING) {
        stream(application, reading.ticks);
    }
}

void mw_application_start(mw_application *application)
{
    memset(application, 0, sizeof *application);
    application->reset_cause = board_reset_cause();
    application->event_at_reset = event_at_reset(application->reset_cause);
    mw_decoder_start(&application->decoder);
    mw_loop_start(&application->loop);
    mw_standalone_start(&application->standalone, application->reset_cause);
    mw_plotter_start(&application->plotter, application->event_at_reset);
    board_set_drive(0.0f);
    retain(MW_STATE_OFF, application->event_at_reset);
    application->reported_state = MW_STATE_OFF;
    application->reported_event = mw_loop_event(&application->loop);
    /* Without a request: it informs a host in the middle of a run that the board has restarted. */
    if (!application->plotter.on) {
        send_identity(application);
    }
}
