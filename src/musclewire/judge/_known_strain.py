"""A strain that is known at one moment of a run, as of an end stop: how far the estimate is off scales the rest.

Resistance alone does not show whether the wire has moved or its own resistance, load or spring has changed. One known
strain gives the factor by which the resistance is to be read for the rest of the run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.controllers import Reference
from musclewire.errors import CallerError
from musclewire.judge._loop import DetectedRows, JudgedLoop
from musclewire.signals import MetadataValue, RunFacts

# [s] before the moment of the known strain, over which the estimate is averaged.
COMPARED_S = 1.0
# Standard deviations to either side of the mean within which 95 % of normal errors lie.
WITHIN_STD = 1.96


class KnownStrain(NamedTuple):
    """What the wire's strain (or displacement [m], force [N]) is at a time [s] of a run, whatever the estimate says."""

    value: float
    at_s: float

    def metadata(self) -> dict[str, MetadataValue]:
        """Return it as a recording states it."""
        return {"known_strain": self.value, "known_strain_at_s": self.at_s}


def known_strain_in(
    known: float | tuple[float, float] | None, reference: Reference, approach_s: float, sample_period_s: float
) -> KnownStrain | None:
    """Return a known strain with its time, or with the end of a reference's first hold. Raises CallerError without."""
    if known is None:
        return None
    try:
        numbers = [float(number) for number in np.atleast_1d(np.asarray(known, dtype=np.float64))]
    except (TypeError, ValueError):
        numbers = []
    if len(numbers) not in (1, 2) or not np.all(np.isfinite(numbers)):
        raise CallerError(f"a known strain is a number in SI, or with its time [s] two, as (0.012, 3.0): not {known!r}")
    if len(numbers) == 2:
        last_s = approach_s + reference.duration_s
        if not 0.0 <= numbers[1] < last_s:
            raise CallerError(f"the known strain is one at {numbers[1]:g} s, and the run goes from 0 to {last_s:g} s")
        return KnownStrain(*numbers)
    targets = reference.targets_at(np.arange(0.0, reference.duration_s, sample_period_s))
    held = np.flatnonzero(np.append(targets != targets[0], True))[0]
    if held * sample_period_s < COMPARED_S:
        raise CallerError(
            "the reference does not begin with a hold: give the known strain with the time that it holds at"
        )
    return KnownStrain(numbers[0], approach_s + float(held - 1) * sample_period_s)


class MissedBy(NamedTuple):
    """The row at which a known strain was compared, and by how much the estimate was above it, with its deviation."""

    row: int
    above: float
    std: float

    @property
    def is_away(self) -> bool:
        """Whether that is beyond the 95 % interval."""
        return abs(self.above) > WITHIN_STD * self.std


def compared_with_known(loop: JudgedLoop) -> MissedBy | None:
    """Return by how much a run's estimate missed the strain that was known; None without one or the other."""
    known = stated_in(loop.facts)
    if known is None or not loop.suffix or "estimate_std" not in loop.recording:
        return None
    # The first row is of the first sample; a recording that was cut still counts from the beginning of the run.
    elapsed_s = loop.time_s - min(float(loop.time_s[0]), loop.facts.sample_period_s)
    rows = np.flatnonzero(elapsed_s <= known.at_s)
    if not rows.size:
        return None
    row = int(rows[-1])
    there = rows[(elapsed_s[rows] >= elapsed_s[row] - COMPARED_S) & loop.valid[rows]]
    std = float(loop.std[row])
    if row + 1 == len(loop.recording) or not loop.valid[row]:
        return None
    (value,) = held_mean(loop.estimate[there][:, None], std)
    return MissedBy(row, float(value) - known.value, std)


def missed_known_strain(loop: JudgedLoop) -> DetectedRows:
    """Return the samples since the estimate missed a known strain, by how much, and what followed."""
    missed = loop.once(compared_with_known)
    if missed is None or not missed.is_away:
        return DetectedRows(loop.since(None))
    factor, unit = loop.shown_as
    side = "above" if missed.above > 0.0 else "below"
    by = f"by {factor * abs(missed.above):.2g} {unit} {side}, beyond +-{factor * WITHIN_STD * missed.std:.2g} {unit}"
    scaled_by = loop.recording["resistance_factor"][-1]
    return DetectedRows(loop.since(missed.row), lambda: f"{by}; the resistance is scaled by {scaled_by:.4f}")


def held_mean(rows: FloatArray, std: float) -> FloatArray:
    """Return the mean of rows, (n, columns), since the estimate, in the last column, has been within its interval."""
    away = np.flatnonzero(np.abs(rows[:, -1] - rows[-1, -1]) > WITHIN_STD * std)
    return np.asarray(rows[away[-1] + 1 if away.size else 0 :].mean(axis=0))


def stated_in(facts: RunFacts) -> KnownStrain | None:
    """Return the known strain that a run states; None if none."""
    value, at_s = facts.number_or_none("known_strain"), facts.number_or_none("known_strain_at_s")
    return None if value is None or at_s is None else KnownStrain(value, at_s)


def known_strain_unused(loop: JudgedLoop) -> str:
    """Return in words that a known strain was not compared; "" if it was, or there is none."""
    known = stated_in(loop.facts)
    if known is None or loop.once(compared_with_known) is not None:
        return ""
    why = "no estimate was valid then, or the recording has no such time"
    return f"the strain that is known at {known.at_s:g} s was not compared: {why}"
