"""``musclewire simulate`` and ``musclewire catalogue``: what a maker types, and what comes back."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine

from musclewire.files import read_recording
from musclewire.parameters import names


def test_a_wire_of_the_catalogue_needs_nothing_else(musclewire: CommandLine) -> None:
    answer = musclewire("simulate", "--wire", "flexinol-0.20-lt", "--json")
    assert answer.code == 0
    said = answer.json
    assert said["current_a"] == 0.66
    assert said["catalogue"]["one_second_current_a"]["status"] == "corroborated"
    assert said["catalogue"]["cooling_s"]["value"] == 3.2
    assert 0.0 < said["contraction_share_pct"] <= 100.1
    assert said["current_mean_a"] == pytest.approx(0.66, rel=0.005)
    assert said["suggested"]["shunt_rating_w"] > 3 * said["suggested"]["shunt_power_w"]


def test_quantities_may_be_written_as_people_write_them(musclewire: CommandLine) -> None:
    said = musclewire(
        "simulate", "--wire", "flexinol-0.15-ht", "--supply", "3300 mV", "--wire-length", "12 cm", "--load", "100 gf",
        "--spring", "0.2 N/mm", "--ambient", "300 K", "--shunt", "220 mohm", "--off-after", "0.5 s", "--json",
    ).json  # fmt: skip
    assert said["supply_v"] == pytest.approx(3.3)
    assert said["length_m"] == pytest.approx(0.12)
    assert said["load_n"] == pytest.approx(0.980665)
    assert said["spring_stiffness_n_per_m"] == pytest.approx(200.0)
    assert said["shunt_resistance_ohm"] == pytest.approx(0.22)
    assert said["ambient_temperature_degc"] == pytest.approx(26.85)
    assert said["drive_voltage_peak_v"] == pytest.approx(3.3, abs=1e-3)


def test_the_recording_and_the_figure_are_written(musclewire: CommandLine, tmp_path: Path) -> None:
    answer = musclewire("simulate", "-o", tmp_path / "drive.h5", "--plot", tmp_path / "drive.png")
    assert answer.code == 0, answer.err
    run = read_recording(tmp_path / "drive.h5")
    assert run.metadata["wire"] == "flexinol-0.10-lt"
    assert run.metadata["ended"] == "done"
    assert "wire_temperature_k" in run
    assert (tmp_path / "drive.png").read_bytes().startswith(b"\x89PNG")
    again = musclewire("simulate", "-o", tmp_path / "drive.h5")
    assert (again.code, "--overwrite" in again.err) == (2, True)


def test_a_wire_that_gets_too_hot_is_warned_about(musclewire: CommandLine) -> None:
    answer = musclewire("simulate", "--wire", "flexinol-0.10-lt", "--current", "450 mA", "--off-after", "3 s")
    assert answer.code == 0
    assert "warning: overheated" in answer.err
    assert "left on, it would settle" in musclewire("simulate", "--wire", "flexinol-0.31-lt").err
    small = musclewire("simulate", "--current", "200 mA", "--supply", "2 V", "--json")
    assert any("does not reach" in warning for warning in small.json["warnings"])


def test_a_duty_without_its_unit_is_asked_about(musclewire: CommandLine) -> None:
    assert musclewire("simulate", "--duty", "33").refusal.endswith("33 is outside 0 to 1: for 33 % write '33 %'")


def test_a_molten_wire_is_no_result(musclewire: CommandLine) -> None:
    assert musclewire("simulate", "--supply", "100 V").code == 2
    answer = musclewire("simulate", "--supply", "100 V", "--json", "--beyond-catalogue")
    assert answer.code == 1
    assert "melted" in answer.json["warnings"][0]
    assert answer.json["true_peak_temperature_degc"] is None
    assert answer.json["suggested"]["supply_v"] == pytest.approx(3.73, abs=0.01)
    shown = musclewire("simulate", "--supply", "100 V", "--beyond-catalogue").out
    assert "through 1 ohm for 1 s: melted" in shown
    assert "contraction" not in shown


def test_the_list_has_every_wire(musclewire: CommandLine) -> None:
    text = musclewire("simulate", "--list").out
    wires, alloys = text.strip().split("\n\n")
    assert [line.split()[0] for line in wires.splitlines()] == names("wire")
    assert "alloy flexinol: data cover 45 to 220 MPa and temperatures to 140 C" in alloys
    assert [row["name"] for row in musclewire("simulate", "--list", "--json").json["wires"]] == names("wire")


def test_the_catalogue_fails_where_a_judged_cell_fails(musclewire: CommandLine) -> None:
    answer = musclewire("catalogue", "--json")
    said = answer.json
    failing = [row for row in said["rows"] if False in (row["contraction_ok"], row["cooling_ok"])]
    assert answer.code == (1 if failing else 0)
    assert said["ok"] is not bool(failing)
    assert (len(said["rows"]), said["judged"]) == (24, 8)
    assert all(row["contraction_ok"] is None and row["cooling_ok"] is None for row in said["rows"][1::2])


def test_the_table_answers_for_every_wire_at_a_length(musclewire: CommandLine) -> None:
    said = musclewire("simulate", "--table", "--wire-length", "200 mm", "--json").json
    assert [row["wire"] for row in said["rows"]] == [name for name in names("wire") if name.startswith("flexinol-")]
    for row in said["rows"]:
        assert 0.0 < row["holding_current_a"] <= 1.001 * row["one_second_current_a"]
        assert row["holding_current_a"] < row["lasting_current_a"]
        assert row["shunt_rating_w"] >= 3.0 * row["shunt_power_w"]
        assert row["power_w"] < row["supply_v"] * row["one_second_current_a"]
        assert 0.5 < row["one_second_current_a"] / row["catalogue_current_a"] < 1.5


def test_a_row_of_the_table_equals_the_answer_for_this_wire_alone_and_lasts(musclewire: CommandLine) -> None:
    rows = {row["wire"]: row for row in musclewire("simulate", "--table", "--json").json["rows"]}
    row = rows["flexinol-0.15-lt"]
    alone = musclewire("simulate", "--wire", "flexinol-0.15-lt", "--json").json["suggested"]
    # The shunt in series with the wire while it is sized makes no difference to a held current.
    assert row["one_second_current_a"] == pytest.approx(alone["one_second_current_a"], rel=1e-3)
    assert row["supply_v"] == pytest.approx(alone["supply_v"], rel=1e-2)
    assert row["shunt_resistance_ohm"] == alone["shunt_resistance_ohm"]
    lasting = f"{rows['flexinol-0.20-ht']['lasting_current_a']} A"
    said = musclewire(
        "simulate", "--wire", "flexinol-0.20-ht", "--current", lasting, "--off-after", "30 s", "--json"
    ).json
    # The current is that of a wire which is kept from contracting; a free one, whose resistance is lower, stays cooler.
    assert 144.0 < said["settled_temperature_degc"] <= 150.0


def test_a_duty_heats_in_pulses_and_shows_largest_and_final_contraction(musclewire: CommandLine) -> None:
    drive = ("--current", "200 mA", "--off-after", "6 s", "--seed", "2", "--json")
    steady = musclewire("simulate", *drive).json
    pulsed = musclewire("simulate", *drive, "--duty", "50 %", "--duty-period", "0.5 s").json
    assert (steady["duty"], pulsed["duty"], pulsed["duty_period_s"]) == (1.0, 0.5, 0.5)
    assert pulsed["energy_j"] == pytest.approx(0.5 * steady["energy_j"], rel=0.15)  # a cooler wire has more resistance
    assert pulsed["current_mean_a"] == pytest.approx(0.5 * 0.2, rel=0.03)
    assert pulsed["largest_contraction_pct"] >= pulsed["contraction_pct"] > pulsed["final_contraction_pct"]
    assert steady["last_period_pct"] is None
    lowest, highest = pulsed["last_period_pct"]
    assert 0.0 < lowest < highest <= pulsed["largest_contraction_pct"]
    assert "on for 50 % of every 1 s" in musclewire("simulate", "--duty", "0.5").out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("simulate --wire flexinol-0.1-lt", "'flexinol-0.10-lt'"),
        ("simulate --load 1N --stress 172MPa", "not both"),
        ("simulate --wire paper-100um", "--supply or --current"),
        ("simulate --off-after 3s --duration 1s", "ends before"),
        ("simulate --load 100N", "4.75"),
        ("simulate --duty 50% --duty-period 20ms", "[pwm]"),
    ],
)
def test_wrong_usage_is_one_line(arguments: str, words: str, musclewire: CommandLine) -> None:
    assert words in musclewire(*arguments.split()).refusal
