"""Reading recordings from files of musclewire and of other programs, with a report of how they were understood."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError
from musclewire.signals.columns import BRANCH_TABLE, COLUMNS, ISOBAR_TABLE, needs_no_clock
from musclewire.signals.headers import IgnoredHeader, MatchedHeader, numbered_headers, understand_headers
from musclewire.signals.journal import is_journal, unfinished
from musclewire.signals.metadata import MetadataValue
from musclewire.signals.recording import Recording
from musclewire.signals.tables import Table

__all__ = ["Understanding", "has_headers", "read_hdf5", "read_recording", "understand"]

# Our own runs hold NaN in samples without an estimate; in any other column NaN is a gap in the data.
_MAY_BE_NAN = frozenset(name for name in COLUMNS if name.startswith("estimated_"))

# A wire that shortens by its whole length does not exist: larger numbers are percent, not fractions.
_STRAINS = frozenset({"reference_strain", "target_strain", "strain_heating", "strain_cooling"})


@dataclass(frozen=True)
class Understanding:
    """How a file was understood: which header became which column, and which were left out.

    Parameters
    ----------
    path
        The file.
    layout
        How the file is built, in words: "CSV, separated by semicolons".
    row_count
        Number of rows, n_times.
    taken
        The headers that became columns, with unit and factor.
    ignored
        The headers that did not, each with the reason.
    metadata
        The metadata in the file.
    """

    path: str
    layout: str
    row_count: int
    taken: tuple[MatchedHeader, ...]
    ignored: tuple[IgnoredHeader, ...]
    metadata: Mapping[str, MetadataValue]

    def as_dict(self) -> dict[str, object]:
        """Return plain values for JSON."""
        return {
            "path": self.path,
            "layout": self.layout,
            "rows": self.row_count,
            "taken": [asdict(item) for item in self.taken],
            "ignored": [asdict(item) for item in self.ignored],
            "metadata": dict(self.metadata),
        }

    def __str__(self) -> str:
        """Return the report as lines of text."""
        lines = [f"{self.path}: {self.layout}, {self.row_count} rows"]
        lines += [f"  '{item.header}' -> {item.column}{_arithmetic(item)} ({item.how})" for item in self.taken]
        lines += [f"  '{item.header}' ignored: {item.reason}" for item in self.ignored]
        lines += [f"  {key} = {value}" for key, value in self.metadata.items()]
        return "\n".join(lines)


def read_recording(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    metadata: Mapping[str, MetadataValue] | None = None,
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

    Returns
    -------
    The recording, its columns in SI units.

    Raises
    ------
    RecordingError
        If the file cannot be used: one line with file, column and row.
    CallerError
        For a NAME in ``columns`` that is no column, or metadata that no file could keep.
    MissingExtraError
        For .parquet without pyarrow.
    """
    path = Path(path)
    table = _table(path)
    taken, _ = _understood(table, columns, path)
    _check_has_clock(taken, table, path)
    if table.row_count < 2:
        raise RecordingError(f"{path}: has {table.row_count} rows; a recording needs 2 or more")
    values = {item.column: _values(item, table, path) for item in taken}
    if "time_s" in values:
        _check_clock_rises(values["time_s"], table, path)
    return _recording(values, table.metadata, path).with_metadata(metadata)


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
    headers = _table(Path(path)).headers
    return headers != numbered_headers(len(headers))


def understand(path: str | Path, columns: Mapping[str, str] | None = None) -> Understanding:
    """Return the column, unit and factor of each header of a file, and which headers are ignored.

    The numbers themselves are not checked.

    Parameters
    ----------
    path
        The file.
    columns
        As in :func:`read_recording`.

    Returns
    -------
    The report.

    Raises
    ------
    RecordingError
        If the file or its headers cannot be used.
    """
    path = Path(path)
    table = _table(path)
    taken, ignored = _understood(table, columns, path)
    return Understanding(str(path), table.layout, table.row_count, taken, ignored, table.metadata)


def _understood(
    table: Table, columns: Mapping[str, str] | None, path: Path
) -> tuple[tuple[MatchedHeader, ...], tuple[IgnoredHeader, ...]]:
    if not columns and table.headers == numbered_headers(len(table.headers)):
        raise RecordingError(
            f"{path}: has no headers; name the columns in the first line, such as 'time [s],wire_voltage_v', "
            "or map them by number: time_s=#1:s"
        )
    return understand_headers(table.headers, columns, str(path))


