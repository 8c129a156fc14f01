"""Parts of a load by the name that ``part = "..."`` has in a rig file: built-in ones and those of other packages."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, model_validator

from musclewire.parameters import TaggedTable
from musclewire.registry import Registry
from musclewire.rigs._load_part import LoadPart

LOAD_PARTS: Registry[type[LoadPart]] = Registry(
    "part of a load",
    "load_parts",
    {
        "spring": "musclewire.rigs._load_parts:Spring",
        "pretensioner": "musclewire.rigs._load_parts:Pretensioner",
        "finger": "musclewire.rigs._load_parts:Finger",
        "weight": "musclewire.rigs._load_parts:Weight",
        "blocked": "musclewire.rigs._load_parts:Blocked",
        "contact": "musclewire.rigs._load_parts:Contact",
    },
)

Part = Annotated[LoadPart, TaggedTable(LOAD_PARTS, "part")]


class Parts(BaseModel):
    """A list of parts that fit together."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    load: list[Part]

    @model_validator(mode="after")
    def _parts_fit_together(self) -> Parts:
        names = [item.part for item in self.load]
        for item in self.load:
            if item.once and names.count(item.part) > 1:
                raise ValueError(
                    f"there are {names.count(item.part)} parts '{item.part}', 1 fits: leave the others out"
                )
        wires = [item.part for item in self.load if item.second_wire is not None]
        if len(wires) > 1:
            raise ValueError(f"a rig has room for one second wire: give one of {', '.join(wires)}")
        for item in self.load:
            reason = item.misfit(self.load)
            if reason is not None:
                raise ValueError(reason)
        return self
