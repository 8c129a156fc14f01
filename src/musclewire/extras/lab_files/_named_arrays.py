"""One model of every binary format: folders of named arrays with attributes; arrays of one length are a table.

MATLAB's structs and the groups of HDF5, netCDF and LabVIEW are such folders. What follows from names, shapes and
attributes is here: units, names of columns, clocks that are stated, metadata, and which arrays are one table.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime
from typing import Any, NamedTuple

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import MusclewireError
from musclewire.extras.lab_files._file_table import (
    MAX_CELLS_AT_ONCE,
    MAX_NAMED,
    FileColumn,
    FilePart,
    is_clock,
    metadata_of,
    one_line,
)
from musclewire.files import Cells, split_header, stated_periods_s
from musclewire.signals import columns_called, parse_quantity

MAX_COLUMNS = 10_000  # of a matrix; a damaged file may state any number

# Under these attributes programs keep the unit, the name, and the names of the columns of a matrix.
_UNITS = ("unit", "units", "unit_string", "ni_unitdescription", "engineeringunits", "uom")
_LABELS = ("long_name", "label")
_NAMES = ("columns", "column_names", "names", "fields", "channels", "labels", "headers", "variables", "colheaders")
# Attributes that say how a program keeps or draws an array, not what was measured.
_TECHNICAL = re.compile(
    "NI_|wf_|unit_string|ResultStatusTable|_NC|_Netcdf4|DIMENSION_|REFERENCE_|CLASS|VERSION|TITLE|PYTABLES|MATLAB_|H5"
)
# The netCDF conventions' times: https://cfconventions.org, section 4.4; without a zone they are UTC.
_SINCE = re.compile(r"(\w+) since (\d+-\d+-\d+)(?:[T ](\d+):(\d+)(?::(\d+(?:\.\d+)?))?)?.*")


@dataclass(frozen=True, eq=False)
class NamedArray:
    """An array: ``read`` takes an index with an entry for each dimension; it returns numbers, times or texts."""

    name: str
    shape: tuple[int, ...]
    read: Callable[[tuple[int | slice, ...]], Any]
    attributes: Mapping[str, object] = field(default_factory=dict)
    is_time: bool = False
    is_text: bool = False

    @property
    def axes(self) -> list[int]:
        """The dimensions with more than one entry, that of the rows first: the other, as many as names, or the longer.

        HDF5, MATLAB and Simulink keep a matrix either way, and a recording has more rows than columns.
        """
        axes = [axis for axis, length in enumerate(self.shape) if length != 1]
        names = len(texts_of(self.attributes, _NAMES))
        named = [axis for axis in axes if self.shape[axis] == names]
        return sorted(axes, key=lambda axis: (axis in named[-1:], -self.shape[axis]))

    @property
    def row_count(self) -> int:
        """The number of rows, 1 of a scalar."""
        return self.shape[self.axes[0]] if self.axes else 1

    @property
    def header(self) -> str:
        """The name that is written with the array, or else that under which it is kept."""
        return next(iter(texts_of(self.attributes, _LABELS, whole=True)), "") or self.name

    def columns(self) -> Iterator[FileColumn]:
        """Yield the columns: one of a vector, and of a matrix as many as are read."""
        width = self.shape[self.axes[1]] if len(self.axes) > 1 else 1
        names = texts_of(self.attributes, _NAMES)
        units = texts_of(self.attributes, _UNITS, whole=width == 1)
        for index in range(min(width, MAX_COLUMNS)):
            name = names[index] if len(names) == width > 1 else self.header + f" {index + 1}" * (width > 1)
            unit = units[index] if len(units) == width else None
            unit = "s" if self.is_time else one_line(unit) if unit else None
            yield FileColumn(one_line(name) or "unnamed", unit, self.is_text, read=self._reader(index))

    def value(self) -> Any:
        """Return the first entry."""
        return np.asarray(self.read((0,) * len(self.shape))).reshape(-1)[0]

    def _reader(self, column: int) -> Callable[[int, int], Cells]:
        rows, *columns = self.axes
        constant = _number(self.attributes.get("add_offset"), 0.0)
        factor = _number(self.attributes.get("scale_factor"), 1.0)
        blank = _number(self.attributes.get("_FillValue", self.attributes.get("missing_value")), np.nan)

        def read(start: int, stop: int) -> Cells:
            place: list[int | slice] = [column if axis in columns else 0 for axis in range(len(self.shape))]
            place[rows] = slice(start, stop)
            values = np.asarray(self.read(tuple(place))).reshape(-1)
            if self.is_text:
                return [one_line(decoded(text) or "") for text in values]
            if self.is_time:
                return _seconds_since(self.value(), values)
            numbers = values.astype(np.float64)
            numbers[numbers == blank] = np.nan
            # Whole numbers are packed by the conventions of netCDF; next to others a factor may say anything.
            return numbers * factor + constant if values.dtype.kind in "iu" else numbers

        return read


@dataclass
class Folder:
    """Arrays that are kept together, their attributes and single numbers, and what was left out, in words."""

    path: tuple[str, ...] = ()
    arrays: list[NamedArray] = field(default_factory=list)
    attributes: dict[str, object] = field(default_factory=dict)
    left_out: dict[str, str] = field(default_factory=dict)


class _Clock(NamedTuple):
    """A clock that attributes state: from ``offset`` in steps of ``increment``; when it began [s], 0 if not stated."""

    increment: float
    offset: float
    start_s: float
    name: str
    unit: str

    def column(self) -> FileColumn:
        """Return the clock as a column."""
        read = lambda start, stop: self.offset + self.increment * np.arange(start, stop, dtype=np.float64)  # noqa: E731
        return FileColumn(self.name, self.unit, read=read)


def parts_of(folders: Iterable[Folder], spelled: Callable[[tuple[str, ...]], str]) -> list[FilePart]:
    """Return the tables of a file; ``spelled`` writes a path as the format does. Attributes at the top hold for all."""
    tree = {folder.path: folder for folder in folders}
    root = tree.setdefault((), Folder())
    _give_units(tree)
    for folder in tree.values():
        folder.arrays = [_dated(_named(array, folder.attributes)) for array in folder.arrays]
    _lift_channels(tree)
    return [part for folder in tree.values() for part in _tables(folder, root, spelled)]


def texts_of(attributes: Mapping[str, object], keys: Sequence[str], whole: bool = False) -> list[str]:
    """Return the texts of the first of some attributes: those of an array, or of one text with commas between them."""
    present = {key.lower(): value for key, value in attributes.items()}
    for key in keys:
        value = present.get(key)
        if isinstance(value, (list, np.ndarray)) and np.ndim(value) == 1 and 1 < len(value) <= MAX_COLUMNS:
            return [decoded(item) or "" for item in value]
        if text := decoded(value):
            return [text] if whole else [part.strip() for part in text.split(",")]
    return []


def names_columns(name: str) -> bool:
    """Return whether texts of such a name are those of the columns next to them, and not a column."""
    return name.lower() in {*_NAMES, *_UNITS}


def decoded(value: object) -> str | None:
    """Return text as it may be kept in an attribute (bytes, text, an array of one), or None for anything else."""
    if isinstance(value, np.ndarray):
        value = value.reshape(-1)[0] if value.size == 1 else None
    if isinstance(value, bytes):
        return value.decode("utf-8", errors="replace")
    return value if isinstance(value, str) else None


def _number(value: object, otherwise: float) -> float:
    single = value.reshape(-1)[0] if isinstance(value, np.ndarray) and value.size == 1 else value
    return float(single) if isinstance(single, (int, float, np.number)) and np.isfinite(single) else otherwise


def _give_units(tree: dict[tuple[str, ...], Folder]) -> None:
    """Give arrays the units that a folder "units" next to them states by their names; Simulink's time is in seconds."""
    for path in [path for path in tree if path and path[-1].lower() in {"unit", "units"}]:
        units = tree.pop(path).attributes
        if beside := tree.get(path[:-1]):
            beside.arrays = [_with_unit(each, units.get(each.name)) for each in beside.arrays]
    for path in [path for path in tree if path and path[-1].partition("(")[0] == "signals"]:
        if beside := tree.get(path[:-1]):
            beside.arrays = [_with_unit(each, "s" if each.name == "time" else None) for each in beside.arrays]


