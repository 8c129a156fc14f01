"""Tables of numbers in files of other programs, read column by column and in ranges of rows."""

from __future__ import annotations

import contextlib
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from musclewire.errors import MusclewireError, RecordingError, argument, nearest_hint
from musclewire.files import (
    BLOCK_ROWS,
    Cells,
    CurableError,
    ImportMapping,
    RowBlock,
    SourceColumn,
    split_header,
    stated_periods_s,
)
from musclewire.signals import MetadataValue, checked_metadata, columns_called, entry_from_text, key_of_header, measures

# Characters: a longer name or text was not written by a person, and would fill the screen.
MAX_TEXT_LENGTH = 200
MAX_METADATA = 200  # entries: more are a program's settings, not facts of a test
MAX_NAMED = 8  # names that a message lists: more are not read

MAX_BYTES_AT_ONCE = 2**29  # of a file that is read as a whole: a reader takes several times its size in memory
MAX_BYTES_UNPACKED = 2**30  # of all members of a zip file together: a small one may unpack to more than any memory
# Numbers, since a file may state far more than its bytes hold: 1 GiB of them, all in memory,
MAX_CELLS_AT_ONCE = 2**27
MAX_CELLS = 2**32  # and 32 GiB, read in blocks


@dataclass(frozen=True)
class FileColumn(SourceColumn):
    """A column in a file: ``read(start, stop)`` returns the cells of these rows."""

    read: Callable[[int, int], Cells] = field(kw_only=True)


