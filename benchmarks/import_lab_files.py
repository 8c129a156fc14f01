"""Convert large files of LabVIEW, MATLAB, HDF5 and Parquet to our format, and print memory and time of each.

    python benchmarks/import_lab_files.py [--mib 256]

Each conversion runs in a process of its own; its largest memory is what the system counted. The file holds a time and
three channels of float64, in segments, chunks or row groups of 65,536 rows, as programs write them
that measure for hours.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
from nptdms import ChannelObject, TdmsWriter
from pyarrow import parquet
from tests.extras.lab_files.corpus.generate_matlab import mat73

NAMES = {"time_s": "s", "wire_voltage_v": "V", "shunt_voltage_v": "V", "displacement_m": "m"}
BLOCK = 65_536

CHILD = """
import resource, sys, time
from musclewire.signals import import_recording
began_s = time.perf_counter()
rows = import_recording(sys.argv[1], sys.argv[2]).row_count
spent_s = time.perf_counter() - began_s
print(rows, round(spent_s, 1), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024)
"""


def blocks(rows: int) -> Iterator[dict[str, np.ndarray]]:
    """Yield blocks of columns that do not repeat."""
    generator = np.random.default_rng(15)
    for start in range(0, rows, BLOCK):
        count = min(BLOCK, rows - start)
        time_s = (start + np.arange(count)) * 1e-3
        yield {name: time_s if name == "time_s" else generator.random(count) for name in NAMES}


def write_tdms(path: Path, rows: int) -> None:
    """Write a segment a block."""
    with TdmsWriter(path) as writer:
        for block in blocks(rows):
            writer.write_segment(
                [
                    ChannelObject("Measured", name, values, {"unit_string": NAMES[name]})
                    for name, values in block.items()
                ]
            )


def write_hdf5(path: Path, rows: int, matlab: bool = False) -> None:
    """Write data sets in chunks, with MATLAB's header and classes if asked."""
    with mat73(path) if matlab else h5py.File(path, "w") as file:
        for name in NAMES:
            shape = (1, rows) if matlab else (rows,)
            dataset = file.create_dataset(name, shape, "f8", chunks=(*shape[:-1], BLOCK))
            dataset.attrs["MATLAB_class" if matlab else "units"] = np.bytes_("double") if matlab else NAMES[name]
        for number, block in enumerate(blocks(rows)):
            for name, values in block.items():
                file[name][..., number * BLOCK : number * BLOCK + values.size] = values


def write_parquet(path: Path, rows: int) -> None:
    """Write a row group a block."""
    schema = pa.schema([pa.field(name, pa.float64()) for name in NAMES])
    with parquet.ParquetWriter(path, schema) as writer:
        for block in blocks(rows):
            writer.write_table(pa.table(block, schema=schema))


def main() -> None:
    """Write each file, convert it, and print a line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mib", type=int, default=256, help="size of each file")
    rows = parser.parse_args().mib * 2**20 // (8 * len(NAMES))
    writers: dict[str, Callable[[Path, int], None]] = {
        "big.tdms": write_tdms,
        "big.hdf5": write_hdf5,
        "big.mat": lambda path, count: write_hdf5(path, count, matlab=True),
        "big.parquet": write_parquet,
    }
    with tempfile.TemporaryDirectory() as folder:
        for name, write in writers.items():
            path = Path(folder) / name
            write(path, rows)
            command = [sys.executable, "-c", CHILD, str(path), str(path.with_name("out.h5"))]
            done = subprocess.run(command, capture_output=True, text=True, check=True)
            count, spent_s, memory_mib = done.stdout.split()
            size_mib = path.stat().st_size // 2**20
            print(f"{path.suffix}: {size_mib} MiB, {count} rows, {spent_s} s, {memory_mib} MiB of memory at most")
            path.unlink()


if __name__ == "__main__":
    main()
