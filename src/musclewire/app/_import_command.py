"""The command import: recordings of other programs, shown as they are understood, converted, remembered."""

from __future__ import annotations

import dataclasses
import shlex
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import require_free
from musclewire.app._options import (
    DELAY,
    DROP_MISSING,
    IGNORE,
    JOIN,
    MATLAB_VERSION,
    OVERWRITE,
    SAMPLE_PERIOD,
    SAVE_MAPPING,
    in_si,
    own_help,
)
from musclewire.app._output import Result, say
from musclewire.app._recording_options import ReadingOptions
from musclewire.errors import CallerError, RecordingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from musclewire.app._answers import ImportAnswer
    from musclewire.signals import FileInterpretation, ImportMapping, JoinedRecordings


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


def import_recordings(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings of other programs.")],
    reading: ReadingOptions,
    table: TableOptions,
    figure: FigureOptions,
    join: Annotated[str | None, JOIN] = None,
    delay: Annotated[str | None, DELAY] = None,
    output: Annotated[
        Path | None, own_help("--output", "Recording to write (.h5, .csv, .parquet, .mat, .xlsx); one FILE only.")
    ] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
    save_mapping: Annotated[Path | None, SAVE_MAPPING] = None,
) -> Result:
    """Read recordings of other programs and show how they were interpreted; with -o convert one, or join two."""
    from musclewire.signals import mappings_of_files

    require_possible(files, join if delay is None else delay, output, save_mapping, overwrite)
    joining = join is not None or delay is not None or (output is not None and len(files) > 1)
    require_one_figure(figure, files, joining)
    mappings = mappings_of_files(files, table.added_to(reading.import_mapping()))
    single, version = None if joining else output, table.matlab_version
    understood = [
        imported(path, mapping, single, version, reading.mapping) for path, mapping in zip(files, mappings, strict=True)
    ]
    problem = next((item.problem for item in understood if item.problem), "")
    proposals = [line for item in understood for line in proposal_lines(item.path, item.proposal, reading.mapping)]
    if problem:
        for line in proposals:
            say(line)
        return Result(import_answer(understood, None), "\n".join(map(str, understood)), error=RecordingError(problem))
    joined = joined_files(files, mappings, join, in_si("--delay", delay)) if joining else None
    if joined is not None and output is not None:
        joined.recording.save(output, version)
    if save_mapping is not None:
        remember(understood[0], save_mapping)
    figure.draw(partial(drawn, files[0], mappings[0], joined))
    written = [f"written to {path}" for path in (output, save_mapping) if path is not None]
    lines = [
        *map(str, understood),
        *proposals,
        *([] if joined is None else joined_lines(joined, understood[1].path)),
        *written,
    ]
    return Result(import_answer(understood, joined), "\n".join(lines))


def require_possible(
    files: list[Path], join: str | None, output: Path | None, save_mapping: Path | None, overwrite: bool
) -> None:
    """Raise CallerError for files that cannot be written, or too many or too few to join."""
    if len(files) != 2 and join is not None:
        raise CallerError(f"--join takes two files, {len(files)} were given: give two")
    if len(files) > 2 and output is not None:
        raise CallerError(f"-o takes one file, or two to join, {len(files)} were given: import them one by one")
    if len(files) > 1 and save_mapping is not None:
        raise CallerError(
            f"--save-mapping takes one file, {len(files)} were given: a mapping belongs to one kind of file"
        )
    for path in (output, save_mapping):
        if path is not None:
            require_free(path, overwrite)


def require_one_figure(figure: FigureOptions, files: list[Path], joining: bool) -> None:
    """Raise CallerError for a figure that cannot be, or of several recordings that are not joined."""
    figure.check()
    if figure.plot is not None and len(files) > 1 and not joining:
        raise CallerError(f"--plot draws one recording, {len(files)} were given: import them one by one, or --join two")


def drawn(path: Path, mapping: ImportMapping, joined: JoinedRecordings | None, *, style: str) -> Figure:
    """Return the figure of what was imported: the joined recording, or the only file."""
    from musclewire.signals import read_recording

    recording = read_recording(path, mapping=mapping) if joined is None else joined.recording
    return recording.plot(style=style)


