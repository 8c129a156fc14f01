"""LabVIEW's measurement files (.lvm): text with a header of the file, then packets, each with a header of its own.

The format is that of National Instruments' "Specification for the LabVIEW Measurement File (.lvm)". Channels are
arrays, packets follow one another on one clock, and with several X columns each channel has a folder of its own.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import (
    FileTable,
    chosen_table,
    damage_reported,
    is_clock,
    metadata_of,
    one_line,
)
from musclewire.extras.lab_files._named_arrays import Folder, NamedArray, parts_of
from musclewire.extras.lab_files._text_lines import Line, lines_of

MAX_COLUMNS = 1_000  # cells in a row; no measuring card has as many channels
_TITLE = "LabVIEW Measurement"
_END = "***End_of_Header***"
_SEPARATORS = {"tab": "\t", "comma": ",", "semicolon": ";"}
_TECHNICAL = frozenset({
    "Writer_Version", "Reader_Version", "Separator", "Decimal_Separator", "Multi_Headings", "X_Columns", "Time_Pref",
    "Date", "Time",
})  # fmt: skip
# With these begins the header of the next packet.
_FIELDS = frozenset({"Channels", "Samples", "Date", "Time", "X_Dimension", "Y_Unit_Label", "X0", "Delta_X", "Notes"})


@dataclass(frozen=True)
class _Style:
    """How the file is written, from its first header."""

    path: Path
    separator: str
    entries: Mapping[str, str]

    @property
    def is_paired(self) -> bool:
        """Whether each channel has an X column of its own before it."""
        return self.entries.get("X_Columns", "").lower() == "multi"

    def number(self, cell: str) -> float:
        """Return a cell as a number, NaN if it is blank."""
        return float(cell.replace(self.entries.get("Decimal_Separator") or ".", ".")) if cell else np.nan


@dataclass(frozen=True)
class _Packet:
    """A packet: the fields of its header by channel, the names of its columns, and these, NaN for a blank cell."""

    style: _Style
    fields: Mapping[str, list[str]]
    names: list[str]
    columns: list[array[float]]

    def field(self, name: str, channel: int) -> str:
        """Return a field of the header for the channel of a column."""
        paired, cells = self.style.is_paired, self.fields.get(name, [])
        # Between pairs of columns the cells of a header may be blank.
        cells, index = ([cell for cell in cells if cell], channel // 2) if paired else (cells, channel - 1)
        return cells[index] if index < len(cells) else ""

    def began(self, channel: int) -> datetime | None:
        """Return when the packet began."""
        return _moment(self.field("Date", channel), self.field("Time", channel))

    def numbers(self, channel: int) -> tuple[FloatArray, FloatArray]:
        """Return the abscissa of a channel, as written or counted, and its numbers."""
        x, y = (np.array(self.columns[each]) for each in (channel - 1 if self.style.is_paired else 0, channel))
        if self.style.is_paired:
            # Channels may have fewer rows than the longest: blank cells below.
            x, y = x[~np.isnan(y)], y[~np.isnan(y)]
        if np.isnan(x).any():
            try:
                first, step = (self.style.number(self.field(name, channel)) for name in ("X0", "Delta_X"))
            except ValueError:
                first = step = np.nan
            if np.isnan(first + step):
                what = f"states neither X values nor X0 and Delta_X for channel '{one_line(self.names[channel])}'"
                raise RecordingError(f"{self.style.path}: {what}; save it with one X column")
            x = np.where(np.isnan(x), first + step * np.arange(x.size), x)
        return x, y


def is_lvm(first_line: str) -> bool:
    """Return whether the first line of a file is that of LabVIEW's measurement files, whatever its suffix."""
    return first_line.lstrip("\ufeff").startswith(_TITLE)


def read_lvm_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of an .lvm file; ``group`` chooses a channel where several have X columns that differ.

    Raises RecordingError naming the line for a cell that is no number.
    """
    with damage_reported(path, "a LabVIEW measurement file"):
        lines = lines_of(path)
        style = _style(path, lines)
        packets = list(_packets(style, lines))
        if not packets:
            raise RecordingError(f"{path}: has no line 'X_Value' with the names of channels; was it saved whole?")
        began = packets[0].began(1) or _moment(style.entries.get("Date", ""), style.entries.get("Time", ""))
        described: dict[str, object] = {key: value for key, value in style.entries.items() if key not in _TECHNICAL}
        metadata = metadata_of(described | ({"start_time": began.isoformat()} if began else {}))
        parts = parts_of(_folders(packets), lambda names: "".join(names) or "all channels")
        parts = [replace(part, metadata=metadata) for part in parts]
        return chosen_table(path, "LabVIEW measurement file, {}", parts, group)


def _style(path: Path, lines: Iterator[Line]) -> _Style:
    """Return what the file's own header says."""
    entries: dict[str, str] = {}
    separator = "\t"
    for number, line in lines:
        if number == 1 and not is_lvm(line):
            raise RecordingError(f"{path}: does not begin with '{_TITLE}'; give a file that LabVIEW wrote")
        if line.startswith(_END):
            return _Style(path, separator, entries)
        if line.startswith("Separator"):
            name = line.removeprefix("Separator").strip("\t,; ").lower()
            if name not in _SEPARATORS:
                cure = "save it with Tab, Comma or Semicolon"
                raise RecordingError(f"{path}: line {number} names a separator that is not known: {cure}")
            separator = _SEPARATORS[name]
        key, _, value = line.partition(separator)
        entries.setdefault(key.strip(), value.strip(separator).strip())
    raise RecordingError(f"{path}: has no line '{_END}'; it is cut off, use another copy")


