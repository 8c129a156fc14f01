"""LabVIEW's measurement files (.lvm): text with a header of the file, then packets, each with a header of its own.

The format is that of National Instruments' "Specification for the LabVIEW Measurement File (.lvm)". Packets become
lines of one table, which is read by the rules for tables in text files.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from functools import partial
from pathlib import Path

from musclewire.errors import RecordingError, argument, nearest_hint
from musclewire.extras.lab_files._file_table import MAX_NAMED, damage_reported, is_clock, metadata_of, one_line
from musclewire.signals import CurableError, ImportMapping, Line, TextTable, lines_of, table_of_lines

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
class _LvmStyle:
    """How the file is written, from its first header."""

    separator: str
    decimal: str
    paired: bool
    absolute: bool
    start: datetime | None
    entries: Mapping[str, str]


@dataclass
class _LvmPacket:
    """One packet: the names of its columns, the fields of its header, and its numbered rows of cells as they come."""

    path: Path
    style: _LvmStyle
    names: Sequence[str]
    fields: Mapping[str, Sequence[str]]
    rows: Iterator[tuple[int, list[str]]] = field(default_factory=lambda: iter(()))

    @property
    def channels(self) -> list[int]:
        """The columns that hold channels; with several X columns, every other one does."""
        return list(range(1, len(self.names), 2 if self.style.paired else 1))

    def cell(self, name: str, channel: int) -> str:
        """Return a field of the header for a channel."""
        cells, index = self.fields.get(name, ()), (channel // 2 if self.style.paired else channel - 1)
        # Between pairs of columns the cells of a header may be blank.
        cells = [cell for cell in cells if cell] if self.style.paired else cells
        return cells[index] if index < len(cells) else ""

    def header(self, channel: int) -> str:
        """Return the name of a channel with its unit."""
        unit, name = self.cell("Y_Unit_Label", channel), self.names[channel]
        return f"{name} [{unit}]" if unit else name

    def header_of_x(self, channel: int) -> str:
        """Return the name of what the rows are counted by, with its unit."""
        dimension = self.cell("X_Dimension", channel) or "Time"
        if dimension.lower() == "time":
            return f"time [{self.cell('X_Unit_Label', channel) or 's'}]"
        unit = self.cell("X_Unit_Label", channel)
        return f"{dimension} [{unit}]" if unit else dimension

    def start(self, channel: int) -> datetime | None:
        """Return when the packet began."""
        return _moment(self.cell("Date", channel), self.cell("Time", channel))

    def counted_x(self, row: int, channel: int) -> float:
        """Return the abscissa of a row by X0 and Delta_X. Raises RecordingError if the header does not state them."""
        try:
            first, step = (
                float(self.cell(name, channel).replace(self.style.decimal, ".")) for name in ("X0", "Delta_X")
            )
        except ValueError:
            where = f"states neither X values nor X0 and Delta_X for channel '{one_line(self.names[channel])}'"
            raise RecordingError(f"{self.path}: {where}; save it with one X column") from None
        return first + step * row


def _moment(date: str, time: str) -> datetime | None:
    """Return a date and a time of the format's spelling, such as "2013/03/08" and "10:30:28,5130068"."""
    clock, _, fraction = time.replace(",", ".").partition(".")
    try:
        whole = datetime.strptime(f"{date} {clock}", "%Y/%m/%d %H:%M:%S")
        return whole.replace(microsecond=round(float(f"0.{fraction or 0}") * 1e6) % 1_000_000)
    except ValueError:
        return None


def is_lvm(first_line: str) -> bool:
    """Return whether the first line of a file is that of LabVIEW's measurement files, whatever its suffix."""
    return first_line.lstrip("\ufeff").startswith(_TITLE)


def read_lvm_table(path: Path, group: str | None = None) -> TextTable:
    """Return the table of an .lvm file, its packets one after another on one clock.

    With several X columns that differ, each channel is a table of its own, chosen by ``group``. Raises RecordingError
    naming the line for a cell that is no number.
    """
    with damage_reported(path, "a LabVIEW measurement file"):
        style = _style(path)
        first = next(_packets(path, style), None)
        if first is None:
            raise RecordingError(f"{path}: has no line 'X_Value' with the names of channels; was it saved whole?")
        channels = _chosen(first, group)
        lines = partial(_lines, path, style, channels)
        table = table_of_lines(str(path), lines, "LabVIEW measurement file", style.separator, "line")
    start = first.start(channels[0]) or style.start
    return replace(
        table, metadata=metadata_of({**style.entries, "start_time": start.isoformat() if start else ""}), notes=()
    )


def _style(path: Path) -> _LvmStyle:
    entries: dict[str, str] = {}
    separator = "\t"
    for number, line in lines_of(path):
        if number == 1 and not is_lvm(line):
            raise RecordingError(f"{path}: does not begin with '{_TITLE}'; give a file that LabVIEW wrote")
        if line.startswith(_END):
            break
        if line.startswith("Separator"):
            name = line.removeprefix("Separator").strip("\t,; ").lower()
            if name not in _SEPARATORS:
                cure = "save it with Tab, Comma or Semicolon"
                raise RecordingError(f"{path}: line {number} names a separator that is not known: {cure}")
            separator = _SEPARATORS[name]
        key, _, value = line.partition(separator)
        entries.setdefault(key.strip(), value.strip(separator).strip())
    else:
        raise RecordingError(f"{path}: has no line '{_END}'; it is cut off, use another copy")
    return _LvmStyle(
        separator,
        decimal=entries.get("Decimal_Separator", ".") or ".",
        paired=entries.get("X_Columns", "").lower() == "multi",
        absolute=entries.get("Time_Pref", "").lower() == "absolute",
        start=_moment(entries.get("Date", ""), entries.get("Time", "")),
        entries={key: value for key, value in entries.items() if key not in _TECHNICAL and value},
    )


