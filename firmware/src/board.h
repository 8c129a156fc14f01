/* The hardware layer: all that the application asks of a board. One implementation per board, in firmware/boards.
 *
 * Nothing here may block for longer than it says: a line that nobody reads must not keep a wire hot. */
#ifndef MW_BOARD_H
#define MW_BOARD_H

#include <stdbool.h>
#include <stdint.h>

/* What the analogue front end saw in one tick. Volts at the wire and at the shunt, as Eq. 1 needs them. */
typedef struct {
    float wire_voltage_v;
    float shunt_voltage_v;
    uint8_t ticks; /* since the last reading: 1, more where conversions were missing, or overwritten before they were
                      fetched */
} mw_board_reading;

typedef enum {
    MW_TICK_READING, /* a conversion came: its ticks have passed */
    MW_TICK_MISSING, /* a conversion is overdue by the independent time base: one tick has passed without it */
    MW_TICK_PENDING  /* the converter says that it still works on it: no time has passed */
} mw_board_tick;

/* Output off before anything else, then clocks, converter, serial line, watchdog. */
void board_start(void);

/* One of MW_RESET_...; what the last reset was. */
uint8_t board_reset_cause(void);

/* Drive voltage behind the output stage, 0 to the board's full scale; takes effect at once. */
void board_set_drive(float drive_voltage_v);

/* Waits until a tick has passed, or a byte has come, at most one tick. True where a tick is to be worked on. */
bool board_wait(mw_board_tick *tick, mw_board_reading *reading);

/* The host's line. Put takes all of the bytes or, where the line is not read and no room is left, none. */
bool board_get(uint8_t *byte);
bool board_put(const uint8_t *bytes, uint8_t length);

/* The loop has gone round once. If this is not called for 0.2 s the processor is reset and the output is off. */
void board_watchdog_feed(void);

/* Memory that is not cleared by a reset; its content is checked by whoever reads it. */
typedef struct {
    uint32_t magic;
    uint8_t state;
    uint8_t event;
    uint16_t check;
} mw_retained;
extern mw_retained board_retained;

/* Stand-alone: a button that starts and stops, and a knob, 0 to 1. A board without them says false and 0. */
bool board_button(void);
float board_knob(void);

#endif
