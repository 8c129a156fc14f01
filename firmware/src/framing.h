/* Frames on a serial line: COBS( body ) 0x00, where body = version | type | sequence | payload | crc32.
 *
 * Bytes in, whole bodies out; no allocation. docs/reference/firmware_protocol.md is the specification. */
#ifndef MW_FRAMING_H
#define MW_FRAMING_H

#include <stdbool.h>
#include <stdint.h>

#include "messages.h"

#define MW_HEADER_BYTES 4u
#define MW_CHECK_BYTES 4u
#define MW_PAYLOAD_MAX (MW_BODY_MAX - MW_HEADER_BYTES - MW_CHECK_BYTES)
/* COBS adds one byte to anything shorter than 254 bytes; the zero at the end is one more. */
#define MW_FRAME_MAX (MW_BODY_MAX + 2u)

typedef enum { MW_FRAME_NONE, MW_FRAME_GOOD, MW_FRAME_BAD } mw_frame_result;

typedef struct {
    uint8_t version;
    uint8_t type;
    uint16_t sequence;
    uint8_t payload_length;
    uint8_t payload[MW_PAYLOAD_MAX];
} mw_message;

typedef struct {
    uint8_t bytes[MW_BODY_MAX + 1u];
    uint8_t length;
    bool skipping; /* the frame is too long: bytes are dropped until the next zero */
} mw_decoder;

/* CRC-32 of IEEE 802.3, reflected: the value zlib.crc32 gives. */
uint32_t mw_crc32(const uint8_t *bytes, uint16_t length);

void mw_decoder_start(mw_decoder *decoder);

/* Takes one byte of the line. GOOD fills `message`; BAD is a frame that was dropped: wrong COBS, length, checksum or
 * version. Empty frames are ignored: a zero may be sent at any time to synchronise. */
mw_frame_result mw_decoder_push(mw_decoder *decoder, uint8_t byte, mw_message *message);

/* Writes a whole frame with its zero, at most MW_FRAME_MAX bytes, and returns its length. */
uint8_t mw_frame_encode(const mw_message *message, uint8_t frame[MW_FRAME_MAX]);

/* Little endian, whatever the processor is. */
void mw_put_u16(uint8_t *at, uint16_t value);
void mw_put_u32(uint8_t *at, uint32_t value);
void mw_put_f32(uint8_t *at, float value);
uint16_t mw_get_u16(const uint8_t *at);
uint32_t mw_get_u32(const uint8_t *at);
float mw_get_f32(const uint8_t *at);

#endif
