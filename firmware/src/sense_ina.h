/* Sense front end of a voltage and current monitor on I2C: the chips of monitors.h.
 *
 * The chip measures its shunt between IN+ and IN- and the bus between VBUS and ground; wired with VBUS above the wire and
 * the shunt below it, the wire's voltage is the bus voltage less the shunt's.
 */
#ifndef MW_SENSE_INA_H
#define MW_SENSE_INA_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"

/* One chip's registers, settings and steps: a row of monitors.h. */
typedef struct {
    uint8_t address_lowest, address_highest;
    uint8_t maker_register, kind_register, configuration_register, flags_register, clear_register;
    uint16_t maker, kind, kind_mask, settings, flags_setting, ready_mask, overflow_mask;
    uint8_t shunt_register, shunt_bytes, shunt_shift, bus_register, bus_bytes, bus_shift;
    int32_t shunt_lowest, shunt_highest;
    float shunt_step_v, bus_step_v;
} mw_ina_kind;

/* Both return false if the chip does not acknowledge. Most significant byte first; written are 2 bytes, read 2 or 3. */
typedef struct {
    bool (*write)(void *bus, uint8_t address, uint8_t chip_register, uint16_t value);
    bool (*read)(void *bus, uint8_t address, uint8_t chip_register, uint8_t bytes, uint32_t *value);
    void *bus;
    uint8_t address;         /* 0x40 to 0x4f, by the pins A0 and A1 */
    const mw_ina_kind *kind; /* NULL: whichever answers; mw_ina_start sets it */
} mw_ina;

typedef enum { MW_INA_READY, MW_INA_NOT_YET, MW_INA_LOST, MW_INA_OVERFLOW } mw_ina_result;

/* Checks what answers, then sets continuous conversion of both inputs without averaging, and reads the settings back.
 * Returns false if no such chip answers; a chip that is another one is not written to. */
bool mw_ina_start(mw_ina *chip);

/* Returns the newest pair, each pair once. A chip that lost its settings (its supply dipped) is LOST, and its readings
 * are not used. A shunt voltage at an end of the range is OVERFLOW, with that end in the reading. */
mw_ina_result mw_ina_read(const mw_ina *chip, mw_board_reading *reading);

/* The row of a chip of monitors.h, by its number there. */
const mw_ina_kind *mw_ina_kind_of(uint8_t number);

#endif
