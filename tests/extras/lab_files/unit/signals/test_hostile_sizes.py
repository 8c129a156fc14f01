"""Files that state or unpack to far more than they are: refused in one line, in bounded memory; files cut anywhere."""

import builtins
import struct
import subprocess
import sys
import zipfile
import zlib

import h5py
import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from tests.extras.lab_files.corpus.generate_excel import repacked
from tests.extras.lab_files.corpus.generate_matlab import header

from musclewire.errors import MissingExtraError, MusclewireError
from musclewire.signals import read_recording

# Reading runs in a process of its own, whose largest memory is asked for afterwards. The kernel's VmHWM is of that
# program alone; ru_maxrss keeps what its parent, a process with thousands of tests behind it, held when it began.
CHILD = r"""
import re, sys
from pathlib import Path
from musclewire.errors import MusclewireError
from musclewire.signals import read_recording
try:
    print(read_recording(sys.argv[1]))
except MusclewireError as problem:
    print(problem)
print(int(re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())[1]) // 1024)
"""
MAX_MEMORY_MIB = 1024


def said_and_memory_mib(path):
    done = subprocess.run([sys.executable, "-c", CHILD, str(path)], capture_output=True, text=True, check=True)
    said, memory_mib = done.stdout.strip().split("\n")
    return said, int(memory_mib)


def zeros_packed(bytes_unpacked, start=b""):
    """Return many zeros as zlib packs them, made piece by piece."""
    packer = zlib.compressobj(9)
    pieces = [packer.compress(start)]
    pieces += [packer.compress(b"\0" * 2**20) for _ in range(bytes_unpacked // 2**20)]
    return b"".join([*pieces, packer.flush()])


@pytest.mark.slow
def test_a_matlab_file_of_a_few_megabytes_that_unpacks_to_gigabytes_is_refused(tmp_path):
    packed = zeros_packed(2**31, struct.pack("<II", 14, 2**31))
    (tmp_path / "bomb.mat").write_bytes(header() + struct.pack("<II", 15, len(packed)) + packed)
    said, memory_mib = said_and_memory_mib(tmp_path / "bomb.mat")
    assert "holds more than 512 MiB" in said
    assert memory_mib < MAX_MEMORY_MIB


@pytest.mark.slow
def test_a_workbook_of_a_few_megabytes_that_unpacks_to_gigabytes_is_refused(lab_files, tmp_path):
    path = tmp_path / "bomb.xlsx"
    repacked(path, lab_files / "read" / "xlsx_plain.xlsx", {})
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=9) as workbook,
        workbook.open("xl/worksheets/sheet2.xml", "w", force_zip64=True) as sheet,
    ):
        for _ in range(1100):
            sheet.write(b" " * 2**20)
    said, memory_mib = said_and_memory_mib(path)
    assert "unpacks to more than 1024 MiB" in said
    assert memory_mib < MAX_MEMORY_MIB


@pytest.mark.slow
def test_a_parquet_file_of_a_megabyte_that_states_hundreds_of_millions_of_rows_is_refused(tmp_path):
    path = tmp_path / "rows.parquet"
    ones = pa.table({"time_s": pa.array(np.ones(2**25, dtype=np.int8))})
    with parquet.ParquetWriter(path, ones.schema) as writer:
        for _ in range(9):
            writer.write_table(ones, row_group_size=2**25)
    said, memory_mib = said_and_memory_mib(path)
    assert "states 301989888 rows" in said
    assert memory_mib < MAX_MEMORY_MIB


@pytest.mark.slow
def test_compressed_hdf5_of_others_that_states_more_than_deflate_can_hold_is_refused(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        for name in ("time_s", "force_n"):
            file.create_dataset(name, (2**31,), "f8", chunks=(2**16,), compression="gzip")[:10] = 1.0
    said, memory_mib = said_and_memory_mib(tmp_path / "a.h5")
    assert "it is damaged" in said
    assert memory_mib < MAX_MEMORY_MIB


NOT_HDF5 = (
    "tdms_waveforms.tdms", "tdms_many_segments.tdms", "lvm_three_packets.lvm", "mat5_rows_and_units.mat",
    "mat5_compressed.mat", "mat4_columns.mat", "xlsx_plain.xlsx", "parquet_arrow_units.parquet",
)  # fmt: skip


@pytest.mark.parametrize("name", NOT_HDF5)
def test_a_file_cut_at_any_of_100_places_is_read_or_refused_in_one_line(lab_files, tmp_path, name):
    whole = (lab_files / "read" / name).read_bytes()
    for length in np.linspace(0, len(whole) - 1, 100).astype(int):
        (tmp_path / name).write_bytes(whole[:length])
        assert "\n" not in said_about(tmp_path / name)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hdf5_group_compressed.hdf5", "mat73_columns.mat"])
def test_an_hdf5_file_cut_at_any_of_12_places_is_refused_in_one_line(lab_files, tmp_path, name):
    whole = (lab_files / "read" / name).read_bytes()
    for length in np.linspace(0, len(whole) - 1, 12).astype(int):
        (tmp_path / name).write_bytes(whole[:length])
        assert said_about(tmp_path / name).startswith(str(tmp_path / name))
        assert "\n" not in said_about(tmp_path / name)


def said_about(path):
    """Return what reading a recording says: nothing, or the error of ours; any other error passes."""
    try:
        read_recording(path)
    except MusclewireError as problem:
        return str(problem)
    return ""


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [
        ("tdms_waveforms.tdms", "nptdms", "labfiles"),
        ("xlsx_plain.xlsx", "openpyxl", "labfiles"),
        ("parquet_pandas.parquet", "pyarrow", "parquet"),
    ],
)
def test_a_missing_package_is_named_by_its_extra(lab_files, monkeypatch, name, package, extra):
    really = builtins.__import__

    def without(called, *rest, **more):
        if called.partition(".")[0] == package:
            raise ImportError(called)
        return really(called, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(MissingExtraError, match=rf"needs the extra '{extra}': pip install"):
        read_recording(lab_files / "read" / name)
