"""How far a curve without an instrument may be off: curves of wires that the resistance leaves possible."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError, NumericsError
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
    """Return the curves of drawn wires; a wire without a usable loop is passed over.

    Raises NumericsError if hardly any of them has one.
    """
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
    """Return the standard deviations of a common factor and a common offset that describe the spread of curves.

    Least squares of the variance over the squared value, neither below 0, over the model's valid range.
    """
    from scipy.optimize import nnls

    inside = (model.normalised_min <= GRID) & (model.normalised_max >= GRID)
    variance = curves.quantity.var(axis=0, ddof=1)[:, inside].mean(axis=0)
    value = evaluate(model.average_coefficients, GRID[inside])
    squares = np.column_stack([value**2, np.full(value.size, model.quantity_max**2)])
    found, _ = nnls(squares, variance)
    return float(np.sqrt(found[0])), float(np.sqrt(found[1]) * model.quantity_max)
