"""Tables in text: CSV in its dialects, tab-separated and space-separated columns, read block after block.

Blocks of plain numbers are read by NumPy, the others by Python's csv; what is ours is the layout and what messages say.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from musclewire.errors import RecordingError
from musclewire.extras.lab_files._number_style import is_missing, number_and_unit
from musclewire.extras.lab_files._text_layout import (
    COUNTED,
    OF_UNITS,
    TextLayout,
    conforms,
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
# With what a comment or a blank line begins; any other line needs no closer look.
_MAY_BE_NO_ROW = frozenset("#%/!; \t\f\v\xa0")
_ONLY_SEPARATORS = " \t;,|"
# For NumPy; a point among decimal commas makes a number none.
_COMMA_AS_POINT = str.maketrans({",": ".", ".": "x"})
_SEPARATOR_LINE = re.compile(r"\s*\"?sep=.\"?\s*", re.IGNORECASE)
_HEAD_LINES = 2000  # the first ones, from which the layout follows,
_HEAD_LENGTH = 1 << 22  # and their characters: of long lines fewer are looked at
_BLOCK_LENGTH = 1 << 22  # characters: rows of wide tables are handed over in smaller blocks
_LARGE = 1 << 24  # bytes from which on compiled code is worth its loading
_ROWS_TO_COMPARE = 20  # before a last line that may be cut off: they show what a whole one is like


@dataclass(frozen=True)
class TextTable:
    """A table in lines of text, of which only the first have been read."""

    path: str
    lines: Callable[[], Iterator[Line]]  # begins with the first of them again
    text_layout: TextLayout
    layout: str
    row_word: str  # what messages call a line
    columns: tuple[SourceColumn, ...]
    parts: tuple[tuple[int, ...], ...]  # which cells of a line each column is
    cell_units: tuple[str | None, ...]  # the unit in the cells of each column themselves
    metadata: Mapping[str, MetadataValue] = field(default_factory=dict)
    stated_periods_s: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    plain_path: Path | None = None  # a large file whose lines are those of the table, so that its bytes may be read
    ends_open: bool = False  # the file's last line has no end

    def blocks(self, indices: Sequence[int]) -> Iterator[RowBlock]:
        """Return the rows of some columns, block after block; each call begins again."""
        first_line = self.text_layout.first_line
        if self.plain_path is not None and indices and all(map(self._is_plain, indices)):
            # Here, because compiled code takes half a second to load, which a small file is not worth.
            from musclewire.extras.lab_files._plain_rows import plain_rows

            style, width = self.text_layout.style, len(self.text_layout.headers)
            pieces = plain_rows(self.plain_path, first_line, self.text_layout.separator, width, style.decimal)
            for table, is_end in pieces:
                plain = tuple(table[:, self.parts[index][0]] for index in indices)
                yield RowBlock(plain, self._place(range(first_line, first_line + len(table))), len(table))
                first_line += len(table)
                if is_end:
                    return
        below = itertools.dropwhile(lambda line: line[0] < first_line, self.lines())
        first = next(below, (0, ""))
        count = max(1, min(BLOCK_ROWS, _BLOCK_LENGTH // (len(first[1]) + 1)))
        lines = itertools.chain([first], below)
        held: list[Line] = []
        longest = 0
        while block := list(itertools.islice(lines, count)):
            longest = max(longest, *(len(text) for _, text in block[:-1]), 0)
            # What follows the last row of a block is judged with the next one, or at the end of the file.
            yield from self._rows_of(held, block, indices)
        if held:
            yield self._end(held, longest, indices)

    def _rows_of(self, held: list[Line], block: list[Line], indices: Sequence[int]) -> Iterator[RowBlock]:
        """Yield a block's rows with the lines among them that are none; ``held`` are the last, without a row after."""
        numbers, texts = zip(*block, strict=True)
        plain = None if held or self.ends_open else self._plain_block(list(texts), indices)
        if plain is not None:
            yield RowBlock(plain, self._place(numbers), len(texts))
            return
        lines = [*held, *block]
        rows = split_lines([text for _, text in lines], self.text_layout.separator)
        kinds = [self._kind_of(line, row) for line, row in zip(lines, rows, strict=True)]
        last = max((place for place, kind in enumerate(kinds) if kind == "row"), default=-1)
        held[:] = lines[last + 1 :]
        chosen = [place for place in range(last + 1) if kinds[place] in ("row", "damaged")]
        others = tuple(lines[place] for place in range(last + 1) if kinds[place] == "words")
        if chosen and not held and self.ends_open and self._is_cut([rows[place] for place in chosen], lines[last][1]):
            held[:] = [lines[chosen.pop()]]
        if not chosen:
            held[:0] = others
            return
        numbers = tuple(lines[place][0] for place in chosen)
        words: dict[tuple[int, int], str] = {}
        values = self._values(numbers, [rows[place] for place in chosen], indices, words)
        headers = [place for place in range(last) if lines[place][1] in self.text_layout.header_lines]
        again = tuple(dict.fromkeys(int(np.searchsorted(chosen, place)) for place in headers))
        yield RowBlock(values, self._place(numbers), len(chosen), others, words=words, again=again)

    def _kind_of(self, line: Line, row: Sequence[str]) -> str:
        """Return what a line is: a "row", a "damaged" one, "words" between rows, or "nothing"."""
        layout = self.text_layout
        if not line[1].strip(_ONLY_SEPARATORS) or line[1] in layout.header_lines:
            return "nothing"
        if layout.kinds[0] == "blank" and row[0].strip():
            return "words"
        counted = layout.counted
        is_wide = any(cell.strip() for cell in row[len(layout.headers) :])
        if len(row) > counted[-1] and conforms(row, counted) and not is_wide:
            return "row"
        begins = counted[0] < len(row) and kind_of(row[counted[0]]) in COUNTED
        return "damaged" if begins else "words"

    def _is_cut(self, rows: Sequence[Sequence[str]], text: str) -> bool:
        """Return whether the last row ends earlier than those before it, as in a file that is being written."""
        end = self.text_layout.counted[-1]
        others = [row for row in rows[-1 - _ROWS_TO_COMPARE : -1] if len(row) > end]
        if not others or len(rows[-1]) < len(others[0]) or text.count('"') % 2:
            return bool(others)
        place = len(others[0]) - 1
        ends = [_end_of(row[place]) for row in others if len(row) > place and not is_missing(row[place])]
        return bool(ends) and _end_of(rows[-1][place]) < min(ends)

    def _end(self, held: Sequence[Line], longest: int, indices: Sequence[int]) -> RowBlock:
        """Return the lines behind the last row: a damaged one, one that is cut off, or a table of something else."""
        rows = split_lines([text for _, text in held], self.text_layout.separator)
        place = self._place([number for number, _ in held])
        cut = len(held) == 1 and self.ends_open and len(held[0][1]) <= longest
        if self._kind_of(held[0], rows[0]) in ("row", "damaged") and not cut:
            words: dict[tuple[int, int], str] = {}
            return RowBlock(
                self._values((held[0][0],), rows[:1], indices, words), place, 1, tuple(held[1:]), words=words
            )
        return RowBlock((), place, 0, tuple(held), is_end=True, is_cut=cut and any(map(str.isdigit, held[0][1])))

    def _place(self, numbers: Sequence[int]) -> Callable[[int], str]:
        return lambda row: f"{self.row_word} {numbers[row]}"

    def _plain_block(self, texts: list[str], indices: Sequence[int]) -> tuple[Cells, ...] | None:
        """Return the columns of a block that NumPy reads at once; None if lines have to be looked at one by one."""
        layout = self.text_layout
        if not indices or layout.style.thousands or not all(map(self._is_plain, indices)):
            return None
        # A line with other cells than the others, or with quotes, is not for NumPy.
        counts = {text.count(layout.separator) for text in texts} if layout.separator != " " else {0}
        if len(counts) > 1 or counts > {len(layout.headers)} or any('"' in text for text in texts):
            return None
        source = [self.parts[index][0] for index in indices]
        lines = [text.translate(_COMMA_AS_POINT) for text in texts] if layout.style.decimal == "," else texts
        separator = None if layout.separator == " " else layout.separator
        try:
            # A blank cell or any word but nan and inf ends this; what NumPy reads is what float() reads.
            found = np.loadtxt(lines, delimiter=separator, usecols=source, comments=None, ndmin=2, unpack=True)
        except ValueError:
            return None
        return tuple(found) if found.shape == (len(source), len(texts)) else None

    def _is_plain(self, index: int) -> bool:
        """Return whether the cells of a column are numbers and nothing else."""
        return not self.columns[index].is_text and self.cell_units[index] is None

    def _values(
        self, numbers: Sequence[int], rows: list[list[str]], indices: Sequence[int], words: dict[tuple[int, int], str]
    ) -> tuple[Cells, ...]:
        width = len(self.text_layout.headers)
        for number, row in zip(numbers, rows, strict=True):
            if len(row) > width and any(cell.strip() for cell in row[width:]):
                beginning = f"{self.path}: {self.row_word} {number} has {len(row)} cells for {width} headers"
                raise RecordingError(too_wide(beginning, ",".join(row), self.text_layout.separator))
        return tuple(self._cells(index, rows, numbers, words) for index in indices)

    def _cells(
        self, index: int, rows: Sequence[Sequence[str]], numbers: Sequence[int], words: dict[tuple[int, int], str]
    ) -> Cells:
        """Return the cells of a column; a word among numbers is none of them, and kept in ``words``."""
        parts = self.parts[index]
        style = self.text_layout.styles[parts[0]]
        if self.cell_units[index] == "unit":
            pairs = [number_and_unit(row[parts[0]]) if parts[0] < len(row) else None for row in rows]
            return ["" if pair is None else pair[1] for pair in pairs]
        if self.columns[index].is_text:
            return [row[parts[0]].strip() if parts[0] < len(row) else "" for row in rows]
        values = np.full(len(rows), np.nan)
        for place, row in enumerate(rows):
            cell = row[parts[0]] if parts[0] < len(row) else ""
            scale = 1.0
            if self.cell_units[index] is not None:
                beside = row[parts[1]] if len(parts) > 1 and parts[1] < len(row) else None
                cell, scale = self._without_unit(cell, beside, index, numbers[place])
            try:
                values[place] = style.number(cell) * scale
            except ValueError:
                if not is_missing(cell):
                    shown = " ".join(cell.split())[:40]
                    if not any(map(str.isdigit, cell)):
                        words[place, index] = shown
                        continue
                    where = self._where(numbers[place], index)
                    message = f"{where}: '{shown}' is not a number; correct it or remove the {self.row_word}"
                    raise RecordingError(message) from None
        return values

    def _where(self, number: int, index: int) -> str:
        return f"{self.path}: {self.row_word} {number}, column '{self.columns[index].header}'"

    def _without_unit(self, cell: str, beside: str | None, index: int, number: int) -> tuple[str, float]:
        """Return the number of "0.33 V", or of a cell next to its unit, and what makes it one in the column's unit.

        Raises RecordingError if the unit measures something else.
        """
        own = str(self.cell_units[index])
        found, unit = number_and_unit(cell) or (cell.strip(), own)
        if not own:
            return found, 1.0
        if beside is not None:
            found, unit = cell.strip(), beside.strip() or own
        if unit == own or is_missing(found):
            return found, 1.0
        scale = scale_between(unit, own)
        if scale is None:
            said = f"'{cell.strip()[:40]}' in {unit} is not in {own}, as the cells above are"
            raise RecordingError(f"{self._where(number, index)}: {said}; write one quantity in a column")
        return found, scale


