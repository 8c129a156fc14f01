/* Current monitors on I2C: registers, settings, steps, by TI's data sheets SBOS547, SLYS021, SBOS656, SBOS448.
 * Written by `python firmware/protocol.py` from the host's data/monitors.toml; a test holds it to that. */
#ifndef MW_MONITORS_H
#define MW_MONITORS_H

enum { MW_INA226, MW_INA228, MW_INA260, MW_INA219, MW_INA_KINDS };

#define MW_INA_TABLE { \
    [MW_INA226] = { \
        .address_lowest = 64, .address_highest = 79, .maker_register = 254, \
        .kind_register = 255, .configuration_register = 0, .flags_register = 6, \
        .clear_register = 0, .maker = 21577, .kind = 8800, \
        .kind_mask = 65520, .settings = 16535, .flags_setting = 0, \
        .ready_mask = 8, .overflow_mask = 4, .shunt_register = 1, \
        .shunt_bytes = 2, .shunt_shift = 0, .bus_register = 2, \
        .bus_bytes = 2, .bus_shift = 0, .shunt_lowest = -32768, \
        .shunt_highest = 32767, .shunt_step_v = 2.5e-06f, .bus_step_v = 0.00125f \
    }, \
    [MW_INA228] = { \
        .address_lowest = 64, .address_highest = 79, .maker_register = 62, \
        .kind_register = 63, .configuration_register = 1, .flags_register = 11, \
        .clear_register = 0, .maker = 21577, .kind = 8832, \
        .kind_mask = 65520, .settings = 46824, .flags_setting = 32768, \
        .ready_mask = 2, .overflow_mask = 512, .shunt_register = 4, \
        .shunt_bytes = 3, .shunt_shift = 4, .bus_register = 5, \
        .bus_bytes = 3, .bus_shift = 4, .shunt_lowest = -524288, \
        .shunt_highest = 524287, .shunt_step_v = 3.125e-07f, .bus_step_v = 0.0001953125f \
    }, \
    [MW_INA260] = { \
        .address_lowest = 64, .address_highest = 79, .maker_register = 254, \
        .kind_register = 255, .configuration_register = 0, .flags_register = 6, \
        .clear_register = 0, .maker = 21577, .kind = 8816, \
        .kind_mask = 65520, .settings = 24727, .flags_setting = 0, \
        .ready_mask = 8, .overflow_mask = 4, .shunt_register = 1, \
        .shunt_bytes = 2, .shunt_shift = 0, .bus_register = 2, \
        .bus_bytes = 2, .bus_shift = 0, .shunt_lowest = -32768, \
        .shunt_highest = 32767, .shunt_step_v = 2.5e-06f, .bus_step_v = 0.00125f \
    }, \
    [MW_INA219] = { \
        .address_lowest = 64, .address_highest = 79, .maker_register = 0, \
        .kind_register = 0, .configuration_register = 0, .flags_register = 2, \
        .clear_register = 3, .maker = 14751, .kind = 14751, \
        .kind_mask = 65535, .settings = 6559, .flags_setting = 0, \
        .ready_mask = 2, .overflow_mask = 1, .shunt_register = 1, \
        .shunt_bytes = 2, .shunt_shift = 0, .bus_register = 2, \
        .bus_bytes = 2, .bus_shift = 3, .shunt_lowest = -32000, \
        .shunt_highest = 32000, .shunt_step_v = 1e-05f, .bus_step_v = 0.004f \
    }, \
}

#endif
