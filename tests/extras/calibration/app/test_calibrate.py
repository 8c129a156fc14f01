"""The command that finds a wire: from a loop to a wire that does the same loop; an interrupted search; wrong input."""

from __future__ import annotations

import json
import signal
import time
from pathlib import Path

import numpy as np
import pytest
from tests.app.interrupting import PATIENCE_S, start
from tests.command_line import CommandLine

import musclewire as mw
from musclewire.app import ReadingOptions
from musclewire.extras.calibration import read_one
from musclewire.identify import simulated_isobar
from musclewire.parameters import load_alloy, load_bench, load_wire, read_wire_file


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short loop of a simulated wire, with its noise."""
    path = tmp_path_factory.mktemp("loop") / "loop.h5"
    with mw.open_rig("simulated", seed=5) as rig:
        mw.characterize(rig, cycles=1, period_s=12.0, path=path)
    return path


@pytest.fixture(scope="module")
def isobars(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Isobars of a simulated wire as a test machine writes them: no header, no clock."""
    wire = load_wire("paper-100um")
    random = np.random.default_rng(8)
    rows = []
    for stress_pa in (60e6, 120e6, 200e6):
        one = simulated_isobar(load_alloy(wire.alloy), wire, load_bench("paper"), stress_pa, points=120)
        strain = one.strain + 1e-5 * random.standard_normal(one.strain.size)
        stress = np.full(strain.size, stress_pa / 1e6)
        rows.append(np.column_stack([one.temperature_k - 273.15, 100.0 * strain, stress]))
    path = tmp_path_factory.mktemp("isobars") / "machine.txt"
    np.savetxt(path, np.concatenate(rows), delimiter="\t")
    return path


BY_NUMBER = ("-c", "wire_temperature_k=#1:degC", "-c", "reference_strain=#2:%", "-c", "stress_pa=#3:MPa")