def _end_of(cell: str) -> tuple[int, int]:
    """Return how many signs a number has, as a point and an exponent, and how many digits after the last of them."""
    parts = re.split(r"[.,]|[eE][+-]?", cell.strip())
    return len(parts), len(parts[-1]) if len(parts) > 1 else 0


def read_text_table(path: Path, group: str | None = None) -> TextTable:
    """Return the table in a text file by its first lines. Raises RecordingError if it is no text, or holds no table."""
    path, comments = without_groups(path, group), list[str]()
    for number, text in lines_of(path):
        comment = _COMMENT.fullmatch(text)
        if comment is not None:
            comments.append(comment[1].strip())
        elif text.strip(_ONLY_SEPARATORS) and not (number < 3 and _SEPARATOR_LINE.fullmatch(text)):
            break
    separator = "\t" if path.suffix.lower() == ".tsv" else None
    plain = partial(_without_comments, path)
    shape = shape_of(list(itertools.islice(plain(), _HEAD_LINES)))
    ends_open = ends_within_a_line(path)
    if shape is None:
        table = table_of_lines(str(path), plain, "text", separator, "line", comments)
        layout = table.text_layout
        is_large = path.stat().st_size >= _LARGE and layout.separator != " " and not layout.style.thousands
        return replace(table, plain_path=path if is_large else None, ends_open=ends_open)
    table = table_of_lines(str(path), lambda: shape.lines(plain()), shape.words, shape.separator, "line", comments)
    return replace(table, ends_open=ends_open)


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
    columns, parts, cell_units = _source_columns(layout, head)
    titles = layout.titles
    notes = (f"{titles} {row_word}{'s' if titles > 1 else ''} above the headers skipped",) if titles else ()
    periods_s = stated_periods_s(layout.metadata, unit_stated=True)
    return TextTable(
        path, lines, layout, words, row_word, columns, parts, cell_units, layout.metadata, periods_s, notes
    )


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
    """Return the columns, which cells of a line each one is, and the unit in its cells, or next to them."""
    rows = split_lines([text for number, text in lines if number >= layout.first_line], layout.separator)
    rows = [row for row in rows if len(row) == len(layout.headers) and conforms(row, layout.counted)]
    columns: list[SourceColumn] = []
    parts: list[tuple[int, ...]] = []
    units: list[str | None] = []
    before = ""
    for index, (header, unit, kind) in enumerate(zip(layout.headers, layout.units, layout.kinds, strict=True)):
        cells = [row[index] for row in rows if not is_missing(row[index])]
        beside = _unit_of([cell.strip() for cell in cells]) if kind == "text" and before == "numbers" else None
        inside = (
            _unit_of([pair[1] for cell in cells if (pair := number_and_unit(cell))]) if kind == "quantities" else None
        )
        before = kind
        if beside and OF_UNITS.fullmatch(header):
            columns[-1] = replace(columns[-1], unit=beside)
            parts[-1], units[-1] = (index - 1, index), beside
        elif inside == "":
            # Several quantities below each other, as in a row for each channel.
            columns += [SourceColumn(header), SourceColumn("unit", is_text=True)]
            parts += [(index,), (index,)]
            units += ["", "unit"]
        elif kind != "beside":
            is_text = kind in {"times", "text"}
            columns.append(SourceColumn(header, unit if inside is None else inside, is_text, kind == "blank"))
            parts.append((index,))
            units.append(inside)
    return tuple(columns), tuple(parts), tuple(units)


def _unit_of(texts: Sequence[str]) -> str | None:
    """Return the first unit among texts, "" if another one measures another thing, None if there is none."""
    units = [text for text in dict.fromkeys(texts) if is_unit(text)]
    same = all(scale_between(unit, units[0]) is not None for unit in units)
    return None if not units else units[0] if same else ""
