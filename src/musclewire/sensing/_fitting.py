"""Fit a self-sensing model to one loop, or to two branches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import pairwise
from math import sqrt
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, FitRejectedError, RecordingError, argument, nearest_hint
from musclewire.sensing._branch_equations import average, check_resistance_range, evaluate, normalised_resistance
from musclewire.sensing._branches import Branch, checked_branch, single_valued
from musclewire.sensing._curve import QUANTITY_UNITS, SHOWN_AS
from musclewire.sensing._gaps import hysteresis_gap
from musclewire.sensing._model import SensingModel
from musclewire.sensing._polynomial_fit import (
    FitPoints,
    PolynomialFit,
    check_order,
    choose_order,
    fit_points,
    fit_polynomial,
)
from musclewire.sensing._segments import LoopSegments, find_segments
from musclewire.signals import MAX_STRAIN

AnyBranch = tuple[npt.ArrayLike, npt.ArrayLike]

# g_a must fall over at least this fraction of the range of the data to serve as a sensor.
MIN_FALLING_FRACTION = 0.6
LARGE_GAP = 0.05
# Segment A-B usually takes 5 to 25 % of the stroke. Less does no harm: the simulated finger even moves back by one
# percent before it bends.
LARGE_COLD_FRACTION = 0.25
# A cold strain of more than this fraction of the stroke means that the sensor was not zeroed.
UNZEROED_FRACTION = 0.05
KEPT_SAMPLES = 200
RMSE_SLICES = 100


class HotEnd(NamedTuple):
    """What is known of a loop's hottest point besides its resistance and strain."""

    # The fall of the resistance over power has levelled off there, which is C as much as a rise is.
    levelled: bool = False
    more_drive: str = "raise the amplitude if more drive adds stroke and the wire's temperature and stress permit"


UNKNOWN_HOT_END = HotEnd()


def fit_loop(
    resistance_ohm: npt.ArrayLike,
    strain: npt.ArrayLike,
    valid: npt.ArrayLike | None = None,
    order: int | str = 6,
    cycle: str | int = "last",
    quantity: str = "strain",
    wire: Mapping[str, str | float] | None = None,
    source: str = "",
    hot_end: HotEnd = UNKNOWN_HOT_END,
) -> SensingModel:
    """Fit a model to one loop of a recording: find A, B, C (Fig. 3b), fit B to C on both branches (Eqs. 3 to 5).

    The columns have shape (n_times,), contraction is positive. ``order`` is a number, the paper's is 6, or "auto" for
    cross-validation; ``cycle`` as in :func:`find_segments`. Raises RecordingError for no usable loop or too few points,
    FitRejectedError if the average polynomial cannot be inverted, CallerError for wrong arguments.

    References
    ----------
    Lan and Fan 2010, Fig. 3(b) and Eqs. 3 to 5.
    """
    _check_arguments(order, quantity)
    segments = find_segments(resistance_ohm, strain, valid, cycle, quantity)
    return fit_segments(segments, order, quantity, wire, source, hot_end)


def fit_segments(
    segments: LoopSegments,
    order: int | str = 6,
    quantity: str = "strain",
    wire: Mapping[str, str | float] | None = None,
    source: str = "",
    hot_end: HotEnd = UNKNOWN_HOT_END,
) -> SensingModel:
    """Fit a model to a loop whose points A, B, C are known; arguments as in :func:`fit_loop`, and raises as it does."""
    model = fit_branches(
        segments.heating,
        segments.cooling,
        order,
        resistance_min_ohm=segments.resistance_min_ohm,
        resistance_max_ohm=segments.resistance_max_ohm,
        quantity=quantity,
        wire=wire,
        source=source,
    )
    warnings = (*model.warnings, *_loop_warnings(segments, quantity, hot_end))
    return replace(
        model,
        warnings=warnings,
        resistance_noise_ohm=segments.resistance_noise_ohm,
        measured_stroke=segments.strain_max - segments.strain_cold,
    )


