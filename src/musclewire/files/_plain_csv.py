"""Plain CSV: what we write, and what else is a line of names and rows of numbers between commas.

Other text is read by the part lab_files, where it is there, and so is this.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from musclewire.errors import RecordingError
from musclewire.files._source_table import SourceColumn, TableInMemory
from musclewire.signals import entry_from_text


def read_plain_csv(path: Path) -> TableInMemory:
    """Return the table of a CSV file: comments "# key = value", names, numbers. Raises RecordingError for others."""
    try:
        lines = path.read_text("utf-8-sig").splitlines()
    except (OSError, UnicodeError) as problem:
        raise RecordingError(f"{path}: cannot be read as text: {problem}; check the file") from None
    comments = next((number for number, line in enumerate(lines) if not line.startswith("#")), len(lines))
    stated = [line.lstrip("# ").partition("=") for line in lines[:comments]]
    metadata = dict(filter(None, (entry_from_text(key, value) for key, sign, value in stated if sign)))
    names, *rows = csv.reader(lines[comments:]) if comments < len(lines) else [[]]
    first_row = comments + 2
    numbers = [_numbers(f"{path}: line {number}", row, len(names)) for number, row in enumerate(rows, first_row) if row]
    table = np.array(numbers, dtype=np.float64).reshape(-1, len(names))
    columns = tuple(SourceColumn(name.strip()) for name in names)
    return TableInMemory(
        str(path), "plain CSV", columns, tuple(table.T), metadata, row_word="line", first_row=first_row
    )


def _numbers(line: str, row: Sequence[str], width: int) -> list[float]:
    try:
        found = [float(cell) if cell.strip() else float("nan") for cell in row]
    except ValueError as problem:
        raise RecordingError(
            f"{line}: {problem}; correct it, or add the part lab_files, which reads other text"
        ) from None
    if len(found) != width:
        raise RecordingError(f"{line}: has {len(found)} cells for {width} names; correct it")
    return found
