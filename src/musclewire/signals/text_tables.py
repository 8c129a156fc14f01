"""Tables in text files: CSV in its dialects, tab-separated and space-separated columns."""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals.headers import numbered_headers
from musclewire.signals.metadata import MetadataValue, entry_from_text, value_to_text

__all__ = ["TextTable", "read_text_table", "fill_csv"]

_SEPARATOR_WORDS = {",": "commas", ";": "semicolons", "\t": "tabs", " ": "spaces"}


@dataclass(frozen=True)
class TextTable:
    """The cells of a text file, still as text. ``line_numbers`` gives the line of each row, from 1."""

    path: str
    separator: str
    headers: tuple[str, ...]
    rows: list[list[str]]
    line_numbers: list[int]
    metadata: dict[str, MetadataValue] = field(default_factory=dict)

    @property
    def layout(self) -> str:
        """How the file is built, in words."""
        comma = ", decimal comma" if self.has_decimal_comma else ""
        return f"text, separated by {_SEPARATOR_WORDS[self.separator]}{comma}"

    @property
    def row_count(self) -> int:
        """The number of rows, n_times."""
        return len(self.rows)

    @cached_property
    def has_decimal_comma(self) -> bool:
        """True when numbers are written 1,5: the separator leaves commas free and no number has a point."""
        if self.separator == ",":
            return False
        numbers = [cell for row in self.rows for cell in row if _looks_numeric(cell)]
        return any("," in cell for cell in numbers) and not any("." in cell for cell in numbers)

    def place(self, row: int) -> str:
        """Return where row ``row`` (from 0) is in the file."""
        return f"line {self.line_numbers[row]}"

    def numbers(self, index: int) -> FloatArray:
        """Return a column, shape (n_times,). Raises RecordingError if a cell is blank or holds no number."""
        cells = [row[index] if index < len(row) else "" for row in self.rows]
        if self.has_decimal_comma:
            cells = [cell.replace(",", ".") for cell in cells]
        try:
            # float() accepts 1_000, which in a file is a mistake that _is_number finds.
            if not any("_" in cell for cell in cells):
                return np.array([float(cell) for cell in cells], dtype=np.float64)
        except ValueError:
            pass
        bad = next(row for row, cell in enumerate(cells) if not _is_number(cell))
        cell = self.rows[bad][index].strip() if index < len(self.rows[bad]) else ""
        where = f"{self.path}: {self.place(bad)}, column '{self.headers[index]}'"
        what = f"'{cell}' is not a number" if cell else "the cell is blank"
        raise RecordingError(f"{where}: {what}; correct it or remove the line")


def read_text_table(path: Path) -> TextTable:
    """Read a .csv, .tsv or .txt file with one line of headers, or none: then they are "#1", "#2", ...

    The separator is found by trying; leading ``# key = value`` lines become metadata. Raises RecordingError if
    the file is no text, is empty, or has a row with more cells than headers.
    """
    comments, lines = _comments_and_lines(_text(path), path)
    separator = _separator(lines, path)
    header_cells, rows, line_numbers = _cells(lines, separator, path)
    if _are_numbers(header_cells):
        header_cells = _commented_headers(comments, separator, header_cells, path)
        rows, line_numbers = [_split(lines[0][1], separator), *rows], [lines[0][0], *line_numbers]
    headers = tuple(cell.strip() for cell in header_cells)
    rows = _without_trailing_blanks(rows, len(headers))
    _check_widths(headers, rows, line_numbers, path)
    return TextTable(str(path), separator, headers, rows, line_numbers, _metadata(comments))


def fill_csv(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path``: metadata as comments, our names, every number to the last bit."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for key, value in metadata.items():
            file.write(f"# {key} = {value_to_text(key, value)}\n")
        file.write(",".join(columns) + "\n")
        numbers = [values.tolist() for values in columns.values()]
        file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*numbers, strict=True))


def _text(path: Path) -> str:
    try:
        raw = path.read_bytes()
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror}; check the file") from None
    if raw.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        text = raw.decode("utf-16", errors="replace")
    else:
        try:
            text = raw.decode("utf-8-sig")
        except UnicodeDecodeError:
            # Western spreadsheets still write this encoding, which has the degree sign and the micro sign.
            text = raw.decode("cp1252", errors="replace")
    if "\0" in text:
        raise RecordingError(f"{path}: is not a text file; export it as CSV")
    return text.replace("\r\n", "\n").replace("\r", "\n")


_Line = tuple[int, str]


