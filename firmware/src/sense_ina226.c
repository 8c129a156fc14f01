#include "sense_ina226.h"

#define CONFIGURATION 0x00u
#define SHUNT_VOLTAGE 0x01u
#define BUS_VOLTAGE 0x02u
#define MASK_ENABLE 0x06u
#define MAKER 0xfeu
#define CHIP 0xffu

#define MAKER_TI 0x5449u
#define CHIP_INA226 0x2260u
#define CHIP_MASK 0xfff0u /* the lowest four bits are the revision */

/* Bits 14 to 12 read 100; AVG 000 = 1; VBUSCT 010 = 332 us; VSHCT 010 = 332 us; MODE 111 = both, continuously. */
#define SETTINGS 0x4097u
#define CONVERSION_READY 0x0008u

#define SHUNT_STEP_V 2.5e-6f
#define BUS_STEP_V 1.25e-3f

static bool get(const mw_ina226 *chip, uint8_t chip_register, uint16_t *value)
{
    return chip->read(chip->bus, chip->address, chip_register, value);
}

bool mw_ina226_start(const mw_ina226 *chip)
{
    uint16_t maker = 0, kind = 0, settings = 0;
    if (!get(chip, MAKER, &maker) || maker != MAKER_TI) {
        return false;
    }
    if (!get(chip, CHIP, &kind) || (kind & CHIP_MASK) != CHIP_INA226) {
        return false;
    }
    return chip->write(chip->bus, chip->address, CONFIGURATION, SETTINGS) && get(chip, CONFIGURATION, &settings) &&
           settings == SETTINGS;
}

mw_ina226_result mw_ina226_read(const mw_ina226 *chip, mw_board_reading *reading)
{
    uint16_t flags = 0, settings = 0, shunt = 0, bus = 0;
    /* Reading the flags clears the ready bit: each pair is taken once. */
    if (!get(chip, MASK_ENABLE, &flags)) {
        return MW_INA226_LOST;
    }
    if ((flags & CONVERSION_READY) == 0u) {
        return MW_INA226_NOT_YET;
    }
    if (!get(chip, CONFIGURATION, &settings) || settings != SETTINGS || !get(chip, SHUNT_VOLTAGE, &shunt) ||
        !get(chip, BUS_VOLTAGE, &bus)) {
        return MW_INA226_LOST;
    }
    /* Two's complement without relying on how a compiler converts out-of-range numbers. */
    const int32_t shunt_steps = shunt >= 0x8000u ? (int32_t)shunt - 0x10000 : (int32_t)shunt;
    reading->ticks = 1u;
    reading->shunt_voltage_v = (float)shunt_steps * SHUNT_STEP_V;
    reading->wire_voltage_v = (float)bus * BUS_STEP_V - reading->shunt_voltage_v;
    return shunt == 0x7fffu || shunt == 0x8000u ? MW_INA226_OVERFLOW : MW_INA226_READY;
}
