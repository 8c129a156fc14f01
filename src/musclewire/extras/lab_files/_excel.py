"""Excel workbooks (.xlsx, .xlsm), one sheet at a time, values only.

A sheet's rows become lines of text, so that titles, headers, units, dates and numbers are found in it by the rules for
tables in text files.
"""

from __future__ import annotations

import csv
import io
import itertools
import re
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, RecordingError, argument, nearest_hint
from musclewire.extras.lab_files._file_table import MAX_NAMED, check_limits, damage_reported, one_line
from musclewire.extras.lab_files._text_lines import Line
from musclewire.extras.lab_files._text_tables import TextTable, table_of_lines
from musclewire.files import CurableError, ImportMapping
from musclewire.signals import FileWriter, MetadataValue, entry_from_text, value_to_text

MAX_ROWS = 1_048_576  # of a sheet of Excel 2007 and later
MAX_COLUMNS = 16_384  # of the same
_HEAD_ROWS = 60  # titles, headers and rows enough to see what the columns are without reading a long sheet
_SEPARATOR = ";"  # between the cells of a line: a comma may be in a number
_DECIMAL_COMMA = re.compile(r"[+-]?(?:[0-9]+|[0-9]{1,3}(?:\.[0-9]{3})+),[0-9]+(?:[eE][+-]?[0-9]+)?")
_OLE = b"\xd0\xcf\x11\xe0"  # old workbooks begin so, and new ones with a password


def read_excel_table(path: Path, group: str | None = None) -> TextTable:
    """Return the table of one sheet of a workbook; None takes the only one that holds numbers below headers.

    Formulas give the value that was saved with them, and macros are never looked at. Raises RecordingError as one line.
    """
    import openpyxl

    with path.open("rb") as file:
        if file.read(4) == _OLE:
            cure = "save it as .xlsx, without a password"
            raise RecordingError(f"{path}: is an old .xls workbook or has a password; {cure}")
    with damage_reported(path, "an Excel workbook"), warnings.catch_warnings():
        # openpyxl warns of styles and extensions that it leaves out.
        warnings.simplefilter("ignore")
        check_limits(path, at_once=True)
        with closing(openpyxl.load_workbook(path, read_only=True, data_only=True, keep_links=False)) as workbook:
            own = _own_metadata(workbook, path)
            sheet = _chosen(workbook.worksheets, RECORDING_SHEET if own and group is None else group, path)
            table = _table(sheet, list(_lines(sheet, path)), path)
        return replace(
            table, metadata=own or table.metadata, notes=(*table.notes, *_formulas(path, sheet.title, table, openpyxl))
        )


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
            where = f"{path}: sheet '{one_line(sheet.title)}'"
            raise RecordingError(f"{where} has rows or columns that Excel cannot have; save it again, or as CSV")
        yield row


def _lines(sheet: Any, path: Path) -> Iterator[Line]:
    rows = _rows(sheet, path)
    head = list(itertools.islice(rows, _HEAD_ROWS))
    dates = set(range(max(map(len, head), default=0)))
    for row in head:
        # openpyxl gives a date without a time as midnight.
        dates -= {index for index, value in enumerate(row) if isinstance(value, datetime) and value.time() != time()}
    for number, row in enumerate(itertools.chain(head, rows), start=1):
        line = io.StringIO()
        cells = [_text(value, index in dates) for index, value in enumerate(row)]
        csv.writer(line, delimiter=_SEPARATOR, lineterminator="").writerow(cells)
        yield number, line.getvalue()


def _text(value: Any, is_date: bool) -> str:
    """Return a cell as a text file would write it."""
    if isinstance(value, datetime) and is_date:
        return value.date().isoformat()
    if isinstance(value, str):
        text = " ".join(value.split())
        return text.replace(".", "").replace(",", ".") if _DECIMAL_COMMA.fullmatch(text) else text
    if isinstance(value, timedelta):
        minutes, seconds = divmod(value.total_seconds(), 60.0)
        return f"{minutes // 60:.0f}:{minutes % 60:02.0f}:{seconds:09.6f}"
    if isinstance(value, bool):
        return str(int(value))
    return "" if value is None else str(value)


def _table(sheet: Any, lines: Sequence[Line], path: Path) -> TextTable:
    what = f"Excel workbook, sheet '{one_line(sheet.title)}'"
    return table_of_lines(str(path), lambda: iter(lines), what, _SEPARATOR)


