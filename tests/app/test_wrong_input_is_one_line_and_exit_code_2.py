"""Item 6 of the main job: what cannot be used is refused in one line that says what and where; nothing is written."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.command_line import CommandLine

HEADER = "time [s],V_SMA [V],I [A],displacement [mm]"


def loop_rows(points: int = 400, *, transforms: bool = True, current: float = 0.15) -> list[list[float]]:
    """A wire measured with V and I: resistance rises, falls with the contraction, and comes back."""
    phase = np.linspace(0.0, 2.0 * np.pi, points)
    heat = 0.5 * (1.0 - np.cos(phase))
    moved = 1.0 / (1.0 + np.exp(-12.0 * (heat - 0.55))) if transforms else 0.0 * heat
    resistance = 17.0 + 0.5 * heat - 3.0 * moved
    current_a = current * (0.2 + heat)  # by its power an estimator knows heating from cooling
    columns = (90.0 * phase / (2.0 * np.pi), current_a * resistance, current_a, 2.4 * moved)
    return np.column_stack(columns).tolist()


def write_csv(path: Path, rows: list[list[float]], header: str = HEADER) -> Path:
    text = [header, *(",".join(repr(value) for value in row) for row in rows)]
    path.write_text("\n".join(text) + "\n")
    return path


def test_a_wire_measured_with_voltage_and_current_is_fitted(musclewire: CommandLine, tmp_path: Path) -> None:
    path = write_csv(tmp_path / "bench.csv", loop_rows())
    answer = musclewire("fit", path, "--leg-length", "70 mm", "-o", tmp_path / "m.json", "--json")
    assert answer.code == 0, answer.err
    assert answer.json["resistance_max_ohm"] > answer.json["resistance_min_ohm"] > 10.0
    estimated = musclewire("estimate", tmp_path / "m.json", path, "--leg-length", "70 mm", "--json")
    assert estimated.code == 0, estimated.err
    assert estimated.json["rms_pct"] < 5.0
    for name in ("rms_pct", "max_pct", "valid_share"):
        assert answer.json[name] == estimated.json[name], "fit and estimate say the same of the same file"


def test_a_fit_replaces_no_model_unless_it_is_told_to(musclewire: CommandLine, tmp_path: Path) -> None:
    path, model = write_csv(tmp_path / "bench.csv", loop_rows()), tmp_path / "model.json"
    again = ("fit", path, "--leg-length", "70 mm", "-o", model)
    assert musclewire(*again).code == 0
    first = model.read_bytes()
    assert "model.json exists: give another name or --overwrite" in musclewire(*again, "--order", 5).refusal
    assert model.read_bytes() == first
    assert musclewire(*again, "--order", 5, "--overwrite").code == 0
    assert model.read_bytes() != first


def without(column: int, rows: list[list[float]]) -> list[list[float]]:
    return [[value for place, value in enumerate(row) if place != column] for row in rows]


def changed(row: int, column: int, value: float, rows: list[list[float]]) -> list[list[float]]:
    rows[row][column] = value
    return rows


CASES = {
    "a missing column": (without(3, loop_rows()), "time [s],V_SMA [V],I [A]", ("displacement_m",)),
    "a clock that runs back": (changed(41, 0, 1.0, loop_rows()), HEADER, ("line 43", "clock")),
    "no current": (loop_rows(current=1e-6), HEADER, ("no current",)),
}


@pytest.mark.parametrize("name", CASES)
def test_a_recording_that_cannot_be_used(name: str, musclewire: CommandLine, tmp_path: Path) -> None:
    rows, header, words = CASES[name]
    path = write_csv(tmp_path / "bench.csv", rows, header)
    line = musclewire("fit", path, "--leg-length", "70 mm", "-o", tmp_path / "model.json", "--json").refusal
    assert line.startswith("musclewire: ")
    for word in words:
        assert word in line
    assert sorted(file.name for file in tmp_path.iterdir()) == ["bench.csv"]


def test_displacement_without_a_length_says_how_to_give_one(musclewire: CommandLine, tmp_path: Path) -> None:
    assert "--leg-length" in musclewire("fit", write_csv(tmp_path / "bench.csv", loop_rows())).refusal


def test_a_sensor_that_reads_absolute_and_backwards_is_turned_and_zeroed(
    musclewire: CommandLine, tmp_path: Path
) -> None:
    rows = [[time, volts, amps, 123.4 - moved] for time, volts, amps, moved in loop_rows()]
    path = write_csv(tmp_path / "laser.csv", rows)
    plain = musclewire("fit", write_csv(tmp_path / "bench.csv", loop_rows()), "--leg-length", "70 mm", "--json").json
    refused = musclewire("fit", path, "--leg-length", "70 mm")
    assert refused.code == 2
    turned = musclewire("fit", path, "--leg-length", "70 mm", "--invert", "--zero", "--json")
    assert turned.code == 0, turned.err
    assert turned.json["strain_gap_pct"] == pytest.approx(plain["strain_gap_pct"], abs=1e-6)


def test_a_header_of_another_program_is_taken_by_an_explicit_mapping(musclewire: CommandLine, tmp_path: Path) -> None:
    path = write_csv(tmp_path / "bench.csv", loop_rows(), "Zeitpunkt,Kanal 1,Kanal 2,Weg2")
    mapped = [
        *("-c", "time_s=Zeitpunkt:s", "-c", "wire_voltage_v=Kanal 1:V"),
        *("-c", "wire_current_a=Kanal 2:A", "-c", "displacement_m=Weg2:mm"),
    ]
    answer = musclewire("fit", path, *mapped, "--leg-length", "70 mm", "--json")
    assert answer.code == 0, answer.err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("fit", "RECORDING"),
        ("fti x", "Did you mean 'fit'"),
        ("fit x.h5 --ordr 6", "--order"),
        ("--json rules", "musclewire COMMAND ... --json"),
        ("fit nowhere.csv", "nowhere.csv"),
        ("fit lan-fan-2010-table-2", "order 6"),
        ("fit lan-fan-2010-table-2 --order 3 -o m.json --plot x.gif", ".svg"),
        ("import one.csv two.csv --plot both.svg", "--plot draws one recording"),
        ("characterize simulatd -o x.h5", "simulated"),
        ("characterize simulated -o nowhere/x.h5", "nowhere"),
        ("characterize simulated -o x.h5 --amplitude 9V", "maximum"),
        ("characterize simulated -o x.h5 --amplitude 3", "--amplitude: '3' has no unit; write it with one, as "),
        ("characterize simulated -o x.h5 --cpu 99999999999", "--cpu: give at most"),
        ("characterize simulated -o x.h5 --real-time-priority", "add --real-time"),
        ("doctor simulated --write", "rig file of your own"),
    ],
)
def test_wrong_usage_is_one_line_too(
    arguments: str, words: str, musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of each kind of mistake one: a word, a file, a folder, a unit, a range, options that do not go together."""
    monkeypatch.chdir(tmp_path)
    assert words in musclewire(*arguments.split()).refusal
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("--on-board --home start", "leave out --home"),
        ("--load=1.9N", "--load belongs to a home move"),
        ("--runs 2 -o run.h5", "--output belongs to a single run"),
        ("--runs 2 --zero-from to-day", "did you mean 'today'"),
        ("--on-board --quantity force --known-stiffness=600N/m", "leave out --known-stiffness"),
        ("--on-board --zero-from today", "only a board with musclewire's firmware"),
        ("--zero-from to-day", "did you mean 'today'"),
        ("--known-strain=12mm", "--known-strain: "),
        ("--known-strain=12%", "this model senses"),
        ("--known-strain=1.5%@", "--known-strain: "),
        ("--runs 2 --known-strain=12%", "this model senses"),
        ("--refrence x", "(Possible options: --reference)"),
        ("--quantity force", "--known-stiffness"),
    ],
)
def test_what_control_cannot_do_is_one_line_too(
    arguments: str, words: str, musclewire: CommandLine, model: Path
) -> None:
    assert words in musclewire("control", "simulated", model, *arguments.split()).refusal


def test_an_existing_recording_is_not_replaced_without_overwrite(musclewire: CommandLine, tmp_path: Path) -> None:
    path = tmp_path / "loop.h5"
    path.write_bytes(b"precious")
    command = ("characterize", "simulated", "-o", path, "--period", "30 s", "--cycles", "1", "--json")
    assert musclewire(*command).code == 2
    assert path.read_bytes() == b"precious"
    assert musclewire(*command, "--overwrite").code == 0


def test_a_recording_where_a_model_belongs_is_called_one(musclewire: CommandLine, tmp_path: Path) -> None:
    recording, model = tmp_path / "loop.csv", tmp_path / "model.json"
    recording.write_text("time [s],wire_voltage_v,shunt_voltage_v\n0,1,1\n1,1,1\n", "utf-8")
    model.write_text("{}")
    for command in (("estimate",), ("tune",), ("control", "simulated")):
        refused = musclewire(*command, recording, *([recording] if len(command) == 1 else [])).refusal
        assert f"{recording} is a recording, where a model file (.json) belongs" in refused
    assert "a .json file is a model, and no recording" in musclewire("fit", model).refusal
