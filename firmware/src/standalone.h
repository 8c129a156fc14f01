/* Without a host: a target from the board's knob, or the built-in staircase, started by its button.
 *
 * Only with -DMW_STANDALONE. After a watchdog or brown-out reset nothing starts by itself. */
#ifndef MW_STANDALONE_H
#define MW_STANDALONE_H

#include <stdbool.h>
#include <stdint.h>

#include "control.h"

typedef struct {
    bool allowed;  /* the last reset was a power-on or the reset button */
    bool running;
    bool pressed;  /* the button, without its bouncing */
    uint8_t other; /* ticks for which it has been in the other position */
    uint32_t tick; /* since the run began */
} mw_standalone;

void mw_standalone_start(mw_standalone *standalone, uint8_t reset_cause);

/* Once a tick. Does nothing while a host is in charge. */
void mw_standalone_tick(mw_standalone *standalone, mw_control_loop *loop);

/* A host has taken over. */
void mw_standalone_stop(mw_standalone *standalone);

#endif
