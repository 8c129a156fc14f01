"""Reading recordings from files of musclewire and of other programs, with a report of how they were understood."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.signals.headers import numbered_headers
from musclewire.signals.import_mapping import ImportMapping, load_mapping
from musclewire.signals.importing import ImportPlan, Tally, checked_blocks, plan_import
from musclewire.signals.journal import is_journal, unfinished
from musclewire.signals.metadata import MetadataValue, checked_metadata
from musclewire.signals.recording import Recording
from musclewire.signals.source_table import SourceColumn, SourceTable, TableInMemory
from musclewire.signals.understanding import Understanding, understanding_of
from musclewire.signals.writing import require_streamable, write_blocks

__all__ = ["has_headers", "import_recording", "read_hdf5", "read_recording", "understand"]


def read_recording(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    metadata: Mapping[str, MetadataValue] | None = None,
    mapping: ImportMapping | str | Path | None = None,
) -> Recording:
    """Read a recording from .h5, .hdf5, .csv, .tsv, .txt or .parquet.

    Parameters
    ----------
    path
        The file.
    columns
        NAME -> "HEADER" or "HEADER:UNIT" for headers that are not recognised by themselves, such as
        ``{"wire_voltage_v": "Vw:mV"}``; HEADER may itself carry a unit, and ``#2`` is the second column whatever it is
        called, also in a file without headers. None if all headers are recognised.
    metadata
        Added to those of the file, and used instead of them if both state a key.
    mapping
        Everything else about how the file is read: an :class:`~musclewire.signals.ImportMapping`, or the path of a
        mapping file; what ``columns`` and ``metadata`` say comes first. None if there is nothing else to say.

    Returns
    -------
    The recording, its columns in SI units.

    Raises
    ------
    RecordingError
        If the file cannot be used: one line with file, column and row.
    CallerError
        For a NAME in ``columns`` that is no column, metadata that no file could keep, or a wrong mapping file.
    MissingExtraError
        For .parquet without pyarrow.
    """
    wanted = _mapping(mapping, columns, metadata)
    plan, tally = plan_import(_table(Path(path)), wanted), Tally()
    blocks = list(checked_blocks(plan, tally))
    values = {name: np.concatenate([block[name] for block in blocks]) for name in blocks[0]}
    started = {} if tally.start_time is None else {"start_time": tally.start_time}
    return _recording(values, {**started, **plan.table.metadata}, Path(path)).with_metadata(wanted.metadata)


def import_recording(
    path: str | Path,
    output: str | Path | None = None,
    columns: Mapping[str, str] | None = None,
    metadata: Mapping[str, MetadataValue] | None = None,
    mapping: ImportMapping | str | Path | None = None,
) -> Understanding:
    """Check a recording of another program to its last row, and convert it if an output is given.

    The file is read block after block, so that its size does not matter.

    Parameters
    ----------
    path
        The file.
    output
        The file to write: .h5, .hdf5, .csv or .parquet; one of this name is replaced. None, the default, only checks.
    columns
        As in :func:`read_recording`.
    metadata
        As in :func:`read_recording`.
    mapping
        As in :func:`read_recording`.

    Returns
    -------
    How the file was understood. Without an output a file that cannot be used has a ``problem``.

    Raises
    ------
    RecordingError
        If the file cannot be read at all, and with an output if it cannot be used; nothing is written then.
    CallerError
        For a NAME in ``columns`` that is no column, a wrong mapping file, or an output that cannot be written.
    MissingExtraError
        For .parquet without pyarrow.
    """
    plan, tally = plan_import(_table(Path(path)), _mapping(mapping, columns, metadata)), Tally()
    problem = ""
    if output is None:
        problem = _first_problem(plan, tally)
    else:
        _write(plan, tally, Path(output))
    return understanding_of(plan, tally, problem)


def understand(path: str | Path, columns: Mapping[str, str] | None = None) -> Understanding:
    """Return the column, unit, factor and range of each header of a file, which are ignored, and what is wrong with it.

    Parameters
    ----------
    path
        The file.
    columns
        As in :func:`read_recording`.

    Returns
    -------
    The report, as of :func:`import_recording` without an output.

    Raises
    ------
    RecordingError
        If the file cannot be read at all, or the mapping does not fit it.
    """
    return import_recording(path, columns=columns)


def read_hdf5(path: str | Path) -> Recording:
    """Return a recording in musclewire's format without checks; an unfinished one has ``ended`` "running" or "cut off".

    Raises RecordingError if the file is missing, damaged, or not a musclewire recording.
    """
    from musclewire.signals.runs_on_disk import read_run

    return _recording(*read_run(Path(path)), Path(path))


def has_headers(path: str | Path) -> bool:
    """Return whether a file names its columns.

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    False if its first line is numbers.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    headers = tuple(column.header for column in _table(Path(path)).columns)
    return headers != numbered_headers(len(headers))


