"""Distributions of a parameter by name: the usual ones by the numbers that people know, and those of scipy.stats."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, nearest_hint


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
    """Return the quantile function of a distribution.

    Parameters
    ----------
    where
        Beginning of messages, as "parameters.pretension_n".
    spacing
        "linear" or "log": which distribution low and high alone mean, uniform or log-uniform.
    given
        The keys of the parameter's table, numbers in SI.

    Returns
    -------
    A function from cumulative probabilities to values, both (n,).

    Raises
    ------
    CallerError
        For an unknown distribution, for keys that it lacks or does not know, and for numbers that make none.
    """
    name = given.get("distribution", "log-uniform" if spacing == "log" else "uniform")
    numbers = {key: value for key, value in given.items() if key != "distribution"}
    frozen = usual(where, name, numbers) if name in USUAL else of_scipy(where, name, numbers)
    # Outside of what a distribution allows, scipy returns NaN and raises nothing.
    if not np.isfinite(frozen.ppf([0.25, 0.5, 0.75])).all():
        raise CallerError(f"{where}: {numbers} make no distribution '{name}': see scipy.stats")
    return lambda probability: np.asarray(frozen.ppf(probability), dtype=np.float64)


def usual(where: str, name: str, numbers: Mapping[str, Any]) -> Any:
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
