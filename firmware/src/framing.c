#include "framing.h"

#include <string.h>

uint32_t mw_crc32(const uint8_t *bytes, uint16_t length)
{
    /* Half a byte at a time: 64 bytes of table instead of 1024, which a small AVR can afford. */
    static const uint32_t table[16] = {
        0x00000000u, 0x1db71064u, 0x3b6e20c8u, 0x26d930acu, 0x76dc4190u, 0x6b6b51f4u, 0x4db26158u, 0x5005713cu,
        0xedb88320u, 0xf00f9344u, 0xd6d6a3e8u, 0xcb61b38cu, 0x9b64c2b0u, 0x86d3d2d4u, 0xa00ae278u, 0xbdbdf21cu,
    };
    uint32_t crc = 0xffffffffu;
    for (uint16_t i = 0; i < length; i++) {
        crc = table[(crc ^ bytes[i]) & 15u] ^ (crc >> 4);
        crc = table[(crc ^ (uint32_t)(bytes[i] >> 4)) & 15u] ^ (crc >> 4);
    }
    return ~crc;
}

void mw_put_u16(uint8_t *at, uint16_t value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}

void mw_put_u32(uint8_t *at, uint32_t value)
{
    mw_put_u16(at, (uint16_t)value);
    mw_put_u16(at + 2, (uint16_t)(value >> 16));
}

void mw_put_f32(uint8_t *at, float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    mw_put_u32(at, bits);
}

uint16_t mw_get_u16(const uint8_t *at)
{
    return (uint16_t)(at[0] | (uint16_t)((uint16_t)at[1] << 8));
}

uint32_t mw_get_u32(const uint8_t *at)
{
    return (uint32_t)mw_get_u16(at) | (uint32_t)mw_get_u16(at + 2) << 16;
}

float mw_get_f32(const uint8_t *at)
{
    const uint32_t bits = mw_get_u32(at);
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

void mw_decoder_start(mw_decoder *decoder)
{
    decoder->length = 0;
    decoder->skipping = false;
}

/* Decodes COBS in place. Returns the body's length, 0 if a count points outside the frame. */
static uint8_t unstuffed(uint8_t *bytes, uint8_t length)
{
    uint8_t in = 0, out = 0;
    while (in < length) {
        const uint8_t count = bytes[in++];
        if (count == 0u || (uint16_t)in + count - 1u > length) {
            return 0;
        }
        for (uint8_t i = 1; i < count; i++) {
            bytes[out++] = bytes[in++];
        }
        if (in < length) { /* the zero at the very end comes from the sender's COBS and is not data */
            bytes[out++] = 0u;
        }
    }
    return out;
}

static bool opened(const uint8_t *body, uint8_t length, mw_message *message)
{
    if (length < MW_HEADER_BYTES + MW_CHECK_BYTES || length > MW_BODY_MAX) {
        return false;
    }
    const uint8_t checked = (uint8_t)(length - MW_CHECK_BYTES);
    if (mw_crc32(body, checked) != mw_get_u32(body + checked) || body[0] != MW_PROTOCOL_VERSION) {
        return false;
    }
    message->version = body[0];
    message->type = body[1];
    message->sequence = mw_get_u16(body + 2);
    message->payload_length = (uint8_t)(checked - MW_HEADER_BYTES);
    memcpy(message->payload, body + MW_HEADER_BYTES, message->payload_length);
    return true;
}

mw_frame_result mw_decoder_push(mw_decoder *decoder, uint8_t byte, mw_message *message)
{
    if (byte != 0u) {
        if (decoder->length < sizeof decoder->bytes) {
            decoder->bytes[decoder->length++] = byte;
            return MW_FRAME_NONE;
        }
        /* Noise without any zero counts too, once per frame's length: a storm need not contain zeros. */
        decoder->skipping = true;
        decoder->length = 0;
        return MW_FRAME_BAD;
    }
    const uint8_t length = decoder->length;
    const bool skipped = decoder->skipping;
    mw_decoder_start(decoder);
    if (skipped || length == 0u) {
        return MW_FRAME_NONE; /* a frame that was skipped was counted when it became too long */
    }
    return opened(decoder->bytes, unstuffed(decoder->bytes, length), message) ? MW_FRAME_GOOD : MW_FRAME_BAD;
}

/* COBS: every zero is replaced by the distance to the next one. */
static uint8_t stuffed(const uint8_t *body, uint8_t length, uint8_t *frame)
{
    uint8_t out = 1, mark = 0, count = 1;
    for (uint8_t i = 0; i < length; i++) {
        if (body[i] == 0u) {
            frame[mark] = count;
            mark = out++;
            count = 1;
        } else {
            frame[out++] = body[i];
            count++;
        }
    }
    frame[mark] = count;
    frame[out++] = 0u;
    return out;
}

uint8_t mw_frame_encode(const mw_message *message, uint8_t frame[MW_FRAME_MAX])
{
    uint8_t body[MW_BODY_MAX];
    const uint8_t payload = message->payload_length <= MW_PAYLOAD_MAX ? message->payload_length : MW_PAYLOAD_MAX;
    const uint8_t checked = (uint8_t)(MW_HEADER_BYTES + payload);
    body[0] = message->version;
    body[1] = message->type;
    mw_put_u16(body + 2, message->sequence);
    memcpy(body + MW_HEADER_BYTES, message->payload, payload);
    mw_put_u32(body + checked, mw_crc32(body, checked));
    return stuffed(body, (uint8_t)(checked + MW_CHECK_BYTES), frame);
}
