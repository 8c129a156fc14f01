"""What the doctor judges by: the few volts that it applies, straight lines through the readings, and plain findings.

Nothing above the sense voltage is ever applied. The first levels lie below half of it: there the protection expects no
current yet, so wrong wiring can be examined without a trip. Only if these levels pass is the sense voltage applied.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from types import MappingProxyType
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RigError
from musclewire.parameters import Wire, load_wire
from musclewire.rigs import Rig, keeps_real_time
from musclewire.signals import RawSample, RunFacts


class RigCheck(NamedTuple):
    """One check: measured value, whether it is acceptable, and advice: what to do if not, else what it means."""

    name: str
    ok: bool
    value: float | str | None
    unit: str
    advice: str


class SkippedCheck(NamedTuple):
    """A check that could not be made on this rig or after earlier findings, and why."""

    name: str
    reason: str


class Findings(NamedTuple):
    """Checks that were made and checks that could not be."""

    checks: tuple[RigCheck, ...]
    unchecked: tuple[SkippedCheck, ...] = ()

    def __add__(self, other: object) -> Findings:
        """Return both lists, one after the other."""
        if not isinstance(other, Findings):
            return NotImplemented
        return Findings(self.checks + other.checks, self.unchecked + other.unchecked)

    @property
    def failed(self) -> frozenset[str]:
        """Names of the checks that did not hold."""
        return frozenset(check.name for check in self.checks if not check.ok)

    @property
    def worst_first(self) -> tuple[RigCheck, ...]:
        """The checks as people read them: those that failed before those that hold, else in their order."""
        return tuple(sorted(self.checks, key=lambda check: check.ok))

    @property
    def summary(self) -> str:
        """How many checks there are of each kind, as command and live page say it."""
        failed = sum(not check.ok for check in self.checks)
        all_of_them = len(self.checks) + len(self.unchecked)
        return (
            f"{all_of_them} checks: {failed} failed, {len(self.checks) - failed} passed, {len(self.unchecked)} not run"
        )


NO_CURRENT = "no current follows the drive"

# Fractions of the sense voltage below the protection's threshold for "driven", which is half of it.
LOW_FRACTIONS = (0.25, 0.45)
# After a step the first readings may be from before it, and do not count:
SETTLING_S = 0.1  # [s] that a filter takes
SETTLING_SAMPLES = 2  # samples in transit, on a rig whose samples are farther apart
MIN_SAMPLES = 20


class VoltageLevel(NamedTuple):
    """Settled samples of one output voltage, arrays of shape (n_times,); ``host_s`` is when the host got each."""

    commanded_v: float
    time_s: FloatArray
    host_s: FloatArray
    drive_voltage_v: FloatArray
    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray


class VoltageProbe:
    """Holds voltages on a rig and keeps the samples, also those of a level during which the rig had a fault."""

    def __init__(self, rig: Rig, clock: Callable[[], float], on_sample: Callable[[RawSample], None] | None) -> None:
        """Take an open rig; ``clock`` returns the host's seconds."""
        self._rig, self._clock, self._on_sample = rig, clock, on_sample
        self.levels: list[VoltageLevel] = []
        self.trouble: RigError | None = None
        self.highest_v = 0.0

    def hold(self, voltage_v: float, seconds: float) -> VoltageLevel | None:
        """Hold a voltage and return its samples; None after a fault of the rig, which is then in ``trouble``.

        Raises CallerError for a voltage above the sense voltage, which must not be applied here.
        """
        if not 0.0 <= voltage_v <= self._rig.sense_voltage_v * (1.0 + 1e-9):
            raise CallerError(
                f"{voltage_v:g} V is outside 0 to the sense voltage, {self._rig.sense_voltage_v:g} V: the doctor "
                "heats nothing, give less"
            )
        self.highest_v = max(self.highest_v, voltage_v)
        rows: list[tuple[float, ...]] = []
        settling = max(round(SETTLING_S / self._rig.sample_period_s), SETTLING_SAMPLES)
        try:
            # Never fewer than statistics need.
            self._fill(rows, voltage_v, settling + max(round(seconds / self._rig.sample_period_s), MIN_SAMPLES))
        except RigError as error:
            self.trouble = error
        # Of a level cut short at the very beginning the unsettled samples are better than none.
        kept = rows if self.trouble is not None and not self.levels else rows[settling:]
        if kept:
            columns = np.asarray(kept, dtype=np.float64).T
            self.levels.append(VoltageLevel(voltage_v, *columns))
        return None if self.trouble is not None else self.levels[-1]

    def _fill(self, rows: list[tuple[float, ...]], voltage_v: float, samples: int) -> None:
        """Append this number of samples to rows, as they arrive."""
        for _ in range(samples):
            sample = self._rig.exchange(voltage_v)
            arrived_s = self._clock()
            if self._on_sample is not None:
                self._on_sample(sample)
            rows.append((sample.time_s, arrived_s, *sample[1:4]))


# A smaller slope [V/V] counts as none, however significant statistically.
MIN_SLOPE = 1e-5
SIGMAS = 6.0


class Channel(NamedTuple):
    """A channel below the sense voltage, with the straight line through its readings over the commanded voltage."""

    readings_v: FloatArray  # (n_times,)
    zero_v: FloatArray  # those at 0 V among them
    offset_v: float  # at no drive
    slope: float  # volts per volt
    slope_error: float
    at_sense_v: float  # expected at the sense voltage without the offset

    @property
    def moves(self) -> bool:
        """Whether the channel follows the drive, upward or downward, beyond chance."""
        return abs(self.slope) > max(SIGMAS * self.slope_error, MIN_SLOPE)


