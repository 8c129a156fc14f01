"""The command import: recordings of other programs, shown as they are understood, converted, remembered."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app.commands import add_command
from musclewire.app.files import require_free
from musclewire.app.options import (
    DROP_MISSING,
    IGNORE,
    MATLAB_VERSION,
    OUTPUT,
    OVERWRITE,
    SAMPLE_PERIOD,
    SAVE_MAPPING,
    Json,
    in_si,
)
from musclewire.app.output import emit_json, show
from musclewire.app.recording_options import ReadingOptions
from musclewire.errors import CallerError, RecordingError

if TYPE_CHECKING:
    from musclewire.signals.import_mapping import ImportMapping
    from musclewire.signals.understanding import Understanding

__all__ = ["add_import_command"]


@dataclasses.dataclass(frozen=True)
class TableOptions:
    """What only import asks of a file, and a mapping file remembers, and what is written."""

    sample_period: Annotated[str | None, SAMPLE_PERIOD] = None
    ignore: Annotated[list[str] | None, IGNORE] = None
    drop_missing: Annotated[bool, DROP_MISSING] = False
    matlab_version: Annotated[str | None, MATLAB_VERSION] = None

    def added_to(self, mapping: ImportMapping) -> ImportMapping:
        """Return a mapping with these options."""
        options = type(mapping)(
            ignore=tuple(self.ignore or ()),
            sample_period_s=in_si("--sample-period", self.sample_period),
            drop_missing=self.drop_missing,
        )
        return mapping.joined(options)


def add_import_command(app: typer.Typer) -> None:
    """Add the command."""
    add_command(app, import_recordings, "import")


def import_recordings(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings of other programs.")],
    reading: ReadingOptions,
    table: TableOptions,
    output: Annotated[Path | None, OUTPUT] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
    save_mapping: Annotated[Path | None, SAVE_MAPPING] = None,
    json: Json = False,
) -> None:
    """Read recordings of other programs and show how they were interpreted; with -o convert one."""
    mapping = table.added_to(reading.import_mapping())
    for path in (output, save_mapping):
        require_one_file(path, files)
        if path is not None:
            require_free(path, overwrite)
    understood = [imported(path, mapping, output, table.matlab_version) for path in files]
    problem = next((item.problem for item in understood if item.problem), "")
    if save_mapping is not None and not problem:
        remember(understood[0], save_mapping)
    if json and not problem:
        emit_json({"files": [item.as_dict() for item in understood]})
        return
    for item in understood:
        show(str(item))
    if problem:
        raise RecordingError(problem)
    for path in (output, save_mapping):
        if path is not None:
            show(f"written to {path}")


def require_one_file(path: Path | None, files: list[Path]) -> None:
    """Raise CallerError if something is to be written for more than one file."""
    if path is not None and len(files) != 1:
        raise CallerError(f"{path} can be written for one file, {len(files)} were given: import them one by one")


def imported(path: Path, mapping: ImportMapping, output: Path | None, matlab_version: str | None) -> Understanding:
    """Return how a file was understood; if it can be used and there is an output, it has been converted."""
    from musclewire.signals import import_recording

    return import_recording(path, output, mapping=mapping, matlab_version=matlab_version)


def remember(understood: Understanding, path: Path) -> None:
    """Write the mapping by which a file was read."""
    from musclewire.signals import save_mapping

    save_mapping(understood.mapping, path)
