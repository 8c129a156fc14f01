"""Files as people met them: a chip at the end of its range, a meter's overload marks, pulses that are off."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.arrays import FloatArray


@pytest.fixture(scope="module")
def loop() -> Mapping[str, FloatArray]:
    """A slow loop: millis, volts, milliamperes, millimetres."""
    with mw.open_rig("simulated") as rig:
        recording = mw.characterize(rig)
    return {
        "millis": 1e3 * recording["time_s"],
        "bus_V": recording["wire_voltage_v"],
        "current_mA": 1e3 * recording["shunt_voltage_v"],
        "position_mm": 1e3 * recording["displacement_m"],
    }


def written(path: Path, columns: Mapping[str, FloatArray]) -> Path:
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, fmt="%.6g", delimiter=",", header=",".join(columns), comments="")
    return path


OPTIONS = ("-c", "wire_voltage_v=bus_V:V", "--leg-length", "70 mm")


def test_a_chip_at_the_end_of_its_range_is_said_by_import_and_estimate_and_not_used(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine
) -> None:
    true = written(tmp_path / "true.csv", loop)
    cut = {**loop, "current_mA": np.round(np.minimum(loop["current_mA"], 120.0), 1)}
    file, model, output = written(tmp_path / "ina219.csv", cut), tmp_path / "m.json", tmp_path / "e.h5"
    at_end = cut["current_mA"] == 120.0
    said = f"{int(at_end.sum())} of 3600 rows are no measurements: wire_current_a stays at 0.12 A"
    assert musclewire("fit", true, *OPTIONS, "-o", model).code == 0
    preview = musclewire("import", file, "-c", "wire_voltage_v=bus_V:V", "-o", tmp_path / "r.h5")
    assert said in preview.out
    assert said in str(mw.read_recording(tmp_path / "r.h5").metadata["unusable_readings"])
    estimated = musclewire("estimate", model, file, *OPTIONS, "-o", output)
    assert said in estimated.err
    assert not mw.read_recording(output)["valid"][at_end].any()


def test_overload_marks_are_left_out_counted_and_the_rest_is_fitted(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine
) -> None:
    ohm = 1e3 * loop["bus_V"] / loop["current_mA"]
    ohm[[100, 200, 300]] = 9.9e37
    columns = {"Time (ms)": loop["millis"], "R wire (Ohm)": ohm, "LVDT (mm)": loop["position_mm"]}
    file = written(tmp_path / "meter.csv", columns)
    preview = musclewire("import", file, "-o", tmp_path / "meter.h5")
    assert "3597 rows" in preview.out
    assert "left out: 3 rows with an overload mark in wire_resistance_ohm" in preview.out
    assert "3 rows" in str(mw.read_recording(tmp_path / "meter.h5").metadata["rows_left_out"])
    fitted = musclewire("fit", file, "--leg-length", "70 mm", "--json")
    assert fitted.json["resistance_max_ohm"] < 30.0
    assert any("left out: 3 rows" in text for text in fitted.json["warnings"])


def test_pulses_that_are_off_are_named_and_the_pulses_are_fitted(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine
) -> None:
    off = np.arange(3600) % 5 > 1
    columns = {
        **loop,
        "bus_V": np.where(off, 0.001, loop["bus_V"]),
        "current_mA": np.where(off, -0.8, loop["current_mA"]),
    }
    fitted = musclewire("fit", written(tmp_path / "raw.csv", columns), *OPTIONS, "--json")
    assert fitted.code == 0, fitted.err
    assert any("2160 of 3600 rows are no measurements: the drive is off" in text for text in fitted.json["warnings"])
    assert 15.0 < fitted.json["resistance_min_ohm"] < fitted.json["resistance_max_ohm"] < 18.0


@pytest.mark.parametrize(("current", "refused"), [("I_avg [mA]", True), ("I_rms [mA]", False)])
def test_an_rms_voltage_over_a_mean_current_is_no_resistance(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine, current: str, refused: bool
) -> None:
    columns = {"time [ms]": loop["millis"], "V_rms [V]": loop["bus_V"], current: loop["current_mA"]}
    file = written(tmp_path / "pulses.csv", columns)
    given = ("-c", "wire_voltage_v=V_rms [V]", "-c", f"wire_current_a={current}")
    answer = musclewire("import", file, *given)
    assert answer.code == (2 if refused else 0)
    assert ("root of the duty cycle" in answer.err) == refused


@pytest.mark.parametrize("turned", ["current_mA", "bus_V"])
def test_a_voltage_or_current_that_is_negative_throughout_is_turned_and_said_to_be(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine, turned: str
) -> None:
    file = written(tmp_path / "leads.csv", {**loop, turned: -loop[turned]})
    said = (
        f"{'wire_current_a' if turned == 'current_mA' else 'wire_voltage_v'} is negative throughout: its sign is turned"
    )
    assert said in musclewire("import", file, "-c", "wire_voltage_v=bus_V:V", "-o", tmp_path / "r.h5").out
    recording = mw.read_recording(tmp_path / "r.h5")
    assert recording["wire_current_a"].min() > 0.0
    assert recording["wire_voltage_v"].min() > 0.0
    fitted = musclewire("fit", file, *OPTIONS, "--json")
    assert any(said in text for text in fitted.json["warnings"])


def test_a_current_of_both_signs_is_not_turned(
    loop: Mapping[str, FloatArray], tmp_path: Path, musclewire: CommandLine
) -> None:
    sign = np.where(np.arange(3600) % 2, 1.0, -1.0)
    file = written(
        tmp_path / "ac.csv", {**loop, "bus_V": sign * loop["bus_V"], "current_mA": sign * loop["current_mA"]}
    )
    assert "is turned" not in musclewire("import", file, "-c", "wire_voltage_v=bus_V:V").out
