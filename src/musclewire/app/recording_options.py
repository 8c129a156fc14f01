"""Options of commands that read a recording: what its columns are, and what it does not state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app.options import COLUMN, INVERT, LEG_LENGTH, SHUNT, ZERO, in_si, mapping

if TYPE_CHECKING:
    from musclewire.signals.recording import MetadataValue, Recording

__all__ = ["ReadingOptions"]

PUBLISHED = ("lan-fan-2010-table-2",)


@dataclass(frozen=True)
class ReadingOptions:
    """How a recording is read."""

    column: Annotated[list[str] | None, COLUMN] = None
    leg_length: Annotated[str | None, LEG_LENGTH] = None
    shunt: Annotated[str | None, SHUNT] = None
    zero: Annotated[bool, ZERO] = False
    invert: Annotated[bool, INVERT] = False

    def metadata(self) -> dict[str, MetadataValue]:
        """Return what the options state about a recording."""
        known: dict[str, MetadataValue] = {
            "leg_length_m": in_si("--leg-length", self.leg_length),
            "shunt_resistance_ohm": in_si("--shunt", self.shunt),
        }
        return {name: value for name, value in known.items() if value is not None}

    def read(self, recording: str) -> Recording:
        """Return a recording by path, or the paper's own measured wire by name."""
        from importlib.resources import as_file, files

        from musclewire.signals import read_recording

        metadata = self.metadata()
        if recording in PUBLISHED and not Path(recording).exists():
            with as_file(files("musclewire.parameters") / "data" / "published" / f"{recording}.csv") as path:
                return read_recording(path, mapping(self.column), metadata)
        return turned(read_recording(recording, mapping(self.column), metadata), self.zero, self.invert)


def turned(recording: Recording, zero: bool, invert: bool) -> Recording:
    """Return a recording whose mechanical columns count from the first row, or in the other direction."""
    changed = {
        name: (-recording[name] if invert and name != "force_n" else recording[name])
        for name in ("displacement_m", "reference_strain", "force_n")
        if name in recording
    }
    if zero:
        changed = {name: values - values[0] for name, values in changed.items()}
    return recording.with_columns(changed)