def _chosen(sheets: Sequence[Any], wanted: str | None, path: Path) -> Any:
    if wanted is not None:
        named = [sheet for sheet in sheets if sheet.title.strip().lower() == wanted.strip().lower()]
        if not named:
            hint = one_line(nearest_hint(wanted, [sheet.title for sheet in sheets]))
            raise RecordingError(f"{path}: has no sheet '{one_line(wanted)}'{hint}")
        sheets = named[:1]
    found = [sheet for sheet in sheets if _holds_numbers(sheet, path)]
    if wanted is None:
        # Who hid a sheet does not mean it, unless nothing else is there.
        found = [sheet for sheet in found if sheet.sheet_state == "visible"] or found
    if len(found) == 1:
        return found[0]
    if not found:
        which = "no sheet holds a" if wanted is None else f"sheet '{one_line(wanted)}' holds no"
        cure = "names in one row and numbers below (formulas need values: open it in Excel or LibreOffice and save it)"
        raise RecordingError(f"{path}: {which} table of numbers; it needs {cure}")
    names = "; ".join(f"'{one_line(sheet.title)}' ({_headers_of(sheet, path)})" for sheet in found[:20])
    message = (
        f"{path}: holds {len(found)} sheets with tables: choose one with " + argument("group", "NAME") + f": {names}"
    )
    raise CurableError(message, ImportMapping(group=found[0].title))


def _headers_of(sheet: Any, path: Path) -> str:
    headers = [f"'{one_line(column.header)}'" for column in _table(sheet, _head(sheet, path), path).columns]
    return ", ".join(headers[:MAX_NAMED]) + (", ..." if len(headers) > MAX_NAMED else "")


def _head(sheet: Any, path: Path) -> list[Line]:
    return list(itertools.islice(_lines(sheet, path), _HEAD_ROWS))


def _holds_numbers(sheet: Any, path: Path) -> bool:
    try:
        _table(sheet, _head(sheet, path), path)
    except RecordingError:
        return False
    return True


def _formulas(path: Path, title: str, table: TextTable, openpyxl: Any) -> list[str]:
    """Return a note for each column that begins with formulas without values: the workbook was never calculated."""
    rows = [row for row, _ in zip(table.lines(), range(table.text_layout.first_line + 1), strict=False)]
    found: list[str] = []
    with closing(openpyxl.load_workbook(path, read_only=True, keep_links=False)) as workbook:
        for (number, line), row in zip(rows, _rows(workbook[title], path), strict=False):
            values = next(csv.reader([line], delimiter=_SEPARATOR), [])
            for index, (column, formula) in enumerate(zip(table.columns, row, strict=False)):
                blank = index >= len(values) or not values[index]
                if number >= table.text_layout.first_line and blank and str(formula).startswith("="):
                    found.append(one_line(column.header))
    cure = "open the workbook in Excel or LibreOffice and save it"
    return [f"column '{name}' holds formulas without values: {cure}" for name in dict.fromkeys(found)]


RECORDING_SHEET = "recording"  # a workbook that we wrote holds this sheet,
METADATA_SHEET = "metadata"  # this one, and no other
SHEET_ROWS = 1_048_575  # below the row of names


def fill_excel(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write a workbook. Raises CallerError for more rows than a sheet holds."""
    from openpyxl import Workbook
    from openpyxl.cell import WriteOnlyCell

    rows = len(next(iter(columns.values())))
    if rows > SHEET_ROWS:
        raise CallerError(f"{path}: {rows} rows are more than the {SHEET_ROWS} of an Excel sheet; save as .csv or .h5")
    workbook = Workbook(write_only=True)
    sheet = workbook.create_sheet(RECORDING_SHEET)
    sheet.append(list(columns))
    for row in zip(*(_cells(values) for values in columns.values()), strict=True):
        sheet.append(row)
    sheet = workbook.create_sheet(METADATA_SHEET)
    for key, value in metadata.items():
        cell = WriteOnlyCell(sheet, value_to_text(key, value))
        # Text, whatever it begins with: "=" would make it a formula.
        cell.data_type = "s"
        sheet.append([key, cell])
    with path.open("wb") as file:
        workbook.save(file)


def _cells(values: FloatArray) -> list[float | None]:
    """Return a column as cells: what is no number is an empty cell, which Excel can keep."""
    return [value if np.isfinite(value) else None for value in values.tolist()]


WRITER = FileWriter(lambda _version: fill_excel)
