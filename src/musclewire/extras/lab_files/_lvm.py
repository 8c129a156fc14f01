"""LabVIEW's measurement files (.lvm): text with a header of the file, then packets, each with a header of its own.

The format is that of National Instruments' "Specification for the LabVIEW Measurement File (.lvm)". The reader is our
own: the one on PyPI keeps and reads back a pickle next to the file, and a pickle can execute code.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import (
    FileColumn,
    FilePart,
    FileTable,
    chosen_part,
    file_table,
    has_clock,
    metadata_of,
    one_line,
)

__all__ = ["read_lvm_table", "is_lvm"]

_TITLE = "LabVIEW Measurement"
_END = "***End_of_Header***"
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
MAX_LINE_LENGTH = 1_000_000
MAX_CHANNELS = 10_000
_TECHNICAL = frozenset({
    "Writer_Version", "Reader_Version", "Separator", "Decimal_Separator", "Multi_Headings", "X_Columns", "Time_Pref",
    "Date", "Time",
})  # fmt: skip


@dataclass(frozen=True)
class _LvmStyle:
    """How the file is written, from its first header."""

    separator: str
    decimal: str
    x_columns: str
    absolute: bool
    start: datetime | None
    entries: Mapping[str, str]


@dataclass
class _LvmPacket:
    """One packet: the fields of its header, the names of its columns, and its numbers row by row."""

    names: list[str]
    fields: Mapping[str, Sequence[str]]
    values: array[float] = field(default_factory=lambda: array("d"))

    def header_cells(self, name: str) -> list[str]:
        """Return a field of the header, one cell per channel; empty if the packet does not state it."""
        return list(self.fields.get(name, ()))

    @property
    def numbers(self) -> FloatArray:
        """All rows, shape (n_rows, n_columns); a blank cell is NaN."""
        return np.frombuffer(self.values, dtype=np.float64).reshape(-1, len(self.names))


def is_lvm(first_line: str) -> bool:
    """Return whether the first line of a file is that of LabVIEW's measurement files, whatever its suffix."""
    return first_line.lstrip("\ufeff").startswith(_TITLE)


def read_lvm_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of an .lvm file, its packets one after another on one clock.

    With several X columns that differ, each channel is a table of its own, chosen by ``group``. Raises RecordingError
    naming the line for a cell that is no number.
    """
    lines = _NumberedLines(path)
    style = _style(lines)
    packets = list(_packets(lines, style))
    if not packets:
        raise RecordingError(f"{path}: has no line 'X_Value' with the names of channels; was it saved whole?")
    names = packets[0].names
    for packet in packets[1:]:
        if packet.names != names:
            raise RecordingError(f"{path}: its packets have other channels than the first; save them as separate files")
    part = chosen_part(_parts(packets, style, path), group, path)
    comma = ", decimal comma" if style.decimal == "," else ""
    layout = (
        f"LabVIEW measurement file, {len(packets)} packets{comma}"
        if len(packets) > 1
        else (f"LabVIEW measurement file{comma}")
    )
    return file_table(path, layout, part)


class _NumberedLines:
    """The lines of a file with their numbers, one at a time."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.number = 0

    def __iter__(self) -> Iterator[str]:
        """Yield each line without its end. Raises RecordingError for binary contents."""
        self.number = 0
        encoding = _encoding(self.path)
        with self.path.open(encoding=encoding, errors="replace", newline=None) as file:
            while line := file.readline(MAX_LINE_LENGTH):
                self.number += 1
                if "\0" in line or len(line) == MAX_LINE_LENGTH:
                    raise self.problem("is no text; use another copy")
                yield line.rstrip("\n")

    def problem(self, what: str) -> RecordingError:
        """Return an error that names the line being read."""
        return RecordingError(f"{self.path}: line {self.number} {what}")


def _encoding(path: Path) -> str:
    with path.open("rb") as file:
        start = file.read(65536)
    if start.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    try:
        start.decode("utf-8-sig")
    except UnicodeDecodeError as problem:
        # The cut at the end may fall within a character; anything else is the encoding of Windows.
        return "utf-8-sig" if problem.start > len(start) - 4 else "cp1252"
    return "utf-8-sig"