class Outcome(NamedTuple):
    """What a check has seen: is it acceptable, the value, the numbers of its words; which words, if not those of ok."""

    ok: bool
    value: float | str
    numbers: Mapping[str, float | str] = MappingProxyType({})
    said: str = ""


class Examined:
    """What checks look at, worked out once; fits are of the levels below the sense voltage, two or more, all finite."""

    def __init__(self, rig: Rig, probe: VoltageProbe) -> None:
        """Read what the rig states of its wire; None for what it does not state."""
        self.rig, self.probe, self.levels = rig, probe, probe.levels
        self.metadata, self.limits, self.paced = rig.metadata(), rig.protection_limits, keeps_real_time(rig)
        self.at_sense = False
        facts = RunFacts(self.metadata, "this rig")
        self.length_m = facts.positive_or_none("wire_length_m")
        self.wire, self.why_unknown = known_wire(facts.text_or_none("wire"))
        if self.wire is not None and self.length_m is None:
            self.why_unknown = "the rig does not state the length of its wire"
        if facts.wires > 1.0:
            # In series or in parallel: the protection's window accounts for it, ohm per metre times length does not.
            self.wire, self.why_unknown = None, "several wires share the drive; see the window"
        by, least = facts.text_or_none("arriving_fraction_by"), facts.positive_or_none("arriving_fraction_least")
        self.arriving = None if by is None or least is None else (least, self.limits.arriving_fraction, by)

    @property
    def right_ohm(self) -> float | None:
        """Resistance of the cold wire by its wire file; None if that is not known."""
        if self.wire is None or self.length_m is None:
            return None
        return self.wire.resistance_per_metre_ohm_per_m.value * self.length_m

    @property
    def low(self) -> list[VoltageLevel]:
        """The levels below the sense voltage, the first at 0 V."""
        return self.levels[: 1 + len(LOW_FRACTIONS)]

    @cached_property
    def lost(self) -> int:
        """How many of their samples are no numbers."""
        return sum(
            int(np.sum(~np.isfinite(one.wire_voltage_v) | ~np.isfinite(one.shunt_voltage_v))) for one in self.low
        )

    @property
    def has_zero(self) -> bool:
        """Whether the output at 0 V is known."""
        return bool(self.low) and not self.lost

    @property
    def has_fits(self) -> bool:
        """Whether there are enough numbers for lines through them."""
        return self.has_zero and len(self.low) > 1 and min(len(level.time_s) for level in self.low) > 2

    @cached_property
    def channels(self) -> dict[str, Channel]:
        """The channels "wire" and "shunt", and both together, "circuit"."""
        wire, shunt = ([getattr(one, f"{name}_voltage_v") for one in self.low] for name in ("wire", "shunt"))
        both = [one + other for one, other in zip(wire, shunt, strict=True)]
        return {name: self.channel(one) for name, one in {"wire": wire, "shunt": shunt, "circuit": both}.items()}

    def channel(self, levels_v: list[FloatArray]) -> Channel:
        """Return a channel with the least-squares line through its readings."""
        drive_v = np.concatenate([np.full(len(level.time_s), level.commanded_v) for level in self.low])
        reading_v = np.concatenate(levels_v)
        away = drive_v - drive_v.mean()
        spread = float(away @ away)
        slope = float(away @ reading_v) / spread
        offset = float(reading_v.mean()) - slope * float(drive_v.mean())
        rest = reading_v - offset - slope * drive_v
        error = math.sqrt(float(rest @ rest) / (len(rest) - 2) / spread)
        return Channel(reading_v, levels_v[0], offset, slope, error, abs(slope) * self.rig.sense_voltage_v)

    @property
    def carries(self) -> bool:
        """Whether a current flows that grows with the drive, and the wire has a voltage with it."""
        return self.channels["wire"].moves and self.channels["shunt"].moves

    @property
    def resistance_ohm(self) -> float:
        """Resistance of the wire by the slopes, which no offset affects."""
        return self.rig.shunt_resistance_ohm * self.channels["wire"].slope / self.channels["shunt"].slope

    @cached_property
    def resistance_at_sense_ohm(self) -> FloatArray:
        """Resistance of the wire at the sense voltage, sample by sample."""
        wire, shunt = (
            getattr(self.levels[-1], f"{name}_voltage_v") - self.channels[name].offset_v for name in ("wire", "shunt")
        )
        return np.asarray(self.rig.shunt_resistance_ohm * wire / shunt)

    @property
    def timed(self) -> list[VoltageLevel]:
        """The levels with steps of the sample clock."""
        return [level for level in self.levels if len(level.time_s) > 2]


def known_wire(name: str | None) -> tuple[Wire | None, str]:
    """Return a wire by its name, or None and why not."""
    if name is None:
        return None, "the rig does not state which wire is mounted"
    try:
        return load_wire(name), ""
    except CallerError as error:
        return None, f"the rig's wire is not known: {error}"


def noise_v(readings_v: FloatArray) -> float:
    """Return the rms noise of readings after removing a linear drift."""
    count = np.arange(len(readings_v), dtype=np.float64)
    slope, offset = np.polyfit(count, readings_v, 1)
    return float(np.std(readings_v - offset - slope * count))
