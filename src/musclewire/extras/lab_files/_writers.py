"""What writes the files of MATLAB and Excel, and Parquet."""

from __future__ import annotations

from musclewire.errors import require_extra
from musclewire.extras.lab_files._excel import fill_excel
from musclewire.extras.lab_files._matlab import fill_of_version
from musclewire.extras.lab_files._parquet_table import fill_parquet, fill_parquet_blocks
from musclewire.signals import FileWriter, Fill

MATLAB = FileWriter(fill_of_version)
EXCEL = FileWriter(lambda _version: fill_excel)


def fill_of_parquet(_version: str | None) -> Fill:
    """Return what writes Parquet. Raises MissingExtraError without pyarrow."""
    require_extra("a Parquet file", "parquet")
    return fill_parquet


PARQUET = FileWriter(fill_of_parquet, fill_parquet_blocks)
