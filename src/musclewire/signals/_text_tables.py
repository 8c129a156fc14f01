"""Tables in text files: CSV in its dialects, tab-separated and space-separated columns, read block after block."""

from __future__ import annotations

import csv
import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals._clock_texts import is_date, is_time_of_day
from musclewire.signals._metadata import MetadataValue, entry_from_text, value_to_text
from musclewire.signals._number_style import is_missing
from musclewire.signals._source_table import Cells, RowBlock, SourceColumn
from musclewire.signals._text_layout import Line, TextLayout, layout_of, split_line, too_wide
from musclewire.signals._text_lines import lines_of

__all__ = ["TextTable", "fill_csv", "fill_csv_blocks", "read_text_table"]

_COMMENT = re.compile(r"\s*(?:#|%|//|!)+\s?(.*)")
_ONLY_SEPARATORS = " \t;,|"
_SEPARATOR_LINE = re.compile(r"\s*\"?sep=.\"?\s*", re.IGNORECASE)
# Keys under which programs state the time between rows, without the unit that metadata append.
_PERIOD_KEY = re.compile(r"(?:sampl\w*_)?(?:interval|period|time_step|dt|delta_[tx])_s|sample_time_s")
_RATE_KEY = re.compile(r"(?:sampl\w*_)?(?:rate|frequency|freq)_hz|fs_hz")
_MAX_TITLE_LENGTH = 200


@dataclass(frozen=True)
class TextTable:
    """A table in a text file, of which only the first lines have been read. Its rows come from the file, in blocks."""

    path: str
    file: Path
    text_layout: TextLayout
    columns: tuple[SourceColumn, ...]
    parts: tuple[tuple[int, ...], ...]
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    sample_period_s: float | None = None
    notes: tuple[str, ...] = ()

    @property
    def layout(self) -> str:
        """How the file is built, in words."""
        return str(self.text_layout)

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, block after block; each call begins again."""
        for numbers, texts in _rows_of(self.file, self.text_layout.first_line):
            yield RowBlock(self._values(numbers, texts, indices), _place(numbers))

    def _values(self, numbers: Sequence[int], texts: list[str], indices: Sequence[int]) -> tuple[Cells, ...]:
        plain = self._plain_numbers(texts, indices)
        if plain is not None:
            return plain
        rows = self._split(texts)
        width = len(self.text_layout.headers)
        for number, row in zip(numbers, rows, strict=True):
            self._check_width(number, row, width)
        return tuple(self._cells(index, rows, numbers) for index in indices)

    def _plain_numbers(self, texts: list[str], indices: Sequence[int]) -> tuple[FloatArray, ...] | None:
        """Return columns of numbers that NumPy reads at once; None if cells have to be looked at one by one."""
        layout, source = self.text_layout, [self.parts[index][0] for index in indices]
        swaps = layout.style.decimal == ","
        if not source or any(self.columns[index].is_text for index in indices) or layout.style.thousands:
            return None
        if not _is_regular(texts, layout.separator, len(layout.headers)):
            return None
        lines = [text.replace(",", ".") for text in texts] if swaps else texts
        separator = None if layout.separator == " " else layout.separator
        try:
            # A blank cell or any word but nan and inf ends this; what NumPy reads is what float() reads.
            found = np.loadtxt(lines, delimiter=separator, usecols=source, comments=None, ndmin=2, unpack=True)
        except ValueError:
            return None
        return tuple(found) if found.shape == (len(source), len(texts)) else None

    def _split(self, texts: list[str]) -> list[list[str]]:
        separator = self.text_layout.separator
        if separator != " ":
            try:
                return list(csv.reader(texts, delimiter=separator, skipinitialspace=separator != "\t"))
            except csv.Error:
                pass
        return [split_line(text, separator) for text in texts]

    def _check_width(self, number: int, row: Sequence[str], width: int) -> None:
        if len(row) <= width or not any(cell.strip() for cell in row[width:]):
            return
        beginning = f"{self.path}: line {number} has {len(row)} cells for {width} headers"
        raise RecordingError(too_wide(beginning, ",".join(row), self.text_layout.separator))

    def _cells(self, index: int, rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> Cells:
        parts = self.parts[index]
        if self.columns[index].is_text:
            return [" ".join(row[part].strip() for part in parts if part < len(row)) for row in rows]
        return self._numbers(index, [row[parts[0]] if parts[0] < len(row) else "" for row in rows], numbers)

    def _numbers(self, index: int, cells: Sequence[str], numbers: Sequence[int]) -> FloatArray:
        style, values = self.text_layout.style, np.full(len(cells), np.nan)
        for row, cell in enumerate(cells):
            try:
                values[row] = style.number(cell)
            except ValueError:
                if not is_missing(cell):
                    where = f"{self.path}: line {numbers[row]}, column '{self.columns[index].header}'"
                    shown = " ".join(cell.split())[:40]
                    raise RecordingError(f"{where}: '{shown}' is not a number; correct it or remove the line") from None
        return values


def read_text_table(path: Path) -> TextTable:
    """Return the table in a .csv, .tsv or .txt file after its first lines: titles, headers, units and where rows begin.

    Separator, decimal sign, rows of headers and units are found in the first lines; titles and comments as
    ``key = value`` become metadata. Raises RecordingError if the file is no text, or holds no table.
    """
    comments, lines = _first_lines(path)
    if not lines:
        raise RecordingError(f"{path}: has no rows; the first line names the columns, the others hold numbers")
    layout = layout_of(lines, comments, path.suffix.lower(), str(path))
    metadata = {**_metadata(comments, " "), **_metadata(layout.titles, layout.separator)}
    columns, parts = _with_dates_joined(layout, lines)
    titles = len(layout.titles)
    notes = (f"{titles} line{'s' if titles > 1 else ''} above the headers skipped",) if titles else ()
    return TextTable(str(path), path, layout, columns, parts, metadata, _sample_period_s(metadata), notes)


def fill_csv(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write columns to ``path``: metadata as comments, our names, every number to the last bit."""
    fill_csv_blocks(tuple(columns), [tuple(columns.values())], metadata, path)