def _packets(path: Path, style: _LvmStyle) -> Iterator[_LvmPacket]:
    """Yield the packets; special blocks are left out. The rows of one have to be read before the next is asked for."""
    cells_of = ((number, [cell.strip() for cell in line.split(style.separator)]) for number, line in lines_of(path))
    for _, cells in cells_of:
        if cells[0].startswith(_END):
            break
    fields: dict[str, list[str]] = {}
    in_special = False

    def rows() -> Iterator[tuple[int, list[str]]]:
        for number, cells in cells_of:
            if cells[0] in _FIELDS or cells[0].startswith("***"):
                # The rows have ended: the header of the next packet begins, or a special block.
                fields[cells[0]] = cells[1:]
                return
            if any(cells):
                yield number, cells

    for number, cells in cells_of:
        first = cells[0]
        if in_special or first == "***Start_Special***":
            in_special = first != "***End_Special***"
        elif first == "X_Value":
            names = [cell for cell in cells if cell]
            names = names[:-1] if names[-1].lower() == "comment" else names
            if len(names) < 2:
                raise RecordingError(f"{path}: line {number} names no channel; was it saved whole?")
            packet = _LvmPacket(path, style, names, dict(fields), rows())
            fields.clear()
            yield packet
            in_special = "***Start_Special***" in fields
        elif first and not first.startswith("***"):
            fields[first] = cells[1:]


def _chosen(first: _LvmPacket, group: str | None) -> list[int]:
    """Return the columns of the channels that are one table: those whose X columns are the same, or one by its name."""
    channels = first.channels
    steps = {cell: channel for channel in channels if (cell := first.cell("Delta_X", channel))}
    if not first.style.paired and len(steps) > 1:
        stated = ", ".join(f"'{one_line(first.names[channel])}' every {step}" for step, channel in steps.items())
        cure = "save it with one X column for each channel"
        raise RecordingError(f"{first.path}: states channels of different rates, {stated}, in one table: {cure}")
    same = not first.style.paired or all(
        len({row[channel - 1] for channel in channels if channel <= len(row)}) < 2
        for packet in _packets(first.path, first.style)
        for _, row in packet.rows
    )
    if same and group in {None, "all channels"}:
        return channels
    named = [channel for channel in channels if not same and first.names[channel] == group]
    if len(named) == 1:
        return named
    known = ["all channels"] if same else [first.names[channel] for channel in channels]
    if group is not None:
        hint = one_line(nearest_hint(group, known))
        raise RecordingError(f"{first.path}: has no group '{one_line(group)}'{hint}")
    listed = ", ".join(f"'{one_line(name)}'" for name in known[:MAX_NAMED])
    message = f"{first.path}: holds {len(known)} tables: choose one with " + argument("group", "NAME") + f": {listed}"
    raise CurableError(message, ImportMapping(group=known[0]))


def _lines(path: Path, style: _LvmStyle, channels: Sequence[int]) -> Iterator[Line]:
    """Yield one line of headers, and the rows of all packets with their abscissa in front."""
    names: Sequence[str] = ()
    began: datetime | None = None
    for packet in _packets(path, style):
        headers = [packet.header(channel) for channel in channels]
        # A channel may itself be the time.
        keeps_x = not any(map(is_clock, headers))
        if not names:
            names, began = packet.names, packet.start(channels[0])
            yield 0, style.separator.join(_quoted([packet.header_of_x(channels[0])] * keeps_x + headers))
        elif packet.names != names:
            raise RecordingError(f"{path}: its packets have other channels than the first; save them as separate files")
        start = packet.start(channels[0])
        # Relative times count from the date of their packet.
        after_s = 0.0 if style.absolute or start is None or began is None else (start - began).total_seconds()
        for row, (number, cells) in enumerate(packet.rows):
            values = [cells[channel] if channel < len(cells) else "" for channel in channels]
            # With X columns of their own, channels may have fewer rows than the longest: blank cells below.
            if not style.paired or any(values):
                x = _abscissa(cells[channels[0] - 1 if style.paired else 0], packet, row, channels[0], after_s)
                yield number, style.separator.join([x] * keeps_x + values)


def _abscissa(written: str, packet: _LvmPacket, row: int, channel: int, after_s: float) -> str:
    """Return the cell of the abscissa: as written, or counted, and later by the time since the first packet."""
    if written and not after_s:
        return written
    decimal = packet.style.decimal
    if not written:
        return repr(after_s + packet.counted_x(row, channel)).replace(".", decimal)
    try:
        return repr(after_s + float(written.replace(decimal, "."))).replace(".", decimal)
    except ValueError:
        # Whoever reads the table says which line holds a word.
        return written


def _quoted(headers: Sequence[str]) -> list[str]:
    return [f'"{header}"' if any(sign in header for sign in ",;\t") else header for header in headers]
