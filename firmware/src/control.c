#include "control.h"

#include <math.h>

#include "board_constants.h"

/* Nothing has been commanded yet, and a host is in charge. */
static void forget_commands(mw_control_loop *loop)
{
    loop->command_v = 0.0f;
    loop->target = NAN;
    loop->scale = 1.0f;
    loop->zero = 0.0f;
    loop->closed_loop = false;
    loop->expires = true;
    loop->ticks_to_control = MW_CONTROL_TICKS;
    loop->command_age_s = loop->reading_age_s = 0.0f;
}

void mw_loop_start(mw_control_loop *loop)
{
    forget_commands(loop);
    mw_start(&loop->core);
    mw_protect_off(&loop->core.protection);
}

void mw_loop_arm(mw_control_loop *loop)
{
    forget_commands(loop);
    /* A wire that has just been switched off because it was too hot is not cold yet when it is armed again. */
    mw_start_again(&loop->core);
    loop->command_v = (float)MW_SENSE_VOLTAGE_V;
}

void mw_loop_off(mw_control_loop *loop)
{
    mw_protect_stop(&loop->core.protection);
}

void mw_loop_trip(mw_control_loop *loop, uint8_t event)
{
    /* What is off already stays off with its first cause. */
    if (mw_loop_armed(loop)) {
        mw_protect_trip(&loop->core.protection, event);
    }
}

/* The on-board loop starts again from the present drive, without earlier readings. */
static void take_over(mw_control_loop *loop)
{
    loop->core.started = 0;
#if defined(MW_FILTER)
    loop->core.follower.followed = 0; /* what it remembers is from before */
#endif
    loop->core.wire_sum_v = loop->core.shunt_sum_v = 0;
    loop->core.samples = 0;
}

bool mw_loop_armed(const mw_control_loop *loop)
{
    return mw_state_drives(loop->core.protection.state);
}

void mw_loop_renew(mw_control_loop *loop)
{
    loop->command_age_s = 0.0f;
    if (mw_protect_recover(&loop->core.protection, MW_EVENT_COMMAND_MISSING)) {
        take_over(loop);
    }
}

bool mw_loop_drive(mw_control_loop *loop, float drive_voltage_v)
{
    /* The core checks the range: a drive that it refuses trips. */
    mw_loop_renew(loop);
    mw_drive(&loop->core, (mw_real)drive_voltage_v);
    loop->closed_loop = false;
    loop->command_v = drive_voltage_v;
    return mw_loop_armed(loop);
}

bool mw_loop_target(mw_control_loop *loop, float target)
{
    const float highest = (float)MW_TARGET_HIGHEST; /* in the model's zero; from that of today it may be further up */
    if (!(target >= (float)MW_TARGET_LOWEST && (target <= highest || target + loop->zero <= highest))) {
        mw_loop_trip(loop, MW_EVENT_COMMAND_REFUSED);
        return false;
    }
    mw_loop_renew(loop);
    if (!loop->closed_loop) {
        take_over(loop);
        loop->ticks_to_control = MW_CONTROL_TICKS;
    }
    loop->closed_loop = true;
    loop->target = target;
    return true;
}

bool mw_loop_correct(mw_control_loop *loop, float scale, float zero)
{
    /* Written so that what is not a number is refused. */
    if (!(fabsf(scale - 1.0f) <= MW_SCALE_MOST && fabsf(zero) <= (float)(MW_QUANTITY_MAX - MW_QUANTITY_MIN))) {
        return false;
    }
    loop->scale = scale;
    loop->zero = zero;
#if defined(MW_FILTER)
    loop->core.follower.followed = 0; /* what it has followed was another resistance */
#endif
    return true;
}

/* The controller's tick by the corrected model. */
static void control_corrected(mw_control_loop *loop)
{
    const float highest = (float)MW_TARGET_HIGHEST, target = loop->target + loop->zero;
    const mw_real root = mw_root((mw_real)loop->scale);
    /* The resistance is scaled and the power stays: so it is with a model whose resistances are divided by the scale. */
    loop->core.wire_sum_v *= root;
    loop->core.shunt_sum_v /= root;
    mw_control(&loop->core, (mw_real)(target > highest ? highest : target), (mw_real)(MW_CONTROL_TICKS * MW_TICK_S));
}

/* Follows the last command again after a missing reading has interrupted it. */
static void follow(mw_control_loop *loop, uint8_t ticks)
{
    mw_protection *protection = &loop->core.protection;
    if (!loop->closed_loop) {
        mw_protect_command(protection, (mw_real)loop->command_v);
        return;
    }
    const bool follows = mw_protect_follows(protection);
    if (!follows) {
        take_over(loop); /* the drive is not the loop's own, and the sums contain missing readings */
    }
    if (loop->ticks_to_control > ticks) {
        loop->ticks_to_control = (uint16_t)(loop->ticks_to_control - ticks);
        return;
    }
    loop->ticks_to_control = MW_CONTROL_TICKS;
    if (follows) {
        control_corrected(loop);
    }
}

/* Applies the table's rule to the host's silence: hold, then sense, then trip. */
static void age_command(mw_control_loop *loop, float passed_s)
{
    mw_protection *protection = &loop->core.protection;
    const uint8_t event = protection->event;
    loop->command_age_s += passed_s;
    if (!loop->expires || loop->command_age_s <= MW_COMMAND_GRACE_S) {
        return;
    }
    /* A missing reading has its own clock, which no command may reset; both end in the same state. */
    const bool expired = loop->command_age_s * 1000.0f > (float)MW_EXPIRY_MS;
    if (expired || event == MW_EVENT_NONE || event == MW_EVENT_COMMAND_MISSING) {
        mw_protect_event(protection, MW_EVENT_COMMAND_MISSING, (mw_real)loop->command_age_s);
    }
}

void mw_loop_reading(mw_control_loop *loop, const mw_board_reading *reading)
{
    const float passed_s = (float)reading->ticks * MW_TICK_S;
    if (!mw_loop_armed(loop)) {
        mw_protect_cool(&loop->core.protection, (mw_real)passed_s);
        return;
    }
    /* Ticks without a reading were already counted when they passed. */
    const float uncounted_s = passed_s > loop->reading_age_s ? passed_s - loop->reading_age_s : 0.0f;
    loop->reading_age_s = 0.0f;
    mw_sample(&loop->core, (mw_real)reading->wire_voltage_v, (mw_real)reading->shunt_voltage_v, (mw_real)passed_s);
    age_command(loop, uncounted_s);
    if (mw_loop_armed(loop)) {
        follow(loop, reading->ticks);
    }
}

void mw_loop_missing(mw_control_loop *loop)
{
    if (!mw_loop_armed(loop)) {
        return;
    }
    loop->reading_age_s += MW_TICK_S;
    if (loop->reading_age_s > MW_READING_GRACE_S) {
        mw_protect_event(&loop->core.protection, MW_EVENT_SAMPLE_LATE, (mw_real)loop->reading_age_s);
    }
    age_command(loop, MW_TICK_S); /* the host's silence counts whether the converter delivers or not */
}

float mw_loop_output(const mw_control_loop *loop)
{
    return (float)mw_protect_allowed(&loop->core.protection);
}

uint8_t mw_loop_state(const mw_control_loop *loop)
{
    return loop->core.protection.state;
}

uint8_t mw_loop_event(const mw_control_loop *loop)
{
    return loop->core.protection.event;
}

float mw_loop_resistance(const mw_control_loop *loop)
{
    const mw_protection *protection = &loop->core.protection;
    return (float)mw_resistance(protection->wire_voltage_v, protection->shunt_voltage_v);
}
