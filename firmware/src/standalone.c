#include "standalone.h"

#include "board_constants.h"
#include "messages.h"

#ifdef MW_STANDALONE
/* The staircase in shares of the stroke: up and down again, each step long enough for a wire in still air. */
#define STEP_S 6.0f
static const float staircase[] = {0.25f, 0.5f, 0.75f, 0.5f, 0.25f, 0.0f};
#define STEPS (sizeof staircase / sizeof staircase[0])

static float share_of_stroke(const mw_standalone *standalone)
{
#if MW_BOARD_HAS_KNOB
    (void)standalone;
    return board_knob();
#else
    const uint32_t step = standalone->tick / (uint32_t)(STEP_S / MW_TICK_S);
    return staircase[step % STEPS];
#endif
}
#endif

void mw_standalone_start(mw_standalone *standalone, uint8_t reset_cause)
{
    /* A program that hung, or a supply that broke down, must not start to heat again on its own. */
    standalone->allowed = reset_cause == MW_RESET_POWER_ON || reset_cause == MW_RESET_EXTERNAL;
    standalone->running = false;
    standalone->pressed = true; /* a button that is held down at the start is no press */
    standalone->tick = 0;
}

void mw_standalone_stop(mw_standalone *standalone)
{
    standalone->running = false;
}

void mw_standalone_tick(mw_standalone *standalone, mw_control_loop *loop)
{
#ifdef MW_STANDALONE
    const bool down = board_button();
    const bool press = down && !standalone->pressed;
    standalone->pressed = down;
    if (press && standalone->running) {
        standalone->running = false;
        mw_loop_off(loop);
    } else if (press && standalone->allowed && !(loop->expires && mw_loop_armed(loop))) {
        mw_loop_arm(loop);
        loop->expires = false;
        standalone->running = true;
        standalone->tick = 0;
    }
    if (standalone->running && mw_loop_armed(loop)) {
        const float span = MW_TARGET_HIGHEST - MW_TARGET_LOWEST;
        (void)mw_loop_target(loop, MW_TARGET_LOWEST + span * share_of_stroke(standalone));
        standalone->tick++;
    }
#else
    (void)standalone;
    (void)loop;
#endif
}