def imported(
    path: Path,
    mapping: ImportMapping,
    output: Path | None,
    matlab_version: str | None,
    mapping_file: Path | None = None,
) -> FileInterpretation:
    """Return how a file was understood; if it can be used and there is an output, it has been converted.

    Before a refusal the command that reads the file is said, if one is known: on stderr, like the refusal.
    """
    from musclewire.signals import import_recording, proposed_mapping

    try:
        return import_recording(path, output, mapping=mapping, matlab_version=matlab_version)
    except RecordingError as problem:
        for line in proposal_lines(str(path), proposed_mapping(path, mapping, problem), mapping_file):
            say(line)
        raise


def proposal_lines(path: str, proposal: ImportMapping | None, mapping_file: Path | None) -> list[str]:
    """Return the command that reads a file, which has been tried; nothing without a proposal."""
    if proposal is None:
        return []
    from musclewire.signals import EXAMPLE_PERIOD_S, EXAMPLE_SHUNT, load_mapping

    remembered = [] if mapping_file is None else as_options(load_mapping(mapping_file))
    added = [option for option in as_options(proposal) if option not in remembered]
    named = [] if mapping_file is None else [("--mapping", str(mapping_file))]
    words = ["musclewire", "import", path, *(word for option in (*named, *added) for word in option)]
    examples = []
    if proposal.sample_period_s == EXAMPLE_PERIOD_S:
        examples.append(f"  ({EXAMPLE_PERIOD_S:g} s is an example: give the time between two of your rows)")
    if proposal.metadata.items() >= EXAMPLE_SHUNT.metadata.items():
        examples.append("  (a shunt of 1 ohm is an example: give the resistance of yours)")
    return [f"  try: {shlex.join(words)}", *examples]


def as_options(mapping: ImportMapping) -> list[tuple[str, ...]]:
    """Return a mapping as the options of the command line that give it."""
    options: list[tuple[str, ...]] = [("-c", f"{name}={wanted}") for name, wanted in mapping.columns.items()]
    options += [("--ignore", header) for header in mapping.ignore]
    if mapping.sample_period_s is not None:
        options.append(("--sample-period", f"{mapping.sample_period_s:g} s"))
    if mapping.group is not None:
        options.append(("--group", mapping.group))
    options += [
        (f"--{name.replace('_', '-')}",) for name in ("drop_missing", "zero", "invert") if getattr(mapping, name)
    ]
    known = {"shunt_resistance_ohm": ("--shunt", "ohm"), "leg_length_m": ("--leg-length", "m")}
    options += [(known[key][0], f"{value} {known[key][1]}") for key, value in mapping.metadata.items() if key in known]
    return options


def joined_files(
    files: list[Path], mappings: list[ImportMapping], join: str | None, delay_s: float | None = None
) -> JoinedRecordings:
    """Return two files as one recording on the first one's clock."""
    from musclewire.signals import join_recordings, read_recording

    first, second = (read_recording(path, mapping=mapping) for path, mapping in zip(files, mappings, strict=True))
    one, equals, other = (join or "").partition("=")
    pair = None if join is None else (one.strip(), other.strip() if equals else one.strip())
    return join_recordings(first, second, pair, delay_s)


def remember(understood: FileInterpretation, path: Path) -> None:
    """Write the mapping by which a file was read."""
    from musclewire.signals import save_mapping

    save_mapping(understood.mapping, path)


def import_answer(understood: list[FileInterpretation], joined: JoinedRecordings | None) -> ImportAnswer:
    """Return how the files were understood and joined."""
    from musclewire.app._answers import ImportAnswer, JoinedFiles

    join = None if joined is None else JoinedFiles.read_from(joined, rows=len(joined.recording))
    return ImportAnswer.read_from(files=[item.as_dict() for item in understood], join=join)


def joined_lines(joined: JoinedRecordings, second: str) -> list[str]:
    """Return in words how a second file was joined to the first."""
    how = joined.how
    if joined.columns:
        how = f"by the correlation {joined.correlation:.3f} of {' and '.join(dict.fromkeys(joined.columns))}"
    rate = f", and runs {joined.rate:.6g} times as fast (+- {joined.rate_std:.2g})" if joined.rate != 1.0 else ""
    scatter = "" if joined.delay_std_s is None else f", standard deviation {joined.delay_std_s:.2g} s"
    delay = f"{joined.delay_s:.6g} s{scatter}"
    return [
        f"{second}: its clock is ahead by {delay}{rate}, {how}",
        *(f"  {note}" for note in joined.notes),
    ]
