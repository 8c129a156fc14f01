"""A file that describes one designed pretensioner: its dimensions, its material, and the computed properties.

What is computed is there for rigs and readers; a design computes it again from the dimensions.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from musclewire.errors import CallerError
from musclewire.parameters._parameter_groups import Parameter
from musclewire.parameters._validation import validated
from musclewire.small_files import read_toml


class FileGeometry(BaseModel):
    """The dimensions in a file [m]."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    beams: int
    half_length_m: float = Field(allow_inf_nan=False)
    pitch_m: float = Field(allow_inf_nan=False)
    thickness_m: float = Field(allow_inf_nan=False)
    depth_m: float = Field(allow_inf_nan=False)
    corner_radius_m: float = Field(allow_inf_nan=False)


class PretensionerFile(BaseModel):
    """A pretensioner's file."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    format: Literal["musclewire-pretensioner"]
    version: Literal[1]
    material: str
    process: str
    geometry: FileGeometry
    computed: dict[str, Parameter] = {}

    @property
    def stiffness_n_per_m(self) -> float:
        """Stiffness along the wire by the design [N/m]. Raises CallerError if the file does not state it."""
        found = self.computed.get("stiffness_n_per_m")
        if found is None:
            raise CallerError(
                "this pretensioner's file does not state its stiffness: write it again by 'design pretensioner'"
            )
        return found.value


def read_pretensioner(path: str | Path) -> PretensionerFile:
    """Return a pretensioner's file, checked. Raises CallerError naming the file, the key and the nearest right key."""
    return validated(PretensionerFile, read_toml(Path(path), "pretensioner file"), f"pretensioner file {path}")
