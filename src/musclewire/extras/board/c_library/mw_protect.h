/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The protection: one table of states, signals, events and times (mw_constants.h), and the functions that follow it.
 * Which state follows which is in the table alone; no program needs to write into the structure.
 *
 * It has no clock and no output: the caller passes the time that each reading covers, and calls mw_protect_allowed before
 * every change of the output. Times are counted in whole microseconds, so that sums are the same in single and in double
 * precision.
 */
#ifndef MW_PROTECT_H
#define MW_PROTECT_H

#include "mw_real.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct {
    uint8_t state;               /* MW_STATE_... */
    uint8_t event;               /* MW_EVENT_...: why it is not running */
    mw_real drive_voltage_v;     /* the last drive that was commanded and allowed */
    mw_real above_ambient_k;     /* temperature of the wire above the air's, estimated from its power */
    uint32_t missing_us;         /* how long a reading or a command has been missing */
    uint32_t often_missing_us;   /* how long readings have been, with interruptions, less what sound ones made up for */
    uint32_t lasting_us[MW_LASTING];
    mw_real earlier_drive_v, recent_drive_v; /* highest drives ordered in the last stretch of the delay and in this one, */
    uint32_t recent_us;                      /* and how long this one has lasted */
    mw_real settled_ohm;         /* the last resistance that was no jump; 0 for none */
    mw_real wire_voltage_v, shunt_voltage_v; /* of the last reading */
    uint16_t wire_repeats, shunt_repeats; /* how often in a row a channel gave the same number, */
    mw_real repeats_drive_v;              /* and the drive when that began */
} mw_protection;

/* Arm for a cold wire: nothing has been commanded yet, and the sense voltage is out. */
void mw_protect_arm(mw_protection *protection);

/* The same, but the wire's estimated temperature is kept: it may just have been switched off because it was too hot. */
void mw_protect_arm_again(mw_protection *protection);

/* Switch to 0 V; only arming leaves this state, as it leaves the tripped state. */
void mw_protect_off(mw_protection *protection);

/* The same by a command: the event is MW_EVENT_STOPPED. If it has tripped, the cause of that is kept. */
void mw_protect_stop(mw_protection *protection);

/* Note a pause at the sense voltage or less, in which no reading was taken; the next command or reading ends it. */
void mw_protect_rest(mw_protection *protection);

/* Switch off for an event; the first cause stays. */
void mw_protect_trip(mw_protection *protection, uint8_t event);

/* Trip or degrade, as the table says, for an event that was detected outside these functions and has lasted for
 * missing_s. */
void mw_protect_event(mw_protection *protection, uint8_t event, mw_real missing_s);

/* Report that the reading or command that was missing under this event is back. Returns whether it was missing;
 * otherwise nothing changes. */
uint8_t mw_protect_recover(mw_protection *protection, uint8_t event);

/* Whether a command would be followed now. */
uint8_t mw_protect_follows(const mw_protection *protection);

/* Whether a voltage other than 0 may be out in a state. */
uint8_t mw_state_drives(uint8_t state);

/* Command a drive. One that is not finite or outside 0 to the maximum trips; while a reading is missing it is not
 * followed. */
void mw_protect_command(mw_protection *protection, mw_real drive_voltage_v);

/* Return the only drive that may be out now [V]. */
mw_real mw_protect_allowed(const mw_protection *protection);

/* Report that something has been missing for missing_s in total: hold, then the sense voltage, then trip. */
void mw_protect_missing(mw_protection *protection, uint8_t event, mw_real missing_s);

/* Judge one reading, which covers dt_s at drive_voltage_v; ordered_voltage_v is the highest drive ordered in this time,
 * which heats. */
void mw_protect_reading(mw_protection *protection, mw_real drive_voltage_v, mw_real wire_voltage_v,
                        mw_real shunt_voltage_v, mw_real ordered_voltage_v, mw_real dt_s);

/* Let the estimated temperature fall over dt_s at 0 V. Does nothing while a drive is out: then readings determine it. */
void mw_protect_cool(mw_protection *protection, mw_real dt_s);

/* Return seconds as whole microseconds: 0 for anything that is not a positive number, and at most 4000 s. */
uint32_t mw_microseconds(mw_real time_s);

#ifdef __cplusplus
}
#endif

#endif
