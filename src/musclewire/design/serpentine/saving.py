"""A designed pretensioner as a file: its dimensions, what it is made of, and what was computed from them.

format = "musclewire-pretensioner"
version = 1
material = "pom"                        by name, or the path of a material file
process = "laser-cut"

[geometry]
beams = 4
half_length_m = 0.01172
...

[computed.stiffness_n_per_m]            for the reader; computed again when the file is read
...
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from musclewire.design.serpentine.analysis import Pretensioner
from musclewire.design.serpentine.geometry import SerpentineGeometry
from musclewire.parameters.schema import Parameter
from musclewire.parameters.toml_file import read_toml
from musclewire.parameters.validation import validated
from musclewire.parameters.wire_file import parameter_lines, quoted

__all__ = ["DIMENSIONS", "PretensionerFile", "pretensioner_text", "read_pretensioner"]

DIMENSIONS = ("half_length_m", "pitch_m", "thickness_m", "depth_m", "corner_radius_m")


class FileGeometry(BaseModel):
    """The dimensions in a file [m]."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    beams: int
    half_length_m: float = Field(allow_inf_nan=False)
    pitch_m: float = Field(allow_inf_nan=False)
    thickness_m: float = Field(allow_inf_nan=False)
    depth_m: float = Field(allow_inf_nan=False)
    corner_radius_m: float = Field(allow_inf_nan=False)

    def geometry(self) -> SerpentineGeometry:
        """Return the serpentine. Raises CallerError where it is none."""
        return SerpentineGeometry(self.beams, **{name: getattr(self, name) for name in DIMENSIONS})


class PretensionerFile(BaseModel):
    """A pretensioner's file."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["musclewire-pretensioner"]
    version: Literal[1]
    material: str
    process: str
    geometry: FileGeometry
    computed: dict[str, Parameter] = {}


def read_pretensioner(path: str | Path) -> PretensionerFile:
    """Return a pretensioner's file, checked. Raises CallerError naming the file, the key and the nearest right key."""
    return validated(PretensionerFile, read_toml(Path(path), "pretensioner file"), f"pretensioner file {path}")


def pretensioner_text(made: Pretensioner, material_name: str) -> str:
    """Return the text of a pretensioner's file; every number keeps all its bits."""
    geometry = made.geometry
    lines = [
        'format = "musclewire-pretensioner"',
        "version = 1",
        f"material = {quoted(material_name)}",
        f"process = {quoted(made.process)}",
        "",
        "[geometry]",
        f"beams = {geometry.beams}",
        *(f"{name} = {getattr(geometry, name)!r}" for name in DIMENSIONS),
    ]
    for key, item in computed(made).items():
        lines += ["", f"[computed.{key}]", *parameter_lines(item)]
    return "\n".join(lines) + "\n"


def computed(made: Pretensioner) -> dict[str, Parameter]:
    """Return the numbers that a file tells its reader."""
    source = "musclewire design pretensioner, plane-stress finite elements"
    values = {
        "stiffness_n_per_m": (made.stiffness_n_per_m, "N/m"),
        "stiffness_guided_n_per_m": (made.guided.stiffness_n_per_m, "N/m"),
        "safe_travel_m": (made.curve.safe_travel_m, "m"),
    }
    return {
        key: Parameter(value=float(value), unit=unit, kind="derived", source=source)
        for key, (value, unit) in values.items()
    }
