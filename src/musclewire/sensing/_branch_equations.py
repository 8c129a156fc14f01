"""Eqs. 3 to 5 as plain functions: normalised resistance, a branch's polynomial, the average of both branches."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import overload

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError


@overload
def normalised_resistance(resistance_ohm: float, resistance_min_ohm: float, resistance_max_ohm: float) -> float: ...
@overload
def normalised_resistance(
    resistance_ohm: FloatArray, resistance_min_ohm: float, resistance_max_ohm: float
) -> FloatArray: ...
def normalised_resistance(
    resistance_ohm: float | FloatArray, resistance_min_ohm: float, resistance_max_ohm: float
) -> float | FloatArray:
    """Return the place of a resistance in segment B-C: 0 at C (hot), 1 at B (cold), not clipped outside (Eq. 3).

    Raises CallerError unless 0 < R_min < R_max.

    References
    ----------
    Lan and Fan 2010, Eq. 3.
    """
    check_resistance_range(resistance_min_ohm, resistance_max_ohm)
    return (resistance_ohm - resistance_min_ohm) / (resistance_max_ohm - resistance_min_ohm)


def check_resistance_range(resistance_min_ohm: float, resistance_max_ohm: float) -> None:
    """Raise CallerError unless 0 < R_min < R_max and both are finite."""
    if not 0.0 < resistance_min_ohm < resistance_max_ohm < inf:
        raise CallerError(
            f"minimum resistance {resistance_min_ohm} ohm and maximum resistance {resistance_max_ohm} ohm: "
            "both must be positive and finite, the minimum below the maximum"
        )


@overload
def evaluate(coefficients: Sequence[float], normalised_resistance: float) -> float: ...
@overload
def evaluate(coefficients: Sequence[float], normalised_resistance: FloatArray) -> FloatArray: ...
def evaluate(coefficients: Sequence[float], normalised_resistance: float | FloatArray) -> float | FloatArray:
    """Return the value of a polynomial by Horner's rule (Eq. 4); the coefficients are of ascending powers."""
    total: float | FloatArray = 0.0 * normalised_resistance
    for coefficient in reversed(coefficients):
        total = total * normalised_resistance + coefficient
    return total


def average(heating: Sequence[float], cooling: Sequence[float]) -> tuple[float, ...]:
    """Return the average of the coefficients of both branches, g_a = (g_h + g_c) / 2 (Eq. 5).

    Raises CallerError if the branches are of different order.

    References
    ----------
    Lan and Fan 2010, Eq. 5.
    """
    if len(heating) != len(cooling):
        raise CallerError(f"heating has {len(heating)} coefficients and cooling {len(cooling)}: fit both alike")
    return tuple((h + c) / 2.0 for h, c in zip(heating, cooling, strict=True))


def derivative(coefficients: tuple[float, ...]) -> tuple[float, ...]:
    """Return the ascending coefficients of the derivative of a polynomial."""
    return tuple(power * coefficient for power, coefficient in enumerate(coefficients))[1:]
