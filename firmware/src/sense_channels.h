/* Sense front end of two converter channels: the node above the wire through a divider, the shunt through an amplifier.
 *
 *     output stage --- node --- wire --- shunt --- ground        node = wire + shunt
 */
#ifndef MW_SENSE_CHANNELS_H
#define MW_SENSE_CHANNELS_H

#include <stdint.h>

#include "board.h"

typedef struct {
    uint32_t full_code;      /* the converter's largest code, summed over the readings of one tick */
    float node_range_v;      /* node voltage at the largest code: converter range over the divider's ratio */
    float shunt_range_v;     /* shunt voltage at the largest code: converter range over the amplifier's gain */
} mw_channels;

/* A channel at the end of its range is passed on as that value, not as a difference: the protection must see it. */
mw_board_reading mw_sense_channels(const mw_channels *channels, uint32_t node_code, uint32_t shunt_code);

/* Ticks that a reading covers, as board.h defines them: its own, and those before it that were missing. A board that
 * makes its ticks by a timer calls it once a tick; `missed` is its state. */
uint8_t mw_ticks_passed(uint8_t *missed, mw_board_tick tick);

#endif
