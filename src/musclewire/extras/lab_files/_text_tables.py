"""Tables in text: CSV in its dialects, tab-separated and space-separated columns, read block after block.

Blocks of plain numbers are read by NumPy, the others by Python's csv; what is ours is the layout and what messages say.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._number_style import NumberStyle, is_missing, number_and_unit
from musclewire.extras.lab_files._text_layout import (
    COUNTED,
    OF_UNITS,
    TextLayout,
    is_row,
    kind_of,
    layout_of,
    split_lines,
    too_wide,
)
from musclewire.extras.lab_files._text_lines import Line, ends_within_a_line, lines_of
from musclewire.extras.lab_files._text_shapes import shape_of
from musclewire.files import BLOCK_ROWS, Cells, RowBlock, SourceColumn, stated_periods_s, without_groups
from musclewire.signals import MetadataValue, is_unit, scale_between

_COMMENT = re.compile(r"\s*(?:#(?!\d|N/A)|%|//|!|;(?=\s))+\s?(.*)")
# With what a comment or a line without cells begins; any other line needs no closer look.
_MAY_BE_NO_ROW = frozenset("#%/!;,| \t\f\v\xa0")
_ONLY_SEPARATORS = " \t\f\v\xa0;,|"
# For NumPy; a point among decimal commas makes a number none.
_COMMA_AS_POINT = str.maketrans({",": ".", ".": "x"})
_SEPARATOR_LINE = re.compile(r"\s*\"?sep=.\"?\s*", re.IGNORECASE)
_HEAD_LINES = 2000  # the first ones, from which the layout follows,
_HEAD_LENGTH = 1 << 22  # and their characters: of long lines fewer are looked at
_BLOCK_LENGTH = 1 << 22  # characters: rows of wide tables are handed over in smaller blocks
_LARGE = 1 << 24  # bytes from which on compiled code is worth its loading
_ROWS_TO_COMPARE = 20  # before a last line that may be cut off: they show what a whole one is like


@dataclass(frozen=True)
class TextColumn(SourceColumn):
    """A column, and how its cells are written."""

    cell: int = field(kw_only=True)  # of a line
    style: NumberStyle = field(kw_only=True)
    unit_cell: int | None = None  # the cell of a line that states the unit of the number
    unit_inside: str | None = None  # of the cells themselves, or next to them: numbers come out in it; "" if it changes
    is_unit: bool = False  # only the units in the cells

    @property
    def is_plain(self) -> bool:
        """Whether the cells are numbers and nothing else."""
        return not self.is_text and self.unit_inside is None

    def parts(self, row: Sequence[str]) -> tuple[str, str]:
        """Return what a row holds in the column, and the unit of that."""
        cell = row[self.cell].strip() if self.cell < len(row) else ""
        if self.unit_cell is not None:
            return cell, row[self.unit_cell].strip() if self.unit_cell < len(row) else ""
        return (self.unit_inside is not None and number_and_unit(cell)) or (cell, "")


@dataclass(frozen=True)
class TextTable:
    """A table in lines of text, of which only the first have been read."""

    path: str
    lines: Callable[[], Iterator[Line]]  # begins with the first of them again
    text_layout: TextLayout
    layout: str
    row_word: str  # what messages call a line
    columns: tuple[TextColumn, ...]
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    stated_periods_s: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    plain_path: Path | None = None  # a large file whose lines are those of the table, so that its bytes may be read
    ends_open: bool = False  # the file's last line has no end

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, block after block; each call begins again."""
        first_line = self.text_layout.first_line
        are_plain = bool(indices) and all(self.columns[index].is_plain for index in indices)
        if self.plain_path is not None and are_plain:
            # Here, because compiled code takes half a second to load, which a small file is not worth.
            from musclewire.extras.lab_files._plain_rows import plain_rows

            style, width = self.text_layout.style, len(self.text_layout.headers)
            pieces = plain_rows(self.plain_path, first_line, self.text_layout.separator, width, style.decimal)
            for table, is_end in pieces:
                plain = tuple(table[:, self.columns[index].cell] for index in indices)
                yield RowBlock(plain, self._place(range(first_line, first_line + len(table))), len(table))
                first_line += len(table)
                if is_end:
                    return
        lines = itertools.dropwhile(lambda line: line[0] < first_line, self.lines())
        first = next(lines, (0, ""))
        count = max(1, min(BLOCK_ROWS, _BLOCK_LENGTH // (len(first[1]) + 1)))
        block, held = [first, *itertools.islice(lines, count - 1)], list[Line]()
        while block:
            following = list(itertools.islice(lines, count))
            can_be_plain = are_plain and not held and (following or not self.ends_open)
            values = self._plain_block([text for _, text in block], indices) if can_be_plain else None
            if values is not None:
                yield RowBlock(values, self._place([number for number, _ in block]), len(block))
            else:
                # What follows the last row of a block is judged with the next one, or at the end of the file.
                held = yield from self._rows_of([*held, *block], not following, indices)
            block = following

    def _rows_of(
        self, lines: Sequence[Line], is_end: bool, indices: Sequence[int]
    ) -> Generator[RowBlock, None, list[Line]]:
        """Yield the rows among lines, and at the end what is behind the last one; else this is returned."""
        rows = split_lines([text for _, text in lines], self.text_layout.separator)
        kinds = [self._kind_of(line, row) for line, row in zip(lines, rows, strict=True)]
        end = 1 + max((place for place, kind in enumerate(kinds) if kind == "row"), default=-1)
        is_cut = is_end and self.ends_open and self._is_cut(lines, rows, end)
        if is_cut:
            end = len(lines) - 1
        elif is_end and kinds[end:][:1] == ["damaged"]:
            end += 1
        chosen = [place for place in range(end) if kinds[place] in ("row", "damaged")]
        numbers = [lines[place][0] for place in chosen]
        width = len(self.text_layout.headers)
        for place in chosen:
            if any(map(str.strip, rows[place][width:])):
                where = f"{self.path}: {self.row_word} {lines[place][0]}"
                raise too_wide(where, rows[place], width, self.text_layout.separator)
        if chosen:
            others = tuple(lines[place] for place in range(end) if kinds[place] == "words")
            words: dict[tuple[int, int], str] = {}
            values = tuple(self._cells(index, [rows[place] for place in chosen], numbers, words) for index in indices)
            headers = [place for place in range(end) if lines[place][1] in self.text_layout.header_lines]
            again = tuple(dict.fromkeys(int(np.searchsorted(chosen, place)) for place in headers))
            yield RowBlock(values, self._place(numbers), len(chosen), others, words=words, again=again)
        behind = list(lines[end:] if chosen else lines)
        if is_end and behind:
            is_row = is_cut and any(map(str.isdigit, behind[-1][1]))
            yield RowBlock((), self._place(numbers), 0, tuple(behind), is_end=True, is_cut=is_row)
        return behind

    def _kind_of(self, line: Line, row: Sequence[str]) -> str:
        """Return what a line is: a "row", a "damaged" one, "words" between rows, or "nothing"."""
        layout = self.text_layout
        if not line[1].strip(_ONLY_SEPARATORS) or line[1] in layout.header_lines:
            return "nothing"
        if is_row(row, layout.kinds) and not any(map(str.strip, row[len(layout.headers) :])):
            return "row"
        first = layout.counted[0]
        begins = first < len(row) and kind_of(row[first]) in COUNTED
        return "damaged" if begins and not (layout.kinds[0] == "blank" and row[0].strip()) else "words"

    def _is_cut(self, lines: Sequence[Line], rows: Sequence[Sequence[str]], end: int) -> bool:
        """Return whether the last line ends earlier than the rows before it, as in a file that is being written.

        ``end`` is behind the last line that looks like a row.
        """
        text = lines[-1][1]
        if end < len(lines):
            return end == len(lines) - 1 and len(text) <= max((len(other) for _, other in lines[:-1]), default=0)
        others = [row for row in rows[-1 - _ROWS_TO_COMPARE : -1] if is_row(row, self.text_layout.kinds)]
        if not others or len(rows[-1]) < len(others[0]) or text.count('"') % 2:
            return bool(others)
        place = len(others[0]) - 1
        ends = [_end_of(row[place]) for row in others if len(row) > place and not is_missing(row[place])]
        return bool(ends) and _end_of(rows[-1][place]) < min(ends)

    def _place(self, numbers: Sequence[int]) -> Callable[[int], str]:
        return lambda row: f"{self.row_word} {numbers[row]}"

    def _plain_block(self, texts: list[str], indices: Sequence[int]) -> tuple[Cells, ...] | None:
        """Return the columns of a block that NumPy reads at once; None if lines have to be looked at one by one."""
        layout = self.text_layout
        if layout.style.thousands:
            return None
        # A line with other cells than the others, or with quotes, is not for NumPy.
        counts = {text.count(layout.separator) for text in texts} if layout.separator != " " else {0}
        if len(counts) > 1 or counts > {len(layout.headers)} or any('"' in text for text in texts):
            return None
        source = [self.columns[index].cell for index in indices]
        lines = [text.translate(_COMMA_AS_POINT) for text in texts] if layout.style.decimal == "," else texts
        separator = None if layout.separator == " " else layout.separator
        try:
            # A blank cell or any word but nan and inf ends this; what NumPy reads is what float() reads.
            found = np.loadtxt(lines, delimiter=separator, usecols=source, comments=None, ndmin=2, unpack=True)
        except ValueError:
            return None
        return tuple(found) if found.shape == (len(source), len(texts)) else None

    def _cells(
        self, index: int, rows: Sequence[Sequence[str]], numbers: Sequence[int], words: dict[tuple[int, int], str]
    ) -> Cells:
        """Return the cells of a column; a word among numbers is none of them, and kept in ``words``."""
        column = self.columns[index]
        pairs = [column.parts(row) for row in rows]
        if column.is_text:
            return [unit if column.is_unit else cell for cell, unit in pairs]
        values = np.full(len(rows), np.nan)
        for place, (cell, unit) in enumerate(pairs):
            scale = scale_between(unit, column.unit_inside) if unit and column.unit_inside else 1.0
            where = f"{self.path}: {self.row_word} {numbers[place]}, column '{column.header}'"
            if scale is None:
                said = f"'{cell} {unit}' is not in {column.unit_inside}, as the cells above are"
                raise RecordingError(f"{where}: {said}; write one quantity in a column")
            try:
                values[place] = column.style.number(cell) * scale
            except ValueError:
                if is_missing(cell):
                    continue
                shown = " ".join(cell.split())[:40]
                if any(map(str.isdigit, cell)):
                    cure = f"correct it or remove the {self.row_word}"
                    raise RecordingError(f"{where}: '{shown}' is not a number; {cure}") from None
                words[place, index] = shown
        return values


def _end_of(cell: str) -> tuple[int, int]:
    """Return how many signs a number has, as a point and an exponent, and how many digits after the last of them."""
    parts = re.split(r"[.,]|[eE][+-]?", cell.strip())
    return len(parts), len(parts[-1]) if len(parts) > 1 else 0


def read_text_table(path: Path, group: str | None = None) -> TextTable:
    """Return the table in a text file by its first lines. Raises RecordingError if it is no text, or holds no table."""
    path = without_groups(path, group)
    # Not by a name of this frame, which a traceback keeps: the file would stay open as long.
    found = [_COMMENT.fullmatch(text) for _, text in itertools.takewhile(_is_above, lines_of(path))]
    comments = [match[1].strip() for match in found if match is not None]
    separator = "\t" if path.suffix.lower() == ".tsv" else None

    def lines() -> Iterator[Line]:
        return filter(_may_be_row, lines_of(path))

    shape = shape_of(list(itertools.islice(lines(), _HEAD_LINES)))
    if shape is None:
        table = table_of_lines(str(path), lines, "text", separator, "line", comments)
    else:
        table = table_of_lines(str(path), lambda: shape.lines(lines()), shape.words, shape.separator, "line", comments)
    layout, is_large = table.text_layout, shape is None and path.stat().st_size >= _LARGE
    is_plain = is_large and layout.separator != " " and not layout.style.thousands
    return replace(table, plain_path=path if is_plain else None, ends_open=ends_within_a_line(path))


def table_of_lines(
    path: str,
    lines: Callable[[], Iterator[Line]],
    what: str,
    separator: str | None = None,
    row_word: str = "row",
    comments: Sequence[str] = (),
) -> TextTable:
    """Return the table in ``lines``, numbered and without comments, of a file that is built as ``what`` says.

    Raises RecordingError if there are no rows of numbers, or the headers do not fit them.
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
    titles = layout.titles
    notes = (f"{titles} {row_word}{'s' if titles > 1 else ''} above the headers skipped",) if titles else ()
    periods_s = stated_periods_s(layout.metadata, unit_stated=True)
    columns = _columns_of(layout, head)
    return TextTable(path, lines, layout, words, row_word, columns, layout.metadata, periods_s, notes)


def _is_above(line: Line) -> bool:
    """Return whether a line can be no row, as comments and blank lines above a table."""
    return not _may_be_row(line)


def _may_be_row(line: Line) -> bool:
    """Return whether a line may be a row of a table, its titles or headers."""
    number, text = line
    if not text or (text[0] in _MAY_BE_NO_ROW and (not text.strip(_ONLY_SEPARATORS) or _COMMENT.match(text))):
        return False
    return number > 2 or not _SEPARATOR_LINE.fullmatch(text)


def _columns_of(layout: TextLayout, lines: Sequence[Line]) -> tuple[TextColumn, ...]:
    """Return the columns of a table by its first lines."""
    rows = split_lines([text for number, text in lines if number >= layout.first_line], layout.separator)
    rows = [row for row in rows if len(row) == len(layout.headers) and is_row(row, layout.kinds)]
    columns: list[TextColumn] = []
    before = ""
    for index, (header, unit, kind) in enumerate(zip(layout.headers, layout.units, layout.kinds, strict=True)):
        cells = [row[index].strip() for row in rows if not is_missing(row[index])]
        pairs = [number_and_unit(cell) for cell in cells] if kind == "quantities" else []
        inside = _unit_of([pair[1] for pair in pairs if pair is not None])
        is_text = kind in {"times", "text"}
        column = TextColumn(header, unit, is_text, kind == "blank", cell=index, style=layout.styles[index])
        if kind == "text" and before == "numbers" and OF_UNITS.fullmatch(header) and (beside := _unit_of(cells)):
            columns[-1] = replace(columns[-1], unit=beside, unit_cell=index, unit_inside=beside)
        elif inside == "":
            # Several quantities below each other, as in a row for each channel.
            each = replace(column, unit=None, unit_inside="")
            columns += [each, replace(each, header="unit", is_text=True, is_unit=True)]
        elif inside is not None:
            columns.append(replace(column, unit=inside, unit_inside=inside))
        elif kind != "beside":
            columns.append(column)
        before = kind
    return tuple(columns)


def _unit_of(texts: Sequence[str]) -> str | None:
    """Return the first unit among texts, "" if another one measures another thing, None if there is none."""
    units = [text for text in dict.fromkeys(texts) if is_unit(text)]
    same = all(scale_between(unit, units[0]) is not None for unit in units)
    return None if not units else units[0] if same else ""
