"""The arithmetic of a resistance curve, compiled: its branches, and the estimate from one resistance (Eqs. 3 to 5)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in

# Numbers by name, ``row.normalised_min``, in compiled code and in plain Python alike; mypy knows no fields of it.
Row = Any

# The numbers of a curve, by name; see ``ResistanceCurve.numbers``.
CURVE_NUMBERS = (
    "resistance_min_ohm",
    "per_ohm",
    "normalised_min",
    "normalised_max",
    "normalised_margin",
    "noise_ohm",
    "residual_variance",
    "scale_variance",
    "quantity_max",
    "quantity_span",
)


def row_type(names: tuple[str, ...]) -> np.dtype[Any]:
    """Return the type of a row of numbers with these names."""
    return np.dtype((np.record, [(name, np.float64) for name in names]))


CURVE_ROW = row_type(CURVE_NUMBERS)
N_CURVE = len(CURVE_NUMBERS)


@compiled_inner
def branches(coefficients: FloatArray, normalised: float) -> tuple[float, float, float]:
    """Return g_h, g_c and the slope of their sum at a normalised resistance (Eq. 4): one pass by Horner's rule.

    The coefficients are those of both branches in turns, heating first, from the highest power on.
    """
    heating = cooling = slope = 0.0 * normalised
    for place in range(0, coefficients.shape[0], 2):
        slope = slope * normalised + heating + cooling
        heating = heating * normalised + coefficients[place]
        cooling = cooling * normalised + coefficients[place + 1]
    return heating, cooling, slope


@compiled_inner
def curve_estimate(
    curve: Row, coefficients: FloatArray, resistance_ohm: float, noise_ohm: float
) -> tuple[float, float, bool]:
    """Return value, standard deviation and validity from one resistance; see ``ResistanceCurve.estimate``."""
    normalised = (resistance_ohm - curve.resistance_min_ohm) * curve.per_ohm
    if not math.isfinite(normalised):
        return curve.quantity_max, curve.quantity_span, False
    low, high, margin = curve.normalised_min, curve.normalised_max, curve.normalised_margin
    valid = low - margin <= normalised <= high + margin
    inside = min(max(normalised, low), high)
    heating, cooling, slope = branches(coefficients, inside)
    half_gap = (heating - cooling) / 2.0
    spread = slope / 2.0 * (abs(normalised - inside) + noise_ohm * curve.per_ohm)
    value = (heating + cooling) / 2.0
    variance = half_gap * half_gap + curve.residual_variance + spread * spread + curve.scale_variance * value * value
    return value, min(math.sqrt(variance), curve.quantity_span), valid


@compiled
def curve_estimates(
    constants: FloatArray,
    noise_ohm: float,
    values: FloatArray,
    stds: FloatArray,
    valid: npt.NDArray[np.bool_],
) -> None:
    """Estimate from each of the resistances [ohm] in ``values``, and put the values in their place; all (n,)."""
    curve = row_in(constants, CURVE_ROW)
    for place in range(values.shape[0]):
        values[place], stds[place], valid[place] = curve_estimate(curve, constants[N_CURVE:], values[place], noise_ohm)
