"""Published ranges of the parameters of a wire, and whether a value lies inside."""

from __future__ import annotations

import math
from functools import cache
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import nearest_hint
from musclewire.parameters._library import load_alloy, load_wire, names, read_published
from musclewire.parameters._parameter_groups import Alloy, Bench, Parameter, Wire
from musclewire.parameters._validation import validated

# The wire whose resistance per metre the alloy's resistivities belong to.
REFERENCE_WIRE = "paper-100um"

# Values are stored with few digits: one that differs by less than this fraction lies on the edge, not beyond it.
ROUNDING = 1e-6


class PublishedRange(BaseModel):
    """The range over all sources found, in SI; low and high are equal if there is only one figure.

    ``standing`` says how reliable it is: figures read in a source, derived from such, or from recollection.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: float = Field(allow_inf_nan=False)
    high: float = Field(allow_inf_nan=False)
    unit: str
    standing: Literal["looked up", "derived", "recollection"]
    source: str = Field(min_length=3)

    @model_validator(mode="after")
    def _low_is_not_above_high(self) -> PublishedRange:
        if self.low > self.high:
            raise ValueError(f"low {self.low:g} is above high {self.high:g}: exchange them")
        return self

    @property
    def is_one_figure(self) -> bool:
        """Whether only one figure was found, which makes no range."""
        return self.low == self.high

    def beyond(self, value: float) -> float:
        """Return the distance of a value above (positive) or below (negative) the range, 0 inside; same unit."""
        slack = ROUNDING * max(abs(self.low), abs(self.high))
        if value > self.high + slack:
            return value - self.high
        return min(value - self.low, 0.0) if value < self.low - slack else 0.0


class PublishedRanges(BaseModel):
    """Ranges by parameter name, of quantities that follow from several, and of what spools differ in from their alloy.

    ``spools_of`` has, by the name of a wire, what replaces ``spools`` for it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    parameters: dict[str, PublishedRange]
    derived: dict[str, PublishedRange]
    spools: dict[str, PublishedRange] = Field(default_factory=dict)
    spools_of: dict[str, dict[str, PublishedRange]] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _names_and_units_are_those_of_a_wire(self) -> PublishedRanges:
        fields = Alloy.model_fields | Wire.model_fields | Bench.model_fields
        for name, found in self.parameters.items():
            if name not in fields:
                raise ValueError(f"'{name}' is no parameter{nearest_hint(name, fields)}")
            extra = fields[name].json_schema_extra
            unit = extra["unit"] if isinstance(extra, dict) else ""
            if unit != found.unit:
                raise ValueError(f"{name} has the unit '{found.unit}', it must be given in '{unit}'")
        return self

    @model_validator(mode="after")
    def _spools_are_wires_that_ship(self) -> PublishedRanges:
        for wire, ranges in self.spools_of.items():
            if wire not in names("wire"):
                raise ValueError(f"there is no wire called '{wire}'{nearest_hint(wire, names('wire'))}")
            for name in ranges:
                if name not in self.spools:
                    raise ValueError(f"'{name}' is nothing that spools differ in{nearest_hint(name, self.spools)}")
        return self


@cache
def published_ranges() -> PublishedRanges:
    """Return the ranges that ship with musclewire (data/published/ranges.toml)."""
    return validated(PublishedRanges, read_published("ranges"), "published ranges")


def outside(group: Alloy | Wire | Bench) -> dict[str, Parameter]:
    """Return the parameters of a file that lie outside their published range; one figure makes no range."""
    ranges = published_ranges().parameters
    return {
        name: item
        for name, item in group.items()
        if name in ranges and not ranges[name].is_one_figure and ranges[name].beyond(item.value) != 0.0
    }


def spool_values(wire: Wire) -> dict[str, float]:
    """Return what a spool differs in from its alloy, by the names of ``PublishedRanges.spools``, in SI."""
    values, alloy = wire.values(), load_alloy(wire.alloy).values()
    reference = load_wire(REFERENCE_WIRE).values()
    nominal = nominal_resistivity_ohm_m(values) / nominal_resistivity_ohm_m(reference)
    return {
        "temperature_shift_k": values["temperature_shift_k"],
        "r_phase_temperature_shift_k": values["temperature_shift_k"] + values["r_phase_shift_k"],
        "resistivity_over_nominal": values["resistivity_factor"] / reference["resistivity_factor"] / nominal,
        "martensite_barrier_k": alloy["martensite_barrier_k"] + values["martensite_barrier_shift_k"],
    }


def nominal_resistivity_ohm_m(wire: dict[str, float]) -> float:
    """Return resistance per metre times section."""
    return wire["resistance_per_metre_ohm_per_m"] * math.pi / 4.0 * wire["diameter_m"] ** 2


def spool_ranges(wire: Wire) -> dict[str, PublishedRange]:
    """Return what may lie between a spool and its alloy, by the names of ``spool_values``."""
    ranges = published_ranges()
    return ranges.spools | ranges.spools_of.get(wire.name, {})


def outside_as_a_spool(wire: Wire) -> dict[str, float]:
    """Return in what a spool differs from its alloy by more than spools may, with its values.

    A barrier without a shift of the spool's own is the alloy's, and counts there alone.
    """
    ranges, values = spool_ranges(wire), spool_values(wire)
    if wire.martensite_barrier_shift_k.value == 0.0:
        del values["martensite_barrier_k"]
    return {name: value for name, value in values.items() if ranges[name].beyond(value) != 0.0}
