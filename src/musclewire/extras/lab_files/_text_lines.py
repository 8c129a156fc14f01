"""The lines of a text file in any usual encoding, one after another: no file is too large, and no line endless."""

from __future__ import annotations

import codecs
import itertools
import re
from collections.abc import Iterator
from functools import partial
from pathlib import Path

from musclewire.errors import RecordingError

# A row of a thousand columns of 20 characters is 50 times shorter.
_MAX_LINE_LENGTH = 1_000_000
# A quoted cell may hold line breaks; one that never ends must not swallow the file.
_MAX_LINES_OF_A_CELL = 30
_CONTROL = re.compile(rb"[\x01-\x08\x0b\x0e-\x19\x1b-\x1f]")
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


# The number of a line, from 1, and its text without its end.
Line = tuple[int, str]


def lines_of(path: Path) -> Iterator[Line]:
    """Yield the lines of a text file; those over which a quoted cell extends as one, with the number of the first.

    Raises RecordingError if it cannot be read, is no text, or has a line longer than any row of a table.
    """
    try:
        with path.open("rb") as file:
            encoding = _encoding(file.read(4096), path)
        # Only these end a line, whatever the system: \n, \r\n and \r, as newline=None means.
        with path.open(encoding=encoding, errors="musclewire-windows-1252", newline=None) as stream:
            yield from _whole_rows(enumerate(iter(partial(stream.readline, _MAX_LINE_LENGTH), ""), start=1), path)
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror}; check the file") from None
    except UnicodeError:
        raise RecordingError(f"{path}: is not a text file; export it as CSV") from None


def ends_within_a_line(path: Path) -> bool:
    """Return whether the last line of a file has no end, as in one that is still being written."""
    with path.open("rb") as file:
        file.seek(0, 2)
        file.seek(-min(8, file.tell()), 2)
        return not file.read().rstrip(b"\0\x1a").endswith((b"\n", b"\r"))


def _whole_rows(lines: Iterator[Line], path: Path) -> Iterator[Line]:
    for number, line in lines:
        if len(line) == _MAX_LINE_LENGTH or "\0" in line:
            raise _no_row(number, line, path)
        text = line.rstrip("\n\x1a")
        # A quote inside of a cell is an inch; only one that begins a cell has to end, and a comment has no cells.
        if '"' not in text or text.startswith("#") or _OPEN_QUOTE.search(text) is None:
            yield number, text
            continue
        cell = [(number, text)]
        for following, more in itertools.islice(lines, _MAX_LINES_OF_A_CELL):
            if "\0" in more:
                raise _no_row(following, more, path)
            cell.append((following, more.rstrip("\n")))
            if more.count('"') % 2:
                break
        if len(cell) > _MAX_LINES_OF_A_CELL:
            yield from cell
        else:
            yield number, "\n".join(each for _, each in cell)


def _no_row(number: int, line: str, path: Path) -> RecordingError:
    if "\0" not in line:
        what = f"has more than {_MAX_LINE_LENGTH:,} characters, which is no row of a table; write one row a line"
    else:
        what = "holds NUL characters, as a logger leaves them that lost its power: delete everything from that line on"
    return RecordingError(f"{path}: line {number} {what}")


def _encoding(head: bytes, path: Path) -> str:
    """Return the encoding of a text by its first bytes. Raises RecordingError for what only pretends to be text."""
    for beginning, cure in _BINARY:
        if head.startswith(beginning):
            raise RecordingError(f"{path}: {cure}")
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
    if b"\0" in head and (_CONTROL.search(head.partition(b"\0")[0]) or head.startswith(b"\0")):
        raise RecordingError(f"{path}: is not a text file; export it as CSV")
    return "utf-8-sig"


def _single_bytes(problem: UnicodeError) -> tuple[str, int]:
    """Decode what is no UTF-8 as Windows-1252, in which Western programs still write degree signs."""
    if not isinstance(problem, UnicodeDecodeError) or not problem.encoding.startswith("utf-8"):
        raise problem
    wrong = problem.object[problem.start : problem.end]
    return wrong.decode("cp1252", errors="replace"), problem.end


codecs.register_error("musclewire-windows-1252", _single_bytes)
