"""Checks the structure of a MATLAB 5 file before SciPy reads it: sizes that its bytes can hold, and how deep it nests.

SciPy allocates what a header states (cells, structs, text) before it finds that the bytes are missing.
Format: MathWorks, "MAT-File Format", version 5.
"""

from __future__ import annotations

import math
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

from musclewire.errors import RecordingError

__all__ = ["MAX_BYTES", "check_matlab5"]

MAX_BYTES = 2**29

_MATRIX, _COMPRESSED = 14, 15
_SPARSE, _OPAQUE = 5, 17
_HEADER_BYTES = 128
_PIECE_BYTES = 2**20
MAX_DEPTH = 40


def check_matlab5(path: Path) -> None:
    """Raise RecordingError if an element of the file is cut off, states more than its bytes can hold, or is too large.

    Compressed elements are unpacked one at a time and never beyond ``MAX_BYTES`` in total.
    """
    with path.open("rb") as file:
        data = file.read(MAX_BYTES + 1)
    if len(data) > MAX_BYTES:
        raise _too_large(path)
    order = ">" if data[126:128] == b"MI" else "<"
    unpacked = 0
    for kind, content in _elements(memoryview(data)[_HEADER_BYTES:], order, path, padded=False):
        if kind == _COMPRESSED:
            plain = _unpacked(content, MAX_BYTES - unpacked, path)
            unpacked += len(plain)
            for inner_kind, inner in _elements(memoryview(plain), order, path):
                _check(inner_kind, inner, order, path, 0)
        else:
            _check(kind, content, order, path, 0)


def _too_large(path: Path) -> RecordingError:
    size = MAX_BYTES // 2**20
    return RecordingError(f"{path}: holds more than {size} MiB; save it in MATLAB with '-v7.3', which is read in parts")


def _unpacked(content: memoryview, room: int, path: Path) -> bytes:
    """Return the unpacked element. Its size is counted first, piece by piece: growing memory would hold it twice."""
    stream, size, rest = zlib.decompressobj(), 0, bytes(content)
    while rest and not stream.eof:
        size += len(stream.decompress(rest, _PIECE_BYTES))
        rest = stream.unconsumed_tail
        if size > room:
            raise _too_large(path)
    return zlib.decompressobj().decompress(content, size + 1)


def _elements(data: memoryview, order: str, path: Path, padded: bool = True) -> Iterator[tuple[int, memoryview]]:
    """Yield kind and content of each element; small ones keep both in one word, others are filled up to eight bytes."""
    position = 0
    while position + 8 <= len(data):
        kind, size = struct.unpack_from(f"{order}II", data, position)
        if kind >> 16:
            yield kind & 0xFFFF, data[position + 4 : position + 4 + min(kind >> 16, 4)]
            position += 8
            continue
        if position + 8 + size > len(data):
            raise RecordingError(f"{path}: is cut off or damaged (an element states {size} bytes); use another copy")
        yield kind, data[position + 8 : position + 8 + size]
        # Elements of the file itself follow each other without a gap if they are compressed.
        position += 8 + size + (-size % 8 if padded or kind != _COMPRESSED else 0)


def _check(kind: int, content: memoryview, order: str, path: Path, depth: int) -> None:
    """Check one element and, if it is an array, those within it."""
    if kind != _MATRIX or not len(content):
        return
    if depth > MAX_DEPTH:
        raise RecordingError(f"{path}: nests more than {MAX_DEPTH} levels; save the vectors themselves")
    parts = list(_elements(content, order, path))
    if len(parts) < 2 or len(parts[0][1]) < 4:
        raise RecordingError(f"{path}: is damaged (an array without a size); use another copy")
    matlab_class = struct.unpack_from(f"{order}I", parts[0][1])[0] & 0xFF
    if matlab_class not in {_SPARSE, _OPAQUE}:
        sizes = struct.unpack(f"{order}{len(parts[1][1]) // 4}i", parts[1][1][: len(parts[1][1]) // 4 * 4])
        if min(sizes, default=0) < 0 or math.prod(sizes) > len(content):
            stated = " x ".join(map(str, sizes[:4]))
            raise RecordingError(f"{path}: is damaged (an array states {stated} elements); use another copy")
    for inner_kind, inner in parts:
        _check(inner_kind, inner, order, path, depth + 1)
