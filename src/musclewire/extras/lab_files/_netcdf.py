"""NetCDF: version 4, which is HDF5, and the classic one as SciPy reads it."""

from __future__ import annotations

from pathlib import Path

from musclewire.extras.lab_files._file_table import FileTable, check_limits, chosen_table, damage_reported
from musclewire.extras.lab_files._hdf5_tree import hdf5_path, read_hdf5_of_others
from musclewire.extras.lab_files._named_arrays import Folder, NamedArray, parts_of


def read_netcdf_table(path: Path, group: str | None = None) -> FileTable:
    """Return the table of the variables of one length; None takes the only one. Raises RecordingError as one line."""
    with path.open("rb") as file:
        if file.read(4) == b"\x89HDF":
            return read_hdf5_of_others(path, group)
    with damage_reported(path, "netCDF"):
        return chosen_table(path, "netCDF, '{}'", parts_of([_folder(path)], hdf5_path), group)


def _folder(path: Path) -> Folder:
    from scipy.io import netcdf_file

    check_limits(path, at_once=True)
    with netcdf_file(str(path), mmap=False) as file:
        # SciPy keeps the attributes of a file and of a variable under this name alone.
        folder = Folder(attributes=vars(file)["_attributes"])
        for name, variable in file.variables.items():
            values, attributes = variable.data, vars(variable)["_attributes"]
            if values.dtype.kind in "biuf":
                folder.arrays.append(NamedArray(name, variable.shape, values.__getitem__, attributes))
            else:
                folder.left_out[name] = "it holds no real numbers"
    return folder
