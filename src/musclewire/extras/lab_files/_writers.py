"""What writes the files of MATLAB and Excel, and Parquet."""

from __future__ import annotations

from musclewire.extras.lab_files._excel import fill_excel
from musclewire.extras.lab_files._matlab import fill_of_version
from musclewire.extras.lab_files._parquet_table import fill_parquet, fill_parquet_blocks
from musclewire.signals import FileWriter

MATLAB = FileWriter(fill_of_version)
EXCEL = FileWriter(lambda _version: fill_excel)
PARQUET = FileWriter(lambda _version: fill_parquet, fill_parquet_blocks)
