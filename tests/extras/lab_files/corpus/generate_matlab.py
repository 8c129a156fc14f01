"""Write the corpus's MATLAB files: version 5 and 4 by SciPy, 7.3 as MATLAB lays it out in HDF5."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from scipy.io import savemat
from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    FORCE_N,
    PERIOD_S,
    ROWS,
    SHUNT_VOLTAGE_V,
    TIME_S,
    WIRE_VOLTAGE_V,
)

VECTORS = {"t": TIME_S, "U_wire": WIRE_VOLTAGE_V, "U_shunt": SHUNT_VOLTAGE_V, "disp": DISPLACEMENT_MM}
UNITS = {"t": "s", "U_wire": "V", "U_shunt": "V", "disp": "mm"}
_HEADER_73 = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Fri Mar 08 10:30:28 2024 HDF5 schema 1.00 ."


def good(folder: Path) -> None:
    """Write files that are read."""
    five(folder)
    seven_three(folder)


def five(folder: Path) -> None:
    """Write files of version 5 and 4."""
    named = {f"{name}_{UNITS[name]}": values for name, values in VECTORS.items()}
    savemat(folder / "mat5_columns.mat", {"time_ms": TIME_S * 1e3, **named} | {"t_s": []}, oned_as="column")
    savemat(folder / "mat5_rows_and_units.mat", {**VECTORS, "units": UNITS, "operator": "lab"}, oned_as="row")
    savemat(folder / "mat5_compressed.mat", {**VECTORS, "units": UNITS, "R_shunt": 0.47}, do_compression=True)
    savemat(folder / "mat5_struct.mat", {"run1": {**VECTORS, "units": UNITS}, "leg_length": 0.084})
    two = {"run1": {**VECTORS, "units": UNITS}, "run2": {"t": TIME_S, "force": FORCE_N}}
    savemat(folder / "mat5_two_structs.mat", two)
    matrix = np.column_stack([TIME_S, WIRE_VOLTAGE_V, SHUNT_VOLTAGE_V, DISPLACEMENT_MM])
    savemat(folder / "mat5_matrix.mat", {"data": matrix, "Fs": 1.0 / PERIOD_S})
    savemat(folder / "mat4_columns.mat", {"t": TIME_S, "U_wire": WIRE_VOLTAGE_V, "disp": DISPLACEMENT_MM}, format="4")
    savemat(folder / "mat5_integers.mat", {"t": TIME_S, "U_wire": (WIRE_VOLTAGE_V * 1e3).astype(np.int16)})
    signals = np.zeros(2, dtype=[("values", object), ("dimensions", object), ("label", object), ("blockName", object)])
    signals[0] = (WIRE_VOLTAGE_V[:, None], 1, "wire voltage", "model/U")
    signals[1] = (DISPLACEMENT_MM[:, None], 1, "displacement", "model/x")
    savemat(folder / "mat5_simulink_structure_with_time.mat", {"out": {"time": TIME_S[:, None], "signals": signals}})
    cells = np.array([WIRE_VOLTAGE_V, SHUNT_VOLTAGE_V], dtype=object)
    savemat(folder / "mat5_with_cell.mat", {"T": np.array([["x"], ["y"]], dtype=object), "C": cells})


def seven_three(folder: Path) -> None:
    """Write files of version 7.3."""
    with mat73(folder / "mat73_columns.mat") as file:
        for name, values in VECTORS.items():
            array(file, name, values[:, None])
        text_struct(file, "units", UNITS)
        array(file, "R_shunt", np.array([[0.47]]))
    with mat73(folder / "mat73_rows_compressed.mat") as file:
        for name, values in VECTORS.items():
            array(file, name, values[None, :], chunks=(16, 1), compression="gzip")
        text_struct(file, "units", UNITS)
    with mat73(folder / "mat73_struct.mat") as file:
        group = file.create_group("run1")
        group.attrs["MATLAB_class"] = np.bytes_("struct")
        for name, values in VECTORS.items():
            array(group, name, values[:, None])
        text_struct(group, "units", UNITS)
    with mat73(folder / "mat73_matrix.mat") as file:
        array(file, "data", np.column_stack([TIME_S, WIRE_VOLTAGE_V, DISPLACEMENT_MM]))
    with mat73(folder / "mat73_timetable.mat") as file:
        dataset = file.create_dataset("TT", data=np.array([[0xDD000000, 2, 1, 1, 1, 1]], dtype=np.uint32))
        dataset.attrs["MATLAB_class"] = np.bytes_("timetable")
        dataset.attrs["MATLAB_object_decode"] = np.int32(3)


def mat73(path: Path) -> h5py.File:
    """Return an HDF5 file with MATLAB's 512 bytes in front."""
    with h5py.File(path, "w", userblock_size=512):
        pass
    with path.open("r+b") as raw:
        raw.write(_HEADER_73.ljust(116) + b"\0" * 8 + b"\x00\x02IM")
    return h5py.File(path, "r+")


