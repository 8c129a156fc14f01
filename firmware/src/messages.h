/* What the frames mean: numbers of messages, places of their fields, results, reset causes.
 * Written by `python firmware/protocol.py` from the host's data/protocol.toml; a test holds this file to it.
 * docs/reference/firmware_protocol.md */
#ifndef MW_MESSAGES_H
#define MW_MESSAGES_H

#include <stdint.h>

#define MW_PROTOCOL_VERSION 2u
#define MW_BODY_MAX 96u

enum {
    MW_HELLO = 0x01,
    MW_ARM = 0x02,
    MW_DRIVE = 0x03,
    MW_TARGET = 0x04,
    MW_OFF = 0x05,
    MW_STREAM = 0x06,
    MW_KEEP = 0x07,
    MW_CORRECT = 0x08,
    MW_INJECT = 0x7f, /* only with -DMW_FAULT_INJECTION */
    MW_IDENTITY = 0x81,
    MW_SAMPLE = 0x82,
    MW_EVENT = 0x83,
    MW_ACK = 0x84,
    MW_CORRECTION = 0x85
};

/* What became of a command. */
enum {
    MW_DONE = 0,
    MW_REFUSED = 1,
    MW_UNKNOWN = 2,
    MW_BAD_PAYLOAD = 3
};

/* Why a board has started. */
enum {
    MW_RESET_POWER_ON = 0,
    MW_RESET_EXTERNAL = 1,
    MW_RESET_WATCHDOG = 2,
    MW_RESET_BROWN_OUT = 3
};

/* Faults inside the firmware, for tests. */
enum {
    MW_INJECT_STUCK_LOOP = 1,
    MW_INJECT_FROZEN_CONVERTER = 2,
    MW_INJECT_SILENT_CONVERTER = 3,
    MW_INJECT_NAN = 4
};

/* Lengths of payloads, and the byte at which each field begins. */
#define MW_DRIVE_BYTES 4u
#define MW_AT_DRIVE_DRIVE_VOLTAGE_V 0u /* f32: drive voltage to apply */
#define MW_TARGET_BYTES 4u
#define MW_AT_TARGET_TARGET 0u /* f32: target of the model's quantity */
#define MW_STREAM_BYTES 2u
#define MW_AT_STREAM_EVERY 0u /* u16: ticks from one SAMPLE to the next */
#define MW_CORRECT_BYTES 8u
#define MW_AT_CORRECT_SCALE 0u /* f32: the model's resistance over today's: by so much readings are scaled for the estimate, not for the protection */
#define MW_AT_CORRECT_ZERO 4u /* f32: what the model says where the wire of today is at zero: added to every target */
#define MW_INJECT_BYTES 1u
#define MW_AT_INJECT_WHAT 0u /* u8: a number of `inject`; 0: all is well again */
#define MW_IDENTITY_BYTES 83u
#define MW_AT_IDENTITY_PROTOCOL_VERSION 0u /* u8: version of this protocol */
#define MW_AT_IDENTITY_FIRMWARE_MAJOR 1u /* u8: version of the firmware, before the point */
#define MW_AT_IDENTITY_FIRMWARE_MINOR 2u /* u8: version of the firmware, after the point */
#define MW_AT_IDENTITY_RESET_CAUSE 3u /* u8: why the board started: a number of `reset_cause` */
#define MW_AT_IDENTITY_TICK_PERIOD_US 4u /* u32: time between two readings of the converter */
#define MW_AT_IDENTITY_CONTROL_PERIOD_US 8u /* u32: time between two steps of the board's own controller */
#define MW_AT_IDENTITY_SENSE_VOLTAGE_V 12u /* f32: drive that heats by little and still lets resistance be measured */
#define MW_AT_IDENTITY_MAXIMUM_VOLTAGE_V 16u /* f32: highest drive that is applied */
#define MW_AT_IDENTITY_SHUNT_RESISTANCE_OHM 20u /* f32: R of Eq. 1 (Lan and Fan 2010) */
#define MW_AT_IDENTITY_EXPIRY_MS 24u /* u16: so long without a command, and the heater is off */
#define MW_AT_IDENTITY_MODEL_CHECKSUM 26u /* u32: of model, controller and rules, as `musclewire export c` writes it into `mw_constants.h` */
#define MW_AT_IDENTITY_EVENT_AT_RESET 30u /* u8: event that ended the last run; 20 after the watchdog, 21 if a run was interrupted */
#define MW_AT_IDENTITY_BOARD 31u /* text: name of the board */
#define MW_IDENTITY_BOARD_BYTES 16u
#define MW_AT_IDENTITY_QUANTITY 47u /* text: what the board's model estimates: strain, displacement or force */
#define MW_IDENTITY_QUANTITY_BYTES 12u
#define MW_AT_IDENTITY_WIRE 59u /* text: name of the wire whose limits and model the firmware keeps */
#define MW_IDENTITY_WIRE_BYTES 24u
#define MW_SAMPLE_BYTES 32u
#define MW_AT_SAMPLE_TICK 0u /* u32: the board's clock: it counts conversions, those that were missing too once the next has come */
#define MW_AT_SAMPLE_STATE 4u /* u8: the protection's state */
#define MW_AT_SAMPLE_EVENT 5u /* u8: why it is in this state; 0 for no reason */
#define MW_AT_SAMPLE_COMMAND_SEQUENCE 6u /* u16: sequence of the last ARM, DRIVE or TARGET that was done */
#define MW_AT_SAMPLE_DRIVE_VOLTAGE_V 8u /* f32: drive that is out */
#define MW_AT_SAMPLE_WIRE_VOLTAGE_V 12u /* f32: at the wire, mean; not a number without any reading */
#define MW_AT_SAMPLE_SHUNT_VOLTAGE_V 16u /* f32: at the shunt, mean; not a number without any reading */
#define MW_AT_SAMPLE_RESISTANCE_OHM 20u /* f32: of the means; 0 without current */
#define MW_AT_SAMPLE_ESTIMATE 24u /* f32: of the means, by the board's model in its own zero; not a number without current */
#define MW_AT_SAMPLE_TARGET 28u /* f32: of the last TARGET; not a number before the first */
#define MW_EVENT_BYTES 10u
#define MW_AT_EVENT_TICK 0u /* u32: when */
#define MW_AT_EVENT_STATE 4u /* u8: the state that follows */
#define MW_AT_EVENT_EVENT 5u /* u8: why */
#define MW_AT_EVENT_VALUE 6u /* f32: resistance of the last reading that was judged */
#define MW_ACK_BYTES 4u
#define MW_AT_ACK_SEQUENCE 0u /* u16: sequence of the command */
#define MW_AT_ACK_KIND 2u /* u8: type of the command */
#define MW_AT_ACK_RESULT 3u /* u8: what became of it: a number of `result` */
#define MW_CORRECTION_BYTES 8u
#define MW_AT_CORRECTION_SCALE 0u /* f32: what readings are scaled by for the estimate */
#define MW_AT_CORRECTION_ZERO 4u /* f32: what is added to every target */

#endif
