"""Options of commands that read a recording: what its columns are, and what it does not state."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from musclewire.app._options import COLUMN, GROUP, INVERT, LEG_LENGTH, MAPPING, SHUNT, ZERO, in_si, mapping

if TYPE_CHECKING:
    from musclewire.signals import ImportMapping, MetadataValue, Recording

PUBLISHED = ("lan-fan-2010-table-2",)


@dataclass(frozen=True)
class ReadingOptions:
    """How a recording is read."""

    column: Annotated[list[str] | None, COLUMN] = None
    leg_length: Annotated[str | None, LEG_LENGTH] = None
    shunt: Annotated[str | None, SHUNT] = None
    zero: Annotated[bool, ZERO] = False
    invert: Annotated[bool, INVERT] = False
    mapping: Annotated[Path | None, MAPPING] = None
    group: Annotated[str | None, GROUP] = None

    def metadata(self) -> dict[str, MetadataValue]:
        """Return what the options state about a recording."""
        known: dict[str, MetadataValue] = {
            "leg_length_m": in_si("--leg-length", self.leg_length),
            "shunt_resistance_ohm": in_si("--shunt", self.shunt),
        }
        return {name: value for name, value in known.items() if value is not None}

    def import_mapping(self) -> ImportMapping:
        """Return all options as a mapping; those of a mapping file come second."""
        from musclewire.signals import ImportMapping, load_mapping

        options = ImportMapping(
            mapping(self.column), zero=self.zero, invert=self.invert, metadata=self.metadata(), group=self.group
        )
        return options if self.mapping is None else load_mapping(self.mapping).joined(options)

    def read(self, recording: str) -> Recording:
        """Return a recording by path, or the paper's own measured wire by name."""
        from importlib.resources import as_file, files

        from musclewire.signals import read_recording

        if recording in PUBLISHED and not Path(recording).exists():
            with as_file(files("musclewire.parameters") / "data" / "published" / f"{recording}.csv") as path:
                return read_recording(path, mapping(self.column), self.metadata())
        return read_recording(recording, mapping=self.import_mapping())
