"""Why samples of an estimate are not counted, where its errors are largest and what causes them, from the recording."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.sensing import (
    SHOWN_AS,
    SensingModel,
    centred_mean,
    derivative,
    evaluate,
    noise_level,
    normalised_resistance,
    turning_points,
)
from musclewire.signals import Reason, Recording

Mask = npt.NDArray[np.bool_]

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
# The mean error over so many samples is what noise of single readings leaves.
MEAN_SAMPLES = 33
# A cause explains an error if without its part at most this fraction of the error remains.
EXPLAINED = 0.5
# A single reading is off by at most so many times the noise.
NOISES = 3.0
# A movement of less than this fraction of the stroke, or of so many times the noise, is no turn of the wire.
TURN_FRACTION = 0.05
TURN_NOISES = 8.0


class ErrorCause(StrEnum):
    """What causes the error of a sample."""

    HOT = "beyond the model"
    NOISE = "noise"
    GAP = "gap of the branches"
    MODEL = "another relation"
    ESTIMATOR = "estimator"
    SEVERAL = "several"


IN_WORDS = {
    ErrorCause.HOT: "the wire went beyond the hot end of the model",
    ErrorCause.GAP: "the estimate lies between heating and cooling, off the wire's own branch",
    ErrorCause.NOISE: "single readings scatter",
    ErrorCause.MODEL: "the wire is off the model's branch, as in a minor loop or with another load, air or length",
    ErrorCause.ESTIMATOR: "the estimate is off the model's branch, which is nearer to the reference",
    ErrorCause.SEVERAL: "no single cause explains it",
}


@dataclass(frozen=True)
class ErrorGroup:
    """The counted samples whose errors have one cause, and the largest of these errors.

    Parameters
    ----------
    cause
        The cause, an :class:`ErrorCause`.
    why
        The cause in words.
    fraction
        Fraction of the counted samples.
    squared_error_fraction
        Fraction of the sum of squared errors.
    rms_without_pct
        Root mean square error [%] of the stroke of all other counted samples; None if there are none.
    largest_pct
        Largest error [%] of the stroke, estimated less measured.
    time_s
        Its time [s].
    branch
        The branch on which it is, as the reference moves: "heating" or "cooling".
    voltage_v
        Drive voltage [V] at that time, or the wire's where the drive was not recorded; None without either.
    estimated, measured
        Estimate and reference at that time: strain as a fraction, displacement [m] or force [N].
    explained
        How much of their difference the cause makes: it leaves half of it at most.
    """

    cause: ErrorCause
    why: str
    fraction: float
    squared_error_fraction: float
    rms_without_pct: float | None
    largest_pct: float
    time_s: float
    branch: str
    voltage_v: float | None
    estimated: float
    measured: float
    explained: float


@dataclass(frozen=True, eq=False)
class JudgedEstimate:
    """An estimate and its reference, sample by sample; all arrays (n_times,).

    Parameters
    ----------
    model
        The model of the estimate.
    recording
        Its recording.
    resistance_ohm
        Resistance [ohm].
    estimated, measured
        Strain as a fraction, displacement [m] or force [N].
    valid
        Which samples count; at none of them the wire is colder than the model begins.
    """

    model: SensingModel
    recording: Recording
    resistance_ohm: FloatArray
    estimated: FloatArray
    measured: FloatArray
    valid: Mask

    @property
    def range(self) -> float:
        """The range that the model senses."""
        return self.model.quantity_max - self.model.quantity_min

    @property
    def error_pct(self) -> FloatArray:
        """Estimated less measured [%] of the stroke."""
        return (self.estimated - self.measured) / self.model.stroke * 100.0


def fractions_not_counted(reasons: Sequence[int], valid: Mask, counts: Mask, usable: Mask) -> Mapping[str, float]:
    """Return which fraction of all samples was not counted for which reason, the largest first."""
    rows = zip(reasons, (valid & ~counts).tolist(), counts.tolist(), usable.tolist(), strict=True)
    found = Counter(
        UNNOTICED if unnoticed else NOT_COUNTED[Reason(why)] if there else UNUSABLE
        for why, unnoticed, counted, there in rows
        if not counted
    )
    return {why: count / len(reasons) for why, count in found.most_common()}


def error_groups(judged: JudgedEstimate) -> tuple[ErrorGroup, ...]:
    """Return the counted samples by the cause of their error, that with the most of the squared error first."""
    error = judged.error_pct
    squares = np.where(judged.valid, error**2, 0.0)
    heating = rising_of(judged)
    parts = parts_of(judged, heating)
    found = []
    for cause, members in caused_by(parts, judged.estimated - judged.measured, judged.valid).items():
        if not members.any():
            continue
        others = judged.valid & ~members
        worst = int(np.argmax(np.where(members, np.abs(error), -1.0)))
        found.append(
            ErrorGroup(
                cause=cause,
                why=IN_WORDS[cause],
                fraction=float(members.sum() / judged.valid.sum()),
                squared_error_fraction=float(squares[members].sum() / squares.sum()) if squares.any() else 0.0,
                rms_without_pct=float(np.sqrt(np.mean(error[others] ** 2))) if others.any() else None,
                largest_pct=float(error[worst]),
                time_s=float(judged.recording["time_s"][worst]),
                branch="heating" if heating[worst] else "cooling",
                voltage_v=voltage_at(judged.recording, worst),
                estimated=float(judged.estimated[worst]),
                measured=float(judged.measured[worst]),
                explained=float(parts[cause][worst]),
            )
        )
    return tuple(sorted(found, key=lambda group: -group.squared_error_fraction))


def caused_by(parts: Mapping[ErrorCause, FloatArray], error: FloatArray, valid: Mask) -> dict[ErrorCause, Mask]:
    """Return the counted samples of each cause; a sample has the first whose part leaves little of its error."""
    free = valid.copy()
    groups = {}
    for cause, part in parts.items():
        holds = np.abs(error - part) <= EXPLAINED * np.abs(error)
        groups[cause] = free & holds
        free &= ~holds
    return groups


def parts_of(judged: JudgedEstimate, heating: Mask) -> dict[ErrorCause, FloatArray]:
    """Return how much of each sample's error each cause makes, in the model's quantity; the last makes all of it.

    What an estimate between the branches is off the wire's own makes their gap, what one elsewhere is off it the
    estimator, and what the wire is off it the model.
    """
    model, measured = judged.model, judged.measured
    error = judged.estimated - measured
    normalised = normalised_resistance(judged.resistance_ohm, model.resistance_min_ohm, model.resistance_max_ohm)
    inside = np.clip(normalised, model.normalised_min, model.normalised_max)
    curves = (model.heating_coefficients, model.cooling_coefficients)
    branches = [evaluate(one, inside) for one in curves]
    own, other = np.where(heating, *branches), np.where(heating, *branches[::-1])
    off_branch, gap = judged.estimated - own, other - own
    slow = np.zeros(error.shape)
    slow[judged.valid] = centred_mean(error[judged.valid], MEAN_SAMPLES)
    slope = np.where(heating, *(evaluate(derivative(one), inside) for one in curves))
    per_ohm = slope / (model.resistance_max_ohm - model.resistance_min_ohm)
    scatter = NOISES * np.hypot(per_ohm * noise_level(judged.resistance_ohm[judged.valid]), noise_level(measured))
    return {
        ErrorCause.HOT: np.minimum(hot_end_of(model) - measured, 0.0),
        ErrorCause.GAP: np.clip(off_branch, np.minimum(gap, 0.0), np.maximum(gap, 0.0)),
        ErrorCause.NOISE: np.clip(error - slow, -scatter, scatter),
        ErrorCause.MODEL: own - measured,
        ErrorCause.ESTIMATOR: off_branch,
        ErrorCause.SEVERAL: error,
    }


def hot_end_of(model: SensingModel) -> float:
    """Return the highest value of either branch at the hot end."""
    branches = (model.heating_coefficients, model.cooling_coefficients)
    return float(max(evaluate(one, model.normalised_min) for one in branches))


def rising_of(judged: JudgedEstimate) -> Mask:
    """Return in which samples the reference rises, (n_times,)."""
    measured = judged.measured
    turns, _ = turning_points(measured, max(TURN_FRACTION * judged.range, TURN_NOISES * noise_level(measured)))
    rising = np.ones(measured.shape, dtype=np.bool_)
    for place, turn in enumerate(turns):
        following = turns[place + 1] if place + 1 < len(turns) else turns[place - 1]
        rises = bool(measured[following] > measured[turn])
        if place == 0:
            rising[:] = rises if turn == 0 else not rises
        rising[turn + 1 :] = rises if place + 1 < len(turns) else not rises
    return rising


def voltage_at(recording: Recording, row: int) -> float | None:
    """Return the drive voltage [V] of a row, or the wire's; None if neither was recorded."""
    column = recording.columns.get("drive_voltage_v", recording.columns.get("wire_voltage_v"))
    return None if column is None else float(column[row])


def lines_of(model_quantity: str, groups: Sequence[ErrorGroup]) -> list[str]:
    """Return where the errors are and why: the group of most squares, and that of the largest error if it counts."""
    if not groups:
        return []
    factor, unit = SHOWN_AS[model_quantity]
    largest = max(groups, key=lambda group: abs(group.largest_pct))
    chosen = [groups[0], *[largest][: largest is not groups[0]]]
    lines = []
    for group in chosen:
        voltage = "" if group.voltage_v is None else f", {group.voltage_v:.2f} V"
        without = "" if group.rms_without_pct is None else f"; without them {group.rms_without_pct:.3f} % rms"
        by_this = f", {factor * group.explained:+.2g} {unit} by this" if group.cause is not ErrorCause.SEVERAL else ""
        lines.append(
            f"{100 * group.squared_error_fraction:.0f} % of the squared error: {group.why} "
            f"({100 * group.fraction:.1f} % of the counted samples{without}); largest at {group.time_s:.1f} s, "
            f"{group.branch}{voltage}: {factor * group.estimated:.3g} {unit} estimated, "
            f"{factor * group.measured:.3g} {unit} measured{by_this}"
        )
    return lines