def fit_branches(
    heating: AnyBranch,
    cooling: AnyBranch,
    order: int | str = 6,
    *,
    resistance_min_ohm: float | None = None,
    resistance_max_ohm: float | None = None,
    quantity: str = "strain",
    wire: Mapping[str, str | float] | None = None,
    source: str = "",
) -> SensingModel:
    """Fit a model to the heating and the cooling branch of segment B-C, each in either direction.

    Fits run over the normalised resistances in [0, 1] that both branches have, weighted evenly over resistance (see
    ``fit_points``), and the model is valid where the average falls there. Give R_min and R_max if the branches do not
    reach C and B (a printed table). Raises the errors of :func:`fit_loop`.

    References
    ----------
    Lan and Fan 2010, Eqs. 3 to 5.
    """
    _check_arguments(order, quantity)
    raw = checked_branch(heating, "heating"), checked_branch(cooling, "cooling")
    _check_units(raw, quantity)
    curves = single_valued(raw[0], "heating"), single_valued(raw[1], "cooling")
    low_ohm = float(curves[0].resistance_ohm[0]) if resistance_min_ohm is None else resistance_min_ohm
    high_ohm = float(curves[0].resistance_ohm[-1]) if resistance_max_ohm is None else resistance_max_ohm
    check_resistance_range(low_ohm, high_ohm)
    shared = _shared_range(curves, low_ohm, high_ohm)
    points = [_points_within(fit_points(curve, low_ohm, high_ohm), shared) for curve in curves]
    _check_counts(points)
    chosen = choose_order(points) if isinstance(order, str) else order
    fits = [fit_polynomial(p, chosen, name) for p, name in zip(points, ("heating", "cooling"), strict=True)]
    valid_range = _falling_range(average(fits[0].coefficients, fits[1].coefficients), shared)
    samples = [_samples(branch, low_ohm, high_ohm, shared) for branch in raw]
    gap = hysteresis_gap(*raw)
    return SensingModel(
        resistance_min_ohm=low_ohm,
        resistance_max_ohm=high_ohm,
        heating_coefficients=fits[0].coefficients,
        cooling_coefficients=fits[1].coefficients,
        normalised_min=valid_range[0],
        normalised_max=valid_range[1],
        quantity=quantity,
        hysteresis_gap=gap,
        **_residuals(fits, samples),  # type: ignore[arg-type]  # errors by name, all floats
        samples=sum(resistance.size for resistance, _ in samples),
        heating_standard_errors=fits[0].standard_errors,
        cooling_standard_errors=fits[1].standard_errors,
        warnings=_fit_warnings(gap, fits, shared, valid_range),
        wire=dict(wire or {}),
        created_by=_created_by(),
        source=source,
        heating_samples=_thinned(curves[0]),
        cooling_samples=_thinned(curves[1]),
    )


def _check_arguments(order: int | str, quantity: str) -> None:
    """Raise CallerError for an unknown order or quantity."""
    if isinstance(order, str) and order != "auto":
        raise CallerError(f"polynomial order is {order!r}: use a whole number or 'auto'")
    if not isinstance(order, str):
        check_order(order)
    if quantity not in QUANTITY_UNITS:
        raise CallerError(f"quantity {quantity!r} is unknown{nearest_hint(str(quantity), QUANTITY_UNITS)}")


def _check_units(branches: tuple[Branch, Branch], quantity: str) -> None:
    """Raise RecordingError for a strain that no wire has, as one in percent."""
    largest = max(float(branch.quantity.max()) for branch in branches)
    if quantity == "strain" and largest > MAX_STRAIN:
        raise RecordingError(
            f"strain reaches {largest:.3g}: strain is a fraction (0.035 is 3.5 %), divide percent by 100, "
            "or take off what it reads cold (" + argument("zero", True) + "), "
            "or name the quantity if this is displacement or force"
        )