def _style(lines: _NumberedLines) -> _LvmStyle:
    entries: dict[str, str] = {}
    separator = "\t"
    for line in lines:
        if lines.number == 1 and not is_lvm(line):
            raise RecordingError(f"{lines.path}: does not begin with '{_TITLE}'; give a file that LabVIEW wrote")
        if line.startswith(_END):
            break
        if line.startswith("Separator"):
            separator = _separator(line, lines)
        key, _, value = line.partition(separator)
        entries.setdefault(key.strip(), value.strip(separator).strip())
    else:
        raise RecordingError(f"{lines.path}: has no line '{_END}'; it is cut off, use another copy")
    return _LvmStyle(
        separator=separator,
        decimal=entries.get("Decimal_Separator", ".") or ".",
        x_columns=entries.get("X_Columns", "One").lower(),
        absolute=entries.get("Time_Pref", "").lower() == "absolute",
        start=_moment(entries.get("Date", ""), entries.get("Time", "")),
        entries={key: value for key, value in entries.items() if key not in _TECHNICAL and value},
    )


def _separator(line: str, lines: _NumberedLines) -> str:
    """Return the separator by its name, which is also between the two cells of this line."""
    rest = line.removeprefix("Separator")
    by_name = _SEPARATORS.get(rest.strip("\t,; ").lower())
    if by_name is None:
        raise lines.problem("names a separator that is not known: save it with Tab, Comma or Semicolon")
    return by_name


def _packets(lines: _NumberedLines, style: _LvmStyle) -> Iterator[_LvmPacket]:
    """Yield the packets; special blocks are left out. A packet without a header continues the one before."""
    fields: dict[str, list[str]] = {}
    packet: _LvmPacket | None = None
    in_special = past_header = False
    for line in lines:
        cells = [cell.strip() for cell in line.split(style.separator)]
        first = cells[0]
        if not past_header:
            past_header = line.startswith(_END)
        elif in_special or first == "***Start_Special***":
            in_special = first != "***End_Special***"
        elif first == "X_Value":
            packet = _LvmPacket(_names(cells, lines), fields)
            fields = {}
            yield packet
        elif first in {"Channels", "Samples", "Date", "Time", "X_Dimension", "Y_Unit_Label", "X0", "Delta_X", "Notes"}:
            # The header of the next packet: the rows of the one before have ended.
            packet = None
            fields[first] = cells[1:]
        elif packet is None and not line.startswith("***") and first:
            fields[first] = cells[1:]
        elif packet is not None and any(cells):
            packet.values.extend(_row(cells, packet, style, lines))


def _names(cells: Sequence[str], lines: _NumberedLines) -> list[str]:
    names = [cell for cell in cells if cell]
    names = names[:-1] if names[-1].lower() == "comment" else names
    if not 1 < len(names) <= MAX_CHANNELS:
        raise lines.problem(f"names {len(names) - 1} channels; 1 to {MAX_CHANNELS} are read")
    return names


def _row(cells: Sequence[str], packet: _LvmPacket, style: _LvmStyle, lines: _NumberedLines) -> list[float]:
    """Return the numbers of a row; the comment behind them is left out, and a blank cell is NaN."""
    numbers = [math.nan] * len(packet.names)
    for index, cell in enumerate(cells[: len(packet.names)]):
        text = cell.replace(style.decimal, ".") if style.decimal != "." else cell
        if not text:
            continue
        try:
            numbers[index] = float(text)
        except ValueError:
            what = f"column '{one_line(packet.names[index])}': '{one_line(cell)}' is not a number"
            raise lines.problem(f"{what}; correct it or remove the line") from None
    return numbers


def _parts(packets: Sequence[_LvmPacket], style: _LvmStyle, path: Path) -> list[FilePart]:
    names = packets[0].names
    numbers = np.concatenate([packet.numbers for packet in packets])
    paired = style.x_columns == "multi"
    x_of = {index: index - 1 if paired else 0 for index in range(1, len(names)) if not paired or index % 2}
    metadata = metadata_of({**style.entries, "start_time": _first_moment(packets, style) or ""})
    x_columns = sorted(set(x_of.values()))
    same = all(np.array_equal(numbers[:, 0], numbers[:, x], equal_nan=True) for x in x_columns)
    groups = [list(x_of)] if same else [[y] for y in x_of]
    parts = []
    for ys in groups:
        x = _x_values(packets, style, x_of[ys[0]], ys[0], path)
        # With X columns of their own, channels may have fewer rows than the longest: blank cells below.
        rows = len(x) if same else int(np.count_nonzero(np.isfinite(x)))
        columns = tuple(_channel(names[y], _unit(packets[0], y, paired), numbers[:, y]) for y in ys)
        if not has_clock(columns):
            columns = (_clock(packets[0], x, ys[0], paired), *columns)
        parts.append(FilePart("all channels" if same else names[ys[0]], columns, rows, metadata))
    return parts


