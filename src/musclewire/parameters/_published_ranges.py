"""Published ranges of the parameters of a wire, and whether a value lies inside."""

from __future__ import annotations

from functools import cache
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from musclewire.errors import nearest_hint
from musclewire.parameters._library import names, read_published
from musclewire.parameters._parameter_groups import Alloy, Bench, Wire
from musclewire.parameters._validation import validated

# Values are stored with few digits: one that differs by less than this fraction lies on the edge, not beyond it.
ROUNDING = 1e-6


class PublishedRange(BaseModel):
    """The range over all sources found, in SI; low and high are equal if there is only one figure."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    low: float = Field(allow_inf_nan=False)
    high: float = Field(allow_inf_nan=False)
    unit: str
    # How reliable it is: figures read in a source, derived from such, or from recollection.
    standing: Literal["looked up", "derived", "recollection"]
    source: str = Field(min_length=3)
    # Its ends before it was widened, after one fit and before that which ships.
    former: tuple[float, float] | None = None

    @model_validator(mode="after")
    def _low_is_not_above_high(self) -> PublishedRange:
        if self.low > self.high:
            raise ValueError(f"low {self.low:g} is above high {self.high:g}: exchange them")
        return self

    @property
    def before(self) -> PublishedRange:
        """The range before it was widened after a fit; itself if it was not."""
        low, high = self.former or (self.low, self.high)
        return self.model_copy(update={"low": low, "high": high})

    @property
    def is_one_figure(self) -> bool:
        """Whether only one figure was found, which makes no range."""
        return self.low == self.high

    def excess(self, value: float) -> float:
        """Return the distance of a value above (positive) or below (negative) the range, 0 inside; same unit."""
        slack = ROUNDING * max(abs(self.low), abs(self.high))
        if value > self.high + slack:
            return value - self.high
        return min(value - self.low, 0.0) if value < self.low - slack else 0.0


class PublishedRanges(BaseModel):
    """Ranges of parameters by name, of what follows from several, and of what spools differ in from their alloy."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    parameters: dict[str, PublishedRange]
    derived: dict[str, PublishedRange]
    spools: dict[str, PublishedRange] = Field(default_factory=dict)
    # By the name of a wire, what replaces ``spools`` for it.
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
