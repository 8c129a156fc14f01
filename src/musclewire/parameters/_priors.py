"""Priors: the knowledge of a wire's parameters before any measurement."""

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
    """Return a set of priors that ships with musclewire, or that of a TOML file, checked."""
    return load_named(PriorSet, "priors", "set of priors", name)
