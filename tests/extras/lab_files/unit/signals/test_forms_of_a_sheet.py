"""One run, saved by openpyxl in the forms that people give a sheet, reads alike."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime, timedelta
from pathlib import Path

import openpyxl
import pytest
from tests.extras.lab_files.corpus.lab_signals import DISPLACEMENT_MM, SHUNT_VOLTAGE_V, TIME_S, WIRE_VOLTAGE_V

from musclewire.errors import RecordingError
from musclewire.files import read_recording

BEGAN = datetime(2026, 2, 17, 12, 21)
HEADERS = ["U wire (V)", "U shunt (V)", "Stroke (mm)"]
MEASURED = list(zip(WIRE_VOLTAGE_V.tolist(), SHUNT_VOLTAGE_V.tolist(), DISPLACEMENT_MM.tolist(), strict=True))
SECONDS = TIME_S.tolist()
STAMPS = [BEGAN + timedelta(seconds=second) for second in SECONDS]
NUMBERS = [["Time (s)", *HEADERS], *([second, *row] for second, row in zip(SECONDS, MEASURED, strict=True))]
Rows = Sequence[Sequence[object]]


def timed(clock: Sequence[object], header: str = "Time") -> Rows:
    return [[header, *HEADERS], *([time, *row] for time, row in zip(clock, MEASURED, strict=True))]


def german(value: float) -> str:
    return f"{value:,.6f}".translate(str.maketrans(",.", ".,"))


FORMS: dict[str, Rows] = {
    "numbers": NUMBERS,
    "dates": timed(STAMPS),
    "times of day": timed([stamp.time() for stamp in STAMPS]),
    "durations": timed([timedelta(seconds=second) for second in SECONDS]),
    "dates as text": timed([stamp.strftime("%d.%m.%Y %H:%M:%S.%f") for stamp in STAMPS]),
    "days since 1900": timed([46_070.5 + second / 86_400.0 for second in SECONDS]),
    "dates and times apart": [
        ["Date", "Time", *HEADERS],
        *([stamp.date(), stamp.time(), *row] for stamp, row in zip(STAMPS, MEASURED, strict=True)),
    ],
    "German texts": [
        ["Zeit [ms]", "U wire [V]", "U shunt [V]", "Weg [mm]"],
        *([german(1e3 * s), *map(german, row)] for s, row in zip(SECONDS, MEASURED, strict=True)),
    ],
    "texts among numbers": timed([german(second) for second in SECONDS], "Time (s)"),
    "units in a row": [["Time", "U wire", "U shunt", "Stroke"], ["s", "V", "V", "mm"], *NUMBERS[1:]],
    "a title, and nothing in column A": [[None, "Run 3"], [], *([None, *row] for row in NUMBERS)],
    "means at the side": [[*NUMBERS[0], None, "mean"], [*NUMBERS[1], None, 1.5], *NUMBERS[2:]],
}


def saved(path: Path, sheets: Mapping[str, Rows], hidden: str = "") -> Path:
    book = openpyxl.Workbook()
    book.remove(book.active)
    for title, rows in sheets.items():
        sheet = book.create_sheet(title)
        sheet.sheet_state = "hidden" if title == hidden else "visible"
        for row in rows:
            sheet.append(list(row))
    book.save(path)
    return path


def assert_is_the_run(path: Path, group: str | None = None) -> None:
    recording = read_recording(path, group=group)
    assert recording["time_s"] == pytest.approx(TIME_S, abs=2e-6)
    assert recording["wire_voltage_v"] == pytest.approx(WIRE_VOLTAGE_V, abs=1e-6)
    assert recording["shunt_voltage_v"] == pytest.approx(SHUNT_VOLTAGE_V, abs=1e-6)
    assert recording["displacement_m"] == pytest.approx(1e-3 * DISPLACEMENT_MM, abs=1e-9)


@pytest.mark.parametrize("form", FORMS)
def test_a_run_reads_alike_in_every_form(form: str, tmp_path: Path) -> None:
    assert_is_the_run(saved(tmp_path / "a.xlsx", {"Data": FORMS[form]}))


def test_a_sheet_of_notes_and_a_hidden_one_are_not_meant_and_two_tables_are_asked_for(tmp_path: Path) -> None:
    assert_is_the_run(saved(tmp_path / "a.xlsx", {"Notes": [["what", "who"], ["first", "me"]], "Data": NUMBERS}))
    sheets = {"Old": NUMBERS[:40], "Data": NUMBERS}
    assert_is_the_run(saved(tmp_path / "b.xlsx", sheets, hidden="Old"))
    assert len(read_recording(tmp_path / "b.xlsx", group="Old")) == 39
    with pytest.raises(RecordingError, match="holds 2 sheets with tables: choose one"):
        read_recording(saved(tmp_path / "c.xlsx", sheets))
    assert_is_the_run(tmp_path / "c.xlsx", group="data")
