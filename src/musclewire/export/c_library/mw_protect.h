/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The protection: one table of states, signals, events and times (mw_constants.h), and the functions that follow it.
 * Which state follows which is in the table alone; no program needs to write into the structure.
 *
 * It has no clock and no output: the caller says how long a reading stands for, and asks mw_protect_allowed before
 * every change of the output. Times are counted in whole microseconds, so that they add up to the same in single and in
 * double precision.
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
    mw_real above_ambient_k;     /* temperature of the wire by its power */
    uint32_t missing_us;         /* how long a reading or a command has been missing */
    uint32_t lasting_us[MW_LASTING];
    mw_real settled_ohm;         /* the last resistance that was no jump; 0 for none */
    mw_real wire_voltage_v, shunt_voltage_v; /* of the last reading */
    uint16_t wire_repeats, shunt_repeats; /* how often in a row a channel gave the same number, */
    mw_real repeats_drive_v;              /* and the drive when that began */
} mw_protection;

/* A cold wire that may be driven; nothing has been commanded yet: the sense voltage is out. */
void mw_protect_arm(mw_protection *protection);

/* The same, but the wire is as warm as it was: for one that may just have been switched off for its heat. */
void mw_protect_arm_again(mw_protection *protection);

/* 0 V; only arming again leaves it, as it does the state that an event has tripped. */
void mw_protect_off(mw_protection *protection);

/* The same by a command: the event is MW_EVENT_STOPPED. What has tripped keeps its own cause. */
void mw_protect_stop(mw_protection *protection);

/* A pause at the sense voltage or less, in which no reading was taken: the next command or reading goes on from there. */
void mw_protect_rest(mw_protection *protection);

/* Switch off for an event; the first cause stays. */
void mw_protect_trip(mw_protection *protection, uint8_t event);

/* Do what the table says of an event that was seen outside these functions and has been so for missing_s: trip or
 * degrade. */
void mw_protect_event(mw_protection *protection, uint8_t event, mw_real missing_s);

/* What was missing under this event is back. Returns whether it was missing; anything else stays as it is. */
uint8_t mw_protect_recover(mw_protection *protection, uint8_t event);

/* Whether a command would be followed now. */
uint8_t mw_protect_follows(const mw_protection *protection);

/* Whether any voltage but 0 may be out in a state. */
uint8_t mw_state_drives(uint8_t state);

/* A commanded drive. Not finite or outside 0 to the maximum trips; while a reading is missing it is not followed. */
void mw_protect_command(mw_protection *protection, mw_real drive_voltage_v);

/* The only drive that may be out now [V]. */
mw_real mw_protect_allowed(const mw_protection *protection);

/* Something has been missing for missing_s in total: hold, then the sense voltage, then trip. */
void mw_protect_missing(mw_protection *protection, uint8_t event, mw_real missing_s);

/* One reading that stands for dt_s at drive_voltage_v. */
void mw_protect_reading(mw_protection *protection, mw_real drive_voltage_v, mw_real wire_voltage_v,
                        mw_real shunt_voltage_v, mw_real dt_s);

/* dt_s have passed with 0 V out: the wire has cooled. Does nothing while a drive is out: readings say how warm it is. */
void mw_protect_cool(mw_protection *protection, mw_real dt_s);

/* Seconds as whole microseconds; what is no positive number is 0, and 4000 s is the most. */
uint32_t mw_microseconds(mw_real time_s);

#ifdef __cplusplus
}
#endif

#endif
