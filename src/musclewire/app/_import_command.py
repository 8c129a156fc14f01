"""The command import: recordings of other programs, shown as they are understood, converted, remembered."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from musclewire.app._figure_options import FigureOptions
from musclewire.app._files import require_free
from musclewire.app._options import DELAY, JOIN, MATLAB_VERSION, OVERWRITE, SAVE_MAPPING, in_si, own_help
from musclewire.app._output import Result, say
from musclewire.app._recording_options import ReadingOptions
from musclewire.errors import CallerError, RecordingError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from musclewire.app._answers import ImportAnswer
    from musclewire.files import ImportMapping
    from musclewire.identify import FileInterpretation, JoinedRecordings


def import_recordings(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings of other programs.")],
    reading: ReadingOptions,
    figure: FigureOptions,
    join: Annotated[str | None, JOIN] = None,
    delay: Annotated[str | None, DELAY] = None,
    output: Annotated[
        Path | None, own_help("--output", "Recording to write (.h5, .csv, .parquet, .mat, .xlsx); one FILE only.")
    ] = None,
    overwrite: Annotated[bool, OVERWRITE] = False,
    save_mapping: Annotated[Path | None, SAVE_MAPPING] = None,
    matlab_version: Annotated[str | None, MATLAB_VERSION] = None,
) -> Result:
    """Read recordings of other programs and show how they were interpreted; with -o convert one, or join two."""
    from musclewire.files import mappings_of_files
    from musclewire.files import save_mapping as remember
    from musclewire.identify import import_recording

    require_possible(files, join if delay is None else delay, output, save_mapping, overwrite)
    joining = join is not None or delay is not None or (output is not None and len(files) > 1)
    figure.check()
    if figure.plot is not None and len(files) > 1 and not joining:
        raise CallerError(f"--plot draws one recording, {len(files)} were given: import them one by one, or --join two")
    mappings = mappings_of_files(files, reading.import_mapping())
    single = None if joining else output
    understood = [
        import_recording(path, single, mapping=mapping, matlab_version=matlab_version)
        for path, mapping in zip(files, mappings, strict=True)
    ]
    problem = next((item.problem for item in understood if item.problem), "")
    if problem and output is not None:
        raise RecordingError(problem)
    itself = len(files) == 1
    proposals = [line for one in understood for line in reading.proposal_lines(one.path, one.proposal, itself=itself)]
    if problem:
        for line in proposals:
            say(line)
        return Result(import_answer(understood, None), "\n".join(map(str, understood)), error=RecordingError(problem))
    joined = joined_files(files, mappings, join, in_si("--delay", delay)) if joining else None
    if joined is not None and output is not None:
        joined.recording.save(output, matlab_version)
    if save_mapping is not None:
        remember(understood[0].mapping, save_mapping)
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
        raise CallerError(f"--save-mapping takes one file, {len(files)} were given: it belongs to one kind of file")
    for path in (output, save_mapping):
        if path is not None:
            require_free(path, overwrite)


def drawn(path: Path, mapping: ImportMapping, joined: JoinedRecordings | None, *, style: str) -> Figure:
    """Return the figure of what was imported: the joined recording, or the only file."""
    from musclewire.files import read_recording

    recording = read_recording(path, mapping=mapping) if joined is None else joined.recording
    return recording.plot(style=style)


def joined_files(
    files: list[Path], mappings: list[ImportMapping], join: str | None, delay_s: float | None = None
) -> JoinedRecordings:
    """Return two files as one recording on the first one's clock."""
    from musclewire.files import read_recording
    from musclewire.identify import join_recordings

    first, second = (read_recording(path, mapping=mapping) for path, mapping in zip(files, mappings, strict=True))
    one, equals, other = (join or "").partition("=")
    pair = None if join is None else (one.strip(), other.strip() if equals else one.strip())
    return join_recordings(first, second, pair, delay_s)


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
    scatter = "" if joined.delay_std_s is None else f", standard deviation {joined.delay_std_s:.2g} s"
    delay = f"{joined.delay_s:.6g} s{scatter}"
    return [
        f"{second}: its clock is ahead by {delay}, {how}",
        *(f"  {note}" for note in joined.notes),
    ]