def _packets(style: _Style, lines: Iterator[Line]) -> Iterator[_Packet]:
    """Yield the packets; special blocks are left out."""
    fields: dict[str, list[str]] = {}
    packet: _Packet | None = None
    is_special = False
    for number, line in lines:
        cells = [cell.strip() for cell in line.split(style.separator)]
        begins = cells[0] in _FIELDS or cells[0].startswith("***") or cells[0] == "X_Value"
        if packet and begins:
            yield packet
            packet = None
        if is_special or cells[0] == "***Start_Special***":
            is_special = cells[0] != "***End_Special***"
        elif cells[0] == "X_Value":
            names = [cell for cell in cells if cell]
            names = names[:-1] if names[-1].lower() == "comment" else names
            if not 1 < len(names) <= MAX_COLUMNS:
                cure = "export only those that are needed" if len(names) > 1 else "was it saved whole?"
                raise RecordingError(f"{style.path}: line {number} names {len(names) - 1:,} channels; {cure}")
            packet, fields = _Packet(style, fields, names, [array("d") for _ in names]), {}
        elif packet and any(cells):
            try:
                for index, column in enumerate(packet.columns):
                    column.append(style.number(cells[index] if index < len(cells) else ""))
            except ValueError:
                what = f"line {number} holds '{one_line(cells[index])}', which is no number"
                raise RecordingError(f"{style.path}: {what}; correct it or remove the line") from None
        elif cells[0] and not cells[0].startswith("***"):
            fields[cells[0]] = cells[1:]
    if packet:
        yield packet


def _folders(packets: Sequence[_Packet]) -> list[Folder]:
    """Return the channels with their abscissa: all in one folder, or with X columns of their own in one each."""
    first, style = packets[0], packets[0].style
    if any(packet.names != first.names for packet in packets):
        raise RecordingError(
            f"{style.path}: its packets have other channels than the first; save them as separate files"
        )
    channels = range(1, len(first.names), 2 if style.is_paired else 1)
    steps = {step: first.names[each] for each in channels if (step := first.field("Delta_X", each))}
    if not style.is_paired and len(steps) > 1:
        stated = ", ".join(f"'{one_line(name)}' every {step}" for step, name in steps.items())
        cure = "save it with one X column for each channel"
        raise RecordingError(f"{style.path}: states channels of different rates, {stated}, in one table: {cure}")
    folders = [Folder((first.names[each],)) for each in channels] if style.is_paired else [Folder()] * len(channels)
    for channel, folder in zip(channels, folders, strict=True):
        numbers = [packet.numbers(channel) for packet in packets]
        starts = [packet.began(channel) for packet in packets]
        # Relative times count from the date of their packet.
        is_absolute = style.entries.get("Time_Pref", "").lower() == "absolute"
        after_s = [
            (each - starts[0]).total_seconds() if each and starts[0] and not is_absolute else 0.0 for each in starts
        ]
        x = np.concatenate([each + late_s for (each, _), late_s in zip(numbers, after_s, strict=True)])
        measured = _array(
            first.names[channel], np.concatenate([y for _, y in numbers]), first.field("Y_Unit_Label", channel)
        )
        dimension = first.field("X_Dimension", channel) or "Time"
        unit = first.field("X_Unit_Label", channel) or ("s" if dimension == "Time" else "")
        if not folder.arrays:
            folder.arrays.append(_array("time" if dimension == "Time" else dimension, x, unit))
        folder.arrays.append(measured)
    for folder in folders:
        # A channel may itself be the time.
        if any(is_clock(next(each.columns())) for each in folder.arrays[1:]):
            del folder.arrays[0]
    return folders[: len(channels) if style.is_paired else 1]


def _array(name: str, numbers: FloatArray, unit: str) -> NamedArray:
    return NamedArray(name, numbers.shape, numbers.__getitem__, {"unit": unit})


def _moment(date: str, time: str) -> datetime | None:
    """Return a date and a time of the format's spelling, such as "2013/03/08" and "10:30:28,5130068"."""
    clock, _, fraction = time.replace(",", ".").partition(".")
    try:
        whole = datetime.strptime(f"{date} {clock}", "%Y/%m/%d %H:%M:%S")
        return whole.replace(microsecond=round(float(f"0.{fraction or 0}") * 1e6) % 1_000_000)
    except ValueError:
        return None