def _with_unit(array: NamedArray, unit: object) -> NamedArray:
    return replace(array, attributes={**array.attributes, "unit": unit}) if isinstance(unit, str) else array


def _named(array: NamedArray, around: Mapping[str, object]) -> NamedArray:
    """Return a matrix with the names and units of its columns, where these are kept next to it."""
    found: dict[str, object] = {}
    for keys in (_NAMES, _UNITS):
        texts = texts_of(around, keys)
        if len(array.axes) == 2 and len(texts) in array.shape and not texts_of(array.attributes, keys):
            found[keys[0]] = texts
    return replace(array, attributes={**array.attributes, **found}) if found else array


def _lift_channels(tree: dict[tuple[str, ...], Folder]) -> None:
    """Where each folder holds one channel, and all one clock, make them arrays of the folder around them."""
    beside: dict[tuple[tuple[str, ...], int], list[tuple[Folder, NamedArray, list[NamedArray]]]] = defaultdict(list)
    for path, folder in tree.items():
        arrays = [array for array in folder.arrays if len(array.axes) in {1, 2}]
        rows = max((array.row_count for array in arrays), default=0)
        longest = [array for array in arrays if array.row_count == rows]
        clocks = [array for array in longest if _is_clock(array)]
        others = [array for array in longest if array not in clocks]
        if path and rows > 1 and len(others) == 1 and len(clocks) < 2 and _says_nothing(others[0].name, path[-1]):
            beside[path[:-1], rows].append((folder, others[0], clocks))
    for (around, rows), channels in beside.items():
        own = [array for array in tree.get(around, Folder()).arrays if array.row_count == rows]
        clocks = [clock for _, _, one in channels for clock in one]
        several = len(channels) > 1 or bool(own)
        if not several or len(clocks) not in {0, len(channels)} or not all(_same(clocks[0], one) for one in clocks[1:]):
            continue
        target = tree.setdefault(around, Folder(around))
        target.arrays += clocks[:1]
        for folder, array, _ in channels:
            name = next(iter(texts_of(folder.attributes, (*_LABELS, "name"), whole=True)), "") or folder.path[-1]
            target.arrays.append(replace(array, name=name, attributes={**folder.attributes, **array.attributes}))
            target.left_out |= folder.left_out
            del tree[folder.path]