def fill_csv_blocks(
    names: Sequence[str],
    blocks: Iterable[tuple[FloatArray, ...]],
    metadata: Mapping[str, MetadataValue],
    path: Path,
) -> None:
    """Write blocks of columns to ``path``, as ``fill_csv`` does."""
    with path.open("w", encoding="utf-8", newline="\n") as file:
        for key, value in metadata.items():
            file.write(f"# {key} = {value_to_text(key, value)}\n")
        file.write(",".join(names) + "\n")
        for block in blocks:
            numbers = [values.tolist() for values in block]
            file.writelines(",".join(map(repr, row)) + "\n" for row in zip(*numbers, strict=True))


def _place(numbers: Sequence[int]) -> Callable[[int], str]:
    return lambda row: f"line {numbers[row]}"


def _is_regular(texts: Sequence[str], separator: str, width: int) -> bool:
    """Return whether every line has the same number of cells, none of them in quotes."""
    if separator == " ":
        return True
    counts = {text.count(separator) for text in texts}
    return len(counts) == 1 and counts <= {width - 1, width} and not any('"' in text for text in texts)


def _rows_of(path: Path, first_line: int) -> Iterator[tuple[Sequence[int], list[str]]]:
    """Yield the lines of the table's rows with their numbers: no comments, no blank ones, no separators at the end."""
    held: list[Line] = []
    for lines in lines_of(path):
        kept = [
            (number, text)
            for number, text in enumerate(lines.texts, start=lines.first)
            if number >= first_line and text and not text.isspace() and not _is_comment(text)
        ]
        # Spreadsheets end with lines of separators only; in the middle such a line is a gap in the data.
        kept, held = held + kept, []
        while kept and not kept[-1][1].strip(_ONLY_SEPARATORS):
            held.insert(0, kept.pop())
        if kept:
            numbers, texts = zip(*kept, strict=True)
            yield numbers, list(texts)


def _is_comment(text: str) -> bool:
    return text[0] in "#%/! \t" and _COMMENT.fullmatch(text) is not None


def _first_lines(path: Path) -> tuple[list[str], list[Line]]:
    """Return the comments above the table, and the first lines of the file without them."""
    comments: list[str] = []
    kept: list[Line] = []
    for lines in itertools.islice(lines_of(path), 1):
        for number, text in enumerate(lines.texts, start=lines.first):
            comment = _COMMENT.fullmatch(text)
            if comment is not None:
                comments += [] if kept else [comment[1].strip()]
            elif text.strip(_ONLY_SEPARATORS) and not (number < 3 and _SEPARATOR_LINE.fullmatch(text)):
                kept.append((number, text))
    # The layout follows from the first thousands of characters; the piece that was read is much larger.
    return comments, kept[:2000]


def _with_dates_joined(
    layout: TextLayout, lines: Sequence[Line]
) -> tuple[tuple[SourceColumn, ...], tuple[tuple[int, ...], ...]]:
    """Return the columns, a date and the time of day next to it as one, and which columns of the file each one is."""
    first = split_line(next(text for number, text in lines if number == layout.first_line), layout.separator)
    columns: list[SourceColumn] = []
    parts: list[tuple[int, ...]] = []
    for index, (header, unit, kind) in enumerate(zip(layout.headers, layout.units, layout.kinds, strict=True)):
        cells = first[index - 1 : index + 1] if index else []
        if len(cells) == 2 and is_date(cells[0]) and is_time_of_day(cells[1]):
            columns[-1] = SourceColumn(f"{columns[-1].header} {header}", None, is_text=True)
            parts[-1] = (index - 1, index)
        else:
            columns.append(SourceColumn(header, unit, kind in {"times", "text"}, kind == "blank"))
            parts.append((index,))
    return tuple(columns), tuple(parts)


def _metadata(texts: Sequence[str], separator: str) -> dict[str, MetadataValue]:
    """Return what lines above the table state as ``key = value`` or ``key: value``, or as two cells."""
    found: dict[str, MetadataValue] = {}
    for text in texts:
        pair = _pair(text, separator)
        entry = entry_from_text(*pair) if pair and len(text) <= _MAX_TITLE_LENGTH else None
        if entry is not None:
            found[entry[0]] = entry[1]
    return found


def _pair(text: str, separator: str) -> tuple[str, str] | None:
    key, sign, value = text.partition("=")
    if sign:
        return key, value
    cells = [cell.strip() for cell in split_line(text, separator) if cell.strip()] if separator != " " else [text]
    if len(cells) == 2 and ":" not in cells[0][:-1]:
        return cells[0].rstrip(":"), cells[1]
    key, sign, value = text.partition(": ")
    return (key, value.strip(_ONLY_SEPARATORS)) if sign and len(cells) == 1 else None


def _sample_period_s(metadata: Mapping[str, MetadataValue]) -> float | None:
    """Return the time between two rows [s] that the file's head states, or None."""
    for key, value in metadata.items():
        if isinstance(value, float | int) and value > 0:
            if _PERIOD_KEY.fullmatch(key):
                return float(value)
            if _RATE_KEY.fullmatch(key):
                return 1.0 / float(value)
    return None
