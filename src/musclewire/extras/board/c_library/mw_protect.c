/* Copyright (c) 2026, the musclewire developers. SPDX-License-Identifier: BSD-3-Clause (LICENSE) */
/* The protection's arithmetic. The steps and their order are those of musclewire's controllers/_protection/protect.py. */
#include "mw_protect.h"

#define MAX_MICROSECONDS 4000000000u

static mw_real size_of(mw_real value)
{
    return value < 0 ? -value : value;
}

static uint8_t is_number(mw_real value)
{
    return value >= -MW_LARGEST && value <= MW_LARGEST;
}

static uint32_t later(uint32_t time_us, uint32_t step_us)
{
    return step_us > MAX_MICROSECONDS - time_us ? MAX_MICROSECONDS : time_us + step_us;
}

uint32_t mw_microseconds(mw_real time_s)
{
    if (!(time_s > 0))
        return 0;
    return time_s < 4000 ? (uint32_t)(time_s * MW_R(1e6) + MW_R(0.5)) : MAX_MICROSECONDS;
}

/* Values that a signal may carry: a drive, the event that is its cause, how long something has been missing. */
typedef struct {
    mw_real drive_voltage_v;
    uint32_t missing_us;
    uint8_t event;
} carried;

/* The table's entry for a signal: an effect and the state that follows. */
static uint8_t transition(const mw_protection *protection, uint8_t signal)
{
    MW_TABLE uint8_t transitions[MW_STATES * MW_SIGNALS] = MW_TRANSITIONS;
    /* A number that is not a state, in a memory that has been overwritten, counts as tripped. */
    const uint8_t state = protection->state < MW_STATES ? protection->state : MW_STATE_TRIPPED;
    return transitions[state * MW_SIGNALS + signal];
}

static void clear_for(mw_protection *protection, mw_real drive_voltage_v)
{
    const mw_protection armed = {.state = protection->state,
                                 .drive_voltage_v = drive_voltage_v,
                                 .above_ambient_k = protection->above_ambient_k};
    *protection = armed;
}

static void rest_at(mw_protection *protection, mw_real drive_voltage_v)
{
    if (protection->drive_voltage_v > drive_voltage_v)
        protection->drive_voltage_v = drive_voltage_v;
    protection->settled_ohm = 0;
    protection->wire_repeats = protection->shunt_repeats = 0;
}

/* Follow the table: the only place in which the state changes. Returns the effect. */
static uint8_t follow(mw_protection *protection, uint8_t signal, carried with)
{
    const uint8_t found = transition(protection, signal);
    const uint8_t effect = found / MW_EFFECT_WEIGHT;
    protection->state = found % MW_EFFECT_WEIGHT;
    switch (effect) {
    case MW_EFFECT_ARM:
        clear_for(protection, with.drive_voltage_v);
        break;
    case MW_EFFECT_FOLLOW:
        protection->drive_voltage_v = with.drive_voltage_v;
        break;
    case MW_EFFECT_BRIDGE:
        protection->event = with.event;
        protection->missing_us = with.missing_us;
        break;
    case MW_EFFECT_RESUME:
        protection->event = MW_EVENT_NONE;
        protection->missing_us = 0;
        break;
    case MW_EFFECT_LATCH:
        protection->event = with.event;
        protection->drive_voltage_v = 0;
        break;
    case MW_EFFECT_PAUSE:
        rest_at(protection, with.drive_voltage_v);
        break;
    case MW_EFFECT_SWITCH_OFF:
        protection->event = with.event != MW_EVENT_NONE ? with.event : protection->event;
        protection->drive_voltage_v = 0;
        break;
    default:
        break;
    }
    return effect;
}

static uint8_t signalled(mw_protection *protection, uint8_t signal, mw_real drive_voltage_v, uint8_t event)
{
    const carried with = {drive_voltage_v, 0, event};
    return follow(protection, signal, with);
}

static uint8_t out_in(uint8_t state)
{
    MW_TABLE uint8_t out[MW_STATES] = MW_OUT;
    return state < MW_STATES ? out[state] : MW_OUT_NONE;
}

