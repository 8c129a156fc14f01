"""The home move from the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.command_line import CommandLine

from musclewire.sensing import load_model

STEPS = ("--reference", "1.5 % to 2 % by 0.5 %")


def test_it_says_what_it_assumes_and_finds_and_writes_the_model(
    musclewire: CommandLine, model: Path, tmp_path: Path
) -> None:
    new, sweep = tmp_path / "new.json", tmp_path / "sweep.h5"
    answer = musclewire("home", "simulated", model, "-o", new, "--ambient", "22 degC", "--sweep", sweep)
    assert answer.code == 0
    assert answer.out.startswith("assumed: a load of 1.9 N; air of 22.0 degC\n")
    assert "C was not seen" in answer.out
    assert sweep.exists()
    home = load_model(new).home
    assert home is not None
    assert home.ambient_k == pytest.approx(295.15)
    again = musclewire("home", "simulated", model, "-o", new)
    assert (again.code, "exists" in again.err) == (2, True)


def test_an_aged_wire_is_corrected_and_a_changed_load_refused(
    musclewire: CommandLine, model: Path, tmp_path: Path
) -> None:
    rig = tmp_path / "aged.toml"
    rig.write_text("[settings]\nresistivity_factor = 1.01\n", "utf-8")
    answer = musclewire("home", rig, model, "-o", tmp_path / "new.json", "--cycles-made", 300, "--json")
    assert answer.code == 0
    assert answer.json["corrected"]
    assert answer.json["resistance_max_moved_ohm"] == pytest.approx(0.175, abs=0.015)
    assert answer.json["cycles"] == 300.0
    refused = musclewire("home", "simulated", model, "-o", tmp_path / "no.json", "--load", "2.5 N")
    assert (refused.code, "the load is 2.5 N" in refused.err) == (2, True)
    # The wire transforms 8 K warmer, which voltages alone do not tell from a load.
    rig.write_text("[settings]\ntemperature_shift_k = 13.0\n", "utf-8")
    refused = musclewire("home", rig, model, "-o", tmp_path / "no.json")
    assert (refused.code, "say so (--load" in refused.err) == (1, True)
    assert not (tmp_path / "no.json").exists()
    answer = musclewire("home", rig, model, "-o", tmp_path / "kept.json", "--load", "1.9 N", "--json")
    assert (answer.code, answer.json["corrected"]) == (0, False)


def test_control_takes_the_users_word_on_the_load(musclewire: CommandLine, model: Path, tmp_path: Path) -> None:
    rig = tmp_path / "warmer.toml"
    rig.write_text("[settings]\ntemperature_shift_k = 13.0\n", "utf-8")
    command = ("control", rig, model, *STEPS, "--home", "start", "--json")
    refused = musclewire(*command)
    assert (refused.code, "say so (--load" in refused.err) == (1, True)
    assert musclewire(*command, "--load", "1.9 N").json["home"]["load_n"] == pytest.approx(1.9)


def test_control_makes_one_before_or_after_the_run(musclewire: CommandLine, model: Path, tmp_path: Path) -> None:
    rig = tmp_path / "aged.toml"
    rig.write_text("[settings]\nresistivity_factor = 1.01\n", "utf-8")
    plain = musclewire("control", rig, model, *STEPS, "--json")
    homed = musclewire("control", rig, model, *STEPS, "--home", "start", "--json")
    assert plain.json["home"] is None
    assert homed.json["home"]["corrected"]
    assert homed.json["mae_mean_approached_pct"] < 0.5 * plain.json["mae_mean_approached_pct"]
    new = tmp_path / "new.json"
    idle = musclewire("control", rig, model, *STEPS, "--home", "idle", "--homed-model", new, "--json")
    assert idle.json["home"]["corrected"]
    assert load_model(new).home is not None
