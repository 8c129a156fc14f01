"""Which rows of a recording are measurements, and what these show: resistance by Eq. 1, what a board would have read.

And why samples of an estimate are not counted.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError, argument
from musclewire.files import turned_columns
from musclewire.judge._unusable_readings import judge_readings
from musclewire.physics import ArrayReading, wire_resistance, wire_resistance_from_current
from musclewire.signals import Reason, Recording, asked_once

Mask = NDArray[np.bool_]
# The columns from which resistance follows, the rawest first.
SHUNT, CURRENT, RESISTANCE = SOURCES = (
    ("wire_voltage_v", "shunt_voltage_v"),
    ("wire_voltage_v", "wire_current_a"),
    ("wire_resistance_ohm",),
)
# What a current that was not measured by a shunt is taken to flow through, so that its volts are its amperes.
VIRTUAL_SHUNT_OHM = 1.0
# What samples are called that have no valid estimate for a reason.
NOT_COUNTED = {
    Reason.OK: "not valid",
    Reason.NO_CURRENT: "without current",
    Reason.MISMATCH: "at resistances that this wire never has",
    Reason.OUT_OF_RANGE: "at resistances outside the model's range",
    Reason.COLD: "colder than B",
    Reason.NOT_READY: "before the estimator was ready",
    Reason.UNEXPLAINED: "that the wire file does not explain",
    Reason.UNCERTAIN: "with several explanations",
}
UNUSABLE = "that are no measurements"
UNNOTICED = "colder than the model begins, which the estimator did not notice"


class CircuitReadings(NamedTuple):
    """What a board would have read in a recording: voltages [V], each (n_times,), and the shunt's resistance [ohm]."""

    drive_v: FloatArray
    wire_v: FloatArray
    shunt_v: FloatArray
    shunt_ohm: float


class JudgedRecording:
    """A recording's electrical columns, and what follows from them; RecordingError for what does not follow."""

    def __init__(self, recording: Recording) -> None:
        """Work nothing out yet."""
        self._columns, self._facts, self._n_times = recording.columns, recording.facts, len(recording)

    @cached_property
    def source(self) -> tuple[str, ...]:
        """The columns from which resistance follows; those with a shunt only if its resistance is known."""
        shunt_ohm = self._facts.stated.get("shunt_resistance_ohm")
        known = isinstance(shunt_ohm, int | float) and not isinstance(shunt_ohm, bool) and 0.0 < shunt_ohm < np.inf
        there = [one for one in SOURCES if self._columns.keys() >= set(one)]
        if found := [one for one in there if known or one is not SHUNT]:
            return found[0]
        if SHUNT in there:
            problem = "is missing" if shunt_ohm is None else f"is {shunt_ohm!r}"
            raise RecordingError(
                f"metadata shunt_resistance_ohm {problem}: shunt_voltage_v needs it, give a positive number: "
                + argument("metadata", {"shunt_resistance_ohm": None})
            )
        missing = ", ".join(name for name in dict.fromkeys(chain(*SOURCES)) if name not in self._columns)
        needs = ", or ".join(map(" and ".join, SOURCES))
        raise RecordingError(f"no resistance can be computed from this recording, it lacks {missing}: give {needs}")

    @cached_property
    def measured(self) -> tuple[Mask, tuple[str, ...]]:
        """The rows in which the columns that are used are measurements, (n_times,), and what is said of the others."""
        judged = judge_readings(self._columns, self._facts.stated, self.source)
        if judged.contradiction:
            raise RecordingError(f"{judged.contradiction}")
        return judged.usable, judged.findings

    @cached_property
    def reading(self) -> ArrayReading:
        """Resistance [ohm] and validity of every sample, (n_times,) each: invalid without current or a measurement."""
        first, last = (self._columns[self.source[place]] for place in (0, -1))
        usable, findings = self.measured
        if self.source is SHUNT:
            reading = wire_resistance(first, last, self._facts.shunt_resistance_ohm)
        elif self.source is CURRENT:
            reading = wire_resistance_from_current(first, last)
        else:
            reading = ArrayReading(first, first > 0.0)
        if not usable.all():
            valid = reading.valid & usable
            reading = ArrayReading(np.where(valid, reading.resistance_ohm, 0.0), valid)
        if reading.valid.any():
            for values in reading:  # whoever asks has the same arrays
                values.setflags(write=False)
            return reading
        if not usable.all():
            raise RecordingError(f"none of {self._n_times} samples can be used: {'; '.join(findings)}")
        turned = turned_columns({name: self._columns[name] for name in self.source})
        cure = (
            f"{' and '.join(turned)} is negative throughout: exchange the two leads of its pair, or negate the column"
        )
        raise RecordingError(
            f"no current: none of {self._n_times} samples has 1 mA or more through the wire "
            f"({' and '.join(self.source)}); {cure if turned else 'check the columns and their units'}"
        )

    @property
    def has_current(self) -> bool:
        """Whether a recording has the current with the resistance, as an estimator in a loop requires."""
        return self.source is not RESISTANCE or "wire_current_a" in self._columns

    @cached_property
    def circuit(self) -> CircuitReadings:
        """What an estimator takes, sample by sample; a current without a shunt is that through one of 1 ohm."""
        if not self.has_current:
            raise RecordingError(
                f"{self._facts.whose} has the wire's resistance and no current, so there is no power by which to know "
                "heating from cooling: add the column wire_current_a or wire_voltage_v, or choose the estimator "
                "'polynomial', which takes the resistance alone"
            )
        by_shunt = self.source is SHUNT
        shunt_ohm = self._facts.shunt_resistance_ohm if by_shunt else VIRTUAL_SHUNT_OHM
        wire_v, shunt_v = (self._columns[one] for one in (self.source[0], SHUNT[1] if by_shunt else CURRENT[1]))
        usable, _ = self.measured
        # To an estimator, a row that is no measurement is one without current.
        wire_v = np.where(usable, wire_v * shunt_v if self.source is RESISTANCE else wire_v, 0.0)
        shunt_v = np.where(usable, shunt_v, 0.0)
        return CircuitReadings(self._columns.get("drive_voltage_v", wire_v + shunt_v), wire_v, shunt_v, shunt_ohm)

    def not_counted(self, reasons: Sequence[int], valid: Mask, counts: Mask) -> Mapping[str, float]:
        """Return which fraction of all samples of an estimate was not counted for which reason, the largest first."""
        rows = zip(reasons, (valid & ~counts).tolist(), counts.tolist(), self.measured[0].tolist(), strict=True)
        found = Counter(
            UNNOTICED if unnoticed else NOT_COUNTED[Reason(why)] if there else UNUSABLE
            for why, unnoticed, counted, there in rows
            if not counted
        )
        return {why: count / len(reasons) for why, count in found.most_common()}


def resistance_reading(recording: Recording) -> ArrayReading:
    """Return resistance [ohm] and validity of every sample, from whichever electrical columns there are (Eq. 1).

    Raises RecordingError if none follows from them, two of them contradict each other, or no sample can be used.
    """
    return asked_once(recording, JudgedRecording).reading