@dataclass(frozen=True)
class _RecordingTable:
    """A recording in musclewire's HDF5 format as a table."""

    recording: Recording

    @property
    def layout(self) -> str:
        return "musclewire HDF5"

    @property
    def headers(self) -> tuple[str, ...]:
        return self.recording.names

    @property
    def metadata(self) -> Mapping[str, MetadataValue]:
        return self.recording.metadata

    @property
    def row_count(self) -> int:
        return len(self.recording)

    def numbers(self, index: int) -> FloatArray:
        return self.recording[self.headers[index]]

    def place(self, row: int) -> str:
        return f"row {row + 1}"


def _table(path: Path) -> Table:
    read = _reader_for(path)
    if not path.is_file() and not (is_journal(path) or unfinished(path)):
        what = "is a folder" if path.is_dir() else "no such file"
        raise RecordingError(f"{path}: {what}; give the path of a recording")
    return read(path)


def _reader_for(path: Path) -> Callable[[Path], Table]:
    # Imported here: h5py and pyarrow are slow to load, and most commands read no file.
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"} or is_journal(path) or unfinished(path):
        return lambda file: _RecordingTable(read_hdf5(file))
    if suffix in {".csv", ".tsv", ".txt"}:
        from musclewire.signals.text_tables import read_text_table

        return read_text_table
    if suffix == ".parquet":
        from musclewire.signals.parquet import read_parquet_table

        return read_parquet_table
    known = ".h5, .hdf5, .csv, .tsv, .txt or .parquet"
    raise RecordingError(f"{path}: files ending in '{suffix}' are not read; export it as {known}")


def _check_has_clock(taken: tuple[MatchedHeader, ...], table: Table, path: Path) -> None:
    found = {item.column for item in taken}
    if "time_s" in found or needs_no_clock(found):
        return
    headers = ", ".join(f"'{header}'" for header in table.headers)
    raise RecordingError(
        f"{path}: no column is the time (there are {headers}): "
        f"name one 'time [s]' or map it: time_s=HEADER:s; without a clock a printed loop needs "
        f"{', '.join(BRANCH_TABLE)}, isobars need {', '.join(ISOBAR_TABLE)}"
    )


def _values(item: MatchedHeader, table: Table, path: Path) -> FloatArray:
    written = table.numbers(item.index)
    where = f"column '{item.header}'"
    bad = np.isinf(written) if item.column in _MAY_BE_NAN else ~np.isfinite(written)
    if bad.any():
        row = int(np.argmax(bad))
        message = f"{table.place(row)}, {where}: {written[row]:g} is not a finite number"
        raise RecordingError(f"{path}: {message}; correct it or remove the row")
    _check_strain_is_a_fraction(item, written, table, path)
    return item.conversion.apply(written)


def _check_strain_is_a_fraction(item: MatchedHeader, written: FloatArray, table: Table, path: Path) -> None:
    too_large = np.abs(written) > 1.0
    if item.column not in _STRAINS or item.unit_given or not too_large.any():
        return
    row = int(np.argmax(too_large))
    raise RecordingError(
        f"{path}: {table.place(row)}, column '{item.header}': {written[row]:g} is no strain as a fraction: "
        f"write '{item.header} [%]' in the header or map it: {item.column}={item.header}:%"
    )


def _check_clock_rises(time_s: FloatArray, table: Table, path: Path) -> None:
    stuck = np.diff(time_s) <= 0.0
    if not stuck.any():
        return
    row = int(np.argmax(stuck)) + 1
    before, after = float(time_s[row - 1]), float(time_s[row])
    raise RecordingError(
        f"{path}: {table.place(row)}, column time_s: the clock does not rise, {before!r} s is followed by "
        f"{after!r} s; remove the repeated rows or cut the file there"
    )


def _recording(values: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> Recording:
    try:
        return Recording(values, metadata)
    except (CallerError, RecordingError) as problem:
        # Wrong metadata in a file are the file's fault, not the caller's.
        raise RecordingError(f"{path}: {problem}") from None


def _arithmetic(item: MatchedHeader) -> str:
    if item.factor == 1.0 and not item.offset:
        return f" [{item.unit}]" if item.unit else ""
    offset = f" + {item.offset:g}" if item.offset else ""
    return f" [{item.unit}] x {item.factor:g}{offset}"
