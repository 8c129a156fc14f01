/* The application: bytes and ticks in, output voltage and frames out. It does not access hardware. */
#ifndef MW_APPLICATION_H
#define MW_APPLICATION_H

#include "board.h"
#include "control.h"
#include "framing.h"
#include "messages.h"
#include "plotter.h"
#include "standalone.h"

#define MW_FIRMWARE_MAJOR 1u
#define MW_FIRMWARE_MINOR 2u
/* This many broken frames within this time are a storm. */
#define MW_STORM_FRAMES 16u
#define MW_STORM_S 0.2f
/* A noisy converter that repeats a number for this long is frozen; the protection table's time for a channel. */
#define MW_FROZEN_NODE_S 0.3f

typedef struct {
    float wire_voltage_v, shunt_voltage_v;
    uint16_t count;
} mw_sums;

typedef struct {
    mw_decoder decoder;
    mw_control_loop loop;
    mw_standalone standalone;
    mw_plotter plotter;
    mw_sums sums;
    uint32_t tick;
    float node_v, node_still_s; /* the node's last voltage, and for how long it has not changed */
    uint32_t bad_frames;
    uint32_t storm_ticks[MW_STORM_FRAMES]; /* when each of the last bad frames came */
    uint16_t sequence;                     /* of the next frame to the host */
    uint16_t command_sequence;             /* of the last accepted command */
    uint16_t stream_every, stream_left;
    uint8_t event_at_reset, reset_cause;
    uint8_t reported_state, reported_event; /* the last that were sent to the host and retained */
#ifdef MW_FAULT_INJECTION
    uint8_t injected;
    mw_board_reading kept;
#endif
} mw_application;

void mw_application_start(mw_application *application);
void mw_application_byte(mw_application *application, uint8_t byte);
void mw_application_tick(mw_application *application, mw_board_tick tick, const mw_board_reading *reading);

#endif
