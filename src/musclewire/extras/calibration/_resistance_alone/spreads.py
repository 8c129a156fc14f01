"""The knowledge of a named wire before any measurement: how far spools of a name differ, as priors around it."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import nearest_hint
from musclewire.parameters import Alloy, Bench, Prior, PriorSet, Wire, load_priors, validated

Kind = Literal["alloy", "wire", "bench"]
GROUPS: dict[Kind, type[Alloy] | type[Wire] | type[Bench]] = {"alloy": Alloy, "wire": Wire, "bench": Bench}
# A normal distribution is cut off at so many standard deviations.
CUT_OFF = 4.0


class Spread(BaseModel):
    """The standard deviation of one number of a wire or its bench: absolute, or as a fraction of the value."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    group: Kind
    std: float | None = Field(default=None, ge=0.0, allow_inf_nan=False)
    relative: float | None = Field(default=None, ge=0.0, lt=1.0)
    source: str = Field(min_length=3)

    @model_validator(mode="after")
    def _one_of_both(self) -> Spread:
        if (self.std is None) == (self.relative is None):
            raise ValueError("give std, in the parameter's unit, or relative, a fraction: one of both")
        return self

    def around(self, value: float) -> float:
        """Return the standard deviation around a value."""
        return self.std if self.std is not None else (self.relative or 0.0) * abs(value)


class WireSpreads(BaseModel):
    """Spreads by parameter name; an alloy's other parameters have a fraction of their prior's."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    description: str
    priors: str
    fraction_of_priors: float = Field(ge=0.0, le=1.0)
    spreads: dict[str, Spread]

    @model_validator(mode="after")
    def _names_are_those_of_the_groups(self) -> WireSpreads:
        for name, spread in self.spreads.items():
            fields = GROUPS[spread.group].model_fields
            if name not in fields:
                raise ValueError(f"'{name}' is no parameter of the {spread.group}{nearest_hint(name, fields)}")
        return self


@cache
def load_spreads() -> WireSpreads:
    """Return the spreads around a named wire."""
    text = (files("musclewire.extras.calibration._resistance_alone") / "named-wire.toml").read_text("utf-8")
    return validated(WireSpreads, tomllib.loads(text), "spreads around a named wire")


def priors_around(alloy: Alloy, wire: Wire, bench: Bench, spreads: WireSpreads) -> PriorSet:
    """Return priors whose means are the numbers of a wire, its alloy and its bench."""
    found = {}
    general = load_priors(spreads.priors).parameters
    groups: tuple[tuple[Kind, Alloy | Wire | Bench], ...] = (("alloy", alloy), ("wire", wire), ("bench", bench))
    for kind, group in groups:
        for name, item in group.items():
            prior, spread = general.get(name), spreads.spreads.get(name)
            if spread is not None:
                std, source = spread.around(item.value), spread.source
            elif kind == "alloy" and prior is not None:
                std, source = (
                    spreads.fraction_of_priors * prior.std,
                    f"{spreads.fraction_of_priors:g} of: {prior.source}",
                )
            else:
                continue
            if std > 0.0:
                low, high = limits(item.value, std, prior)
                found[name] = Prior(
                    group=kind, mean=item.value, std=std, low=low, high=high, unit=item.unit, source=source,
                    measure="" if prior is None else prior.measure,
                )  # fmt: skip
    return PriorSet(name=spreads.name, description=spreads.description, parameters=found)


def limits(value: float, std: float, prior: Prior | None) -> tuple[float, float]:
    """Return where a distribution is cut off: where the prior of any such wire is, if the value lies within that."""
    low, high = value - CUT_OFF * std, value + CUT_OFF * std
    if prior is not None and prior.low < value < prior.high:
        return max(low, prior.low), min(high, prior.high)
    return low, high
