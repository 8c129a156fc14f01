"""Messages of the serial protocol: numbers, fields and layouts.

Written by `python firmware/protocol.py` from data/protocol.toml; a test holds this file to it.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

PROTOCOL_VERSION = 2
MAXIMUM_BODY_BYTES = 96


class MessageKind(IntEnum):
    """Types of frames; those of the board have the highest bit set."""

    HELLO = 0x01
    ARM = 0x02
    DRIVE = 0x03
    TARGET = 0x04
    OFF = 0x05
    STREAM = 0x06
    KEEP = 0x07
    CORRECT = 0x08
    INJECT = 0x7F
    IDENTITY = 0x81
    SAMPLE = 0x82
    EVENT = 0x83
    ACKNOWLEDGEMENT = 0x84
    CORRECTION = 0x85


class AcknowledgementResult(IntEnum):
    """What became of a command."""

    DONE = 0
    REFUSED = 1
    UNKNOWN = 2
    BAD_PAYLOAD = 3


class ResetCause(IntEnum):
    """Why a board has started."""

    POWER_ON = 0
    EXTERNAL = 1
    WATCHDOG = 2
    BROWN_OUT = 3


class FaultInjection(IntEnum):
    """Faults inside the firmware, for tests."""

    STUCK_LOOP = 1
    FROZEN_CONVERTER = 2
    SILENT_CONVERTER = 3
    NAN = 4


class IdentityFields(NamedTuple):
    """What a board is and was built with; after HELLO, and unasked when it has started."""

    protocol_version: int  # version of this protocol
    firmware_major: int  # version of the firmware, before the point
    firmware_minor: int  # version of the firmware, after the point
    reset_cause: int  # why the board started: a number of `reset_cause`
    tick_period_us: int  # time between two readings of the converter [us]
    control_period_us: int  # time between two steps of the board's own controller [us]
    sense_voltage_v: float  # drive that heats by little and still lets resistance be measured [V]
    maximum_voltage_v: float  # highest drive that is applied [V]
    shunt_resistance_ohm: float  # R of Eq. 1 (Lan and Fan 2010) [ohm]
    expiry_ms: int  # so long without a command, and the heater is off [ms]
    model_checksum: int  # of model, controller and rules, as `musclewire export c` writes it into `mw_constants.h`
    event_at_reset: int  # event that ended the last run; 20 after the watchdog, 21 if a run was interrupted
    board: str  # name of the board
    quantity: str  # what the board's model estimates: strain, displacement or force
    wire: str  # name of the wire whose limits and model the firmware keeps


class BoardSample(NamedTuple):
    """Means over the board's ticks since the sample before, and what the board does."""

    tick: int  # the board's clock: it counts conversions, those that were missing too once the next has come [ticks]
    state: int  # the protection's state
    event: int  # why it is in this state; 0 for no reason
    command_sequence: int  # sequence of the last ARM, DRIVE or TARGET that was done
    drive_voltage_v: float  # drive that is out [V]
    wire_voltage_v: float  # at the wire, mean; not a number without any reading [V]
    shunt_voltage_v: float  # at the shunt, mean; not a number without any reading [V]
    resistance_ohm: float  # of the means; 0 without current [ohm]
    estimate: float  # of the means, by the board's model in its own zero; not a number without current
    target: float  # of the last TARGET; not a number before the first


class BoardEvent(NamedTuple):
    """A change of the protection's state; at each of them."""

    tick: int  # when [ticks]
    state: int  # the state that follows
    event: int  # why
    value: float  # resistance of the last reading that was judged [ohm]


class Acknowledgement(NamedTuple):
    """The answer to a command."""

    sequence: int  # sequence of the command
    kind: int  # type of the command
    result: int  # what became of it: a number of `result`


class BoardCorrection(NamedTuple):
    """The correction that is in force; after CORRECT, before its ACK."""

    scale: float  # what readings are scaled by for the estimate
    zero: float  # what is added to every target


# Payloads, little endian.
LAYOUTS: dict[MessageKind, struct.Struct] = {
    MessageKind.HELLO: struct.Struct("<"),
    MessageKind.ARM: struct.Struct("<"),
    MessageKind.DRIVE: struct.Struct("<f"),
    MessageKind.TARGET: struct.Struct("<f"),
    MessageKind.OFF: struct.Struct("<"),
    MessageKind.STREAM: struct.Struct("<H"),
    MessageKind.KEEP: struct.Struct("<"),
    MessageKind.CORRECT: struct.Struct("<ff"),
    MessageKind.INJECT: struct.Struct("<B"),
    MessageKind.IDENTITY: struct.Struct("<BBBBIIfffHIB16s12s24s"),
    MessageKind.SAMPLE: struct.Struct("<IBBHffffff"),
    MessageKind.EVENT: struct.Struct("<IBBf"),
    MessageKind.ACKNOWLEDGEMENT: struct.Struct("<HBB"),
    MessageKind.CORRECTION: struct.Struct("<ff"),
}
