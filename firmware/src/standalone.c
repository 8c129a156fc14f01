#include "standalone.h"

#include "board_constants.h"
#include "messages.h"

#ifdef MW_STANDALONE
#if !MW_BOARD_HAS_KNOB || defined(MW_STAIRCASE_ALONE)
/* The paper's staircase in the model's quantity: up and down again, and from the beginning. */
static const float staircase[] = MW_STAIRCASE;
#define STEPS (sizeof staircase / sizeof staircase[0])
#endif
/* Contacts bounce for some milliseconds. */
#define BOUNCING_S 0.03f

static float target_now(const mw_standalone *standalone)
{
#if !MW_BOARD_HAS_KNOB || defined(MW_STAIRCASE_ALONE)
    return staircase[standalone->tick / MW_STAIRCASE_TICKS % STEPS];
#else
    const float stroke = (float)(MW_QUANTITY_MAX - MW_QUANTITY_MIN);
    (void)standalone;
    return (float)MW_QUANTITY_MIN + stroke * board_knob();
#endif
}

/* Whether the button has just been pressed. */
static bool pressed(mw_standalone *standalone)
{
    const bool down = board_button();
    if (down == standalone->pressed) {
        standalone->other = 0;
        return false;
    }
    standalone->other++;
    if ((float)standalone->other * MW_TICK_S < BOUNCING_S) {
        return false;
    }
    standalone->pressed = down;
    standalone->other = 0;
    return down;
}
#endif

void mw_standalone_start(mw_standalone *standalone, uint8_t reset_cause)
{
    /* After a program that hung, or a supply that broke down, heating must not start again by itself. */
    standalone->allowed = reset_cause == MW_RESET_POWER_ON || reset_cause == MW_RESET_EXTERNAL;
    standalone->running = false;
    standalone->pressed = true; /* a button that is held down at the start does not count as pressed */
    standalone->other = 0;
    standalone->tick = 0;
}

void mw_standalone_stop(mw_standalone *standalone)
{
    standalone->running = false;
}

void mw_standalone_tick(mw_standalone *standalone, mw_control_loop *loop)
{
#ifdef MW_STANDALONE
    const bool press = pressed(standalone);
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
        const float target = target_now(standalone);
        /* At the knob's far end, rounding must not exceed the range: that would trip. */
        (void)mw_loop_target(loop, target < (float)MW_TARGET_HIGHEST ? target : (float)MW_TARGET_HIGHEST);
        standalone->tick++;
    }
#else
    (void)standalone;
    (void)loop;
#endif
}
