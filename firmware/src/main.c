#include "application.h"
#include "board.h"

/* At most this many bytes are taken before the next tick: a flood on the line must not delay the protection. */
#define BYTES_AT_ONCE 64u

static mw_application application;

int main(void)
{
    board_start();
    mw_application_start(&application);
    for (;;) {
        mw_board_reading reading = {0.0f, 0.0f, 1u};
        mw_board_tick tick;
        uint8_t byte;
        if (board_wait(&tick, &reading)) {
            mw_application_tick(&application, tick, &reading);
            board_watchdog_feed(); /* fed by finished ticks only: a loop that processes no tick is stuck, too */
        }
        for (uint8_t i = 0; i < BYTES_AT_ONCE && board_get(&byte); i++) {
            mw_application_byte(&application, byte);
        }
    }
}
