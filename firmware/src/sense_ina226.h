/* Sense front end of a voltage and current monitor on I2C: INA226 and its kin.
 *
 * Registers and steps as in TI's data sheet SBOS547 (INA226, 16 bit, 2.5 uV at the shunt, 1.25 mV at the bus). The chip
 * measures its shunt between IN+ and IN- and the bus between VBUS and ground; wired with VBUS above the wire and the
 * shunt below it, the wire's voltage is the bus voltage less the shunt's.
 */
#ifndef MW_SENSE_INA226_H
#define MW_SENSE_INA226_H

#include <stdbool.h>
#include <stdint.h>

#include "board.h"

/* Both return false if the chip does not acknowledge. Registers are 16 bit, most significant byte first. */
typedef struct {
    bool (*write)(void *bus, uint8_t address, uint8_t chip_register, uint16_t value);
    bool (*read)(void *bus, uint8_t address, uint8_t chip_register, uint16_t *value);
    void *bus;
    uint8_t address; /* 0x40 to 0x4f, by the pins A0 and A1 */
} mw_ina226;

typedef enum { MW_INA226_READY, MW_INA226_NOT_YET, MW_INA226_LOST, MW_INA226_OVERFLOW } mw_ina226_result;

/* Checks manufacturer and chip, then sets continuous conversion of both, 332 us each, without averaging: 1.5 kHz.
 * Returns false if no such chip answers. */
bool mw_ina226_start(const mw_ina226 *chip);

/* Returns the newest pair, each pair once. A chip that lost its settings (its supply dipped) is LOST, and its readings
 * are not used. A shunt voltage beyond 81.9 mV is OVERFLOW, with the end of the range in the reading. */
mw_ina226_result mw_ina226_read(const mw_ina226 *chip, mw_board_reading *reading);

#endif
