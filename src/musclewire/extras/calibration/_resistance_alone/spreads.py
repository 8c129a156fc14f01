"""The knowledge of a named wire before any measurement: how far spools of a name differ, as priors around it."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Any, Literal

from musclewire.parameters import Alloy, Bench, Prior, PriorSet, Wire, load_priors

# Standard deviations at which a normal distribution is cut off.
CUT_OFF = 4.0


@cache
def spreads() -> dict[str, Any]:
    """Return what ``named-wire.toml`` says."""
    text = (files("musclewire.extras.calibration._resistance_alone") / "named-wire.toml").read_text("utf-8")
    return tomllib.loads(text)


def priors_around(alloy: Alloy, wire: Wire, bench: Bench) -> PriorSet:
    """Return priors whose means are the numbers of a wire, its alloy and its bench."""
    known, found = spreads(), {}
    general, fraction = load_priors(known["priors"]).parameters, known["fraction_of_priors"]
    groups: tuple[tuple[Literal["alloy", "wire", "bench"], Alloy | Wire | Bench], ...]
    groups = (("alloy", alloy), ("wire", wire), ("bench", bench))
    for kind, group in groups:
        for name, item in group.items():
            prior, spread = general.get(name), known["spreads"].get(name)
            if spread is not None:
                std = spread["std"] if "std" in spread else spread["relative"] * abs(item.value)
                source = spread["source"]
            elif kind == "alloy" and prior is not None:
                std, source = fraction * prior.std, f"{fraction:g} of: {prior.source}"
            else:
                continue
            if std > 0.0:
                low, high = limits(item.value, std, prior)
                found[name] = Prior(
                    group=kind, mean=item.value, std=std, low=low, high=high, unit=item.unit, source=source,
                    measure="" if prior is None else prior.measure,
                )  # fmt: skip
    return PriorSet(name=known["name"], description=known["description"], parameters=found)


def limits(value: float, std: float, prior: Prior | None) -> tuple[float, float]:
    """Return where a distribution is cut off: where the prior of any such wire is, if the value lies within that."""
    low, high = value - CUT_OFF * std, value + CUT_OFF * std
    if prior is not None and prior.low < value < prior.high:
        return max(low, prior.low), min(high, prior.high)
    return low, high
