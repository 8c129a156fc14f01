"""Which reader a file of a laboratory program needs: by its suffix, and where that is not enough by its first bytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from musclewire.errors import RecordingError
from musclewire.extras.lab_files.manifest import TEXT_SUFFIXES
from musclewire.files import SourceTable
from musclewire.manifest import loaded

_Reader = Callable[[Path, str | None], SourceTable]
_LABVIEW_TEXT = (b"LabVIEW Measurement", b"\xef\xbb\xbfLabVIEW Measurement")

# Imported when a file needs them: the packages behind them are slow to load, and most commands read none.
_TEXT = (".csv", *TEXT_SUFFIXES)
_READERS = {
    **dict.fromkeys(_TEXT, "_text_tables:read_text_table"),
    ".h5": "_hdf5_tree:read_hdf5_of_others",
    ".hdf5": "_hdf5_tree:read_hdf5_of_others",
    ".lvm": "_lvm:read_lvm_table",
    ".mat": "_matlab:read_matlab_table",
    ".nc": "_netcdf:read_netcdf_table",
    ".parquet": "_parquet_table:read_parquet_table",
    ".tdms": "_tdms:read_tdms_table",
    ".xlsm": "_excel:read_excel_table",
    ".xlsx": "_excel:read_excel_table",
}
# Formats that are near one that is read, with what their program saves instead.
_NEIGHBOURS = {
    ".xls": "save it in Excel as .xlsx",
    ".xlsb": "save it in Excel as .xlsx",
    ".ods": "save it as .xlsx or CSV",
    ".tdms_index": "give the .tdms file next to it",
    ".tdm": "save it as .tdms (LabVIEW, DIAdem)",
    ".mlx": "save the variables with save('name.mat')",
    ".pkl": "a pickle can execute code and is never read: save it with to_parquet or to_csv",
    ".pickle": "a pickle can execute code and is never read: save it with to_parquet or to_csv",
    ".npy": "save it with numpy.savetxt or as .h5",
    ".npz": "save it with numpy.savetxt or as .h5",
}


def lab_file_reader(path: Path) -> _Reader | None:
    """Return the reader of a file by its suffix, or by LabVIEW's first line; None for what others read.

    Raises RecordingError for formats whose program can save a better one.
    """
    suffix = path.suffix.lower()
    if suffix in _NEIGHBOURS:
        raise RecordingError(f"{path}: files ending in '{suffix}' are not read; {_NEIGHBOURS[suffix]}")
    if suffix in _TEXT and path.is_file() and _start(path).startswith(_LABVIEW_TEXT):
        suffix = ".lvm"
    if suffix not in _READERS:
        return None
    reader: _Reader = loaded(f"musclewire.extras.lab_files.{_READERS[suffix]}")
    return reader


def _start(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(64)
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror}; check the file") from None