def _comments_and_lines(text: str, path: Path) -> tuple[list[str], list[_Line]]:
    """Return the comments before the table, and every line of the table with its number from 1."""
    comments: list[str] = []
    lines: list[_Line] = []
    for number, line in enumerate(text.split("\n"), start=1):
        if line.lstrip().startswith("#"):
            if not lines:
                comments.append(line.lstrip().lstrip("#").strip())
        elif line.strip() and not (number == 1 and line.lower().startswith("sep=")):
            lines.append((number, line))
    # Spreadsheets end with lines of separators only; in the middle such a line is a gap in the data.
    while lines and not lines[-1][1].strip(" \t;,"):
        lines.pop()
    if not lines:
        raise RecordingError(f"{path}: has no rows; the first line names the columns, the others hold numbers")
    return comments, lines


def _separator(lines: Sequence[_Line], path: Path) -> str:
    """Return the separator of the cells, which must split the headers and the first row alike.

    Tab and semicolon are tried before the comma, because in a file that they separate a comma may be the decimal sign.
    """
    if path.suffix.lower() == ".tsv":
        return "\t"
    sample = [line for _, line in lines[:2]]
    for separator in ("\t", ";", ","):
        widths = {_width(line, separator) for line in sample}
        if len(widths) == 1 and widths != {1}:
            return separator
    last = sample[-1].split()
    if len(last) > 1 and _are_numbers(last):
        return " "
    return next((separator for separator in ("\t", ";", ",") if separator in sample[0]), ",")


def _width(line: str, separator: str) -> int:
    cells = _split(line, separator)
    return len(cells) - (1 if cells and not cells[-1].strip() else 0)


def _split(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=separator, skipinitialspace=True), [])
    except csv.Error:
        return line.split(separator)


def _cells(lines: Sequence[_Line], separator: str, path: Path) -> tuple[list[str], list[list[str]], list[int]]:
    rows = [_split(line, separator) for _, line in lines[1:]]
    header_line = lines[0][1]
    if separator == " ":
        width = len(rows[0]) if rows else len(header_line.split())
        headers = _spaced_headers(header_line, width, path)
    else:
        headers = _split(header_line, separator)
        while len(headers) > 1 and not headers[-1].strip():
            headers.pop()
    return headers, rows, [number for number, _ in lines[1:]]


_SPACED_HEADER = re.compile(r"[^\s\[(]+(?:\s*(?:\[[^\]]*\]|\([^)]*\)))?")


def _spaced_headers(line: str, width: int, path: Path) -> list[str]:
    """Return headers that may contain spaces themselves ("Time [s]  Wire voltage [V]") as ``width`` cells."""
    ways: tuple[Callable[[str], list[str]], ...] = (
        _SPACED_HEADER.findall,
        lambda text: re.split(r"\s{2,}", text.strip()),
        str.split,
    )
    for way in ways:
        headers = way(line)
        if len(headers) == width:
            return headers
    raise RecordingError(
        f"{path}: the headers do not fit the {width} numbers below them; separate columns with commas or tabs"
    )


def _commented_headers(comments: Sequence[str], separator: str, cells: Sequence[str], path: Path) -> list[str]:
    """Return the last comment as headers, as numpy.savetxt writes them, or "#1", "#2", ... if it holds none."""
    last = comments[-1] if comments else ""
    if last and "=" not in last:
        headers = _split(last, separator) if separator != " " else _spaced_headers(last, len(cells), path)
        if len(headers) == len(cells) and not _are_numbers(headers):
            return headers
    return list(numbered_headers(len(cells)))


def _without_trailing_blanks(rows: list[list[str]], width: int) -> list[list[str]]:
    # Some programs end every line with a separator.
    return [row[:-1] if len(row) == width + 1 and not row[-1].strip() else row for row in rows]


def _check_widths(
    headers: Sequence[str], rows: Sequence[Sequence[str]], line_numbers: Sequence[int], path: Path
) -> None:
    for row, number in zip(rows, line_numbers, strict=True):
        if len(row) > len(headers):
            raise RecordingError(
                f"{path}: line {number} has {len(row)} cells for {len(headers)} headers; "
                "with decimal commas separate the columns with semicolons"
            )


def _metadata(comments: Sequence[str]) -> dict[str, MetadataValue]:
    pairs = [comment.partition("=") for comment in comments]
    entries = [entry_from_text(key, value) for key, equals, value in pairs if equals]
    return dict(entry for entry in entries if entry is not None)


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return "_" not in cell


def _looks_numeric(cell: str) -> bool:
    return cell.strip(" +-0123456789.,eE") == "" and any(character.isdigit() for character in cell)


def _are_numbers(cells: Sequence[str]) -> bool:
    return all(_is_number(cell.replace(",", ".")) for cell in cells if cell.strip())
