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
    """What a board is and was built with; after HELLO, and unasked when it has started.

    Attributes:
        protocol_version: version of this protocol.
        firmware_major: version of the firmware, before the point.
        firmware_minor: version of the firmware, after the point.
        reset_cause: why the board started: a number of `reset_cause`.
        tick_period_us: time between two readings of the converter [us].
        control_period_us: time between two steps of the board's own controller [us].
        sense_voltage_v: drive that heats by little and still lets resistance be measured [V].
        maximum_voltage_v: highest drive that is applied [V].
        shunt_resistance_ohm: R of Eq. 1 (Lan and Fan 2010) [ohm].
        expiry_ms: so long without a command, and the heater is off [ms].
        model_checksum: of model, controller and rules, as `musclewire export c` writes it into `mw_constants.h`.
        event_at_reset: event that ended the last run; 20 after the watchdog, 21 if a run was interrupted.
        board: name of the board.
        quantity: what the board's model estimates: strain, displacement or force.
        wire: name of the wire whose limits and model the firmware keeps.
    """

    protocol_version: int
    firmware_major: int
    firmware_minor: int
    reset_cause: int
    tick_period_us: int
    control_period_us: int
    sense_voltage_v: float
    maximum_voltage_v: float
    shunt_resistance_ohm: float
    expiry_ms: int
    model_checksum: int
    event_at_reset: int
    board: str
    quantity: str
    wire: str


class BoardSample(NamedTuple):
    """Means over the board's ticks since the sample before, and what the board does.

    Attributes:
        tick: the board's clock: it counts conversions, those that were missing too once the next has come [ticks].
        state: the protection's state.
        event: why it is in this state; 0 for no reason.
        command_sequence: sequence of the last ARM, DRIVE or TARGET that was done.
        drive_voltage_v: drive that is out [V].
        wire_voltage_v: at the wire, mean; not a number without any reading [V].
        shunt_voltage_v: at the shunt, mean; not a number without any reading [V].
        resistance_ohm: of the means; 0 without current [ohm].
        estimate: of the means, by the board's model in its own zero; not a number without current.
        target: of the last TARGET; not a number before the first.
    """

    tick: int
    state: int
    event: int
    command_sequence: int
    drive_voltage_v: float
    wire_voltage_v: float
    shunt_voltage_v: float
    resistance_ohm: float
    estimate: float
    target: float


class BoardEvent(NamedTuple):
    """A change of the protection's state; at each of them.

    Attributes:
        tick: when [ticks].
        state: the state that follows.
        event: why.
        value: resistance of the last reading that was judged [ohm].
    """

    tick: int
    state: int
    event: int
    value: float


class Acknowledgement(NamedTuple):
    """The answer to a command.

    Attributes:
        sequence: sequence of the command.
        kind: type of the command.
        result: what became of it: a number of `result`.
    """

    sequence: int
    kind: int
    result: int


class BoardCorrection(NamedTuple):
    """The correction that is in force; after CORRECT, before its ACK.

    Attributes:
        scale: what readings are scaled by for the estimate.
        zero: what is added to every target.
    """

    scale: float
    zero: float


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
