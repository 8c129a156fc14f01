"""The journal of a run: its rows as they come, in a file that only grows and of which every whole record can be read.

A line that names the format, a line for whoever opens it in an editor, then records: kind, number of bytes, CRC-32 and
body. The first says columns, units and metadata, the last how the run ended; between them are blocks of rows. A kill
can only tear the last record, which then is not believed.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals._columns import COLUMNS, declare_column
from musclewire.signals._metadata import MetadataValue

JOURNAL_SUFFIX = ".journal"
FORMAT = "musclewire-journal"
FORMAT_VERSION = 1
ADVICE = "These are the rows of a run that goes on or was cut off. 'musclewire recover FILE' makes plain HDF5 of them."
# The head of a record: its kind, the number of bytes that follow, and their CRC-32, begun with the CRC-32 of the kind.
HEAD = struct.Struct("<BII")
START = 1  # kind of the first record: columns, units and metadata
ROWS = 2  # of those between them: blocks of rows
END = 3  # of the last: how the run ended
# A torn record loses no more than this; and no number of bytes leaves 32 bits.
BLOCK_BYTES = 1 << 14


def journal_of(path: str | Path) -> Path:
    """Return where the journal of a recording is while its run lasts: next to it, with a suffix of its own."""
    path = Path(path)
    return path.with_name(path.name + JOURNAL_SUFFIX)


def recording_of(path: str | Path) -> Path:
    """Return the recording that a path means: its own, or that of its journal."""
    path = Path(path)
    return path.with_suffix("") if is_journal(path) else path


def is_journal(path: Path) -> bool:
    """Return whether a path names the journal of a run."""
    return path.suffix.lower() == JOURNAL_SUFFIX


def unfinished(path: Path) -> bool:
    """Return whether a recording is there only as the journal of a run that goes on or was cut off."""
    return not path.exists() and journal_of(path).is_file()


def encoded_start(columns: Sequence[str], metadata: Mapping[str, MetadataValue]) -> bytes:
    """Return the beginning of a journal: how it is built, what its columns are, and what is known of the run."""
    facts = {
        "columns": list(columns),
        "units": [COLUMNS[name].unit for name in columns],
        "rows": "float64, little-endian, row after row",
        "metadata": dict(metadata),
    }
    return f"{FORMAT} {FORMAT_VERSION}\n{ADVICE}\n".encode() + _record(START, json.dumps(facts).encode())


def encoded_rows(values: bytes) -> bytes:
    """Return a record of whole rows: float64 of this machine, row after row."""
    return _record(ROWS, np.frombuffer(values, dtype=np.float64).astype("<f8", copy=False).tobytes())


def encoded_end(ended: str, metadata: Mapping[str, MetadataValue]) -> bytes:
    """Return the last record: why the run ended, and what was not known when it began."""
    return _record(END, json.dumps({"ended": ended, "metadata": dict(metadata)}).encode())


def _record(kind: int, body: bytes) -> bytes:
    return HEAD.pack(kind, len(body), _checksum(kind, body)) + body


def _checksum(kind: int, body: bytes | memoryview) -> int:
    return zlib.crc32(body, zlib.crc32(bytes([kind])))


@dataclass(frozen=True)
class JournalContents:
    """What a journal holds."""

    columns: tuple[str, ...]
    values: FloatArray  # of the complete rows, (n_times, n_columns)
    metadata: Mapping[str, MetadataValue]
    ended: str  # "" if it does not say
    damaged_bytes: int  # after the last row, beyond a record that was being written


def parsed_journal(data: bytes, path: Path) -> JournalContents:
    """Return what a journal's bytes hold, up to the first record that is not whole. Raises RecordingError."""
    rest = memoryview(data)[_records_begin(data, path) :]
    first = _whole_record(rest)
    columns, metadata = _start_of(first, path)
    blocks, ended, record = [np.empty(0)], "", first
    while record is not None:
        kind, body = record
        if kind == ROWS and len(body) % (8 * len(columns)) == 0:
            blocks.append(np.frombuffer(body, dtype="<f8"))
        elif kind == END:
            last = _facts_of(body, path)
            ended, metadata = str(last.get("ended", "")), {**metadata, **dict(last.get("metadata", {}))}
        rest = rest[HEAD.size + len(body) :]
        record = _whole_record(rest)
    values = np.concatenate(blocks).reshape(-1, len(columns))
    return JournalContents(columns, values, metadata, ended, _damaged_bytes(rest))


def _whole_record(rest: memoryview) -> tuple[int, memoryview] | None:
    """Return kind and body of the first record of some bytes, None if it is not whole."""
    if len(rest) < HEAD.size:
        return None
    kind, size, checksum = HEAD.unpack_from(rest)
    body = rest[HEAD.size :][:size]
    whole = kind in (START, ROWS, END) and len(body) == size and _checksum(kind, body) == checksum
    return (kind, body) if whole else None


def _damaged_bytes(rest: memoryview) -> int:
    """Return how many bytes are after the last whole record, 0 if a torn one or empty blocks explain them."""
    if len(rest) < HEAD.size:
        return 0
    kind, size, _ = HEAD.unpack_from(rest)
    torn = kind in (ROWS, END) and len(rest) < HEAD.size + size
    # A power cut may leave the length of a file without its last blocks, which then read as zeros.
    return 0 if torn or not np.frombuffer(rest, dtype=np.uint8).any() else len(rest)


def _records_begin(data: bytes, path: Path) -> int:
    name, _, version = data[:100].partition(b"\n")[0].partition(b" ")
    if name != FORMAT.encode():
        raise RecordingError(f"{path}: is not a journal of musclewire; give a recording file")
    if version != str(FORMAT_VERSION).encode():
        known = f"this musclewire reads {FORMAT_VERSION}; update musclewire"
        raise RecordingError(f"{path}: is a journal of version {version[:20].decode('ascii', 'replace')}, {known}")
    return data.find(b"\n", data.find(b"\n") + 1) + 1


def _start_of(record: tuple[int, memoryview] | None, path: Path) -> tuple[tuple[str, ...], dict[str, MetadataValue]]:
    kind, body = record or (0, memoryview(b""))
    facts = _facts_of(body, path) if kind == START else {}
    columns = tuple(name for name in facts.get("columns", ()) if isinstance(name, str) and declare_column(name))
    if not columns or list(columns) != facts["columns"] or len(set(columns)) < len(columns):
        raise _damaged(path)
    return columns, dict(facts.get("metadata", {}))


def _facts_of(body: memoryview, path: Path) -> dict[str, Any]:
    try:
        facts = json.loads(bytes(body))
    except (ValueError, RecursionError):
        raise _damaged(path) from None
    if not isinstance(facts, dict) or not isinstance(facts.get("metadata", {}), dict):
        raise _damaged(path)
    return facts


def _damaged(path: Path) -> RecordingError:
    return RecordingError(f"{path}: is a damaged journal, which does not say what its rows are; use another copy")
