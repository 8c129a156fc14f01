"""Excel workbooks (.xlsx, .xlsm), one sheet at a time, values only. Needs the extra ``labfiles`` (openpyxl)."""

from __future__ import annotations

import math
import warnings
from array import array
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.errors import MissingExtraError, RecordingError, nearest_hint
from musclewire.extras.lab_files._excel_export import METADATA_SHEET, RECORDING_SHEET
from musclewire.extras.lab_files._excel_layout import SheetLayout, layout_of, number_of_text
from musclewire.extras.lab_files._file_table import damage_reported, metadata_of, one_line
from musclewire.extras.lab_files._xlsx_check import check_xlsx
from musclewire.signals import Cells, MetadataValue, SourceColumn, TableInMemory, entry_from_text, numbered_headers

__all__ = ["read_excel_table"]

MAX_ROWS = 1_048_576
MAX_COLUMNS = 16_384
_HEAD_ROWS = 60
_EPOCH = datetime(1970, 1, 1)


def read_excel_table(path: Path, group: str | None = None) -> TableInMemory:
    """Return the table of one sheet of a workbook; None takes the only one that holds numbers below each other.

    Title rows and a row of units are recognised, dates become seconds since the first. Formulas give the value that
    was saved with them, and macros are never looked at. Raises RecordingError as one line, MissingExtraError without
    openpyxl.
    """
    try:
        import openpyxl
    except ImportError:
        raise MissingExtraError("an Excel workbook", "labfiles") from None
    with damage_reported(path, "an Excel workbook"), warnings.catch_warnings():
        # openpyxl warns of styles and extensions that it leaves out.
        warnings.simplefilter("ignore")
        check_xlsx(path)
        workbook = openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)
        with closing(workbook):
            own = _own_metadata(workbook, path)
            sheet, layout = _chosen(workbook.worksheets, RECORDING_SHEET if own and group is None else group, path)
            columns, rows = _read(sheet, layout, path)
        formulas = _without_values(path, sheet.title, layout, columns, openpyxl)
    table = _table(path, sheet.title, layout, columns, rows, formulas)
    return replace(table, metadata=own) if own else table


def _own_metadata(workbook: Any, path: Path) -> dict[str, MetadataValue]:
    """Return the metadata of a workbook that we wrote, from its second sheet; empty for any other."""
    if workbook.sheetnames != [RECORDING_SHEET, METADATA_SHEET]:
        return {}
    pairs = [row[:2] for row in _rows(workbook[METADATA_SHEET], path) if len(row) > 1]
    entries = [entry_from_text(str(key), str(value)) for key, value in pairs if key is not None and value is not None]
    return dict(entry for entry in entries if entry is not None)


def _rows(sheet: Any, path: Path) -> Iterator[tuple[Any, ...]]:
    """Yield the values of each row. Raises RecordingError beyond Excel's own limits, which a damaged file may state."""
    # The size that a sheet states may be wrong, and openpyxl would fill every row up to it.
    sheet.reset_dimensions()
    for number, row in enumerate(sheet.iter_rows(values_only=True), start=1):
        if number > MAX_ROWS or len(row) > MAX_COLUMNS:
            raise RecordingError(
                f"{path}: sheet '{one_line(sheet.title)}' has rows or columns that Excel cannot have; save it again, "
                "or as CSV"
            )
        yield row


def _chosen(sheets: Sequence[Any], wanted: str | None, path: Path) -> tuple[Any, SheetLayout]:
    if wanted is not None:
        named = [sheet for sheet in sheets if sheet.title.strip().lower() == wanted.strip().lower()]
        if not named:
            hint = one_line(nearest_hint(wanted, [sheet.title for sheet in sheets]))
            raise RecordingError(f"{path}: has no sheet '{one_line(wanted)}'{hint}")
        sheets = named[:1]
    found = [(sheet, layout) for sheet in sheets if (layout := _layout(sheet, path)) is not None]
    if len(found) == 1:
        return found[0]
    if not found:
        which = "no sheet holds a" if wanted is None else f"sheet '{one_line(wanted)}' holds no"
        cure = "names in one row and numbers below (formulas need values: open it in Excel or LibreOffice and save it)"
        raise RecordingError(f"{path}: {which} table of numbers; it needs {cure}")
    names = "; ".join(f"'{one_line(sheet.title)}'" for sheet, _ in found[:20])
    raise RecordingError(f"{path}: holds {len(found)} sheets with tables: choose one with --sheet NAME: {names}")


def _layout(sheet: Any, path: Path) -> SheetLayout | None:
    head: list[tuple[Any, ...]] = []
    for row in _rows(sheet, path):
        head.append(row)
        if len(head) == _HEAD_ROWS:
            break
    return layout_of(head)


