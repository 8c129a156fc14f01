"""Files of Excel, MATLAB, LabVIEW, HDF5 and netCDF as laboratories make them; see ``tests/labs/layouts.py``."""

from __future__ import annotations

import io
from collections.abc import Sequence
from datetime import timedelta

import h5py
import numpy as np
import openpyxl
import xarray as xr
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat
from tests.labs.layouts import AMP, BEGAN, FORCE, SHUNT, STROKE, TIME, Layout, R, V, Written, chosen, period_of
from tests.labs.loops import Loop


def workbook(**sheets: Sequence[Sequence[object]]) -> bytes:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(list(row))
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


def rows_of(loop: Loop, *names: str) -> list[list[float]]:
    found: list[list[float]] = np.column_stack([loop[name] for name in names]).tolist()
    return found


def sheet_with_a_blank_row(loop: Loop) -> Written:
    rows = [("Time (s)", "R (Ohm)", "Load (N)"), (), *rows_of(loop, TIME, R, FORCE)]
    return Written({"machine.xlsx": workbook(Data=rows)}, chosen(loop, TIME, R, FORCE))


def two_tests_in_a_sheet(loop: Loop) -> Written:
    table = rows_of(loop, TIME, R, FORCE)
    rows = [("Time (s)", "R (Ohm)", "Load (N)"), (), *table, *table]
    return Written({"machine.xlsx": workbook(Data=rows)}, chosen(loop, TIME, R, FORCE), "line")


def several_sheets(loop: Loop) -> Written:
    rows = [("Time (s)", "R (Ohm)", "Load (N)"), *rows_of(loop, TIME, R, FORCE)]
    return Written({"machine.xlsx": workbook(First=rows, Second=rows[:40])}, chosen(loop, TIME, R, FORCE), "line")


def matlab(**variables: object) -> bytes:
    stream = io.BytesIO()
    savemat(stream, variables)
    return stream.getvalue()


def simulink_structure(loop: Loop) -> Written:
    signal = {"values": loop[STROKE][:, None] * 1e3, "dimensions": 1.0, "label": "Measured_Position"}
    resistance = {"values": loop[R][:, None], "dimensions": 1.0, "label": "R_wire"}
    out = {"time": loop[TIME][:, None], "signals": [signal, resistance], "blockName": "bench/Scope"}
    return Written({"scope.mat": matlab(ScopeData=out)}, chosen(loop, TIME, R), "line")


def structs_in_a_struct(loop: Loop) -> Written:
    test = {"t_s": loop[TIME], "V_wire_V": loop[V], "I_mA": 1e3 * loop[AMP], "pos_mm": 1e3 * loop[STROKE]}
    half = {name: values[:100] for name, values in test.items()}
    return Written({"tests.mat": matlab(data={"run1": test, "run2": half})}, chosen(loop, TIME, V, AMP, STROKE), "line")


OHM = ("--shunt", "1 ohm")


def simulink_to_file(loop: Loop) -> Written:
    """The block To File in its format "Array": a signal in each row, the first of them the time."""
    rows = np.vstack([loop[TIME], loop[V], loop[SHUNT]])
    given = ("-c", f"{V}=ans 2:V", "-c", f"{SHUNT}=ans 3:V")
    return Written({"tofile.mat": matlab(ans=rows)}, chosen(loop, TIME, V, SHUNT), given=(*given, *OHM))


def matlab_outputs(loop: Loop) -> Written:
    """Simulink's "tout" and "yout" in the format "Array": a vector, and a matrix of as many rows."""
    outputs = np.column_stack([loop[V], loop[SHUNT]])
    given = ("-c", "time_s=tout:s", "-c", f"{V}=yout 1:V", "-c", f"{SHUNT}=yout 2:V", *OHM)
    return Written(
        {"out.mat": matlab(tout=loop[TIME][:, None], yout=outputs)}, chosen(loop, TIME, V, SHUNT), given=given
    )


def hdf5(**channels: tuple[np.ndarray | list[str], dict[str, object]]) -> bytes:
    """Arrays by their paths, each with its attributes."""
    stream = io.BytesIO()
    with h5py.File(stream, "w") as file:
        for path, (values, attributes) in channels.items():
            file[path.replace("__", "/")] = values
            file[path.replace("__", "/")].attrs.update(attributes)
    return stream.getvalue()