uint8_t mw_state_drives(uint8_t state)
{
    return out_in(state) != MW_OUT_NONE;
}

void mw_protect_arm(mw_protection *protection)
{
    const mw_protection cold = {.state = MW_STATE_OFF};
    *protection = cold;
    mw_protect_arm_again(protection);
}

void mw_protect_arm_again(mw_protection *protection)
{
    if (!(protection->above_ambient_k > 0))
        protection->above_ambient_k = 0;
    signalled(protection, MW_SIGNAL_ARM, MW_SENSE_VOLTAGE_V, MW_EVENT_NONE);
}

void mw_protect_off(mw_protection *protection)
{
    signalled(protection, MW_SIGNAL_CLOSE, 0, MW_EVENT_NONE);
}

void mw_protect_stop(mw_protection *protection)
{
    signalled(protection, MW_SIGNAL_CLOSE, 0, MW_EVENT_STOPPED);
}

void mw_protect_rest(mw_protection *protection)
{
    signalled(protection, MW_SIGNAL_REST, MW_SENSE_VOLTAGE_V, MW_EVENT_NONE);
}

void mw_protect_trip(mw_protection *protection, uint8_t event)
{
    signalled(protection, MW_SIGNAL_FAULT, 0, event);
}

static void missing_for(mw_protection *protection, uint8_t event, uint32_t missing_us)
{
    const carried with = {0, missing_us, event};
    uint8_t signal = MW_SIGNAL_MISSING;
    if (missing_us >= MW_TRIP_AFTER_US)
        signal = MW_SIGNAL_MISSING_TOO_LONG;
    else if (missing_us >= MW_SENSE_AFTER_US || protection->often_missing_us >= MW_SENSE_AFTER_US)
        signal = MW_SIGNAL_MISSING_LONG;
    follow(protection, signal, with);
}

void mw_protect_missing(mw_protection *protection, uint8_t event, mw_real missing_s)
{
    missing_for(protection, event, mw_microseconds(missing_s));
}

/* Trip or degrade, as the table says, for an event that has been seen for seen_us. */
static void event_for(mw_protection *protection, uint8_t event, uint32_t seen_us)
{
    MW_TABLE uint8_t actions[MW_EVENTS] = MW_ACTIONS;
    if (event >= MW_EVENTS)
        return;
    if (actions[event] == MW_ACTION_TRIP)
        mw_protect_trip(protection, event);
    else if (actions[event] == MW_ACTION_DEGRADE)
        missing_for(protection, event, seen_us);
}

void mw_protect_event(mw_protection *protection, uint8_t event, mw_real missing_s)
{
    event_for(protection, event, mw_microseconds(missing_s));
}

uint8_t mw_protect_recover(mw_protection *protection, uint8_t event)
{
    if (protection->event != event || protection->often_missing_us >= MW_SENSE_AFTER_US)
        return 0;
    return signalled(protection, MW_SIGNAL_PRESENT, 0, MW_EVENT_NONE) == MW_EFFECT_RESUME;
}

void mw_protect_command(mw_protection *protection, mw_real drive_voltage_v)
{
    /* Written so that a NaN is refused. */
    if (drive_voltage_v >= 0 && drive_voltage_v <= MW_MAXIMUM_VOLTAGE_V * MW_MAXIMUM_ROUNDING)
        signalled(protection, MW_SIGNAL_COMMAND, drive_voltage_v, MW_EVENT_NONE);
    else
        event_for(protection, MW_EVENT_COMMAND_REFUSED, 0);
}

uint8_t mw_protect_follows(const mw_protection *protection)
{
    return transition(protection, MW_SIGNAL_COMMAND) / MW_EFFECT_WEIGHT == MW_EFFECT_FOLLOW;
}

mw_real mw_protect_allowed(const mw_protection *protection)
{
    switch (out_in(protection->state)) {
    case MW_OUT_SENSE:
        return MW_SENSE_VOLTAGE_V;
    case MW_OUT_COMMANDED:
        return protection->drive_voltage_v;
    default:
        return 0;
    }
}