@pytest.mark.slow
def test_from_a_loop_to_a_wire_file_that_does_the_same_loop(
    loop: Path, musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    figure = ("--plot", tmp_path / "mine.svg", "--plot-style", "nature")
    answer = musclewire("calibrate", loop, "-o", tmp_path / "mine.toml", "--effort", "quick", "--json", *figure)
    assert answer.code == 0, answer.err
    found = answer.json
    assert found["holds"]
    assert found["rmse"] < 1.0
    assert found["wire"] == str(tmp_path / "mine.toml")
    one = found["parameters"]["martensite_temperature_k"]
    assert {"value", "unit", "std", "prior_std"} <= set(one)
    assert one["std"] < one["prior_std"]
    assert sorted(item.name for item in tmp_path.iterdir()) == ["mine.html", "mine.svg", "mine.toml"]

    wire = read_wire_file(tmp_path / "mine.toml")
    for name, item in found["parameters"].items():
        written = {**dict(wire.alloy.items()), **dict(wire.wire.items()), **wire.bench}[name]
        assert written.value == item["value"]
        assert written.kind == ("fitted" if item["identifiable"] else "assumed")
        assert "95 % interval" in written.note

    monkeypatch.chdir(tmp_path)
    measured = mw.read_recording(loop)
    with mw.open_rig("simulated", wire="mine.toml", seed=5) as rig:
        again = mw.characterize(rig, cycles=1, period_s=12.0)
    strain = [item["displacement_m"] / item.metadata["leg_length_m"] for item in (measured, again)]
    assert np.sqrt(np.mean((strain[0] - strain[1]) ** 2)) < 5e-4


def test_what_exists_is_not_replaced(loop: Path, musclewire: CommandLine, tmp_path: Path) -> None:
    (tmp_path / "mine.html").write_text("mine")
    assert "mine.html exists" in musclewire("calibrate", loop, "-o", tmp_path / "mine.toml").refusal
    assert [item.name for item in tmp_path.iterdir()] == ["mine.html"]


CASES = {
    "the wrong sign": (lambda strain: -strain, (), "--invert"),
    "an unknown number": (lambda strain: strain, ("--set", "pretention_n=1 N"), "did you mean 'pretension_n'"),
    "no folder": (lambda strain: strain, ("--report", "none/page.html"), "there is no folder"),
}


@pytest.mark.parametrize("name", CASES)
def test_wrong_input_is_one_line_and_exit_code_2_and_nothing_is_written(
    name: str, loop: Path, musclewire: CommandLine, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    change, options, words = CASES[name]
    measured = mw.read_recording(loop)
    monkeypatch.chdir(tmp_path)
    measured.with_columns(displacement_m=0.07 * change(measured["displacement_m"] / 0.07)).save("mine.csv")
    assert words in musclewire("calibrate", "mine.csv", *options, "-o", "mine.toml", "--json").refusal
    assert [item.name for item in tmp_path.iterdir()] == ["mine.csv"]


def test_zero_and_invert_make_a_wrong_way_round_sensor_right(loop: Path, tmp_path: Path) -> None:
    measured = mw.read_recording(loop)
    first = measured["displacement_m"][0]
    measured.with_columns(displacement_m=2e-3 - measured["displacement_m"]).save(tmp_path / "mine.csv")
    turned = read_one(str(tmp_path / "mine.csv"), ReadingOptions(zero=True, invert=True))
    assert turned["displacement_m"] == pytest.approx(measured["displacement_m"] - first, abs=1e-12)
    assert np.array_equal(turned["force_n"], measured["force_n"])


@pytest.mark.slow
def test_a_strain_that_no_wire_does_ends_with_exit_code_1_and_files(
    isobars: Path, musclewire: CommandLine, tmp_path: Path
) -> None:
    """Isobars shifted by 200 K belong to no NiTi wire that the priors know."""
    rows = np.loadtxt(isobars)
    rows[:, 0] += 200.0
    np.savetxt(tmp_path / "hot.txt", rows, delimiter="\t")
    answer = musclewire(
        "calibrate", tmp_path / "hot.txt", *BY_NUMBER, "--effort", "quick", "-o", tmp_path / "w.toml", "--json"
    )
    assert answer.code == 1
    assert answer.json["holds"] is False
    assert answer.json["rmse"] > 3.0
    assert sorted(item.name for item in tmp_path.iterdir()) == ["hot.txt", "w.html", "w.toml"]


@pytest.mark.slow
def test_a_mapping_by_number_is_for_the_files_without_headers(
    isobars: Path, musclewire: CommandLine, tmp_path: Path
) -> None:
    rows = np.loadtxt(isobars)
    with_headers = tmp_path / "named.csv"
    lines = ["cycle,Temperature [degC],Strain [%],Stress [MPa]", *(f"1,{a},{b},{c + 20.0}" for a, b, c in rows)]
    with_headers.write_text("\n".join(lines) + "\n")
    answer = musclewire("calibrate", with_headers, isobars, *BY_NUMBER, "--effort", "quick", "--json")
    assert answer.code in (0, 1), answer.err
    stresses = {item["channel"] for item in answer.json["channels"]}
    assert stresses == {f"strain at {stress} MPa" for stress in (60, 80, 120, 140, 200, 220)}


def descents_in(journal: Path) -> int:
    return max(len(journal.read_text().splitlines()) - 1, 0) if journal.exists() else 0


@pytest.mark.slow
def test_an_interrupted_search_goes_on_and_ends_with_the_same_wire_to_the_bit(isobars: Path, tmp_path: Path) -> None:
    asked = (isobars, *BY_NUMBER, "--starts", "4", "--jumps", "6", "--seed", "4", "--json")
    journal = tmp_path / "stopped.toml.search"
    process = start("calibrate", *asked, "-o", tmp_path / "stopped.toml")
    deadline = time.monotonic() + PATIENCE_S
    while descents_in(journal) < 1:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < deadline, "no descent came to its end"
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130, err
    assert out == ""
    assert err.strip().splitlines() == [
        f"musclewire: stopped by Ctrl-C; the same command continues where it stopped ({journal})"
    ]
    assert sorted(item.name for item in tmp_path.iterdir()) == ["stopped.toml.search"]
    left = descents_in(journal)
    assert 1 <= left < 10

    answers = []
    for name in ("stopped.toml", "straight.toml"):
        again = start("calibrate", *asked, "-o", tmp_path / name)
        answers.append(json.loads(again.communicate(timeout=PATIENCE_S)[0]))
    assert not journal.exists()
    resumed, straight = answers
    for key in ("parameters", "rmse", "channels", "descent_costs", "simulations", "correlated", "advice"):
        assert resumed[key] == straight[key], key
    texts = [(tmp_path / name).read_text().split("\n", 3)[3] for name in ("stopped.toml", "straight.toml")]
    assert texts[0] == texts[1]
