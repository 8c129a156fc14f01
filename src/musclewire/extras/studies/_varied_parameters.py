"""What varies in a study: tables ``[parameters.NAME]`` of its file, as axes of a grid or as distributions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint
from musclewire.extras.studies._distributions import quantile_function
from musclewire.parameters import load_priors
from musclewire.signals import parse_quantity

Value = float | str | bool
Quantity = float | str
# Keys of a distribution that have the parameter's unit, and of these the differences, for which a zero is no matter.
WITH_UNIT = ("low", "high", "mean", "median", "mode", "loc", "std", "scale")
DIFFERENCES = ("std", "scale")
# Spacings whose zero is arbitrary: a difference cannot be given in them.
ARBITRARY_ZERO = ("degC", "degF", "°C", "°F", "celsius", "fahrenheit")


class ParameterTable(BaseModel):
    """A table ``[parameters.NAME]``: values, points of a range, or a distribution; in SI, or as text with a unit.

    Parameters
    ----------
    values
        The values of an axis of the grid: numbers, or names for ``wire`` and ``bench``.
    low
        Lower end of a range.
    high
        Upper end of a range.
    points
        Points of the range: an axis of the grid. Without it the range is a uniform distribution.
    spacing
        "linear" or "log": how the points, or the distribution between low and high, are spread.
    distribution
        "uniform", "normal", "log-normal", "triangular", or the name of any continuous distribution of scipy.stats.
    mean
        Mean of the normal distribution; between low and high, if these are given.
    std
        Its standard deviation.
    median
        Median of the log-normal distribution.
    factor
        Standard deviation of the log-normal distribution as a factor: two thirds lie within median / factor and
        median * factor.
    mode
        Most likely value of the triangular distribution.
    loc
        Location of a distribution of scipy.stats.
    scale
        Its scale.
    shape
        Its shape parameters by name.
    prior
        Name or file of a set of priors that has the parameter: its distribution is taken.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    values: list[float | str | bool] | None = Field(default=None, min_length=1)
    low: Quantity | None = None
    high: Quantity | None = None
    points: int | None = Field(default=None, ge=2)
    spacing: Literal["linear", "log"] = "linear"
    distribution: str | None = None
    mean: Quantity | None = None
    std: Quantity | None = None
    median: Quantity | None = None
    factor: float | None = Field(default=None, gt=1.0)
    mode: Quantity | None = None
    loc: Quantity | None = None
    scale: Quantity | None = None
    shape: dict[str, float] = Field(default_factory=dict)
    prior: str | None = None


class GridAxis(NamedTuple):
    """A parameter that takes each of some values: an axis of the grid."""

    name: str
    unit: str
    values: tuple[Value, ...]


class SampledParameter(NamedTuple):
    """A parameter that is drawn: ``quantile`` takes cumulative probabilities, (n,), to its values."""

    name: str
    unit: str
    quantile: Callable[[FloatArray], FloatArray]


def resolved(name: str, unit: str, table: ParameterTable) -> GridAxis | SampledParameter:
    """Return a parameter of a study.

    Parameters
    ----------
    name
        Its name.
    unit
        Its SI unit; "" if it has none, as a name.
    table
        Its table in the study's file.

    Returns
    -------
    An axis of the grid, or a distribution.

    Raises
    ------
    CallerError
        For keys that do not belong together, and for numbers in another unit.
    """
    where = f"parameters.{name}"
    given = {key: value for key, value in table if value not in (None, {}) and key != "spacing"}
    if table.values is not None:
        require_only(where, given, "values", ("values",))
        return GridAxis(name, unit, tuple(axis_value(where, unit, value) for value in table.values))
    if not unit:
        raise CallerError(f"{where}: a parameter without a unit takes 'values' only, a list")
    if table.prior is not None:
        require_only(where, given, "prior", ("prior",))
        return SampledParameter(name, unit, prior_of(name, table.prior, where))
    numbers = {key: in_si(f"{where}.{key}", unit, given[key], key in DIFFERENCES) for key in WITH_UNIT if key in given}
    if table.points is not None:
        require_only(where, given, "points", ("low", "high", "points"))
        return GridAxis(name, unit, points_between(where, numbers, table.points, table.spacing))
    known = {key: given[key] for key in given if key not in WITH_UNIT}
    return SampledParameter(name, unit, quantile_function(where, table.spacing, {**known, **numbers}))


def require_only(where: str, given: Mapping[str, Any], what: str, known: tuple[str, ...]) -> None:
    """Raise CallerError for a key that does not belong to the others."""
    for key in given:
        if key not in known:
            raise CallerError(f"{where}: '{key}' does not belong to '{what}': leave one of them out")


def axis_value(where: str, unit: str, value: Value) -> Value:
    """Return a value of an axis, in SI if it has a unit."""
    return in_si(f"{where}.values", unit, value) if unit else value


def in_si(where: str, unit: str, given: Value, difference: bool = False) -> float:
    """Return a number in SI from one in SI or text with a unit. Raises CallerError for anything else."""
    if isinstance(given, bool):
        raise CallerError(f"{where}: must be a number in SI or text with a unit, not {str(given).lower()}")
    if isinstance(given, str):
        if difference and given.rstrip().endswith(ARBITRARY_ZERO):
            raise CallerError(f"{where}: '{given}': a difference of temperatures is needed, like '3 K'")
        try:
            return parse_quantity(given, "" if unit == "1" else unit)
        except CallerError as error:
            raise CallerError(f"{where}: {error}") from None
    if not math.isfinite(given):
        raise CallerError(f"{where}: must be a finite number, not {given}")
    return float(given)


def points_between(where: str, ends: Mapping[str, float], points: int, spacing: str) -> tuple[float, ...]:
    """Return evenly spaced points of a range, both ends included. Raises CallerError without two ends in order."""
    if not {"low", "high"} <= set(ends) or not ends["low"] < ends["high"]:
        raise CallerError(f"{where}: 'points' needs 'low' and 'high', the first below the second")
    if spacing == "linear":
        return tuple(np.linspace(ends["low"], ends["high"], points).tolist())
    if not ends["low"] > 0.0:
        raise CallerError(f"{where}: a logarithmic spacing needs 'low' above 0")
    return tuple(np.geomspace(ends["low"], ends["high"], points).tolist())


def prior_of(name: str, priors: str, where: str) -> Callable[[FloatArray], FloatArray]:
    """Return the quantiles of a parameter's prior. Raises CallerError if the set has none for it."""
    known = load_priors(priors).parameters
    if name not in known:
        raise CallerError(f"{where}: the priors '{priors}' have none for {name}{nearest_hint(name, known)}")
    prior = known[name]
    numbers = {"mean": prior.mean, "std": prior.std, "low": prior.low, "high": prior.high}
    return quantile_function(where, "linear", {"distribution": "normal", **numbers})