/* Whether the drive is so high that voltage and current must be measurable. */
static uint8_t driven(mw_real drive_voltage_v)
{
    return drive_voltage_v >= MW_DRIVEN_SHARE * MW_SENSE_VOLTAGE_V;
}

static uint8_t missing_event(mw_real drive_voltage_v, mw_real wire_voltage_v, mw_real shunt_voltage_v)
{
    if (!(is_number(wire_voltage_v) && is_number(shunt_voltage_v)))
        return MW_EVENT_READING_NOT_FINITE;
    if (!driven(drive_voltage_v))
        return MW_EVENT_NONE;
    if (size_of(wire_voltage_v) + size_of(shunt_voltage_v) < MW_SUPPLY_SHARE * drive_voltage_v)
        return MW_EVENT_SUPPLY_MISSING;
    return size_of(shunt_voltage_v) < MW_OPEN_SHUNT_VOLTAGE_V ? MW_EVENT_WIRE_OPEN : MW_EVENT_NONE;
}

/* m c dT/dt = P - G (T - T_ambient), second order and stable for any dt. The larger of two powers counts: what was read,
 * and what the ordered drive gives the smallest resistance that this wire can have. Either source may be wrong. */
static void heat(mw_protection *protection, mw_real read_power_w, mw_real ordered_voltage_v, mw_real dt_s)
{
    const mw_real ordered_power_w = MW_LARGEST_W_PER_V2 * ordered_voltage_v * ordered_voltage_v;
    const mw_real power_w = read_power_w > ordered_power_w ? read_power_w : ordered_power_w;
    const mw_real rate = MW_HEAT_LOSS_W_PER_K / MW_HEAT_CAPACITY_J_PER_K * dt_s;
    const mw_real rise_k = dt_s * power_w / MW_HEAT_CAPACITY_J_PER_K * (1 + MW_R(0.5) * rate);
    protection->above_ambient_k = (protection->above_ambient_k + rise_k) / (1 + rate + MW_R(0.5) * rate * rate);
}

static uint8_t too_hot(const mw_protection *protection)
{
    return protection->above_ambient_k > MW_MAXIMUM_ABOVE_AMBIENT_K;
}

void mw_protect_cool(mw_protection *protection, mw_real dt_s)
{
    if (!mw_state_drives(protection->state))
        heat(protection, 0, 0, dt_s);
}

/* The highest drive ordered in this reading or within the delay before it. A reading may come late. */
static mw_real highest_within_delay_v(mw_protection *protection, mw_real ordered_voltage_v, uint32_t dt_us)
{
    mw_real highest_v;
    if (ordered_voltage_v > protection->recent_drive_v)
        protection->recent_drive_v = ordered_voltage_v;
    highest_v = protection->recent_drive_v > protection->earlier_drive_v ? protection->recent_drive_v
                                                                         : protection->earlier_drive_v;
    protection->recent_us = later(protection->recent_us, dt_us);
    if (protection->recent_us >= MW_DELAY_US) {
        protection->earlier_drive_v = protection->recent_drive_v;
        protection->recent_drive_v = 0;
        protection->recent_us = 0;
    }
    return highest_v;
}

static uint16_t once_more(uint16_t repeats, uint8_t same)
{
    if (!same)
        return 0;
    return repeats < UINT16_MAX ? (uint16_t)(repeats + 1) : repeats;
}

static void count_repeats(mw_protection *protection, mw_real drive_voltage_v, mw_real wire_voltage_v,
                          mw_real shunt_voltage_v)
{
    protection->wire_repeats = once_more(protection->wire_repeats, wire_voltage_v == protection->wire_voltage_v);
    protection->shunt_repeats =
        once_more(protection->shunt_repeats, shunt_voltage_v == protection->shunt_voltage_v);
    protection->wire_voltage_v = wire_voltage_v;
    protection->shunt_voltage_v = shunt_voltage_v;
    if (protection->wire_repeats == 0 && protection->shunt_repeats == 0)
        protection->repeats_drive_v = drive_voltage_v;
}

