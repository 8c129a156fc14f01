"""What varies in a study: tables ``[parameters.NAME]`` of its file, as axes of a grid or as distributions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters import load_priors
from musclewire.signals import parse_quantity


class DistributionFamily(NamedTuple):
    """A usual distribution: the keys that it needs, those that it may have, and how scipy.stats makes it."""

    needs: tuple[str, ...]
    may_have: tuple[str, ...]
    frozen: Callable[[Mapping[str, Any]], Any]


def uniform(keys: Mapping[str, Any]) -> Any:
    """Return a uniform distribution between two ends."""
    from scipy import stats

    return stats.uniform(keys["low"], keys["high"] - keys["low"])


def log_uniform(keys: Mapping[str, Any]) -> Any:
    """Return a distribution whose logarithm is uniform between those of two ends."""
    from scipy import stats

    return stats.loguniform(keys["low"], keys["high"])


def normal(keys: Mapping[str, Any]) -> Any:
    """Return a normal distribution, truncated at ends that are given."""
    from scipy import stats

    if "low" not in keys and "high" not in keys:
        return stats.norm(keys["mean"], keys["std"])
    low, high = ((keys.get(key, end) - keys["mean"]) / keys["std"] for key, end in (("low", -np.inf), ("high", np.inf)))
    return stats.truncnorm(low, high, keys["mean"], keys["std"])


def log_normal(keys: Mapping[str, Any]) -> Any:
    """Return a log-normal distribution."""
    from scipy import stats

    return stats.lognorm(np.log(keys["factor"]), scale=keys["median"])


def triangular(keys: Mapping[str, Any]) -> Any:
    """Return a triangular distribution between two ends."""
    from scipy import stats

    width = keys["high"] - keys["low"]
    return stats.triang((keys["mode"] - keys["low"]) / width, keys["low"], width)


USUAL: Mapping[str, DistributionFamily] = {
    "uniform": DistributionFamily(("low", "high"), (), uniform),
    "log-uniform": DistributionFamily(("low", "high"), (), log_uniform),
    "normal": DistributionFamily(("mean", "std"), ("low", "high"), normal),
    "log-normal": DistributionFamily(("median", "factor"), (), log_normal),
    "triangular": DistributionFamily(("low", "mode", "high"), (), triangular),
}


def quantile_function(where: str, spacing: str, given: Mapping[str, Any]) -> Callable[[FloatArray], FloatArray]:
    """Return the quantile function of a distribution; messages begin with ``where``, as "parameters.pretension_n".

    ``given`` are the keys of the parameter's table, in SI; ``spacing`` says what low and high alone mean, a uniform or
    a log-uniform one.
    """
    name = given.get("distribution", "log-uniform" if spacing == "log" else "uniform")
    numbers = {key: value for key, value in given.items() if key != "distribution"}
    frozen = usual_distribution(where, name, numbers) if name in USUAL else of_scipy(where, name, numbers)
    # Outside of what a distribution allows, scipy returns NaN and raises nothing.
    if not np.isfinite(frozen.ppf([0.25, 0.5, 0.75])).all():
        raise CallerError(f"{where}: {numbers} make no distribution '{name}': see scipy.stats")
    return lambda probability: np.asarray(frozen.ppf(probability), dtype=np.float64)


def usual_distribution(where: str, name: str, numbers: Mapping[str, Any]) -> Any:
    """Return a usual distribution. Raises CallerError for missing and unknown keys, and for ends out of order."""
    kind = USUAL[name]
    for key in numbers:
        if key not in (*kind.needs, *kind.may_have):
            raise CallerError(
                f"{where}: a distribution '{name}' has no '{key}'{nearest_hint(key, (*kind.needs, *kind.may_have))}"
            )
    for key in kind.needs:
        if key not in numbers:
            raise CallerError(f"{where}: a distribution '{name}' needs '{key}'")
    ends = [numbers[key] for key in ("low", "mode", "high") if key in numbers]
    if ends != sorted(ends) or ("low" in numbers and numbers["low"] == numbers.get("high")):
        raise CallerError(f"{where}: 'low' must be below 'high', and 'mode' between them, not {ends}")
    if numbers.get("std", 1.0) <= 0.0:
        raise CallerError(f"{where}: 'std' is {numbers['std']:g}: it must be above 0")
    if name.startswith("log-") and min(numbers.values()) <= 0.0:
        raise CallerError(f"{where}: a distribution '{name}' has numbers above 0 only, not {min(numbers.values()):g}")
    return kind.frozen(numbers)


def of_scipy(where: str, name: str, numbers: Mapping[str, Any]) -> Any:
    """Return a continuous distribution of scipy.stats. Raises CallerError for another name and unknown parameters."""
    from scipy import stats

    known = [key for key in dir(stats) if isinstance(getattr(stats, key), stats.rv_continuous)]
    if name not in known:
        raise CallerError(f"{where}: there is no distribution '{name}'{nearest_hint(name, [*USUAL, *known])}")
    distribution = getattr(stats, name)
    shapes = [] if distribution.shapes is None else [text.strip() for text in distribution.shapes.split(",")]
    given = dict(numbers)
    shape = given.pop("shape", {})
    for key in given:
        if key not in ("loc", "scale"):
            raise CallerError(f"{where}: '{name}' of scipy.stats takes loc, scale and shape, not '{key}'")
    if set(shape) != set(shapes):
        raise CallerError(
            f"{where}: '{name}' of scipy.stats needs shape = {{{', '.join(f'{s} = ...' for s in shapes)}}}"
        )
    return distribution(**shape, **given)


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


def parameter_of(name: str, unit: str, table: ParameterTable) -> GridAxis | SampledParameter:
    """Return a parameter, a grid axis or a distribution, from its table; its unit is "" for a name."""
    where = f"parameters.{name}"
    given = {key: value for key, value in table if value not in (None, {}) and key != "spacing"}
    if table.values is not None:
        require_only(where, given, "values", ("values",))
        values = [in_si(f"{where}.values", unit, value) if unit else value for value in table.values]
        return GridAxis(name, unit, tuple(values))
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
