/* What the frames mean: numbers of messages, results, reset causes. docs/reference/firmware_protocol.md */
#ifndef MW_MESSAGES_H
#define MW_MESSAGES_H

#include <stdint.h>

enum {
    MW_HELLO = 0x01,
    MW_ARM = 0x02,
    MW_DRIVE = 0x03,
    MW_TARGET = 0x04,
    MW_OFF = 0x05,
    MW_STREAM = 0x06,
    MW_KEEP = 0x07,
    MW_INJECT = 0x7f, /* only with -DMW_FAULT_INJECTION */
    MW_IDENTITY = 0x81,
    MW_SAMPLE = 0x82,
    MW_EVENT = 0x83,
    MW_ACK = 0x84
};

enum { MW_DONE = 0, MW_REFUSED = 1, MW_UNKNOWN = 2, MW_BAD_PAYLOAD = 3 };

enum { MW_RESET_POWER_ON = 0, MW_RESET_EXTERNAL = 1, MW_RESET_WATCHDOG = 2, MW_RESET_BROWN_OUT = 3 };

/* What MW_INJECT takes: faults inside the firmware that a test cannot cause from outside. */
enum { MW_INJECT_STUCK_LOOP = 1, MW_INJECT_FROZEN_CONVERTER = 2, MW_INJECT_SILENT_CONVERTER = 3, MW_INJECT_NAN = 4 };

#define MW_IDENTITY_BYTES 59u
#define MW_SAMPLE_BYTES 32u
#define MW_EVENT_BYTES 10u
#define MW_ACK_BYTES 4u

#endif