def array(group: Any, name: str, values: np.ndarray, **how: Any) -> None:
    """Write an array as MATLAB does: dimensions in the opposite order, its class as an attribute."""
    dataset = group.create_dataset(name, data=np.ascontiguousarray(values.T), **how)
    dataset.attrs["MATLAB_class"] = np.bytes_("double" if values.dtype == np.float64 else str(values.dtype))


def text_struct(group: Any, name: str, texts: dict[str, str]) -> None:
    """Write a struct of texts."""
    inner = group.create_group(name)
    inner.attrs["MATLAB_class"] = np.bytes_("struct")
    for key, text in texts.items():
        dataset = inner.create_dataset(key, data=np.frombuffer(text.encode("utf-16-le"), dtype="<u2")[:, None])
        dataset.attrs["MATLAB_class"] = np.bytes_("char")
        dataset.attrs["MATLAB_int_decode"] = np.int32(2)


def element(kind: int, content: bytes) -> bytes:
    """Return one element of a MATLAB 5 file."""
    return struct.pack("<II", kind, len(content)) + content + b"\0" * (-len(content) % 8)


def matrix(matlab_class: int, sizes: tuple[int, ...], name: bytes, *content: bytes) -> bytes:
    """Return an array as an element."""
    flags = element(6, struct.pack("<II", matlab_class, 0))
    return element(
        14, flags + element(5, struct.pack(f"<{len(sizes)}i", *sizes)) + element(1, name) + b"".join(content)
    )


def header() -> bytes:
    """Return the first 128 bytes of a MATLAB 5 file."""
    return b"MATLAB 5.0 MAT-file, made to be refused".ljust(124) + struct.pack("<H", 0x0100) + b"IM"


def damaged(folder: Path, good_folder: Path) -> None:
    """Write files that are refused."""
    whole = (good_folder / "mat5_rows_and_units.mat").read_bytes()
    (folder / "mat5_cut_off.mat").write_bytes(whole[:900])
    (folder / "mat5_header_alone.mat").write_bytes(whole[:128])
    (folder / "mat5_not_one.mat").write_bytes(b"\x80\x04\x95" + b"cposix\nsystem\n(S'touch pickled'\ntR." * 8)
    numbers = element(9, TIME_S.tobytes())
    (folder / "mat5_huge_cell.mat").write_bytes(header() + matrix(1, (2**30, 1), b"c", numbers))
    (folder / "mat5_huge_struct.mat").write_bytes(
        header() + matrix(2, (2**30, 1), b"s", element(5, struct.pack("<i", 8)), element(1, b""))
    )
    (folder / "mat5_size_too_large.mat").write_bytes(header() + matrix(6, (ROWS * 1000, 1), b"t", numbers))
    nested = matrix(6, (1, 1), b"", element(9, b"\0" * 8))
    for _ in range(200):
        nested = matrix(1, (1, 1), b"c", nested)
    (folder / "mat5_nested_200_deep.mat").write_bytes(header() + nested)
    function = matrix(16, (1, 1), b"f", matrix(6, (1, 1), b"", element(9, b"\0" * 8)))
    (folder / "mat5_function_handle.mat").write_bytes(header() + function)
    bomb = zlib.compress(struct.pack("<II", 14, 2**27) + b"\0" * 2**20, 9)
    (folder / "mat5_compressed_and_cut.mat").write_bytes(header() + struct.pack("<II", 15, len(bomb)) + bomb)
    seven = (good_folder / "mat73_columns.mat").read_bytes()
    (folder / "mat73_cut_off.mat").write_bytes(seven[: len(seven) // 2])
    with mat73(folder / "mat73_external_link.mat") as file:
        file["t"] = h5py.ExternalLink("mat73_columns.mat", "t")
        file["U_wire"] = h5py.ExternalLink("/etc/passwd", "/")
    with mat73(folder / "mat73_cell_alone.mat") as file:
        dataset = file.create_dataset("C", (2, 1), dtype=h5py.ref_dtype)
        dataset.attrs["MATLAB_class"] = np.bytes_("cell")
