"""How far a curve without an instrument may be off: curves of wires that the resistance leaves possible; what helps."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError, NumericsError
from musclewire.extras.calibration._physical.candidates import CandidateParameters
from musclewire.sensing import SensingModel, evaluate

# Normalised resistances at which curves are compared.
GRID = np.linspace(0.0, 1.0, 25)
# With fewer curves the spread of a spread is above a tenth of it.
MIN_CURVES = 40


class PossibleCurves(NamedTuple):
    """Curves of drawn wires, (n_wires, 2 branches, n_grid), their largest quantities, and the wires' coordinates."""

    quantity: FloatArray
    largest: FloatArray
    coordinates: FloatArray


def possible_curves(drawn: FloatArray, model_of: Callable[[FloatArray], SensingModel]) -> PossibleCurves:
    """Return the curves of the drawn wires that have a usable loop. Raises NumericsError if hardly any has one."""
    curves, largest, kept = [], [], []
    for coordinates in drawn:
        try:
            model = model_of(coordinates)
        except MusclewireError:
            continue
        inside = np.clip(GRID, model.normalised_min, model.normalised_max)
        branches = (model.heating_coefficients, model.cooling_coefficients)
        curves.append([evaluate(branch, inside) for branch in branches])
        largest.append(model.quantity_max)
        kept.append(coordinates)
    if len(kept) < MIN_CURVES:
        raise NumericsError(
            f"{len(kept)} of {drawn.shape[0]} wires drawn from what the resistance leaves possible have a usable loop, "
            f"{MIN_CURVES} are needed: the drive may be too low, or this is another wire than the one named"
        )
    return PossibleCurves(np.array(curves), np.array(largest), np.array(kept))


def scale_and_offset_std(curves: PossibleCurves, model: SensingModel) -> tuple[float, float]:
    """Return the deviations, 0 or more, of a common factor and offset that describe the spread of curves."""
    from scipy.optimize import nnls

    inside = (model.normalised_min <= GRID) & (model.normalised_max >= GRID)
    variance = curves.quantity.var(axis=0, ddof=1)[:, inside].mean(axis=0)
    value = evaluate(model.average_coefficients, GRID[inside])
    squares = np.column_stack([value**2, np.full(value.size, model.quantity_max**2)])
    found, _ = nnls(squares, variance)
    return float(np.sqrt(found[0])), float(np.sqrt(found[1]) * model.quantity_max)


# What a user can measure better, and how it is called.
STATED = {
    "wire_length_m": "the wire's length",
    "pretension_n": "the pretension",
    "spring_stiffness_n_per_m": "the spring's stiffness",
    "ambient_temperature_k": "the air's temperature",
}
# What it would cost to buy: marks by a ruler, by a caliper, and by a dial gauge; standard deviations of a reading.
INSTRUMENTS = {"a ruler": 0.5e-3, "a caliper": 0.05e-3, "a dial gauge": 0.01e-3}
# A number is worth knowing better if knowing it exactly lessened the standard deviation by at least this fraction.
WORTH = 0.02


class StrokeShare(NamedTuple):
    """A stated number, its standard deviation as a fraction of it, and the fraction of the stroke that it costs."""

    name: str
    relative_std: float
    stroke_std: float

    @property
    def text(self) -> str:
        """The cost in words."""
        return (
            f"{STATED[self.name]}, known to {100.0 * self.relative_std:.2g} %, costs "
            f"{100.0 * self.stroke_std:.2g} % of the stroke"
        )


class BetterMeasurement(NamedTuple):
    """A measurement, and the standard deviation of the stroke after it, as a fraction of the stroke."""

    what: str
    stroke_std: float


def costs_of(curves: PossibleCurves, candidates: CandidateParameters) -> list[StrokeShare]:
    """Return what each stated number costs, the dearest first: how much of the stroke's spread depends on it."""
    numbers = np.array([candidates.numbers(one) for one in curves.coordinates])
    mean = float(curves.largest.mean())
    found = []
    for place, name in enumerate(candidates.names):
        spread = float(numbers[:, place].std(ddof=1))
        if name in STATED and spread > 0.0:
            together = float(np.cov(numbers[:, place], curves.largest)[0, 1])
            found.append(
                StrokeShare(name, spread / abs(float(numbers[:, place].mean())), abs(together) / spread / mean)
            )
    return sorted(found, key=lambda item: -item.stroke_std)


def what_helps(
    curves: PossibleCurves, candidates: CandidateParameters, metres_per_unit: float
) -> list[BetterMeasurement]:
    """Return measurements by the standard deviation of the stroke after them, the best first.

    ``metres_per_unit`` turns the model's quantity into displacement. Only those are listed that help.
    """
    mean, now = float(curves.largest.mean()), float(curves.largest.std(ddof=1))
    found = []
    for tool, reading_m in INSTRUMENTS.items():
        mark = 2.0**0.5 * reading_m / metres_per_unit
        found.append(
            BetterMeasurement(
                f"two marks, cold and hot, read with {tool} ({1e3 * reading_m:g} mm)", combined_std(now, mark)
            )
        )
    for cost in costs_of(curves, candidates):
        left = max(now**2 - (cost.stroke_std * mean) ** 2, 0.0) ** 0.5
        found.append(BetterMeasurement(f"{STATED[cost.name]}, measured exactly", left))
    worth = [
        item._replace(stroke_std=item.stroke_std / mean) for item in found if item.stroke_std < (1.0 - WORTH) * now
    ]
    return sorted(worth, key=lambda item: item.stroke_std)


def combined_std(prior_std: float, measured_std: float) -> float:
    """Return the standard deviation of a number known before and measured once more: inverse variances add."""
    return (prior_std**-2 + measured_std**-2) ** -0.5 if prior_std > 0.0 else 0.0