def _mapping(
    mapping: ImportMapping | str | Path | None,
    columns: Mapping[str, str] | None,
    metadata: Mapping[str, MetadataValue] | None,
) -> ImportMapping:
    given = load_mapping(mapping) if isinstance(mapping, str | Path) else mapping or ImportMapping()
    return given.joined(ImportMapping(columns or {}, metadata=checked_metadata(metadata or {})))


def _first_problem(plan: ImportPlan, tally: Tally) -> str:
    """Read a table to its end and return why it cannot be used, or ""."""
    try:
        for _ in checked_blocks(plan, tally):
            pass
    except RecordingError as problem:
        return str(problem)
    return ""


def _write(plan: ImportPlan, tally: Tally, output: Path) -> None:
    if plan.problem:
        raise RecordingError(plan.problem)
    require_streamable(output)
    blocks = checked_blocks(plan, tally)
    # What the first block shows, when a file with dates begins, belongs to the metadata.
    first = next(blocks, None)
    started = {} if tally.start_time is None else {"start_time": tally.start_time}
    metadata = checked_metadata({**started, **plan.metadata})

    def rows() -> Iterator[tuple[FloatArray, ...]]:
        if first is not None:
            yield tuple(first[name] for name in plan.names)
        for block in blocks:
            yield tuple(block[name] for name in plan.names)

    write_blocks(plan.names, rows(), metadata, output)


def _table(path: Path) -> SourceTable:
    read = _reader_for(path)
    if not path.is_file() and not (is_journal(path) or unfinished(path)):
        what = "is a folder" if path.is_dir() else "no such file"
        raise RecordingError(f"{path}: {what}; give the path of a recording")
    return read(path)


def _reader_for(path: Path) -> Callable[[Path], SourceTable]:
    # Imported here: h5py and pyarrow are slow to load, and most commands read no file.
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"} or is_journal(path) or unfinished(path):
        return _own_table
    if suffix in {".csv", ".tsv", ".txt", ".dat", ".asc"}:
        from musclewire.signals.text_tables import read_text_table

        return read_text_table
    if suffix == ".parquet":
        from musclewire.signals.parquet import read_parquet_table

        return read_parquet_table
    known = ".h5, .hdf5, .csv, .tsv, .txt, .dat, .asc or .parquet"
    raise RecordingError(f"{path}: files ending in '{suffix}' are not read; export it as {known}")


def _own_table(path: Path) -> SourceTable:
    recording = read_hdf5(path)
    columns = tuple(SourceColumn(name) for name in recording.names)
    values = tuple(recording[name] for name in recording.names)
    return TableInMemory(str(path), "musclewire HDF5", columns, values, recording.metadata)


def _recording(values: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> Recording:
    try:
        return Recording(values, metadata)
    except (CallerError, RecordingError) as problem:
        # Wrong metadata in a file are the file's fault, not the caller's.
        raise RecordingError(f"{path}: {problem}") from None