/* Whether equal numbers in a row cannot be chance: noise or a changed drive should have changed them. */
static uint8_t is_frozen(const mw_protection *protection, mw_real drive_voltage_v, uint32_t dt_us)
{
    const mw_real moved_v = size_of(drive_voltage_v - protection->repeats_drive_v);
    const uint16_t repeats = protection->wire_repeats > protection->shunt_repeats ? protection->wire_repeats
                                                                                  : protection->shunt_repeats;
    /* repeats * dt >= MW_FROZEN_US, without a product that could overflow */
    if (repeats < MW_FROZEN_READINGS || dt_us == 0 || repeats < (MW_FROZEN_US + dt_us - 1) / dt_us)
        return 0;
    return MW_READINGS_NOISY || moved_v > MW_MOVED_SHARE * MW_MAXIMUM_VOLTAGE_V;
}

static uint8_t in_window(mw_real resistance_ohm)
{
    return resistance_ohm >= MW_RESISTANCE_LOW_OHM && resistance_ohm <= MW_RESISTANCE_HIGH_OHM;
}

/* Whether a channel is reversed, or the two would fit the window if they changed places. */
static uint8_t swapped(mw_real wire_voltage_v, mw_real shunt_voltage_v, mw_real resistance_ohm)
{
    if (resistance_ohm < 0)
        return 1;
    if (resistance_ohm >= MW_RESISTANCE_LOW_OHM || wire_voltage_v == 0)
        return 0;
    return in_window(MW_SERIES_RESISTANCE(shunt_voltage_v, wire_voltage_v));
}

/* Fill in what is wrong with the resistance of a reading. */
static void see_resistance(mw_protection *protection, mw_real wire_voltage_v, mw_real shunt_voltage_v,
                           mw_real resistance_ohm, uint8_t *seen)
{
    const mw_real settled_ohm = protection->settled_ohm;
    const uint8_t inside = in_window(resistance_ohm);
    const uint8_t jumped =
        inside && settled_ohm > 0 && size_of(resistance_ohm - settled_ohm) > MW_JUMP_SHARE * settled_ohm;
    if (inside && !jumped)
        protection->settled_ohm = resistance_ohm;
    seen[MW_LASTING_CHANNELS_SWAPPED] = swapped(wire_voltage_v, shunt_voltage_v, resistance_ohm);
    seen[MW_LASTING_WIRE_SHORT] = resistance_ohm < MW_SHORT_SHARE * MW_RESISTANCE_LOW_OHM;
    seen[MW_LASTING_RESISTANCE_JUMP] = jumped;
    seen[MW_LASTING_RESISTANCE_OUTSIDE_WINDOW] = !inside;
}

/* Fill in which of the events that must last are seen. */
static void see(mw_protection *protection, mw_real drive_voltage_v, mw_real wire_voltage_v,
                mw_real shunt_voltage_v, mw_real highest_voltage_v, uint32_t dt_us, uint8_t *seen)
{
    const mw_real current_a = shunt_voltage_v / MW_SHUNT_RESISTANCE_OHM;
    /* A reading without current has no resistance to judge. */
    if (driven(drive_voltage_v) && size_of(shunt_voltage_v) >= MW_OPEN_SHUNT_VOLTAGE_V) {
        see_resistance(protection, wire_voltage_v, shunt_voltage_v,
                       MW_SERIES_RESISTANCE(wire_voltage_v, shunt_voltage_v), seen);
        seen[MW_LASTING_CHANNEL_FROZEN] = is_frozen(protection, drive_voltage_v, dt_us);
    }
    seen[MW_LASTING_CHANNEL_SATURATED] =
        size_of(wire_voltage_v) >= MW_SATURATED_WIRE_V || size_of(shunt_voltage_v) >= MW_SATURATED_SHUNT_V;
    seen[MW_LASTING_OVER_CURRENT] = size_of(current_a) > MW_MAXIMUM_CURRENT_A;
    seen[MW_LASTING_OVER_POWER] = wire_voltage_v * current_a > MW_MAXIMUM_POWER_W;
    seen[MW_LASTING_OUTPUT_STUCK] =
        wire_voltage_v + shunt_voltage_v > highest_voltage_v + MW_STUCK_SHARE * MW_MAXIMUM_VOLTAGE_V;
    seen[MW_LASTING_OVER_TEMPERATURE] = too_hot(protection);
}

