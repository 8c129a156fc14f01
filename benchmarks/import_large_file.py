"""A large CSV file is converted in bounded memory: largest resident memory of `musclewire import`, time, and rows kept.

    python benchmarks/import_large_file.py [--quick] [--folder FOLDER] [--pandas]

The file is 2 GiB (64 MiB with --quick) of five columns with units, in two dialects: as programs write numbers, and with
semicolons, decimal commas and dates as text. The memory is the child process's as the kernel counts it (ru_maxrss).
Ends with exit code 1 above 500 MiB, or if a row is missing.

With --pandas a file of 300 MB is checked by `musclewire import` without -o, and read by `pandas.read_csv`, both in
processes of their own in the same run: exit code 1 above 2.5 times the time or 1 time the memory of pandas.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter

import h5py

MOST_MEMORY_MIB = 500.0
SIZES_MIB = {False: 2048, True: 64}
# What a check of a file may take of what pandas needs to read it.
PANDAS_MIB = 287  # 300 MB
MAX_TIME_RATIO, MAX_MEMORY_RATIO = 2.5, 1.0
READ_BY_PANDAS = "import sys, pandas; pandas.read_csv(sys.argv[1])"
HEADERS = {
    "plain": "Time [s],V_SMA [V],V_R [V],LVDT [mm],T [degC]\n",
    "dates": "Zeitstempel;V_SMA [mV];V_R [mV];Weg [mm];T [°C]\n",
}
ROWS_AT_ONCE = 100_000
PERIOD_S = 0.001


def row(dialect: str, number: int) -> str:
    """Return one row of the table."""
    voltage, shunt, position, temperature = 1.0 + number % 997 * 1e-3, number % 101 * 1e-3, number % 31 * 0.1, 22.5
    if dialect == "plain":
        return f"{number * PERIOD_S:.3f},{voltage:.4f},{shunt:.5f},{position:.3f},{temperature:.2f}\n"
    second, millisecond = divmod(number, 1000)
    minute, second = divmod(second, 60)
    hour, minute = divmod(minute, 60)
    day, hour = divmod(hour, 24)
    cells = f"{1e3 * voltage:.1f};{1e3 * shunt:.2f};{position:.3f};{temperature:.2f}".replace(".", ",")
    return f"2026-03-{1 + day:02d} {hour:02d}:{minute:02d}:{second:02d}.{millisecond:03d};{cells}\n"


def write_table(path: Path, dialect: str, size_mib: int) -> int:
    """Write a file of at least this size and return its rows."""
    rows, size = 0, size_mib << 20
    with path.open("w", encoding="utf-8") as file:
        file.write(HEADERS[dialect])
        while file.tell() < size:
            file.write("".join(row(dialect, number) for number in range(rows, rows + ROWS_AT_ONCE)))
            rows += ROWS_AT_ONCE
    return rows


def converted(path: Path, output: Path) -> tuple[float, float]:
    """Convert a file in a process of its own; return its largest resident memory [MiB] and its time [s]."""
    return taken_by(["-m", "musclewire", "import", str(path), "-o", str(output), "--overwrite", "--json"])


def taken_by(arguments: list[str]) -> tuple[float, float]:
    """Run Python in a process of its own; return its largest resident memory [MiB] and its time [s]."""
    began = perf_counter()
    command = [sys.executable, *arguments]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as child:
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        sys.exit(f"{' '.join(arguments[:3])} ended with exit code {child.returncode}")
    return usage.ru_maxrss / 1024.0, perf_counter() - began


def measured(dialect: str, folder: Path, size_mib: int) -> dict[str, object]:
    """Return what converting a file of one dialect took."""
    path, output = folder / f"{dialect}.csv", folder / f"{dialect}.h5"
    rows = write_table(path, dialect, size_mib)
    memory_mib, time_s = converted(path, output)
    with h5py.File(output) as file:
        kept, last_s = int(file.attrs["rows"]), float(file["time_s"][-1])
    path.unlink()
    output.unlink()
    complete = kept == rows and abs(last_s - (rows - 1) * PERIOD_S) < 1e-6
    return {
        "dialect": dialect,
        "size_mib": size_mib,
        "rows": rows,
        "complete": complete,
        "memory_mib": round(memory_mib, 1),
        "time_s": round(time_s, 1),
        "within": complete and memory_mib <= MOST_MEMORY_MIB,
    }


def compared(folder: Path, size_mib: int) -> dict[str, object]:
    """Return what checking a plain file takes, as a ratio to what pandas takes to read it."""
    path = folder / "plain.csv"
    rows = write_table(path, "plain", size_mib)
    memory_mib, time_s = taken_by(["-m", "musclewire", "import", str(path), "--json"])
    pandas_mib, pandas_s = taken_by(["-c", READ_BY_PANDAS, str(path)])
    return {
        "size_mib": size_mib,
        "rows": rows,
        "memory_mib": round(memory_mib, 1),
        "time_s": round(time_s, 1),
        "pandas_memory_mib": round(pandas_mib, 1),
        "pandas_time_s": round(pandas_s, 1),
        "memory_ratio": round(memory_mib / pandas_mib, 2),
        "time_ratio": round(time_s / pandas_s, 2),
        "within": memory_mib <= MAX_MEMORY_RATIO * pandas_mib and time_s <= MAX_TIME_RATIO * pandas_s,
    }


def main() -> int:
    """Measure both dialects and print what was found."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true", help="64 MiB instead of 2 GiB")
    parser.add_argument("--folder", type=Path, help="where the large files are written and removed again")
    parser.add_argument("--pandas", action="store_true", help="compare checking 300 MB with pandas instead")
    options = parser.parse_args()
    if options.pandas:
        with tempfile.TemporaryDirectory(dir=options.folder) as folder:
            ratio = compared(Path(folder), SIZES_MIB[True] if options.quick else PANDAS_MIB)
        print(json.dumps(ratio, indent=2))
        return 0 if ratio["within"] else 1
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        found = [measured(dialect, Path(folder), SIZES_MIB[options.quick]) for dialect in HEADERS]
    print(json.dumps({"most_memory_mib": MOST_MEMORY_MIB, "files": found}, indent=2))
    return 0 if all(item["within"] for item in found) else 1


if __name__ == "__main__":
    sys.exit(main())
