"""Faults of a simulated rig, as its rig file lists them: of the wire, the circuit, the channels and the clock.

[[fault]]
kind = "wire_open"
at = "3 s"

A fault has the name of the protection's event that it leads to, if there is one. The wire is simulated as before: a
fault changes only the current that reaches it and the readings of the instruments.
Faults serve to test the protection; they do not model how often anything fails.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, Any, Literal, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

from musclewire.rigs import RigKey
from musclewire.signals import measured_in

# Earlier names of kinds in rig files, before they were those of the protection's events; they can still be read.
OLD_KINDS = {
    "broken wire": "wire_open",
    "short circuit": "wire_short",
    "contact": "bad_contact",
    "slipped clamp": "clamp_slipped",
    "frozen channel": "channel_frozen",
    "saturated channel": "channel_saturated",
    "swapped channels": "channels_swapped",
    "reading not finite": "reading_not_finite",
    "output stuck": "output_stuck",
    "supply lost": "supply_missing",
    "device lost": "device_lost",
    "clock jump": "clock_jump",
}

Seconds = Annotated[float, measured_in("s"), Field(ge=0.0, allow_inf_nan=False)]
Duration = Annotated[float, measured_in("s"), Field(gt=0.0, allow_inf_nan=False)]
Ohms = Annotated[float, measured_in("ohm"), Field(gt=0.0, allow_inf_nan=False)]
Volts = Annotated[float, measured_in("V"), Field(ge=0.0, allow_inf_nan=False)]
Channel = Literal["wire", "shunt"]


class FaultBase(BaseModel):
    """The times of a fault: it begins ``at`` a time of the rig's clock and stays, or ends after ``lasts``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    at: Seconds = 0.0
    lasts: Duration | None = None

    def active(self, time_s: float) -> bool:
        """Whether the fault is present at a time."""
        return time_s >= self.at and (self.lasts is None or time_s < self.at + self.lasts)


class BrokenWire(FaultBase):
    """No current flows, and the whole drive voltage is across the wire's terminals."""

    kind: Literal["wire_open"]


class ShortCircuit(FaultBase):
    """A conductor of this resistance bridges the wire's terminals and takes its current."""

    kind: Literal["wire_short"]
    resistance: Ohms = 0.2


class BadContact(FaultBase):
    """A loose clamp adds this resistance between the wire's terminals."""

    kind: Literal["bad_contact"]
    resistance: Ohms = 5.0


class SlippedClamp(FaultBase):
    """The wire slipped through its clamp: this fraction of its resistance remains between the terminals."""

    kind: Literal["clamp_slipped"]
    fraction: float = Field(default=0.6, gt=0.0, lt=1.0, allow_inf_nan=False)


class FrozenChannel(FaultBase):
    """A channel repeats its last reading to the bit."""

    kind: Literal["channel_frozen"]
    channel: Channel = "wire"


class SaturatedChannel(FaultBase):
    """A channel reads the end of its range."""

    kind: Literal["channel_saturated"]
    channel: Channel = "wire"
    voltage: Volts = 10.0


class SwappedChannels(FaultBase):
    """Each channel reads what the other should."""

    kind: Literal["channels_swapped"]


class NotFinite(FaultBase):
    """A channel gives a value that is not a number."""

    kind: Literal["reading_not_finite"]
    channel: Channel = "wire"


class StuckOutput(FaultBase):
    """The output stays at this voltage whatever is commanded, 0 V included."""

    kind: Literal["output_stuck"]
    voltage: Volts = 3.0


class SupplyLost(FaultBase):
    """The supply is missing: the output is 0 V whatever is commanded."""

    kind: Literal["supply_missing"]


class DeviceLost(FaultBase):
    """The device does not answer any more."""

    kind: Literal["device_lost"]


class ClockJump(FaultBase):
    """The clock jumps by this much once, backwards below zero."""

    kind: Literal["clock_jump"]
    by: Annotated[float, measured_in("s"), Field(allow_inf_nan=False)] = -1.0


def by_present_names(given: Any) -> Any:
    """Return a [[fault]] table with earlier names replaced: those of kinds, and ``share`` for ``fraction``."""
    if not isinstance(given, dict):
        return given
    kind = OLD_KINDS.get(str(given.get("kind")), given.get("kind"))
    return {("fraction" if key == "share" else key): value for key, value in {**given, "kind": kind}.items()}