def _channel(name: str, unit: str | None, values: FloatArray) -> FileColumn:
    return FileColumn(name, unit, lambda start, stop: values[start:stop])


def _cell(packet: _LvmPacket, name: str, y: int, paired: bool) -> str:
    """Return a field of a packet for the channel in column ``y``; there is one cell for each channel."""
    cells, index = packet.header_cells(name), (y // 2 if paired else y - 1)
    # Between pairs of columns the cells of a header may be blank.
    cells = [cell for cell in cells if cell] if paired else cells
    return cells[index] if index < len(cells) else ""


def _unit(packet: _LvmPacket, y: int, paired: bool) -> str | None:
    return _cell(packet, "Y_Unit_Label", y, paired) or None


def _clock(packet: _LvmPacket, x: FloatArray, y: int, paired: bool) -> FileColumn:
    dimension = _cell(packet, "X_Dimension", y, paired) or "Time"
    unit = _cell(packet, "X_Unit_Label", y, paired) or ("s" if dimension.lower() == "time" else None)
    return _channel("time" if dimension.lower() == "time" else dimension, unit, x)


def _x_values(packets: Sequence[_LvmPacket], style: _LvmStyle, x: int, y: int, path: Path) -> FloatArray:
    """Return the abscissa of all rows: written, or by ``X0`` and ``Delta_X``; packets follow each other by their dates.

    Times of a file with ``Time_Pref`` absolute are seconds since 1904: the first becomes 0. Relative times count from
    the date of their packet.
    """
    paired = style.x_columns == "multi"
    found, starts = [], []
    for packet in packets:
        written = packet.numbers[:, x]
        if np.isnan(written).all():
            written = _counted(packet, y, paired, style, path)
        found.append(written)
        starts.append(_moment(_cell(packet, "Date", y, paired), _cell(packet, "Time", y, paired)))
    if not style.absolute and len(packets) > 1 and all(starts):
        moments = [start for start in starts if start is not None]
        found = [each + (moment - moments[0]).total_seconds() for each, moment in zip(found, moments, strict=True)]
    x_values = np.concatenate(found)
    since_1904 = style.absolute and x_values.size and x_values[0] > 1e9
    return x_values - x_values[0] if since_1904 else x_values


def _counted(packet: _LvmPacket, y: int, paired: bool, style: _LvmStyle, path: Path) -> FloatArray:
    texts = [_cell(packet, name, y, paired).replace(style.decimal, ".") for name in ("X0", "Delta_X")]
    try:
        first, step = (float(text) for text in texts)
    except ValueError:
        where = f"states neither X values nor X0 and Delta_X for channel '{one_line(packet.names[y])}'"
        raise RecordingError(f"{path}: {where}; save it with one X column") from None
    return first + step * np.arange(len(packet.numbers), dtype=np.float64)


def _first_moment(packets: Sequence[_LvmPacket], style: _LvmStyle) -> str | None:
    packet = packets[0]
    stated = (
        _moment(next(iter(packet.header_cells("Date")), ""), next(iter(packet.header_cells("Time")), "")) or style.start
    )
    return stated.isoformat() if stated else None


def _moment(date: str, time: str) -> datetime | None:
    """Return a date and a time of the format's spelling, such as "2013/03/08" and "10:30:28,5130068"."""
    clock, _, fraction = time.replace(",", ".").partition(".")
    try:
        whole = datetime.strptime(f"{date} {clock}", "%Y/%m/%d %H:%M:%S")
        return whole.replace(microsecond=round(float(f"0.{fraction or 0}") * 1e6) % 1_000_000)
    except ValueError:
        return None
