"""What the doctor judges by: the few volts that it applies, straight lines through the readings, and plain findings.

Nothing above the sense voltage is ever applied. The first levels lie below half of it: there the protection expects no
current yet, so wrong wiring can be examined without a trip. Only if these levels pass is the sense voltage applied.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RigError
from musclewire.rigs import Rig
from musclewire.signals import RawSample


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


Clock = Callable[[], float]
OnProbe = Callable[[RawSample], None]

# Fractions of the sense voltage below the protection's threshold for "driven", which is half of it.
LOW_FRACTIONS = (0.25, 0.45)
# After a step the first readings may be from before it: through a filter, or a frame in transit.
SETTLING_S, SETTLING_SAMPLES = 0.1, 2
MIN_SAMPLES = 20


class VoltageLevel(NamedTuple):
    """Samples of one output voltage, settled ones only; arrays of shape (n_times,).

    ``host_s`` is the host's own clock when each sample arrived.
    """

    commanded_v: float
    time_s: FloatArray
    host_s: FloatArray
    drive_voltage_v: FloatArray
    wire_voltage_v: FloatArray
    shunt_voltage_v: FloatArray


def samples_of(rig: Rig, seconds: float) -> int:
    """Return how many samples a level of this many seconds has: never fewer than statistics need."""
    return max(round(seconds / rig.sample_period_s), MIN_SAMPLES)


class VoltageProbe:
    """Holds voltages on a rig and keeps the samples, also those of a level during which the rig had a fault."""

    def __init__(self, rig: Rig, clock: Clock, on_sample: OnProbe | None) -> None:
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
            self._fill(rows, voltage_v, settling + samples_of(self._rig, seconds))
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


class LinearFit(NamedTuple):
    """A channel over the commanded voltage: volts at no drive, volts per volt, and the standard error of that."""

    offset_v: float
    slope: float
    slope_error: float

    @property
    def moves(self) -> bool:
        """Whether the channel follows the drive, upward or downward, beyond chance."""
        return abs(self.slope) > max(SIGMAS * self.slope_error, MIN_SLOPE)


class Evidence(NamedTuple):
    """The levels and their fits: ``wire``, ``shunt`` and both together (``circuit``) over the drive, in volts."""

    levels: tuple[VoltageLevel, ...]
    wire: LinearFit
    shunt: LinearFit
    circuit: LinearFit
    sense_voltage_v: float
    shunt_resistance_ohm: float

    @property
    def zero(self) -> VoltageLevel:
        """The level at 0 V."""
        return self.levels[0]

    @property
    def carries(self) -> bool:
        """Whether a current flows that grows with the drive, and the wire has a voltage with it."""
        return self.wire.moves and self.shunt.moves

    @property
    def resistance_ohm(self) -> float:
        """Resistance of the wire by the slopes, which no offset affects; 0.0 without current."""
        return self.shunt_resistance_ohm * self.wire.slope / self.shunt.slope if self.carries else 0.0

    @property
    def wire_at_sense_v(self) -> float:
        """Reading of the wire's channel that is expected at the sense voltage, without its offset."""
        return abs(self.wire.slope) * self.sense_voltage_v

    @property
    def shunt_at_sense_v(self) -> float:
        """Reading of the shunt's channel that is expected at the sense voltage, without its offset."""
        return abs(self.shunt.slope) * self.sense_voltage_v

    @property
    def sense_current_a(self) -> float:
        """Current at the sense voltage; negative if the shunt's channel is reversed."""
        return self.shunt.slope * self.sense_voltage_v / self.shunt_resistance_ohm


def evidence_of(levels: Sequence[VoltageLevel], sense_voltage_v: float, shunt_resistance_ohm: float) -> Evidence:
    """Return the lines through levels of which the first is at 0 V. Needs two levels or more, all finite."""
    drive_v = np.concatenate([np.full(len(level.time_s), level.commanded_v) for level in levels])
    wire_v = np.concatenate([level.wire_voltage_v for level in levels])
    shunt_v = np.concatenate([level.shunt_voltage_v for level in levels])
    return Evidence(
        tuple(levels),
        line(drive_v, wire_v),
        line(drive_v, shunt_v),
        line(drive_v, wire_v + shunt_v),
        sense_voltage_v,
        shunt_resistance_ohm,
    )


def line(drive_v: FloatArray, reading_v: FloatArray) -> LinearFit:
    """Return the least-squares line through readings."""
    away = drive_v - drive_v.mean()
    spread = float(away @ away)
    slope = float(away @ reading_v) / spread
    offset = float(reading_v.mean()) - slope * float(drive_v.mean())
    rest = reading_v - offset - slope * drive_v
    return LinearFit(offset, slope, math.sqrt(float(rest @ rest) / (len(rest) - 2) / spread))


def noise_v(readings_v: FloatArray) -> float:
    """Return the rms noise of readings after removing a linear drift."""
    count = np.arange(len(readings_v), dtype=np.float64)
    slope, offset = np.polyfit(count, readings_v, 1)
    return float(np.std(readings_v - offset - slope * count))