def _shared_range(curves: tuple[Branch, Branch], low_ohm: float, high_ohm: float) -> tuple[float, float]:
    """Return the ends of the normalised resistances within [0, 1] that both branches reach."""
    ends = [normalised_resistance(curve.resistance_ohm[[0, -1]], low_ohm, high_ohm) for curve in curves]
    low = max(0.0, *(float(end[0]) for end in ends))
    high = min(1.0, *(float(end[1]) for end in ends))
    if not high > low:
        raise RecordingError(
            f"the branches share no resistance between {low_ohm:.4f} and {high_ohm:.4f} ohm: "
            "check that both come from one loop and that R_min and R_max are theirs"
        )
    return low, high


def _points_within(points: FitPoints, shared: tuple[float, float]) -> FitPoints:
    """Return the points in the range of both branches; a rounding error does not lose the end point."""
    inside = (points.normalised_resistance >= shared[0] - 1e-9) & (points.normalised_resistance <= shared[1] + 1e-9)
    return FitPoints(points.normalised_resistance[inside], points.quantity[inside], points.weights[inside])


def _check_counts(points: list[FitPoints]) -> None:
    """Raise RecordingError if a branch has fewer than two points in the range of both."""
    for name, branch in zip(("heating", "cooling"), points, strict=True):
        if branch.quantity.size < 2:
            raise RecordingError(
                f"the {name} branch has {branch.quantity.size} points in the range of both branches: "
                "at least 2 are needed, sample faster"
            )


def _falling_range(coefficients: tuple[float, ...], shared: tuple[float, float]) -> tuple[float, float]:
    """Return the longest part of the common range over which the average falls; FitRejectedError if it is short."""
    derivative = np.polynomial.Polynomial(coefficients).deriv()
    roots = derivative.roots()
    turns = roots[np.abs(roots.imag) < 1e-9].real
    low, high = shared
    edges = [low, *sorted(float(turn) for turn in turns if low < turn < high), high]
    stretches: list[tuple[float, float]] = []
    for begin, end in pairwise(edges):
        if derivative((begin + end) / 2.0) >= 0.0:
            continue
        joined = bool(stretches) and stretches[-1][1] == begin
        stretches.append((stretches.pop()[0], end) if joined else (begin, end))
    longest = max(stretches, key=lambda stretch: stretch[1] - stretch[0], default=(low, low))
    falling = (longest[1] - longest[0]) / (high - low)
    if falling < MIN_FALLING_FRACTION:
        raise FitRejectedError(
            f"the average polynomial of order {len(coefficients) - 1} falls over only {100 * falling:.0f} % of "
            f"the data ({100 * MIN_FALLING_FRACTION:.0f} % needed), so it cannot be inverted: lower the "
            "order, or check that contraction is positive"
        )
    return longest


def _samples(
    branch: Branch, low_ohm: float, high_ohm: float, shared: tuple[float, float]
) -> tuple[FloatArray, FloatArray]:
    """Return measured normalised resistance and quantity in the range of both branches."""
    normalised = normalised_resistance(branch.resistance_ohm, low_ohm, high_ohm)
    inside = (normalised >= shared[0] - 1e-9) & (normalised <= shared[1] + 1e-9)
    return normalised[inside], branch.quantity[inside]


def _residuals(fits: list[PolynomialFit], samples: list[tuple[FloatArray, FloatArray]]) -> dict[str, float]:
    """Return the root mean square errors of each branch, and of the average against both."""
    mean = average(fits[0].coefficients, fits[1].coefficients)
    own = [_mean_square(fit.coefficients, *pair) for fit, pair in zip(fits, samples, strict=True)]
    both = [_mean_square(mean, *pair) for pair in samples]
    return {
        "rmse_heating": sqrt(own[0]),
        "rmse_cooling": sqrt(own[1]),
        "rmse_average": sqrt((both[0] + both[1]) / 2.0),
    }


