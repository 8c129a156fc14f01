"""Which reader a file of a laboratory program needs: by its suffix, and where that is not enough by its first bytes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from musclewire.errors import RecordingError
from musclewire.signals import SourceTable

LAB_SUFFIXES = (".tdms", ".lvm", ".mat", ".xlsx", ".parquet")

_Reader = Callable[[Path, str | None], SourceTable]
_TEXT = frozenset({".csv", ".tsv", ".txt", ".dat", ".asc"})

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
    """Return the reader of LabVIEW's, MATLAB's, Excel's, Parquet and others' HDF5 files, None for any other suffix.

    A reader takes the path and the name of a group or sheet, None for the only one. LabVIEW's text files are known by
    their first line, whatever they are called. Raises RecordingError for formats whose program can save a better one.
    """
    suffix = path.suffix.lower()
    if suffix in {".h5", ".hdf5"}:
        from musclewire.extras.lab_files._foreign_hdf5 import read_hdf5_of_others

        return read_hdf5_of_others
    if suffix in _NEIGHBOURS:
        raise RecordingError(f"{path}: files ending in '{suffix}' are not read; {_NEIGHBOURS[suffix]}")
    if suffix == ".lvm" or (suffix in _TEXT and path.is_file() and _is_labview_text(path)):
        from musclewire.extras.lab_files._lvm import read_lvm_table

        return read_lvm_table
    return _binary_reader(suffix)


def _binary_reader(suffix: str) -> _Reader | None:
    # Imported here: the packages behind them are slow to load, and most commands read none of these files.
    if suffix == ".tdms":
        from musclewire.extras.lab_files._tdms import read_tdms_table

        return read_tdms_table
    if suffix in {".xlsx", ".xlsm"}:
        from musclewire.extras.lab_files._excel import read_excel_table

        return read_excel_table
    if suffix == ".parquet":
        from musclewire.extras.lab_files._parquet_table import read_parquet_table

        return read_parquet_table
    if suffix == ".mat":
        from musclewire.extras.lab_files._matlab import read_matlab_table

        return read_matlab_table
    return None


def _is_labview_text(path: Path) -> bool:
    from musclewire.extras.lab_files._lvm import is_lvm

    return is_lvm(_start(path, 64).decode("utf-8", errors="replace"))


def _start(path: Path, count: int) -> bytes:
    try:
        with path.open("rb") as file:
            return file.read(count)
    except OSError as problem:
        raise RecordingError(f"{path}: cannot be read: {problem.strerror}; check the file") from None
