"""Options of commands that read a recording: what its columns are, and what it does not state."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from musclewire.app._options import (
    COLUMN,
    DROP_MISSING,
    GROUP,
    IGNORE,
    INVERT,
    LEG_LENGTH,
    MAPPING,
    SAMPLE_PERIOD,
    SHUNT,
    TRUST_MAPPING,
    ZERO,
    in_si,
    mapping,
)
from musclewire.app._output import say, tell
from musclewire.errors import MusclewireError, RecordingError

if TYPE_CHECKING:
    from musclewire.files import ImportMapping
    from musclewire.signals import MetadataValue, Recording

PUBLISHED = ("lan-fan-2010-table-2",)


@dataclass(frozen=True)
class ReadingOptions:
    """How a recording is read. ``typed`` is the command without these options, ``proposed`` a mapping for them."""

    column: Annotated[list[str] | None, COLUMN] = None
    leg_length: Annotated[str | None, LEG_LENGTH] = None
    shunt: Annotated[str | None, SHUNT] = None
    zero: Annotated[bool, ZERO] = False
    invert: Annotated[bool, INVERT] = False
    sample_period: Annotated[str | None, SAMPLE_PERIOD] = None
    ignore: Annotated[list[str] | None, IGNORE] = None
    drop_missing: Annotated[bool, DROP_MISSING] = False
    trust_mapping: Annotated[bool, TRUST_MAPPING] = False
    mapping: Annotated[Path | None, MAPPING] = None
    group: Annotated[str | None, GROUP] = None
    typed: tuple[str, ...] = ()
    proposed: Any = None

    def metadata(self) -> dict[str, MetadataValue]:
        """Return what the options state about a recording."""
        known: dict[str, MetadataValue] = {
            "leg_length_m": in_si("--leg-length", self.leg_length),
            "shunt_resistance_ohm": in_si("--shunt", self.shunt),
        }
        return {name: value for name, value in known.items() if value is not None}

    def import_mapping(self) -> ImportMapping:
        """Return all options as a mapping; those of a mapping file come second."""
        from musclewire.files import ImportMapping, load_mapping

        if isinstance(self.proposed, ImportMapping):
            return self.proposed
        options = ImportMapping(
            mapping(self.column),
            tuple(self.ignore or ()),
            in_si("--sample-period", self.sample_period),
            self.drop_missing,
            self.zero,
            self.invert,
            self.metadata(),
            group=self.group,
            trust_mapping=self.trust_mapping,
        )
        return options if self.mapping is None else load_mapping(self.mapping).joined(options)

    def read(self, recording: str) -> Recording:
        """Return a recording by path, or the paper's own measured wire by name."""
        from importlib.resources import as_file, files

        from musclewire.files import read_recording

        if recording in PUBLISHED and not Path(recording).exists():
            with as_file(files("musclewire.parameters") / "data" / "published" / f"{recording}.csv") as path:
                return read_recording(path, mapping=self.import_mapping())
        return read_recording(recording, mapping=self.import_mapping())

    def say_what_was_seen(
        self,
        paths: Sequence[str],
        problem: RecordingError,
        tried: Callable[[ImportMapping], MusclewireError | None] | None,
        *,
        imports: bool,
    ) -> None:
        """Say how a file was understood that was refused, and the command that reads it, if one is known.

        ``tried`` returns what the command that was typed ends with by a mapping.
        """
        from musclewire.files import mappings_of_files
        from musclewire.identify import import_recording, proposed_mapping

        for path, wanted in zip(paths, mappings_of_files(paths, self.import_mapping()), strict=True):
            if len(paths) > 1 and not str(problem).startswith(path):
                continue
            try:
                seen = import_recording(path, mapping=wanted)
            except RecordingError:  # it cannot be read at all: nothing was seen
                proposal = proposed_mapping(path, wanted, problem)
            else:
                proposal = seen.proposal or proposed_mapping(path, wanted, problem)
                if seen.problem or proposal is not None:
                    tell(str(seen))
            error = tried(proposal) if tried is not None and proposal is not None else None
            itself = imports and len(paths) == 1 if tried is None else error is None
            for line in self.proposal_lines(path, proposal, itself=itself):
                say(line)
            if error is not None:
                tell(f"  ({self.typed[1]} needs more: " + str(error) + ")")

    def proposal_lines(self, path: str, proposal: ImportMapping | None, *, itself: bool) -> list[str]:
        """Return the command that reads a file: the one that was typed, if it does so ``itself``, or import."""
        if proposal is None:
            return []
        from musclewire.files import load_mapping

        remembered = [] if self.mapping is None else as_options(load_mapping(self.mapping))
        added = [option for option in as_options(proposal) if option not in remembered]
        named = [] if self.mapping is None else [("--mapping", str(self.mapping))]
        command = self.typed if itself else ("musclewire", "import", path)
        words = [*command, *(word for option in (*named, *added) for word in option)]
        return [f"  try: {shlex.join(words)}"]


def as_options(mapping: ImportMapping) -> list[tuple[str, ...]]:
    """Return a mapping as the options of the command line that give it."""
    options: list[tuple[str, ...]] = [("-c", f"{name}={wanted}") for name, wanted in mapping.columns.items()]
    options += [("--ignore", header) for header in mapping.ignore]
    if mapping.sample_period_s is not None:
        options.append(("--sample-period", f"{mapping.sample_period_s:g} s"))
    if mapping.group is not None:
        options.append(("--group", mapping.group))
    options += [
        (f"--{name.replace('_', '-')}",)
        for name in ("drop_missing", "zero", "invert", "trust_mapping")
        if getattr(mapping, name)
    ]
    known = {"shunt_resistance_ohm": ("--shunt", "ohm"), "leg_length_m": ("--leg-length", "m")}
    options += [(known[key][0], f"{value} {known[key][1]}") for key, value in mapping.metadata.items() if key in known]
    return options
