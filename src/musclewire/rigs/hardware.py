"""What every rig file of real hardware shares: it is checked by a schema and knows how to open itself."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Self

from pydantic import BaseModel, ConfigDict

from musclewire.parameters.wire_file import is_wire_file
from musclewire.rigs.guarded import GuardedRig

__all__ = ["HardwareConfiguration"]


class HardwareConfiguration(BaseModel, ABC):
    """A rig file of something that is not simulated: it knows how to open itself."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @abstractmethod
    def open(self) -> GuardedRig:
        """Return the open rig, with its output off and its protection armed.

        Raises MissingExtraError where its package is not installed, RigError where the device cannot be opened.
        """

    def beside(self, folder: Path) -> Self:
        """Return the configuration with the files it names found beside it; by default its wire file."""
        wire = getattr(self, "wire", None)
        return self.model_copy(update={"wire": str(folder / wire)}) if wire and is_wire_file(wire) else self
