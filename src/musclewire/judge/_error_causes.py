"""Where the errors of an estimate are largest and what causes them, from the recording."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.judge._readings import Mask
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
from musclewire.signals import Recording

# Samples over which an error is averaged, so that the noise of single readings drops out.
MEAN_SAMPLES = 33
# A cause explains an error if without its part at most this fraction of the error remains.
EXPLAINED = 0.5
# Standard deviations of the noise by which a single reading is off at most.
NOISES = 3.0
# A smaller movement than both of these is no turn of the wire.
TURN_FRACTION = 0.05  # of the stroke
TURN_NOISES = 8.0  # standard deviations of the noise


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
    """The counted samples whose errors have one cause, and the largest of these errors."""

    cause: ErrorCause
    why: str  # the cause in words
    fraction: float  # of the counted samples
    squared_error_fraction: float  # of the sum of squared errors
    rms_without_pct: float | None  # of the stroke, over all other counted samples; None if there are none
    largest_pct: float  # error of the stroke, estimated less measured; what follows is at its time
    time_s: float
    branch: str  # as the reference moves: "heating" or "cooling"
    voltage_v: float | None  # of the drive, or the wire's where that was not recorded
    estimated: float  # strain as a fraction, displacement [m] or force [N]
    measured: float  # the same of the reference
    explained: float  # how much of their difference the cause makes: it leaves half of it at most

    def in_words(self, quantity: str) -> str:
        """Return where these errors are and why, as a line."""
        factor, unit = SHOWN_AS[quantity]
        voltage = "" if self.voltage_v is None else f", {self.voltage_v:.2f} V"
        without = "" if self.rms_without_pct is None else f"; without them {self.rms_without_pct:.3f} % rms"
        by_this = "" if self.cause is ErrorCause.SEVERAL else f", {factor * self.explained:+.2g} {unit} by this"
        return (
            f"{100 * self.squared_error_fraction:.0f} % of the squared error: {self.why} "
            f"({100 * self.fraction:.1f} % of the counted samples{without}); largest at {self.time_s:.1f} s, "
            f"{self.branch}{voltage}: {factor * self.estimated:.3g} {unit} estimated, "
            f"{factor * self.measured:.3g} {unit} measured{by_this}"
        )


@dataclass(frozen=True, eq=False)
class JudgedEstimate:
    """An estimate and its reference, sample by sample; all arrays (n_times,)."""

    model: SensingModel
    recording: Recording
    resistance_ohm: FloatArray
    estimated: FloatArray  # strain as a fraction, displacement [m] or force [N]
    measured: FloatArray  # the same of the reference
    valid: Mask  # which samples count; at none of them the wire is colder than the model begins

    @property
    def groups(self) -> tuple[ErrorGroup, ...]:
        """The counted samples by the first cause that leaves little of their error, most of the squared error first."""
        error, free, heating, found = self.estimated - self.measured, self.valid, rising_of(self), []
        for cause, part in parts_of(self, heating).items():
            holds = np.abs(error - part) <= EXPLAINED * np.abs(error)
            members, free = free & holds, free & ~holds
            if members.any():
                found.append(self.group(cause, members, part, heating))
        return tuple(sorted(found, key=lambda group: -group.squared_error_fraction))

    def group(self, cause: ErrorCause, members: Mask, part: FloatArray, heating: Mask) -> ErrorGroup:
        """Return some counted samples with their cause, which makes a part of each sample's error."""
        error_pct = (self.estimated - self.measured) / self.model.stroke * 100.0
        squares = np.where(self.valid, error_pct**2, 0.0)
        others = self.valid & ~members
        worst = int(np.argmax(np.where(members, np.abs(error_pct), -1.0)))
        voltage_v = self.recording.columns.get("drive_voltage_v", self.recording.columns.get("wire_voltage_v"))
        return ErrorGroup(
            cause=cause,
            why=IN_WORDS[cause],
            fraction=float(members.sum() / self.valid.sum()),
            squared_error_fraction=float(squares[members].sum() / squares.sum()) if squares.any() else 0.0,
            rms_without_pct=float(np.sqrt(np.mean(error_pct[others] ** 2))) if others.any() else None,
            largest_pct=float(error_pct[worst]),
            time_s=float(self.recording["time_s"][worst]),
            branch="heating" if heating[worst] else "cooling",
            voltage_v=None if voltage_v is None else float(voltage_v[worst]),
            estimated=float(self.estimated[worst]),
            measured=float(self.measured[worst]),
            explained=float(part[worst]),
        )


def parts_of(judged: JudgedEstimate, heating: Mask) -> dict[ErrorCause, FloatArray]:
    """Return how much of each sample's error each cause makes, in the model's quantity; the last makes all of it."""
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
        ErrorCause.HOT: np.minimum(max(evaluate(one, model.normalised_min) for one in curves) - measured, 0.0),
        ErrorCause.GAP: np.clip(off_branch, np.minimum(gap, 0.0), np.maximum(gap, 0.0)),
        ErrorCause.NOISE: np.clip(error - slow, -scatter, scatter),
        ErrorCause.MODEL: own - measured,
        ErrorCause.ESTIMATOR: off_branch,
        ErrorCause.SEVERAL: error,
    }


def rising_of(judged: JudgedEstimate) -> Mask:
    """Return in which samples the reference rises, (n_times,)."""
    measured, model = judged.measured, judged.model
    least = max(TURN_FRACTION * (model.quantity_max - model.quantity_min), TURN_NOISES * noise_level(measured))
    turns, _ = turning_points(measured, least)
    rising = np.ones(measured.shape, dtype=np.bool_)
    for place, turn in enumerate(turns):
        following = turns[place + 1] if place + 1 < len(turns) else turns[place - 1]
        rises = bool(measured[following] > measured[turn])
        if place == 0:
            rising[:] = rises if turn == 0 else not rises
        rising[turn + 1 :] = rises if place + 1 < len(turns) else not rises
    return rising
