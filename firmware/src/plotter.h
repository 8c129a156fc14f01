/* Text for people with nothing but a serial monitor or plotter: a line of labelled numbers 25 times a second, and
 * commands typed as lines.
 *
 * The line `plot` or `help` switches it on, a zero byte off again: every frame of a host begins with one. A person sends
 * no heartbeat, so each command ends by itself and the drive goes to the sense voltage. */
#ifndef MW_PLOTTER_H
#define MW_PLOTTER_H

#include <stdbool.h>
#include <stdint.h>

#include "control.h"

/* How long a command is followed if its line does not say, and at most; then a board that is left alone goes off. */
#define MW_TEXT_COMMAND_S 30.0f
#define MW_TEXT_LONGEST_S 120.0f
#define MW_TEXT_ALONE_S 300.0f
#define MW_TEXT_SWEEP_S 90.0f
#define MW_TEXT_LINE_S 0.04f
#define MW_TEXT_LINE_BYTES 24u

typedef enum { MW_TEXT_REST, MW_TEXT_FOLLOW, MW_TEXT_SWEEP } mw_text_task;

typedef struct {
    bool on;                        /* text, and no frames */
    bool spoiled;                   /* this line is too long, or is no text */
    uint8_t length;                 /* of the line that is being typed */
    char line[MW_TEXT_LINE_BYTES];
    mw_text_task task;
    float left_s;                   /* until the task ends, or at rest until the board goes off */
    float line_left_s;              /* until the next line of numbers */
    const char *said;               /* lines that are still to be sent; in program memory */
    uint8_t event, state;           /* of the last change, and the resistance of its reading */
    float resistance_ohm;
    bool changed;                   /* and is still to be sent */
    bool settling;                  /* just switched on: the next reading was begun at 0 V */
} mw_plotter;

/* The numbers of a line; not a number for what is not known. */
typedef struct {
    float target, estimate, resistance_ohm, drive_v;
} mw_plot;

/* `event_at_reset` is said if lines begin at once. */
void mw_plotter_start(mw_plotter *plotter, uint8_t event_at_reset);

/* A byte from the line. Returns whether it was text; otherwise it belongs to a frame. */
bool mw_plotter_byte(mw_plotter *plotter, mw_control_loop *loop, uint8_t byte);

/* Time passes. Returns whether a line of numbers is due. */
bool mw_plotter_tick(mw_plotter *plotter, mw_control_loop *loop, uint8_t ticks);

/* Whether a reading was begun before the drive was switched on. It would be what the next ones are compared with. */
bool mw_plotter_settles(mw_plotter *plotter);

void mw_plotter_numbers(const mw_plot *plot);

/* The protection has changed its state, by a reading of this resistance (0 without current). */
void mw_plotter_changed(mw_plotter *plotter, uint8_t state, uint8_t event, float resistance_ohm);

#endif