def hdf5_group_per_channel(loop: Loop) -> Written:
    clock, volt, mm = (loop[TIME], {"unit": "s"}), {"unit": "V"}, {"unit": "mm"}
    content = hdf5(
        run__v_wire__data=(loop[V], volt), run__v_wire__time=clock,
        run__v_shunt__data=(loop[SHUNT], volt), run__v_shunt__time=clock,
        run__stroke__data=(1e3 * loop[STROKE], mm), run__stroke__time=clock,
    )  # fmt: skip
    return Written({"daq.h5": content}, chosen(loop, TIME, V, SHUNT, STROKE), given=OHM)


def hdf5_rate_per_channel(loop: Loop) -> Written:
    rate = {"sample_rate": 1.0 / period_of(loop)}
    content = hdf5(
        v_wire=(loop[V], {"unit": "V", **rate}), v_shunt=(loop[SHUNT], {"unit": "V", **rate}),
        stroke=(1e3 * loop[STROKE], {"unit": "mm", **rate}),
    )  # fmt: skip
    return Written({"daq.h5": content}, chosen(loop, V, SHUNT, STROKE), given=OHM)


def matrix_with_names_beside_it(loop: Loop) -> Written:
    """What MATLAB's importdata returns: numbers in one matrix, the headers of its columns in a cell array."""
    names = np.array(["Time (s)", "V wire (V)", "V shunt (V)"], dtype=object)
    data = np.column_stack([loop[TIME], loop[V], loop[SHUNT]])
    return Written({"A.mat": matlab(A={"data": data, "colheaders": names})}, chosen(loop, TIME, V, SHUNT), given=OHM)


def hdf5_times_as_text(loop: Loop) -> Written:
    """Dates as texts in one data set, the numbers in a matrix whose names are another one."""
    stamps = [(BEGAN + timedelta(seconds=second)).strftime("%d.%m.%Y %H:%M:%S.%f") for second in loop[TIME].tolist()]
    names = ["V wire (V)", "V shunt (V)"]
    content = hdf5(time=(stamps, {}), data=(np.column_stack([loop[V], loop[SHUNT]]), {}), columns=(names, {}))
    return Written({"run.h5": content}, {**chosen(loop, V, SHUNT), TIME: loop[TIME] - loop[TIME][0]}, given=OHM)


def netcdf(loop: Loop) -> Written:
    """Variables over a time in "seconds since" a date, as xarray writes them."""
    began = np.datetime64(BEGAN.replace(tzinfo=None), "ns")
    times = began + np.round(1e9 * (loop[TIME] - loop[TIME][0])).astype("timedelta64[ns]")
    variables = {
        "v_wire": ("time", loop[V], {"units": "V"}),
        "v_shunt": ("time", loop[SHUNT], {"units": "V"}),
        "stroke": ("time", 1e3 * loop[STROKE], {"units": "mm"}),
    }
    content = bytes(xr.Dataset(variables, coords={"time": times}).to_netcdf(engine="scipy"))
    expected = {**chosen(loop, V, SHUNT, STROKE), TIME: loop[TIME] - loop[TIME][0]}
    return Written({"run.nc": content}, expected, given=OHM)


def tdms(loop: Loop) -> Written:
    """Waveforms of LabVIEW, each with its increment."""
    clock = {"wf_increment": period_of(loop), "wf_start_offset": 0.0}
    channels = [
        ChannelObject("run", name, values, {"unit_string": unit, **clock})
        for name, values, unit in (
            ("v_wire", loop[V], "V"),
            ("v_shunt", loop[SHUNT], "V"),
            ("stroke", 1e3 * loop[STROKE], "mm"),
        )
    ]
    stream = io.BytesIO()
    with TdmsWriter(stream) as writer:
        writer.write_segment(channels)
    return Written({"run.tdms": stream.getvalue()}, chosen(loop, V, SHUNT, STROKE), given=OHM)


LAYOUTS: tuple[Layout, ...] = (
    sheet_with_a_blank_row, two_tests_in_a_sheet, several_sheets, simulink_structure, structs_in_a_struct,
    simulink_to_file, matlab_outputs, hdf5_group_per_channel, hdf5_rate_per_channel, netcdf, tdms,
    matrix_with_names_beside_it, hdf5_times_as_text,
)  # fmt: skip
