"""A run on disk: plain HDF5 once it is finished, else its journal, both found by the name of the recording."""

from __future__ import annotations

from pathlib import Path

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, MusclewireError, RecordingError, argument
from musclewire.signals._hdf5 import read_hdf5_columns
from musclewire.signals._journal import (
    JournalContents,
    is_journal,
    journal_of,
    parsed_journal,
    recording_of,
    unfinished,
)
from musclewire.signals._locking import locked_by_another
from musclewire.signals._metadata import MetadataValue
from musclewire.signals._open_journal import replace_journal
from musclewire.signals._recording import Recording
from musclewire.signals._writing import write_columns

RUNNING = "running"  # what ``ended`` of the metadata says of an unfinished run whose process lives,
CUT_OFF = "cut off"  # and of any other


def read_run(path: Path) -> tuple[dict[str, FloatArray], dict[str, MetadataValue]]:
    """Return columns and metadata of a run, finished or not. Raises RecordingError if it is missing or damaged."""
    if is_journal(path):
        return read_journal(path)
    if unfinished(path):
        try:
            return read_journal(journal_of(path))
        except RecordingError:
            if not path.exists():
                raise
            # It has been finished meanwhile.
    return read_hdf5_columns(path)


def read_journal(path: Path) -> tuple[dict[str, FloatArray], dict[str, MetadataValue]]:
    """Return columns and metadata of a journal. Raises RecordingError if there are none."""
    try:
        # Before it is read: a run that ends meanwhile then says so itself.
        running = locked_by_another(path)
        journal = parsed_journal(path.read_bytes(), path)
    except FileNotFoundError:
        finished = recording_of(path)
        instead = f"the run was finished as {finished}" if finished.exists() else "no such file"
        raise RecordingError(f"{path}: {instead}; give a recording file") from None
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror or problem}") from None
    columns = {name: journal.values[:, place] for place, name in enumerate(journal.columns)}
    return columns, {**journal.metadata, "ended": ended_of(journal, running)}


def ended_of(journal: JournalContents, running: bool) -> str:
    """Return how a run ended, in one line."""
    if journal.damaged_bytes and not running:
        return f"{journal.ended or CUT_OFF}; {journal.damaged_bytes} bytes after the last row are damaged"
    return journal.ended or (RUNNING if running else CUT_OFF)


def recover_recording(path: str | Path, output: str | Path | None = None, *, overwrite: bool = False) -> Recording:
    """Make plain HDF5 of the journal that a run left when it was cut off, and remove the journal.

    Parameters
    ----------
    path
        The recording as it was to be, ``loop.h5``, or its journal, ``loop.h5.journal``.
    output
        Another file to write; the journal then stays. None for the recording's own name.
    overwrite
        Whether ``output`` may replace a file; by default that is refused.

    Returns
    -------
    The recording; ``metadata["ended"]`` says "cut off", or how the run ended if it could still write that.

    Raises
    ------
    RecordingError
        If there is no journal, or its beginning is damaged.
    CallerError
        If the run still goes on, another recording has this name, or the file cannot be written; the journal stays.
    """
    target = recording_of(path)
    journal = journal_of(target)
    if not journal.is_file():
        raise _nothing_to_recover(target, journal)
    columns, metadata = read_journal(journal)
    if metadata["ended"] == RUNNING:
        raise CallerError(f"{target}: its run still goes on; wait until it ends")
    try:
        recording = Recording(columns, metadata)
    except MusclewireError as problem:
        raise RecordingError(f"{journal}: " + str(problem)) from None
    if output is None:
        _finish(target, journal, recording)
    else:
        _write_beside(Path(output), recording, overwrite)
    return recording


def _finish(target: Path, journal: Path, recording: Recording) -> None:
    if not target.exists():
        replace_journal(target, recording.whole_columns, recording.metadata)
        return
    # A process that was killed between its last two steps leaves both.
    if len(recording) and Recording(*read_hdf5_columns(target)) != recording:
        raise CallerError(f"{target}: exists and is another recording than {journal}; give another name with -o")
    journal.unlink()


def _write_beside(output: Path, recording: Recording, overwrite: bool) -> None:
    if output.exists() and not overwrite:
        raise CallerError(
            f"{output} exists: give another name or allow replacing it (" + argument("overwrite", True) + ")"
        )
    write_columns(recording.whole_columns, recording.metadata, output)


def _nothing_to_recover(target: Path, journal: Path) -> RecordingError:
    if target.is_file():
        return RecordingError(
            f"{target}: is finished, there is no journal next to it; nothing is to be recovered, open it is"
        )
    return RecordingError(f"{target}: no such file, and no journal {journal}; give the name of the recording")