static void judge(mw_protection *protection, const uint8_t *seen, uint32_t dt_us)
{
    MW_TABLE uint8_t events[MW_LASTING] = MW_LASTING_EVENTS;
    MW_TABLE uint32_t must_last_us[MW_LASTING] = MW_LASTING_US;
    uint8_t index;
    for (index = 0; index < MW_LASTING; index++)
        protection->lasting_us[index] = seen[index] ? later(protection->lasting_us[index], dt_us) : 0;
    for (index = 0; index < MW_LASTING; index++) {
        if (seen[index] && protection->lasting_us[index] >= must_last_us[index]) {
            event_for(protection, events[index], protection->lasting_us[index]);
            return;
        }
    }
}

/* Take a reading that is missing: the wire counts as heated by its ordered drive, and nothing else is known. */
static void miss_reading(mw_protection *protection, uint8_t event, mw_real ordered_voltage_v, mw_real dt_s)
{
    const uint32_t dt_us = mw_microseconds(dt_s);
    heat(protection, 0, ordered_voltage_v, dt_s);
    /* A gap that lasts counts until the sense voltage is out; then only further gaps do. */
    if (protection->missing_us < MW_SENSE_AFTER_US) {
        const uint32_t often_us = later(protection->often_missing_us, dt_us);
        protection->often_missing_us = often_us < MW_MAX_OFTEN_MISSING_US ? often_us : MW_MAX_OFTEN_MISSING_US;
    }
    if (too_hot(protection))
        event_for(protection, MW_EVENT_OVER_TEMPERATURE, dt_us);
    event_for(protection, event, later(protection->missing_us, dt_us));
}

/* Take note of a reading that is there: unless too many have been missing, one drives by it again. */
static void have_reading(mw_protection *protection, uint32_t dt_us)
{
    const uint32_t made_up_us = dt_us / MW_MADE_UP_PART;
    protection->often_missing_us =
        protection->often_missing_us > made_up_us ? protection->often_missing_us - made_up_us : 0;
    if (protection->often_missing_us >= MW_SENSE_AFTER_US)
        protection->missing_us = 0;
    else
        signalled(protection, MW_SIGNAL_PRESENT, 0, MW_EVENT_NONE);
}

void mw_protect_reading(mw_protection *protection, mw_real drive_voltage_v, mw_real wire_voltage_v,
                        mw_real shunt_voltage_v, mw_real ordered_voltage_v, mw_real dt_s)
{
    const uint32_t dt_us = mw_microseconds(dt_s);
    uint8_t seen[MW_LASTING] = {0};
    uint8_t missing;
    mw_real highest_v;
    if (!mw_state_drives(protection->state))
        return;
    highest_v = highest_within_delay_v(protection, ordered_voltage_v, dt_us);
    missing = missing_event(drive_voltage_v, wire_voltage_v, shunt_voltage_v);
    if (missing != MW_EVENT_NONE) {
        miss_reading(protection, missing, ordered_voltage_v, dt_s);
        return;
    }
    /* A channel that is reversed heats the wire all the same. */
    heat(protection, size_of(wire_voltage_v * (shunt_voltage_v / MW_SHUNT_RESISTANCE_OHM)), ordered_voltage_v, dt_s);
    count_repeats(protection, drive_voltage_v, wire_voltage_v, shunt_voltage_v);
    see(protection, drive_voltage_v, wire_voltage_v, shunt_voltage_v, highest_v, dt_us, seen);
    have_reading(protection, dt_us);
    judge(protection, seen, dt_us);
}
