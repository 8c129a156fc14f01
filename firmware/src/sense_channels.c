#include "sense_channels.h"

mw_board_reading mw_sense_channels(const mw_channels *channels, uint32_t node_code, uint32_t shunt_code)
{
    const float full = (float)channels->full_code;
    const float node_voltage_v = (float)node_code / full * channels->node_range_v;
    mw_board_reading reading;
    reading.ticks = 1u;
    reading.shunt_voltage_v = (float)shunt_code / full * channels->shunt_range_v;
    reading.wire_voltage_v =
        node_code >= channels->full_code ? channels->node_range_v : node_voltage_v - reading.shunt_voltage_v;
    return reading;
}

uint8_t mw_ticks_passed(uint8_t *missed, mw_board_tick tick)
{
    if (tick != MW_TICK_READING) {
        *missed = (uint8_t)(*missed + (*missed < UINT8_MAX - 1u ? 1u : 0u));
        return 1u;
    }
    const uint8_t ticks = (uint8_t)(*missed + 1u);
    *missed = 0u;
    return ticks;
}
