"""LabVIEW's TDMS files, read in chunks."""

from __future__ import annotations

import logging
import weakref
from dataclasses import replace
from pathlib import Path
from typing import Any

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._file_table import FileTable, check_limits, chosen_table, damage_reported
from musclewire.extras.lab_files._named_arrays import Folder, NamedArray, parts_of


def read_tdms_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of one group of a TDMS file; None takes the only one. An index next to it is never opened.

    Raises RecordingError for a damaged file or an unclear choice.
    """
    file = _opened(path)
    with damage_reported(path, "TDMS"):
        channels = [channel for item in file.groups() for channel in item.channels()]
        check_limits(path, cells=sum(map(len, channels)))
        is_cut_off = bool(file.file_status.incomplete_final_segment)
        folders = [_folder(item, file, is_cut_off) for item in file.groups()]
        root = Folder(attributes=dict(file.properties))
        parts = parts_of([root, *folders], " ".join)
        if is_cut_off:
            note = "the file was cut off in a run: {} rows of all channels are complete"
            parts = [replace(part, notes=(*part.notes, note.format(part.row_count))) for part in parts]
        return chosen_table(path, "LabVIEW TDMS, group '{}'" + ", cut off" * is_cut_off, parts, group)


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


def _folder(group: Any, file: Any, is_cut_off: bool) -> Folder:
    """Return a group with its channels; in a file that was cut off the last values of some of them are missing."""
    folder = Folder((group.name,), attributes=dict(group.properties))
    channels = group.channels()
    numeric = [channel for channel in channels if channel.dtype.kind in "biufM"]
    for channel in [each for each in channels if each not in numeric]:
        if channel.dtype.kind == "O":
            folder.arrays.append(replace(_array(channel, len(channel), file), is_text=True))
        else:
            folder.left_out[channel.name] = "it holds no real numbers"
    least: dict[object, int] = {}
    for channel in numeric:
        clock = channel.properties.get("wf_increment")
        least[clock] = min(len(channel), least.get(clock, len(channel)))
    for channel in numeric:
        rows = least[channel.properties.get("wf_increment")] if is_cut_off else len(channel)
        folder.arrays.append(_array(channel, rows, file))
    return folder


def _array(channel: Any, rows: int, file: Any) -> NamedArray:
    # The file is closed with the last reader.
    def read(index: tuple[int | slice, ...], keep_open: Any = file) -> Any:  # noqa: ARG001
        (place,) = index
        start, stop = (place.start, place.stop) if isinstance(place, slice) else (place, place + 1)
        return channel.read_data(start, stop - start)

    return NamedArray(channel.name, (rows,), read, channel.properties, is_time=channel.dtype.kind == "M")
