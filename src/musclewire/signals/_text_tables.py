"""Tables in text: CSV in its dialects, tab-separated and space-separated columns, read block after block.

Blocks of plain numbers are read by NumPy, the others by Python's csv; what is ours is the layout and what messages say.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import RecordingError
from musclewire.signals._clock_texts import is_date, is_time_of_day
from musclewire.signals._metadata import MetadataValue, entry_from_text, value_to_text
from musclewire.signals._number_style import is_missing, number_and_unit
from musclewire.signals._source_table import BLOCK_ROWS, Cells, RowBlock, SourceColumn, stated_periods_s
from musclewire.signals._text_layout import TextLayout, layout_of, split_lines, too_wide
from musclewire.signals._text_lines import Line, lines_of
from musclewire.signals._text_shapes import shape_of
from musclewire.signals._units import is_unit

_COMMENT = re.compile(r"\s*(?:#|%|//|!)+\s?(.*)")
# With what a comment or a blank line begins; any other line needs no closer look.
_MAY_BE_NO_ROW = frozenset("#%/! \t\f\v\xa0")
_ONLY_SEPARATORS = " \t;,|"
_SEPARATOR_LINE = re.compile(r"\s*\"?sep=.\"?\s*", re.IGNORECASE)
# The header of a column that holds the units of the one before, "#5" without a header.
_OF_UNITS = re.compile(r"units?|einheit(?:en)?|#\d+", re.IGNORECASE)
_MAX_TITLE_LENGTH = 200
# The layout follows from the first lines, of which there are few if they are long.
_HEAD_LINES = 2000
_HEAD_LENGTH = 1 << 22
# Rows of wide tables are handed over in smaller blocks.
_BLOCK_LENGTH = 1 << 22
# From so many bytes on compiled code is worth its loading.
_LARGE = 1 << 24


@dataclass(frozen=True)
class TextTable:
    """A table in lines of text, of which only the first have been read. ``lines`` begins with the first of them again.

    ``row_word`` is what messages call a line, ``parts`` which of the cells of a line each column is, ``cell_units`` the
    unit in the cells of a column themselves. ``plain_path`` is a large file whose lines are those of the table, so
    that its bytes may be read.
    """

    path: str
    lines: Callable[[], Iterator[Line]]
    text_layout: TextLayout
    layout: str
    row_word: str
    columns: tuple[SourceColumn, ...]
    parts: tuple[tuple[int, ...], ...]
    cell_units: tuple[str | None, ...]
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    stated_periods_s: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    plain_path: Path | None = None

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, block after block; each call begins again."""
        first_line = self.text_layout.first_line
        if self.plain_path is not None and indices and all(map(self._is_plain, indices)):
            # Here, because compiled code takes half a second to load, which a small file is not worth.
            from musclewire.signals._plain_rows import PlainRows

            style, width = self.text_layout.style, len(self.text_layout.headers)
            plain_rows = PlainRows(self.plain_path, first_line, self.text_layout.separator, width, style.decimal)
            for table in plain_rows:
                plain = tuple(table[:, self.parts[index][0]] for index in indices)
                yield RowBlock(plain, self._place(range(first_line, first_line + len(table))), len(table))
                first_line += len(table)
            if plain_rows.finished:
                return
        below = itertools.dropwhile(lambda line: line[0] < first_line, self.lines())
        first = next(below, (0, ""))
        count = max(1, min(BLOCK_ROWS, _BLOCK_LENGTH // (len(first[1]) + 1)))
        rows = itertools.chain([first], below)
        held: list[Line] = []
        while block := list(itertools.islice(rows, count)):
            # Spreadsheets end with lines of separators only; in the middle such a line is a gap in the data.
            block, held = held + block, []
            while block and not block[-1][1].strip(_ONLY_SEPARATORS):
                held.insert(0, block.pop())
            # Tests below each other may each have the headers again.
            if not self.text_layout.header_lines.isdisjoint(text for _, text in block):
                block = [line for line in block if line[1] not in self.text_layout.header_lines]
            if block:
                numbers, texts = zip(*block, strict=True)
                yield RowBlock(self._values(numbers, list(texts), indices), self._place(numbers), len(numbers))

    def _place(self, numbers: Sequence[int]) -> Callable[[int], str]:
        return lambda row: f"{self.row_word} {numbers[row]}"

    def _values(self, numbers: Sequence[int], texts: list[str], indices: Sequence[int]) -> tuple[Cells, ...]:
        if not indices:
            return ()
        plain = self._plain_numbers(texts, [index for index in indices if self._is_plain(index)])
        if plain is not None and all(map(self._is_plain, indices)):
            return tuple(plain[index] for index in indices)
        rows = split_lines(texts, self.text_layout.separator)
        width = len(self.text_layout.headers)
        for number, row in zip(numbers, rows, strict=True):
            if len(row) > width and any(cell.strip() for cell in row[width:]):
                beginning = f"{self.path}: {self.row_word} {number} has {len(row)} cells for {width} headers"
                raise RecordingError(too_wide(beginning, ",".join(row), self.text_layout.separator))
        return tuple(
            plain[index] if plain and index in plain else self._cells(index, rows, numbers) for index in indices
        )

    def _is_plain(self, index: int) -> bool:
        """Return whether the cells of a column are numbers and nothing else."""
        return not self.columns[index].is_text and self.cell_units[index] is None

    def _plain_numbers(self, texts: list[str], indices: Sequence[int]) -> dict[int, FloatArray] | None:
        """Return columns of numbers that NumPy reads at once; None if cells have to be looked at one by one."""
        layout, source = self.text_layout, [self.parts[index][0] for index in indices]
        if not source or layout.style.thousands:
            return None
        # A line with other cells than the others, or with quotes, is not for NumPy.
        counts = {text.count(layout.separator) for text in texts} if layout.separator != " " else {0}
        if len(counts) > 1 or counts > {len(layout.headers)} or any('"' in text for text in texts):
            return None
        lines = [text.replace(",", ".") for text in texts] if layout.style.decimal == "," else texts
        separator = None if layout.separator == " " else layout.separator
        try:
            # A blank cell or any word but nan and inf ends this; what NumPy reads is what float() reads.
            found = np.loadtxt(lines, delimiter=separator, usecols=source, comments=None, ndmin=2, unpack=True)
        except ValueError:
            return None
        return dict(zip(indices, found, strict=True)) if found.shape == (len(source), len(texts)) else None

    def _cells(self, index: int, rows: Sequence[Sequence[str]], numbers: Sequence[int]) -> Cells:
        parts = self.parts[index]
        if self.columns[index].is_text:
            return [" ".join(row[part].strip() for part in parts if part < len(row)) for row in rows]
        style, values = self.text_layout.style, np.full(len(rows), np.nan)
        for place, row in enumerate(rows):
            cell = row[parts[0]] if parts[0] < len(row) else ""
            if self.cell_units[index] is not None:
                beside = row[parts[1]] if len(parts) > 1 and parts[1] < len(row) else None
                cell = self._without_unit(cell, beside, index, numbers[place])
            try:
                values[place] = style.number(cell)
            except ValueError:
                if not is_missing(cell):
                    where = f"{self.path}: {self.row_word} {numbers[place]}, column '{self.columns[index].header}'"
                    shown = " ".join(cell.split())[:40]
                    cure = f"correct it or remove the {self.row_word}"
                    raise RecordingError(f"{where}: '{shown}' is not a number; {cure}") from None
        return values

    def _without_unit(self, cell: str, beside: str | None, index: int, number: int) -> str:
        """Return the number of "0.33 V", or of a cell next to its unit. RecordingError if the unit is another one."""
        found, unit = number_and_unit(cell) or (cell.strip(), self.cell_units[index])
        if beside is not None:
            found, unit = cell.strip(), beside.strip() or unit
        if unit != self.cell_units[index] and not is_missing(found):
            where = f"{self.path}: {self.row_word} {number}, column '{self.columns[index].header}'"
            said = f"'{cell.strip()[:40]}' in {unit} is not in {self.cell_units[index]}, as the cells above are"
            raise RecordingError(f"{where}: {said}; write one unit throughout")
        return found


def read_text_table(path: Path) -> TextTable:
    """Return the table in a .csv, .tsv or .txt file after its first lines: titles, headers, units and where rows begin.

    Separator, decimal sign, rows of headers and units are found in the first lines; titles and comments as
    ``key = value`` become metadata. Raises RecordingError if the file is no text, or holds no table.
    """
    comments: list[str] = []
    for number, text in lines_of(path):
        comment = _COMMENT.fullmatch(text)
        if comment is not None:
            comments.append(comment[1].strip())
        elif text.strip(_ONLY_SEPARATORS) and not (number < 3 and _SEPARATOR_LINE.fullmatch(text)):
            break
    separator = "\t" if path.suffix.lower() == ".tsv" else None
    plain = partial(_without_comments, path)
    shape = shape_of(list(itertools.islice(plain(), _HEAD_LINES)), str(path))
    if shape is None:
        table = table_of_lines(str(path), plain, "text", separator, "line", comments)
        layout = table.text_layout
        is_large = path.stat().st_size >= _LARGE and layout.separator != " " and not layout.style.thousands
        return replace(table, plain_path=path) if is_large else table
    return table_of_lines(str(path), lambda: shape.lines(plain()), shape.words, None, "line", comments)


def table_of_lines(
    path: str,
    lines: Callable[[], Iterator[Line]],
    what: str,
    separator: str | None = None,
    row_word: str = "row",
    comments: Sequence[str] = (),
) -> TextTable:
    """Return the table in lines of text, wherever they come from.

    Parameters
    ----------
    path
        The file, as messages name it.
    lines
        Returns the numbered lines, without comments, from the first on.
    what
        How the file is built, in words.
    separator
        The sign between cells; None, the default, finds it.
    row_word
        What messages call a line.
    comments
        Comments above the table; none by default.

    Returns
    -------
    The table.

    Raises
    ------
    RecordingError
        If there are no rows of numbers, or the headers do not fit them.
    """
    head: list[Line] = []
    length = 0
    for number, text in itertools.islice(lines(), _HEAD_LINES):
        length += len(text)
        if text.strip(_ONLY_SEPARATORS):
            head.append((number, text))
        if length > _HEAD_LENGTH:
            break
    if not head:
        raise RecordingError(f"{path}: has no rows; the first line names the columns, the others hold numbers")
    layout = layout_of(head, comments, separator, path)
    words = what if separator is not None and row_word == "row" else f"{what}, {layout}"
    metadata = {**_metadata(comments, " "), **_metadata(layout.titles, layout.separator)}
    columns, parts, cell_units = _source_columns(layout, head)
    titles = len(layout.titles)
    notes = (f"{titles} {row_word}{'s' if titles > 1 else ''} above the headers skipped",) if titles else ()
    periods_s = stated_periods_s(metadata, unit_stated=True)
    return TextTable(path, lines, layout, words, row_word, columns, parts, cell_units, metadata, periods_s, notes)


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


def _without_comments(path: Path) -> Iterator[Line]:
    """Yield the lines of a file that may be rows of a table, its titles or headers."""
    for number, text in lines_of(path):
        if not text or (text[0] in _MAY_BE_NO_ROW and (text.isspace() or _COMMENT.match(text))):
            continue
        if number > 2 or not _SEPARATOR_LINE.fullmatch(text):
            yield number, text


def _source_columns(
    layout: TextLayout, lines: Sequence[Line]
) -> tuple[tuple[SourceColumn, ...], tuple[tuple[int, ...], ...], tuple[str | None, ...]]:
    """Return the columns, which cells of a line each one is, and the unit in its cells.

    A date and the time of day next to it are one column, and so are a number and the unit in the cell next to it.
    """
    rows = split_lines([text for number, text in lines if number >= layout.first_line], layout.separator)
    first = rows[0]
    columns: list[SourceColumn] = []
    parts: list[tuple[int, ...]] = []
    units: list[str | None] = []
    for index, (header, unit, kind) in enumerate(zip(layout.headers, layout.units, layout.kinds, strict=True)):
        cells = first[index - 1 : index + 1] if index else []
        inside = _unit_in(rows, index) if kind in {"quantities", "text"} else None
        if len(cells) == 2 and is_date(cells[0]) and is_time_of_day(cells[1]):
            columns[-1] = SourceColumn(f"{columns[-1].header} {header}", None, is_text=True)
            parts[-1] = (index - 1, index)
        elif (
            inside and index and layout.kinds[index - 1] == "numbers" and kind == "text" and _OF_UNITS.fullmatch(header)
        ):
            columns[-1] = replace(columns[-1], unit=inside)
            parts[-1], units[-1] = (index - 1, index), inside
        else:
            is_text = kind in {"times", "text"}
            columns.append(
                SourceColumn(header, unit if inside is None or is_text else inside, is_text, kind == "blank")
            )
            parts.append((index,))
            units.append(None if is_text else inside)
    return tuple(columns), tuple(parts), tuple(units)


def _unit_in(rows: Sequence[Sequence[str]], index: int) -> str | None:
    """Return the unit that the cells of a column hold, alone or behind a number; None if they hold anything else."""
    cells = [row[index].strip() for row in rows if index < len(row) and not is_missing(row[index])]
    if not cells:
        return None
    found = number_and_unit(cells[0])
    unit = cells[0] if found is None else found[1]
    return unit if is_unit(unit) and (found is not None or all(cell == unit for cell in cells)) else None


def _metadata(texts: Sequence[str], separator: str) -> dict[str, MetadataValue]:
    """Return what lines above the table state as ``key = value`` or ``key: value``, or as two cells."""
    found: dict[str, MetadataValue] = {}
    for text in texts:
        pair = _pair(text, separator)
        entry = entry_from_text(*pair) if pair and len(text) <= _MAX_TITLE_LENGTH else None
        if entry is not None:
            key, value = entry
            # Of two channels that state their rates one below the other, both are kept.
            others = found.get(key, value) != value and stated_periods_s({key: value}, unit_stated=True)
            found[f"second_{key}" if others else key] = value
    return found


def _pair(text: str, separator: str) -> tuple[str, str] | None:
    key, sign, value = text.partition("=")
    if sign:
        return key, value
    cells = [cell.strip() for cell in split_lines([text], separator)[0] if cell.strip()] if separator != " " else [text]
    with_unit = len(cells) == 3 and is_unit(cells[2])
    if (len(cells) == 2 or with_unit) and ":" not in cells[0][:-1]:
        return cells[0].rstrip(": "), " ".join(cells[1:])
    key, sign, value = text.partition(": ")
    return (key, value.strip(_ONLY_SEPARATORS)) if sign and len(cells) == 1 else None