def _mean_square(coefficients: tuple[float, ...], normalised: FloatArray, quantity: FloatArray) -> float:
    """Return the mean of the mean square errors in slices of resistance, so that a dwell counts once."""
    squares = (quantity - evaluate(coefficients, normalised)) ** 2
    slices = np.clip(np.floor(normalised * RMSE_SLICES), 0, RMSE_SLICES).astype(np.intp)
    counts = np.bincount(slices, minlength=RMSE_SLICES + 1)
    sums = np.bincount(slices, weights=squares, minlength=RMSE_SLICES + 1)
    return float(np.mean(sums[counts > 0] / counts[counts > 0])) if normalised.size else 0.0


def _fit_warnings(
    gap: float, fits: list[PolynomialFit], shared: tuple[float, float], valid_range: tuple[float, float]
) -> tuple[str, ...]:
    warnings = []
    if gap > LARGE_GAP:
        warnings.append(
            f"the gap between heating and cooling is {100 * gap:.1f} %, above {100 * LARGE_GAP:.0f} %: "
            "their average is off by half of it; the estimator 'filter', the closed loop's, follows each branch, and "
            "'musclewire pretension' shows whether a pretension within the wire's stress has a smaller gap"
        )
    if valid_range != shared:
        lost = 1.0 - (valid_range[1] - valid_range[0]) / (shared[1] - shared[0])
        warnings.append(
            f"the average polynomial turns back near an end: {100 * lost:.1f} % of the resistance range is left out; "
            "a lower order may keep it"
        )
    if min(fit.spare_points for fit in fits) == 0:
        warnings.append(
            "the polynomial passes through every point: its residuals and standard errors are meaningless: lower the "
            "order"
        )
    return tuple(warnings)


def _loop_warnings(segments: LoopSegments, quantity: str, hot_end: HotEnd) -> tuple[str, ...]:
    warnings = []
    factor, unit = SHOWN_AS[quantity]
    stroke = segments.strain_max - segments.strain_cold
    cold_fraction = 1.0 - segments.transformation_fraction
    at_b = segments.strain_cold + cold_fraction * stroke
    if not segments.returns_cold:
        warnings.append(
            "the loop does not return to cold: B is its turning point, resistances above it are unknown; let it cool "
            "longer"
        )
    elif cold_fraction > LARGE_COLD_FRACTION:
        warnings.append(
            f"segment A-B takes {100 * cold_fraction:.1f} % of the stroke (usually 5 to 25 %): {quantity} below "
            f"{factor * at_b:.3g} {unit} cannot be determined from resistance"
        )
    if not segments.complete and not hot_end.levelled:
        warnings.append(
            "the transformation is not complete (the resistance still falls at the hottest point): "
            f"{quantity} above {factor * segments.strain_max:.3g} {unit} is unknown; {hot_end.more_drive}"
        )
    if segments.returns_cold and abs(segments.strain_cold) > UNZEROED_FRACTION * stroke:
        warnings.append(f"{quantity} at cold is {factor * segments.strain_cold:.3g} {unit}, not zero: zero the sensor")
    return tuple(warnings)


def _thinned(curve: Branch) -> tuple[tuple[float, float], ...]:
    """Return at most 200 points of a branch, for plots, to seven digits."""
    count = curve.resistance_ohm.size
    keep = np.unique(np.linspace(0, count - 1, min(count, KEPT_SAMPLES)).round().astype(np.intp))
    pairs = zip(curve.resistance_ohm[keep].tolist(), curve.quantity[keep].tolist(), strict=True)
    return tuple((float(f"{r:.7g}"), float(f"{q:.7g}")) for r, q in pairs)


def _created_by() -> str:
    """Return program and version."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return f"musclewire {version('musclewire')}"
    except PackageNotFoundError:
        return "musclewire"
