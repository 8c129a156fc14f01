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
