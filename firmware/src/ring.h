/* Bytes between an interrupt and the program, with one writer and one reader. Before this file is included, RING is
 * defined as the number of bytes that fit plus one. */
#ifndef MW_RING_H
#define MW_RING_H

#include <stdbool.h>
#include <stdint.h>

#ifndef RING
#error "ring.h: define RING, the length of a ring in bytes"
#endif

typedef struct {
    volatile uint16_t in, out;
    volatile uint8_t bytes[RING]; /* a byte is stored before its index changes */
} ring;

static inline uint16_t waiting(const ring *of)
{
    return (uint16_t)((uint16_t)(of->in - of->out) % RING);
}

static inline bool is_empty(const ring *of)
{
    return of->in == of->out;
}

static inline void keep(ring *of, uint8_t byte)
{
    if (waiting(of) < RING - 1u) { /* a full ring drops bytes: the frame's checksum then fails */
        of->bytes[of->in] = byte;
        of->in = (uint16_t)((of->in + 1u) % RING);
    }
}

static inline bool take(ring *of, uint8_t *byte)
{
    if (is_empty(of)) {
        return false;
    }
    *byte = of->bytes[of->out];
    of->out = (uint16_t)((of->out + 1u) % RING);
    return true;
}

#endif