@dataclass
class _ExcelColumn:
    """The cells of one column: numbers until a text appears, then text; dates as seconds since 1970."""

    header: str
    unit: str | None
    numbers: array[float] = field(default_factory=lambda: array("d"))
    texts: list[str] | None = None
    is_date: bool = False

    def append(self, value: Any) -> None:
        """Add a cell."""
        if self.texts is None and isinstance(value, str) and value.strip():
            self.texts = ["" if math.isnan(number) else repr(number) for number in self.numbers]
        if self.texts is not None:
            self.texts.append("" if value is None else str(value).strip())
            return
        self.is_date = self.is_date or isinstance(value, date)
        self.numbers.append(_number(value))

    def settle(self) -> str | None:
        """Turn a column of numbers that are kept as text into numbers; return a note if it was one."""
        numbers = None if self.texts is None else [number_of_text(text) for text in self.texts]
        if numbers is None or any(number is None for number in numbers):
            return None
        self.numbers, self.texts = array("d", [math.nan if each is None else each for each in numbers]), None
        return f"column '{one_line(self.header)}' keeps its numbers as text"

    @property
    def first_blank(self) -> int | None:
        """The first row without a number, from 0, of a named column of numbers; None if all are filled."""
        numbers = self.numbers if self.header and self.texts is None else array("d")
        return next((row for row, number in enumerate(numbers) if math.isnan(number)), None)

    @property
    def is_empty(self) -> bool:
        """Whether no cell holds anything."""
        return self.texts is None and all(map(math.isnan, self.numbers))


def _number(value: Any) -> float:
    """Return a cell as a number: dates and times in seconds, an empty cell as NaN."""
    if isinstance(value, datetime):
        return (value.replace(tzinfo=None) - _EPOCH).total_seconds()
    if isinstance(value, date):
        return (datetime.combine(value, time()) - _EPOCH).total_seconds()
    if isinstance(value, time):
        return value.hour * 3600.0 + value.minute * 60.0 + value.second + value.microsecond * 1e-6
    if isinstance(value, timedelta):
        return value.total_seconds()
    return float(value) if isinstance(value, (int, float)) else math.nan


def _read(sheet: Any, layout: SheetLayout, path: Path) -> tuple[list[_ExcelColumn], int]:
    headers = layout.headers or numbered_headers(layout.width)
    columns = [_ExcelColumn(header, layout.unit_of(index)) for index, header in enumerate(headers)]
    length = 0
    for number, row in enumerate(_rows(sheet, path)):
        if number < layout.first_row:
            continue
        for index, column in enumerate(columns):
            column.append(row[index] if index < len(row) else None)
        if any(value is not None and value != "" for value in row[: len(columns)]):
            length = number - layout.first_row + 1
    return columns, length


def _table(
    path: Path, title: str, layout: SheetLayout, columns: Sequence[_ExcelColumn], rows: int, formulas: Sequence[str]
) -> TableInMemory:
    kept = [column for column in columns if not column.is_empty and column.header]
    unnamed = sum(not column.is_empty and not column.header for column in columns)
    if not kept:
        cure = "open the workbook in Excel or LibreOffice and save it" if formulas else "check the sheet"
        raise RecordingError(f"{path}: sheet '{one_line(title)}' holds no numbers; {cure}")
    notes = [
        f"column '{name}' holds formulas without values: open the workbook in Excel or LibreOffice and save it"
        for name in formulas
    ]
    notes += [note for column in kept if (note := column.settle())]
    notes += [f"{unnamed} columns without a name were left out"] if unnamed else []
    metadata = metadata_of(layout.entries)
    for column in kept:
        if column.is_date and column.texts is None and math.isfinite(column.numbers[0]):
            metadata["start_time"] = (_EPOCH + timedelta(seconds=column.numbers[0])).isoformat()
            break
    return TableInMemory(
        str(path),
        f"Excel workbook, sheet '{one_line(title)}'",
        tuple(_source_column(column) for column in kept),
        tuple(_cells(column, rows) for column in kept),
        metadata,
        notes=tuple(notes),
        first_row=layout.first_row + 1,
    )


def _source_column(column: _ExcelColumn) -> SourceColumn:
    unit = "s" if column.is_date and column.texts is None else column.unit
    return SourceColumn(one_line(column.header), unit, is_text=column.texts is not None)


def _cells(column: _ExcelColumn, rows: int) -> Cells:
    if column.texts is not None:
        return column.texts[:rows]
    values = np.frombuffer(column.numbers, dtype=np.float64)[:rows]
    return values - values[0] if column.is_date else values


def _without_values(
    path: Path, title: str, layout: SheetLayout, columns: Sequence[_ExcelColumn], openpyxl: Any
) -> list[str]:
    """Return the headers of columns whose first blank cell is a formula: the workbook was never calculated."""
    blank = {index: column.first_blank for index, column in enumerate(columns) if column.first_blank is not None}
    found: list[str] = []
    if not blank:
        return found
    with closing(openpyxl.load_workbook(path, read_only=True, keep_links=False)) as workbook:
        for number, row in enumerate(_rows(workbook[title], path), start=-layout.first_row):
            if number > max(blank.values()):
                break
            for index, place in blank.items():
                if number == place and index < len(row) and str(row[index] or "").startswith("="):
                    found.append(one_line(columns[index].header))
    return found
