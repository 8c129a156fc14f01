"""Recordings as Excel workbooks: a sheet of columns with our names, and a sheet of metadata. Needs ``labfiles``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from musclewire.arrays import FloatArray
from musclewire.errors import CallerError, MissingExtraError
from musclewire.signals import MetadataValue, value_to_text

RECORDING_SHEET, METADATA_SHEET = "recording", "metadata"
MAX_ROWS = 1_048_575


def fill_excel(columns: Mapping[str, FloatArray], metadata: Mapping[str, MetadataValue], path: Path) -> None:
    """Write a workbook. Raises CallerError for more rows than a sheet holds, MissingExtraError without openpyxl."""
    try:
        from openpyxl import Workbook
        from openpyxl.cell import WriteOnlyCell
    except ImportError:
        raise MissingExtraError("an Excel workbook", "labfiles") from None
    rows = len(next(iter(columns.values())))
    if rows > MAX_ROWS:
        raise CallerError(f"{path}: {rows} rows are more than the {MAX_ROWS} of an Excel sheet; save as .csv or .h5")
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
