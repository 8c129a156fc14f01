#include "sense_ina.h"

#include <stddef.h>

#include "monitors.h"

static const mw_ina_kind kinds[MW_INA_KINDS] = MW_INA_TABLE;

const mw_ina_kind *mw_ina_kind_of(uint8_t number) { return &kinds[number]; }

static bool get(const mw_ina *chip, uint8_t chip_register, uint8_t bytes, uint32_t *value)
{
    return chip->read(chip->bus, chip->address, chip_register, bytes, value);
}

static bool is_of_kind(const mw_ina *chip, const mw_ina_kind *kind)
{
    uint32_t maker = 0, number = 0;
    if (chip->address < kind->address_lowest || chip->address > kind->address_highest ||
        !get(chip, kind->maker_register, 2u, &maker)) {
        return false;
    }
    /* A chip known by its configuration has kept our settings where only the processor was reset. */
    if (kind->maker_register == kind->configuration_register && maker == kind->settings) {
        return true;
    }
    return maker == kind->maker && get(chip, kind->kind_register, 2u, &number) &&
           (number & kind->kind_mask) == kind->kind;
}

bool mw_ina_start(mw_ina *chip)
{
    const mw_ina_kind *kind = chip->kind;
    for (uint8_t i = 0; kind == NULL && i < MW_INA_KINDS; i++) {
        kind = is_of_kind(chip, &kinds[i]) ? &kinds[i] : NULL;
    }
    uint32_t settings = 0;
    if (kind == NULL || !is_of_kind(chip, kind) ||
        !chip->write(chip->bus, chip->address, kind->configuration_register, kind->settings) ||
        !get(chip, kind->configuration_register, 2u, &settings) || settings != kind->settings) {
        return false;
    }
    chip->kind = kind;
    return kind->flags_setting == 0u ||
           chip->write(chip->bus, chip->address, kind->flags_register, kind->flags_setting);
}

mw_ina_result mw_ina_read(const mw_ina *chip, mw_board_reading *reading)
{
    const mw_ina_kind *kind = chip->kind;
    uint32_t flags = 0, cleared = 0, settings = 0, shunt = 0, bus = 0;
    /* Reading the flags, or a register beside them, clears the ready bit: each pair is taken once. */
    if (kind == NULL || !get(chip, kind->flags_register, 2u, &flags)) {
        return MW_INA_LOST;
    }
    if ((flags & kind->ready_mask) == 0u) {
        return MW_INA_NOT_YET;
    }
    if ((kind->clear_register != 0u && !get(chip, kind->clear_register, 2u, &cleared)) ||
        !get(chip, kind->configuration_register, 2u, &settings) || settings != kind->settings ||
        !get(chip, kind->shunt_register, kind->shunt_bytes, &shunt) ||
        !get(chip, kind->bus_register, kind->bus_bytes, &bus)) {
        return MW_INA_LOST;
    }
    /* Two's complement without relying on how a compiler converts out-of-range numbers. */
    const int32_t range = (int32_t)1 << (8u * kind->shunt_bytes - kind->shunt_shift);
    const int32_t raw = (int32_t)(shunt >> kind->shunt_shift);
    const int32_t steps = raw >= range / 2 ? raw - range : raw;
    reading->ticks = 1u;
    reading->shunt_voltage_v = (float)steps * kind->shunt_step_v;
    reading->wire_voltage_v = (float)(bus >> kind->bus_shift) * kind->bus_step_v - reading->shunt_voltage_v;
    return (flags & kind->overflow_mask) != 0u || steps >= kind->shunt_highest || steps <= kind->shunt_lowest
               ? MW_INA_OVERFLOW
               : MW_INA_READY;
}