def _is_clock(array: NamedArray) -> bool:
    return array.is_time or any(map(is_clock, array.columns()))


def _says_nothing(name: str, folder: str) -> bool:
    """Return whether a name, such as "data", does not say more than that of its folder what was measured."""
    return name == folder or not columns_called(split_header(name)[0])


def _same(one: NamedArray, other: NamedArray) -> bool:
    rows = one.row_count
    (first, *_), (second, *_) = one.columns(), other.columns()
    same = rows <= MAX_CELLS_AT_ONCE and np.array_equal(first.read(0, rows), second.read(0, rows))
    return bool(same and first.unit == second.unit and one.value() == other.value())


def _tables(folder: Folder, root: Folder, spelled: Callable[[tuple[str, ...]], str]) -> Iterator[FilePart]:
    """Yield the tables of a folder: its arrays of one length and clock; a matrix without vectors is one by itself."""
    arrays = [array for array in folder.arrays if len(array.axes) in {1, 2}]
    numeric = {array.row_count for array in arrays if not array.is_text}
    arrays = [array for array in arrays if array.row_count in numeric]
    scalars = {array.name: array.value() for array in folder.arrays if not array.axes}
    described = {**root.attributes, **folder.attributes, **scalars}
    metadata = metadata_of({key: value for key, value in described.items() if not _TECHNICAL.match(key)})
    notes = tuple(
        f"'{one_line(name)}' was left out: {what}" for name, what in list(folder.left_out.items())[:MAX_NAMED]
    )
    if not arrays and notes:
        yield FilePart(spelled(folder.path), (), 0, metadata, notes)
    found: list[tuple[int, _Clock | None, list[NamedArray]]] = []
    for rows in dict.fromkeys(array.row_count for array in arrays):
        equal = [array for array in arrays if array.row_count == rows]
        if all(len(array.axes) == 2 for array in equal):
            for array in equal:
                yield FilePart(spelled((*folder.path, array.name)), tuple(array.columns()), rows, metadata, notes)
            continue
        stated = list(dict.fromkeys(clock for array in equal if (clock := _clock(array))))
        if len(stated) < 2:
            found.append((rows, stated[0] if stated else None, equal))
        else:
            found += [(rows, clock, [each for each in equal if _clock(each) == clock]) for clock in (*stated, None)]
    first_s = min((clock.start_s for _, clock, _ in found if clock), default=0.0)
    for rows, clock, equal in found:
        columns = tuple(column for array in equal for column in array.columns())
        if clock and not any(map(is_clock, columns)):
            columns = (clock.column(), *columns)
        name = spelled(folder.path) + ("" if len(found) == 1 else _words(rows, clock, first_s))
        if columns:
            yield FilePart(name, columns, rows, {**metadata, **_started(equal)}, notes)