@dataclass(frozen=True)
class FilePart:
    """One table of a file that may hold several: a group, a sheet, a struct."""

    name: str
    columns: tuple[SourceColumn, ...]
    row_count: int
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class FileTable(FilePart):
    """The part that was chosen in a file, handed over in blocks of rows: a :class:`SourceTable`."""

    path: str = ""
    layout: str = ""

    @property
    def stated_periods_s(self) -> Mapping[str, float]:
        """The times between rows [s] that the metadata state."""
        return stated_periods_s(self.metadata, unit_stated=False)

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, read from the file block by block; each call begins again."""
        if not indices:
            # Whoever only counts the rows does not wait for as many as a damaged file may state.
            yield RowBlock((), lambda row: f"row {1 + row}", self.row_count)
            return
        for start in range(0, self.row_count, BLOCK_ROWS):
            stop = min(start + BLOCK_ROWS, self.row_count)
            values = tuple(self._rows(self.columns[index], start, stop) for index in indices)
            yield RowBlock(values, lambda row, first=start + 1: f"row {first + row}", stop - start)  # type: ignore[misc]

    def _rows(self, column: SourceColumn, start: int, stop: int) -> Cells:
        assert isinstance(column, FileColumn)
        with damage_reported(self.path, self.layout):
            values = column.read(start, stop)
            if len(values) != stop - start:
                ends = f"column '{column.header}' ends after {start + len(values)} of {self.row_count} rows"
                raise RecordingError(f"{self.path}: is cut off, {ends}; use another copy")
            return values


def check_limits(path: Path, cells: int = 0, at_once: bool = False) -> None:
    """Raise RecordingError for a file larger, or that states more cells, than are read in blocks or at once."""
    most = MAX_CELLS_AT_ONCE if at_once else MAX_CELLS
    if cells > most:
        raise RecordingError(f"{path}: states {cells} numbers, of which {most} are read; export a part of it")
    if at_once and path.stat().st_size > MAX_BYTES_AT_ONCE:
        cure = "save it in parts, or as a format that is read in parts (HDF5, MATLAB's -v7.3)"
        raise RecordingError(f"{path}: has more than {MAX_BYTES_AT_ONCE // 2**20} MiB; {cure}")
    if zipfile.is_zipfile(path):
        with zipfile.ZipFile(path) as members:
            unpacked = sum(member.file_size for member in members.infolist())
        if unpacked > MAX_BYTES_UNPACKED:
            limit = f"unpacks to more than {MAX_BYTES_UNPACKED // 2**20} MiB"
            raise RecordingError(f"{path}: {limit}; save the sheet as CSV")


@contextlib.contextmanager
def damage_reported(path: str | Path, what: str) -> Iterator[None]:
    """Turn whatever a reader of another package raises about a file into a RecordingError; our own errors pass."""
    try:
        yield
    except MusclewireError:
        raise
    except Exception as problem:  # struct.error, KeyError, UnicodeDecodeError, MemoryError, plain Exception
        reason = one_line(str(problem)) or type(problem).__name__
        raise RecordingError(f"{path}: cannot be read as {what} ({reason}); use another copy") from None


def chosen_table(path: Path, layout: str, parts: Sequence[FilePart], wanted: str | None) -> FileTable:
    """Return the part called ``wanted``, or with None the only one with two rows or more; ``{}`` becomes its name.

    Raises RecordingError for another name, and where several would do.
    """
    full = [part for part in parts if part.row_count > 1]
    if wanted is not None:
        full = [part for part in parts if part.name == wanted]
        full = full or [part for part in parts if key_of_header(part.name) == key_of_header(wanted)]
    if len(full) == 1:
        return FileTable(**vars(full[0]), path=str(path), layout=layout.replace("{}", one_line(full[0].name)))
    if wanted is not None:
        hint = nearest_hint(wanted, [part.name for part in parts])
        raise RecordingError(f"{path}: has no group '{one_line(wanted)}'{one_line(hint)}")
    if not full:
        why = next((f" ({part.notes[0]})" for part in parts if part.notes), "")
        what = f"holds no table of two rows or more of numbers{why}"
        raise RecordingError(f"{path}: {what}; check that it was saved whole")
    listed = "; ".join(map(_described, full[:MAX_NAMED]))
    more = f"; and {len(full) - MAX_NAMED} more" if len(full) > MAX_NAMED else ""
    # The largest one is the example.
    largest = max(full, key=lambda part: part.row_count).name
    message = f"{path}: holds {len(full)} tables: choose one with " + argument("group", "NAME") + f": {listed}{more}"
    raise CurableError(message, ImportMapping(group=largest))


def _described(part: FilePart) -> str:
    headers = [
        f"'{each.header} [{each.unit}]'" if each.unit else f"'{each.header}'" for each in part.columns[:MAX_NAMED]
    ]
    more = ", ..." if len(part.columns) > MAX_NAMED else ""
    return f"'{one_line(part.name)}' ({part.row_count} rows: {', '.join(headers)}{more})"


def is_clock(column: SourceColumn) -> bool:
    """Return whether a column is the time, by its name and unit."""
    name, unit = split_header(column.header)
    named = name == "time_s" or any(known.name == "time_s" for known in columns_called(name))
    return named and measures(column.unit or unit or "s", "time_s")


def metadata_of(entries: Mapping[str, object]) -> dict[str, MetadataValue]:
    """Return properties of a file as metadata: those whose name and value a recording can keep, at most 200."""
    found: dict[str, MetadataValue] = {}
    for name, value in list(entries.items())[:MAX_METADATA]:
        entry = _entry(str(name), value)
        if entry is not None:
            found.setdefault(*entry)
    return found


def _entry(name: str, value: object) -> tuple[str, MetadataValue] | None:
    if isinstance(value, np.ndarray) and value.size == 1:
        value = value.reshape(-1)[0]
    plain = value.item() if isinstance(value, np.generic) and not isinstance(value, np.datetime64) else value
    if isinstance(plain, bytes):
        plain = plain.decode("utf-8", errors="replace")
    if isinstance(plain, np.datetime64):
        plain = str(plain.astype("datetime64[ms]"))
    # Keys are those of a comment in a text file; its value decides there what is text and what a number.
    named = entry_from_text(name, one_line(plain) if isinstance(plain, str) else "0")
    if named is None or (isinstance(plain, str) and not plain.strip()):
        return None
    entry = named if isinstance(plain, str) else (named[0], plain)
    try:
        return entry[0], checked_metadata({entry[0]: entry[1]})[entry[0]]  # type: ignore[dict-item]
    except MusclewireError:
        return None


def one_line(text: str) -> str:
    """Return text from a file as one printable line of bounded length."""
    printable = "".join(character if character.isprintable() else " " for character in text[: 4 * MAX_TEXT_LENGTH])
    line = " ".join(printable.split())
    return line if len(line) <= MAX_TEXT_LENGTH else line[: MAX_TEXT_LENGTH - 3] + "..."
