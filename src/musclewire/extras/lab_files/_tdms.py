"""LabVIEW's TDMS files, read in chunks."""

from __future__ import annotations

import logging
import math
import weakref
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import (
    FileColumn,
    FilePart,
    FileTable,
    check_limits,
    chosen_part,
    clock_column,
    damage_reported,
    file_table,
    has_clock,
    metadata_of,
    one_line,
    seconds_since,
)
from musclewire.signals import MetadataValue

# Properties that describe how LabVIEW keeps or draws a channel, not what was measured.
_TECHNICAL = ("NI_", "wf_", "unit_string", "ResultStatusTable")


def read_tdms_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of one group of a TDMS file; None takes the only one.

    A waveform's clock (``wf_increment``) becomes a column "time [s]". Channels of a group that differ in length or
    clock are tables of their own. Only this file is opened, never an index next to it.

    Raises RecordingError for a damaged file or an unclear choice.
    """
    file = _opened(path)
    with damage_reported(path, "TDMS"):
        channels = [channel for item in file.groups() for channel in item.channels()]
        check_limits(path, cells=sum(map(len, channels)))
        parts = [part for item in file.groups() for part in _parts_of_group(item, file)]
        part = chosen_part(parts, group, path)
        end = ", cut off" if file.file_status.incomplete_final_segment else ""
        return file_table(path, f"LabVIEW TDMS, group '{one_line(part.name)}'{end}", part)


def _opened(path: Path) -> Any:
    from nptdms import TdmsFile

    # It warns on standard error of what becomes our own line or the layout in words.
    logging.getLogger("nptdms").setLevel(logging.ERROR)
    for module in ("reader", "tdms_segment", "tdms", "types", "base_segment", "scaling"):
        logging.getLogger(f"nptdms.{module}").setLevel(logging.CRITICAL)
    with damage_reported(path, "TDMS"):
        # An open file, not a path: with a path nptdms would also open the index file next to it.
        stream = path.open("rb")
        try:
            if stream.read(4) != b"TDSm":
                raise RecordingError(f"{path}: is not a TDMS file; give the .tdms file that LabVIEW wrote")
            stream.seek(0)
            file = TdmsFile(stream, read_metadata_only=True, keep_open=True)
        except BaseException:
            stream.close()
            raise
    weakref.finalize(file, stream.close)
    return file


def _parts_of_group(group: Any, file: Any) -> list[FilePart]:
    """Return the tables of a group: one for each clock, or length of channels without a clock."""
    clocks: dict[tuple[int, float, float, float], list[Any]] = {}
    for channel in filter(_is_numeric, group.channels()):
        clocks.setdefault(_clock(channel, file.file_status.incomplete_final_segment), []).append(channel)
    text = [one_line(channel.name) for channel in group.channels() if not _is_numeric(channel)]
    notes = tuple(f"channel '{name}' was left out: it holds no real numbers" for name in text)
    if len(clocks) == 1:
        return [_part(group, channels, file, "", notes) for channels in clocks.values()]
    first_s = min((start_s for *_, start_s in clocks), default=0.0)
    return [_part(group, channels, file, _clock_words(clock, first_s), notes) for clock, channels in clocks.items()]


def _clock_words(clock: tuple[int, float, float, float], first_s: float) -> str:
    """Return what distinguishes the table of one clock from others of its group, as the end of its name."""
    rows, increment, _, start_s = clock
    every = f" every {increment:g} s" if increment else ""
    return f", {rows} rows{every}" + (f" from {start_s - first_s:g} s" if start_s > first_s and increment else "")


def _clock(channel: Any, is_cut_off: bool = False) -> tuple[int, float, float, float]:
    """Return number of values, increment, offset and start [s] of a channel; an increment of 0 is no clock.

    In a file that was cut off the last values of some channels are missing: there lengths do not count.
    """
    increment, offset = (_number(channel.properties.get(f"wf_{name}")) for name in ("increment", "start_offset"))
    start = channel.properties.get("wf_start_time")
    start_s = seconds_since(np.datetime64(0, "s"), np.array([start]))[0] if isinstance(start, np.datetime64) else 0.0
    return 0 if is_cut_off else len(channel), increment, offset, float(start_s) if math.isfinite(start_s) else 0.0


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) and math.isfinite(value) else 0.0


def _part(group: Any, channels: list[Any], file: Any, clock_words: str, notes: tuple[str, ...]) -> FilePart:
    _, increment, offset, _ = _clock(channels[0])
    rows = min(len(channel) for channel in channels)
    columns = tuple(_column(channel, file) for channel in channels)
    if increment and not has_clock(columns):
        properties = channels[0].properties
        unit = str(properties.get("wf_xunit_string") or "s")
        name = str(properties.get("wf_xname") or "x") if unit != "s" else "time"
        columns = (clock_column(increment, offset, name, unit), *columns)
    if file.file_status.incomplete_final_segment:
        notes = (*notes, f"the file was cut off in a run: {rows} rows of all channels are complete")
    return FilePart(f"{group.name}{clock_words}", columns, rows, _metadata(group, channels, file), notes)


def _is_numeric(channel: Any) -> bool:
    return channel.dtype.kind in "biufM"


def _column(channel: Any, file: Any) -> FileColumn:
    unit = channel.properties.get("unit_string") or channel.properties.get("NI_UnitDescription")

    def read(start: int, stop: int, keep_open: Any = file) -> FloatArray:  # noqa: ARG001  # closed with the last reader
        values = channel.read_data(start, stop - start)
        if values.dtype.kind == "M":
            return seconds_since(channel.read_data(0, 1)[0], values)
        return np.asarray(values, dtype=np.float64)

    is_time = channel.dtype.kind == "M"
    return FileColumn(channel.name, "s" if is_time else (str(unit) if unit else None), read)


def _metadata(group: Any, channels: list[Any], file: Any) -> dict[str, MetadataValue]:
    found = {**_described(file.properties), **_described(group.properties)}
    times = [channel for channel in channels if channel.dtype.kind == "M" and len(channel)]
    start = times[0].read_data(0, 1)[0] if times else channels[0].properties.get("wf_start_time")
    if isinstance(start, np.datetime64) and not np.isnat(start):
        found["start_time"] = f"{start.astype('datetime64[ms]')}+00:00"
    return metadata_of(found)


def _described(properties: Mapping[str, object]) -> dict[str, object]:
    return {name: value for name, value in properties.items() if not name.startswith(_TECHNICAL)}
