"""The lines of a text file, decoded piece by piece, so that no file is too large and no line endless."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO, NamedTuple

from musclewire.errors import RecordingError

__all__ = ["ConsecutiveLines", "lines_of"]

# Read at once: large enough for speed, small against the 500 MiB that an import may take.
_PIECE_BYTES = 1 << 22
# A row of a thousand columns of 20 characters is 50 times shorter.
_MAX_LINE_LENGTH = 1_000_000
# A quoted cell may hold line breaks; one that never ends must not swallow the file.
_MAX_LINES_OF_A_CELL = 30
_OPEN_QUOTE = re.compile(r'(?:^|[,;\t|] ?)"(?:[^"]|"")*$')

# What files begin with that only pretend to be text, and what to do.
_BINARY = (
    (b"PK\x03\x04", "is a workbook or an archive: rename it to .xlsx if a spreadsheet wrote it, or export it as CSV"),
    (b"\xd0\xcf\x11\xe0", "is an old Excel workbook (.xls): save it as .xlsx or CSV"),
    (b"\x1f\x8b", "is compressed: unpack it with gunzip first"),
    (b"BZh", "is compressed: unpack it with bunzip2 first"),
    (b"\xfd7zXZ", "is compressed: unpack it with unxz first"),
    (b"\x28\xb5\x2f\xfd", "is compressed: unpack it with unzstd first"),
    (b"\x89HDF\r\n", "is an HDF5 file: rename it to .h5"),
    (b"PAR1", "is a Parquet file: rename it to .parquet"),
    (b"TDSm", "is a LabVIEW TDMS file: rename it to .tdms"),
    (b"MATLAB ", "is a MATLAB file: rename it to .mat"),
    (b"%PDF", "is a PDF document: export the table itself as CSV"),
    (b"<!DOCTYPE", "is a web page: export the table itself as CSV"),
    (b"<html", "is a web page: export the table itself as CSV"),
)


class ConsecutiveLines(NamedTuple):
    """Some consecutive lines without their ends, and the number of the first, from 1.

    ``ends`` is False for the last lines of a file whose last line has no end, as a recording has that was cut off.
    """

    first: int
    texts: list[str]
    ends: bool = True


def lines_of(path: Path) -> Iterator[ConsecutiveLines]:
    """Yield the lines of a text file, piece by piece.

    UTF-8 (with single bytes of Windows-1252), UTF-16 and UTF-32 are recognised. Raises RecordingError if the file
    cannot be read, is no text, or has a line longer than any row of a table.
    """
    try:
        with path.open("rb") as file:
            yield from _lines(file, path)
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror}; check the file") from None


def _lines(file: BinaryIO, path: Path) -> Iterator[ConsecutiveLines]:
    decoder = _decoder(file.read(4096), path)
    file.seek(0)
    number, carried = 1, ""
    while True:
        raw = file.read(_PIECE_BYTES)
        text = carried + _decoded(decoder, raw, path)
        _check_no_nul(text, number, path)
        # The other half of a line's end may be in the next piece.
        half = "\r" if raw and text.endswith("\r") else ""
        texts, last = _split(text[: len(text) - len(half)])
        _check_lengths([*texts, last] if len(text) > _MAX_LINE_LENGTH else (), number, path)
        if not raw:
            yield ConsecutiveLines(number, [*texts, last] if last else texts, ends=not last)
            return
        yield ConsecutiveLines(number, texts)
        number += len(texts) + (sum(text.count("\n") for text in texts) if '"' in text else 0)
        carried = last + half


def _split(text: str) -> tuple[list[str], str]:
    """Return the complete lines of a text, and what follows the last line's end."""
    # Only these end a line: str.splitlines would also split at form feeds and at U+2028.
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    # Old systems end a file by this sign.
    text = text.rstrip("\x1a") if text.endswith("\x1a") else text
    *texts, last = text.split("\n")
    return _whole_quotes(texts, last) if '"' in text else (texts, last)


def _decoder(head: bytes, path: Path) -> codecs.IncrementalDecoder:
    for beginning, cure in _BINARY:
        if head.startswith(beginning):
            raise RecordingError(f"{path}: {cure}")
    return codecs.getincrementaldecoder(_encoding(head))(errors="musclewire-windows-1252")


def _encoding(head: bytes) -> str:
    if head.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        return "utf-32"
    if head.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    # Without a mark: in UTF-16 every other byte of plain characters is zero.
    even, odd = head[0::2], head[1::2]
    if odd and odd.count(0) > 0.8 * len(odd) and not even.count(0):
        return "utf-16-le"
    if even and even.count(0) > 0.8 * len(even) and not odd.count(0):
        return "utf-16-be"
    return "utf-8-sig"


def _decoded(decoder: codecs.IncrementalDecoder, raw: bytes, path: Path) -> str:
    try:
        return decoder.decode(raw, final=not raw)
    except UnicodeError:
        raise RecordingError(f"{path}: is not a text file; export it as CSV") from None


def _single_bytes(problem: UnicodeError) -> tuple[str, int]:
    """Decode what is no UTF-8 as Windows-1252, in which Western programs still write degree signs."""
    if not isinstance(problem, UnicodeDecodeError) or not problem.encoding.startswith("utf-8"):
        raise problem
    wrong = problem.object[problem.start : problem.end]
    return wrong.decode("cp1252", errors="replace"), problem.end


codecs.register_error("musclewire-windows-1252", _single_bytes)


def _check_no_nul(text: str, number: int, path: Path) -> None:
    found = text.find("\0")
    if found < 0:
        return
    before = text[max(0, found - 1000) : found]
    if number == 1 and (not before.strip() or any(sign < " " and sign not in "\t\n\r\f\x1a" for sign in before)):
        raise RecordingError(f"{path}: is not a text file; export it as CSV")
    line = number + text.count("\n", 0, found)
    raise RecordingError(
        f"{path}: line {line} holds NUL characters, as a logger leaves them that lost its power: "
        "delete everything from that line on"
    )


def _check_lengths(texts: list[str] | tuple[()], number: int, path: Path) -> None:
    for offset, text in enumerate(texts):
        if len(text) > _MAX_LINE_LENGTH:
            raise RecordingError(
                f"{path}: line {number + offset} has more than {_MAX_LINE_LENGTH:,} characters, which is no row of a "
                "table; write one row a line"
            )


def _whole_quotes(texts: list[str], last: str) -> tuple[list[str], str]:
    """Join lines of which a quoted cell holds the end; the beginning of a cell at the end stays in ``last``."""
    joined: list[str] = []
    waiting: list[str] = []
    for text in texts:
        waiting.append(text)
        # A quote inside of a cell is an inch; only one that begins a cell has to end.
        opens = bool(waiting[1:]) or _OPEN_QUOTE.search(text) is not None
        if not opens or (waiting[1:] and text.count('"') % 2):
            joined.append("\n".join(waiting))
            waiting = []
        elif len(waiting) > _MAX_LINES_OF_A_CELL:
            joined += waiting
            waiting = []
    return joined, "\n".join([*waiting, last])
