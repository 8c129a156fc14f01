"""Workbooks and MATLAB files as laboratories make them; see ``tests/labs/layouts.py``."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
import openpyxl
from scipy.io import savemat
from tests.labs.layouts import AMP, FORCE, STROKE, TIME, Layout, R, V, Written, chosen
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
    return Written({"scope.mat": matlab(ScopeData=out)}, chosen(loop, TIME, R, STROKE), "line")


def structs_in_a_struct(loop: Loop) -> Written:
    test = {"t_s": loop[TIME], "V_wire_V": loop[V], "I_mA": 1e3 * loop[AMP], "pos_mm": 1e3 * loop[STROKE]}
    half = {name: values[:100] for name, values in test.items()}
    return Written({"tests.mat": matlab(data={"run1": test, "run2": half})}, chosen(loop, TIME, V, AMP, STROKE), "line")


LAYOUTS: tuple[Layout, ...] = (
    sheet_with_a_blank_row, two_tests_in_a_sheet, several_sheets, simulink_structure, structs_in_a_struct,
)  # fmt: skip
