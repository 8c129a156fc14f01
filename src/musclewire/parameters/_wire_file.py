"""A file that describes one wire: its own numbers, its alloy, and the known numbers of the bench it was measured on.

format = "musclewire-wire"
version = 1
name = "my-spool"
description = "..."

[wire.diameter_m]                       all numbers of a wire, each as in the parameter files of musclewire
value = 0.0001
unit = "m"
kind = "measured"
source = "calliper"

[alloy.martensite_temperature_k]        all numbers of an alloy
...
[alloy.grain_quantiles]                 and, if they were measured, quantiles of its grains
fraction = [0.0, 0.5, 1.0]
offset = [-5.0, 0.0, 5.0]
kind = "measured"
source = "an isobar"
[alloy.validity.stress]                 the stresses and temperatures that the alloy's data cover (low, high), the
low = 45e6                              vendor's working_stress and the annealing_temperature (value): all four or none
high = 220e6
...
[bench.guide_friction_n]                those of a bench that are known, if any
...
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, model_validator

from musclewire.parameters._parameter_groups import (
    Alloy,
    Bench,
    CoveredRange,
    GrainQuantiles,
    Parameter,
    Wire,
    checked,
    key_hint,
)
from musclewire.parameters._validation import read_toml, validated

SUFFIX = ".toml"
# Texts of a wire and an alloy that the file says once, at its head.
HEAD = ("name", "description")


class WireFile(BaseModel):
    """A wire, its alloy, and the numbers of a bench that are known; the wire's alloy is the one in the file."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["musclewire-wire"]
    version: Literal[1]
    name: str
    description: str = ""
    wire: Wire
    alloy: Alloy
    bench: dict[str, Parameter] = {}

    @model_validator(mode="after")
    def _bench_is_a_part_of_a_bench(self) -> WireFile:
        fields = {key: field for key, field in Bench.model_fields.items() if key not in HEAD}
        for key, item in self.bench.items():
            if key not in fields:
                raise ValueError(f"unknown key 'bench.{key}'{key_hint(key, fields)}")
            checked(f"bench.{key}", item, fields[key])
        return self


def is_wire_file(name: str) -> bool:
    """Return whether a wire's name is the path of a file."""
    return name.endswith(SUFFIX)


def read_wire_file(path: str | Path) -> WireFile:
    """Return a wire file, checked. Raises CallerError that names the file, the key and the nearest valid key."""
    file = Path(path)
    data = read_toml(file, "wire file")
    head = {key: data.get(key, "") for key in HEAD}
    # load_alloy finds the alloy where load_wire found the wire: in this file.
    for group, texts in (("wire", {**head, "alloy": str(file.resolve())}), ("alloy", head)):
        if isinstance(data.get(group), dict):
            data[group] = {**texts, **data[group]}
    return validated(WireFile, data, f"wire file {file}")


def wire_file_text(name: str, description: str, wire: Wire, alloy: Alloy, bench: Mapping[str, Parameter]) -> str:
    """Return the text of the file for a wire, its alloy and the known numbers of its bench."""
    lines = [
        'format = "musclewire-wire"',
        "version = 1",
        f"name = {quoted(name)}",
        f"description = {quoted(description)}",
    ]
    for group, items in (("wire", dict(wire.items())), ("alloy", dict(alloy.items())), ("bench", dict(bench))):
        for key, item in items.items():
            lines += ["", f"[{group}.{key}]", *parameter_lines(item)]
    if alloy.grain_quantiles is not None:
        lines += ["", "[alloy.grain_quantiles]", *quantile_lines(alloy.grain_quantiles)]
    if alloy.validity is not None:
        for key, value in alloy.validity:
            stated = range_lines(value) if isinstance(value, CoveredRange) else parameter_lines(value)
            lines += ["", f"[alloy.validity.{key}]", *stated]
    return "\n".join(lines) + "\n"


def range_lines(item: CoveredRange) -> list[str]:
    """Return a range that data cover as lines of TOML."""
    first, *others = parameter_lines(Parameter(value=item.low, **item.model_dump(exclude={"low", "high"})))
    return [first.replace("value", "low"), f"high = {item.high!r}", *others]


def quantile_lines(item: GrainQuantiles) -> list[str]:
    """Return measured quantiles as lines of TOML."""
    lines = [
        f"fraction = {list(item.fraction)!r}",
        f"offset = {list(item.offset)!r}",
        f"kind = {quoted(item.kind)}",
        f"source = {quoted(item.source)}",
    ]
    return [*lines, f"note = {quoted(item.note)}"] if item.note else lines


def parameter_lines(item: Parameter) -> list[str]:
    """Return a parameter as lines of TOML."""
    lines = [
        # repr keeps every bit, so that a wire read back is the same wire.
        f"value = {item.value!r}",
        f"unit = {quoted(item.unit)}",
        f"kind = {quoted(item.kind)}",
        f"source = {quoted(item.source)}",
    ]
    return [*lines, f"note = {quoted(item.note)}"] if item.note else lines


def quoted(text: str) -> str:
    """Return text as a TOML basic string: JSON's is one, but for the character that JSON leaves as it is."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")