SimulatedFault = Annotated[
    BrokenWire
    | ShortCircuit
    | BadContact
    | SlippedClamp
    | FrozenChannel
    | SaturatedChannel
    | SwappedChannels
    | NotFinite
    | StuckOutput
    | SupplyLost
    | DeviceLost
    | ClockJump,
    Field(discriminator="kind"),
    BeforeValidator(by_present_names),
]

FAULTS = RigKey(
    list[SimulatedFault],
    Field(default_factory=list, description="Faults of wire, circuit, channels and clock, with their times."),
    written="[[fault]]",
    what="faults",
    device="musclewire.extras.instruments._faulty_device:FaultyDevice",
)


class CircuitState(NamedTuple):
    """Current through the wire and the voltages at the terminals of wire and shunt."""

    wire_current_a: float
    wire_voltage_v: float
    shunt_voltage_v: float


class SimulatedFaults:
    """The faults of one simulated rig: times in, currents and readings out; it keeps the last readings."""

    def __init__(self, faults: Sequence[SimulatedFault]) -> None:
        """Take the faults of a rig file; if two contradict each other, the first one applies."""
        self._faults = tuple(faults)
        self._last_readings_v: tuple[float, float] | None = None

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self._faults)

    def _now(self, time_s: float) -> list[SimulatedFault]:
        return [fault for fault in self._faults if fault.active(time_s)]

    def device_lost(self, time_s: float) -> bool:
        """Whether the device does not answer any more."""
        return any(isinstance(fault, DeviceLost) for fault in self._now(time_s))

    def output_v(self, commanded_v: float, time_s: float) -> float:
        """Return the true voltage of the output [V]."""
        for fault in self._now(time_s):
            if isinstance(fault, StuckOutput):
                return fault.voltage
            if isinstance(fault, SupplyLost):
                return 0.0
        return commanded_v

    def circuit(self, output_v: float, wire_ohm: float, shunt_ohm: float, time_s: float) -> CircuitState:
        """Return current and voltages at an output voltage in the faulty circuit of a wire and a shunt."""
        current_a = output_v / (wire_ohm + shunt_ohm)
        for fault in self._now(time_s):
            if isinstance(fault, BrokenWire):
                return CircuitState(0.0, output_v, 0.0)
            if isinstance(fault, ShortCircuit):
                bridged_ohm = wire_ohm * fault.resistance / (wire_ohm + fault.resistance)
                current_a = output_v / (bridged_ohm + shunt_ohm)
                bridged_v = current_a * bridged_ohm
                return CircuitState(bridged_v / wire_ohm, bridged_v, current_a * shunt_ohm)
            if isinstance(fault, (BadContact, SlippedClamp)):
                between_ohm = (
                    wire_ohm + fault.resistance if isinstance(fault, BadContact) else wire_ohm * fault.fraction
                )
                current_a = output_v / (between_ohm + shunt_ohm)
                return CircuitState(current_a, current_a * between_ohm, current_a * shunt_ohm)
        return CircuitState(current_a, current_a * wire_ohm, current_a * shunt_ohm)

    def readings_v(self, wire_voltage_v: float, shunt_voltage_v: float, time_s: float) -> tuple[float, float]:
        """Return the readings of wire and shunt [V] after the faults of their channels."""
        readings = [wire_voltage_v, shunt_voltage_v]
        for fault in reversed(self._now(time_s)):
            if isinstance(fault, SwappedChannels):
                readings.reverse()
            elif isinstance(fault, (FrozenChannel, SaturatedChannel, NotFinite)):
                place = 0 if fault.channel == "wire" else 1
                readings[place] = self._instead(fault, readings[place], place)
        self._last_readings_v = (readings[0], readings[1])
        return self._last_readings_v

    def _instead(self, fault: FrozenChannel | SaturatedChannel | NotFinite, reading_v: float, place: int) -> float:
        if isinstance(fault, NotFinite):
            return math.nan
        if isinstance(fault, SaturatedChannel):
            return fault.voltage
        return reading_v if self._last_readings_v is None else self._last_readings_v[place]

    def clock_s(self, time_s: float) -> float:
        """Return the time [s] that a clock with jumps shows."""
        return time_s + sum(fault.by for fault in self._now(time_s) if isinstance(fault, ClockJump))
