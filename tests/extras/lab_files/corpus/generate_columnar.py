"""Write the corpus's HDF5 and Parquet files with h5py, pandas and pyarrow, as other programs lay them out."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas as pd
import pyarrow as pa
from pyarrow import parquet
from tests.extras.lab_files.corpus.lab_signals import (
    DISPLACEMENT_MM,
    FORCE_N,
    PERIOD_S,
    ROWS,
    SHUNT_VOLTAGE_V,
    START,
    TIME_S,
    WIRE_VOLTAGE_V,
)

VECTORS = {"Time": TIME_S, "U wire": WIRE_VOLTAGE_V, "U shunt": SHUNT_VOLTAGE_V, "LVDT": DISPLACEMENT_MM}
UNITS = {"Time": "s", "U wire": "V", "U shunt": "V", "LVDT": "mm"}
TIMES = START + (TIME_S * 1e6).astype("timedelta64[us]")


def good(folder: Path) -> None:
    """Write files that are read, and some that are refused with the cure."""
    hdf5(folder)
    parquets(folder)


def vectors(group: Any, attribute: str = "units", **how: Any) -> None:
    """Write each column as a data set with its unit."""
    for name, values in VECTORS.items():
        group.create_dataset(name, data=values, **how).attrs[attribute] = UNITS[name]


def hdf5(folder: Path) -> None:
    """Write HDF5 files."""
    with h5py.File(folder / "hdf5_vectors.h5", "w") as file:
        vectors(file)
        file.attrs["Shunt resistance [ohm]"] = "0.47"
    with h5py.File(folder / "hdf5_group_compressed.hdf5", "w") as file:
        vectors(file.create_group("run/daq"), "Unit", chunks=(16,), compression="gzip", shuffle=True)
    with h5py.File(folder / "hdf5_two_groups.h5", "w") as file:
        vectors(file.create_group("daq"))
        file["load_cell/Time"], file["load_cell/Force"] = TIME_S, FORCE_N
    with h5py.File(folder / "hdf5_records.h5", "w") as file:
        records = np.zeros(ROWS, dtype=[("time_s", "f8"), ("wire_voltage_v", "f4"), ("force_n", "f8"), ("state", "S8")])
        records["time_s"], records["wire_voltage_v"], records["force_n"] = TIME_S, WIRE_VOLTAGE_V, FORCE_N
        file["log"] = records
    with h5py.File(folder / "hdf5_matrix_with_names.h5", "w") as file:
        matrix = file.create_dataset("data", data=np.column_stack(list(VECTORS.values())))
        matrix.attrs["column_names"] = list(VECTORS)
        matrix.attrs["units"] = list(UNITS.values())
    with h5py.File(folder / "hdf5_matrix_in_rows.h5", "w") as file:
        matrix = file.create_dataset("data", data=np.vstack([WIRE_VOLTAGE_V, FORCE_N]))
        matrix.attrs["channels"] = "Wire voltage [V], Force [N]"
        file["sample_rate"] = 1.0 / PERIOD_S
    with h5py.File(folder / "hdf5_link_to_another_file.h5", "w") as file:
        vectors(file)
        file["elsewhere"] = h5py.ExternalLink("hdf5_vectors.h5", "/Time")


def parquets(folder: Path) -> None:
    """Write Parquet files."""
    frame = pd.DataFrame({f"{name} [{UNITS[name]}]": values for name, values in VECTORS.items()})
    frame.attrs["shunt_resistance_ohm"] = 0.47
    frame.to_parquet(folder / "parquet_pandas.parquet")
    stamped = frame.drop(columns="Time [s]").set_index(pd.DatetimeIndex(TIMES, name="Timestamp"))
    stamped.to_parquet(folder / "parquet_pandas_times.parquet")
    fields = [pa.field(name, pa.float64(), metadata={"unit": UNITS[name]}) for name in VECTORS]
    table = pa.Table.from_arrays([pa.array(values) for values in VECTORS.values()], schema=pa.schema(fields))
    parquet.write_table(table, folder / "parquet_arrow_units.parquet", row_group_size=16)
    mixed = table.append_column("state", pa.array(["on"] * ROWS).dictionary_encode())
    mixed = mixed.append_column("raw", pa.array([[1, 2]] * ROWS))
    parquet.write_table(mixed, folder / "parquet_text_and_lists.parquet")


def damaged(folder: Path, good_folder: Path) -> None:
    """Write files that are refused."""
    damaged_hdf5(folder, good_folder)
    whole = (good_folder / "parquet_arrow_units.parquet").read_bytes()
    (folder / "parquet_cut_off.parquet").write_bytes(whole[: len(whole) // 2])
    (folder / "parquet_footer_damaged.parquet").write_bytes(whole[:-200] + b"\xff" * 150 + whole[-50:])
    (folder / "parquet_a_pickle.parquet").write_bytes(b"\x80\x04cposix\nsystem\n(S'touch pickled'\ntR.")
    table = pa.table({"time_s": TIME_S, "force_n": FORCE_N})
    deep = json.dumps({"format_version": 1}).encode() + b"[" * 5_000
    parquet.write_table(
        table.replace_schema_metadata({b"musclewire-recording": deep}), folder / "parquet_deep_metadata.parquet"
    )


def damaged_hdf5(folder: Path, good_folder: Path) -> None:
    """Write HDF5 files that are refused."""
    whole = (good_folder / "hdf5_vectors.h5").read_bytes()
    (folder / "hdf5_cut_off.h5").write_bytes(whole[: len(whole) // 2])
    (folder / "hdf5_not_one.h5").write_bytes(b"time,force\n" * 100)
    with h5py.File(folder / "hdf5_links_out_alone.h5", "w") as file:
        file["Time"] = h5py.ExternalLink("/etc/passwd", "/")
        file["loop"] = h5py.SoftLink("/loop")
    with h5py.File(folder / "hdf5_virtual.h5", "w") as file:
        for name in ("Time", "Force"):
            layout = h5py.VirtualLayout((ROWS,), "f8")
            layout[:] = h5py.VirtualSource("../read/hdf5_vectors.h5", "Time", (ROWS,))
            file.create_virtual_dataset(f"{name} [s]" if name == "Time" else f"{name} [N]", layout)
    with h5py.File(folder / "hdf5_numbers_outside.h5", "w") as file:
        outside = [("outside.bin", 0, ROWS * 8)]
        for name in ("time_s", "force_n"):
            file.create_dataset(name, (ROWS,), "f8", external=outside)
    with h5py.File(folder / "hdf5_huge_shape.h5", "w") as file:
        for name in ("time_s", "force_n"):
            file.create_dataset(name, (2**60,), "f8", chunks=(1024,))
    unknown_filter(folder / "hdf5_unknown_filter.h5")


def unknown_filter(path: Path) -> None:
    """Write a file whose data sets name a filter that HDF5 would load a library for."""
    with h5py.File(path, "w") as file:
        for name in ("time_s", "force_n"):
            plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            plist.set_chunk((ROWS,))
            plist.set_filter(32001, h5py.h5z.FLAG_OPTIONAL, (1, 2, 3))
            space = h5py.h5s.create_simple((ROWS,))
            dataset = h5py.h5d.create(file.id, name.encode(), h5py.h5t.NATIVE_DOUBLE, space, plist)
            dataset.write_direct_chunk((0,), b"packed by nobody" * ROWS)
