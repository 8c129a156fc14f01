"""Priors: the knowledge of a wire's parameters before any measurement."""

from __future__ import annotations

import tomllib
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import CallerError, nearest_hint
from musclewire.parameters._parameter_groups import Alloy, Bench, Wire
from musclewire.parameters._validation import validated

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

    @model_validator(mode="after")
    def _mean_lies_between_the_bounds(self) -> Prior:
        if not self.low < self.mean < self.high:
            raise ValueError(f"mean {self.mean:g} must lie between low {self.low:g} and high {self.high:g}")
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


def prior_set_names() -> list[str]:
    """Return the names of the prior sets that ship with musclewire."""
    folder = files("musclewire.parameters") / "data" / "priors"
    return sorted(item.name.removesuffix(".toml") for item in folder.iterdir() if item.name.endswith(".toml"))


@cache
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
    if name.endswith(".toml"):
        return validated(PriorSet, read_file(Path(name)), f"priors {name}")
    if name not in prior_set_names():
        raise CallerError(f"there are no priors called '{name}'{nearest_hint(name, prior_set_names())}")
    text = (files("musclewire.parameters") / "data" / "priors" / f"{name}.toml").read_text("utf-8")
    return validated(PriorSet, tomllib.loads(text), f"priors {name}")


def read_file(path: Path) -> dict[str, Any]:
    """Return a TOML file as plain data, or raise CallerError."""
    try:
        return tomllib.loads(path.read_text("utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise CallerError(f"priors {path} cannot be read: {error}") from None
