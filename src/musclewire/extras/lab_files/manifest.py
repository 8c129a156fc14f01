"""Recordings in text of any layout, in the files of LabVIEW, MATLAB and Excel, and in HDF5 and Parquet of others."""

from __future__ import annotations

from musclewire.manifest import Manifest

__all__ = ["MANIFEST"]

# Of text; the core reads plain CSV alone.
TEXT_SUFFIXES = (".tsv", ".txt", ".dat", ".asc", ".log", ".tra", ".prn", ".jsonl", ".ndjson")
MANIFEST = Manifest(
    name="lab_files",
    readers=("musclewire.extras.lab_files._formats:lab_file_reader",),
    suffixes_read=(*TEXT_SUFFIXES, ".tdms", ".lvm", ".mat", ".xlsx", ".parquet", ".nc"),
    kernels=("musclewire.extras.lab_files._plain_rows",),
    writers={
        ".mat": "musclewire.extras.lab_files._matlab:WRITER",
        ".parquet": "musclewire.extras.lab_files._parquet_table:WRITER",
        ".xlsx": "musclewire.extras.lab_files._excel:WRITER",
    },
)
