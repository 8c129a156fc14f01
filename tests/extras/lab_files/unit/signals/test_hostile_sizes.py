"""Workbooks that unpack to far more than they are: refused in bounded memory; files of every format cut anywhere."""

import shutil
import subprocess
import sys
import zipfile

import numpy as np
import pytest

from musclewire.errors import MissingExtraError, MusclewireError
from musclewire.files import read_recording

# Reading runs in a process of its own, whose largest memory is asked for afterwards. The kernel's VmHWM is of that
# program alone; ru_maxrss keeps what its parent, a process with thousands of tests behind it, held when it began.
CHILD = r"""
import re, sys
from pathlib import Path
from musclewire.errors import MusclewireError
from musclewire.files import read_recording
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


@pytest.mark.slow
def test_a_workbook_of_a_few_megabytes_that_unpacks_to_gigabytes_is_refused(lab_files, tmp_path):
    path = tmp_path / "bomb.xlsx"
    shutil.copyfile(lab_files / "read" / "xlsx_plain.xlsx", path)
    with (
        zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=9) as workbook,
        workbook.open("xl/worksheets/sheet2.xml", "w", force_zip64=True) as sheet,
    ):
        for _ in range(1100):
            sheet.write(b" " * 2**20)
    said, memory_mib = said_and_memory_mib(path)
    assert "unpacks to more than 1024 MiB" in said
    assert memory_mib < MAX_MEMORY_MIB


CUT = (
    "tdms_waveforms.tdms", "tdms_many_segments.tdms", "lvm_three_packets.lvm", "mat5_rows_and_units.mat",
    "mat5_compressed.mat", "mat4_columns.mat", "mat73_columns.mat", "xlsx_plain.xlsx", "parquet_arrow_units.parquet",
    "hdf5_group_compressed.hdf5", "netcdf_classic.nc", "pandas_table.h5",
)  # fmt: skip


@pytest.mark.parametrize("name", CUT)
def test_a_file_cut_at_any_of_100_places_is_read_or_refused_in_one_line(lab_files, tmp_path, name):
    whole = (lab_files / "read" / name).read_bytes()
    for length in np.linspace(0, len(whole) - 1, 100).astype(int):
        (tmp_path / name).write_bytes(whole[:length])
        assert "\n" not in said_about(tmp_path / name)


def said_about(path):
    """Return what reading a recording says: nothing, or the error of ours; any other error passes."""
    try:
        read_recording(path)
    except MusclewireError as problem:
        return str(problem)
    return ""


def test_a_missing_package_is_named_by_its_extra(lab_files, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingExtraError, match="needs the extra 'parquet': pip install"):
        read_recording(lab_files / "read" / "parquet_pandas.parquet")