def _words(rows: int, clock: _Clock | None, first_s: float) -> str:
    """Return what distinguishes a table from others of its folder, as the end of its name."""
    if clock is None:
        return f", {rows} rows"
    after_s = clock.start_s - first_s
    return f", {rows} rows every {clock.increment:g} s" + (f" from {after_s:g} s" if after_s > 0.0 else "")


def _clock(array: NamedArray) -> _Clock | None:
    """Return the clock that the attributes of an array state: LabVIEW's waveform, or a rate as programs call it."""
    stated = {"dt": array.attributes.get("wf_increment"), **array.attributes}
    increment = next(iter(stated_periods_s(metadata_of(stated), unit_stated=False).values()), 0.0)
    if not increment or _is_clock(array):
        return None
    start = array.attributes.get("wf_start_time")
    start_s = _seconds_since(np.datetime64(0, "s"), np.array([start]))[0] if _is_moment(start) else 0.0
    unit = decoded(array.attributes.get("wf_xunit_string")) or "s"
    name = "time" if unit == "s" else decoded(array.attributes.get("wf_xname")) or "x"
    offset = _number(array.attributes.get("wf_start_offset"), 0.0)
    return _Clock(increment, offset, float(start_s), name, unit)


def _is_moment(value: object) -> bool:
    return isinstance(value, np.datetime64) and not np.isnat(value)


def _dated(array: NamedArray) -> NamedArray:
    """Return an array in "seconds since 2026-02-17" as one of times."""
    since = _SINCE.fullmatch(next(iter(texts_of(array.attributes, _UNITS, whole=True)), ""))
    if since is None:
        return array
    try:
        unit_s = parse_quantity(f"1 {since[1]}", "s")
        hours, minutes, seconds = (float(text or 0) for text in since.group(3, 4, 5))
        began = np.datetime64(datetime.strptime(since[2], "%Y-%m-%d"), "ns")  # UTC, as all of NumPy's
    except (MusclewireError, ValueError):
        return array
    after_s = 3600.0 * hours + 60.0 * minutes + seconds

    def read(index: tuple[int | slice, ...]) -> Any:
        nanoseconds = (np.asarray(array.read(index), dtype=np.float64) * unit_s + after_s) * 1e9
        with np.errstate(invalid="ignore"):  # NaN becomes no time
            return began + nanoseconds.astype("timedelta64[ns]")

    return replace(array, read=read, is_time=True, attributes={**array.attributes, "zone": "+00:00"})


def _started(arrays: Sequence[NamedArray]) -> dict[str, str]:
    """Return when the first row was measured, by a column of times or as LabVIEW states it."""
    moments = [(array.value(), array) for array in arrays if array.is_time]
    moments += [(array.attributes.get("wf_start_time"), array) for array in arrays]
    for moment, array in moments:
        if _is_moment(moment):
            return {"start_time": f"{moment.astype('datetime64[ms]')}{array.attributes.get('zone', '+00:00')}"}
    return {}


def _seconds_since(first: np.datetime64, times: Any) -> FloatArray:
    """Return times as seconds since ``first``; one that is no time is NaN."""
    elapsed = times.astype("datetime64[ns]") - first.astype("datetime64[ns]")
    seconds: FloatArray = elapsed.astype(np.float64) * 1e-9
    seconds[np.isnat(elapsed)] = np.nan
    return seconds
