/* The exported C core, run once a tick: always the protection, and the closed loop if a target is set.
 *
 * This file adds only what the core leaves to its user: the age of the last command, and who is in charge. */
#ifndef MW_CONTROL_H
#define MW_CONTROL_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"
#include "musclewire.h"

/* A host that exchanges every 0.05 s is not silent; a longer silence is `command_missing`. */
#define MW_COMMAND_GRACE_S 0.06f
/* A converter that is late by a tick or two is not silent. The table's 0.1 s and 0.25 s still count from the last
 * reading. */
#define MW_READING_GRACE_S 0.02f
/* A wire's resistance changes by less in its life. */
#define MW_SCALE_MOST 0.06f

typedef struct {
    mw_controller core;
    float command_v;           /* of the last DRIVE */
    float target;              /* of the last TARGET; not a number before the first */
    float scale, zero;         /* of the last CORRECT; 1 and 0 before the first */
    bool closed_loop;          /* TARGET rather than DRIVE */
    bool expires;              /* a host is in charge: its silence ends the run */
    uint16_t ticks_to_control; /* until the loop is closed the next time */
    float command_age_s, reading_age_s;
} mw_control_loop;

void mw_loop_start(mw_control_loop *loop); /* state off, 0 V */
/* State armed; a trip is cleared, a host is in charge. The wire's estimated temperature is kept. */
void mw_loop_arm(mw_control_loop *loop);
void mw_loop_off(mw_control_loop *loop);
void mw_loop_trip(mw_control_loop *loop, uint8_t event);
void mw_loop_renew(mw_control_loop *loop); /* a valid command has come */

bool mw_loop_armed(const mw_control_loop *loop);

/* Both take effect at once and are followed until the next command. A value that is not finite or out of range trips. */
bool mw_loop_drive(mw_control_loop *loop, float drive_voltage_v);
bool mw_loop_target(mw_control_loop *loop, float target);

/* From the next control tick on the estimator starts again with resistances so many times the readings, and the zero is
 * added to every target. Returns false, and nothing has changed, out of range. */
bool mw_loop_correct(mw_control_loop *loop, float scale, float zero);

/* One tick, with its reading or without. */
void mw_loop_reading(mw_control_loop *loop, const mw_board_reading *reading);
void mw_loop_missing(mw_control_loop *loop);

/* The only voltage that may be out now. */
float mw_loop_output(const mw_control_loop *loop);
uint8_t mw_loop_state(const mw_control_loop *loop);
uint8_t mw_loop_event(const mw_control_loop *loop);
/* Resistance of the last reading that the protection has judged [ohm], 0 without current. */
float mw_loop_resistance(const mw_control_loop *loop);

#endif
