/* The hardware layer: the functions that a board must provide. One implementation per board, in firmware/boards.
 *
 * Nothing here may block for longer than it says: a host that does not read its line must not keep a wire hot. */
#ifndef MW_BOARD_H
#define MW_BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* Readings of the analogue front end in one tick: voltages at the wire and at the shunt, as Eq. 1 needs them. */
typedef struct {
    float wire_voltage_v;
    float shunt_voltage_v;
    uint8_t ticks; /* since the last reading: 1, or more if conversions were missing or overwritten before they were
                      fetched */
} mw_board_reading;

typedef enum {
    MW_TICK_READING, /* a conversion came: its ticks have passed */
    MW_TICK_MISSING, /* a conversion is overdue by the independent time base: one tick has passed without it */
    MW_TICK_PENDING  /* the converter reports that it is still converting: no time has passed */
} mw_board_tick;

/* Switches the output off before anything else, then starts clocks, converter, serial line and watchdog. */
void board_start(void);

/* The cause of the last reset: one of MW_RESET_... */
uint8_t board_reset_cause(void);

/* Sets the drive voltage after the output stage, 0 to the board's full scale; takes effect at once. */
void board_set_drive(float drive_voltage_v);

/* Waits until a tick has passed or a byte has come, at most one tick. Returns true if there is a tick to process. */
bool board_wait(mw_board_tick *tick, mw_board_reading *reading);

/* The host's line. Put takes all bytes or, if the host does not read and no room is left, none. */
bool board_get(uint8_t *byte);
bool board_put(const uint8_t *bytes, uint8_t length);

/* Feeds the watchdog, once per loop. If it is not called for 0.2 s the processor is reset and the output is off. */
void board_watchdog_feed(void);

/* Memory that is not cleared by a reset; a check word shows whether its content is valid. */
typedef struct {
    uint32_t magic;
    uint8_t state;
    uint8_t event;
    uint16_t check;
} mw_retained;
extern mw_retained board_retained;

/* Stand-alone: a button that starts and stops, and a knob, 0 to 1. A board without them returns false and 0. */
bool board_button(void);
float board_knob(void);

#endif
