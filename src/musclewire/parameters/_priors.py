"""Priors: the knowledge of a wire's parameters before any measurement, of any wire or of a named one."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import nearest_hint
from musclewire.parameters._parameter_groups import Alloy, Bench, Wire
from musclewire.parameters._validation import load_named

SCHEMAS: dict[str, type[Alloy] | type[Wire] | type[Bench]] = {"alloy": Alloy, "wire": Wire, "bench": Bench}


class Prior(BaseModel):
    """A normal distribution truncated at bounds, in SI.

    Parameters
    ----------
    group
        The group of the parameter: alloy, wire or bench.
    mean
        Mean of the distribution.
    std
        Its standard deviation, above 0.
    low
        Lower bound, below the mean.
    high
        Upper bound, above the mean.
    unit
        Unit of the four numbers, the one that the parameter has in its schema.
    source
        Source of the numbers.
    measure
        The experiment that makes the parameter identifiable.
    starts
        Values from which a search begins, one after the other, where what it looks for has valleys apart; empty if the
        mean and draws around it will do.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    group: Literal["alloy", "wire", "bench"]
    mean: float = Field(allow_inf_nan=False)
    std: float = Field(gt=0.0, allow_inf_nan=False)
    low: float = Field(allow_inf_nan=False)
    high: float = Field(allow_inf_nan=False)
    unit: str
    source: str = Field(min_length=3)
    measure: str
    starts: tuple[float, ...] = ()

    @model_validator(mode="after")
    def _mean_and_starts_lie_between_the_bounds(self) -> Prior:
        for name, value in (("mean", self.mean), *(("start", start) for start in self.starts)):
            if not self.low < value < self.high:
                raise ValueError(f"{name} {value:g} must lie between low {self.low:g} and high {self.high:g}")
        return self


class PriorSet(BaseModel):
    """Priors by parameter name; what has none stays at the value of the wire, alloy or bench it starts from.

    Parameters
    ----------
    name
        Name of the set.
    description
        What the set is for, in a sentence.
    parameters
        A prior for each parameter, by the parameter's name.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    description: str
    parameters: dict[str, Prior]

    @model_validator(mode="after")
    def _names_and_units_are_those_of_the_groups(self) -> PriorSet:
        for name, prior in self.parameters.items():
            fields = SCHEMAS[prior.group].model_fields
            if name not in fields:
                article = "an" if prior.group == "alloy" else "a"
                raise ValueError(f"'{name}' is no parameter of {article} {prior.group}{nearest_hint(name, fields)}")
            extra = fields[name].json_schema_extra
            unit = extra["unit"] if isinstance(extra, dict) else ""
            if unit != prior.unit:
                raise ValueError(f"{name} has the unit '{prior.unit}', it must be given in '{unit}'")
        return self


def load_priors(name: str = "niti-wire") -> PriorSet:
    """Return a set of priors.

    Parameters
    ----------
    name
        Name of a set that ships with musclewire, or path of a TOML file; by default that of NiTi wires.

    Returns
    -------
    The priors, checked.

    Raises
    ------
    CallerError
        For an unknown name, or a file that cannot be read or breaks the schema.
    """
    return load_named(PriorSet, "priors", "set of priors", name)


Kind = Literal["alloy", "wire", "bench"]
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
            fields = SCHEMAS[spread.group].model_fields
            if name not in fields:
                raise ValueError(f"'{name}' is no parameter of the {spread.group}{nearest_hint(name, fields)}")
        return self


def load_spreads(name: str = "named-wire") -> WireSpreads:
    """Return spreads that ship with musclewire, or those of a TOML file. Raises CallerError for a wrong file."""
    return load_named(WireSpreads, "spreads", "set of spreads", name)


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
