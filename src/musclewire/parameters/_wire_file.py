"""A file that describes one wire: its own numbers, its alloy, and the known numbers of the bench it was measured on.

All numbers of ``[wire.NAME]`` and ``[alloy.NAME]``, and of ``[bench.NAME]`` those that are known, are as in the
parameter files of musclewire. ``[alloy.grain_quantiles]`` is there if they were measured; of ``[alloy.validity]`` all
four tables or none.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, model_validator

from musclewire.errors import nearest_hint
from musclewire.parameters._parameter_groups import Alloy, Bench, Parameter, Wire, checked
from musclewire.parameters._validation import validated
from musclewire.small_files import read_toml, toml_text

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
                raise ValueError(f"unknown key 'bench.{key}'{nearest_hint(key, fields)}")
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
    return toml_text(
        {
            "format": "musclewire-wire",
            "version": 1,
            "name": name,
            "description": description,
            "wire": wire.model_dump(exclude={*HEAD, "alloy"}),
            "alloy": alloy.model_dump(exclude=set(HEAD)),
            "bench": {key: item.model_dump() for key, item in bench.items()},
        }
    )
