"""The resistance curve of a wire: strain from resistance, and the resistance a strain requires (Eqs. 3 to 5).

An estimator evaluates it at every tick, by ``curve_estimate``. The report of the fit that found these
numbers is in ``_fit_report``.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isfinite
from typing import Any, NamedTuple, cast, overload

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.compiled import compiled, compiled_inner, row_in
from musclewire.errors import CallerError, nearest_hint
from musclewire.sensing._branch_equations import average, check_resistance_range, derivative, evaluate

# Numbers by name, ``row.normalised_min``, in compiled code and in plain Python alike; mypy knows no fields of it.
Row = Any

# The numbers of a curve, by name; see ``ResistanceCurve.numbers``.
CURVE_NUMBERS = (
    "resistance_min_ohm",
    "per_ohm",
    "normalised_min",
    "normalised_max",
    "valid_from",
    "valid_to",
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

    The coefficients are of both branches in turns, heating first, from the highest power on.
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
    valid = curve.valid_from <= normalised <= curve.valid_to
    inside = min(max(normalised, curve.normalised_min), curve.normalised_max)
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


Pairs = tuple[tuple[float, float], ...]

QUANTITY_UNITS = {"strain": "1", "displacement": "m", "force": "N"}
# Display of each quantity: factor from SI, and unit.
SHOWN_AS = {"strain": (100.0, "%"), "displacement": (1e3, "mm"), "force": (1.0, "N")}

# A resistance up to this far outside the valid range, in normalised resistance, still counts as its end.
MARGIN = 0.02
# A resistance further outside R_min..R_max, as a fraction of their span, is that of another wire, or a fault.
MISMATCH_FRACTION = 0.15
# A quantity up to this fraction of the range outside it counts as its end, as data are rounded.
QUANTITY_MARGIN = 0.005
DERIVATIVE_CHECKS = 201
# No wire has numbers of this size in SI units, and below it the arithmetic of an estimate cannot overflow.
MAX_NUMBER = 1e12


class CurveEstimate(NamedTuple):
    """The estimate from one resistance: value, standard deviation and validity."""

    value: float  # strain as a fraction, displacement [m] or force [N]
    std: float
    valid: bool  # whether the resistance was in the valid range


class ArrayEstimate(NamedTuple):
    """The estimates from many resistances, in three arrays of the shape of the resistances."""

    value: FloatArray  # strain as a fraction, displacement [m] or force [N]
    std: FloatArray
    valid: npt.NDArray[np.bool_]  # whether each resistance was in the valid range


@dataclass(frozen=True)
class ResistanceCurve:
    """Polynomials from normalised resistance to strain (or displacement, force), with their valid range.

    Source: Lan and Fan 2010, Eqs. 3 to 5: heating g_h, cooling g_c and their mean g_a, of lambda (normalised
    resistance: 0 at ``resistance_min_ohm``, 1 at ``resistance_max_ohm``). Between ``normalised_min`` and
    ``normalised_max`` g_a falls strictly, so it can be inverted; outside, resistances are read as the nearer end and
    marked invalid. All quantities are SI: strain is a fraction, displacement in metres, force in newtons.

    Parameters
    ----------
    resistance_min_ohm, resistance_max_ohm
        Resistance [ohm] at point C (hot) and at point B (cold).
    heating_coefficients, cooling_coefficients
        Ascending powers of g_h and g_c in lambda; both of one order, at least 1.
    normalised_min, normalised_max
        Ends of the valid range of lambda.
    quantity
        "strain", "displacement" or "force".
    rmse_heating, rmse_cooling
        Root mean square errors of the branches against the samples they were fitted to, in the quantity's unit.
    resistance_noise_ohm
        Standard deviation of one resistance reading [ohm]; 0 if it is unknown.
    scale_std, offset_std
        Standard deviations of a common factor of the quantity, a fraction, and of a common offset, in its unit, for a
        curve that was not measured with an instrument; 0 for one that was.

    Raises
    ------
    CallerError
        If the parts contradict each other.
    """

    resistance_min_ohm: float
    resistance_max_ohm: float
    heating_coefficients: tuple[float, ...]
    cooling_coefficients: tuple[float, ...]
    normalised_min: float
    normalised_max: float
    quantity: str = "strain"
    rmse_heating: float = 0.0
    rmse_cooling: float = 0.0
    resistance_noise_ohm: float = 0.0
    scale_std: float = 0.0
    offset_std: float = 0.0
    average_coefficients: tuple[float, ...] = field(init=False, repr=False, compare=False)
    quantity_min: float = field(init=False, repr=False, compare=False)
    quantity_max: float = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Derive g_a and the range of the quantity, and check that the parts agree."""
        check_resistance_range(self.resistance_min_ohm, self.resistance_max_ohm)
        mean = average(self.heating_coefficients, self.cooling_coefficients)
        object.__setattr__(self, "average_coefficients", mean)
        self._check()
        object.__setattr__(self, "quantity_min", evaluate(mean, self.normalised_max))
        object.__setattr__(self, "quantity_max", evaluate(mean, self.normalised_min))

    def _check(self) -> None:
        """Raise CallerError if the parts contradict each other."""
        if self.quantity not in QUANTITY_UNITS:
            hint = nearest_hint(str(self.quantity), QUANTITY_UNITS)
            raise CallerError(f"quantity {self.quantity!r} is unknown{hint}")
        if len(self.average_coefficients) < 2 or not all(map(isfinite, self.average_coefficients)):
            raise CallerError(
                "a sensing model needs at least 2 finite coefficients a branch (order 1), not "
                f"{self.average_coefficients}"
            )
        largest = max(map(abs, (*self.heating_coefficients, *self.cooling_coefficients)))
        if largest > MAX_NUMBER:
            raise CallerError(f"a coefficient of {largest:.3g} is beyond {MAX_NUMBER:g}: no wire has it, fit again")
        low, high = self.normalised_min, self.normalised_max
        if not -0.5 <= low < high <= 1.5:
            raise CallerError(f"valid range of normalised resistance {low} to {high}: must rise within -0.5 to 1.5")
        require_in_range((self.rmse_heating, self.rmse_cooling, self.resistance_noise_ohm))
        require_in_range((self.scale_std, self.offset_std))
        slope = evaluate(derivative(self.average_coefficients), np.linspace(low, high, DERIVATIVE_CHECKS))
        if not (slope[1:-1] < 0.0).all():
            raise CallerError(
                f"the average polynomial does not fall throughout its valid range {low:.4f} to {high:.4f} of "
                "normalised resistance: it cannot be inverted, fit again"
            )

    @property
    def order(self) -> int:
        """Order of the polynomials."""
        return len(self.heating_coefficients) - 1

    @property
    def unit(self) -> str:
        """SI unit of the quantity ("1" for strain)."""
        return QUANTITY_UNITS[self.quantity]

    @property
    def valid_resistance_ohm(self) -> tuple[float, float]:
        """Minimum and maximum resistance of the valid range [ohm]."""
        span = self.resistance_max_ohm - self.resistance_min_ohm
        low = self.resistance_min_ohm + self.normalised_min * span
        return low, self.resistance_min_ohm + self.normalised_max * span

    @property
    def own_resistance_ohm(self) -> tuple[float, float]:
        """Minimum and maximum resistance [ohm] that can be this wire's; one beyond is another wire's, or a fault."""
        margin = MISMATCH_FRACTION * (self.resistance_max_ohm - self.resistance_min_ohm)
        return self.resistance_min_ohm - margin, self.resistance_max_ohm + margin

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers that compiled code reads, by name."""
        return {
            "resistance_min_ohm": self.resistance_min_ohm,
            "per_ohm": self._per_ohm,
            "normalised_min": self.normalised_min,
            "normalised_max": self.normalised_max,
            "valid_from": self.normalised_min - MARGIN,
            "valid_to": self.normalised_max + MARGIN,
            "noise_ohm": self.resistance_noise_ohm,
            "residual_variance": (self.rmse_heating**2 + self.rmse_cooling**2) / 2.0 + self.offset_std**2,
            "scale_variance": self.scale_std**2,
            "quantity_max": self.quantity_max,
            "quantity_span": self.quantity_max - self.quantity_min,
        }

    @property
    def coefficients_in_turns(self) -> FloatArray:
        """The coefficients of both branches in turns, heating first, from the highest power on: (2 (order + 1),)."""
        return np.column_stack([self.heating_coefficients, self.cooling_coefficients])[::-1].reshape(-1)

    @cached_property
    def _per_ohm(self) -> float:
        """Normalised resistance per ohm."""
        return 1.0 / (self.resistance_max_ohm - self.resistance_min_ohm)

    @cached_property
    def _constants(self) -> FloatArray:
        """The array that compiled code reads."""
        numbers = self.numbers
        return np.concatenate([[numbers[name] for name in CURVE_NUMBERS], self.coefficients_in_turns])

    @overload
    def estimate(self, resistance_ohm: float, resistance_std_ohm: float | None = ...) -> CurveEstimate: ...
    @overload
    def estimate(self, resistance_ohm: FloatArray, resistance_std_ohm: float | None = ...) -> ArrayEstimate: ...
    def estimate(
        self, resistance_ohm: float | FloatArray, resistance_std_ohm: float | None = None
    ) -> CurveEstimate | ArrayEstimate:
        """Estimate the quantity from one resistance or from an array.

        The value is g_a (Eq. 5) with the resistance clipped to the valid range. The standard deviation adds
        in squares: half the distance of the branches, the branches' residual, the resistance noise times
        the slope, to which a resistance beyond the valid range adds its distance, and what a curve without an
        instrument may be off by as a whole (``scale_std``, ``offset_std``); it is at most the whole range.

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm], a number or an array of any shape.
        resistance_std_ohm
            Its standard deviation [ohm]; that of the recording the model was fitted to if None.

        Returns
        -------
        Value, standard deviation, and validity: False if the resistance is outside the valid range by more than 2 % of
        the span, or not finite. A resistance that is not finite reads as fully contracted, as does the 0.0 ohm of "no
        current": a loop that ignores validity then cools.
        """
        noise_ohm = self.resistance_noise_ohm if resistance_std_ohm is None else resistance_std_ohm
        value = np.array(resistance_ohm, dtype=np.float64, order="C")
        std, valid = np.empty(value.shape), np.empty(value.shape, dtype=np.bool_)
        curve_estimates(self._constants, noise_ohm, value.reshape(-1), std.reshape(-1), valid.reshape(-1))
        if isinstance(resistance_ohm, (float, int)):
            return CurveEstimate(value.item(), std.item(), valid.item())
        return ArrayEstimate(value, std, valid)

    @overload
    def value(self, resistance_ohm: float) -> float: ...
    @overload
    def value(self, resistance_ohm: FloatArray) -> FloatArray: ...
    def value(self, resistance_ohm: float | FloatArray) -> float | FloatArray:
        """Return the quantity of this model, g_a of the clipped resistance (Eq. 5).

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm], a number or an array of any shape.

        Returns
        -------
        The quantity, in the same shape: strain as a fraction, displacement [m] or force [N].

        Warns
        -----
        UserWarning
            If a resistance cannot be this wire's: it reads as the nearest end of the range.
        """
        return self._branch_value(self.average_coefficients, resistance_ohm)

    @overload
    def strain(self, resistance_ohm: float) -> float: ...
    @overload
    def strain(self, resistance_ohm: FloatArray) -> FloatArray: ...
    def strain(self, resistance_ohm: float | FloatArray) -> float | FloatArray:
        """Return the strain, g_a of the clipped resistance (Eq. 5).

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm], a number or an array of any shape.

        Returns
        -------
        The strain as a fraction, contraction positive, in the same shape.

        Raises
        ------
        CallerError
            If the model is one of displacement or force: there use :meth:`value`.

        Warns
        -----
        UserWarning
            If a resistance cannot be this wire's: it reads as the nearest end of the range.
        """
        self._check_strain()
        return self._branch_value(self.average_coefficients, resistance_ohm)

    @overload
    def strain_heating(self, resistance_ohm: float) -> float: ...
    @overload
    def strain_heating(self, resistance_ohm: FloatArray) -> FloatArray: ...
    def strain_heating(self, resistance_ohm: float | FloatArray) -> float | FloatArray:
        """Return the strain on the heating branch, g_h (Eq. 4).

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm], a number or an array of any shape.

        Returns
        -------
        As :meth:`strain`.
        """
        self._check_strain()
        return self._branch_value(self.heating_coefficients, resistance_ohm)

    @overload
    def strain_cooling(self, resistance_ohm: float) -> float: ...
    @overload
    def strain_cooling(self, resistance_ohm: FloatArray) -> FloatArray: ...
    def strain_cooling(self, resistance_ohm: float | FloatArray) -> float | FloatArray:
        """Return the strain on the cooling branch, g_c (Eq. 4).

        Parameters
        ----------
        resistance_ohm
            Resistance [ohm], a number or an array of any shape.

        Returns
        -------
        As :meth:`strain`.
        """
        self._check_strain()
        return self._branch_value(self.cooling_coefficients, resistance_ohm)

    @overload
    def resistance_ohm(self, strain: float) -> float: ...
    @overload
    def resistance_ohm(self, strain: FloatArray) -> FloatArray: ...
    def resistance_ohm(self, strain: float | FloatArray) -> float | FloatArray:
        """Return the resistance that a strain (or displacement, force) requires: the inverse of g_a.

        Parameters
        ----------
        strain
            The quantity, a number or an array of any shape: strain as a fraction, displacement [m] or force [N]. A
            value within 0.5 % of the range beyond either end gives that end.

        Returns
        -------
        The resistance [ohm], in the same shape.

        Raises
        ------
        CallerError
            If a value is further outside; the message states the range.

        References
        ----------
        Lan and Fan 2010, Table 2, second row.
        """
        wanted = np.asarray(strain, dtype=np.float64)
        room = QUANTITY_MARGIN * (self.quantity_max - self.quantity_min)
        outside = ~((wanted >= self.quantity_min - room) & (wanted <= self.quantity_max + room))
        if outside.any():
            factor, unit = SHOWN_AS[self.quantity]
            raise CallerError(
                f"{self.quantity} {factor * float(wanted[outside].flat[0]):.4g} {unit} is outside the model's valid "
                f"range {factor * self.quantity_min:.4g} to {factor * self.quantity_max:.4g} {unit}: "
                "choose a value within, or fit a loop that reaches further"
            )
        fraction = self._inverse(np.clip(wanted, self.quantity_min, self.quantity_max))
        span = self.resistance_max_ohm - self.resistance_min_ohm
        result = self.resistance_min_ohm + fraction * span
        return float(result) if result.ndim == 0 else result

    def _inverse(self, wanted: FloatArray) -> FloatArray:
        """Return the normalised resistance of each quantity by Newton's method, with bisection if a step fails."""
        low = np.full(wanted.shape, self.normalised_min)
        high = np.full(wanted.shape, self.normalised_max)
        slope_of = derivative(self.average_coefficients)
        fraction = (low + high) / 2.0
        for _ in range(80):
            excess = evaluate(self.average_coefficients, fraction) - wanted
            # g_a falls: too large a quantity means the resistance is too low.
            low = np.where(excess >= 0.0, fraction, low)
            high = np.where(excess <= 0.0, fraction, high)
            slope = evaluate(slope_of, fraction)
            newton = fraction - excess / np.where(slope < 0.0, slope, -inf)
            middle = (low + high) / 2.0
            following = np.where((newton > low) & (newton < high) & (slope < 0.0), newton, middle)
            if np.all((np.abs(following - fraction) <= 1e-15) | (high - low <= 1e-15)):
                return cast(FloatArray, following)
            fraction = following
        return cast(FloatArray, fraction)

    def _branch_value(self, coefficients: tuple[float, ...], resistance_ohm: float | FloatArray) -> float | FloatArray:
        """Return a polynomial of the clipped normalised resistance, at its lower end if that is not finite."""
        low, high = self.normalised_min, self.normalised_max
        self._warn_of_other_wires(resistance_ohm)
        with np.errstate(over="ignore"):
            fraction = (np.asarray(resistance_ohm, dtype=np.float64) - self.resistance_min_ohm) * self._per_ohm
        value = evaluate(coefficients, np.clip(np.where(np.isfinite(fraction), fraction, low), low, high))
        return float(value) if np.ndim(resistance_ohm) == 0 else value

    def _warn_of_other_wires(self, resistance_ohm: float | FloatArray) -> None:
        """Warn of resistances that are no readings of this wire, and read as an end of its range all the same."""
        readings = np.asarray(resistance_ohm)
        others = readings[other_wires(self, readings)]
        if not others.size:
            return
        low, high = self.valid_resistance_ohm
        many = "" if readings.size == 1 else f"{others.size} of {readings.size} readings, the first "
        warnings.warn(
            f"{many}{float(others.flat[0]):.4g} ohm, outside the {low:.4g} to {high:.4g} ohm that this model senses: "
            "read as the nearest end; is it the model's wire? estimate() says which readings are valid",
            stacklevel=4,
        )

    def _check_strain(self) -> None:
        """Raise CallerError for a model of another quantity than strain."""
        if self.quantity != "strain":
            raise CallerError(f"this is a model of {self.quantity}, not of strain: use value() or estimate()")


def other_wires(curve: ResistanceCurve, resistance_ohm: FloatArray) -> npt.NDArray[np.bool_]:
    """Return which resistances are no reading of a curve's wire; what is not finite is no reading at all."""
    low, high = curve.own_resistance_ohm
    return np.isfinite(resistance_ohm) & ((resistance_ohm < low) | (resistance_ohm > high))


def require_in_range(numbers: Sequence[float]) -> None:
    """Raise CallerError unless each number is from 0 to ``MAX_NUMBER``."""
    if not all(0.0 <= number <= MAX_NUMBER for number in numbers):
        raise CallerError(
            f"gap, root mean square errors, noise and samples of a model must be from 0 to {MAX_NUMBER:g}, not "
            f"{list(numbers)}"
        )
